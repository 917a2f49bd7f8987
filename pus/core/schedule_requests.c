// SPDX-License-Identifier: Apache-2.0
#include "pus/core/schedule_internal.h"

#include "base/assertion.h"
#include "pus/core/stored_request.h"

pus_reply_t schedule_refuse(pus_schedule_t* const schedule, const uint16_t code, const uint32_t detail)
{
    schedule->counters.refused++;
    return pus_refused(code, detail);
}

void schedule_refuse_one(pus_schedule_t* const schedule, pus_request_t* const request,
                         const uint16_t instruction, const uint16_t code, const uint32_t detail)
{
    schedule->counters.refused++;
    pus_request_refuse(request, instruction, code, detail);
}

static pus_reply_t io_failed(const status_t status)
{
    return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
}

uint32_t schedule_id_detail(const pus_activity_id_t* const id)
{
    return ((uint32_t)id->apid << 16U) | id->sequence;
}

// ---- The function as a whole ----

static pus_reply_t set_enabled(pus_schedule_t* const schedule, const bool is_enabled)
{
    const bool was_enabled  = schedule->is_enabled;
    schedule->is_enabled    = is_enabled;
    const pus_reply_t reply = schedule_put_state(schedule);
    if (reply.kind != PUS_DONE) {
        schedule->is_enabled = was_enabled;
    }
    return reply;
}

pus_reply_t pus_schedule_enable(void* const object, pus_request_t* const request)
{
    (void)request;
    return set_enabled(object, true);
}

pus_reply_t pus_schedule_disable(void* const object, pus_request_t* const request)
{
    (void)request;
    return set_enabled(object, false);
}

/// Delete all activities that a filter selects. STATUS_OK, STATUS_IO (the remaining ones are not deleted).
static status_t delete_selected(pus_schedule_t* const schedule, const pus_schedule_filter_t* const filter)
{
    uint16_t slot = schedule_select(schedule, filter);
    while (slot != NO_SLOT) {
        const uint16_t next   = schedule_select_next(schedule, filter, slot);
        const status_t status = schedule_erase(schedule, slot);
        if (status != STATUS_OK) {
            return status;
        }
        schedule_drop(schedule, slot);
        slot = next;
    }
    return STATUS_OK;
}

pus_reply_t pus_schedule_reset(void* const object, pus_request_t* const request)
{
    (void)request;
    pus_schedule_t* const schedule     = object;
    const pus_schedule_filter_t filter = schedule_filter_all();
    status_t status                    = schedule_abandon(schedule);
    if (status == STATUS_OK) {
        status = delete_selected(schedule, &filter);
    }
    schedule->is_enabled    = false;
    schedule->sub_schedules = (pus_schedule_set_t){0};
    for (uint16_t i = 0U; i < PUS_SCHEDULE_IDS; i++) {
        schedule->groups.flags[i] |= ((schedule->groups.flags[i] & EXISTS) != 0U) ? ENABLED : 0U;
    }
    const pus_reply_t reply = schedule_put_state(schedule);
    return (status == STATUS_OK) ? reply : io_failed(status);
}

// ---- Insertion ----

/// Check an instruction; returns the first reason to refuse it. `draft` is complete except for the
/// identifier, which is read from the embedded request.
static pus_failure_t check(const pus_schedule_t* const schedule, activity_draft_t* const draft,
                           const bool is_tag, const size_t tag_offset, const size_t request_offset,
                           const uint64_t earliest)
{
    pus_tc_t tc;
    pus_failure_t failure;
    if (!is_tag) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, (uint32_t)tag_offset);
    }
    if ((schedule->groups.flags[draft->group] & EXISTS) == 0U) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, draft->group);
    }
    if ((draft->size > PUS_SCHEDULE_REQUEST_MAX) ||
        (pus_stored_request_decode(draft->request, draft->size, &tc, &failure) != STATUS_OK)) {
        return pus_failure(PUS_FAILURE_EMBEDDED, (uint32_t)request_offset);
    }
    draft->id = schedule_id_of(&tc);
    if (draft->tag < earliest) {
        return pus_failure(PUS_FAILURE_PAST, 0U);
    }
    return (schedule->free != NO_SLOT) ? pus_no_failure()
                                       : pus_failure(PUS_FAILURE_TABLE_FULL, schedule->config.activity_count);
}

