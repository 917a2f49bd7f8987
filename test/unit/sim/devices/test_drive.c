// SPDX-License-Identifier: Apache-2.0
// The joint drive on a bus with a motor that is a single mass: states over the bus, regulator, brake, faults.
#include "sim/devices/drive.h"
#include "test/support/bounds.h"
#include "test/unit/sim/devices/master.h"
#include "test/unit/sim/devices/statuswords.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ID 0x11U
#define SHEET "descriptors/devices/joint-drive.eds"
#define STEP_NS 500000U
#define SUBSTEPS 4U
#define INERTIA 0.25 // kgm2

static master_t master;
static drive_t* drive;
static char error[EDS_ERROR_MAX];

/// The motor: a mass under a constant load, held by the brake.
static struct {
    double position_rad;
    double velocity_rad_s;
    double load_nm;
    double joint_torque_nm;
    double torque_nm; // Torque that the drive applied last.
} motor;

static unsigned changes;
static uint16_t first_statusword; // Since `changes` was set to 0.
static uint64_t first_ns;
static uint16_t changed_statusword; // The last one that changed.
static bool changed_brake;

static void read_truth(void* context, drive_truth_t* out_truth)
{
    (void)context;
    *out_truth = (drive_truth_t){.motor_position_rad   = motor.position_rad,
                                 .motor_velocity_rad_s = motor.velocity_rad_s,
                                 .joint_torque_nm      = motor.joint_torque_nm};
}

static void observe(void* context, uint8_t node, unsigned axis, uint16_t statusword, bool brake,
                    uint64_t now_ns)
{
    (void)context;
    TEST_ASSERT_EQUAL_HEX8(ID, node);
    TEST_ASSERT_EQUAL_UINT(0U, axis);
    if (changes == 0U) {
        first_statusword = statusword;
        first_ns         = now_ns;
    }
    changes++;
    changed_statusword = statusword;
    changed_brake      = brake;
}

/// One step of the plant, as the simulator does it.
static void move(void)
{
    const bool is_held = drive_brake_is_engaged(drive);
    for (unsigned i = 0U; i < SUBSTEPS; i++) {
        motor.torque_nm = drive_regulate(drive, motor.position_rad, motor.velocity_rad_s);
        if (is_held) {
            motor.velocity_rad_s = 0.0;
            continue;
        }
        motor.velocity_rad_s += (motor.torque_nm - motor.load_nm) / INERTIA * 125e-6;
        motor.position_rad += motor.velocity_rad_s * 125e-6;
    }
    drive_end_step(drive, bus_now_ns(master.bus));
}

static void send_csp(uint16_t controlword, double position_rad, double torque_nm)
{
    const int32_t position = (int32_t)lround(position_rad * 1e6);
    const int16_t torque   = (int16_t)lround(torque_nm * 100.0);
    const uint8_t data[8]  = {(uint8_t)controlword,      (uint8_t)(controlword >> 8),
                              (uint8_t)position,         (uint8_t)(position >> 8),
                              (uint8_t)(position >> 16), (uint8_t)((uint32_t)position >> 24),
                              (uint8_t)torque,           (uint8_t)((uint16_t)torque >> 8)};
    master_send(&master, 0x200U + ID, data, 8U);
}

static void send_cst(uint16_t controlword, double torque_nm, double velocity_rad_s)
{
    const int16_t torque   = (int16_t)lround(torque_nm * 100.0);
    const int32_t velocity = (int32_t)lround(velocity_rad_s * 1e6);
    const uint8_t data[8]  = {(uint8_t)controlword,      (uint8_t)(controlword >> 8),
                              (uint8_t)torque,           (uint8_t)((uint16_t)torque >> 8),
                              (uint8_t)velocity,         (uint8_t)(velocity >> 8),
                              (uint8_t)(velocity >> 16), (uint8_t)((uint32_t)velocity >> 24)};
    master_send(&master, 0x300U + ID, data, 8U);
}

/// A cycle: the frames that were queued before, SYNC, then a step of the plant.
static void cycle(void)
{
    master_send(&master, 0x080U, NULL, 0U);
    master_wait(&master, STEP_NS);
    move();
}

