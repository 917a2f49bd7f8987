// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/parameter/parameter.h"

#include "base/assertion.h"
#include "base/number.h"

#include <float.h>
#include <string.h>

#define NO_ENTRY UINT16_MAX
#define SPREAD 2654435769U // 2^32 / golden ratio: multiplicative hash of an id.

typedef union { // One scalar of any type, aligned for all types.
    uint64_t u64;
    double f64;
    uint8_t octets[8];
} scalar_t;

static void lock(parameter_dictionary_t* const dictionary)
{
    // STATUS_CLOSED (the owner of the mutex has died) cannot occur: the mutex belongs to this process, and
    // so do all its owners.
    (void)osal_mutex_lock(&dictionary->mutex);
}

static void unlock(parameter_dictionary_t* const dictionary)
{
    osal_mutex_unlock(&dictionary->mutex);
}

/// Lock the mutex, and mark the values for readers without the lock: the sequence counter is odd while the
/// values may be inconsistent.
static void lock_values(parameter_dictionary_t* const dictionary)
{
    lock(dictionary);
    __atomic_store_n(&dictionary->sequence_counter, dictionary->sequence_counter + 1U, __ATOMIC_RELAXED);
    __atomic_thread_fence(__ATOMIC_RELEASE);
}

static void unlock_values(parameter_dictionary_t* const dictionary)
{
    __atomic_store_n(&dictionary->sequence_counter, dictionary->sequence_counter + 1U, __ATOMIC_RELEASE);
    unlock(dictionary);
}

/// Returns the hash of a key: index of one of `capacity` lists. Consecutive keys are distributed over all
/// lists.
static uint16_t bucket_of(const parameter_dictionary_t* const dictionary, const uint32_t key)
{
    const uint32_t spread = key * SPREAD;
    return (uint16_t)(((uint64_t)spread * dictionary->capacity) >> 32U);
}

static parameter_entry_t* entry_of_id(const parameter_dictionary_t* const dictionary, const uint32_t id)
{
    uint16_t index = dictionary->entries[bucket_of(dictionary, id)].first_of_id;
    while ((index != NO_ENTRY) && (dictionary->entries[index].definition->id != id)) {
        index = dictionary->entries[index].next_of_id;
    }
    return (index != NO_ENTRY) ? &dictionary->entries[index] : NULL;
}

/// True if a parameter already has this name. Only publishing compares names; later look-ups use ids.
static bool is_name_taken(const parameter_dictionary_t* const dictionary, const char* const name)
{
    bool is_taken = false;
    for (uint16_t i = 0U; i < dictionary->count; i++) {
        is_taken = is_taken || (strcmp(dictionary->entries[i].definition->name, name) == 0);
    }
    return is_taken;
}

static void forget_all(parameter_dictionary_t* const dictionary)
{
    for (uint16_t i = 0U; i < dictionary->capacity; i++) {
        dictionary->entries[i].first_of_id = NO_ENTRY;
    }
}

status_t parameter_init(parameter_dictionary_t* const dictionary, parameter_entry_t* const entries,
                        const uint16_t capacity, parameter_bounds_t* const bounds,
                        const uint16_t bounds_capacity)
{
    FSW_ASSERT((dictionary != NULL) && (entries != NULL) && (capacity >= 1U) && (bounds != NULL));
    *dictionary = (parameter_dictionary_t){
        .entries = entries, .capacity = capacity, .bounds = bounds, .bounds_capacity = bounds_capacity};
    forget_all(dictionary);
    return osal_mutex_create(&dictionary->mutex, false);
}

/// Insert the new entry at the front of the list of its id's hash.
static void enter(parameter_dictionary_t* const dictionary, parameter_entry_t* const entry)
{
    parameter_entry_t* const of_id = &dictionary->entries[bucket_of(dictionary, entry->definition->id)];
    entry->next_of_id              = of_id->first_of_id;
    of_id->first_of_id             = dictionary->count;
    __atomic_store_n(&dictionary->count, (uint16_t)(dictionary->count + 1U), __ATOMIC_RELAXED);
}

static bool is_well_defined(const parameter_definition_t* const definition)
{
    uint32_t wire = 0U;
    for (uint16_t i = 0U; i < definition->field_count; i++) {
        const parameter_field_t* const field = &definition->fields[i];
        if ((field->type >= VALUE_SCALARS) || (field->count == 0U) ||
            ((field->offset + (value_size(field->type) * field->count)) > definition->memory_size)) {
            return false;
        }
        wire += (uint32_t)(value_size(field->type) * field->count);
    }
    return (definition->field_count >= 1U) && (wire == definition->wire_size);
}

