// SPDX-License-Identifier: Apache-2.0
// Proves: a frame is accepted only if its MAC is right, its number is the next one of its connection,
//     and its part continues the packet; nothing of a frame with a wrong MAC is used, and what was
//     decrypted of it is overwritten with zeros. An accepted number is never accepted again, neither on
//     its own connection nor on another one: the counts of a connection rise by one without wrapping, and
//     a new connection gets a session number above all earlier ones. Only an incomplete frame waits for
//     octets, and only a frame of another link hides the start of the next one. Parts never exceed a
//     packet. A refused frame changes nothing but its counter. No access is outside the frame or the
//     packet.
// Bounds: any receiver and two connections in every sound state, and any number that was accepted
//     earlier; one frame of 0..42 octets on one of the connections, or its new beginning, which is an
//     induction over any number of frames; frames of up to 40 octets instead of 1024, packets of up to 8
//     instead of 4096; counters at 0.
// Replaced: the cipher decrypts to any octets, and the comparison of the MAC has any result; the
//     session mark may fail to be written (replaced_cipher.h). The strength of the cipher is not proved.
// Sources: fsw/framework/sdls/sdls.c base/octets.c
// Options: --unwind 7
// Reduced: fsw/framework/sdls/sdls.h
//   - #define SDLS_FRAME_MAX 1024U
//   + #define SDLS_FRAME_MAX 40U
// Reduced: fsw/framework/sdls/sdls.h
//   - #define SDLS_PACKET_MAX 4096U
//   + #define SDLS_PACKET_MAX 8U
// Fault: fsw/framework/sdls/sdls.c
//   - const bool is_right = (memeql_sec(mac, &octets[SDLS_CLEAR_OCTETS + content], sizeof mac) != 0);
//   + const bool is_right = (memeql_sec(mac, &octets[SDLS_CLEAR_OCTETS + content], sizeof mac) >= 0);
// Fault: fsw/framework/sdls/sdls.c
//   - sdls_wipe(&session->packet[session->held], content);
//   + sdls_wipe(&session->packet[session->held], content - 1U);
// Fault: fsw/framework/sdls/sdls.c
//   - ? ((number == session->session) && (count == session->next) && !session->is_spent)
//   + ? ((number == session->session) && (count == session->next))
// Fault: fsw/framework/sdls/sdls.c
//   - : ((number > self->mark.session) && (count == 0U));
//   + : ((number >= self->mark.session) && (count == 0U));
// Fault: fsw/framework/sdls/sdls.c
//   - if (size < length) {
//   + if (size < (length - 1U)) {
// Fault: fsw/framework/sdls/sdls.c
//   - if (content > (sizeof session->packet - session->held)) {
//   + if (content > sizeof session->packet) {
#include "base/octets.h"
#include "fsw/framework/sdls/sdls.h"
#include "test/proof/fsw/framework/sdls/replaced_cipher.h"

#define RECEIVED (SDLS_FRAME_MAX + 2U)

static sdls_receiver_t receiver;
static sdls_session_t first;
static sdls_session_t second;
static uint32_t earlier_number; // Session and count of any frame that was accepted earlier.
static uint32_t earlier_count;
// State before the frame, which is on the first connection.
static sdls_session_t before;
static uint32_t mark_before;

static uint32_t sum_of_refused(void)
{
    uint32_t sum = 0U;
    for (unsigned reason = 0U; reason < (unsigned)SDLS_REFUSALS; reason++) {
        sum += receiver.refused[reason];
    }
    return sum;
}

/// True if the connection accepts no frame with this session and count any more.
static bool excludes(const sdls_session_t* const one, const uint32_t number, const uint32_t count)
{
    return !one->is_bound || (one->session != number) || (count < one->next) || one->is_spent;
}

/// True if no connection, and none that begins later, accepts a frame with this session and count.
static bool is_past(const uint32_t number, const uint32_t count)
{
    return (number <= receiver.mark.session) && excludes(&first, number, count) &&
           excludes(&second, number, count);
}

static bool is_session_sound(const sdls_session_t* const one)
{
    return (one->held <= SDLS_PACKET_MAX) && (!one->is_bound || (one->session <= receiver.mark.session));
}

static bool is_sound(void)
{
    return is_session_sound(&first) && is_one_sound(&second) &&
           !(first.is_bound && second.is_bound && (first.session == second.session)) &&
           is_past(earlier_number, earlier_count);
}

static void any_sound_state(void)
{
    __CPROVER_havoc_object(&first);
    second.is_bound       = nondet_bool();
    second.session        = nondet_u32();
    second.next           = nondet_u32();
    second.is_spent       = nondet_bool();
    earlier_number        = nondet_u32();
    earlier_count         = nondet_u32();
    receiver.is_open      = nondet_bool();
    receiver.mark.session = nondet_u32();
    ASSUME(is_sound());
    before      = first;
    mark_before = receiver.mark.session;
}

