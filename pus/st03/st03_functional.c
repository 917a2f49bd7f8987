// SPDX-License-Identifier: Apache-2.0
// Functional reporting of ST[03], TC[3,37] to [3,44]: named sets of structures that one request enables or
// disables together.
#include "base/assertion.h"
#include "pus/st03/st03_structures.h"

#include <string.h>

enum {
    DEFINITION_REPORT = 41,
    HOUSEKEEPING      = 25, // Types of structures in requests.
    DIAGNOSTIC        = 26
};

#define RECORD_HEAD 1U // Octets before the entries of a record: the number of entries.
#define ENTRY_SIZE 8U  // Size of an entry in a record [octets].

static pus_hk_functional_t* definition_of(const pus_hk_t* const hk, const uint16_t id)
{
    for (uint16_t i = 0U; i < hk->config.functional_count; i++) {
        if (hk->config.functional[i].in_use && (hk->config.functional[i].id == id)) {
            return &hk->config.functional[i];
        }
    }
    return NULL;
}

static pus_hk_functional_t* free_definition(const pus_hk_t* const hk)
{
    for (uint16_t i = 0U; i < hk->config.functional_count; i++) {
        if (!hk->config.functional[i].in_use) {
            return &hk->config.functional[i];
        }
    }
    return NULL;
}

/// Returns the entry of a structure in a definition, or null.
static pus_hk_member_t* member_of(pus_hk_functional_t* const definition, const bool is_diagnostic,
                                  const uint16_t id)
{
    for (uint8_t i = 0U; i < definition->count; i++) {
        pus_hk_member_t* const member = &definition->members[i];
        if ((member->is_diagnostic == is_diagnostic) && (member->id == id)) {
            return member;
        }
    }
    return NULL;
}

// ---- Persistent data ----

static status_t keep(const pus_hk_t* const hk, const pus_hk_functional_t* const definition)
{
    const pus_persistence_t* const persistence = hk->config.persistence;
    uint8_t record[RECORD_HEAD + (PUS_HK_MEMBERS_MAX * ENTRY_SIZE)];
    octet_writer_t writer = octet_writer(record, sizeof record);
    octet_write_u8(&writer, definition->count);
    for (uint8_t i = 0U; i < definition->count; i++) {
        const pus_hk_member_t* const member = &definition->members[i];
        octet_write_u8(&writer, member->is_diagnostic ? DIAGNOSTIC : HOUSEKEEPING);
        octet_write_u16(&writer, member->id);
        octet_write_u8(&writer, member->is_periodic ? 1U : 0U);
        octet_write_u32(&writer, member->interval);
    }
    return (persistence == NULL) ? STATUS_OK
                                 : persistence->put(persistence->context, PUS_SERVICE_HOUSEKEEPING,
                                                    definition->id, record, writer.position);
}

/// Read the fields of an entry that a request and a record have in common. False: a value is out of range.
static bool read_member(octet_reader_t* const reader, const bool has_values,
                        pus_hk_member_t* const out_member)
{
    const uint8_t type        = octet_read_u8(reader);
    out_member->is_diagnostic = (type == DIAGNOSTIC);
    out_member->id            = octet_read_u16(reader);
    out_member->is_periodic   = false;
    out_member->interval      = 1U;
    uint8_t status            = 0U;
    if (has_values) {
        status                  = octet_read_u8(reader);
        out_member->is_periodic = (status == 1U);
        out_member->interval    = octet_read_u32(reader);
    }
    return ((type == HOUSEKEEPING) || (type == DIAGNOSTIC)) && (status <= 1U) && (out_member->interval > 0U);
}

status_t pus_hk_restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    pus_hk_t* const hk = self;
    FSW_ASSERT((hk != NULL) && (octets != NULL));
    octet_reader_t reader     = octet_reader(octets, size);
    pus_hk_functional_t* slot = (key <= UINT16_MAX) ? definition_of(hk, (uint16_t)key) : NULL;
    slot                      = (slot == NULL) ? free_definition(hk) : slot;
    if (slot == NULL) {
        return STATUS_EXHAUSTED;
    }
    pus_hk_functional_t* const scratch = &hk->functional;
    *scratch = (pus_hk_functional_t){.in_use = true, .id = (uint16_t)key, .count = octet_read_u8(&reader)};
    bool is_good = (key <= UINT16_MAX) && (scratch->count <= PUS_HK_MEMBERS_MAX);
    for (uint8_t i = 0U; is_good && (i < scratch->count); i++) {
        is_good = read_member(&reader, true, &scratch->members[i]);
    }
    if (!is_good || !octet_reader_is_done(&reader)) {
        return STATUS_INVALID;
    }
    *slot = *scratch;
    return STATUS_OK;
}

