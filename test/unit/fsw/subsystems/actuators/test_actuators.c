// SPDX-License-Identifier: Apache-2.0
// ACTUATORS with its real descriptor and scripted devices: axes, outputs, inputs, homing, and devices that do
// not fit.
#include "fsw/subsystems/actuators/actuators.h"
#include "osal/include/osal/file.h"
#include "pus/core/tailoring.h"
#include "test/support/bounds.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>

#define DESCRIPTOR "descriptors/subsystems/actuators.xml"
#define HOMING 0U ///< Indices of the configurations.
#define NOMINAL 1U
#define VELOCITY 2U
#define TOKEN 7U
#define MOVED_IN_A_CYCLE 200 ///< At 0.2 rad/s and 1 kHz [urad].

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static char text[65536];
static size_t length;
static scripted_bus_t bus;
static scripted_node_t* boom;
static scripted_node_t* valves;
static scripted_node_t* gyro;
static subsystem_t generic;
static actuators_t own;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, bus.address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

static void load(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(DESCRIPTOR, text, sizeof text, &length));
    descriptor_loader_init(&loader);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK,
                              descriptor_parse_subsystem(&loader, DESCRIPTOR, text, length, &descriptor),
                              descriptor_error(&loader));
}

void setUp(void)
{
    load();
    scripted_bus_open(&bus, "test-actuators");
    boom   = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x25U);
    valves = scripted_bus_add(&bus, SCRIPTED_VALVES, 0x3AU);
    gyro   = scripted_bus_add(&bus, SCRIPTED_GYRO, 0x2BU);
    double_init(&generic, &descriptor, actuators_callbacks(), &own);
    generic.period_ns = 1000000U;
    actuators_init(&own, &generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, generic.callbacks->software_init(&own));
    own.parameters.speed = 0.2;
}

void tearDown(void)
{
    generic.callbacks->release(&own);
    scripted_bus_close(&bus);
}

typedef status_t (*action_t)(void* self);

static status_t cycle(const action_t action)
{
    const status_t status = double_cycle(&generic, action, true);
    scripted_bus_run(&bus);
    generic.now_ns += generic.period_ns;
    if ((generic.now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&bus);
    }
    return status;
}

static void run(const action_t action, const state_t state)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < 1000U); i++) {
        status = cycle(action);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    generic.state = state;
}

static void cycles(const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        (void)cycle(NULL);
    }
}

static status_t configure(void* const self)
{
    return generic.callbacks->configure(self, generic.configuration);
}

static void bring(const unsigned configuration, const state_t state)
{
    generic.configuration = &descriptor.configurations[configuration];
    run(generic.callbacks->hardware_init, STATE_HARDWARE_INIT);
    run(configure, STATE_PRE_OPERATIONAL);
    if (state >= STATE_SAFE_OPERATIONAL) {
        run(generic.callbacks->start_control, STATE_SAFE_OPERATIONAL);
    }
    if (state == STATE_OPERATIONAL) {
        run(generic.callbacks->engage, STATE_OPERATIONAL);
    }
}

static status_t call(const uint16_t function_id)
{
    const subsystem_function_t function = {.function_id = function_id, .call_token = TOKEN};
    return generic.callbacks->perform(&own, &function);
}

