// SPDX-License-Identifier: Apache-2.0
// Frames that the receiver accepts and refuses. frames_of_another_implementation_are_accepted has frames made
// with pyca/cryptography (OpenSSL); test/unit/gse/hirosco_gse/test_ground_sdls.py has the same octets.
#include "base/octets.h"
#include "test/support/assertion.h"
#include "test/support/recorded_media.h"
#include "test/support/sealer.h"
#include "unity.h"

#include <string.h>

#define CONTENT_MAX (SDLS_FRAME_MAX - SDLS_CLEAR_OCTETS - SDLS_MAC_OCTETS)

static const image_t empty[2];
static sdls_receiver_t receiver;
static sdls_session_t session;
static sdls_frame_t checked;
static sealed_t frame;

void setUp(void)
{
    recorded_clear(empty);
    const medium_t medium = recorded_medium(0U);
    sealer_make_mark(&medium, sealer_key, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_open(&receiver, sealer_key, &medium));
    sdls_begin(&session);
    frame = (sealed_t){.session = 1U, .spi = SDLS_SPI, .part = SEALER_WHOLE};
}

void tearDown(void)
{
}

static status_t look(void)
{
    return sdls_look(&receiver, &session, frame.octets, frame.size, &checked);
}

static status_t take(void)
{
    const status_t status = look();
    if (status == STATUS_OK) {
        sdls_accept(&receiver, &session);
    }
    return status;
}

static status_t take_text(const char* const text)
{
    seal(&frame, sealer_key, (const uint8_t*)text, strlen(text));
    return take();
}

/// Expect that frames were refused for this reason only.
static void expect_refused(const sdls_refusal_t reason, const uint32_t times)
{
    for (unsigned i = 0U; i < SDLS_REFUSALS; i++) {
        TEST_ASSERT_EQUAL_UINT32((i == (unsigned)reason) ? times : 0U, receiver.refused[i]);
    }
}

static void accept(void)
{
    sdls_accept(&receiver, &session);
}

/// Only a valid frame that was checked last can be accepted, and only once.
static void accepting_a_frame_that_was_not_checked_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(accept));
    TEST_ASSERT_EQUAL(STATUS_OK, take_text("a"));
    TEST_ASSERT_TRUE(assertion_fails(accept));
    frame.count = 1U;
    seal(&frame, sealer_key, (const uint8_t*)"b", 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, look());
    frame.octets[frame.size - 1U] ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_CHECKSUM, look());
    TEST_ASSERT_TRUE(assertion_fails(accept));
    frame.octets[frame.size - 1U] ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, look());
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, sdls_look(&receiver, &session, frame.octets, 0U, &checked));
    TEST_ASSERT_TRUE(assertion_fails(accept));
    TEST_ASSERT_EQUAL_UINT32(1U, receiver.accepted);
    TEST_ASSERT_EQUAL(STATUS_OK, take());
    TEST_ASSERT_EQUAL_UINT32(2U, receiver.accepted);
}

static size_t hex(const char* const text, uint8_t* const octets)
{
    const size_t size = strlen(text) / 2U;
    for (size_t i = 0U; i < (2U * size); i++) {
        const char digit     = text[i];
        const uint8_t nibble = (uint8_t)((digit <= '9') ? (digit - '0') : (digit - 'a' + 10));
        octets[i / 2U]       = (uint8_t)((uint8_t)(octets[i / 2U] << 4U) | nibble);
    }
    return size;
}

static void take_known_frame(const char* const text)
{
    frame.size = hex(text, frame.octets);
    TEST_ASSERT_EQUAL(STATUS_OK, take());
    TEST_ASSERT_EQUAL(frame.size, checked.taken);
}

static void frames_of_another_implementation_are_accepted(void)
{
    uint8_t check[SESSION_MARK_CHECK];
    uint8_t expected[SDLS_FRAME_MAX];
    TEST_ASSERT_EQUAL(SESSION_MARK_CHECK, hex("f05d76ae4ab99fe5", expected));
    sealer_key_check(sealer_key, check);
    TEST_ASSERT_EQUAL_MEMORY(expected, check, sizeof check);

    take_known_frame(
        "2001003100c00001000000000000000100000000290aa47d319bc59af5529e9a7be54538e048770377ec5a9c6d922351ac"
        "ba");
    TEST_ASSERT_EQUAL(14U, checked.size);
    (void)hex("1801c0000006190811010001c5d2", expected);
    TEST_ASSERT_EQUAL_MEMORY(expected, checked.packet, 14U);

    sdls_begin(&session);
    take_known_frame("20010026004000010000000000000007000000008317ae457af0ad7502a7c483e925565fb06fb9");
    TEST_ASSERT_NULL(checked.packet);
    take_known_frame("200100270080000100000000000000070000000162dfb75b881091d14bcf67a8a11544b308c506bf");
    TEST_ASSERT_EQUAL(7U, checked.size);
    TEST_ASSERT_EQUAL_MEMORY("abcdefg", checked.packet, 7U);
    TEST_ASSERT_EQUAL_UINT32(3U, receiver.accepted);
    TEST_ASSERT_EQUAL_UINT32(7U, receiver.mark.session);
}

