// SPDX-License-Identifier: Apache-2.0
// The joystick through its whole life, with its real descriptor, a scripted device and a scripted robot.
#include "fsw/subsystems/joystick/joystick.h"
#include "test/support/bounds.h"
#include "test/support/scripted_bus.h"
#include "test/support/subsystem_double.h"

#include "pus/core/tailoring.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define CYCLES_MAX 4000U
#define HAND JOYSTICK_PORT_HAND_POSITION
#define ROBOT JOYSTICK_PORT_ROBOT_STATE

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static scripted_bus_t bus;
static scripted_bus_t channel_b; // No device is on it.
static scripted_node_t* stick;
static subsystem_t generic;
static joystick_t joystick;
static const subsystem_callbacks_t* callbacks;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    const bool is_b = (strcmp(name, "joystick-b") == 0);
    if ((kind != ENDNODE_CAN) || (!is_b && (strcmp(name, "joystick") != 0))) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, is_b ? channel_b.address : bus.address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

void setUp(void)
{
    callbacks = joystick_callbacks();
    scripted_bus_open(&bus, "test-joystick");
    scripted_bus_open(&channel_b, "test-joystick-b");
    stick              = scripted_bus_add(&bus, SCRIPTED_JOYSTICK, 0x21U);
    stick->position[0] = 50000;
    stick->position[1] = -20000;
    double_init(&generic, &descriptor, callbacks, &joystick);
    TEST_ASSERT_NOT_NULL(generic.descriptor);
    joystick_init(&joystick, &generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&generic));
}

void tearDown(void)
{
    canopen_network_close(&joystick.drives.network);
    scripted_bus_close(&bus);
    scripted_bus_close(&channel_b);
}

typedef status_t (*action_t)(void* self);

static status_t cycle(const action_t action)
{
    const bool is_controlled = (generic.configuration != NULL) && (generic.state >= STATE_PRE_OPERATIONAL) &&
                               (generic.state <= STATE_ERROR_OPERATIONAL);
    const status_t status = double_cycle(&generic, action, is_controlled);
    scripted_bus_run(&bus);
    generic.now_ns += generic.period_ns;
    if ((generic.now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&bus);
    }
    return status;
}

static status_t run_action(const action_t action)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < CYCLES_MAX); i++) {
        status = cycle(action);
    }
    return status;
}

static void idle(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        (void)cycle(NULL);
    }
}

static status_t configure(void* const self)
{
    return callbacks->configure(self, generic.configuration);
}

static void robot_feels(const double first_nm, const double second_nm)
{
    const joystick_robot_state_payload_t robot = {{1.0, -1.5}, {first_nm, second_nm}};
    memcpy(generic.ports[ROBOT].sample, &robot, sizeof robot);
    generic.ports[ROBOT].read_status = STATUS_OK;
    generic.ports[ROBOT].age_us      = 500U;
}

static void bring(const uint16_t configuration, const state_t state)
{
    generic.state = STATE_HARDWARE_INIT;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->hardware_init));
    generic.state         = STATE_PRE_OPERATIONAL;
    generic.configuration = descriptor_find_configuration(&descriptor, configuration);
    double_set_initials(&generic, generic.configuration);
    joystick.parameters.control.ramp_time = 0.2;
    joystick.parameters.control.fade_time = 0.2;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    if (state >= STATE_SAFE_OPERATIONAL) {
        generic.state = STATE_SAFE_OPERATIONAL;
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->start_control));
    }
    if (state == STATE_OPERATIONAL) {
        generic.state = STATE_OPERATIONAL;
        TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->engage));
    }
}

static status_t perform(const uint16_t function, const void* const arguments, const uint32_t call_token)
{
    const subsystem_function_t call = {
        .function_id = function, .arguments = arguments, .call_token = call_token};
    return callbacks->perform(&joystick, &call);
}

static double torque(const unsigned axis)
{
    return 1.0e-4 * (double)stick->target_torque[axis];
}

