// SPDX-License-Identifier: Apache-2.0
// Deaths and restarts, forged and damaged frames, and equal behaviour of ring and UDP.
#include "fsw/framework/message/message.h"

#include "base/octets.h"
#include "test/unit/fsw/framework/message/party.h"
#include "unity.h"

#include <string.h>

static party_t party;
static party_t udp_party;
static uint8_t taken[MESSAGE_PAYLOAD_MAX];

void setUp(void)
{
}

void tearDown(void)
{
}

static uint32_t random_state = 11U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static message_endpoint_t* end(unsigned index)
{
    return &party.members[index].endpoint;
}

static void send_number(unsigned from, unsigned to, uint32_t number)
{
    TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, from, to, &number, sizeof number));
}

/// Returns the next number that arrives; UINT32_MAX if there is none.
static uint32_t next_number(unsigned index)
{
    unsigned from  = 0U;
    size_t size    = 0U;
    uint32_t found = UINT32_MAX;
    if (party_receive(&party, index, &from, taken, sizeof taken, &size) == STATUS_OK) {
        TEST_ASSERT_EQUAL(sizeof found, size);
        (void)memcpy(&found, taken, sizeof found);
    }
    return found;
}

static void exchange(unsigned a, unsigned b, uint32_t first, uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        send_number(a, b, first + i);
        TEST_ASSERT_EQUAL(first + i, next_number(b));
        send_number(b, a, first + i);
        TEST_ASSERT_EQUAL(first + i, next_number(a));
    }
}

// ---- Restarts ----

static void restart_the_receiver(void)
{
    exchange(0U, 1U, 0U, 5U);
    send_number(0U, 1U, 50U); // In transit when the receiver dies.
    send_number(0U, 1U, 51U);
    party_restart(&party, 1U, 2U);
    TEST_ASSERT_EQUAL_MESSAGE(UINT32_MAX, next_number(1U),
                              "accepted a block that was meant for its predecessor");
    send_number(1U, 0U, 100U);
    TEST_ASSERT_EQUAL(100U, next_number(0U));
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(end(0U), party_id(1U)));
    exchange(0U, 1U, 200U, 100U);
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.lost + end(1U)->counters.lost);
}

static void transfer_starts_again_after_a_restart_of_the_receiver(void)
{
    party_in_each_form(&party, restart_the_receiver);
}

static void restart_the_sender(void)
{
    exchange(0U, 1U, 0U, 5U);
    send_number(0U, 1U, 50U); // The last frames of the dead sender are still accepted.
    party_restart(&party, 0U, 2U);
    TEST_ASSERT_EQUAL(50U, next_number(1U));
    send_number(0U, 1U, 100U);
    TEST_ASSERT_EQUAL(100U, next_number(1U));
    exchange(0U, 1U, 200U, 100U);
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.lost + end(1U)->counters.lost);
}

static void transfer_starts_again_after_a_restart_of_the_sender(void)
{
    party_in_each_form(&party, restart_the_sender);
}

static uint8_t caught[64];
static size_t caught_size;

static status_t catch_frame(party_t* self, unsigned from, unsigned to, const uint8_t* frame, size_t size)
{
    (void)self;
    (void)from;
    (void)to;
    TEST_ASSERT_TRUE(size <= sizeof caught);
    (void)memcpy(caught, frame, size);
    caught_size = size;
    return STATUS_EMPTY;
}

static void hear_an_old_sender_late(void)
{
    exchange(0U, 1U, 0U, 2U);
    party.outcome = catch_frame;
    send_number(0U, 1U, 50U); // The first frame of the next life overtakes this frame.
    party.outcome = NULL;
    party_restart(&party, 0U, 2U);
    send_number(0U, 1U, 60U);
    TEST_ASSERT_EQUAL(60U, next_number(1U));
    party_inject(&party, 0U, 1U, caught, caught_size);
    send_number(0U, 1U, 61U);
    TEST_ASSERT_EQUAL(61U, next_number(1U));
    TEST_ASSERT_EQUAL(1U, end(1U)->counters.stale);
}

static void an_old_peer_is_never_confused_with_the_new_one(void)
{
    party_in_each_form(&party, hear_an_old_sender_late);
}

