// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/record.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <stdbool.h>

#define SCALAR_OCTETS_MAX 8U

/// Copy one scalar; reverse its octets for little-endian records, since base/value encodes big-endian.
static void copy_scalar(const uint8_t* const from, const size_t size, const flow_order_t order,
                        uint8_t* const to)
{
    for (size_t i = 0U; i < size; i++) {
        to[(order == FLOW_ORDER_LITTLE) ? (size - 1U - i) : i] = from[i];
    }
}

size_t flow_record_octets(const flow_record_layout_t* const layout)
{
    FSW_ASSERT((layout != NULL) && ((layout->fields != NULL) || (layout->field_count == 0U)));
    size_t octets = 0U;
    for (size_t i = 0U; i < layout->field_count; i++) {
        octets += value_size(layout->fields[i].type) * layout->fields[i].count;
    }
    return octets;
}

status_t flow_record_encode(const flow_record_layout_t* const layout, const flow_order_t order,
                            const void* const record, uint8_t* const octets, const size_t capacity,
                            size_t* const out_size)
{
    FSW_ASSERT((record != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (capacity < flow_record_octets(layout)) {
        return STATUS_FULL;
    }
    for (size_t i = 0U; i < layout->field_count; i++) {
        const flow_record_field_t* const field = &layout->fields[i];
        const size_t size                      = value_size(field->type);
        for (uint16_t k = 0U; k < field->count; k++) {
            uint8_t scalar[SCALAR_OCTETS_MAX];
            (void)value_put(scalar, field->type, (const uint8_t*)record + field->offset + (k * size), 1U);
            copy_scalar(scalar, size, order, &octets[*out_size]);
            *out_size += size;
        }
    }
    return STATUS_OK;
}

/// Decode every scalar into the record; if `record` is null, only check the octets.
static status_t decode(const flow_record_layout_t* const layout, const flow_order_t order,
                       const uint8_t* const octets, uint8_t* const record)
{
    size_t position = 0U;
    for (size_t i = 0U; i < layout->field_count; i++) {
        const flow_record_field_t* const field = &layout->fields[i];
        const size_t size                      = value_size(field->type);
        for (uint16_t k = 0U; k < field->count; k++) {
            uint8_t scalar[SCALAR_OCTETS_MAX];
            uint64_t discarded = 0U;
            copy_scalar(&octets[position], size, order, scalar);
            octet_reader_t reader = octet_reader(scalar, size);
            void* const memory =
                (record != NULL) ? (void*)&record[field->offset + (k * size)] : (void*)&discarded;
            const status_t status = value_decode(&reader, field->type, memory);
            if (status != STATUS_OK) {
                return status;
            }
            position += size;
        }
    }
    return STATUS_OK;
}

status_t flow_record_decode(const flow_record_layout_t* const layout, const flow_order_t order,
                            const uint8_t* const octets, const size_t size, void* const record)
{
    FSW_ASSERT((octets != NULL) && (record != NULL));
    const size_t expected = flow_record_octets(layout);
    if (size != expected) {
        return (size < expected) ? STATUS_TRUNCATED : STATUS_TOO_LARGE;
    }
    // Check all octets first, so that an invalid scalar leaves the record unchanged.
    const status_t status = decode(layout, order, octets, NULL);
    return (status == STATUS_OK) ? decode(layout, order, octets, record) : status;
}
