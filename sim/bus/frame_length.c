// SPDX-License-Identifier: Apache-2.0
#include "sim/bus/frame_length.h"

#include <stdbool.h>
#include <stddef.h>

// State of the stuffing rule: 4 x level of the last bit + length of the run of equal bits - 1 (1..4; a fifth
// equal bit is followed by a stuff bit of the other level, which starts a run of its own).
#define AFTER_START_OF_FRAME 0U // One dominant bit.
#define STATE_MASK 7U
#define BASE_HEADER_BITS 18U // Of a classic frame, after the start of frame, to the data length code.
#define EXTENDED_HEADER_BITS 38U

// Next state for each state and the next four bits, or one bit; 8 is added if a stuff bit was inserted.
static const uint8_t nibble_step[8][16] = {
    {12, 4, 0, 5, 1, 4, 0, 6, 2, 4, 0, 5, 1, 4, 0, 7},
    {8, 13, 0, 5, 1, 4, 0, 6, 2, 4, 0, 5, 1, 4, 0, 7},
    {9, 12, 8, 14, 1, 4, 0, 6, 2, 4, 0, 5, 1, 4, 0, 7},
    {10, 12, 8, 13, 9, 12, 8, 15, 2, 4, 0, 5, 1, 4, 0, 7},
    {3, 4, 0, 5, 1, 4, 0, 6, 2, 4, 0, 5, 1, 4, 0, 8},
    {3, 4, 0, 5, 1, 4, 0, 6, 2, 4, 0, 5, 1, 4, 9, 12},
    {3, 4, 0, 5, 1, 4, 0, 6, 2, 4, 0, 5, 10, 12, 8, 13},
    {3, 4, 0, 5, 1, 4, 0, 6, 11, 12, 8, 13, 9, 12, 8, 14},
};
static const uint8_t bit_step[8][2] = {{1, 4}, {2, 4}, {3, 4}, {12, 4}, {0, 5}, {0, 6}, {0, 7}, {0, 8}};

static const uint16_t crc15_step[16] = {0x0000, 0x4599, 0x4EAB, 0x0B32, 0x58CF, 0x1D56, 0x1664, 0x53FD,
                                        0x7407, 0x319E, 0x3AAC, 0x7F35, 0x2CC8, 0x6951, 0x6263, 0x27FA};

typedef struct {
    uint32_t state;
    uint32_t stuffed;
} stuffing_t;

static void take(stuffing_t* const stuffing, const uint32_t next)
{
    stuffing->state = next & STATE_MASK;
    stuffing->stuffed += next >> 3;
}

#define CRC15_BITS 15U
#define CRC15_REST (CRC15_BITS - 8U) // Bits of a CRC after its first octet.
#define BASE_HEADERS (2048U * 16U)   // Base identifiers and data length codes.
#define IS_KNOWN 0x80000000U         // Marks an effect that has been computed.
#define FD_BASE_HEADERS (2048U * 2U) // Base identifiers, without and with bit rate switch.
#define FD_IS_KNOWN 0x80U
#define FD_CONTROL_BITS 5U // Error state indicator and data length code.

/// Tables for whole octets, and for whole headers of data frames in base format.
typedef struct {
    uint8_t stuffing[8U * 256U];                 ///< For each state and octet: state | stuff bits << 3.
    uint8_t crc15_rest[8U * (1U << CRC15_REST)]; ///< The same for the last bits of a CRC.
    uint16_t crc15[256];
    /// For each identifier << 4 | length of a data frame in base format, the effect of its header:
    /// IS_KNOWN | CRC << 8 | stuff bits << 3 | state.
    uint32_t header[BASE_HEADERS];
    uint8_t fd_control[8U << FD_CONTROL_BITS]; ///< For each state and bits after the bit rate switch.
    /// For each identifier << 1 | bit rate switch of an FD frame in base format, the effect of its bits up to
    /// that switch: FD_IS_KNOWN | stuff bits << 3 | state.
    uint8_t fd_arbitration[FD_BASE_HEADERS];
    bool are_filled; ///< All but `header` and `fd_arbitration`, which are filled as frames occur.
} steps_t;

