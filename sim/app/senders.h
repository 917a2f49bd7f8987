// SPDX-License-Identifier: Apache-2.0
/// Which device sends which process data: on a bus, at most one device may send with an identifier.
#ifndef SIM_APP_SENDERS_H
#define SIM_APP_SENDERS_H

#include "base/status.h"
#include "sim/app/devices.h"

/// Compare the transmit PDOs that the data sheets enable. STATUS_OK; STATUS_INVALID: two devices of a bus
/// would send with the same identifier; `error` names the world, the line of the second device, and both
/// devices.
MUST_USE status_t senders_check(const devices_t* devices, const world_t* world,
                                char error[SIMULATOR_ERROR_MAX]);

#endif // SIM_APP_SENDERS_H
