// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/parameter/parameter.h"
#include "test/support/assertion.h"
#include "test/support/consistent_parameter.h"

#include "unity.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define APID 16U
#define MANY 2000U

typedef struct {
    int32_t state;
    double position[2];
    uint16_t word;
    bool flag;
} values_t;

static const parameter_field_t fields[] = {
    {"STATE", VALUE_INT32, 1U, (uint32_t)offsetof(values_t, state)},
    {"POSITION", VALUE_DOUBLE, 2U, (uint32_t)offsetof(values_t, position)},
    {"WORD", VALUE_UINT16, 1U, (uint32_t)offsetof(values_t, word)},
    {"FLAG", VALUE_BOOL, 1U, (uint32_t)offsetof(values_t, flag)},
    {"TARGET", VALUE_DOUBLE, 2U, 0U},
    {"RATE", VALUE_FLOAT, 1U, 0U},
    {"VALUE", VALUE_DOUBLE, 1U, 0U},
};

static const parameter_definition_t definitions[] = {
    {"VALUES", PARAMETER_ID(APID, VALUE_STRUCT, 0U), &fields[0], 4U, (uint32_t)sizeof(values_t), 23U},
    {"TARGET", PARAMETER_ID(APID, VALUE_ARRAY, 1U), &fields[4], 1U, 16U, 16U},
    {"RATE", PARAMETER_ID(APID, VALUE_FLOAT, 2U), &fields[5], 1U, 4U, 4U},
};
#define VALUES definitions[0].id
#define TARGET definitions[1].id
#define RATE definitions[2].id
#define UNKNOWN PARAMETER_ID(APID, VALUE_FLOAT, 1U)

static parameter_entry_t entries[64];
static parameter_bounds_t bounds[64];
static parameter_dictionary_t dictionary;
static values_t values;
static double target[2];
static float rate;
static uint8_t octets[64];

void setUp(void)
{
    values    = (values_t){-2, {1.5, -2.5}, 0xBEEFU, true};
    target[0] = 0.25;
    target[1] = 0.5;
    rate      = 1.0F;
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_init(&dictionary, entries, 64U, bounds, 64U));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &definitions[1], target));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &definitions[2], &rate));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &definitions[0], &values));
}

void tearDown(void)
{
    TEST_ASSERT_TRUE(parameter_is_consistent(&dictionary));
}

static void an_id_contains_apid_layout_and_number(void)
{
    const uint32_t id = PARAMETER_ID(2046U, VALUE_ARRAY, 65535U);
    TEST_ASSERT_EQUAL_HEX32(0xFFD9FFFFU, id);
    TEST_ASSERT_EQUAL_UINT16(2046U, PARAMETER_APID(id));
    TEST_ASSERT_EQUAL_UINT8(VALUE_ARRAY, PARAMETER_LAYOUT(id));
    TEST_ASSERT_EQUAL_UINT16(65535U, PARAMETER_NUMBER(id));
}

static void a_structure_is_read_big_endian_without_padding(void)
{
    static const uint8_t expected[] = {0xFF, 0xFF, 0xFF, 0xFE, 0x3F, 0xF8, 0, 0, 0,    0,    0, 0,
                                       0xC0, 0x04, 0,    0,    0,    0,    0, 0, 0xBE, 0xEF, 1};
    octet_writer_t writer           = octet_writer(octets, sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_read(&dictionary, VALUES, &writer));
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, octets, sizeof expected);
}

static void parameters_are_found_by_id(void)
{
    const parameter_entry_t* by_id = NULL;
    for (size_t i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, parameter_find(&dictionary, definitions[i].id, &by_id));
        TEST_ASSERT_EQUAL_PTR(&definitions[i], by_id->definition);
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_find(&dictionary, UNKNOWN, &by_id));
    TEST_ASSERT_EQUAL_UINT32(1U, dictionary.refusals.unknown);
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_read(&dictionary, UNKNOWN, &writer));
    TEST_ASSERT_EQUAL_UINT32(2U, dictionary.refusals.unknown);
}

