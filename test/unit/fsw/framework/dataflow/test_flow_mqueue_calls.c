// SPDX-License-Identifier: Apache-2.0
// What a flow on a message queue does with each status of the queue. The queue is mocked.
#include "fsw/framework/dataflow/flow_mqueue.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define OCTETS 16U
#define DEPTH 4U
#define RETRY_NS 10U

static flow_mqueue_t flow;
static quota_t quota;

status_t __wrap_osal_mqueue_create(osal_mqueue_t* queue, const char* name, uint32_t depth,
                                   uint32_t message_octets)
{
    assert_ptr_equal(&flow.queue, queue);
    assert_string_equal("/commands", name);
    assert_int_equal(DEPTH, depth);
    assert_int_equal(OCTETS, message_octets);
    return mock_type(status_t);
}

status_t __wrap_osal_mqueue_open(osal_mqueue_t* queue, const char* name)
{
    assert_ptr_equal(&flow.queue, queue);
    assert_string_equal("/commands", name);
    return mock_type(status_t);
}

uint32_t __wrap_osal_mqueue_message_octets(const osal_mqueue_t* queue)
{
    assert_ptr_equal(&flow.queue, queue);
    return mock_type(uint32_t);
}

status_t __wrap_osal_mqueue_send(osal_mqueue_t* queue, const uint8_t* octets, size_t size)
{
    assert_ptr_equal(&flow.queue, queue);
    check_expected_ptr(octets);
    check_expected(size);
    return mock_type(status_t);
}

status_t __wrap_osal_mqueue_receive(osal_mqueue_t* queue, uint8_t* octets, size_t capacity, size_t* out_size)
{
    const char* const words = mock_ptr_type(const char*);
    assert_ptr_equal(&flow.queue, queue);
    assert_true(capacity >= OCTETS);
    *out_size = strlen(words);
    (void)memcpy(octets, words, *out_size);
    return mock_type(status_t);
}

void __wrap_osal_mqueue_close(osal_mqueue_t* queue)
{
    assert_ptr_equal(&flow.queue, queue);
    function_called();
}

status_t __wrap_osal_mqueue_remove(const char* name)
{
    assert_string_equal("/commands", name);
    function_called();
    return mock_type(status_t);
}

