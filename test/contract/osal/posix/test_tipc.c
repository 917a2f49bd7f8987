// SPDX-License-Identifier: Apache-2.0
// TIPC of this kernel. If the kernel has no TIPC, the test only checks STATUS_UNSUPPORTED; `make test-hil`
// runs it on a kernel with TIPC.
#include "osal/include/osal/tipc.h"
#include "unity.h"

#include <string.h>
#include <unistd.h>

#define OCTETS_MAX 66000U ///< Longest message of the protocol.
#define SOON_MS 5000U
#define INSTANCE 16U
#define OTHER 17U

static osal_socket_t receiver = OSAL_SOCKET_CLOSED;
static osal_socket_t sender   = OSAL_SOCKET_CLOSED;
static osal_socket_t watch    = OSAL_SOCKET_CLOSED;
static uint32_t type;
static uint8_t octets[OCTETS_MAX];
static uint8_t taken[OCTETS_MAX];
static uint64_t from;
static size_t size;

static osal_tipc_name_t name(uint32_t instance)
{
    return (osal_tipc_name_t){type, instance};
}

void setUp(void)
{
    type++;
}

void tearDown(void)
{
    osal_socket_close(&receiver);
    osal_socket_close(&sender);
    osal_socket_close(&watch);
}

static void open_pair(osal_tipc_kind_t kind)
{
    const osal_tipc_name_t own = name(INSTANCE);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&receiver, kind, &own, OSAL_TIPC_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&sender, kind, NULL, OSAL_TIPC_NODE));
}

static void receive(osal_socket_t* sock)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(sock, SOON_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_receive(sock, &from, taken, sizeof taken, &size));
}

static void a_kernel_without_tipc_is_reported(void)
{
    const osal_tipc_name_t own = name(INSTANCE);
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_tipc_open(&receiver, OSAL_TIPC_MESSAGE, &own, OSAL_TIPC_NODE));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED,
                      osal_tipc_open(&receiver, OSAL_TIPC_SAMPLE, NULL, OSAL_TIPC_CLUSTER));
    TEST_ASSERT_EQUAL(STATUS_UNSUPPORTED, osal_tipc_watch_open(&watch, type));
    TEST_ASSERT_FALSE(osal_socket_is_open(&receiver));
    TEST_ASSERT_FALSE(osal_socket_is_open(&watch));
}

static void messages_of_every_size_arrive_whole_and_in_order(void)
{
    static const size_t sizes[] = {1U, 2U, 24U, 1000U, 1500U, 4120U, 65000U, OCTETS_MAX};
    uint64_t identity           = 0U;
    open_pair(OSAL_TIPC_MESSAGE);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_identity(&sender, &identity));
    for (size_t i = 0U; i < (sizeof sizes / sizeof sizes[0]); i++) {
        (void)memset(octets, (int)i + 1, sizes[i]);
        TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_send(&sender, name(INSTANCE), octets, sizes[i]));
    }
    for (size_t i = 0U; i < (sizeof sizes / sizeof sizes[0]); i++) {
        receive(&receiver);
        TEST_ASSERT_EQUAL(sizes[i], size);
        TEST_ASSERT_EACH_EQUAL_UINT8(i + 1U, taken, size);
        TEST_ASSERT_EQUAL_HEX64(identity, from);
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tipc_receive(&receiver, &from, taken, sizeof taken, &size));
}

static void a_message_longer_than_the_protocol_permits_is_refused(void)
{
    static uint8_t longer[OCTETS_MAX + 1U];
    open_pair(OSAL_TIPC_MESSAGE);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_tipc_send(&sender, name(INSTANCE), longer, sizeof longer));
}

static void a_message_longer_than_the_buffer_is_dropped_and_reported(void)
{
    open_pair(OSAL_TIPC_MESSAGE);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_send(&sender, name(INSTANCE), octets, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_send(&sender, name(INSTANCE), octets, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&receiver, SOON_MS));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_tipc_receive(&receiver, &from, taken, 99U, &size));
    receive(&receiver);
    TEST_ASSERT_EQUAL(10U, size);
}

static void a_name_without_a_socket_is_reported(void)
{
    open_pair(OSAL_TIPC_MESSAGE);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_tipc_send(&sender, name(OTHER), octets, 10U));
    osal_socket_close(&receiver);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_tipc_send(&sender, name(INSTANCE), octets, 10U));
}

