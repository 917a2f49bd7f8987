// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/compiled_descriptors.h"

#include "base/assertion.h"
#include "base/text.h"

/// Write that the program has no descriptors for this component of the run. The list is last, because a text
/// that is too long is cut at its end.
static const char* refuse(compiled_descriptors_t* const compiled, const run_state_t* const run,
                          const unsigned index)
{
    text_t text = text_in(compiled->error, sizeof compiled->error);
    text_add(&text, run->mission_path);
    text_add(&text, ": hash ");
    text_add_hex(&text, run->mission_hash, 16U);
    text_add(&text, ": run `make rtos` to build the program of ");
    text_add(&text, run->components[index].name);
    text_add(&text, ", which was compiled for");
    for (size_t i = 0U; i < compiled->count; i++) {
        text_add(&text, (i > 0U) ? ", " : " ");
        text_add(&text, compiled->entries[i].mission->name);
        text_add(&text, " ");
        text_add_hex(&text, compiled->entries[i].mission_hash, 16U);
    }
    return compiled->error;
}

static const char* load(void* const context, const run_state_t* const run, const unsigned index,
                        const mission_descriptor_t** const out_mission,
                        subsystem_descriptor_t** const out_own)
{
    compiled_descriptors_t* const compiled = (compiled_descriptors_t*)context;
    for (size_t i = 0U; i < compiled->count; i++) {
        const compiled_descriptor_t* const one = &compiled->entries[i];
        if ((one->mission_hash == run->mission_hash) && (one->apid == run->components[index].apid)) {
            *out_mission = one->mission;
            *out_own     = one->own;
            return NULL;
        }
    }
    return refuse(compiled, run, index);
}

static status_t refuse_to_read(void* const context, const char* const path,
                               subsystem_descriptor_t** const out_spare, text_t* const error)
{
    (void)context;
    *out_spare = NULL;
    text_add(error, path);
    text_add(error, ":1: the descriptor is compiled into the program; run `make rtos`");
    return STATUS_UNSUPPORTED;
}

static void exchange(void* const context, subsystem_descriptor_t* const old)
{
    (void)context;
    (void)old;
    FSW_ASSERT(false); // No descriptor has been read.
}

component_descriptors_t compiled_descriptors(compiled_descriptors_t* const compiled)
{
    FSW_ASSERT((compiled != NULL) && (compiled->entries != NULL));
    return (component_descriptors_t){
        .context = compiled, .load = load, .read = refuse_to_read, .exchange = exchange};
}
