// SPDX-License-Identifier: Apache-2.0
// The manipulator from OFFLINE to OPERATIONAL and back.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/manipulator/manipulator_rig.h"

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

// ---- Life ----

static void the_manipulator_goes_from_offline_to_telepresence_and_back(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    rig_idle(10U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, rig_joints[0]->status[0]); // No voltage yet.
    TEST_ASSERT_EQUAL_UINT(2U, rig_joints[0]->last_pdo);        // Torque mode.
    TEST_ASSERT_EQUAL_UINT32(10U, scripted_object(rig_joints[0], 0x6060U, 0U)->value);
    TEST_ASSERT_TRUE(rig_generic.ports[ROBOT].writes > 5U); // The links work before the controllers start.
    rig_hand_at(0.0, 0.0);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->start_control));
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_joints[0]->status[0]); // The brakes hold the arm.
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_joints[1]->status[0]);
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    TEST_ASSERT_EQUAL_HEX16(0x0237U, rig_joints[0]->status[0]);
    rig_idle(100U);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, rig_joints[1]->status[0]);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->disengage));
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_joints[1]->status[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->stop_control));
    TEST_ASSERT_EQUAL_HEX16(0x0250U, rig_joints[1]->status[0]);
    rig_generic.state = STATE_POST_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->post));
    rig_idle(2U);
    TEST_ASSERT_EQUAL_HEX8(0x7FU, rig_joints[0]->nmt);
    rig_generic.state = STATE_HARDWARE_DEINIT;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->hardware_deinit));
    TEST_ASSERT_EQUAL_UINT(2U, rig_joints[0]->boots);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.event_count); // TARE_DONE and nothing else.
}

static void leaving_operation_takes_one_cycle(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    (void)rig_cycle(rig_callbacks->disengage);
    TEST_ASSERT_EQUAL_HEX16(0x0007U, rig_joints[0]->control[0]);
    TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_joints[0]->status[0]);
}

static void a_subsystem_that_ended_can_be_initialised_again(void)
{
    for (unsigned life = 0U; life < 2U; life++) {
        rig_hand_at(0.0, 0.0);
        rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
        rig_generic.state = STATE_ERROR_OPERATIONAL;
        (void)rig_run_action(rig_callbacks->secure);
        rig_generic.state = STATE_POST_OPERATIONAL;
        TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->post));
        rig_generic.state = STATE_HARDWARE_DEINIT;
        TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->hardware_deinit));
        parameter_withdraw_all(&rig_generic.dictionary);
        TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&rig_generic));
        rig_generic.configuration = NULL;
    }
    TEST_ASSERT_EQUAL_UINT(2U, double_events(&rig_generic, MANIPULATOR_EVENT_TARE_DONE));
    TEST_ASSERT_EQUAL_UINT(2U, rig_generic.event_count);
}

static void a_missing_bus_fails_at_once(void)
{
    scripted_bus_close(&rig_bus);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rig_cycle(rig_callbacks->hardware_init));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_cycle(rig_callbacks->hardware_deinit));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_cycle(rig_callbacks->secure));
    TEST_ASSERT_EQUAL(STATUS_OK, rig_cycle(rig_callbacks->post));
    scripted_bus_open(&rig_bus, "test-manipulator");
}

static void a_release_closes_the_bus(void)
{
    rig_callbacks->release(&rig_manipulator); // The manipulator has no bus yet.
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    TEST_ASSERT_TRUE(flow_can_is_open(rig_manipulator.drives.buses[0].network.flow));
    rig_callbacks->release(&rig_manipulator);
    TEST_ASSERT_FALSE(flow_can_is_open(rig_manipulator.drives.buses[0].network.flow));
    rig_generic.state = STATE_HARDWARE_DEINIT;
    // The action succeeds at once, because there is no device to reset.
    TEST_ASSERT_EQUAL(STATUS_OK, rig_cycle(rig_callbacks->hardware_deinit));
}