static void parameters_already_published_or_without_room_are_refused(void)
{
    static parameter_entry_t few[1];
    static parameter_bounds_t four[4];
    parameter_dictionary_t small;
    TEST_ASSERT_EQUAL(STATUS_EXISTS, parameter_publish(&dictionary, &definitions[0], &values));
    parameter_definition_t same_name = definitions[1];
    same_name.id                     = UNKNOWN;
    TEST_ASSERT_EQUAL(STATUS_EXISTS, parameter_publish(&dictionary, &same_name, target));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_init(&small, few, 1U, four, 3U));
    // The structure has four fields.
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, parameter_publish(&small, &definitions[0], &values));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&small, &definitions[1], target));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, parameter_publish(&small, &definitions[2], &rate));
    TEST_ASSERT_EQUAL_UINT32(2U, small.refusals.no_room);
    parameter_withdraw_all(&small);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&small, &definitions[2], &rate));
    TEST_ASSERT_TRUE(parameter_is_consistent(&small));
}

static void a_read_that_does_not_fit_writes_nothing(void)
{
    for (size_t room = 0U; room < 23U; room++) {
        octet_writer_t writer = octet_writer(octets, room);
        memset(octets, 0x77, sizeof octets);
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parameter_read(&dictionary, VALUES, &writer));
        TEST_ASSERT_EQUAL_UINT64(0U, writer.position);
        TEST_ASSERT_FALSE(writer.failed);
        TEST_ASSERT_EACH_EQUAL_HEX8(0x77, octets, sizeof octets);
    }
    octet_writer_t exact = octet_writer(octets, 23U);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_read(&dictionary, VALUES, &exact));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_read(&dictionary, UNKNOWN, &exact));
    TEST_ASSERT_EQUAL_UINT32(23U, dictionary.refusals.no_room);
}

static void an_entry_is_read_without_the_lock(void)
{
    const parameter_entry_t* entry = NULL;
    octet_writer_t writer          = octet_writer(octets, 23U);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_find(&dictionary, VALUES, &entry));
    // As if another task held the lock.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_mutex_lock(&dictionary.mutex));
#ifndef THREAD_CHECKS // With the thread sanitizer every reader takes the lock, which this task holds.
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_read_entry(&dictionary, entry, &writer));
    TEST_ASSERT_EQUAL_UINT64(23U, writer.position);
#endif
    osal_mutex_unlock(&dictionary.mutex);
    for (size_t room = 0U; room < 23U; room++) {
        writer = octet_writer(octets, room);
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parameter_read_entry(&dictionary, entry, &writer));
        TEST_ASSERT_EQUAL_UINT64(0U, writer.position);
    }
    writer.failed = true;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parameter_read_entry(&dictionary, entry, &writer));
    TEST_ASSERT_EQUAL_UINT32(24U, dictionary.refusals.no_room);
}

/// The octets of the value overlap the sequence counter: the read looks as if the owner wrote during it.
static void a_read_during_a_write_is_repeated_under_the_lock(void)
{
    static const uint8_t expected[] = {0x3F, 0x80, 0x00, 0x00};
    const parameter_entry_t* entry  = NULL;
    octet_writer_t writer =
        octet_writer((uint8_t*)&dictionary.sequence_counter, sizeof dictionary.sequence_counter);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_find(&dictionary, RATE, &entry));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_read_entry(&dictionary, entry, &writer));
    TEST_ASSERT_EQUAL_UINT64(4U, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, &dictionary.sequence_counter, sizeof expected);
}

