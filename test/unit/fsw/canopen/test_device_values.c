// SPDX-License-Identifier: Apache-2.0
// Process data that are not words of an axis: input and output modules (CiA 401), measuring devices (CiA
// 404), manufacturer objects.
#include "fsw/canopen/device.h"
#include "test/support/scripted_bus.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define NODE 0x31U

/// Rate, status octet and a signed manufacturer's value of a gyro, output and on-time of a valve box, with
/// padding between them.
static const canopen_device_profile_t mixed = {
    .type           = "mixed",
    .profile        = 404U,
    .value_count    = 5U,
    .values         = {{0x9130U, 1U, 4U, true, false, 1e-6},
                       {0x6000U, 1U, 1U, false, false, 1.0},
                       {0x2100U, 0U, 2U, true, false, 0.1},
                       {0x6200U, 1U, 1U, false, false, 1.0},
                       {0x2101U, 3U, 3U, false, false, 0.01}},
    .transmit_count = 1U,
    .transmit       = {{.cob_base     = 0x180U,
                        .is_valid     = true,
                        .is_each_sync = true,
                        .entry_count  = 4U,
                        .entries      = {{0x9130U, 1U, 4U, PROFILE_VALUE, 0U},
                                         {0x0005U, 0U, 1U, PROFILE_PADDING, 0U},
                                         {0x6000U, 1U, 1U, PROFILE_VALUE, 1U},
                                         {0x2100U, 0U, 2U, PROFILE_VALUE, 2U}}}},
    .receive_count  = 1U,
    .receive        = {{.cob_base    = 0x200U,
                        .is_valid    = true,
                        .entry_count = 3U,
                        .entries     = {{0x6200U, 1U, 1U, PROFILE_VALUE, 3U},
                                        {0x0006U, 0U, 2U, PROFILE_PADDING, 0U},
                                        {0x2101U, 3U, 3U, PROFILE_VALUE, 4U}}}}};

static scripted_bus_t bus;
static flow_can_t flow;
static canopen_master_t master;
static canopen_device_t device;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, bus.address);
    return STATUS_OK;
}

static const flow_resolver_t resolver       = {NULL, resolve};
static const canopen_master_config_t config = {
    .node_id = 1U, .heartbeat_ns = 20000000U, .heartbeat_timeout_ns = 60000000U, .sdo_timeout_ns = 50000000U};

void setUp(void)
{
    scripted_bus_open(&bus, "test-values");
    (void)scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x7EU); // Another node, which acknowledges frames.
    flow_can_init(&flow);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_can_open(&flow, &resolver, "robot"));
    canopen_master_init(&master, &config, &flow);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_device_attach(&device, &master, &mixed, NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_device_connect(&device));
}

void tearDown(void)
{
    flow_can_close(&flow);
    scripted_bus_close(&bus);
}

static void values_are_found_by_their_object(void)
{
    TEST_ASSERT_EQUAL_UINT8(1U, canopen_device_profile_value(&mixed, 0x6000U, 1U));
    TEST_ASSERT_EQUAL_UINT8(4U, canopen_device_profile_value(&mixed, 0x2101U, 3U));
    TEST_ASSERT_EQUAL_UINT8(PROFILE_NO_VALUE, canopen_device_profile_value(&mixed, 0x2101U, 1U));
    TEST_ASSERT_EQUAL_UINT8(PROFILE_NO_VALUE, canopen_device_profile_value(&mixed, 0x6001U, 1U));
    for (uint8_t i = 0U; i < mixed.value_count; i++) {
        TEST_ASSERT_EQUAL(i >= 3U, canopen_device_profile_is_output(&mixed, i));
    }
}

static void expect(const uint8_t value, const double expected)
{
    TEST_ASSERT_TRUE(fabs(canopen_device_value(&device, value) - expected) <= 1e-9);
}

static void received_values_have_their_sign_and_unit(void)
{
    static const uint8_t octets[8] = {0xC0U, 0xBDU, 0xF0U, 0xFFU, 0xAAU, 0x81U, 0xFEU, 0xFFU};
    scripted_bus_deliver(&bus, 0x180U + NODE, octets, 8U);
    canopen_master_receive(&master, 0U);
    expect(0U, -1.0);
    expect(1U, 129.0);
    expect(2U, -0.2);
    static const uint8_t largest[8] = {0xFFU, 0xFFU, 0xFFU, 0x7FU, 0x00U, 0xFFU, 0xFFU, 0x7FU};
    scripted_bus_deliver(&bus, 0x180U + NODE, largest, 8U);
    canopen_master_receive(&master, 0U);
    expect(0U, 2147.483647);
    expect(1U, 255.0);
    expect(2U, 3276.7);
    scripted_bus_deliver(&bus, 0x180U + NODE, octets, 7U); // A frame of another length is dropped.
    canopen_master_receive(&master, 0U);
    expect(0U, 2147.483647);
    TEST_ASSERT_EQUAL_UINT32(1U, device.malformed);
    canopen_device_reset(&device);
    expect(0U, 0.0);
}

