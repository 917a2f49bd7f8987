// SPDX-License-Identifier: Apache-2.0
#include "pus/st18/st18_procedures.h"

#include "base/assertion.h"
#include "generated/pus/st18_request_formats.h"
#include "pus/core/list_report.h"
#include "pus/st18/st18_internal.h"

#include <string.h>

void pus_procedures_init(pus_procedures_t* const self, const pus_procedures_config_t* const config)
{
    FSW_ASSERT((self != NULL) && (config != NULL) && (config->process != NULL) && (config->cycle_ns >= 1U));
    FSW_ASSERT((config->requester != NULL) && (config->procedures != NULL) && (config->runs != NULL));
    FSW_ASSERT(config->calls >= 1U);
    *self = (pus_procedures_t){.config = *config};
    for (uint16_t i = 0U; i < config->capacity; i++) {
        config->procedures[i].in_use = false;
        config->procedures[i].parts  = 0U;
        config->procedures[i].level  = PUS_OBSERVE_NOTHING;
        config->procedures[i].slot   = PUS_PROCEDURE_NONE;
    }
    for (uint16_t i = 0U; i < config->engine.slots; i++) {
        config->runs[i].procedure = PUS_PROCEDURE_NONE;
    }
}

bool pus_procedures_are_active(const pus_procedures_t* const self)
{
    FSW_ASSERT(self != NULL);
    bool are_active = false;
    for (uint16_t i = 0U; i < self->config.engine.slots; i++) {
        if (self->config.runs[i].procedure != PUS_PROCEDURE_NONE) {
            are_active = true;
        }
    }
    return are_active;
}

static pus_reply_t reply_of(pus_procedures_t* const self, const pus_failure_t failure)
{
    if (failure.code == PUS_FAILURE_NONE) {
        return pus_done();
    }
    self->counters.refused++;
    return pus_refused(failure.code, failure.detail);
}

static pus_failure_t none(void)
{
    return pus_no_failure();
}

static const uint8_t* read_id(pus_request_t* const request)
{
    return octet_read_octets(&request->reader, PUS_NAME_SIZE);
}

/// Find the procedure with this id. It must be active if `is_active`, else inactive.
static pus_failure_t find(const pus_procedures_t* const self, const uint8_t* const id, const bool is_active,
                          pus_procedure_t** const out_procedure)
{
    *out_procedure = procedures_find(self, id);
    if (*out_procedure == NULL) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, procedures_detail(id));
    }
    return (((*out_procedure)->slot != PUS_PROCEDURE_NONE) == is_active)
               ? none()
               : pus_failure(PUS_FAILURE_STATE, procedures_detail(id));
}

// ---- Loading ----

static pus_reply_t load(void* const self, pus_request_t* const request)
{
    const uint8_t* const id = read_id(request);
    return reply_of(self, procedures_load(self, id, &request->reader));
}

static pus_file_name_t read_file_name(octet_reader_t* const reader)
{
    pus_file_name_t name = {.path_size = octet_read_u16(reader)};
    name.path            = octet_read_octets(reader, name.path_size);
    name.name_size       = octet_read_u16(reader);
    name.name            = octet_read_octets(reader, name.name_size);
    return name;
}

static pus_reply_t load_by_reference(void* const self, pus_request_t* const request)
{
    const uint8_t* const id    = read_id(request);
    const pus_file_name_t name = read_file_name(&request->reader);
    return reply_of(self, procedures_load_file(self, id, &name));
}

static pus_reply_t unload(void* const self, pus_request_t* const request)
{
    pus_procedure_t* procedure = NULL;
    pus_failure_t failure      = find(self, read_id(request), false, &procedure);
    if (failure.code == PUS_FAILURE_NONE) {
        failure = procedures_unload(self, procedure);
    }
    return reply_of(self, failure);
}

// ---- Activation ----

