// SPDX-License-Identifier: Apache-2.0
// Devices that a subsystem cannot operate are refused with their line before the start.
#include "fsw/drives/drives.h"
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
#define DEVICE(name, node) "<Device name='" name "' type='joint-drive'>\n" MODE ENDNODE(" node='" node "'")

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static subsystem_misfit_t misfit;

static bool fits_count(const char* document, const uint16_t count)
{
    static const int modes[]  = {10, 8, 0};
    const drives_need_t joint = {.axes         = 1U,
                                 .reason_type  = "type",
                                 .count        = count,
                                 .reason_count = "count",
                                 .modes        = modes,
                                 .reason_mode  = "mode"};
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK, descriptor_parse_subsystem(&loader, "arm.xml", document, strlen(document), &descriptor),
        descriptor_error(&loader));
    misfit = (subsystem_misfit_t){0U, "", 0U};
    return drives_fit(&descriptor, &joint, &misfit);
}

static bool fits(const char* document)
{
    return fits_count(document, 2U);
}

static void expect_refused(const char* document, uint32_t line, const char* reason)
{
    TEST_ASSERT_FALSE_MESSAGE(fits(document), reason);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, reason), misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(line, misfit.line);
}

void setUp(void)
{
    descriptor_loader_init(&loader);
}

void tearDown(void)
{
}

static void two_drives_on_one_bus_are_accepted(void)
{
    TEST_ASSERT_TRUE(fits(BEGIN DEVICE("A", "0x11") DEVICE("B", "0x12") END));
}

static void one_drive_is_refused_where_two_are_needed(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") END, 2U, "count");
}

static void another_class_is_refused(void)
{
    expect_refused(
        BEGIN DEVICE("A", "0x11") "<Device name='B' type='gyroscope'>\n" MODE ENDNODE(" node='0x12'") END, 7U,
        "expected a class of descriptors/devices: gyro");
    expect_refused(
        BEGIN DEVICE("A", "0x11") "<Device name='B' type='joystick'>\n" MODE ENDNODE(" node='0x12'") END, 7U,
        "type");
    TEST_ASSERT_EQUAL_STRING("type", misfit.reason);
}

/// An end node on CAN does not help: no object of the program would operate the device.
static void a_stream_device_is_refused_where_none_is_permitted(void)
{
    TEST_ASSERT_FALSE(fits(BEGIN DEVICE("A", "0x11") DEVICE(
        "B", "0x12") "<Device name='C' type='stream'>\n" ENDNODE(" node='0x13'") END));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, "expected a class"), misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(10U, misfit.line);
}

static void a_missing_or_different_mode_is_refused(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n" ENDNODE(" node='0x12'")
                       END,
                   7U, "mode");
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n"
                                             "<Setting object='0x6060:00' type='INT8' value='8'/>\n" ENDNODE(
                                                 " node='0x12'") END,
                   7U, "mode");
}

/// A drive interpolates its set points over 0x60C2: the data sheet of the class has 5 x 10^-4 s.
static bool fits_period(const char* const type, const char* const cycle, const char* const settings)
{
    char document[1024];
    (void)snprintf(document, sizeof document,
                   "<Subsystem name='ARM' id='16'>\n<Configuration name='C' id='1' priority='1' "
                   "samplingTime='%s'>\n<Devices>\n<Device name='A' type='%s'>\n%s\n" ENDNODE(" node='0x11'")
                       END,
                   cycle, type, settings);
    return fits_count(document, 1U);
}

#define CYCLIC_POSITION "<Setting object='0x6060:00' type='INT8' value='8'/>"
#define PERIOD(value) "<Setting object='0x60C2:01' type='UINT8' value='" value "'/>"
#define EXPONENT(value) "<Setting object='0x60C2:02' type='INT8' value='" value "'/>"

static void a_period_of_set_points_that_is_set_is_the_cycle(void)
{
    static const struct {
        const char* cycle;
        const char* settings;
        bool is_accepted;
    } rows[] = {
        {"1ms", CYCLIC_POSITION PERIOD("10"), true},
        {"2ms", CYCLIC_POSITION PERIOD("10"), false},
        {"500us", CYCLIC_POSITION PERIOD("10"), false},
        {"500us", CYCLIC_POSITION PERIOD("10") PERIOD("5"), true},
        {"2ms", CYCLIC_POSITION PERIOD("2") EXPONENT("-3"), true},
        {"2ms", CYCLIC_POSITION PERIOD("2"), false},
        {"1ms", CYCLIC_POSITION EXPONENT("-3"), false},
        {"5ms", CYCLIC_POSITION EXPONENT("-3"), true},
        {"10s", CYCLIC_POSITION PERIOD("1") EXPONENT("1"), true},
        {"10s", CYCLIC_POSITION PERIOD("1") EXPONENT("2"), false},
        {"1ms", CYCLIC_POSITION PERIOD("1") EXPONENT("-7"), false},
        {"100us", CYCLIC_POSITION PERIOD("100") EXPONENT("-6"), true},
        {"2ms", "<Setting object='0x6060:00' type='INT8' value='10'/>" PERIOD("10"), false},
    };
    for (size_t i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(rows[i].is_accepted,
                                  fits_period("joint-drive", rows[i].cycle, rows[i].settings),
                                  rows[i].settings);
        TEST_ASSERT_EQUAL_UINT32(rows[i].is_accepted ? 0U : 5U, misfit.line);
        TEST_ASSERT_TRUE(rows[i].is_accepted || (strstr(misfit.reason, "samplingTime") != NULL));
    }
}

