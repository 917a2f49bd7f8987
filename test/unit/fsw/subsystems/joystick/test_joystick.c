// SPDX-License-Identifier: Apache-2.0
// The joystick from OFFLINE to OPERATIONAL and back, with its real descriptor, a scripted device and a
// scripted robot.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/joystick/joystick_rig.h"

#include "pus/core/tailoring.h"
#include "unity.h"

#include <math.h>
#include <string.h>

void setUp(void)
{
    rig_set_up();
}

void tearDown(void)
{
    rig_tear_down();
}

static void robot_feels(const double first_nm, const double second_nm)
{
    const joystick_robot_state_payload_t robot = {{1.0, -1.5}, {first_nm, second_nm}};
    memcpy(rig_generic.ports[ROBOT].sample, &robot, sizeof robot);
    rig_generic.ports[ROBOT].read_status = STATUS_OK;
    rig_generic.ports[ROBOT].age_us      = 500U;
}

static void the_joystick_goes_from_offline_to_telepresence_and_back(void)
{
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    rig_idle(5U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, rig_stick->status[0]);
    joystick_hand_position_payload_t hand;
    // Links may be used as soon as they are open.
    TEST_ASSERT_EQUAL_UINT64(sizeof hand, rig_generic.ports[HAND].written_size);
    memcpy(&hand, rig_generic.ports[HAND].written, sizeof hand);
    EXPECT_WITHIN(0.05, 1.0e-9, hand.position[0]);
    EXPECT_WITHIN(-0.02, 1.0e-9, hand.position[1]);
    robot_feels(0.0, 0.0);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->start_control));
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_stick->status[0]);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_stick->status[1]);
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    TEST_ASSERT_EQUAL_HEX16(0x0237U, rig_stick->status[1]);
    rig_idle(50U);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->disengage));
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_stick->status[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->stop_control));
    rig_generic.state = STATE_POST_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->post));
    rig_generic.state = STATE_HARDWARE_DEINIT;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->hardware_deinit));
    TEST_ASSERT_EQUAL_UINT(2U, rig_stick->boots);
    TEST_ASSERT_EQUAL_UINT(0U, rig_generic.event_count);
}

