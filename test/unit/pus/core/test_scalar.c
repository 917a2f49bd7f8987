// SPDX-License-Identifier: Apache-2.0
// Scalar values of parameters: type, octets, comparison and differences.
#include "pus/core/scalar.h"

#include "pus/core/tailoring.h"
#include "test/unit/pus/fixtures/scalars.h"
#include "unity.h"

#define INFINITE (1e300 * 1e300)
#define NOT_A_NUMBER 0x7FF8000000000000ULL
#define NOT_A_FLOAT 0x7FC00000ULL

void setUp(void)
{
}

void tearDown(void)
{
}

static void the_id_determines_the_type(void)
{
    TEST_ASSERT_EQUAL(VALUE_UINT8, pus_scalar_type(0U));
    TEST_ASSERT_EQUAL(VALUE_BOOL, pus_scalar_type(SCALAR_ID(VALUE_BOOL, 77U)));
    TEST_ASSERT_EQUAL(VALUE_SCALARS, pus_scalar_type(SCALAR_ARRAY));
    TEST_ASSERT_EQUAL(VALUE_SCALARS, pus_scalar_type(SCALAR_ID(VALUE_SCALARS, 0U)));
}

static void parameters_are_found(void)
{
    const pus_parameter_port_t port = scalars_port();
    pus_scalar_t scalar             = {.id = 1U};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_scalar_find(&port, SCALAR_ID(VALUE_INT16, 5U), &scalar));
    TEST_ASSERT_EQUAL_HEX32(SCALAR_ID(VALUE_INT16, 5U), scalar.id);
    TEST_ASSERT_EQUAL(VALUE_INT16, scalar.type);
    scalar_set(scalar.id, 0xFEDCU);
    uint64_t bits = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_scalar_sample(&port, &scalar, &bits));
    TEST_ASSERT_EQUAL_HEX64(0xFEDCU, bits);
    scalar.id = SCALAR_UNKNOWN; // There is no parameter with this id.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_scalar_sample(&port, &scalar, &bits));
    TEST_ASSERT_EQUAL_HEX64(0U, bits);
    scalar.id = SCALAR_ID(VALUE_INT16, 5U);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, pus_scalar_find(&port, SCALAR_UNKNOWN, &scalar));
    scalars.is_silent = true; // The parameter is known, but has no value yet.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_scalar_find(&port, scalar.id, &scalar));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, pus_scalar_sample(&port, &scalar, &bits));
    TEST_ASSERT_EQUAL_HEX64(0U, bits);
    scalars.is_silent = false;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, pus_scalar_find(&port, SCALAR_SECRET, &scalar));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_scalar_find(&port, SCALAR_ODD, &scalar));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_scalar_find(&port, SCALAR_ARRAY, &scalar));
    TEST_ASSERT_EQUAL_HEX32(SCALAR_ID(VALUE_INT16, 5U), scalar.id);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_UNKNOWN_ID, pus_scalar_failure(STATUS_NOT_FOUND));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ACCESS, pus_scalar_failure(STATUS_FORBIDDEN));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_ACCESS, pus_scalar_failure(STATUS_INVALID));
}

static void octets_are_in_the_order_of_the_packet(void)
{
    static const uint8_t octets[] = {0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0xF0};
    for (value_type_t type = VALUE_UINT8; type < VALUE_SCALARS; type++) {
        uint8_t written[8]    = {0};
        const size_t size     = value_size(type);
        octet_reader_t reader = octet_reader(octets, sizeof octets);
        const uint64_t bits   = pus_scalar_read(&reader, type);
        TEST_ASSERT_EQUAL_HEX64(0x123456789ABCDEF0ULL >> (64U - (8U * size)), bits);
        octet_writer_t writer = octet_writer(written, sizeof written);
        pus_scalar_write(&writer, type, bits);
        TEST_ASSERT_EQUAL_UINT64(size, writer.position);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, written, size);
    }
}

static void expect_order(const value_type_t type, const uint64_t one, const uint64_t other,
                         const pus_comparison_t expected)
{
    static const pus_comparison_t reverse[] = {PUS_GREATER, PUS_EQUAL, PUS_LESS, PUS_UNORDERED};
    TEST_ASSERT_EQUAL(expected, pus_scalar_compare(type, one, other));
    TEST_ASSERT_EQUAL(reverse[expected], pus_scalar_compare(type, other, one));
}

static void integers_are_compared_exactly(void)
{
    expect_order(VALUE_UINT8, 127U, 128U, PUS_LESS);
    expect_order(VALUE_INT8, 0x80U, 0x7FU, PUS_LESS);
    expect_order(VALUE_INT8, 0xFFU, 0x00U, PUS_LESS);
    expect_order(VALUE_UINT16, 0xFFFFU, 0xFFFFU, PUS_EQUAL);
    expect_order(VALUE_INT16, 0x8000U, 0xFFFFU, PUS_LESS);
    expect_order(VALUE_UINT32, 0x80000000U, 0x7FFFFFFFU, PUS_GREATER);
    expect_order(VALUE_INT32, 0x80000000U, 0x7FFFFFFFU, PUS_LESS);
    expect_order(VALUE_UINT64, 0xFFFFFFFFFFFFFFFEULL, UINT64_MAX, PUS_LESS);
    expect_order(VALUE_INT64, 0x8000000000000000ULL, 0x7FFFFFFFFFFFFFFFULL, PUS_LESS);
    // Both have the same value as double.
    expect_order(VALUE_INT64, 0x7FFFFFFFFFFFFFFEULL, 0x7FFFFFFFFFFFFFFFULL, PUS_LESS);
    expect_order(VALUE_INT64, UINT64_MAX, 0U, PUS_LESS);
    expect_order(VALUE_BOOL, 0U, 1U, PUS_LESS);
}

