// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/descriptor.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

#include <string.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t arm;

void setUp(void)
{
    descriptor_loader_init(&loader);
}

void tearDown(void)
{
}

/// Load the good document with these lines of services.
static status_t load_with(const char* const services)
{
    char replacement[256] = "</Functions><Services>";
    (void)strcat(strcat(replacement, services), "</Services>");
    const char* const text = damaged(arm_document, "</Functions>", replacement);
    return descriptor_parse_subsystem(&loader, "arm.xml", text, strlen(text), &arm);
}

static void services_are_read_with_their_capacities(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load_with(""));
    TEST_ASSERT_EQUAL_UINT16(0U, arm.service_count);
    const uint64_t without = arm.interface_hash;
    TEST_ASSERT_EQUAL(STATUS_OK, load_with("<Service type='6'/>"));
    TEST_ASSERT_EQUAL_UINT16(1U, arm.service_count);
    TEST_ASSERT_EQUAL_UINT8(6U, arm.services[0].type);
    TEST_ASSERT_EQUAL_UINT16(4U, arm.services[0].capacity);
    TEST_ASSERT_EQUAL_UINT16(0U, arm.services[0].functional);
    const uint64_t with = arm.interface_hash;
    TEST_ASSERT_EQUAL(STATUS_OK, load_with("<Service type='6' capacity='16'/>"));
    TEST_ASSERT_EQUAL_UINT16(16U, arm.services[0].capacity);
    TEST_ASSERT_TRUE((without != with) && (with != arm.interface_hash)); // Their storage is compiled.
}

static status_t load_supervisor(const char* const service)
{
    char text[256] = "<Subsystem name='S' id='1'><Services>\n";
    (void)strcat(strcat(text, service), "</Services></Subsystem>");
    return descriptor_parse_subsystem(&loader, "supervisor.xml", text, strlen(text), &arm);
}

static void the_supervisor_is_granted_entries_of_the_whole_spacecrafts(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load_supervisor(""));
    const uint64_t without = arm.interface_hash;
    TEST_ASSERT_EQUAL(STATUS_OK, load_supervisor("<Service type='11'/>"));
    TEST_ASSERT_TRUE(arm.services[0].is_of_spacecraft);
    TEST_ASSERT_EQUAL_UINT16(DESCRIPTOR_TIME_ACTIVITIES_MAX, arm.services[0].capacity);
    TEST_ASSERT_EQUAL(STATUS_OK, load_supervisor("<Service type='11' capacity='7'/>"));
    TEST_ASSERT_EQUAL_UINT16(7U, arm.services[0].capacity);
    TEST_ASSERT_TRUE(without == arm.interface_hash); // Their storage does not depend on it.
    TEST_ASSERT_EQUAL(STATUS_INVALID, load_supervisor("<Service type='15' capacity='9'/>"));
    TEST_ASSERT_EQUAL_STRING("supervisor.xml:2: capacity=\"9\" of <Service>: expected a number from 1 to 8",
                             descriptor_error(&loader));
}

static void an_error_in_a_service_list_is_reported_with_its_line(void)
{
    static const struct {
        const char* services;
        const char* error;
    } cases[] = {
        {"<Service type='7'/>", "arm.xml:25: type=\"7\" of <Service>: expected one of "},
        {"<Service/>", "arm.xml:25: <Service> has no attribute type"},
        {"<Service type='6' capacity='0'/>",
         "arm.xml:25: capacity=\"0\" of <Service>: expected a number from 1"},
        {"<Service type='6' functional='1'/>", "arm.xml:25: service 6 has no attribute functional"},
        {"<Service type='11'/>", "arm.xml:25: service 11 is the supervisor's, which has id 1"},
        {"<Service type='6'/>\n<Service type='6'/>", "arm.xml:26: type 6 is taken in line 25"},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, load_with(cases[i].services));
        TEST_ASSERT_EQUAL_STRING_LEN(cases[i].error, descriptor_error(&loader), strlen(cases[i].error));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(services_are_read_with_their_capacities);
    RUN_TEST(the_supervisor_is_granted_entries_of_the_whole_spacecrafts);
    RUN_TEST(an_error_in_a_service_list_is_reported_with_its_line);
    return UNITY_END();
}