static uint16_t statusword(void)
{
    return octets_u16(master_last(&master, 0x180U + ID)->data);
}

static void csp_cycles(unsigned count, uint16_t controlword, double position_rad, double torque_nm)
{
    for (unsigned i = 0U; i < count; i++) {
        send_csp(controlword, position_rad, torque_nm);
        cycle();
        if (master.count > (MASTER_HEARD_MAX - 100U)) {
            master_forget(&master);
        }
    }
}

static void cst_cycles(unsigned count, uint16_t controlword, double torque_nm)
{
    for (unsigned i = 0U; i < count; i++) {
        send_cst(controlword, torque_nm, 0.0);
        cycle();
        if (master.count > (MASTER_HEARD_MAX - 100U)) {
            master_forget(&master);
        }
    }
}

static void enable_csp(double torque_nm)
{
    csp_cycles(1U, 0x06U, motor.position_rad, torque_nm);
    csp_cycles(1U, 0x07U, motor.position_rad, torque_nm);
    csp_cycles(1U, 0x0FU, motor.position_rad, torque_nm);
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, statusword() & STATE_BITS);
}

/// Select a mode with its PDO, without a deadline so that SDO transfers may come between cycles.
static void select_mode(uint32_t mode)
{
    master_nmt(&master, 128U, ID);
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1401U, 5U, 0U, 2U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1400U, 1U, 0x80000211U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1401U, 1U, 0x00000311U, 4U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6060U, 0U, mode, 1U));
    master_nmt(&master, 1U, ID);
}

static const char* sheet = SHEET;

static void open_drive(double torque_limit_nm)
{
    const drive_config_t config = {.seed            = 1U,
                                   .torque_limit_nm = torque_limit_nm,
                                   .sensor_device   = ID,
                                   .step_ns         = STEP_NS,
                                   .substep_ns      = STEP_NS / SUBSTEPS,
                                   .torque_sensor   = {.range_nm = 60.0},
                                   .encoder         = {.counts_per_turn = 65536U, .gear_ratio = 160.0},
                                   .read_truth      = read_truth,
                                   .observer        = observe};
    memset(&motor, 0, sizeof motor);
    motor.position_rad = 0.5;
    changes            = 0U;
    master_open(&master, false);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, drive_create(master.bus, sheet, ID, &config, &drive, error),
                                  error);
    node_power_on(drive_node(drive));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
}

void setUp(void)
{
    open_drive(0.0);
}

void tearDown(void)
{
    drive_destroy(drive);
    master_close(&master);
}

static void controlwords_lead_to_operation_enabled_and_back(void)
{
    static const struct {
        uint16_t controlword;
        uint16_t state;
        bool brake;
    } way[] = {{0x00U, 0x40U, true},  {0x0FU, 0x40U, true}, {0x06U, 0x21U, true},  {0x07U, 0x23U, true},
               {0x0FU, 0x27U, false}, {0x07U, 0x23U, true}, {0x0FU, 0x27U, false}, {0x06U, 0x21U, true},
               {0x0FU, 0x27U, false}, {0x00U, 0x40U, true}};
    for (size_t i = 0U; i < (sizeof way / sizeof way[0]); i++) {
        csp_cycles(1U, way[i].controlword, motor.position_rad, 0.0);
        // The TPDO of the same SYNC that applied the controlword shows the new state.
        TEST_ASSERT_EQUAL_HEX16(way[i].state, statusword() & 0x6FU);
        TEST_ASSERT_EQUAL(way[i].brake, drive_brake_is_engaged(drive));
        TEST_ASSERT_EQUAL_UINT64(way[i].brake ? 1U : 0U, node_object(drive_node(drive), 0x2220U, 0U)->value);
        TEST_ASSERT_EQUAL(way[i].brake, changed_brake);
    }
}

