// SPDX-License-Identifier: Apache-2.0
#include "pus/st03/st03_structures.h"

#include <string.h>

pus_hk_structure_t* hk_structure_of(const pus_hk_t* const hk, const bool is_diagnostic, const uint16_t id)
{
    for (uint16_t i = 0U; i < hk->config.structure_count; i++) {
        pus_hk_structure_t* const structure = &hk->config.structures[i];
        if (structure->in_use && (structure->is_diagnostic == is_diagnostic) && (structure->id == id)) {
            return structure;
        }
    }
    return NULL;
}

/// Store the failure in `verdict`. Returns false, because the caller must not continue.
static bool fail(pus_hk_t* const hk, const uint16_t code, const uint32_t detail)
{
    hk->verdict = pus_failure(code, detail);
    return false;
}

static bool is_good(const pus_hk_t* const hk)
{
    return hk->verdict.code == PUS_FAILURE_NONE;
}

/// Append an entry. False after an earlier failure or if this entry fails; then nothing changes except
/// `verdict`.
static bool add_parameter(pus_hk_t* const hk, const uint32_t parameter_id)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    if (!is_good(hk)) {
        return false;
    }
    if (candidate->entry_count >= PUS_HK_PARAMETERS_MAX) {
        return fail(hk, PUS_FAILURE_TABLE_FULL, PUS_HK_PARAMETERS_MAX);
    }
    for (uint8_t i = 0U; i < candidate->entry_count; i++) {
        if (candidate->entries[i].parameter_id == parameter_id) {
            return fail(hk, PUS_FAILURE_DUPLICATE, parameter_id);
        }
    }
    pus_hk_entry_t* const entry = &candidate->entries[candidate->entry_count];
    entry->parameter_id         = parameter_id;
    const status_t status =
        hk->config.parameters.find(hk->config.parameters.context, parameter_id, &entry->handle, &entry->size);
    if (status != STATUS_OK) {
        const bool is_known = (status == STATUS_FORBIDDEN);
        return fail(hk, is_known ? PUS_FAILURE_ACCESS : PUS_FAILURE_UNKNOWN_ID, parameter_id);
    }
    candidate->entry_count++;
    return true;
}

void hk_candidate_add(pus_hk_t* const hk, const uint32_t parameter_id)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    if (!add_parameter(hk, parameter_id)) {
        return;
    }
    // Move the new entry from the end of the list to the position before the entries of the sets.
    pus_hk_entry_t* const first_of_sets = &candidate->entries[candidate->simple_count];
    const size_t count_of_sets          = (size_t)candidate->entry_count - 1U - candidate->simple_count;
    const pus_hk_entry_t entry          = first_of_sets[count_of_sets];
    (void)memmove(&first_of_sets[1], first_of_sets, count_of_sets * sizeof entry);
    *first_of_sets = entry;
    candidate->simple_count++;
    for (uint8_t i = 0U; i < candidate->set_count; i++) {
        candidate->sets[i].first++;
    }
}

void hk_candidate_add_set(pus_hk_t* const hk, const uint16_t repetitions, const uint8_t count,
                          const uint32_t offset)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    if (!is_good(hk)) {
        return;
    }
    if (candidate->set_count >= PUS_HK_SETS_MAX) {
        (void)fail(hk, PUS_FAILURE_TABLE_FULL, PUS_HK_SETS_MAX);
    } else if ((repetitions == 0U) || (repetitions > candidate->interval) || (count == 0U)) {
        (void)fail(hk, PUS_FAILURE_OUT_OF_RANGE, offset);
    } else {
        candidate->sets[candidate->set_count] =
            (pus_hk_set_t){.repetitions = repetitions, .first = candidate->entry_count};
        candidate->set_count++;
    }
}

void hk_candidate_add_to_set(pus_hk_t* const hk, const uint32_t parameter_id)
{
    if (add_parameter(hk, parameter_id)) {
        hk->candidate.sets[hk->candidate.set_count - 1U].count++;
    }
}

/// Returns the size of the values of `count` entries from `first` on [octets].
static uint32_t size_of(const pus_hk_structure_t* const structure, const uint8_t first, const uint8_t count)
{
    uint32_t size = 0U;
    for (uint8_t i = 0U; i < count; i++) {
        size += structure->entries[first + i].size;
    }
    return size;
}

void hk_candidate_lay_out(pus_hk_t* const hk, const unsigned entries, const uint32_t offset)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    const uint32_t room                 = hk->config.sample_size;
    uint32_t size                       = size_of(candidate, 0U, candidate->simple_count);
    if (!is_good(hk)) {
        return;
    }
    if (entries == 0U) {
        (void)fail(hk, PUS_FAILURE_OUT_OF_RANGE, offset);
        return;
    }
    for (uint8_t i = 0U; (i < candidate->set_count) && (size <= room); i++) {
        pus_hk_set_t* const set = &candidate->sets[i];
        const uint32_t sample   = size_of(candidate, set->first, set->count);
        set->offset             = (uint16_t)size;
        set->size               = (uint16_t)sample;
        // A division, because the product of 65535 repetitions and 64 values of 65535 octets overflows 32
        // bits.
        size += (sample > ((room - size) / set->repetitions)) ? (room + 1U) : (sample * set->repetitions);
    }
    if (size > room) {
        (void)fail(hk, PUS_FAILURE_TABLE_FULL, room);
    }
    candidate->size = (uint16_t)size;
}

static pus_hk_structure_t* free_structure(const pus_hk_t* const hk)
{
    for (uint16_t i = 0U; i < hk->config.structure_count; i++) {
        if (!hk->config.structures[i].in_use) {
            return &hk->config.structures[i];
        }
    }
    return NULL;
}

void hk_candidate_begin(pus_hk_t* const hk, const bool is_diagnostic, const uint16_t id,
                        const uint32_t interval, pus_hk_structure_t** const out_slot)
{
    (void)memset(&hk->candidate, 0, sizeof hk->candidate);
    hk->candidate.in_use        = true;
    hk->candidate.id            = id;
    hk->candidate.is_diagnostic = is_diagnostic;
    hk->candidate.interval      = interval;
    hk->verdict                 = pus_no_failure();
    *out_slot                   = free_structure(hk);
    if (hk_structure_of(hk, is_diagnostic, id) != NULL) {
        (void)fail(hk, PUS_FAILURE_EXISTS, id);
    } else if (interval == 0U) {
        (void)fail(hk, PUS_FAILURE_OUT_OF_RANGE, HK_ID_SIZE);
    } else if (*out_slot == NULL) {
        (void)fail(hk, PUS_FAILURE_TABLE_FULL, hk->config.structure_count);
    } else {
        // The structure can be created.
    }
}

void hk_candidate_extend(pus_hk_t* const hk, const pus_hk_structure_t* const structure)
{
    hk->candidate = *structure;
    hk->verdict   = pus_no_failure();
}
