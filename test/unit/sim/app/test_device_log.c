// SPDX-License-Identifier: Apache-2.0
// Benches, power units and buses of a world in the truth log. Instruments need a flow; the mission zoo tests
// them.
#include "sim/app/device_log.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <lcm/eventlog.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define BUSES 3U
#define STEP_NS 500000U
#define CONTENT 20U // Octets of an event before its first array.

static world_t world;
static segment_t segments[BUSES];
static bus_t* channel_b[BUSES];
static devices_t* devices;
static plant_truth_t truth;
static truth_t* truth_log;
static device_log_t device_log;
static char error[SIMULATOR_ERROR_MAX];
static char path[64];

static void changed(void* context, uint64_t now_ns, const truth_drive_t* drive)
{
    (void)context;
    (void)now_ns;
    (void)drive;
}

/// The world of the mission rokviss with one more motor, on a bench on another bus.
void setUp(void)
{
    char reason[DOCUMENT_ERROR_MAX];
    (void)snprintf(path, sizeof path, "/tmp/device-log-%ld.lcm", (long)getpid());
    (void)temporary_copy("rokviss.urdf", "descriptors/worlds/rokviss.urdf");
    const char* file = temporary_variant(
        "w.xml", "descriptors/worlds/rokviss.xml", "</World>",
        "<Bench name=\"MOTOR\" type=\"light\" bus=\"gripper\" node=\"0x31\" eds=\"joint-drive.eds\" "
        "contact=\"0.6\" stiffness=\"400\" range=\"2\"/>\n</World>");
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(file, &world, reason), reason);
    for (unsigned i = 0U; i < BUSES; i++) {
        const segment_config_t config = {
            .name = world.bus[i], .bit_rate = 1000000U, .data_bit_rate = 5000000U, .seed = 1U};
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_open(&segments[i], &config, error));
    }
    const devices_config_t wanted = {.world     = &world,
                                     .directory = "descriptors/devices",
                                     .truth     = &truth,
                                     .segments  = segments,
                                     .channel_b = channel_b,
                                     .seed      = 1U,
                                     .changed   = changed};
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, devices_open(&wanted, &devices, error), error);
    devices_power_on(devices);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_open(path, TRUTH_OCTETS_MAX, &truth_log));
    device_log =
        (device_log_t){.world = &world, .devices = devices, .segments = segments, .bus_count = BUSES};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, device_log_names(truth_log, &device_log));
}

void tearDown(void)
{
    devices_close(devices);
    for (unsigned i = 0U; i < BUSES; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK, segment_close(&segments[i]));
    }
    temporary_files_remove();
    (void)unlink(path);
}

static void steps(const unsigned first, const unsigned last)
{
    for (unsigned i = first; i <= last; i++) {
        const uint64_t now_ns = (uint64_t)i * STEP_NS;
        for (unsigned k = 0U; k < BUSES; k++) {
            bus_run_until(segments[k].bus, now_ns);
        }
        TEST_ASSERT_EQUAL_INT(STATUS_OK, device_log_state(truth_log, &device_log, now_ns));
    }
}

/// Returns the octets of the last event of a channel in the log, and the number of its events. Valid until
/// the next call.
static const unsigned char* last_event(const char* channel, unsigned* out_count)
{
    static unsigned char octets[1024];
    lcm_eventlog_t* log         = lcm_eventlog_create(path, "r");
    lcm_eventlog_event_t* event = NULL;
    *out_count                  = 0U;
    while ((event = lcm_eventlog_read_next_event(log)) != NULL) {
        if (strcmp(event->channel, channel) == 0) {
            memcpy(octets, event->data, (size_t)event->datalen);
            (*out_count)++;
        }
        lcm_eventlog_free_event(event);
    }
    lcm_eventlog_destroy(log);
    return octets;
}

static void the_names_are_those_of_the_world(void)
{
    unsigned count = 0U;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_close(truth_log));
    const unsigned char* names = last_event("NAMES", &count);
    TEST_ASSERT_EQUAL_UINT(3U, count); // Events for BENCH, POWER and BUS; the world has no instrument.
    TEST_ASSERT_EQUAL_STRING("BUS", (const char*)&names[20]);
    TEST_ASSERT_EQUAL_STRING(world.bus[0], (const char*)&names[20 + 4 + 4 + 4]);
}

static void buses_have_load_errors_and_controllers_that_are_off(void)
{
    steps(1U, 200U);
    bus_set_restart(segments[1].bus, 0U, false);
    bus_force_off(segments[1].bus, 0U); // The first device of the second bus.
    steps(201U, 401U);                  // The next interval ends within these steps.
    const uint64_t errors = bus_statistics(segments[1].bus)->errors;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_close(truth_log));
    unsigned count            = 0U;
    const unsigned char* last = last_event("BUS", &count);
    TEST_ASSERT_EQUAL_UINT8(BUSES, last[CONTENT - 1U]);
    // The arrays of the event: load (double) and frames (u64), errors (u64), state (i32), controllers off
    // (i32).
    const unsigned char* load        = &last[CONTENT];
    const unsigned char* error_count = &load[16U * BUSES];
    const unsigned char* state       = &load[24U * BUSES];
    const unsigned char* off         = &state[4U * BUSES];
    TEST_ASSERT_EQUAL_UINT8(errors % 256U, error_count[8U + 7U]);
    TEST_ASSERT_GREATER_THAN_UINT(0U, errors);
    TEST_ASSERT_EQUAL_UINT8(0xFFU, state[0]); // There is no flight software: -1.
    TEST_ASSERT_EQUAL_UINT8(0U, off[3]);
    TEST_ASSERT_EQUAL_UINT8(1U, off[4U + 3U]);
    TEST_ASSERT_GREATER_THAN_UINT(3U, count); // The intervals, and the changes between them.
}

static void a_bus_is_logged_ten_times_a_second(void)
{
    unsigned count = 0U;
    steps(1U, 2000U);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_close(truth_log));
    (void)last_event("BUS", &count);
    // Each interval changes load and errors and may log the last step before, too.
    TEST_ASSERT_UINT_WITHIN(4U, 18U, count);
    (void)last_event("BENCH", &count);
    TEST_ASSERT_UINT_WITHIN(1U, 11U, count);
}

static void a_device_that_is_switched_off_is_not_supplied(void)
{
    unsigned count = 0U;
    steps(1U, 10U);
    TEST_ASSERT_GREATER_THAN_UINT(0U, device_log.supply_count);
    node_power_off(device_model(devices, device_log.supply[0])->node);
    steps(11U, 20U);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, truth_close(truth_log));
    const unsigned char* last = last_event("POWER", &count);
    TEST_ASSERT_EQUAL_UINT8(device_log.supply_count, last[CONTENT - 1U]);
    TEST_ASSERT_EQUAL_UINT8(0U, last[CONTENT]);
    TEST_ASSERT_EQUAL_UINT8(1U, last[CONTENT + 1U]);
    TEST_ASSERT_EQUAL_UINT(4U, count); // The first and the last step of each of the two states.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_names_are_those_of_the_world);
    RUN_TEST(buses_have_load_errors_and_controllers_that_are_off);
    RUN_TEST(a_bus_is_logged_ten_times_a_second);
    RUN_TEST(a_device_that_is_switched_off_is_not_supplied);
    return UNITY_END();
}
