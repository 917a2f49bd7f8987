// SPDX-License-Identifier: Apache-2.0
// Functions: their arguments in a struct, and every refusal. The numbers of requests and reports are
// subtypes; pus/catalogue/st08_functions.txt has their names and fields.
#include "pus/st08/st08_functions.h"

#include "pus/st01/st01_verification.h"
#include "test/support/assertion.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <stddef.h>
#include <string.h>

/// Arguments that the port gets for MOVE_TO.
typedef struct {
    double position[2];
    double duration;
    bool is_smooth;
} move_to_t;

typedef struct {
    uint8_t a;
    int64_t b;
    float c[3];
} every_t;

static const pus_argument_t move_to[] = {
    {.id = 1U, .type = VALUE_DOUBLE, .count = 2U, .offset = offsetof(move_to_t, position)},
    {.id = 2U, .type = VALUE_DOUBLE, .count = 1U, .offset = offsetof(move_to_t, duration)},
    {.id = 7U, .type = VALUE_BOOL, .count = 1U, .offset = offsetof(move_to_t, is_smooth)},
};
static const pus_argument_t every[] = {
    {.id = 1U, .type = VALUE_UINT8, .count = 1U, .offset = offsetof(every_t, a)},
    {.id = 2U, .type = VALUE_INT64, .count = 1U, .offset = offsetof(every_t, b)},
    {.id = 3U, .type = VALUE_FLOAT, .count = 3U, .offset = offsetof(every_t, c)},
};
static const pus_function_t table[] = {
    {.name = "TARE"},
    {.name = "MOVE_TO", .argument_count = 3U, .arguments = move_to},
    {.name = "EIGHTCHR", .argument_count = 3U, .arguments = every},
};

static uint64_t area[8];
static pus_functions_t functions;
static struct {
    pus_reply_t reply;
    unsigned calls;
    uint16_t index;
    pus_token_t token;
    move_to_t move_to;
    every_t every;
} performed;

static pus_reply_t perform(void* const context, const uint16_t index, const void* const arguments,
                           const pus_token_t* const token, const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&performed, context);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, now_ns);
    performed.calls++;
    performed.index = index;
    performed.token = *token;
    if (index == 1U) {
        memcpy(&performed.move_to, arguments, sizeof(move_to_t));
    } else if (index == 2U) {
        memcpy(&performed.every, arguments, sizeof(every_t));
    }
    return performed.reply;
}

static const pus_function_port_t port = {.context = &performed, .perform = perform};

void setUp(void)
{
    memset(&performed, 0, sizeof performed);
    bench_start();
    memset(&functions, 0xA5, sizeof functions);
    pus_functions_init(&functions, table, 3U, &port, area, sizeof area);
    bench_serve(pus_functions_service(&functions));
}

void tearDown(void)
{
}

/// MOVE_TO {POSITION 0.5 -0.25, DURATION 2, smooth}; the argument ids are at the octets 9, 27 and 37, each
/// value two octets later.
static const uint8_t move[] = {'M', 'O',  'V', 'E', '_', 'T',  'O',  0, 3, 0, 1, 0x3F, 0xE0, 0,
                               0,   0,    0,   0,   0,   0xBF, 0xD0, 0, 0, 0, 0, 0,    0,    0,
                               2,   0x40, 0,   0,   0,   0,    0,    0, 0, 0, 7, 1};

static void arguments_become_a_struct(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, move, sizeof move));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(1U, performed.index);
    TEST_ASSERT_TRUE(performed.move_to.position[0] == 0.5);
    TEST_ASSERT_TRUE(performed.move_to.position[1] == -0.25);
    TEST_ASSERT_TRUE(performed.move_to.duration == 2.0);
    TEST_ASSERT_TRUE(performed.move_to.is_smooth);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, performed.token.request_id);
}

static void arguments_may_have_any_order(void)
{
    static const uint8_t data[] = {'E',  'I',  'G',  'H',  'T',  'C',  'H',  'R',  3,    0, 3, 0x3F,
                                   0x80, 0,    0,    0xC0, 0,    0,    0,    0,    0,    0, 0, 0,
                                   2,    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFE, 0, 1, 200};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, sizeof data));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL_UINT8(200U, performed.every.a);
    TEST_ASSERT_TRUE(performed.every.b == -2);
    TEST_ASSERT_TRUE(performed.every.c[0] == 1.0F);
    TEST_ASSERT_TRUE(performed.every.c[1] == -2.0F);
    TEST_ASSERT_TRUE(performed.every.c[2] == 0.0F);
}

static void the_request_for_a_function_without_arguments_has_the_count_0(void)
{
    static const uint8_t data[] = {'T', 'A', 'R', 'E', 0, 0, 0, 0, 0};
    performed.reply             = pus_later();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, sizeof data));
    EXPECT_MESSAGES(1, 1, 1, 3);
    TEST_ASSERT_EQUAL_UINT16(0U, performed.index);
    pus_verify_completed(&bench.process, &performed.token, TEST_NOW_NS);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(1U, data, sizeof data);
}

static void a_refusal_of_the_port_is_reported(void)
{
    performed.reply = pus_refused(PUS_FAILURE_STATE, 3U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, move, sizeof move));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, PUS_FAILURE_STATE, 0U, 3U);
    bench_clear();
    performed.reply = pus_failed(PUS_FAILURE_DEVICE, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, move, sizeof move));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
}

