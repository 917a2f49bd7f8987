// SPDX-License-Identifier: Apache-2.0
#include "launcher/descriptor_classes.h"

#include "base/assertion.h"

#include <string.h>

void descriptor_classes_add(descriptor_classes_t* const classes,
                            const subsystem_descriptor_t* const subsystem)
{
    FSW_ASSERT((classes != NULL) && (subsystem != NULL));
    FSW_ASSERT(canopen_device_classes.count == DEVICE_CLASSES_COUNT);
    for (uint16_t i = 0U; i < subsystem->device_count; i++) {
        for (unsigned k = 0U; k < DEVICE_CLASSES_COUNT; k++) {
            const char* const name = canopen_device_classes.rows[k].type;
            classes->is_named[k]   = classes->is_named[k] || (strcmp(name, subsystem->devices[i].type) == 0);
        }
    }
}

void descriptor_classes_write(const descriptor_classes_t* const classes, text_t* const text)
{
    FSW_ASSERT((classes != NULL) && (text != NULL));
    unsigned count = 0U;
    text_add(text, "\n/* Device classes that the descriptors name. */\n"
                   "#include \"fsw/canopen/device_profile.h\"\n\n");
    for (unsigned i = 0U; i < DEVICE_CLASSES_COUNT; i++) {
        if (classes->is_named[i]) {
            text_add(text, (count == 0U) ? "static const canopen_device_profile_t classes[] = {\n" : "");
            text_add_pattern(text, "    DEVICE_CLASS_#, /* % */\n", canopen_device_classes.rows[i].type, NULL,
                             i);
            count++;
        }
    }
    text_add(text, (count > 0U) ? "};\n" : "");
    text_add(text, "const canopen_device_classes_t canopen_device_classes = {");
    text_add(text, (count > 0U) ? "classes" : "NULL");
    text_add_pattern(text, ", #U,\n    \"type of <Device>: expected a class that is compiled in:", NULL, NULL,
                     count);
    text_add(text, (count > 0U) ? "" : " none");
    for (unsigned i = 0U; i < DEVICE_CLASSES_COUNT; i++) {
        text_add(text, classes->is_named[i] ? " " : "");
        text_add(text, classes->is_named[i] ? canopen_device_classes.rows[i].type : "");
    }
    text_add(text, "\"};\n");
}
