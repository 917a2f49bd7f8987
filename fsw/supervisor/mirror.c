// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/mirror.h"

#include "base/assertion.h"
#include "base/value.h"

#include <string.h>

#define LAYOUT_SHIFT 16U
#define LAYOUT_MASK 0x1FU
#define HASH_FACTOR 2654435761U // 2^32 / golden ratio: spreads ids that differ in few bits.
#define HASH_SHIFT 20U          // 12 bits for MIRROR_BUCKETS.

enum {
    HOUSEKEEPING_CONTENT = 10,
    DIAGNOSTIC_CONTENT   = 12,
    HOUSEKEEPING_REPORT  = 25,
    DIAGNOSTIC_REPORT    = 26,
    VALUE_REPORT         = 2
};

void mirror_init(mirror_t* const mirror, const mirror_sizes_t* const sizes)
{
    FSW_ASSERT((mirror != NULL) && (sizes != NULL));
    (void)memset(mirror, 0, sizeof(*mirror));
    mirror->sizes = *sizes;
}

// ---- Values ----

static uint32_t bucket_of(const uint32_t id)
{
    return ((uint32_t)(id * HASH_FACTOR) >> HASH_SHIFT) % MIRROR_BUCKETS;
}

/// The bucket that has this id, or the free one where it would be.
static uint32_t place_of(const mirror_t* const mirror, const uint32_t id)
{
    uint32_t bucket = bucket_of(id);
    while ((mirror->buckets[bucket] != 0U) && (mirror->values[mirror->buckets[bucket] - 1U].id != id)) {
        bucket = (bucket + 1U) % MIRROR_BUCKETS;
    }
    return bucket;
}

/// Size of a parameter's value on the wire; 0 if unknown.
static uint16_t size_of(const mirror_t* const mirror, const uint32_t id)
{
    const uint32_t layout = (id >> LAYOUT_SHIFT) & LAYOUT_MASK;
    uint16_t size         = 0U;
    if (layout < (uint32_t)VALUE_SCALARS) {
        size = (uint16_t)value_size((value_type_t)layout);
    } else if ((mirror->sizes.size_of == NULL) ||
               (mirror->sizes.size_of(mirror->sizes.context, id, &size) != STATUS_OK)) {
        size = 0U;
    } else {
        // Told.
    }
    return size;
}

/// The value of a parameter, which gets a place if it has none. STATUS_OK, STATUS_NOT_FOUND (its size is not
/// known), STATUS_EXHAUSTED.
static status_t get(mirror_t* const mirror, const uint32_t id, uint16_t* const out_index)
{
    const uint32_t bucket = place_of(mirror, id);
    if (mirror->buckets[bucket] != 0U) {
        *out_index = (uint16_t)(mirror->buckets[bucket] - 1U);
        return STATUS_OK;
    }
    const uint16_t size = size_of(mirror, id);
    if (size == 0U) {
        return STATUS_NOT_FOUND;
    }
    if ((mirror->value_count >= MIRROR_PARAMETERS) || ((mirror->octet_count + size) > MIRROR_OCTETS)) {
        mirror->counters.full++;
        return STATUS_EXHAUSTED;
    }
    *out_index                 = mirror->value_count;
    mirror->values[*out_index] = (mirror_value_t){.id = id, .size = size, .offset = mirror->octet_count};
    mirror->buckets[bucket]    = (uint16_t)(*out_index + 1U);
    mirror->octet_count += size;
    mirror->value_count++;
    return STATUS_OK;
}

/// Take a value that is at the reader's position; there are enough octets.
static void take(mirror_t* const mirror, const uint16_t index, octet_reader_t* const reader,
                 const uint64_t time_ns)
{
    mirror_value_t* const value = &mirror->values[index];
    (void)memcpy(&mirror->octets[value->offset], octet_read_octets(reader, value->size), value->size);
    if (value->is_known && (time_ns > value->taken_ns)) { // Not a further sample of the same report.
        value->interval_ns = time_ns - value->taken_ns;
    }
    value->is_known = true;
    value->taken_ns = time_ns;
    mirror->counters.taken++;
}

// ---- Definitions ----

static mirror_structure_t* find_structure(mirror_t* const mirror, const uint16_t apid, const uint8_t subtype,
                                          const uint16_t id)
{
    for (uint16_t i = 0U; i < mirror->structure_count; i++) {
        mirror_structure_t* const structure = &mirror->structures[i];
        if ((structure->apid == apid) && (structure->subtype == subtype) && (structure->id == id)) {
            return structure;
        }
    }
    return NULL;
}

