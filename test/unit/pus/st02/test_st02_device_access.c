// SPDX-License-Identifier: Apache-2.0
// Access to devices: switching, registers, pulses, commands and acquisitions, with devices that fail. The
// numbers of requests and reports are subtypes; pus/catalogue/st02_device_access.txt has their names and
// fields.
#include "pus/st02/st02_device_access.h"

#include "pus/st01/st01_verification.h"

#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

#define OPERATIONS 2U
#define TIMEOUT_NS 1000000000ULL

#define UNKNOWN 0xFFU  ///< Device or CPDU that does not exist.
#define RESTING 0xFEU  ///< Device that may not be accessed now.
#define PICKY 0xFDU    ///< Device that accepts nothing.
#define BROKEN 0x50U   ///< Device on which each action fails after it has begun.
#define REFUSING 0x51U ///< Device that refuses to begin.
#define SILENT 0x52U   ///< Device that never answers.
#define CROWDED 0x53U  ///< Device that can never begin.

static pus_device_access_t access;
static pus_device_operation_t operations[OPERATIONS];
static struct {
    unsigned busy;      ///< Polls until an action is done.
    unsigned full;      ///< Number of times that begin returns STATUS_FULL.
    unsigned begun;     ///< Actions begun.
    unsigned abandoned; ///< Number of actions abandoned.
    unsigned left[OPERATIONS];
    bool is_open[OPERATIONS];
    pus_device_action_t actions[OPERATIONS]; ///< Last action of each slot.
    uint8_t data[OPERATIONS][64];            ///< Data of the last action of each slot.
    uint8_t protocol[OPERATIONS][PUS_DEVICE_PROTOCOL_SIZE];
} devices;
static uint64_t now_ns;
static uint8_t data[PUS_TC_DATA_MAX];
static octet_writer_t writer;

static uint32_t device_of(const pus_device_action_t* const action)
{
    const bool is_register =
        (action->kind == PUS_DEVICE_LOAD_REGISTER) || (action->kind == PUS_DEVICE_DUMP_REGISTER);
    return is_register ? action->address : action->device;
}

static status_t check(void* const context, const pus_device_action_t* const action)
{
    TEST_ASSERT_EQUAL_PTR(&devices, context);
    switch (device_of(action)) {
    case UNKNOWN:
        return STATUS_NOT_FOUND;
    case RESTING:
        return STATUS_FORBIDDEN;
    case PICKY:
        return STATUS_OUT_OF_RANGE;
    default:
        return STATUS_OK;
    }
}

static status_t begin_action(void* const context, const uint8_t slot, const pus_device_action_t* const action,
                             pus_device_result_t* const out_result)
{
    TEST_ASSERT_TRUE((context == &devices) && (slot < OPERATIONS) && !devices.is_open[slot]);
    if (device_of(action) == REFUSING) {
        out_result->return_code = 3U;
        out_result->detail      = 0x06020000U;
        return STATUS_IO;
    }
    if ((devices.full > 0U) || (device_of(action) == CROWDED)) {
        devices.full -= (devices.full > 0U) ? 1U : 0U;
        return STATUS_FULL;
    }
    devices.begun++;
    devices.is_open[slot] = true;
    devices.left[slot]    = devices.busy;
    devices.actions[slot] = *action;
    TEST_ASSERT_TRUE(action->size <= sizeof devices.data[slot]);
    if (action->data != NULL) {
        memcpy(devices.data[slot], action->data, action->size);
    }
    if (action->protocol != NULL) {
        memcpy(devices.protocol[slot], action->protocol, PUS_DEVICE_PROTOCOL_SIZE);
    }
    return STATUS_OK;
}