static void restart_both(void)
{
    exchange(0U, 1U, 0U, 20U);
    send_number(0U, 1U, 50U);
    send_number(1U, 0U, 51U);
    party_restart(&party, 0U, 2U);
    party_restart(&party, 1U, 3U);
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(0U));
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    send_number(0U, 1U, 60U); // Neither end has received from the other's new life: one block may be lost.
    send_number(1U, 0U, 61U);
    (void)next_number(0U);
    (void)next_number(1U);
    exchange(0U, 1U, 200U, 100U);
}

static void two_restarted_ends_agree_again(void)
{
    party_in_each_form(&party, restart_both);
}

/// The peer sends a frame and dies before it reads any of five blocks: its next life counts none as lost.
static void die_before_reading(void)
{
    for (uint32_t i = 0U; i < 5U; i++) {
        send_number(0U, 1U, i);
    }
    send_number(1U, 0U, 70U);
    TEST_ASSERT_EQUAL(70U, next_number(0U));
    party_restart(&party, 1U, 2U);
    send_number(1U, 0U, 71U);
    TEST_ASSERT_EQUAL(71U, next_number(0U));
    for (uint32_t i = 0U; i < 10U; i++) {
        send_number(0U, 1U, 100U + i);
    }
    for (uint32_t i = 0U; i < 10U; i++) {
        TEST_ASSERT_EQUAL(100U + i, next_number(1U));
    }
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

static void messages_to_a_previous_life_consume_no_credit(void)
{
    party_in_each_form(&party, die_before_reading);
}

static void restart_a_receiver_before_its_first_answer(void)
{
    send_number(0U, 1U, 1U); // The receiver was never heard before, so it can only be the first life.
    TEST_ASSERT_EQUAL(1U, next_number(1U));
    party_restart(&party, 1U, 2U);
    send_number(0U, 1U, 2U); // The life for which this frame was meant is unknown.
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(1U, end(1U)->counters.stale);
    send_number(1U, 0U, 3U);
    TEST_ASSERT_EQUAL(3U, next_number(0U));
    exchange(0U, 1U, 10U, 40U);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

static void a_restarted_component_is_heard_before_it_is_reported(void)
{
    party_in_each_form(&party, restart_a_receiver_before_its_first_answer);
}

/// Blocks of the largest size in a window.
#define LARGEST_BLOCKS (MESSAGE_WINDOW_OCTETS / MESSAGE_FRAME_MAX)

/// A full, unchecked window of the earlier life is in the inbox when that of the next life comes.
static void fill_twice(void)
{
    static uint8_t block[MESSAGE_PAYLOAD_MAX];
    for (uint8_t life = 1U; life <= 2U; life++) {
        party_restart(&party, 0U, life);
        for (uint8_t i = 0U; i < LARGEST_BLOCKS; i++) {
            block[0] = (uint8_t)((life * 100U) + i);
            TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 0U, 1U, block, sizeof block));
        }
        party_take_in(&party, 1U);
    }
    for (uint8_t i = 0U; i < LARGEST_BLOCKS; i++) {
        unsigned from = 0U;
        size_t size   = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 1U, &from, taken, sizeof taken, &size));
        TEST_ASSERT_EQUAL_UINT8(200U + i, taken[0]);
    }
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(LARGEST_BLOCKS, end(1U)->counters.stale);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.overruns + end(1U)->counters.lost);
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(0U)); // This receives the credit.
    exchange(0U, 1U, 200U, 2U * MESSAGE_WINDOW);
}

static void a_full_window_of_an_earlier_life_makes_room_for_the_next(void)
{
    party_in_each_form(&party, fill_twice);
}

static void restart_at_random(void)
{
    uint32_t epochs[2]  = {1U, 1U};
    uint32_t last[2]    = {0U, 0U}; // Highest number that each has received; numbers only increase.
    uint32_t number     = 1U;
    unsigned deliveries = 0U;
    for (unsigned step = 0U; step < 20000U; step++) {
        const unsigned who = draw(2U);
        if (draw(200U) == 0U) {
            epochs[who]++;
            party_restart(&party, who, epochs[who]);
            last[who] = 0U;
        } else if (draw(2U) == 0U) {
            if (party_send(&party, who, 1U - who, &number, sizeof number) == STATUS_OK) {
                number++;
            }
        } else {
            const uint32_t found = next_number(who);
            if (found != UINT32_MAX) {
                TEST_ASSERT_TRUE_MESSAGE(found > last[who], "expected each message once and in order");
                last[who] = found;
                deliveries++;
            }
        }
        TEST_ASSERT_TRUE(message_credit(end(who), party_id(1U - who)) <= MESSAGE_WINDOW);
    }
    TEST_ASSERT_TRUE(deliveries > 6000U);
}