static void fill(steps_t* const steps)
{
    for (uint32_t i = 0U; i < sizeof steps->stuffing; i++) {
        const uint32_t high = nibble_step[i >> 8][(i >> 4) & 15U];
        const uint32_t low  = nibble_step[high & STATE_MASK][i & 15U];
        steps->stuffing[i]  = (uint8_t)((low & STATE_MASK) | (((high >> 3) + (low >> 3)) << 3));
    }
    for (uint32_t i = 0U; i < sizeof steps->crc15_rest; i++) {
        stuffing_t now = {.state = i >> CRC15_REST};
        for (uint32_t bit = CRC15_REST; bit > 4U; bit--) {
            take(&now, bit_step[now.state][(i >> (bit - 1U)) & 1U]);
        }
        take(&now, nibble_step[now.state][i & 15U]);
        steps->crc15_rest[i] = (uint8_t)(now.state | (now.stuffed << 3));
    }
    for (uint32_t i = 0U; i < sizeof steps->fd_control; i++) {
        stuffing_t now = {.state = i >> FD_CONTROL_BITS};
        take(&now, bit_step[now.state][(i >> 4) & 1U]);
        take(&now, nibble_step[now.state][i & 15U]);
        steps->fd_control[i] = (uint8_t)(now.state | (now.stuffed << 3));
    }
    for (uint32_t i = 0U; i < 256U; i++) {
        const uint32_t high = crc15_step[i >> 4];
        steps->crc15[i]     = (uint16_t)(((high << 4) & 0x7FFFU) ^ crc15_step[((high >> 11) ^ i) & 15U]);
    }
    steps->are_filled = true;
}

/// Returns the tables. The first call fills them.
static steps_t* all_steps(void)
{
    static steps_t steps;
    if (!steps.are_filled) {
        fill(&steps);
    }
    return &steps;
}

/// Send the low `count` bits of `bits`, most significant first.
static void stuff_bits(stuffing_t* const stuffing, const uint64_t bits, uint32_t count)
{
    const uint8_t* steps = all_steps()->stuffing;
    stuffing_t now       = *stuffing;
    for (; (count % 4U) != 0U; count--) {
        take(&now, bit_step[now.state][(bits >> (count - 1U)) & 1U]);
    }
    if ((count % 8U) != 0U) {
        count -= 4U;
        take(&now, nibble_step[now.state][(bits >> count) & 15U]);
    }
    while (count != 0U) {
        count -= 8U;
        take(&now, steps[(now.state << 8) | ((bits >> count) & 255U)]);
    }
    *stuffing = now;
}

static void stuff_octets(stuffing_t* const stuffing, const uint8_t* const octets, const size_t size)
{
    const uint8_t* steps = all_steps()->stuffing;
    stuffing_t now       = *stuffing;
    for (size_t i = 0U; i < size; i++) {
        take(&now, steps[(now.state << 8) | octets[i]]);
    }
    *stuffing = now;
}

static uint32_t crc15_octet(const steps_t* const steps, const uint32_t crc, const uint32_t octet)
{
    return ((crc << 8) & 0x7FFFU) ^ steps->crc15[((crc >> 7) ^ octet) & 255U];
}

static uint32_t crc15_bits(uint32_t crc, const uint64_t bits, uint32_t count)
{
    const steps_t* steps = all_steps();
    for (; (count % 8U) != 0U; count--) {
        const uint32_t feedback = ((crc >> 14) ^ (uint32_t)(bits >> (count - 1U))) & 1U;
        crc                     = ((crc << 1) & 0x7FFFU) ^ ((feedback != 0U) ? 0x4599U : 0U);
    }
    for (; count != 0U; count -= 8U) {
        crc = crc15_octet(steps, crc, (uint32_t)(bits >> (count - 8U)));
    }
    return crc;
}

typedef struct {
    uint64_t bits; // After start of frame, to the end of the data length code.
    uint32_t count;
} header_t;

