// SPDX-License-Identifier: Apache-2.0
// @NAME@ with its real descriptor, with a test double of the generic subsystem.
#include "fsw/subsystems/@name@/@name@.h"
#include "pus/core/tailoring.h"
#include "test/support/subsystem_double.h"

#include "unity.h"

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static subsystem_t generic;
static @name@_t own;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)out_address;
    return STATUS_NOT_FOUND; // There are no devices here.
}

static const flow_resolver_t resolver = {NULL, resolve};

void setUp(void)
{
    double_init(&generic, &descriptor, @name@_callbacks(), &own);
    @name@_init(&own, &generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&generic));
    own.parameters.rate  = 0.5;
    own.parameters.reach = 1.0;
    generic.period_ns = 1000000U;
    generic.state     = STATE_OPERATIONAL;
}

void tearDown(void)
{
}

static void fly(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, double_cycle(&generic, NULL, true));
        generic.now_ns += generic.period_ns;
    }
}

static void the_value_follows_at_its_rate_and_its_arrival_is_reported_once(void)
{
    own.parameters.des_value = 0.25;
    fly(400U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.2, own.parameters.cur_values.value);
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&generic, @NAME@_EVENT_ARRIVED));
    fly(400U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.25, own.parameters.cur_values.value);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, @NAME@_EVENT_ARRIVED));
    TEST_ASSERT_EQUAL_INT(STATE_OPERATIONAL, own.parameters.cur_values.state);
}

static void out_of_operation_the_value_does_not_change(void)
{
    generic.state            = STATE_SAFE_OPERATIONAL;
    own.parameters.des_value = 0.25;
    fly(100U);
    TEST_ASSERT_DOUBLE_WITHIN(0.0, 0.0, own.parameters.cur_values.value);
}

static void at_the_pace_fast_the_value_moves_twice_as_fast(void)
{
    own.parameters.des_value = 1.0;
    own.parameters.pace      = @NAME@_VALUE_PACE_FAST;
    fly(400U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.4, own.parameters.cur_values.value);
}

static status_t move(const double to, const uint32_t call_token)
{
    const @name@_move_arguments_t arguments = {.to = to, .pace = @NAME@_VALUE_PACE_FAST};
    const subsystem_function_t function     = {
            .function_id = @NAME@_FUNCTION_MOVE, .arguments = &arguments, .call_token = call_token};
    return generic.callbacks->perform(&own, &function);
}

static void expect_result(const unsigned number, const uint32_t call_token, const uint16_t code)
{
    TEST_ASSERT_TRUE(generic.result_count > number);
    TEST_ASSERT_EQUAL_UINT32(call_token, generic.results[number].call_token);
    TEST_ASSERT_EQUAL_HEX16(code, generic.results[number].code);
}

static void a_motion_ends_at_its_arrival_or_is_replaced(void)
{
    TEST_ASSERT_EQUAL(STATUS_BUSY, move(0.5, 7U));
    fly(100U);
    TEST_ASSERT_EQUAL_UINT(0U, generic.result_count);
    TEST_ASSERT_EQUAL(STATUS_BUSY, move(0.2, 8U));
    expect_result(0U, 7U, PUS_FAILURE_ABORTED);
    fly(200U);
    expect_result(1U, 8U, PUS_FAILURE_NONE);
    const double_event_t* const event = double_last_event(&generic, @NAME@_EVENT_ARRIVED);
    TEST_ASSERT_NOT_NULL(event);
    TEST_ASSERT_EQUAL_UINT8(@NAME@_VALUE_PACE_FAST, event->octets[@NAME@_EVENT_ARRIVED_OCTETS - 1U]);
}

static void a_motion_beyond_the_reach_fails_with_the_own_code(void)
{
    own.parameters.reach = 0.4;
    TEST_ASSERT_EQUAL(STATUS_BUSY, move(-0.5, 9U));
    expect_result(0U, 9U, @NAME@_FAILURE_BEYOND_REACH);
    TEST_ASSERT_EQUAL_UINT32(400U, generic.results[0].detail);
    fly(10U);
    TEST_ASSERT_DOUBLE_WITHIN(0.0, 0.0, own.parameters.cur_values.value);
}

static void the_descriptor_fits_and_another_mode_does_not(void)
{
    subsystem_misfit_t misfit = {0U, "", 0U};
    TEST_ASSERT_TRUE_MESSAGE(generic.callbacks->fits(&descriptor, &misfit), misfit.reason);
    descriptor.storage.settings[0].bits = 9U;
    TEST_ASSERT_FALSE(generic.callbacks->fits(&descriptor, &misfit));
    descriptor.storage.settings[0].bits = 8U;
}

static void stop_holds_the_present_value(void)
{
    const subsystem_function_t stop = {.function_id = @NAME@_FUNCTION_STOP};
    own.parameters.des_value        = 1.0;
    fly(100U);
    TEST_ASSERT_EQUAL(STATUS_OK, generic.callbacks->perform(&own, &stop));
    const double held = own.parameters.cur_values.value;
    fly(100U);
    TEST_ASSERT_DOUBLE_WITHIN(0.0, held, own.parameters.cur_values.value);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, generic.callbacks->perform(&own, &(subsystem_function_t){0}));
}

int main(void)
{
    UNITY_BEGIN();
    descriptor_loader_init(&loader);
    const status_t status =
        descriptor_load_subsystem(&loader, "descriptors/subsystems/@file@.xml", &descriptor);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, status, descriptor_error(&loader));
    RUN_TEST(the_value_follows_at_its_rate_and_its_arrival_is_reported_once);
    RUN_TEST(out_of_operation_the_value_does_not_change);
    RUN_TEST(at_the_pace_fast_the_value_moves_twice_as_fast);
    RUN_TEST(a_motion_ends_at_its_arrival_or_is_replaced);
    RUN_TEST(a_motion_beyond_the_reach_fails_with_the_own_code);
    RUN_TEST(the_descriptor_fits_and_another_mode_does_not);
    RUN_TEST(stop_holds_the_present_value);
    return UNITY_END();
}
