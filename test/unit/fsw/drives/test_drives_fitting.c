// SPDX-License-Identifier: Apache-2.0
// Devices that a subsystem cannot drive are refused with their line before it starts.
#include "fsw/drives/drives_fitting.h"

#include "fsw/framework/descriptor/descriptor.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define BEGIN                                                                                                \
    "<Subsystem name='ARM' id='16'>\n<Configuration name='C' id='1' priority='1' "                           \
    "samplingTime='1ms'>\n<Devices>\n"
#define END "</Devices></Configuration>\n</Subsystem>"
#define MODE "<Setting object='0x6060:00' type='INT8' value='10'/>\n"
#define ENDNODE(more) "<Endnode type='CAN' bus='robot'" more "/></Device>\n"
#define DEVICE(name, node) "<Device name='" name "' type='cia402-drive'>\n" MODE ENDNODE(" node='" node "'")

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static subsystem_misfit_t misfit;

static bool fits(const char* document)
{
    static const int modes[]         = {10, 8, 0};
    static const drives_need_t joint = {"cia402-drive", "type", 2U, "count", modes, "mode"};
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK, descriptor_parse_subsystem(&loader, "arm.xml", document, strlen(document), &descriptor),
        descriptor_error(&loader));
    misfit = (subsystem_misfit_t){0U, ""};
    return drives_fit(&descriptor, &joint, &misfit);
}

static void expect_refused(const char* document, uint32_t line, const char* says)
{
    TEST_ASSERT_FALSE_MESSAGE(fits(document), says);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.says, says), misfit.says);
    TEST_ASSERT_EQUAL_UINT32(line, misfit.line);
}

void setUp(void)
{
    descriptor_loader_init(&loader);
}

void tearDown(void)
{
}

static void two_drives_on_one_bus_fit(void)
{
    TEST_ASSERT_TRUE(fits(BEGIN DEVICE("A", "0x11") DEVICE("B", "0x12") END));
}

static void one_drive_is_refused_where_two_are_needed(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") END, 2U, "count");
}

static void another_class_is_refused(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='gyro'>\n" MODE ENDNODE(" node='0x12'")
                       END,
                   7U, "type");
}

static void another_mode_is_refused_and_so_are_two(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='cia402-drive'>\n" ENDNODE(" node='0x12'")
                       END,
                   7U, "mode");
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='cia402-drive'>\n"
                                             "<Setting object='0x6060:00' type='INT8' value='8'/>\n" ENDNODE(
                                                 " node='0x12'") END,
                   7U, "mode");
}

static void every_device_has_one_end_node_on_can(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='cia402-drive'/>" END, 7U,
                   "has no <Endnode");
    static const char* const others[] = {"type='SHM' name='x'", "type='UDP' address='127.0.0.1' port='9'",
                                         "type='SERIAL' name='/dev/ttyS0'", "type='FILE' name='/dev/adc0'"};
    for (unsigned i = 0U; i < 4U; i++) {
        char document[1024];
        (void)snprintf(
            document, sizeof document,
            BEGIN DEVICE("A", "0x11") "<Device name='B' type='cia402-drive'>\n<Endnode %s/></Device>" END,
            others[i]);
        expect_refused(document, 8U, "type of <Endnode>: expected CAN");
    }
    expect_refused(
        BEGIN "<Device name='A' type='cia402-drive'>\n<Endnode type='CAN' bus='robot' node='1'/>\n" ENDNODE(
            " node='2'") END,
        6U, "a second <Endnode>");
}

static void all_devices_are_on_one_bus(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='cia402-drive'>\n"
                                             "<Endnode type='CAN' bus='other' node='0x12'/></Device>" END,
                   8U, "bus of <Endnode>");
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='cia402-drive'>\n" ENDNODE(
                       " redundantBus='robot-b' node='0x12'") END,
                   8U, "bus of <Endnode>");
}

static void a_bus_has_room_for_four_nodes_of_all_configurations(void)
{
    expect_refused(BEGIN DEVICE("A", "1") DEVICE("B", "2") DEVICE("C", "3") DEVICE("D", "4") DEVICE("E", "5")
                       END,
                   16U, "too many nodes");
    static const char again[] = BEGIN DEVICE("A", "1")
        DEVICE("B", "2") "</Devices></Configuration><Configuration name='D' id='2' priority='1' "
                         "samplingTime='1ms'><Devices>" DEVICE("A", "1") DEVICE("B", "2") END;
    TEST_ASSERT_TRUE(fits(again));
}

static void a_device_has_room_for_its_settings(void)
{
    char document[8192] = BEGIN DEVICE("A", "1") "<Device name='B' type='cia402-drive'>\n";
    for (unsigned i = 0U; i < 33U; i++) {
        (void)strcat(document, MODE);
    }
    (void)strcat(document, ENDNODE(" node='0x12'") END);
    expect_refused(document, 7U, "too many <Setting>");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(two_drives_on_one_bus_fit);
    RUN_TEST(one_drive_is_refused_where_two_are_needed);
    RUN_TEST(another_class_is_refused);
    RUN_TEST(another_mode_is_refused_and_so_are_two);
    RUN_TEST(every_device_has_one_end_node_on_can);
    RUN_TEST(all_devices_are_on_one_bus);
    RUN_TEST(a_bus_has_room_for_four_nodes_of_all_configurations);
    RUN_TEST(a_device_has_room_for_its_settings);
    return UNITY_END();
}
