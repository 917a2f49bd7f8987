// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/telemetry_cache.h"

#include "base/assertion.h"
#include "base/value.h"

#include <string.h>

#define LAYOUT_SHIFT 16U
#define LAYOUT_MASK 0x1FU
#define HASH_FACTOR 2654435761U // Prime near 2^32 / golden ratio: distributes ids that differ in few bits.
#define HASH_SHIFT 20U          // Leaves 12 bits for TELEMETRY_CACHE_BUCKETS.

enum {
    HOUSEKEEPING_CONTENT = 10,
    DIAGNOSTIC_CONTENT   = 12,
    HOUSEKEEPING_REPORT  = 25,
    DIAGNOSTIC_REPORT    = 26,
    VALUE_REPORT         = 2
};

void supervisor_telemetry_cache_init(telemetry_cache_t* const cache,
                                     const telemetry_cache_sizes_t* const sizes)
{
    FSW_ASSERT((cache != NULL) && (sizes != NULL));
    (void)memset(cache, 0, sizeof *cache);
    cache->sizes = *sizes;
}

// ---- Values ----

static uint32_t bucket_of(const uint32_t id)
{
    return ((uint32_t)(id * HASH_FACTOR) >> HASH_SHIFT) % TELEMETRY_CACHE_BUCKETS;
}

/// Returns the bucket that contains this id, or the free one where it belongs.
static uint32_t bucket_with(const telemetry_cache_t* const cache, const uint32_t id)
{
    uint32_t bucket = bucket_of(id);
    while ((cache->buckets[bucket] != 0U) && (cache->values[cache->buckets[bucket] - 1U].id != id)) {
        bucket = (bucket + 1U) % TELEMETRY_CACHE_BUCKETS;
    }
    return bucket;
}

/// Returns the size of a parameter's value on the wire; 0 if it is unknown.
static uint16_t size_of(const telemetry_cache_t* const cache, const uint32_t id)
{
    const uint32_t layout = (id >> LAYOUT_SHIFT) & LAYOUT_MASK;
    uint16_t size         = 0U;
    if (layout < (uint32_t)VALUE_SCALARS) {
        size = (uint16_t)value_size((value_type_t)layout);
    } else if ((cache->sizes.size_of == NULL) ||
               (cache->sizes.size_of(cache->sizes.context, id, &size) != STATUS_OK)) {
        size = 0U;
    } else {
        // The port has stored the size.
    }
    return size;
}

/// Get the value of a parameter; creates the value if there is none. STATUS_OK, STATUS_NOT_FOUND (its size
/// is not known), STATUS_EXHAUSTED.
static status_t get(telemetry_cache_t* const cache, const uint32_t id, uint16_t* const out_index)
{
    const uint32_t bucket = bucket_with(cache, id);
    if (cache->buckets[bucket] != 0U) {
        *out_index = (uint16_t)(cache->buckets[bucket] - 1U);
        return STATUS_OK;
    }
    const uint16_t size = size_of(cache, id);
    if (size == 0U) {
        return STATUS_NOT_FOUND;
    }
    if ((cache->value_count >= TELEMETRY_CACHE_PARAMETERS) ||
        ((cache->octet_count + size) > TELEMETRY_CACHE_OCTETS)) {
        cache->counters.full++;
        return STATUS_EXHAUSTED;
    }
    *out_index = cache->value_count;
    cache->values[*out_index] =
        (telemetry_cache_value_t){.id = id, .size = size, .offset = cache->octet_count};
    cache->buckets[bucket] = (uint16_t)(*out_index + 1U);
    cache->octet_count += size;
    cache->value_count++;
    return STATUS_OK;
}

/// Store the value at the reader's position. The caller has checked the number of octets.
static void take(telemetry_cache_t* const cache, const uint16_t index, octet_reader_t* const reader,
                 const uint64_t time_ns)
{
    telemetry_cache_value_t* const value = &cache->values[index];
    (void)memcpy(&cache->octets[value->offset], octet_read_octets(reader, value->size), value->size);
    // A further sample of the same report does not change the interval.
    if (value->is_known && (time_ns > value->taken_ns)) {
        value->interval_ns = time_ns - value->taken_ns;
    }
    value->is_known = true;
    value->taken_ns = time_ns;
    cache->counters.taken++;
}

// ---- Definitions ----

static telemetry_cache_structure_t* find_structure(telemetry_cache_t* const cache, const uint16_t apid,
                                                   const uint8_t subtype, const uint16_t id)
{
    for (uint16_t i = 0U; i < cache->structure_count; i++) {
        telemetry_cache_structure_t* const structure = &cache->structures[i];
        if ((structure->apid == apid) && (structure->subtype == subtype) && (structure->id == id)) {
            return structure;
        }
    }
    return NULL;
}

