// SPDX-License-Identifier: Apache-2.0
#include "pus/st12/st12_monitoring.h"

#include "base/assertion.h"
#include "generated/pus/st12_request_formats.h"
#include "pus/st12/st12_internal.h"

#include <string.h>

#define KIND_SHIFT 16U // Position of the kind in a record's key.
#define SETTINGS_SIZE 6U

void pus_monitoring_init(pus_monitoring_t* const self, const pus_monitoring_config_t* const config)
{
    FSW_ASSERT((self != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->events.is_known != NULL) && (config->events.raise != NULL));
    FSW_ASSERT((config->pmons != NULL) && (config->pmon_order != NULL) && (config->fmons != NULL) &&
               (config->touched != NULL) && (config->members != NULL) && (config->transitions != NULL) &&
               (config->transition_capacity >= 1U) && (config->fmon_members >= 1U));
    *self = (pus_monitoring_t){.config = *config, .reporting_delay = config->reporting_delay};
    pus_due_init(&self->due, config->due, config->pmon_positions, config->pmon_capacity);
    for (uint16_t i = 0U; i < config->pmon_capacity; i++) {
        config->pmon_order[i] = i;
    }
    for (uint16_t i = 0U; i < config->fmon_capacity; i++) {
        config->fmons[i] = (pus_fmon_t){0};
    }
}

// ---- Tables ----

/// Returns the position of an id in the order, or the position at which it would be inserted.
static uint16_t position_of(const pus_monitoring_t* const self, const uint16_t id)
{
    uint16_t low  = 0U;
    uint16_t high = self->pmon_count;
    while (low < high) {
        const uint16_t middle = (uint16_t)(low + ((high - low) / 2U));
        if (self->config.pmons[self->config.pmon_order[middle]].id < id) {
            low = (uint16_t)(middle + 1U);
        } else {
            high = middle;
        }
    }
    return low;
}

static pus_pmon_t* pmon_at(const pus_monitoring_t* const self, const uint16_t position)
{
    return &self->config.pmons[self->config.pmon_order[position]];
}

pus_pmon_t* monitoring_pmon(const pus_monitoring_t* const self, const uint16_t id)
{
    const uint16_t position = position_of(self, id);
    if ((position == self->pmon_count) || (pmon_at(self, position)->id != id)) {
        return NULL;
    }
    return pmon_at(self, position);
}

/// Insert a definition. The caller has checked that there is room and that its id is new.
static void insert(pus_monitoring_t* const self, const pus_pmon_t* const pmon)
{
    uint16_t* const order   = self->config.pmon_order;
    const uint16_t position = position_of(self, pmon->id);
    const uint16_t taken    = order[self->pmon_count];
    (void)memmove(&order[position + 1U], &order[position],
                  (size_t)(self->pmon_count - position) * sizeof order[0]);
    order[position] = taken;
    self->pmon_count++;
    self->config.pmons[taken] = *pmon;
    self->is_unlinked         = true;
    monitoring_schedule(self, &self->config.pmons[taken]);
}

// ---- Records ----

static pus_failure_t outcome(pus_monitoring_t* const self, const status_t status)
{
    const bool is_good = status == STATUS_OK;
    self->counters.unsaved += is_good ? 0U : 1U;
    return pus_failure(is_good ? PUS_FAILURE_NONE : PUS_FAILURE_IO, (uint32_t)status);
}

pus_failure_t monitoring_save(pus_monitoring_t* const self, const uint32_t kind, const uint16_t id,
                              const uint8_t* const octets, const size_t size)
{
    const pus_persistence_t* const store = self->config.persistence;
    return outcome(self, (store == NULL) ? STATUS_OK
                                         : store->put(store->context, PUS_SERVICE_MONITORING,
                                                      (kind << KIND_SHIFT) | id, octets, size));
}

pus_failure_t monitoring_forget(pus_monitoring_t* const self, const uint32_t kind, const uint16_t id)
{
    const pus_persistence_t* const store = self->config.persistence;
    const status_t status =
        (store == NULL) ? STATUS_OK
                        : store->erase(store->context, PUS_SERVICE_MONITORING, (kind << KIND_SHIFT) | id);
    return outcome(self, (status == STATUS_NOT_FOUND) ? STATUS_OK : status);
}

