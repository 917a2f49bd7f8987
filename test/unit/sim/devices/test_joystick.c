// SPDX-License-Identifier: Apache-2.0
// The joystick: two axes in one node, each with its own state machine, torque and position.
#include "sim/devices/joystick.h"
#include "sim/devices/emergency.h"
#include "test/support/bounds.h"
#include "test/unit/sim/devices/master.h"
#include "test/unit/sim/devices/statuswords.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define ID 0x21U
#define SHEET "descriptors/devices/joystick.eds"
#define STEP_NS 500000U

static master_t master;
static joystick_t* joystick;
static joystick_truth_t stick;
static char error[EDS_ERROR_MAX];

static void read_truth(void* context, joystick_truth_t* out_truth)
{
    (void)context;
    *out_truth = stick;
}

void setUp(void)
{
    const joystick_config_t config = {.encoder    = {.counts_per_turn = 65536U, .gear_ratio = 1.0},
                                      .read_truth = read_truth};
    memset(&stick, 0, sizeof stick);
    master_open(&master, false);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK,
                                  joystick_create(master.bus, SHEET, ID, &config, &joystick, error), error);
    node_power_on(joystick_node(joystick));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
}

void tearDown(void)
{
    joystick_destroy(joystick);
    master_close(&master);
}

/// One cycle of the master: controlword and target torque of both axes in the RPDO, SYNC, and one step.
static void cycle(uint16_t first, uint16_t second, double first_nm, double second_nm)
{
    const int16_t a       = (int16_t)lround(first_nm * 1e4);
    const int16_t b       = (int16_t)lround(second_nm * 1e4);
    const uint8_t data[8] = {
        (uint8_t)a,     (uint8_t)((uint16_t)a >> 8), (uint8_t)b,      (uint8_t)((uint16_t)b >> 8),
        (uint8_t)first, (uint8_t)(first >> 8),       (uint8_t)second, (uint8_t)(second >> 8)};
    master_send(&master, 0x200U + ID, data, 8U);
    master_send(&master, 0x080U, NULL, 0U);
    master_wait(&master, STEP_NS);
    joystick_end_step(joystick, bus_now_ns(master.bus));
}

static uint16_t statusword(unsigned axis)
{
    return octets_u16(&master_last(&master, 0x280U + ID)->data[2U * axis]);
}

static void enable(void)
{
    cycle(0x06U, 0x06U, 0.0, 0.0);
    cycle(0x07U, 0x07U, 0.0, 0.0);
    cycle(0x0FU, 0x0FU, 0.0, 0.0);
}

static void each_axis_has_its_own_state_machine(void)
{
    cycle(0x06U, 0x00U, 0.1, 0.1);
    TEST_ASSERT_EQUAL_HEX16(READY_TO_SWITCH_ON, statusword(0U) & STATE_BITS);
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, statusword(1U) & STATE_BITS_WITHOUT_5);
    cycle(0x0FU, 0x06U, 0.1, 0.1);
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, statusword(0U) & STATE_BITS);
    TEST_ASSERT_EQUAL_HEX16(READY_TO_SWITCH_ON, statusword(1U) & STATE_BITS);
    TEST_ASSERT_EQUAL_HEX16(statusword(1U), joystick_statusword(joystick, 1U));
}

static void only_an_enabled_axis_gives_its_torque(void)
{
    double torque_nm[JOYSTICK_AXES];
    cycle(0x06U, 0x06U, 0.5, -0.5);
    cycle(0x07U, 0x07U, 0.5, -0.5);
    joystick_torque(joystick, torque_nm);
    TEST_ASSERT_TRUE((torque_nm[0] == 0.0) && (torque_nm[1] == 0.0));
    cycle(0x0FU, 0x07U, 0.4321, -0.5);
    joystick_torque(joystick, torque_nm);
    EXPECT_WITHIN(0.4321, 1e-12, torque_nm[0]);
    TEST_ASSERT_TRUE(torque_nm[1] == 0.0);
    cycle(0x0FU, 0x0FU, 0.4321, -0.5);
    joystick_torque(joystick, torque_nm);
    EXPECT_WITHIN(-0.5, 1e-12, torque_nm[1]);
}

static void a_torque_beyond_the_limit_is_cut_and_sets_the_status_bit(void)
{
    double torque_nm[JOYSTICK_AXES];
    enable();
    cycle(0x0FU, 0x0FU, 3.0, -3.0);
    joystick_torque(joystick, torque_nm);
    EXPECT_WITHIN(1.5, 1e-12, torque_nm[0]);
    EXPECT_WITHIN(-1.5, 1e-12, torque_nm[1]);
    TEST_ASSERT_TRUE((statusword(0U) & AXIS_STATUS_INTERNAL_LIMIT) != 0U);
    cycle(0x0FU, 0x0FU, 0.1, 0.1);
    TEST_ASSERT_TRUE((statusword(0U) & AXIS_STATUS_INTERNAL_LIMIT) == 0U);
}

static void positions_and_buttons_are_reported(void)
{
    stick.position_rad[0] = 0.2;
    stick.position_rad[1] = -0.3;
    stick.buttons         = 2U;
    cycle(0x00U, 0x00U, 0.0, 0.0);
    const osal_can_frame_t* positions = master_last(&master, 0x180U + ID);
    TEST_ASSERT_INT32_WITHIN(97, 200000, (int32_t)octets_u32(positions->data));
    TEST_ASSERT_INT32_WITHIN(97, -300000, (int32_t)octets_u32(&positions->data[4]));
    TEST_ASSERT_EQUAL_HEX32(0x00020000U, octets_u32(&master_last(&master, 0x280U + ID)->data[4]));
    // The encoder resolves 96 urad: a smaller motion is not reported.
    stick.position_rad[0] += 1e-6;
    cycle(0x00U, 0x00U, 0.0, 0.0);
    TEST_ASSERT_EQUAL_HEX32(octets_u32(positions->data), octets_u32(master_last(&master, 0x180U + ID)->data));
}

