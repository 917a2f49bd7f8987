// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_quantity.h"

#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"
#include "base/octets.h"
#include "base/value.h"

#include <float.h>
#include <math.h>

#define OCTET_BITS 8U
#define HALF 0.5

status_t drives_quantity_find(const drives_t* const drives, const uint16_t node, const uint32_t id,
                              const descriptor_quantity_t** const out_quantity)
{
    FSW_ASSERT((drives != NULL) && (out_quantity != NULL));
    const descriptor_configuration_t* const configuration = drives->configuration;
    status_t status                                       = STATUS_NOT_FOUND;
    if (configuration == NULL) {
        return status;
    }
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    for (uint16_t i = 0U; i < configuration->device_count; i++) {
        const descriptor_device_t* const device   = &descriptor->devices[configuration->first_device + i];
        const descriptor_endnode_t* const endnode = drives_endnode(descriptor, device);
        const bool is_node                        = (endnode != NULL) && (endnode->node == node);
        const uint16_t count                      = is_node ? device->quantity_count : 0U;
        for (uint16_t k = 0U; (k < count) && (status != STATUS_OK); k++) {
            *out_quantity = &descriptor->quantities[device->first_quantity + k];
            status        = ((*out_quantity)->id == id) ? STATUS_OK : STATUS_OUT_OF_RANGE;
        }
    }
    return status;
}

static bool is_signed(const value_type_t type)
{
    return (type == VALUE_INT8) || (type == VALUE_INT16) || (type == VALUE_INT32) || (type == VALUE_INT64);
}

/// Returns 2 to the power of `bits`; the result is exact.
static double power_of_two(const size_t bits)
{
    double power = 1.0;
    for (size_t i = 0U; i < bits; i++) {
        power *= 2.0;
    }
    return power;
}

/// Round to the nearest whole number, halves away from zero, in two's complement. False if an object of
/// `octets` octets cannot hold it.
static bool round_to(const double real, const size_t octets, const bool has_sign, uint64_t* const out_bits)
{
    const double range = power_of_two(octets * OCTET_BITS);
    const double end   = has_sign ? (range * HALF) : range; // The smallest number that is too large.
    const double low   = has_sign ? -end : 0.0;
    const double whole = round(real);
    if (!((whole >= low) && (whole < end))) { // NaN fails both comparisons.
        return false;
    }
    *out_bits = (whole < 0.0) ? (uint64_t)(int64_t)whole : (uint64_t)whole;
    return true;
}

/// Round to the nearest number of single (FLOAT) or double precision. False if it is out of range.
static bool narrow_to(const double real, const value_type_t type, uint64_t* const out_bits)
{
    const double largest = (type == VALUE_FLOAT) ? (double)FLT_MAX : DBL_MAX;
    if (!((real >= -largest) && (real <= largest))) { // NaN fails both comparisons.
        return false;
    }
    if (type == VALUE_FLOAT) {
        const float single = (float)real;
        *out_bits          = value_bits(VALUE_FLOAT, &single);
    } else {
        *out_bits = value_bits(VALUE_DOUBLE, &real);
    }
    return true;
}

bool drives_quantity_to_object(const descriptor_quantity_t* const quantity,
                               const uint8_t value[DRIVES_QUANTITY_OCTETS],
                               uint8_t out_octets[DRIVES_QUANTITY_OCTETS])
{
    FSW_ASSERT((quantity != NULL) && (value != NULL) && (out_octets != NULL));
    uint64_t bits         = 0U;
    octet_reader_t reader = octet_reader(value, DRIVES_QUANTITY_OCTETS);
    const double real     = octet_read_f64(&reader) / quantity->scale;
    const size_t size     = value_size(quantity->type);
    const bool is_real    = (quantity->type == VALUE_FLOAT) || (quantity->type == VALUE_DOUBLE);
    const bool fits       = is_real ? narrow_to(real, quantity->type, &bits)
                                    : round_to(real, size, is_signed(quantity->type), &bits);
    canopen_put(out_octets, bits, size);
    return fits;
}

void drives_quantity_of_object(const descriptor_quantity_t* const quantity, const uint8_t* const octets,
                               uint8_t out_value[DRIVES_QUANTITY_OCTETS])
{
    FSW_ASSERT((quantity != NULL) && (octets != NULL) && (out_value != NULL));
    uint64_t memory = 0U; // Holds any scalar type.
    value_store(quantity->type, canopen_at(octets, value_size(quantity->type)), &memory);
    const double real = value_as_double(quantity->type, &memory) * quantity->scale;
    (void)value_put(out_value, VALUE_DOUBLE, &real, 1U);
}
