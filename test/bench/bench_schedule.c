// SPDX-License-Identifier: Apache-2.0
/// A time schedule with 10 000 activities: a request inserts one activity and a step releases one; and a step
/// in which no activity is due. Baselines: a sorted array that is moved to make room, with the same packets
/// checked and copied; and one comparison of times. The baseline of the second row is the first row with 100
/// activities: it shows the additional cost of many.
#include "pus/st11/st11_time_schedule.h"
#include "test/bench/measure.h"

#include <stdlib.h>
#include <string.h>

#define MANY 10000U
#define FEW 100U
#define WORK 16U
#define APID 16U
#define GROUP 1U
#define EPOCH_S 2000000000U
#define STEP_NS 1000000ULL
#define REQUEST_SIZE 33U
#define HEAD 11U // Sub-schedule, count, group and time before the request.

typedef struct { // A schedule and its environment.
    pus_time_schedule_t schedule;
    pus_app_process_t process;
    pus_dispatcher_t dispatcher;
    pus_service_t services[1];
    pus_activity_t activities[MANY + 1U];
    pus_sorted_index_node_t nodes[MANY + 1U];
    uint16_t buckets[16384];
    uint64_t storage[PUS_BLOCK_CHAIN_WORDS(MANY + 1U)];
    pool_slot_t slots[MANY + 1U];
    pus_block_chains_t chains;
    uint64_t now_ns;
    uint32_t state;
    uint64_t horizon_ms; // Range of the tags.
} held_t;

typedef struct {
    uint64_t time_ns;
    uint8_t request[REQUEST_SIZE];
} row_t;

static held_t many;
static held_t few;
static row_t* rows[MANY + 1U]; // The latest is the first.
static row_t row_storage[MANY + 1U];
static row_t* free_rows[MANY + 1U];
static size_t row_count;
static size_t free_count;
static uint64_t array_now_ns;
static uint32_t array_state = 1U;
static volatile uint64_t first_ns;
static volatile unsigned sink; // Keeps the compiler from removing the work.
static unsigned released;

static status_t take(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    sink = packet[size - 1U];
    released++;
    return STATUS_OK;
}

static void must(const bool is_good)
{
    if (!is_good) {
        abort();
    }
}

static size_t make(uint8_t* const octets, const uint8_t service, const uint8_t subtype,
                   const uint16_t sequence, const uint8_t* const data, const size_t size)
{
    size_t packet_size = 0U;
    const pus_tc_t tc  = {.apid     = APID,
                          .sequence = sequence,
                          .service  = service,
                          .subtype  = subtype,
                          .data     = data,
                          .size     = size};
    must(pus_tc_encode(&tc, octets, PUS_PACKET_MAX, &packet_size) == STATUS_OK);
    return packet_size;
}

static uint32_t draw(uint32_t* const state)
{
    *state = (*state * 1664525U) + 1013904223U;
    return *state >> 8U;
}

/// TC[11,4] with one activity.
static size_t make_insertion(uint8_t* const packet, const uint64_t time_ns, const uint16_t sequence)
{
    uint8_t data[HEAD + PUS_PACKET_MAX];
    static const uint8_t content[REQUEST_SIZE - PUS_TC_MIN] = {0};
    octet_writer_t writer                                   = octet_writer(data, HEAD);
    octet_write_u8(&writer, 1U);
    octet_write_u8(&writer, 1U);
    octet_write_u8(&writer, GROUP);
    pus_time_write(&writer, (EPOCH_S * 1000000000ULL) + time_ns);
    const size_t size = make(&data[HEAD], 17U, 1U, sequence, content, sizeof content);
    return make(packet, PUS_SERVICE_TIME_SCHEDULE, 4U, 0U, data, HEAD + size);
}

static void dispatch(held_t* const held, const uint8_t* const packet, const size_t size)
{
    must(pus_dispatch(&held->dispatcher, packet, size, held->now_ns) == STATUS_OK);
}

static void insert(held_t* const held)
{
    uint8_t packet[PUS_PACKET_MAX];
    const uint64_t ms = 1U + (draw(&held->state) % held->horizon_ms);
    const size_t size =
        make_insertion(packet, held->now_ns + (ms * STEP_NS), (uint16_t)(held->state & 0x3FFFU));
    const uint32_t all = held->schedule.schedule.counters.inserted;
    dispatch(held, packet, size);
    must(held->schedule.schedule.counters.inserted == (all + 1U));
}

