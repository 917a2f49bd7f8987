// SPDX-License-Identifier: Apache-2.0
// Reports that wait for the ground: order, classes, and the taking and returning of blocks.
#include "fsw/supervisor/ground_backlog.h"

#include "unity.h"

#include <string.h>

static ground_backlog_t backlog;

void setUp(void)
{
    supervisor_ground_backlog_init(&backlog);
}

static unsigned blocks_taken(void)
{
    unsigned taken = 0U;
    for (unsigned i = 0U; i < GROUND_SIZES; i++) {
        taken += backlog.blocks.pools[i].stats.taken;
    }
    return taken;
}

static void drain(void)
{
    ground_report_t report;
    while (supervisor_ground_backlog_next(&backlog, true, &report)) {
        supervisor_ground_backlog_sent(&backlog, &report);
    }
}

void tearDown(void)
{
    drain();
    TEST_ASSERT_TRUE(supervisor_ground_backlog_is_empty(&backlog));
    TEST_ASSERT_EQUAL(0U, blocks_taken());
}

/// A report with its message type and a number that identifies it.
static void build(uint8_t packet[PUS_PACKET_MAX], uint8_t service, uint8_t subtype, uint8_t number)
{
    (void)memset(packet, 0, PUS_PACKET_MAX);
    packet[0]  = 0x08U;
    packet[7]  = service;
    packet[8]  = subtype;
    packet[17] = number;
}

static status_t put(uint8_t source, uint8_t service, uint8_t subtype, uint8_t number, size_t size)
{
    static uint8_t packet[PUS_PACKET_MAX];
    build(packet, service, subtype, number);
    return supervisor_ground_backlog_put(&backlog, source, packet, size, NULL);
}

static void expect(bool is_plain_open, uint8_t number)
{
    ground_report_t report;
    TEST_ASSERT_TRUE(supervisor_ground_backlog_next(&backlog, is_plain_open, &report));
    TEST_ASSERT_EQUAL(number, report.packet[17]);
    supervisor_ground_backlog_sent(&backlog, &report);
}

static void expect_none(bool is_plain_open)
{
    ground_report_t report;
    TEST_ASSERT_FALSE(supervisor_ground_backlog_next(&backlog, is_plain_open, &report));
}

static void reports_leave_in_the_order_they_came(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 5U, 1U, 1U, 30U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 1U, 7U, 2U, 30U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 3U, 25U, 3U, 300U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 5U, 4U, 4U, 30U));
    for (uint8_t i = 1U; i <= 4U; i++) {
        expect(true, i);
    }
    expect_none(true);
}

static void firm_reports_overtake_plain_ones_but_not_the_answer_they_complete(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 17U, 2U, 1U, 30U)); // An answer.
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 1U, 7U, 2U, 30U));  // The end of the answered request.
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 5U, 4U, 3U, 30U));  // A HIGH event of the same subsystem.
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 1U, 7U, 4U, 30U));  // The end of a request to another subsystem.
    expect(false, 3U);
    expect(false, 4U);
    expect_none(false);
    expect(true, 1U);
    expect(false, 2U);
    expect_none(true);
}

static void each_class_has_its_own_room(void)
{
    unsigned plain = 0U;
    unsigned bulk  = 0U;
    unsigned firm  = 0U;
    while (put(1U, 5U, 1U, 0U, 60U) == STATUS_OK) {
        plain++;
    }
    while (put(1U, 3U, 25U, 0U, 4000U) == STATUS_OK) {
        bulk++;
    }
    TEST_ASSERT_EQUAL(GROUND_PLAIN_REPORTS, plain);
    TEST_ASSERT_EQUAL(0U, supervisor_ground_backlog_room(&backlog, PUS_CLASS_PLAIN));
    TEST_ASSERT_EQUAL(GROUND_BULK_OCTETS / 4000U, bulk);
    TEST_ASSERT_EQUAL(GROUND_FIRM_OCTETS, supervisor_ground_backlog_room(&backlog, PUS_CLASS_FIRM));
    while (put(1U, 1U, 7U, 0U, 40U) == STATUS_OK) {
        firm++;
    }
    TEST_ASSERT_EQUAL(GROUND_FIRM_REPORTS, firm);
}

