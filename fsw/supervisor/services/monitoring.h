// SPDX-License-Identifier: Apache-2.0
/// Parameters that ST[12] of the supervisor monitors: its own, and those of the subsystems with their last
/// reported values. A parameter that no descriptor of the mission defines is unknown. A parameter has no
/// value, and its check is invalid, if it was not reported yet, is no longer reported
/// (supervisor_telemetry_cache_is_old), or its subsystem does not run, is OFFLINE or is silent.
#ifndef FSW_SUPERVISOR_SERVICES_MONITORING_H
#define FSW_SUPERVISOR_SERVICES_MONITORING_H

#include "pus/core/parameter_port.h"

/// Callback `watched` of the supervisor as a subsystem.
pus_parameter_port_t spacecraft_watched(void* supervisor);

#endif // FSW_SUPERVISOR_SERVICES_MONITORING_H