/// The torque of the robot has the direction of the motion of the stick, which oscillates by 1 mrad.
static void a_stick_that_gives_energy_at_rest_is_reported(void)
{
    robot_feels(0.0, 0.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_joystick.parameters.passivity.limit = 2.0e-3;
    rig_joystick.parameters.passivity.time  = 0.5;
    for (unsigned i = 0U; i < 2400U; i++) {
        const bool is_up = ((i / 50U) % 2U) == 0U;
        robot_feels(is_up ? 9.0 : -9.0, 0.0);
        rig_stick->position[0] += is_up ? 20 : -20;
        rig_idle(1U);
    }
    TEST_ASSERT_EQUAL_UINT(2U, double_events(&rig_generic, JOYSTICK_EVENT_PASSIVITY));
    const double_event_t* const event = double_last_event(&rig_generic, JOYSTICK_EVENT_PASSIVITY);
    octet_reader_t reader             = octet_reader(event->octets, event->size);
    EXPECT_ABOVE(2.0e-3, octet_read_f64(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    EXPECT_BELOW(0.0, rig_joystick.parameters.energy.taken);
    EXPECT_ABOVE(2.0e-3, rig_joystick.parameters.energy.given);
    // The energy is counted from zero again.
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    TEST_ASSERT_TRUE(rig_joystick.energy.given_j == 0.0);
}

/// The displayed torque is FORCE_SCALE (0.03) times the torque of the robot.
static void the_displayed_torque_rises_smoothly_to_the_robot_s_torque(void)
{
    double before = 0.0;
    robot_feels(-11.0, 8.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    EXPECT_WITHIN(0.0, 0.02, rig_torque(0U));
    for (unsigned i = 0U; i < 8000U; i++) {
        (void)rig_cycle(NULL);
        EXPECT_BELOW(0.005, fabs(rig_torque(0U) - before)); // 0.33 Nm rise smoothly in 400 cycles.
        before = rig_torque(0U);
    }
    EXPECT_WITHIN(-0.33, 1.0e-4, rig_torque(0U));
    EXPECT_WITHIN(0.24, 1.0e-4, rig_torque(1U));
    EXPECT_WITHIN(-0.33, 1.0e-4, rig_joystick.parameters.cur_values.felt_torque[0]);
}

static void a_torque_that_is_not_renewed_expires(void)
{
    robot_feels(-11.0, 8.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_idle(8000U);
    rig_generic.ports[ROBOT].read_status = STATUS_STALE;
    rig_idle(41U); // In each cycle the torque decays by 10 %.
    EXPECT_WITHIN(0.0, 0.01, rig_torque(0U));
    EXPECT_WITHIN(0.0, 0.2, rig_joystick.felt_nm[0]);
}

static void no_torque_is_applied_until_engaged(void)
{
    robot_feels(-11.0, 8.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    rig_idle(2000U);
    // The device applies no torque, whatever the control computes.
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_stick->status[0]);
    TEST_ASSERT_EQUAL_HEX16(0x0007U, rig_stick->control[0]);
}

static void unplugging_is_detected_at_once(void)
{
    robot_feels(0.0, 0.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_stick->is_plugged = false;
    const uint64_t cut_ns = rig_generic.now_ns;
    while ((rig_generic.state == STATE_OPERATIONAL) && ((rig_generic.now_ns - cut_ns) < 10000000U)) {
        (void)rig_cycle(NULL);
    }
    TEST_ASSERT_TRUE((rig_generic.now_ns - cut_ns) <= 2000000U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, JOYSTICK_EVENT_DEVICE_LOST));
    TEST_ASSERT_EQUAL_HEX8(0x21U, double_last_event(&rig_generic, JOYSTICK_EVENT_DEVICE_LOST)->octets[0]);
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, rig_generic.ports[HAND].written_state);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->secure));
}

static void the_function_force_displays_a_torque_for_a_time(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 0.5};
    const joystick_force_arguments_t large = {{1.6, 0.0}, 0.5};
    const joystick_force_arguments_t never = {{0.1, 0.0}, 0.0};
    const joystick_force_arguments_t none  = {{(double)NAN, 0.0}, 0.5};
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(JOYSTICK_FUNCTION_FORCE, &large, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(JOYSTICK_FUNCTION_FORCE, &never, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(JOYSTICK_FUNCTION_FORCE, &none, 1U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 11U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 12U));
    rig_idle(500U);
    EXPECT_WITHIN(0.3, 1.0e-4, rig_torque(0U));
    EXPECT_WITHIN(-0.15, 1.0e-4, rig_torque(1U));
    EXPECT_WITHIN(0.3, 1.0e-12, rig_joystick.parameters.des_torque[0]);
    TEST_ASSERT_EQUAL_UINT(0U, rig_generic.result_count);
    rig_idle(510U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL_UINT32(11U, rig_generic.results[0].call_token);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_generic.results[0].detail);
    EXPECT_WITHIN(0.0, 1.0e-4, rig_torque(0U));
}

/// A force equal to the ceiling is allowed on each axis in both directions; a greater one is not.
static void a_force_is_allowed_up_to_the_ceiling(void)
{
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    const double ceiling = rig_joystick.parameters.control.torque_ceiling;
    const double above   = nextafter(ceiling, 2.0 * ceiling);
    for (unsigned axis = 0U; axis < 2U; axis++) {
        for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
            joystick_force_arguments_t force = {{0.0, 0.0}, 0.5};
            force.torque[axis]               = sign * above;
            TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
            force.torque[axis] = sign * ceiling;
            TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
            rig_idle(1010U);
        }
    }
    TEST_ASSERT_EQUAL_UINT(4U, rig_generic.result_count);
}

static void stop_and_leaving_operation_end_a_force(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 5.0};
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    rig_idle(500U);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(JOYSTICK_FUNCTION_STOP, NULL, 2U));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    rig_idle(200U);
    EXPECT_WITHIN(0.0, 1.0e-4, rig_torque(0U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 3U));
    rig_idle(500U);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    (void)rig_run_action(rig_callbacks->disengage);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[1].code);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(JOYSTICK_FUNCTION_STOP, NULL, 4U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rig_perform(99U, NULL, 4U));
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    rig_idle(500U);
    EXPECT_WITHIN(0.0, 1.0e-4, rig_torque(0U)); // The force does not continue.
}