/// The default is at most the cycle, so that the drive reaches each set point before the next one. Other
/// modes hold a set point without interpolation; the class wheel has no such object.
static void a_default_period_of_set_points_is_at_most_the_cycle(void)
{
    TEST_ASSERT_TRUE(fits_period("joint-drive", "500us", CYCLIC_POSITION));
    TEST_ASSERT_TRUE(fits_period("servo-drive", "1ms", CYCLIC_POSITION));
    TEST_ASSERT_FALSE(fits_period("servo-drive", "250us", CYCLIC_POSITION));
    TEST_ASSERT_EQUAL_UINT32(4U, misfit.line);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, "expected samplingTime"), misfit.reason);
    TEST_ASSERT_TRUE(
        fits_period("joint-drive", "250us", "<Setting object='0x6060:00' type='INT8' value='10'/>"));
    TEST_ASSERT_TRUE(fits_period("wheel", "250us", CYCLIC_POSITION));
}

static void every_device_has_one_end_node_on_can(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'/>" END, 7U,
                   "has no <Endnode");
    static const char* const others[] = {"type='SHM' name='x'", "type='UDP' address='127.0.0.1' port='9'",
                                         "type='SERIAL' name='/dev/ttyS0'", "type='FILE' name='/dev/adc0'"};
    for (unsigned i = 0U; i < 4U; i++) {
        char document[1024];
        (void)snprintf(
            document, sizeof document,
            BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n<Endnode %s/></Device>" END,
            others[i]);
        expect_refused(document, 8U, "type of <Endnode>: expected CAN");
    }
    expect_refused(
        BEGIN "<Device name='A' type='joint-drive'>\n<Endnode type='CAN' bus='robot' node='1'/>\n" ENDNODE(
            " node='2'") END,
        6U, "a second <Endnode>");
}

static void each_bus_has_one_channel_b_and_each_node_one_bus(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n" ENDNODE(
                       " redundantBus='robot-b' node='0x12'") END,
                   8U, "redundantBus of <Endnode>");
    expect_refused(BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n"
                                             "<Endnode type='CAN' bus='b' redundantBus='robot' "
                                             "node='0x12'/></Device>" END,
                   8U, "is no channel B");
    expect_refused(BEGIN "<Device name='A' type='joint-drive'>\n" MODE ENDNODE(
                       " redundantBus='b' node='1'") "<Device name='B' type='joint-drive'>\n"
                                                     "<Endnode type='CAN' bus='b' node='2'/></Device>" END,
                   8U, "is no channel B");
    static const char other_bus[] = MODE "<Endnode type='CAN' bus='other' node='0x12'/></Device>";
    char document[2048]           = BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n";
    (void)strcat(strcat(document, other_bus), END);
    TEST_ASSERT_TRUE_MESSAGE(fits(document), misfit.reason);
    expect_refused(BEGIN DEVICE("A", "0x12") "<Device name='B' type='joint-drive'>\n"
                                             "<Endnode type='CAN' bus='other' node='0x12'/></Device>" END,
                   8U, "node of <Endnode>");
}

static void add_device(char* const document, const size_t size, const unsigned node, const char* const bus)
{
    const size_t length = strlen(document);
    (void)snprintf(&document[length], size - length,
                   "<Device name='D%u' type='joint-drive'>\n" MODE
                   "<Endnode type='CAN' bus='%s' node='%u'/></Device>\n",
                   node, bus, node);
}