pus_failure_t monitoring_save_settings(pus_monitoring_t* const self, const bool is_enabled,
                                       const bool is_functional, const uint32_t reporting_delay)
{
    uint8_t octets[SETTINGS_SIZE];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, is_enabled ? 1U : 0U);
    octet_write_u8(&writer, is_functional ? 1U : 0U);
    octet_write_u32(&writer, reporting_delay);
    return monitoring_save(self, MONITORING_SETTINGS_RECORD, 0U, octets, sizeof octets);
}

static pus_failure_t save(pus_monitoring_t* const self, const pus_pmon_t* const pmon)
{
    uint8_t octets[MONITORING_PMON_MAX];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    monitoring_write_pmon(&writer, pmon);
    return monitoring_save(self, MONITORING_PMON_RECORD, pmon->id, octets, writer.position);
}

status_t monitoring_status(const pus_failure_t* const failure)
{
    switch (failure->code) {
    case PUS_FAILURE_NONE:
        return STATUS_OK;
    case PUS_FAILURE_UNKNOWN_ID:
        return STATUS_NOT_FOUND;
    case PUS_FAILURE_TABLE_FULL:
        return STATUS_EXHAUSTED;
    default:
        return STATUS_INVALID;
    }
}

static status_t restore_pmon(pus_monitoring_t* const self, octet_reader_t* const reader)
{
    pus_pmon_t pmon;
    if (!monitoring_read_pmon(reader, MONITORING_FROM_RECORD, &pmon) || !octet_reader_is_done(reader)) {
        return STATUS_INVALID;
    }
    pus_pmon_t* const there = monitoring_pmon(self, pmon.id);
    if ((there == NULL) && (self->pmon_count == self->config.pmon_capacity)) {
        return STATUS_EXHAUSTED;
    }
    const pus_failure_t failure = monitoring_check_pmon(self, MONITORING_FROM_RECORD, &pmon, 0U);
    if (failure.code == PUS_FAILURE_NONE) {
        if (there != NULL) {
            monitoring_uncheck(self, there);
            pmon.members = there->members;
            *there       = pmon;
            monitoring_schedule(self, there);
        } else {
            insert(self, &pmon);
        }
    }
    return monitoring_status(&failure);
}

static void enable_all(pus_monitoring_t* const self)
{
    self->is_enabled = true;
    for (uint16_t i = 0U; i < self->pmon_count; i++) {
        monitoring_schedule(self, pmon_at(self, i));
    }
}

static status_t restore_settings(pus_monitoring_t* const self, octet_reader_t* const reader)
{
    const bool is_enabled    = octet_read_u8(reader) != 0U;
    const bool is_functional = octet_read_u8(reader) != 0U;
    const uint32_t delay     = octet_read_u32(reader);
    if (!octet_reader_is_done(reader) || (is_functional && !is_enabled)) {
        return STATUS_INVALID;
    }
    self->reporting_delay = delay;
    self->is_functional   = is_functional;
    if (is_enabled) {
        enable_all(self);
    }
    return STATUS_OK;
}

status_t pus_monitoring_restore(pus_monitoring_t* const self, const uint32_t key, const uint8_t* const octets,
                                const size_t size)
{
    FSW_ASSERT((self != NULL) && ((octets != NULL) || (size == 0U)));
    octet_reader_t reader = octet_reader(octets, size);
    switch (key >> KIND_SHIFT) {
    case MONITORING_PMON_RECORD:
        return restore_pmon(self, &reader);
    case MONITORING_FMON_RECORD:
        return monitoring_restore_fmon(self, &reader);
    case MONITORING_SETTINGS_RECORD:
        return restore_settings(self, &reader);
    default:
        return STATUS_INVALID;
    }
}

// ---- Requests ----

pus_reply_t monitoring_reply(pus_monitoring_t* const self, const pus_failure_t* const failure)
{
    if (failure->code == PUS_FAILURE_NONE) {
        return pus_done();
    }
    self->counters.refused++;
    return pus_refused(failure->code, failure->detail);
}

void monitoring_settle(pus_monitoring_t* const self, pus_request_t* const request, const uint16_t instruction,
                       const pus_failure_t* const failure)
{
    if (failure->code == PUS_FAILURE_NONE) {
        pus_request_perform(request);
    } else {
        self->counters.refused++;
        pus_request_refuse(request, instruction, failure->code, failure->detail);
    }
}