/// A gripper's motor of 4 Nm allows less torque than the objects of the drive.
static void the_torque_limit_of_the_motor_is_applied(void)
{
    tearDown();
    open_drive(4.0);
    enable_csp(0.0);
    csp_cycles(20U, 0x0FU, motor.position_rad - 0.02, 0.0);
    csp_cycles(1U, 0x0FU, motor.position_rad - 0.02, 0.0);
    EXPECT_WITHIN(-4.0, 1e-12, motor.torque_nm);
    TEST_ASSERT_BITS_HIGH(AXIS_STATUS_INTERNAL_LIMIT, statusword());
    csp_cycles(1U, 0x0FU, motor.position_rad + 0.02, 0.0);
    csp_cycles(1U, 0x0FU, motor.position_rad + 0.02, 0.0);
    EXPECT_WITHIN(4.0, 1e-12, motor.torque_nm);
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6072U, 0U, 100U, 2U)); // 1 Nm
    csp_cycles(1U, 0x0FU, motor.position_rad + 0.02, 0.0);
    EXPECT_WITHIN(1.0, 1e-12, motor.torque_nm);
}

static void the_engaged_brake_prevents_torque_and_motion(void)
{
    motor.load_nm = 10.0;
    csp_cycles(50U, 0x07U, 1.0, 20.0);
    TEST_ASSERT_TRUE(motor.torque_nm == 0.0);
    TEST_ASSERT_TRUE(motor.position_rad == 0.5);
}

static void positions_are_reported_in_microradians(void)
{
    motor.position_rad = -1.25;
    csp_cycles(1U, 0x00U, 0.0, 0.0);
    const int32_t reported_urad = (int32_t)octets_u32(&master_last(&master, 0x191U)->data[2]);
    TEST_ASSERT_INT32_WITHIN(1, -1250000, reported_urad);
}

static void the_torque_of_the_sensor_is_reported_in_hundredths_of_nm(void)
{
    motor.joint_torque_nm = 12.345;
    csp_cycles(1U, 0x00U, 0.0, 0.0);
    TEST_ASSERT_INT16_WITHIN(1, 1235, (int16_t)octets_u16(&master_last(&master, 0x191U)->data[6]));
    drive_set_torque_offset(drive, -0.2);
    csp_cycles(1U, 0x00U, 0.0, 0.0);
    TEST_ASSERT_INT16_WITHIN(1, 1215, (int16_t)octets_u16(&master_last(&master, 0x191U)->data[6]));
    motor.joint_torque_nm = -100.0; // Beyond the sensor's range.
    drive_set_torque_offset(drive, 0.0);
    csp_cycles(1U, 0x00U, 0.0, 0.0);
    TEST_ASSERT_INT16_WITHIN(1, -6000, (int16_t)octets_u16(&master_last(&master, 0x191U)->data[6]));
}

static void csp_holds_against_a_known_load_without_a_jerk(void)
{
    motor.load_nm = 8.0;
    enable_csp(8.0);
    csp_cycles(200U, 0x0FU, 0.5, 8.0);
    EXPECT_WITHIN(0.5, 1e-5, motor.position_rad);
    TEST_ASSERT_TRUE((statusword() & AXIS_STATUS_FOLLOWS) != 0U);
    TEST_ASSERT_TRUE((statusword() & (AXIS_STATUS_INTERNAL_LIMIT | AXIS_STATUS_FOLLOWING_ERROR)) == 0U);
}

static void csp_deviates_by_load_over_gain(void)
{
    motor.load_nm = 4.0; // The drive gets no torque offset for this load.
    enable_csp(0.0);
    csp_cycles(1000U, 0x0FU, 0.5, 0.0);
    EXPECT_WITHIN(0.5 - (4.0 / 4000.0), 1e-5, motor.position_rad);
}

static void csp_follows_a_ramp_with_interpolated_targets(void)
{
    enable_csp(0.0);
    double wanted = 0.5;
    for (unsigned i = 0U; i < 400U; i++) {
        wanted += 0.5 * 500e-6; // 0.5 rad/s
        csp_cycles(1U, 0x0FU, wanted, 0.0);
    }
    EXPECT_WITHIN(wanted, 1e-4, motor.position_rad);
    EXPECT_WITHIN(0.5, 0.01, motor.velocity_rad_s);
    EXPECT_BELOW(1.0, fabs(motor.torque_nm)); // A smooth ramp needs no torque on a free mass.
}

