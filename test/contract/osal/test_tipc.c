// SPDX-License-Identifier: Apache-2.0
// TIPC on a system that may lack it, for both ports of osal. posix/test_tipc.c tests messages.
#include "osal/include/osal/tipc.h"

#include "unity.h"

#define TYPE 70000U

static osal_socket_t sock;

void setUp(void)
{
    sock = (osal_socket_t){.descriptor = 7777}; // A call that opens it sets its descriptor.
}

void tearDown(void)
{
    osal_socket_close(&sock);
}

/// Open a socket without a name, and sockets of both kinds and scopes with a name: all of them, or none.
static void all_sockets_open_or_none(void)
{
    static const osal_tipc_name_t name = {TYPE, 3U};
    const status_t expected            = osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE);
    TEST_ASSERT_TRUE((expected == STATUS_OK) || (expected == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL(expected == STATUS_OK, osal_socket_is_open(&sock));
    osal_socket_close(&sock);
    for (int kind = OSAL_TIPC_MESSAGE; kind <= OSAL_TIPC_SAMPLE; kind++) {
        for (int scope = OSAL_TIPC_NODE; scope <= OSAL_TIPC_CLUSTER; scope++) {
            TEST_ASSERT_EQUAL(expected,
                              osal_tipc_open(&sock, (osal_tipc_kind_t)kind, &name, (osal_tipc_scope_t)scope));
            TEST_ASSERT_EQUAL(expected == STATUS_OK, osal_socket_is_open(&sock));
            osal_socket_close(&sock);
        }
    }
}

static void a_watch_without_names_has_no_event(void)
{
    osal_tipc_event_t event;
    const status_t status = osal_tipc_watch_open(&sock, TYPE);
    TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL(status == STATUS_OK, osal_socket_is_open(&sock));
    if (status == STATUS_OK) {
        TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tipc_watch_next(&sock, &event));
    }
}

static void a_closed_socket_carries_nothing(void)
{
    const osal_tipc_name_t to = {TYPE, 1U};
    uint8_t octet             = 1U;
    uint64_t from             = 0U;
    size_t size               = 7U;
    sock                      = (osal_socket_t)OSAL_SOCKET_CLOSED;
    status_t status           = osal_tipc_send(&sock, to, &octet, 1U);
    TEST_ASSERT_TRUE((status == STATUS_IO) || (status == STATUS_UNSUPPORTED));
    status = osal_tipc_receive(&sock, &from, &octet, 1U, &size);
    TEST_ASSERT_TRUE((status == STATUS_IO) || (status == STATUS_UNSUPPORTED));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    status = osal_tipc_identity(&sock, &from);
    TEST_ASSERT_TRUE((status == STATUS_IO) || (status == STATUS_UNSUPPORTED));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(all_sockets_open_or_none);
    RUN_TEST(a_watch_without_names_has_no_event);
    RUN_TEST(a_closed_socket_carries_nothing);
    return UNITY_END();
}