static void the_last_number_is_accepted_once(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, take_text("a"));
    receiver.mark.session = UINT32_MAX - 1U;
    sdls_begin(&session);
    frame.session = UINT32_MAX;
    TEST_ASSERT_EQUAL(STATUS_OK, take_text("b"));
    session.next = UINT32_MAX;
    (void)hex("2001002400c0000100000000ffffffffffffffff577a24c457db7bd8742aa304c98340643d", frame.octets);
    TEST_ASSERT_EQUAL(STATUS_OK, take());
    TEST_ASSERT_EQUAL_HEX8(0x55U, checked.packet[0]);
    TEST_ASSERT_EQUAL(STATUS_STALE, take());
    frame.count = 0U; // Numbers do not wrap.
    TEST_ASSERT_EQUAL(STATUS_STALE, take_text("c"));
    sdls_begin(&session);
    TEST_ASSERT_EQUAL(STATUS_STALE, take_text("c"));
    frame.session = 0U;
    TEST_ASSERT_EQUAL(STATUS_STALE, take_text("c"));
    expect_refused(SDLS_REFUSED_REPLAYED, 4U);
}

static void counts_are_taken_one_by_one(void)
{
    frame.count = 1U; // A session must begin with the first count.
    TEST_ASSERT_EQUAL(STATUS_STALE, take_text("a"));
    TEST_ASSERT_EQUAL_UINT32(0U, receiver.mark.session);
    static const struct {
        uint32_t count;
        status_t status;
    } steps[] = {{0U, STATUS_OK}, {0U, STATUS_STALE},         {2U, STATUS_STALE},
                 {1U, STATUS_OK}, {1U, STATUS_STALE},         {0U, STATUS_STALE},
                 {2U, STATUS_OK}, {UINT32_MAX, STATUS_STALE}, {3U, STATUS_OK}};
    for (size_t i = 0U; i < (sizeof steps / sizeof steps[0]); i++) {
        frame.count = steps[i].count;
        TEST_ASSERT_EQUAL(steps[i].status, take_text("a"));
    }
    frame.session = 2U; // A connection cannot change its session.
    frame.count   = 4U;
    TEST_ASSERT_EQUAL(STATUS_STALE, take_text("a"));
    frame.count = 0U;
    TEST_ASSERT_EQUAL(STATUS_STALE, take_text("a"));
    expect_refused(SDLS_REFUSED_REPLAYED, 8U);
}

static void two_connections_keep_their_sessions(void)
{
    static sdls_session_t other;
    sdls_begin(&other);
    TEST_ASSERT_EQUAL(STATUS_OK, take_text("a"));
    frame = (sealed_t){.session = 2U, .spi = SDLS_SPI, .part = SEALER_WHOLE};
    seal(&frame, sealer_key, (const uint8_t*)"b", 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, sdls_look(&receiver, &other, frame.octets, frame.size, &checked));
    sdls_accept(&receiver, &other);
    frame.session = 1U; // The older session continues on its own connection.
    frame.count   = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, take_text("c"));
    frame.count = 2U; // It cannot continue on another connection.
    seal(&frame, sealer_key, (const uint8_t*)"d", 1U);
    TEST_ASSERT_EQUAL(STATUS_STALE, sdls_look(&receiver, &other, frame.octets, frame.size, &checked));
    sdls_begin(&other);
    TEST_ASSERT_EQUAL(STATUS_STALE, sdls_look(&receiver, &other, frame.octets, frame.size, &checked));
    frame.count = 0U;
    seal(&frame, sealer_key, (const uint8_t*)"a", 1U);
    TEST_ASSERT_EQUAL(STATUS_STALE, sdls_look(&receiver, &other, frame.octets, frame.size, &checked));
}

static void opening_a_frame_again_before_acceptance_gives_the_same_packet(void)
{
    seal(&frame, sealer_key, (const uint8_t*)"again", 5U);
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, look());
        TEST_ASSERT_EQUAL_MEMORY("again", checked.packet, 5U);
    }
    sdls_accept(&receiver, &session);
    TEST_ASSERT_EQUAL_UINT32(1U, receiver.accepted);
    TEST_ASSERT_EQUAL(STATUS_STALE, look());
}