static void while_values_change_an_entry_is_read_with_the_lock(void)
{
    const parameter_entry_t* entry = NULL;
    octet_writer_t writer          = octet_writer(octets, 4U);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_find(&dictionary, RATE, &entry));
    dictionary.sequence_counter++; // As between parameter_lock and parameter_unlock.
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_read_entry(&dictionary, entry, &writer));
    TEST_ASSERT_EQUAL_UINT64(4U, writer.position);
    dictionary.sequence_counter++;
    const uint32_t before = dictionary.sequence_counter;
    parameter_lock(&dictionary);
    TEST_ASSERT_EQUAL_UINT32(1U, dictionary.sequence_counter % 2U);
    parameter_unlock(&dictionary);
    TEST_ASSERT_EQUAL_UINT32(before + 2U, dictionary.sequence_counter);
}

static octet_reader_t target_value(const double first, const double second)
{
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_f64(&writer, first);
    octet_write_f64(&writer, second);
    return octet_reader(octets, writer.position);
}

static void only_settable_parameters_are_written(void)
{
    octet_reader_t reader = target_value(-0.5, 1.0);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_write(&dictionary, UNKNOWN, &reader));
    TEST_ASSERT_EQUAL_UINT32(1U, dictionary.refusals.unknown);
    TEST_ASSERT_EQUAL(STATUS_READ_ONLY, parameter_write(&dictionary, TARGET, &reader));
    TEST_ASSERT_EQUAL_DOUBLE(0.25, target[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_settable(&dictionary, TARGET, true));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_write(&dictionary, TARGET, &reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    TEST_ASSERT_EQUAL_DOUBLE(-0.5, target[0]);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, target[1]);
    const parameter_entry_t* entry = NULL;
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_find(&dictionary, TARGET, &entry));
    TEST_ASSERT_EQUAL_UINT32(1U, entry->writes);
    TEST_ASSERT_EQUAL_UINT32(1U, dictionary.refusals.read_only);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_set_settable(&dictionary, UNKNOWN, true));
}

static void a_write_changes_all_fields_or_none(void)
{
    static const double bad[] = {1.0001, -1.0001, NAN, INFINITY, -INFINITY, DBL_MAX};
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_settable(&dictionary, TARGET, true));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_bounds(&dictionary, TARGET, "TARGET", -1.0, 1.0));
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        octet_reader_t reader = target_value(0.75, bad[i]);
        TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, parameter_write(&dictionary, TARGET, &reader));
        TEST_ASSERT_EQUAL_UINT64(0U, reader.position);
        TEST_ASSERT_EQUAL_DOUBLE(0.25, target[0]);
    }
    for (size_t size = 0U; size < 16U; size++) {
        octet_reader_t reader = target_value(0.75, 0.75);
        reader.size           = size;
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, parameter_write(&dictionary, TARGET, &reader));
        TEST_ASSERT_EQUAL_DOUBLE(0.25, target[0]);
    }
    octet_reader_t reader = target_value(-1.0, 1.0);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_write(&dictionary, TARGET, &reader));
    TEST_ASSERT_EQUAL_UINT32(6U, dictionary.refusals.out_of_range);
    TEST_ASSERT_EQUAL_UINT32(16U, dictionary.refusals.malformed);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_set_bounds(&dictionary, TARGET, "OTHER", 0.0, 1.0));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_set_bounds(&dictionary, UNKNOWN, "TARGET", 0.0, 1.0));
}

/// NaN and infinity are refused even without bounds in the descriptor; a BOOL is 0 or 1.
static void octets_that_are_no_value_of_the_type_are_refused(void)
{
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_settable(&dictionary, VALUES, true));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_settable(&dictionary, RATE, true));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_read(&dictionary, VALUES, &writer));
    octets[22]            = 2U;
    octet_reader_t reader = octet_reader(octets, writer.position);
    TEST_ASSERT_EQUAL(STATUS_INVALID, parameter_write(&dictionary, VALUES, &reader));
    static const uint8_t nan32[] = {0x7F, 0xC0, 0, 0};
    reader                       = octet_reader(nan32, sizeof nan32);
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, parameter_write(&dictionary, RATE, &reader));
    TEST_ASSERT_EQUAL_FLOAT(1.0F, rate);
}

