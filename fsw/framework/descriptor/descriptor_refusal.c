// SPDX-License-Identifier: Apache-2.0
// Refusals of a descriptor that is valid, but that this program does not support.
#include "fsw/framework/descriptor/mission_descriptor.h"

#include "base/assertion.h"

#include <string.h>

status_t descriptor_check_interface(text_t* const out_error, const char* const path,
                                    const subsystem_descriptor_t* const descriptor,
                                    const uint64_t compiled_hash)
{
    FSW_ASSERT((out_error != NULL) && (path != NULL) && (descriptor != NULL));
    if (descriptor->interface_hash == compiled_hash) {
        return STATUS_OK;
    }
    text_add(out_error, path);
    text_add(out_error, ":1: interface hash: expected ");
    text_add_hex(out_error, compiled_hash, 16U);
    text_add(out_error, " as compiled, found ");
    text_add_hex(out_error, descriptor->interface_hash, 16U);
    text_add(out_error, ": run make");
    return STATUS_CHECKSUM;
}

status_t descriptor_refuse(text_t* const out_error, const char* const path, const uint32_t line,
                           const char* const reason, const uint32_t most)
{
    FSW_ASSERT((out_error != NULL) && (path != NULL) && (reason != NULL));
    text_add_pattern(out_error, "%:#: ", path, NULL, line);
    text_add_pattern(out_error, (most > 0U) ? "too many %, at most #" : "%", reason, NULL, most);
    return STATUS_UNSUPPORTED;
}

status_t descriptor_path_of(text_t* const out_error, const char* const mission_path,
                            const mission_subsystem_t* const subsystem, char* const out_path,
                            const size_t capacity)
{
    FSW_ASSERT((out_error != NULL) && (mission_path != NULL) && (subsystem != NULL) && (out_path != NULL));
    const char* const name  = subsystem->descriptor;
    const char* const slash = strrchr(mission_path, '/');
    text_t path             = text_in(out_path, capacity);
    if ((slash != NULL) && (name[0] != '/')) {
        for (const char* at = mission_path; at <= slash; at++) {
            text_add_character(&path, *at);
        }
    }
    text_add(&path, name);
    if (!path.cut) {
        return STATUS_OK;
    }
    text_add_pattern(out_error, "%:#: descriptor=\"", mission_path, NULL, subsystem->line);
    text_add_pattern(out_error,
                     "%\" of <Subsystem>: expected a path of at most # characters with its directory", name,
                     NULL, capacity - 1U);
    return STATUS_TOO_LARGE;
}
