// SPDX-License-Identifier: Apache-2.0
/// ST[11] time-based scheduling, all messages: a schedule (pus/core/schedule.h) whose tags are absolute
/// times, in ticks of 2^-24 s since 1958-01-01 TAI.
///
/// The caller passes mission time, which may jump: after a jump forward all due activities are released once,
/// in order; after a jump back no activity is released again. If the caller steps the schedule at
/// pus_time_schedule_next_ns, activities are released with an accuracy of 1 ns.
///
/// Ownership, context and time are those of pus/core/schedule.h.
#ifndef PUS_ST11_ST11_TIME_SCHEDULE_H
#define PUS_ST11_ST11_TIME_SCHEDULE_H

#include "pus/core/schedule.h"

typedef struct { // Private, except schedule.counters and schedule.count.
    pus_schedule_t schedule;
    uint64_t epoch_ns;
} pus_time_schedule_t;

/// epoch_s: as in pus_app_process_init.
void pus_time_schedule_init(pus_time_schedule_t* self, uint32_t epoch_s, const pus_schedule_config_t* config);
/// Entry of the service for a dispatcher. It has no `step`: the caller calls pus_time_schedule_step.
pus_service_t pus_time_schedule_service(pus_time_schedule_t* self);
/// Restore a persistent record. Statuses of pus_schedule_restore.
MUST_USE status_t pus_time_schedule_restore(pus_time_schedule_t* self, uint32_t key, const uint8_t* octets,
                                            size_t size);
/// Release due activities, and continue a report.
void pus_time_schedule_step(pus_time_schedule_t* self, uint64_t now_ns);
/// Mission time at which the next activity is due, in the past if it is already due; UINT64_MAX if there is
/// none. Activities that wait for the port (pus_schedule_is_waiting) are not included.
uint64_t pus_time_schedule_next_ns(const pus_time_schedule_t* self);

#endif // PUS_ST11_ST11_TIME_SCHEDULE_H
