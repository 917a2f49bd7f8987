// SPDX-License-Identifier: Apache-2.0
/// A schedule of requests that are released when their tag is due: the common part of ST[11], whose tags are
/// times, and ST[22], whose tags are positions along the orbit. It performs the requests 1..26 of both
/// services, by subtype. Activities, reports and refusals: docs/services/st11.md.
///
/// Every change is stored before it is acknowledged; a status or a group that cannot be stored stays as it
/// was. Each request is released at most once, also across a restart (docs/decisions/0017). A step takes the
/// due requests out of the schedule and stores their identifiers in one record. They are under release until
/// the port has taken all of them. After a restart `lost` reports the requests in that record. If the record
/// cannot be stored, `unsaved` counts that, and the due requests are still released.
///
/// Ownership  The caller provides all arrays.
/// Context    One loop.
/// Time       A step in which no request is due: O(1); insertion, release, deletion: O(log activities);
///            search by identifier: O(1). A step releases at most PUS_SCHEDULE_BATCH activities. Requests by
///            filter, shifts of all and reports: O(activities that they select).
#ifndef PUS_CORE_SCHEDULE_H
#define PUS_CORE_SCHEDULE_H

#include "pus/core/block_chain.h"
#include "pus/core/long_report.h"
#include "pus/core/sorted_index.h"
#include "pus/core/service.h"

#define PUS_SCHEDULE_IDS 256U   ///< Maximum number of sub-schedules, and of groups.
#define PUS_SCHEDULE_BATCH 256U ///< Largest number of activities that one step takes out of the schedule.
/// Largest request of an activity, so that TM[11,10] can report it in one packet [octets].
#define PUS_SCHEDULE_REQUEST_MAX (PUS_TM_DATA_MAX - 12U)
#define PUS_SCHEDULE_RECORD_HEAD 18U ///< Octets before the request in the record of an activity.

/// The functions that differ for times and positions.
typedef struct {
    uint8_t service;
    uint64_t tag_max; ///< Largest tag, < 2^62.
    /// Read a tag or an offset; each function reads all octets of its field. read_tag returns false if the
    /// tag is malformed.
    bool (*read_tag)(octet_reader_t* reader, uint64_t* out_tag);
    int64_t (*read_offset)(octet_reader_t* reader);
    void (*write_tag)(octet_writer_t* writer, uint64_t tag);
    /// The present tag; `self` is the argument of pus_schedule_init.
    uint64_t (*now)(void* self, uint64_t now_ns);
} pus_schedule_kind_t;

typedef struct { // Identifier of the request of an activity.
    uint16_t source;
    uint16_t apid;
    uint16_t sequence;
} pus_activity_id_t;

typedef struct { // Private.
    pus_block_chain_t request;
    pus_activity_id_t id;
    uint8_t sub_schedule;
    uint8_t group;
    // Next in its bucket, in the list of requests under release, or in the list of free slots.
    uint16_t next;
    uint16_t previous; // Previous activity in its bucket.
    uint16_t chosen;   // Next activity that a shift has selected.
    uint32_t report;   // Number of the report by identifiers that includes this activity.
    bool in_use;
} pus_activity_t;

typedef struct {
    pus_app_process_t* process;           ///< Sends the reports that a step continues.
    pus_port_t release;                   ///< Port that takes due requests.
    const pus_persistence_t* persistence; ///< Null: the schedule is not persistent.
    pus_activity_t* activities;
    pus_sorted_index_node_t* nodes; ///< One for each activity.
    uint16_t activity_count;        ///< 1..65534.
    uint16_t* buckets;              ///< Hash table by identifier, with about as many entries as activities.
    uint32_t bucket_count;          ///< A power of two.
    pus_block_chains_t* chains;     ///< Blocks for the requests; services of one loop may share them.
    uint16_t sub_schedule_count;    ///< Maximum number of sub-schedules, 1..256.
    uint16_t group_count;           ///< Maximum number of groups, 1..256.
    uint64_t margin;                ///< Minimum distance of a tag from now [ticks of the tag].
    void* context;                  ///< Context of `lost`.
    /// Called in the first step after a restart for each request that was under release: it may or may not
    /// have been released. May be null.
    void (*lost)(void* context, const pus_activity_id_t* id);
} pus_schedule_config_t;