static void telepresence_from_offline_and_back(void)
{
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    idle(5U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, stick->status[0]);
    joystick_hand_position_payload_t hand;
    TEST_ASSERT_EQUAL_UINT64(sizeof hand, generic.ports[HAND].written_size); // As soon as a link may be open.
    memcpy(&hand, generic.ports[HAND].written, sizeof hand);
    EXPECT_WITHIN(0.05, 1.0e-9, hand.position[0]);
    EXPECT_WITHIN(-0.02, 1.0e-9, hand.position[1]);
    robot_feels(0.0, 0.0);
    generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->start_control));
    TEST_ASSERT_EQUAL_HEX16(0x0233U, stick->status[0]);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, stick->status[1]);
    generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->engage));
    TEST_ASSERT_EQUAL_HEX16(0x0237U, stick->status[1]);
    idle(50U);
    generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->disengage));
    TEST_ASSERT_EQUAL_HEX16(0x0233U, stick->status[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->stop_control));
    generic.state = STATE_POST_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->post));
    generic.state = STATE_HARDWARE_DEINIT;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->hardware_deinit));
    TEST_ASSERT_EQUAL_UINT(2U, stick->boots);
    TEST_ASSERT_EQUAL_UINT(0U, generic.event_count);
}

static void the_displayed_torque_rises_smoothly_to_the_robot_s_torque(void)
{
    double before = 0.0;
    robot_feels(-11.0, 8.0);
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    EXPECT_WITHIN(0.0, 0.02, torque(0U));
    for (unsigned i = 0U; i < 8000U; i++) {
        (void)cycle(NULL);
        EXPECT_BELOW(0.005, fabs(torque(0U) - before)); // 0.33 Nm in 400 cycles, smoothly.
        before = torque(0U);
    }
    EXPECT_WITHIN(-0.33, 1.0e-4, torque(0U));
    EXPECT_WITHIN(0.24, 1.0e-4, torque(1U));
    EXPECT_WITHIN(-0.33, 1.0e-4, joystick.parameters.cur_values.felt_torque[0]);
}

static void a_torque_that_is_not_renewed_expires(void)
{
    robot_feels(-11.0, 8.0);
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    idle(8000U);
    generic.ports[ROBOT].read_status = STATUS_STALE;
    idle(41U); // 20 ms.
    EXPECT_WITHIN(0.0, 0.01, torque(0U));
}

static void no_torque_is_applied_until_engaged(void)
{
    robot_feels(-11.0, 8.0);
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    idle(2000U);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, stick->status[0]); // Whatever is computed, the device applies no torque.
    TEST_ASSERT_EQUAL_HEX16(0x0007U, stick->control[0]);
}

static void unplugging_is_noticed_at_once(void)
{
    robot_feels(0.0, 0.0);
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    stick->is_plugged     = false;
    const uint64_t cut_ns = generic.now_ns;
    while ((generic.state == STATE_OPERATIONAL) && ((generic.now_ns - cut_ns) < 10000000U)) {
        (void)cycle(NULL);
    }
    TEST_ASSERT_TRUE((generic.now_ns - cut_ns) <= 2000000U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, JOYSTICK_EVENT_DEVICE_LOST));
    TEST_ASSERT_EQUAL_HEX8(0x21U, double_last_event(&generic, JOYSTICK_EVENT_DEVICE_LOST)->octets[0]);
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, generic.ports[HAND].written_state);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->secure));
}

