// SPDX-License-Identifier: Apache-2.0
// Reports that wait for a slow reader: both kinds keep their order; a full queue drops the oldest
// housekeeping, and never another report.
#include "fsw/subsystems/communication/ground_queue.h"

#include "unity.h"

#include <string.h>

#define MODEL_MAX 16384U

static communication_ground_queue_t queue;
static uint32_t random_state;

void setUp(void)
{
    communication_ground_queue_init(&queue);
    random_state = 21U;
}

void tearDown(void)
{
}

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

/// A report of a kind with its number in its first and last octets.
static void build(uint8_t packet[PUS_PACKET_MAX], bool is_housekeeping, uint32_t number, size_t size)
{
    (void)memset(packet, (int)(number & 0xFFU), size);
    (void)memcpy(packet, &number, 4U);
    packet[7] = is_housekeeping ? 3U : 5U;
    packet[8] = is_housekeeping ? 25U : 1U;
}

static status_t put(bool is_housekeeping, uint32_t number, size_t size)
{
    static uint8_t packet[PUS_PACKET_MAX];
    build(packet, is_housekeeping, number, size);
    return communication_ground_queue_put(&queue, packet, size);
}

/// Take the next report in pieces of random size and check every octet of it.
static void expect(bool is_housekeeping, uint32_t number, size_t size)
{
    static uint8_t expected[PUS_PACKET_MAX];
    size_t position = 0U;
    build(expected, is_housekeeping, number, size);
    while (position < size) {
        size_t left               = 0U;
        const uint8_t* const next = communication_ground_queue_next(&queue, &left);
        TEST_ASSERT_NOT_NULL(next);
        TEST_ASSERT_EQUAL(size - position, left);
        TEST_ASSERT_EQUAL(0, memcmp(&expected[position], next, left));
        const size_t sent = 1U + draw((uint32_t)left);
        communication_ground_queue_sent(&queue, sent);
        position += sent;
    }
}

static void expect_empty(void)
{
    size_t size = 99U;
    TEST_ASSERT_NULL(communication_ground_queue_next(&queue, &size));
    TEST_ASSERT_EQUAL(0U, size);
    TEST_ASSERT_EQUAL(0U, communication_ground_queue_count(&queue));
}

static void order_is_kept_across_both_kinds(void)
{
    expect_empty();
    for (uint32_t i = 0U; i < 60U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, put((i % 3U) == 0U, i, 20U + i));
        TEST_ASSERT_EQUAL(i + 1U, communication_ground_queue_count(&queue));
    }
    for (uint32_t i = 0U; i < 60U; i++) {
        expect((i % 3U) == 0U, i, 20U + i);
    }
    expect_empty();
    TEST_ASSERT_EQUAL(0U, queue.dropped);
}

static void the_order_is_kept_when_the_stamps_wrap(void)
{
    queue.next_stamp = UINT32_MAX - 20U;
    order_is_kept_across_both_kinds();
}

static void the_oldest_housekeeping_is_dropped_first(void)
{
    const uint32_t fits = GROUND_QUEUE_OCTETS / (1000U + 8U);
    TEST_ASSERT_EQUAL(STATUS_OK, put(false, 7777U, 100U));
    for (uint32_t i = 0U; i < (3U * fits); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, put(true, i, 1000U));
    }
    TEST_ASSERT_EQUAL(2U * fits, queue.dropped);
    TEST_ASSERT_EQUAL(fits + 1U, communication_ground_queue_count(&queue));
    expect(false, 7777U, 100U);
    for (uint32_t i = 2U * fits; i < (3U * fits); i++) {
        expect(true, i, 1000U);
    }
    expect_empty();
}

static void a_partly_sent_packet_is_sent_to_its_end(void)
{
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, put(true, 1U, 500U));
    TEST_ASSERT_NOT_NULL(communication_ground_queue_next(&queue, &size));
    communication_ground_queue_sent(&queue, 200U);
    for (uint32_t i = 0U; i < 1000U; i++) { // All other reports of this kind are dropped.
        TEST_ASSERT_EQUAL(STATUS_OK, put(true, 100U + i, 1000U));
    }
    const uint8_t* const next = communication_ground_queue_next(&queue, &size);
    TEST_ASSERT_EQUAL(300U, size);
    TEST_ASSERT_EQUAL_HEX8(1U, next[0]);
    TEST_ASSERT_EQUAL_HEX8(1U, next[299]);
    communication_ground_queue_sent(&queue, 300U);
    TEST_ASSERT_NOT_NULL(communication_ground_queue_next(&queue, &size));
    TEST_ASSERT_EQUAL(1000U, size);
}

static void a_firm_report_is_refused_when_the_queue_is_full(void)
{
    uint32_t count = 0U;
    while (put(false, count, 2000U) == STATUS_OK) {
        count++;
    }
    TEST_ASSERT_EQUAL(GROUND_QUEUE_OCTETS / (2000U + 8U), count);
    TEST_ASSERT_EQUAL(STATUS_OK, put(true, count, 2000U)); // Housekeeping has room of its own.
    TEST_ASSERT_EQUAL(STATUS_FULL, put(false, 99999U, 2000U));
    for (uint32_t i = 0U; i < count; i++) {
        expect(false, i, 2000U);
    }
    expect(true, count, 2000U);
    expect_empty();
}

