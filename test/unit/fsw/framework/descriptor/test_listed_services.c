// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/descriptor.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

#include <stdio.h>
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

/// Load the correct document with these lines of services.
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
    // The storage of these services is compiled into the program.
    TEST_ASSERT_TRUE((without != with) && (with != arm.interface_hash));
}

static status_t load_supervisor(const char* const service)
{
    char text[256] = "<Subsystem name='S' id='1'><Services>\n";
    (void)strcat(strcat(text, service), "</Services></Subsystem>");
    return descriptor_parse_subsystem(&loader, "supervisor.xml", text, strlen(text), &arm);
}

static void the_supervisor_is_granted_entries_of_the_services_of_the_spacecraft(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, load_supervisor(""));
    const uint64_t without = arm.interface_hash;
    TEST_ASSERT_EQUAL(STATUS_OK, load_supervisor("<Service type='11'/>"));
    TEST_ASSERT_TRUE(arm.services[0].is_of_spacecraft);
    TEST_ASSERT_EQUAL_UINT16(DESCRIPTOR_TIME_ACTIVITIES_MAX, arm.services[0].capacity);
    TEST_ASSERT_EQUAL(STATUS_OK, load_supervisor("<Service type='11' capacity='7'/>"));
    TEST_ASSERT_EQUAL_UINT16(7U, arm.services[0].capacity);
    TEST_ASSERT_TRUE(without == arm.interface_hash); // The storage does not depend on this number.
    TEST_ASSERT_EQUAL(STATUS_INVALID, load_supervisor("<Service type='15' capacity='9'/>"));
    TEST_ASSERT_EQUAL_STRING("supervisor.xml:2: capacity=\"9\" of <Service>: expected a number from 1 to 8",
                             descriptor_error(&loader));
}

static void each_service_has_its_type_and_its_largest_capacity(void)
{
    static const struct {
        unsigned type;
        unsigned most;       // Capacity.
        unsigned functional; // Largest functional capacity; 0 if the service has none.
        bool is_of_spacecraft;
    } services[] = {{2U, 16U, 0U, false},
                    {4U, 256U, 0U, false},
                    {6U, 16U, 0U, false},
                    {12U, 2000U, 200U, false},
                    {11U, DESCRIPTOR_TIME_ACTIVITIES_MAX, 0U, true},
                    {15U, DESCRIPTOR_PACKET_STORES_MAX, 0U, true},
                    {18U, DESCRIPTOR_PROCEDURES_MAX, 0U, true},
                    {19U, DESCRIPTOR_EVENT_ACTIONS_MAX, 0U, true},
                    {21U, DESCRIPTOR_SEQUENCES_MAX, 0U, true},
                    {22U, DESCRIPTOR_POSITION_ACTIVITIES_MAX, 0U, true},
                    {23U, DESCRIPTOR_FILE_LOCKS_MAX, 0U, true}};
    for (size_t i = 0U; i < (sizeof services / sizeof services[0]); i++) {
        for (unsigned more = 0U; more < 2U; more++) {
            char line[96];
            (void)snprintf(line, sizeof line, "<Service type='%u' capacity='%u'/>", services[i].type,
                           services[i].most + more);
            TEST_ASSERT_EQUAL_MESSAGE((more == 0U) ? STATUS_OK : STATUS_INVALID, load_supervisor(line), line);
            if (more == 0U) {
                TEST_ASSERT_EQUAL_UINT8(services[i].type, arm.services[0].type);
                TEST_ASSERT_EQUAL_UINT16(services[i].most, arm.services[0].capacity);
                TEST_ASSERT_EQUAL(services[i].is_of_spacecraft, arm.services[0].is_of_spacecraft);
            }
            (void)snprintf(line, sizeof line, "<Service type='%u' functional='%u'/>", services[i].type,
                           services[i].functional + more);
            const bool is_good = (services[i].functional > 0U) && (more == 0U);
            TEST_ASSERT_EQUAL_MESSAGE(is_good ? STATUS_OK : STATUS_INVALID, load_supervisor(line), line);
        }
    }
}

static void a_service_without_attributes_has_its_usual_capacity(void)
{
    static const unsigned services[][3] = {{2U, 4U, 0U}, {4U, 16U, 0U}, {6U, 4U, 0U}, {12U, 32U, 4U}};
    for (size_t i = 0U; i < (sizeof services / sizeof services[0]); i++) {
        char line[32];
        (void)snprintf(line, sizeof line, "<Service type='%u'/>", services[i][0]);
        TEST_ASSERT_EQUAL(STATUS_OK, load_with(line));
        TEST_ASSERT_EQUAL_UINT16(services[i][1], arm.services[0].capacity);
        TEST_ASSERT_EQUAL_UINT16(services[i][2], arm.services[0].functional);
    }
}

static void an_error_in_a_service_list_is_reported_with_its_line(void)
{
    static const struct {
        const char* services;
        const char* error;
    } cases[] = {
        {"<Service type='7'/>", "arm.xml:25: type=\"7\" of <Service>: expected one of "},
        {"<Service/>", "arm.xml:25: <Service> needs attribute type"},
        {"<Service type='6' capacity='0'/>",
         "arm.xml:25: capacity=\"0\" of <Service>: expected a number from 1"},
        {"<Service type='6' functional='1'/>", "arm.xml:25: service 6 cannot have attribute functional"},
        {"<Service type='11'/>", "arm.xml:25: only the supervisor (id 1) can have service 11"},
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
    RUN_TEST(the_supervisor_is_granted_entries_of_the_services_of_the_spacecraft);
    RUN_TEST(each_service_has_its_type_and_its_largest_capacity);
    RUN_TEST(a_service_without_attributes_has_its_usual_capacity);
    RUN_TEST(an_error_in_a_service_list_is_reported_with_its_line);
    return UNITY_END();
}
