// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/device_profile.h"

#include "fsw/canopen/cob.h"
#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

const canopen_device_profile_t* canopen_device_profile_find(const char* const type)
{
    FSW_ASSERT(type != NULL);
    for (size_t i = 0U; i < canopen_device_classes.count; i++) {
        if (strcmp(canopen_device_classes.rows[i].type, type) == 0) {
            return &canopen_device_classes.rows[i];
        }
    }
    return NULL;
}

const canopen_device_profile_t* canopen_device_profile_at(const size_t position)
{
    return (position < canopen_device_classes.count) ? &canopen_device_classes.rows[position] : NULL;
}

uint8_t canopen_device_profile_value(const canopen_device_profile_t* const profile, const uint16_t index,
                                     const uint8_t subindex)
{
    FSW_ASSERT(profile != NULL);
    for (uint8_t i = 0U; i < profile->value_count; i++) {
        if ((profile->values[i].index == index) && (profile->values[i].subindex == subindex)) {
            return i;
        }
    }
    return PROFILE_NO_VALUE;
}

bool canopen_device_profile_is_output(const canopen_device_profile_t* const profile, const uint8_t value)
{
    FSW_ASSERT((profile != NULL) && (value < profile->value_count));
    bool is_output = false;
    for (uint8_t i = 0U; i < profile->receive_count; i++) {
        for (uint8_t k = 0U; k < profile->receive[i].entry_count; k++) {
            const canopen_profile_entry_t* const entry = &profile->receive[i].entries[k];
            is_output = is_output || ((entry->word == PROFILE_VALUE) && (entry->number == value));
        }
    }
    return is_output;
}

uint8_t canopen_device_profile_pdo_octets(const canopen_profile_pdo_t* const pdo)
{
    FSW_ASSERT(pdo != NULL);
    uint8_t octets = 0U;
    for (uint8_t i = 0U; i < pdo->entry_count; i++) {
        octets = (uint8_t)(octets + pdo->entries[i].octets);
    }
    return octets;
}

// ---- Mapping ----

// Four groups of objects: parameters and mappings of receive PDOs, then those of transmit PDOs.
#define PDO_PARAMETERS_FIRST 0x1400U
#define PDO_PARAMETERS_LAST 0x1BFFU
#define PDO_GROUP 0x200U
#define COB_ID 1U
#define BITS 8U

/// Set the number of entries.
static status_t set_count(canopen_profile_pdo_t* const pdo, const uint32_t count)
{
    unsigned octets = 0U;
    if (count > PROFILE_ENTRIES_MAX) {
        return STATUS_TOO_LARGE;
    }
    for (uint32_t i = 0U; i < count; i++) {
        if (pdo->entries[i].octets == 0U) {
            return STATUS_NOT_FOUND;
        }
        octets += pdo->entries[i].octets;
    }
    if (octets > CANOPEN_PDO_OCTETS_MAX) {
        return STATUS_TOO_LARGE;
    }
    pdo->entry_count = (uint8_t)count;
    return STATUS_OK;
}

/// Returns the number of the value of an object. Adds a value if the profile has none for this object.
static uint8_t value_of(canopen_device_profile_t* const profile, const canopen_profile_object_t* const object)
{
    const uint8_t known = canopen_device_profile_value(profile, object->index, object->subindex);
    if ((known != PROFILE_NO_VALUE) || (profile->value_count == PROFILE_VALUES_MAX)) {
        return known;
    }
    profile->values[profile->value_count] = (canopen_profile_value_t){.index     = object->index,
                                                                      .subindex  = object->subindex,
                                                                      .octets    = object->octets,
                                                                      .is_signed = object->is_signed,
                                                                      .is_real   = object->is_real,
                                                                      .scale     = object->scale};
    profile->value_count++;
    return (uint8_t)(profile->value_count - 1U);
}

/// Returns the object with this mapping value (index, subindex, bits); null if the data sheet does not allow
/// it.
static const canopen_profile_object_t* find_object(const canopen_device_profile_t* const profile,
                                                   const uint32_t mapping)
{
    for (uint8_t i = 0U; i < profile->object_count; i++) {
        const canopen_profile_object_t* const object = &profile->objects[i];
        const uint32_t own = ((uint32_t)object->index << 16) | ((uint32_t)object->subindex << 8) |
                             ((uint32_t)object->octets * BITS);
        if (own == mapping) {
            return object;
        }
    }
    return NULL;
}

/// Set entry `number` (1..) of a PDO to the object with this mapping value.
static status_t set_entry(canopen_device_profile_t* const profile, canopen_profile_pdo_t* const pdo,
                          const bool is_transmit, const uint8_t number, const uint32_t mapping)
{
    if (number > PROFILE_ENTRIES_MAX) {
        return STATUS_TOO_LARGE;
    }
    const canopen_profile_object_t* const object = find_object(profile, mapping);
    const canopen_profile_word_t word =
        (object == NULL) ? PROFILE_PADDING : (is_transmit ? object->transmit : object->receive);
    if (word == PROFILE_PADDING) {
        return STATUS_NOT_FOUND;
    }
    const uint8_t value = (word == PROFILE_VALUE) ? value_of(profile, object) : object->axis;
    if (value == PROFILE_NO_VALUE) {
        return STATUS_TOO_LARGE;
    }
    pdo->entries[number - 1U] = (canopen_profile_entry_t){.index    = object->index,
                                                          .subindex = object->subindex,
                                                          .octets   = object->octets,
                                                          .word     = word,
                                                          .number   = value};
    return STATUS_OK;
}

bool canopen_device_profile_is_mapping(const uint16_t index)
{
    return (index >= PDO_PARAMETERS_FIRST) && (index <= PDO_PARAMETERS_LAST) &&
           ((((index - PDO_PARAMETERS_FIRST) / PDO_GROUP) % 2U) == 1U);
}

status_t canopen_device_profile_map(canopen_device_profile_t* const profile, const uint16_t index,
                                    const uint8_t subindex, const uint32_t value)
{
    FSW_ASSERT(profile != NULL);
    if ((index < PDO_PARAMETERS_FIRST) || (index > PDO_PARAMETERS_LAST)) {
        return STATUS_OK;
    }
    const unsigned group             = (index - PDO_PARAMETERS_FIRST) / PDO_GROUP;
    const unsigned number            = (index - PDO_PARAMETERS_FIRST) % PDO_GROUP;
    const bool is_transmit           = group >= 2U;
    const bool is_mapping            = canopen_device_profile_is_mapping(index);
    canopen_profile_pdo_t* const pdo = is_transmit ? profile->transmit : profile->receive;
    if (number >= (is_transmit ? profile->transmit_count : profile->receive_count)) {
        return is_mapping ? STATUS_NOT_FOUND : STATUS_OK;
    }
    if (!is_mapping) {
        pdo[number].is_valid =
            (subindex == COB_ID) ? ((value & COB_PDO_INVALID) == 0U) : pdo[number].is_valid;
        return STATUS_OK;
    }
    // CiA 301: a mapping changes only while its PDO is not valid, its entries only while their number is 0.
    if (pdo[number].is_valid || ((subindex != 0U) && (pdo[number].entry_count != 0U))) {
        return STATUS_FORBIDDEN;
    }
    return (subindex == 0U) ? set_count(&pdo[number], value)
                            : set_entry(profile, &pdo[number], is_transmit, subindex, value);
}
