// SPDX-License-Identifier: Apache-2.0
// Events of the truth log, which LCM reads again: their channels and times, fewer samples of channels at
// rest, and failures. With the environment variable TRUTH_FILE the sample log is kept, for readers in other
// languages.
#include "sim/truth/truth.h"
#include "unity.h"

#include <lcm/eventlog.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SAMPLE_EVENTS 18U
#define SAMPLE_OCTETS 1894U // Size of the log up to the first fault.

static char path[256];

void setUp(void)
{
    const char* wanted = getenv("TRUTH_FILE");
    (void)snprintf(path, sizeof path, "/tmp/truth-%ld.lcm", (long)getpid());
    if (wanted != NULL) {
        (void)snprintf(path, sizeof path, "%s", wanted);
    }
}

void tearDown(void)
{
    if (getenv("TRUTH_FILE") == NULL) {
        (void)unlink(path);
    }
}

/// One event of each kind; the numbers identify the members, so that a reader detects exchanged ones.
static void write_sample(const char* where)
{
    static const char* const names[]  = {"arm.joint1", "arm.joint2", "STICK", "STICK",
                                         "arm.finger", "arm.tip",    "arm"};
    static const double numbers[7][2] = {{1.1, 1.2}, {2.1, 2.2},  {3.1, 3.2}, {4.1, 4.2},
                                         {5.1, 5.2}, {6.1, -6.2}, {7.1, 7.2}};
    static const double sticks[4][2]  = {{0.1, 0.2}, {0.3, 0.4}, {0.5, 0.6}, {0.7, -1e-300}};
    static const bool brakes[]        = {true, false};
    const truth_world_t world         = {
                {2U, names}, {2U, &names[2]}, {2U, &names[4]}, {1U, &names[4]}, {1U, &names[6]}};
    const truth_joints_t joints    = {2U,         numbers[0], numbers[1], numbers[2], numbers[3],
                                      numbers[4], numbers[5], numbers[6], brakes};
    const truth_stick_t stick      = {2U, sticks[0], sticks[1], sticks[2], sticks[3]};
    const truth_touch_t contacts[] = {{{0.1, 0.2, 0.3}, {1.1, 1.2, 1.3}, {2.1, 2.2, 2.3}, true},
                                      {{0.4, 0.5, 0.6}, {1.4, 1.5, 1.6}, {2.4, 2.5, 2.6}, false}};
    const truth_touch_t spring     = {{0.1, 0.2, 0.3}, {0.0}, {3.1, 3.2, 3.3}, true};
    const truth_base_t base      = {{1.0, 2.0, 3.0}, {0.5, 0.5, -0.5, 0.5}, {4.0, 5.0, 6.0}, {7.0, 8.0, 9.0}};
    const truth_wheel_t wheels[] = {{1.5, 0.1}, {-2.5, -0.2}};
    const truth_operator_t intent      = {{0.1, 0.2}, {0.3, 0.4}, {0.5, 0.6}, 0.75, "follow"};
    static const bool flags[]          = {true, false, true};
    const truth_benches_t benches      = {2U, numbers[0], numbers[1], numbers[2]};
    const truth_instruments_t readings = {2U, numbers[3], flags, &flags[1]};
    static const uint64_t frames[]     = {1234567890123U, 5U};
    static const uint64_t errors[]     = {7U, 0U};
    static const int32_t states[]      = {3, -1};
    static const uint32_t off[]        = {1U, 0U};
    const truth_buses_t buses          = {2U, numbers[4], frames, errors, states, off, flags};
    const truth_drive_t drive          = {"robot", 0x12U, 1U, 0x8627U, true, false};
    const truth_valve_t valve          = {"PUSH1", true};
    const truth_latch_t latch          = {"DOCK", true};
    const truth_fault_t fault          = {"unplug", "robot 0x11", true};
    truth_t* truth                     = NULL;

    TEST_ASSERT_EQUAL(STATUS_OK, truth_open(where, SAMPLE_OCTETS, &truth));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_world(truth, 0U, &world));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_names(truth, 0U, "WHEEL", &world.springs));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_joints(truth, 500000U, &joints));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_stick(truth, 500000U, &stick));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_wheels(truth, 500000U, wheels, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_contacts(truth, 1000000U, contacts, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_springs(truth, 1000000U, &spring, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_bases(truth, 1000000U, &base, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_benches(truth, 1000000U, &benches));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_instruments(truth, 1000000U, &readings));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_power(truth, 1000000U, flags, 3U));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_buses(truth, 1000000U, &buses));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_operator(truth, 1500000U, &intent));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_drive(truth, 1500123U, &drive));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_valve(truth, 1500500U, &valve));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_latch(truth, 1500500U, &latch));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_fault(truth, 95000000000U, &fault));
    // The log is full now: its last event is CUT, and the log ignores later events.
    TEST_ASSERT_EQUAL(STATUS_OK, truth_fault(truth, 96000000000U, &fault));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_fault(truth, 97000000000U, &fault));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_close(truth));
}