static status_t resolve(void* context, flow_endnode_kind_t kind, const char* name,
                        flow_endnode_address_t* out_address)
{
    (void)context;
    assert_int_equal(ENDNODE_MQUEUE, kind);
    (void)strcpy(out_address->address, name);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static void begin(const bool is_receiver)
{
    const flow_mqueue_setup_t setup = {.name             = "/commands",
                                       .is_receiver      = is_receiver,
                                       .depth            = DEPTH,
                                       .message_octets   = OCTETS,
                                       .retry_first_ns   = RETRY_NS,
                                       .retry_longest_ns = RETRY_NS,
                                       .quota            = &quota};
    quota_init(&quota, 1U);
    flow_mqueue_init(&flow, &setup, &resolver);
}

/// A receiver removes what a predecessor has left, whether there is something or not, and makes the queue.
static void receiver_opens(const uint64_t now_ns, const status_t removed)
{
    expect_function_call(__wrap_osal_mqueue_remove);
    will_return(__wrap_osal_mqueue_remove, removed);
    will_return(__wrap_osal_mqueue_create, STATUS_OK);
    assert_int_equal(STATUS_OK, flow_mqueue_step(&flow, now_ns));
    assert_int_equal(1U, quota.stats.used);
}

static void sender_opens(const uint64_t now_ns)
{
    will_return(__wrap_osal_mqueue_open, STATUS_OK);
    will_return(__wrap_osal_mqueue_message_octets, OCTETS);
    assert_int_equal(STATUS_OK, flow_mqueue_step(&flow, now_ns));
}

static void assert_lost(const status_t why, const uint32_t times)
{
    assert_false(flow_mqueue_is_open(&flow));
    assert_int_equal(why, flow.link.failure);
    assert_int_equal(times, flow.link.reconnect.lost);
    assert_int_equal(0U, quota.stats.used);
}

static void a_queue_that_fails_to_receive_is_closed_and_opened_again(void** state)
{
    static const status_t failures[] = {STATUS_IO, STATUS_TOO_LARGE, STATUS_CLOSED};
    uint8_t octets[OCTETS];
    size_t size = 1U;
    (void)state;
    begin(true);
    receiver_opens(0U, STATUS_NOT_FOUND);
    for (uint32_t i = 0U; i < (sizeof failures / sizeof failures[0]); i++) {
        will_return(__wrap_osal_mqueue_receive, "");
        will_return(__wrap_osal_mqueue_receive, failures[i]);
        expect_function_call(__wrap_osal_mqueue_close);
        assert_int_equal(STATUS_CLOSED, flow_mqueue_receive(&flow, octets, sizeof octets, &size));
        assert_int_equal(0U, size);
        assert_lost(failures[i], i + 1U);
        assert_int_equal(STATUS_CLOSED, flow_mqueue_receive(&flow, octets, sizeof octets, &size));
        receiver_opens((i + 1U) * 10U * RETRY_NS, STATUS_OK);
        will_return(__wrap_osal_mqueue_receive, "again");
        will_return(__wrap_osal_mqueue_receive, STATUS_OK);
        assert_int_equal(STATUS_OK, flow_mqueue_receive(&flow, octets, sizeof octets, &size));
        assert_int_equal(5U, size);
        assert_memory_equal("again", octets, size);
        assert_int_equal(i + 1U, flow.counters.received);
    }
    will_return(__wrap_osal_mqueue_receive, "");
    will_return(__wrap_osal_mqueue_receive, STATUS_EMPTY);
    assert_int_equal(STATUS_EMPTY, flow_mqueue_receive(&flow, octets, sizeof octets, &size));
    assert_true(flow_mqueue_is_open(&flow));
    expect_function_call(__wrap_osal_mqueue_close);
    expect_function_call(__wrap_osal_mqueue_remove);
    will_return(__wrap_osal_mqueue_remove, STATUS_NOT_FOUND);
    flow_mqueue_close(&flow);
}

static void say(const status_t returned, const status_t expected)
{
    static const uint8_t words[] = {1U, 2U, 3U};
    expect_value(__wrap_osal_mqueue_send, octets, (uintptr_t)words);
    expect_value(__wrap_osal_mqueue_send, size, sizeof words);
    will_return(__wrap_osal_mqueue_send, returned);
    assert_int_equal(expected, flow_mqueue_send(&flow, words, sizeof words));
}

static void a_queue_that_fails_to_send_is_closed_and_a_full_one_is_not(void** state)
{
    (void)state;
    begin(false);
    sender_opens(0U);
    say(STATUS_OK, STATUS_OK);
    say(STATUS_FULL, STATUS_FULL);
    assert_true(flow_mqueue_is_open(&flow));
    expect_function_call(__wrap_osal_mqueue_close);
    say(STATUS_CLOSED, STATUS_CLOSED);
    assert_lost(STATUS_CLOSED, 1U);
    sender_opens(10U * RETRY_NS);
    expect_function_call(__wrap_osal_mqueue_close);
    say(STATUS_IO, STATUS_CLOSED);
    assert_lost(STATUS_IO, 2U);
    assert_int_equal(1U, flow.counters.sent);
    assert_int_equal(3U, flow.counters.refused);
}

static void an_attempt_that_fails_gives_back_what_it_has_taken(void** state)
{
    (void)state;
    begin(false);
    will_return(__wrap_osal_mqueue_open, STATUS_OK);
    will_return(__wrap_osal_mqueue_message_octets, OCTETS - 1U);
    expect_function_call(__wrap_osal_mqueue_close);
    assert_int_equal(STATUS_CLOSED, flow_mqueue_step(&flow, 0U));
    assert_lost(STATUS_INVALID, 0U);
    will_return(__wrap_osal_mqueue_open, STATUS_EXHAUSTED);
    expect_function_call(__wrap_osal_mqueue_close);
    assert_int_equal(STATUS_CLOSED, flow_mqueue_step(&flow, 10U * RETRY_NS));
    assert_lost(STATUS_EXHAUSTED, 0U);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_queue_that_fails_to_receive_is_closed_and_opened_again),
        cmocka_unit_test(a_queue_that_fails_to_send_is_closed_and_a_full_one_is_not),
        cmocka_unit_test(an_attempt_that_fails_gives_back_what_it_has_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
