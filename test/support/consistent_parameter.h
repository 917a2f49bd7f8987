// SPDX-License-Identifier: Apache-2.0
/// Checks whether a dictionary of parameters is consistent, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_PARAMETER_H
#define TEST_SUPPORT_CONSISTENT_PARAMETER_H

#include "fsw/framework/parameter/parameter.h"

#define PARAMETER_LIST_BROKEN UINT16_MAX

/// Returns the number of entries in the list of one hash of ids (`place`); PARAMETER_LIST_BROKEN if a link is
/// wrong or an id is in the list twice.
static inline uint16_t parameters_of_id(const parameter_dictionary_t* dictionary, uint16_t place)
{
    const parameter_entry_t* const entries = dictionary->entries;
    uint16_t length                        = 0U;
    for (uint16_t i = entries[place].first_of_id; i != UINT16_MAX; i = entries[i].next_of_id) {
        if ((i >= dictionary->count) || (length >= dictionary->count)) {
            return PARAMETER_LIST_BROKEN;
        }
        for (uint16_t k = entries[place].first_of_id; k != i; k = entries[k].next_of_id) {
            if (entries[k].definition->id == entries[i].definition->id) {
                return PARAMETER_LIST_BROKEN;
            }
        }
        length++;
    }
    return length;
}

/// True if every entry has its definition and storage and is in exactly one list of ids.
static inline bool parameter_is_consistent(const parameter_dictionary_t* dictionary)
{
    const parameter_entry_t* const entries = dictionary->entries;
    if (dictionary->count > dictionary->capacity) {
        return false;
    }
    for (uint16_t i = 0U; i < dictionary->count; i++) {
        if ((entries[i].definition == NULL) || (entries[i].storage == NULL)) {
            return false;
        }
    }
    uint32_t ids = 0U;
    for (uint16_t i = 0U; i < dictionary->capacity; i++) {
        ids += parameters_of_id(dictionary, i);
    }
    return ids == dictionary->count;
}

#endif // TEST_SUPPORT_CONSISTENT_PARAMETER_H
