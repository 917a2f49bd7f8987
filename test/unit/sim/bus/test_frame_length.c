// SPDX-License-Identifier: Apache-2.0
// Compares frame lengths with those of a second encoder, which was written bit by bit from the frame formats,
// with the well-known worst-case formula, and with lengths counted by hand.
#include "sim/bus/frame_length.h"
#include "unity.h"

#include <string.h>

/// Number of bits of a frame at each rate, stuff bits included.
typedef struct {
    unsigned count; // Bits on the wire so far.
    unsigned run;   // Equal bits at the end.
    unsigned level; // Level of the last bit.
    unsigned nominal;
    unsigned fast;
    bool is_fast;
    uint32_t crc15;
    bool has_crc;
} wire_t;

static uint64_t random_state;

void setUp(void)
{
    random_state = 42U;
}

void tearDown(void)
{
}

static uint32_t random_u32(void)
{
    random_state = (random_state * 6364136223846793005U) + 1442695040888963407U;
    return (uint32_t)(random_state >> 33);
}

static void count_bit(wire_t* wire)
{
    wire->nominal += wire->is_fast ? 0U : 1U;
    wire->fast += wire->is_fast ? 1U : 0U;
    wire->count++;
}

static void put_plain(wire_t* wire, unsigned level)
{
    wire->run   = ((wire->count != 0U) && (wire->level == level)) ? (wire->run + 1U) : 1U;
    wire->level = level;
    count_bit(wire);
}

static void put_crc15(wire_t* wire, unsigned level)
{
    const unsigned next = level ^ ((wire->crc15 >> 14) & 1U);
    wire->crc15         = (wire->crc15 << 1) & 0x7FFFU;
    if (next != 0U) {
        wire->crc15 ^= 0x4599U;
    }
}

/// Append a bit by the stuffing rule: after five equal bits, first append their complement.
static void put(wire_t* wire, unsigned level)
{
    if (wire->run == 5U) {
        put_plain(wire, 1U - wire->level);
    }
    if (wire->has_crc) {
        put_crc15(wire, level);
    }
    put_plain(wire, level);
}

static void put_bits(wire_t* wire, uint64_t bits, unsigned count)
{
    for (unsigned i = count; i > 0U; i--) {
        put(wire, (unsigned)((bits >> (i - 1U)) & 1U));
    }
}

static void put_identifier(wire_t* wire, uint32_t id, unsigned remote, bool is_fd)
{
    if ((id & OSAL_CAN_EXTENDED) == 0U) {
        put_bits(wire, id & 0x7FFU, 11U);
        put(wire, remote);
        put(wire, 0U); // IDE
        return;
    }
    put_bits(wire, (id & OSAL_CAN_ID_MASK) >> 18, 11U);
    put(wire, 1U); // SRR
    put(wire, 1U); // IDE
    put_bits(wire, id & 0x3FFFFU, 18U);
    put(wire, remote);
    if (!is_fd) {
        put(wire, 0U); // r1
    }
}

static wire_t encode_classic(const osal_can_frame_t* frame)
{
    wire_t wire           = {.has_crc = true};
    const unsigned remote = ((frame->id & OSAL_CAN_REMOTE) != 0U) ? 1U : 0U;
    put(&wire, 0U);
    put_identifier(&wire, frame->id, remote, false);
    put(&wire, 0U); // r0
    put_bits(&wire, frame->length, 4U);
    for (unsigned i = 0U; (remote == 0U) && (i < frame->length); i++) {
        put_bits(&wire, frame->data[i], 8U);
    }
    const uint32_t crc = wire.crc15;
    wire.has_crc       = false;
    put_bits(&wire, crc, 15U);
    if (wire.run == 5U) {
        put_plain(&wire, 1U - wire.level); // A stuff bit may also follow the last CRC bit.
    }
    wire.crc15 = crc;
    for (unsigned i = 0U; i < 10U; i++) {
        put_plain(&wire, 1U); // CRC delimiter, ACK slot, ACK delimiter, seven bits of end of frame.
    }
    return wire;
}

