// SPDX-License-Identifier: Apache-2.0
#include "pus/st12/st12_internal.h"

#include "base/assertion.h"

static pus_failure_t none(void)
{
    return pus_no_failure();
}

static pus_fmon_t* fmon_of(const pus_monitoring_t* const self, const uint16_t id)
{
    for (uint16_t i = 0U; i < self->config.fmon_capacity; i++) {
        pus_fmon_t* const fmon = &self->config.fmons[i];
        if (fmon->in_use && (fmon->id == id)) {
            return fmon;
        }
    }
    return NULL;
}

static pus_fmon_t* free_fmon(const pus_monitoring_t* const self)
{
    for (uint16_t i = 0U; i < self->config.fmon_capacity; i++) {
        if (!self->config.fmons[i].in_use) {
            return &self->config.fmons[i];
        }
    }
    return NULL;
}

static pus_fmon_member_t* members_of(const pus_monitoring_t* const self, const pus_fmon_t* const fmon)
{
    return &self->config.members[(size_t)(fmon - self->config.fmons) * self->config.fmon_members];
}

// ---- PMONs that the FMONs name ----

void monitoring_link(pus_monitoring_t* const self)
{
    if (!self->is_unlinked) {
        return;
    }
    self->is_unlinked = false;
    for (uint16_t i = 0U; i < self->config.pmon_capacity; i++) {
        self->config.pmons[i].members = 0U;
    }
    for (uint16_t i = 0U; i < self->config.fmon_capacity; i++) {
        const pus_fmon_t* const fmon = &self->config.fmons[i]; // An unused FMON has no members.
        pus_fmon_member_t* member    = members_of(self, fmon);
        for (uint8_t k = 0U; k < fmon->count; k++) {
            pus_pmon_t* const pmon = monitoring_pmon(self, member->pmon_id);
            if (pmon != NULL) { // Null if the record of the PMON is lost.
                member->next  = pmon->members;
                pmon->members = (uint16_t)((member - self->config.members) + 1);
            }
            member++;
        }
    }
}

/// Returns the FMON to which *member (number of a member + 1) belongs, and moves *member to the next member
/// that names the same PMON.
static pus_fmon_t* named_by(const pus_monitoring_t* const self, uint16_t* const member)
{
    const uint16_t number = (uint16_t)(*member - 1U);
    *member               = self->config.members[number].next;
    return &self->config.fmons[number / self->config.fmon_members];
}

void monitoring_touch(pus_monitoring_t* const self, const pus_pmon_t* const pmon)
{
    uint16_t member = pmon->members;
    while (member != 0U) {
        pus_fmon_t* const fmon = named_by(self, &member);
        if (self->is_functional && fmon->is_enabled && !fmon->is_touched) {
            fmon->is_touched                          = true;
            self->config.touched[self->touched_count] = (uint16_t)(fmon - self->config.fmons);
            self->touched_count++;
        }
    }
}

bool monitoring_is_protected(pus_monitoring_t* const self, const pus_pmon_t* const pmon)
{
    monitoring_link(self);
    bool is_protected = false;
    uint16_t member   = pmon->members;
    while (member != 0U) {
        const pus_fmon_t* const fmon = named_by(self, &member);
        if (fmon->is_protected) {
            is_protected = true;
        }
    }
    return is_protected;
}

// ---- Evaluation ----

static uint16_t failing(const pus_monitoring_t* const self, const pus_fmon_t* const fmon)
{
    uint16_t count                         = 0U;
    const pus_fmon_member_t* const members = members_of(self, fmon);
    for (uint8_t i = 0U; i < fmon->count; i++) {
        const pus_pmon_t* const pmon = monitoring_pmon(self, members[i].pmon_id);
        const bool is_failing        = (pmon != NULL) && (pmon->status >= (uint8_t)PUS_CHECK_LOW);
        count                        = (uint16_t)(count + (is_failing ? 1U : 0U));
    }
    return count;
}

static void fail(pus_monitoring_t* const self, const pus_fmon_t* const fmon, const uint16_t count,
                 const uint64_t now_ns)
{
    uint8_t octets[MONITORING_FMON_EVENT];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, fmon->id);
    octet_write_u16(&writer, count);
    self->counters.failures++;
    if (fmon->event != 0U) {
        self->config.events.raise(self->config.events.context, fmon->event, octets, sizeof octets, now_ns);
    }
}

static void evaluate(pus_monitoring_t* const self, pus_fmon_t* const fmon, const uint64_t now_ns)
{
    if (!monitoring_is_valid(self, &fmon->validity)) {
        fmon->status = PUS_FMON_INVALID;
        return;
    }
    const uint16_t count = failing(self, fmon);
    if (count < fmon->minimum) {
        fmon->status = PUS_FMON_RUNNING;
    } else if (fmon->status != (uint8_t)PUS_FMON_FAILED) {
        fmon->status = PUS_FMON_FAILED;
        fail(self, fmon, count, now_ns);
    } else {
        // The failure has already been reported.
    }
}