static void random_restarts_neither_double_nor_reorder_messages(void)
{
    party_in_each_form(&party, restart_at_random);
}

// ---- Malformed frames ----

typedef struct {
    uint16_t magic;
    uint8_t version;
    uint8_t kind;
    uint16_t from;
    uint16_t to;
    uint32_t from_epoch;
    uint32_t to_epoch;
    uint32_t sequence;
    uint32_t taken;
} header_t;

static const header_t good = {0x484DU, 1U, 0U, 16U, 17U, 1U, 0U, 0U, 0U};

static size_t write_frame(const header_t* header, uint8_t octets[64], size_t payload)
{
    octet_writer_t writer = octet_writer(octets, 64U);
    octet_write_u16(&writer, header->magic);
    octet_write_u8(&writer, header->version);
    octet_write_u8(&writer, header->kind);
    octet_write_u16(&writer, header->from);
    octet_write_u16(&writer, header->to);
    octet_write_u32(&writer, header->from_epoch);
    octet_write_u32(&writer, header->to_epoch);
    octet_write_u32(&writer, header->sequence);
    octet_write_u32(&writer, header->taken);
    for (size_t i = 0U; i < payload; i++) {
        octet_write_u8(&writer, (uint8_t)i);
    }
    return writer.position;
}

static void inject(const header_t* header, size_t payload)
{
    uint8_t octets[64];
    const size_t size = write_frame(header, octets, payload);
    party_inject(&party, 0U, 1U, octets, size);
}

static void the_frame_has_the_layout_of_its_header_file(void)
{
    party_open(&party, PARTY_RING);
    uint8_t expected[64];
    const uint8_t payload[3] = {0U, 1U, 2U};
    party.outcome            = catch_frame;
    TEST_ASSERT_EQUAL(STATUS_OK, party_send(&party, 0U, 1U, payload, sizeof payload));
    TEST_ASSERT_EQUAL(write_frame(&good, expected, sizeof payload), caught_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, caught, caught_size);
    party_close(&party);
}

static void cut_at_every_length(void)
{
    uint8_t octets[64];
    const size_t whole = write_frame(&good, octets, 0U);
    TEST_ASSERT_EQUAL(MESSAGE_HEADER_OCTETS, whole);
    const size_t shortest = (party.form == PARTY_TIPC) ? 1U : 0U; // TIPC does not pass an empty message.
    for (size_t size = shortest; size < whole; size++) {
        party_inject(&party, 0U, 1U, octets, size);
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
        TEST_ASSERT_EQUAL((size - shortest) + 1U, end(1U)->counters.malformed);
    }
    party_inject(&party, 0U, 1U, octets, whole);
    unsigned from = 0U;
    size_t size   = 99U;
    TEST_ASSERT_EQUAL(STATUS_OK, party_receive(&party, 1U, &from, taken, sizeof taken, &size));
    TEST_ASSERT_EQUAL(0U, size);
}

static void a_frame_is_refused_at_every_shorter_length(void)
{
    party_in_each_form(&party, cut_at_every_length);
}

static void break_each_field(void)
{
    header_t bad[9];
    for (unsigned i = 0U; i < 9U; i++) {
        bad[i] = good;
    }
    bad[0].magic      = 0x484CU;
    bad[1].version    = 0U;
    bad[2].version    = 2U;
    bad[3].kind       = 4U;
    bad[4].kind       = 255U;
    bad[5].from       = 99U; // An unknown peer.
    bad[6].from       = 17U; // Itself.
    bad[7].to         = 18U;
    bad[8].from_epoch = 0U;
    for (unsigned i = 0U; i < 9U; i++) {
        inject(&bad[i], 4U);
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
        TEST_ASSERT_EQUAL(i + 1U, end(1U)->counters.malformed);
    }
    inject(&good, 4U);
    TEST_ASSERT_NOT_EQUAL(UINT32_MAX, next_number(1U));
}

