// SPDX-License-Identifier: Apache-2.0
// Proves: the reader and the writer of fields access no octet outside their buffer, for any requests in any
//     order; a request fails if and only if its field does not fit or an earlier one has failed; each field
//     is read with the value that was written; a reader reports that it is done if and only if it has read
//     every octet.
// Bounds: buffers of 0..12 octets, any two fields of 1, 2, 4 or 8 octets or strings of any size.
// Replaced: nothing.
// Sources: base/octets.c
// Options: --unwind 3
// Fault: base/octets.c
//   - const uint8_t* const start = &reader->octets[reader->position];
//   + const uint8_t* const start = &reader->octets[reader->position + 1U];
// Fault: base/octets.h
//   - octets[1] = (uint8_t)((value >> 16U) & 0xFFU);
//   + octets[1] = (uint8_t)((value >> 15U) & 0xFFU);
// Fault: base/octets.c
//   - (void)memcpy(&writer->octets[writer->position], octets, size);
//   + (void)memcpy(writer->octets, octets, size);
// Fault: base/octets.c
//   - return !reader->failed && (reader->position == reader->size);
//   + return reader->position == reader->size;
#include "base/octets.h"
#include "test/proof/proof.h"

#define CAPACITY 12U
#define FIELDS 2U

/// Size of a field; a kind above 3 is a string.
static size_t size_of(const uint8_t kind, const size_t string_size)
{
    static const size_t sizes[] = {1U, 2U, 4U, 8U};
    return (kind < 4U) ? sizes[kind] : string_size;
}

static uint64_t read_field(octet_reader_t* const reader, const uint8_t kind, const size_t size)
{
    switch (kind) {
    case 0:
        return octet_read_u8(reader);
    case 1:
        return octet_read_u16(reader);
    case 2:
        return octet_read_u32(reader);
    case 3:
        return octet_read_u64(reader);
    default: {
        const uint8_t* const string = octet_read_octets(reader, size);
        PROVE((string == NULL) || __CPROVER_r_ok(string, size), "a string is inside the buffer");
        return ((kind == 4U) && (string != NULL) && (size > 0U)) ? string[size - 1U] : 0U;
    }
    }
}

/// Write a field; returns what a reader must find.
static uint64_t write_field(octet_writer_t* const writer, const uint8_t kind, const size_t size)
{
    const uint64_t value = nondet_u64();
    switch (kind) {
    case 0:
        octet_write_u8(writer, (uint8_t)value);
        return (uint8_t)value;
    case 1:
        octet_write_u16(writer, (uint16_t)value);
        return (uint16_t)value;
    case 2:
        octet_write_u32(writer, (uint32_t)value);
        return (uint32_t)value;
    case 3:
        octet_write_u64(writer, value);
        return value;
    case 4: {
        uint8_t string[CAPACITY];
        ASSUME(size <= CAPACITY);
        octet_write_octets(writer, string, size);
        return (size > 0U) ? string[size - 1U] : 0U;
    }
    default: {
        uint8_t* const space = octet_write_space(writer, size);
        PROVE((space == NULL) || __CPROVER_w_ok(space, size), "space is inside the buffer");
        return 0U;
    }
    }
}

void proof(void)
{
    const size_t size = any_size(CAPACITY);
    uint8_t octets[CAPACITY];
    octet_writer_t writer = octet_writer(octets, size);
    uint8_t kinds[FIELDS];
    size_t sizes[FIELDS];
    uint64_t values[FIELDS];
    bool had_failed = false;
    for (size_t i = 0U; i < FIELDS; i++) {
        const size_t room = size - writer.position;
        values[i]         = write_field(&writer, kinds[i], sizes[i]);
        PROVE(writer.position <= size, "the writer is inside its buffer");
        PROVE(writer.failed == (had_failed || (size_of(kinds[i], sizes[i]) > room)),
              "a writer fails if and only if a field does not fit, and stays failed");
        had_failed = writer.failed;
    }
    octet_reader_t reader = octet_reader(octets, size);
    had_failed            = false;
    for (size_t i = 0U; i < FIELDS; i++) {
        const size_t left    = reader.size - reader.position;
        const uint64_t value = read_field(&reader, kinds[i], sizes[i]);
        PROVE(reader.position <= reader.size, "the reader is inside its buffer");
        PROVE(reader.failed == (had_failed || (size_of(kinds[i], sizes[i]) > left)),
              "a reader fails if and only if a field is not there, and stays failed");
        PROVE(IMPLIES(reader.failed, value == 0U), "what is not there is read as 0");
        PROVE(IMPLIES(!writer.failed, !reader.failed && (value == values[i])), "a field is read as written");
        PROVE(octet_reader_left(&reader) == (reader.failed ? 0U : reader.size - reader.position),
              "the octets left are those after the position");
        had_failed = reader.failed;
    }
    PROVE(octet_reader_is_done(&reader) == (!reader.failed && (reader.position == reader.size)),
          "a reader is done if and only if it has read every octet");
}