typedef struct { // Private: sub-schedules or groups.
    uint16_t count;
    uint8_t flags[PUS_SCHEDULE_IDS]; // For each id: EXISTS, ENABLED.
} pus_schedule_set_t;

typedef struct {   // Private: conditions that an activity must meet to be selected.
    uint64_t from; // Smallest tag; for this tag, `serial` is the smallest serial number.
    uint64_t serial;
    uint64_t to;
    uint32_t report;        // Select only activities with this number; 0: any.
    bool has_sub_schedules; // Select only activities of the sub-schedules in the list.
    bool has_groups;
    uint8_t sub_schedules[PUS_SCHEDULE_IDS / 8U];
    uint8_t groups[PUS_SCHEDULE_IDS / 8U];
} pus_schedule_filter_t;

typedef struct { // Private, except `counters` and `count`: read-only, for telemetry.
    const pus_schedule_kind_t* kind;
    void* self; // The service.
    pus_schedule_config_t config;
    bool is_enabled;
    uint16_t count; ///< Number of activities in the schedule.
    uint16_t free;
    uint64_t serial;        // Serial number of the next activity.
    uint32_t report_number; // Number of the last report by identifiers.
    pus_sorted_index_t order;
    pus_schedule_set_t sub_schedules;
    pus_schedule_set_t groups;
    uint16_t group_uses[PUS_SCHEDULE_IDS]; // Number of activities in each group.
    pus_long_report_t report;
    pus_schedule_filter_t report_filter;
    uint16_t releasing; // First activity under release.
    uint16_t releasing_last;
    uint16_t lost_count; // Requests that a restart has found under release, and that are not reported yet.
    pus_activity_id_t lost[PUS_SCHEDULE_BATCH];
    uint8_t record[PUS_SCHEDULE_RECORD_HEAD + PUS_PACKET_MAX];
    struct {
        uint32_t inserted;
        uint32_t released;
        uint32_t deferred; ///< Number of times that the port refused a due request.
        uint32_t dropped;  ///< Activities that became due while disabled.
        uint32_t lost;     ///< Activities that a restart found under release.
        uint32_t refused;  ///< Requests and instructions refused.
        uint32_t unsaved;  ///< Changes in steps that could not be stored.
    } counters;
} pus_schedule_t;

/// `self` is the service, for kind->now and its own requests.
void pus_schedule_init(pus_schedule_t* schedule, const pus_schedule_kind_t* kind, void* self,
                       const pus_schedule_config_t* config);
/// Restore a persistent record, before the first request and step. STATUS_OK, STATUS_INVALID (malformed),
/// STATUS_EXISTS (the slot of the activity is in use), STATUS_EXHAUSTED (no room).
MUST_USE status_t pus_schedule_restore(pus_schedule_t* schedule, uint32_t key, const uint8_t* octets,
                                       size_t size);
/// Release due activities, and continue a report.
void pus_schedule_step(pus_schedule_t* schedule, uint64_t now_ns);
/// True if the next step has work, independent of its time: the port has refused a request, a restart has
/// found requests under release, or a report is not complete. Due activities are not included.
bool pus_schedule_is_waiting(const pus_schedule_t* schedule);
/// Tag of the next activity; UINT64_MAX if there is none.
uint64_t pus_schedule_next(const pus_schedule_t* schedule);
/// Store a record of the service itself in addition to the records of the schedule. PUS_DONE; PUS_FAILED
/// (PUS_FAILURE_IO, status).
pus_reply_t pus_schedule_keep_own(pus_schedule_t* schedule, const uint8_t* octets, size_t size);
#define PUS_SCHEDULE_KEY_OWN 2U ///< Key of that record; pus_schedule_restore refuses it.

