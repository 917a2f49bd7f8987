// SPDX-License-Identifier: Apache-2.0
#include "base/assertion.h"
#include "pus/st01/st01_verification.h"
#include "pus/st18/st18_internal.h"

#include <string.h>

#define OBSERVATION_SIZE 60U // Size of the auxiliary data of an observation [octets].
#define OWN_EVENT_SIZE 10U   // Size of the auxiliary data of an event that a procedure raises [octets].
#define NS_PER_S 1e9
#define NS_PER_MS 1000000U

// ---- Observing ----

/// Present step of a procedure; 0 if it is inactive.
static uint16_t step_of(const pus_procedures_t* const self, const pus_procedure_t* const procedure)
{
    return (procedure->slot == PUS_PROCEDURE_NONE) ? 0U : self->config.runs[procedure->slot].step;
}

static void raise_event(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                        const uint16_t event, const pus_observation_t what, const uint32_t detail,
                        const char* const text)
{
    uint8_t octets[OBSERVATION_SIZE] = {0};
    octet_writer_t writer            = octet_writer(octets, sizeof octets);
    if (event == 0U) {
        return;
    }
    octet_write_octets(&writer, procedure->id, PUS_NAME_SIZE);
    octet_write_u8(&writer, (uint8_t)what);
    octet_write_u16(&writer, step_of(self, procedure));
    octet_write_u32(&writer, detail);
    for (size_t i = 0U; (i < PUS_OBSERVATION_TEXT) && (text[i] != '\0'); i++) {
        octet_write_u8(&writer, (uint8_t)text[i]);
    }
    self->config.events.raise(self->config.events.context, event, octets, sizeof octets, self->now_ns);
}

void procedures_report(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                       const pus_observability_t level, const pus_observation_t what, const uint32_t detail)
{
    if (procedure->level >= (uint8_t)level) {
        raise_event(self, procedure, self->config.observation_event, what, detail, "");
    }
}

// ---- Beginning and end ----

pus_procedure_run_t* procedures_run_of(const pus_procedures_t* const self,
                                       const pus_procedure_t* const procedure)
{
    FSW_ASSERT(procedure->slot != PUS_PROCEDURE_NONE);
    return &self->config.runs[procedure->slot];
}

static uint16_t find_slot(const pus_procedures_t* const self)
{
    uint16_t slot = 0U;
    while ((slot < self->config.engine.slots) && (self->config.runs[slot].procedure != PUS_PROCEDURE_NONE)) {
        slot++;
    }
    return slot;
}

pus_reply_t procedures_activate(pus_procedures_t* const self, const pus_request_t* const request,
                                pus_procedure_t* const procedure, const uint8_t* const arguments,
                                const size_t size)
{
    const pus_procedure_port_t* const engine = &self->config.engine;
    const uint16_t slot                      = find_slot(self);
    char name[PUS_NAME_SIZE + 1U]            = {0};
    pus_call_t call                          = {0};
    if (slot == engine->slots) {
        self->counters.refused++;
        return pus_refused(PUS_FAILURE_TABLE_FULL, engine->slots);
    }
    self->now_ns = request->now_ns;
    (void)memcpy(name, procedure->id, PUS_NAME_SIZE);
    if (engine->start(engine->context, slot, name, procedure->code, procedure->size, arguments, size,
                      &call) != STATUS_OK) {
        self->counters.failed++;
        raise_event(self, procedure, self->config.failure_event, PUS_OBSERVED_FAILED, call.number, call.text);
        return pus_failed(PUS_FAILURE_PROCEDURE, call.number);
    }
    pus_procedure_run_t* const run = &self->config.runs[slot];

    run->procedure    = (uint16_t)(procedure - self->config.procedures);
    run->is_held      = false;
    run->unloads      = false;
    run->step         = 0U;
    run->stop         = (pus_hold_t){0};
    run->suspension   = (pus_hold_t){0};
    run->token        = request->token;
    run->waiting      = PUS_WAITS_NOT;
    run->until        = 0U;
    run->answer       = (pus_answer_t){.kind = PUS_ANSWER_NONE};
    run->communicated = 0U;
    procedure->slot   = slot;
    self->counters.started++;
    procedures_report(self, procedure, PUS_OBSERVE_PROCEDURE, PUS_OBSERVED_STARTED, 0U);
    return pus_later();
}

