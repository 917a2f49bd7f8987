// SPDX-License-Identifier: Apache-2.0
/// On/off devices and command pulses of ST[02]. They switch the supplies of drives through the power units
/// that the elements `<Supply>` of the descriptor name.
///
/// A CPDU is a power unit; its number is the node id, and its output lines are those of the descriptor. An
/// on/off device address is unit << 8 | line; it requests a pulse of DRIVES_SUPPLY_EXPONENT on that line. A
/// pulse is one frame of process data to the unit, 0x200 + its node id: line (u16, lowest octet first),
/// exponent (u8). The unit generates the pulse and does not answer; only the state of the drive shows the
/// effect. If the buses are closed, they are opened for the frame, so that a drive can be switched on before
/// its commissioning.
#ifndef FSW_DRIVES_DRIVES_SUPPLY_H
#define FSW_DRIVES_DRIVES_SUPPLY_H

#include "fsw/drives/drives.h"
#include "pus/st02/st02_device_access.h"

#define DRIVES_SUPPLY_EXPONENT 2U          ///< The pulse lasts 2^2 basic durations of the unit.
#define DRIVES_SUPPLY_LEAVE_NS 10000000ULL ///< Time in which a sent frame leaves the controller.

/// True if the instruction is a switch or a pulse.
bool drives_supply_is(const pus_device_action_t* action);
/// Check a switch or pulse. STATUS_OK, STATUS_NOT_FOUND (on/off address, or CPDU), STATUS_OUT_OF_RANGE
/// (output line).
status_t drives_supply_check(const drives_t* drives, const pus_device_action_t* action);
/// Send the pulse of a checked instruction. STATUS_OK, STATUS_FULL, STATUS_CLOSED; statuses of drives_borrow.
status_t drives_supply_send(drives_t* drives, const pus_device_action_t* action);
/// Wait until sent frames have left the controller. STATUS_BUSY for DRIVES_SUPPLY_LEAVE_NS after the last
/// frame; then the buses are given back, and the status is STATUS_OK.
status_t drives_supply_poll(drives_t* drives);

#endif // FSW_DRIVES_DRIVES_SUPPLY_H
