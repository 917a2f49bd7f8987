// SPDX-License-Identifier: Apache-2.0
// Commanded faults of a bus, and the reports of the affected controller to its software.
#include "sim/bus/bus.h"
#include "unity.h"

#include <string.h>

#define REPORTS_MAX 64U
#define US 1000U
#define MS 1000000U
#define RECOVERY_NS (CONTROLLER_RECOVERY_BITS * US) // At 1 Mbit/s.
#define OVERFLOW 0x01U

typedef struct {
    osal_can_frame_t report[REPORTS_MAX];
    unsigned reports;
    unsigned frames;
} listener_t;

static bus_t* bus;
static listener_t listener[3];
static unsigned node[3];

static void hear(void* context, const osal_can_frame_t* frame)
{
    listener_t* own = context;
    (void)frame;
    own->frames++;
}

static void hear_report(void* context, const osal_can_frame_t* frame)
{
    listener_t* own = context;
    TEST_ASSERT_LESS_THAN_UINT(REPORTS_MAX, own->reports);
    own->report[own->reports] = *frame;
    own->reports++;
}

void setUp(void)
{
    const bus_config_t config = {.nominal_bit_rate = 1000000U, .data_bit_rate = 5000000U, .seed = 1U};
    bus                       = bus_create(&config);
    TEST_ASSERT_NOT_NULL(bus);
    memset(listener, 0, sizeof listener);
    for (unsigned i = 0U; i < 3U; i++) {
        const bus_callbacks_t callbacks = {
            .on_frame = hear, .on_error = hear_report, .context = &listener[i]};
        TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(bus, &callbacks, &node[i]));
    }
}

void tearDown(void)
{
    bus_destroy(bus);
}

static status_t submit(unsigned index, uint32_t id, uint64_t time_ns)
{
    const osal_can_frame_t frame = {.id = id, .length = 2U};
    return bus_submit(bus, node[index], &frame, time_ns);
}

static void run(uint64_t ns)
{
    bus_run_until(bus, bus_now_ns(bus) + ns);
}

static const osal_can_frame_t* last_report(unsigned index)
{
    TEST_ASSERT_GREATER_THAN_UINT(0U, listener[index].reports);
    return &listener[index].report[listener[index].reports - 1U];
}

static void bus_off_ends_after_128_times_11_bits(void)
{
    run(MS);
    bus_force_off(bus, node[0]);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_BUS_OFF, last_report(0U)->id);
    TEST_ASSERT_EQUAL_UINT8(255U, last_report(0U)->data[6]);
    TEST_ASSERT_EQUAL_INT(STATUS_CLOSED, submit(0U, 0x100U, 0U));
    const uint64_t off_ns = bus_now_ns(bus);
    run(2U * MS);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_RESTARTED | OSAL_CAN_ERROR_CONTROLLER,
                            last_report(0U)->id);
    TEST_ASSERT_EQUAL_UINT64(off_ns + RECOVERY_NS, last_report(0U)->time_ns);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x100U, 0U));
    run(MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[1].frames);
}

static void bus_off_lasts_until_a_restart_if_it_is_not_automatic(void)
{
    bus_set_restart(bus, node[0], false);
    bus_restart(bus, node[0]); // The controller is not in bus-off: no effect.
    bus_force_off(bus, node[0]);
    bus_force_off(bus, node[0]);
    const unsigned reports = listener[0].reports;
    run(100U * MS);
    TEST_ASSERT_EQUAL_UINT(reports, listener[0].reports);
    const uint64_t restart_ns = bus_now_ns(bus);
    bus_restart(bus, node[0]);
    run(MS);
    bus_restart(bus, node[0]); // The recovery is running and does not start again.
    run(MS);
    TEST_ASSERT_EQUAL_UINT64(restart_ns + RECOVERY_NS, last_report(0U)->time_ns);
    bus_set_restart(bus, node[0], true);
    bus_force_off(bus, node[0]);
    run(2U * MS);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, bus_controller(bus, node[0])->state);
}

