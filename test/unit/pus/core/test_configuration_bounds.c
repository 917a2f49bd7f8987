// SPDX-License-Identifier: Apache-2.0
// The smallest and the largest configuration of each service are accepted; the next value beyond fails an
// assertion.
#include "pus/core/packet_store.h"
#include "pus/core/report_selection.h"
#include "pus/core/requester.h"
#include "pus/st03/st03_housekeeping.h"
#include "pus/st04/st04_statistics.h"
#include "pus/st05/st05_events.h"
#include "pus/st06/st06_memory.h"
#include "pus/st08/st08_functions.h"
#include "pus/st11/st11_time_schedule.h"
#include "pus/st12/st12_monitoring.h"
#include "pus/st13/st13_large_packets.h"
#include "pus/st15/st15_storage.h"
#include "pus/st18/st18_procedures.h"
#include "pus/st19/st19_event_action.h"
#include "pus/st21/st21_sequences.h"
#include "test/support/assertion.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

static uint64_t room[1024]; // Memory for the tables of every service.
static pus_requester_t requester;
static pus_block_chains_t chains;

void setUp(void)
{
    memset(room, 0, sizeof room);
    bench_start();
}

void tearDown(void)
{
}

// The value under test, and the function that starts the service with it.
static uint64_t value;

static void expect_bounds(void (*const begin)(void), const uint64_t least, const uint64_t greatest)
{
    const uint64_t inside[]  = {least, greatest};
    const uint64_t outside[] = {least - 1U, greatest + 1U};
    for (unsigned i = 0U; i < 2U; i++) {
        value = inside[i];
        TEST_ASSERT_FALSE_MESSAGE(assertion_fails(begin), "a permitted value failed an assertion");
        value = outside[i];
        if (value != ((i == 0U) ? UINT64_MAX : 0U)) { // There is a value beyond the bound.
            TEST_ASSERT_TRUE_MESSAGE(assertion_fails(begin), "a value out of bounds was accepted");
        }
    }
}

static status_t refuse_read(void* const context, const uint32_t address, uint8_t* const octets,
                            const size_t size)
{
    (void)context;
    (void)address;
    (void)octets;
    (void)size;
    return STATUS_IO;
}

static status_t find(void* const context, const uint32_t id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    (void)context;
    (void)id;
    (void)out_handle;
    (void)out_size;
    return STATUS_NOT_FOUND;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    (void)context;
    (void)handle;
    (void)writer;
}

// ---- Processes and requesters ----

static void begin_process(void)
{
    const pus_port_t port = bench_port();
    pus_app_process_t process;
    pus_app_process_init(&process, (uint16_t)value, 0U, &port);
}

static void begin_requester(void)
{
    const pus_port_t port = bench_port();
    pus_requester_init(&requester, (uint16_t)value, &port);
}

static status_t begin_long(void* const context, const uint8_t service, const uint8_t subtype,
                           const uint16_t destination, const uint64_t now_ns,
                           octet_writer_t* const out_writer)
{
    (void)context;
    (void)service;
    (void)subtype;
    (void)destination;
    (void)now_ns;
    (void)out_writer;
    return STATUS_FULL;
}

static status_t post_long(void* const context, octet_writer_t* const writer)
{
    (void)context;
    (void)writer;
    return STATUS_FULL;
}

static void begin_longer(void)
{
    const pus_long_port_t port = {.data_max = (uint32_t)value, .begin = begin_long, .post = post_long};
    pus_app_process_lengthen(&bench.process, &port);
}

static void the_bounds_of_processes_and_requesters_are_asserted(void)
{
    expect_bounds(begin_process, 1U, PUS_APID_MAX);
    expect_bounds(begin_requester, 1U, PUS_APID_MAX);
    expect_bounds(begin_longer, PUS_TM_DATA_MAX, UINT64_MAX);
}

// ---- Housekeeping, statistics, monitoring ----

static void begin_housekeeping(void)
{
    static pus_hk_t hk;
    pus_hk_init(&hk, &(pus_hk_config_t){.process     = &bench.process,
                                        .parameters  = {.find = find, .read = read},
                                        .structures  = (void*)room,
                                        .samples     = (void*)room,
                                        .sample_size = (uint16_t)value});
}

static void begin_housekeeping_without_functional(void)
{
    static pus_hk_t hk;
    pus_hk_init(&hk, &(pus_hk_config_t){.process          = &bench.process,
                                        .parameters       = {.find = find, .read = read},
                                        .structures       = (void*)room,
                                        .samples          = (void*)room,
                                        .functional_count = (uint16_t)value});
}

