// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "fsw/framework/dataflow/flow_mqueue.h"

#include "test/unit/fsw/framework/dataflow/sample_record.h"
#include "test/support/assertion.h"
#include "unity.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define OCTETS 16U
#define DEPTH 4U

static char address[ENDNODE_ADDRESS_MAX];
static flow_mqueue_t sender;
static flow_mqueue_t receiver;
static quota_t quota;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    if ((kind != ENDNODE_MQUEUE) || (strcmp(name, "moon") == 0)) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, (strcmp(name, "bad") == 0) ? "no name" : address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static void begin(flow_mqueue_t* const flow, const char* const name, const bool is_receiver,
                  const uint32_t octets)
{
    const flow_mqueue_setup_t setup = {.name             = name,
                                       .is_receiver      = is_receiver,
                                       .depth            = DEPTH,
                                       .message_octets   = octets,
                                       .retry_first_ns   = 10U,
                                       .retry_longest_ns = 40U,
                                       .quota            = &quota};
    flow_mqueue_init(flow, &setup, &resolver);
}

void setUp(void)
{
    (void)snprintf(address, sizeof address, "/flow-mqueue-test.%d", (int)getpid());
    (void)osal_mqueue_remove(address);
    quota_init(&quota, 4U);
    begin(&receiver, "commands", true, OCTETS);
    begin(&sender, "commands", false, OCTETS);
    osal_mqueue_t probe;
    if (osal_mqueue_create(&probe, address, 1U, 1U) == STATUS_UNSUPPORTED) {
        TEST_IGNORE_MESSAGE("this system has no message queues");
    }
    osal_mqueue_close(&probe);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mqueue_remove(address));
}

void tearDown(void)
{
    flow_mqueue_close(&sender);
    flow_mqueue_close(&receiver);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_mqueue_remove(address)); // No object remains.
}

static status_t say(const char* const words)
{
    return flow_mqueue_send(&sender, (const uint8_t*)words, strlen(words));
}

static void expect(const char* const words)
{
    uint8_t octets[OCTETS];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_receive(&receiver, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(strlen(words), size);
    TEST_ASSERT_EQUAL(0, memcmp(words, octets, size));
}

static void expect_nothing(const status_t status)
{
    uint8_t octets[OCTETS];
    size_t size = 1U;
    TEST_ASSERT_EQUAL(status, flow_mqueue_receive(&receiver, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
}

static void messages_pass_whichever_end_opens_first(void)
{
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, sender.link.failure);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, say("early"));
    expect_nothing(STATUS_CLOSED);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&receiver, 0U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_mqueue_step(&sender, 9U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&sender, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, say("one"));
    TEST_ASSERT_EQUAL(STATUS_OK, say(""));
    expect("one");
    expect("");
    expect_nothing(STATUS_EMPTY);
    TEST_ASSERT_EQUAL_UINT32(2U, sender.counters.sent);
    TEST_ASSERT_EQUAL_UINT32(1U, sender.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(2U, receiver.counters.received);
    TEST_ASSERT_EQUAL_UINT16(2U, quota.stats.used);
}

static void records_have_the_byte_order_of_the_flow(void)
{
    uint8_t octets[OCTETS];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&receiver, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&sender, 0U));
    for (unsigned order = 0U; order < (unsigned)FLOW_ORDERS; order++) {
        sample_t seen        = {.number = 9U};
        sender.setup.order   = (flow_order_t)order;
        receiver.setup.order = (flow_order_t)order;
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_mqueue_receive_record(&receiver, &sample_layout, &seen));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_send_record(&sender, &sample_layout, &sample));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_receive(&receiver, octets, sizeof octets, &size));
        TEST_ASSERT_EQUAL_UINT64(SAMPLE_OCTETS, size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(sample_wire[order], octets, size);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_send(&sender, octets, size + 1U));
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, flow_mqueue_receive_record(&receiver, &sample_layout, &seen));
        TEST_ASSERT_EQUAL_UINT32(order + 1U, receiver.counters.unfit);
        TEST_ASSERT_EQUAL_UINT16(9U, seen.number);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_send(&sender, octets, size));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_receive_record(&receiver, &sample_layout, &seen));
        TEST_ASSERT_TRUE(is_sample(&seen));
    }
    TEST_ASSERT_EQUAL_UINT32(2U, receiver.counters.unfit);
}

static void send_a_giant(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_send_record(&sender, &giant_layout, giant_record));
}

static void a_record_that_is_too_long_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(send_a_giant));
}

static void a_full_queue_and_a_message_that_is_too_large_are_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&receiver, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, say("12345678901234567"));
    for (unsigned i = 0U; i < DEPTH; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, say("1234567890123456"));
    }
    TEST_ASSERT_EQUAL(STATUS_FULL, say("x"));
    TEST_ASSERT_EQUAL_UINT32(2U, sender.counters.refused);
    TEST_ASSERT_TRUE(flow_mqueue_is_open(&sender));
}

/// A receiver killed in another process leaves its queue; its successor begins with an empty one.
static void a_new_receiver_replaces_a_killed_one(void)
{
    const pid_t other = fork();
    if (other == 0) {
        if (flow_mqueue_step(&receiver, 0U) == STATUS_OK) {
            (void)raise(SIGKILL);
        }
        _exit(1);
    }
    int exit_status = 0;
    TEST_ASSERT_EQUAL(other, waitpid(other, &exit_status, 0));
    TEST_ASSERT_TRUE(WIFSIGNALED(exit_status));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, say("to the dead"));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&receiver, 0U));
    expect_nothing(STATUS_EMPTY);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, say("lost"));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, sender.link.failure);
    TEST_ASSERT_EQUAL_UINT32(1U, sender.link.reconnect.lost);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&sender, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, say("alive"));
    expect("alive");
}

static void a_queue_that_cannot_be_opened_reports_the_reason(void)
{
    begin(&sender, "moon", false, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, sender.link.failure);
    begin(&sender, "bad", false, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, sender.link.failure);
    begin(&sender, "commands", true, 100000000U);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, sender.link.failure);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_mqueue_step(&receiver, 0U));
    begin(&sender, "commands", false, OCTETS + 1U); // The messages of this queue would be too large.
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_INVALID, sender.link.failure);
    quota_init(&quota, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      quota_take(&quota)); // Takes the only unit of the quota, as an open receiver does.
    begin(&sender, "commands", false, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_mqueue_step(&sender, 0U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, sender.link.failure);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(messages_pass_whichever_end_opens_first);
    RUN_TEST(records_have_the_byte_order_of_the_flow);
    RUN_TEST(a_record_that_is_too_long_is_a_coding_error);
    RUN_TEST(a_full_queue_and_a_message_that_is_too_large_are_reported);
    RUN_TEST(a_new_receiver_replaces_a_killed_one);
    RUN_TEST(a_queue_that_cannot_be_opened_reports_the_reason);
    return UNITY_END();
}