/// Insert the checked activity, and store it.
static pus_failure_t insert(pus_schedule_t* const schedule, const activity_draft_t* const draft)
{
    const uint16_t slot = schedule->free;
    if (schedule_add(schedule, slot, draft) != STATUS_OK) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, schedule->config.chains->pool.block_count);
    }
    const status_t status = schedule_put(schedule, slot, draft->tag);
    if (status != STATUS_OK) {
        schedule_drop(schedule, slot);
        return pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    }
    schedule->serial++;
    schedule->counters.inserted++;
    return pus_no_failure();
}

static void insert_one(pus_schedule_t* const schedule, pus_request_t* const request,
                       const uint16_t instruction, const uint8_t sub_schedule, const uint64_t earliest)
{
    octet_reader_t* const reader = &request->reader;
    activity_draft_t draft       = {.serial = schedule->serial, .sub_schedule = sub_schedule};
    draft.group                  = octet_read_u8(reader);
    const size_t tag_offset      = reader->position;
    const bool is_tag            = schedule->kind->read_tag(reader, &draft.tag);
    const size_t request_offset  = reader->position;
    const status_t status =
        pus_packet_frame(&reader->octets[request_offset], octet_reader_left(reader), &draft.size);
    FSW_ASSERT(status == STATUS_OK); // The dispatcher has checked the format.
    draft.request         = octet_read_octets(reader, draft.size);
    pus_failure_t failure = check(schedule, &draft, is_tag, tag_offset, request_offset, earliest);
    if (failure.code == (uint16_t)PUS_FAILURE_NONE) {
        failure = insert(schedule, &draft);
    }
    if (failure.code == (uint16_t)PUS_FAILURE_NONE) {
        pus_request_perform(request);
    } else {
        schedule_refuse_one(schedule, request, instruction, failure.code, failure.detail);
    }
}

static uint64_t earliest_tag(const pus_schedule_t* const schedule, const pus_request_t* const request)
{
    return schedule_now(schedule, request->now_ns) + schedule->config.margin;
}

pus_reply_t pus_schedule_insert(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    const uint8_t sub_schedule     = octet_read_u8(&request->reader);
    const uint8_t count            = octet_read_u8(&request->reader);
    pus_schedule_set_t* const set  = &schedule->sub_schedules;
    const bool is_new              = (set->flags[sub_schedule] & EXISTS) == 0U;
    if (is_new && (set->count >= schedule->config.sub_schedule_count)) {
        return schedule_refuse(schedule, PUS_FAILURE_TABLE_FULL, schedule->config.sub_schedule_count);
    }
    const uint64_t earliest = earliest_tag(schedule, request);
    for (uint16_t i = 1U; i <= count; i++) {
        insert_one(schedule, request, i, sub_schedule, earliest);
    }
    if (!is_new || (request->performed == 0U)) {
        return pus_done();
    }
    set->flags[sub_schedule] = EXISTS;
    set->count++;
    return schedule_put_state(schedule);
}

// ---- Deletion ----

/// Delete all activities with the identifier of `first`, from `first` on.
static status_t delete_named(pus_schedule_t* const schedule, const uint16_t first)
{
    uint16_t slot = first;
    while (slot != NO_SLOT) {
        const uint16_t next   = schedule_find_next(schedule, slot);
        const status_t status = schedule_erase(schedule, slot);
        if (status != STATUS_OK) {
            return status;
        }
        schedule_drop(schedule, slot);
        slot = next;
    }
    return STATUS_OK;
}

pus_reply_t pus_schedule_delete_ids(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    const uint8_t count            = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const pus_activity_id_t id = schedule_read_id(&request->reader);
        const uint16_t slot        = schedule_find(schedule, &id);
        const status_t status      = delete_named(schedule, slot);
        if (slot == NO_SLOT) {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_UNKNOWN_ID, schedule_id_detail(&id));
        } else if (status != STATUS_OK) {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_IO, (uint32_t)status);
        } else {
            pus_request_perform(request);
        }
    }
    return pus_done();
}

pus_reply_t pus_schedule_delete_filtered(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    pus_schedule_filter_t filter;
    const pus_reply_t reply = schedule_read_filter(schedule, &request->reader, &filter);
    if (reply.kind != PUS_DONE) {
        return reply;
    }
    const status_t status = delete_selected(schedule, &filter);
    return (status == STATUS_OK) ? pus_done() : io_failed(status);
}

// ---- Shift ----

/// Activities that an instruction or a request shifts: a list that begins with `first` and continues with
/// `chosen` of each activity.
typedef struct {
    uint16_t first;
    uint64_t tag_min;
    uint64_t tag_max;
} choice_t;

