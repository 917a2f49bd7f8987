// SPDX-License-Identifier: Apache-2.0
// The table of the device classes that the descriptors of a program name: each once, no other.
#include "launcher/descriptor_classes.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>

static subsystem_descriptor_t model;
static descriptor_classes_t classes;
static char source[DESCRIPTOR_CLASSES_OCTETS];

void setUp(void)
{
    descriptor_subsystem_clear(&model);
    (void)memset(&classes, 0, sizeof classes);
}

void tearDown(void)
{
}

static void add_device(const char* const type)
{
    model.storage.devices[model.device_count] = (descriptor_device_t){.name = "D", .type = type};
    model.device_count++;
}

static void write(void)
{
    text_t text = text_in(source, sizeof source);
    descriptor_classes_add(&classes, &model);
    descriptor_classes_write(&classes, &text);
    TEST_ASSERT_FALSE(text.cut);
}

/// The line of the table for a class.
static const char* line_of(const char* const type)
{
    static char line[128];
    unsigned position = 0U;
    while (strcmp(canopen_device_profile_at(position)->type, type) != 0) {
        position++;
    }
    (void)snprintf(line, sizeof line, "    DEVICE_CLASS_%u, /* %s */\n", position, type);
    return line;
}

static void expect(const char* const words)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(source, words), source);
}

static void each_class_is_listed_once(void)
{
    add_device("joint-drive");
    write();
    model.device_count = 0U;
    add_device("joint-drive"); // In another mission.
    add_device("gyro");
    add_device("gyro");
    write();
    expect(line_of("gyro"));
    expect(line_of("joint-drive"));
    expect("= {classes, 2U,\n    \"type of <Device>: expected a class that is compiled in: gyro "
           "joint-drive\"};");
    unsigned lines = 0U;
    for (const char* at = strstr(source, "DEVICE_CLASS_"); at != NULL; at = strstr(&at[1], "DEVICE_CLASS_")) {
        lines++;
    }
    TEST_ASSERT_EQUAL_UINT(2U, lines);
}

static void a_type_that_is_no_class_is_left_out(void)
{
    add_device("stream");
    add_device("gyroscope");
    write();
    expect("canopen_device_classes = {NULL, 0U,\n    \"type of <Device>: expected a class that is compiled "
           "in: none\"}");
    TEST_ASSERT_NULL_MESSAGE(strstr(source, "DEVICE_CLASS_"), source);
}

static void all_classes_fit_the_text(void)
{
    for (unsigned i = 0U; i < DEVICE_CLASSES_COUNT; i++) {
        add_device(canopen_device_profile_at(i)->type);
    }
    write();
    for (unsigned i = 0U; i < DEVICE_CLASSES_COUNT; i++) {
        expect(line_of(canopen_device_profile_at(i)->type));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_class_is_listed_once);
    RUN_TEST(a_type_that_is_no_class_is_left_out);
    RUN_TEST(all_classes_fit_the_text);
    return UNITY_END();
}
