// SPDX-License-Identifier: Apache-2.0
/// Scalar parameters behind the parameter port, of every type, whose bits a test sets.
#ifndef TEST_UNIT_PUS_SCALARS_H
#define TEST_UNIT_PUS_SCALARS_H

#include "fsw/framework/base/value.h"
#include "pus/parameter_port.h"

#define SCALAR_NUMBERS 1024U ///< Of each type.
#define SCALAR_ID(type, number) ((16U << 21U) | ((uint32_t)(type) << 16U) | (number))
#define SCALAR_SECRET SCALAR_ID(VALUE_UINT8, 0x2000U)  ///< Not readable.
#define SCALAR_ODD SCALAR_ID(VALUE_UINT8, 0x2001U)     ///< Of 3 octets.
#define SCALAR_UNKNOWN SCALAR_ID(VALUE_UINT8, 0x2002U) ///< Not there.
#define SCALAR_ARRAY SCALAR_ID(VALUE_ARRAY, 0U)        ///< Not a scalar.

typedef struct {
    uint64_t bits[VALUE_SCALARS][SCALAR_NUMBERS];
    unsigned reads;
    bool is_withdrawn; ///< No parameter is there.
    bool is_silent;    ///< No parameter has a value.
} scalars_t;

extern scalars_t scalars;

/// All values are 0.
pus_parameter_port_t scalars_port(void);
void scalar_set(uint32_t id, uint64_t bits);
uint64_t bits_of_double(double value);
uint64_t bits_of_float(float value);

#endif // TEST_UNIT_PUS_SCALARS_H
