// SPDX-License-Identifier: Apache-2.0
/// Private to pus/core/schedule*.c: functions on activities, which the requests use.
#ifndef PUS_CORE_SCHEDULE_INTERNAL_H
#define PUS_CORE_SCHEDULE_INTERNAL_H

#include "pus/core/schedule.h"

#define NO_SLOT PUS_SORTED_INDEX_NONE
#define TAG_NEVER UINT64_MAX
#define EXISTS 0x01U // Flags of a sub-schedule or group.
#define ENABLED 0x02U

/// An activity before its insertion. `request` must be valid until then.
typedef struct {
    uint64_t tag;
    uint64_t serial;
    uint8_t sub_schedule;
    uint8_t group;
    pus_activity_id_t id;
    const uint8_t* request;
    size_t size; // [octets]
} activity_draft_t;

/// Returns the present tag.
uint64_t schedule_now(const pus_schedule_t* schedule, uint64_t now_ns);
/// Insert an activity into a free slot, in memory only. STATUS_OK, STATUS_EXHAUSTED (not enough blocks).
MUST_USE status_t schedule_add(pus_schedule_t* schedule, uint16_t slot, const activity_draft_t* draft);
/// Returns the identifier of a decoded request.
pus_activity_id_t schedule_id_of(const pus_tc_t* tc);
/// Remove an activity from the schedule and free its slot.
void schedule_drop(pus_schedule_t* schedule, uint16_t slot);
/// Store the record of an activity, with this tag. Statuses of the persistence port.
MUST_USE status_t schedule_put(pus_schedule_t* schedule, uint16_t slot, uint64_t tag);
/// Erase the record of an activity. STATUS_OK, STATUS_IO.
MUST_USE status_t schedule_erase(const pus_schedule_t* schedule, uint16_t slot);
/// Clear the list of requests under release and erase its record. STATUS_OK, STATUS_IO.
MUST_USE status_t schedule_abandon(pus_schedule_t* schedule);
/// Store the status of the function, of the sub-schedules and of the groups. PUS_DONE; PUS_FAILED
/// (PUS_FAILURE_IO, status).
pus_reply_t schedule_put_state(pus_schedule_t* schedule);
/// Give an activity another tag. Its serial number, which orders equal tags, does not change.
void schedule_retag(pus_schedule_t* schedule, uint16_t slot, uint64_t tag);
/// Return the first activity with this request identifier, and the next one after `slot`; NO_SLOT if there
/// is none.
uint16_t schedule_find(const pus_schedule_t* schedule, const pus_activity_id_t* id);
uint16_t schedule_find_next(const pus_schedule_t* schedule, uint16_t slot);
/// Copy the request of an activity to `out_octets` (PUS_PACKET_MAX). Returns its size.
size_t schedule_request(const pus_schedule_t* schedule, uint16_t slot, uint8_t* out_octets);
/// Read a request identifier; convert one to the detail of a failure.
pus_activity_id_t schedule_read_id(octet_reader_t* reader);
uint32_t schedule_id_detail(const pus_activity_id_t* id);

/// Refuse a request, or one instruction of it, and count the refusal.
pus_reply_t schedule_refuse(pus_schedule_t* schedule, uint16_t code, uint32_t detail);
void schedule_refuse_one(pus_schedule_t* schedule, pus_request_t* request, uint16_t instruction,
                         uint16_t code, uint32_t detail);

/// Returns a filter that selects all activities.
pus_schedule_filter_t schedule_filter_all(void);
/// Read a filter. PUS_DONE, or PUS_REFUSED.
pus_reply_t schedule_read_filter(pus_schedule_t* schedule, octet_reader_t* reader,
                                 pus_schedule_filter_t* out_filter);
/// Returns the first activity that the filter selects; NO_SLOT if there is none.
uint16_t schedule_select(const pus_schedule_t* schedule, const pus_schedule_filter_t* filter);
/// Returns the next selected activity after `slot`.
uint16_t schedule_select_next(const pus_schedule_t* schedule, const pus_schedule_filter_t* filter,
                              uint16_t slot);

/// Continue an unfinished report, and complete its request after the last packet.
void schedule_report_go_on(pus_schedule_t* schedule, uint64_t now_ns);

#endif // PUS_CORE_SCHEDULE_INTERNAL_H