static void setting_the_desired_torque_lasts_until_stop(void)
{
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    rig_joystick.parameters.des_torque[0] = 0.2;
    rig_joystick.parameters.des_torque[1] = 0.0;
    rig_callbacks->parameter_set(&rig_joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    rig_idle(20000U);
    EXPECT_WITHIN(0.2, 1.0e-4, rig_torque(0U));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(JOYSTICK_FUNCTION_STOP, NULL, 4U));
    rig_idle(200U);
    EXPECT_WITHIN(0.0, 1.0e-4, rig_torque(0U));
    rig_callbacks->parameter_set(&rig_joystick, JOYSTICK_PARAMETER_CONTROL);
}

static void in_telepresence_no_commanded_force_is_displayed(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 5.0};
    robot_feels(0.0, 0.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(JOYSTICK_FUNCTION_STOP, NULL, 1U));
    rig_joystick.parameters.des_torque[0] = 0.2;
    rig_callbacks->parameter_set(&rig_joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    rig_idle(400U);
    EXPECT_WITHIN(0.0, 1.0e-4, rig_torque(0U));
    EXPECT_WITHIN(0.0, 1.0e-12, rig_joystick.parameters.des_torque[0]);
}

static void events_and_counters_are_published(void)
{
    const joystick_raise_arguments_t note = {JOYSTICK_EVENT_OPERATOR_NOTE};
    const joystick_raise_arguments_t lost = {JOYSTICK_EVENT_DEVICE_LOST};
    robot_feels(0.0, 0.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(JOYSTICK_FUNCTION_RAISE, &note, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(JOYSTICK_FUNCTION_RAISE, &lost, 1U));
    scripted_bus_deliver(&rig_bus, 0x123U, NULL, 0U);
    scripted_bus_emergency(&rig_bus, 0x21U, 0x4310U);
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      flow_can_send(rig_joystick.drives.buses[0].network.flow, 0x800U, NULL, 0U));
    rig_idle(2U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, JOYSTICK_EVENT_DRIVE_WARNING));
    const joystick_counters_t* const counters = &rig_joystick.parameters.counters;
    TEST_ASSERT_EQUAL_UINT32(rig_generic.cycle, counters->cycles);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->frames_refused);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->emergencies);
    TEST_ASSERT_EQUAL_UINT32(0U, counters->pdo_missed);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->transmit_refused);
    TEST_ASSERT_EQUAL_UINT32(0U, counters->transmit_full); // The frames were refused for another reason.
    TEST_ASSERT_EQUAL_UINT32(500U, rig_joystick.parameters.link_age);
    TEST_ASSERT_EQUAL_INT32(STATE_OPERATIONAL, rig_joystick.parameters.cur_values.state);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, rig_joystick.parameters.cur_values.statusword[1]);
    EXPECT_WITHIN(0.05, 1.0e-9, rig_joystick.parameters.cur_values.position[0]);
}

/// CHANNEL selects a channel of the bus, reports it, and refuses one that the bus does not have.
static void the_channel_of_the_bus_is_selected_by_command(void)
{
    const joystick_channel_arguments_t first  = {NETWORK_CHANNEL_A};
    const joystick_channel_arguments_t second = {NETWORK_CHANNEL_B};
    const joystick_channel_arguments_t third  = {NETWORK_CHANNELS};
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(JOYSTICK_FUNCTION_CHANNEL, &second, 1U));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_B, rig_joystick.drives.buses[0].network.channel);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, JOYSTICK_EVENT_CHANNEL_SELECTED));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(JOYSTICK_FUNCTION_CHANNEL, &third, 1U));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_B, rig_joystick.drives.buses[0].network.channel);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(JOYSTICK_FUNCTION_CHANNEL, &first, 1U));
    TEST_ASSERT_EQUAL_UINT8(NETWORK_CHANNEL_A, rig_joystick.drives.buses[0].network.channel);
    TEST_ASSERT_EQUAL_UINT(2U, double_events(&rig_generic, JOYSTICK_EVENT_CHANNEL_SELECTED));
}

