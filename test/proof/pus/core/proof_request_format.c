// SPDX-License-Identifier: Apache-2.0
// Proves: from every state of the reader, each word of a format has the effect that request_format.h
//     describes: it takes exactly the octets of its field, refuses a count that is too small, a layout
//     without a scalar value and a nested request of a size that no request can have, and continues at the
//     right word. After a wrong count or selector it points at that. A group is repeated as often as its
//     count states; then the format continues after it. No access is outside the data or the format. So a
//     request is read as its format states, word by word.
// Bounds: data of 0..20 octets that were read up to any position; any operands, selector, layouts and nested
//     counts; one word and one end of groups, by induction the words of any format. Groups are nested, and
//     operands number layouts, only as far as the generator of the formats permits; a format refuses only
//     after a selector.
// Replaced: nothing.
// Sources: base/octets.c base/value.c
// Options: --unwind 6
// Fault: pus/core/request_format.c
//   - if (reader->failed || (found < least)) {
//   + if (reader->failed) {
// Fault: pus/core/request_format.c
//   - if (!reader->failed) {
//   + if (reader->failed) {
// Fault: pus/core/request_format.c
//   - if (loop->left > 0U) {
//   + if (loop->left > 1U) {
// Fault: pus/core/request_format.c
//   - if ((size < PUS_TC_MIN) || (size > PUS_PACKET_MAX)) {
//   + if (size > PUS_PACKET_MAX) {
// Fault: pus/core/request_format.c
//   - interpreter->next += (argument == interpreter->selector) ? 1U : (1U + (size_t)*interpreter->next);
//   + interpreter->next += (argument == interpreter->selector) ? 1U : (size_t)*interpreter->next;
#include "pus/core/request_format.c"

#include "test/proof/proof.h"

#define DATA 20U
#define WORDS 600U // Larger than any distance that an operand can state.
#define AT 300U    // Place of the word.

static uint8_t words[WORDS];
static uint8_t data[DATA];
static octet_reader_t reader;
static interpreter_t before;
static interpreter_t after;
static const uint8_t* field; // The octets that are not read yet.
static size_t left;          // Number of these octets.

/// Any state of the interpreter and its reader, in which the word at AT has been taken.
static void any_state(void)
{
    __CPROVER_havoc_object(words);
    __CPROVER_havoc_object(data);
    const size_t size = any_size(DATA); // The data end with the array: the first octet after them is outside.
    const size_t position = any_size(size);
    reader                = octet_reader(&data[DATA - size], size);
    reader.position       = position;
    field                 = &data[DATA - size + position];
    left                  = size - position;
    before                = (interpreter_t){.next = &words[AT + 1U], .reader = &reader};
    before.layouts[0]     = nondet_u32();
    before.layouts[1]     = nondet_u32();
    before.selector       = nondet_u8();
    before.depth          = nondet_u8();
    ASSUME(before.depth <= PUS_REQUEST_FORMAT_DEPTH);
    for (size_t i = 0U; i < PUS_REQUEST_FORMAT_DEPTH; i++) {
        before.loops[i] = (loop_t){&words[any_size(WORDS)], &words[any_size(WORDS)], nondet_u8()};
    }
    after = before;
}

/// True if exactly `size` octets were taken, or the reader has failed because there are fewer.
static bool takes(const size_t size)
{
    return (size <= left) ? (!reader.failed && (octet_reader_left(&reader) == (left - size))) : reader.failed;
}

static bool goes_to(const size_t position)
{
    return (after.next == &words[position]) && (after.depth == before.depth);
}

static void prove_count(const bool is_good)
{
    const uint8_t least = words[AT + 1U];
    const size_t behind = AT + 3U + words[AT + 2U];
    PROVE(is_good == ((left >= 1U) && (field[0] >= least)), "a count is there, and large enough");
    if (is_good && (field[0] == 0U)) {
        PROVE(goes_to(behind) && takes(1U), "a count of 0 continues after the group");
    } else if (is_good) {
        const loop_t* const loop = &after.loops[before.depth];
        PROVE((after.depth == (before.depth + 1U)) && (after.next == &words[AT + 3U]) && takes(1U),
              "the first group begins");
        PROVE((loop->body == &words[AT + 3U]) && (loop->end == &words[behind]) &&
                  ((loop->left + 1U) == field[0]),
              "there are as many groups as were counted");
    } else {
        PROVE(octet_reader_left(&reader) == left, "the reader is at a refused or missing count");
    }
}

static void prove_value(const bool is_good)
{
    static const uint8_t sizes[] = {1U, 2U, 4U, 8U, 1U, 2U, 4U, 8U, 4U, 8U, 1U};
    const uint32_t layout        = before.layouts[words[AT + 1U]];
    PROVE(is_good == (layout < sizeof sizes), "only scalars are read");
    PROVE(IMPLIES(is_good, goes_to(AT + 2U) && takes(sizes[layout])), "a value has the size of its layout");
}

