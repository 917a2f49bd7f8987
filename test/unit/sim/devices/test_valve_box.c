// SPDX-License-Identifier: Apache-2.0
// The valve box on a bus: outputs, inputs, shortest pulses, longest times, and its reactions when the master
// is lost.
#include "sim/devices/emergency.h"
#include "sim/devices/valve_box.h"
#include "test/unit/sim/devices/master.h"
#include "unity.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#define ID 0x3AU
#define SHEET "descriptors/devices/valve-box.eds"
#define REAL_SHEET "descriptors/devices/valve-timer.eds" // The longest time is a REAL32.
#define CYCLE_NS 10000000U
#define PULSE_NS 20000000U // Shortest pulse of output 2.

static master_t master;
static valve_box_t* box;
static char error[EDS_ERROR_MAX];
static unsigned changes[VALVE_BOX_OUTPUTS];
static uint64_t changed_ns;

static void changed(void* context, unsigned output, bool is_open, uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&master, context);
    TEST_ASSERT_EQUAL(is_open, (changes[output] % 2U) == 0U);
    changes[output]++;
    changed_ns = now_ns;
}

static void open_box(const char* const sheet)
{
    const valve_box_config_t config = {
        .shortest_ns = {[1] = PULSE_NS}, .changed = changed, .context = &master};
    memset(changes, 0, sizeof changes);
    master_open(&master, true);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, valve_box_create(master.bus, sheet, ID, &config, &box, error),
                                  error);
    node_power_on(valve_box_node(box));
    master_wait(&master, 2U * MASTER_MS);
    master_nmt(&master, 1U, ID);
}

void setUp(void)
{
    open_box(SHEET);
}

void tearDown(void)
{
    valve_box_destroy(box);
    master_close(&master);
}

static void send(const uint16_t outputs, const uint16_t longest)
{
    const uint8_t data[4] = {(uint8_t)outputs, (uint8_t)(outputs >> 8), (uint8_t)longest,
                             (uint8_t)(longest >> 8)};
    master_send(&master, 0x200U + ID, data, 4U);
}

/// Send SYNC and wait for one cycle, with a step of the plant in each millisecond.
static void cycle(void)
{
    master_send(&master, 0x080U, NULL, 0U);
    for (unsigned i = 0U; i < 10U; i++) {
        master_wait(&master, CYCLE_NS / 10U);
        valve_box_end_step(box, bus_now_ns(master.bus));
    }
}

static uint16_t open_outputs(void)
{
    uint16_t bits = 0U;
    for (unsigned i = 0U; i < VALVE_BOX_OUTPUTS; i++) {
        bits = (uint16_t)(bits | (valve_box_is_open(box, i) ? (1U << i) : 0U));
    }
    return bits;
}

static uint16_t inputs(void)
{
    return octets_u16(master_last(&master, 0x180U + ID)->data);
}

static void each_output_moves_its_valve_and_its_input(void)
{
    for (unsigned i = 0U; i < VALVE_BOX_OUTPUTS; i++) {
        send((uint16_t)(1U << i), 0U);
        cycle();
        cycle();
        cycle(); // After these cycles the shortest pulse of the output before is over, too.
        send((uint16_t)(1U << i), 0U); // Before the RPDO deadline of 50 ms.
        cycle();
        TEST_ASSERT_EQUAL_HEX16(1U << i, open_outputs());
        TEST_ASSERT_EQUAL_HEX16(1U << i, inputs());
        TEST_ASSERT_EQUAL_UINT(1U, changes[i]);
    }
    send(0U, 0U);
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0U, open_outputs());
    TEST_ASSERT_EQUAL_HEX16(0U, inputs()); // The TPDO of the same SYNC has the new inputs.
}

static void a_command_acts_at_sync(void)
{
    send(0x8001U, 0U);
    master_wait(&master, CYCLE_NS / 10U);
    TEST_ASSERT_EQUAL_HEX16(0U, open_outputs());
    master_send(&master, 0x080U, NULL, 0U);
    master_wait(&master, CYCLE_NS / 10U);
    TEST_ASSERT_EQUAL_HEX16(0x8001U, open_outputs());
}

static void a_pulse_is_at_least_the_shortest_one(void)
{
    send(0x0003U, 0U);
    cycle();
    const uint64_t opened_ns = changed_ns;
    send(0x0000U, 0U);
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0002U, open_outputs()); // The other open output has no shortest pulse.
    TEST_ASSERT_EQUAL_HEX16(0x0002U, inputs());
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0000U, open_outputs());
    TEST_ASSERT_TRUE(changed_ns >= (opened_ns + PULSE_NS));
    TEST_ASSERT_TRUE(changed_ns <= (opened_ns + PULSE_NS + (CYCLE_NS / 10U)));
}

static void the_longest_time_closes_all_valves(void)
{
    send(0xFFFFU, 3U);
    cycle();
    const uint64_t opened_ns = changed_ns;
    cycle();
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, open_outputs());
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0000U, open_outputs());
    TEST_ASSERT_TRUE((changed_ns - opened_ns) >= 30000000U);
    TEST_ASSERT_TRUE((changed_ns - opened_ns) <= 31000000U);
    send(0x0001U, 3U); // Each command restarts the longest time.
    cycle();
    send(0x0001U, 3U);
    cycle();
    cycle();
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0001U, open_outputs());
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0000U, open_outputs());
}

