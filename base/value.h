// SPDX-License-Identifier: Apache-2.0
/// Scalar value types of parameters, arguments and link payloads: names as in descriptors, codes as in the
/// five layout bits of a parameter id, size on the wire, and conversion between host memory and the wire.
/// Each function takes scalar types only; another type is a coding error (FSW_ASSERT).
#ifndef BASE_VALUE_H
#define BASE_VALUE_H

#include "base/octets.h"
#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

typedef enum {
    VALUE_UINT8 = 0,
    VALUE_UINT16,
    VALUE_UINT32,
    VALUE_UINT64,
    VALUE_INT8,
    VALUE_INT16,
    VALUE_INT32,
    VALUE_INT64,
    VALUE_FLOAT,
    VALUE_DOUBLE,
    VALUE_BOOL,        ///< One octet, 0 or 1; C type bool.
    VALUE_SCALARS,     ///< Number of scalar types.
    VALUE_STRUCT = 24, ///< Layout code of a structured parameter; the dictionary has its length.
    VALUE_ARRAY  = 25  ///< Layout code of an array (count > 1) of one scalar type.
} value_type_t;

/// Returns the size of one scalar [octets]; the same in host memory and on the wire.
size_t value_size(value_type_t type);
/// Returns the name of a type in descriptors ("DOUBLE"), never null.
const char* value_type_name(value_type_t type);
/// Find the scalar type of this name. STATUS_OK, STATUS_NOT_FOUND.
MUST_USE status_t value_type_of(const char* name, value_type_t* out_type);

/// Returns the bits of a scalar in host memory, as the low bits of the result.
uint64_t value_bits(value_type_t type, const void* memory);
/// Store the low bits of a number, two's complement or IEEE 754, as a scalar.
void value_store(value_type_t type, uint64_t bits, void* memory);
/// Write one scalar from host memory, at any address, big-endian.
void value_encode(octet_writer_t* writer, value_type_t type, const void* memory);
/// Write `count` consecutive scalars from host memory big-endian to `octets`, which must have room for them.
/// Returns the number of octets written.
size_t value_put(uint8_t* octets, value_type_t type, const void* memory, size_t count);
/// Read one scalar into host memory. STATUS_OK, STATUS_TRUNCATED, STATUS_INVALID (BOOL other than 0 and 1);
/// memory changes only with STATUS_OK.
MUST_USE status_t value_decode(octet_reader_t* reader, value_type_t type, void* memory);
/// Returns the scalar as a double (64-bit integers may round).
double value_as_double(value_type_t type, const void* memory);

#endif // BASE_VALUE_H
