// SPDX-License-Identifier: Apache-2.0
// Quantities of devices in engineering units, and the logical devices of ST[02] that use them.
#include "fsw/drives/drives_quantity.h"

#include "fsw/drives/drives_access.h"
#include "test/support/subsystem_double.h"
#include "test/unit/fsw/drives/two_nodes.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const char document[] =
    "<Subsystem name='ARM' id='20'><Parameters/><Events/><Functions/>\n"
    "<Configuration name='ONE' id='1' priority='80' samplingTime='500us'><Devices>\n"
    "<Device name='A' type='joint-drive'>\n"
    "<Quantity name='HEAT' id='1' object='0x2210:00' type='INT16' scale='0.1' unit='degC' settable='true'/>\n"
    "<Quantity name='BRAKE' id='2' object='0x2220:00' type='UINT8' scale='1'/>\n"
    "<Quantity name='GAIN' id='3' object='0x2230:01' type='FLOAT' scale='-2' settable='true'/>\n"
    "<Quantity name='COUNT' id='4' object='0x2240:00' type='INT32' scale='1' settable='true'/>\n"
    "<Quantity name='WIDE' id='5' object='0x2250:00' type='INT64' scale='1' settable='true'/>\n"
    "<Quantity name='LARGE' id='6' object='0x2260:00' type='UINT64' scale='1' settable='true'/>\n"
    "<Quantity name='FINE' id='7' object='0x2270:00' type='DOUBLE' scale='0.5' settable='true'/>\n"
    "<Endnode type='CAN' bus='robot' node='0x11'/></Device>\n"
    "<Device name='B' type='joint-drive'><Endnode type='CAN' bus='robot' node='0x12'/></Device>\n"
    "</Devices></Configuration></Subsystem>\n";

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static subsystem_t generic;
static drives_t drives;
static pus_device_port_t port;
static pus_device_result_t result;
static uint8_t octets[DRIVES_QUANTITY_OCTETS];

/// Parse the descriptor with its first `from` replaced by `to`.
static status_t parse(const char* const from, const char* const to)
{
    char text[sizeof document + 64U];
    const char* const found = strstr(document, from);
    TEST_ASSERT_NOT_NULL(found);
    const size_t before = (size_t)(found - document);
    memcpy(text, document, before);
    (void)strcpy(&text[before], to);
    (void)strcat(text, &found[strlen(from)]);
    descriptor_loader_init(&loader);
    return descriptor_parse_subsystem(&loader, "test", text, strlen(text), &descriptor);
}

void setUp(void)
{
    static const subsystem_callbacks_t no_callback = {.emit = NULL};
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, parse("ARM", "ARM"), descriptor_error(&loader));
    double_init(&generic, &descriptor, &no_callback, NULL);
    memset(&result, 0, sizeof result);
    memset(octets, 0, sizeof octets);
    two_nodes_run(&drives);
    drives.generic       = &generic;
    drives.configuration = &descriptor.configurations[0];
    port                 = drives_access_port(&drives);
}

void tearDown(void)
{
}

static const descriptor_quantity_t* quantity(const uint16_t id)
{
    const descriptor_quantity_t* found = NULL;
    TEST_ASSERT_EQUAL(STATUS_OK, drives_quantity_find(&drives, FIRST_NODE, id, &found));
    return found;
}

static const uint8_t* value(const double real)
{
    static uint8_t encoded[DRIVES_QUANTITY_OCTETS];
    uint64_t bits = 0U;
    memcpy(&bits, &real, sizeof bits);
    for (unsigned i = 0U; i < sizeof encoded; i++) {
        encoded[i] = (uint8_t)(bits >> (8U * (7U - i)));
    }
    return encoded;
}

static bool to_object(const uint16_t id, const double real)
{
    return drives_quantity_to_object(quantity(id), value(real), octets);
}

static void quantities_are_found_by_node_and_id(void)
{
    const descriptor_quantity_t* found = quantity(1U);
    TEST_ASSERT_EQUAL_STRING("degC", found->unit);
    TEST_ASSERT_EQUAL_HEX16(0x2210U, found->index);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, drives_quantity_find(&drives, FIRST_NODE, 9U, &found));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, drives_quantity_find(&drives, SECOND_NODE, 1U, &found));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, drives_quantity_find(&drives, 0x111U, 1U, &found));
    drives.configuration = NULL;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, drives_quantity_find(&drives, FIRST_NODE, 1U, &found));
}