static void an_enabled_drive_holds_until_the_first_target_arrives(void)
{
    motor.load_nm = 2.0;
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x1400U, 5U, 0U, 2U));
    csp_cycles(1U, 0x06U, 0.0, 0.0); // Targets of 0 rad, far from the position, before the drive is enabled.
    csp_cycles(1U, 0x07U, 0.0, 0.0);
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6040U, 0U, 0x0FU, 2U)); // SDO: no target.
    for (unsigned i = 0U; i < 100U; i++) {
        cycle();
    }
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, statusword() & STATE_BITS);
    EXPECT_WITHIN(0.5, 1e-3, motor.position_rad);
}

static void cst_gives_the_sum_of_target_and_offset(void)
{
    select_mode(10U);
    cst_cycles(1U, 0x06U, 0.0);
    cst_cycles(1U, 0x07U, 0.0);
    cst_cycles(1U, 0x0FU, 3.21);
    EXPECT_WITHIN(3.21, 1e-9, motor.torque_nm);
    object_t* offset = node_object(drive_node(drive), 0x60B2U, 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x60B2U, 0U, 100U, 2U));
    TEST_ASSERT_EQUAL_INT64(100, object_signed(offset));
    cst_cycles(1U, 0x0FU, -3.0);
    EXPECT_WITHIN(-2.0, 1e-9, motor.torque_nm);
}

static void a_reached_torque_limit_sets_internal_limit_active(void)
{
    select_mode(10U);
    cst_cycles(1U, 0x06U, 0.0);
    cst_cycles(1U, 0x07U, 0.0);
    cst_cycles(2U, 0x0FU, 50.0);
    EXPECT_WITHIN(40.0, 1e-9, motor.torque_nm);
    cst_cycles(1U, 0x0FU, 50.0);
    TEST_ASSERT_TRUE((statusword() & AXIS_STATUS_INTERNAL_LIMIT) != 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x60E1U, 0U, 500U, 2U)); // -5 Nm
    cst_cycles(2U, 0x0FU, -50.0);
    EXPECT_WITHIN(-5.0, 1e-9, motor.torque_nm);
    cst_cycles(3U, 0x0FU, 1.0);
    TEST_ASSERT_TRUE((statusword() & AXIS_STATUS_INTERNAL_LIMIT) == 0U);
}

static void csv_moves_at_the_commanded_velocity(void)
{
    select_mode(9U);
    for (unsigned i = 0U; i < 400U; i++) {
        send_cst((i == 0U) ? 0x06U : ((i == 1U) ? 0x07U : 0x0FU), 0.0, 0.25);
        cycle();
    }
    EXPECT_WITHIN(0.25, 1e-3, motor.velocity_rad_s);
}

static void a_target_beyond_the_software_limits_is_limited(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x607DU, 2U, 510000U, 4U));
    enable_csp(0.0);
    for (unsigned i = 0U; i < 400U; i++) {
        csp_cycles(1U, 0x0FU, 0.5 + (i * 1e-4), 0.0);
    }
    EXPECT_WITHIN(0.51, 1e-4, motor.position_rad);
    TEST_ASSERT_TRUE((statusword() & AXIS_STATUS_INTERNAL_LIMIT) != 0U);
}

static void only_supported_modes_of_operation_are_accepted(void)
{
    static const uint32_t refused[] = {1U, 3U, 4U, 7U, 11U, 0xFFU};
    for (size_t i = 0U; i < (sizeof refused / sizeof refused[0]); i++) {
        TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_VALUE, master_write(&master, ID, 0x6060U, 0U, refused[i], 1U));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6060U, 0U, 0U, 1U));
    csp_cycles(1U, 0x06U, 0.5, 0.0);
    csp_cycles(1U, 0x07U, 0.5, 0.0);
    csp_cycles(3U, 0x0FU, 0.5, 0.0);
    TEST_ASSERT_EQUAL_HEX16(SWITCHED_ON, statusword() & STATE_BITS); // Not enabled: no mode is selected.
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6060U, 0U, 8U, 1U));
    uint32_t mode = 0U;
    TEST_ASSERT_EQUAL_UINT32(0U, master_read(&master, ID, 0x6061U, 0U, &mode));
    TEST_ASSERT_EQUAL_UINT32(8U, mode);
}