void monitoring_evaluate_touched(pus_monitoring_t* const self, const uint64_t now_ns)
{
    for (uint16_t i = 0U; i < self->touched_count; i++) {
        pus_fmon_t* const fmon = &self->config.fmons[self->config.touched[i]];
        fmon->is_touched       = false;
        if (self->is_functional && fmon->is_enabled) { // The FMON may have been disabled since it was marked.
            evaluate(self, fmon, now_ns);
        }
    }
    self->touched_count = 0U;
}

// ---- Definitions ----

/// A definition that was read and is not yet in the table.
typedef struct {
    pus_fmon_t fmon;
    octet_reader_t members; // Ids of the members, not read yet.
    uint16_t member_count;
} candidate_t;

/// Read a definition. False: malformed.
static bool read_fmon(octet_reader_t* const reader, const monitoring_origin_t origin,
                      candidate_t* const out_candidate)
{
    *out_candidate         = (candidate_t){.fmon = {.in_use = true}};
    pus_fmon_t* const fmon = &out_candidate->fmon;
    fmon->id               = octet_read_u16(reader);
    if (!monitoring_read_validity(reader, &fmon->validity)) {
        return false;
    }
    if (origin == MONITORING_FROM_RECORD) {
        fmon->is_protected = octet_read_u8(reader) != 0U;
        fmon->is_enabled   = octet_read_u8(reader) != 0U;
    }
    fmon->event   = octet_read_u16(reader);
    fmon->minimum = octet_read_u16(reader);
    out_candidate->member_count =
        (origin == MONITORING_FROM_RECORD) ? octet_read_u16(reader) : octet_read_u8(reader);
    const size_t size        = (size_t)out_candidate->member_count * sizeof(uint16_t);
    const uint8_t* const ids = octet_read_octets(reader, size);
    if (ids == NULL) {
        return false;
    }
    out_candidate->members = octet_reader(ids, size);
    return true;
}

/// Write a definition as an entry of TM[12,26] and as a record. `members`: its entries in the table.
static void write_fmon(octet_writer_t* const writer, const pus_fmon_t* const fmon,
                       const pus_fmon_member_t* const members)
{
    octet_write_u16(writer, fmon->id);
    monitoring_write_validity(writer, &fmon->validity);
    octet_write_u8(writer, fmon->is_protected ? 1U : 0U);
    octet_write_u8(writer, fmon->is_enabled ? 1U : 0U);
    octet_write_u16(writer, fmon->event);
    octet_write_u16(writer, fmon->minimum);
    octet_write_u16(writer, fmon->count);
    for (uint8_t i = 0U; i < fmon->count; i++) {
        octet_write_u16(writer, members[i].pmon_id);
    }
}

/// Check the size and the contents of a definition, except whether its PMONs exist.
static pus_failure_t check_fmon(const pus_monitoring_t* const self, const monitoring_origin_t origin,
                                candidate_t* const candidate, const uint32_t offset)
{
    pus_fmon_t* const fmon = &candidate->fmon;
    if (candidate->member_count > self->config.fmon_members) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, self->config.fmon_members);
    }
    if ((fmon->minimum == 0U) || (fmon->minimum > candidate->member_count)) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    fmon->count                 = (uint8_t)candidate->member_count;
    const pus_failure_t failure = monitoring_check_event(self, fmon->event, MONITORING_FMON_EVENT);
    return (failure.code != PUS_FAILURE_NONE)
               ? failure
               : monitoring_check_validity(self, origin, &fmon->validity, offset);
}

/// Write the ids of the members of a new definition to the table.
static pus_failure_t take_members(const pus_monitoring_t* const self, candidate_t* const candidate,
                                  pus_fmon_member_t* const members)
{
    for (uint8_t i = 0U; i < candidate->fmon.count; i++) {
        const uint16_t id = octet_read_u16(&candidate->members);
        if (monitoring_pmon(self, id) == NULL) {
            return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
        }
        for (uint8_t k = 0U; k < i; k++) {
            if (members[k].pmon_id == id) {
                return pus_failure(PUS_FAILURE_DUPLICATE, id);
            }
        }
        members[i] = (pus_fmon_member_t){.pmon_id = id};
    }
    return none();
}

static pus_failure_t save(pus_monitoring_t* const self, const pus_fmon_t* const fmon,
                          const pus_fmon_member_t* const members)
{
    uint8_t octets[MONITORING_RECORD_MAX];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    write_fmon(&writer, fmon, members);
    return monitoring_save(self, MONITORING_FMON_RECORD, fmon->id, octets, writer.position);
}