static void a_change_of_any_octet_or_bit_is_detected(void)
{
    seal(&frame, sealer_key, (const uint8_t*)"ping", 4U);
    for (size_t bit = 0U; bit < (8U * frame.size); bit++) {
        frame.octets[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_NOT_EQUAL(STATUS_OK, look());
        frame.octets[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    for (size_t size = 0U; size < frame.size; size++) {
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, sdls_look(&receiver, &session, frame.octets, size, &checked));
        TEST_ASSERT_EQUAL(0U, checked.taken);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, receiver.accepted);
    TEST_ASSERT_EQUAL_UINT32(0U, receiver.mark.session);
    TEST_ASSERT_EQUAL(STATUS_OK, take());
}

/// Change a field of the primary header of a sealed frame: the header is checked before the MAC.
static void expect_header_refused(const size_t offset, const uint8_t octet)
{
    seal(&frame, sealer_key, (const uint8_t*)"ping", 4U);
    frame.octets[offset] = octet;
    TEST_ASSERT_EQUAL(STATUS_INVALID, look());
    TEST_ASSERT_EQUAL(0U, checked.taken);
}

static void headers_of_other_frames_are_refused(void)
{
    expect_header_refused(0U, 0x00U); // Sequence-controlled.
    expect_header_refused(0U, 0x60U); // Version 1.
    expect_header_refused(0U, 0x30U); // Control command.
    expect_header_refused(1U, 0x02U); // Another spacecraft.
    expect_header_refused(2U, 0x04U); // Another channel.
    expect_header_refused(4U, 0x01U); // A frame with a sequence number.
    expect_header_refused(3U, SDLS_FRAME_MIN - 2U);
    expect_refused(SDLS_REFUSED_FRAME, 7U);
    frame.octets[2] = 0x03U; // The greatest length: the end of the frame has not arrived.
    frame.octets[3] = 0xFFU;
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, look());
}

static void other_keys_and_associations_are_refused(void)
{
    uint8_t other[SDLS_KEY_OCTETS];
    memcpy(other, sealer_key, sizeof other);
    other[31] ^= 1U;
    seal(&frame, other, (const uint8_t*)"ping", 4U);
    TEST_ASSERT_EQUAL(STATUS_CHECKSUM, take());
    TEST_ASSERT_EQUAL(frame.size, checked.taken);
    expect_refused(SDLS_REFUSED_FORGED, 1U);
    receiver.refused[SDLS_REFUSED_FORGED] = 0U;
    frame.spi                             = SDLS_SPI + 1U;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, take_text("ping"));
    TEST_ASSERT_EQUAL(frame.size, checked.taken);
    expect_refused(SDLS_REFUSED_ASSOCIATION, 1U);
}

static void a_number_of_more_than_64_bits_is_refused(void)
{
    static const uint8_t one = 1U;
    struct gcm_aes256_ctx cipher;
    seal(&frame, sealer_key, &one, 1U);
    frame.octets[11] = 1U; // A number of more than 64 bits, with a correct MAC.
    gcm_aes256_set_key(&cipher, sealer_key);
    gcm_aes256_set_iv(&cipher, GCM_IV_SIZE, &frame.octets[8]);
    gcm_aes256_update(&cipher, SDLS_CLEAR_OCTETS, frame.octets);
    gcm_aes256_encrypt(&cipher, 1U, &frame.octets[SDLS_CLEAR_OCTETS], &one);
    gcm_aes256_digest(&cipher, SDLS_MAC_OCTETS, &frame.octets[SDLS_CLEAR_OCTETS + 1U]);
    TEST_ASSERT_EQUAL(STATUS_STALE, look());
    expect_refused(SDLS_REFUSED_REPLAYED, 1U);
}

static void take_segment(const uint8_t flags, const size_t size, const status_t expected)
{
    static uint8_t content[CONTENT_MAX];
    memset(content, (int)frame.count, sizeof content);
    frame.part = flags;
    seal(&frame, sealer_key, content, size);
    TEST_ASSERT_EQUAL(expected, take());
    frame.count += (expected == STATUS_OK) ? 1U : 0U;
}

