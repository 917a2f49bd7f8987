// SPDX-License-Identifier: Apache-2.0
// Executes the state machine: runs entry actions with their time-outs and reports every change.
#include "fsw/framework/subsystem/subsystem_internal.h"

#include "base/assertion.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

static status_t call(status_t (*const callback)(void*), void* const self)
{
    return (callback != NULL) ? callback(self) : STATUS_OK;
}

// ---- Entry actions ----

static status_t run_software_init(subsystem_t* const subsystem)
{
    if (subsystem->is_action_fresh) {
        parameter_withdraw_all(&subsystem->dictionary);
    }
    const status_t status = call(subsystem->config.callbacks->software_init, subsystem->config.self);
    return (status == STATUS_OK) ? subsystem_initialise_parameters(subsystem) : status;
}

static status_t run_configure(subsystem_t* const subsystem)
{
    if (subsystem->is_action_fresh) {
        subsystem_close_links(subsystem, PUS_LINK_REASON_NONE);
        const status_t status = subsystem_apply_configuration(subsystem);
        if (status != STATUS_OK) {
            return status;
        }
    }
    const subsystem_callbacks_t* const callbacks = subsystem->config.callbacks;
    return (callbacks->configure != NULL)
               ? callbacks->configure(subsystem->config.self, subsystem->configuration)
               : STATUS_OK;
}

static status_t run_post(subsystem_t* const subsystem)
{
    if (subsystem->is_action_fresh) {
        subsystem_close_links(subsystem, PUS_LINK_REASON_STATE);
    }
    return call(subsystem->config.callbacks->post, subsystem->config.self);
}

static status_t run_software_deinit(subsystem_t* const subsystem)
{
    const status_t status = call(subsystem->config.callbacks->software_deinit, subsystem->config.self);
    if (status != STATUS_BUSY) {
        // Removes structures that requests have created without a configuration.
        pus_hk_clear(&subsystem->housekeeping);
        parameter_withdraw_all(&subsystem->dictionary);
    }
    return status;
}

/// Call the callback of an action, and do the work of the generic subsystem that belongs to it.
static status_t perform(subsystem_t* const subsystem, const state_action_t action)
{
    const subsystem_callbacks_t* const callbacks = subsystem->config.callbacks;
    void* const self                             = subsystem->config.self;
    switch (action) {
    case ACTION_SOFTWARE_INIT:
        return run_software_init(subsystem);
    case ACTION_HARDWARE_INIT:
        return call(callbacks->hardware_init, self);
    case ACTION_CONFIGURE:
        return run_configure(subsystem);
    case ACTION_START_CONTROL:
        return call(callbacks->start_control, self);
    case ACTION_STOP_CONTROL:
        return call(callbacks->stop_control, self);
    case ACTION_ENGAGE:
        return call(callbacks->engage, self);
    case ACTION_DISENGAGE:
        return call(callbacks->disengage, self);
    case ACTION_SECURE:
        return call(callbacks->secure, self);
    case ACTION_POST:
        return run_post(subsystem);
    case ACTION_HARDWARE_DEINIT:
        return call(callbacks->hardware_deinit, self);
    default:
        FSW_ASSERT(action == ACTION_SOFTWARE_DEINIT);
        return run_software_deinit(subsystem);
    }
}

/// Start the time-out of a new action. An action that continues after a request or an event keeps its
/// time-out, so that repeating a request does not extend it.
static void start_action(subsystem_t* const subsystem)
{
    const state_machine_t* const machine = &subsystem->machine;
    // Each action occurs in one state only, so a new action means a new start.
    if (machine->action != subsystem->started_action) {
        subsystem->started_action  = machine->action;
        subsystem->is_action_fresh = true;
        subsystem->action_start_ns = subsystem->now_ns;
    }
}

/// End the function commands that still run, because the devices are switched off.
static void abort_call_tokens(subsystem_t* const subsystem)
{
    for (uint32_t call_token = 1U; call_token <= SUBSYSTEM_CALL_TOKENS; call_token++) {
        if (call_token != subsystem->token_in_call) {
            subsystem_function_done(subsystem, call_token, PUS_FAILURE_ABORTED, 0U);
        }
    }
}