static void choose(const pus_schedule_t* const schedule, choice_t* const choice, const uint16_t slot)
{
    const uint64_t tag = schedule->config.nodes[slot].tag;

    schedule->config.activities[slot].chosen = choice->first;
    if ((choice->first == NO_SLOT) || (tag < choice->tag_min)) {
        choice->tag_min = tag;
    }
    if (tag > choice->tag_max) {
        choice->tag_max = tag;
    }
    choice->first = slot;
}

/// Shift all selected activities, or none if one of them may not be shifted. If storing fails, the rest is
/// not shifted.
static pus_failure_t shift(pus_schedule_t* const schedule, const choice_t* const choice, const int64_t offset,
                           const uint64_t earliest)
{
    // Tags and magnitudes of offsets are below 2^62, so the sums do not overflow.
    const int64_t first = (int64_t)choice->tag_min + offset;
    const int64_t last  = (int64_t)choice->tag_max + offset;
    if ((choice->first != NO_SLOT) && ((first < 0) || (last > (int64_t)schedule->kind->tag_max))) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, 0U); // The offset is the first field.
    }
    if ((choice->first != NO_SLOT) && ((uint64_t)first < earliest)) {
        return pus_failure(PUS_FAILURE_PAST, 0U);
    }
    for (uint16_t slot = choice->first; slot != NO_SLOT; slot = schedule->config.activities[slot].chosen) {
        const uint64_t tag    = (uint64_t)((int64_t)schedule->config.nodes[slot].tag + offset);
        const status_t status = schedule_put(schedule, slot, tag);
        if (status != STATUS_OK) {
            return pus_failure(PUS_FAILURE_IO, (uint32_t)status);
        }
        schedule_retag(schedule, slot, tag);
    }
    return pus_no_failure();
}

pus_reply_t pus_schedule_shift_ids(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    const int64_t offset           = schedule->kind->read_offset(&request->reader);
    const uint8_t count            = octet_read_u8(&request->reader);
    const uint64_t earliest        = earliest_tag(schedule, request);
    for (uint16_t i = 1U; i <= count; i++) {
        const pus_activity_id_t id = schedule_read_id(&request->reader);
        choice_t choice            = {.first = NO_SLOT};
        for (uint16_t slot = schedule_find(schedule, &id); slot != NO_SLOT;
             slot          = schedule_find_next(schedule, slot)) {
            choose(schedule, &choice, slot);
        }
        const pus_failure_t failure = (choice.first != NO_SLOT)
                                          ? shift(schedule, &choice, offset, earliest)
                                          : pus_failure(PUS_FAILURE_UNKNOWN_ID, schedule_id_detail(&id));
        if (failure.code == (uint16_t)PUS_FAILURE_NONE) {
            pus_request_perform(request);
        } else {
            schedule_refuse_one(schedule, request, i, failure.code, failure.detail);
        }
    }
    return pus_done();
}

static pus_reply_t shift_selected(pus_schedule_t* const schedule, const pus_request_t* const request,
                                  const pus_schedule_filter_t* const filter, const int64_t offset)
{
    choice_t choice = {.first = NO_SLOT};
    for (uint16_t slot = schedule_select(schedule, filter); slot != NO_SLOT;
         slot          = schedule_select_next(schedule, filter, slot)) {
        choose(schedule, &choice, slot);
    }
    const pus_failure_t failure = shift(schedule, &choice, offset, earliest_tag(schedule, request));
    if (failure.code == (uint16_t)PUS_FAILURE_NONE) {
        return pus_done();
    }
    return (failure.code == (uint16_t)PUS_FAILURE_IO)
               ? pus_failed(failure.code, failure.detail)
               : schedule_refuse(schedule, failure.code, failure.detail);
}

pus_reply_t pus_schedule_shift_filtered(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    const int64_t offset           = schedule->kind->read_offset(&request->reader);
    pus_schedule_filter_t filter;
    const pus_reply_t reply = schedule_read_filter(schedule, &request->reader, &filter);
    return (reply.kind == PUS_DONE) ? shift_selected(schedule, request, &filter, offset) : reply;
}

pus_reply_t pus_schedule_shift_all(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule     = object;
    const int64_t offset               = schedule->kind->read_offset(&request->reader);
    const pus_schedule_filter_t filter = schedule_filter_all();
    return shift_selected(schedule, request, &filter, offset);
}