/// Begin the procedure `id`, whose observability level and arguments follow in the request.
static pus_reply_t begin(pus_procedures_t* const self, pus_request_t* const request, const uint8_t* const id)
{
    pus_procedure_t* procedure  = NULL;
    const uint32_t offset       = (uint32_t)request->reader.position;
    const uint8_t level         = octet_read_u8(&request->reader);
    const pus_failure_t failure = find(self, id, false, &procedure);
    if (failure.code != PUS_FAILURE_NONE) {
        return reply_of(self, failure);
    }
    if (self->is_stopped) {
        return reply_of(self, pus_failure(PUS_FAILURE_STATE, procedures_detail(id)));
    }
    if (level > (uint8_t)PUS_OBSERVE_ALL) {
        return reply_of(self, pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset));
    }
    const size_t size = octet_reader_left(&request->reader);
    procedure->level  = level;
    return procedures_activate(self, request, procedure, octet_read_octets(&request->reader, size), size);
}

static pus_reply_t activate(void* const self, pus_request_t* const request)
{
    return begin(self, request, read_id(request));
}

static pus_reply_t activate_for_one_step(void* const context, pus_request_t* const request)
{
    pus_procedures_t* const self = context;
    const uint8_t* const id      = read_id(request);
    const pus_reply_t reply      = begin(self, request, id);
    if (reply.kind == PUS_LATER) {
        const pus_procedure_t* const procedure = procedures_find(self, id);
        FSW_ASSERT(procedure != NULL); // `begin` has found it.
        procedures_run_of(self, procedure)->suspension = (pus_hold_t){.is_wanted = true};
    }
    return reply;
}

static pus_reply_t load_and_activate(void* const self, pus_request_t* const request)
{
    const pus_file_name_t name  = read_file_name(&request->reader);
    const uint8_t* const id     = read_id(request);
    const pus_failure_t failure = procedures_load_file(self, id, &name);
    return (failure.code == PUS_FAILURE_NONE) ? begin(self, request, id) : reply_of(self, failure);
}

// ---- Active procedures ----

static pus_reply_t stop_at(pus_procedures_t* const self, pus_request_t* const request, const bool unloads)
{
    pus_procedure_t* procedure  = NULL;
    const pus_failure_t failure = find(self, read_id(request), true, &procedure);
    if (failure.code != PUS_FAILURE_NONE) {
        return reply_of(self, failure);
    }
    pus_procedure_run_t* const run = procedures_run_of(self, procedure);
    run->stop    = (pus_hold_t){.is_wanted = true, .step = octet_read_u16(&request->reader)};
    run->unloads = unloads;
    if (run->is_held) { // A suspended procedure reaches no step at which it could stop.
        self->now_ns = request->now_ns;
        procedures_end(self, procedure, PUS_OBSERVED_STOPPED);
    }
    return pus_done();
}

static pus_reply_t stop(void* const self, pus_request_t* const request)
{
    return stop_at(self, request, false);
}

static pus_reply_t stop_and_unload(void* const self, pus_request_t* const request)
{
    return stop_at(self, request, true);
}

/// Find an active procedure. It must be suspended if `is_held`, else running.
static pus_failure_t find_run(const pus_procedures_t* const self, const uint8_t* const id, const bool is_held,
                              pus_procedure_t** const out_procedure)
{
    const pus_failure_t failure = find(self, id, true, out_procedure);
    if ((failure.code == PUS_FAILURE_NONE) && (procedures_run_of(self, *out_procedure)->is_held != is_held)) {
        return pus_failure(PUS_FAILURE_STATE, procedures_detail(id));
    }
    return failure;
}

static pus_reply_t suspend(void* const context, pus_request_t* const request)
{
    pus_procedures_t* const self = context;
    pus_procedure_t* procedure   = NULL;
    const pus_failure_t failure  = find_run(self, read_id(request), false, &procedure);
    if (failure.code == PUS_FAILURE_NONE) {
        procedures_run_of(self, procedure)->suspension =
            (pus_hold_t){.is_wanted = true, .step = octet_read_u16(&request->reader)};
    }
    return reply_of(self, failure);
}

