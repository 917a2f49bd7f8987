// SPDX-License-Identifier: Apache-2.0
// The torque actual value of drives with and without a torque sensor, and of a drive whose data sheet lacks
// the object.
#include "sim/devices/drive.h"
#include "test/support/bounds.h"
#include "test/unit/sim/devices/master.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <string.h>

#define ID 0x11U
#define SHEET "descriptors/devices/joint-drive.eds"
#define STEP_NS 500000U

static master_t master;
static drive_t* drive;
static char error[EDS_ERROR_MAX];

void setUp(void)
{
    master_open(&master, false);
}

void tearDown(void)
{
    drive_destroy(drive);
    drive = NULL;
    master_close(&master);
    temporary_files_remove();
}

/// A motor at 0.5 rad; the joint torque behind its gear is 12.345 Nm.
static void read_truth(void* context, drive_truth_t* out_truth)
{
    (void)context;
    *out_truth = (drive_truth_t){.motor_position_rad = 0.5, .joint_torque_nm = 12.345};
}

static status_t open_drive(const char* sheet, const double range_nm)
{
    const drive_config_t config = {.seed          = 1U,
                                   .sensor_device = ID,
                                   .step_ns       = STEP_NS,
                                   .substep_ns    = STEP_NS / 4U,
                                   .torque_sensor = {.range_nm = range_nm},
                                   .encoder       = {.counts_per_turn = 65536U, .gear_ratio = 160.0},
                                   .read_truth    = read_truth};
    const status_t status       = drive_create(master.bus, sheet, ID, &config, &drive, error);
    if (status == STATUS_OK) {
        node_power_on(drive_node(drive));
        master_wait(&master, 2U * MASTER_MS);
        master_nmt(&master, 1U, ID);
    }
    return status;
}

/// Enable torque control with a target in units of 0.01 Nm.
static void enable(const uint32_t target)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6060U, 0U, 10U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6071U, 0U, target, 2U));
    static const uint32_t controlwords[] = {0x06U, 0x07U, 0x0FU};
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6040U, 0U, controlwords[i], 2U));
        master_sync(&master, STEP_NS);
    }
    EXPECT_WITHIN(0.01 * target, 1e-9, drive_regulate(drive, 0.5, 0.0));
    master_sync(&master, STEP_NS);
}

static int16_t actual_torque(void)
{
    return (int16_t)object_signed(node_object(drive_node(drive), 0x6077U, 0U));
}

static void with_a_sensor_the_actual_torque_is_measured_behind_the_gear(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, open_drive(SHEET, 60.0), error);
    enable(800U);
    TEST_ASSERT_INT16_WITHIN(1, 1235, actual_torque());
}

static void without_a_sensor_the_actual_torque_is_the_torque_of_the_motor(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, open_drive(SHEET, 0.0), error);
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT16(0, actual_torque()); // The brake carries the load.
    enable(800U);
    TEST_ASSERT_EQUAL_INT16(800, actual_torque());
    drive_set_torque_offset(drive, 0.5); // As a scenario sets it.
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT16(850, actual_torque());
}

/// A data sheet without the torque actual value: only a drive with a sensor needs the object.
static void without_a_sensor_the_object_may_be_absent(void)
{
    const char* path = temporary_variant("1.eds", SHEET, "=0x6077", "=0x2077");
    path             = temporary_variant("2.eds", path, "=0x60770010", "=0x20770010");
    path             = temporary_variant("3.eds", path, "[6077]", "[2077]");
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, open_drive(path, 60.0));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "3.eds"), error);
    master_close(&master);
    master_open(&master, false);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, open_drive(path, 0.0), error);
    enable(800U);
    TEST_ASSERT_NULL(node_object(drive_node(drive), 0x6077U, 0U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(with_a_sensor_the_actual_torque_is_measured_behind_the_gear);
    RUN_TEST(without_a_sensor_the_actual_torque_is_the_torque_of_the_motor);
    RUN_TEST(without_a_sensor_the_object_may_be_absent);
    return UNITY_END();
}