static void an_unknown_function_is_refused(void)
{
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rig_perform(UINT16_MAX, NULL, 1U));
}

static void a_release_closes_the_bus(void)
{
    rig_callbacks->release(&rig_joystick); // The joystick has no bus yet.
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    TEST_ASSERT_TRUE(flow_can_is_open(rig_joystick.drives.buses[0].network.flow));
    rig_callbacks->release(&rig_joystick);
    TEST_ASSERT_FALSE(flow_can_is_open(rig_joystick.drives.buses[0].network.flow));
    rig_generic.state = STATE_HARDWARE_DEINIT;
    // The action succeeds at once, because there is no device to reset.
    TEST_ASSERT_EQUAL(STATUS_OK, rig_cycle(rig_callbacks->hardware_deinit));
}

static void only_a_descriptor_of_one_stick_fits(void)
{
    static subsystem_descriptor_t wrong;
    subsystem_misfit_t misfit = {0};
    TEST_ASSERT_TRUE(rig_callbacks->fits(&rig_descriptor, &misfit));
    TEST_ASSERT_NULL(misfit.reason);
    wrong = rig_descriptor; // The copy refers to the same texts.
    descriptor_subsystem_use_storage(&wrong);
    wrong.storage.configurations[0].device_count++;
    wrong.storage
        .endnodes[wrong.storage.devices[wrong.storage.configurations[0].first_device + 1U].first_endnode]
        .node = 0x7EU;
    TEST_ASSERT_FALSE(rig_callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_NOT_NULL(strstr(misfit.reason, "expected one <Device>, the stick"));
    wrong = rig_descriptor;
    descriptor_subsystem_use_storage(&wrong);
    for (uint16_t i = 0U; i < wrong.setting_count; i++) {
        wrong.storage.settings[i].bits =
            (wrong.storage.settings[i].index == 0x6060U) ? 1U : wrong.storage.settings[i].bits;
    }
    TEST_ASSERT_FALSE(rig_callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_NOT_NULL(strstr(misfit.reason, "0x6060:00 to 10 (torque)"));
    wrong = rig_descriptor;
    descriptor_subsystem_use_storage(&wrong);
    wrong.storage.devices[wrong.storage.configurations[0].first_device].type = "joint-drive";
    TEST_ASSERT_FALSE(rig_callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_NOT_NULL(strstr(misfit.reason, "expected a class of CiA 402 with two axes"));
}

/// Forces received in the earlier configuration do not count: the robot that is coupled next may be another.
static void configuring_discards_earlier_forces_and_commands(void)
{
    robot_feels(-11.0, 8.0);
    rig_bring(JOYSTICK_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_idle(8000U);
    TEST_ASSERT_TRUE(fabs(rig_joystick.felt_nm[0]) > 10.0);
    TEST_ASSERT_TRUE(rig_joystick.share == 1.0);
    rig_generic.ports[ROBOT].read_status = STATUS_STALE;
    rig_generic.state                    = STATE_PRE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_callbacks->configure(&rig_joystick, rig_generic.configuration));
    TEST_ASSERT_TRUE((rig_joystick.felt_nm[0] == 0.0) && (rig_joystick.felt_nm[1] == 0.0));
    TEST_ASSERT_FALSE(rig_joystick.control.is_started);
    TEST_ASSERT_TRUE(rig_joystick.control.command_nm[0] == 0.0);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_configure));
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->start_control));
    rig_generic.state = STATE_OPERATIONAL;
    (void)rig_cycle(rig_callbacks->engage);
    EXPECT_BELOW(0.01, rig_joystick.share); // The torque fades in again.
}