static void force_displays_a_torque_for_a_time(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 0.5};
    const joystick_force_arguments_t large = {{1.6, 0.0}, 0.5};
    const joystick_force_arguments_t never = {{0.1, 0.0}, 0.0};
    const joystick_force_arguments_t none  = {{(double)NAN, 0.0}, 0.5};
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->engage));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, perform(JOYSTICK_FUNCTION_FORCE, &large, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, perform(JOYSTICK_FUNCTION_FORCE, &never, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, perform(JOYSTICK_FUNCTION_FORCE, &none, 1U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, perform(JOYSTICK_FUNCTION_FORCE, &force, 11U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, perform(JOYSTICK_FUNCTION_FORCE, &force, 12U));
    idle(500U);
    EXPECT_WITHIN(0.3, 1.0e-4, torque(0U));
    EXPECT_WITHIN(-0.15, 1.0e-4, torque(1U));
    EXPECT_WITHIN(0.3, 1.0e-12, joystick.parameters.des_torque[0]);
    TEST_ASSERT_EQUAL_UINT(0U, generic.result_count);
    idle(510U);
    TEST_ASSERT_EQUAL_UINT(1U, generic.result_count);
    TEST_ASSERT_EQUAL_UINT32(11U, generic.results[0].call_token);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(0U, generic.results[0].detail);
    EXPECT_WITHIN(0.0, 1.0e-4, torque(0U));
}

/// The ceiling itself is allowed, on each axis and in each direction, and nothing above it.
static void a_force_is_allowed_up_to_the_ceiling(void)
{
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    const double ceiling = joystick.parameters.control.torque_ceiling;
    const double above   = nextafter(ceiling, 2.0 * ceiling);
    for (unsigned axis = 0U; axis < 2U; axis++) {
        for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
            joystick_force_arguments_t force = {{0.0, 0.0}, 0.5};
            force.torque[axis]               = sign * above;
            TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
            force.torque[axis] = sign * ceiling;
            TEST_ASSERT_EQUAL(STATUS_BUSY, perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
            idle(1010U);
        }
    }
    TEST_ASSERT_EQUAL_UINT(4U, generic.result_count);
}

static void stop_and_leaving_operation_end_a_force(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 5.0};
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    idle(500U);
    TEST_ASSERT_EQUAL(STATUS_OK, perform(JOYSTICK_FUNCTION_STOP, NULL, 2U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, generic.results[0].code);
    idle(200U);
    EXPECT_WITHIN(0.0, 1.0e-4, torque(0U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, perform(JOYSTICK_FUNCTION_FORCE, &force, 3U));
    idle(500U);
    generic.state = STATE_SAFE_OPERATIONAL;
    (void)run_action(callbacks->disengage);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, generic.results[1].code);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, perform(JOYSTICK_FUNCTION_STOP, NULL, 4U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, perform(99U, NULL, 4U));
}

static void setting_the_desired_torque_lasts_until_stop(void)
{
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    joystick.parameters.des_torque[0] = 0.2;
    joystick.parameters.des_torque[1] = 0.0;
    callbacks->parameter_set(&joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    idle(20000U);
    EXPECT_WITHIN(0.2, 1.0e-4, torque(0U));
    TEST_ASSERT_EQUAL(STATUS_OK, perform(JOYSTICK_FUNCTION_STOP, NULL, 4U));
    idle(200U);
    EXPECT_WITHIN(0.0, 1.0e-4, torque(0U));
    callbacks->parameter_set(&joystick, JOYSTICK_PARAMETER_CONTROL);
}

static void a_telepresence_joystick_displays_nothing(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 5.0};
    robot_feels(0.0, 0.0);
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, perform(JOYSTICK_FUNCTION_STOP, NULL, 1U));
    joystick.parameters.des_torque[0] = 0.2;
    callbacks->parameter_set(&joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    idle(400U);
    EXPECT_WITHIN(0.0, 1.0e-4, torque(0U));
    EXPECT_WITHIN(0.0, 1.0e-12, joystick.parameters.des_torque[0]);
}

static void events_and_counters_are_published(void)
{
    const joystick_raise_arguments_t note = {JOYSTICK_EVENT_OPERATOR_NOTE};
    const joystick_raise_arguments_t lost = {JOYSTICK_EVENT_DEVICE_LOST};
    robot_feels(0.0, 0.0);
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, perform(JOYSTICK_FUNCTION_RAISE, &note, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, perform(JOYSTICK_FUNCTION_RAISE, &lost, 1U));
    scripted_bus_deliver(&bus, 0x123U, NULL, 0U);
    scripted_bus_emergency(&bus, 0x21U, 0x4310U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_can_send(joystick.drives.network.flow, 0x800U, NULL, 0U));
    idle(2U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, JOYSTICK_EVENT_DRIVE_WARNING));
    const joystick_counters_t* const counters = &joystick.parameters.counters;
    TEST_ASSERT_EQUAL_UINT32(generic.cycle, counters->cycles);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->frames_refused);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->emergencies);
    TEST_ASSERT_EQUAL_UINT32(0U, counters->pdo_missed);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->transmit_refused);
    TEST_ASSERT_EQUAL_UINT32(0U, counters->transmit_full); // The reason was another one.
    TEST_ASSERT_EQUAL_UINT32(500U, joystick.parameters.link_age);
    TEST_ASSERT_EQUAL_INT32(STATE_OPERATIONAL, joystick.parameters.cur_values.state);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, joystick.parameters.cur_values.statusword[1]);
    EXPECT_WITHIN(0.05, 1.0e-9, joystick.parameters.cur_values.position[0]);
}

