// SPDX-License-Identifier: Apache-2.0
// The bus in simulated time: arbitration, arrival of frames, errors; equal seeds repeat a run.
#include "sim/bus/bus.h"
#include "sim/bus/frame_length.h"
#include "unity.h"

#include <string.h>

#define HEARD_MAX 4096U
#define MS 1000000U
#define FD_BRS (OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS)

typedef struct {
    osal_can_frame_t frame[HEARD_MAX];
    unsigned count;
    unsigned reports;
    uint32_t report_classes;
    unsigned wakes;
    uint64_t woken_ns;
} listener_t;

static bus_t* bus;
static listener_t listener[4];
static unsigned node[4];
static uint32_t random_state;

static void hear(void* context, const osal_can_frame_t* frame)
{
    listener_t* own = context;
    TEST_ASSERT_LESS_THAN_UINT(HEARD_MAX, own->count);
    own->frame[own->count] = *frame;
    own->count++;
}

static void hear_report(void* context, const osal_can_frame_t* frame)
{
    listener_t* own = context;
    own->reports++;
    own->report_classes |= frame->id;
}

static void wake(void* context, uint64_t now_ns)
{
    listener_t* own = context;
    own->woken_ns   = now_ns;
    own->wakes++;
}

static void open_bus(unsigned nodes, uint32_t data_bit_rate, uint64_t seed)
{
    const bus_config_t config = {.nominal_bit_rate = 1000000U, .data_bit_rate = data_bit_rate, .seed = seed};
    bus_destroy(bus);
    bus = bus_create(&config);
    TEST_ASSERT_NOT_NULL(bus);
    memset(listener, 0, sizeof listener);
    for (unsigned i = 0U; i < nodes; i++) {
        const bus_callbacks_t callbacks = {
            .on_frame = hear, .on_error = hear_report, .on_wake = wake, .context = &listener[i]};
        TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(bus, &callbacks, &node[i]));
    }
}

void setUp(void)
{
    random_state = 7U;
    open_bus(3U, 5000000U, 1U);
}

void tearDown(void)
{
    bus_destroy(bus);
    bus = NULL;
}

static uint32_t random_below(uint32_t limit)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8) % limit;
}

static osal_can_frame_t data_frame(uint32_t id, uint8_t length, uint8_t flags)
{
    osal_can_frame_t frame = {.id = id, .length = length, .flags = flags};
    for (unsigned i = 0U; i < length; i++) {
        frame.data[i] = (uint8_t)random_below(256U);
    }
    return frame;
}

static void submit(unsigned from, const osal_can_frame_t* frame, uint64_t time_ns)
{
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(bus, node[from], frame, time_ns));
}

static uint64_t duration_ns(const osal_can_frame_t* frame)
{
    const frame_length_t length = frame_length(frame);
    return (length.nominal_bits * 1000U) + (length.data_bits * 200U);
}

static void a_frame_arrives_at_all_other_nodes_at_its_end(void)
{
    const osal_can_frame_t classic = data_frame(0x123U, 8U, 0U);
    submit(0U, &classic, 5000U);
    bus_run_until(bus, MS);
    TEST_ASSERT_EQUAL_UINT(0U, listener[0].count);
    for (unsigned i = 1U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_UINT(1U, listener[i].count);
        TEST_ASSERT_EQUAL_HEX32(0x123U, listener[i].frame[0].id);
        TEST_ASSERT_EQUAL_MEMORY(classic.data, listener[i].frame[0].data, 8U);
        TEST_ASSERT_EQUAL_UINT64(5000U + duration_ns(&classic), listener[i].frame[0].time_ns);
    }
    TEST_ASSERT_EQUAL_UINT64(1U, bus_statistics(bus)->frames);
    TEST_ASSERT_EQUAL_UINT64(duration_ns(&classic) + 3000U, bus_statistics(bus)->busy_ns);
}