static void values_are_rounded_into_objects_that_can_hold_them(void)
{
    static const struct {
        double real;
        uint16_t id;
        bool fits;
        uint8_t expected[2];
    } cases[] = {
        {21.26, 1U, true, {213U, 0U}},      {-21.24, 1U, true, {0x2CU, 0xFFU}},
        {3276.7, 1U, true, {0xFFU, 0x7FU}}, {-3276.8, 1U, true, {0x00U, 0x80U}},
        {3276.8, 1U, false, {0U, 0U}},      {-3276.9, 1U, false, {0U, 0U}},
        {-0.4, 2U, true, {0U, 0U}},         {255.4, 2U, true, {255U, 0U}},
        {255.6, 2U, false, {0U, 0U}},       {-0.6, 2U, false, {0U, 0U}},
        {1e300, 1U, false, {0U, 0U}},       {(double)NAN, 2U, false, {0U, 0U}},
        {1e39, 3U, false, {0U, 0U}},        {-1e39, 3U, false, {0U, 0U}},
        {(double)NAN, 3U, false, {0U, 0U}}, {(double)NAN, 7U, false, {0U, 0U}},
        {DBL_MAX, 7U, false, {0U, 0U}},     {-(double)INFINITY, 7U, false, {0U, 0U}},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        memset(octets, 0, sizeof octets);
        TEST_ASSERT_EQUAL_MESSAGE(cases[i].fits, to_object(cases[i].id, cases[i].real), "fits");
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].expected, octets, 2U);
    }
    TEST_ASSERT_TRUE(to_object(3U, -1.0)); // 0.5 as a FLOAT.
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0U, 0U, 0U, 0x3FU}), octets, 4U);
    TEST_ASSERT_TRUE(to_object(7U, 1e300)); // 2e300 as a DOUBLE.
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x9CU, 0x75U, 0x00U, 0x88U, 0x3CU, 0xE4U, 0x47U, 0x7EU}),
                                 octets, 8U);
}

static void objects_become_values(void)
{
    uint8_t found[DRIVES_QUANTITY_OCTETS];
    drives_quantity_of_object(quantity(1U), (const uint8_t[]){0x06U, 0xFFU}, found); // -250.
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value(-250 * 0.1), found, sizeof found);
    drives_quantity_of_object(quantity(3U), (const uint8_t[]){0U, 0U, 0U, 0x3FU}, found);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value(-1.0), found, sizeof found);
    drives_quantity_of_object(quantity(7U),
                              (const uint8_t[]){0x9AU, 0x99U, 0x99U, 0x99U, 0x99U, 0x99U, 0xB9U, 0x3FU},
                              found); // 0.1.
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value(0.05), found, sizeof found);
    // A device without a measurement: the report contains what the device has sent.
    drives_quantity_of_object(quantity(3U), (const uint8_t[]){0U, 0U, 0x80U, 0xFFU}, found);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value((double)INFINITY), found, sizeof found);
}

/// Fetch the next frame of the device's client and answer it.
static void answer(uint8_t frame[SDO_FRAME_OCTETS], const uint8_t first, const uint8_t low)
{
    canopen_sdo_client_t* const client =
        &drives.buses[0].network.master.nodes[drives.devices[0].device.index].sdo;
    TEST_ASSERT_TRUE(canopen_sdo_client_request(client, 1U, frame));
    const uint8_t reply[SDO_FRAME_OCTETS] = {first, frame[1], frame[2], frame[3], low, 0U, 0U, 0U};
    canopen_sdo_client_answer(client, reply, sizeof reply);
}

static void logical_devices_are_read_and_set(void)
{
    uint8_t frame[SDO_FRAME_OCTETS];
    const pus_device_action_t read = {
        .kind = PUS_DEVICE_LOGICAL_ACQUIRE, .device = FIRST_NODE, .address = 1U};
    const pus_device_action_t set = {.kind    = PUS_DEVICE_LOGICAL_COMMAND,
                                     .device  = FIRST_NODE,
                                     .command = 1U,
                                     .data    = value(30.0),
                                     .size    = DRIVES_QUANTITY_OCTETS};
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &set));
    TEST_ASSERT_EQUAL(STATUS_OK, port.begin(port.context, 0U, &set, &result));
    answer(frame, 0x60U, 0U); // Downloaded. The request: 2 octets (0x2B) to 0x2210:00, 300 = 30.0 degC / 0.1.
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x2B, 0x10, 0x22, 0x00, 0x2C, 0x01}), frame, 6U);
    TEST_ASSERT_EQUAL(STATUS_OK, port.poll(port.context, 0U, &result));
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &read));
    TEST_ASSERT_EQUAL(STATUS_OK, port.begin(port.context, 1U, &read, &result));
    answer(frame, 0x4BU, 100U); // Uploaded: 2 octets.
    TEST_ASSERT_EQUAL(STATUS_OK, port.poll(port.context, 1U, &result));
    TEST_ASSERT_EQUAL_UINT16(DRIVES_QUANTITY_OCTETS, result.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value(100 * 0.1), result.data, DRIVES_QUANTITY_OCTETS);
}

