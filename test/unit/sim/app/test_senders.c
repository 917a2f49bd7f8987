// SPDX-License-Identifier: Apache-2.0
// Two devices of a bus that would send with the same identifier are refused with the line of the second one.
#include "sim/app/senders.h"

#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define BUSES 2U

static world_t world;
static segment_t segments[BUSES];
static bus_t* channel_b[BUSES];
static devices_t* devices;
static plant_truth_t truth;
static char error[SIMULATOR_ERROR_MAX];

void setUp(void)
{
    char reason[DOCUMENT_ERROR_MAX];
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read("descriptors/worlds/rokviss.xml", &world, reason),
                                  reason);
    TEST_ASSERT_EQUAL_UINT(BUSES, world.bus_count);
    for (unsigned i = 0U; i < BUSES; i++) {
        const segment_config_t config = {.name = world.bus[i], .bit_rate = 1000000U, .seed = 1U};
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_open(&segments[i], &config, error));
    }
    error[0] = '\0';
}

void tearDown(void)
{
    devices_close(devices);
    devices = NULL;
    for (unsigned i = 0U; i < BUSES; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_close(&segments[i]));
    }
    temporary_files_remove();
}

/// Check the senders with the data sheet of the drives in which `words` are replaced.
static status_t check_with(const char* words, const char* replacement)
{
    char directory[256];
    (void)temporary_variant("joystick.eds", "descriptors/devices/joystick.eds", "[", "[");
    const char* sheet =
        temporary_variant("joint-drive.eds", "descriptors/devices/joint-drive.eds", words, replacement);
    (void)snprintf(directory, sizeof directory, "%.*s", (int)(strrchr(sheet, '/') - sheet), sheet);
    const devices_config_t config = {.world     = &world,
                                     .directory = directory,
                                     .truth     = &truth,
                                     .segments  = segments,
                                     .channel_b = channel_b};
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, devices_open(&config, &devices, error), error);
    const status_t status = senders_check(devices, &world, error);
    devices_close(devices);
    devices = NULL;
    return status;
}

static void devices_with_identifiers_of_their_own_are_accepted(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, check_with("[", "["), error);
}

static void a_second_sender_of_an_identifier_is_refused_with_its_line(void)
{
    char expected[SIMULATOR_ERROR_MAX];
    (void)snprintf(expected, sizeof expected,
                   "simulator: descriptors/worlds/rokviss.xml:%u: JOINT2 sends process data with identifier "
                   "0x1A0, as JOINT1 does in line %u: expected data sheets with different identifiers on bus "
                   "robot",
                   world.drive[1].device.line, world.drive[0].device.line);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, check_with("DefaultValue=$NODEID+0x180\n", "DefaultValue=0x1A0\n"));
    TEST_ASSERT_EQUAL_STRING(expected, error);
}

static void disabled_process_data_and_another_bus_have_no_conflict(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(
        STATUS_OK, check_with("DefaultValue=$NODEID+0x180\n", "DefaultValue=0x800001A0\n"), error);
    world.drive[1].device.bus = 1U;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK,
                                  check_with("DefaultValue=$NODEID+0x180\n", "DefaultValue=0x1A0\n"), error);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(devices_with_identifiers_of_their_own_are_accepted);
    RUN_TEST(a_second_sender_of_an_identifier_is_refused_with_its_line);
    RUN_TEST(disabled_process_data_and_another_bus_have_no_conflict);
    return UNITY_END();
}
