// SPDX-License-Identifier: Apache-2.0
// Devices that only measure: values at SYNC or by a clock of the device, delays, time stamps, errors and
// losses.
#include "sim/devices/measuring_device.h"
#include "test/unit/sim/devices/master.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define ID 0x39U
#define GYRO "descriptors/devices/gyro.eds"
#define TRACKER "descriptors/devices/star-tracker.eds"
#define STEP_NS 500000U

static master_t master;
static measuring_device_t* device;
static char error[EDS_ERROR_MAX];
// First value: rate [rad/s] of the gyro, sent in units of 1e-7; component of the quaternion of the star
// tracker, sent in units of 1e-9.
static double truth;
static uint64_t numbers[64];
static unsigned measured;
static bool is_lost;

static bool measure(void* context, uint64_t number, double* out_values)
{
    numbers[measured % 64U] = number;
    measured++;
    for (unsigned i = 0U; i < *(const unsigned*)context; i++) {
        out_values[i] = truth * (1.0 + i);
    }
    return !is_lost;
}

static status_t create(const char* sheet, unsigned values, uint64_t period_ns, uint64_t delay_ns)
{
    static unsigned count;
    count                           = values;
    const measuring_config_t config = {.value_count = values,
                                       .period_ns   = period_ns,
                                       .delay_ns    = delay_ns,
                                       .step_ns     = STEP_NS,
                                       .measure     = measure,
                                       .context     = &count};
    return measuring_device_create(master.bus, sheet, ID, &config, &device, error);
}

static void begin(const char* sheet, unsigned values, uint64_t period_ns, uint64_t delay_ns)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, create(sheet, values, period_ns, delay_ns), error);
    node_power_on(measuring_device_node(device));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
    master_wait(&master, STEP_NS);
    measured = 0U;
}

void setUp(void)
{
    device   = NULL;
    truth    = 0.01;
    measured = 0U;
    is_lost  = false;
    master_open(&master, false);
}

void tearDown(void)
{
    measuring_device_destroy(device);
    master_close(&master);
}

static void run(unsigned steps)
{
    for (unsigned i = 0U; i < steps; i++) {
        master_wait(&master, STEP_NS);
        measuring_device_end_step(device, bus_now_ns(master.bus));
    }
}

static const uint8_t* pdo(unsigned number)
{
    return master_last(&master, 0x080U + (0x100U * number) + ID)->data;
}

static void a_gyro_measures_at_each_sync(void)
{
    begin(GYRO, 3U, 0U, 0U);
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT32(100000, (int32_t)octets_u32(pdo(1U)));
    TEST_ASSERT_EQUAL_INT32(200000, (int32_t)octets_u32(&pdo(1U)[4]));
    TEST_ASSERT_EQUAL_INT32(300000, (int32_t)octets_u32(pdo(2U)));
    const unsigned counter = octets_u16(&pdo(2U)[4]);
    TEST_ASSERT_EQUAL_UINT8(0U, pdo(2U)[6]);
    truth = -0.02;
    run(10U);
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT32(-200000, (int32_t)octets_u32(pdo(1U)));
    TEST_ASSERT_EQUAL_UINT(counter + 1U, octets_u16(&pdo(2U)[4]));
    TEST_ASSERT_EQUAL_UINT64(2U, measured);
    TEST_ASSERT_GREATER_THAN_UINT64(numbers[0], numbers[1]);
    truth = 1e6; // Beyond the range of the object.
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, (int32_t)octets_u32(pdo(1U)));
}

/// Replace each `old` in a text by `new`, which has the same length.
static void replace(char* text, const char* old, const char* new)
{
    TEST_ASSERT_EQUAL_UINT(strlen(old), strlen(new));
    for (char* at = strstr(text, old); at != NULL; at = strstr(at, old)) {
        memcpy(at, new, strlen(new));
    }
}

/// CiA 404 has the measured values as REAL32 in 0x6130. The sheet is that of the gyro with these objects.
static void a_device_measures_real_numbers(void)
{
    static char text[64U * 1024U];
    char path[]         = "/tmp/hirosco-measuring-XXXXXX";
    FILE* sheet         = fopen(GYRO, "r");
    const size_t length = fread(text, 1U, sizeof text - 1U, sheet);
    text[length]        = '\0';
    (void)fclose(sheet);
    replace(text, "9130", "6130");
    replace(text, "DataType=0x0004", "DataType=0x0008");
    const int file = mkstemp(path);
    TEST_ASSERT_EQUAL_INT((int)length, (int)write(file, text, length));
    (void)close(file);
    begin(path, 3U, 0U, 0U);
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_HEX32(0x3C23D70AU, octets_u32(pdo(1U))); // 0.01 as REAL32.
    TEST_ASSERT_EQUAL_HEX32(0x3CA3D70AU, octets_u32(&pdo(1U)[4]));
    TEST_ASSERT_EQUAL_HEX32(0x3CF5C28FU, octets_u32(pdo(2U)));
    TEST_ASSERT_EQUAL_UINT8(0U, pdo(2U)[6]);
    truth = -1e6;
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_HEX32(0xC9742400U, octets_u32(pdo(1U)));
    measuring_device_set_error(device, 0x5000U, true, bus_now_ns(master.bus));
    truth = 1.0;
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_HEX32(0xC9742400U, octets_u32(pdo(1U))); // Not valid: the values do not change.
    TEST_ASSERT_EQUAL_UINT8(1U, pdo(2U)[6]);
    (void)unlink(path);
}