// ---- Changes of one definition ----

/// Function that performs a request for one entry. The code of its result is PUS_FAILURE_NONE on success.
typedef pus_failure_t (*change_t)(pus_hk_functional_t* definition, const pus_hk_member_t* member);

static pus_failure_t add_member(pus_hk_functional_t* const definition, const pus_hk_member_t* const member)
{
    if (member_of(definition, member->is_diagnostic, member->id) != NULL) {
        return pus_failure(PUS_FAILURE_EXISTS, member->id);
    }
    if (definition->count >= PUS_HK_MEMBERS_MAX) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, PUS_HK_MEMBERS_MAX);
    }
    definition->members[definition->count] = *member;
    definition->count++;
    return pus_no_failure();
}

static pus_failure_t modify_member(pus_hk_functional_t* const definition, const pus_hk_member_t* const member)
{
    pus_hk_member_t* const own = member_of(definition, member->is_diagnostic, member->id);
    if (own == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, member->id);
    }
    *own = *member;
    return pus_no_failure();
}

static pus_failure_t remove_member(pus_hk_functional_t* const definition, const pus_hk_member_t* const member)
{
    pus_hk_member_t* const own = member_of(definition, member->is_diagnostic, member->id);
    if (own == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, member->id);
    }
    definition->count--;
    *own = definition->members[definition->count];
    return pus_no_failure();
}

/// Change the copy of the definition by the entries of a request. If all entries succeed, the copy replaces
/// `slot`; otherwise the whole request is refused.
static pus_reply_t change(pus_hk_t* const hk, pus_request_t* const request, pus_hk_functional_t* const slot,
                          const change_t perform)
{
    octet_reader_t* const reader = &request->reader;
    const bool has_values        = (perform != remove_member);
    const uint8_t apid_count     = octet_read_u8(reader);
    for (uint8_t i = 0U; i < apid_count; i++) {
        const uint16_t apid         = octet_read_u16(reader);
        const uint8_t members_count = octet_read_u8(reader);
        if (apid != hk->config.process->apid) {
            return pus_refused(PUS_FAILURE_UNKNOWN_ID, apid);
        }
        for (uint8_t k = 0U; k < members_count; k++) {
            const uint32_t offset  = (uint32_t)reader->position;
            pus_hk_member_t member = {0};
            if (!read_member(reader, has_values, &member)) {
                return pus_refused(PUS_FAILURE_OUT_OF_RANGE, offset);
            }
            const pus_failure_t failure = perform(&hk->functional, &member);
            if (failure.code != PUS_FAILURE_NONE) {
                return pus_refused(failure.code, failure.detail);
            }
        }
    }
    const status_t status = keep(hk, &hk->functional);
    if (status != STATUS_OK) {
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    *slot = hk->functional;
    return pus_done();
}

pus_reply_t hk_functional_create(void* const self, pus_request_t* const request)
{
    pus_hk_t* const hk              = self;
    const uint16_t id               = octet_read_u16(&request->reader);
    pus_hk_functional_t* const slot = free_definition(hk);
    if (definition_of(hk, id) != NULL) {
        return pus_refused(PUS_FAILURE_EXISTS, id);
    }
    if (slot == NULL) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, hk->config.functional_count);
    }
    hk->functional = (pus_hk_functional_t){.in_use = true, .id = id};
    return change(hk, request, slot, add_member);
}

static pus_reply_t change_known(pus_hk_t* const hk, pus_request_t* const request, const change_t perform)
{
    const uint16_t id               = octet_read_u16(&request->reader);
    pus_hk_functional_t* const slot = definition_of(hk, id);
    if (slot == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, id);
    }
    hk->functional = *slot;
    return change(hk, request, slot, perform);
}

pus_reply_t hk_functional_add(void* const self, pus_request_t* const request)
{
    return change_known(self, request, add_member);
}

pus_reply_t hk_functional_remove(void* const self, pus_request_t* const request)
{
    return change_known(self, request, remove_member);
}