/// CHANNEL selects a channel of the bus, reports it, and refuses one that the bus does not have.
static void the_channel_of_the_bus_is_selected_by_command(void)
{
    const joystick_channel_arguments_t first  = {NETWORK_CHANNEL_A};
    const joystick_channel_arguments_t second = {NETWORK_CHANNEL_B};
    const joystick_channel_arguments_t third  = {NETWORK_CHANNELS};
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, perform(JOYSTICK_FUNCTION_CHANNEL, &second, 1U));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_B, joystick.drives.network.channel);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&generic, JOYSTICK_EVENT_CHANNEL_SELECTED));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, perform(JOYSTICK_FUNCTION_CHANNEL, &third, 1U));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_B, joystick.drives.network.channel);
    TEST_ASSERT_EQUAL(STATUS_OK, perform(JOYSTICK_FUNCTION_CHANNEL, &first, 1U));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_A, joystick.drives.network.channel);
    TEST_ASSERT_EQUAL_UINT(2U, double_events(&generic, JOYSTICK_EVENT_CHANNEL_SELECTED));
}

static void a_function_that_it_does_not_have_is_refused(void)
{
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, perform(UINT16_MAX, NULL, 1U));
}

static void a_release_closes_the_bus(void)
{
    callbacks->release(&joystick); // Before it has one.
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    TEST_ASSERT_TRUE(flow_can_is_open(joystick.drives.network.flow));
    callbacks->release(&joystick);
    TEST_ASSERT_FALSE(flow_can_is_open(joystick.drives.network.flow));
    generic.state = STATE_HARDWARE_DEINIT;
    // At once: there is no device to be reset.
    TEST_ASSERT_EQUAL(STATUS_OK, cycle(callbacks->hardware_deinit));
}

static void only_a_descriptor_of_one_stick_fits(void)
{
    static subsystem_descriptor_t wrong;
    subsystem_misfit_t misfit = {0};
    TEST_ASSERT_TRUE(callbacks->fits(&descriptor, &misfit));
    TEST_ASSERT_NULL(misfit.says);
    wrong = descriptor; // The texts keep their addresses.
    wrong.configurations[0].device_count++;
    TEST_ASSERT_FALSE(callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_NOT_NULL(strstr(misfit.says, "expected one <Device>, the stick"));
    wrong.configurations[0].device_count--;
    wrong.devices[wrong.configurations[0].first_device].type = "cia402-drive";
    TEST_ASSERT_FALSE(callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_NOT_NULL(strstr(misfit.says, "expected joystick"));
}

/// Forces felt before are not those of the robot that is coupled next.
static void configuring_forgets_forces_and_the_command_of_before(void)
{
    robot_feels(-11.0, 8.0);
    bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    idle(8000U);
    TEST_ASSERT_TRUE(fabs(joystick.felt_nm[0]) > 10.0);
    TEST_ASSERT_TRUE(joystick.share == 1.0);
    generic.ports[ROBOT].read_status = STATUS_STALE;
    generic.state                    = STATE_PRE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_BUSY, callbacks->configure(&joystick, generic.configuration));
    TEST_ASSERT_TRUE((joystick.felt_nm[0] == 0.0) && (joystick.felt_nm[1] == 0.0));
    TEST_ASSERT_FALSE(joystick.control.is_started);
    TEST_ASSERT_TRUE(joystick.control.command_nm[0] == 0.0);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(configure));
    generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->start_control));
    generic.state = STATE_OPERATIONAL;
    (void)cycle(callbacks->engage);
    EXPECT_BELOW(0.01, joystick.share); // It is faded in again.
}

/// Without a commanded force, STOP and the end of operation report no further completion.
static void a_force_ends_once(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 0.1};
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    idle(300U);
    TEST_ASSERT_EQUAL_UINT(1U, generic.result_count);
    TEST_ASSERT_EQUAL(STATUS_OK, perform(JOYSTICK_FUNCTION_STOP, NULL, 2U));
    generic.state = STATE_SAFE_OPERATIONAL;
    (void)run_action(callbacks->disengage);
    TEST_ASSERT_EQUAL_UINT(1U, generic.result_count);
}

