// SPDX-License-Identifier: Apache-2.0
/// Writes models of descriptors as C sources: lists of constants, and the model that refers to them. The
/// compiler of the target must lay out numbers in structures as the compiler of this program does, because
/// a model contains offsets in generated structures; the source does not compile otherwise.
///
/// Ownership  The caller places the writer.
/// Errors     The first failure of the file is kept in `status`; later calls have no effect.
#ifndef LAUNCHER_DESCRIPTOR_WRITER_H
#define LAUNCHER_DESCRIPTOR_WRITER_H

#include "base/status.h"
#include "base/text.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "osal/include/osal/file.h"

#define DESCRIPTOR_WRITER_OCTETS 16384U

typedef struct { // Private, except `status`.
    osal_file_t* file;
    status_t status;
    text_t text;
    char characters[DESCRIPTOR_WRITER_OCTETS];
} descriptor_writer_t;

/// Begin to write to a file that was created: the checks of the layout.
void descriptor_writer_begin(descriptor_writer_t* writer, osal_file_t* file);
/// Write each word of a list that ends with null.
void descriptor_writer_add(descriptor_writer_t* writer, const char* const* words);
/// Write a model as `subsystem_<number>`; `mission_<number>`: only what a subsystem needs of it.
void descriptor_writer_subsystem(descriptor_writer_t* writer, unsigned number,
                                 const subsystem_descriptor_t* descriptor);
void descriptor_writer_mission(descriptor_writer_t* writer, unsigned number,
                               const mission_descriptor_t* mission);
/// Write what is left. Returns `status`.
MUST_USE status_t descriptor_writer_end(descriptor_writer_t* writer);

#endif // LAUNCHER_DESCRIPTOR_WRITER_H