static void quick_stop_brakes_on_a_ramp_then_engages_the_brake(void)
{
    motor.load_nm = 6.0;
    enable_csp(6.0);
    double wanted = 0.5;
    for (unsigned i = 0U; i < 400U; i++) {
        wanted += 0.4 * 500e-6;
        csp_cycles(1U, 0x0FU, wanted, 6.0);
    }
    const double before_rad = motor.position_rad;
    csp_cycles(1U, 0x02U, wanted, 6.0);
    TEST_ASSERT_EQUAL_HEX16(QUICK_STOP_ACTIVE, statusword() & STATE_BITS);
    TEST_ASSERT_FALSE(drive_brake_is_engaged(drive));
    unsigned steps = 0U;
    while (!drive_brake_is_engaged(drive) && (steps < 1000U)) {
        csp_cycles(1U, 0x02U, wanted, 6.0);
        steps++;
    }
    // 0.4 rad/s at 20 rad/s2: 20 ms and 4 mrad.
    TEST_ASSERT_UINT_WITHIN(12U, 40U, steps);
    EXPECT_WITHIN(before_rad + 0.004, 0.0015, motor.position_rad);
    csp_cycles(1U, 0x0FU, wanted, 6.0);
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, statusword() & STATE_BITS_WITHOUT_5);
}

static void quick_stop_at_rest_holds_the_load(void)
{
    motor.load_nm = 10.0;
    select_mode(10U);
    cst_cycles(1U, 0x06U, 0.0);
    cst_cycles(1U, 0x07U, 0.0);
    cst_cycles(20U, 0x0FU, 10.0);
    cst_cycles(3U, 0x02U, 0.0);
    TEST_ASSERT_TRUE(drive_brake_is_engaged(drive));
    EXPECT_WITHIN(0.5, 1e-4, motor.position_rad);
}

/// The drive is unplugged in a cycle, `phase_ns` after SYNC: it must enter its safe state without a command.
static uint64_t silence_reaction_ns(uint64_t phase_ns)
{
    setUp();
    motor.load_nm = 8.0;
    enable_csp(8.0);
    csp_cycles(20U, 0x0FU, 0.5, 8.0);
    send_csp(0x0FU, 0.5, 8.0);
    master_send(&master, 0x080U, NULL, 0U);
    master_wait(&master, phase_ns);
    const uint64_t cut_ns = bus_now_ns(master.bus);
    changes               = 0U;
    node_unplug(drive_node(drive));
    master_wait(&master, STEP_NS - phase_ns);
    move();
    for (unsigned i = 0U; (i < 20U) && (changes == 0U); i++) {
        master_wait(&master, STEP_NS);
        move();
    }
    TEST_ASSERT_EQUAL_HEX16(QUICK_STOP_ACTIVE, first_statusword & STATE_BITS);
    const uint64_t reaction_ns = first_ns - cut_ns;
    for (unsigned i = 0U; i < 20U; i++) {
        master_wait(&master, STEP_NS);
        move();
    }
    TEST_ASSERT_TRUE(drive_brake_is_engaged(drive));
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, drive_statusword(drive) & STATE_BITS_WITHOUT_5);
    EXPECT_WITHIN(0.5, 1e-3, motor.position_rad);
    tearDown();
    return reaction_ns;
}

static void a_disconnected_drive_leaves_operation_by_its_deadline_at_any_phase(void)
{
    tearDown();
    for (unsigned i = 0U; i < 20U; i++) {
        const uint64_t reaction_ns = silence_reaction_ns(i * (STEP_NS / 20U));
        TEST_ASSERT_LESS_OR_EQUAL_UINT64(2500000U, reaction_ns);
        TEST_ASSERT_GREATER_OR_EQUAL_UINT64(1000000U, reaction_ns);
    }
    setUp();
}

static void the_abort_connection_option_decides_how_a_drive_stops(void)
{
    static const struct {
        uint32_t option;
        uint16_t state;
    } cases[] = {{0U, 0x27U}, {1U, 0x08U}, {2U, 0x40U}, {3U, 0x40U}};
    for (unsigned i = 0U; i < 4U; i++) {
        tearDown();
        setUp();
        TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6007U, 0U, cases[i].option, 2U));
        enable_csp(0.0);
        for (unsigned k = 0U; k < 20U; k++) {
            master_wait(&master, STEP_NS);
            move();
        }
        cycle();
        TEST_ASSERT_EQUAL_HEX16(cases[i].state,
                                statusword() & 0x6FU & ((cases[i].state == 0x27U) ? 0x6FU : 0x4FU));
        TEST_ASSERT_EQUAL(cases[i].option != 0U, drive_brake_is_engaged(drive));
    }
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_TOO_HIGH, master_write(&master, ID, 0x6007U, 0U, 4U, 2U));
}