static void only_a_descriptor_of_two_joints_fits(void)
{
    static subsystem_descriptor_t wrong;
    subsystem_misfit_t misfit = {0};
    TEST_ASSERT_TRUE(rig_callbacks->fits(&rig_descriptor, &misfit));
    TEST_ASSERT_NULL(misfit.reason);
    wrong = rig_descriptor; // The copy refers to the same texts.
    descriptor_subsystem_use_storage(&wrong);
    wrong.storage.configurations[0].device_count--;
    TEST_ASSERT_FALSE(rig_callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_NOT_NULL(strstr(misfit.reason, "expected two <Device>, one for each joint"));
    wrong.storage.configurations[0].device_count++;
    wrong.storage.devices[wrong.storage.configurations[0].first_device].type = "joystick";
    TEST_ASSERT_FALSE(rig_callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_NOT_NULL(strstr(misfit.reason, "expected a class of CiA 402 with one axis"));
}

static void joints_in_two_modes_do_not_fit(void)
{
    static subsystem_descriptor_t wrong;
    subsystem_misfit_t misfit = {0};
    wrong                     = rig_descriptor; // The copy refers to the same texts.
    descriptor_subsystem_use_storage(&wrong);
    const descriptor_device_t* const joint = &wrong.devices[wrong.configurations[0].first_device + 1U];
    for (uint16_t i = 0U; i < joint->setting_count; i++) {
        descriptor_setting_t* const setting = &wrong.storage.settings[joint->first_setting + i];
        if (setting->index == 0x6060U) {
            setting->bits = (setting->bits == 8U) ? 10U : 8U;
        }
    }
    TEST_ASSERT_FALSE(rig_callbacks->fits(&wrong, &misfit));
    TEST_ASSERT_EQUAL_UINT32(joint->line, misfit.line);
    TEST_ASSERT_NOT_NULL(strstr(misfit.reason, "the same for both joints"));
}

static void the_sensors_are_tared_while_the_brakes_hold(void)
{
    rig_show(GRAVITY1 + 0.2, GRAVITY2 - 0.15);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    const uint64_t begun_ns = rig_generic.now_ns;
    while ((double_events(&rig_generic, MANIPULATOR_EVENT_TARE_DONE) == 0U) &&
           ((rig_generic.now_ns - begun_ns) < 1000000000U)) {
        (void)rig_cycle(NULL);
    }
    TEST_ASSERT_EQUAL_UINT64(700000000U, rig_generic.now_ns - begun_ns);
    EXPECT_WITHIN(0.2, 0.02, rig_manipulator.tare.offset_nm[0]);
    EXPECT_WITHIN(-0.15, 0.02, rig_manipulator.tare.offset_nm[1]);
    const double_event_t* const event = double_last_event(&rig_generic, MANIPULATOR_EVENT_TARE_DONE);
    octet_reader_t reader             = octet_reader(event->octets, event->size);
    EXPECT_WITHIN(0.2, 0.02, octet_read_f64(&reader));
    EXPECT_WITHIN(-0.15, 0.02, octet_read_f64(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    rig_idle(200U);
    EXPECT_WITHIN(0.0, 0.02, rig_values()->external_torque[0]);
    EXPECT_WITHIN(0.0, 0.02, rig_values()->external_torque[1]);
}

static void torque_mode_waits_for_the_tare(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    rig_idle(100U);
    rig_generic.state = STATE_OPERATIONAL;
    for (unsigned i = 0U; i < 1000U; i++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, rig_cycle(rig_callbacks->engage));
        TEST_ASSERT_EQUAL_HEX16(0x0233U, rig_joints[0]->status[0]);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
}

static void torque_mode_does_not_engage_in_contact_without_a_zero(void)
{
    rig_hand_at(0.0, 0.0);
    rig_show(GRAVITY1 - 4.0, GRAVITY2);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_run_action(rig_callbacks->engage));
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&rig_generic, MANIPULATOR_EVENT_TARE_DONE));
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    rig_show(GRAVITY1, GRAVITY2); // The contact has ended: tare on command.
    rig_idle(20U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_TARE, NULL, 5U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(MANIPULATOR_FUNCTION_TARE, NULL, 6U));
    rig_idle(1500U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL_UINT32(5U, rig_generic.results[0].call_token);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
}

static void a_sensor_zero_is_kept_until_the_hardware_is_initialised_again(void)
{
    rig_hand_at(0.0, 0.0);
    rig_show(GRAVITY1 + 0.2, GRAVITY2 - 0.15);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    (void)rig_run_action(rig_callbacks->disengage);
    (void)rig_run_action(rig_callbacks->stop_control);
    rig_show(GRAVITY1 - 4.0, GRAVITY2); // The arm is in contact now.
    (void)rig_run_action(rig_callbacks->start_control);
    rig_idle(1500U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_TARE, NULL, 3U));
    rig_idle(1500U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_DEVICE, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(STATUS_OUT_OF_RANGE, rig_generic.results[0].detail);
    EXPECT_WITHIN(0.2, 0.02, rig_manipulator.parameters.torque_offset[0]);
    rig_generic.state = STATE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    const double zero[2] = {rig_manipulator.control.zero_nm[0], rig_manipulator.control.zero_nm[1]};
    // A second configuration keeps the zero, too.
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_configure));
    EXPECT_WITHIN(zero[0], 0.0, rig_manipulator.control.zero_nm[0]);
    EXPECT_WITHIN(zero[1], 0.0, rig_manipulator.control.zero_nm[1]);
}