status_t parameter_publish(parameter_dictionary_t* const dictionary,
                           const parameter_definition_t* const definition, void* const storage)
{
    FSW_ASSERT((dictionary != NULL) && (definition != NULL) && (storage != NULL));
    FSW_ASSERT(is_well_defined(definition));
    lock(dictionary);
    status_t status = STATUS_OK;
    if ((entry_of_id(dictionary, definition->id) != NULL) || is_name_taken(dictionary, definition->name)) {
        status = STATUS_EXISTS;
    } else if ((dictionary->count >= dictionary->capacity) ||
               ((dictionary->bounds_capacity - dictionary->bounds_used) < definition->field_count)) {
        dictionary->refusals.no_room++;
        status = STATUS_EXHAUSTED;
    } else {
        parameter_entry_t* const entry = &dictionary->entries[dictionary->count];
        entry->definition              = definition;
        entry->storage                 = storage;
        entry->bounds                  = &dictionary->bounds[dictionary->bounds_used];
        entry->is_settable             = false;
        entry->writes                  = 0U;
        for (uint16_t i = 0U; i < definition->field_count; i++) {
            entry->bounds[i] = (parameter_bounds_t){.min = -DBL_MAX, .max = DBL_MAX};
        }
        dictionary->bounds_used = (uint16_t)(dictionary->bounds_used + definition->field_count);
        enter(dictionary, entry);
    }
    unlock(dictionary);
    return status;
}

void parameter_withdraw_all(parameter_dictionary_t* const dictionary)
{
    FSW_ASSERT(dictionary != NULL);
    lock(dictionary);
    __atomic_store_n(&dictionary->count, 0U, __ATOMIC_RELAXED);
    dictionary->bounds_used = 0U;
    forget_all(dictionary);
    unlock(dictionary);
}

status_t parameter_find(parameter_dictionary_t* const dictionary, const uint32_t id,
                        const parameter_entry_t** const out_entry)
{
    FSW_ASSERT((dictionary != NULL) && (out_entry != NULL));
    lock(dictionary);
    *out_entry = entry_of_id(dictionary, id);
    dictionary->refusals.unknown += (*out_entry == NULL) ? 1U : 0U;
    unlock(dictionary);
    return (*out_entry != NULL) ? STATUS_OK : STATUS_NOT_FOUND;
}

status_t parameter_set_settable(parameter_dictionary_t* const dictionary, const uint32_t id,
                                const bool is_settable)
{
    FSW_ASSERT(dictionary != NULL);
    lock(dictionary);
    parameter_entry_t* const entry = entry_of_id(dictionary, id);
    if (entry != NULL) {
        entry->is_settable = is_settable;
    }
    unlock(dictionary);
    return (entry != NULL) ? STATUS_OK : STATUS_NOT_FOUND;
}

/// Find a parameter with this id and a field of this name; NULL if there is none. Also returns the index of
/// the field.
static const parameter_entry_t* entry_of_field(const parameter_dictionary_t* const dictionary,
                                               const uint32_t id, const char* const name,
                                               uint16_t* const out_index)
{
    const parameter_entry_t* const entry = entry_of_id(dictionary, id);
    for (uint16_t i = 0U; (entry != NULL) && (i < entry->definition->field_count); i++) {
        if (strcmp(entry->definition->fields[i].name, name) == 0) {
            *out_index = i;
            return entry;
        }
    }
    return NULL;
}

status_t parameter_set_bounds(parameter_dictionary_t* const dictionary, const uint32_t id,
                              const char* const field, const double min, const double max)
{
    FSW_ASSERT((dictionary != NULL) && (field != NULL));
    status_t status = STATUS_NOT_FOUND;
    lock(dictionary);
    uint16_t index                       = 0U;
    const parameter_entry_t* const entry = entry_of_field(dictionary, id, field, &index);
    if (entry != NULL) {
        entry->bounds[index] = (parameter_bounds_t){.min = min, .max = max};
        status               = STATUS_OK;
    }
    unlock(dictionary);
    return status;
}

