// SPDX-License-Identifier: Apache-2.0
/// ST[12] of a subsystem (`<Service type="12" capacity="64" functional="8"/>` of its descriptor): monitoring
/// of its own scalar parameters, or of those that its callback `watched` gives; it raises its own events.
/// `capacity` is the number of parameter monitoring definitions, `functional` that of functional ones. The
/// auxiliary data of a raised event is that of pus/st12/st12_monitoring.h, or parameters that the event
/// definition samples, or nothing; a monitor may not name an event with other values.
///
/// Ownership  The program places it (generated).
/// Context    The component's own loop.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_MONITORING_SERVICE_H
#define FSW_FRAMEWORK_SUBSYSTEM_MONITORING_SERVICE_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "pus/st12/st12_monitoring.h"

#define MONITORING_FMON_MEMBERS 16U ///< Parameter monitoring definitions that a functional one names.
#define MONITORING_TRANSITIONS 32U  ///< In one TM[12,12].
#define MONITORING_DELAY_CYCLES 1000U

typedef struct { // Private, except `monitoring.counters`.
    pus_monitoring_t monitoring;
    pus_check_transition_t transitions[MONITORING_TRANSITIONS];
} monitoring_service_t;

/// The arrays, as the generator places them.
typedef struct {
    pus_pmon_t* pmons; ///< `capacity` of each of these.
    uint16_t* order;
    uint16_t* places;
    pus_due_t* due;
    uint16_t capacity;
    pus_fmon_t* fmons; ///< `functional` of each of these, and MONITORING_FMON_MEMBERS times as many members.
    uint16_t* touched;
    pus_fmon_member_t* members;
    uint16_t functional;
} monitoring_room_t;

/// Add the service to a component. `room` is read during the call only.
void subsystem_monitoring_service_add(subsystem_t* subsystem, monitoring_service_t* service,
                                      const monitoring_room_t* room);

#endif // FSW_FRAMEWORK_SUBSYSTEM_MONITORING_SERVICE_H
