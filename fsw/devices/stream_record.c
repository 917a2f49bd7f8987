// SPDX-License-Identifier: Apache-2.0
#include "fsw/devices/stream_record.h"

#include "base/assertion.h"
#include "base/crc.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define CHECKSUM_OCTETS 2U

typedef struct {
    double low;
    double high;
} range_t;

// The limits for 64-bit integers are the outermost doubles that are inside the range of the integer.
static const range_t ranges[VALUE_SCALARS] = {
    [VALUE_UINT8]  = {0.0, 255.0},
    [VALUE_UINT16] = {0.0, 65535.0},
    [VALUE_UINT32] = {0.0, 4294967295.0},
    [VALUE_UINT64] = {0.0, 18446744073709549568.0},
    [VALUE_INT8]   = {-128.0, 127.0},
    [VALUE_INT16]  = {-32768.0, 32767.0},
    [VALUE_INT32]  = {-2147483648.0, 2147483647.0},
    [VALUE_INT64]  = {-9223372036854775808.0, 9223372036854774784.0},
    [VALUE_FLOAT]  = {-(double)FLT_MAX, (double)FLT_MAX},
    [VALUE_DOUBLE] = {-DBL_MAX, DBL_MAX},
    [VALUE_BOOL]   = {0.0, 1.0},
};

void stream_record_init(stream_record_t* const record, const subsystem_descriptor_t* const descriptor,
                        const descriptor_device_t* const device, const bool is_out)
{
    FSW_ASSERT((record != NULL) && (descriptor != NULL) && (device != NULL) && (device->endnode_count > 0U));
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
    (void)memset(record, 0, sizeof *record);
    record->order        = endnode->format.order;
    record->has_checksum = endnode->has_checksum;
    for (uint16_t i = 0U; i < device->record_field_count; i++) {
        const descriptor_record_field_t* const source =
            &descriptor->record_fields[device->first_record_field + i];
        if (source->is_out != is_out) {
            continue;
        }
        const uint8_t index = record->field_count;
        FSW_ASSERT(index < STREAM_RECORD_FIELDS_MAX);
        record->sources[index] = source;
        record->fields[index] =
            (flow_record_field_t){.type = source->type, .count = 1U, .offset = index * sizeof(uint64_t)};
        record->field_count++;
    }
}

static flow_record_layout_t layout_of(const stream_record_t* const record)
{
    return (flow_record_layout_t){.fields = record->fields, .field_count = record->field_count};
}

uint32_t stream_record_octets(const stream_record_t* const record)
{
    FSW_ASSERT(record != NULL);
    const flow_record_layout_t layout = layout_of(record);
    const size_t octets               = flow_record_octets(&layout);
    return (uint32_t)(octets + (((octets > 0U) && record->has_checksum) ? CHECKSUM_OCTETS : 0U));
}

/// Returns the index of the high octet in the two octets of the checksum, by the byte order of the end node.
static size_t high_index(const stream_record_t* const record)
{
    return (record->order == FLOW_ORDER_BIG) ? 0U : 1U;
}

status_t stream_record_take(stream_record_t* const record, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((record != NULL) && (octets != NULL));
    const size_t expected = stream_record_octets(record);
    if (size != expected) {
        return (size < expected) ? STATUS_TRUNCATED : STATUS_TOO_LARGE;
    }
    size_t length = size;
    if (record->has_checksum && (size > 0U)) {
        length -= CHECKSUM_OCTETS;
        const size_t high       = high_index(record);
        const uint16_t checksum = crc16_ccitt(octets, length);
        if ((octets[length + high] != (uint8_t)(checksum >> 8U)) ||
            (octets[length + (1U - high)] != (uint8_t)(checksum & 0xFFU))) {
            return STATUS_CHECKSUM;
        }
    }
    const flow_record_layout_t layout = layout_of(record);
    return flow_record_decode(&layout, record->order, octets, length, record->memory);
}

size_t stream_record_put(const stream_record_t* const record, uint8_t octets[STREAM_RECORD_OCTETS_MAX])
{
    FSW_ASSERT((record != NULL) && (octets != NULL));
    const flow_record_layout_t layout = layout_of(record);
    size_t size                       = 0U;
    const status_t status =
        flow_record_encode(&layout, record->order, record->memory, octets, STREAM_RECORD_OCTETS_MAX, &size);
    FSW_ASSERT(status == STATUS_OK);
    if (record->has_checksum && (size > 0U)) {
        const size_t high          = high_index(record);
        const uint16_t checksum    = crc16_ccitt(octets, size);
        octets[size + high]        = (uint8_t)(checksum >> 8U);
        octets[size + (1U - high)] = (uint8_t)(checksum & 0xFFU);
        size += CHECKSUM_OCTETS;
    }
    return size;
}

double stream_record_value(const stream_record_t* const record, const uint8_t field)
{
    FSW_ASSERT((record != NULL) && (field < record->field_count));
    const descriptor_record_field_t* const source = record->sources[field];
    return (value_as_double(source->type, &record->memory[field]) * source->scale) + source->offset;
}

/// Convert a raw value, which is within the range of its type, to its bits; an integer is rounded, halves
/// away from zero.
static uint64_t bits_of(const value_type_t type, const double raw)
{
    uint64_t bits = 0U;
    if (type == VALUE_DOUBLE) {
        (void)memcpy(&bits, &raw, sizeof raw);
    } else if (type == VALUE_FLOAT) {
        const float single = (float)raw;
        uint32_t low       = 0U;
        (void)memcpy(&low, &single, sizeof single);
        bits = low;
    } else {
        const double whole = round(raw);
        bits               = (whole < 0.0) ? (uint64_t)(int64_t)whole : (uint64_t)whole;
    }
    return bits;
}

status_t stream_record_set(stream_record_t* const record, const uint8_t field, const double value)
{
    FSW_ASSERT((record != NULL) && (field < record->field_count));
    const descriptor_record_field_t* const source = record->sources[field];
    const range_t* const range                    = &ranges[source->type];
    double raw                                    = (value - source->offset) / source->scale;
    raw                                           = (raw < range->low) ? range->low : raw;
    raw                                           = (raw > range->high) ? range->high : raw;
    if (!((raw >= range->low) && (raw <= range->high))) {
        return STATUS_OUT_OF_RANGE; // NaN: all comparisons with it are false.
    }
    value_store(source->type, bits_of(source->type, raw), &record->memory[field]);
    return STATUS_OK;
}

void stream_record_set_safe(stream_record_t* const record)
{
    FSW_ASSERT(record != NULL);
    for (uint8_t i = 0U; i < record->field_count; i++) {
        (void)stream_record_set(record, i, record->sources[i]->safe);
    }
}
