// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/mqueue.h"

#include "osal/include/osal/process.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define OCTETS 64U

static char name[64];
static osal_mqueue_t receiver;
static osal_mqueue_t sender;

void setUp(void)
{
    (void)snprintf(name, sizeof name, "/osal-mq-test.%d", (int)osal_process_own_id());
    (void)osal_mqueue_remove(name);
    const status_t status = osal_mqueue_create(&receiver, name, 4U, OCTETS);
    if (status == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this system has no message queues");
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_open(&sender, name));
}

void tearDown(void)
{
    osal_mqueue_close(&sender);
    osal_mqueue_close(&receiver);
    (void)osal_mqueue_remove(name);
}

static void expect(const char* const words)
{
    uint8_t octets[OCTETS];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_receive(&receiver, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(strlen(words), size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(words, octets, size);
}

static status_t say(const char* const words)
{
    return osal_mqueue_send(&sender, (const uint8_t*)words, strlen(words));
}

static void messages_arrive_whole_and_in_order(void)
{
    uint8_t octets[OCTETS];
    size_t size = 1U;
    TEST_ASSERT_TRUE(sender.is_open);
    TEST_ASSERT_EQUAL_UINT32(OCTETS, osal_mqueue_message_octets(&sender));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_mqueue_receive(&receiver, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_OK, say("one"));
    TEST_ASSERT_EQUAL(STATUS_OK, say("two and more"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_send(&sender, NULL, 0U)); // An empty message is a message, too.
    expect("one");
    expect("two and more");
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_receive(&receiver, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
}

static void limits_are_reached_and_reported(void)
{
    uint8_t octets[OCTETS + 1U] = {0U};
    size_t size                 = 0U;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_mqueue_send(&sender, octets, OCTETS + 1U));
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_send(&sender, octets, OCTETS));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, osal_mqueue_send(&sender, octets, 1U));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_mqueue_receive(&receiver, octets, OCTETS - 1U, &size));
    for (unsigned i = 0U; i < 4U; i++) { // The call that was refused took no message.
        TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_receive(&receiver, octets, OCTETS, &size));
        TEST_ASSERT_EQUAL_UINT64(OCTETS, size);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_mqueue_receive(&receiver, octets, OCTETS, &size));
}

static void the_minimum_queue_is_always_granted_and_an_excessive_one_never(void)
{
    osal_mqueue_t other;
    osal_mqueue_close(&sender);
    osal_mqueue_close(&receiver);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_remove(name));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      osal_mqueue_create(&other, name, OSAL_MQUEUE_DEPTH_ALWAYS, OSAL_MQUEUE_OCTETS_ALWAYS));
    osal_mqueue_close(&other);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_remove(name));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, osal_mqueue_create(&other, name, 1000000U, 1000000U));
    // The call that was refused leaves no name.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_mqueue_open(&other, name));
}

static void existing_missing_and_malformed_names_are_distinguished(void)
{
    osal_mqueue_t other;
    TEST_ASSERT_EQUAL(STATUS_EXISTS, osal_mqueue_create(&other, name, 4U, OCTETS));
    TEST_ASSERT_FALSE(other.is_open);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_remove(name));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_mqueue_remove(name));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_mqueue_open(&other, name));
    static const char* const bad[] = {"", "/", "noslash", "/a/b", "/a b", "/.", "/..", "//"};
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, osal_mqueue_create(&other, bad[i], 1U, 1U), bad[i]);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, osal_mqueue_open(&other, bad[i]), bad[i]);
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, osal_mqueue_remove(bad[i]), bad[i]);
    }
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_mqueue_create(&other, name, 0U, 1U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_mqueue_create(&other, name, 1U, 0U));
}

static void a_sender_is_informed_when_the_receiver_starts_again(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, say("old"));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_remove(name));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, say("lost"));
    osal_mqueue_close(&receiver);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_create(&receiver, name, 4U, OCTETS));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, say("lost"));
    osal_mqueue_close(&sender);
    osal_mqueue_close(&sender);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_open(&sender, name));
    TEST_ASSERT_EQUAL(STATUS_OK, say("new"));
    expect("new");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(messages_arrive_whole_and_in_order);
    RUN_TEST(limits_are_reached_and_reported);
    RUN_TEST(the_minimum_queue_is_always_granted_and_an_excessive_one_never);
    RUN_TEST(existing_missing_and_malformed_names_are_distinguished);
    RUN_TEST(a_sender_is_informed_when_the_receiver_starts_again);
    return UNITY_END();
}