static status_t poll(void* const context, const uint8_t slot, pus_device_result_t* const out_result)
{
    TEST_ASSERT_TRUE((context == &devices) && devices.is_open[slot]);
    const uint32_t device = device_of(&devices.actions[slot]);
    if ((device == SILENT) || (devices.left[slot] > 0U)) {
        devices.left[slot] -= (devices.left[slot] > 0U) ? 1U : 0U;
        return STATUS_BUSY;
    }
    devices.is_open[slot] = false;
    if (device == BROKEN) {
        out_result->return_code = 2U;
        out_result->detail      = 0x08000000U;
        return STATUS_IO;
    }
    out_result->size = 4U;
    octets_put_u32(out_result->data, device + 0x100U);
    return STATUS_OK;
}

static void abandon(void* const context, const uint8_t slot)
{
    TEST_ASSERT_TRUE((context == &devices) && devices.is_open[slot]);
    devices.is_open[slot] = false;
    devices.abandoned++;
}

void setUp(void)
{
    const pus_device_config_t config = {.process         = &bench.process,
                                        .port            = {&devices, check, begin_action, poll, abandon},
                                        .operations      = operations,
                                        .operation_count = OPERATIONS,
                                        .timeout_ns      = TIMEOUT_NS};
    memset(&devices, 0, sizeof devices);
    now_ns = TEST_NOW_NS;
    bench_start();
    memset(operations, 0xA5, sizeof operations);
    memset(&access, 0xA5, sizeof access);
    pus_device_access_init(&access, &config);
    bench_serve(pus_device_access_service(&access));
}

void tearDown(void)
{
}

static void begin(const unsigned count)
{
    writer = octet_writer(data, sizeof data);
    octet_write_u8(&writer, (uint8_t)count);
}

static void u8(const unsigned value)
{
    octet_write_u8(&writer, (uint8_t)value);
}

static void u16(const unsigned value)
{
    octet_write_u16(&writer, (uint16_t)value);
}

static void u32(const uint32_t value)
{
    octet_write_u32(&writer, value);
}

static void request(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(writer.failed);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(subtype, data, writer.position));
}

static void step(void)
{
    bench_step(now_ns, 0U);
}

static void devices_are_switched_one_after_the_other(void)
{
    devices.busy = 1U;
    begin(3U);
    u16(1U);
    u16(2U);
    u16(3U);
    request(1U);
    EXPECT_MESSAGES(1, 1, 1, 3);
    step();
    TEST_ASSERT_EQUAL_UINT(1U, devices.begun);
    step();
    TEST_ASSERT_EQUAL_UINT(2U, devices.begun);
    TEST_ASSERT_EQUAL_UINT16(2U, devices.actions[0].device);
    step();
    step();
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT32(3U, access.counters.performed);
    expect_strict_format(1U, data, writer.position);
    begin(0U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(1U, data, 1U));
}

static void faulty_instructions_are_refused_alone(void)
{
    begin(5U);
    u16(UNKNOWN);
    u16(1U);
    u16(RESTING);
    u16(PICKY);
    u16(2U);
    request(1U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 4, 1, 4, 1, 3);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, UNKNOWN);
    expect_failure(2U, 4U, PUS_FAILURE_STATE, 3U, RESTING);
    expect_failure(3U, 4U, PUS_FAILURE_OUT_OF_RANGE, 4U, 7U); // The detail is the octet offset of the value.
    step();
    expect_failure(5U, 8U, PUS_FAILURE_SOME_FAILED, 0U, 3U);
    TEST_ASSERT_EQUAL_UINT(2U, devices.begun);
    begin(1U);
    u16(UNKNOWN);
    request(1U);
    step();
    EXPECT_MESSAGES(1, 1, 1, 4);
    TEST_ASSERT_EQUAL_UINT32(4U, access.counters.refused);
}

static void registers_are_loaded(void)
{
    begin(2U);
    u32(UNKNOWN);
    u32(1U);
    u32(0xABCD0000U);
    u32(0x11223344U);
    request(2U);
    step();
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, UNKNOWN);
    TEST_ASSERT_EQUAL_HEX32(0xABCD0000U, devices.actions[0].address);
    TEST_ASSERT_EQUAL_HEX32(0x11223344U, octets_u32_at(devices.data[0]));
    expect_strict_format(2U, data, writer.position);
}