/// Remove a structure, and close the gap in the entries.
static void forget(telemetry_cache_t* const cache, telemetry_cache_structure_t* const structure)
{
    const uint16_t first = structure->first;
    const uint16_t count = structure->count;
    const uint16_t end   = (uint16_t)(first + count);
    (void)memmove(&cache->entries[first], &cache->entries[end],
                  (size_t)(cache->entry_count - end) * sizeof(telemetry_cache_entry_t));
    cache->entry_count = (uint16_t)(cache->entry_count - count);
    cache->structure_count--;
    *structure = cache->structures[cache->structure_count];
    for (uint16_t i = 0U; i < cache->structure_count; i++) {
        if (cache->structures[i].first > first) {
            cache->structures[i].first = (uint16_t)(cache->structures[i].first - count);
        }
    }
}

static status_t add_entry(telemetry_cache_t* const cache, telemetry_cache_structure_t* const structure,
                          const telemetry_cache_entry_t entry)
{
    const uint32_t index = (uint32_t)structure->first + structure->count;
    if (index >= TELEMETRY_CACHE_ENTRIES) {
        cache->counters.full++;
        return STATUS_EXHAUSTED;
    }
    cache->entries[index] = entry;
    structure->count++;
    return STATUS_OK;
}

/// Add a list of parameters; a report has this number of samples of each.
static status_t add_parameters(telemetry_cache_t* const cache, telemetry_cache_structure_t* const structure,
                               octet_reader_t* const content, const uint16_t samples)
{
    const uint16_t count = octet_read_u16(content);
    status_t status      = (samples == 0U) ? STATUS_INVALID : STATUS_OK;
    if (samples > 1U) {
        status =
            add_entry(cache, structure, (telemetry_cache_entry_t){.value = count, .repetitions = samples});
    }
    for (uint16_t i = 0U; (i < count) && (status == STATUS_OK); i++) {
        uint16_t index    = 0U;
        const uint32_t id = octet_read_u32(content);
        status            = content->failed ? STATUS_INVALID : get(cache, id, &index);
        status            = (status == STATUS_NOT_FOUND) ? STATUS_INVALID : status;
        if (status == STATUS_OK) {
            structure->size += (uint32_t)cache->values[index].size * samples;
            status = add_entry(cache, structure, (telemetry_cache_entry_t){.value = index});
        }
    }
    return status;
}

status_t supervisor_telemetry_cache_define(telemetry_cache_t* const cache, const uint16_t apid,
                                           const uint8_t subtype, const uint16_t id,
                                           octet_reader_t* const content)
{
    FSW_ASSERT((cache != NULL) && (content != NULL));
    telemetry_cache_structure_t* const known = find_structure(cache, apid, subtype, id);
    if (known != NULL) {
        forget(cache, known);
    }
    if (cache->structure_count >= TELEMETRY_CACHE_STRUCTURES) {
        cache->counters.full++;
        return STATUS_EXHAUSTED;
    }
    telemetry_cache_structure_t structure = {
        .apid = apid, .subtype = subtype, .id = id, .first = cache->entry_count};
    status_t status     = add_parameters(cache, &structure, content, 1U);
    const uint16_t sets = (status == STATUS_OK) ? octet_read_u16(content) : 0U;
    for (uint16_t i = 0U; (i < sets) && (status == STATUS_OK); i++) {
        const uint16_t repetitions = octet_read_u16(content);
        status                     = add_parameters(cache, &structure, content, repetitions);
    }
    if ((status == STATUS_OK) && !octet_reader_is_done(content)) {
        status = STATUS_INVALID;
    }
    if (status == STATUS_OK) {
        cache->structures[cache->structure_count] = structure;
        cache->structure_count++;
        cache->entry_count = (uint16_t)(cache->entry_count + structure.count);
    }
    return status;
}

// ---- Reports ----

/// Store the values of a report, which are in the order of the structure's definition; sets are reported
/// sample by sample.
static void take_structure(telemetry_cache_t* const cache, const telemetry_cache_structure_t* const structure,
                           octet_reader_t* const reader, const uint64_t time_ns)
{
    uint16_t i = 0U;
    while (i < structure->count) {
        const telemetry_cache_entry_t* const entry = &cache->entries[structure->first + i];
        const bool is_set                          = entry->repetitions > 0U;
        const uint16_t samples                     = is_set ? entry->repetitions : 1U;
        const uint16_t parameters                  = is_set ? entry->value : 1U;
        i                                          = (uint16_t)(i + (is_set ? 1U : 0U));
        for (uint16_t sample = 0U; sample < samples; sample++) {
            for (uint16_t k = 0U; k < parameters; k++) {
                take(cache, cache->entries[structure->first + i + k].value, reader, time_ns);
            }
        }
        i = (uint16_t)(i + parameters);
    }
}