/// True if a scalar is a finite number within its bounds (a NaN fails every comparison).
static bool is_within(const value_type_t type, const scalar_t* const scalar,
                      const parameter_bounds_t* const bounds)
{
    const double value   = value_as_double(type, scalar);
    const bool is_real   = (type == VALUE_FLOAT) || (type == VALUE_DOUBLE);
    const bool is_finite = !is_real || ((value >= -DBL_MAX) && (value <= DBL_MAX));
    return is_finite && (value >= bounds->min) && (value <= bounds->max);
}

/// Check scalar number `number` of field `index`, and store it only if `is_for_real`.
static status_t take_scalar(const parameter_entry_t* const entry, const uint16_t index, const uint16_t number,
                            const scalar_t* const scalar, const bool is_for_real)
{
    const parameter_field_t* const field = &entry->definition->fields[index];
    const size_t size                    = value_size(field->type);
    if (!is_within(field->type, scalar, &entry->bounds[index])) {
        return STATUS_OUT_OF_RANGE;
    }
    if (is_for_real) {
        (void)memcpy((uint8_t*)entry->storage + field->offset + (number * size), scalar, size);
    }
    return STATUS_OK;
}

/// Read the values of one field from text and store them only if `is_for_real`; without text they are zero.
static status_t take_text(const parameter_entry_t* const entry, const uint16_t index, const char* text,
                          const bool is_for_real)
{
    const parameter_field_t* const field = &entry->definition->fields[index];
    if (text == NULL) {
        if (is_for_real) {
            (void)memset((uint8_t*)entry->storage + field->offset, 0, value_size(field->type) * field->count);
        }
        return STATUS_OK;
    }
    for (uint16_t i = 0U; i < field->count; i++) {
        scalar_t scalar = {.u64 = 0U};
        status_t status = number_read_value(&text, field->type, &scalar);
        if (status == STATUS_OK) {
            status = take_scalar(entry, index, i, &scalar, is_for_real);
        }
        if (status != STATUS_OK) {
            return (status == STATUS_OUT_OF_RANGE) ? STATUS_OUT_OF_RANGE : STATUS_INVALID;
        }
    }
    return number_is_end(text) ? STATUS_OK : STATUS_INVALID;
}

status_t parameter_set_initial(parameter_dictionary_t* const dictionary, const uint32_t id,
                               const char* const field, const char* const text)
{
    FSW_ASSERT((dictionary != NULL) && (field != NULL));
    status_t status = STATUS_NOT_FOUND;
    lock_values(dictionary);
    uint16_t index                       = 0U;
    const parameter_entry_t* const entry = entry_of_field(dictionary, id, field, &index);
    if (entry != NULL) {
        status = take_text(entry, index, text, false);
        if (status == STATUS_OK) {
            status = take_text(entry, index, text, true);
        }
    }
    unlock_values(dictionary);
    return status;
}

static bool has_room(const octet_writer_t* const writer, const parameter_entry_t* const entry)
{
    return !writer->failed && ((writer->capacity - writer->position) >= entry->definition->wire_size);
}

/// Write the values after the writer's last octet, without advancing the writer.
static void put_values(const parameter_entry_t* const entry, const octet_writer_t* const writer)
{
    uint8_t* octets = &writer->octets[writer->position];
    for (uint16_t f = 0U; f < entry->definition->field_count; f++) {
        const parameter_field_t* const field = &entry->definition->fields[f];
        octets +=
            value_put(octets, field->type, (const uint8_t*)entry->storage + field->offset, field->count);
    }
}

static status_t encode(const parameter_entry_t* const entry, octet_writer_t* const writer)
{
    if (!has_room(writer, entry)) {
        return STATUS_TOO_LARGE;
    }
    put_values(entry, writer);
    writer->position += entry->definition->wire_size;
    return STATUS_OK;
}

status_t parameter_read(parameter_dictionary_t* const dictionary, const uint32_t id,
                        octet_writer_t* const writer)
{
    FSW_ASSERT((dictionary != NULL) && (writer != NULL));
    lock(dictionary);
    const parameter_entry_t* const entry = entry_of_id(dictionary, id);
    const status_t status                = (entry == NULL) ? STATUS_NOT_FOUND : encode(entry, writer);
    dictionary->refusals.unknown += (status == STATUS_NOT_FOUND) ? 1U : 0U;
    dictionary->refusals.no_room += (status == STATUS_TOO_LARGE) ? 1U : 0U;
    unlock(dictionary);
    return status;
}

