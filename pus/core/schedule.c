// SPDX-License-Identifier: Apache-2.0
#include "pus/core/schedule.h"

#include "base/assertion.h"
#include "pus/core/schedule_internal.h"
#include "pus/core/stored_request.h"

#include <string.h>

// Keys of persistent records.
#define KEY_STATE 0U     // Function, sub-schedules and groups.
#define KEY_RELEASING 1U // Identifiers of the requests under release.
#define KEY_ACTIVITY 0x01000000U
#define SLOT_MASK 0xFFFFU
#define ID_SIZE 6U // Size of an identifier in a record [octets].

void pus_schedule_init(pus_schedule_t* const schedule, const pus_schedule_kind_t* const kind,
                       void* const self, const pus_schedule_config_t* const config)
{
    FSW_ASSERT((schedule != NULL) && (kind != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->release.send != NULL));
    FSW_ASSERT((config->activities != NULL) && (config->buckets != NULL) && (config->chains != NULL));
    FSW_ASSERT((config->activity_count >= 1U) && (config->activity_count < NO_SLOT) &&
               (config->bucket_count >= 1U) && ((config->bucket_count & (config->bucket_count - 1U)) == 0U) &&
               (config->sub_schedule_count <= PUS_SCHEDULE_IDS) && (config->group_count <= PUS_SCHEDULE_IDS));
    (void)memset(schedule, 0, sizeof *schedule);
    schedule->kind           = kind;
    schedule->self           = self;
    schedule->config         = *config;
    schedule->free           = NO_SLOT;
    schedule->releasing      = NO_SLOT;
    schedule->releasing_last = NO_SLOT;
    pus_sorted_index_init(&schedule->order, config->nodes);
    for (uint32_t i = 0U; i < config->bucket_count; i++) {
        config->buckets[i] = NO_SLOT;
    }
    for (uint16_t i = 0U; i < config->activity_count; i++) {
        config->activities[i] =
            (pus_activity_t){.next     = schedule->free,
                             .previous = ((i + 1U) < config->activity_count) ? (uint16_t)(i + 1U) : NO_SLOT};
        schedule->free = i;
    }
}

uint64_t schedule_now(const pus_schedule_t* const schedule, const uint64_t now_ns)
{
    return schedule->kind->now(schedule->self, now_ns);
}

// ---- Lists of slots: free slots, and slots of a bucket ----

static void list_put(pus_schedule_t* const schedule, uint16_t* const first, const uint16_t slot)
{
    pus_activity_t* const activities = schedule->config.activities;
    activities[slot].next            = *first;
    activities[slot].previous        = NO_SLOT;
    if (*first != NO_SLOT) {
        activities[*first].previous = slot;
    }
    *first = slot;
}

static void list_take(pus_schedule_t* const schedule, uint16_t* const first, const uint16_t slot)
{
    pus_activity_t* const activities     = schedule->config.activities;
    const pus_activity_t* const activity = &activities[slot];
    if (activity->previous != NO_SLOT) {
        activities[activity->previous].next = activity->next;
    } else {
        *first = activity->next;
    }
    if (activity->next != NO_SLOT) {
        activities[activity->next].previous = activity->previous;
    }
}

static uint16_t* bucket_of(const pus_schedule_t* const schedule, const pus_activity_id_t* const id)
{
    uint32_t hash = ((uint32_t)id->apid << 16U) ^ ((uint32_t)id->source << 5U) ^ id->sequence;
    hash          = (hash ^ (hash >> 15U)) * 0x2C1B3C6DU;
    hash          = hash ^ (hash >> 12U);
    return &schedule->config.buckets[hash & (schedule->config.bucket_count - 1U)];
}

static bool is_named(const pus_activity_id_t* const one, const pus_activity_id_t* const other)
{
    return (one->source == other->source) && (one->apid == other->apid) && (one->sequence == other->sequence);
}