static void frames_follow_each_other_after_three_bits(void)
{
    const osal_can_frame_t first  = data_frame(0x300U, 8U, FD_BRS);
    const osal_can_frame_t second = data_frame(0x100U, 0U, 0U);
    submit(0U, &first, 0U);
    submit(0U, &second, 0U);
    bus_run_until(bus, MS);
    TEST_ASSERT_EQUAL_UINT(2U, listener[1].count);
    TEST_ASSERT_EQUAL_UINT64(duration_ns(&first) + 3000U + duration_ns(&second),
                             listener[1].frame[1].time_ns);
}

static void a_queue_keeps_its_order_whatever_the_identifiers(void)
{
    for (uint32_t i = 0U; i < 8U; i++) {
        const osal_can_frame_t frame = data_frame(0x700U - (i * 0x80U), 2U, 0U);
        submit(0U, &frame, 0U);
    }
    bus_run_until(bus, 10U * MS);
    TEST_ASSERT_EQUAL_UINT(8U, listener[1].count);
    for (uint32_t i = 0U; i < 8U; i++) {
        TEST_ASSERT_EQUAL_HEX32(0x700U - (i * 0x80U), listener[1].frame[i].id);
    }
}

static void a_frame_that_does_not_end_in_a_run_continues_in_the_next(void)
{
    const osal_can_frame_t frame = data_frame(0x10U, 8U, 0U);
    submit(0U, &frame, 0U);
    // The frame ends exactly at that instant and has not yet arrived.
    bus_run_until(bus, duration_ns(&frame));
    TEST_ASSERT_EQUAL_UINT(0U, listener[1].count);
    TEST_ASSERT_EQUAL_UINT(1U, bus_queued(bus, 0U));
    bus_run_until(bus, duration_ns(&frame) + 1U);
    TEST_ASSERT_EQUAL_UINT(1U, listener[1].count);
    TEST_ASSERT_EQUAL_UINT(0U, bus_queued(bus, 0U));
}

/// The rule of arbitration, checked over the frames that were ready when a frame began.
static void the_ready_frame_with_the_lowest_identifier_always_wins(void)
{
    struct {
        osal_can_frame_t frame[30];
        uint64_t ready_ns[30];
        unsigned head;
    } queue[3];
    for (unsigned round = 0U; round < 200U; round++) {
        open_bus(4U, 5000000U, 1U);
        memset(queue, 0, sizeof queue);
        for (unsigned n = 0U; n < 3U; n++) {
            uint64_t ready_ns = 0U;
            for (unsigned i = 0U; i < 30U; i++) {
                // 3 k + n: no two nodes use the same identifier. A quarter has 29 bits.
                uint32_t id = (random_below(680U) * 3U) + n;
                if (random_below(4U) == 0U) {
                    id = (id << 18) | random_below(1U << 18) | OSAL_CAN_EXTENDED;
                }
                ready_ns += random_below(200000U);
                queue[n].frame[i] =
                    data_frame(id, (uint8_t)random_below(9U), (random_below(2U) == 0U) ? 0U : FD_BRS);
                queue[n].ready_ns[i] = ready_ns;
                submit(n, &queue[n].frame[i], ready_ns);
            }
        }
        bus_run_until(bus, 100U * MS);
        TEST_ASSERT_EQUAL_UINT(90U, listener[3].count);
        uint64_t idle_ns = 0U;
        for (unsigned k = 0U; k < 90U; k++) {
            uint64_t start_ns = BUS_NEVER;
            for (unsigned n = 0U; n < 3U; n++) {
                if ((queue[n].head < 30U) && (queue[n].ready_ns[queue[n].head] < start_ns)) {
                    start_ns = queue[n].ready_ns[queue[n].head];
                }
            }
            start_ns        = (start_ns > idle_ns) ? start_ns : idle_ns;
            unsigned winner = 3U;
            uint64_t lowest = UINT64_MAX;
            for (unsigned n = 0U; n < 3U; n++) {
                if ((queue[n].head == 30U) || (queue[n].ready_ns[queue[n].head] > start_ns)) {
                    continue;
                }
                const osal_can_frame_t* head = &queue[n].frame[queue[n].head];
                const bool is_long           = (head->id & OSAL_CAN_EXTENDED) != 0U;
                const uint32_t id            = head->id & OSAL_CAN_ID_MASK;
                // Rank: the 11 base bits, then short before long identifiers, then the other 18 bits.
                const uint64_t rank = is_long ? (((uint64_t)(id >> 18) << 20) | (1U << 19) | (id & 0x3FFFFU))
                                              : ((uint64_t)id << 20);
                if (rank < lowest) {
                    lowest = rank;
                    winner = n;
                }
            }
            const osal_can_frame_t* sent = &queue[winner].frame[queue[winner].head];
            TEST_ASSERT_EQUAL_HEX32(sent->id, listener[3].frame[k].id);
            TEST_ASSERT_EQUAL_UINT64(start_ns + duration_ns(sent), listener[3].frame[k].time_ns);
            idle_ns = listener[3].frame[k].time_ns + 3000U;
            queue[winner].head++;
        }
    }
}