static void a_star_tracker_exposes_by_its_own_clock_and_sends_time_stamps(void)
{
    begin(TRACKER, 4U, 10U * MASTER_MS, 0U);
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_UINT8(1U, pdo(3U)[6]); // Nothing measured so far.
    run(30U);
    const unsigned before = measured;
    TEST_ASSERT_TRUE((before == 1U) || (before == 2U));
    truth = 0.2;
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT32(10000000,
                            (int32_t)octets_u32(pdo(1U))); // The last exposure was before the change.
    TEST_ASSERT_EQUAL_UINT8(0U, pdo(3U)[6]);
    TEST_ASSERT_EQUAL_UINT16(1U, octets_u16(pdo(3U)));
    const uint64_t exposed_us = octets_u32(&pdo(3U)[2]);
    TEST_ASSERT_TRUE((exposed_us > 0U) && (exposed_us < 16000U));
    const uint8_t counter = pdo(3U)[7];
    run(25U);
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_INT32(200000000, (int32_t)octets_u32(pdo(1U)));
    TEST_ASSERT_EQUAL_INT32(800000000, (int32_t)octets_u32(&pdo(2U)[4]));
    TEST_ASSERT_EQUAL_UINT16(2U, octets_u16(pdo(3U)));
    TEST_ASSERT_TRUE(pdo(3U)[7] > counter);
    TEST_ASSERT_EQUAL_UINT64(numbers[0] + 1U, numbers[1]);
}

static void a_value_is_available_after_its_delay(void)
{
    begin(TRACKER, 4U, 10U * MASTER_MS, 25U * MASTER_MS);
    run(45U); // Exposures at 10 and 20 ms: available at 35 and 45 ms, after the next SYNC.
    const unsigned before = measured;
    master_sync(&master, STEP_NS);
    TEST_ASSERT_TRUE(before >= 2U);
    TEST_ASSERT_EQUAL_UINT8(1U, pdo(3U)[6]);
    run(40U);
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_UINT8(0U, pdo(3U)[6]);
    TEST_ASSERT_LESS_THAN_UINT(measured, pdo(3U)[7]);
    TEST_ASSERT_EQUAL_UINT16(0U, octets_u16(pdo(3U))); // The SYNCs before that exposure.
}

static void a_lost_measurement_changes_nothing(void)
{
    begin(GYRO, 3U, 0U, 0U);
    master_sync(&master, STEP_NS);
    const uint16_t counter = octets_u16(&pdo(2U)[4]);
    is_lost                = true;
    truth                  = 0.5;
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_UINT16(counter, octets_u16(&pdo(2U)[4]));
    TEST_ASSERT_EQUAL_INT32(100000, (int32_t)octets_u32(pdo(1U)));
}

static void errors_make_measurements_invalid_and_warnings_do_not(void)
{
    begin(GYRO, 3U, 0U, 0U);
    master_sync(&master, STEP_NS);
    measuring_device_set_error(device, EMERGENCY_DEVICE_TEMPERATURE, true, bus_now_ns(master.bus));
    truth = 0.02;
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_UINT8(0U, pdo(2U)[6]);
    TEST_ASSERT_EQUAL_UINT(1U, master_heard(&master, 0x080U + ID));
    measuring_device_set_error(device, 0x5000U, true, bus_now_ns(master.bus));
    measuring_device_set_error(device, 0x5000U, true, bus_now_ns(master.bus));
    measuring_device_set_error(device, 0x5001U, true, bus_now_ns(master.bus));
    truth = 0.03;
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_UINT8(1U, pdo(2U)[6]);
    TEST_ASSERT_EQUAL_INT32(200000, (int32_t)octets_u32(pdo(1U)));
    measuring_device_set_error(device, 0x5000U, false, bus_now_ns(master.bus));
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_UINT8(1U, pdo(2U)[6]);
    measuring_device_set_error(device, 0x5001U, false, bus_now_ns(master.bus));
    master_sync(&master, STEP_NS);
    TEST_ASSERT_EQUAL_UINT8(0U, pdo(2U)[6]);
    TEST_ASSERT_EQUAL_INT32(300000, (int32_t)octets_u32(pdo(1U)));
}

static void a_star_tracker_without_power_does_not_expose(void)
{
    begin(TRACKER, 4U, 10U * MASTER_MS, 0U);
    node_power_off(measuring_device_node(device));
    run(60U);
    TEST_ASSERT_EQUAL_UINT(0U, measured);
}

static void a_data_sheet_without_the_objects_of_the_device_is_refused(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, create("descriptors/devices/wheel.eds", 3U, 0U, 0U));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "wheel.eds: an object that a measuring device needs"), error);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, create(GYRO, 4U, 0U, 0U));
    TEST_ASSERT_NULL(device);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_gyro_measures_at_each_sync);
    RUN_TEST(a_device_measures_real_numbers);
    RUN_TEST(a_star_tracker_exposes_by_its_own_clock_and_sends_time_stamps);
    RUN_TEST(a_value_is_available_after_its_delay);
    RUN_TEST(a_lost_measurement_changes_nothing);
    RUN_TEST(errors_make_measurements_invalid_and_warnings_do_not);
    RUN_TEST(a_star_tracker_without_power_does_not_expose);
    RUN_TEST(a_data_sheet_without_the_objects_of_the_device_is_refused);
    return UNITY_END();
}
