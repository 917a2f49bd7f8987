// SPDX-License-Identifier: Apache-2.0
// TC[2,5] in a build whose reports have room for few registers, as on a board: this file compiles the service
// with such a limit.
#define PUS_DEVICE_REGISTERS_MAX 4U
#include "pus/st02/st02_device_access.c"

#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define DUMP 5U

static pus_device_access_t access;
static pus_device_operation_t operation;

static status_t permit(void* const context, const pus_device_action_t* const action)
{
    (void)context;
    (void)action;
    return STATUS_OK;
}

static status_t begin_read(void* const context, const uint8_t slot, const pus_device_action_t* const action,
                           pus_device_result_t* const out_result)
{
    (void)slot;
    (void)out_result;
    *(uint32_t*)context = action->address;
    return STATUS_OK;
}

static status_t poll_read(void* const context, const uint8_t slot, pus_device_result_t* const out_result)
{
    (void)slot;
    octets_put_u32(out_result->data, *(uint32_t*)context + 0x100U);
    return STATUS_OK;
}

static void give_up(void* const context, const uint8_t slot)
{
    (void)context;
    (void)slot;
}

void setUp(void)
{
    static uint32_t address;
    const pus_device_config_t config = {.process         = &bench.process,
                                        .port            = {&address, permit, begin_read, poll_read, give_up},
                                        .operations      = &operation,
                                        .operation_count = 1U,
                                        .timeout_ns      = 1000000000ULL};
    bench_start();
    memset(&access, 0xA5, sizeof access);
    pus_device_access_init(&access, &config);
    bench_serve(pus_device_access_service(&access));
}

void tearDown(void)
{
}

static void request_registers(const uint8_t count)
{
    uint8_t data[1U + (5U * 4U)];
    octet_writer_t writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, count);
    for (uint8_t i = 0U; i < count; i++) {
        octet_write_u32(&writer, i);
    }
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(DUMP, data, writer.position));
    for (unsigned i = 0U; i < 20U; i++) {
        bench_step(TEST_NOW_NS, 0U);
    }
}

static void more_registers_than_fit_a_report_are_refused(void)
{
    request_registers(5U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, 4U);
    request_registers(4U);
    EXPECT_MESSAGES(1, 1, 1, 3, 2, 6, 1, 7);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(4U, octet_read_u16(&reader));
    for (uint32_t i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL_HEX32(i, octet_read_u32(&reader));
        TEST_ASSERT_EQUAL_HEX32(i + 0x100U, octet_read_u32(&reader));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(more_registers_than_fit_a_report_are_refused);
    return UNITY_END();
}
