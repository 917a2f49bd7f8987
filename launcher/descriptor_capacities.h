// SPDX-License-Identifier: Apache-2.0
/// Sizes of the static storage of a program whose descriptors are compiled in: for the contents of its
/// descriptors, and for definitions that the ground may add. They are written as macros to a header, which
/// the compiler includes before the sources of this program; each macro replaces a default in the header of a
/// module.
///
/// Ownership  The caller provides the capacities.
#ifndef LAUNCHER_DESCRIPTOR_CAPACITIES_H
#define LAUNCHER_DESCRIPTOR_CAPACITIES_H

#include "base/text.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

#define DESCRIPTOR_CAPACITIES 14U

typedef struct { // Private. All zero: no descriptor.
    uint32_t values[DESCRIPTOR_CAPACITIES];
} descriptor_capacities_t;

/// Add a subsystem of the program, as a mission has it: each size is the largest of all of them.
void descriptor_capacities_add(descriptor_capacities_t* capacities, const subsystem_descriptor_t* subsystem,
                               const mission_descriptor_t* mission);
/// Append the header.
void descriptor_capacities_write(const descriptor_capacities_t* capacities, text_t* text);

#endif // LAUNCHER_DESCRIPTOR_CAPACITIES_H
