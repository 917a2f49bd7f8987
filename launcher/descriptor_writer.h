// SPDX-License-Identifier: Apache-2.0
/// Writes models of descriptors as C sources: lists of constants, and the model that refers to them. The
/// models contain offsets of members in generated structures. Therefore the compiler of the target must align
/// numbers in structures as the compiler of this program does; otherwise the written source does not compile.
///
/// Ownership  The caller provides the writer.
/// Errors     The first failure of a write to the file is kept in `status`; later calls have no effect.
#ifndef LAUNCHER_DESCRIPTOR_WRITER_H
#define LAUNCHER_DESCRIPTOR_WRITER_H

#include "base/status.h"
#include "base/text.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "osal/include/osal/file.h"

#define DESCRIPTOR_WRITER_OCTETS 16384U ///< Size of the buffer [octets].

typedef struct { // Private, except `status`.
    osal_file_t* file;
    status_t status;
    text_t text;
    char characters[DESCRIPTOR_WRITER_OCTETS];
} descriptor_writer_t;

/// Begin the source in a file that was created for it: write the checks of the alignment.
void descriptor_writer_begin(descriptor_writer_t* writer, osal_file_t* file);
/// Write each word of a list that ends with null.
void descriptor_writer_add(descriptor_writer_t* writer, const char* const* words);
/// Write a model as the object `subsystem_<number>`, or the members of a mission that a subsystem needs as
/// `mission_<number>`.
void descriptor_writer_subsystem(descriptor_writer_t* writer, unsigned number,
                                 const subsystem_descriptor_t* descriptor);
void descriptor_writer_mission(descriptor_writer_t* writer, unsigned number,
                               const mission_descriptor_t* mission);
/// Write the rest of the buffer. Returns `status`.
MUST_USE status_t descriptor_writer_end(descriptor_writer_t* writer);

#endif // LAUNCHER_DESCRIPTOR_WRITER_H
