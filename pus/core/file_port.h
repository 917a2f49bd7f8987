// SPDX-License-Identifier: Apache-2.0
/// The port by which services reach files by repository path and name: whole files, read or written in
/// pieces.
#ifndef PUS_CORE_FILE_PORT_H
#define PUS_CORE_FILE_PORT_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

/// Path and name of a file in a request.
typedef struct {
    const uint8_t* path; ///< Repository path; not ended by NUL.
    const uint8_t* name; ///< Name of the file.
    uint16_t path_size;
    uint16_t name_size;
} pus_file_name_t;

typedef struct {
    void* context;
    /// Open an existing file for reading; *out_size is its size. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID
    /// (path or name), STATUS_FORBIDDEN (may not be read), STATUS_EXHAUSTED (too many are open), STATUS_IO.
    status_t (*open)(void* context, const pus_file_name_t* name, uint32_t* out_file, uint32_t* out_size);
    /// Create a file for writing, which must not exist yet. Statuses of open, and STATUS_EXISTS.
    status_t (*create)(void* context, const pus_file_name_t* name, uint32_t* out_file);
    /// Read exactly `size` octets from `offset` on. STATUS_OK, STATUS_TRUNCATED (beyond the end), STATUS_IO.
    status_t (*read)(void* context, uint32_t file, uint32_t offset, uint8_t* octets, size_t size);
    /// Write all octets; the file grows if necessary. STATUS_OK, STATUS_FULL (no space), STATUS_IO.
    status_t (*write)(void* context, uint32_t file, uint32_t offset, const uint8_t* octets, size_t size);
    /// Make the written octets persistent and close the file. STATUS_OK, STATUS_IO; it is closed in both
    /// cases.
    status_t (*close)(void* context, uint32_t file);
} pus_file_port_t;

#endif // PUS_CORE_FILE_PORT_H
