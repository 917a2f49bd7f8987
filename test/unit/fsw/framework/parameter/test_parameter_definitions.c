// SPDX-License-Identifier: Apache-2.0
/// Contradictory definitions are coding errors, and the self-test of a dictionary finds damage.
#include "fsw/framework/parameter/parameter.h"
#include "test/support/assertion.h"
#include "test/support/consistent_parameter.h"

#include "unity.h"

#include <string.h>

static const parameter_field_t fields[]   = {{"LEFT", VALUE_UINT16, 2U, 0U}, {"RIGHT", VALUE_UINT8, 1U, 4U}};
static const parameter_definition_t good  = {"PAIR", PARAMETER_ID(16U, VALUE_STRUCT, 1U), fields, 2U, 6U, 5U};
static const parameter_definition_t other = {"LAST", PARAMETER_ID(16U, VALUE_UINT16, 2U), fields, 1U, 4U, 4U};

static parameter_entry_t entries[4];
static parameter_bounds_t bounds[8];
static parameter_dictionary_t dictionary;
static uint8_t storage[8];
static uint8_t other_storage[8];

static parameter_field_t field;
static parameter_definition_t definition;

void setUp(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_init(&dictionary, entries, 4U, bounds, 8U));
    field      = fields[0];
    definition = (parameter_definition_t){good.name, good.id, &field, 1U, 4U, 4U};
}

void tearDown(void)
{
    TEST_ASSERT_TRUE(parameter_is_consistent(&dictionary));
}

static void publish(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &definition, storage));
}

static void a_definition_agrees_with_its_fields(void)
{
    TEST_ASSERT_FALSE(assertion_fails(publish));
    parameter_withdraw_all(&dictionary);
    field.type = VALUE_STRUCT; // A structure is not a scalar.
    TEST_ASSERT_TRUE(assertion_fails(publish));
    field       = fields[0];
    field.count = 0U;
    TEST_ASSERT_TRUE(assertion_fails(publish));
    field.count = 3U; // More elements than the storage has.
    TEST_ASSERT_TRUE(assertion_fails(publish));
    field        = fields[0];
    field.offset = 1U;
    TEST_ASSERT_TRUE(assertion_fails(publish));
    field                = fields[0];
    definition.wire_size = 5U;
    TEST_ASSERT_TRUE(assertion_fails(publish));
    definition.wire_size   = 0U;
    definition.field_count = 0U;
    TEST_ASSERT_TRUE(assertion_fails(publish));
}

static void a_value_is_written_completely_or_refused(void)
{
    uint8_t octets[16];
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &good, storage));
    for (size_t room = 0U; room < good.wire_size; room++) {
        octet_writer_t writer = octet_writer(octets, room);
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parameter_read(&dictionary, good.id, &writer));
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parameter_read_entry(&dictionary, &entries[0], &writer));
        TEST_ASSERT_EQUAL_UINT64(0U, writer.position);
    }
    octet_writer_t failed = octet_writer(octets, sizeof octets);
    failed.failed         = true;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, parameter_read(&dictionary, good.id, &failed));
    TEST_ASSERT_EQUAL_UINT32((2U * good.wire_size) + 1U, dictionary.refusals.no_room);
}

static void the_self_test_finds_damage(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &good, storage));
    TEST_ASSERT_EQUAL(STATUS_OK, parameter_publish(&dictionary, &other, other_storage));
    parameter_entry_t whole[4];
    memcpy(whole, entries, sizeof whole);
    for (unsigned damage = 0U; damage < 5U; damage++) {
        entries[1].definition = (damage == 0U) ? NULL : entries[1].definition;
        entries[1].storage    = (damage == 1U) ? NULL : entries[1].storage;
        // A list with a link out of range, with a cycle, or without one of its entries.
        entries[1].next_of_id = (damage == 2U) ? 2U : entries[1].next_of_id;
        entries[1].next_of_id = (damage == 3U) ? 1U : entries[1].next_of_id;
        for (unsigned i = 0U; i < 4U; i++) {
            entries[i].first_of_id = (damage == 4U) ? UINT16_MAX : entries[i].first_of_id;
        }
        TEST_ASSERT_FALSE_MESSAGE(parameter_is_consistent(&dictionary), "damage not found");
        memcpy(entries, whole, sizeof whole);
        TEST_ASSERT_TRUE(parameter_is_consistent(&dictionary));
    }
    dictionary.capacity = 1U;
    TEST_ASSERT_FALSE(parameter_is_consistent(&dictionary));
    dictionary.capacity = 4U;
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_definition_agrees_with_its_fields);
    RUN_TEST(a_value_is_written_completely_or_refused);
    RUN_TEST(the_self_test_finds_damage);
    return UNITY_END();
}