/// Functions `execute` of the requests; the object is a pus_schedule_t.
pus_reply_t pus_schedule_enable(void* object, pus_request_t* request);
pus_reply_t pus_schedule_disable(void* object, pus_request_t* request);
pus_reply_t pus_schedule_reset(void* object, pus_request_t* request);
pus_reply_t pus_schedule_insert(void* object, pus_request_t* request);
pus_reply_t pus_schedule_delete_ids(void* object, pus_request_t* request);
pus_reply_t pus_schedule_delete_filtered(void* object, pus_request_t* request);
pus_reply_t pus_schedule_shift_ids(void* object, pus_request_t* request);
pus_reply_t pus_schedule_shift_filtered(void* object, pus_request_t* request);
pus_reply_t pus_schedule_shift_all(void* object, pus_request_t* request);
pus_reply_t pus_schedule_report_ids(void* object, pus_request_t* request);
pus_reply_t pus_schedule_report_filtered(void* object, pus_request_t* request);
pus_reply_t pus_schedule_report_all(void* object, pus_request_t* request);
pus_reply_t pus_schedule_report_sub_schedules(void* object, pus_request_t* request);
pus_reply_t pus_schedule_enable_sub_schedules(void* object, pus_request_t* request);
pus_reply_t pus_schedule_disable_sub_schedules(void* object, pus_request_t* request);
pus_reply_t pus_schedule_create_groups(void* object, pus_request_t* request);
pus_reply_t pus_schedule_delete_groups(void* object, pus_request_t* request);
pus_reply_t pus_schedule_enable_groups(void* object, pus_request_t* request);
pus_reply_t pus_schedule_disable_groups(void* object, pus_request_t* request);
pus_reply_t pus_schedule_report_groups(void* object, pus_request_t* request);

/// The table of the requests 1..26 of a service.
#define PUS_SCHEDULE_REQUESTS(service)                                                                       \
    PUS_REQUEST(service, 1, pus_schedule_enable), PUS_REQUEST(service, 2, pus_schedule_disable),             \
        PUS_REQUEST(service, 3, pus_schedule_reset), PUS_REQUEST(service, 4, pus_schedule_insert),           \
        PUS_REQUEST(service, 5, pus_schedule_delete_ids),                                                    \
        PUS_REQUEST(service, 6, pus_schedule_delete_filtered),                                               \
        PUS_REQUEST(service, 7, pus_schedule_shift_ids),                                                     \
        PUS_REQUEST(service, 8, pus_schedule_shift_filtered),                                                \
        PUS_REQUEST(service, 9, pus_schedule_report_ids),                                                    \
        PUS_REQUEST(service, 11, pus_schedule_report_filtered),                                              \
        PUS_REQUEST(service, 12, pus_schedule_report_ids),                                                   \
        PUS_REQUEST(service, 14, pus_schedule_report_filtered),                                              \
        PUS_REQUEST(service, 15, pus_schedule_shift_all), PUS_REQUEST(service, 16, pus_schedule_report_all), \
        PUS_REQUEST(service, 17, pus_schedule_report_all),                                                   \
        PUS_REQUEST(service, 18, pus_schedule_report_sub_schedules),                                         \
        PUS_REQUEST(service, 20, pus_schedule_enable_sub_schedules),                                         \
        PUS_REQUEST(service, 21, pus_schedule_disable_sub_schedules),                                        \
        PUS_REQUEST(service, 22, pus_schedule_create_groups),                                                \
        PUS_REQUEST(service, 23, pus_schedule_delete_groups),                                                \
        PUS_REQUEST(service, 24, pus_schedule_enable_groups),                                                \
        PUS_REQUEST(service, 25, pus_schedule_disable_groups),                                               \
        PUS_REQUEST(service, 26, pus_schedule_report_groups)

#endif // PUS_CORE_SCHEDULE_H