static void leaving_nmt_operational_stops_the_drive(void)
{
    enable_csp(0.0);
    master_nmt(&master, 128U, ID);
    for (unsigned i = 0U; i < 20U; i++) {
        master_wait(&master, STEP_NS);
        move();
    }
    TEST_ASSERT_TRUE(drive_brake_is_engaged(drive));
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, drive_statusword(drive) & STATE_BITS_WITHOUT_5);
}

static void a_following_error_is_a_fault_after_its_timeout(void)
{
    enable_csp(0.0);
    motor.load_nm  = 300.0; // More than the drive can give.
    unsigned steps = 0U;
    while (((statusword() & 0x4FU) != 0x08U) && (steps < 600U)) {
        csp_cycles(1U, 0x0FU, 0.5, 0.0);
        steps++;
    }
    TEST_ASSERT_EQUAL_HEX16(FAULT, statusword() & STATE_BITS_WITHOUT_5);
    TEST_ASSERT_EQUAL_HEX16(0x8611U, octets_u16(master_last(&master, 0x091U)->data));
    TEST_ASSERT_EQUAL_HEX64(0x8611U, node_object(drive_node(drive), 0x603FU, 0U)->value);
    TEST_ASSERT_TRUE(drive_brake_is_engaged(drive));
    motor.load_nm = 0.0;
    csp_cycles(2U, 0x0FU, 0.5, 0.0);
    TEST_ASSERT_EQUAL_HEX16(FAULT, statusword() & STATE_BITS_WITHOUT_5);
    csp_cycles(1U, 0x80U, motor.position_rad, 0.0); // Fault reset.
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, statusword() & STATE_BITS_WITHOUT_5);
    TEST_ASSERT_EQUAL_HEX16(0U, octets_u16(master_last(&master, 0x091U)->data));
    TEST_ASSERT_EQUAL_HEX64(0U, node_object(drive_node(drive), 0x603FU, 0U)->value);
    enable_csp(0.0);
}

static void faults_stay_until_their_cause_is_gone(void)
{
    static const uint16_t faults[] = {0x2310U, 0x3220U, 0x7305U, 0xFF01U};
    for (size_t i = 0U; i < (sizeof faults / sizeof faults[0]); i++) {
        enable_csp(0.0);
        drive_set_error(drive, faults[i], true, bus_now_ns(master.bus));
        csp_cycles(1U, 0x0FU, 0.5, 0.0);
        TEST_ASSERT_EQUAL_HEX16(faults[i], octets_u16(master_last(&master, 0x091U)->data));
        csp_cycles(20U, 0x0FU, 0.5, 0.0);
        TEST_ASSERT_EQUAL_HEX16(FAULT, statusword() & STATE_BITS_WITHOUT_5);
        csp_cycles(1U, 0x80U, 0.5, 0.0);
        TEST_ASSERT_EQUAL_HEX16(FAULT, statusword() & STATE_BITS_WITHOUT_5); // The fault is still present.
        drive_set_error(drive, faults[i], false, bus_now_ns(master.bus));
        csp_cycles(1U, 0x00U, 0.5, 0.0);
        csp_cycles(1U, 0x80U, 0.5, 0.0);
        TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, statusword() & STATE_BITS_WITHOUT_5);
    }
}

