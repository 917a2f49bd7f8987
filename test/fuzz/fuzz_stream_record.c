// SPDX-License-Identifier: Apache-2.0
// Records of a stream device. For all octets that a device can send: a record is accepted, or refused without
// a change of the values; an accepted record is encoded to the same octets.
//
// The first octet of the input selects byte order, checksum and the number of fields; one octet for each
// field selects its type; the rest is the record.
#include "fsw/devices/stream_record.h"
#include "test/fuzz/fuzz.h"

#include <string.h>

#define FIELDS 16U

static subsystem_descriptor_t descriptor;

static void describe(const uint8_t selector, const uint8_t* const types, const uint8_t count)
{
    descriptor_subsystem_clear(&descriptor);
    descriptor.device_count       = 1U;
    descriptor.endnode_count      = 1U;
    descriptor.record_field_count = count;
    descriptor.storage.devices[0] = (descriptor_device_t){
        .name = "D", .type = "stream", .endnode_count = 1U, .record_field_count = count};
    descriptor.storage.endnodes[0].format.order =
        ((selector & 0x40U) != 0U) ? FLOW_ORDER_LITTLE : FLOW_ORDER_BIG;
    descriptor.storage.endnodes[0].has_checksum = (selector & 0x80U) != 0U;
    for (uint8_t i = 0U; i < count; i++) {
        descriptor.storage.record_fields[i] =
            (descriptor_record_field_t){.name   = "F",
                                        .unit   = "",
                                        .type   = (value_type_t)(types[i] % VALUE_BOOL),
                                        .scale  = 0.5,
                                        .offset = -3.0};
    }
}

/// True if the values are equal, or if both are NaN.
static bool is_same_value(const double one, const double other)
{
    return (one == other) || ((one != one) && (other != other));
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    stream_record_t record;
    stream_record_t again;
    uint8_t octets[STREAM_RECORD_OCTETS_MAX];
    if (size < 1U) {
        return 0;
    }
    const uint8_t count = (uint8_t)((data[0] & 0x0FU) + 1U);
    if ((count > FIELDS) || (size < (1U + (size_t)count))) {
        return 0;
    }
    describe(data[0], &data[1], count);
    stream_record_init(&record, &descriptor, &descriptor.devices[0], false);
    stream_record_init(&again, &descriptor, &descriptor.devices[0], false);
    const status_t status = stream_record_take(&record, &data[1U + count], size - 1U - count);
    FUZZ_CHECK((status == STATUS_OK) || (memcmp(record.memory, again.memory, sizeof record.memory) == 0));
    const size_t length = stream_record_put(&record, octets);
    FUZZ_CHECK(length == stream_record_octets(&record));
    FUZZ_CHECK((status != STATUS_OK) || (memcmp(octets, &data[1U + count], length) == 0));
    FUZZ_CHECK(stream_record_take(&again, octets, length) == STATUS_OK);
    for (uint8_t i = 0U; i < count; i++) {
        const double value = stream_record_value(&record, i);
        FUZZ_CHECK(is_same_value(value, stream_record_value(&again, i)));
        const bool is_set = (stream_record_set(&record, i, value) == STATUS_OK);
        FUZZ_CHECK(is_set == (value == value)); // Only NaN is refused.
    }
    return 0;
}
