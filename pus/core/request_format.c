// SPDX-License-Identifier: Apache-2.0
#include "pus/core/request_format.h"

#include "base/assertion.h"
#include "base/value.h"
#include "pus/core/packet.h"

#define REGISTERS 2U
#define LAYOUT_SHIFT 16U
#define LAYOUT_MASK 0x1FU
#define LENGTH_OFFSET 4U // Offset of the length field in a packet [octets].

typedef struct {
    const uint8_t* body;
    const uint8_t* end; // End of the body.
    uint8_t left;       // Number of repetitions after the present one.
} loop_t;

typedef struct {
    const uint8_t* next; // Next word of the program.
    octet_reader_t* reader;
    uint32_t layouts[REGISTERS];
    uint8_t selector;
    uint8_t depth;
    loop_t loops[PUS_REQUEST_FORMAT_DEPTH];
} interpreter_t;

static uint8_t operand(interpreter_t* const interpreter)
{
    const uint8_t value = *interpreter->next;
    interpreter->next++;
    return value;
}

/// Read a count, and enter the body; if the count is 0, skip the body. False: the reader is at a count that
/// is too small or missing.
static bool count(interpreter_t* const interpreter)
{
    octet_reader_t* const reader = interpreter->reader;
    const uint8_t least          = operand(interpreter);
    const uint8_t length         = operand(interpreter);
    const uint8_t found          = octet_read_u8(reader);
    if (reader->failed || (found < least)) {
        if (!reader->failed) {
            reader->position--;
        }
        return false;
    }
    if (found == 0U) {
        interpreter->next += length;
        return true;
    }
    FSW_ASSERT(interpreter->depth < PUS_REQUEST_FORMAT_DEPTH);
    interpreter->loops[interpreter->depth] =
        (loop_t){.body = interpreter->next, .end = interpreter->next + length, .left = (uint8_t)(found - 1U)};
    interpreter->depth++;
    return true;
}

/// If the program is at the end of a body, enter the body again, or continue after it.
static void repeat(interpreter_t* const interpreter)
{
    while ((interpreter->depth > 0U) &&
           (interpreter->next == interpreter->loops[interpreter->depth - 1U].end)) {
        loop_t* const loop = &interpreter->loops[interpreter->depth - 1U];
        if (loop->left > 0U) {
            loop->left--;
            interpreter->next = loop->body;
            return;
        }
        interpreter->depth--;
    }
}

static bool value(interpreter_t* const interpreter)
{
    const uint32_t layout = interpreter->layouts[operand(interpreter)];
    if (layout >= (uint32_t)VALUE_SCALARS) {
        return false;
    }
    (void)octet_read_octets(interpreter->reader, value_size((value_type_t)layout));
    return true;
}

/// Read a request inside the request; its length field gives its size. The service checks its content later.
static bool packet(octet_reader_t* const reader)
{
    const size_t left = octet_reader_left(reader);
    if (left < PUS_TC_MIN) {
        reader->failed = true;
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
static bool step(interpreter_t* const interpreter, const uint8_t word)
{
    octet_reader_t* const reader = interpreter->reader;
    uint8_t argument             = 0U;
    switch (word) {
    case PUS_REQUEST_FORMAT_SKIP:
        (void)octet_read_octets(reader, operand(interpreter));
        return true;
    case PUS_REQUEST_FORMAT_COUNT:
        return count(interpreter);
    case PUS_REQUEST_FORMAT_SELECT:
        interpreter->selector = octet_read_u8(reader);
        return true;
    case PUS_REQUEST_FORMAT_CASE:
        argument = operand(interpreter);
        interpreter->next += (argument == interpreter->selector) ? 1U : (1U + (size_t)*interpreter->next);
        return true;
    case PUS_REQUEST_FORMAT_JUMP:
        argument = operand(interpreter);
        interpreter->next += argument;
        return true;
    case PUS_REQUEST_FORMAT_ID:
        argument                       = operand(interpreter);
        interpreter->layouts[argument] = (octet_read_u32(reader) >> LAYOUT_SHIFT) & LAYOUT_MASK;
        return true;
    case PUS_REQUEST_FORMAT_LAYOUT:
        argument                       = operand(interpreter);
        interpreter->layouts[argument] = octet_read_u8(reader);
        return true;
    case PUS_REQUEST_FORMAT_VALUE:
        return value(interpreter);
    case PUS_REQUEST_FORMAT_SIZED:
        (void)octet_read_octets(reader, octet_read_u16(reader));
        return true;
    case PUS_REQUEST_FORMAT_PACKET:
        return packet(reader);
    case PUS_REQUEST_FORMAT_REST:
        (void)octet_read_octets(reader, octet_reader_left(reader));
        return true;
    default: // PUS_REQUEST_FORMAT_FAIL: the selector, which was read last, has no case.
        reader->position--;
        return false;
    }
}

bool pus_request_format_check(const uint8_t* const program, octet_reader_t* const reader)
{
    FSW_ASSERT((program != NULL) && (reader != NULL));
    interpreter_t interpreter = {.next = program, .reader = reader};
    for (uint8_t word = operand(&interpreter); word != (uint8_t)PUS_REQUEST_FORMAT_END;
         word         = operand(&interpreter)) {
        if (!step(&interpreter, word) || reader->failed) {
            return false;
        }
        repeat(&interpreter);
    }
    return true;
}
