// SPDX-License-Identifier: Apache-2.0
// Homing of the joint drive (CiA 402 mode 6) over the bus; the motor is a mass between two end stops.
#include "sim/devices/drive.h"
#include "sim/devices/homing.h"
#include "test/support/bounds.h"
#include "test/unit/sim/devices/master.h"
#include "test/unit/sim/devices/statuswords.h"
#include "unity.h"

#include <string.h>

#define ID 0x11U
#define SHEET "descriptors/devices/joint-drive.eds"
#define STEP_NS 500000U
#define SUBSTEPS 4U
#define INERTIA 0.25 // kgm2
#define FRICTION 5.0 // Nms/rad
#define STOP_NM_RAD 20000.0
#define STOP_RAD 0.3 // On both sides of the start.
#define START_RAD 0.5
#define SPEED 0.1 // rad/s, from the data sheet.

#define ENABLE 0x0FU
#define SEARCH 0x1FU
#define HALT 0x11FU
#define ATTAINED 0x1000U
#define REACHED 0x0400U
#define FAILED 0x2000U
#define RESULT_BITS (ATTAINED | REACHED | FAILED)

static master_t master;
static drive_t* drive;

static struct {
    double position_rad;
    double velocity_rad_s;
} motor;

static void read_truth(void* context, drive_truth_t* out_truth)
{
    (void)context;
    *out_truth = (drive_truth_t){.motor_position_rad   = motor.position_rad,
                                 .motor_velocity_rad_s = motor.velocity_rad_s};
}

static double stop_torque_nm(void)
{
    const double away = motor.position_rad - START_RAD;
    const double deep =
        (away > STOP_RAD) ? (away - STOP_RAD) : ((away < -STOP_RAD) ? (away + STOP_RAD) : 0.0);
    return -STOP_NM_RAD * deep;
}

static void move(void)
{
    const bool is_held = drive_brake_is_engaged(drive);
    for (unsigned i = 0U; i < SUBSTEPS; i++) {
        const double torque_nm = drive_regulate(drive, motor.position_rad, motor.velocity_rad_s);
        const double sum_nm    = torque_nm + stop_torque_nm() - (FRICTION * motor.velocity_rad_s);
        motor.velocity_rad_s   = is_held ? 0.0 : (motor.velocity_rad_s + (sum_nm / INERTIA * 125e-6));
        motor.position_rad += motor.velocity_rad_s * 125e-6;
    }
    drive_end_step(drive, bus_now_ns(master.bus));
}

/// Run cycles with a controlword and a target position, which only CSP uses.
static void run_cycles(const unsigned count, const uint16_t controlword, const int32_t target)
{
    for (unsigned i = 0U; i < count; i++) {
        const uint32_t bits   = (uint32_t)target;
        const uint8_t data[8] = {(uint8_t)controlword, (uint8_t)(controlword >> 8), (uint8_t)bits,
                                 (uint8_t)(bits >> 8), (uint8_t)(bits >> 16),       (uint8_t)(bits >> 24)};
        master_forget(&master);
        master_send(&master, 0x200U + ID, data, 8U);
        master_send(&master, 0x080U, NULL, 0U);
        master_wait(&master, STEP_NS);
        move();
    }
}

static void run_seconds(const double s, const uint16_t controlword)
{
    run_cycles((unsigned)(s / 0.0005), controlword, 0);
}

static uint16_t statusword(void)
{
    return octets_u16(master_last(&master, 0x180U + ID)->data);
}

static double position_rad(void)
{
    return 1e-6 * (double)(int32_t)octets_u32(&master_last(&master, 0x180U + ID)->data[2]);
}

static void expect_result_bits(const uint16_t bits)
{
    TEST_ASSERT_EQUAL_HEX16(bits, statusword() & RESULT_BITS);
}

static void write_object(const uint16_t index, const uint8_t subindex, const uint32_t value,
                         const uint8_t size)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, index, subindex, value, size));
}

/// Bring the drive into the mode homing with a method, and into the state operation enabled.
static void prepare(const uint32_t method)
{
    write_object(0x1400U, 5U, 0U, 2U); // No RPDO deadline, so that SDO transfers may come between cycles.
    write_object(0x6060U, 0U, 6U, 1U);
    write_object(0x6098U, 0U, method & 0xFFU, 1U);
    run_cycles(1U, 0x06U, 0);
    run_cycles(1U, 0x07U, 0);
    run_cycles(4U, ENABLE, 0);
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, statusword() & STATE_BITS);
    expect_result_bits(REACHED); // The search has not been started.
}