/// Report `index` states that this step failed.
static void expect_progress_failure(const size_t index, const uint16_t number)
{
    const pus_tm_t tm = bench_report(index);
    pus_verification_t last_verification;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_verification_read(&tm, &last_verification));
    TEST_ASSERT_EQUAL_UINT8(6U, last_verification.subtype);
    TEST_ASSERT_EQUAL_UINT16(number, last_verification.step);
    TEST_ASSERT_EQUAL_UINT16(number, last_verification.failure.instruction);
}

static void registers_that_fail_are_left_out_of_a_dump(void)
{
    begin(4U);
    u32(1U);
    u32(BROKEN);
    u32(UNKNOWN);
    u32(2U);
    request(5U);
    bench.refusals = 2U; // The report of the failed step and the report of the registers are refused.
    step();
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3);
    step();
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 6, 2, 6, 1, 8);
    octet_reader_t reader = bench_data(4U);
    TEST_ASSERT_EQUAL_UINT16(2U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_HEX32(1U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_HEX32(0x101U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_HEX32(2U, octet_read_u32(&reader));
    TEST_ASSERT_EQUAL_HEX32(0x102U, octet_read_u32(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    expect_progress_failure(3U, 2U);
    expect_failure(5U, 8U, PUS_FAILURE_DEVICE, 2U, 0x08000000U);
    expect_strict_format(5U, data, writer.position);
}

static void as_many_registers_as_a_request_may_name_are_dumped(void)
{
    begin(255U);
    for (unsigned i = 0U; i < 255U; i++) {
        u32(0x1000U + i);
    }
    request(5U);
    for (unsigned i = 0U; i < 20U; i++) {
        step();
    }
    EXPECT_MESSAGES(1, 1, 1, 3, 2, 6, 1, 7);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(255U, octet_read_u16(&reader));
    TEST_ASSERT_EQUAL_UINT64(255U * 8U, octet_reader_left(&reader));
}

static void pulses_are_given_by_each_unit(void)
{
    begin(2U);
    u8(7U); // CPDU.
    u8(2U);
    u16(0x1237U); // Line 0x123, exponent 7.
    u16(0x4568U); // The reserved bit.
    u8(9U);
    u8(1U);
    u16(0xFFF0U);
    request(4U);
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 2U, 5U);
    devices.busy = 1U;
    step();
    TEST_ASSERT_EQUAL_UINT16(7U, devices.actions[0].device);
    TEST_ASSERT_EQUAL_HEX16(0x123U, devices.actions[0].command);
    TEST_ASSERT_EQUAL_UINT8(7U, devices.actions[0].exponent);
    step();
    TEST_ASSERT_EQUAL_UINT16(9U, devices.actions[0].device);
    TEST_ASSERT_EQUAL_HEX16(0xFFFU, devices.actions[0].command);
    step();
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 1, 8);
    expect_strict_format(4U, data, writer.position);
}

static void as_many_pulses_as_a_request_may_have_are_given_over_many_steps(void)
{
    begin(8U);
    for (unsigned i = 0U; i < 8U; i++) {
        u8(i);
        u8(250U);
        for (unsigned k = 0U; k < 250U; k++) {
            u16(k << 4U);
        }
    }
    request(4U);
    step();
    TEST_ASSERT_TRUE(devices.begun < 100U); // One step does not give all pulses.
    for (unsigned i = 0U; i < 100U; i++) {
        step();
    }
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT(2000U, devices.begun);
}

static void add_command(const unsigned device, const char* const text)
{
    u16(device);
    octet_write_octets(&writer, (const uint8_t*)"PROT", PUS_DEVICE_PROTOCOL_SIZE);
    u16((unsigned)strlen(text));
    octet_write_octets(&writer, (const uint8_t*)text, strlen(text));
}

static void physical_devices_are_commanded(void)
{
    begin(2U);
    add_command(1U, "first");
    add_command(2U, "");
    devices.busy = 1U;
    request(7U);
    step();
    TEST_ASSERT_EQUAL_STRING_LEN("PROT", devices.protocol[0], 4U);
    TEST_ASSERT_EQUAL_UINT16(5U, devices.actions[0].size);
    TEST_ASSERT_EQUAL_STRING_LEN("first", devices.data[0], 5U);
    step();
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(7U, data, writer.position);
}

static void one_faulty_command_refuses_the_whole_request(void)
{
    begin(2U);
    add_command(1U, "first");
    add_command(UNKNOWN, "second");
    request(7U);
    step();
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 2U, UNKNOWN);
    TEST_ASSERT_EQUAL_UINT(0U, devices.begun);
    begin(1U);
    u16(PICKY);
    u16(3U);
    u16(0U);
    request(10U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 1U);
}

static void the_first_command_that_fails_ends_the_request(void)
{
    begin(3U);
    add_command(1U, "");
    add_command(REFUSING, "");
    add_command(2U, "");
    request(7U);
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 6, 1, 8);
    expect_failure(3U, 8U, PUS_FAILURE_DEVICE, 2U, 0x06020000U);
    TEST_ASSERT_EQUAL_UINT(1U, devices.begun);
}