pus_reply_t monitoring_for_each(pus_monitoring_t* const self, pus_request_t* const request,
                                const monitoring_act_t act)
{
    const uint8_t count = octet_read_u8(&request->reader);
    monitoring_link(self);
    for (uint16_t i = 1U; i <= count; i++) {
        const pus_failure_t failure = act(self, octet_read_u16(&request->reader));
        monitoring_settle(self, request, i, &failure);
    }
    return pus_done();
}

bool monitoring_accept_ids(pus_monitoring_t* const self, pus_request_t* const request,
                           const monitoring_act_t look_up)
{
    if (request->reader.octets[request->reader.position] == 0U) {
        pus_request_perform(request);
    } else {
        (void)monitoring_for_each(self, request, look_up);
    }
    return request->performed > 0U;
}

static pus_failure_t look_up(pus_monitoring_t* const self, const uint16_t id)
{
    return pus_failure((monitoring_pmon(self, id) == NULL) ? PUS_FAILURE_UNKNOWN_ID : PUS_FAILURE_NONE, id);
}

/// Enable or disable a PMON. The record is stored first: a change that cannot be stored is refused.
static pus_failure_t set_enabled(pus_monitoring_t* const self, pus_pmon_t* const pmon, const bool is_enabled)
{
    const bool was_enabled      = pmon->is_enabled;
    pmon->is_enabled            = is_enabled;
    const pus_failure_t failure = save(self, pmon);
    if (failure.code != PUS_FAILURE_NONE) {
        pmon->is_enabled = was_enabled;
    }
    return failure;
}

static pus_failure_t enable(pus_monitoring_t* const self, const uint16_t id)
{
    pus_pmon_t* const pmon = monitoring_pmon(self, id);
    if (pmon == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (pmon->is_enabled) {
        return pus_no_failure(); // The PMON is already enabled: the times of its checks do not change.
    }
    const pus_failure_t failure = set_enabled(self, pmon, true);
    monitoring_schedule(self, pmon);
    return failure;
}

static pus_failure_t disable(pus_monitoring_t* const self, const uint16_t id)
{
    pus_pmon_t* const pmon = monitoring_pmon(self, id);
    if (pmon == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (monitoring_is_protected(self, pmon)) {
        return pus_failure(PUS_FAILURE_PROTECTED, id);
    }
    const pus_failure_t failure = set_enabled(self, pmon, false);
    if (failure.code == PUS_FAILURE_NONE) {
        monitoring_uncheck(self, pmon);
    }
    return failure;
}

/// Delete a definition that exists, and that no FMON contains.
static pus_failure_t drop(pus_monitoring_t* const self, const uint16_t id)
{
    const pus_failure_t failure = monitoring_forget(self, MONITORING_PMON_RECORD, id);
    if (failure.code == PUS_FAILURE_NONE) {
        uint16_t* const order   = self->config.pmon_order;
        const uint16_t position = position_of(self, id);
        const uint16_t freed    = order[position];
        self->pmon_count--;
        (void)memmove(&order[position], &order[position + 1U],
                      (size_t)(self->pmon_count - position) * sizeof order[0]);
        order[self->pmon_count] = freed;
    }
    return failure;
}

static pus_failure_t forget(pus_monitoring_t* const self, const uint16_t id)
{
    const pus_pmon_t* const pmon = monitoring_pmon(self, id);
    if (pmon == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (pmon->is_enabled || (pmon->members != 0U)) {
        return pus_failure(PUS_FAILURE_STATE, id);
    }
    return drop(self, id);
}

static pus_reply_t enable_pmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, enable);
}

static pus_reply_t disable_pmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, disable);
}

static pus_reply_t delete_pmons(void* const self, pus_request_t* const request)
{
    return monitoring_for_each(self, request, forget);
}

static pus_reply_t change_delay(void* const context, pus_request_t* const request)
{
    pus_monitoring_t* const self = context;
    const uint32_t delay         = octet_read_u32(&request->reader);
    const pus_failure_t failure =
        monitoring_save_settings(self, self->is_enabled, self->is_functional, delay);
    if (failure.code == PUS_FAILURE_NONE) {
        self->reporting_delay = delay;
    }
    return monitoring_reply(self, &failure);
}

