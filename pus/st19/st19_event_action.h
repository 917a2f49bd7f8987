// SPDX-License-Identifier: Apache-2.0
/// ST[19] event-action, all messages: when an event occurs, even if its report is disabled, the service
/// releases the request of its definition. Definitions and refusals: docs/services/st19.md.
///
/// The key of a definition consists of an application process and an event. Requests that the port cannot
/// take at once wait in the order of the events. They are dropped and counted if the function or the
/// definition is disabled meanwhile.
///
/// Ownership  The caller provides all arrays.
/// Context    One loop.
/// Time       pus_event_action_observe is O(1) on average for any number of definitions, and O(request) if it
///            releases a request; a step is O(1) if no request waits.
#ifndef PUS_ST19_ST19_EVENT_ACTION_H
#define PUS_ST19_ST19_EVENT_ACTION_H

#include "pus/core/block_chain.h"
#include "pus/core/long_report.h"
#include "pus/core/service.h"

/// Largest request, so that TM[19,11] can report it in one packet [octets].
#define PUS_EVENT_ACTION_REQUEST_MAX (PUS_TM_DATA_MAX - 7U)
#define PUS_EVENT_ACTION_RELEASES 256U ///< Largest number of requests that one step releases.
/// Octets before the request in the record of a definition.
#define PUS_EVENT_ACTION_RECORD_HEAD 5U

typedef struct { // Private.
    pus_block_chain_t request;
    uint16_t apid;
    uint16_t event;
    uint16_t next;    // Next definition in its bucket, or next free one in the list of free definitions.
    uint16_t waiting; // Number of events whose request the port has not taken yet.
    uint32_t report;  // Number of the report that includes this definition.
    bool in_use;
    bool is_enabled;
    bool is_queued; // The queue contains this slot, perhaps for an earlier definition that was deleted.
} pus_event_action_definition_t;

typedef struct {
    pus_app_process_t* process; ///< Sends the reports that a step continues.
    /// Port that takes the requests.
    pus_port_t release;
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
    pus_event_action_definition_t* definitions;
    uint16_t definition_count;  ///< 1..65534.
    uint16_t* queue;            ///< One entry for each definition.
    uint16_t* buckets;          ///< Hash table, with about as many entries as definitions.
    uint32_t bucket_count;      ///< A power of two.
    pus_block_chains_t* chains; ///< Blocks for the requests; services of one loop may share them.
} pus_event_action_config_t;

typedef struct { // Private, except `counters` and `count`: read-only, for telemetry.
    pus_event_action_config_t config;
    bool is_enabled;
    uint16_t count; ///< Number of definitions.
    uint16_t free;
    uint16_t queue_first;
    uint16_t queue_count;
    uint32_t report_number; // Number of the last report by identifiers.
    // Number of the present report; it includes the definitions that have this number. 0: all definitions.
    uint32_t report_wanted;
    pus_long_report_t report;
    uint8_t record[PUS_EVENT_ACTION_RECORD_HEAD + PUS_PACKET_MAX];
    struct {
        uint32_t observed; ///< Events that have an enabled definition.
        uint32_t released;
        uint32_t deferred; ///< Number of times that the port refused a request.
        uint32_t dropped;  ///< Waiting requests dropped: function or definition disabled, or too many waited.
        uint32_t refused;  ///< Requests and instructions refused.
    } counters;
} pus_event_action_t;

void pus_event_action_init(pus_event_action_t* self, const pus_event_action_config_t* config);
/// Entry of the service for a dispatcher, without a step.
pus_service_t pus_event_action_service(pus_event_action_t* self);
/// Restore a persistent record, before the first request and event. STATUS_OK, STATUS_INVALID (malformed),
/// STATUS_EXISTS (its slot is in use, or there is a definition with its key), STATUS_EXHAUSTED (no room).
MUST_USE status_t pus_event_action_restore(pus_event_action_t* self, uint32_t key, const uint8_t* octets,
                                           size_t size);
/// Process a report or notice of an event: release the request of its definition, if any.
void pus_event_action_observe(pus_event_action_t* self, uint16_t apid, uint16_t event);
/// Release waiting requests, and continue a report.
void pus_event_action_step(pus_event_action_t* self, uint64_t now_ns);
/// True if the next step has work.
bool pus_event_action_is_waiting(const pus_event_action_t* self);

#endif // PUS_ST19_ST19_EVENT_ACTION_H