/// Replace a definition in the table and in its record.
static pus_failure_t replace(pus_monitoring_t* const self, pus_fmon_t* const slot, pus_fmon_t* const fmon)
{
    const pus_failure_t failure = save(self, fmon, members_of(self, slot));
    if (failure.code == PUS_FAILURE_NONE) {
        fmon->is_touched = slot->is_touched;
        *slot            = *fmon;
    }
    return failure;
}

static pus_failure_t add(pus_monitoring_t* const self, candidate_t* const candidate, const uint32_t offset)
{
    pus_fmon_t* const slot = free_fmon(self);
    if (fmon_of(self, candidate->fmon.id) != NULL) {
        return pus_failure(PUS_FAILURE_EXISTS, candidate->fmon.id);
    }
    if (slot == NULL) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, self->config.fmon_capacity);
    }
    pus_failure_t failure = check_fmon(self, MONITORING_FROM_ADD, candidate, offset);
    if (failure.code == PUS_FAILURE_NONE) {
        failure = take_members(self, candidate, members_of(self, slot));
    }
    if (failure.code == PUS_FAILURE_NONE) {
        failure           = replace(self, slot, &candidate->fmon);
        self->is_unlinked = true;
    }
    return failure;
}

pus_reply_t monitoring_add_fmons(void* const context, pus_request_t* const request)
{
    pus_monitoring_t* const self = context;
    const uint8_t count          = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        candidate_t candidate;
        const uint32_t offset = (uint32_t)request->reader.position;
        // The dispatcher has checked the format.
        (void)read_fmon(&request->reader, MONITORING_FROM_ADD, &candidate);
        const pus_failure_t failure = add(self, &candidate, offset);
        monitoring_settle(self, request, i, &failure);
    }
    return pus_done();
}

status_t monitoring_restore_fmon(pus_monitoring_t* const self, octet_reader_t* const reader)
{
    candidate_t candidate;
    if (!read_fmon(reader, MONITORING_FROM_RECORD, &candidate) || !octet_reader_is_done(reader)) {
        return STATUS_INVALID;
    }
    pus_fmon_t* slot = fmon_of(self, candidate.fmon.id);
    slot             = (slot != NULL) ? slot : free_fmon(self);
    if (slot == NULL) {
        return STATUS_EXHAUSTED;
    }
    const pus_failure_t failure = check_fmon(self, MONITORING_FROM_RECORD, &candidate, 0U);
    if (failure.code == PUS_FAILURE_NONE) {
        // The records of its PMONs may be restored later.
        pus_fmon_member_t* const members = members_of(self, slot);
        for (uint8_t i = 0U; i < candidate.fmon.count; i++) {
            members[i] = (pus_fmon_member_t){.pmon_id = octet_read_u16(&candidate.members)};
        }
        *slot             = candidate.fmon;
        self->is_unlinked = true;
    }
    return monitoring_status(&failure);
}

// ---- Requests for existing definitions ----

static pus_failure_t remove_fmon(pus_monitoring_t* const self, const uint16_t id)
{
    pus_fmon_t* const fmon = fmon_of(self, id);
    if (fmon == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (fmon->is_enabled) {
        return pus_failure(PUS_FAILURE_STATE, id);
    }
    if (fmon->is_protected) {
        return pus_failure(PUS_FAILURE_PROTECTED, id);
    }
    const pus_failure_t failure = monitoring_forget(self, MONITORING_FMON_RECORD, id);
    if (failure.code == PUS_FAILURE_NONE) {
        *fmon             = (pus_fmon_t){.is_touched = fmon->is_touched};
        self->is_unlinked = true;
    }
    return failure;
}

static pus_failure_t set(pus_monitoring_t* const self, const uint16_t id, const bool is_enabled,
                         const bool is_protected)
{
    pus_fmon_t* const fmon = fmon_of(self, id);
    FSW_ASSERT(fmon != NULL); // True, because the caller has found it.
    pus_fmon_t changed   = *fmon;
    changed.is_enabled   = is_enabled;
    changed.is_protected = is_protected;
    changed.status       = is_enabled ? fmon->status : (uint8_t)PUS_FMON_UNCHECKED;
    return replace(self, fmon, &changed);
}

static pus_failure_t enable_fmon(pus_monitoring_t* const self, const uint16_t id)
{
    const pus_fmon_t* const fmon = fmon_of(self, id);
    return (fmon == NULL) ? pus_failure(PUS_FAILURE_UNKNOWN_ID, id) : set(self, id, true, fmon->is_protected);
}

static pus_failure_t disable_fmon(pus_monitoring_t* const self, const uint16_t id)
{
    const pus_fmon_t* const fmon = fmon_of(self, id);
    if (fmon == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
    }
    return fmon->is_protected ? pus_failure(PUS_FAILURE_PROTECTED, id) : set(self, id, false, false);
}

static pus_failure_t protect_fmon(pus_monitoring_t* const self, const uint16_t id)
{
    const pus_fmon_t* const fmon = fmon_of(self, id);
    return (fmon == NULL) ? pus_failure(PUS_FAILURE_UNKNOWN_ID, id) : set(self, id, fmon->is_enabled, true);
}

static pus_failure_t unprotect_fmon(pus_monitoring_t* const self, const uint16_t id)
{
    const pus_fmon_t* const fmon = fmon_of(self, id);
    return (fmon == NULL) ? pus_failure(PUS_FAILURE_UNKNOWN_ID, id) : set(self, id, fmon->is_enabled, false);
}

static pus_failure_t look_up(pus_monitoring_t* const self, const uint16_t id)
{
    return pus_failure((fmon_of(self, id) == NULL) ? PUS_FAILURE_UNKNOWN_ID : PUS_FAILURE_NONE, id);
}

pus_reply_t monitoring_enable_fmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, enable_fmon);
}

