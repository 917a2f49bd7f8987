// SPDX-License-Identifier: Apache-2.0
/// The port to one file-like medium with random access, for a journal or a packet store. A power cut may tear
/// a write, and writes may reach the medium in another order; data written before a successful `sync` is on
/// the medium after a power cut.
#ifndef BASE_MEDIUM_H
#define BASE_MEDIUM_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

typedef struct {
    void* context;
    /// Read exactly `size` octets. STATUS_OK, STATUS_TRUNCATED (they go beyond the end), STATUS_IO.
    status_t (*read)(void* context, uint64_t offset, uint8_t* octets, size_t size);
    /// Write all `size` octets; the medium grows if necessary. STATUS_OK, STATUS_FULL (no space), STATUS_IO.
    status_t (*write)(void* context, uint64_t offset, const uint8_t* octets, size_t size);
    /// STATUS_OK, STATUS_IO.
    status_t (*sync)(void* context);
    /// Present end [octets]. STATUS_OK, STATUS_IO.
    status_t (*size)(void* context, uint64_t* out_size);
    /// Cut, or extend with zeros. STATUS_OK, STATUS_FULL, STATUS_IO.
    status_t (*resize)(void* context, uint64_t size);
} medium_t;

#endif // BASE_MEDIUM_H