static void lcm_reads_the_channels_and_the_simulated_time(void)
{
    static const struct {
        const char* channel;
        int64_t time_us;
        int32_t octets; // Size of the event; 0: not compared.
    } wanted[SAMPLE_EVENTS] = {{"WORLD", 0, 0},
                               {"NAMES", 0, 20 + 10 + 15},
                               {"JOINTS", 500, 20 + 7 * 16 + 2},
                               {"STICK", 500, 20 + 64},
                               {"WHEEL", 500, 20 + 32},
                               {"CONTACT", 1000, 20 + 2 * 73},
                               {"SPRING", 1000, 20 + 49},
                               {"BASE", 1000, 20 + 104},
                               {"BENCH", 1000, 20 + 48},
                               {"INSTRUMENT", 1000, 20 + 20},
                               {"POWER", 1000, 20 + 3},
                               {"BUS", 1000, 20 + 2 * 33},
                               {"OPERATOR", 1500, 16 + 56 + 11},
                               {"DRIVE", 1500, 16 + 10 + 14},
                               {"VALVE", 1500, 16 + 10 + 1},
                               {"LATCH", 1500, 16 + 9 + 1},
                               {"FAULT", 95000000, 16 + 11 + 15 + 1},
                               {"CUT", 96000000, 16 + 8}};
    write_sample(path);
    lcm_eventlog_t* log = lcm_eventlog_create(path, "r");
    TEST_ASSERT_NOT_NULL(log);
    for (unsigned i = 0U; i < SAMPLE_EVENTS; i++) {
        lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log);
        TEST_ASSERT_NOT_NULL(event);
        TEST_ASSERT_EQUAL_INT64(i, event->eventnum);
        TEST_ASSERT_EQUAL_INT64(wanted[i].time_us, event->timestamp);
        TEST_ASSERT_EQUAL_INT32((int32_t)strlen(wanted[i].channel), event->channellen);
        TEST_ASSERT_EQUAL_STRING(wanted[i].channel, event->channel);
        TEST_ASSERT_TRUE((wanted[i].octets == 0) || (wanted[i].octets == event->datalen));
        lcm_eventlog_free_event(event);
    }
    TEST_ASSERT_NULL(lcm_eventlog_read_next_event(log));
    lcm_eventlog_destroy(log);
}

#define STEPS 2000U // 1 s.
#define STEP_NS 500000U

/// Write STEPS steps of a joystick, of which the first axis moves from `first` to `last`. Returns the number
/// of events and their times.
static unsigned write_steps(const unsigned first, const unsigned last, const double stride,
                            int64_t time_us[STEPS + 1U])
{
    truth_t* truth     = NULL;
    double position[2] = {0.5, 0.0};
    double zero[2]     = {0.0, 0.0};
    TEST_ASSERT_EQUAL(STATUS_OK, truth_open(path, TRUTH_OCTETS_MAX, &truth));
    for (unsigned i = 1U; i <= STEPS; i++) {
        const truth_stick_t stick = {2U, position, zero, zero, zero};
        position[0] += ((i >= first) && (i <= last)) ? stride : 0.0;
        zero[1] = -zero[1]; // A changed sign of zero is not a change.
        TEST_ASSERT_EQUAL(STATUS_OK, truth_stick(truth, (uint64_t)i * STEP_NS, &stick));
    }
    truth_flush(truth, true);
    TEST_ASSERT_EQUAL(STATUS_OK, truth_close(truth));
    lcm_eventlog_t* log         = lcm_eventlog_create(path, "r");
    lcm_eventlog_event_t* event = NULL;
    unsigned count              = 0U;
    while ((event = lcm_eventlog_read_next_event(log)) != NULL) {
        TEST_ASSERT_LESS_OR_EQUAL_UINT(STEPS, count);
        time_us[count] = event->timestamp;
        count++;
        lcm_eventlog_free_event(event);
    }
    lcm_eventlog_destroy(log);
    return count;
}

static void a_channel_at_rest_is_written_ten_times_a_second(void)
{
    static int64_t time_us[STEPS + 1U];
    TEST_ASSERT_EQUAL_UINT(11U, write_steps(1U, 0U, 0.0, time_us));
    for (unsigned i = 0U; i < 10U; i++) {
        TEST_ASSERT_EQUAL_INT64(500 + (100000 * i), time_us[i]);
    }
    TEST_ASSERT_EQUAL_INT64(1000000, time_us[10]); // The end of the log.
    TEST_ASSERT_EQUAL_UINT(11U, write_steps(1U, STEPS, 1e-13, time_us));
}