pus_reply_t monitoring_disable_fmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, disable_fmon);
}

pus_reply_t monitoring_protect_fmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, protect_fmon);
}

pus_reply_t monitoring_unprotect_fmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, unprotect_fmon);
}

pus_reply_t monitoring_delete_fmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, remove_fmon);
}

pus_reply_t monitoring_enable_functional(void* const context, pus_request_t* const request)
{
    (void)request;
    pus_monitoring_t* const self = context;
    pus_failure_t failure        = pus_failure(PUS_FAILURE_STATE, 0U);
    if (self->is_enabled) {
        failure             = monitoring_save_settings(self, true, true, self->reporting_delay);
        self->is_functional = self->is_functional || (failure.code == PUS_FAILURE_NONE);
    }
    return monitoring_reply(self, &failure);
}

pus_reply_t monitoring_disable_functional(void* const context, pus_request_t* const request)
{
    (void)request;
    pus_monitoring_t* const self = context;
    const pus_failure_t failure =
        monitoring_save_settings(self, self->is_enabled, false, self->reporting_delay);
    if (failure.code == PUS_FAILURE_NONE) {
        self->is_functional = false;
        for (uint16_t i = 0U; i < self->config.fmon_capacity; i++) {
            self->config.fmons[i].status = PUS_FMON_UNCHECKED;
        }
    }
    return monitoring_reply(self, &failure);
}

// ---- Reports ----

static void report_fmon(const pus_monitoring_t* const self, pus_list_report_t* const list,
                        const pus_fmon_t* const fmon)
{
    write_fmon(pus_list_report_entry(list, MONITORING_RECORD_MAX), fmon, members_of(self, fmon));
}

pus_reply_t monitoring_report_fmons(void* const context, pus_request_t* const request)
{
    pus_monitoring_t* const self   = context;
    octet_reader_t ids             = request->reader;
    const uint8_t count            = octet_read_u8(&ids);
    const pus_list_target_t target = pus_list_answer(request, 26U);
    pus_list_report_t list;
    if (!monitoring_accept_ids(self, request, look_up)) {
        return pus_done();
    }
    pus_list_report_begin(&list, &target, NULL, 0U);
    for (uint8_t i = 0U; i < count; i++) {
        const pus_fmon_t* const fmon = fmon_of(self, octet_read_u16(&ids));
        if (fmon != NULL) {
            report_fmon(self, &list, fmon);
        }
    }
    for (uint16_t i = 0U; (count == 0U) && (i < self->config.fmon_capacity); i++) {
        if (self->config.fmons[i].in_use) {
            report_fmon(self, &list, &self->config.fmons[i]);
        }
    }
    return pus_list_report_end(&list);
}

pus_reply_t monitoring_report_fmon_status(void* const context, pus_request_t* const request)
{
    pus_monitoring_t* const self   = context;
    const pus_list_target_t target = pus_list_answer(request, 28U);
    pus_list_report_t list;
    pus_request_perform(request);
    pus_list_report_begin(&list, &target, NULL, 0U);
    for (uint16_t i = 0U; i < self->config.fmon_capacity; i++) {
        const pus_fmon_t* const fmon = &self->config.fmons[i];
        if (fmon->in_use) {
            octet_writer_t* const writer = pus_list_report_entry(&list, 5U);
            octet_write_u16(writer, fmon->id);
            octet_write_u8(writer, fmon->is_protected ? 1U : 0U);
            octet_write_u8(writer, fmon->is_enabled ? 1U : 0U);
            octet_write_u8(writer, fmon->status);
        }
    }
    return pus_list_report_end(&list);
}