static void the_frames_of_a_robot_cycle_take_at_most_the_computed_time(void)
{
    // SYNC and four PDOs at 1/5 Mbit/s: 278 us with the worst stuffing.
    for (unsigned round = 0U; round < 1000U; round++) {
        const uint64_t begin_ns = bus_now_ns(bus);
        const uint64_t busy_ns  = bus_statistics(bus)->busy_ns;
        for (uint32_t k = 0U; k < 2U; k++) {
            const osal_can_frame_t rpdo = data_frame(0x211U + k, 8U, FD_BRS);
            const osal_can_frame_t tpdo = data_frame(0x191U + k, 8U, FD_BRS);
            submit(0U, &rpdo, begin_ns);
            submit(1U + k, &tpdo, begin_ns);
        }
        const osal_can_frame_t sync = data_frame(0x080U, 0U, 0U);
        submit(0U, &sync, begin_ns);
        bus_run_until(bus, begin_ns + 500000U);
        const uint64_t used_ns = bus_statistics(bus)->busy_ns - busy_ns;
        TEST_ASSERT_LESS_OR_EQUAL_UINT64(278200U, used_ns);
        TEST_ASSERT_GREATER_THAN_UINT64(240000U, used_ns);
        for (unsigned i = 0U; i < 3U; i++) {
            TEST_ASSERT_EQUAL_UINT(0U, bus_queued(bus, i));
            listener[i].count = 0U;
        }
    }
}

static void wake_callbacks_are_called_in_the_order_of_their_times(void)
{
    bus_set_wake(bus, node[1], 2000U);
    bus_set_wake(bus, node[0], 1000U);
    bus_run_until(bus, 2000U);
    TEST_ASSERT_EQUAL_UINT(1U, listener[0].wakes);
    TEST_ASSERT_EQUAL_UINT64(1000U, listener[0].woken_ns);
    TEST_ASSERT_EQUAL_UINT(0U, listener[1].wakes);
    bus_set_wake(bus, node[0], BUS_NEVER);
    bus_run_until(bus, MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[0].wakes);
    TEST_ASSERT_EQUAL_UINT64(2000U, listener[1].woken_ns);
}

