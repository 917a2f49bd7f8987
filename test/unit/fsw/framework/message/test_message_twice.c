// SPDX-License-Identifier: Apache-2.0
// Frames that the network delivers twice: a frame gives one block, and credit is given once.
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/message_frame.h"

#include "test/unit/fsw/framework/message/party.h"
#include "unity.h"

#include <string.h>

static party_t party;

void setUp(void)
{
}

void tearDown(void)
{
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
    if (party_receive(&party, index, &from, (uint8_t*)&found, sizeof found, &size) == STATUS_OK) {
        TEST_ASSERT_EQUAL(sizeof found, size);
    }
    return found;
}

static void exchange(unsigned a, unsigned b, uint32_t first_number, uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        send_number(a, b, first_number + i);
        TEST_ASSERT_EQUAL(first_number + i, next_number(b));
        send_number(b, a, first_number + i);
        TEST_ASSERT_EQUAL(first_number + i, next_number(a));
    }
}

/// Header of a frame of member 0 to member 1.
static const message_frame_t first = {.kind = MESSAGE_DATA, .from = 16U, .to = 17U, .from_life = 1U};

static void inject(const message_frame_t* header, size_t payload)
{
    uint8_t octets[MESSAGE_HEADER_OCTETS + 8U] = {0U};
    message_frame_write(header, octets);
    party_inject(&party, 0U, 1U, octets, MESSAGE_HEADER_OCTETS + payload);
}

static void drop_again(uint32_t count)
{
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
    TEST_ASSERT_EQUAL(count, end(1U)->counters.stale);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.lost);
}

/// The network delivers each frame of half a window twice: at once, after the frames were received, and while
/// the next frames wait.
static void deliver_twice(void)
{
    exchange(0U, 1U, 0U, 3U);
    message_frame_t header = first;
    header.to_life         = 1U;
    header.taken           = 3U;
    uint32_t again         = 0U;
    const uint32_t window  = MESSAGE_WINDOW / 2U; // Inboxes hold a window; here each frame comes twice.
    for (uint32_t i = 0U; i < window; i++) {
        send_number(0U, 1U, 100U + i);
        header.sequence = 3U + i;
        inject(&header, 4U);
    }
    for (uint32_t i = 0U; i < window; i++) {
        TEST_ASSERT_EQUAL(100U + i, next_number(1U));
    }
    again += window;
    drop_again(again);
    for (uint32_t i = 0U; i < window; i++) { // Late, one after the other.
        header.sequence = 3U + i;
        inject(&header, 4U);
        again++;
        drop_again(again);
    }
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(0U)); // This receives the credit.
    for (uint32_t i = 0U; i < window; i++) {        // Late, before the next frames.
        header.sequence = 3U + i;
        inject(&header, 4U);
        again++;
        send_number(0U, 1U, 200U + i);
    }
    for (uint32_t i = 0U; i < window; i++) {
        TEST_ASSERT_EQUAL(200U + i, next_number(1U));
    }
    drop_again(again);
    TEST_ASSERT_EQUAL(0U, end(1U)->counters.overruns);
    exchange(0U, 1U, 300U, 3U);
    TEST_ASSERT_EQUAL(UINT32_MAX, next_number(0U));
    TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(end(0U), party_id(1U)) +
                                          (end(1U)->slots[0].channel.position.taken -
                                           end(1U)->slots[0].channel.position.acknowledged));
}

static void a_duplicated_frame_is_delivered_once(void)
{
    party_in_each_form(&party, deliver_twice);
}

/// Credit that is reported twice is given once, even if more was sent in between.
static void report_credit_twice(void)
{
    message_frame_t header = first;
    header.kind            = MESSAGE_CREDIT;
    header.to_life         = 1U;
    for (uint32_t i = 0U; i < 10U; i++) {
        send_number(1U, 0U, i);
        TEST_ASSERT_EQUAL(i, next_number(0U));
    }
    header.taken = 10U;
    for (unsigned k = 0U; k < 3U; k++) {
        inject(&header, 0U);
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW, message_credit(end(1U), party_id(0U)));
    }
    for (uint32_t i = 0U; i < 5U; i++) {
        send_number(1U, 0U, 10U + i);
    }
    for (unsigned k = 0U; k < 3U; k++) {
        inject(&header, 0U); // The same count as before.
        TEST_ASSERT_EQUAL(UINT32_MAX, next_number(1U));
        TEST_ASSERT_EQUAL(MESSAGE_WINDOW - 5U, message_credit(end(1U), party_id(0U)));
        TEST_ASSERT_EQUAL(5U * (MESSAGE_HEADER_OCTETS + 4U), end(1U)->slots[0].channel.position.under_way);
    }
    for (uint32_t i = 0U; i < 5U; i++) {
        TEST_ASSERT_EQUAL(10U + i, next_number(0U));
    }
    TEST_ASSERT_EQUAL(0U, end(0U)->counters.lost + end(0U)->counters.stale);
}

static void credit_that_is_received_twice_is_given_once(void)
{
    party_in_each_form(&party, report_credit_twice);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_duplicated_frame_is_delivered_once);
    RUN_TEST(credit_that_is_received_twice_is_given_once);
    return UNITY_END();
}