static void prove_packet(const bool is_good)
{
    const size_t size = (left >= PUS_TC_MIN) ? ((size_t)octets_u16_at(&field[4]) + 7U) : 0U;
    PROVE(is_good == ((size >= 13U) && (size <= 4096U)), "a nested request has a permitted size");
    PROVE(IMPLIES(is_good, goes_to(AT + 1U) && takes(size)),
          "a nested request takes the size of its length field");
}

static void prove_plain(const uint8_t word, const bool is_good)
{
    const uint8_t operand = words[AT + 1U];
    if (word == PUS_REQUEST_FORMAT_SKIP) {
        PROVE(is_good && goes_to(AT + 2U) && takes(operand), "octets are skipped");
    } else if (word == PUS_REQUEST_FORMAT_SELECT) {
        PROVE(is_good && goes_to(AT + 1U) && takes(1U), "a selector is an octet");
        PROVE(IMPLIES(left >= 1U, after.selector == field[0]), "the selector is the octet in the data");
    } else if (word == PUS_REQUEST_FORMAT_CASE) {
        const size_t body = (operand == before.selector) ? 0U : words[AT + 2U];
        PROVE(is_good && goes_to(AT + 3U + body) && takes(0U), "a case is for its selector only");
    } else if (word == PUS_REQUEST_FORMAT_JUMP) {
        PROVE(is_good && goes_to(AT + 2U + operand) && takes(0U), "a jump leads past the cases");
    } else if (word == PUS_REQUEST_FORMAT_ID) {
        PROVE(is_good && goes_to(AT + 2U) && takes(4U), "an id has four octets");
        PROVE(IMPLIES(left >= 4U, after.layouts[operand] == (field[1] & 0x1FU)),
              "an id gives the layout of its value");
    } else if (word == PUS_REQUEST_FORMAT_LAYOUT) {
        PROVE(is_good && goes_to(AT + 2U) && takes(1U), "a layout is an octet");
        PROVE(IMPLIES(left >= 1U, after.layouts[operand] == field[0]), "the layout is the octet in the data");
    } else if (word == PUS_REQUEST_FORMAT_SIZED) {
        const size_t size = (left >= 2U) ? octets_u16_at(field) : 0U;
        PROVE(is_good && goes_to(AT + 1U) && takes(2U + size), "a text takes the size of its length field");
    } else if (word == PUS_REQUEST_FORMAT_REST) {
        PROVE(is_good && goes_to(AT + 1U) && takes(left), "all octets are taken");
    } else {
        PROVE(!is_good && (octet_reader_left(&reader) == (left + 1U)),
              "without a case the request is refused at its selector");
    }
}

static void prove_word(void)
{
    const uint8_t word = words[AT];
    ASSUME(word != PUS_REQUEST_FORMAT_END);
    // The generator of the formats ensures these three conditions.
    ASSUME((word != PUS_REQUEST_FORMAT_COUNT) || (before.depth < PUS_REQUEST_FORMAT_DEPTH));
    ASSUME(((word != PUS_REQUEST_FORMAT_ID) && (word != PUS_REQUEST_FORMAT_LAYOUT) &&
            (word != PUS_REQUEST_FORMAT_VALUE)) ||
           (words[AT + 1U] < REGISTERS));
    ASSUME(((word != PUS_REQUEST_FORMAT_FAIL) && (word <= PUS_REQUEST_FORMAT_REST)) ||
           (reader.position >= 1U));
    const bool is_good = step(&after, word);
    PROVE(reader.position <= reader.size, "the reader stays inside the data");
    if (word == PUS_REQUEST_FORMAT_COUNT) {
        prove_count(is_good);
    } else if (word == PUS_REQUEST_FORMAT_VALUE) {
        prove_value(is_good);
    } else if (word == PUS_REQUEST_FORMAT_PACKET) {
        prove_packet(is_good);
    } else {
        prove_plain(word, is_good);
    }
}

/// The end of groups: the innermost group with repetitions left begins again; the groups inside it have none.
static void prove_end_of_groups(void)
{
    repeat(&after);
    const uint8_t depth = after.depth;
    PROVE(depth <= before.depth, "groups end, and none begins");
    for (uint8_t i = 0U; i < PUS_REQUEST_FORMAT_DEPTH; i++) {
        const bool is_over = (before.loops[i].end == before.next) && (before.loops[i].left == 0U);
        PROVE(IMPLIES((i >= depth) && (i < before.depth), is_over), "a group that ends has none left");
    }
    if ((depth > 0U) && (before.loops[depth - 1U].end == before.next)) {
        PROVE((after.next == before.loops[depth - 1U].body) &&
                  ((after.loops[depth - 1U].left + 1U) == before.loops[depth - 1U].left),
              "the next group begins");
    } else {
        PROVE(after.next == before.next, "the format continues after the groups");
    }
}

void proof(void)
{
    any_state();
    if (nondet_bool()) {
        prove_word();
    } else {
        prove_end_of_groups();
    }
}