static uint16_t find_from(const pus_schedule_t* const schedule, const pus_activity_id_t* const id,
                          const uint16_t first)
{
    uint16_t slot = first;
    while ((slot != NO_SLOT) && !is_named(&schedule->config.activities[slot].id, id)) {
        slot = schedule->config.activities[slot].next;
    }
    return slot;
}

uint16_t schedule_find(const pus_schedule_t* const schedule, const pus_activity_id_t* const id)
{
    return find_from(schedule, id, *bucket_of(schedule, id));
}

uint16_t schedule_find_next(const pus_schedule_t* const schedule, const uint16_t slot)
{
    const pus_activity_t* const activity = &schedule->config.activities[slot];
    return find_from(schedule, &activity->id, activity->next);
}

// ---- Activities ----

status_t schedule_add(pus_schedule_t* const schedule, const uint16_t slot,
                      const activity_draft_t* const draft)
{
    pus_activity_t* const activity = &schedule->config.activities[slot];
    const status_t status =
        pus_block_chain_append(schedule->config.chains, &activity->request, draft->request, draft->size);
    if (status == STATUS_OK) {
        list_take(schedule, &schedule->free, slot);
        activity->id           = draft->id;
        activity->sub_schedule = draft->sub_schedule;
        activity->group        = draft->group;
        activity->report       = 0U;
        activity->in_use       = true;
        list_put(schedule, bucket_of(schedule, &activity->id), slot);
        pus_sorted_index_insert(&schedule->order, slot, draft->tag, draft->serial);
        schedule->group_uses[draft->group]++;
        schedule->count++;
    }
    return status;
}

/// Remove an activity from the schedule, but keep its request.
static void take_out(pus_schedule_t* const schedule, const uint16_t slot)
{
    pus_activity_t* const activity = &schedule->config.activities[slot];
    list_take(schedule, bucket_of(schedule, &activity->id), slot);
    pus_sorted_index_remove(&schedule->order, slot);
    schedule->group_uses[activity->group]--;
    schedule->count--;
}

static void free_slot(pus_schedule_t* const schedule, const uint16_t slot)
{
    pus_block_chain_free(schedule->config.chains, &schedule->config.activities[slot].request);
    schedule->config.activities[slot].in_use = false;
    list_put(schedule, &schedule->free, slot);
}

void schedule_drop(pus_schedule_t* const schedule, const uint16_t slot)
{
    take_out(schedule, slot);
    free_slot(schedule, slot);
}

void schedule_retag(pus_schedule_t* const schedule, const uint16_t slot, const uint64_t tag)
{
    const uint64_t serial = schedule->config.nodes[slot].serial;
    pus_sorted_index_remove(&schedule->order, slot);
    pus_sorted_index_insert(&schedule->order, slot, tag, serial);
}

size_t schedule_request(const pus_schedule_t* const schedule, const uint16_t slot, uint8_t* const out_octets)
{
    pus_block_chain_reader_t reader = pus_block_chain_reader(&schedule->config.activities[slot].request);
    return pus_block_chain_read(&reader, out_octets, PUS_PACKET_MAX);
}

pus_activity_id_t schedule_id_of(const pus_tc_t* const tc)
{
    return (pus_activity_id_t){.source = tc->source, .apid = tc->apid, .sequence = tc->sequence};
}

pus_activity_id_t schedule_read_id(octet_reader_t* const reader)
{
    pus_activity_id_t id;
    id.source   = octet_read_u16(reader);
    id.apid     = octet_read_u16(reader);
    id.sequence = octet_read_u16(reader);
    return id;
}

// ---- Persistent records ----

static status_t put(const pus_schedule_t* const schedule, const uint32_t key, const size_t size)
{
    const pus_persistence_t* const port = schedule->config.persistence;
    return (port != NULL) ? port->put(port->context, schedule->kind->service, key, schedule->record, size)
                          : STATUS_OK;
}

