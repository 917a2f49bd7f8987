// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/descriptor_files.h"
#include "fsw/programs/executive.h"

static descriptor_files_t storage;

int executive_main(const int argument_count, char* const arguments[], const char* const executable,
                   const component_open_t open, const mission_scope_t* const scope)
{
    const component_descriptors_t descriptors = descriptor_files(&storage, scope);
    return executive_run(argument_count, arguments, executable, open, &descriptors);
}