static void prove_lengths(const status_t status, const uint8_t* const octets, const size_t size,
                          const sdls_frame_t* const frame)
{
    const bool has_header = (size >= 5U);
    const size_t length   = has_header ? ((size_t)octets_u16_at(&octets[2]) + 1U) : 0U;
    const bool is_ours    = has_header && (octets_u16_at(octets) == 0x2001U) && (octets[4] == 0U) &&
                         (length >= 37U) && (length <= SDLS_FRAME_MAX);
    PROVE((status == STATUS_TRUNCATED) == (!has_header || (is_ours && (size < length))),
          "only an incomplete frame waits for octets");
    PROVE((status == STATUS_INVALID) == (has_header && !is_ours), "only a frame of another link is invalid");
    PROVE(frame->taken == ((is_ours && (size >= length)) ? length : 0U),
          "the stream advances by a complete frame");
}

static void prove_refused(const status_t status)
{
    const sdls_session_t* const after = &first;
    const size_t index                = any_size(SDLS_PACKET_MAX - 1U);
    PROVE((after->is_bound == before.is_bound) && (after->next == before.next) &&
              (after->is_spent == before.is_spent) && (after->held == before.held) &&
              (after->candidate == 0U),
          "a refused frame changes nothing of the connection");
    PROVE(!after->is_bound || (after->session == before.session), "the session number stays");
    PROVE(IMPLIES(index < before.held, after->packet[index] == before.packet[index]),
          "the parts that were received before stay");
    PROVE((receiver.accepted == 0U) && (receiver.mark.session == mark_before),
          "a refused frame does not count as accepted");
    PROVE(sum_of_refused() == ((status == STATUS_TRUNCATED) ? 0U : 1U), "a refused frame is counted once");
    PROVE((status == STATUS_CHECKSUM) == (cipher_is_checked && !cipher_is_authentic),
          "only a frame with a wrong MAC is forged, whatever else is wrong");
    PROVE(IMPLIES((status == STATUS_CHECKSUM) && (index >= before.held) &&
                      (index < (before.held + cipher_content)),
                  after->packet[index] == 0U),
          "nothing of a forged frame is left");
}

static void prove_next(const uint8_t* const octets)
{
    const uint32_t number = octets_u32_at(&octets[12]);
    const uint32_t count  = octets_u32_at(&octets[16]);
    PROVE(octets_u32_at(&octets[8]) == 0U, "the initialization vector has no other number");
    if (before.is_bound) {
        PROVE((number == before.session) && (count == before.next) && !before.is_spent,
              "the frame has the next number of its connection");
        PROVE(receiver.mark.session == mark_before, "the mark changes only when a session begins");
    } else {
        PROVE((number > mark_before) && (count == 0U), "a new session is above all earlier ones");
        PROVE((receiver.mark.session == number) && first.is_bound && (first.session == number),
              "a session that began cannot begin again");
    }
}

static void prove_parts(const uint8_t* const octets, const sdls_frame_t* const frame)
{
    const sdls_session_t* const after = &first;
    const uint8_t part                = octets[5];
    const size_t index                = any_size(SDLS_PACKET_MAX - 1U);
    const bool is_last                = (part == 0x80U) || (part == 0xC0U);
    PROVE((before.held == 0U) ? ((part == 0x40U) || (part == 0xC0U)) : ((part == 0x00U) || (part == 0x80U)),
          "the part continues the packet");
    PROVE(frame->packet == (is_last ? after->packet : NULL), "only the last part ends the packet");
    PROVE(
        IMPLIES(is_last, (frame->size == (before.held + cipher_content)) && (frame->size <= SDLS_PACKET_MAX)),
        "the packet has all its parts");
    PROVE(IMPLIES(index < before.held, after->packet[index] == before.packet[index]), "earlier parts stay");
    sdls_accept(&receiver, &first);
    PROVE(after->held == (is_last ? 0U : (before.held + cipher_content)),
          "the next part is put after this one");
    PROVE(receiver.accepted == 1U, "an accepted frame is counted");
}

void proof(void)
{
    any_sound_state();
    if (nondet_bool()) {
        sdls_begin(&first);
        PROVE(is_sound(), "a new connection is sound");
        return;
    }
    const size_t size = any_size(RECEIVED);
    uint8_t octets[size];
    sdls_frame_t frame;
    cipher_examine(octets);
    const status_t status = sdls_look(&receiver, &first, octets, size, &frame);
    prove_lengths(status, octets, size, &frame);
    if (status != STATUS_OK) {
        PROVE(frame.packet == NULL, "a refused frame has no packet");
        prove_refused(status);
    } else {
        const uint32_t number = octets_u32_at(&octets[12]);
        const uint32_t count  = octets_u32_at(&octets[16]);
        PROVE(cipher_is_authentic && receiver.is_open, "only an authentic frame is accepted");
        PROVE((number != earlier_number) || (count != earlier_count), "no frame is accepted twice");
        prove_next(octets);
        prove_parts(octets, &frame);
        PROVE(is_past(number, count), "the frame will not be accepted again");
    }
    PROVE(is_sound(), "the state stays sound");
}