static void fill(held_t* const held, const uint16_t count)
{
    static const uint8_t group[]       = {1U, GROUP, 1U};
    static const uint8_t all[]         = {0U};
    uint8_t packet[PUS_PACKET_MAX]     = {0};
    const pus_port_t port              = {.send = take};
    const pus_schedule_config_t config = {.process            = &held->process,
                                          .release            = port,
                                          .activities         = held->activities,
                                          .nodes              = held->nodes,
                                          .activity_count     = MANY + 1U,
                                          .buckets            = held->buckets,
                                          .bucket_count       = 16384U,
                                          .chains             = &held->chains,
                                          .sub_schedule_count = 1U,
                                          .group_count        = 1U};
    pus_block_chains_init(&held->chains, held->storage, held->slots, MANY + 1U);
    pus_app_process_init(&held->process, APID, EPOCH_S, &port);
    pus_time_schedule_init(&held->schedule, EPOCH_S, &config);
    held->services[0] = pus_time_schedule_service(&held->schedule);
    pus_dispatcher_init(&held->dispatcher, &held->process, held->services, 1U);
    held->state      = 1U;
    held->horizon_ms = count * 2U;
    dispatch(held, packet, make(packet, PUS_SERVICE_TIME_SCHEDULE, 22U, 0U, group, sizeof group));
    dispatch(held, packet, make(packet, PUS_SERVICE_TIME_SCHEDULE, 1U, 0U, NULL, 0U));
    for (uint16_t i = 0U; i < count; i++) {
        insert(held);
    }
    dispatch(held, packet, make(packet, PUS_SERVICE_TIME_SCHEDULE, 20U, 0U, all, sizeof all));
}

/// Insert one activity and advance to the time of the first one, so that their number stays the same.
static void insert_and_release(held_t* const held)
{
    for (unsigned i = 0U; i < WORK; i++) {
        insert(held);
        const unsigned before = released;
        while (released == before) {
            held->now_ns = pus_time_schedule_next_ns(&held->schedule);
            pus_time_schedule_step(&held->schedule, held->now_ns);
        }
        for (unsigned more = released - before; more > 1U; more--) { // Several activities were due together.
            insert(held);
        }
    }
}

static void among_many(void)
{
    insert_and_release(&many);
}

static void among_few(void)
{
    insert_and_release(&few);
}

static void array_insert(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    const uint64_t ms      = 1U + (draw(&array_state) % (MANY * 2U));
    const uint64_t time_ns = array_now_ns + (ms * STEP_NS);
    const size_t size      = make_insertion(packet, time_ns, (uint16_t)(array_state & 0x3FFFU));
    pus_tc_t outer;
    pus_tc_t inner;
    pus_failure_t failure;
    must(pus_tc_decode(packet, size, &outer, &failure) == STATUS_OK);
    must(pus_tc_decode(&outer.data[HEAD], outer.size - HEAD, &inner, &failure) == STATUS_OK);
    free_count--;
    row_t* const row = free_rows[free_count];
    row->time_ns     = time_ns;
    memcpy(row->request, &outer.data[HEAD], REQUEST_SIZE);
    size_t low  = 0U;
    size_t high = row_count;
    while (low < high) {
        const size_t middle = (low + high) / 2U;
        if (rows[middle]->time_ns > time_ns) {
            low = middle + 1U;
        } else {
            high = middle;
        }
    }
    memmove(&rows[low + 1U], &rows[low], (row_count - low) * sizeof rows[0]);
    rows[low] = row;
    row_count++;
}

static void among_sorted(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        array_insert();
        row_count--;
        row_t* const row = rows[row_count];
        array_now_ns     = row->time_ns;
        (void)take(NULL, row->request, REQUEST_SIZE);
        free_rows[free_count] = row;
        free_count++;
    }
}

static void idle_step(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        pus_time_schedule_step(&many.schedule, many.now_ns);
    }
}

static void compare(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        if (first_ns <= many.now_ns) {
            abort();
        }
    }
}

int main(void)
{
    for (size_t i = 0U; i <= MANY; i++) {
        free_rows[i] = &row_storage[i];
    }
    free_count = MANY + 1U;
    for (unsigned i = 0U; i < MANY; i++) {
        array_insert();
    }
    fill(&many, MANY);
    fill(&few, FEW);
    measure_compare("schedule_insert_and_release_10000", among_many, among_sorted, WORK, "ns", 1.0);
    measure_compare("schedule_10000_by_100", among_many, among_few, WORK, "ns", 1.0);
    many.now_ns = pus_time_schedule_next_ns(&many.schedule) - 1000U;
    first_ns    = UINT64_MAX;
    measure_compare("schedule_idle_step_10000", idle_step, compare, WORK, "ns", 1.0);
    return 0;
}
