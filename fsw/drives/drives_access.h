// SPDX-License-Identifier: Apache-2.0
/// The port by which ST[02] reaches the drives of a subsystem, by SDO, below the cycle that controls them.
///
/// A physical device is a device of the descriptor, by its CAN node id; protocol-specific data are the index
/// (u16) and subindex (u8) of an object and its length (u8, 1..SDO_OCTETS_MAX; 0 when reading: whatever it
/// is). Data are the octets of the object as CANopen has them, lowest first. A register is an object of 32
/// bits: its address is node << 24 | index << 8 | subindex.
///
/// A logical device is the same device seen in engineering units: its quantities of the descriptor
/// (<Quantity>), by their ids. A parameter that is acquired, and the argument of a command, are a DOUBLE; a
/// command sets a quantity that is settable. On/off devices and pulses are those of drives_supply.h.
///
/// Devices are reached while process data flow: before, commissioning has the transfers to itself, and it
/// ends one of ours. Pulses go in any state, since what has no supply cannot be commissioned. One transfer to
/// a node at a time; others wait.
///
/// The return code of an acquisition that failed is the upper half of the abort code, DRIVES_ACCESS_CLOSED if
/// the bus was given up meanwhile, or DRIVES_ACCESS_WRONG if the answer has another length or breaks the
/// protocol; the detail is the whole abort code, or the return code.
#ifndef FSW_DRIVES_DRIVES_ACCESS_H
#define FSW_DRIVES_DRIVES_ACCESS_H

#include "fsw/drives/drives.h"
#include "pus/st02/st02_device_access.h"

#define DRIVES_ACCESS_CLOSED 1U
#define DRIVES_ACCESS_WRONG 2U

/// The port; its context is `drives`. At most DRIVES_ACCESS_SLOTS operations.
pus_device_port_t drives_access_port(drives_t* drives);

#endif // FSW_DRIVES_DRIVES_ACCESS_H