/// A receiver that does not read: datagrams without room come back. The delivered and the returned datagrams
/// are together all that were sent.
static void messages_that_a_slow_receiver_has_no_room_for_are_returned(void)
{
    unsigned sent     = 0U;
    unsigned returned = 0U;
    unsigned arrived  = 0U;
    open_pair(OSAL_TIPC_MESSAGE);
    while ((sent < 20000U) && (returned == 0U)) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_send(&sender, name(INSTANCE), octets, 4000U));
        sent++;
        const status_t status = osal_tipc_receive(&sender, &from, taken, sizeof taken, &size);
        TEST_ASSERT_TRUE((status == STATUS_EMPTY) || (status == STATUS_FORBIDDEN));
        returned += (status == STATUS_FORBIDDEN) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(1U, returned);
    while (osal_tipc_receive(&receiver, &from, taken, sizeof taken, &size) == STATUS_OK) {
        TEST_ASSERT_EQUAL(4000U, size);
        arrived++;
    }
    TEST_ASSERT_EQUAL(sent, arrived + returned);
}

static void samples_that_have_no_room_are_not_returned_to_the_sender(void)
{
    open_pair(OSAL_TIPC_SAMPLE);
    for (unsigned i = 0U; i < 20000U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_send(&sender, name(INSTANCE), octets, 1000U));
    }
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tipc_receive(&sender, &from, taken, sizeof taken, &size));
    receive(&receiver);
    TEST_ASSERT_EQUAL(1000U, size);
}

static void identities_differ_and_do_not_change(void)
{
    uint64_t one   = 0U;
    uint64_t other = 0U;
    uint64_t again = 0U;
    open_pair(OSAL_TIPC_MESSAGE);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_identity(&receiver, &one));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_identity(&sender, &other));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_identity(&receiver, &again));
    TEST_ASSERT_TRUE(one != other);
    TEST_ASSERT_EQUAL_HEX64(one, again);
}

static void an_adopted_socket_continues(void)
{
    osal_socket_t heir = OSAL_SOCKET_CLOSED;
    open_pair(OSAL_TIPC_MESSAGE);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_adopt(&heir, dup(osal_socket_descriptor(&receiver))));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_send(&sender, name(INSTANCE), octets, 3U));
    receive(&heir);
    TEST_ASSERT_EQUAL(3U, size);
    osal_socket_close(&heir);
}

static void expect_event(bool is_published, uint32_t instance)
{
    osal_tipc_event_t event = {false, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&watch, SOON_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_watch_next(&watch, &event));
    TEST_ASSERT_EQUAL(is_published, event.is_published);
    TEST_ASSERT_EQUAL(instance, event.instance);
}

static void names_that_appear_and_disappear_are_reported(void)
{
    const osal_tipc_name_t other = name(OTHER);
    osal_tipc_event_t event      = {false, 0U};
    open_pair(OSAL_TIPC_MESSAGE);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_watch_open(&watch, type));
    expect_event(true, INSTANCE); // The name existed before the watch.
    osal_socket_close(&sender);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&sender, OSAL_TIPC_MESSAGE, &other, OSAL_TIPC_NODE));
    expect_event(true, OTHER);
    osal_socket_close(&receiver);
    expect_event(false, INSTANCE);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tipc_watch_next(&watch, &event));
}

int main(void)
{
    type = 0x60000000U + (((uint32_t)getpid() & 0x000FFFFFU) << 4U);
    UNITY_BEGIN();
    if (osal_tipc_open(&receiver, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE) == STATUS_UNSUPPORTED) {
        RUN_TEST(a_kernel_without_tipc_is_reported);
        return UNITY_END();
    }
    osal_socket_close(&receiver);
    RUN_TEST(messages_of_every_size_arrive_whole_and_in_order);
    RUN_TEST(a_message_longer_than_the_protocol_permits_is_refused);
    RUN_TEST(a_message_longer_than_the_buffer_is_dropped_and_reported);
    RUN_TEST(a_name_without_a_socket_is_reported);
    RUN_TEST(messages_that_a_slow_receiver_has_no_room_for_are_returned);
    RUN_TEST(samples_that_have_no_room_are_not_returned_to_the_sender);
    RUN_TEST(identities_differ_and_do_not_change);
    RUN_TEST(an_adopted_socket_continues);
    RUN_TEST(names_that_appear_and_disappear_are_reported);
    return UNITY_END();
}
