// SPDX-License-Identifier: Apache-2.0
/// ST[04] of a subsystem (`<Service type="4" capacity="32"/>` of its descriptor): statistics of its own
/// scalar parameters. `capacity` is the number of parameters. Sampling intervals are multiples of 1 ms; a
/// component with a longer cycle samples at most once in each of its cycles.
///
/// Ownership  The generated program provides statistics_service_t and the arrays.
/// Context    The main loop of the component.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_STATISTICS_SERVICE_H
#define FSW_FRAMEWORK_SUBSYSTEM_STATISTICS_SERVICE_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "pus/st04/st04_statistics.h"

typedef struct { // Private, except `statistics.counters`.
    pus_statistics_t statistics;
} statistics_service_t;

typedef struct { // The arrays that the generated program provides, each with `capacity` elements.
    pus_statistic_t* statistics;
    pus_due_t* due;
    uint16_t* positions;
    uint16_t capacity;
} statistics_room_t;

/// Add the service to a component. `room` is read during the call only.
void subsystem_statistics_service_add(subsystem_t* subsystem, statistics_service_t* service,
                                      const statistics_room_t* room);

#endif // FSW_FRAMEWORK_SUBSYSTEM_STATISTICS_SERVICE_H
