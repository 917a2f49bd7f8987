// SPDX-License-Identifier: Apache-2.0
/// Descriptors that were compiled into a program for a target that has neither files of descriptors nor a
/// parser of XML. The program descriptor-compiler writes the constants; it reads the files as a program on
/// Linux does. A program contains the descriptors of each mission that has a subsystem of this program. The
/// configuration hash of the mission, which covers all its descriptors, selects the mission; a run with
/// another hash is refused.
///
/// Ownership  The generated source provides everything (static).
/// Context    One task.
#ifndef FSW_PROGRAMS_COMPILED_DESCRIPTORS_H
#define FSW_PROGRAMS_COMPILED_DESCRIPTORS_H

#include "fsw/programs/component_runtime.h"

typedef struct {           // A subsystem of this program in one mission.
    uint64_t mission_hash; ///< Configuration hash of the whole mission.
    uint16_t apid;
    const mission_descriptor_t* mission; ///< The mission as a subsystem reads it: its hashes are 0.
    subsystem_descriptor_t* own;
} compiled_descriptor_t;

typedef struct { // Private, except `entries` and `count`, which are set before the first call.
    const compiled_descriptor_t* entries;
    size_t count;
    char error[DESCRIPTOR_ERROR_CHARACTERS];
} compiled_descriptors_t;

/// Returns the access to the descriptors. They cannot be read again: a reload is STATUS_UNSUPPORTED.
component_descriptors_t compiled_descriptors(compiled_descriptors_t* compiled);
/// Returns the descriptors of the program, in the generated source.
compiled_descriptors_t* compiled_descriptors_of_program(void);

#endif // FSW_PROGRAMS_COMPILED_DESCRIPTORS_H