static void sent_values_are_rounded_and_limited_to_their_object(void)
{
    static const struct {
        double outputs;
        double time;
        uint8_t octets[6];
    } cases[] = {{5.0, 0.25, {0x05U, 0U, 0U, 25U, 0U, 0U}},
                 {4.4, 655.364, {0x04U, 0U, 0U, 0x00U, 0x00U, 0x01U}},
                 {-1.0, -3.0, {0x00U, 0U, 0U, 0U, 0U, 0U}},
                 {0.49999999999999994, 0.005, {0x00U, 0U, 0U, 1U, 0U, 0U}},
                 {0.5, 0.0, {0x01U, 0U, 0U, 0U, 0U, 0U}},
                 {1e12, 1e12, {0xFFU, 0U, 0U, 0xFFU, 0xFFU, 0xFFU}},
                 {(double)NAN, (double)INFINITY, {0x00U, 0U, 0U, 0xFFU, 0xFFU, 0xFFU}}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        canopen_device_set_value(&device, 3U, cases[i].outputs);
        canopen_device_set_value(&device, 4U, cases[i].time);
        canopen_device_emit(&device);
        scripted_bus_run(&bus);
        TEST_ASSERT_EQUAL_UINT(1U, bus.seen_count);
        TEST_ASSERT_EQUAL_HEX32(0x200U + NODE, bus.seen[0].id);
        TEST_ASSERT_EQUAL_UINT8(6U, bus.seen[0].length);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].octets, bus.seen[0].data, 6U);
    }
    canopen_device_set_value(&device, 2U, -0.26); // A signed value.
    expect(2U, -0.3);
    canopen_device_set_value(&device, 2U, -1e9);
    expect(2U, -3276.8);
    canopen_device_set_value(&device, 2U, 1e9);
    expect(2U, 3276.7);
}

/// Outputs of an earlier configuration are not sent with the first process data of the next; inputs keep
/// their values.
static void outputs_are_zero_in_a_new_configuration(void)
{
    device.values[0] = 7U;
    canopen_device_set_value(&device, 3U, 5.0);
    canopen_device_set_value(&device, 4U, 0.25);
    canopen_device_emit(&device);
    scripted_bus_run(&bus);
    canopen_device_configure(&device, NULL, 0U);
    // The process data still carry these values.
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_device_configure_step(&device));
    canopen_device_emit(&device);
    scripted_bus_run(&bus);
    static const uint8_t zeros[6] = {0U};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(zeros, bus.seen[0].data, 6U);
    TEST_ASSERT_EQUAL_UINT32(7U, device.values[0]);
}

/// A setting makes the first PDO invalid. Two objects are in this PDO only, one is in both PDOs: the object
/// that the second PDO still carries is not written.
static void values_without_process_data_are_set_to_zero(void)
{
    static const canopen_device_profile_t both = {
        .value_count   = 3U,
        .values        = {{0x6200U, 1U, 1U, false, false, 1.0},
                          {0x6200U, 2U, 1U, false, false, 1.0},
                          {0x2101U, 2U, 2U, true, false, 1.0}},
        .receive_count = 2U,
        .receive       = {
                  {.cob_base    = 0x200U,
                   .is_valid    = true,
                   .entry_count = 4U,
                   .entries     = {{0x6200U, 1U, 1U, PROFILE_VALUE, 0U},
                                   {0x6200U, 2U, 1U, PROFILE_VALUE, 1U},
                                   {0x0005U, 0U, 1U, PROFILE_PADDING, 0U},
                                   {0x2101U, 2U, 2U, PROFILE_VALUE, 2U}}},
                  {.cob_base    = 0x300U,
                   .is_valid    = true,
                   .entry_count = 2U,
                   .entries     = {{0x6200U, 1U, 1U, PROFILE_VALUE, 0U}, {0x0005U, 0U, 1U, PROFILE_PADDING, 0U}}}}};
    canopen_setting_t setting   = {.index = 0x1400U, .subindex = 1U, .octets = 4U, .value = 0x80000232U};
    scripted_node_t* const node = scripted_bus_add(&bus, SCRIPTED_DRIVE, NODE + 1U);
    scripted_object(node, 0x6200U, 1U)->value = 1U;
    scripted_object(node, 0x6200U, 2U)->value = 1U;
    scripted_object(node, 0x2101U, 2U)->value = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_device_attach(&device, &master, &both, NODE + 1U));
    canopen_device_emit(&device);
    status_t status = STATUS_BUSY;
    canopen_device_configure(&device, &setting, 1U);
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < 20U); i++) {
        canopen_master_receive(&master, i * 500000U);
        status = canopen_device_configure_step(&device);
        canopen_master_emit(&master, i * 500000U);
        scripted_bus_run(&bus);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL_UINT(3U, node->writes); // The setting, and zero for two objects.
    TEST_ASSERT_EQUAL_UINT32(1U, scripted_object(node, 0x6200U, 1U)->value);
    TEST_ASSERT_EQUAL_UINT32(0U, scripted_object(node, 0x6200U, 2U)->value);
    TEST_ASSERT_EQUAL_UINT32(0U, scripted_object(node, 0x2101U, 2U)->value);
}

