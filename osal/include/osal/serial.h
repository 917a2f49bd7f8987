// SPDX-License-Identifier: Apache-2.0
/// Serial line: a terminal device, raw (no echo, no translation, no flow control), 8 data bits, no parity,
/// 1 stop bit. Every octet passes unchanged in both directions. Read, write and close it as a device.
///
/// Ownership  As in device.h.
/// Context    One task. Never blocks, and does not wait for the carrier signal of a modem.
#ifndef OSAL_SERIAL_H
#define OSAL_SERIAL_H

#include "base/status.h"
#include "osal/include/osal/device.h"

#include <stdbool.h>
#include <stdint.h>

/// Bit rates that each port with serial lines supports [bit/s]; it may support more.
#define OSAL_SERIAL_BAUDS                                                                                    \
    {                                                                                                        \
        9600U, 19200U, 38400U, 57600U, 115200U, 230400U                                                      \
    }

/// Open the line and discard octets received before. If the system supports it, no other program can open the
/// line while it is open. STATUS_OK, STATUS_OUT_OF_RANGE (bit rate not supported), STATUS_NOT_FOUND,
/// STATUS_INVALID (not a serial line), STATUS_BUSY, STATUS_DENIED, STATUS_EXHAUSTED, STATUS_IO,
/// STATUS_UNSUPPORTED (this system has no serial lines).
MUST_USE status_t osal_serial_open(osal_device_t* line, const char* path, uint32_t baud);

#endif // OSAL_SERIAL_H