static void a_frame_with_a_wrong_field_is_dropped_and_counted_as_malformed(void)
{
    party_in_each_form(&party, break_each_field);
}

static void jump_in_the_sequence(void)
{
    exchange(0U, 1U, 0U, 3U);
    header_t header               = good;
    header.to_epoch               = 1U;
    header.taken                  = 3U;
    static const uint32_t leaps[] = {2U, 3U + MESSAGE_WINDOW, 0x7FFFFFFFU, 0x80000002U, UINT32_MAX};
    for (unsigned i = 0U; i < (sizeof leaps / sizeof leaps[0]); i++) {
        header.sequence = leaps[i]; // Behind the window, or further ahead than any credit allows.
        inject(&header, 4U);
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
        TEST_ASSERT_EQUAL(i + 1U, end(1U)->counters.stale);
    }
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
    exchange(0U, 1U, 10U, 3U);
}

static void a_sequence_beyond_the_window_is_not_accepted(void)
{
    party_in_each_form(&party, jump_in_the_sequence);
}

static void acknowledge_more_than_was_sent(void)
{
    for (uint32_t i = 0U; i < 10U; i++) {
        send_number(1U, 0U, i);
    }
    header_t header                = good;
    header.kind                    = 1U;
    header.to_epoch                = 1U;
    static const uint32_t claims[] = {11U, 33U, 0x80000000U, UINT32_MAX};
    for (unsigned i = 0U; i < (sizeof claims / sizeof claims[0]); i++) {
        header.taken = claims[i]; // More than was ever sent.
        inject(&header, 0U);
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW - 10U, message_credit(end(1U), party_id(0U)));
    }
    header.taken = 10U;
    inject(&header, 0U);
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(end(1U), party_id(0U)));
    header.taken = 4U; // An older count does not reduce the credit.
    inject(&header, 0U);
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(end(1U), party_id(0U)));
}

static void credit_beyond_what_was_sent_is_not_accepted(void)
{
    party_in_each_form(&party, acknowledge_more_than_was_sent);
}

static void messages_of_unknown_peers_are_dropped(void)
{
    party_open(&party, PARTY_UDP);
    osal_socket_t stranger = OSAL_SOCKET_CLOSED;
    uint8_t octets[64];
    const size_t size = write_frame(&good, octets, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&stranger, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_send(&stranger, party.members[1].address, octets, size));
    party.members[1].announced++;
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(1U, party.members[1].udp.other_senders);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.malformed);
    osal_socket_close(&stranger);
    party_close(&party);
}

static void a_datagram_longer_than_any_frame_is_malformed(void)
{
    static uint8_t octets[MESSAGE_FRAME_MAX + 1U];
    party_open(&party, PARTY_UDP);
    (void)write_frame(&good, octets, 0U);
    party_inject(&party, 0U, 1U, octets, sizeof octets);
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(1U, end(1U)->counters.malformed);
    party_close(&party);
}

static void random_octets_cause_no_failure(void)
{
    party_open(&party, PARTY_RING);
    for (unsigned i = 0U; i < 200000U; i++) {
        uint8_t octets[64];
        size_t size = draw(sizeof octets);
        if (draw(4U) == 0U) {
            for (size_t k = 0U; k < size; k++) {
                octets[k] = (uint8_t)draw(256U);
            }
        } else { // A correct frame with a few octets changed.
            header_t header   = good;
            header.sequence   = draw(40U);
            header.taken      = draw(40U);
            header.to_epoch   = draw(3U);
            header.from_epoch = draw(3U);
            size              = write_frame(&header, octets, draw(20U));
            octets[draw((uint32_t)size)] ^= (uint8_t)(1U << draw(8U));
        }
        party_inject(&party, 0U, 1U, octets, size);
        unsigned from    = 0U;
        size_t found     = 0U;
        const status_t s = party_receive(&party, 1U, &from, taken, 16U, &found);
        TEST_ASSERT_TRUE((s == STATUS_OK) || (s == STATUS_EMPTY) || (s == STATUS_TOO_LARGE));
        TEST_ASSERT_TRUE(message_credit(end(1U), party_id(0U)) <= MESSAGE_WINDOW);
        while (party_receive(&party, 0U, &from, taken, sizeof taken, &found) != STATUS_EMPTY) {
        }
    }
    party_close(&party);
}

