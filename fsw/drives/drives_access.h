// SPDX-License-Identifier: Apache-2.0
/// Port through which ST[02] accesses the drives of a subsystem by SDO, while the cycle controls them.
/// Addresses, protocol-specific data, quantities and return codes: docs/services/st02.md.
///
/// Devices are accessible while process data flow. Before that, only commissioning uses SDO; when it
/// starts, it aborts a transfer of this port. Command pulses switch the supply of devices; they are sent in
/// any state, because a device without supply cannot be commissioned. One transfer per node runs at a time;
/// others wait.
#ifndef FSW_DRIVES_DRIVES_ACCESS_H
#define FSW_DRIVES_DRIVES_ACCESS_H

#include "fsw/drives/drives.h"
#include "pus/st02/st02_device_access.h"

/// Return code: process data do not flow, the transfer was reset, or a pulse could not be sent.
#define DRIVES_ACCESS_CLOSED 1U
/// Return code: the device violated the protocol, or its value has another length than requested or is longer
/// than SDO_OCTETS_MAX.
#define DRIVES_ACCESS_WRONG 2U

/// Returns the port: this function is the callback device_port, and `self` is the subsystem's drives_t. At
/// most DRIVES_ACCESS_SLOTS operations run at the same time.
pus_device_port_t drives_access_port(void* self);

#endif // FSW_DRIVES_DRIVES_ACCESS_H