/// REAL32 of CiA 404 (0x6130) and of the manufacturer, octet by octet.
static const canopen_device_profile_t real = {
    .type           = "real",
    .profile        = 404U,
    .value_count    = 2U,
    .values         = {{0x6130U, 1U, 4U, true, true, 1.0}, {0x2200U, 0U, 4U, true, true, 1.0}},
    .transmit_count = 1U,
    .transmit       = {{.cob_base     = 0x180U,
                        .is_valid     = true,
                        .is_each_sync = true,
                        .entry_count  = 1U,
                        .entries      = {{0x6130U, 1U, 4U, PROFILE_VALUE, 0U}}}},
    .receive_count  = 1U,
    .receive        = {{.cob_base    = 0x200U,
                        .is_valid    = true,
                        .entry_count = 1U,
                        .entries     = {{0x2200U, 0U, 4U, PROFILE_VALUE, 1U}}}}};

static void connect_real(void)
{
    canopen_device_disconnect(&device);
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_device_attach(&device, &master, &real, NODE + 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_device_connect(&device));
}

/// A number that is NaN or infinite is not valid: the value is NaN until the device sends a finite one.
static void a_received_real_has_its_number_or_is_not_valid(void)
{
    static const struct {
        uint8_t octets[4];
        double number; ///< NaN: not valid.
    } cases[] = {{{0x00U, 0x00U, 0x80U, 0x3FU}, 1.0},
                 {{0xCDU, 0xCCU, 0xCCU, 0xBDU}, -0.10000000149011612},
                 {{0x00U, 0x00U, 0xC0U, 0x7FU}, (double)NAN}, // Quiet NaN.
                 {{0x01U, 0x00U, 0x80U, 0xFFU}, (double)NAN}, // Signalling NaN.
                 {{0x00U, 0x00U, 0x80U, 0x7FU}, (double)NAN}, // Infinite.
                 {{0x00U, 0x00U, 0x80U, 0xFFU}, (double)NAN},
                 {{0xFFU, 0xFFU, 0x7FU, 0x7FU}, 3.4028234663852886e38}, // The largest.
                 {{0xFFU, 0xFFU, 0x7FU, 0xFFU}, -3.4028234663852886e38},
                 {{0x01U, 0x00U, 0x00U, 0x00U}, 1.401298464324817e-45}, // The least above 0.
                 {{0x00U, 0x00U, 0x00U, 0x80U}, 0.0}};
    connect_real();
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        scripted_bus_deliver(&bus, 0x180U + NODE + 1U, cases[i].octets, 4U);
        canopen_master_receive(&master, 0U);
        const double number = canopen_device_value(&device, 0U);
        TEST_ASSERT_EQUAL(isnan(cases[i].number), isnan(number));
        TEST_ASSERT_TRUE(isnan(number) || (number == cases[i].number));
    }
}

static void a_sent_real_is_the_nearest_finite_number(void)
{
    static const struct {
        double wanted;
        uint8_t octets[4];
    } cases[] = {{0.1, {0xCDU, 0xCCU, 0xCCU, 0x3DU}},   {-2.5, {0x00U, 0x00U, 0x20U, 0xC0U}},
                 {1e300, {0xFFU, 0xFFU, 0x7FU, 0x7FU}}, {-(double)INFINITY, {0xFFU, 0xFFU, 0x7FU, 0xFFU}},
                 {(double)NAN, {0U, 0U, 0U, 0U}},       {1e-300, {0U, 0U, 0U, 0U}}};
    connect_real();
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        canopen_device_set_value(&device, 1U, cases[i].wanted);
        canopen_device_emit(&device);
        scripted_bus_run(&bus);
        TEST_ASSERT_EQUAL_HEX32(0x200U + NODE + 1U, bus.seen[0].id);
        TEST_ASSERT_EQUAL_UINT8(4U, bus.seen[0].length);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].octets, bus.seen[0].data, 4U);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(values_are_found_by_their_object);
    RUN_TEST(received_values_have_their_sign_and_unit);
    RUN_TEST(sent_values_are_rounded_and_limited_to_their_object);
    RUN_TEST(outputs_are_zero_in_a_new_configuration);
    RUN_TEST(values_without_process_data_are_set_to_zero);
    RUN_TEST(a_received_real_has_its_number_or_is_not_valid);
    RUN_TEST(a_sent_real_is_the_nearest_finite_number);
    return UNITY_END();
}