/// Delete all definitions, also those that are enabled: this is permitted because the monitoring function is
/// disabled.
static pus_reply_t delete_all(void* const context, pus_request_t* const request)
{
    (void)request;
    pus_monitoring_t* const self = context;
    pus_failure_t failure        = pus_failure(self->is_enabled ? PUS_FAILURE_STATE : PUS_FAILURE_NONE, 0U);
    for (uint16_t i = 0U; i < self->config.fmon_capacity; i++) {
        if (self->config.fmons[i].in_use) {
            failure = pus_failure(PUS_FAILURE_STATE, self->config.fmons[i].id);
        }
    }
    if (failure.code != PUS_FAILURE_NONE) {
        return monitoring_reply(self, &failure);
    }
    while ((self->pmon_count > 0U) && (failure.code == PUS_FAILURE_NONE)) {
        failure = drop(self, pmon_at(self, (uint16_t)(self->pmon_count - 1U))->id);
    }
    return (failure.code == PUS_FAILURE_NONE) ? pus_done() : pus_failed(PUS_FAILURE_IO, failure.detail);
}

static pus_failure_t add(pus_monitoring_t* const self, pus_pmon_t* const pmon, const uint32_t offset)
{
    if (monitoring_pmon(self, pmon->id) != NULL) {
        return pus_failure(PUS_FAILURE_EXISTS, pmon->id);
    }
    if (self->pmon_count == self->config.pmon_capacity) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, self->config.pmon_capacity);
    }
    pus_failure_t failure = monitoring_check_pmon(self, MONITORING_FROM_ADD, pmon, offset);
    if (failure.code == PUS_FAILURE_NONE) {
        failure = save(self, pmon);
    }
    if (failure.code == PUS_FAILURE_NONE) {
        insert(self, pmon);
    }
    return failure;
}

/// Modify a definition. Its validity condition and interval are not in the request and do not change.
static pus_failure_t modify(pus_monitoring_t* const self, pus_pmon_t* const pmon, const uint32_t offset)
{
    pus_pmon_t* const there = monitoring_pmon(self, pmon->id);
    if (there == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, pmon->id);
    }
    if (monitoring_is_protected(self, there)) {
        return pus_failure(PUS_FAILURE_PROTECTED, pmon->id);
    }
    if (there->is_enabled) {
        return pus_failure(PUS_FAILURE_STATE, pmon->id);
    }
    if ((there->scalar.id != pmon->scalar.id) || (there->check_type != pmon->check_type)) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    pmon->validity        = there->validity;
    pmon->interval        = there->interval;
    pmon->members         = there->members;
    pus_failure_t failure = monitoring_check_pmon(self, MONITORING_FROM_ADD, pmon, offset);
    if (failure.code == PUS_FAILURE_NONE) {
        failure = save(self, pmon);
    }
    if (failure.code == PUS_FAILURE_NONE) {
        *there = *pmon;
    }
    return failure;
}

typedef pus_failure_t (*define_t)(pus_monitoring_t* self, pus_pmon_t* pmon, uint32_t offset);

static pus_reply_t define_each(pus_monitoring_t* const self, pus_request_t* const request,
                               const monitoring_origin_t origin, const define_t define)
{
    const uint8_t count = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        pus_pmon_t pmon;
        const uint32_t offset = (uint32_t)request->reader.position;
        (void)monitoring_read_pmon(&request->reader, origin, &pmon); // The dispatcher has checked the format.
        const pus_failure_t failure = define(self, &pmon, offset);
        monitoring_settle(self, request, i, &failure);
    }
    return pus_done();
}

static pus_reply_t add_pmons(void* const self, pus_request_t* const request)
{
    return define_each(self, request, MONITORING_FROM_ADD, add);
}

static pus_reply_t modify_pmons(void* const self, pus_request_t* const request)
{
    return define_each(self, request, MONITORING_FROM_MODIFY, modify);
}

static pus_reply_t enable_function(void* const context, pus_request_t* const request)
{
    (void)request;
    pus_monitoring_t* const self = context;
    const pus_failure_t failure =
        monitoring_save_settings(self, true, self->is_functional, self->reporting_delay);
    if ((failure.code == PUS_FAILURE_NONE) && !self->is_enabled) {
        enable_all(self);
    }
    return monitoring_reply(self, &failure);
}

static pus_reply_t disable_function(void* const context, pus_request_t* const request)
{
    (void)request;
    pus_monitoring_t* const self = context;
    pus_failure_t failure        = pus_failure(PUS_FAILURE_STATE, 0U);
    if (!self->is_functional) {
        failure = monitoring_save_settings(self, false, false, self->reporting_delay);
    }
    if (failure.code == PUS_FAILURE_NONE) {
        self->is_enabled = false;
        for (uint16_t i = 0U; i < self->pmon_count; i++) {
            monitoring_uncheck(self, pmon_at(self, i));
        }
    }
    return monitoring_reply(self, &failure);
}