static void plain_reports_leave_the_blocks_reserved_for_firm_ones(void)
{
    unsigned plain = 0U;
    while (put(1U, 17U, 2U, 0U, 200U) == STATUS_OK) {
        plain++;
    }
    TEST_ASSERT_EQUAL(80U, plain); // 128 blocks of this size, 48 of them reserved for FIRM reports.
    TEST_ASSERT_TRUE(supervisor_ground_backlog_room(&backlog, PUS_CLASS_PLAIN) > 200U);
    for (unsigned i = 0U; i < 48U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 1U, 8U, 0U, 200U));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, put(1U, 1U, 8U, 0U, 200U)); // No block is left.
}

/// Handle a report of 60 octets as the router does, which takes a block before it knows the class of the
/// report.
static status_t put_routed(uint8_t service, uint8_t subtype)
{
    uint8_t* const block = supervisor_ground_backlog_take(&backlog, 60U);
    if (block == NULL) {
        return STATUS_FULL;
    }
    uint8_t packet[PUS_PACKET_MAX];
    build(packet, service, subtype, 0U);
    (void)memcpy(block, packet, 60U);
    const status_t status = supervisor_ground_backlog_put(&backlog, 1U, block, 60U, block);
    supervisor_ground_backlog_give(&backlog, block);
    return status;
}

/// Requests are accepted while their answers have room; waiting BULK reports do not prevent this.
static void bulk_reports_leave_room_for_requests(void)
{
    unsigned plain = 0U;
    while (put_routed(3U, 25U) == STATUS_OK) {
    }
    TEST_ASSERT_TRUE(supervisor_ground_backlog_takes_requests(&backlog));
    while (supervisor_ground_backlog_takes_requests(&backlog)) {
        TEST_ASSERT_EQUAL(STATUS_OK, put_routed(17U, 2U));
        plain++;
    }
    // 320 blocks are kept from BULK reports; requests are accepted while 2 * 128 of these are free.
    TEST_ASSERT_EQUAL(65U, plain);
    // GROUND_INTAKE_REPORTS requests may be outstanding. The last report above was the answer to one of them.
    for (unsigned i = 1U; i < GROUND_INTAKE_REPORTS; i++) {
        // The answer to each of the others, and its completion.
        TEST_ASSERT_EQUAL(STATUS_OK, put_routed(17U, 2U));
        TEST_ASSERT_EQUAL(STATUS_OK, put_routed(1U, 7U));
    }
}

static void a_waiting_report_stays_in_its_block(void)
{
    uint8_t* const block = supervisor_ground_backlog_take(&backlog, 100U);
    ground_report_t report;
    TEST_ASSERT_NOT_NULL(block);
    build(block, 1U, 7U, 9U);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_ground_backlog_put(&backlog, 3U, block, 100U, block));
    TEST_ASSERT_EQUAL(1U, blocks_taken());
    // The router has released the block, but the queue still holds it.
    supervisor_ground_backlog_give(&backlog, block);
    TEST_ASSERT_EQUAL(1U, blocks_taken());
    TEST_ASSERT_TRUE(supervisor_ground_backlog_next(&backlog, true, &report));
    TEST_ASSERT_EQUAL_PTR(block, report.packet);
    TEST_ASSERT_EQUAL(PUS_CLASS_FIRM, report.class);
    supervisor_ground_backlog_sent(&backlog, &report);
    TEST_ASSERT_EQUAL(0U, blocks_taken());
}