/// Header of a classic frame without the start of frame, with which the stuffing starts.
static header_t classic_header(const osal_can_frame_t* const frame)
{
    const uint64_t remote = ((frame->id & OSAL_CAN_REMOTE) != 0U) ? 1U : 0U;
    if ((frame->id & OSAL_CAN_EXTENDED) == 0U) {
        const uint64_t id = frame->id & 0x7FFU;
        return (header_t){.bits = (id << 7) | (remote << 6) | frame->length, .count = BASE_HEADER_BITS};
    }
    const uint64_t id = frame->id & OSAL_CAN_ID_MASK;
    return (header_t){.bits = ((id >> 18) << 27) | (3ULL << 25) | ((id & 0x3FFFFU) << 7) | (remote << 6) |
                              frame->length,
                      .count = EXTENDED_HEADER_BITS};
}

uint8_t frame_fd_length(const uint8_t length)
{
    static const uint8_t steps[] = {12, 16, 20, 24, 32, 48, 64};
    if (length <= 8U) {
        return length;
    }
    size_t i = 0U;
    while ((i < (sizeof steps - 1U)) && (steps[i] < length)) {
        i++;
    }
    return steps[i];
}

static uint8_t fd_length_code(const uint8_t length)
{
    uint8_t code                 = (length <= 8U) ? length : 9U;
    static const uint8_t steps[] = {12, 16, 20, 24, 32, 48, 64};
    for (size_t i = 0U; (length > 8U) && (i < (sizeof steps - 1U)) && (steps[i] < length); i++) {
        code++;
    }
    return code;
}

static uint32_t data_octets(const osal_can_frame_t* const frame)
{
    return ((frame->id & OSAL_CAN_REMOTE) == 0U) ? frame->length : 0U;
}

uint16_t frame_crc15(const osal_can_frame_t* const frame)
{
    const header_t header = classic_header(frame);
    const steps_t* steps  = all_steps();
    uint32_t crc          = crc15_bits(0U, header.bits, header.count);
    for (size_t i = 0U; i < data_octets(frame); i++) {
        crc = crc15_octet(steps, crc, frame->data[i]);
    }
    return (uint16_t)crc;
}

/// Returns the effect of the bits after a start of frame on the stuffing: stuff bits << 3 | state.
static uint32_t stuffing_effect(const header_t* const header)
{
    stuffing_t stuffing = {.state = AFTER_START_OF_FRAME};
    stuff_bits(&stuffing, header->bits, header->count);
    return (stuffing.stuffed << 3) | stuffing.state;
}

/// Returns the effect of a header, in the format of steps_t.header.
static uint32_t effect_of(const header_t* const header)
{
    return IS_KNOWN | (crc15_bits(0U, header->bits, header->count) << 8) | stuffing_effect(header);
}

static uint32_t header_effect(steps_t* const steps, const osal_can_frame_t* const frame)
{
    const header_t header = classic_header(frame);
    if ((frame->id & (OSAL_CAN_EXTENDED | OSAL_CAN_REMOTE)) != 0U) {
        return effect_of(&header);
    }
    uint32_t* const known = &steps->header[((frame->id & 0x7FFU) << 4) | (frame->length & 15U)];
    if (*known == 0U) {
        *known = effect_of(&header);
    }
    return *known;
}

static frame_length_t classic_length(const osal_can_frame_t* const frame)
{
    steps_t* steps        = all_steps();
    const uint32_t octets = data_octets(frame);
    const uint32_t effect = header_effect(steps, frame);
    const uint32_t header = ((frame->id & OSAL_CAN_EXTENDED) == 0U) ? BASE_HEADER_BITS : EXTENDED_HEADER_BITS;
    const uint32_t unstuffed = 1U + header + (8U * octets) + CRC15_BITS;
    uint32_t crc             = (effect & ~IS_KNOWN) >> 8;
    stuffing_t stuffing      = {.state = effect & STATE_MASK, .stuffed = (effect >> 3) & 31U};
    for (size_t i = 0U; i < octets; i++) {
        crc = crc15_octet(steps, crc, frame->data[i]);
        take(&stuffing, steps->stuffing[(stuffing.state << 8) | frame->data[i]]);
    }
    take(&stuffing, steps->stuffing[(stuffing.state << 8) | (crc >> CRC15_REST)]);
    take(&stuffing, steps->crc15_rest[(stuffing.state << CRC15_REST) | (crc & ((1U << CRC15_REST) - 1U))]);
    // CRC delimiter and ACK slot, then the tail.
    return (frame_length_t){.nominal_bits = unstuffed + stuffing.stuffed + 2U + CAN_TAIL_BITS};
}

