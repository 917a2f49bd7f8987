// SPDX-License-Identifier: Apache-2.0
// Lists of entries of equal size fill each packet: as many entries as fit, the rest in the next packet.
#include "pus/st04/st04_statistics.h"
#include "pus/st12/st12_monitoring.h"
#include "pus/st18/st18_procedures.h"
#include "test/unit/pus/fixtures/parameters.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#define ENTRIES 1500U

void setUp(void)
{
    bench_start();
}

void tearDown(void)
{
}

/// The answer to a request without data is ENTRIES entries of `size` octets after `prefix` octets.
static void expect_filled_packets(const uint8_t subtype, const size_t prefix, const size_t size)
{
    const size_t each    = (PUS_TM_DATA_MAX - prefix - 2U) / size;
    const size_t packets = (ENTRIES + each - 1U) / each;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, NULL, 0U));
    TEST_ASSERT_EQUAL_UINT64(3U + packets, bench.count);
    TEST_ASSERT_EQUAL_UINT8(7U, bench_report(2U + packets).subtype);
    for (size_t i = 0U; i < packets; i++) {
        const pus_tm_t tm  = bench_report(2U + i);
        const size_t count = (i < (packets - 1U)) ? each : (ENTRIES - (each * i));
        TEST_ASSERT_EQUAL_UINT16(count, octets_u16_at(&tm.data[prefix]));
        TEST_ASSERT_EQUAL_UINT64(prefix + 2U + (count * size), tm.size);
    }
}

static void definitions_of_statistics_fill_each_packet(void)
{
    static pus_statistics_t statistics;
    static pus_statistic_t table[ENTRIES];
    static pus_due_t due[ENTRIES];
    static uint16_t positions[ENTRIES];
    pus_statistics_init(&statistics, &(pus_statistics_config_t){.process    = &bench.process,
                                                                .parameters = dictionary_port(),
                                                                .statistics = table,
                                                                .due        = due,
                                                                .positions  = positions,
                                                                .capacity   = ENTRIES,
                                                                .cycle_ns   = 1U});
    for (uint16_t i = 0U; i < ENTRIES; i++) {
        table[i].in_use = true;
    }
    bench_serve(pus_statistics_service(&statistics));
    expect_filled_packets(8U, PUS_RELATIVE_TIME_SIZE, 4U + PUS_RELATIVE_TIME_SIZE);
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

static void states_of_monitoring_definitions_fill_each_packet(void)
{
    static pus_monitoring_t monitoring;
    static pus_pmon_t pmons[ENTRIES];
    static uint16_t order[ENTRIES];
    static uint16_t positions[ENTRIES];
    static pus_due_t due[ENTRIES];
    static pus_fmon_t fmons[ENTRIES];
    static uint16_t touched[ENTRIES];
    static pus_fmon_member_t members[ENTRIES];
    static pus_check_transition_t transitions[1];
    pus_monitoring_init(&monitoring,
                        &(pus_monitoring_config_t){.process    = &bench.process,
                                                   .parameters = dictionary_port(),
                                                   .events     = {.is_known = is_known, .raise = raise_none},
                                                   .pmons      = pmons,
                                                   .pmon_order = order,
                                                   .pmon_positions      = positions,
                                                   .due                 = due,
                                                   .fmons               = fmons,
                                                   .touched             = touched,
                                                   .members             = members,
                                                   .transitions         = transitions,
                                                   .pmon_capacity       = ENTRIES,
                                                   .fmon_capacity       = ENTRIES,
                                                   .transition_capacity = 1U,
                                                   .fmon_members        = 1U});
    monitoring.pmon_count = ENTRIES;
    for (uint16_t i = 0U; i < ENTRIES; i++) {
        pmons[i].id     = i;
        fmons[i].in_use = true;
        fmons[i].id     = i;
    }
    bench_serve(pus_monitoring_service(&monitoring));
    expect_filled_packets(13U, 0U, 3U);
    expect_filled_packets(27U, 0U, 5U);
}

static void states_of_procedures_fill_each_packet(void)
{
    static pus_procedures_t procedures;
    static pus_requester_t requester;
    static pus_procedure_t table[ENTRIES];
    static pus_procedure_run_t runs[1];
    pus_procedures_init(&procedures, &(pus_procedures_config_t){.process    = &bench.process,
                                                                .requester  = &requester,
                                                                .procedures = table,
                                                                .runs       = runs,
                                                                .capacity   = ENTRIES,
                                                                .calls      = 1U,
                                                                .cycle_ns   = 1U});
    for (uint16_t i = 0U; i < ENTRIES; i++) {
        table[i].in_use = true;
    }
    bench_serve(pus_procedures_service(&procedures));
    expect_filled_packets(8U, 0U, PUS_NAME_SIZE + 3U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(definitions_of_statistics_fill_each_packet);
    RUN_TEST(states_of_monitoring_definitions_fill_each_packet);
    RUN_TEST(states_of_procedures_fill_each_packet);
    return UNITY_END();
}
