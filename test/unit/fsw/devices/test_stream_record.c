// SPDX-License-Identifier: Apache-2.0
// Octets expected here are written down by hand.
#include "fsw/devices/stream_record.h"

#include "base/crc.h"
#include "test/unit/fsw/devices/descriptors.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define ALL_TYPES(direction)                                                                                 \
    "<Field name='A" direction "' direction='" direction "' type='UINT8'/>"                                  \
    "<Field name='B" direction "' direction='" direction "' type='INT16' scale='0.5' offset='10'/>"          \
    "<Field name='C" direction "' direction='" direction "' type='UINT32' scale='-2'/>"                      \
    "<Field name='D" direction "' direction='" direction "' type='FLOAT'/>"                                  \
    "<Field name='E" direction "' direction='" direction "' type='DOUBLE' scale='1e-3'/>"                    \
    "<Field name='F" direction "' direction='" direction "' type='INT64'/>"                                  \
    "<Field name='G" direction "' direction='" direction "' type='UINT64'/>"                                 \
    "<Field name='H" direction "' direction='" direction "' type='INT8'/>"

#define OCTETS 36U

static subsystem_descriptor_t descriptor;
static stream_record_t record;

static void begin(const char* const endnode, const bool is_out)
{
    char document[4096];
    (void)strcpy(document, BEGIN "<Device name='X' type='stream'>" ALL_TYPES("IN") ALL_TYPES("OUT"));
    (void)strcat(document, endnode);
    (void)strcat(document, "</Device>" END);
    load_document(document, &descriptor);
    stream_record_init(&record, &descriptor, &descriptor.devices[0], is_out);
}

void setUp(void)
{
    begin("<Endnode type='SHM' name='x'/>", false);
}

void tearDown(void)
{
}

static const uint8_t big[OCTETS] = {0x07, 0xFF, 0xFE, 0x00, 0x00, 0x00, 0x03, 0x3F, 0x80, 0x00, 0x00, 0x40,
                                    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
                                    0xFF, 0xFF, 0xFE, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x05, 0x80};
static const double values[8]    = {7.0, 9.0, -6.0, 1.0, 0.002, -2.0, 5.0, -128.0};

static void reverse_fields(uint8_t* const octets)
{
    static const size_t sizes[8] = {1U, 2U, 4U, 4U, 8U, 8U, 8U, 1U};
    size_t start                 = 0U;
    for (unsigned i = 0U; i < 8U; i++) {
        for (size_t k = 0U; k < sizes[i]; k++) {
            octets[start + k] = big[start + sizes[i] - 1U - k];
        }
        start += sizes[i];
    }
}

static void raw_values_become_engineering_values_in_both_byte_orders(void)
{
    uint8_t octets[OCTETS];
    TEST_ASSERT_EQUAL_UINT8(8U, record.field_count);
    TEST_ASSERT_EQUAL_UINT32(OCTETS, stream_record_octets(&record));
    TEST_ASSERT_EQUAL(STATUS_OK, stream_record_take(&record, big, OCTETS));
    for (uint8_t i = 0U; i < 8U; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, values[i], stream_record_value(&record, i));
    }
    begin("<Endnode type='SHM' name='x' order='LITTLE'/>", false);
    reverse_fields(octets);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_record_take(&record, octets, OCTETS));
    for (uint8_t i = 0U; i < 8U; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, values[i], stream_record_value(&record, i));
    }
}

static void engineering_values_become_raw_values_in_both_byte_orders(void)
{
    uint8_t octets[STREAM_RECORD_OCTETS_MAX];
    uint8_t expected[OCTETS];
    begin("<Endnode type='SHM' name='x'/>", true);
    for (uint8_t i = 0U; i < 8U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, stream_record_set(&record, i, values[i]));
    }
    TEST_ASSERT_EQUAL_UINT64(OCTETS, stream_record_put(&record, octets));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(big, octets, OCTETS);
    begin("<Endnode type='SHM' name='x' order='LITTLE'/>", true);
    for (uint8_t i = 0U; i < 8U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, stream_record_set(&record, i, values[i]));
    }
    reverse_fields(expected);
    TEST_ASSERT_EQUAL_UINT64(OCTETS, stream_record_put(&record, octets));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, octets, OCTETS);
}