static void switching_continues_after_a_failure(void)
{
    begin(3U);
    u16(BROKEN);
    u16(REFUSING);
    u16(2U);
    request(1U);
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 6, 1, 6, 1, 8);
    expect_progress_failure(2U, 1U);
    expect_progress_failure(3U, 2U);
    expect_failure(4U, 8U, PUS_FAILURE_DEVICE, 1U, 0x08000000U); // The first failure is reported.
    TEST_ASSERT_EQUAL_UINT16(2U, devices.actions[0].device);
    TEST_ASSERT_EQUAL_UINT32(2U, access.counters.failed);
}

static void logical_devices_are_commanded(void)
{
    begin(1U);
    u16(5U);
    u16(0x77U);
    u16(3U);
    octet_write_octets(&writer, (const uint8_t*)"abc", 3U);
    request(10U);
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(5U, devices.actions[0].device);
    TEST_ASSERT_EQUAL_HEX16(0x77U, devices.actions[0].command);
    TEST_ASSERT_EQUAL_STRING_LEN("abc", devices.data[0], 3U);
    expect_strict_format(10U, data, writer.position);
}

static void add_acquisition(const unsigned transaction, const unsigned device)
{
    u16(transaction);
    u16(device);
    octet_write_octets(&writer, (const uint8_t*)"PROT", PUS_DEVICE_PROTOCOL_SIZE);
}