/// Expect this result as the only one since the last call.
static void expect_result(const uint16_t code, const uint32_t detail)
{
    TEST_ASSERT_EQUAL_UINT(1U, generic.result_count);
    TEST_ASSERT_EQUAL_UINT32(TOKEN, generic.results[0].call_token);
    TEST_ASSERT_EQUAL_HEX16(code, generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(detail, generic.results[0].detail);
    generic.result_count = 0U;
}

static void an_axis_goes_to_its_target_with_its_speed(void)
{
    boom->position[0] = 100000;
    bring(NOMINAL, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL_INT32(100000, boom->target_position); // The axis holds its position.
    own.parameters.target[0] = 0.3;
    cycles(500U); // 0.5 s.
    TEST_ASSERT_INT32_WITHIN(2 * MOVED_IN_A_CYCLE, 200000, boom->target_position);
    cycles(600U);
    TEST_ASSERT_EQUAL_INT32(300000, boom->target_position);
    own.parameters.target[0] = -1.0;
    cycles(500U);
    TEST_ASSERT_INT32_WITHIN(2 * MOVED_IN_A_CYCLE, 200000, boom->target_position);
    TEST_ASSERT_EQUAL(STATUS_OK, call(ACTUATORS_FUNCTION_STOP));
    const int32_t stopped = boom->target_position;
    cycles(100U);
    TEST_ASSERT_INT32_WITHIN(MOVED_IN_A_CYCLE + 1, stopped, boom->target_position);
    boom->position[0] = 250000;
    boom->torque[0]   = -120; // Thousandths of the rated torque of 10 Nm.
    cycles(2U);
    EXPECT_WITHIN(0.25, 1e-9, own.parameters.cur_values.position[0]);
    EXPECT_WITHIN(-1.2, 1e-9, own.parameters.cur_values.torque[0]);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, own.parameters.cur_values.statusword[0]);
    TEST_ASSERT_EQUAL_INT32(STATE_OPERATIONAL, own.parameters.cur_values.state);
}

/// The second RPDO of the drive carries the velocity; after STOP and in each new operation the velocity is
/// zero.
static void an_axis_in_csv_moves_with_its_velocity_in_operational_only(void)
{
    bring(VELOCITY, STATE_SAFE_OPERATIONAL);
    own.parameters.velocity[0] = 0.5;
    cycles(2U);
    TEST_ASSERT_EQUAL_HEX32(0U, scripted_object(boom, 0x60FFU, 0U)->value);
    run(generic.callbacks->engage, STATE_OPERATIONAL);
    cycles(2U);
    TEST_ASSERT_EQUAL_HEX32(0U, scripted_object(boom, 0x60FFU, 0U)->value);
    own.parameters.velocity[0] = -0.25;
    cycles(2U);
    TEST_ASSERT_EQUAL_HEX32((uint32_t)-250000, scripted_object(boom, 0x60FFU, 0U)->value);
    TEST_ASSERT_EQUAL_UINT(2U, boom->last_pdo);
    TEST_ASSERT_EQUAL(STATUS_OK, call(ACTUATORS_FUNCTION_STOP));
    cycles(2U);
    TEST_ASSERT_EQUAL_HEX32(0U, scripted_object(boom, 0x60FFU, 0U)->value);
    own.parameters.velocity[0] = 0.125;
    cycles(2U);
    run(generic.callbacks->disengage, STATE_SAFE_OPERATIONAL);
    cycles(2U);
    TEST_ASSERT_EQUAL_HEX32(0U, scripted_object(boom, 0x60FFU, 0U)->value);
}

/// The rates [rad/s] are the inputs after those of the valves.
static void the_rates_of_the_gyro_are_inputs(void)
{
    gyro->rate[0] = 12345678;
    gyro->rate[2] = -50000;
    bring(NOMINAL, STATE_SAFE_OPERATIONAL);
    cycles(3U);
    EXPECT_WITHIN(1.2345678, 1e-12, own.parameters.cur_values.input[2]);
    EXPECT_WITHIN(0.0, 0.0, own.parameters.cur_values.input[3]);
    EXPECT_WITHIN(-0.005, 1e-12, own.parameters.cur_values.input[4]);
}

static void outputs_act_in_operational_only(void)
{
    static const uint8_t wanted[4] = {0x03U, 0x80U, 0x32U, 0x00U};
    static const uint8_t zeros[4]  = {0U};
    own.parameters.output[0]       = 3.0;
    own.parameters.output[1]       = 128.0;
    own.parameters.output[2]       = 50.0;
    bring(NOMINAL, STATE_SAFE_OPERATIONAL);
    cycles(3U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(zeros, valves->outputs, 4U);
    run(generic.callbacks->engage, STATE_OPERATIONAL);
    cycles(3U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(wanted, valves->outputs, 4U);
    EXPECT_WITHIN(3.0, 0.0, own.parameters.cur_values.input[0]);
    EXPECT_WITHIN(128.0, 0.0, own.parameters.cur_values.input[1]);
    generic.state = STATE_ERROR_OPERATIONAL;
    (void)cycle(generic.callbacks->secure);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(zeros, valves->outputs, 4U);
    run(generic.callbacks->secure, STATE_ERROR_OPERATIONAL);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, boom->status[0]);
}

static void homing_ends_with_the_result_of_the_drive(void)
{
    bring(HOMING, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, call(ACTUATORS_FUNCTION_HOME));
    run(generic.callbacks->engage, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, call(ACTUATORS_FUNCTION_HOME));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, call(ACTUATORS_FUNCTION_HOME)); // A search is in progress.
    cycles(5U);
    TEST_ASSERT_EQUAL_HEX16(0x001FU, boom->control[0]);
    generic.result_count = 0U; // Forget the results of earlier activities.
    cycles(1U);
    TEST_ASSERT_EQUAL_UINT(0U, generic.result_count);
    boom->status[0] |= 0x1400U;
    cycles(2U);
    expect_result(PUS_FAILURE_NONE, 0U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, call(ACTUATORS_FUNCTION_HOME));
    boom->status[0] = 0x2637U;
    cycles(3U);
    expect_result(PUS_FAILURE_DEVICE, 0x25U);
    cycles(1U);
    TEST_ASSERT_EQUAL_HEX16(0x000FU, boom->control[0]);
    TEST_ASSERT_EQUAL(STATUS_BUSY, call(ACTUATORS_FUNCTION_HOME));
    TEST_ASSERT_EQUAL(STATUS_OK, call(ACTUATORS_FUNCTION_STOP));
    expect_result(PUS_FAILURE_ABORTED, 0U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, call(ACTUATORS_FUNCTION_HOME));
    boom->status[0] = 0x0237U;
    run(generic.callbacks->disengage, STATE_SAFE_OPERATIONAL);
    expect_result(PUS_FAILURE_ABORTED, 0U);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, call(99U));
}