/// Every structure that can be read can be written back, and then reads the same.
static void a_structure_that_is_written_back_reads_the_same(void)
{
    uint8_t first[23];
    uint8_t second[23];
    uint32_t random = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_settable(&dictionary, VALUES, true));
    for (unsigned i = 0U; i < 10000U; i++) {
        random = (random * 1664525U) + 1013904223U;
        values = (values_t){(int32_t)random, {(double)random / 7.0, -(double)i}, (uint16_t)i, (i % 2U) == 0U};
        octet_writer_t writer = octet_writer(first, sizeof first);
        TEST_ASSERT_EQUAL(STATUS_OK, parameter_read(&dictionary, VALUES, &writer));
        values                = (values_t){0};
        octet_reader_t reader = octet_reader(first, sizeof first);
        TEST_ASSERT_EQUAL(STATUS_OK, parameter_write(&dictionary, VALUES, &reader));
        writer = octet_writer(second, sizeof second);
        TEST_ASSERT_EQUAL(STATUS_OK, parameter_read(&dictionary, VALUES, &writer));
        TEST_ASSERT_EQUAL_HEX8_ARRAY(first, second, sizeof first);
    }
}

static void initial_values_are_set_from_text(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_initial(&dictionary, TARGET, "TARGET", "-1.5 2e-3"));
    TEST_ASSERT_EQUAL_DOUBLE(-1.5, target[0]);
    TEST_ASSERT_EQUAL_DOUBLE(0.002, target[1]);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_initial(&dictionary, VALUES, "FLAG", "false"));
    TEST_ASSERT_FALSE(values.flag);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_initial(&dictionary, VALUES, "WORD", "0x1234"));
    TEST_ASSERT_EQUAL_HEX16(0x1234U, values.word);
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_initial(&dictionary, VALUES, "POSITION", NULL));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, values.position[1]);
    TEST_ASSERT_EQUAL(STATUS_INVALID, parameter_set_initial(&dictionary, TARGET, "TARGET", "1"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parameter_set_initial(&dictionary, TARGET, "TARGET", "1 2 3"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parameter_set_initial(&dictionary, TARGET, "TARGET", "1 x"));
    TEST_ASSERT_EQUAL(STATUS_INVALID, parameter_set_initial(&dictionary, TARGET, "TARGET", ""));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, parameter_set_initial(&dictionary, VALUES, "WORD", "65536"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_set_initial(&dictionary, VALUES, "SPEED", "1"));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, parameter_set_initial(&dictionary, UNKNOWN, "RATE", "1"));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_set_bounds(&dictionary, TARGET, "TARGET", -1.0, 1.0));
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, parameter_set_initial(&dictionary, TARGET, "TARGET", "0 1.5"));
    TEST_ASSERT_EQUAL_DOUBLE(-1.5, target[0]); // All values are set, or none.
}

/// Parameters are found in whatever order they were published.
static void all_parameters_are_found_in_any_order_of_publishing(void)
{
    static char names[64][4];
    static parameter_definition_t many[64];
    static double storage[64];
    uint32_t random = 7U;
    for (unsigned round = 0U; round < 50U; round++) {
        parameter_withdraw_all(&dictionary);
        for (unsigned i = 0U; i < 64U; i++) {
            random           = (random * 1664525U) + 1013904223U;
            const unsigned n = (i * (2U * (round % 32U) + 1U)) % 64U; // A permutation: odd steps.
            names[n][0]      = (char)('A' + (n % 26U));
            names[n][1]      = (char)('A' + (n / 26U));
            many[n]          = (parameter_definition_t){
                         names[n], PARAMETER_ID(APID, VALUE_DOUBLE, 999U - n), &fields[4], 1U, 16U, 16U};
            TEST_ASSERT_EQUAL(STATUS_OK,
                              parameter_publish(&dictionary, &many[n], (round % 2U) ? storage : target));
        }
        const parameter_entry_t* entry = NULL;
        for (unsigned i = 0U; i < 64U; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, parameter_find(&dictionary, many[i].id, &entry));
            TEST_ASSERT_EQUAL_PTR(&many[i], entry->definition);
        }
        TEST_ASSERT_TRUE(parameter_is_consistent(&dictionary));
    }
}