/// Make a procedure inactive, and complete its request; the request has failed if `failure` has a code.
static void release(pus_procedures_t* const self, pus_procedure_t* const procedure,
                    const pus_failure_t failure)
{
    pus_procedure_run_t* const run = procedures_run_of(self, procedure);
    run->procedure                 = PUS_PROCEDURE_NONE;
    procedure->slot                = PUS_PROCEDURE_NONE;
    pus_verify_ended(self->config.process, &run->token, failure, self->now_ns);
}

void procedures_end(pus_procedures_t* const self, pus_procedure_t* const procedure,
                    const pus_observation_t what)
{
    const pus_procedure_port_t* const engine = &self->config.engine;
    const bool unloads                       = procedures_run_of(self, procedure)->unloads;
    engine->kill(engine->context, procedure->slot);
    self->counters.aborted++;
    procedures_report(self, procedure, PUS_OBSERVE_PROCEDURE, what, 0U);
    release(self, procedure, pus_failure(PUS_FAILURE_ABORTED, 0U));
    if (unloads) {
        // If the erasure fails, it is counted, and the procedure stays loaded.
        (void)procedures_unload(self, procedure);
    }
}

static void complete(pus_procedures_t* const self, pus_procedure_t* const procedure)
{
    self->counters.ended++;
    procedures_report(self, procedure, PUS_OBSERVE_PROCEDURE, PUS_OBSERVED_ENDED, 0U);
    release(self, procedure, pus_no_failure());
}

static void fail(pus_procedures_t* const self, pus_procedure_t* const procedure, const pus_call_t* const call)
{
    self->counters.failed++;
    raise_event(self, procedure, self->config.failure_event, PUS_OBSERVED_FAILED, call->number, call->text);
    release(self, procedure, pus_failure(PUS_FAILURE_PROCEDURE, call->number));
}

// ---- Calls. The functions that return a bool return true if the procedure continues in this cycle. ----

/// Answer a call with a result.
static void set_result(pus_procedure_run_t* const run, const uint16_t code, const uint32_t detail)
{
    run->answer  = (pus_answer_t){.kind = PUS_ANSWER_VERDICT, .code = code, .detail = detail};
    run->waiting = PUS_WAITS_NOT;
}

static bool matches(const pus_hold_t* const hold, const uint16_t step)
{
    return hold->is_wanted && ((hold->step == 0U) || (hold->step == step));
}

static bool begin_step(pus_procedures_t* const self, pus_procedure_t* const procedure,
                       pus_procedure_run_t* const run)
{
    run->step = (uint16_t)run->call.number;
    procedures_report(self, procedure, PUS_OBSERVE_STEPS, PUS_OBSERVED_STEP, run->step);
    if (matches(&run->stop, run->step)) {
        procedures_end(self, procedure, PUS_OBSERVED_STOPPED);
        return false;
    }
    pus_verify_progress(self->config.process, &run->token, run->step, self->now_ns);
    if (matches(&run->suspension, run->step)) {
        run->suspension = (pus_hold_t){0};
        run->is_held    = true;
        procedures_report(self, procedure, PUS_OBSERVE_PROCEDURE, PUS_OBSERVED_HELD, run->step);
    }
    return !run->is_held;
}

/// Wait for a number of seconds. True if the waiting time is 0.
static bool wait_for(const pus_procedures_t* const self, pus_procedure_run_t* const run,
                     const pus_waiting_t waiting)
{
    const double wanted = (run->call.seconds * NS_PER_S) / (double)self->config.cycle_ns;
    const uint64_t down = (uint64_t)wanted;
    run->until          = self->cycle + down + (((double)down < wanted) ? 1U : 0U);
    run->waiting        = (run->until > self->cycle) ? waiting : PUS_WAITS_NOT;
    return run->waiting == PUS_WAITS_NOT;
}