static status_t erase(const pus_schedule_t* const schedule, const uint32_t key)
{
    const pus_persistence_t* const port = schedule->config.persistence;
    const status_t status =
        (port != NULL) ? port->erase(port->context, schedule->kind->service, key) : STATUS_OK;
    return (status == STATUS_NOT_FOUND) ? STATUS_OK : status;
}

/// Count a change made in a step that could not be stored.
static void note(pus_schedule_t* const schedule, const status_t status)
{
    schedule->counters.unsaved += (status != STATUS_OK) ? 1U : 0U;
}

static void commit(pus_schedule_t* const schedule)
{
    const pus_persistence_t* const port = schedule->config.persistence;
    note(schedule, (port != NULL) ? port->commit(port->context) : STATUS_OK);
}

static pus_reply_t reply_of(const status_t status)
{
    return (status == STATUS_OK) ? pus_done() : pus_failed(PUS_FAILURE_IO, (uint32_t)status);
}

status_t schedule_put(pus_schedule_t* const schedule, const uint16_t slot, const uint64_t tag)
{
    const pus_activity_t* const activity = &schedule->config.activities[slot];
    octet_writer_t writer                = octet_writer(schedule->record, PUS_SCHEDULE_RECORD_HEAD);
    octet_write_u64(&writer, tag);
    octet_write_u64(&writer, schedule->config.nodes[slot].serial);
    octet_write_u8(&writer, activity->sub_schedule);
    octet_write_u8(&writer, activity->group);
    const size_t size = schedule_request(schedule, slot, &schedule->record[PUS_SCHEDULE_RECORD_HEAD]);
    return put(schedule, KEY_ACTIVITY | slot, PUS_SCHEDULE_RECORD_HEAD + size);
}

status_t schedule_erase(const pus_schedule_t* const schedule, const uint16_t slot)
{
    return erase(schedule, KEY_ACTIVITY | slot);
}

static void write_set(octet_writer_t* const writer, const pus_schedule_set_t* const set)
{
    octet_write_u16(writer, set->count);
    for (uint16_t i = 0U; i < PUS_SCHEDULE_IDS; i++) {
        if ((set->flags[i] & EXISTS) != 0U) {
            octet_write_u8(writer, (uint8_t)i);
            octet_write_u8(writer, set->flags[i]);
        }
    }
}

pus_reply_t schedule_put_state(pus_schedule_t* const schedule)
{
    octet_writer_t writer = octet_writer(schedule->record, sizeof schedule->record);
    octet_write_u8(&writer, schedule->is_enabled ? 1U : 0U);
    write_set(&writer, &schedule->sub_schedules);
    write_set(&writer, &schedule->groups);
    return reply_of(put(schedule, KEY_STATE, writer.position));
}

pus_reply_t pus_schedule_keep_own(pus_schedule_t* const schedule, const uint8_t* const octets,
                                  const size_t size)
{
    FSW_ASSERT((schedule != NULL) && (octets != NULL) && (size <= sizeof schedule->record));
    (void)memcpy(schedule->record, octets, size);
    return reply_of(put(schedule, PUS_SCHEDULE_KEY_OWN, size));
}

static status_t restore_set(octet_reader_t* const reader, const uint16_t maximum,
                            pus_schedule_set_t* const out_set)
{
    pus_schedule_set_t set = {.count = octet_read_u16(reader)};
    if (set.count > maximum) {
        return STATUS_EXHAUSTED;
    }
    for (uint16_t i = 0U; i < set.count; i++) {
        const uint8_t id    = octet_read_u8(reader);
        const uint8_t flags = octet_read_u8(reader);
        if ((set.flags[id] != 0U) || ((flags & EXISTS) == 0U)) {
            return STATUS_INVALID;
        }
        set.flags[id] = flags & (EXISTS | ENABLED);
    }
    *out_set = set;
    return STATUS_OK;
}