static void bad_frames_and_full_queues_are_refused(void)
{
    osal_can_frame_t frame = data_frame(0x1U, 8U, 0U);
    frame.length           = 9U;
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, bus_submit(bus, node[0], &frame, 0U));
    frame.flags = FD_BRS;
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, bus_submit(bus, node[0], &frame, 0U));
    frame.length = 12U;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(bus, node[0], &frame, 0U));
    frame.id = 0x1U | OSAL_CAN_REMOTE;
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, bus_submit(bus, node[0], &frame, 0U));
    frame = (osal_can_frame_t){.id = OSAL_CAN_ERROR, .length = 8U};
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, bus_submit(bus, node[0], &frame, 0U));
    frame = data_frame(0x2U, 0U, 0U);
    for (unsigned i = 0U; i < BUS_QUEUE_FRAMES; i++) {
        submit(1U, &frame, 0U);
    }
    TEST_ASSERT_EQUAL_INT(STATUS_FULL, bus_submit(bus, node[1], &frame, 0U));
    TEST_ASSERT_EQUAL_UINT(BUS_QUEUE_FRAMES, bus_queued(bus, node[1]));

    open_bus(2U, 0U, 1U); // Classic bus.
    frame = data_frame(0x2U, 8U, FD_BRS);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, bus_submit(bus, node[0], &frame, 0U));
    TEST_ASSERT_FALSE(bus_is_fd(bus));
    const bus_config_t odd = {.nominal_bit_rate = 999999U};
    TEST_ASSERT_NULL(bus_create(&odd));
}

static void a_lone_sender_becomes_error_passive_and_continues_to_try(void)
{
    const osal_can_frame_t frame = data_frame(0x123U, 8U, 0U);
    bus_unplug(bus, node[1]);
    bus_unplug(bus, node[2]);
    submit(0U, &frame, 0U);
    bus_run_until(bus, 100U * MS);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_PASSIVE, bus_controller(bus, node[0])->state);
    TEST_ASSERT_EQUAL_UINT32(128U, bus_controller(bus, node[0])->transmit_errors);
    TEST_ASSERT_EQUAL_UINT(3U, listener[0].reports); // Missing acknowledgement, warning, error passive.
    TEST_ASSERT_EQUAL_HEX32(OSAL_CAN_ERROR | OSAL_CAN_ERROR_NO_ACK | OSAL_CAN_ERROR_CONTROLLER,
                            listener[0].report_classes);
    TEST_ASSERT_EQUAL_UINT(1U, bus_queued(bus, node[0]));
    // Each try: frame to the ACK slot, error frame 20, intermission 3, suspend 8 bits when passive.
    const uint64_t try_ns = duration_ns(&frame) - 8000U + 31000U;
    const uint64_t tries  = bus_statistics(bus)->errors;
    TEST_ASSERT_UINT64_WITHIN(2U, (100U * MS) / try_ns, tries);
    bus_plug(bus, node[1]);
    bus_run_until(bus, 101U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[1].count);
    TEST_ASSERT_EQUAL_UINT(0U, listener[2].count);
    TEST_ASSERT_EQUAL_UINT32(127U, bus_controller(bus, node[0])->transmit_errors);
}

static void unplugging_the_sender_breaks_its_frame(void)
{
    const osal_can_frame_t mine   = data_frame(0x100U, 8U, 0U);
    const osal_can_frame_t theirs = data_frame(0x200U, 8U, 0U);
    submit(0U, &mine, 0U);
    submit(1U, &theirs, 0U);
    bus_run_until(bus, 40000U);
    bus_unplug(bus, node[0]);
    TEST_ASSERT_EQUAL_INT(STATUS_CLOSED, bus_submit(bus, node[0], &mine, 40000U));
    bus_run_until(bus, MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[2].count);
    TEST_ASSERT_EQUAL_HEX32(0x200U, listener[2].frame[0].id);
    TEST_ASSERT_EQUAL_UINT64(40000U + 23000U + duration_ns(&theirs), listener[2].frame[0].time_ns);
    // One error, then a good frame.
    TEST_ASSERT_EQUAL_UINT32(0U, bus_controller(bus, node[2])->receive_errors);
    TEST_ASSERT_EQUAL_UINT(0U, listener[0].count);
    TEST_ASSERT_FALSE(bus_is_plugged(bus, node[0]));
    bus_plug(bus, node[0]);
    submit(0U, &mine, MS);
    bus_run_until(bus, 2U * MS);
    TEST_ASSERT_EQUAL_UINT(2U, listener[2].count);
}