static pus_reply_t go_on(pus_procedures_t* const self, pus_request_t* const request, const bool for_one_step)
{
    pus_procedure_t* procedure  = NULL;
    const pus_failure_t failure = find_run(self, read_id(request), true, &procedure);
    if (failure.code == PUS_FAILURE_NONE) {
        pus_procedure_run_t* const run = procedures_run_of(self, procedure);
        self->now_ns                   = request->now_ns;
        run->is_held                   = false;
        run->suspension                = (pus_hold_t){.is_wanted = for_one_step};
        procedures_report(self, procedure, PUS_OBSERVE_PROCEDURE, PUS_OBSERVED_RESUMED, 0U);
    }
    return reply_of(self, failure);
}

static pus_reply_t resume(void* const self, pus_request_t* const request)
{
    return go_on(self, request, false);
}

static pus_reply_t resume_for_one_step(void* const self, pus_request_t* const request)
{
    return go_on(self, request, true);
}

static pus_reply_t communicate(void* const context, pus_request_t* const request)
{
    pus_procedures_t* const self = context;
    const uint8_t* const id      = read_id(request);
    const size_t size            = octet_reader_left(&request->reader);
    pus_procedure_t* procedure   = NULL;
    pus_failure_t failure        = find(self, id, true, &procedure);
    if (failure.code != PUS_FAILURE_NONE) {
        return reply_of(self, failure);
    }
    pus_procedure_run_t* const run = procedures_run_of(self, procedure);
    if (run->communicated > 0U) {
        failure = pus_failure(PUS_FAILURE_STATE, procedures_detail(id));
    } else if (size > sizeof run->values) {
        failure = pus_failure(PUS_FAILURE_TABLE_FULL, sizeof run->values);
    } else {
        (void)memcpy(run->values, octet_read_octets(&request->reader, size), size);
        run->communicated = (uint16_t)size;
    }
    return reply_of(self, failure);
}

static pus_reply_t abort_one(void* const context, pus_request_t* const request)
{
    pus_procedures_t* const self = context;
    pus_procedure_t* procedure   = NULL;
    const pus_failure_t failure  = find(self, read_id(request), true, &procedure);
    if (failure.code == PUS_FAILURE_NONE) {
        self->now_ns = request->now_ns;
        // An earlier TC[18,20] may wait for its step and would unload the procedure; an abort does not
        // unload.
        procedures_run_of(self, procedure)->unloads = false;
        procedures_end(self, procedure, PUS_OBSERVED_ABORTED);
    }
    return reply_of(self, failure);
}

/// Abort all active procedures.
static void abort_all(pus_procedures_t* const self, const uint64_t now_ns)
{
    self->now_ns = now_ns;
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        pus_procedure_t* const procedure = &self->config.procedures[i];
        procedure->was_aborted           = procedure->slot != PUS_PROCEDURE_NONE;
        if (procedure->was_aborted) {
            procedures_run_of(self, procedure)->unloads = false;
            procedures_end(self, procedure, PUS_OBSERVED_ABORTED);
        }
    }
}

static pus_reply_t abort_and_report(void* const context, pus_request_t* const request)
{
    pus_procedures_t* const self = context;
    pus_list_target_t target     = pus_list_answer(request, 18U);
    pus_list_report_t list;
    // The answer is not attached to the request, because a second execution would abort procedures again.
    target.request = NULL;
    pus_request_perform(request);
    abort_all(self, request->now_ns);
    pus_list_report_begin(&list, &target, NULL, 0U);
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        if (self->config.procedures[i].was_aborted) {
            octet_write_octets(pus_list_report_entry(&list, PUS_NAME_SIZE), self->config.procedures[i].id,
                               PUS_NAME_SIZE);
        }
    }
    return pus_list_report_end(&list);
}

