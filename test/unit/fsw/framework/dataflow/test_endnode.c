// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/endnode.h"

#include "unity.h"

#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void addresses_are_read(void)
{
    const struct {
        const char* text;
        uint32_t ipv4;
        uint16_t port;
    } good[] = {{"127.0.0.1:10015", 0x7F000001U, 10015U},
                {"0.0.0.0:0", 0U, 0U},
                {"255.255.255.255:65535", 0xFFFFFFFFU, 65535U},
                {"10.0.002.3:00080", 0x0A000203U, 80U}};
    for (unsigned i = 0U; i < (sizeof good / sizeof good[0]); i++) {
        osal_address_t address = {0U, 0U};
        TEST_ASSERT_EQUAL(STATUS_OK, flow_endnode_socket_address(good[i].text, &address));
        TEST_ASSERT_EQUAL_HEX32(good[i].ipv4, address.ipv4);
        TEST_ASSERT_EQUAL_UINT16(good[i].port, address.port);
    }
}

static void an_invalid_address_is_refused(void)
{
    const char* const bad[] = {"",
                               "127.0.0.1",
                               "127.0.0.1:",
                               "127.0.0.1:65536",
                               "127.0.0.256:1",
                               "127.0.0:1",
                               "127.0.0.0.1:1",
                               "127.0.0.1:1 ",
                               " 127.0.0.1:1",
                               "127.0.0.1:-1",
                               "127.0.0.1:0x10",
                               "localhost:1",
                               "127..0.1:1",
                               "127.0.0.1:99999999999999999999",
                               "99999999999999999999.0.0.1:1"};
    for (unsigned i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        osal_address_t address = {1U, 2U};
        TEST_ASSERT_EQUAL_MESSAGE(STATUS_INVALID, flow_endnode_socket_address(bad[i], &address), bad[i]);
        TEST_ASSERT_EQUAL_HEX32(1U, address.ipv4);
    }
}

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    if (strcmp(name, "endless") == 0) {
        memset(out_address->address, 'x', sizeof out_address->address);
        return STATUS_OK;
    }
    if ((kind != ENDNODE_CAN) || (strcmp(name, "robot") != 0)) {
        return STATUS_INVALID;
    }
    (void)strcpy(out_address->address, "shm:somewhere");
    return STATUS_OK;
}

static void an_unknown_name_is_not_found_and_an_unterminated_address_is_invalid(void)
{
    const flow_resolver_t resolver = {NULL, resolve};
    flow_endnode_address_t address;
    memset(&address, 0xFF, sizeof address);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_endnode_resolve(&resolver, ENDNODE_CAN, "robot", &address));
    TEST_ASSERT_EQUAL_STRING("shm:somewhere", address.address);
    TEST_ASSERT_FALSE(address.is_fd);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_endnode_resolve(&resolver, ENDNODE_UDP, "robot", &address));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_endnode_resolve(&resolver, ENDNODE_CAN, "moon", &address));
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_endnode_resolve(&resolver, ENDNODE_CAN, "endless", &address));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(addresses_are_read);
    RUN_TEST(an_invalid_address_is_refused);
    RUN_TEST(an_unknown_name_is_not_found_and_an_unterminated_address_is_invalid);
    return UNITY_END();
}