static void reals_are_compared_as_numbers(void)
{
    expect_order(VALUE_DOUBLE, bits_of_double(-1.0), bits_of_double(1.0), PUS_LESS);
    expect_order(VALUE_DOUBLE, bits_of_double(-0.0), bits_of_double(0.0), PUS_EQUAL);
    expect_order(VALUE_DOUBLE, bits_of_double(INFINITE), bits_of_double(1e308), PUS_GREATER);
    expect_order(VALUE_DOUBLE, NOT_A_NUMBER, bits_of_double(0.0), PUS_UNORDERED);
    expect_order(VALUE_DOUBLE, NOT_A_NUMBER, NOT_A_NUMBER, PUS_UNORDERED);
    expect_order(VALUE_FLOAT, bits_of_float(-2.5F), bits_of_float(-2.25F), PUS_LESS);
    expect_order(VALUE_FLOAT, NOT_A_FLOAT, bits_of_float(1.0F), PUS_UNORDERED);
}

static void expect_delta(const value_type_t type, const uint64_t first, const uint64_t last,
                         const uint16_t count, const uint64_t threshold, const pus_comparison_t expected)
{
    TEST_ASSERT_EQUAL(expected, pus_scalar_compare_delta(type, first, last, count, threshold));
}

static void differences_are_exact(void)
{
    TEST_ASSERT_EQUAL(VALUE_INT8, pus_scalar_delta_type(VALUE_BOOL));
    TEST_ASSERT_EQUAL(VALUE_INT64, pus_scalar_delta_type(VALUE_UINT64));
    TEST_ASSERT_EQUAL(VALUE_FLOAT, pus_scalar_delta_type(VALUE_FLOAT));
    expect_delta(VALUE_UINT8, 10U, 15U, 1U, 5U, PUS_EQUAL);
    expect_delta(VALUE_UINT8, 10U, 15U, 1U, 4U, PUS_GREATER);
    expect_delta(VALUE_UINT8, 10U, 15U, 1U, 6U, PUS_LESS);
    expect_delta(VALUE_UINT8, 15U, 10U, 1U, 0xFBU, PUS_EQUAL); // -5.
    expect_delta(VALUE_UINT8, 15U, 10U, 1U, 0xFCU, PUS_LESS);
    expect_delta(VALUE_UINT8, 15U, 10U, 1U, 0xFAU, PUS_GREATER);
    expect_delta(VALUE_UINT8, 15U, 10U, 1U, 0U, PUS_LESS);
    expect_delta(VALUE_UINT8, 10U, 10U, 1U, 0xFFU, PUS_GREATER);
    expect_delta(VALUE_INT8, 0x80U, 0x7FU, 1U, 0x7FU, PUS_GREATER); // 255 against 127.
    expect_delta(VALUE_INT8, 0x80U, 0x7FU, 3U, 85U, PUS_EQUAL);
    expect_delta(VALUE_UINT64, 0U, UINT64_MAX, 1U, 0x7FFFFFFFFFFFFFFFULL, PUS_GREATER);
    expect_delta(VALUE_UINT64, 0U, UINT64_MAX, 3U, 0x5555555555555555ULL, PUS_EQUAL);
    // The sum exceeds 64 bits.
    expect_delta(VALUE_UINT64, 0U, UINT64_MAX, 3U, 0x5555555555555556ULL, PUS_LESS);
    expect_delta(VALUE_UINT64, UINT64_MAX, 0U, 3U, 0xAAAAAAAAAAAAAAAAULL, PUS_GREATER);
    expect_delta(VALUE_UINT64, UINT64_MAX, 0U, 3U, 0xAAAAAAAAAAAAAAABULL, PUS_EQUAL);
    expect_delta(VALUE_UINT64, UINT64_MAX, 0U, 1U, 0x8000000000000000ULL, PUS_LESS);
    expect_delta(VALUE_INT64, 0x8000000000000000ULL, 0x7FFFFFFFFFFFFFFFULL, 65535U, 0x0001000100010001ULL,
                 PUS_EQUAL);
    expect_delta(VALUE_DOUBLE, bits_of_double(1.0), bits_of_double(2.0), 4U, bits_of_double(0.25), PUS_EQUAL);
    expect_delta(VALUE_FLOAT, bits_of_float(1.0F), bits_of_float(0.0F), 1U, bits_of_float(-0.5F), PUS_LESS);
    expect_delta(VALUE_DOUBLE, bits_of_double(INFINITE), bits_of_double(INFINITE), 1U, bits_of_double(0.0),
                 PUS_UNORDERED);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_id_determines_the_type);
    RUN_TEST(parameters_are_found);
    RUN_TEST(octets_are_in_the_order_of_the_packet);
    RUN_TEST(integers_are_compared_exactly);
    RUN_TEST(reals_are_compared_as_numbers);
    RUN_TEST(differences_are_exact);
    return UNITY_END();
}