static void a_frame_is_not_acknowledged_after_the_only_receiver_is_unplugged(void)
{
    const osal_can_frame_t frame = data_frame(0x100U, 8U, 0U);
    bus_unplug(bus, node[2]);
    submit(0U, &frame, 0U);
    bus_run_until(bus, 40000U);
    bus_unplug(bus, node[1]);
    bus_run_until(bus, MS);
    TEST_ASSERT_EQUAL_UINT(0U, listener[1].count);
    TEST_ASSERT_TRUE((listener[0].report_classes & OSAL_CAN_ERROR_NO_ACK) != 0U);
}

static void equal_frames_merge_and_unequal_ones_destroy_each_other(void)
{
    const osal_can_frame_t sync = data_frame(0x080U, 0U, 0U);
    submit(0U, &sync, 0U);
    submit(1U, &sync, 0U);
    bus_run_until(bus, MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[2].count);
    TEST_ASSERT_EQUAL_UINT(0U, bus_queued(bus, node[0]) + bus_queued(bus, node[1]));

    const osal_can_frame_t one = {.id = 0x200U, .length = 1U, .data = {1U}};
    const osal_can_frame_t two = {.id = 0x200U, .length = 1U, .data = {2U}};
    submit(0U, &one, MS);
    submit(1U, &two, MS);
    bus_run_until(bus, 5U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[2].count);
    TEST_ASSERT_TRUE((listener[0].report_classes & OSAL_CAN_ERROR_BUS_OFF) != 0U);
    TEST_ASSERT_TRUE((listener[1].report_classes & OSAL_CAN_ERROR_BUS_OFF) != 0U);
    // Both queues are empty; after 128 x 11 bits both controllers have recovered from bus-off.
    bus_run_until(bus, 20U * MS);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, bus_controller(bus, node[0])->state);
    TEST_ASSERT_TRUE((listener[0].report_classes & OSAL_CAN_ERROR_RESTARTED) != 0U);
    submit(0U, &one, 20U * MS);
    bus_run_until(bus, 21U * MS);
    TEST_ASSERT_EQUAL_UINT(2U, listener[2].count);
}

static void unequal_frames_destroy_each_other_without_any_receiver(void)
{
    const osal_can_frame_t one = {.id = 0x591U, .length = 1U, .data = {1U}};
    const osal_can_frame_t two = {.id = 0x591U, .length = 0U};
    open_bus(2U, 5000000U, 1U);
    submit(0U, &one, 0U);
    submit(1U, &two, 0U);
    // Both have been in bus-off and have recovered; their frames were discarded.
    bus_run_until(bus, 20U * MS);
    TEST_ASSERT_TRUE((listener[0].report_classes & OSAL_CAN_ERROR_BUS_OFF) != 0U);
    TEST_ASSERT_TRUE((listener[1].report_classes & OSAL_CAN_ERROR_BUS_OFF) != 0U);
    submit(0U, &one, 20U * MS);
    bus_run_until(bus, 21U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[1].count);
}

static void send_in_turn(unsigned frames)
{
    for (unsigned i = 0U; i < frames; i++) {
        const osal_can_frame_t frame = data_frame(0x100U + (i & 0xFFU), 8U, 0U);
        submit(i % 3U, &frame, bus_now_ns(bus));
        bus_run_until(bus, bus_now_ns(bus) + (MS / 2U));
    }
}

static void each_receiver_loses_the_commanded_share_of_frames(void)
{
    bus_set_loss(bus, 0.25);
    send_in_turn(3000U);
    // Each node could receive 2000 frames of other nodes and lost a quarter of them; the bus carried all
    // frames.
    TEST_ASSERT_EQUAL_UINT64(3000U, bus_statistics(bus)->frames);
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_UINT_WITHIN(80U, 1500U, listener[i].count);
        TEST_ASSERT_EQUAL_UINT32(0U, bus_controller(bus, node[i])->transmit_errors);
    }
    TEST_ASSERT_EQUAL_UINT64(6000U - (listener[0].count + listener[1].count + listener[2].count),
                             bus_statistics(bus)->lost);
}