#ifdef THREAD_CHECKS
/// In a build with the thread sanitizer every reader takes the lock: the sanitizer would report values that
/// change while they are read without it.
static bool read_unlocked(const parameter_dictionary_t* const dictionary,
                          const parameter_entry_t* const entry, octet_writer_t* const writer)
{
    (void)dictionary;
    (void)entry;
    (void)writer;
    return false;
}
#else
/// Try to read without the lock. False if values changed during the read or do not fit; the writer is then
/// unchanged.
static bool read_unlocked(const parameter_dictionary_t* const dictionary,
                          const parameter_entry_t* const entry, octet_writer_t* const writer)
{
    const uint32_t before = __atomic_load_n(&dictionary->sequence_counter, __ATOMIC_ACQUIRE);
    if (((before % 2U) != 0U) || !has_room(writer, entry)) {
        return false;
    }
    put_values(entry, writer);
    // Read all values before the sequence counter is read again.
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    if (__atomic_load_n(&dictionary->sequence_counter, __ATOMIC_RELAXED) != before) {
        return false;
    }
    writer->position += entry->definition->wire_size;
    return true;
}
#endif

status_t parameter_read_entry(parameter_dictionary_t* const dictionary, const parameter_entry_t* const entry,
                              octet_writer_t* const writer)
{
    FSW_ASSERT((dictionary != NULL) && (entry != NULL) && (writer != NULL));
    FSW_ASSERT((entry >= dictionary->entries) &&
               (entry < &dictionary->entries[__atomic_load_n(&dictionary->count, __ATOMIC_RELAXED)]));
    if (read_unlocked(dictionary, entry, writer)) {
        return STATUS_OK;
    }
    lock(dictionary);
    const status_t status = encode(entry, writer);
    dictionary->refusals.no_room += (status == STATUS_TOO_LARGE) ? 1U : 0U;
    unlock(dictionary);
    return status;
}

/// Decode and check every scalar of a parameter; store them only if `is_for_real`.
static status_t decode(const parameter_entry_t* const entry, octet_reader_t* const reader,
                       const bool is_for_real)
{
    for (uint16_t f = 0U; f < entry->definition->field_count; f++) {
        const parameter_field_t* const field = &entry->definition->fields[f];
        for (uint16_t i = 0U; i < field->count; i++) {
            scalar_t scalar = {.u64 = 0U};
            status_t status = value_decode(reader, field->type, &scalar);
            if (status == STATUS_OK) {
                status = take_scalar(entry, f, i, &scalar, is_for_real);
            }
            if (status != STATUS_OK) {
                return status;
            }
        }
    }
    return STATUS_OK;
}

/// Check whether the next value in the reader may be written; advances the reader.
static status_t check_write(const parameter_entry_t* const entry, octet_reader_t* const reader)
{
    if (entry == NULL) {
        return STATUS_NOT_FOUND;
    }
    return entry->is_settable ? decode(entry, reader, false) : STATUS_READ_ONLY;
}

static void count_refusal(parameter_refusals_t* const refusals, const status_t status)
{
    refusals->unknown += (status == STATUS_NOT_FOUND) ? 1U : 0U;
    refusals->read_only += (status == STATUS_READ_ONLY) ? 1U : 0U;
    refusals->out_of_range += (status == STATUS_OUT_OF_RANGE) ? 1U : 0U;
    refusals->malformed += ((status == STATUS_TRUNCATED) || (status == STATUS_INVALID)) ? 1U : 0U;
}

/// Store a value that check_write has accepted.
static void store(parameter_entry_t* const entry, octet_reader_t* const reader)
{
    const status_t status = decode(entry, reader, true);
    FSW_ASSERT(status == STATUS_OK);
    entry->writes++;
}

status_t parameter_write(parameter_dictionary_t* const dictionary, const uint32_t id,
                         octet_reader_t* const reader)
{
    FSW_ASSERT((dictionary != NULL) && (reader != NULL));
    lock_values(dictionary);
    parameter_entry_t* const entry = entry_of_id(dictionary, id);
    octet_reader_t trial           = *reader;
    const status_t status          = check_write(entry, &trial);
    if (status == STATUS_OK) {
        store(entry, reader);
    }
    count_refusal(&dictionary->refusals, status);
    unlock_values(dictionary);
    return status;
}

void parameter_lock(parameter_dictionary_t* const dictionary)
{
    FSW_ASSERT(dictionary != NULL);
    lock_values(dictionary);
}

void parameter_unlock(parameter_dictionary_t* const dictionary)
{
    FSW_ASSERT(dictionary != NULL);
    unlock_values(dictionary);
}