pus_reply_t hk_functional_modify(void* const self, pus_request_t* const request)
{
    return change_known(self, request, modify_member);
}

// ---- Several definitions ----

pus_reply_t hk_functional_delete(void* const self, pus_request_t* const request)
{
    const pus_hk_t* const hk                   = self;
    const pus_persistence_t* const persistence = hk->config.persistence;
    const uint8_t count                        = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint16_t id                     = octet_read_u16(&request->reader);
        pus_hk_functional_t* const definition = definition_of(hk, id);
        const status_t status                 = ((definition == NULL) || (persistence == NULL))
                                                    ? STATUS_OK
                                                    : persistence->erase(persistence->context, PUS_SERVICE_HOUSEKEEPING, id);
        if (definition == NULL) {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, id);
        } else if (status != STATUS_OK) {
            pus_request_refuse(request, i, PUS_FAILURE_IO, (uint32_t)status);
        } else {
            pus_request_perform(request);
            definition->in_use = false;
        }
    }
    return pus_done();
}

pus_reply_t hk_functional_report(void* const self, pus_request_t* const request)
{
    const pus_hk_t* const hk = self;
    const uint8_t count      = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint16_t id                           = octet_read_u16(&request->reader);
        const pus_hk_functional_t* const definition = definition_of(hk, id);
        if (definition == NULL) {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, id);
            continue;
        }
        pus_request_perform(request);
        octet_writer_t writer = pus_answer_begin(request, DEFINITION_REPORT);
        octet_write_u16(&writer, id);
        octet_write_u16(&writer, (definition->count > 0U) ? 1U : 0U);
        if (definition->count > 0U) {
            octet_write_u16(&writer, hk->config.process->apid);
            octet_write_u16(&writer, definition->count);
        }
        for (uint8_t k = 0U; k < definition->count; k++) {
            const pus_hk_member_t* const member = &definition->members[k];
            octet_write_u8(&writer, member->is_diagnostic ? DIAGNOSTIC : HOUSEKEEPING);
            octet_write_u16(&writer, member->id);
            octet_write_u8(&writer, member->is_periodic ? 1U : 0U);
            octet_write_u32(&writer, member->interval);
        }
        pus_answer_send(request, &writer);
    }
    return pus_done();
}

/// Apply a definition to its structures. Returns the number of structures to which it cannot be applied.
static uint32_t apply(const pus_hk_t* const hk, const pus_hk_functional_t* const definition)
{
    uint32_t failures = 0U;
    for (uint8_t i = 0U; i < definition->count; i++) {
        const pus_hk_member_t* const member = &definition->members[i];
        pus_hk_structure_t* const structure = hk_structure_of(hk, member->is_diagnostic, member->id);
        if ((structure == NULL) || (member->interval < hk_interval_min(structure))) {
            failures++;
        } else {
            const bool is_new = (structure->interval != member->interval);
            hk_set_periodic(structure, structure->is_periodic && !is_new);
            structure->interval = member->interval;
            hk_set_periodic(structure, member->is_periodic);
        }
    }
    return failures;
}

pus_reply_t hk_functional_apply(void* const self, pus_request_t* const request)
{
    const pus_hk_t* const hk  = self;
    const uint8_t exclusive   = octet_read_u8(&request->reader);
    const octet_reader_t list = request->reader;
    const uint8_t count       = octet_read_u8(&request->reader);
    uint32_t failures         = 0U;
    if (exclusive > 1U) {
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    for (uint16_t i = 1U; i <= count; i++) {
        const uint16_t id = octet_read_u16(&request->reader);
        if (definition_of(hk, id) == NULL) {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, id);
        } else {
            pus_request_perform(request);
        }
    }
    if (request->performed == 0U) {
        return pus_done();
    }
    hk_lock(hk);
    for (uint16_t i = 0U; (exclusive == 1U) && (i < hk->config.structure_count); i++) {
        hk_set_periodic(&hk->config.structures[i], false);
    }
    request->reader = list;
    (void)octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const pus_hk_functional_t* const definition = definition_of(hk, octet_read_u16(&request->reader));
        failures += (definition != NULL) ? apply(hk, definition) : 0U;
    }
    hk_unlock(hk);
    return (failures == 0U) ? pus_done() : pus_failed(PUS_FAILURE_SOME_FAILED, failures + request->refused);
}