/// Returns the number of entries compared to find each published parameter once.
static uint32_t count_comparisons(void)
{
    uint32_t looks = 0U;
    for (uint16_t i = 0U; i < dictionary.capacity; i++) {
        const uint32_t ids = parameters_of_id(&dictionary, i);
        looks += (ids * (ids + 1U)) / 2U;
    }
    return looks;
}

/// On average at most two comparisons find a parameter, even in a full dictionary.
static void finding_a_parameter_takes_at_most_two_comparisons_on_average(void)
{
    static char names[MANY][24];
    static parameter_definition_t many[MANY];
    static parameter_entry_t many_entries[MANY];
    static parameter_bounds_t many_bounds[MANY];
    static double storage;
    for (uint16_t number = 1U; number <= MANY; number = (uint16_t)((number * 3U / 2U) + 1U)) {
        TEST_ASSERT_EQUAL(STATUS_OK, parameter_init(&dictionary, many_entries, number, many_bounds, number));
        for (uint16_t i = 0U; i < number; i++) {
            (void)snprintf(names[i], sizeof names[i], "JOINT%u.V%u", i / 4U, i % 4U);
            many[i] = (parameter_definition_t){
                names[i], PARAMETER_ID(APID, VALUE_DOUBLE, i), &fields[6], 1U, 8U, 8U};
            TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &many[i], &storage));
        }
        TEST_ASSERT_TRUE(parameter_is_consistent(&dictionary));
        TEST_ASSERT_TRUE(count_comparisons() <= (2U * number));
    }
    setUp();
}

static void publish_with_a_wrong_wire_size(void)
{
    parameter_definition_t wrong = definitions[0];
    wrong.wire_size--;
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &wrong, &values));
}

static void publish_beyond_the_storage(void)
{
    parameter_definition_t wrong = definitions[0];
    wrong.memory_size            = 20U;
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &wrong, &values));
}

static void no_entries(void)
{
    parameter_dictionary_t none;
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_init(&none, entries, 0U, bounds, 1U));
}

static void definitions_that_contradict_themselves_are_coding_errors(void)
{
    TEST_ASSERT_TRUE(assertion_fails(publish_with_a_wrong_wire_size));
    TEST_ASSERT_TRUE(assertion_fails(publish_beyond_the_storage));
    TEST_ASSERT_TRUE(assertion_fails(no_entries));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_id_contains_apid_layout_and_number);
    RUN_TEST(a_structure_is_read_big_endian_without_padding);
    RUN_TEST(parameters_are_found_by_id);
    RUN_TEST(parameters_already_published_or_without_room_are_refused);
    RUN_TEST(a_read_that_does_not_fit_writes_nothing);
    RUN_TEST(an_entry_is_read_without_the_lock);
    RUN_TEST(a_read_during_a_write_is_repeated_under_the_lock);
    RUN_TEST(while_values_change_an_entry_is_read_with_the_lock);
    RUN_TEST(only_settable_parameters_are_written);
    RUN_TEST(a_write_changes_all_fields_or_none);
    RUN_TEST(octets_that_are_no_value_of_the_type_are_refused);
    RUN_TEST(a_structure_that_is_written_back_reads_the_same);
    RUN_TEST(initial_values_are_set_from_text);
    RUN_TEST(all_parameters_are_found_in_any_order_of_publishing);
    RUN_TEST(finding_a_parameter_takes_at_most_two_comparisons_on_average);
    RUN_TEST(definitions_that_contradict_themselves_are_coding_errors);
    return UNITY_END();
}