/// A node that occurs in two configurations counts once.
static void a_bus_has_room_for_sixteen_nodes_of_all_configurations(void)
{
    char document[8192] = BEGIN;
    for (unsigned node = 2U; node < (2U + NETWORK_DEVICES_MAX); node++) {
        add_device(document, sizeof document, node, "robot");
    }
    static char full[8192];
    (void)strcat(strcpy(full, document), END);
    TEST_ASSERT_TRUE_MESSAGE(fits_count(full, NETWORK_DEVICES_MAX), misfit.reason);
    add_device(document, sizeof document, 2U + NETWORK_DEVICES_MAX, "robot");
    (void)strcat(document, END);
    expect_refused(document, 6U + (3U * NETWORK_DEVICES_MAX), "nodes on one bus");
    static const char again[] = BEGIN DEVICE("A", "1")
        DEVICE("B", "2") "</Devices></Configuration><Configuration name='D' id='2' priority='1' "
                         "samplingTime='1ms'><Devices>" DEVICE("A", "1") DEVICE("B", "2") END;
    TEST_ASSERT_TRUE(fits(again));
}

static void a_subsystem_has_room_for_four_buses_and_thirty_two_nodes(void)
{
    static char document[16384];
    static char full[16384];
    static const char* const buses[] = {"a", "b", "c", "d", "e"};
    (void)strcpy(document, BEGIN);
    for (unsigned i = 0U; i < DRIVES_DEVICES_MAX; i++) {
        add_device(document, sizeof document, 2U + i, buses[i % DRIVES_BUSES_MAX]);
    }
    (void)strcat(strcpy(full, document), END);
    TEST_ASSERT_TRUE_MESSAGE(fits_count(full, 0U), misfit.reason);
    add_device(document, sizeof document, 100U, "a");
    (void)strcat(document, END);
    expect_refused(document, 6U + (3U * DRIVES_DEVICES_MAX), "nodes of one subsystem");
    (void)strcpy(document, BEGIN);
    for (unsigned i = 0U; i <= DRIVES_BUSES_MAX; i++) {
        add_device(document, sizeof document, 2U + i, buses[i]);
    }
    (void)strcat(document, END);
    expect_refused(document, 6U + (3U * DRIVES_BUSES_MAX), "buses of one subsystem");
}

/// The same node in another configuration is the same device.
static void two_devices_of_a_configuration_are_not_one_node(void)
{
    expect_refused(BEGIN DEVICE("A", "0x11") DEVICE("B", "0x11") END, 9U, "that no device above has");
    static const char second[] = BEGIN DEVICE("A", "1")
        DEVICE("B", "2") "</Devices></Configuration>\n"
                         "<Configuration name='D' id='2' priority='1' samplingTime='1ms'><Devices>\n" DEVICE(
                             "A", "2") DEVICE("B", "2") END;
    expect_refused(second, 17U, "that no device above has");
    static const int modes[] = {10, 0};
    const drives_need_t need = {1U, false, "type", 0U, "count", modes, "mode", true};
    static const char* const stream_first =
        BEGIN "<Device name='S' type='stream'><Field name='V' direction='IN' type='UINT8'/>"
              "<Endnode type='UDP' address='localhost' port='4000'/></Device>\n" DEVICE("A", "0x11") END;
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK,
        descriptor_parse_subsystem(&loader, "arm.xml", stream_first, strlen(stream_first), &descriptor),
        descriptor_error(&loader));
    TEST_ASSERT_TRUE_MESSAGE(drives_fit(&descriptor, &need, &misfit), misfit.reason);
}

static void at_least_one_device_is_needed(void)
{
    TEST_ASSERT_TRUE(fits_count(BEGIN DEVICE("A", "1") END, 0U));
    TEST_ASSERT_FALSE(fits_count(BEGIN END, 0U));
    TEST_ASSERT_EQUAL_STRING("count", misfit.reason);
}

static void a_device_has_room_for_its_settings(void)
{
    char document[8192] = BEGIN DEVICE("A", "1") "<Device name='B' type='joint-drive'>\n";
    for (unsigned i = 0U; i < 33U; i++) {
        (void)strcat(document, MODE);
    }
    (void)strcat(document, ENDNODE(" node='0x12'") END);
    expect_refused(document, 7U, "too many <Setting>");
}

#define MAPPED(settings)                                                                                     \
    BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n" MODE settings ENDNODE(" node='0x12'") \
        END
#define MAPPED_FIRST(settings)                                                                               \
    BEGIN DEVICE("A", "0x11") "<Device name='B' type='joint-drive'>\n" settings MODE ENDNODE(" node='0x12'") \
        END
#define SET(object, type, value) "<Setting object='" object "' type='" type "' value='" value "'/>\n"
#define DISABLE SET("0x1800:01", "UINT32", "0x80000192") SET("0x1A00:00", "UINT8", "0")

static void a_mapping_that_the_data_sheet_allows_fits(void)
{
    TEST_ASSERT_TRUE(
        fits(MAPPED(DISABLE SET("0x1A00:01", "UINT32", "0x60770010") SET("0x1A00:02", "UINT32", "0x60640020")
                        SET("0x1A00:00", "UINT8", "2") SET("0x1800:01", "UINT32", "0x192"))));
}