static void all_valves_close_if_no_rpdo_arrives(void)
{
    send(0xFFFFU, 0U);
    for (unsigned i = 0U; i < 4U; i++) {
        cycle();
        TEST_ASSERT_EQUAL_HEX16(0xFFFFU, open_outputs());
    }
    cycle();
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0000U, open_outputs());
    TEST_ASSERT_EQUAL_HEX16(EMERGENCY_RPDO_TIMEOUT, octets_u16(master_last(&master, 0x080U + ID)->data));
    send(0x0001U, 0U); // The next command opens the valve again.
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0001U, open_outputs());
}

static void each_output_has_its_own_error_mode_and_error_value(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6206U, 1U, 0x0FU, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6207U, 1U, 0xC3U, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, master_write(&master, ID, 0x6207U, 2U, 0x80U, 1U));
    send(0xFF55U, 0U);
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0xFF55U, open_outputs());
    for (unsigned i = 0U; i < 8U; i++) {
        cycle();
    }
    // Outputs 1 to 4 and 9 to 16 take their error value; outputs 5 to 8 have error mode 0 and keep their
    // state.
    TEST_ASSERT_EQUAL_HEX16(0x8053U, open_outputs());
}

static void leaving_operational_closes_all_valves(void)
{
    static const uint8_t commands[] = {2U, 128U, 129U, 130U};
    for (size_t i = 0U; i < sizeof commands; i++) {
        master_nmt(&master, 1U, ID);
        send(0x0101U, 0U);
        cycle();
        TEST_ASSERT_EQUAL_HEX16(0x0101U, open_outputs());
        master_nmt(&master, commands[i], ID);
        cycle();
        TEST_ASSERT_EQUAL_HEX16(0x0000U, open_outputs());
    }
}

static void without_power_valves_close_at_once(void)
{
    send(0x0002U, 0U);
    cycle();
    node_power_off(valve_box_node(box));
    TEST_ASSERT_EQUAL_HEX16(0x0000U, open_outputs());
    TEST_ASSERT_EQUAL_UINT(2U, changes[1]);
    cycle();
    TEST_ASSERT_EQUAL_HEX16(0x0000U, open_outputs());
}

static void a_data_sheet_of_another_device_is_refused(void)
{
    const valve_box_config_t config = {.changed = NULL};
    valve_box_t* other              = NULL;
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, valve_box_create(master.bus, "descriptors/devices/joint-drive.eds",
                                                           0x3BU, &config, &other, error));
    TEST_ASSERT_NOT_NULL(strstr(error, "an object that a valve box needs is missing"));
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND,
                          valve_box_create(master.bus, "nowhere.eds", 0x3CU, &config, &other, error));
    TEST_ASSERT_NULL(other);
}

static void a_longest_time_in_real32_closes_the_valves_to_a_part_of_its_unit(void)
{
    static const struct {
        float longest; // In 10 ms.
        unsigned open_ms;
    } rows[] = {{2.5F, 25U},
                {0.25F, 3U},
                {0.0F, UINT_MAX},
                {-1.0F, UINT_MAX},
                {(float)NAN, UINT_MAX},
                {1e30F, UINT_MAX},
                {(float)INFINITY, UINT_MAX}};
    valve_box_destroy(box);
    master_close(&master);
    open_box(REAL_SHEET);
    for (size_t i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        uint8_t data[6] = {1U, 0U};
        uint32_t bits   = 0U;
        (void)memcpy(&bits, &rows[i].longest, sizeof bits);
        for (unsigned k = 0U; k < 4U; k++) {
            data[2U + k] = (uint8_t)(bits >> (8U * k));
        }
        master_send(&master, 0x200U + ID, data, sizeof data);
        master_send(&master, 0x080U, NULL, 0U);
        const uint64_t start_ns = bus_now_ns(master.bus);
        unsigned open_ms        = UINT_MAX;
        for (unsigned ms = 1U; (ms <= 40U) && (open_ms == UINT_MAX); ms++) {
            master_wait(&master, MASTER_MS);
            valve_box_end_step(box, bus_now_ns(master.bus));
            open_ms = valve_box_is_open(box, 0U) ? UINT_MAX : ms;
        }
        TEST_ASSERT_LESS_OR_EQUAL_UINT64(50U * MASTER_MS, bus_now_ns(master.bus) - start_ns);
        TEST_ASSERT_UINT_WITHIN_MESSAGE(1U, rows[i].open_ms, open_ms,
                                        "time for which the valve was open [ms]");
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_output_moves_its_valve_and_its_input);
    RUN_TEST(a_command_acts_at_sync);
    RUN_TEST(a_pulse_is_at_least_the_shortest_one);
    RUN_TEST(the_longest_time_closes_all_valves);
    RUN_TEST(all_valves_close_if_no_rpdo_arrives);
    RUN_TEST(each_output_has_its_own_error_mode_and_error_value);
    RUN_TEST(leaving_operational_closes_all_valves);
    RUN_TEST(without_power_valves_close_at_once);
    RUN_TEST(a_data_sheet_of_another_device_is_refused);
    RUN_TEST(a_longest_time_in_real32_closes_the_valves_to_a_part_of_its_unit);
    return UNITY_END();
}