static status_t restore_state(pus_schedule_t* const schedule, octet_reader_t* const reader)
{
    pus_schedule_set_t sub_schedules = {0};
    pus_schedule_set_t groups        = {0};
    const bool is_enabled            = octet_read_u8(reader) != 0U;
    status_t status = restore_set(reader, schedule->config.sub_schedule_count, &sub_schedules);
    if (status == STATUS_OK) {
        status = restore_set(reader, schedule->config.group_count, &groups);
    }
    if (status != STATUS_OK) {
        return status;
    }
    if (!octet_reader_is_done(reader)) {
        return STATUS_INVALID;
    }
    schedule->is_enabled    = is_enabled;
    schedule->sub_schedules = sub_schedules;
    schedule->groups        = groups;
    return STATUS_OK;
}

static status_t restore_releasing(pus_schedule_t* const schedule, octet_reader_t* const reader)
{
    const size_t count = octet_reader_left(reader) / ID_SIZE;
    if ((count > PUS_SCHEDULE_BATCH) || ((octet_reader_left(reader) % ID_SIZE) != 0U)) {
        return STATUS_INVALID;
    }
    for (size_t i = 0U; i < count; i++) {
        schedule->lost[i] = schedule_read_id(reader);
    }
    schedule->lost_count = (uint16_t)count;
    return STATUS_OK;
}

static status_t restore_activity(pus_schedule_t* const schedule, const uint32_t slot,
                                 octet_reader_t* const reader)
{
    if (slot >= schedule->config.activity_count) {
        return STATUS_EXHAUSTED;
    }
    if (schedule->config.activities[slot].in_use) {
        return STATUS_EXISTS;
    }
    activity_draft_t draft = {0};
    draft.tag              = octet_read_u64(reader);
    draft.serial           = octet_read_u64(reader);
    draft.sub_schedule     = octet_read_u8(reader);
    draft.group            = octet_read_u8(reader);
    draft.size             = octet_reader_left(reader);
    draft.request          = octet_read_octets(reader, draft.size);
    pus_tc_t tc;
    pus_failure_t failure;
    if ((draft.size == 0U) || (draft.tag > schedule->kind->tag_max) ||
        (pus_stored_request_decode(draft.request, draft.size, &tc, &failure) != STATUS_OK)) {
        return STATUS_INVALID;
    }
    draft.id         = schedule_id_of(&tc);
    schedule->serial = (draft.serial >= schedule->serial) ? (draft.serial + 1U) : schedule->serial;
    return schedule_add(schedule, (uint16_t)slot, &draft);
}

status_t pus_schedule_restore(pus_schedule_t* const schedule, const uint32_t key, const uint8_t* const octets,
                              const size_t size)
{
    FSW_ASSERT((schedule != NULL) && (octets != NULL));
    octet_reader_t reader = octet_reader(octets, size);
    if (key == KEY_STATE) {
        return restore_state(schedule, &reader);
    }
    if (key == KEY_RELEASING) {
        return restore_releasing(schedule, &reader);
    }
    if ((key & ~SLOT_MASK) == KEY_ACTIVITY) {
        return restore_activity(schedule, key & SLOT_MASK, &reader);
    }
    return STATUS_INVALID;
}

// ---- Release ----

static void report_lost(pus_schedule_t* const schedule)
{
    for (uint16_t i = 0U; i < schedule->lost_count; i++) {
        schedule->counters.lost++;
        if (schedule->config.lost != NULL) {
            schedule->config.lost(schedule->config.context, &schedule->lost[i]);
        }
    }
    schedule->lost_count = 0U;
    note(schedule, erase(schedule, KEY_RELEASING));
    commit(schedule);
}

static bool may_be_released(const pus_schedule_t* const schedule, const pus_activity_t* const activity)
{
    return schedule->is_enabled &&
           ((schedule->sub_schedules.flags[activity->sub_schedule] & ENABLED) != 0U) &&
           ((schedule->groups.flags[activity->group] & ENABLED) != 0U);
}