static void in_another_mode_homing_is_refused(void)
{
    bring(NOMINAL, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, call(ACTUATORS_FUNCTION_HOME));
    cycles(2U);
    TEST_ASSERT_EQUAL_HEX16(0x000FU, boom->control[0]);
}

/// The subsystem is in OPERATIONAL before its axes are in operation: until then the outputs stay zero and the
/// target of an axis is its position.
static void outputs_and_targets_wait_for_the_axes_in_operational(void)
{
    boom->position[0] = 100000;
    bring(NOMINAL, STATE_SAFE_OPERATIONAL);
    generic.state = STATE_OPERATIONAL;
    for (unsigned i = 0U; i < 3U; i++) {
        own.parameters.output[0] = 1.0;
        own.parameters.target[0] = 0.3;
        cycles(1U);
        TEST_ASSERT_EQUAL_HEX8(0U, valves->outputs[0]);
        TEST_ASSERT_EQUAL_INT32(100000, boom->target_position);
    }
    run(generic.callbacks->engage, STATE_OPERATIONAL);
    own.parameters.target[0] = 0.3;
    cycles(3U);
    TEST_ASSERT_EQUAL_HEX8(1U, valves->outputs[0]);
    TEST_ASSERT_TRUE(boom->target_position > 100000);
}

/// Add `more` devices of a class to the first configuration of the descriptor. Expect that it is refused with
/// this reason; null: that it fits.
static void expect_misfit(const char* type, const unsigned more, const char* reason)
{
    static char longer[sizeof text];
    const char* const place   = strstr(text, "    </Devices>");
    const size_t before       = (size_t)(place - text);
    size_t used               = before;
    subsystem_misfit_t misfit = {0U, "", 0U};
    memcpy(longer, text, before);
    for (unsigned i = 0U; i < more; i++) {
        used +=
            (size_t)sprintf(&longer[used],
                            "<Device name=\"D%u\" type=\"%s\"><Setting object=\"0x6060:00\" type=\"INT8\" "
                            "value=\"8\"/><Endnode type=\"CAN\" bus=\"platform\" node=\"%u\"/></Device>",
                            i, type, 0x40U + i);
    }
    memcpy(&longer[used], place, length - before);
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK,
        descriptor_parse_subsystem(&loader, DESCRIPTOR, longer, used + length - before, &descriptor),
        descriptor_error(&loader));
    TEST_ASSERT_EQUAL(reason == NULL, generic.callbacks->fits(&descriptor, &misfit));
    if (reason != NULL) {
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(misfit.reason, reason), misfit.reason);
        TEST_ASSERT_TRUE(misfit.line > 50U);
    }
}

static void devices_above_the_capacities_do_not_fit(void)
{
    expect_misfit("joint-drive", 7U, NULL);
    expect_misfit("joint-drive", 8U, "axes of a <Configuration>");
    expect_misfit("valve-box", 4U, NULL); // 10 inputs and 15 outputs fit.
    expect_misfit("valve-box", 5U, "outputs of a <Configuration>");
    expect_misfit("gyro", 2U, NULL); // 12 inputs fit.
    expect_misfit("gyro", 3U, "inputs of a <Configuration>");
    expect_misfit("joystick", 1U, "expected a drive of CiA 402 with one axis, or a class without axes");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_axis_goes_to_its_target_with_its_speed);
    RUN_TEST(an_axis_in_csv_moves_with_its_velocity_in_operational_only);
    RUN_TEST(the_rates_of_the_gyro_are_inputs);
    RUN_TEST(outputs_act_in_operational_only);
    RUN_TEST(homing_ends_with_the_result_of_the_drive);
    RUN_TEST(in_another_mode_homing_is_refused);
    RUN_TEST(outputs_and_targets_wait_for_the_axes_in_operational);
    RUN_TEST(devices_above_the_capacities_do_not_fit);
    return UNITY_END();
}