static void segments_are_assembled_to_a_packet(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        take_segment(SEALER_FIRST, CONTENT_MAX, STATUS_OK);
        take_segment(SEALER_MIDDLE, CONTENT_MAX, STATUS_OK);
        take_segment(SEALER_MIDDLE, CONTENT_MAX, STATUS_OK);
        take_segment(SEALER_MIDDLE, CONTENT_MAX, STATUS_OK);
        TEST_ASSERT_NULL(checked.packet);
        take_segment(SEALER_LAST, SDLS_PACKET_MAX - (4U * CONTENT_MAX) + 1U, STATUS_OUT_OF_RANGE);
        take_segment(SEALER_LAST, SDLS_PACKET_MAX - (4U * CONTENT_MAX), STATUS_OK);
        TEST_ASSERT_EQUAL(SDLS_PACKET_MAX, checked.size);
        for (size_t at = 0U; at < checked.size; at++) {
            TEST_ASSERT_EQUAL_UINT8((5U * i) + (at / CONTENT_MAX), checked.packet[at]);
        }
    }
    expect_refused(SDLS_REFUSED_PARTS, 2U);
}

static void segments_in_the_wrong_order_are_refused(void)
{
    take_segment(SEALER_LAST, 1U, STATUS_OUT_OF_RANGE);
    take_segment(SEALER_MIDDLE, 1U, STATUS_OUT_OF_RANGE);
    take_segment(SEALER_WHOLE | 1U, 1U, STATUS_OUT_OF_RANGE); // Another MAP.
    take_segment(SEALER_FIRST, 1U, STATUS_OK);
    take_segment(SEALER_FIRST, 1U, STATUS_OUT_OF_RANGE);
    take_segment(SEALER_WHOLE, 1U, STATUS_OUT_OF_RANGE);
    take_segment(SEALER_LAST | 1U, 1U, STATUS_OUT_OF_RANGE);
    take_segment(SEALER_LAST, 1U, STATUS_OK);
    expect_refused(SDLS_REFUSED_PARTS, 6U);
    sdls_begin(&session); // An incomplete packet is discarded with its connection.
    frame.session++;
    frame.count = 0U;
    take_segment(SEALER_FIRST, 1U, STATUS_OK);
    sdls_begin(&session);
    frame.session++;
    frame.count = 0U;
    take_segment(SEALER_WHOLE, 2U, STATUS_OK);
    TEST_ASSERT_EQUAL(2U, checked.size);
}

static void a_session_whose_mark_cannot_be_stored_is_refused(void)
{
    recorded.calls      = 0U;
    recorded.fail_from  = 1U;
    recorded.fail_count = 1U;
    recorded.failure    = STATUS_FULL;
    TEST_ASSERT_EQUAL(STATUS_IO, take_text("a"));
    expect_refused(SDLS_REFUSED_NOT_KEPT, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, take_text("a")); // The disk has room again.
    recorded.fail_from = 0U;
}

static void without_a_mark_no_frame_is_accepted(void)
{
    recorded_clear(empty);
    const medium_t medium = recorded_medium(0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, sdls_open(&receiver, sealer_key, &medium));
    TEST_ASSERT_EQUAL(STATUS_IO, take_text("a"));
    TEST_ASSERT_EQUAL(frame.size, checked.taken);
    expect_refused(SDLS_REFUSED_NOT_KEPT, 1U);
}

static void a_wipe_clears_exactly_the_given_octets(void)
{
    uint8_t secret[3] = {1U, 2U, 3U};
    sdls_wipe(secret, 2U);
    TEST_ASSERT_EQUAL_UINT8(0U, secret[0]);
    TEST_ASSERT_EQUAL_UINT8(0U, secret[1]);
    TEST_ASSERT_EQUAL_UINT8(3U, secret[2]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(frames_of_another_implementation_are_accepted);
    RUN_TEST(accepting_a_frame_that_was_not_checked_is_a_coding_error);
    RUN_TEST(the_last_number_is_accepted_once);
    RUN_TEST(counts_are_taken_one_by_one);
    RUN_TEST(two_connections_keep_their_sessions);
    RUN_TEST(opening_a_frame_again_before_acceptance_gives_the_same_packet);
    RUN_TEST(a_change_of_any_octet_or_bit_is_detected);
    RUN_TEST(headers_of_other_frames_are_refused);
    RUN_TEST(other_keys_and_associations_are_refused);
    RUN_TEST(a_number_of_more_than_64_bits_is_refused);
    RUN_TEST(segments_are_assembled_to_a_packet);
    RUN_TEST(segments_in_the_wrong_order_are_refused);
    RUN_TEST(a_session_whose_mark_cannot_be_stored_is_refused);
    RUN_TEST(without_a_mark_no_frame_is_accepted);
    RUN_TEST(a_wipe_clears_exactly_the_given_octets);
    return UNITY_END();
}