static void bus_off_breaks_the_frame_on_the_wire(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x100U, 0U));
    run(20U * US);
    bus_force_off(bus, node[0]);
    run(MS);
    TEST_ASSERT_EQUAL_UINT(0U, listener[1].frames);
    TEST_ASSERT_EQUAL_UINT64(1U, bus_statistics(bus)->errors);
    bus_unplug(bus, node[1]);
    bus_force_off(bus, node[1]); // No effect on a controller that is unplugged.
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, bus_controller(bus, node[1])->state);
}

static void an_overflow_loses_frames_that_others_receive(void)
{
    bus_lose_next(bus, node[1], 2U);
    for (unsigned i = 0U; i < 5U; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x100U + i, 0U));
    }
    run(2U * MS);
    TEST_ASSERT_EQUAL_UINT(3U, listener[1].frames);
    TEST_ASSERT_EQUAL_UINT(5U, listener[2].frames);
    TEST_ASSERT_EQUAL_UINT(2U, listener[1].reports);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_CONTROLLER, last_report(1U)->id);
    TEST_ASSERT_EQUAL_HEX8(OVERFLOW, last_report(1U)->data[1]);
    // The frame was acknowledged by other nodes, so its sender gets no report.
    TEST_ASSERT_EQUAL_UINT(0U, listener[0].reports);
}

static void lost_arbitration_is_reported_with_its_bit_to_nodes_that_request_it(void)
{
    bus_set_arbitration_reports(bus, node[1], true);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x120U, 0U)); // 001 0010 0000
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(1U, 0x130U, 0U)); // 001 0011 0000: the seventh bit
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(2U, 0x140U, 0U));
    run(MS);
    TEST_ASSERT_EQUAL_UINT(0U, listener[0].reports);
    TEST_ASSERT_EQUAL_UINT(1U, listener[1].reports);
    // Node 2 lost twice, but its driver does not report lost arbitration.
    TEST_ASSERT_EQUAL_UINT(0U, listener[2].reports);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_LOST_ARBITRATION, last_report(1U)->id);
    TEST_ASSERT_EQUAL_UINT8(6U, last_report(1U)->data[0]);
    TEST_ASSERT_EQUAL_UINT(2U, listener[1].frames); // The frame was sent after the frame that won.
    TEST_ASSERT_EQUAL_UINT(2U, listener[0].frames);
}

static void a_frame_that_cannot_leave_is_reported(void)
{
    bus_set_transmit_timeout(bus, node[0], 10U * MS);
    bus_set_babbling(bus, node[2], true);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x100U, 0U));
    run(9U * MS);
    TEST_ASSERT_EQUAL_UINT(0U, listener[0].reports);
    run(2U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[0].reports);
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_TX_TIMEOUT, last_report(0U)->id);
    TEST_ASSERT_EQUAL_UINT64(10U * MS, last_report(0U)->time_ns);
    run(100U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[0].reports); // One report for the frame that waits.
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x101U, 0U));
    run(11U * MS);
    TEST_ASSERT_EQUAL_UINT(2U,
                           listener[0].reports); // One more report for the frame that was submitted later.
}

static void frames_that_leave_in_time_are_not_reported(void)
{
    bus_set_transmit_timeout(bus, node[0], 2U * MS);
    for (unsigned i = 0U; i < 40U; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x100U, 0U));
        run(MS);
    }
    TEST_ASSERT_EQUAL_UINT(40U, listener[1].frames);
    TEST_ASSERT_EQUAL_UINT(0U, listener[0].reports);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, submit(0U, 0x100U, 0U));
    bus_unplug(bus, node[0]);
    run(10U * MS); // The queue of node 0 was discarded when it was unplugged.
    TEST_ASSERT_EQUAL_UINT(0U, listener[0].reports);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(bus_off_ends_after_128_times_11_bits);
    RUN_TEST(bus_off_lasts_until_a_restart_if_it_is_not_automatic);
    RUN_TEST(bus_off_breaks_the_frame_on_the_wire);
    RUN_TEST(an_overflow_loses_frames_that_others_receive);
    RUN_TEST(lost_arbitration_is_reported_with_its_bit_to_nodes_that_request_it);
    RUN_TEST(a_frame_that_cannot_leave_is_reported);
    RUN_TEST(frames_that_leave_in_time_are_not_reported);
    return UNITY_END();
}