static void append_to_release(pus_schedule_t* const schedule, const uint16_t slot)
{
    pus_activity_t* const activities = schedule->config.activities;
    activities[slot].next            = NO_SLOT;
    if (schedule->releasing == NO_SLOT) {
        schedule->releasing = slot;
    } else {
        activities[schedule->releasing_last].next = slot;
    }
    schedule->releasing_last = slot;
}

/// Take the due activities out of the schedule: delete those that are disabled, and put the others under
/// release.
static void gather(pus_schedule_t* const schedule, const uint64_t now)
{
    octet_writer_t writer = octet_writer(schedule->record, sizeof schedule->record);
    uint16_t count        = 0U;
    uint16_t slot         = pus_sorted_index_first(&schedule->order);
    while ((slot != NO_SLOT) && (schedule->config.nodes[slot].tag <= now) && (count < PUS_SCHEDULE_BATCH)) {
        const pus_activity_t* const activity = &schedule->config.activities[slot];
        note(schedule, schedule_erase(schedule, slot));
        take_out(schedule, slot);
        if (may_be_released(schedule, activity)) {
            octet_write_u16(&writer, activity->id.source);
            octet_write_u16(&writer, activity->id.apid);
            octet_write_u16(&writer, activity->id.sequence);
            append_to_release(schedule, slot);
        } else {
            schedule->counters.dropped++;
            free_slot(schedule, slot);
        }
        count++;
        slot = pus_sorted_index_first(&schedule->order);
    }
    // Committed before the first release: a restart finds these identifiers and does not release them again.
    if (writer.position > 0U) {
        note(schedule, put(schedule, KEY_RELEASING, writer.position));
    }
    if (count > 0U) {
        commit(schedule);
    }
}

/// Pass the requests under release to the port until it refuses one.
static void release(pus_schedule_t* const schedule)
{
    const pus_port_t* const port = &schedule->config.release;
    while (schedule->releasing != NO_SLOT) {
        const uint16_t slot = schedule->releasing;
        const size_t size   = schedule_request(schedule, slot, schedule->record);
        if (port->send(port->context, schedule->record, size) != STATUS_OK) {
            schedule->counters.deferred++;
            return;
        }
        schedule->counters.released++;
        schedule->releasing = schedule->config.activities[slot].next;
        free_slot(schedule, slot);
    }
    note(schedule, erase(schedule, KEY_RELEASING));
    commit(schedule);
}

status_t schedule_abandon(pus_schedule_t* const schedule)
{
    while (schedule->releasing != NO_SLOT) {
        const uint16_t slot = schedule->releasing;
        schedule->releasing = schedule->config.activities[slot].next;
        free_slot(schedule, slot);
    }
    return erase(schedule, KEY_RELEASING);
}

void pus_schedule_step(pus_schedule_t* const schedule, const uint64_t now_ns)
{
    FSW_ASSERT(schedule != NULL);
    if (schedule->lost_count > 0U) {
        report_lost(schedule);
    }
    if (schedule->releasing != NO_SLOT) {
        release(schedule);
    }
    if (schedule->releasing == NO_SLOT) {
        gather(schedule, schedule_now(schedule, now_ns));
        if (schedule->releasing != NO_SLOT) {
            release(schedule);
        }
    }
    if (schedule->report.is_active) {
        schedule_report_go_on(schedule, now_ns);
    }
}

bool pus_schedule_is_waiting(const pus_schedule_t* const schedule)
{
    FSW_ASSERT(schedule != NULL);
    return (schedule->lost_count > 0U) || (schedule->releasing != NO_SLOT) || schedule->report.is_active;
}

uint64_t pus_schedule_next(const pus_schedule_t* const schedule)
{
    FSW_ASSERT(schedule != NULL);
    const uint16_t slot = pus_sorted_index_first(&schedule->order);
    return (slot != NO_SLOT) ? schedule->config.nodes[slot].tag : TAG_NEVER;
}