static void corruption_costs_time_and_increases_counters_but_loses_no_frame(void)
{
    bus_set_corruption(bus, 0.05);
    send_in_turn(3000U);
    TEST_ASSERT_EQUAL_UINT64(3000U, bus_statistics(bus)->frames);
    TEST_ASSERT_UINT64_WITHIN(50U, 158U, bus_statistics(bus)->errors); // 3000 x 0.05 / 0.95
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_UINT(2000U, listener[i].count);
    }
}

static void duplicated_frames_arrive_twice(void)
{
    bus_set_duplication(bus, 0.05);
    send_in_turn(2000U);
    TEST_ASSERT_EQUAL_UINT64(bus_statistics(bus)->frames * 2U,
                             listener[0].count + listener[1].count + listener[2].count);
    TEST_ASSERT_UINT64_WITHIN(40U, 2105U, bus_statistics(bus)->frames);
}

static uint64_t hash_of_a_noisy_run(uint64_t seed)
{
    random_state = 3U;
    open_bus(3U, 5000000U, seed);
    bus_set_loss(bus, 0.02);
    bus_set_corruption(bus, 0.05);
    bus_set_duplication(bus, 0.01);
    send_in_turn(1000U);
    uint64_t hash = 0xCBF29CE484222325U;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < listener[i].count; k++) {
            hash = (hash ^ listener[i].frame[k].time_ns ^ ((uint64_t)listener[i].frame[k].id << 40)) *
                   0x100000001B3U;
        }
    }
    return hash;
}

static void equal_seeds_give_equal_faults_and_unequal_seeds_do_not(void)
{
    const uint64_t first = hash_of_a_noisy_run(11U);
    TEST_ASSERT_EQUAL_HEX64(first, hash_of_a_noisy_run(11U));
    TEST_ASSERT_TRUE(first != hash_of_a_noisy_run(12U));
}

static void a_babbling_node_keeps_other_nodes_from_sending(void)
{
    const osal_can_frame_t frame = data_frame(0x100U, 8U, 0U);
    bus_set_babbling(bus, node[2], true);
    submit(0U, &frame, 0U);
    bus_run_until(bus, 10U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, bus_queued(bus, node[0]));
    TEST_ASSERT_GREATER_THAN_UINT(70U, listener[1].count);
    TEST_ASSERT_EQUAL_HEX32(0U, listener[1].frame[5].id);
    TEST_ASSERT_UINT64_WITHIN(200000U, 10U * MS, bus_statistics(bus)->busy_ns);
    bus_set_babbling(bus, node[2], false);
    bus_run_until(bus, 11U * MS);
    TEST_ASSERT_EQUAL_UINT(0U, bus_queued(bus, node[0]));
}

static void a_dominant_bus_drives_the_sender_bus_off_and_the_others_error_passive(void)
{
    const osal_can_frame_t frame = data_frame(0x100U, 8U, 0U);
    submit(0U, &frame, 0U);
    bus_run_until(bus, 20000U);
    bus_set_stuck(bus, true);
    bus_run_until(bus, 10U * MS);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_BUS_OFF, bus_controller(bus, node[0])->state);
    TEST_ASSERT_EQUAL_UINT(1U, bus_off_count(bus));
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_PASSIVE, bus_controller(bus, node[1])->state);
    TEST_ASSERT_EQUAL_UINT(0U, listener[1].count);
    bus_set_stuck(bus, false);
    bus_run_until(bus, 20U * MS);
    TEST_ASSERT_EQUAL_INT(CONTROLLER_STATE_ACTIVE, bus_controller(bus, node[0])->state);
    submit(0U, &frame, 20U * MS);
    bus_run_until(bus, 21U * MS);
    TEST_ASSERT_EQUAL_UINT(1U, listener[1].count);
}

static void a_delayed_node_sends_later_by_the_delay(void)
{
    const osal_can_frame_t frame = data_frame(0x100U, 8U, 0U);
    bus_set_delay(bus, node[0], 70000U);
    submit(0U, &frame, 1000U);
    bus_run_until(bus, MS);
    TEST_ASSERT_EQUAL_UINT64(71000U + duration_ns(&frame), listener[1].frame[0].time_ns);
}