static void a_command_takes_over_the_automatic_tare(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    rig_idle(600U);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_TARE, NULL, 9U));
    rig_idle(900U);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MANIPULATOR_EVENT_TARE_DONE));
}

static void engaging_commands_the_present_torques_of_the_joints(void)
{
    rig_hand_at(0.21, -0.17);
    rig_show(GRAVITY1 + 0.05, GRAVITY2 - 0.03);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    for (unsigned i = 0U; i < 200U; i++) {
        (void)rig_cycle(NULL);
        EXPECT_WITHIN(GRAVITY1, 0.05, 0.01 * (double)rig_joints[0]->target_torque[0]);
        EXPECT_WITHIN(GRAVITY2, 0.05, 0.01 * (double)rig_joints[1]->target_torque[0]);
    }
    rig_hand_at(0.21 + 0.001, -0.17);
    rig_idle(40U);
    EXPECT_ABOVE(GRAVITY1 + 5.0, 0.01 * (double)rig_joints[0]->target_torque[0]); // 2 mrad x 4000 Nm/rad.
}

// ---- Supervision ----

static void exceeding_the_torque_limit_is_reported_once_per_excess(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_manipulator.parameters.torque_limit[1] = 12.0;
    for (unsigned excess = 1U; excess <= 3U; excess++) {
        rig_show(GRAVITY1, -12.5);
        rig_idle(1U); // This cycle samples the torque.
        TEST_ASSERT_EQUAL_UINT(excess - 1U, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
        rig_idle(1U); // The next cycle detects and reports the excess.
        TEST_ASSERT_EQUAL_UINT(excess, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
        rig_idle(50U);
        rig_show(GRAVITY1, -11.8); // Still within the hysteresis.
        rig_idle(3U);
        rig_show(GRAVITY1, -12.5);
        rig_idle(3U);
        TEST_ASSERT_EQUAL_UINT(excess, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
        rig_show(GRAVITY1, -11.0);
        rig_idle(3U);
    }
    const double_event_t* const event = double_last_event(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT);
    octet_reader_t reader             = octet_reader(event->octets, event->size);
    TEST_ASSERT_EQUAL_UINT8(2U, octet_read_u8(&reader));
    EXPECT_WITHIN(-12.5, 1.0e-9, octet_read_f64(&reader));
    EXPECT_WITHIN(12.0, 0.0, octet_read_f64(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void the_torque_limit_is_checked_in_operation_only(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    rig_show(GRAVITY1, -50.0);
    rig_idle(50U);
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
}

static void an_unplugged_drive_stops_the_other_drive_in_that_cycle(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_joints[0]->is_plugged = false;
    const uint64_t cut_ns     = rig_generic.now_ns;
    while (rig_generic.state == STATE_OPERATIONAL) {
        (void)rig_cycle(NULL);
    }
    TEST_ASSERT_TRUE((rig_generic.now_ns - cut_ns) <= 2000000U);
    TEST_ASSERT_EQUAL_HEX16(0x0002U, rig_joints[1]->control[0]);
    const double_event_t* const event = double_last_event(&rig_generic, MANIPULATOR_EVENT_DEVICE_LOST);
    TEST_ASSERT_NOT_NULL(event);
    TEST_ASSERT_EQUAL_UINT64(MANIPULATOR_EVENT_DEVICE_LOST_OCTETS, event->size);
    TEST_ASSERT_EQUAL_HEX8(0x11U, event->octets[0]);
    // The sample to the joystick contains the state.
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, rig_generic.ports[ROBOT].written_state);
    rig_joints[1]->status[0] = 0x0250U;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->secure));
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MANIPULATOR_EVENT_DEVICE_LOST));
}

static void emergencies_become_events(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    scripted_bus_emergency(&rig_bus, 0x12U, 0x4310U);
    scripted_bus_emergency(&rig_bus, 0x12U, 0x8120U);
    rig_idle(1U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, rig_generic.state);
    const double_event_t* event = double_last_event(&rig_generic, MANIPULATOR_EVENT_DRIVE_WARNING);
    TEST_ASSERT_NOT_NULL(event);
    const uint8_t warning[] = {0x12U, 0x43U, 0x10U};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(warning, event->octets, 3U);
    TEST_ASSERT_EQUAL_UINT64(MANIPULATOR_EVENT_BUS_WARNING_OCTETS,
                             double_last_event(&rig_generic, MANIPULATOR_EVENT_BUS_WARNING)->size);
    scripted_bus_deliver(&rig_bus, 0x080U, NULL, 0U); // SYNC of another node.
    rig_idle(1U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MANIPULATOR_EVENT_SYNC_CONFLICT));
    TEST_ASSERT_EQUAL_UINT32(1U, rig_manipulator.parameters.counters.conflicting_syncs);
    scripted_bus_emergency(&rig_bus, 0x12U, 0x7305U);
    rig_idle(1U);
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, rig_generic.state);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MANIPULATOR_EVENT_DRIVE_FAULT));
}

