// SPDX-License-Identifier: Apache-2.0
/// Access to one medium with random access, such as a file, for a journal or a packet store. After a power
/// cut the medium has all data written before the last successful `sync`. Later writes may be incomplete, and
/// may have reached the medium in another order.
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
    /// Force all data to the medium. STATUS_OK, STATUS_IO.
    status_t (*sync)(void* context);
    /// Present size [octets]. STATUS_OK, STATUS_IO.
    status_t (*size)(void* context, uint64_t* out_size);
    /// Cut the medium to `size`, or extend it with zeros. STATUS_OK, STATUS_FULL, STATUS_IO.
    status_t (*resize)(void* context, uint64_t size);
} medium_t;

#endif // BASE_MEDIUM_H
