// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/scalars.h"

#include "unity.h"

#include <string.h>

scalars_t scalars;

static status_t find(void* const context, const uint32_t id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    TEST_ASSERT_EQUAL_PTR(&scalars, context);
    const uint32_t type   = (id >> 16U) & 0x1FU;
    const uint32_t number = id & 0xFFFFU;
    *out_handle           = (uint16_t)((type * SCALAR_NUMBERS) + number);
    *out_size             = 3U;
    if (id == SCALAR_SECRET) {
        return STATUS_FORBIDDEN;
    }
    if ((id == SCALAR_ODD) || (id == SCALAR_ARRAY)) {
        return STATUS_OK;
    }
    if (scalars.is_withdrawn || (type >= VALUE_SCALARS) || (number >= SCALAR_NUMBERS) ||
        ((id >> 21U) != 16U)) {
        return STATUS_NOT_FOUND;
    }
    *out_size = (uint16_t)value_size((value_type_t)type);
    return scalars.is_silent ? STATUS_EMPTY : STATUS_OK;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    TEST_ASSERT_EQUAL_PTR(&scalars, context);
    const uint64_t bits = scalars.bits[handle / SCALAR_NUMBERS][handle % SCALAR_NUMBERS];
    scalars.reads++;
    for (size_t i = value_size((value_type_t)(handle / SCALAR_NUMBERS)); i > 0U; i--) {
        octet_write_u8(writer, (uint8_t)(bits >> (8U * (i - 1U))));
    }
}

pus_parameter_port_t scalars_port(void)
{
    memset(&scalars, 0, sizeof(scalars));
    return (pus_parameter_port_t){.context = &scalars, .find = find, .read = read};
}

void scalar_set(const uint32_t id, const uint64_t bits)
{
    scalars.bits[(id >> 16U) & 0x1FU][id & 0xFFFFU] = bits;
}

uint64_t bits_of_double(const double value)
{
    return value_bits(VALUE_DOUBLE, &value);
}

uint64_t bits_of_float(const float value)
{
    return value_bits(VALUE_FLOAT, &value);
}
