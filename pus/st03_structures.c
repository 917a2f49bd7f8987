// SPDX-License-Identifier: Apache-2.0
#include "pus/st03_structures.h"

#include <string.h>

static pus_failure_t good(void)
{
    return pus_failure(PUS_FAILURE_NONE, 0U);
}

pus_hk_structure_t* hk_structure_of(const pus_hk_t* const hk, const uint16_t id)
{
    for (uint16_t i = 0U; i < hk->config.structure_count; i++) {
        pus_hk_structure_t* const structure = &hk->config.structures[i];
        if (structure->in_use && (structure->id == id)) {
            return structure;
        }
    }
    return NULL;
}

static pus_failure_t add_parameter(pus_hk_t* const hk, const uint32_t parameter_id)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    if (candidate->entry_count >= PUS_HK_PARAMETERS_MAX) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, PUS_HK_PARAMETERS_MAX);
    }
    for (uint8_t i = 0U; i < candidate->entry_count; i++) {
        if (candidate->entries[i].parameter_id == parameter_id) {
            return pus_failure(PUS_FAILURE_DUPLICATE, parameter_id);
        }
    }
    pus_hk_entry_t entry = {.parameter_id = parameter_id};
    const status_t status =
        hk->config.parameters.find(hk->config.parameters.context, parameter_id, &entry.handle, &entry.size);
    if (status != STATUS_OK) {
        const bool is_known = (status == STATUS_FORBIDDEN);
        return pus_failure(is_known ? PUS_FAILURE_ACCESS : PUS_FAILURE_UNKNOWN_ID, parameter_id);
    }
    candidate->entries[candidate->entry_count] = entry;
    candidate->entry_count++;
    return good();
}

pus_failure_t hk_candidate_add(pus_hk_t* const hk, const uint32_t parameter_id)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    const pus_failure_t verdict         = add_parameter(hk, parameter_id);
    if (verdict.code != PUS_FAILURE_NONE) {
        return verdict;
    }
    const pus_hk_entry_t entry = candidate->entries[candidate->entry_count - 1U];
    for (uint8_t i = (uint8_t)(candidate->entry_count - 1U); i > candidate->simple_count; i--) {
        candidate->entries[i] = candidate->entries[i - 1U];
    }
    candidate->entries[candidate->simple_count] = entry;
    candidate->simple_count++;
    for (uint8_t i = 0U; i < candidate->set_count; i++) {
        candidate->sets[i].first++;
    }
    return good();
}

pus_failure_t hk_candidate_add_set(pus_hk_t* const hk, const uint16_t repetitions, const uint8_t count,
                                   const uint32_t offset)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    if (candidate->set_count >= PUS_HK_SETS_MAX) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, PUS_HK_SETS_MAX);
    }
    if ((repetitions == 0U) || (repetitions > candidate->interval) || (count == 0U)) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    candidate->sets[candidate->set_count] =
        (pus_hk_set_t){.repetitions = repetitions, .first = candidate->entry_count, .count = 0U};
    candidate->set_count++;
    return good();
}

pus_failure_t hk_candidate_add_to_set(pus_hk_t* const hk, const uint32_t parameter_id)
{
    const pus_failure_t verdict = add_parameter(hk, parameter_id);
    if (verdict.code == PUS_FAILURE_NONE) {
        hk->candidate.sets[hk->candidate.set_count - 1U].count++;
    }
    return verdict;
}

pus_failure_t hk_candidate_lay_out(pus_hk_t* const hk)
{
    pus_hk_structure_t* const candidate = &hk->candidate;
    uint32_t size                       = 0U;
    for (uint8_t i = 0U; i < candidate->simple_count; i++) {
        size += candidate->entries[i].size;
    }
    for (uint8_t i = 0U; i < candidate->set_count; i++) {
        pus_hk_set_t* const set = &candidate->sets[i];
        uint32_t sample         = 0U;
        for (uint8_t k = 0U; k < set->count; k++) {
            sample += candidate->entries[set->first + k].size;
        }
        // Checked before the product: 65535 repetitions of 64 values of 65535 octets overflow 32 bits.
        if ((size > hk->config.sample_size) ||
            (sample > ((hk->config.sample_size - size) / set->repetitions))) {
            return pus_failure(PUS_FAILURE_TABLE_FULL, hk->config.sample_size);
        }
        set->offset = (uint16_t)size;
        set->size   = (uint16_t)sample;
        size += sample * set->repetitions;
    }
    if (size > hk->config.sample_size) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, hk->config.sample_size);
    }
    candidate->size = (uint16_t)size;
    return good();
}

void hk_candidate_begin(pus_hk_t* const hk, const uint16_t id, const uint32_t interval)
{
    (void)memset(&hk->candidate, 0, sizeof(hk->candidate));
    hk->candidate.in_use   = true;
    hk->candidate.id       = id;
    hk->candidate.interval = interval;
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

pus_failure_t hk_check_new(const pus_hk_t* const hk, const uint16_t id, const uint32_t interval,
                           pus_hk_structure_t** const out_place)
{
    *out_place = free_structure(hk);
    if (hk_structure_of(hk, id) != NULL) {
        return pus_failure(PUS_FAILURE_EXISTS, id);
    }
    if (interval == 0U) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, HK_ID_SIZE);
    }
    if (*out_place == NULL) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, hk->config.structure_count);
    }
    return good();
}