static void observe_structure(telemetry_cache_t* const cache, const pus_tm_t* const tm)
{
    octet_reader_t reader                              = octet_reader(tm->data, tm->size);
    const uint16_t id                                  = octet_read_u16(&reader);
    const telemetry_cache_structure_t* const structure = find_structure(cache, tm->apid, tm->subtype, id);
    if (structure == NULL) {
        return;
    }
    if (octet_reader_left(&reader) == structure->size) {
        take_structure(cache, structure, &reader, tm->time_ns);
    } else {
        cache->counters.unfitting++;
    }
}

static void observe_definition(telemetry_cache_t* const cache, const pus_tm_t* const tm)
{
    const uint8_t subtype =
        (uint8_t)((tm->subtype == (uint8_t)HOUSEKEEPING_CONTENT) ? HOUSEKEEPING_REPORT : DIAGNOSTIC_REPORT);
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    const uint16_t id     = octet_read_u16(&reader);
    (void)octet_read_u8(&reader);  // Periodic generation flag: not needed.
    (void)octet_read_u32(&reader); // Collection interval: not needed.
    if (supervisor_telemetry_cache_define(cache, tm->apid, subtype, id, &reader) == STATUS_INVALID) {
        cache->counters.unfitting++;
    }
}

static void observe_values(telemetry_cache_t* const cache, const pus_tm_t* const tm)
{
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    const uint16_t count  = octet_read_u16(&reader);
    for (uint16_t i = 0U; i < count; i++) {
        uint16_t index    = 0U;
        const uint32_t id = octet_read_u32(&reader);
        if (reader.failed || (get(cache, id, &index) != STATUS_OK) ||
            (octet_reader_left(&reader) < cache->values[index].size)) {
            cache->counters.unfitting++;
            return;
        }
        take(cache, index, &reader, tm->time_ns);
    }
}

void supervisor_telemetry_cache_observe(telemetry_cache_t* const cache, const pus_tm_t* const tm)
{
    FSW_ASSERT((cache != NULL) && (tm != NULL));
    if (tm->service == PUS_SERVICE_HOUSEKEEPING) {
        switch (tm->subtype) {
        case HOUSEKEEPING_REPORT:
        case DIAGNOSTIC_REPORT:
            observe_structure(cache, tm);
            break;
        case HOUSEKEEPING_CONTENT:
        case DIAGNOSTIC_CONTENT:
            observe_definition(cache, tm);
            break;
        default: // Other reports contain neither values nor a definition.
            break;
        }
    } else if ((tm->service == PUS_SERVICE_PARAMETERS) && (tm->subtype == (uint8_t)VALUE_REPORT)) {
        observe_values(cache, tm);
    } else {
        // The cache evaluates no other reports.
    }
}

// ---- Port ----

static status_t find(void* const context, const uint32_t parameter_id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    telemetry_cache_t* const cache = context;
    if (get(cache, parameter_id, out_handle) != STATUS_OK) {
        return STATUS_NOT_FOUND;
    }
    *out_size = cache->values[*out_handle].size;
    return STATUS_OK;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    const telemetry_cache_t* const cache       = context;
    const telemetry_cache_value_t* const value = &cache->values[handle];
    octet_write_octets(writer, &cache->octets[value->offset], value->size);
}

pus_parameter_port_t supervisor_telemetry_cache_port(telemetry_cache_t* const cache)
{
    FSW_ASSERT(cache != NULL);
    return (pus_parameter_port_t){.context = cache, .find = find, .read = read};
}

/// Returns the value of a parameter; null if it is not known.
static const telemetry_cache_value_t* find_value(const telemetry_cache_t* const cache,
                                                 const uint32_t parameter_id)
{
    const uint16_t found = cache->buckets[bucket_with(cache, parameter_id)];
    return (found == 0U) ? NULL : &cache->values[found - 1U];
}

bool supervisor_telemetry_cache_is_old(const telemetry_cache_t* const cache, const uint32_t parameter_id,
                                       const uint64_t now_ns)
{
    FSW_ASSERT(cache != NULL);
    const telemetry_cache_value_t* const value = find_value(cache, parameter_id);
    if ((value == NULL) || (value->interval_ns == 0U) || (now_ns <= value->taken_ns)) {
        return false;
    }
    const uint64_t age_ns = now_ns - value->taken_ns;
    return (age_ns > TELEMETRY_CACHE_AGE_MIN_NS) &&
           ((age_ns / TELEMETRY_CACHE_INTERVALS) > value->interval_ns);
}

status_t supervisor_telemetry_cache_value(const telemetry_cache_t* const cache, const uint32_t parameter_id,
                                          const uint8_t** const out_octets, uint16_t* const out_size)
{
    FSW_ASSERT((cache != NULL) && (out_octets != NULL) && (out_size != NULL));
    const telemetry_cache_value_t* const value = find_value(cache, parameter_id);
    if (value == NULL) {
        return STATUS_NOT_FOUND;
    }
    *out_octets = &cache->octets[value->offset];
    *out_size   = value->size;
    return value->is_known ? STATUS_OK : STATUS_EMPTY;
}