// ---- Reports ----

static pus_reply_t report_pmons(void* const context, pus_request_t* const request)
{
    pus_monitoring_t* const self   = context;
    octet_reader_t ids             = request->reader;
    const uint8_t count            = octet_read_u8(&ids);
    const pus_list_target_t target = pus_list_answer(request, 9U);
    uint8_t delay[sizeof(uint32_t)];
    pus_list_report_t list;
    if (!monitoring_accept_ids(self, request, look_up)) {
        return pus_done();
    }
    octets_put_u32(delay, self->reporting_delay);
    pus_list_report_begin(&list, &target, delay, sizeof delay);
    for (uint8_t i = 0U; i < count; i++) {
        const pus_pmon_t* const pmon = monitoring_pmon(self, octet_read_u16(&ids));
        if (pmon != NULL) {
            monitoring_write_pmon(pus_list_report_entry(&list, MONITORING_PMON_MAX), pmon);
        }
    }
    for (uint16_t i = 0U; (count == 0U) && (i < self->pmon_count); i++) {
        monitoring_write_pmon(pus_list_report_entry(&list, MONITORING_PMON_MAX), pmon_at(self, i));
    }
    return pus_list_report_end(&list);
}

static pus_reply_t report_out_of_limits(void* const context, pus_request_t* const request)
{
    const pus_monitoring_t* const self = context;
    const pus_list_target_t target     = pus_list_answer(request, 11U);
    pus_list_report_t list;
    pus_request_perform(request);
    pus_list_report_begin(&list, &target, NULL, 0U);
    for (uint16_t i = 0U; i < self->pmon_count; i++) {
        const pus_pmon_t* const pmon = pmon_at(self, i);
        if (pmon->status >= (uint8_t)PUS_CHECK_LOW) {
            monitoring_write_transition(pus_list_report_entry(&list, MONITORING_TRANSITION_MAX), &pmon->last);
        }
    }
    return pus_list_report_end(&list);
}

static pus_reply_t report_status(void* const context, pus_request_t* const request)
{
    const pus_monitoring_t* const self = context;
    const pus_list_target_t target     = pus_list_answer(request, 14U);
    pus_list_report_t list;
    pus_request_perform(request);
    pus_list_report_begin(&list, &target, NULL, 0U);
    for (uint16_t i = 0U; i < self->pmon_count; i++) {
        octet_writer_t* const writer = pus_list_report_entry(&list, 3U);
        octet_write_u16(writer, pmon_at(self, i)->id);
        octet_write_u8(writer, pmon_at(self, i)->is_enabled ? 1U : 0U);
    }
    return pus_list_report_end(&list);
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    pus_monitoring_step(self, now_ns, cycle);
}

pus_service_t pus_monitoring_service(pus_monitoring_t* const self)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(12, 1, enable_pmons),
        PUS_REQUEST(12, 2, disable_pmons),
        PUS_REQUEST(12, 3, change_delay),
        PUS_REQUEST(12, 4, delete_all),
        PUS_REQUEST(12, 5, add_pmons),
        PUS_REQUEST(12, 6, delete_pmons),
        PUS_REQUEST(12, 7, modify_pmons),
        PUS_REQUEST(12, 8, report_pmons),
        PUS_REQUEST(12, 10, report_out_of_limits),
        PUS_REQUEST(12, 13, report_status),
        PUS_REQUEST(12, 15, enable_function),
        PUS_REQUEST(12, 16, disable_function),
        PUS_REQUEST(12, 17, monitoring_enable_functional),
        PUS_REQUEST(12, 18, monitoring_disable_functional),
        PUS_REQUEST(12, 19, monitoring_enable_fmons),
        PUS_REQUEST(12, 20, monitoring_disable_fmons),
        PUS_REQUEST(12, 21, monitoring_protect_fmons),
        PUS_REQUEST(12, 22, monitoring_unprotect_fmons),
        PUS_REQUEST(12, 23, monitoring_add_fmons),
        PUS_REQUEST(12, 24, monitoring_delete_fmons),
        PUS_REQUEST(12, 25, monitoring_report_fmons),
        PUS_REQUEST(12, 27, monitoring_report_fmon_status),
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_MONITORING, subtypes, sizeof subtypes / sizeof subtypes[0], self);
    service.step = step;
    return service;
}
