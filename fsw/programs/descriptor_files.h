// SPDX-License-Identifier: Apache-2.0
/// Descriptors of a program that reads them from files.
///
/// Ownership  The caller provides descriptor_files_t (static).
/// Context    One task.
#ifndef FSW_PROGRAMS_DESCRIPTOR_FILES_H
#define FSW_PROGRAMS_DESCRIPTOR_FILES_H

#include "fsw/programs/component_runtime.h"
#include "fsw/framework/descriptor/descriptor.h"

typedef struct { // Private. All components of a program use it, one after the other.
    descriptor_loader_t loader;
    const mission_scope_t* scope;
    mission_descriptor_t mission;
    subsystem_descriptor_t models[2]; // The model in use, and the spare one for a reloaded descriptor.
    subsystem_descriptor_t* spare;
} descriptor_files_t;

/// Returns the access to the descriptors. `scope`: how much of a mission is read (descriptor.h).
component_descriptors_t descriptor_files(descriptor_files_t* files, const mission_scope_t* scope);

#endif // FSW_PROGRAMS_DESCRIPTOR_FILES_H
