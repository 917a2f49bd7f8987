// SPDX-License-Identifier: Apache-2.0
/// What ST[12] of the supervisor watches: its own parameters, and those of the subsystems by the values they
/// reported last. A parameter that no descriptor of the mission has is unknown. One that was not reported
/// yet or is not reported any more (mirror_is_old) has no value, nor has one whose subsystem does not run, is
/// OFFLINE or is silent: its check is invalid.
#ifndef FSW_SUPERVISOR_SERVICES_ONBOARD_MONITORING_H
#define FSW_SUPERVISOR_SERVICES_ONBOARD_MONITORING_H

#include "pus/core/parameter_port.h"

/// Callback of the supervisor as a subsystem.
pus_parameter_port_t onboard_watched(void* supervisor);

#endif // FSW_SUPERVISOR_SERVICES_ONBOARD_MONITORING_H