/// While FORCE is under way, and out of range, DES_TORQUE changes nothing.
static void the_desired_torque_is_taken_only_where_it_is_allowed(void)
{
    const joystick_force_arguments_t force = {{0.3, 0.0}, 5.0};
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    joystick.parameters.des_torque[0] = 2.0 * joystick.parameters.control.torque_ceiling;
    callbacks->parameter_set(&joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    idle(100U);
    EXPECT_WITHIN(0.0, 1.0e-4, torque(0U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    idle(500U);
    joystick.parameters.des_torque[0] = 0.1;
    callbacks->parameter_set(&joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    idle(500U);
    EXPECT_WITHIN(0.3, 1.0e-4, torque(0U));
    TEST_ASSERT_EQUAL_UINT(0U, generic.result_count);
}

/// Each axis and each quantity has its own field, whether process data flow or not.
static void every_value_of_both_axes_is_published(void)
{
    const joystick_parameters_t* const shown = &joystick.parameters;
    bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_PRE_OPERATIONAL);
    idle(3U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, shown->cur_values.statusword[1]);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(callbacks->post));
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        const double base                   = 100.0 * (double)(i + 1U);
        joystick.control.position_rad[i]    = base + 1.0;
        joystick.control.motion[i].velocity = base + 2.0;
        joystick.control.command_nm[i]      = base + 3.0;
        joystick.display.torque_nm[i]       = base + 4.0;
    }
    joystick.control.limited = 9U;
    for (unsigned mode = 0U; mode < 2U; mode++) {
        joystick.is_reflecting = (mode == 1U);
        callbacks->control(&joystick);
        joystick_hand_position_payload_t hand;
        memcpy(&hand, generic.ports[HAND].written, sizeof hand);
        for (unsigned i = 0U; i < STICK_AXES; i++) {
            const double base = 100.0 * (double)(i + 1U);
            EXPECT_WITHIN(base + 1.0, 0.0, shown->cur_values.position[i]);
            EXPECT_WITHIN(base + 2.0, 0.0, shown->cur_values.velocity[i]);
            EXPECT_WITHIN(base + 3.0, 0.0, shown->cur_values.felt_torque[i]);
            TEST_ASSERT_EQUAL_HEX16(0U, shown->cur_values.statusword[i]); // No configuration is applied.
            EXPECT_WITHIN((mode == 1U) ? 0.0 : (base + 4.0), 0.0, shown->des_torque[i]);
            EXPECT_WITHIN(base + 1.0, 0.0, hand.position[i]);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(9U, shown->counters.command_limited);
}

int main(void)
{
    descriptor_loader_init(&loader);
    if (descriptor_load_subsystem(&loader, "descriptors/subsystems/joystick.xml", &descriptor) != STATUS_OK) {
        (void)puts(descriptor_error(&loader));
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(telepresence_from_offline_and_back);
    RUN_TEST(the_displayed_torque_rises_smoothly_to_the_robot_s_torque);
    RUN_TEST(a_torque_that_is_not_renewed_expires);
    RUN_TEST(no_torque_is_applied_until_engaged);
    RUN_TEST(unplugging_is_noticed_at_once);
    RUN_TEST(force_displays_a_torque_for_a_time);
    RUN_TEST(a_force_is_allowed_up_to_the_ceiling);
    RUN_TEST(stop_and_leaving_operation_end_a_force);
    RUN_TEST(setting_the_desired_torque_lasts_until_stop);
    RUN_TEST(a_telepresence_joystick_displays_nothing);
    RUN_TEST(events_and_counters_are_published);
    RUN_TEST(the_channel_of_the_bus_is_selected_by_command);
    RUN_TEST(a_function_that_it_does_not_have_is_refused);
    RUN_TEST(a_release_closes_the_bus);
    RUN_TEST(only_a_descriptor_of_one_stick_fits);
    RUN_TEST(configuring_forgets_forces_and_the_command_of_before);
    RUN_TEST(a_force_ends_once);
    RUN_TEST(the_desired_torque_is_taken_only_where_it_is_allowed);
    RUN_TEST(every_value_of_both_axes_is_published);
    return UNITY_END();
}