/// After a force has ended, STOP and leaving OPERATIONAL do not report its end again.
static void a_force_ends_once(void)
{
    const joystick_force_arguments_t force = {{0.3, -0.15}, 0.1};
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    rig_idle(300U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(JOYSTICK_FUNCTION_STOP, NULL, 2U));
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    (void)rig_run_action(rig_callbacks->disengage);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
}

/// DES_TORQUE has no effect while FORCE is performed, or if it is out of range.
static void the_desired_torque_has_an_effect_only_where_it_is_allowed(void)
{
    const joystick_force_arguments_t force = {{0.3, 0.0}, 5.0};
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_OPERATIONAL);
    rig_joystick.parameters.des_torque[0] = 2.0 * rig_joystick.parameters.control.torque_ceiling;
    rig_callbacks->parameter_set(&rig_joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    rig_idle(100U);
    EXPECT_WITHIN(0.0, 1.0e-4, rig_torque(0U));
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(JOYSTICK_FUNCTION_FORCE, &force, 1U));
    rig_idle(500U);
    rig_joystick.parameters.des_torque[0] = 0.1;
    rig_callbacks->parameter_set(&rig_joystick, JOYSTICK_PARAMETER_DES_TORQUE);
    rig_idle(500U);
    EXPECT_WITHIN(0.3, 1.0e-4, rig_torque(0U));
    TEST_ASSERT_EQUAL_UINT(0U, rig_generic.result_count);
}

/// Each axis and each quantity has its own field, whether process data flow or not.
static void every_value_of_both_axes_is_published(void)
{
    const joystick_parameters_t* const shown = &rig_joystick.parameters;
    rig_bring(JOYSTICK_CONFIGURATION_STAND_ALONE, STATE_PRE_OPERATIONAL);
    rig_idle(3U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, shown->cur_values.statusword[1]);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->post));
    for (unsigned i = 0U; i < STICK_AXES; i++) {
        const double base                       = 100.0 * (double)(i + 1U);
        rig_joystick.control.position_rad[i]    = base + 1.0;
        rig_joystick.control.motion[i].velocity = base + 2.0;
        rig_joystick.control.command_nm[i]      = base + 3.0;
        rig_joystick.display.torque_nm[i]       = base + 4.0;
    }
    rig_joystick.control.limited = 9U;
    for (unsigned mode = 0U; mode < 2U; mode++) {
        rig_joystick.is_reflecting = (mode == 1U);
        rig_callbacks->control(&rig_joystick);
        joystick_hand_position_payload_t hand;
        memcpy(&hand, rig_generic.ports[HAND].written, sizeof hand);
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
    if (!rig_load()) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(the_joystick_goes_from_offline_to_telepresence_and_back);
    RUN_TEST(a_stick_that_gives_energy_at_rest_is_reported);
    RUN_TEST(the_displayed_torque_rises_smoothly_to_the_robot_s_torque);
    RUN_TEST(a_torque_that_is_not_renewed_expires);
    RUN_TEST(no_torque_is_applied_until_engaged);
    RUN_TEST(unplugging_is_detected_at_once);
    RUN_TEST(the_function_force_displays_a_torque_for_a_time);
    RUN_TEST(a_force_is_allowed_up_to_the_ceiling);
    RUN_TEST(stop_and_leaving_operation_end_a_force);
    RUN_TEST(setting_the_desired_torque_lasts_until_stop);
    RUN_TEST(in_telepresence_no_commanded_force_is_displayed);
    RUN_TEST(events_and_counters_are_published);
    RUN_TEST(the_channel_of_the_bus_is_selected_by_command);
    RUN_TEST(an_unknown_function_is_refused);
    RUN_TEST(a_release_closes_the_bus);
    RUN_TEST(only_a_descriptor_of_one_stick_fits);
    RUN_TEST(configuring_discards_earlier_forces_and_commands);
    RUN_TEST(a_force_ends_once);
    RUN_TEST(the_desired_torque_has_an_effect_only_where_it_is_allowed);
    RUN_TEST(every_value_of_both_axes_is_published);
    return UNITY_END();
}
