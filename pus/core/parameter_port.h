// SPDX-License-Identifier: Apache-2.0
/// The port by which services reach parameters. Ids are resolved to handles once; values are octets in the
/// order of the wire (big-endian).
#ifndef PUS_CORE_PARAMETER_PORT_H
#define PUS_CORE_PARAMETER_PORT_H

#include "base/octets.h"
#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

typedef struct {
    void* context;
    /// Resolve a parameter id to the port's handle and the size of its value on the wire [octets, >= 1].
    /// STATUS_OK, STATUS_NOT_FOUND (unknown), STATUS_FORBIDDEN (known, but not readable). A port to
    /// parameters of other processes also returns STATUS_EMPTY (known, but no value yet; handle and size are
    /// set).
    status_t (*find)(void* context, uint32_t parameter_id, uint16_t* out_handle, uint16_t* out_size);
    /// Write the present value, in exactly the size found; zeros if the parameter was withdrawn meanwhile.
    /// Must not send reports.
    void (*read)(void* context, uint16_t handle, octet_writer_t* writer);
    /// Set the value as a whole or not at all; `octets` has exactly the size found. STATUS_OK,
    /// STATUS_READ_ONLY, STATUS_OUT_OF_RANGE or STATUS_INVALID (value), STATUS_FORBIDDEN or STATUS_BUSY (not
    /// now). Null: no parameter is settable.
    status_t (*write)(void* context, uint16_t handle, const uint8_t* octets, size_t size);
} pus_parameter_port_t;

#endif // PUS_CORE_PARAMETER_PORT_H