static void quick_stop_removes_the_torque_and_disables_the_axis(void)
{
    double torque_nm[JOYSTICK_AXES];
    enable();
    cycle(0x0FU, 0x0FU, 1.0, 1.0);
    cycle(0x02U, 0x0FU, 1.0, 1.0);
    TEST_ASSERT_EQUAL_HEX16(QUICK_STOP_ACTIVE, statusword(0U) & STATE_BITS);
    joystick_torque(joystick, torque_nm);
    TEST_ASSERT_TRUE(torque_nm[0] == 0.0);
    EXPECT_WITHIN(1.0, 1e-12, torque_nm[1]);
    for (unsigned i = 0U; i < 4U; i++) {
        cycle(0x02U, 0x0FU, 1.0, 1.0);
    }
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, statusword(0U) & STATE_BITS_WITHOUT_5);
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, statusword(1U) & STATE_BITS);
}

static void both_axes_are_disabled_if_no_rpdo_arrives(void)
{
    double torque_nm[JOYSTICK_AXES];
    enable();
    cycle(0x0FU, 0x0FU, 1.0, 1.0);
    for (unsigned i = 0U; i < 10U; i++) {
        master_wait(&master, STEP_NS);
        joystick_end_step(joystick, bus_now_ns(master.bus));
    }
    joystick_torque(joystick, torque_nm);
    TEST_ASSERT_TRUE((torque_nm[0] == 0.0) && (torque_nm[1] == 0.0));
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, joystick_statusword(joystick, 0U) & STATE_BITS_WITHOUT_5);
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, joystick_statusword(joystick, 1U) & STATE_BITS_WITHOUT_5);
    TEST_ASSERT_EQUAL_HEX16(EMERGENCY_RPDO_TIMEOUT, octets_u16(master_last(&master, 0x080U + ID)->data));
}

static void only_torque_mode_is_offered(void)
{
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x6060U, 0U, 8U, 1U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x6860U, 0U, 9U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6860U, 0U, 10U, 1U));
    uint32_t modes = 0U;
    TEST_ASSERT_EQUAL_UINT32(0U, master_read(&master, ID, 0x6D02U, 0U, &modes));
    TEST_ASSERT_EQUAL_HEX32(0x200U, modes);
}

static void a_fault_stops_both_axes(void)
{
    enable();
    joystick_set_error(joystick, EMERGENCY_UNDER_VOLTAGE, true, bus_now_ns(master.bus));
    for (unsigned i = 0U; i < 5U; i++) {
        cycle(0x0FU, 0x0FU, 0.1, 0.1);
    }
    TEST_ASSERT_EQUAL_HEX16(FAULT, statusword(0U) & STATE_BITS_WITHOUT_5);
    TEST_ASSERT_EQUAL_HEX16(FAULT, statusword(1U) & STATE_BITS_WITHOUT_5);
    cycle(0x80U, 0x80U, 0.0, 0.0);
    TEST_ASSERT_EQUAL_HEX16(FAULT, statusword(0U) & STATE_BITS_WITHOUT_5);
    joystick_set_error(joystick, EMERGENCY_UNDER_VOLTAGE, false, bus_now_ns(master.bus));
    cycle(0x00U, 0x00U, 0.0, 0.0);
    cycle(0x80U, 0x80U, 0.0, 0.0);
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, statusword(0U) & STATE_BITS_WITHOUT_5);
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, statusword(1U) & STATE_BITS_WITHOUT_5);
}

static void warnings_are_in_both_statuswords(void)
{
    joystick_set_error(joystick, EMERGENCY_DEVICE_TEMPERATURE, true, bus_now_ns(master.bus));
    cycle(0x00U, 0x00U, 0.0, 0.0);
    TEST_ASSERT_TRUE((statusword(0U) & statusword(1U) & AXIS_STATUS_WARNING) != 0U);
    joystick_set_error(joystick, EMERGENCY_DEVICE_TEMPERATURE, false, bus_now_ns(master.bus));
    cycle(0x00U, 0x00U, 0.0, 0.0);
    TEST_ASSERT_TRUE((statusword(0U) & AXIS_STATUS_WARNING) == 0U);
}

static void on_a_classic_bus_pdos_are_classic_can_frames(void)
{
    const joystick_config_t config = {.encoder    = {.counts_per_turn = 65536U, .gear_ratio = 1.0},
                                      .read_truth = read_truth};
    tearDown();
    master_open(&master, true);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, joystick_create(master.bus, SHEET, ID, &config, &joystick, error));
    node_power_on(joystick_node(joystick));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
    cycle(0x06U, 0x06U, 0.0, 0.0);
    TEST_ASSERT_EQUAL_HEX8(0U, master_last(&master, 0x180U + ID)->flags);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_axis_has_its_own_state_machine);
    RUN_TEST(only_an_enabled_axis_gives_its_torque);
    RUN_TEST(a_torque_beyond_the_limit_is_cut_and_sets_the_status_bit);
    RUN_TEST(positions_and_buttons_are_reported);
    RUN_TEST(quick_stop_removes_the_torque_and_disables_the_axis);
    RUN_TEST(both_axes_are_disabled_if_no_rpdo_arrives);
    RUN_TEST(only_torque_mode_is_offered);
    RUN_TEST(a_fault_stops_both_axes);
    RUN_TEST(warnings_are_in_both_statuswords);
    RUN_TEST(on_a_classic_bus_pdos_are_classic_can_frames);
    return UNITY_END();
}
