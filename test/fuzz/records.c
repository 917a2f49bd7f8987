// SPDX-License-Identifier: Apache-2.0
#include "test/fuzz/fuzz.h"

#include "base/assertion.h"
#include "base/crc.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RECORDS_MAX 256U
#define OCTETS_MAX 65535U
#define PACKET_MIN 9U
#define TIME_OFFSET 13U

void fuzz_fail(const char* const file, const int line, const char* const condition)
{
    (void)fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, condition);
    abort();
}

/// An assertion that an input makes fail is an error of the tested code.
void fsw_assertion_failed(const char* const file, const int line)
{
    fuzz_fail(file, line, "assertion");
}

uint32_t fuzz_random(uint32_t* const state)
{
    *state = (*state * 1664525U) + 1013904223U;
    return *state >> 8U;
}

// ---- Reading ----

fuzz_input_t fuzz_input(const uint8_t* const data, const size_t size)
{
    return (fuzz_input_t){.data = data, .size = size};
}

bool fuzz_next(fuzz_input_t* const input, fuzz_record_t* const out_record)
{
    free(input->copy);
    input->copy = NULL;
    if ((input->size - input->position) < FUZZ_RECORD_HEADER) {
        return false;
    }
    const uint8_t* const head = &input->data[input->position];
    const size_t left         = input->size - input->position - FUZZ_RECORD_HEADER;
    const size_t stated       = ((size_t)head[2] << 8U) | head[3];
    out_record->kind          = head[0];
    out_record->argument      = head[1];
    out_record->size          = (stated < left) ? stated : left;
    input->copy               = malloc((out_record->size > 0U) ? out_record->size : 1U);
    FUZZ_CHECK(input->copy != NULL);
    (void)memcpy(input->copy, &head[FUZZ_RECORD_HEADER], out_record->size);
    out_record->octets = input->copy;
    input->position += FUZZ_RECORD_HEADER + out_record->size;
    return true;
}

// ---- Mutating ----

typedef struct {
    size_t offset; // Offset of its header.
    size_t size;   // Size of its octets.
} span_t;

static size_t find_records(const uint8_t* const data, const size_t size, span_t spans[RECORDS_MAX])
{
    size_t count    = 0U;
    size_t position = 0U;
    while ((count < RECORDS_MAX) && ((size - position) >= FUZZ_RECORD_HEADER)) {
        const size_t left   = size - position - FUZZ_RECORD_HEADER;
        const size_t stated = ((size_t)data[position + 2U] << 8U) | data[position + 3U];
        spans[count]        = (span_t){position, (stated < left) ? stated : left};
        position += FUZZ_RECORD_HEADER + spans[count].size;
        count++;
    }
    return count;
}

/// Replace the record at `span` by `octets`. Returns the new size, or the old one if it does not fit.
static size_t replace(uint8_t* const data, const size_t size, const size_t max_size, const span_t span,
                      const uint8_t* const octets, const size_t count)
{
    const size_t end = span.offset + FUZZ_RECORD_HEADER + span.size;
    if ((count > OCTETS_MAX) || ((size - span.size + count) > max_size)) {
        return size;
    }
    (void)memmove(&data[span.offset + FUZZ_RECORD_HEADER + count], &data[end], size - end);
    (void)memcpy(&data[span.offset + FUZZ_RECORD_HEADER], octets, count);
    data[span.offset + 2U] = (uint8_t)(count >> 8U);
    data[span.offset + 3U] = (uint8_t)count;
    return size - span.size + count;
}

static size_t mutate_octets(uint8_t* const data, const size_t size, const size_t max_size, const span_t span,
                            uint32_t* const random, const fuzz_repair_t repair)
{
    static uint8_t octets[OCTETS_MAX];
    const size_t room = ((max_size - size) < (OCTETS_MAX - span.size)) ? (max_size - size) : 0U;
    (void)memcpy(octets, &data[span.offset + FUZZ_RECORD_HEADER], span.size);
    const size_t count = LLVMFuzzerMutate(octets, span.size, span.size + room);
    if ((repair != NULL) && ((fuzz_random(random) % 8U) != 0U)) {
        repair(data[span.offset], octets, count, random);
    }
    return replace(data, size, max_size, span, octets, count);
}

