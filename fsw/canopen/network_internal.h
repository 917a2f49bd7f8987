// SPDX-License-Identifier: Apache-2.0
/// Functions that only the source files of network.h share.
#ifndef FSW_CANOPEN_NETWORK_INTERNAL_H
#define FSW_CANOPEN_NETWORK_INTERNAL_H

#include "fsw/canopen/network.h"

/// Queue a fault. If the queue is full, the fault is counted and dropped.
void canopen_network_report(canopen_network_t* network, const canopen_network_fault_t* fault);
/// Returns the present state of a controller, and its counts of overruns, transmit time-outs, bus-offs and
/// restarts. The time of the last loss of frames is 0.
canopen_network_conditions_t canopen_network_conditions(const flow_can_t* flow);
/// Report the condition of one of the master's controllers.
void canopen_network_report_condition(canopen_network_t* network, uint8_t channel,
                                      canopen_network_bus_condition_t condition);
/// Report that a device is not commissioned, with a reason.
void canopen_network_report_refusal(canopen_network_t* network, const canopen_network_device_t* entry,
                                    canopen_network_refusal_t refusal);
/// Report that the access at which the device's list stopped (run.position) has failed with `status`.
void canopen_network_report_access(canopen_network_t* network, const canopen_network_device_t* entry,
                                   status_t status);

#endif // FSW_CANOPEN_NETWORK_INTERNAL_H