static bool send(pus_procedures_t* const self, const pus_procedure_t* const procedure,
                 pus_procedure_run_t* const run)
{
    const pus_call_t* const call     = &run->call;
    pus_requester_t* const requester = self->config.requester;
    pus_token_t token                = {0};
    octet_writer_t writer            = pus_tc_begin(requester, call->apid, call->service, call->subtype,
                                         call->does_wait ? (PUS_ACK_ACCEPTANCE | PUS_ACK_COMPLETION) : 0U);
    if (call->size > 0U) {
        octet_write_octets(&writer, call->octets, call->size);
    }
    const status_t status = pus_tc_send(requester, &writer, &token);
    if (status == STATUS_FULL) {
        run->waiting = PUS_WAITS_PORT;
        return false;
    }
    if (status != STATUS_OK) {
        set_result(run, PUS_FAILURE_TABLE_FULL, PUS_ADDRESSEES);
        return true;
    }
    self->counters.sent++;
    procedures_report(self, procedure, PUS_OBSERVE_ALL, PUS_OBSERVED_SENT,
                      ((uint32_t)call->service << 8U) | call->subtype);
    set_result(run, PUS_FAILURE_NONE, 0U);
    if (call->does_wait) {
        run->waiting    = PUS_WAITS_VERIFICATION;
        run->request_id = token.request_id;
        run->until      = self->cycle + self->config.verification_cycles;
    }
    return !call->does_wait;
}

static void get(const pus_procedures_t* const self, pus_procedure_run_t* const run)
{
    const pus_telemetry_port_t* const telemetry = &self->config.telemetry;
    pus_answer_t* const answer                  = &run->answer;
    const status_t status =
        (run->call.kind == PUS_CALL_GET_NAMED)
            ? telemetry->read_named(telemetry->context, run->call.text, &answer->type, &answer->bits)
            : telemetry->read(telemetry->context, run->call.number, &answer->type, &answer->bits);
    answer->kind = (status == STATUS_OK) ? PUS_ANSWER_VALUE : PUS_ANSWER_MISSING;
}

static void raise_own(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                      pus_procedure_run_t* const run)
{
    const pus_event_port_t* const events = &self->config.events;
    const uint16_t event                 = (uint16_t)run->call.number;
    uint8_t octets[OWN_EVENT_SIZE];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    if (!events->is_known(events->context, event)) {
        set_result(run, PUS_FAILURE_UNKNOWN_ID, event);
        return;
    }
    octet_write_octets(&writer, procedure->id, PUS_NAME_SIZE);
    octet_write_u16(&writer, run->step);
    events->raise(events->context, event, octets, sizeof octets, self->now_ns);
    set_result(run, PUS_FAILURE_NONE, 0U);
}

/// Pass the communicated parameters to the procedure. False: there are none.
static bool take_parameters(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                            pus_procedure_run_t* const run)
{
    if (run->communicated == 0U) {
        return false;
    }
    (void)memcpy(run->taken, run->values, run->communicated);
    run->answer = (pus_answer_t){.kind = PUS_ANSWER_VALUES, .octets = run->taken, .size = run->communicated};
    run->communicated = 0U;
    run->waiting      = PUS_WAITS_NOT;
    procedures_report(self, procedure, PUS_OBSERVE_ALL, PUS_OBSERVED_RECEIVED, 0U);
    return true;
}

static bool want_parameters(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                            pus_procedure_run_t* const run)
{
    if (take_parameters(self, procedure, run)) {
        return true;
    }
    run->answer = (pus_answer_t){.kind = PUS_ANSWER_MISSING}; // The answer if no parameters arrive in time.
    return wait_for(self, run, PUS_WAITS_PARAMETERS);
}

static bool perform(pus_procedures_t* const self, pus_procedure_t* const procedure,
                    pus_procedure_run_t* const run)
{
    run->answer = (pus_answer_t){.kind = PUS_ANSWER_NONE};
    switch (run->call.kind) {
    case PUS_CALL_STEP:
        return begin_step(self, procedure, run);
    case PUS_CALL_WAIT:
        return wait_for(self, run, PUS_WAITS_TIME);
    case PUS_CALL_SEND:
        return send(self, procedure, run);
    case PUS_CALL_GET:
    case PUS_CALL_GET_NAMED:
        get(self, run);
        return true;
    case PUS_CALL_EVENT:
        raise_own(self, procedure, run);
        return true;
    case PUS_CALL_PARAMETERS:
        return want_parameters(self, procedure, run);
    case PUS_CALL_ENDED:
        complete(self, procedure);
        return false;
    case PUS_CALL_FAILED:
        fail(self, procedure, &run->call);
        return false;
    case PUS_CALL_PAUSED:
    default:
        return false;
    }
}