static void routed_reports_leave_the_blocks_reserved_for_firm_ones(void)
{
    unsigned others = 0U;
    unsigned firm   = 0U;
    for (unsigned i = 0U; i < 400U; i++) {
        others += (put_routed(5U, 1U) == STATUS_OK) ? 1U : 0U;
        others += (put_routed(3U, 25U) == STATUS_OK) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(GROUND_PLAIN_REPORTS + 96U, others); // BULK reports are half of the first 192.
    while (put_routed(1U, 7U) == STATUS_OK) {
        firm++;
    }
    TEST_ASSERT_EQUAL(768U - others, firm); // At least the 256 reserved for these.
}

static void without_blocks_allocation_is_refused(void)
{
    uint8_t* blocks[7];
    TEST_ASSERT_NULL(supervisor_ground_backlog_take(&backlog, PUS_PACKET_MAX + 1U));
    for (unsigned i = 0U; i < 7U; i++) {
        blocks[i] = supervisor_ground_backlog_take(&backlog, PUS_PACKET_MAX);
        TEST_ASSERT_NOT_NULL(blocks[i]);
    }
    TEST_ASSERT_NULL(supervisor_ground_backlog_take(&backlog, PUS_PACKET_MAX));
    TEST_ASSERT_EQUAL(STATUS_FULL, put(1U, 1U, 7U, 0U, 4000U));
    for (unsigned i = 0U; i < 7U; i++) {
        supervisor_ground_backlog_give(&backlog, blocks[i]);
    }
}

static void waiting_reports_are_copied_in_order(void)
{
    static uint8_t storage[GROUND_OCTETS];
    static uint8_t packet[PUS_PACKET_MAX];
    message_ring_t ring;
    size_t size = 0U;
    message_ring_init(&ring, storage, sizeof storage);
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 5U, 4U, 1U, 30U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 17U, 2U, 2U, 30U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 1U, 7U, 3U, 30U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 5U, 4U, 4U, 30U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 3U, 25U, 5U, 300U));
    TEST_ASSERT_EQUAL(STATUS_OK, put(2U, 5U, 4U, 6U, 30U));
    expect(false, 1U);
    expect(false, 4U); // The removed report leaves a gap in the queue.
    supervisor_ground_backlog_copy(&backlog, &ring);
    static const uint8_t left[] = {2U, 3U, 5U, 6U};
    for (size_t i = 0U; i < sizeof left; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&ring, packet, sizeof packet, &size));
        TEST_ASSERT_EQUAL(left[i], packet[17]);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, message_ring_take(&ring, packet, sizeof packet, &size));
}

/// There are more slots than blocks, so the reports of a class share one block. Then every slot of every
/// queue is in use.
static void full_queues_are_copied_completely(void)
{
    static const uint8_t types[PUS_CLASSES][2] = {{1U, 7U}, {17U, 2U}, {3U, 25U}};
    static uint8_t storage[GROUND_OCTETS];
    static uint8_t packet[PUS_PACKET_MAX];
    message_ring_t ring;
    size_t size       = 0U;
    unsigned expected = 0U;
    message_ring_init(&ring, storage, sizeof storage);
    for (unsigned i = 0U; i < 300U; i++) { // Afterwards the queues do not begin at their first slot.
        TEST_ASSERT_EQUAL(STATUS_OK, put(1U, 1U, 7U, 0U, 30U));
        expect(true, 0U);
    }
    for (size_t class = 0U; class < PUS_CLASSES; class ++) {
        uint8_t* const block = supervisor_ground_backlog_take(&backlog, 30U);
        build(packet, types[class][0], types[class][1], (uint8_t) class);
        (void)memcpy(block, packet, 30U);
        while (supervisor_ground_backlog_put(&backlog, 1U, block, 30U, block) == STATUS_OK) {
            expected++;
        }
        supervisor_ground_backlog_give(&backlog, block);
    }
    TEST_ASSERT_EQUAL(GROUND_REPORTS, expected);
    supervisor_ground_backlog_copy(&backlog, &ring);
    TEST_ASSERT_EQUAL(GROUND_REPORTS, ring.blocks);
    static const unsigned counts[PUS_CLASSES] = {GROUND_FIRM_REPORTS, GROUND_PLAIN_REPORTS,
                                                 GROUND_BULK_REPORTS};
    for (size_t class = 0U; class < PUS_CLASSES; class ++) {
        for (unsigned i = 0U; i < counts[class]; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(&ring, packet, sizeof packet, &size));
            TEST_ASSERT_EQUAL(class, packet[17]);
        }
    }
}

/// Put this many reports of a class into its queue, all in one block.
static void put_shared(uint8_t service, uint8_t subtype, size_t size, unsigned count)
{
    uint8_t packet[PUS_PACKET_MAX];
    uint8_t* const block = supervisor_ground_backlog_take(&backlog, size);
    build(packet, service, subtype, 0U);
    (void)memcpy(block, packet, size);
    for (unsigned i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, supervisor_ground_backlog_put(&backlog, 1U, block, size, block));
    }
    supervisor_ground_backlog_give(&backlog, block);
}