static void begin_statistics(void)
{
    static pus_statistics_t statistics;
    pus_statistics_init(&statistics, &(pus_statistics_config_t){.process    = &bench.process,
                                                                .parameters = {.find = find, .read = read},
                                                                .statistics = (void*)room,
                                                                .due        = (void*)room,
                                                                .positions  = (void*)room,
                                                                .cycle_ns   = value});
}

static bool is_known(void* const context, const uint16_t event)
{
    (void)context;
    return event == 0U;
}

static void raise_none(void* const context, const uint16_t event, const uint8_t* const aux, const size_t size,
                       const uint64_t now_ns)
{
    (void)context;
    (void)event;
    (void)aux;
    (void)size;
    (void)now_ns;
}

static void begin_monitoring(const uint16_t transitions, const uint8_t members)
{
    static pus_monitoring_t monitoring;
    pus_monitoring_init(&monitoring,
                        &(pus_monitoring_config_t){.process    = &bench.process,
                                                   .parameters = {.find = find, .read = read},
                                                   .events     = {.is_known = is_known, .raise = raise_none},
                                                   .pmons      = (void*)room,
                                                   .pmon_order = (void*)room,
                                                   .pmon_positions      = (void*)room,
                                                   .due                 = (void*)room,
                                                   .fmons               = (void*)room,
                                                   .touched             = (void*)room,
                                                   .members             = (void*)room,
                                                   .transitions         = (void*)room,
                                                   .transition_capacity = transitions,
                                                   .fmon_members        = members});
}

static void begin_monitoring_with_transitions(void)
{
    begin_monitoring((uint16_t)value, 1U);
}

static void begin_monitoring_with_members(void)
{
    begin_monitoring(1U, (uint8_t)value);
}

static void the_bounds_of_services_that_sample_are_asserted(void)
{
    expect_bounds(begin_housekeeping, 0U, PUS_TM_DATA_MAX - 2U);
    expect_bounds(begin_housekeeping_without_functional, 0U, 0U);
    expect_bounds(begin_statistics, 1U, UINT64_MAX);
    expect_bounds(begin_monitoring_with_transitions, 1U, UINT64_MAX);
    expect_bounds(begin_monitoring_with_members, 1U, UINT64_MAX);
}

// ---- Events, memories, functions ----

static void begin_events_without_tables(void)
{
    static pus_events_t events;
    pus_events_init(&events, &bench.process, NULL, NULL, (uint16_t)value);
}

static void begin_event_of_severity(void)
{
    static pus_events_t events;
    static pus_event_state_t states[2];
    const pus_event_definition_t definitions[] = {{.id = 1U, .severity = PUS_SEVERITY_LOW},
                                                  {.id = 2U, .severity = (uint8_t)value}};
    pus_events_init(&events, &bench.process, definitions, states, 2U);
}

static pus_memory_t memory;

static void begin_memory(void)
{
    static pus_memory_service_t service;
    static pus_memory_state_t states[1];
    memory.read = refuse_read;
    pus_memory_init(&service, &(pus_memory_config_t){.process      = &bench.process,
                                                     .memories     = &memory,
                                                     .states       = states,
                                                     .memory_count = 1U,
                                                     .operations   = (void*)room});
}

static void a_memory_lies_in_its_address_space_and_is_aligned(void)
{
    static const struct {
        uint8_t access;
        uint32_t base;
        uint32_t size;
        bool is_good;
    } memories[] = {{1U, 0U, 1U, true},
                    {1U, 0U, 0U, false},
                    {1U, UINT32_MAX, 1U, true},
                    {1U, UINT32_MAX, 2U, false},
                    {1U, UINT32_MAX - 1U, 2U, true},
                    {1U, 1U, UINT32_MAX, true},
                    {1U, 2U, UINT32_MAX, false},
                    {0U, 0U, 8U, false},
                    {8U, 16U, 24U, true},
                    {9U, 18U, 9U, false},
                    {4U, 6U, 8U, false},
                    {4U, 5U, 8U, false},
                    {4U, 8U, 6U, false},
                    {4U, 8U, 5U, false}};
    for (size_t i = 0U; i < (sizeof memories / sizeof memories[0]); i++) {
        memory =
            (pus_memory_t){.access = memories[i].access, .base = memories[i].base, .size = memories[i].size};
        TEST_ASSERT_EQUAL(!memories[i].is_good, assertion_fails(begin_memory));
    }
}

static pus_reply_t perform(void* const context, const uint16_t index, const void* const arguments,
                           const pus_token_t* const token, const uint64_t now_ns)
{
    (void)context;
    (void)index;
    (void)arguments;
    (void)token;
    (void)now_ns;
    return pus_done();
}

static const pus_function_port_t function_port = {.perform = perform};

static void begin_functions_without_area(void)
{
    static pus_functions_t functions;
    pus_functions_init(&functions, NULL, 0U, &function_port, NULL, (size_t)value);
}

