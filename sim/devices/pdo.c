// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/pdo.h"

#include "sim/devices/sdo.h"

#include <string.h>

#define RECEIVE_BASE 0x1400U
#define TRANSMIT_BASE 0x1800U
#define MAPPING_OFFSET 0x200U // Distance of the mapping parameters from the communication parameters.
#define COB_ID_BITS 0x1FFFFFFFU
#define NS_PER_MS 1000000U

static uint16_t communication_index(const pdo_t* const pdo)
{
    return (uint16_t)(((pdo->direction == PDO_RECEIVE) ? RECEIVE_BASE : TRANSMIT_BASE) + pdo->number);
}

bool pdo_init(pdo_t* const pdo, const pdo_direction_t direction, const uint16_t number,
              const dictionary_t* const dictionary)
{
    *pdo                   = (pdo_t){.direction = direction, .number = number, .deadline_ns = UINT64_MAX};
    const uint16_t index   = communication_index(pdo);
    const uint16_t mapping = (uint16_t)(index + MAPPING_OFFSET);
    pdo->cob_entry         = dictionary_find(dictionary, index, 1U);
    pdo->type_entry        = dictionary_find(dictionary, index, 2U);
    pdo->event_entry       = dictionary_find(dictionary, index, 5U);
    pdo->start_entry       = (direction == PDO_TRANSMIT) ? dictionary_find(dictionary, index, 6U) : NULL;
    pdo->count_entry       = dictionary_find(dictionary, mapping, 0U);
    for (uint8_t i = 0U; i < PDO_ENTRIES_MAX; i++) {
        pdo->map_entry[i] = dictionary_find(dictionary, mapping, (uint8_t)(i + 1U));
    }
    if ((pdo->cob_entry == NULL) || (pdo->type_entry == NULL) || (pdo->count_entry == NULL)) {
        return false;
    }
    pdo_configure(pdo, dictionary);
    return true;
}

/// Returns the object of a dummy entry, which names a data type instead of an object and skips its octets in
/// a received PDO (CiA 301); null if there is no such type. All PDOs share these objects: nothing reads them.
static object_t* dummy_object(const uint32_t mapping)
{
    static object_t dummy[] = {{.index = OBJECT_INTEGER8, .size = 1U, .is_writable = true},
                               {.index = OBJECT_INTEGER16, .size = 2U, .is_writable = true},
                               {.index = OBJECT_INTEGER32, .size = 4U, .is_writable = true},
                               {.index = OBJECT_UNSIGNED8, .size = 1U, .is_writable = true},
                               {.index = OBJECT_UNSIGNED16, .size = 2U, .is_writable = true},
                               {.index = OBJECT_UNSIGNED32, .size = 4U, .is_writable = true}};
    for (size_t i = 0U; i < (sizeof dummy / sizeof dummy[0]); i++) {
        if (mapping == (((uint32_t)dummy[i].index << 16) | (8U * dummy[i].size))) {
            return &dummy[i];
        }
    }
    return NULL;
}

/// Returns the object of a mapping entry (index 16 bits, sub-index 8 bits, length [bits] 8 bits); null if the
/// device has no such object that can be mapped with this length.
static object_t* mapped_object(const pdo_t* const pdo, const dictionary_t* const dictionary,
                               const uint32_t mapping)
{
    object_t* const dummy = (pdo->direction == PDO_RECEIVE) ? dummy_object(mapping) : NULL;
    if (dummy != NULL) {
        return dummy;
    }
    object_t* object     = dictionary_find(dictionary, (uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8));
    const bool is_usable = (object != NULL) && object->is_mappable && !object_is_text(object) &&
                           ((mapping & 0xFFU) == (8U * object->size));
    return is_usable ? object : NULL;
}

uint8_t pdo_unusable_entry(const pdo_t* const pdo)
{
    uint8_t used =
        0U; // pdo_configure() leaves out entries that it cannot use, and keeps the order of the others.
    while ((used < pdo->entry_count) && (pdo->map_entry[used] != NULL) &&
           (pdo->entry[used]->index == (pdo->map_entry[used]->value >> 16)) &&
           (pdo->entry[used]->subindex == ((pdo->map_entry[used]->value >> 8) & 0xFFU))) {
        used++;
    }
    return (used < pdo->count_entry->value) ? (uint8_t)(used + 1U) : 0U;
}

void pdo_configure(pdo_t* const pdo, const dictionary_t* const dictionary)
{
    const uint32_t cob   = (uint32_t)pdo->cob_entry->value;
    const bool was_valid = pdo->is_valid;
    pdo->cob_id          = cob & COB_ID_BITS;
    pdo->type            = (uint8_t)pdo->type_entry->value;
    pdo->event_ns        = (pdo->event_entry != NULL) ? (pdo->event_entry->value * NS_PER_MS) : 0U;
    pdo->entry_count     = 0U;
    pdo->octets          = 0U;
    for (unsigned i = 0U; (i < pdo->count_entry->value) && (i < PDO_ENTRIES_MAX); i++) {
        object_t* object = (pdo->map_entry[i] != NULL)
                               ? mapped_object(pdo, dictionary, (uint32_t)pdo->map_entry[i]->value)
                               : NULL;
        if ((object != NULL) && ((pdo->octets + object->size) <= PDO_OCTETS_MAX)) {
            pdo->entry[pdo->entry_count] = object;
            pdo->entry_count++;
            pdo->octets = (uint8_t)(pdo->octets + object->size);
        }
    }
    pdo->is_valid = (cob & PDO_INVALID) == 0U;
    if (!pdo->is_valid || !was_valid) {
        pdo->is_pending  = false;
        pdo->sync_count  = 0U;
        pdo->deadline_ns = UINT64_MAX;
    }
    if (pdo->event_ns == 0U) {
        pdo->deadline_ns = UINT64_MAX;
    }
}

