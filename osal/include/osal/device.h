// SPDX-License-Identifier: Apache-2.0
/// Input and output of a device that the system offers as a file: a character device, a FIFO, or a file that
/// a driver writes. Octets pass in both directions, without waiting; one write of the partner may arrive in
/// several pieces. A serial line (serial.h) is also opened as a device.
///
/// Ownership  The caller provides osal_device_t; closed by osal_device_close.
/// Context    One task. Only osal_device_wait_readable blocks.
/// Errors     Each function lists its statuses; interrupted calls are repeated inside. On a system without
///            devices each of them returns STATUS_UNSUPPORTED at once, and the device stays closed. A null
///            argument is a coding error (FSW_ASSERT).
#ifndef OSAL_DEVICE_H
#define OSAL_DEVICE_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    OSAL_DEVICE_READ,
    OSAL_DEVICE_WRITE,
    OSAL_DEVICE_BOTH
} osal_device_direction_t;

typedef struct { // Private; descriptor < 0 when closed.
    int descriptor;
    bool is_file; ///< A regular file has no partner.
} osal_device_t;

/// Closed device, for initialisation.
#define OSAL_DEVICE_CLOSED                                                                                   \
    {                                                                                                        \
        -1, false                                                                                            \
    }

/// Open an existing device or file; writing to a file appends. STATUS_OK, STATUS_NOT_FOUND (also: a FIFO that
/// is opened for writing and has no reader), STATUS_BUSY (another program uses the device), STATUS_DENIED,
/// STATUS_EXHAUSTED (no descriptor left), STATUS_INVALID (a directory), STATUS_IO.
MUST_USE status_t osal_device_open(osal_device_t* device, const char* path,
                                   osal_device_direction_t direction);
/// Write as much of `size` octets (>= 1) as the device takes now. STATUS_OK with *out_sent >= 1, STATUS_FULL
/// (it takes nothing now, or a file has no space), STATUS_CLOSED (the partner, or the device, is gone),
/// STATUS_IO.
MUST_USE status_t osal_device_write(osal_device_t* device, const uint8_t* octets, size_t size,
                                    size_t* out_sent);
/// Read at most `capacity` (>= 1) of the available octets. STATUS_OK with *out_size >= 1, STATUS_EMPTY
/// (nothing now; or the end of a file, which may grow), STATUS_CLOSED (the partner, or the device, is gone),
/// STATUS_IO.
MUST_USE status_t osal_device_read(osal_device_t* device, uint8_t* octets, size_t capacity, size_t* out_size);
/// Wait (wall-clock) until octets can be read or the partner is gone, at most timeout_ms (<= INT32_MAX).
/// STATUS_OK, STATUS_TIMEOUT.
MUST_USE status_t osal_device_wait_readable(osal_device_t* device, uint32_t timeout_ms);
/// Both ends of a pipe, for a child process that inherits one of them. STATUS_OK, STATUS_EXHAUSTED (no
/// descriptor left), STATUS_UNSUPPORTED.
MUST_USE status_t osal_device_pipe(osal_device_t* out_reader, osal_device_t* out_writer);
/// Returns the descriptor number, for osal_process_start_t.descriptors; -1: closed.
int osal_device_descriptor(const osal_device_t* device);
void osal_device_close(osal_device_t* device);

#endif // OSAL_DEVICE_H