static void warnings_do_not_stop_the_drive(void)
{
    enable_csp(0.0);
    drive_set_temperature(drive, 85.0, bus_now_ns(master.bus));
    csp_cycles(2U, 0x0FU, 0.5, 0.0);
    TEST_ASSERT_EQUAL_HEX16(0x4310U, octets_u16(master_last(&master, 0x091U)->data));
    TEST_ASSERT_EQUAL_HEX16(OPERATION_ENABLED, statusword() & STATE_BITS);
    TEST_ASSERT_TRUE((statusword() & AXIS_STATUS_WARNING) != 0U);
    TEST_ASSERT_EQUAL_UINT64(850U, node_object(drive_node(drive), 0x2210U, 0U)->value);
    drive_set_temperature(drive, 78.0, bus_now_ns(master.bus));
    csp_cycles(2U, 0x0FU, 0.5, 0.0);
    TEST_ASSERT_TRUE((statusword() & AXIS_STATUS_WARNING) != 0U);
    drive_set_temperature(drive, 40.0, bus_now_ns(master.bus));
    csp_cycles(2U, 0x0FU, 0.5, 0.0);
    TEST_ASSERT_TRUE((statusword() & AXIS_STATUS_WARNING) == 0U);
    TEST_ASSERT_EQUAL_HEX16(0U, octets_u16(master_last(&master, 0x091U)->data));
}

static void manufacturer_objects_are_found_by_their_names(void)
{
    char line[512];
    FILE* from = fopen(SHEET, "r");
    FILE* to   = fopen("build/test/other-drive.eds", "w");
    while (fgets(line, (int)sizeof line, from) != NULL) {
        char* number = strstr(line, "2210");
        (void)memmove((number != NULL) ? number : line, (number != NULL) ? "2A10" : line, 4U);
        (void)fputs(line, to);
    }
    TEST_ASSERT_EQUAL_INT(0, fclose(from) + fclose(to));
    tearDown();
    sheet = "build/test/other-drive.eds";
    open_drive(0.0);
    sheet = SHEET;
    drive_set_temperature(drive, 85.0, bus_now_ns(master.bus));
    TEST_ASSERT_EQUAL_UINT64(850U, node_object(drive_node(drive), 0x2A10U, 0U)->value);
}

static void a_power_cycle_engages_the_brake_at_once(void)
{
    enable_csp(0.0);
    node_unplug(drive_node(drive));
    node_plug(drive_node(drive));
    TEST_ASSERT_TRUE(drive_brake_is_engaged(drive));
    TEST_ASSERT_TRUE(drive_regulate(drive, 0.5, 0.0) == 0.0);
    TEST_ASSERT_EQUAL_HEX16(SWITCH_ON_DISABLED, changed_statusword & STATE_BITS_WITHOUT_5);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(controlwords_lead_to_operation_enabled_and_back);
    RUN_TEST(the_torque_limit_of_the_motor_is_applied);
    RUN_TEST(the_engaged_brake_prevents_torque_and_motion);
    RUN_TEST(positions_are_reported_in_microradians);
    RUN_TEST(the_torque_of_the_sensor_is_reported_in_hundredths_of_nm);
    RUN_TEST(csp_holds_against_a_known_load_without_a_jerk);
    RUN_TEST(csp_deviates_by_load_over_gain);
    RUN_TEST(csp_follows_a_ramp_with_interpolated_targets);
    RUN_TEST(an_enabled_drive_holds_until_the_first_target_arrives);
    RUN_TEST(cst_gives_the_sum_of_target_and_offset);
    RUN_TEST(a_reached_torque_limit_sets_internal_limit_active);
    RUN_TEST(csv_moves_at_the_commanded_velocity);
    RUN_TEST(a_target_beyond_the_software_limits_is_limited);
    RUN_TEST(only_supported_modes_of_operation_are_accepted);
    RUN_TEST(quick_stop_brakes_on_a_ramp_then_engages_the_brake);
    RUN_TEST(quick_stop_at_rest_holds_the_load);
    RUN_TEST(a_disconnected_drive_leaves_operation_by_its_deadline_at_any_phase);
    RUN_TEST(the_abort_connection_option_decides_how_a_drive_stops);
    RUN_TEST(leaving_nmt_operational_stops_the_drive);
    RUN_TEST(a_following_error_is_a_fault_after_its_timeout);
    RUN_TEST(faults_stay_until_their_cause_is_gone);
    RUN_TEST(warnings_do_not_stop_the_drive);
    RUN_TEST(manufacturer_objects_are_found_by_their_names);
    RUN_TEST(a_power_cycle_engages_the_brake_at_once);
    return UNITY_END();
}
