// SPDX-License-Identifier: Apache-2.0
/// Device classes that the descriptors of a program name. A program whose descriptors are compiled in
/// contains only these classes, in a table that replaces fsw/canopen/device_classes.c.
///
/// Ownership  The caller provides the set.
#ifndef LAUNCHER_DESCRIPTOR_CLASSES_H
#define LAUNCHER_DESCRIPTOR_CLASSES_H

#include "base/text.h"
#include "fsw/canopen/device_profile.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

/// Room for the text of descriptor_classes_write, with names of up to 32 characters.
#define DESCRIPTOR_CLASSES_OCTETS (1024U + (128U * DEVICE_CLASSES_COUNT))

typedef struct { // Private. All false: no class.
    bool is_named[DEVICE_CLASSES_COUNT];
} descriptor_classes_t;

/// Add the classes of all devices of a subsystem. A type that is not a class is ignored: the program refuses
/// the descriptor when it starts, as on Linux.
void descriptor_classes_add(descriptor_classes_t* classes, const subsystem_descriptor_t* subsystem);
/// Append the table as C source.
void descriptor_classes_write(const descriptor_classes_t* classes, text_t* text);

#endif // LAUNCHER_DESCRIPTOR_CLASSES_H