static void an_unknown_or_unsettable_quantity_is_refused(void)
{
    const struct {
        pus_device_action_t action;
        status_t status;
    } cases[] = {
        {{.kind = PUS_DEVICE_LOGICAL_ACQUIRE, .device = SECOND_NODE, .address = 1U}, STATUS_NOT_FOUND},
        {{.kind = PUS_DEVICE_LOGICAL_ACQUIRE, .device = FIRST_NODE, .address = 0x10001U}, // Id 1 in 16 bit.
         STATUS_OUT_OF_RANGE},
        {{.kind    = PUS_DEVICE_LOGICAL_COMMAND,
          .device  = FIRST_NODE,
          .command = 2U,
          .data    = value(1.0),
          .size    = 8U},
         STATUS_OUT_OF_RANGE},
        {{.kind    = PUS_DEVICE_LOGICAL_COMMAND,
          .device  = FIRST_NODE,
          .command = 1U,
          .data    = value(1.0),
          .size    = 7U},
         STATUS_OUT_OF_RANGE},
        {{.kind = PUS_DEVICE_SWITCH, .device = FIRST_NODE}, STATUS_NOT_FOUND},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL(cases[i].status, port.check(port.context, &cases[i].action));
    }
    TEST_ASSERT_FALSE(to_object(1U, 1e9));
}

static void wrong_lines_of_a_descriptor_are_reported(void)
{
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("scale='0.1'", "scale='0'"));
    TEST_ASSERT_NOT_NULL(strstr(descriptor_error(&loader), "a number other than 0"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("scale='0.1'", "scale='one'"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("type='INT16'", "type='BOOL'"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("0x2210:00", "2210"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parse("id='2'", "id='1'"));
}

static void the_limits_of_each_range_can_be_set(void)
{
    static const struct {
        double real;
        uint16_t id;
        bool fits;
    } cases[] = {{3276.74, 1U, true},
                 {3276.75, 1U, false},
                 {-3276.84, 1U, true},
                 {-3276.86, 1U, false},
                 {0.0, 2U, true},
                 {255.0, 2U, true},
                 {-0.49, 2U, true},
                 {-0.51, 2U, false},
                 {6.8e38, 3U, true},
                 {-6.8e38, 3U, true},
                 {6.9e38, 3U, false},
                 {-6.9e38, 3U, false},
                 {2.0 * (double)FLT_MAX, 3U, true},
                 {-2.0 * (double)FLT_MAX, 3U, true},
                 {-0.5, 2U, false},
                 {255.5, 2U, false}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(cases[i].fits, to_object(cases[i].id, cases[i].real), "fits");
    }
}

/// The sum of one half and 0.49999999999999994, or a number above 2^52, is not exact.
static void halves_are_rounded_away_from_zero(void)
{
    static const struct {
        double real;
        uint16_t id;
        bool fits;
        uint64_t bits;
    } cases[] = {{0.49999999999999994, 4U, true, 0U},
                 {-0.49999999999999994, 4U, true, 0U},
                 {0.5, 4U, true, 1U},
                 {-0.5, 4U, true, 0xFFFFFFFFU},
                 {-2.5, 4U, true, 0xFFFFFFFDU},
                 {2147483646.5, 4U, true, 0x7FFFFFFFU},
                 {2147483647.4999998, 4U, true, 0x7FFFFFFFU},
                 {2147483647.5, 4U, false, 0U},
                 {-2147483648.4999995, 4U, true, 0x80000000U},
                 {-2147483648.5, 4U, false, 0U},
                 {0.49999999999999994, 6U, true, 0U},
                 {-0.49999999999999994, 6U, true, 0U},
                 {-0.5, 6U, false, 0U},
                 {4503599627370497.0, 5U, true, 0x10000000000001U},
                 {-4503599627370497.0, 5U, true, 0xFFEFFFFFFFFFFFFFU},
                 {9007199254740991.0, 6U, true, 0x1FFFFFFFFFFFFFU},
                 {-9223372036854775808.0, 5U, true, 0x8000000000000000U},
                 {9223372036854775808.0, 5U, false, 0U},
                 {9223372036854775808.0, 6U, true, 0x8000000000000000U},
                 {18446744073709551616.0, 6U, false, 0U},
                 {(double)NAN, 4U, false, 0U},
                 {(double)INFINITY, 5U, false, 0U}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        uint8_t expected[DRIVES_QUANTITY_OCTETS] = {0U};
        for (unsigned k = 0U; k < sizeof expected; k++) {
            expected[k] = (uint8_t)(cases[i].bits >> (8U * k));
        }
        memset(octets, 0, sizeof octets);
        TEST_ASSERT_EQUAL_MESSAGE(cases[i].fits, to_object(cases[i].id, cases[i].real), "fits");
        TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, octets, sizeof expected);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(quantities_are_found_by_node_and_id);
    RUN_TEST(values_are_rounded_into_objects_that_can_hold_them);
    RUN_TEST(objects_become_values);
    RUN_TEST(logical_devices_are_read_and_set);
    RUN_TEST(an_unknown_or_unsettable_quantity_is_refused);
    RUN_TEST(wrong_lines_of_a_descriptor_are_reported);
    RUN_TEST(the_limits_of_each_range_can_be_set);
    RUN_TEST(halves_are_rounded_away_from_zero);
    return UNITY_END();
}