void setUp(void)
{
    const drive_config_t config = {.seed          = 1U,
                                   .sensor_device = ID,
                                   .step_ns       = STEP_NS,
                                   .substep_ns    = STEP_NS / SUBSTEPS,
                                   .torque_sensor = {.range_nm = 60.0},
                                   .encoder       = {.counts_per_turn = 65536U, .gear_ratio = 160.0},
                                   .read_truth    = read_truth};
    char error[EDS_ERROR_MAX];
    memset(&motor, 0, sizeof motor);
    motor.position_rad = START_RAD;
    master_open(&master, false);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, drive_create(master.bus, SHEET, ID, &config, &drive, error),
                                  error);
    node_power_on(drive_node(drive));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
}

void tearDown(void)
{
    drive_destroy(drive);
    master_close(&master);
}

static void the_present_position_becomes_the_reference(void)
{
    static const uint32_t methods[] = {35U, 37U};
    for (size_t i = 0U; i < 2U; i++) {
        write_object(0x607CU, 0U, 200000U, 4U);
        prepare(methods[i]);
        run_cycles(2U, SEARCH, 0);
        expect_result_bits(ATTAINED | REACHED);
        EXPECT_WITHIN(-0.2, 2e-6, position_rad());
        EXPECT_WITHIN(START_RAD, 1e-3, motor.position_rad);
        run_cycles(1U, 0x00U, 0);
        expect_result_bits(0U);
    }
}

/// The zero is 0.1 rad from the position where the axis stopped, and the targets of CSP refer to it.
static void positions_count_from_the_new_zero(void)
{
    write_object(0x607CU, 0U, (uint32_t)-100000, 4U);
    prepare(37U);
    run_cycles(2U, SEARCH, 0);
    EXPECT_WITHIN(0.1, 2e-6, position_rad());
    write_object(0x6060U, 0U, 8U, 1U);
    run_cycles(1U, ENABLE, 100000);
    // Bit 12 means in CSP that the drive follows its target.
    TEST_ASSERT_EQUAL_HEX16(ATTAINED, statusword() & RESULT_BITS);
    for (int32_t i = 0; i < 500; i++) {
        run_cycles(1U, ENABLE, 100000 - (100 * i));
    }
    run_cycles(100U, ENABLE, 50000);
    EXPECT_WITHIN(0.05, 1e-3, position_rad());
    EXPECT_WITHIN(START_RAD - 0.05, 1e-3, motor.position_rad);
    node_power_off(drive_node(drive)); // The encoder keeps its zero without power.
    node_power_on(drive_node(drive));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
    run_cycles(2U, 0x00U, 0);
    EXPECT_WITHIN(motor.position_rad, 1e-5, position_rad());
}

static void an_end_stop_is_found_from_both_sides(void)
{
    static const struct {
        uint32_t method;
        double stop_rad;
    } cases[] = {{0xFFU, START_RAD - STOP_RAD}, {0xFEU, START_RAD + STOP_RAD}};
    for (size_t i = 0U; i < 2U; i++) {
        motor.position_rad = START_RAD;
        prepare(cases[i].method);
        run_seconds(1.0, SEARCH);
        expect_result_bits(0U);
        EXPECT_WITHIN(SPEED, 1e-3, (i == 0U) ? -motor.velocity_rad_s : motor.velocity_rad_s);
        run_seconds(3.0, SEARCH);
        expect_result_bits(ATTAINED | REACHED);
        EXPECT_WITHIN(cases[i].stop_rad, 3e-3, motor.position_rad);
        EXPECT_WITHIN(0.0, 3e-3, position_rad()); // The axis has moved off the stop since.
        EXPECT_WITHIN(0.0, 1e-3, motor.velocity_rad_s);
        run_seconds(0.1, ENABLE);
        expect_result_bits(ATTAINED | REACHED); // The result remains.
        run_cycles(1U, 0x00U, 0);
    }
}

