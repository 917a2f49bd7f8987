// SPDX-License-Identifier: Apache-2.0
// The table of all classes: in the order of names, each found by its name, and all named in the refusal.
#include "fsw/canopen/device_profile.h"

#include "unity.h"

#include <string.h>

void setUp(void)
{
}

void tearDown(void)
{
}

static void classes_are_in_the_order_of_names(void)
{
    TEST_ASSERT_EQUAL(DEVICE_CLASSES_COUNT, canopen_device_classes.count);
    TEST_ASSERT_GREATER_THAN(2U, canopen_device_classes.count);
    for (size_t i = 1U; i < canopen_device_classes.count; i++) {
        TEST_ASSERT_LESS_THAN(
            0, strcmp(canopen_device_classes.rows[i - 1U].type, canopen_device_classes.rows[i].type));
    }
}

static void each_class_is_found_by_name_and_position(void)
{
    for (size_t i = 0U; i < canopen_device_classes.count; i++) {
        const canopen_device_profile_t* const class = &canopen_device_classes.rows[i];
        TEST_ASSERT_EQUAL_PTR(class, canopen_device_profile_find(class->type));
        TEST_ASSERT_EQUAL_PTR(class, canopen_device_profile_at(i));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(canopen_device_classes.refusal, class->type), class->type);
    }
}

static void another_name_or_position_has_no_class(void)
{
    TEST_ASSERT_NULL(canopen_device_profile_find("gyroscope"));
    TEST_ASSERT_NULL(canopen_device_profile_find(""));
    TEST_ASSERT_NULL(canopen_device_profile_at(canopen_device_classes.count));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(classes_are_in_the_order_of_names);
    RUN_TEST(each_class_is_found_by_name_and_position);
    RUN_TEST(another_name_or_position_has_no_class);
    return UNITY_END();
}
