// SPDX-License-Identifier: Apache-2.0
// Refusals of a descriptor that is valid, but that this program does not support.
#include "fsw/framework/descriptor/subsystem_descriptor.h"

#include "base/assertion.h"

status_t descriptor_check_interface(text_t* const out_error, const char* const path,
                                    const subsystem_descriptor_t* const descriptor,
                                    const uint64_t compiled_hash)
{
    FSW_ASSERT((out_error != NULL) && (path != NULL) && (descriptor != NULL));
    if (descriptor->interface_hash == compiled_hash) {
        return STATUS_OK;
    }
    text_add(out_error, path);
    text_add(out_error, ":1: interface compiled ");
    text_add_hex(out_error, compiled_hash, 16U);
    text_add(out_error, ", found ");
    text_add_hex(out_error, descriptor->interface_hash, 16U);
    text_add(out_error, ": run make");
    return STATUS_CHECKSUM;
}

status_t descriptor_refuse(text_t* const out_error, const char* const path, const uint32_t line,
                           const char* const says)
{
    FSW_ASSERT((out_error != NULL) && (path != NULL) && (says != NULL));
    text_add_pattern(out_error, "%:#: ", path, NULL, line);
    text_add(out_error, says);
    return STATUS_UNSUPPORTED;
}
