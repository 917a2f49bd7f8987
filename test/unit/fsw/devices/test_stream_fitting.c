// SPDX-License-Identifier: Apache-2.0
// Descriptors that a program with stream devices refuses, with line and reason.
#include "fsw/devices/stream_devices.h"

#include "test/unit/fsw/devices/descriptors.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static subsystem_descriptor_t descriptor;

static bool fits(const char* const document, subsystem_misfit_t* const out_misfit)
{
    static const char* const in[]           = {"COUNT", "VALUE", NULL};
    static const char* const out[]          = {"ENABLE", NULL};
    static const stream_devices_need_t need = {.in          = in,
                                               .out         = out,
                                               .reason_in   = "no IN",
                                               .reason_out  = "no OUT",
                                               .most        = 2U,
                                               .reason_most = "at most 2"};
    load_document(document, &descriptor);
    return stream_devices_fit(&descriptor, &need, out_misfit);
}

static void expect_refused(const char* const document, const uint32_t line, const char* const reason)
{
    subsystem_misfit_t misfit = {0U, "", 0U};
    TEST_ASSERT_FALSE(fits(document, &misfit));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, reason), misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(line, misfit.line);
}

void setUp(void)
{
}

void tearDown(void)
{
}

static void every_end_node_but_can_is_accepted(void)
{
    static const char* const endnodes[] = {
        "type='SHM' name='x'",
        "type='MQUEUE' name='x'",
        "type='UDP' address='h' port='1'",
        "type='TCP' address='h' port='1' framing='LENGTH'",
        "type='SERIAL' name='/dev/x' framing='SLIP'",
        "type='FILE' name='/dev/x' framing='SLIP' direction='BOTH'",
    };
    for (size_t i = 0U; i < (sizeof endnodes / sizeof endnodes[0]); i++) {
        char document[4096];
        subsystem_misfit_t misfit = {0U, "", 0U};
        (void)snprintf(document, sizeof document, BEGIN AXIS("X", "<Endnode %s/>") END, endnodes[i]);
        TEST_ASSERT_TRUE_MESSAGE(fits(document, &misfit), misfit.reason);
    }
}

static void devices_that_cannot_be_reached_are_refused(void)
{
    expect_refused(BEGIN AXIS("X", "") END, 6U, "expected one <Endnode>");
    expect_refused(BEGIN AXIS("X", "<Endnode type='SHM' name='x'/><Endnode type='SHM' name='y'/>") END, 6U,
                   "expected one <Endnode>");
    expect_refused(BEGIN AXIS("X", "<Endnode type='CAN' bus='b' node='3'/>") END, 7U,
                   "expected SHM, MQUEUE, UDP, TCP, SERIAL or FILE");
    expect_refused(BEGIN AXIS("X", "<Endnode type='TCP' address='h' port='1'/>") END, 7U, "LENGTH or SLIP");
    expect_refused(BEGIN AXIS("X", "<Endnode type='SERIAL' name='x' framing='LINE'/>") END, 7U,
                   "LENGTH or SLIP");
    expect_refused(BEGIN AXIS("X", "<Endnode type='FILE' name='x' framing='RAW'/>") END, 7U,
                   "LENGTH or SLIP");
    expect_refused(BEGIN AXIS("X", "<Endnode type='FILE' name='x' framing='SLIP' direction='READ'/>") END, 7U,
                   "direction of <Endnode>");
    expect_refused(BEGIN AXIS("X", "<Endnode type='FILE' name='x' framing='SLIP' direction='WRITE'/>") END,
                   7U, "direction of <Endnode>");
    expect_refused(BEGIN "<Device name='X' type='cia402-drive'/>" END, 6U, "expected \"stream\"");
}

static void two_devices_at_one_end_node_are_refused(void)
{
    expect_refused(BEGIN AXIS("X", "<Endnode type='SHM' name='x'/>")
                       AXIS("Y", "<Endnode type='SHM' name='x'/>") END,
                   9U, "that no device above has");
    expect_refused(BEGIN AXIS("X", "<Endnode type='UDP' address='h' port='1'/>")
                       NEXT_CONFIGURATION AXIS("Y", "<Endnode type='UDP' address='i' port='1'/>") END,
                   11U, "that no device above has");
    subsystem_misfit_t misfit = {0U, "", 0U};
    TEST_ASSERT_TRUE(fits(BEGIN AXIS("X", "<Endnode type='SHM' name='x'/>")
                              AXIS("Y", "<Endnode type='MQUEUE' name='x'/>") END,
                          &misfit));
}