static void without_its_link_the_arm_holds_its_position(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_idle(100U);
    rig_generic.ports[HAND].read_status           = STATUS_STALE;
    const manipulator_hand_position_payload_t far = {{0.3, 0.3}};
    memcpy(rig_generic.ports[HAND].sample, &far, sizeof far);
    for (unsigned i = 0U; i < 400U; i++) {
        (void)rig_cycle(NULL);
        EXPECT_WITHIN(GRAVITY1, 0.1, 0.01 * (double)rig_joints[0]->target_torque[0]);
    }
}

// ---- Telemetry ----

static void only_low_events_can_be_raised_by_command(void)
{
    const manipulator_raise_arguments_t note = {MANIPULATOR_EVENT_OPERATOR_NOTE};
    const manipulator_raise_arguments_t lost = {MANIPULATOR_EVENT_DEVICE_LOST};
    const manipulator_raise_arguments_t none = {999U};
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(MANIPULATOR_FUNCTION_RAISE, &note, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(MANIPULATOR_FUNCTION_RAISE, &lost, 1U));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(MANIPULATOR_FUNCTION_RAISE, &none, 1U));
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.event_count);
}

static void current_values_and_counters_are_published(void)
{
    rig_hand_at(0.1, 0.2);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_idle(10U);
    TEST_ASSERT_EQUAL_INT32(STATE_OPERATIONAL, rig_values()->state);
    EXPECT_WITHIN(1.0471975512, 1.0e-5, rig_values()->position[0]);
    EXPECT_WITHIN(GRAVITY2, 0.006, rig_values()->torque[1]);
    EXPECT_WITHIN(0.0, 0.001, rig_values()->velocity[0]);
    EXPECT_WITHIN(GRAVITY1, 0.05, rig_values()->command[0]);
    TEST_ASSERT_EQUAL_HEX16(0x0237U, rig_values()->statusword[1]);
    TEST_ASSERT_EQUAL_UINT32(1500U, rig_manipulator.parameters.link_age);
    const manipulator_counters_t* const counters = &rig_manipulator.parameters.counters;
    TEST_ASSERT_EQUAL_UINT32(rig_generic.cycle, counters->cycles);
    TEST_ASSERT_TRUE(counters->frames_received > 100U);
    TEST_ASSERT_TRUE(counters->frames_sent > 100U);
    TEST_ASSERT_EQUAL_UINT32(3U, counters->pool_peak); // Counters of the subsystem double.
    TEST_ASSERT_EQUAL_UINT32(4U, counters->pool_refused);
    TEST_ASSERT_EQUAL_UINT32(5U, counters->tc_refused);
    TEST_ASSERT_EQUAL_UINT32(0U, counters->frames_refused + counters->transmit_full + counters->emergencies);
    TEST_ASSERT_EQUAL(STATUS_INVALID,
                      flow_can_send(rig_manipulator.drives.buses[0].network.flow, 0x800U, NULL, 0U));
    scripted_bus_deliver(&rig_bus, 0x123U, NULL, 0U);
    scripted_bus_deliver(&rig_bus, 0x191U | OSAL_CAN_REMOTE, NULL, 0U);
    scripted_bus_emergency(&rig_bus, 0x11U, 0x8120U);
    rig_joints[1]->is_pdo_mute = true;
    rig_idle(1U);
    rig_joints[1]->is_pdo_mute = false;
    rig_idle(2U);
    TEST_ASSERT_EQUAL_UINT32(2U, counters->frames_refused);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->transmit_refused);
    TEST_ASSERT_EQUAL_UINT32(0U, counters->transmit_full); // The frames were refused for another reason.
    TEST_ASSERT_EQUAL_UINT32(1U, counters->emergencies);
    TEST_ASSERT_EQUAL_UINT32(1U, counters->pdo_missed[1]);
    rig_generic.ports[HAND].age_us = UINT32_MAX;
    rig_idle(1U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, rig_manipulator.parameters.link_age);
    manipulator_robot_state_payload_t robot;
    TEST_ASSERT_EQUAL_UINT64(sizeof robot, rig_generic.ports[ROBOT].written_size);
    memcpy(&robot, rig_generic.ports[ROBOT].written, sizeof robot);
    EXPECT_WITHIN(rig_values()->position[0], 0.0, robot.position[0]);
    EXPECT_WITHIN(rig_values()->external_torque[1], 0.0, robot.external_torque[1]);
}