/// End the waiting of a procedure if its condition is met or its time is over.
static void check_waiting(pus_procedures_t* const self, const pus_procedure_t* const procedure,
                          pus_procedure_run_t* const run)
{
    if (run->waiting == PUS_WAITS_PORT) {
        (void)send(self, procedure, run);
    } else if (run->waiting == PUS_WAITS_PARAMETERS) {
        (void)take_parameters(self, procedure, run);
    } else {
        // The procedure waits for a time or for a verification report.
    }
    const bool is_over = self->cycle >= run->until;
    if (is_over && (run->waiting == PUS_WAITS_VERIFICATION)) {
        const uint64_t ms = (self->config.verification_cycles * self->config.cycle_ns) / NS_PER_MS;
        set_result(run, PUS_FAILURE_TIMEOUT, (uint32_t)ms);
    }
    if (is_over && (run->waiting != PUS_WAITS_PORT)) {
        run->waiting = PUS_WAITS_NOT;
    }
}

/// True if a call causes a report or a request.
static bool has_effect(const pus_call_kind_t kind)
{
    return (kind == PUS_CALL_STEP) || (kind == PUS_CALL_EVENT) || (kind == PUS_CALL_SEND);
}

/// Step the procedure in a slot, with a budget of at most `share` units. Returns the units used.
static uint32_t step_run(pus_procedures_t* const self, const uint16_t slot, const uint32_t share)
{
    const pus_procedure_port_t* const engine = &self->config.engine;
    pus_procedure_run_t* const run           = &self->config.runs[slot];
    pus_procedure_t* const procedure         = &self->config.procedures[run->procedure];
    if (run->waiting != PUS_WAITS_NOT) {
        check_waiting(self, procedure, run);
    }
    const bool runs = (run->waiting == PUS_WAITS_NOT) && !run->is_held && (share > 0U);
    bool goes_on    = runs;
    uint16_t calls  = 0U;
    if (goes_on) {
        engine->grant(engine->context, slot, share);
    }
    while (goes_on) {
        engine->run(engine->context, slot, &run->answer, &run->call);
        calls   = (uint16_t)(calls + (has_effect(run->call.kind) ? 1U : 0U));
        goes_on = perform(self, procedure, run) && (calls < self->config.calls);
    }
    return runs ? engine->used(engine->context, slot) : 0U;
}

void pus_procedures_step(pus_procedures_t* const self, const uint64_t now_ns, const uint32_t cycle)
{
    FSW_ASSERT(self != NULL);
    const pus_persistence_t* const store = self->config.persistence;
    const uint32_t budget                = self->config.budget;
    uint32_t excess                      = 0U; // Units used beyond the share; the next procedures get less.
    bool unloads                         = false;
    self->cycle += (uint32_t)(cycle - self->last_cycle);
    self->last_cycle = cycle;
    self->now_ns     = now_ns;
    for (uint16_t slot = 0U; slot < self->config.engine.slots; slot++) {
        if (self->config.runs[slot].procedure != PUS_PROCEDURE_NONE) {
            const uint32_t share = (excess < budget) ? (budget - excess) : 0U;
            unloads              = unloads || self->config.runs[slot].unloads;
            const uint32_t used  = step_run(self, slot, share);
            excess               = (excess - (budget - share)) + ((used > share) ? (used - share) : 0U);
        }
    }
    if (unloads && (store != NULL)) {
        self->counters.unsaved += (store->commit(store->context) == STATUS_OK) ? 0U : 1U;
    }
}

void pus_procedures_observe(pus_procedures_t* const self, const pus_tm_t* const tm)
{
    FSW_ASSERT((self != NULL) && (tm != NULL));
    pus_verification_t verification = {0};
    if ((tm->destination != self->config.requester->source) ||
        (pus_verification_read(tm, &verification) != STATUS_OK) ||
        !pus_verification_is_final(&verification)) {
        return;
    }
    for (uint16_t slot = 0U; slot < self->config.engine.slots; slot++) {
        pus_procedure_run_t* const run = &self->config.runs[slot];
        if ((run->procedure != PUS_PROCEDURE_NONE) && (run->waiting == PUS_WAITS_VERIFICATION) &&
            (run->request_id == verification.request_id)) {
            set_result(run, verification.failure.code, verification.failure.detail);
        }
    }
}
