// SPDX-License-Identifier: Apache-2.0
#include "pus/core/scalar.h"

#include "base/assertion.h"
#include "pus/core/tailoring.h"

#define LAYOUT_SHIFT 16U // Position of the layout bits in a parameter id.
#define LAYOUT_MASK 0x1FU
#define SIGN 0x8000000000000000ULL

value_type_t pus_scalar_type(const uint32_t parameter_id)
{
    const uint32_t layout = (parameter_id >> LAYOUT_SHIFT) & LAYOUT_MASK;
    return (layout < (uint32_t)VALUE_SCALARS) ? (value_type_t)layout : VALUE_SCALARS;
}

/// Find a scalar and the port's handle for it. Statuses of pus_scalar_sample.
static status_t find(const pus_parameter_port_t* const port, const uint32_t parameter_id,
                     uint16_t* const out_handle)
{
    const value_type_t type = pus_scalar_type(parameter_id);
    uint16_t size           = 0U;
    const status_t status   = port->find(port->context, parameter_id, out_handle, &size);
    if ((status != STATUS_OK) && (status != STATUS_EMPTY)) {
        return status;
    }
    return ((type == VALUE_SCALARS) || (value_size(type) != size)) ? STATUS_INVALID : status;
}

status_t pus_scalar_find(const pus_parameter_port_t* const port, const uint32_t parameter_id,
                         pus_scalar_t* const out_scalar)
{
    FSW_ASSERT((port != NULL) && (out_scalar != NULL));
    uint16_t handle       = 0U;
    const status_t status = find(port, parameter_id, &handle);
    if ((status != STATUS_OK) && (status != STATUS_EMPTY)) {
        return status;
    }
    *out_scalar = (pus_scalar_t){.id = parameter_id, .type = pus_scalar_type(parameter_id)};
    return STATUS_OK;
}

uint16_t pus_scalar_failure(const status_t status)
{
    return (status == STATUS_NOT_FOUND) ? PUS_FAILURE_UNKNOWN_ID : PUS_FAILURE_ACCESS;
}

status_t pus_scalar_sample(const pus_parameter_port_t* const port, const pus_scalar_t* const scalar,
                           uint64_t* const out_bits)
{
    FSW_ASSERT((port != NULL) && (scalar != NULL) && (out_bits != NULL));
    uint8_t octets[sizeof(uint64_t)] = {0};
    uint16_t handle                  = 0U;
    const status_t status            = find(port, scalar->id, &handle);
    *out_bits                        = 0U;
    if (status == STATUS_OK) {
        octet_writer_t writer = octet_writer(octets, value_size(scalar->type));
        port->read(port->context, handle, &writer);
        octet_reader_t reader = octet_reader(octets, sizeof octets);
        *out_bits             = pus_scalar_read(&reader, scalar->type);
    }
    return status;
}

uint64_t pus_scalar_read(octet_reader_t* const reader, const value_type_t type)
{
    uint64_t bits     = 0U;
    const size_t size = value_size(type);
    for (size_t i = 0U; i < size; i++) {
        bits = (bits << 8U) | octet_read_u8(reader);
    }
    return bits;
}

void pus_scalar_write(octet_writer_t* const writer, const value_type_t type, const uint64_t bits)
{
    for (size_t i = value_size(type); i > 0U; i--) {
        octet_write_u8(writer, (uint8_t)((bits >> (8U * (i - 1U))) & 0xFFU));
    }
}

double pus_scalar_as_double(const value_type_t type, const uint64_t bits)
{
    uint64_t memory = 0U; // Aligned for every type.
    value_store(type, bits, &memory);
    return value_as_double(type, &memory);
}

static bool is_real(const value_type_t type)
{
    return (type == VALUE_FLOAT) || (type == VALUE_DOUBLE);
}

static bool has_sign(const value_type_t type)
{
    return (type >= VALUE_INT8) && (type <= VALUE_INT64);
}

/// Extend the sign of a value to 64 bits.
static uint64_t extend(const value_type_t type, const uint64_t bits)
{
    const uint64_t sign = 1ULL << ((8U * value_size(type)) - 1U);
    return (bits ^ sign) - sign;
}

/// Map an integer to an unsigned number, so that the order and the differences of the integers of one type
/// are kept.
static uint64_t rank_of(const value_type_t type, const uint64_t bits)
{
    return has_sign(type) ? (extend(type, bits) ^ SIGN) : bits;
}

static pus_comparison_t order_of_ranks(const uint64_t one, const uint64_t other)
{
    if (one == other) {
        return PUS_EQUAL;
    }
    return (one < other) ? PUS_LESS : PUS_GREATER;
}

static pus_comparison_t order_of_reals(const double one, const double other)
{
    if (one < other) {
        return PUS_LESS;
    }
    if (one > other) {
        return PUS_GREATER;
    }
    return (one == other) ? PUS_EQUAL : PUS_UNORDERED;
}

pus_comparison_t pus_scalar_compare(const value_type_t type, const uint64_t one, const uint64_t other)
{
    if (is_real(type)) {
        return order_of_reals(pus_scalar_as_double(type, one), pus_scalar_as_double(type, other));
    }
    return order_of_ranks(rank_of(type, one), rank_of(type, other));
}

value_type_t pus_scalar_delta_type(const value_type_t type)
{
    static const value_type_t types[VALUE_SCALARS] = {
        VALUE_INT8,  VALUE_INT16, VALUE_INT32, VALUE_INT64,  VALUE_INT8, VALUE_INT16,
        VALUE_INT32, VALUE_INT64, VALUE_FLOAT, VALUE_DOUBLE, VALUE_INT8,
    };
    FSW_ASSERT(type < VALUE_SCALARS);
    return types[type];
}

pus_comparison_t pus_scalar_compare_delta(const value_type_t type, const uint64_t first, const uint64_t last,
                                          const uint16_t count, const uint64_t threshold)
{
    FSW_ASSERT(count >= 1U);
    const value_type_t delta_type = pus_scalar_delta_type(type);
    if (is_real(type)) {
        const double delta = pus_scalar_as_double(type, last) - pus_scalar_as_double(type, first);
        return order_of_reals(delta / count, pus_scalar_as_double(delta_type, threshold));
    }
    const uint64_t from         = rank_of(type, first);
    const uint64_t to           = rank_of(type, last);
    const uint64_t limit        = extend(delta_type, threshold);
    const bool falls            = to < from;
    const bool limit_falls      = (limit & SIGN) != 0U;
    const uint64_t amount       = falls ? (from - to) : (to - from);
    const uint64_t limit_amount = limit_falls ? (0U - limit) : limit;
    if (falls != limit_falls) {
        return falls ? PUS_LESS : PUS_GREATER;
    }
    // Compare the whole difference with `count` times the threshold; a product beyond 64 bits exceeds every
    // difference.
    const bool is_beyond = limit_amount > (UINT64_MAX / count);
    const uint64_t whole = is_beyond ? UINT64_MAX : (limit_amount * count);
    if (is_beyond || (amount < whole)) {
        return falls ? PUS_GREATER : PUS_LESS;
    }
    return order_of_ranks(falls ? whole : amount, falls ? amount : whole);
}