bool pdo_owns(const pdo_t* const pdo, const object_t* const object)
{
    const uint16_t index = communication_index(pdo);
    return (object->index == index) || (object->index == (index + MAPPING_OFFSET));
}

static uint32_t check_cob(const pdo_t* const pdo, const uint32_t value)
{
    const uint32_t present = (uint32_t)pdo->cob_entry->value;
    const bool stays_valid = ((present & PDO_INVALID) == 0U) && ((value & PDO_INVALID) == 0U);
    if ((value & PDO_EXTENDED) != 0U) {
        return SDO_ABORT_VALUE;
    }
    if (stays_valid && ((present & COB_ID_BITS) != (value & COB_ID_BITS))) {
        return SDO_ABORT_STATE; // The PDO must be disabled first.
    }
    const uint32_t id        = value & COB_ID_BITS;
    const bool is_restricted = (id <= 0x180U) || (id > 0x57FU); // CiA 301 table of restricted identifiers.
    return (((value & PDO_INVALID) == 0U) && is_restricted) ? SDO_ABORT_VALUE : 0U;
}

static uint32_t check_count(const pdo_t* const pdo, const dictionary_t* const dictionary, const int64_t value)
{
    if ((value < 0) || (value > (int64_t)PDO_ENTRIES_MAX)) {
        return SDO_ABORT_VALUE;
    }
    unsigned octets = 0U;
    for (unsigned i = 0U; i < (unsigned)value; i++) {
        const object_t* object = (pdo->map_entry[i] != NULL)
                                     ? mapped_object(pdo, dictionary, (uint32_t)pdo->map_entry[i]->value)
                                     : NULL;
        if (object == NULL) {
            return SDO_ABORT_NOT_MAPPABLE;
        }
        octets += object->size;
    }
    return (octets > PDO_OCTETS_MAX) ? SDO_ABORT_PDO_LENGTH : 0U;
}

static uint32_t check_mapping(const pdo_t* const pdo, const dictionary_t* const dictionary,
                              const int64_t value)
{
    if (pdo->count_entry->value != 0U) {
        return SDO_ABORT_STATE;
    }
    if (value == 0) {
        return 0U;
    }
    const object_t* object = mapped_object(pdo, dictionary, (uint32_t)value);
    if ((object == NULL) || ((pdo->direction == PDO_RECEIVE) && !object->is_writable)) {
        return SDO_ABORT_NOT_MAPPABLE;
    }
    return 0U;
}

uint32_t pdo_check(const pdo_t* const pdo, const dictionary_t* const dictionary, const object_t* const object,
                   const int64_t value)
{
    const bool is_live = (pdo->cob_entry->value & PDO_INVALID) == 0U;
    if (object == pdo->cob_entry) {
        return check_cob(pdo, (uint32_t)value);
    }
    if (object == pdo->type_entry) {
        const bool is_known =
            (value <= (int64_t)PDO_SYNCHRONOUS_MAX) || (value >= (int64_t)PDO_EVENT_MANUFACTURER);
        return is_known ? 0U : SDO_ABORT_VALUE;
    }
    if (object->index == communication_index(pdo)) {
        const bool is_event_timer = object == pdo->event_entry;
        return (is_live && !is_event_timer) ? SDO_ABORT_STATE : 0U;
    }
    if (is_live) {
        return SDO_ABORT_STATE;
    }
    return (object == pdo->count_entry) ? check_count(pdo, dictionary, value)
                                        : check_mapping(pdo, dictionary, value);
}

bool pdo_pack(pdo_t* const pdo)
{
    uint64_t packed = 0U;
    unsigned bits   = 0U;
    for (unsigned i = 0U; i < pdo->entry_count; i++) {
        packed |= pdo->entry[i]->value << bits;
        bits += 8U * pdo->entry[i]->size;
    }
    bool is_changed = false;
    for (unsigned i = 0U; i < pdo->octets; i++) {
        const uint8_t octet = (uint8_t)(packed >> (8U * i));
        is_changed          = is_changed || (octet != pdo->data[i]);
        pdo->data[i]        = octet;
    }
    return is_changed;
}

void pdo_unpack(pdo_t* const pdo)
{
    const uint8_t* octets = pdo->data;
    for (unsigned i = 0U; i < pdo->entry_count; i++) {
        object_t* object = pdo->entry[i];
        uint64_t value   = 0U;
        for (unsigned k = 0U; k < object->size; k++) {
            value |= (uint64_t)*octets << (8U * k);
            octets++;
        }
        object->value = value;
    }
}