static void other_names_are_unknown(void)
{
    static const char* const names[] = {"",         "TAR",     "TARE_",    "tare",
                                        "MOVE_TO_", "EIGHTCH", "EIGHTCHX", "XTARE"};
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        uint8_t data[20] = {0};
        memcpy(data, names[i], strlen(names[i]));
        bench_clear();
        // The arguments of an unknown function cannot be checked.
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, 9U + i));
        EXPECT_MESSAGES(1, 1, 1, 4);
        const uint32_t first_4_octets = // The detail of the failure.
            ((uint32_t)data[0] << 24U) | ((uint32_t)data[1] << 16U) | ((uint32_t)data[2] << 8U) | data[3];
        expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 0U, first_4_octets);
    }
    for (size_t size = 0U; size < 9U; size++) {
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(1U, "NO_SUCH_F", size));
    }
    static const uint8_t padded[] = {'T', 'A', 'R', 'E', 0,
                                     'X', 0,   0,   0}; // Octets after the end of the name.
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, padded, sizeof padded));
    EXPECT_MESSAGES(1, 1, 1, 4);
    TEST_ASSERT_EQUAL_UINT32(0U, performed.calls);
}

/// Expect that MOVE_TO with octet `offset` changed is refused at its start and not performed.
static void expect_refused(const size_t offset, const uint8_t value, const uint16_t code,
                           const uint16_t instruction, const uint32_t detail)
{
    uint8_t data[sizeof move];
    memcpy(data, move, sizeof data);
    data[offset] = value;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, sizeof data));
    EXPECT_MESSAGES(1, 1, 1, 4);
    expect_failure(1U, 4U, code, instruction, detail);
    TEST_ASSERT_EQUAL_UINT32(0U, performed.calls);
}

static void bad_arguments_are_reported_with_their_position(void)
{
    expect_refused(10U, 99U, PUS_FAILURE_UNKNOWN_ID, 1U, 99U);
    expect_refused(28U, 99U, PUS_FAILURE_UNKNOWN_ID, 2U, 99U);
    expect_refused(38U, 8U, PUS_FAILURE_UNKNOWN_ID, 3U, 8U);
    expect_refused(39U, 2U, PUS_FAILURE_OUT_OF_RANGE, 3U, 39U); // A BOOL that is neither 0 nor 1.
    // The same argument occurs twice, with equal sizes.
    static const uint8_t twice[] = {'E', 'I', 'G', 'H', 'T', 'C', 'H', 'R', 3, 0, 1, 5, 0, 1, 6, 0, 1, 7};
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, twice, sizeof twice));
    expect_failure(1U, 4U, PUS_FAILURE_DUPLICATE, 2U, 1U);
}

static void values_that_are_not_finite_are_refused(void)
{
    uint8_t data[sizeof move];
    for (unsigned sign = 0U; sign < 2U; sign++) {
        for (unsigned fraction = 0U; fraction < 2U; fraction++) { // The values are infinity and NaN.
            memcpy(data, move, sizeof data);
            data[19] = (uint8_t)(0x7FU | (sign << 7U));
            data[20] = (uint8_t)(0xF0U | (fraction << 3U));
            bench_clear();
            TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, sizeof data));
            expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 1U, 11U);
        }
    }
    data[19] = 0x7FU; // The largest double.
    data[20] = 0xEFU;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, data, sizeof data));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    uint8_t floats[] = {'E', 'I', 'G', 'H', 'T', 'C', 'H', 'R', 3, 0, 1, 5, 0, 2, 0,    0,    0, 0,
                        0,   0,   0,   0,   0,   3,   0,   0,   0, 0, 0, 0, 0, 0, 0x7F, 0x80, 0, 0};
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, floats, sizeof floats));
    expect_failure(1U, 4U, PUS_FAILURE_OUT_OF_RANGE, 3U, 24U);
    floats[33] = 0x7FU;
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, floats, sizeof floats));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

static void every_wrong_count_and_length_is_rejected(void)
{
    uint8_t data[sizeof move];
    expect_strict_format(1U, move, sizeof move);
    for (unsigned count = 0U; count < 256U; count++) {
        memcpy(data, move, sizeof data);
        data[8] = (uint8_t)count;
        if (count != 3U) {
            bench_clear();
            TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(1U, data, sizeof data));
            expect_failure(0U, 2U, PUS_FAILURE_DATA, 0U, 8U);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0U, performed.calls);
}

static void declare_beyond_the_area(void)
{
    memset(&functions, 0xA5, sizeof functions);
    pus_functions_init(&functions, table, 3U, &port, area, sizeof(move_to_t) - 8U);
}

static void a_table_that_does_not_fit_its_area_is_a_coding_error(void)
{
    TEST_ASSERT_TRUE(assertion_fails(declare_beyond_the_area));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(arguments_become_a_struct);
    RUN_TEST(arguments_may_have_any_order);
    RUN_TEST(the_request_for_a_function_without_arguments_has_the_count_0);
    RUN_TEST(a_refusal_of_the_port_is_reported);
    RUN_TEST(other_names_are_unknown);
    RUN_TEST(bad_arguments_are_reported_with_their_position);
    RUN_TEST(values_that_are_not_finite_are_refused);
    RUN_TEST(every_wrong_count_and_length_is_rejected);
    RUN_TEST(a_table_that_does_not_fit_its_area_is_a_coding_error);
    return UNITY_END();
}
