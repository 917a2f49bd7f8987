// SPDX-License-Identifier: Apache-2.0
/// ST[12] of a subsystem (`<Service type="12" capacity="64" functional="8"/>` of its descriptor):
/// monitoring of its own scalar parameters, or of those that its callback `watched` returns. It raises
/// events of the subsystem. `capacity` is the number of parameter monitoring definitions, `functional` the
/// number of functional monitoring definitions. The auxiliary data of a raised event is that of
/// docs/services/st12.md, or parameters that the event definition samples, or empty; a monitor may not
/// refer to an event with other auxiliary data.
///
/// Ownership  The generated program provides monitoring_service_t and its arrays.
/// Context    The main loop of the component.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_MONITORING_SERVICE_H
#define FSW_FRAMEWORK_SUBSYSTEM_MONITORING_SERVICE_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "pus/st12/st12_monitoring.h"

#define MONITORING_FMON_MEMBERS 16U ///< Parameter monitoring definitions in a functional one.
#define MONITORING_TRANSITIONS 32U  ///< Transitions in one TM[12,12].
/// Initial value of the maximum transition reporting delay [cycles].
#define MONITORING_DELAY_CYCLES 1000U

typedef struct { // Private, except `monitoring.counters`.
    pus_monitoring_t monitoring;
    pus_check_transition_t transitions[MONITORING_TRANSITIONS];
} monitoring_service_t;

/// The arrays that the generated program provides.
typedef struct {
    pus_pmon_t* pmons; ///< `capacity` elements in each of these arrays.
    uint16_t* order;
    uint16_t* positions;
    pus_due_t* due;
    uint16_t capacity;
    /// `functional` elements in each of these arrays, and MONITORING_FMON_MEMBERS times as many members.
    pus_fmon_t* fmons;
    uint16_t* touched;
    pus_fmon_member_t* members;
    uint16_t functional;
} monitoring_room_t;

/// Add the service to a component. `room` is read during the call only.
void subsystem_monitoring_service_add(subsystem_t* subsystem, monitoring_service_t* service,
                                      const monitoring_room_t* room);

#endif // FSW_FRAMEWORK_SUBSYSTEM_MONITORING_SERVICE_H
