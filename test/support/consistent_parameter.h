// SPDX-License-Identifier: Apache-2.0
/// Whether a dictionary of parameters agrees with itself, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_PARAMETER_H
#define TEST_SUPPORT_CONSISTENT_PARAMETER_H

#include "fsw/framework/parameter/parameter.h"

#include <string.h>

/// Both orders are complete and sorted, every entry has its definition and storage.
static inline bool parameter_is_consistent(const parameter_dictionary_t* dictionary)
{
    const parameter_entry_t* const entries = dictionary->entries;
    if (dictionary->count > dictionary->capacity) {
        return false;
    }
    for (uint16_t i = 0U; i < dictionary->count; i++) {
        if ((entries[i].definition == NULL) || (entries[i].storage == NULL) ||
            (entries[i].by_id >= dictionary->count) || (entries[i].by_name >= dictionary->count)) {
            return false;
        }
    }
    for (uint16_t i = 1U; i < dictionary->count; i++) { // Strictly sorted, so that none stands twice.
        if ((entries[entries[i - 1U].by_id].definition->id >= entries[entries[i].by_id].definition->id) ||
            (strcmp(entries[entries[i - 1U].by_name].definition->name,
                    entries[entries[i].by_name].definition->name) >= 0)) {
            return false;
        }
    }
    return true;
}

#endif // TEST_SUPPORT_CONSISTENT_PARAMETER_H