static void a_search_can_be_interrupted_and_halted(void)
{
    prepare(0xFFU);
    run_seconds(1.0, SEARCH);
    run_seconds(0.5, HALT);
    expect_result_bits(REACHED);
    EXPECT_WITHIN(0.0, 1e-3, motor.velocity_rad_s);
    const double halted_rad = motor.position_rad;
    TEST_ASSERT_TRUE(halted_rad < (START_RAD - 0.08));
    run_seconds(0.5, HALT);
    EXPECT_WITHIN(halted_rad, 1e-4, motor.position_rad);
    run_seconds(0.5, SEARCH); // The search continues.
    expect_result_bits(0U);
    TEST_ASSERT_TRUE(motor.position_rad < (halted_rad - 0.03));
    run_seconds(0.5, ENABLE); // The search ends without a result.
    expect_result_bits(REACHED);
    const double ended_rad = motor.position_rad;
    run_seconds(0.5, ENABLE);
    EXPECT_WITHIN(ended_rad, 1e-4, motor.position_rad);
    EXPECT_WITHIN(motor.position_rad, 1e-4, position_rad()); // The zero has not changed.
    run_seconds(4.0, SEARCH);
    expect_result_bits(ATTAINED | REACHED);
}

static void a_search_without_a_stop_fails_at_the_end_of_the_range(void)
{
    write_object(0x607DU, 1U, 400000U, 4U);
    write_object(0x607DU, 2U, 500000U, 4U);
    prepare(0xFEU);
    run_seconds(1.3, SEARCH);
    expect_result_bits(FAILED); // The axis still moves.
    run_seconds(0.3, SEARCH);
    expect_result_bits(FAILED | REACHED); // The axis has stopped.
    EXPECT_WITHIN(START_RAD + 0.11, 0.01, motor.position_rad);
    EXPECT_WITHIN(motor.position_rad, 1e-4, position_rad());
    run_cycles(2U, ENABLE, 0);
    expect_result_bits(FAILED | REACHED);
    run_cycles(2U, SEARCH, 0); // Another attempt.
    expect_result_bits(0U);
}

static void a_method_that_the_drive_does_not_have_fails(void)
{
    static const uint32_t methods[] = {0U, 17U, 0xFDU};
    for (size_t i = 0U; i < 3U; i++) {
        prepare(methods[i]);
        run_cycles(2U, SEARCH, 0);
        expect_result_bits(FAILED | REACHED);
        EXPECT_WITHIN(START_RAD, 1e-4, motor.position_rad);
        run_cycles(1U, 0x00U, 0);
    }
}

static void a_fault_ends_the_search(void)
{
    prepare(0xFFU);
    run_seconds(1.0, SEARCH);
    drive_set_error(drive, EMERGENCY_OVER_CURRENT, true, bus_now_ns(master.bus));
    run_seconds(0.5, SEARCH);
    TEST_ASSERT_EQUAL_HEX16(FAULT, statusword() & STATE_BITS_WITHOUT_5);
    expect_result_bits(0U);
    drive_set_error(drive, EMERGENCY_OVER_CURRENT, false, bus_now_ns(master.bus));
    run_cycles(1U, 0x80U, 0);
    const double after_rad = motor.position_rad;
    prepare(0xFFU);
    run_seconds(0.2, ENABLE);
    EXPECT_WITHIN(after_rad, 1e-4, motor.position_rad);
    EXPECT_WITHIN(motor.position_rad, 1e-4, position_rad());
}

static void a_disabled_drive_ends_the_search(void)
{
    prepare(0xFEU);
    run_seconds(1.0, SEARCH);
    run_cycles(1U, 0x07U, 0);
    TEST_ASSERT_TRUE(drive_brake_is_engaged(drive));
    expect_result_bits(0U);
    const double after_rad = motor.position_rad;
    run_cycles(1U, ENABLE, 0);
    expect_result_bits(REACHED);
    run_seconds(0.2, ENABLE);
    EXPECT_WITHIN(after_rad, 1e-4, motor.position_rad);
    run_cycles(1U, 0x07U, 0);
    run_seconds(0.3, SEARCH); // One controlword enables the drive and starts the search.
    expect_result_bits(0U);
    TEST_ASSERT_TRUE(motor.position_rad > (after_rad + 0.01));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_present_position_becomes_the_reference);
    RUN_TEST(positions_count_from_the_new_zero);
    RUN_TEST(an_end_stop_is_found_from_both_sides);
    RUN_TEST(a_search_can_be_interrupted_and_halted);
    RUN_TEST(a_search_without_a_stop_fails_at_the_end_of_the_range);
    RUN_TEST(a_method_that_the_drive_does_not_have_fails);
    RUN_TEST(a_fault_ends_the_search);
    RUN_TEST(a_disabled_drive_ends_the_search);
    return UNITY_END();
}
