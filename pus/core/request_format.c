// SPDX-License-Identifier: Apache-2.0
#include "pus/core/request_format.h"

#include "base/assertion.h"
#include "base/value.h"
#include "pus/core/packet.h"

#define REGISTERS 2U
#define LAYOUT_SHIFT 16U
#define LAYOUT_MASK 0x1FU
#define LENGTH_OFFSET 4U // Of the length field in a packet [octets].

typedef struct {
    const uint8_t* body;
    const uint8_t* end; // Behind the body.
    uint8_t left;       // Passes after the present one.
} loop_t;

typedef struct {
    const uint8_t* next; // In the program.
    octet_reader_t* reader;
    uint32_t layouts[REGISTERS];
    uint8_t selector;
    uint8_t depth;
    loop_t loops[PUS_REQUEST_FORMAT_DEPTH];
} walk_t;

static uint8_t operand(walk_t* const walk)
{
    const uint8_t value = *walk->next;
    walk->next++;
    return value;
}

/// Enter the body, or go past it if the count is 0.
static bool count(walk_t* const walk)
{
    const uint8_t least  = operand(walk);
    const uint8_t length = operand(walk);
    const uint8_t found  = octet_read_u8(walk->reader);
    if (walk->reader->failed || (found < least)) {
        return false;
    }
    if (found == 0U) {
        walk->next += length;
        return true;
    }
    FSW_ASSERT(walk->depth < PUS_REQUEST_FORMAT_DEPTH);
    walk->loops[walk->depth] =
        (loop_t){.body = walk->next, .end = walk->next + length, .left = (uint8_t)(found - 1U)};
    walk->depth++;
    return true;
}

/// At the end of a body: once more, or out of it.
static void repeat(walk_t* const walk)
{
    while ((walk->depth > 0U) && (walk->next == walk->loops[walk->depth - 1U].end)) {
        loop_t* const loop = &walk->loops[walk->depth - 1U];
        if (loop->left > 0U) {
            loop->left--;
            walk->next = loop->body;
            return;
        }
        walk->depth--;
    }
}

static bool value(walk_t* const walk)
{
    const uint32_t layout = walk->layouts[operand(walk)];
    if (layout >= (uint32_t)VALUE_SCALARS) {
        return false;
    }
    (void)octet_read_octets(walk->reader, value_size((value_type_t)layout));
    return true;
}

/// A request within the request: its size is in its own header; the rest is checked when it is used.
static bool packet(octet_reader_t* const reader)
{
    const size_t left = octet_reader_left(reader);
    if (left < PUS_TC_MIN) {
        (void)octet_read_octets(reader, PUS_TC_MIN);
        return false;
    }
    const uint8_t* const octets = &reader->octets[reader->position + LENGTH_OFFSET];
    const size_t size           = PUS_PRIMARY_HEADER_SIZE + 1U + (((size_t)octets[0] << 8U) | octets[1]);
    if ((size < PUS_TC_MIN) || (size > PUS_PACKET_MAX)) {
        return false;
    }
    (void)octet_read_octets(reader, size);
    return true;
}

/// Perform one word of the program other than END. False: the data is wrong.
static bool step(walk_t* const walk, const uint8_t word)
{
    octet_reader_t* const reader = walk->reader;
    uint8_t place                = 0U;
    switch (word) {
    case PUS_REQUEST_FORMAT_SKIP:
        (void)octet_read_octets(reader, operand(walk));
        return true;
    case PUS_REQUEST_FORMAT_COUNT:
        return count(walk);
    case PUS_REQUEST_FORMAT_SELECT:
        walk->selector = octet_read_u8(reader);
        return true;
    case PUS_REQUEST_FORMAT_CASE:
        place = operand(walk);
        walk->next += (place == walk->selector) ? 1U : (1U + (size_t)*walk->next);
        return true;
    case PUS_REQUEST_FORMAT_JUMP:
        place = operand(walk);
        walk->next += place;
        return true;
    case PUS_REQUEST_FORMAT_ID:
        place                = operand(walk);
        walk->layouts[place] = (octet_read_u32(reader) >> LAYOUT_SHIFT) & LAYOUT_MASK;
        return true;
    case PUS_REQUEST_FORMAT_LAYOUT:
        place                = operand(walk);
        walk->layouts[place] = octet_read_u8(reader);
        return true;
    case PUS_REQUEST_FORMAT_VALUE:
        return value(walk);
    case PUS_REQUEST_FORMAT_SIZED:
        (void)octet_read_octets(reader, octet_read_u16(reader));
        return true;
    case PUS_REQUEST_FORMAT_PACKET:
        return packet(reader);
    case PUS_REQUEST_FORMAT_REST:
        (void)octet_read_octets(reader, octet_reader_left(reader));
        return true;
    default: // PUS_REQUEST_FORMAT_FAIL: no case for the selector.
        return false;
    }
}

bool pus_request_format_walk(const uint8_t* const program, octet_reader_t* const reader)
{
    FSW_ASSERT((program != NULL) && (reader != NULL));
    walk_t walk = {.next = program, .reader = reader};
    repeat(&walk);
    for (uint8_t word = operand(&walk); word != (uint8_t)PUS_REQUEST_FORMAT_END; word = operand(&walk)) {
        if (!step(&walk, word) || reader->failed) {
            return false;
        }
        repeat(&walk);
    }
    return true;
}
