// SPDX-License-Identifier: Apache-2.0
#include "osal/freertos/datagrams.h"

#include <string.h>

#define STORE_OCTETS 65536U
#define ALIGNMENT 8U

typedef struct { // Header of a record; the octets of the datagram follow it.
    uint32_t number;
    osal_address_t from;
    uint32_t size;  ///< Number of octets of the datagram.
    uint32_t whole; ///< Size of the record with its header, rounded up to a multiple of ALIGNMENT [octets].
} record_t;

static uint64_t store[STORE_OCTETS / sizeof(uint64_t)];
static size_t used; // Records lie in [0, used).

static uint8_t* at(const size_t offset)
{
    return (uint8_t*)store + offset;
}

static record_t* record_at(const size_t offset)
{
    return (record_t*)(void*)at(offset);
}

/// Offset of the first record of a socket, or `used`.
static size_t find(const uint32_t number)
{
    size_t offset = 0U;
    while ((offset < used) && (record_at(offset)->number != number)) {
        offset += record_at(offset)->whole;
    }
    return offset;
}

static void remove_record(const size_t offset)
{
    const size_t whole = record_at(offset)->whole;
    (void)memmove(at(offset), at(offset + whole), used - offset - whole);
    used -= whole;
}

bool datagrams_add(const uint32_t number, const osal_address_t from, const uint8_t* const octets,
                   const size_t size)
{
    const size_t whole = (sizeof(record_t) + size + (ALIGNMENT - 1U)) & ~(size_t)(ALIGNMENT - 1U);
    if (whole > (STORE_OCTETS - used)) {
        return false;
    }
    *record_at(used) = (record_t){number, from, (uint32_t)size, (uint32_t)whole};
    (void)memcpy(at(used + sizeof(record_t)), octets, size);
    used += whole;
    return true;
}

bool datagrams_has(const uint32_t number)
{
    return find(number) < used;
}

status_t datagrams_take(const uint32_t number, osal_address_t* const out_from, uint8_t* const octets,
                        const size_t capacity, size_t* const out_size)
{
    const size_t offset = find(number);
    *out_size           = 0U;
    if (offset == used) {
        return STATUS_EMPTY;
    }
    const record_t record = *record_at(offset);
    const bool does_fit   = (record.size <= capacity);
    if (does_fit) {
        (void)memcpy(octets, at(offset + sizeof record), record.size);
        *out_size = record.size;
        *out_from = record.from;
    }
    remove_record(offset);
    return does_fit ? STATUS_OK : STATUS_TOO_LARGE;
}

void datagrams_drop(const uint32_t number)
{
    while (datagrams_has(number)) {
        remove_record(find(number));
    }
}