static void begin_functions_with_argument_at(void)
{
    static pus_functions_t functions;
    const pus_argument_t argument = {.id = 1U, .type = VALUE_UINT8, .count = 3U, .offset = (uint16_t)value};
    const pus_function_t function = {.name = "F", .argument_count = 1U, .arguments = &argument};
    pus_functions_init(&functions, &function, 1U, &function_port, room, 16U);
}

static void the_bounds_of_events_and_functions_are_asserted(void)
{
    expect_bounds(begin_events_without_tables, 0U, 0U);
    expect_bounds(begin_event_of_severity, PUS_SEVERITY_INFORMATIVE, PUS_SEVERITY_HIGH);
    expect_bounds(begin_functions_without_area, 0U, 0U);
    expect_bounds(begin_functions_with_argument_at, 0U, 13U); // The last octet of the area.
}

// ---- Requests that are kept ----

static void begin_schedule(const uint16_t activities, const uint32_t buckets, const uint16_t subs,
                           const uint16_t groups)
{
    static pus_time_schedule_t schedule;
    pus_time_schedule_init(&schedule, 0U,
                           &(pus_schedule_config_t){.process            = &bench.process,
                                                    .release            = bench_port(),
                                                    .activities         = (void*)room,
                                                    .nodes              = (void*)&room[512],
                                                    .activity_count     = activities,
                                                    .buckets            = (void*)&room[768],
                                                    .bucket_count       = buckets,
                                                    .chains             = &chains,
                                                    .sub_schedule_count = subs,
                                                    .group_count        = groups});
}

static void begin_schedule_with_buckets(void)
{
    begin_schedule(1U, (uint32_t)value, 1U, 1U);
}

static void begin_schedule_with_subs(void)
{
    begin_schedule(1U, 1U, (uint16_t)value, 1U);
}

static void begin_schedule_with_groups(void)
{
    begin_schedule(1U, 1U, 1U, (uint16_t)value);
}

static void begin_schedule_with_activities(void)
{
    begin_schedule((uint16_t)value, 1U, 1U, 1U);
}

static void begin_event_action(const uint16_t definitions, const uint32_t buckets)
{
    static pus_event_action_t actions;
    pus_event_action_init(&actions, &(pus_event_action_config_t){.process          = &bench.process,
                                                                 .release          = bench_port(),
                                                                 .definitions      = (void*)room,
                                                                 .definition_count = definitions,
                                                                 .queue            = (void*)&room[512],
                                                                 .buckets          = (void*)&room[768],
                                                                 .bucket_count     = buckets,
                                                                 .chains           = &chains});
}

static void begin_event_action_with_buckets(void)
{
    begin_event_action(1U, (uint32_t)value);
}

static void begin_event_action_with_definitions(void)
{
    begin_event_action((uint16_t)value, 1U);
}

/// Hash tables must have a number of buckets that is a power of two.
static void expect_powers_of_two(void (*const begin)(void))
{
    for (uint32_t count = 0U; count <= 64U; count++) {
        const bool is_power = (count == 1U) || (count == 2U) || (count == 4U) || (count == 8U) ||
                              (count == 16U) || (count == 32U) || (count == 64U);
        value = count;
        TEST_ASSERT_EQUAL(!is_power, assertion_fails(begin));
    }
}

static void begin_sequences(void)
{
    static pus_sequences_t sequences;
    static pus_sequence_t table[PUS_SEQUENCE_COUNT_MAX];
    pus_sequences_init(&sequences, &(pus_sequences_config_t){.process        = &bench.process,
                                                             .release        = bench_port(),
                                                             .sequences      = table,
                                                             .nodes          = (void*)room,
                                                             .sequence_count = (uint16_t)value,
                                                             .chains         = &chains});
}

static void begin_procedures(const uint16_t calls, const uint64_t cycle_ns)
{
    static pus_procedures_t procedures;
    pus_procedures_init(&procedures, &(pus_procedures_config_t){.process    = &bench.process,
                                                                .requester  = &requester,
                                                                .procedures = (void*)room,
                                                                .runs       = (void*)room,
                                                                .calls      = calls,
                                                                .cycle_ns   = cycle_ns});
}

static void begin_procedures_with_calls(void)
{
    begin_procedures((uint16_t)value, 1U);
}

static void begin_procedures_with_cycle(void)
{
    begin_procedures(1U, value);
}