static unsigned tapped;
static unsigned tapped_reports;

static void tap(void* context, uint32_t senders, const osal_can_frame_t* frame)
{
    TEST_ASSERT_EQUAL((frame->id & OSAL_CAN_ERROR) != 0U, senders == 0U);
    (void)context;
    tapped++;
    tapped_reports += ((frame->id & OSAL_CAN_ERROR) != 0U) ? 1U : 0U;
}

static void the_tap_shows_the_wire_and_the_reports_of_one_controller(void)
{
    tapped         = 0U;
    tapped_reports = 0U;
    bus_set_tap(bus, tap, NULL, node[0]);
    send_in_turn(9U);
    TEST_ASSERT_EQUAL_UINT(9U, tapped);
    bus_unplug(bus, node[1]);
    bus_unplug(bus, node[2]);
    const osal_can_frame_t frame = data_frame(0x100U, 8U, 0U);
    submit(0U, &frame, bus_now_ns(bus));
    bus_run_until(bus, bus_now_ns(bus) + (10U * MS));
    TEST_ASSERT_EQUAL_UINT(3U, tapped_reports);
    TEST_ASSERT_EQUAL_UINT(12U, tapped);
}

static void a_new_node_can_replace_a_removed_one(void)
{
    unsigned extra[BUS_NODES_MAX];
    const bus_callbacks_t silent = {.context = NULL};
    for (unsigned i = 3U; i < BUS_NODES_MAX; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(bus, &silent, &extra[i]));
    }
    unsigned none = 0U;
    TEST_ASSERT_EQUAL_INT(STATUS_EXHAUSTED, bus_add_node(bus, &silent, &none));
    bus_remove_node(bus, extra[7]);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(bus, &silent, &none));
    TEST_ASSERT_EQUAL_UINT(extra[7], none);
    send_in_turn(3U);
    TEST_ASSERT_EQUAL_UINT64(3U, bus_statistics(bus)->frames);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_frame_arrives_at_all_other_nodes_at_its_end);
    RUN_TEST(frames_follow_each_other_after_three_bits);
    RUN_TEST(a_queue_keeps_its_order_whatever_the_identifiers);
    RUN_TEST(a_frame_that_does_not_end_in_a_run_continues_in_the_next);
    RUN_TEST(the_ready_frame_with_the_lowest_identifier_always_wins);
    RUN_TEST(the_frames_of_a_robot_cycle_take_at_most_the_computed_time);
    RUN_TEST(wake_callbacks_are_called_in_the_order_of_their_times);
    RUN_TEST(bad_frames_and_full_queues_are_refused);
    RUN_TEST(a_lone_sender_becomes_error_passive_and_continues_to_try);
    RUN_TEST(unplugging_the_sender_breaks_its_frame);
    RUN_TEST(a_frame_is_not_acknowledged_after_the_only_receiver_is_unplugged);
    RUN_TEST(equal_frames_merge_and_unequal_ones_destroy_each_other);
    RUN_TEST(unequal_frames_destroy_each_other_without_any_receiver);
    RUN_TEST(each_receiver_loses_the_commanded_share_of_frames);
    RUN_TEST(corruption_costs_time_and_increases_counters_but_loses_no_frame);
    RUN_TEST(duplicated_frames_arrive_twice);
    RUN_TEST(equal_seeds_give_equal_faults_and_unequal_seeds_do_not);
    RUN_TEST(a_babbling_node_keeps_other_nodes_from_sending);
    RUN_TEST(a_dominant_bus_drives_the_sender_bus_off_and_the_others_error_passive);
    RUN_TEST(a_delayed_node_sends_later_by_the_delay);
    RUN_TEST(the_tap_shows_the_wire_and_the_reports_of_one_controller);
    RUN_TEST(a_new_node_can_replace_a_removed_one);
    return UNITY_END();
}
