// SPDX-License-Identifier: Apache-2.0
#include "base/value.h"

#include "base/assertion.h"

#include <stdbool.h>
#include <string.h>

typedef struct { // One scalar type.
    const char* name;
    uint8_t size;
    bool is_signed;
} scalar_t;

static const scalar_t scalars[VALUE_SCALARS] = {
    [VALUE_UINT8] = {"UINT8", 1U, false},   [VALUE_UINT16] = {"UINT16", 2U, false},
    [VALUE_UINT32] = {"UINT32", 4U, false}, [VALUE_UINT64] = {"UINT64", 8U, false},
    [VALUE_INT8] = {"INT8", 1U, true},      [VALUE_INT16] = {"INT16", 2U, true},
    [VALUE_INT32] = {"INT32", 4U, true},    [VALUE_INT64] = {"INT64", 8U, true},
    [VALUE_FLOAT] = {"FLOAT", 4U, true},    [VALUE_DOUBLE] = {"DOUBLE", 8U, true},
    [VALUE_BOOL] = {"BOOL", 1U, false},
};

static const scalar_t* scalar_of(const value_type_t type)
{
    FSW_ASSERT((unsigned)type < (unsigned)VALUE_SCALARS);
    return &scalars[type];
}

/// Returns the bits of a scalar in host memory, as the low bits of the result.
static inline uint64_t load_bits(const size_t size, const void* const memory)
{
    uint8_t octet   = 0U;
    uint16_t half   = 0U;
    uint32_t word   = 0U;
    uint64_t result = 0U;
    if (size == sizeof octet) {
        (void)memcpy(&octet, memory, sizeof octet);
        result = octet;
    } else if (size == sizeof half) {
        (void)memcpy(&half, memory, sizeof half);
        result = half;
    } else if (size == sizeof word) {
        (void)memcpy(&word, memory, sizeof word);
        result = word;
    } else {
        (void)memcpy(&result, memory, sizeof result);
    }
    return result;
}

size_t value_size(const value_type_t type)
{
    return scalar_of(type)->size;
}

const char* value_type_name(const value_type_t type)
{
    return scalar_of(type)->name;
}

status_t value_type_of(const char* const name, value_type_t* const out_type)
{
    FSW_ASSERT((name != NULL) && (out_type != NULL));
    for (unsigned i = 0U; i < (unsigned)VALUE_SCALARS; i++) {
        if (strcmp(name, scalars[i].name) == 0) {
            *out_type = (value_type_t)i;
            return STATUS_OK;
        }
    }
    return STATUS_NOT_FOUND;
}

uint64_t value_bits(const value_type_t type, const void* const memory)
{
    return load_bits(value_size(type), memory);
}

void value_store(const value_type_t type, const uint64_t bits, void* const memory)
{
    const size_t size   = value_size(type);
    const uint8_t octet = (uint8_t)(bits & UINT8_MAX);
    const uint16_t half = (uint16_t)(bits & UINT16_MAX);
    const uint32_t word = (uint32_t)(bits & UINT32_MAX);
    if (size == sizeof octet) {
        (void)memcpy(memory, &octet, sizeof octet);
    } else if (size == sizeof half) {
        (void)memcpy(memory, &half, sizeof half);
    } else if (size == sizeof word) {
        (void)memcpy(memory, &word, sizeof word);
    } else {
        (void)memcpy(memory, &bits, sizeof bits);
    }
}

size_t value_put(uint8_t* const octets, const value_type_t type, const void* const memory, const size_t count)
{
    FSW_ASSERT((octets != NULL) && (memory != NULL));
    const size_t size           = scalar_of(type)->size;
    const uint8_t* const values = memory;
    const size_t end            = size * count;
    if (size == 8U) {
        for (size_t i = 0U; i < end; i += 8U) {
            octets_put_u64(&octets[i], load_bits(8U, &values[i]));
        }
    } else if (size == 4U) {
        for (size_t i = 0U; i < end; i += 4U) {
            octets_put_u32(&octets[i], (uint32_t)load_bits(4U, &values[i]));
        }
    } else if (size == 2U) {
        for (size_t i = 0U; i < end; i += 2U) {
            octets_put_u16(&octets[i], (uint16_t)load_bits(2U, &values[i]));
        }
    } else {
        (void)memcpy(octets, values, end);
    }
    return end;
}

void value_encode(octet_writer_t* const writer, const value_type_t type, const void* const memory)
{
    FSW_ASSERT(memory != NULL);
    uint8_t* const octets = octet_write_space(writer, value_size(type));
    if (octets != NULL) {
        (void)value_put(octets, type, memory, 1U);
    }
}

status_t value_decode(octet_reader_t* const reader, const value_type_t type, void* const memory)
{
    FSW_ASSERT((reader != NULL) && (memory != NULL));
    const size_t size           = value_size(type);
    const uint8_t* const octets = octet_read_octets(reader, size);
    if (octets == NULL) {
        return STATUS_TRUNCATED;
    }
    uint64_t bits = 0U;
    for (size_t i = 0U; i < size; i++) {
        bits = (bits << 8U) | octets[i];
    }
    if ((type == VALUE_BOOL) && (bits > 1U)) {
        return STATUS_INVALID;
    }
    value_store(type, bits, memory);
    return STATUS_OK;
}

double value_as_double(const value_type_t type, const void* const memory)
{
    FSW_ASSERT(memory != NULL);
    const scalar_t* const scalar = scalar_of(type);
    double number                = 0.0;
    float single                 = 0.0F;
    if (type == VALUE_DOUBLE) {
        (void)memcpy(&number, memory, sizeof number);
    } else if (type == VALUE_FLOAT) {
        (void)memcpy(&single, memory, sizeof single);
        number = (double)single;
    } else {
        const uint64_t bits = value_bits(type, memory);
        const uint64_t sign = 1ULL << ((8U * scalar->size) - 1U);
        if (scalar->is_signed && ((bits & sign) != 0U)) {
            // Magnitude of a negative number: its two's complement, within the width of its type.
            number = -(double)(((sign - 1U) & ~bits) + 1U);
        } else {
            number = (double)bits;
        }
    }
    return number;
}