static unsigned code_of(unsigned length)
{
    static const unsigned lengths[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
    unsigned code                   = 0U;
    while (lengths[code] != length) {
        code++;
    }
    return code;
}

static wire_t encode_fd(const osal_can_frame_t* frame)
{
    wire_t wire         = {0};
    const bool switches = (frame->flags & OSAL_CAN_FLAG_BRS) != 0U;
    put(&wire, 0U);
    put_identifier(&wire, frame->id, 0U, true);
    put(&wire, 1U); // FDF
    put(&wire, 0U); // res
    put(&wire, switches ? 1U : 0U);
    wire.is_fast = switches;
    put(&wire, ((frame->flags & OSAL_CAN_FLAG_ESI) != 0U) ? 1U : 0U);
    put_bits(&wire, code_of(frame->length), 4U);
    for (unsigned i = 0U; i < frame->length; i++) {
        put_bits(&wire, frame->data[i], 8U);
    }
    const unsigned crc_bits = (frame->length > 16U) ? 21U : 17U;
    for (unsigned i = 0U; i < (4U + crc_bits); i++) {
        if ((i % 4U) == 0U) {
            count_bit(&wire); // Fixed stuff bit in front of each group of four.
        }
        count_bit(&wire);
    }
    count_bit(&wire); // CRC delimiter, sent at the fast rate.
    wire.is_fast = false;
    for (unsigned i = 0U; i < 9U; i++) {
        count_bit(&wire);
    }
    return wire;
}

static osal_can_frame_t random_frame(bool is_fd)
{
    static const uint8_t fd_lengths[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
    osal_can_frame_t frame            = {0};
    frame.id                          = random_u32() & 0x7FFU;
    if ((random_u32() & 3U) == 0U) {
        frame.id = (random_u32() & OSAL_CAN_ID_MASK) | OSAL_CAN_EXTENDED;
    }
    frame.length = is_fd ? fd_lengths[random_u32() % 16U] : (uint8_t)(random_u32() % 9U);
    if (is_fd) {
        frame.flags = (uint8_t)(OSAL_CAN_FLAG_FD | (random_u32() & (OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI)));
    } else if ((random_u32() & 7U) == 0U) {
        frame.id |= OSAL_CAN_REMOTE;
    }
    // Long runs of equal bits are the critical case of stuffing.
    const uint32_t kind = random_u32() % 4U;
    for (unsigned i = 0U; i < frame.length; i++) {
        const uint8_t any = (uint8_t)random_u32();
        frame.data[i] =
            (kind == 0U) ? 0U : ((kind == 1U) ? 0xFFU : ((kind == 2U) ? (uint8_t)(any & 0x88U) : any));
    }
    return frame;
}

static void lengths_of_classic_frames_equal_the_reference(void)
{
    for (unsigned i = 0U; i < 100000U; i++) {
        const osal_can_frame_t frame = random_frame(false);
        const wire_t wire            = encode_classic(&frame);
        const frame_length_t length  = frame_length(&frame);
        TEST_ASSERT_EQUAL_UINT32(wire.crc15, frame_crc15(&frame));
        TEST_ASSERT_EQUAL_UINT32(wire.nominal, length.nominal_bits);
        TEST_ASSERT_EQUAL_UINT32(0U, length.data_bits);
    }
}

static void lengths_of_fd_frames_equal_the_reference(void)
{
    for (unsigned i = 0U; i < 100000U; i++) {
        const osal_can_frame_t frame = random_frame(true);
        const wire_t wire            = encode_fd(&frame);
        const frame_length_t length  = frame_length(&frame);
        TEST_ASSERT_EQUAL_UINT32(wire.nominal, length.nominal_bits);
        TEST_ASSERT_EQUAL_UINT32(wire.fast, length.data_bits);
    }
}

static void lengths_equal_those_counted_by_hand(void)
{
    // SYNC 0x080 without data, CRC-15 0x1C05: 0 00010000000 0 0 0 0000 001110000000101.
    // These are 34 bits, and 4 stuff bits; CRC delimiter, ACK and end of frame are 10 bits.
    const osal_can_frame_t sync = {.id = 0x080U};
    TEST_ASSERT_EQUAL_HEX16(0x1C05, frame_crc15(&sync));
    TEST_ASSERT_EQUAL_UINT32(34U + 4U + 10U, frame_length(&sync).nominal_bits);

    // Identifier 0x555 and data 0x55 alternate: five equal bits occur only in the fields between them.
    osal_can_frame_t dotted = {.id = 0x555U, .length = 8U};
    memset(dotted.data, 0x55, 8U);
    const frame_length_t length = frame_length(&dotted);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(108U, length.nominal_bits);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(108U + 4U, length.nominal_bits);

    osal_can_frame_t zero = {.length = 8U, .flags = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS};
    // Nominal rate, 17 + 2 + 9 = 28 bits: SOF 0, 11 bits of the identifier 0, RRS 0 and IDE 0 are 14 zeros
    // with 2 stuff bits; then FDF 1, res 0 and BRS 1; ACK and end of frame have 9 bits.
    // Fast rate: ESI 0, DLC 1000, 64 zeros. The last 67 of these bits are zeros and need 13 stuff bits. The
    // CRC has 27 bits, its fixed stuff bits included, and its delimiter 1 bit.
    const frame_length_t fast = frame_length(&zero);
    TEST_ASSERT_EQUAL_UINT32(28U, fast.nominal_bits);
    TEST_ASSERT_EQUAL_UINT32(5U + 64U + 13U + 28U, fast.data_bits);
}

static void a_stuff_bit_due_at_the_end_of_fd_data_is_the_fixed_stuff_bit(void)
{
    // The data 0x5F (0101 1111) end with five equal bits: the stuff bit after them is the fixed stuff bit at
    // the beginning of the CRC. In 0xBE (1011 1110) the five equal bits end before the last bit and need a
    // stuff bit.
    const osal_can_frame_t ends_in_run = {
        .length = 1U, .flags = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, .data = {0x5FU}};
    TEST_ASSERT_EQUAL_UINT32(5U + 8U + 28U, frame_length(&ends_in_run).data_bits);
    const osal_can_frame_t passes_run = {
        .length = 1U, .flags = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, .data = {0xBEU}};
    TEST_ASSERT_EQUAL_UINT32(5U + 8U + 1U + 28U, frame_length(&passes_run).data_bits);
}

/// Returns the number of bits with intermission if the frame has the most possible stuff bits: the first
/// after five equal bits, each further one after four bits.
static unsigned worst_classic(unsigned octets, unsigned header)
{
    return 13U + header + 8U * octets + (header + 8U * octets - 1U) / 4U;
}

static void no_frame_is_longer_than_the_worst_case(void)
{
    // The known worst cases with intermission: 135 bits with 8 octets, 55 without data, 160 with an extended
    // identifier and 8 octets.
    TEST_ASSERT_EQUAL_UINT(135U, worst_classic(8U, 34U));
    TEST_ASSERT_EQUAL_UINT(55U, worst_classic(0U, 34U));
    TEST_ASSERT_EQUAL_UINT(160U, worst_classic(8U, 54U));
    uint32_t longest = 0U;
    for (unsigned i = 0U; i < 200000U; i++) {
        const osal_can_frame_t frame = random_frame(false);
        const uint32_t bits          = frame_length(&frame).nominal_bits + CAN_INTERMISSION_BITS;
        const unsigned octets        = ((frame.id & OSAL_CAN_REMOTE) != 0U) ? 0U : frame.length;
        const unsigned header        = ((frame.id & OSAL_CAN_EXTENDED) != 0U) ? 54U : 34U;
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(worst_classic(octets, header), bits);
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(13U + header + 8U * octets, bits);
        longest = (bits > longest) ? bits : longest;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(140U, longest);
}

static void the_longest_fd_frame_has_the_computed_time_at_1_and_5_mbit_s(void)
{
    // Bits in alternating groups of four have the most stuff bits; the identifier 0x078 begins such a
    // sequence.
    static const struct {
        uint8_t octets;
        unsigned tenths_us; // Duration [0.1 us] with intermission.
    } cases[] = {{8U, 558U}, {16U, 718U}, {24U, 888U}, {48U, 1368U}, {64U, 1688U}};
    for (unsigned i = 0U; i < 5U; i++) {
        unsigned longest = 0U;
        for (unsigned k = 0U; k < 4096U; k++) {
            osal_can_frame_t frame = {
                .id = 0x078U, .length = cases[i].octets, .flags = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS};
            for (unsigned n = 0U; n < frame.length; n++) {
                frame.data[n] =
                    (k < 2048U) ? (uint8_t)(((n + k) % 2U == 0U) ? (k >> 1) : ~(k >> 1)) : (uint8_t)(k >> 1);
            }
            const frame_length_t length = frame_length(&frame);
            const unsigned tenths =
                (length.nominal_bits + CAN_INTERMISSION_BITS) * 10U + length.data_bits * 2U;
            TEST_ASSERT_LESS_OR_EQUAL_UINT(cases[i].tenths_us, tenths);
            longest = (tenths > longest) ? tenths : longest;
        }
        // Constant patterns reach the bound except for a few stuff bits.
        TEST_ASSERT_GREATER_THAN_UINT(cases[i].tenths_us * 95U / 100U, longest);
    }
}

static void an_fd_frame_without_rate_switch_is_sent_at_the_nominal_rate(void)
{
    const osal_can_frame_t frame = {.id = 0x123U, .length = 8U, .flags = OSAL_CAN_FLAG_FD};
    TEST_ASSERT_EQUAL_UINT32(0U, frame_length(&frame).data_bits);
    TEST_ASSERT_GREATER_THAN_UINT32(100U, frame_length(&frame).nominal_bits);
}

static void fd_data_lengths_are_rounded_up(void)
{
    TEST_ASSERT_EQUAL_UINT8(8U, frame_fd_length(8U));
    TEST_ASSERT_EQUAL_UINT8(12U, frame_fd_length(9U));
    TEST_ASSERT_EQUAL_UINT8(24U, frame_fd_length(21U));
    TEST_ASSERT_EQUAL_UINT8(64U, frame_fd_length(49U));
    TEST_ASSERT_EQUAL_UINT8(64U, frame_fd_length(64U));
}

static void an_error_frame_has_no_length(void)
{
    const osal_can_frame_t frame = {.id = OSAL_CAN_ERROR | OSAL_CAN_ERROR_NO_ACK, .length = 8U};
    TEST_ASSERT_EQUAL_UINT32(0U, frame_length(&frame).nominal_bits);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(lengths_of_classic_frames_equal_the_reference);
    RUN_TEST(lengths_of_fd_frames_equal_the_reference);
    RUN_TEST(lengths_equal_those_counted_by_hand);
    RUN_TEST(a_stuff_bit_due_at_the_end_of_fd_data_is_the_fixed_stuff_bit);
    RUN_TEST(no_frame_is_longer_than_the_worst_case);
    RUN_TEST(the_longest_fd_frame_has_the_computed_time_at_1_and_5_mbit_s);
    RUN_TEST(an_fd_frame_without_rate_switch_is_sent_at_the_nominal_rate);
    RUN_TEST(fd_data_lengths_are_rounded_up);
    RUN_TEST(an_error_frame_has_no_length);
    return UNITY_END();
}
