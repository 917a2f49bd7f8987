// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/descriptor_files.h"

#include "base/assertion.h"

static const char* load(void* const context, const run_state_t* const run, const unsigned index,
                        const mission_descriptor_t** const out_mission,
                        subsystem_descriptor_t** const out_own)
{
    descriptor_files_t* const files = (descriptor_files_t*)context;
    *out_mission                    = &files->mission;
    *out_own                        = &files->models[0];
    return (descriptor_load_mission(&files->loader, run->mission_path, run->components[index].apid,
                                    files->scope, &files->mission, &files->models[0]) == STATUS_OK)
               ? NULL
               : descriptor_error(&files->loader);
}

static status_t read_again(void* const context, const char* const path,
                           subsystem_descriptor_t** const out_spare, text_t* const error)
{
    descriptor_files_t* const files = (descriptor_files_t*)context;
    const status_t status           = descriptor_load_subsystem(&files->loader, path, files->spare);
    *out_spare                      = files->spare;
    if (status != STATUS_OK) {
        text_add(error, descriptor_error(&files->loader));
    }
    return status;
}

static void exchange(void* const context, subsystem_descriptor_t* const old)
{
    ((descriptor_files_t*)context)->spare = old;
}

component_descriptors_t descriptor_files(descriptor_files_t* const files, const mission_scope_t* const scope)
{
    FSW_ASSERT(files != NULL);
    descriptor_loader_init(&files->loader);
    files->scope = scope;
    files->spare = &files->models[1];
    return (component_descriptors_t){
        .context = files, .load = load, .read = read_again, .exchange = exchange};
}