/// Forget a structure and close the gap in the entries.
static void forget(mirror_t* const mirror, mirror_structure_t* const structure)
{
    const uint16_t first = structure->first;
    const uint16_t count = structure->count;
    const uint16_t end   = (uint16_t)(first + count);
    (void)memmove(&mirror->entries[first], &mirror->entries[end],
                  (size_t)(mirror->entry_count - end) * sizeof(mirror_entry_t));
    mirror->entry_count = (uint16_t)(mirror->entry_count - count);
    mirror->structure_count--;
    *structure = mirror->structures[mirror->structure_count];
    for (uint16_t i = 0U; i < mirror->structure_count; i++) {
        if (mirror->structures[i].first > first) {
            mirror->structures[i].first = (uint16_t)(mirror->structures[i].first - count);
        }
    }
}

static status_t add_entry(mirror_t* const mirror, mirror_structure_t* const structure,
                          const mirror_entry_t entry)
{
    const uint32_t place = (uint32_t)structure->first + structure->count;
    if (place >= MIRROR_ENTRIES) {
        mirror->counters.full++;
        return STATUS_EXHAUSTED;
    }
    mirror->entries[place] = entry;
    structure->count++;
    return STATUS_OK;
}

/// Add a list of parameters; a report has this number of samples of each.
static status_t add_parameters(mirror_t* const mirror, mirror_structure_t* const structure,
                               octet_reader_t* const content, const uint16_t samples)
{
    const uint16_t count = octet_read_u16(content);
    status_t status      = (samples == 0U) ? STATUS_INVALID : STATUS_OK;
    if (samples > 1U) {
        status = add_entry(mirror, structure, (mirror_entry_t){.value = count, .repetitions = samples});
    }
    for (uint16_t i = 0U; (i < count) && (status == STATUS_OK); i++) {
        uint16_t index    = 0U;
        const uint32_t id = octet_read_u32(content);
        status            = content->failed ? STATUS_INVALID : get(mirror, id, &index);
        status            = (status == STATUS_NOT_FOUND) ? STATUS_INVALID : status;
        if (status == STATUS_OK) {
            structure->size += (uint32_t)mirror->values[index].size * samples;
            status = add_entry(mirror, structure, (mirror_entry_t){.value = index});
        }
    }
    return status;
}

status_t mirror_define(mirror_t* const mirror, const uint16_t apid, const uint8_t subtype, const uint16_t id,
                       octet_reader_t* const content)
{
    FSW_ASSERT((mirror != NULL) && (content != NULL));
    mirror_structure_t* const known = find_structure(mirror, apid, subtype, id);
    if (known != NULL) {
        forget(mirror, known);
    }
    if (mirror->structure_count >= MIRROR_STRUCTURES) {
        mirror->counters.full++;
        return STATUS_EXHAUSTED;
    }
    mirror_structure_t structure = {.apid = apid, .subtype = subtype, .id = id, .first = mirror->entry_count};
    status_t status              = add_parameters(mirror, &structure, content, 1U);
    const uint16_t sets          = (status == STATUS_OK) ? octet_read_u16(content) : 0U;
    for (uint16_t i = 0U; (i < sets) && (status == STATUS_OK); i++) {
        const uint16_t repetitions = octet_read_u16(content);
        status                     = add_parameters(mirror, &structure, content, repetitions);
    }
    if ((status == STATUS_OK) && !octet_reader_is_done(content)) {
        status = STATUS_INVALID;
    }
    if (status == STATUS_OK) {
        mirror->structures[mirror->structure_count] = structure;
        mirror->structure_count++;
        mirror->entry_count = (uint16_t)(mirror->entry_count + structure.count);
    }
    return status;
}

// ---- Reports ----

/// Values of a structure, in the order of its definition; sets sample by sample.
static void take_structure(mirror_t* const mirror, const mirror_structure_t* const structure,
                           octet_reader_t* const reader, const uint64_t time_ns)
{
    uint16_t i = 0U;
    while (i < structure->count) {
        const mirror_entry_t* const entry = &mirror->entries[structure->first + i];
        const bool is_set                 = entry->repetitions > 0U;
        const uint16_t samples            = is_set ? entry->repetitions : 1U;
        const uint16_t parameters         = is_set ? entry->value : 1U;
        i                                 = (uint16_t)(i + (is_set ? 1U : 0U));
        for (uint16_t sample = 0U; sample < samples; sample++) {
            for (uint16_t k = 0U; k < parameters; k++) {
                take(mirror, mirror->entries[structure->first + i + k].value, reader, time_ns);
            }
        }
        i = (uint16_t)(i + parameters);
    }
}

static void observe_structure(mirror_t* const mirror, const pus_tm_t* const tm)
{
    octet_reader_t reader                     = octet_reader(tm->data, tm->size);
    const uint16_t id                         = octet_read_u16(&reader);
    const mirror_structure_t* const structure = find_structure(mirror, tm->apid, tm->subtype, id);
    if (structure == NULL) {
        return;
    }
    if (octet_reader_left(&reader) == structure->size) {
        take_structure(mirror, structure, &reader, tm->time_ns);
    } else {
        mirror->counters.unfitting++;
    }
}

