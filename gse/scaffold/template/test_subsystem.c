// SPDX-License-Identifier: Apache-2.0
// @NAME@ with its real descriptor, with a test double of the generic subsystem.
#include "fsw/subsystems/@name@/@name@.h"
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
    return STATUS_NOT_FOUND; // There is no bus here.
}

static const flow_resolver_t resolver = {NULL, resolve};

void setUp(void)
{
    double_init(&generic, &descriptor, @name@_callbacks(), &own);
    @name@_init(&own, &generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&generic));
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
    own.parameters.rate      = 0.5;
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
    RUN_TEST(stop_holds_the_present_value);
    return UNITY_END();
}
