// SPDX-License-Identifier: Apache-2.0
/// The network interfaces of SocketCAN: query their properties, create and remove virtual ones.
///
/// The program that prepares a run uses it; flight components open a bus by its address (osal/can.h).
///
/// Ownership  The caller provides all structures.
/// Context    Any task. Each call waits for the answer of the kernel.
/// Errors     Each function lists every status it returns; on a system without SocketCAN each returns
///            STATUS_UNSUPPORTED, whatever its arguments. A null argument is a coding error (FSW_ASSERT).
#ifndef OSAL_CAN_INTERFACE_H
#define OSAL_CAN_INTERFACE_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_CAN_INTERFACE_NAME_MAX 15U ///< Characters of a name.
#define OSAL_CAN_LABEL_MAX 31U          ///< Characters of a label.

typedef struct {
    bool is_virtual; ///< vcan or vxcan: no bit rate, no arbitration, no acknowledge; carries error frames.
    bool is_up;
    bool is_bus_off;                     ///< The controller has left the bus.
    bool carries_fd;                     ///< The largest frame (MTU) is that of CAN FD.
    uint32_t bit_rate;                   ///< Nominal [bit/s]; 0: none or unknown.
    uint32_t data_bit_rate;              ///< CAN FD data phase [bit/s]; 0: none or unknown.
    char label[OSAL_CAN_LABEL_MAX + 1U]; ///< `label` of osal_can_interface_create, cut if longer.
} osal_can_interface_t;

/// Claim on an interface for one run. It ends with osal_can_interface_release, or with the process.
typedef struct { // Private; -1: none.
    int descriptor;
} osal_can_claim_t;

/// Query the properties of an interface. Returns STATUS_OK, STATUS_INVALID (name empty, longer than 15
/// characters, "." or "..", or with '/', ':' or white space), STATUS_UNSUPPORTED (no SocketCAN in this
/// kernel), STATUS_NOT_FOUND (no such interface), STATUS_NOT_OURS (it is not an interface for CAN),
/// STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_can_interface_look(const char* name, osal_can_interface_t* out_interface);

/// Create a vcan interface, classic or FD, with a label, and bring it up. Returns STATUS_OK, STATUS_EXISTS,
/// STATUS_DENIED (CAP_NET_ADMIN is required), STATUS_UNSUPPORTED (no SocketCAN or no vcan in this kernel),
/// STATUS_INVALID (name, or a label that is too long), STATUS_IO.
MUST_USE status_t osal_can_interface_create(const char* name, bool carries_fd, const char* label);
/// Remove a virtual interface. Returns STATUS_OK, STATUS_NOT_FOUND, STATUS_DENIED, STATUS_INVALID,
/// STATUS_UNSUPPORTED (it is hardware), STATUS_IO.
status_t osal_can_interface_remove(const char* name);

/// Claim the name of an interface, whether it exists or not. Only one claim of a name can exist in a network
/// namespace. Returns STATUS_OK, STATUS_EXISTS (claimed by another), STATUS_INVALID (name), STATUS_IO.
MUST_USE status_t osal_can_interface_claim(const char* name, osal_can_claim_t* out_claim);
/// Release a claim. No effect if the structure holds none.
void osal_can_interface_release(osal_can_claim_t* claim);

#endif // OSAL_CAN_INTERFACE_H
