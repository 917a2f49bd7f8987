// SPDX-License-Identifier: Apache-2.0
/// Values of scalar parameters as bits, for monitoring and statistics. Comparisons are exact: 64-bit integers
/// are not rounded, and NaN is neither less nor greater than any value.
///
/// The bits are those of base/value.h: the octets of the value, with the first octet on the wire as the most
/// significant.
///
/// Context    Any; no state.
/// Time       O(1).
#ifndef PUS_CORE_SCALAR_H
#define PUS_CORE_SCALAR_H

#include "base/octets.h"
#include "base/value.h"
#include "pus/core/parameter_port.h"

typedef enum {
    PUS_LESS,
    PUS_EQUAL,
    PUS_GREATER,
    PUS_UNORDERED ///< At least one of the two is NaN.
} pus_comparison_t;

/// A scalar parameter of the port.
typedef struct {
    uint32_t id;
    value_type_t type; ///< A scalar type.
} pus_scalar_t;

/// Returns the type in the layout bits of a parameter id; VALUE_SCALARS if it is not a scalar.
value_type_t pus_scalar_type(uint32_t parameter_id);
/// Find a parameter, with or without a value, and check that it is a scalar. STATUS_OK, STATUS_NOT_FOUND,
/// STATUS_FORBIDDEN (not readable), STATUS_INVALID (no scalar). *out_scalar changes only with STATUS_OK.
MUST_USE status_t pus_scalar_find(const pus_parameter_port_t* port, uint32_t parameter_id,
                                  pus_scalar_t* out_scalar);
/// Failure code for a status of pus_scalar_find other than STATUS_OK; its detail is the parameter id.
uint16_t pus_scalar_failure(status_t status);
/// Read the bits of the present value. Each call finds the parameter again, because it may be withdrawn and
/// defined again when its process restarts. Statuses of pus_scalar_find, or STATUS_EMPTY (no value yet);
/// *out_bits is 0 unless STATUS_OK.
MUST_USE status_t pus_scalar_sample(const pus_parameter_port_t* port, const pus_scalar_t* scalar,
                                    uint64_t* out_bits);

/// Read or write the bits of a value in the layout of the wire.
uint64_t pus_scalar_read(octet_reader_t* reader, value_type_t type);
void pus_scalar_write(octet_writer_t* writer, value_type_t type, uint64_t bits);
/// Convert to a double; a 64-bit integer may be rounded.
double pus_scalar_as_double(value_type_t type, uint64_t bits);

/// Compare `one` with `other`.
pus_comparison_t pus_scalar_compare(value_type_t type, uint64_t one, uint64_t other);
/// Returns the type of the difference of two values of a type: the signed type of the same size, or the type
/// itself if it is real.
value_type_t pus_scalar_delta_type(value_type_t type);
/// Compare the mean difference over `count` (>= 1) steps from `first` to `last` with a threshold, whose type
/// is pus_scalar_delta_type(type). Integers are compared exactly, real numbers in double precision.
pus_comparison_t pus_scalar_compare_delta(value_type_t type, uint64_t first, uint64_t last, uint16_t count,
                                          uint64_t threshold);

#endif // PUS_CORE_SCALAR_H