static void each_acquisition_has_a_report(void)
{
    // Transaction, return code, size and octets of the data.
    static const uint8_t first[]  = {0, 11, 0, 0, 0, 4, 0, 0, 1, 1};
    static const uint8_t second[] = {0, 12, 0, 2, 0, 0};
    begin(3U);
    add_acquisition(11U, 1U);
    add_acquisition(12U, BROKEN);
    add_acquisition(13U, UNKNOWN);
    request(8U);
    bench.refusals = 1U;
    step();
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3);
    step();
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 2, 9, 1, 6, 2, 9, 1, 8);
    TEST_ASSERT_EQUAL_UINT64(sizeof first, bench_report(3U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(first, bench_report(3U).data, sizeof first);
    TEST_ASSERT_EQUAL_UINT64(sizeof second, bench_report(5U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(second, bench_report(5U).data, sizeof second);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, bench_report(5U).destination);
    TEST_ASSERT_EQUAL_STRING_LEN("PROT", devices.protocol[0], 4U);
    expect_strict_format(8U, data, writer.position);
}

static void logical_devices_answer_with_a_value_alone(void)
{
    // Transaction, return code 0 and the value.
    static const uint8_t expected[] = {0, 9, 0, 0, 0, 0, 1, 4};
    begin(1U);
    u16(9U);
    u16(4U);
    u32(0x02000001U);
    request(11U);
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 2, 12, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, bench_report(2U).size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bench_report(2U).data, sizeof expected);
    TEST_ASSERT_EQUAL_HEX32(0x02000001U, devices.actions[0].address);
    expect_strict_format(11U, data, writer.position);
}

static void an_acquisition_from_a_device_that_does_not_answer_times_out(void)
{
    begin(2U);
    add_acquisition(1U, SILENT);
    add_acquisition(2U, CROWDED);
    request(8U);
    step();
    now_ns += TIMEOUT_NS - 1U;
    step();
    EXPECT_MESSAGES(1, 1, 1, 3);
    now_ns += 1U;
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 6, 2, 9);
    TEST_ASSERT_EQUAL_HEX16(PUS_DEVICE_TIMED_OUT, octets_u16_at(&bench_report(3U).data[2]));
    TEST_ASSERT_EQUAL_UINT(1U, devices.abandoned);
    now_ns += TIMEOUT_NS;
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 6, 2, 9, 1, 6, 2, 9, 1, 8);
    expect_failure(6U, 8U, PUS_FAILURE_NO_ANSWER, 1U, SILENT);
    TEST_ASSERT_EQUAL_UINT(1U, devices.abandoned); // The other action had not begun.
    TEST_ASSERT_EQUAL_UINT32(2U, access.counters.timed_out);
}

/// The request was transferred in parts and is well-formed.
static void a_request_longer_than_a_packet_is_refused(void)
{
    static uint8_t octets[5000];
    octets[0] = 1U;
    octets_put_u16(&octets[1], SILENT);
    octets_put_u16(&octets[7], sizeof octets - 9U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request_large(7U, octets, sizeof octets));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, PUS_TC_DATA_MAX);
}

static void several_requests_are_under_way_at_once(void)
{
    devices.full = 1U;
    begin(1U);
    u16(SILENT);
    request(1U);
    request(1U);
    request(1U);
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_TABLE_FULL, 0U, OPERATIONS);
    step();
    TEST_ASSERT_EQUAL_UINT(1U, devices.begun);
    step();
    TEST_ASSERT_EQUAL_UINT(2U, devices.begun);
    TEST_ASSERT_TRUE(devices.is_open[0] && devices.is_open[1]);
}

static void a_request_continues_when_the_one_before_it_has_ended(void)
{
    begin(1U);
    u16(1U);
    request(1U);
    begin(1U);
    u16(SILENT);
    request(1U);
    step();
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    now_ns += TIMEOUT_NS;
    step();
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7, 1, 6, 1, 8);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(devices_are_switched_one_after_the_other);
    RUN_TEST(faulty_instructions_are_refused_alone);
    RUN_TEST(registers_are_loaded);
    RUN_TEST(registers_that_fail_are_left_out_of_a_dump);
    RUN_TEST(as_many_registers_as_a_request_may_name_are_dumped);
    RUN_TEST(pulses_are_given_by_each_unit);
    RUN_TEST(as_many_pulses_as_a_request_may_have_are_given_over_many_steps);
    RUN_TEST(physical_devices_are_commanded);
    RUN_TEST(one_faulty_command_refuses_the_whole_request);
    RUN_TEST(the_first_command_that_fails_ends_the_request);
    RUN_TEST(switching_continues_after_a_failure);
    RUN_TEST(logical_devices_are_commanded);
    RUN_TEST(each_acquisition_has_a_report);
    RUN_TEST(logical_devices_answer_with_a_value_alone);
    RUN_TEST(an_acquisition_from_a_device_that_does_not_answer_times_out);
    RUN_TEST(a_request_continues_when_the_one_before_it_has_ended);
    RUN_TEST(a_request_longer_than_a_packet_is_refused);
    RUN_TEST(several_requests_are_under_way_at_once);
    return UNITY_END();
}