// ---- Ring and UDP ----

typedef struct {
    status_t status;
    unsigned from;
    size_t size;
    uint32_t digest;
} result_t;

static result_t act(party_t* self, uint32_t kind, unsigned who, unsigned other, uint32_t number, size_t size)
{
    static uint8_t octets[MESSAGE_PAYLOAD_MAX];
    result_t result = {.status = STATUS_OK};
    if (kind == 0U) {
        party_restart(self, who, number);
    } else if (kind < 60U) {
        (void)memset(octets, (int)(number & 0xFFU), size);
        result.status = party_send(self, who, other, octets, size);
    } else {
        result.status = party_receive(self, who, &result.from, octets, sizeof octets, &result.size);
        for (size_t i = 0U; i < result.size; i++) {
            result.digest = (result.digest * 31U) + octets[i];
        }
    }
    return result;
}

static void ring_and_udp_behave_equally(void)
{
    uint32_t epoch = 1U;
    party_open(&udp_party, PARTY_UDP);
    party_open(&party, PARTY_RING);
    for (uint32_t step = 0U; step < 30000U; step++) {
        uint32_t kind        = draw(100U);
        const unsigned who   = draw(PARTY_MEMBERS);
        const unsigned other = (who + 1U + draw(PARTY_MEMBERS - 1U)) % PARTY_MEMBERS;
        const size_t size    = draw(3U) == 0U ? draw(MESSAGE_PAYLOAD_MAX) : draw(40U);
        kind                 = ((kind == 0U) && (draw(20U) > 0U)) ? 99U : kind;
        // The member dies after it has read all blocks, because each form keeps unread blocks in another
        // place.
        if (kind == 0U) {
            while (act(&party, 99U, who, 0U, 0U, 0U).status != STATUS_EMPTY) {
            }
            while (act(&udp_party, 99U, who, 0U, 0U, 0U).status != STATUS_EMPTY) {
            }
            epoch++;
        }
        const uint32_t number   = (kind == 0U) ? epoch : step;
        const result_t in_ring  = act(&party, kind, who, other, number, size);
        const result_t over_udp = act(&udp_party, kind, who, other, number, size);
        TEST_ASSERT_EQUAL(in_ring.status, over_udp.status);
        TEST_ASSERT_EQUAL(in_ring.from, over_udp.from);
        TEST_ASSERT_EQUAL(in_ring.size, over_udp.size);
        TEST_ASSERT_EQUAL(in_ring.digest, over_udp.digest);
        TEST_ASSERT_EQUAL_MEMORY(party.frames, udp_party.frames, sizeof party.frames);
    }
    for (unsigned i = 0U; i < PARTY_MEMBERS; i++) {
        TEST_ASSERT_EQUAL_MEMORY(&party.members[i].endpoint.counters, &udp_party.members[i].endpoint.counters,
                                 sizeof party.members[i].endpoint.counters);
    }
    party_close(&party);
    party_close(&udp_party);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(transfer_starts_again_after_a_restart_of_the_receiver);
    RUN_TEST(transfer_starts_again_after_a_restart_of_the_sender);
    RUN_TEST(an_old_peer_is_never_confused_with_the_new_one);
    RUN_TEST(two_restarted_ends_agree_again);
    RUN_TEST(messages_to_a_previous_life_consume_no_credit);
    RUN_TEST(a_restarted_component_is_heard_before_it_is_reported);
    RUN_TEST(a_full_window_of_an_earlier_life_makes_room_for_the_next);
    RUN_TEST(random_restarts_neither_double_nor_reorder_messages);
    RUN_TEST(the_frame_has_the_layout_of_its_header_file);
    RUN_TEST(a_frame_is_refused_at_every_shorter_length);
    RUN_TEST(a_frame_with_a_wrong_field_is_dropped_and_counted_as_malformed);
    RUN_TEST(a_sequence_beyond_the_window_is_not_accepted);
    RUN_TEST(credit_beyond_what_was_sent_is_not_accepted);
    RUN_TEST(messages_of_unknown_peers_are_dropped);
    RUN_TEST(a_datagram_longer_than_any_frame_is_malformed);
    RUN_TEST(random_octets_cause_no_failure);
    RUN_TEST(ring_and_udp_behave_equally);
    return UNITY_END();
}