static void observe_definition(mirror_t* const mirror, const pus_tm_t* const tm)
{
    const uint8_t subtype =
        (uint8_t)((tm->subtype == (uint8_t)HOUSEKEEPING_CONTENT) ? HOUSEKEEPING_REPORT : DIAGNOSTIC_REPORT);
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    const uint16_t id     = octet_read_u16(&reader);
    (void)octet_read_u8(&reader);  // Periodic or not,
    (void)octet_read_u32(&reader); // and how often, is not needed.
    if (mirror_define(mirror, tm->apid, subtype, id, &reader) == STATUS_INVALID) {
        mirror->counters.unfitting++;
    }
}

static void observe_values(mirror_t* const mirror, const pus_tm_t* const tm)
{
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    const uint16_t count  = octet_read_u16(&reader);
    for (uint16_t i = 0U; i < count; i++) {
        uint16_t index    = 0U;
        const uint32_t id = octet_read_u32(&reader);
        if (reader.failed || (get(mirror, id, &index) != STATUS_OK) ||
            (octet_reader_left(&reader) < mirror->values[index].size)) {
            mirror->counters.unfitting++;
            return;
        }
        take(mirror, index, &reader, tm->time_ns);
    }
}

void mirror_observe(mirror_t* const mirror, const pus_tm_t* const tm)
{
    FSW_ASSERT((mirror != NULL) && (tm != NULL));
    if (tm->service == PUS_SERVICE_HOUSEKEEPING) {
        switch (tm->subtype) {
        case HOUSEKEEPING_REPORT:
        case DIAGNOSTIC_REPORT:
            observe_structure(mirror, tm);
            break;
        case HOUSEKEEPING_CONTENT:
        case DIAGNOSTIC_CONTENT:
            observe_definition(mirror, tm);
            break;
        default: // No values, no definition.
            break;
        }
    } else if ((tm->service == PUS_SERVICE_PARAMETERS) && (tm->subtype == (uint8_t)VALUE_REPORT)) {
        observe_values(mirror, tm);
    } else {
        // Nothing of interest.
    }
}

// ---- Port ----

static status_t find(void* const context, const uint32_t parameter_id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    mirror_t* const mirror = context;
    if (get(mirror, parameter_id, out_handle) != STATUS_OK) {
        return STATUS_NOT_FOUND;
    }
    *out_size = mirror->values[*out_handle].size;
    return STATUS_OK;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    const mirror_t* const mirror      = context;
    const mirror_value_t* const value = &mirror->values[handle];
    octet_write_octets(writer, &mirror->octets[value->offset], value->size);
}

pus_parameter_port_t mirror_port(mirror_t* const mirror)
{
    FSW_ASSERT(mirror != NULL);
    return (pus_parameter_port_t){.context = mirror, .find = find, .read = read};
}

/// The value of a parameter; null if it is not known.
static const mirror_value_t* find_value(const mirror_t* const mirror, const uint32_t parameter_id)
{
    const uint16_t found = mirror->buckets[place_of(mirror, parameter_id)];
    return (found == 0U) ? NULL : &mirror->values[found - 1U];
}

bool mirror_is_old(const mirror_t* const mirror, const uint32_t parameter_id, const uint64_t now_ns)
{
    FSW_ASSERT(mirror != NULL);
    const mirror_value_t* const value = find_value(mirror, parameter_id);
    if ((value == NULL) || (value->interval_ns == 0U) || (now_ns <= value->taken_ns)) {
        return false;
    }
    const uint64_t age_ns = now_ns - value->taken_ns;
    return (age_ns > MIRROR_AGE_MIN_NS) && ((age_ns / MIRROR_INTERVALS) > value->interval_ns);
}

status_t mirror_time(const mirror_t* const mirror, const uint32_t parameter_id, uint64_t* const out_time_ns)
{
    FSW_ASSERT((mirror != NULL) && (out_time_ns != NULL));
    const mirror_value_t* const value = find_value(mirror, parameter_id);
    if (value == NULL) {
        return STATUS_NOT_FOUND;
    }
    *out_time_ns = value->taken_ns;
    return value->is_known ? STATUS_OK : STATUS_EMPTY;
}

status_t mirror_value(const mirror_t* const mirror, const uint32_t parameter_id,
                      const uint8_t** const out_octets, uint16_t* const out_size)
{
    FSW_ASSERT((mirror != NULL) && (out_octets != NULL) && (out_size != NULL));
    const mirror_value_t* const value = find_value(mirror, parameter_id);
    if (value == NULL) {
        return STATUS_NOT_FOUND;
    }
    *out_octets = &mirror->octets[value->offset];
    *out_size   = value->size;
    return value->is_known ? STATUS_OK : STATUS_EMPTY;
}