static pus_reply_t set_levels(void* const context, pus_request_t* const request)
{
    pus_procedures_t* const self = context;
    const uint8_t count          = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint8_t* const id          = read_id(request);
        const uint32_t offset            = (uint32_t)request->reader.position;
        const uint8_t level              = octet_read_u8(&request->reader);
        pus_procedure_t* const procedure = procedures_find(self, id);
        if (procedure == NULL) {
            self->counters.refused++;
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, procedures_detail(id));
        } else if (level > (uint8_t)PUS_OBSERVE_ALL) {
            self->counters.refused++;
            pus_request_refuse(request, i, PUS_FAILURE_OUT_OF_RANGE, offset);
        } else {
            pus_request_perform(request);
            procedure->level = level;
        }
    }
    return pus_done();
}

static pus_procedure_status_t status_of(const pus_procedures_t* const self,
                                        const pus_procedure_t* const procedure)
{
    if (procedure->slot == PUS_PROCEDURE_NONE) {
        return PUS_PROCEDURE_INACTIVE;
    }
    return procedures_run_of(self, procedure)->is_held ? PUS_PROCEDURE_HELD : PUS_PROCEDURE_RUNNING;
}

static pus_reply_t report_status(void* const context, pus_request_t* const request)
{
    const pus_procedures_t* const self = context;
    const pus_list_target_t target     = pus_list_answer(request, 9U);
    pus_list_report_t list;
    pus_request_perform(request);
    pus_list_report_begin(&list, &target, NULL, 0U);
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        const pus_procedure_t* const procedure = &self->config.procedures[i];
        if (procedure->in_use) {
            octet_writer_t* const writer = pus_list_report_entry(&list, PUS_NAME_SIZE + 3U);
            octet_write_octets(writer, procedure->id, PUS_NAME_SIZE);
            octet_write_u16(writer, procedure->checksum);
            octet_write_u8(writer, (uint8_t)status_of(self, procedure));
        }
    }
    return pus_list_report_end(&list);
}

// ---- The engine ----

static pus_reply_t start_engine(void* const context, pus_request_t* const request)
{
    (void)request;
    pus_procedures_t* const self = context;
    const pus_failure_t failure  = procedures_save_engine(self, false);
    // If the record cannot be stored, the state does not change, so that a restart finds the same state.
    self->is_stopped = self->is_stopped && (failure.code != PUS_FAILURE_NONE);
    return reply_of(self, failure);
}

static pus_reply_t stop_engine(void* const context, pus_request_t* const request)
{
    pus_procedures_t* const self = context;
    const pus_failure_t failure  = procedures_save_engine(self, true);
    if (failure.code == PUS_FAILURE_NONE) {
        self->is_stopped = true;
        abort_all(self, request->now_ns);
    }
    return reply_of(self, failure);
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    pus_procedures_step(self, now_ns, cycle);
}

pus_service_t pus_procedures_service(pus_procedures_t* const self)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(18, 1, load),
        PUS_REQUEST(18, 2, unload),
        PUS_REQUEST(18, 3, activate),
        PUS_REQUEST(18, 4, stop),
        PUS_REQUEST(18, 5, suspend),
        PUS_REQUEST(18, 6, resume),
        PUS_REQUEST(18, 7, communicate),
        PUS_REQUEST(18, 8, report_status),
        PUS_REQUEST(18, 12, abort_one),
        PUS_REQUEST(18, 13, load_by_reference),
        PUS_REQUEST(18, 14, activate_for_one_step),
        PUS_REQUEST(18, 15, resume_for_one_step),
        PUS_REQUEST(18, 16, set_levels),
        PUS_REQUEST(18, 17, abort_and_report),
        PUS_REQUEST(18, 19, load_and_activate),
        PUS_REQUEST(18, 20, stop_and_unload),
        PUS_REQUEST(18, 21, start_engine),
        PUS_REQUEST(18, 22, stop_engine),
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_PROCEDURES, subtypes, sizeof subtypes / sizeof subtypes[0], self);
    service.step = step;
    return service;
}