#define REMAPPED(name, node)                                                                                 \
    "<Device name='" name "' type='joint-drive'>\n" MODE DISABLE ENDNODE(" node='" node "'")

/// A node counts once, even if several configurations map it.
static void the_number_of_mappings_is_limited(void)
{
    static const char* const nine =
        BEGIN REMAPPED("A", "1") REMAPPED("B", "2") REMAPPED("C", "3") REMAPPED("D", "4") REMAPPED("E", "5")
            REMAPPED("F", "6") REMAPPED("G", "7") REMAPPED("H", "8") REMAPPED("I", "9") END;
    static const char* const twice = BEGIN REMAPPED("A", "1") REMAPPED("B", "2") REMAPPED("C", "3")
        REMAPPED("D", "4") REMAPPED("E", "5") REMAPPED("F", "6") REMAPPED("G", "7") REMAPPED("H", "8")
            DEVICE("I", "9") "</Devices></Configuration>\n<Configuration name='D' id='2' priority='1' "
                             "samplingTime='1ms'>\n<Devices>\n" REMAPPED("A", "1") END;
    TEST_ASSERT_FALSE(fits_count(nine, 0U));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, "devices whose <Setting> changes the mapping"),
                                 misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(8U, misfit.most);
    TEST_ASSERT_EQUAL_UINT32(47U, misfit.line);
    TEST_ASSERT_TRUE_MESSAGE(fits_count(twice, 0U), misfit.reason);
    TEST_ASSERT_TRUE(drives_is_mapped(&descriptor, 8U));
    TEST_ASSERT_FALSE(drives_is_mapped(&descriptor, 9U));
}

static void another_mapping_is_refused_with_its_line(void)
{
    expect_refused(MAPPED(SET("0x1A00:00", "UINT8", "0")), 9U, "order of CiA 301");
    expect_refused(MAPPED_FIRST(SET("0x1A00:00", "UINT8", "0")), 8U, "order of CiA 301");
    TEST_ASSERT_TRUE(drives_is_mapped(&descriptor, 0x12U));
    expect_refused(MAPPED(DISABLE SET("0x1A00:01", "UINT32", "0x10180120")), 11U, "data sheet allows");
    expect_refused(MAPPED(DISABLE SET("0x1A07:00", "UINT8", "0")), 11U, "a PDO of the class");
    expect_refused(MAPPED(DISABLE SET("0x1A00:00", "UINT8", "9")), 11U, "at most 8 entries");
}

static void another_unit_than_that_of_the_class_is_refused(void)
{
    expect_refused(MAPPED(SET("0x60A8:00", "UINT32", "0xFD410000")), 9U, "unit of the data sheet");
    expect_refused(MAPPED(SET("0x60A9:00", "UINT32", "0xFD410300")), 9U, "unit of the data sheet");
    expect_refused(MAPPED_FIRST(SET("0x60A9:00", "UINT32", "0xFD410300")), 8U, "unit of the data sheet");
    TEST_ASSERT_TRUE_MESSAGE(fits(MAPPED(SET("0x60A8:00", "UINT32", "0xFA100000"))), misfit.reason);
    TEST_ASSERT_TRUE_MESSAGE(fits(MAPPED(SET("0x607D:02", "INT32", "1000000"))), misfit.reason);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(two_drives_on_one_bus_are_accepted);
    RUN_TEST(one_drive_is_refused_where_two_are_needed);
    RUN_TEST(another_class_is_refused);
    RUN_TEST(a_stream_device_is_refused_where_none_is_permitted);
    RUN_TEST(a_missing_or_different_mode_is_refused);
    RUN_TEST(a_period_of_set_points_that_is_set_is_the_cycle);
    RUN_TEST(a_default_period_of_set_points_is_at_most_the_cycle);
    RUN_TEST(every_device_has_one_end_node_on_can);
    RUN_TEST(each_bus_has_one_channel_b_and_each_node_one_bus);
    RUN_TEST(a_bus_has_room_for_sixteen_nodes_of_all_configurations);
    RUN_TEST(a_subsystem_has_room_for_four_buses_and_thirty_two_nodes);
    RUN_TEST(two_devices_of_a_configuration_are_not_one_node);
    RUN_TEST(at_least_one_device_is_needed);
    RUN_TEST(a_device_has_room_for_its_settings);
    RUN_TEST(a_mapping_that_the_data_sheet_allows_fits);
    RUN_TEST(the_number_of_mappings_is_limited);
    RUN_TEST(another_mapping_is_refused_with_its_line);
    RUN_TEST(another_unit_than_that_of_the_class_is_refused);
    return UNITY_END();
}
