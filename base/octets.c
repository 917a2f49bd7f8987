// SPDX-License-Identifier: Apache-2.0
#include "base/octets.h"

#include "base/assertion.h"

#include <string.h>

octet_reader_t octet_reader(const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    return (octet_reader_t){.octets = octets, .size = size, .position = 0U, .failed = false};
}

const uint8_t* octet_read_octets(octet_reader_t* const reader, const size_t size)
{
    FSW_ASSERT(reader != NULL);
    if (reader->failed || (size > (reader->size - reader->position))) {
        reader->failed = true;
        return NULL;
    }
    const uint8_t* const start = &reader->octets[reader->position];
    reader->position += size;
    return start;
}

uint8_t octet_read_u8(octet_reader_t* const reader)
{
    const uint8_t* const octets = octet_read_octets(reader, 1U);
    return (octets != NULL) ? octets[0] : 0U;
}

uint16_t octet_read_u16(octet_reader_t* const reader)
{
    const uint8_t* const octets = octet_read_octets(reader, 2U);
    return (octets != NULL) ? octets_u16_at(octets) : 0U;
}

uint32_t octet_read_u32(octet_reader_t* const reader)
{
    const uint8_t* const octets = octet_read_octets(reader, 4U);
    return (octets != NULL) ? octets_u32_at(octets) : 0U;
}

uint64_t octet_read_u64(octet_reader_t* const reader)
{
    const uint8_t* const octets = octet_read_octets(reader, 8U);
    return (octets != NULL) ? octets_u64_at(octets) : 0U;
}

double octet_read_f64(octet_reader_t* const reader)
{
    const uint64_t bits = octet_read_u64(reader);
    double value        = 0.0;
    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

size_t octet_reader_left(const octet_reader_t* const reader)
{
    FSW_ASSERT(reader != NULL);
    return reader->failed ? 0U : (reader->size - reader->position);
}

bool octet_reader_is_done(const octet_reader_t* const reader)
{
    FSW_ASSERT(reader != NULL);
    return !reader->failed && (reader->position == reader->size);
}

octet_writer_t octet_writer(uint8_t* const octets, const size_t capacity)
{
    FSW_ASSERT((octets != NULL) || (capacity == 0U));
    return (octet_writer_t){.octets = octets, .capacity = capacity, .position = 0U, .failed = false};
}

void octet_write_octets(octet_writer_t* const writer, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((writer != NULL) && ((octets != NULL) || (size == 0U)));
    if (writer->failed || (size > (writer->capacity - writer->position))) {
        writer->failed = true;
        return;
    }
    if (size > 0U) {
        (void)memcpy(&writer->octets[writer->position], octets, size);
        writer->position += size;
    }
}

uint8_t* octet_write_space(octet_writer_t* const writer, const size_t size)
{
    FSW_ASSERT(writer != NULL);
    if (writer->failed || (size > (writer->capacity - writer->position))) {
        writer->failed = true;
        return NULL;
    }
    uint8_t* const start = &writer->octets[writer->position];
    writer->position += size;
    return start;
}

void octet_write_u8(octet_writer_t* const writer, const uint8_t value)
{
    uint8_t* const octets = octet_write_space(writer, 1U);
    if (octets != NULL) {
        octets[0] = value;
    }
}

void octet_write_u16(octet_writer_t* const writer, const uint16_t value)
{
    uint8_t* const octets = octet_write_space(writer, 2U);
    if (octets != NULL) {
        octets_put_u16(octets, value);
    }
}

void octet_write_u32(octet_writer_t* const writer, const uint32_t value)
{
    uint8_t* const octets = octet_write_space(writer, 4U);
    if (octets != NULL) {
        octets_put_u32(octets, value);
    }
}

void octet_write_u64(octet_writer_t* const writer, const uint64_t value)
{
    uint8_t* const octets = octet_write_space(writer, 8U);
    if (octets != NULL) {
        octets_put_u64(octets, value);
    }
}

void octet_write_f64(octet_writer_t* const writer, const double value)
{
    uint64_t bits = 0U;
    (void)memcpy(&bits, &value, sizeof bits);
    octet_write_u64(writer, bits);
}