static void other_reports_of_service_3_are_no_housekeeping(void)
{
    uint8_t packet[64] = {0};
    packet[7]          = 3U;
    for (unsigned subtype = 0U; subtype < 256U; subtype++) {
        const uint32_t before = queue.housekeeping.blocks;
        packet[8]             = (uint8_t)subtype;
        TEST_ASSERT_EQUAL(STATUS_OK, communication_ground_queue_put(&queue, packet, sizeof packet));
        TEST_ASSERT_EQUAL((subtype == 25U) ? 1U : 0U, queue.housekeeping.blocks - before);
    }
    // A packet too short for its type is kept.
    TEST_ASSERT_EQUAL(STATUS_OK, communication_ground_queue_put(&queue, packet, 8U));
    TEST_ASSERT_EQUAL(1U, queue.housekeeping.blocks);
}

typedef struct {
    bool is_housekeeping;
    uint32_t number;
    size_t size;
} item_t;

static item_t items[MODEL_MAX];
static unsigned item_count;
static size_t used[2]; // Octets per kind.

static void remove_item(unsigned index)
{
    used[items[index].is_housekeeping ? 1U : 0U] -= items[index].size + 8U;
    item_count--;
    (void)memmove(&items[index], &items[index + 1U], (item_count - index) * sizeof items[0]);
}

static void put_into_both(uint32_t number)
{
    const bool is_housekeeping = draw(3U) > 0U;
    const size_t size          = 9U + draw(PUS_PACKET_MAX - 8U);
    const unsigned kind        = is_housekeeping ? 1U : 0U;
    if (!is_housekeeping && ((used[0] + size + 8U) > GROUND_QUEUE_OCTETS)) {
        TEST_ASSERT_EQUAL(STATUS_FULL, put(false, number, size));
        return;
    }
    TEST_ASSERT_EQUAL(STATUS_OK, put(is_housekeeping, number, size));
    for (unsigned i = 0U; is_housekeeping && ((used[1] + size + 8U) > GROUND_QUEUE_OCTETS);) {
        if (items[i].is_housekeeping) {
            remove_item(i);
        } else {
            i++;
        }
    }
    TEST_ASSERT_TRUE(item_count < MODEL_MAX);
    items[item_count++] = (item_t){is_housekeeping, number, size};
    used[kind] += size + 8U;
}

static void a_queue_behaves_like_its_model(void)
{
    item_count = 0U;
    used[0]    = 0U;
    used[1]    = 0U;
    for (uint32_t step = 0U; step < 20000U; step++) {
        const bool is_slow = ((step / 1000U) % 2U) == 0U;
        if (draw(100U) < (is_slow ? 80U : 35U)) {
            put_into_both(step);
        } else if (item_count > 0U) {
            const item_t first = items[0];
            remove_item(0U);
            expect(first.is_housekeeping, first.number, first.size);
        } else {
            expect_empty();
        }
        TEST_ASSERT_EQUAL(item_count, communication_ground_queue_count(&queue));
    }
    TEST_ASSERT_TRUE(queue.dropped > 1000U);
}

static void a_report_that_is_being_sent_counts_as_waiting(void)
{
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, put(true, 1U, 50U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(false, 2U, 50U));
    for (uint32_t left = 2U; left > 0U; left--) {
        (void)communication_ground_queue_next(&queue, &size);
        TEST_ASSERT_EQUAL(left, communication_ground_queue_count(&queue));
        communication_ground_queue_sent(&queue, size - 1U);
        TEST_ASSERT_EQUAL(left, communication_ground_queue_count(&queue));
        communication_ground_queue_sent(&queue, 1U);
        TEST_ASSERT_EQUAL(left - 1U, communication_ground_queue_count(&queue));
    }
}

/// A queue that is initialised for another client has no report for its earlier client.
static void an_initialised_queue_is_empty(void)
{
    size_t size         = 0U;
    const size_t unused = communication_ground_queue_room(&queue);
    TEST_ASSERT_EQUAL(STATUS_OK, put(true, 1U, 50U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(false, 2U, 50U));
    TEST_ASSERT_TRUE(communication_ground_queue_room(&queue) < unused);
    (void)communication_ground_queue_next(&queue, &size);
    communication_ground_queue_sent(&queue, 3U);
    communication_ground_queue_init(&queue);
    expect_empty();
    TEST_ASSERT_EQUAL(unused, communication_ground_queue_room(&queue));
}

/// The octets that follow the packet in memory have no effect.
static void a_packet_that_ends_before_its_subtype_is_no_housekeeping(void)
{
    const uint8_t packet[9] = {[7] = 3U, [8] = 25U};
    TEST_ASSERT_EQUAL(STATUS_OK, communication_ground_queue_put(&queue, packet, 8U));
    TEST_ASSERT_EQUAL(1U, queue.firm.blocks);
    TEST_ASSERT_EQUAL(STATUS_OK, communication_ground_queue_put(&queue, packet, 9U));
    TEST_ASSERT_EQUAL(1U, queue.firm.blocks);
    TEST_ASSERT_EQUAL(1U, queue.housekeeping.blocks);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(order_is_kept_across_both_kinds);
    RUN_TEST(the_order_is_kept_when_the_stamps_wrap);
    RUN_TEST(the_oldest_housekeeping_is_dropped_first);
    RUN_TEST(a_partly_sent_packet_is_sent_to_its_end);
    RUN_TEST(a_firm_report_is_refused_when_the_queue_is_full);
    RUN_TEST(other_reports_of_service_3_are_no_housekeeping);
    RUN_TEST(a_queue_behaves_like_its_model);
    RUN_TEST(a_report_that_is_being_sent_counts_as_waiting);
    RUN_TEST(an_initialised_queue_is_empty);
    RUN_TEST(a_packet_that_ends_before_its_subtype_is_no_housekeeping);
    return UNITY_END();
}