/// Put a copy of one record in front of another.
static size_t copy_record(uint8_t* const data, const size_t size, const size_t max_size, const span_t from,
                          const span_t to)
{
    static uint8_t record[FUZZ_RECORD_HEADER + OCTETS_MAX];
    const size_t count = FUZZ_RECORD_HEADER + from.size;
    if ((size + count) > max_size) {
        return size;
    }
    (void)memcpy(record, &data[from.offset], count);
    record[2] = (uint8_t)(from.size >> 8U);
    record[3] = (uint8_t)from.size;
    (void)memmove(&data[to.offset + count], &data[to.offset], size - to.offset);
    (void)memcpy(&data[to.offset], record, count);
    return size + count;
}

static size_t drop_record(uint8_t* const data, const size_t size, const span_t span)
{
    const size_t end = span.offset + FUZZ_RECORD_HEADER + span.size;
    (void)memmove(&data[span.offset], &data[end], size - end);
    return size - (end - span.offset);
}

static size_t new_record(uint8_t* const data, const size_t size, const size_t max_size,
                         uint32_t* const random)
{
    if ((size + FUZZ_RECORD_HEADER) > max_size) {
        return size;
    }
    const uint8_t head[FUZZ_RECORD_HEADER] = {(uint8_t)fuzz_random(random), (uint8_t)fuzz_random(random), 0U,
                                              0U};
    (void)memcpy(&data[size], head, sizeof head);
    return size + sizeof head;
}

size_t fuzz_mutate_records(uint8_t* const data, const size_t size, const size_t max_size, const unsigned seed,
                           const fuzz_repair_t repair)
{
    uint32_t random = seed;
    span_t spans[RECORDS_MAX];
    const size_t count    = find_records(data, size, spans);
    const uint32_t action = fuzz_random(&random) % 16U;
    if (count == 0U) {
        return new_record(data, 0U, max_size, &random);
    }
    const span_t span  = spans[fuzz_random(&random) % count];
    const span_t other = spans[fuzz_random(&random) % count];
    switch (action) {
    case 0:
        return LLVMFuzzerMutate(data, size, max_size);
    case 1:
        return drop_record(data, size, span);
    case 2:
    case 3:
        return copy_record(data, size, max_size, span, other);
    case 4:
        return new_record(data, size, max_size, &random);
    case 5:
        data[span.offset] = (uint8_t)fuzz_random(&random);
        return size;
    case 6:
        data[span.offset + 1U] = (uint8_t)fuzz_random(&random);
        return size;
    default:
        return mutate_octets(data, size, max_size, span, &random, repair);
    }
}

size_t fuzz_mutate_message(uint8_t* const data, const size_t size, const size_t max_size, const unsigned seed,
                           const fuzz_repair_t repair)
{
    uint32_t random     = seed;
    const size_t result = LLVMFuzzerMutate(data, size, max_size);
    if ((fuzz_random(&random) % 8U) != 0U) {
        repair(0U, data, result, &random);
    }
    return result;
}

// ---- Repairing ----

void fuzz_repair_packet(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    (void)kind;
    if (size < PACKET_MIN) {
        return;
    }
    const bool is_tc = ((octets[0] & 0x10U) != 0U);
    if ((fuzz_random(random) % 16U) != 0U) { // Version 0, secondary header, unsegmented, PUS-C.
        octets[0] = (uint8_t)((octets[0] & 0x17U) | 0x08U);
        octets[2] |= 0xC0U;
        octets[6] = (uint8_t)((octets[6] & 0x0FU) | 0x20U);
        if (!is_tc && (size > TIME_OFFSET)) {
            octets[TIME_OFFSET] = 0x1FU;
        }
    }
    octets[4]          = (uint8_t)((size - 7U) >> 8U);
    octets[5]          = (uint8_t)(size - 7U);
    const uint16_t crc = crc16_ccitt(octets, size - 2U);
    octets[size - 2U]  = (uint8_t)(crc >> 8U);
    octets[size - 1U]  = (uint8_t)crc;
}
