// SPDX-License-Identifier: Apache-2.0
// A program that contains one class alone, as a program on a board does: a device of another class is refused
// with the text of its table.
#include "fsw/drives/drives_fitting.h"

#include "fsw/canopen/device_profile.h"
#include "fsw/framework/descriptor/descriptor.h"

#include "unity.h"

#include <string.h>

#define DEVICE(name, type, node)                                                                             \
    "<Device name='" name "' type='" type "'>\n<Setting object='0x6060:00' type='INT8' value='10'/>\n"       \
    "<Endnode type='CAN' bus='robot' node='" node "'/></Device>\n"
#define ARM(devices)                                                                                         \
    "<Subsystem name='ARM' id='16'>\n<Configuration name='C' id='1' priority='1' samplingTime='1ms'>\n"      \
    "<Devices>\n" devices "</Devices></Configuration>\n</Subsystem>"
#define REFUSAL "expected joint-drive"

static const canopen_device_profile_t all[] = {DEVICE_CLASSES};
static canopen_device_profile_t contained[1];
const canopen_device_classes_t canopen_device_classes = {contained, 1U, REFUSAL};

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static subsystem_misfit_t misfit;

void setUp(void)
{
    descriptor_loader_init(&loader);
    for (size_t i = 0U; i < (sizeof all / sizeof all[0]); i++) {
        contained[0] = (strcmp(all[i].type, "joint-drive") == 0) ? all[i] : contained[0];
    }
    misfit = (subsystem_misfit_t){0U, "", 0U};
}

void tearDown(void)
{
}

static bool fits(const char* const document)
{
    static const int modes[]  = {10, 8, 0};
    const drives_need_t joint = {1U, true, "type", 2U, "count", modes, "mode", false};
    TEST_ASSERT_EQUAL_MESSAGE(
        STATUS_OK, descriptor_parse_subsystem(&loader, "arm.xml", document, strlen(document), &descriptor),
        descriptor_error(&loader));
    return drives_fit(&descriptor, &joint, &misfit);
}

static void a_class_that_is_compiled_in_fits(void)
{
    TEST_ASSERT_TRUE_MESSAGE(fits(ARM(DEVICE("A", "joint-drive", "0x11") DEVICE("B", "joint-drive", "0x12"))),
                             misfit.reason);
}

static void another_class_is_refused_and_the_compiled_ones_are_named(void)
{
    TEST_ASSERT_FALSE(fits(ARM(DEVICE("A", "joint-drive", "0x11") DEVICE("B", "gyro", "0x12"))));
    TEST_ASSERT_EQUAL_STRING(REFUSAL, misfit.reason);
    TEST_ASSERT_EQUAL_UINT32(7U, misfit.line);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_class_that_is_compiled_in_fits);
    RUN_TEST(another_class_is_refused_and_the_compiled_ones_are_named);
    return UNITY_END();
}