static void a_moving_channel_is_written_in_each_step_after_its_last_sample_at_rest(void)
{
    static int64_t time_us[STEPS + 1U];
    TEST_ASSERT_EQUAL_UINT(STEPS, write_steps(1U, STEPS, 1e-8, time_us));
    // Motion from step 1101 to step 1300: 6 events at rest, the last step at rest, 200 events of motion, 3 at
    // rest, and the end.
    TEST_ASSERT_EQUAL_UINT(6U + 1U + 200U + 3U + 1U, write_steps(1101U, 1300U, 1e-8, time_us));
    TEST_ASSERT_EQUAL_INT64(1100 * 500, time_us[6]);
    for (unsigned i = 0U; i < 200U; i++) {
        TEST_ASSERT_EQUAL_INT64((1101 + i) * 500, time_us[7U + i]);
    }
}

static void slow_motion_is_not_taken_for_rest(void)
{
    static int64_t time_us[STEPS + 1U];
    // The change since the last event exceeds the resolution in each third step.
    const unsigned count = write_steps(1U, STEPS, 4e-10, time_us);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT(STEPS / 3U, count);
}

static void a_value_that_is_not_a_number_is_not_taken_for_rest(void)
{
    static int64_t time_us[STEPS + 1U];
    TEST_ASSERT_EQUAL_UINT(STEPS, write_steps(1U, STEPS, (double)NAN, time_us));
}

static size_t read_all(const char* where, unsigned char* octet, size_t size)
{
    FILE* file = fopen(where, "rb");
    TEST_ASSERT_NOT_NULL(file);
    const size_t used = fread(octet, 1U, size, file);
    (void)fclose(file);
    return used;
}

static void equal_runs_give_equal_octets(void)
{
    static unsigned char first[4096];
    static unsigned char second[4096];
    write_sample(path);
    const size_t used = read_all(path, first, sizeof first);
    write_sample(path); // Overwrites the old one.
    TEST_ASSERT_GREATER_THAN_UINT(400U, used);
    TEST_ASSERT_EQUAL_UINT64(used, read_all(path, second, sizeof second));
    TEST_ASSERT_EQUAL_MEMORY(first, second, used);
}

static void long_words_are_truncated(void)
{
    static char word[1000];
    memset(word, 'x', sizeof word - 1U);
    const truth_fault_t fault = {word, word, false};
    truth_t* truth            = NULL;
    TEST_ASSERT_EQUAL(STATUS_OK, truth_open(path, TRUTH_OCTETS_MAX, &truth));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_fault(truth, 0U, &fault));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_close(truth));
    lcm_eventlog_t* const log         = lcm_eventlog_create(path, "r");
    lcm_eventlog_event_t* const event = lcm_eventlog_read_next_event(log);
    TEST_ASSERT_NOT_NULL(event);
    TEST_ASSERT_EQUAL_INT32(16 + 2 * (4 + 96 + 1) + 1, event->datalen);
    lcm_eventlog_free_event(event);
    lcm_eventlog_destroy(log);
    write_sample(path); // Keep the sample for readers in other languages.
}

static void failures_to_open_and_to_write_are_reported(void)
{
    truth_t* truth            = NULL;
    double moving[2]          = {0.0, 0.0};
    const truth_stick_t stick = {2U, moving, moving, moving, moving};
    TEST_ASSERT_EQUAL(STATUS_IO, truth_open("/nowhere/truth.lcm", TRUTH_OCTETS_MAX, &truth));
    TEST_ASSERT_NULL(truth);
    TEST_ASSERT_EQUAL(STATUS_OK, truth_close(NULL));

    // A full disk is detected at the latest when the log is closed.
    TEST_ASSERT_EQUAL(STATUS_OK, truth_open("/dev/full", TRUTH_OCTETS_MAX, &truth));
    status_t written = STATUS_OK;
    for (unsigned i = 0U; (i < 10000U) && (written == STATUS_OK); i++) {
        moving[0] = i;
        written   = truth_stick(truth, i, &stick);
    }
    TEST_ASSERT_EQUAL(STATUS_IO, written);
    TEST_ASSERT_EQUAL(STATUS_IO, truth_stick(truth, 1U, &stick));
    TEST_ASSERT_EQUAL(STATUS_IO, truth_close(truth));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_open("/dev/full", TRUTH_OCTETS_MAX, &truth));
    TEST_ASSERT_EQUAL(STATUS_OK, truth_stick(truth, 1U, &stick));
    TEST_ASSERT_EQUAL(STATUS_IO, truth_close(truth));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(lcm_reads_the_channels_and_the_simulated_time);
    RUN_TEST(equal_runs_give_equal_octets);
    RUN_TEST(a_channel_at_rest_is_written_ten_times_a_second);
    RUN_TEST(a_moving_channel_is_written_in_each_step_after_its_last_sample_at_rest);
    RUN_TEST(slow_motion_is_not_taken_for_rest);
    RUN_TEST(a_value_that_is_not_a_number_is_not_taken_for_rest);
    RUN_TEST(failures_to_open_and_to_write_are_reported);
    RUN_TEST(long_words_are_truncated);
    return UNITY_END();
}
