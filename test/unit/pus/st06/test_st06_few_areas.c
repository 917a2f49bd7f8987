// SPDX-License-Identifier: Apache-2.0
// Dumps and checks in a build whose reports have room for few areas, as on a board: this file compiles the
// service with such a limit.
#define PUS_MEMORY_AREAS_MAX 3U
#include "pus/st06/st06_areas.c"
#include "pus/st06/st06_memory.c"
#include "pus/st06/st06_operations.c"

#include "test/unit/pus/fixtures/memories.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define DUMP 5U
#define CHECK 9U

static pus_memory_service_t service;
static pus_memory_state_t states[3];
static pus_memory_operation_t operation;

void setUp(void)
{
    const pus_memory_config_t config = {.process         = &bench.process,
                                        .memories        = memory_list(),
                                        .states          = states,
                                        .memory_count    = 3U,
                                        .operations      = &operation,
                                        .operation_count = 1U};
    bench_start();
    memset(&service, 0xA5, sizeof service);
    pus_memory_init(&service, &config);
    bench_serve(pus_memory_service(&service));
}

void tearDown(void)
{
}

static void request_areas(const uint8_t subtype, const uint8_t count)
{
    memory_begin(RAM);
    octet_write_u8(&memory_writer, count);
    for (uint32_t i = 0U; i < count; i++) {
        memory_add_area(RAM_BASE + (16U * i), 16U);
    }
    memory_request(subtype);
    for (unsigned i = 0U; i < 5U; i++) {
        pus_memory_step(&service, TEST_NOW_NS);
    }
}

static void more_areas_than_fit_a_report_are_refused(void)
{
    request_areas(CHECK, 4U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 3U);
    request_areas(DUMP, 4U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    request_areas(CHECK, 3U);
    EXPECT_MESSAGES(1, 1, 1, 3, 6, 10, 1, 7);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT8(RAM, octet_read_u8(&reader));
    TEST_ASSERT_EQUAL_UINT16(3U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT32(3U, service.counters.checked);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(more_areas_than_fit_a_report_are_refused);
    return UNITY_END();
}