/// Room for answers is counted in slots, octets and blocks, for FIRM and for PLAIN reports.
static void requests_are_taken_up_to_the_exact_room_for_their_answers(void)
{
    put_shared(1U, 7U, 30U, GROUND_FIRM_REPORTS - GROUND_INTAKE_REPORTS);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_takes_requests(&backlog));
    put_shared(1U, 7U, 30U, 1U);
    TEST_ASSERT_FALSE(supervisor_ground_backlog_takes_requests(&backlog));
    drain();
    put_shared(17U, 2U, 30U, GROUND_PLAIN_REPORTS - GROUND_INTAKE_REPORTS);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_takes_requests(&backlog));
    put_shared(17U, 2U, 30U, 1U);
    TEST_ASSERT_FALSE(supervisor_ground_backlog_takes_requests(&backlog));
    drain();
    put_shared(1U, 7U, 4096U, (GROUND_FIRM_OCTETS - GROUND_INTAKE) / 4096U);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_takes_requests(&backlog));
    put_shared(1U, 7U, 30U, 1U);
    TEST_ASSERT_FALSE(supervisor_ground_backlog_takes_requests(&backlog));
    drain();
    put_shared(17U, 2U, 4096U, (GROUND_PLAIN_OCTETS - GROUND_INTAKE) / 4096U);
    TEST_ASSERT_TRUE(supervisor_ground_backlog_takes_requests(&backlog));
    put_shared(17U, 2U, 30U, 1U);
    TEST_ASSERT_FALSE(supervisor_ground_backlog_takes_requests(&backlog));
    drain();
    uint8_t* blocks[257];
    // 256 of the 768 blocks are reserved for FIRM reports, and 256 for the answers.
    for (unsigned i = 0U; i < 256U; i++) {
        blocks[i] = supervisor_ground_backlog_take(&backlog, 30U);
    }
    TEST_ASSERT_TRUE(supervisor_ground_backlog_takes_requests(&backlog));
    blocks[256] = supervisor_ground_backlog_take(&backlog, 30U);
    TEST_ASSERT_FALSE(supervisor_ground_backlog_takes_requests(&backlog));
    for (unsigned i = 0U; i < 257U; i++) {
        supervisor_ground_backlog_give(&backlog, blocks[i]);
    }
}

/// The numbers of a class are consecutive: no report is duplicated, lost or out of order within its class.
static void random_operations_keep_order_and_blocks(void)
{
    uint32_t random_state         = 5U;
    uint8_t next[PUS_CLASSES]     = {0U};
    uint8_t expected[PUS_CLASSES] = {0U};
    for (unsigned i = 0U; i < 100000U; i++) {
        random_state          = (random_state * 1664525U) + 1013904223U;
        const unsigned choice = (random_state >> 24U) % 8U;
        const size_t size     = 30U + ((random_state >> 8U) % ((choice == 2U) ? 4000U : 300U));
        if (choice < 3U) {
            static const uint8_t types[3][2] = {{5U, 4U}, {5U, 1U}, {3U, 25U}};
            if (put((uint8_t)(random_state % 16U), types[choice][0], types[choice][1], next[choice], size) ==
                STATUS_OK) {
                next[choice]++;
            }
        } else {
            ground_report_t report;
            if (supervisor_ground_backlog_next(&backlog, choice < 6U, &report)) {
                TEST_ASSERT_EQUAL(expected[report.class], report.packet[17]);
                expected[report.class]++;
                supervisor_ground_backlog_sent(&backlog, &report);
            }
        }
    }
    drain();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(reports_leave_in_the_order_they_came);
    RUN_TEST(firm_reports_overtake_plain_ones_but_not_the_answer_they_complete);
    RUN_TEST(each_class_has_its_own_room);
    RUN_TEST(plain_reports_leave_the_blocks_reserved_for_firm_ones);
    RUN_TEST(bulk_reports_leave_room_for_requests);
    RUN_TEST(a_waiting_report_stays_in_its_block);
    RUN_TEST(routed_reports_leave_the_blocks_reserved_for_firm_ones);
    RUN_TEST(without_blocks_allocation_is_refused);
    RUN_TEST(waiting_reports_are_copied_in_order);
    RUN_TEST(full_queues_are_copied_completely);
    RUN_TEST(requests_are_taken_up_to_the_exact_room_for_their_answers);
    RUN_TEST(random_operations_keep_order_and_blocks);
    return UNITY_END();
}
