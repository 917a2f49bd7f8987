// SPDX-License-Identifier: Apache-2.0
/// ST[22] position-based scheduling, all messages: a schedule (pus/core/schedule.h) whose tags are positions
/// along the orbit: orbit number and angle from the ascending node, as one number in units of 2^-16 orbits.
///
/// A port gives the position: the number of orbits that its source has counted, and the angle. The position
/// may stand still and may jump, like time in ST[11]. TC[22,28] sets the number of the next orbit; the
/// present orbit keeps its number. The number survives a power cut if the count of the source survives it,
/// too.
///
/// Ownership, context and time are those of pus/core/schedule.h.
#ifndef PUS_ST22_ST22_POSITION_SCHEDULE_H
#define PUS_ST22_ST22_POSITION_SCHEDULE_H

#include "pus/core/schedule.h"

#define PUS_POSITION_TICKS 65536U ///< Number of ticks in one orbit.

typedef struct { // Source of the on-board orbit position parameter.
    void* context;
    /// Orbits that the source has counted << 16 | angle [2^-16 orbits], 48 bits.
    uint64_t (*read)(void* context);
} pus_position_port_t;

typedef struct { // Private, except schedule.counters and schedule.count.
    pus_schedule_t schedule;
    pus_position_port_t port;
    uint32_t offset; // Orbit number minus the count of the source.
    bool is_pending; // The orbit after `orbit` (count of the source) will have the number `number`.
    uint32_t orbit;
    uint32_t number;
} pus_position_schedule_t;

void pus_position_schedule_init(pus_position_schedule_t* self, const pus_position_port_t* port,
                                const pus_schedule_config_t* config);
/// Entry of the service for a dispatcher, without a step.
pus_service_t pus_position_schedule_service(pus_position_schedule_t* self);
/// Restore a persistent record. Statuses of pus_schedule_restore.
MUST_USE status_t pus_position_schedule_restore(pus_position_schedule_t* self, uint32_t key,
                                                const uint8_t* octets, size_t size);
/// Release due activities, and continue a report. now_ns: time of the reports.
void pus_position_schedule_step(pus_position_schedule_t* self, uint64_t now_ns);
/// Returns the present position with the orbit number of the schedule [2^-16 orbits].
uint64_t pus_position_schedule_now(pus_position_schedule_t* self);

#endif // PUS_ST22_ST22_POSITION_SCHEDULE_H