static void the_channel_is_selected_by_command(void)
{
    const manipulator_channel_arguments_t second = {1U};
    const manipulator_channel_arguments_t third  = {2U};
    TEST_ASSERT_EQUAL(STATUS_OK, rig_perform(MANIPULATOR_FUNCTION_CHANNEL, &second, 1U));
    TEST_ASSERT_EQUAL_UINT8(1U,
                            double_last_event(&rig_generic, MANIPULATOR_EVENT_CHANNEL_SELECTED)->octets[0]);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, rig_perform(MANIPULATOR_FUNCTION_CHANNEL, &third, 1U));
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MANIPULATOR_EVENT_CHANNEL_SELECTED));
}

/// Leaving SAFE_OPERATIONAL ends a tare with its command; the next one is accepted.
static void a_tare_whose_state_is_left_is_aborted_once_and_can_be_repeated(void)
{
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_SAFE_OPERATIONAL);
    TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_TARE, NULL, 5U));
    rig_generic.state = STATE_PRE_OPERATIONAL;
    (void)rig_run_action(rig_callbacks->stop_control);
    TEST_ASSERT_EQUAL_UINT(1U, rig_generic.result_count);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ABORTED, rig_generic.results[0].code);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_generic.results[0].detail);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, rig_manipulator.tare.result);
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, rig_perform(MANIPULATOR_FUNCTION_TARE, NULL, 6U));
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->start_control));
    for (uint32_t token = 7U; token < 9U; token++) {
        TEST_ASSERT_EQUAL(STATUS_BUSY, rig_perform(MANIPULATOR_FUNCTION_TARE, NULL, token));
        rig_idle(1500U);
        TEST_ASSERT_EQUAL_UINT(token - 5U, rig_generic.result_count);
        TEST_ASSERT_EQUAL_UINT32(token, rig_generic.results[token - 6U].call_token);
    }
    (void)rig_run_action(rig_callbacks->stop_control);
    TEST_ASSERT_EQUAL_UINT(3U, rig_generic.result_count);
}