static void raw_values_are_rounded_and_limited_to_their_type(void)
{
    begin("<Endnode type='SHM' name='x'/>", true);
    static const struct {
        uint8_t field;
        double value;
        double expected;
    } cases[] = {{0U, 7.4, 7.0},
                 {0U, 7.5, 8.0},
                 {0U, -3.0, 0.0},
                 {0U, 300.0, 255.0},
                 {1U, 10.2, 10.0},
                 {1U, 9.7, 9.5},
                 {1U, 1e9, 16393.5},
                 {1U, -1e9, -16374.0},
                 {2U, 100.0, 0.0},
                 {2U, -1e12, -2.0 * 4294967295.0},
                 {7U, -127.6, -128.0},
                 {7U, 1000.0, 127.0},
                 {7U, -2.5, -3.0},
                 {7U, 0.49999999999999994, 0.0}, // The sum with 0.5 would be 1.
                 {7U, -0.49999999999999994, 0.0},
                 {5U, 4503599627370497.0, 4503599627370497.0}, // 2^52 + 1: the sum would round to 2^52 + 2.
                 {5U, -4503599627370497.0, -4503599627370497.0},
                 {5U, 1e300, 9223372036854774784.0},
                 {5U, -1e300, -9223372036854775808.0},
                 {6U, 1e300, 18446744073709549568.0},
                 {3U, 1e300, 3.4028234663852886e38}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, stream_record_set(&record, cases[i].field, cases[i].value));
        TEST_ASSERT_TRUE(stream_record_value(&record, cases[i].field) == cases[i].expected);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, stream_record_set(&record, 0U, 9.0));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, stream_record_set(&record, 0U, (double)NAN));
    TEST_ASSERT_TRUE(stream_record_value(&record, 0U) == 9.0);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_record_set(&record, 4U, (double)INFINITY));
    TEST_ASSERT_TRUE(isfinite(stream_record_value(&record, 4U)));
}

static void records_of_another_length_change_nothing(void)
{
    uint8_t longer[OCTETS + 1U] = {0U};
    TEST_ASSERT_EQUAL(STATUS_OK, stream_record_take(&record, big, OCTETS));
    for (size_t size = 0U; size < OCTETS; size++) {
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, stream_record_take(&record, longer, size));
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, stream_record_take(&record, longer, sizeof longer));
    TEST_ASSERT_TRUE(stream_record_value(&record, 0U) == 7.0);
}

static void every_damaged_bit_of_a_record_with_checksum_is_found(void)
{
    for (unsigned order = 0U; order < 2U; order++) {
        uint8_t octets[STREAM_RECORD_OCTETS_MAX];
        const char* const endnode = (order == 0U)
                                        ? "<Endnode type='SHM' name='x' checksum='true'/>"
                                        : "<Endnode type='SHM' name='x' order='LITTLE' checksum='true'/>";
        begin(endnode, true);
        for (uint8_t i = 0U; i < 8U; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, stream_record_set(&record, i, values[i]));
        }
        TEST_ASSERT_EQUAL_UINT64(OCTETS + 2U, stream_record_put(&record, octets));
        const uint16_t checksum = crc16_ccitt(octets, OCTETS);
        TEST_ASSERT_EQUAL_HEX8((order == 0U) ? (checksum >> 8U) : (checksum & 0xFFU), octets[OCTETS]);
        begin(endnode, false);
        TEST_ASSERT_EQUAL(STATUS_OK, stream_record_take(&record, octets, OCTETS + 2U));
        for (unsigned bit = 0U; bit < ((OCTETS + 2U) * 8U); bit++) {
            octets[bit / 8U] = (uint8_t)(octets[bit / 8U] ^ (1U << (bit % 8U)));
            TEST_ASSERT_EQUAL(STATUS_CHECKSUM, stream_record_take(&record, octets, OCTETS + 2U));
            octets[bit / 8U] = (uint8_t)(octets[bit / 8U] ^ (1U << (bit % 8U)));
        }
        TEST_ASSERT_TRUE(stream_record_value(&record, 0U) == 7.0);
    }
}

static void safe_values_are_those_of_the_descriptor(void)
{
    load_document(BEGIN AXIS("X", "<Endnode type='SHM' name='x'/>") END, &descriptor);
    stream_record_init(&record, &descriptor, &descriptor.devices[0], true);
    TEST_ASSERT_EQUAL(STATUS_OK, stream_record_set(&record, 0U, 1.0));
    stream_record_set_safe(&record);
    TEST_ASSERT_TRUE(stream_record_value(&record, 0U) == 0.0);
    TEST_ASSERT_TRUE(stream_record_value(&record, 1U) == 3.0);
}

static void a_direction_without_fields_has_no_octets(void)
{
    uint8_t octets[STREAM_RECORD_OCTETS_MAX];
    load_document(
        BEGIN "<Device name='X' type='stream'><Endnode type='SHM' name='x' checksum='true'/></Device>" END,
        &descriptor);
    stream_record_init(&record, &descriptor, &descriptor.devices[0], true);
    TEST_ASSERT_EQUAL_UINT32(0U, stream_record_octets(&record));
    TEST_ASSERT_EQUAL_UINT64(0U, stream_record_put(&record, octets));
    TEST_ASSERT_EQUAL(STATUS_OK, stream_record_take(&record, octets, 0U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(raw_values_become_engineering_values_in_both_byte_orders);
    RUN_TEST(engineering_values_become_raw_values_in_both_byte_orders);
    RUN_TEST(raw_values_are_rounded_and_limited_to_their_type);
    RUN_TEST(records_of_another_length_change_nothing);
    RUN_TEST(every_damaged_bit_of_a_record_with_checksum_is_found);
    RUN_TEST(safe_values_are_those_of_the_descriptor);
    RUN_TEST(a_direction_without_fields_has_no_octets);
    return UNITY_END();
}