/// True if the failure of an action raises an event: devices cannot be secured, or the failure is on the way
/// from PRE_OPERATIONAL to OFFLINE. Other failures end the request that led to them (docs/states.md). The
/// event is called STATE_TIMEOUT in every descriptor.
static bool needs_event(const state_action_t action)
{
    return (action == ACTION_SECURE) || (action == ACTION_POST) || (action == ACTION_HARDWARE_DEINIT) ||
           (action == ACTION_SOFTWARE_DEINIT);
}

/// Report the end of an action to the state machine, and release what its end makes invalid.
static void end_action(subsystem_t* const subsystem, const state_action_t action,
                       const state_outcome_t outcome)
{
    const uint16_t codes[] = {[OUTCOME_DONE]    = PUS_FAILURE_NONE,
                              [OUTCOME_FAILED]  = PUS_FAILURE_STEP,
                              [OUTCOME_TIMEOUT] = PUS_FAILURE_TIMEOUT};
    subsystem_state_machine_outcome(&subsystem->machine, outcome);
    subsystem->started_action = ACTION_NONE;
    subsystem->last_code      = codes[outcome];
    if ((action == ACTION_POST) || ((action == ACTION_CONFIGURE) && (outcome != OUTCOME_DONE))) {
        subsystem_revoke_configuration(subsystem);
    }
    subsystem_after_change(subsystem); // Report the transition before the event.
    if ((outcome != OUTCOME_DONE) && needs_event(action)) {
        subsystem_raise_named(subsystem, "STATE_TIMEOUT");
    }
}

void subsystem_run_action(subsystem_t* const subsystem)
{
    const state_action_t action = subsystem->machine.action;
    FSW_ASSERT(action != ACTION_NONE);
    const status_t status = perform(subsystem, action);
    if (subsystem->machine.action != action) {
        return; // The action has raised an event that changed the state.
    }
    subsystem->is_action_fresh = false;
    const uint64_t limit_ns = (uint64_t)subsystem->descriptor->timeout_us[subsystem->machine.state] * 1000U;
    const bool is_late      = ((subsystem->now_ns - subsystem->action_start_ns) >= limit_ns);
    if (status == STATUS_OK) {
        end_action(subsystem, action, OUTCOME_DONE);
    } else if (status != STATUS_BUSY) {
        end_action(subsystem, action, OUTCOME_FAILED);
    } else if (is_late) {
        end_action(subsystem, action, OUTCOME_TIMEOUT);
    } else {
        // The action continues in the next cycle.
    }
}

// ---- Reports ----

static void end_pending(subsystem_t* const subsystem, const uint16_t code, const uint32_t detail)
{
    subsystem->has_pending = false;
    pus_verify_ended(&subsystem->process, &subsystem->pending, pus_failure(code, detail), subsystem->now_ns);
}

static void report_transitions(subsystem_t* const subsystem)
{
    for (uint8_t i = 0U; i < subsystem->machine.transition_count; i++) {
        const state_transition_t* const made = &subsystem->machine.transitions[i];
        const pus_transition_t report        = {.previous      = made->previous,
                                                .state         = made->state,
                                                .phase         = made->phase,
                                                .configuration = subsystem->configuration_id,
                                                .cause         = made->cause,
                                                .code          = subsystem->last_code,
                                                .cycle         = subsystem->cycle};
        (void)pus_transition_report(&subsystem->process, &report, subsystem->now_ns);
        if (subsystem->has_pending && (made->previous != made->state)) {
            pus_verify_progress(&subsystem->process, &subsystem->pending, made->state, subsystem->now_ns);
        }
    }
}

void subsystem_after_change(subsystem_t* const subsystem)
{
    if (subsystem->machine.action != ACTION_NONE) {
        start_action(subsystem);
    } else {
        subsystem->started_action = ACTION_NONE;
    }
    report_transitions(subsystem);
    // ERROR_OPERATIONAL, or a state on the way down.
    if (subsystem->machine.state >= STATE_ERROR_OPERATIONAL) {
        abort_call_tokens(subsystem);
    }
    if (subsystem->has_pending && (subsystem->machine.action == ACTION_NONE)) {
        const bool has_failed = subsystem->machine.has_failed;
        end_pending(subsystem, has_failed ? PUS_FAILURE_STEP : PUS_FAILURE_NONE,
                    (uint32_t)subsystem->machine.state);
    }
    // The first cycle after OFFLINE is due at once.
    subsystem->next_cycle_ns =
        (subsystem->machine.state == STATE_OFFLINE) ? subsystem->now_ns : subsystem->next_cycle_ns;
}