/// Returns the bits after the start of frame, up to the bit rate switch, which is included.
static header_t fd_arbitration(const osal_can_frame_t* const frame)
{
    const uint64_t switches = ((frame->flags & OSAL_CAN_FLAG_BRS) != 0U) ? 1U : 0U;
    const uint64_t id       = frame->id & OSAL_CAN_ID_MASK;
    if ((frame->id & OSAL_CAN_EXTENDED) == 0U) { // id, RRS 0, IDE 0, FDF 1, res 0, BRS
        return (header_t){.bits = ((id & 0x7FFU) << 5) | 4U | switches, .count = 16U};
    }
    // id 28..18, SRR 1, IDE 1, id 17..0, RRS 0, FDF 1, res 0, BRS
    return (header_t){.bits  = ((id >> 18) << 24) | (3ULL << 22) | ((id & 0x3FFFFU) << 4) | 4U | switches,
                      .count = 35U};
}

/// Returns the effect of the bits up to the bit rate switch: stuff bits << 3 | state.
static uint32_t fd_arbitration_effect(steps_t* const steps, const osal_can_frame_t* const frame,
                                      const header_t* const header)
{
    if ((frame->id & OSAL_CAN_EXTENDED) != 0U) {
        return stuffing_effect(header);
    }
    uint8_t* const known = &steps->fd_arbitration[((frame->id & 0x7FFU) << 1) | (header->bits & 1U)];
    if (*known == 0U) {
        *known = (uint8_t)(FD_IS_KNOWN | stuffing_effect(header));
    }
    return *known & ~FD_IS_KNOWN;
}

static frame_length_t fd_length(const osal_can_frame_t* const frame)
{
    steps_t* steps             = all_steps();
    const header_t header      = fd_arbitration(frame);
    const uint32_t passive     = ((frame->flags & OSAL_CAN_FLAG_ESI) != 0U) ? 16U : 0U;
    const uint32_t control     = passive | fd_length_code(frame->length);
    const uint32_t octets      = frame->length;
    const uint32_t effect      = fd_arbitration_effect(steps, frame, &header);
    const uint32_t arbitration = 1U + header.count + (effect >> 3);
    stuffing_t stuffing        = {.state = effect & STATE_MASK};
    take(&stuffing, steps->fd_control[(stuffing.state << FD_CONTROL_BITS) | control]);
    stuff_octets(&stuffing, frame->data, octets);

    // A dynamic stuff bit after the last bit is the first fixed stuff bit of the CRC field: do not count it
    // twice.
    const uint32_t last_level =
        (octets != 0U) ? (frame->data[octets - 1U] & 1U) : (uint32_t)(fd_length_code(frame->length) & 1U);
    const bool is_pending = (stuffing.state >> 2) != last_level;
    // Stuff count 4 + CRC 17 + 6 fixed, or 4 + 21 + 7 above 16 octets; CRC delimiter.
    const uint32_t crc  = ((octets > 16U) ? 32U : 27U) + 1U;
    const uint32_t data = 5U + (8U * octets) + stuffing.stuffed - (is_pending ? 1U : 0U) + crc;
    if ((frame->flags & OSAL_CAN_FLAG_BRS) == 0U) {
        return (frame_length_t){.nominal_bits = arbitration + data + 1U + CAN_TAIL_BITS};
    }
    return (frame_length_t){.nominal_bits = arbitration + 1U + CAN_TAIL_BITS, .data_bits = data};
}

frame_length_t frame_length(const osal_can_frame_t* const frame)
{
    if ((frame->id & OSAL_CAN_ERROR) != 0U) {
        return (frame_length_t){0};
    }
    return ((frame->flags & OSAL_CAN_FLAG_FD) != 0U) ? fd_length(frame) : classic_length(frame);
}