static void the_bounds_of_services_that_keep_requests_are_asserted(void)
{
    expect_powers_of_two(begin_schedule_with_buckets);
    expect_powers_of_two(begin_event_action_with_buckets);
    expect_bounds(begin_schedule_with_subs, 0U, 256U);
    expect_bounds(begin_schedule_with_groups, 0U, 256U);
    expect_bounds(begin_sequences, 1U, PUS_SEQUENCE_COUNT_MAX);
    expect_bounds(begin_procedures_with_calls, 1U, UINT64_MAX);
    expect_bounds(begin_procedures_with_cycle, 1U, UINT64_MAX);
    static void (*const begins[])(void) = {begin_schedule_with_activities,
                                           begin_event_action_with_definitions};
    for (unsigned i = 0U; i < 2U; i++) {
        value = 0U;
        TEST_ASSERT_TRUE(assertion_fails(begins[i]));
        value = 1U;
        TEST_ASSERT_FALSE(assertion_fails(begins[i]));
        value = 65535U; // This number means "no definition".
        TEST_ASSERT_TRUE(assertion_fails(begins[i]));
    }
}

// ---- Packets that are kept ----

static size_t no_limit(void* const context, const uint16_t apid)
{
    (void)context;
    (void)apid;
    return PUS_LARGE_MAX;
}

static status_t take_none(void* const context, const uint8_t* const packet, const size_t size,
                          const uint64_t now_ns)
{
    (void)context;
    (void)packet;
    (void)size;
    (void)now_ns;
    return STATUS_FULL;
}

static void begin_large(const size_t reports, const size_t report_size, const size_t uplink_size)
{
    static pus_large_t large;
    pus_large_init(&large, &(pus_large_config_t){.process       = &bench.process,
                                                 .reports       = (void*)room,
                                                 .report_octets = (void*)room,
                                                 .report_count  = reports,
                                                 .report_size   = report_size,
                                                 .uplinks       = (void*)room,
                                                 .uplink_octets = (void*)room,
                                                 .uplink_size   = uplink_size,
                                                 .limit         = no_limit,
                                                 .take          = take_none});
}

static void begin_large_with_report(void)
{
    begin_large(1U, (size_t)value, 0U);
}

static void begin_large_with_uplink(void)
{
    begin_large(1U, PUS_PACKET_MAX, (size_t)value);
}

static void begin_large_with_count(void)
{
    begin_large((size_t)value, PUS_PACKET_MAX, 0U);
}

static void begin_store(void)
{
    static pus_packet_store_t store;
    pus_packet_store_init(&store, &(pus_packet_store_config_t){.blocks         = (void*)room,
                                                               .block_capacity = (uint16_t)value,
                                                               .buffer         = (void*)room});
}

static status_t send_again(void* const context, const uint8_t channel, const uint8_t* const packet,
                           const size_t size)
{
    (void)context;
    (void)channel;
    (void)packet;
    (void)size;
    return STATUS_FULL;
}

static void begin_storage(void)
{
    static pus_storage_t storage;
    static const medium_t media[PUS_STORES_MAX + 1U];
    static const uint16_t apids[] = {1U};
    pus_storage_init(&storage, &(pus_storage_config_t){.process              = &bench.process,
                                                       .media                = media,
                                                       .store_count          = (uint8_t)value,
                                                       .blocks_of_store      = PUS_STORE_BLOCKS_MIN,
                                                       .blocks               = (void*)room,
                                                       .entries_of_selection = 1U,
                                                       .entries              = (void*)room,
                                                       .candidate            = (void*)room,
                                                       .apids                = apids,
                                                       .apid_count           = 1U,
                                                       .port                 = {.send = send_again}});
    // Also with the largest number of stores, their table ends before the member `buffer`, which stays 0.
    TEST_ASSERT_EACH_EQUAL_UINT8(0U, storage.buffer, sizeof storage.buffer);
}

static void begin_selection(void)
{
    pus_selection_t selection;
    pus_selection_init(&selection, (void*)room, (uint16_t)value);
}

static void the_bounds_of_services_that_keep_packets_are_asserted(void)
{
    expect_bounds(begin_large_with_report, PUS_PACKET_MAX, PUS_LARGE_MAX);
    expect_bounds(begin_large_with_uplink, 0U, PUS_LARGE_MAX);
    value = 0U;
    TEST_ASSERT_TRUE(assertion_fails(begin_large_with_count));
    expect_bounds(begin_store, PUS_STORE_BLOCKS_MIN, UINT64_MAX);
    expect_bounds(begin_storage, 1U, PUS_STORES_MAX);
    expect_bounds(begin_selection, 1U, PUS_SELECTION_ENTRIES_MAX);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_bounds_of_processes_and_requesters_are_asserted);
    RUN_TEST(the_bounds_of_services_that_sample_are_asserted);
    RUN_TEST(a_memory_lies_in_its_address_space_and_is_aligned);
    RUN_TEST(the_bounds_of_events_and_functions_are_asserted);
    RUN_TEST(the_bounds_of_services_that_keep_requests_are_asserted);
    RUN_TEST(the_bounds_of_services_that_keep_packets_are_asserted);
    return UNITY_END();
}