static void missing_fields_and_too_many_fields_or_devices_are_refused(void)
{
    char document[8192] = BEGIN "<Device name='X' type='stream'>"
                                "<Field name='COUNT' direction='IN' type='UINT16'/>"
                                "<Field name='VALUE' direction='IN' type='UINT16'/>"
                                "<Field name='ENABLE' direction='OUT' type='UINT16'/>";
    expect_refused(BEGIN "<Device name='X' type='stream'><Field name='COUNT' direction='IN' type='UINT8'/>"
                         "<Field name='VALUE' direction='OUT' type='UINT8'/>"
                         "<Endnode type='SHM' name='x'/></Device>" END,
                   6U, "no IN");
    expect_refused(BEGIN "<Device name='X' type='stream'><Field name='COUNT' direction='IN' type='UINT8'/>"
                         "<Field name='VALUE' direction='IN' type='UINT8'/>"
                         "<Endnode type='SHM' name='x'/></Device>" END,
                   6U, "no OUT");
    for (unsigned i = 0U; i < 16U; i++) {
        char field[96];
        (void)snprintf(field, sizeof field, "<Field name='F%u' direction='OUT' type='UINT8'/>", i);
        (void)strcat(document, field);
    }
    (void)strcat(document, "<Endnode type='SHM' name='x'/></Device>" END);
    expect_refused(document, 6U, "too many <Field> of one direction, at most 16");
    expect_refused(BEGIN AXIS("X", "<Endnode type='SHM' name='x'/>")
                       AXIS("Y", "<Endnode type='SHM' name='y'/>") AXIS("Z", "<Endnode type='SHM' name='z'/>")
                           END,
                   10U, "at most 2");
}

static bool fits_without_needs(const char* const fields, const char* const endnode)
{
    static const char* const none[]         = {NULL};
    static const stream_devices_need_t need = {
        .in = none, .out = none, .reason_in = "", .reason_out = "", .most = 1U, .reason_most = ""};
    char document[8192];
    subsystem_misfit_t misfit = {0U, "", 0U};
    (void)snprintf(document, sizeof document, BEGIN "<Device name='X' type='stream'>%s%s</Device>" END,
                   fields, endnode);
    load_document(document, &descriptor);
    return stream_devices_fit(&descriptor, &need, &misfit);
}

static void an_end_node_of_one_direction_serves_fields_of_that_direction(void)
{
    static const char in[]     = "<Field name='A' direction='IN' type='UINT8'/>";
    static const char out[]    = "<Field name='A' direction='OUT' type='UINT8'/>";
    static const char reads[]  = "<Endnode type='FILE' name='/x' framing='SLIP' direction='READ'/>";
    static const char writes[] = "<Endnode type='FILE' name='/x' framing='SLIP' direction='WRITE'/>";
    TEST_ASSERT_TRUE(fits_without_needs(in, reads));
    TEST_ASSERT_TRUE(fits_without_needs(out, writes));
    TEST_ASSERT_FALSE(fits_without_needs(in, writes));
    TEST_ASSERT_FALSE(fits_without_needs(out, reads));
}

static void sixteen_fields_of_each_direction_are_accepted(void)
{
    char fields[4096] = "";
    for (unsigned i = 0U; i < 32U; i++) {
        char field[96];
        (void)snprintf(field, sizeof field, "<Field name='F%u' direction='%s' type='UINT8'/>", i,
                       (i < 16U) ? "IN" : "OUT");
        (void)strcat(fields, field);
    }
    TEST_ASSERT_TRUE(fits_without_needs(fields, "<Endnode type='SHM' name='x'/>"));
}

static void more_than_sixteen_input_fields_are_refused(void)
{
    char document[8192] = BEGIN "<Device name='X' type='stream'>"
                                "<Field name='COUNT' direction='IN' type='UINT16'/>"
                                "<Field name='VALUE' direction='IN' type='UINT16'/>"
                                "<Field name='ENABLE' direction='OUT' type='UINT16'/>";
    for (unsigned i = 0U; i < 15U; i++) {
        char field[96];
        (void)snprintf(field, sizeof field, "<Field name='F%u' direction='IN' type='UINT8'/>", i);
        (void)strcat(document, field);
    }
    (void)strcat(document, "<Endnode type='SHM' name='x'/></Device>" END);
    expect_refused(document, 6U, "too many <Field> of one direction, at most 16");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_end_node_but_can_is_accepted);
    RUN_TEST(devices_that_cannot_be_reached_are_refused);
    RUN_TEST(two_devices_at_one_end_node_are_refused);
    RUN_TEST(missing_fields_and_too_many_fields_or_devices_are_refused);
    RUN_TEST(an_end_node_of_one_direction_serves_fields_of_that_direction);
    RUN_TEST(sixteen_fields_of_each_direction_are_accepted);
    RUN_TEST(more_than_sixteen_input_fields_are_refused);
    return UNITY_END();
}
