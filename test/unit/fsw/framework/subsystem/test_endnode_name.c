// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/endnode_name.h"

#include "unity.h"

#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void every_type_has_its_kind_and_name(void)
{
    static const struct {
        descriptor_endnode_t endnode;
        flow_endnode_kind_t kind;
        const char* name;
    } cases[] = {
        {{.type = DESCRIPTOR_ENDNODE_CAN, .bus = "robot", .name = ""}, ENDNODE_CAN, "robot"},
        {{.type = DESCRIPTOR_ENDNODE_SHM, .name = "image"}, ENDNODE_SHM, "image"},
        {{.type = DESCRIPTOR_ENDNODE_MQUEUE, .name = "work"}, ENDNODE_MQUEUE, "work"},
        {{.type = DESCRIPTOR_ENDNODE_UDP, .address = "10.0.0.1", .port = 65535U},
         ENDNODE_UDP,
         "10.0.0.1:65535"},
        {{.type = DESCRIPTOR_ENDNODE_TCP, .address = "127.0.0.1", .port = 1U}, ENDNODE_TCP, "127.0.0.1:1"},
        {{.type = DESCRIPTOR_ENDNODE_SERIAL, .name = "/dev/ttyS0"}, ENDNODE_SERIAL, "/dev/ttyS0"},
        {{.type = DESCRIPTOR_ENDNODE_FILE, .name = "/dev/adc0"}, ENDNODE_FILE, "/dev/adc0"},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        char name[ENDNODE_ADDRESS_MAX];
        flow_endnode_kind_t kind = ENDNODE_CAN;
        TEST_ASSERT_EQUAL(STATUS_OK, subsystem_endnode_name(&cases[i].endnode, &kind, name));
        TEST_ASSERT_EQUAL(cases[i].kind, kind);
        TEST_ASSERT_EQUAL_STRING(cases[i].name, name);
    }
}

static void a_name_that_no_flow_takes_is_refused(void)
{
    char words[ENDNODE_ADDRESS_MAX + 1U];
    char name[ENDNODE_ADDRESS_MAX];
    flow_endnode_kind_t kind           = ENDNODE_CAN;
    const descriptor_endnode_t endnode = {.type = DESCRIPTOR_ENDNODE_FILE, .name = words};
    memset(words, 'x', sizeof words);
    words[ENDNODE_ADDRESS_MAX - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_OK, subsystem_endnode_name(&endnode, &kind, name));
    words[ENDNODE_ADDRESS_MAX - 1U] = 'x';
    words[ENDNODE_ADDRESS_MAX]      = '\0';
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, subsystem_endnode_name(&endnode, &kind, name));
    TEST_ASSERT_EQUAL_STRING("", name);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_type_has_its_kind_and_name);
    RUN_TEST(a_name_that_no_flow_takes_is_refused);
    return UNITY_END();
}