/// End the running request, if there is one, because another request or event has pre-empted it.
static void supersede_pending(subsystem_t* const subsystem)
{
    if (subsystem->has_pending) {
        end_pending(subsystem, PUS_FAILURE_ABORTED, 0U);
    }
}

void subsystem_machine_event(subsystem_t* const subsystem, const state_event_t event,
                             const state_cause_t cause, const uint16_t code)
{
    if (!subsystem_state_machine_event(&subsystem->machine, event, cause)) {
        return;
    }
    subsystem->last_code   = code;
    const bool was_pending = subsystem->has_pending;
    // Suppresses progress reports of the request while TM[129,2] is sent; the request ends afterwards.
    subsystem->has_pending = false;
    subsystem_after_change(subsystem);
    subsystem->has_pending = was_pending;
    supersede_pending(subsystem);
}

// ---- Requests ----

/// Make a request the pending one.
static void take_on(subsystem_t* const subsystem, const pus_token_t* const token)
{
    supersede_pending(subsystem);
    subsystem->has_pending = true;
    subsystem->pending     = *token;
}

state_answer_t subsystem_request(subsystem_t* const subsystem, const state_t target,
                                 const state_cause_t cause)
{
    const state_answer_t answer = subsystem_state_machine_request(&subsystem->machine, target, cause);
    if (answer == ANSWER_STARTED) {
        subsystem->last_code = 0U;
        subsystem_after_change(subsystem);
    }
    return answer;
}

pus_reply_t subsystem_request_state(void* const context, const pus_state_order_t* const order,
                                    const pus_token_t* const token, const uint64_t now_ns)
{
    subsystem_t* const subsystem = (subsystem_t*)context;
    const uint8_t target         = order->target;
    subsystem->now_ns            = now_ns;
    uint16_t missing_port        = 0U;
    if (((target == STATE_SAFE_OPERATIONAL) || (target == STATE_OPERATIONAL)) &&
        (subsystem->machine.state < (state_t)target) &&
        !subsystem_has_required_links(subsystem, &missing_port)) {
        return pus_refused(PUS_FAILURE_LINK_MISSING,
                           ((uint32_t)subsystem->descriptor->apid << 16U) | missing_port);
    }
    const state_answer_t verdict = subsystem_state_machine_verdict(&subsystem->machine, (state_t)target);
    if (verdict == ANSWER_DONE) {
        return pus_done();
    }
    if (verdict != ANSWER_STARTED) {
        return pus_refused(PUS_FAILURE_STATE, target);
    }
    take_on(subsystem, token);
    // Must precede the reports of the first transition.
    pus_verify_started(&subsystem->process, token, now_ns);
    (void)subsystem_request(subsystem, (state_t)target, (state_cause_t)order->cause);
    return pus_started();
}

state_answer_t subsystem_select(subsystem_t* const subsystem, const uint16_t configuration_id)
{
    const descriptor_configuration_t* const configuration =
        descriptor_find_configuration(subsystem->descriptor, configuration_id);
    if (configuration == NULL) {
        return ANSWER_NO;
    }
    const state_answer_t answer = subsystem_state_machine_configure(&subsystem->machine);
    if (answer == ANSWER_STARTED) {
        subsystem->configuration    = configuration;
        subsystem->configuration_id = configuration_id;
        subsystem->last_code        = 0U;
        subsystem_after_change(subsystem);
    }
    return answer;
}

pus_reply_t subsystem_select_configuration(void* const context, const uint16_t configuration,
                                           const pus_token_t* const token, const uint64_t now_ns)
{
    subsystem_t* const subsystem = (subsystem_t*)context;
    subsystem->now_ns            = now_ns;
    if (descriptor_find_configuration(subsystem->descriptor, configuration) == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, configuration);
    }
    const bool is_at_rest =
        (subsystem->machine.state == STATE_PRE_OPERATIONAL) && (subsystem->machine.action == ACTION_NONE);
    if (!is_at_rest) {
        return pus_refused(PUS_FAILURE_STATE, (uint32_t)subsystem->machine.state);
    }
    take_on(subsystem, token);
    pus_verify_started(&subsystem->process, token, now_ns);
    (void)subsystem_select(subsystem, configuration);
    return pus_started();
}
