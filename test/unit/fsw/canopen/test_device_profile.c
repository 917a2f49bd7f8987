// SPDX-License-Identifier: Apache-2.0
// The mapping of process data follows settings in the order of CiA 301, as far as the data sheet allows.
#include "fsw/canopen/device_profile.h"

#include "unity.h"

#define DISABLED 0x80000000U
#define STATUSWORD 0x60410010U
#define POSITION 0x60640020U
#define TORQUE 0x60770010U
#define CONTROLWORD 0x60400010U
#define TORQUE_DEMAND 0x60740010U
#define MODE 0x60600008U
#define VENDOR 0x10180120U

static canopen_device_profile_t own;

void setUp(void)
{
    own = *canopen_device_profile_find("joint-drive");
}

void tearDown(void)
{
}

static status_t map(const uint16_t index, const uint8_t subindex, const uint32_t value)
{
    return canopen_device_profile_map(&own, index, subindex, value);
}

static void disable_transmit_pdo(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1800U, 1U, DISABLED | 0x191U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 0U, 0U));
}

static void entries_become_words_at_their_positions(void)
{
    disable_transmit_pdo();
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 1U, TORQUE));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 2U, POSITION));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 0U, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1800U, 1U, 0x191U));
    TEST_ASSERT_TRUE(own.transmit[0].is_valid);
    TEST_ASSERT_EQUAL_UINT8(2U, own.transmit[0].entry_count);
    TEST_ASSERT_EQUAL(PROFILE_TORQUE, own.transmit[0].entries[0].word);
    TEST_ASSERT_EQUAL(PROFILE_POSITION, own.transmit[0].entries[1].word);
    TEST_ASSERT_EQUAL_UINT8(6U, canopen_device_profile_pdo_octets(&own.transmit[0]));
}

static void a_mapping_must_follow_the_order_of_cia_301(void)
{
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, map(0x1A00U, 0U, 0U)); // The PDO is enabled.
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1800U, 2U, 1U)); // Another entry than the COB-ID does not disable it.
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, map(0x1A00U, 0U, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1800U, 1U, DISABLED | 0x191U));
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, map(0x1A00U, 1U, TORQUE)); // The number of entries is not 0.
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 0U, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 1U, TORQUE));
}

static void an_object_has_its_length_and_direction(void)
{
    disable_transmit_pdo();
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1A00U, 1U, 0x60640010U)); // The length of half a position.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1A00U, 1U, VENDOR));      // The object cannot be mapped.
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1400U, 1U, DISABLED | 0x211U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1600U, 0U, 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1600U, 1U, STATUSWORD)); // Read-only.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1600U, 1U, MODE));       // No cyclic command uses the mode.
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1600U, 1U, CONTROLWORD));
    TEST_ASSERT_EQUAL(PROFILE_CONTROLWORD, own.receive[0].entries[0].word);
}

static void each_object_of_a_data_sheet_is_found_from_the_first_to_the_last(void)
{
    const canopen_profile_object_t* const objects = own.objects;
    const uint8_t count                           = own.object_count;
    disable_transmit_pdo();
    for (uint8_t i = 0U; i < count; i++) {
        const uint32_t mapping = ((uint32_t)objects[i].index << 16U) | ((uint32_t)objects[i].subindex << 8U) |
                                 ((uint32_t)objects[i].octets * 8U);
        own.objects      = &objects[i]; // As first and last object of a data sheet.
        own.object_count = 1U;
        TEST_ASSERT_EQUAL((objects[i].transmit == PROFILE_PADDING) ? STATUS_NOT_FOUND : STATUS_OK,
                          map(0x1A00U, 1U, mapping));
        own.object_count = 0U;
        TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1A00U, 1U, mapping));
    }
}

static void an_object_that_is_not_a_word_of_an_axis_is_a_value(void)
{
    const uint8_t values = own.value_count;
    disable_transmit_pdo();
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 1U, TORQUE_DEMAND));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 2U, TORQUE_DEMAND)); // The value is already known.
    TEST_ASSERT_EQUAL_UINT8(values + 1U, own.value_count);
    TEST_ASSERT_EQUAL(PROFILE_VALUE, own.transmit[0].entries[1].word);
    TEST_ASSERT_EQUAL_UINT8(values, own.transmit[0].entries[1].number);
    TEST_ASSERT_EQUAL_UINT8(values, canopen_device_profile_value(&own, 0x6074U, 0U));
    TEST_ASSERT_TRUE(own.values[values].is_signed);
}

/// The rates of a gyro have one index and the subindices 1 to 3.
static void an_object_is_found_by_its_subindex(void)
{
    own = *canopen_device_profile_find("gyro");
    disable_transmit_pdo();
    for (uint8_t i = 1U; i <= 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 1U, 0x91300020U | ((uint32_t)i << 8)));
        TEST_ASSERT_EQUAL(PROFILE_VALUE, own.transmit[0].entries[0].word);
        TEST_ASSERT_EQUAL_UINT8(i, own.transmit[0].entries[0].subindex);
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1A00U, 1U, 0x91300420U));
}

static void pdos_entries_octets_and_values_are_limited(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1A00U + own.transmit_count, 0U, 0U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1600U + own.receive_count, 0U, 0U));
    // The profile accepts it; the device itself refuses it.
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1800U + own.transmit_count, 1U, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x13FFU, 0U, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1C00U, 0U, 1U));
    disable_transmit_pdo();
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, map(0x1A00U, PROFILE_ENTRIES_MAX + 1U, TORQUE));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, map(0x1A00U, 0U, PROFILE_ENTRIES_MAX + 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, map(0x1A00U, 0U, 4U)); // The fourth entry was never set.
    for (uint8_t i = 1U; i <= 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, i, POSITION));
    }
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, map(0x1A00U, 0U, 3U)); // 12 octets.
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 0U, 2U));
    TEST_ASSERT_EQUAL(STATUS_OK, map(0x1A00U, 0U, 0U));
    own.value_count = PROFILE_VALUES_MAX;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, map(0x1A00U, 1U, TORQUE_DEMAND));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(entries_become_words_at_their_positions);
    RUN_TEST(a_mapping_must_follow_the_order_of_cia_301);
    RUN_TEST(an_object_has_its_length_and_direction);
    RUN_TEST(each_object_of_a_data_sheet_is_found_from_the_first_to_the_last);
    RUN_TEST(an_object_that_is_not_a_word_of_an_axis_is_a_value);
    RUN_TEST(an_object_is_found_by_its_subindex);
    RUN_TEST(pdos_entries_octets_and_values_are_limited);
    return UNITY_END();
}