/// Initialising the hardware discards the zero, because a sensor may have been replaced.
static void initialising_the_hardware_again_removes_the_zero(void)
{
    rig_show(GRAVITY1 + 0.2, GRAVITY2 - 0.15);
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    EXPECT_WITHIN(0.2, 0.02, rig_manipulator.tare.offset_nm[0]);
    EXPECT_ABOVE(3.03, rig_manipulator.model.link_mass[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->post));
    rig_idle(1U);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->hardware_deinit));
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    TEST_ASSERT_FALSE(rig_manipulator.has_zero);
    EXPECT_WITHIN(0.0, 0.0, rig_manipulator.control.zero_nm[0]);
    TEST_ASSERT_TRUE(rig_manipulator.model.link_mass[0] == 3.0);
    EXPECT_WITHIN(0.0, 0.0, rig_manipulator.control.zero_nm[1]);
}

/// An excess of torque from before is reported again if it still exists when the arm is engaged.
static void the_torque_limit_is_checked_again_after_each_engagement(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_manipulator.parameters.torque_limit[0] = 12.0;
    rig_manipulator.parameters.torque_limit[1] = 12.0;
    for (unsigned i = 1U; i <= 2U; i++) {
        rig_show(12.5, -12.5);
        rig_idle(5U);
        TEST_ASSERT_EQUAL_UINT(2U * i, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
        rig_generic.state = STATE_SAFE_OPERATIONAL;
        (void)rig_run_action(rig_callbacks->disengage);
        rig_generic.state = STATE_OPERATIONAL;
        TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    }
}

/// A torque equal to the limit is not reported; an excess ends when the torque is at most 95 % of the limit.
static void the_torque_limit_is_the_largest_torque_that_is_allowed(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_manipulator.parameters.torque_limit[1] = fabs(rig_joints[1]->torque[0] * 0.01);
    rig_idle(5U);
    TEST_ASSERT_EQUAL_UINT(0U, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
    rig_manipulator.parameters.torque_limit[1] *= 0.999;
    rig_idle(5U);
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
}

/// Each joint and each quantity has its own field, whether process data flow or not.
static void every_value_of_both_joints_is_published(void)
{
    manipulator_arm_control_t* const control    = &rig_manipulator.control;
    const manipulator_parameters_t* const shown = &rig_manipulator.parameters;
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_PRE_OPERATIONAL);
    rig_idle(3U);
    TEST_ASSERT_EQUAL_HEX16(0x0250U, rig_values()->statusword[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->post));
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double base                  = 100.0 * (double)(i + 1U);
        control->link_rad[i]               = base + 1.0;
        control->observer.link[i].velocity = base + 2.0;
        control->torque_nm[i]              = base + 3.0;
        control->observer.external_nm[i]   = base + 4.0;
        control->command_nm[i]             = base + 5.0;
        control->motor_target_rad[i]       = base + 6.0;
        control->reference[i].position     = base + 7.0;
        control->zero_nm[i]                = base + 8.0;
    }
    control->limited = 9U;
    for (unsigned mode = 0U; mode < 2U; mode++) {
        rig_manipulator.is_torque_mode = (mode == 1U);
        rig_callbacks->control(&rig_manipulator);
        manipulator_robot_state_payload_t robot;
        memcpy(&robot, rig_generic.ports[ROBOT].written, sizeof robot);
        for (unsigned i = 0U; i < ARM_JOINTS; i++) {
            const double base = 100.0 * (double)(i + 1U);
            EXPECT_WITHIN(base + 1.0, 0.0, shown->cur_values.position[i]);
            EXPECT_WITHIN(base + 2.0, 0.0, shown->cur_values.velocity[i]);
            EXPECT_WITHIN(base + 3.0, 0.0, shown->cur_values.torque[i]);
            EXPECT_WITHIN(base + 4.0, 0.0, shown->cur_values.external_torque[i]);
            EXPECT_WITHIN(base + ((mode == 1U) ? 5.0 : 6.0), 0.0, shown->cur_values.command[i]);
            TEST_ASSERT_EQUAL_HEX16(0U, shown->cur_values.statusword[i]); // No configuration is applied.
            EXPECT_WITHIN(base + 7.0, 0.0, shown->des_position[i]);
            EXPECT_WITHIN(base + 8.0, 0.0, shown->torque_offset[i]);
            EXPECT_WITHIN(base + 1.0, 0.0, robot.position[i]);
            EXPECT_WITHIN(base + 4.0, 0.0, robot.external_torque[i]);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(9U, shown->counters.command_limited);
}

static void an_excess_of_torque_ends_at_95_percent_of_the_limit(void)
{
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_manipulator.parameters.torque_limit[1] = 20.0;
    for (unsigned i = 1U; i <= 2U; i++) {
        rig_show(GRAVITY1, 20.5);
        rig_idle(3U);
        TEST_ASSERT_EQUAL_UINT(i, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
        rig_show(GRAVITY1, 19.0);
        rig_idle(3U);
    }
    rig_show(GRAVITY1, 20.5);
    rig_idle(3U);
    rig_show(GRAVITY1, 19.01);
    rig_idle(3U);
    rig_show(GRAVITY1, 20.5);
    rig_idle(3U);
    TEST_ASSERT_EQUAL_UINT(3U, double_events(&rig_generic, MANIPULATOR_EVENT_TORQUE_LIMIT));
}

int main(void)
{
    if (!rig_load()) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(the_manipulator_goes_from_offline_to_telepresence_and_back);
    RUN_TEST(leaving_operation_takes_one_cycle);
    RUN_TEST(a_subsystem_that_ended_can_be_initialised_again);
    RUN_TEST(a_missing_bus_fails_at_once);
    RUN_TEST(a_release_closes_the_bus);
    RUN_TEST(only_a_descriptor_of_two_joints_fits);
    RUN_TEST(joints_in_two_modes_do_not_fit);
    RUN_TEST(the_sensors_are_tared_while_the_brakes_hold);
    RUN_TEST(torque_mode_waits_for_the_tare);
    RUN_TEST(torque_mode_does_not_engage_in_contact_without_a_zero);
    RUN_TEST(a_sensor_zero_is_kept_until_the_hardware_is_initialised_again);
    RUN_TEST(a_command_takes_over_the_automatic_tare);
    RUN_TEST(engaging_commands_the_present_torques_of_the_joints);
    RUN_TEST(exceeding_the_torque_limit_is_reported_once_per_excess);
    RUN_TEST(the_torque_limit_is_checked_in_operation_only);
    RUN_TEST(an_unplugged_drive_stops_the_other_drive_in_that_cycle);
    RUN_TEST(emergencies_become_events);
    RUN_TEST(without_its_link_the_arm_holds_its_position);
    RUN_TEST(only_low_events_can_be_raised_by_command);
    RUN_TEST(current_values_and_counters_are_published);
    RUN_TEST(the_channel_is_selected_by_command);
    RUN_TEST(a_tare_whose_state_is_left_is_aborted_once_and_can_be_repeated);
    RUN_TEST(initialising_the_hardware_again_removes_the_zero);
    RUN_TEST(the_torque_limit_is_checked_again_after_each_engagement);
    RUN_TEST(the_torque_limit_is_the_largest_torque_that_is_allowed);
    RUN_TEST(every_value_of_both_joints_is_published);
    RUN_TEST(an_excess_of_torque_ends_at_95_percent_of_the_limit);
    return UNITY_END();
}
