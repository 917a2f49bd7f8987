// SPDX-License-Identifier: Apache-2.0
// Walks the state machine: runs entry actions with their time-outs and reports every change.
#include "fsw/framework/subsystem/component_internal.h"

#include "base/assertion.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

static status_t call(status_t (*const callback)(void*), void* const self)
{
    return (callback != NULL) ? callback(self) : STATUS_OK;
}

// ---- Entry actions ----

static status_t run_software_init(component_t* const component)
{
    if (component->is_action_fresh) {
        parameter_withdraw_all(&component->dictionary);
    }
    const status_t status = call(component->config.callbacks->software_init, component->config.self);
    return (status == STATUS_OK) ? component_initialise_parameters(component) : status;
}

static status_t run_configure(component_t* const component)
{
    if (component->is_action_fresh) {
        component_close_links(component, PUS_LINK_REASON_NONE);
        const status_t status = component_apply_configuration(component);
        if (status != STATUS_OK) {
            return status;
        }
    }
    const subsystem_callbacks_t* const callbacks = component->config.callbacks;
    return (callbacks->configure != NULL)
               ? callbacks->configure(component->config.self, component->configuration)
               : STATUS_OK;
}

static status_t run_post(component_t* const component)
{
    if (component->is_action_fresh) {
        component_close_links(component, PUS_LINK_REASON_STATE);
    }
    return call(component->config.callbacks->post, component->config.self);
}

static status_t run_software_deinit(component_t* const component)
{
    const status_t status = call(component->config.callbacks->software_deinit, component->config.self);
    if (status != STATUS_BUSY) {
        pus_hk_clear(&component->housekeeping); // Structures made by request without a configuration.
        parameter_withdraw_all(&component->dictionary);
    }
    return status;
}

static status_t perform(component_t* const component, const state_action_t action)
{
    const subsystem_callbacks_t* const callbacks = component->config.callbacks;
    void* const self                             = component->config.self;
    switch (action) {
    case ACTION_SOFTWARE_INIT:
        return run_software_init(component);
    case ACTION_HARDWARE_INIT:
        return call(callbacks->hardware_init, self);
    case ACTION_CONFIGURE:
        return run_configure(component);
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
        return run_post(component);
    case ACTION_HARDWARE_DEINIT:
        return call(callbacks->hardware_deinit, self);
    default:
        FSW_ASSERT(action == ACTION_SOFTWARE_DEINIT);
        return run_software_deinit(component);
    }
}

/// An action that continues after a request or an event keeps its time-out: repeating a request does not
/// extend the time-out.
static void start_action(component_t* const component)
{
    const state_machine_t* const machine = &component->machine;
    if (machine->action != component->started_action) { // Each action belongs to one state.
        component->started_action  = machine->action;
        component->is_action_fresh = true;
        component->action_start_ns = component->now_ns;
    }
}

/// Function commands still under way end when the hardware goes away.
static void abort_tickets(component_t* const component)
{
    for (uint32_t ticket = 1U; ticket <= COMPONENT_TICKETS; ticket++) {
        if (ticket != component->ticket_in_call) {
            subsystem_function_done(component, ticket, PUS_FAILURE_ABORTED, 0U);
        }
    }
}

/// docs/states.md: devices that cannot be secured, and failures on the way down, are events; other failures
/// end the request that led to them. STATE_TIMEOUT is the event's name in every descriptor.
static bool is_worth_an_event(const state_action_t action)
{
    return (action == ACTION_SECURE) || (action == ACTION_POST) || (action == ACTION_HARDWARE_DEINIT) ||
           (action == ACTION_SOFTWARE_DEINIT);
}

static void end_action(component_t* const component, const state_action_t action,
                       const state_outcome_t outcome)
{
    const uint16_t codes[] = {[OUTCOME_DONE]    = PUS_FAILURE_NONE,
                              [OUTCOME_FAILED]  = PUS_FAILURE_STEP,
                              [OUTCOME_TIMEOUT] = PUS_FAILURE_TIMEOUT};
    state_machine_outcome(&component->machine, outcome);
    component->started_action = ACTION_NONE;
    component->last_code      = codes[outcome];
    if ((action == ACTION_POST) || ((action == ACTION_CONFIGURE) && (outcome != OUTCOME_DONE))) {
        component_revoke_configuration(component);
    }
    component_after_change(component); // The transition is reported before the event.
    if ((outcome != OUTCOME_DONE) && is_worth_an_event(action)) {
        component_raise(component, "STATE_TIMEOUT");
    }
}

void component_run_action(component_t* const component)
{
    const state_action_t action = component->machine.action;
    FSW_ASSERT(action != ACTION_NONE);
    const status_t status = perform(component, action);
    if (component->machine.action != action) {
        return; // The action itself raised an error that took the machine elsewhere.
    }
    component->is_action_fresh = false;
    const uint64_t limit_ns = (uint64_t)component->descriptor->timeout_us[component->machine.state] * 1000U;
    const bool is_late      = ((component->now_ns - component->action_start_ns) >= limit_ns);
    if (status == STATUS_OK) {
        end_action(component, action, OUTCOME_DONE);
    } else if (status != STATUS_BUSY) {
        end_action(component, action, OUTCOME_FAILED);
    } else if (is_late) {
        end_action(component, action, OUTCOME_TIMEOUT);
    } else {
        // It continues in the next cycle.
    }
}

// ---- Reports ----

static void end_pending(component_t* const component, const uint16_t code, const uint32_t detail)
{
    component->has_pending = false;
    pus_verify_ended(&component->process, &component->pending, pus_failure(code, detail), component->now_ns);
}

static void report_transitions(component_t* const component)
{
    for (uint8_t i = 0U; i < component->machine.transition_count; i++) {
        const state_transition_t* const made = &component->machine.transitions[i];
        const pus_transition_t report        = {.previous      = made->previous,
                                                .state         = made->state,
                                                .phase         = made->phase,
                                                .configuration = component->configuration_id,
                                                .cause         = made->cause,
                                                .code          = component->last_code,
                                                .cycle         = component->cycle};
        (void)pus_transition_report(&component->process, &report, component->now_ns);
        if (component->has_pending && (made->previous != made->state)) {
            pus_verify_progress(&component->process, &component->pending, made->state, component->now_ns);
        }
    }
    component->machine.transition_count = 0U;
}

void component_after_change(component_t* const component)
{
    if (component->machine.action != ACTION_NONE) {
        start_action(component);
    } else {
        component->started_action = ACTION_NONE;
    }
    report_transitions(component);
    if (component->machine.state >= STATE_ERROR_OPERATIONAL) { // In error, or on the way down.
        abort_tickets(component);
    }
    if (component->has_pending && (component->machine.action == ACTION_NONE)) {
        const bool has_failed = component->machine.has_failed;
        end_pending(component, has_failed ? PUS_FAILURE_STEP : PUS_FAILURE_NONE,
                    (uint32_t)component->machine.state);
    }
    component->next_cycle_ns =
        (component->machine.state == STATE_OFFLINE) ? component->now_ns : component->next_cycle_ns;
}

/// The request that was under way has been pre-empted.
static void supersede_pending(component_t* const component)
{
    if (component->has_pending) {
        end_pending(component, PUS_FAILURE_ABORTED, 0U);
    }
}

void component_machine_event(component_t* const component, const state_event_t event,
                             const state_cause_t cause, const uint16_t code)
{
    if (!state_machine_event(&component->machine, event, cause)) {
        return;
    }
    component->last_code   = code;
    const bool was_pending = component->has_pending;
    component->has_pending = false; // Its progress ends here; TM[129,2] comes first.
    component_after_change(component);
    component->has_pending = was_pending;
    supersede_pending(component);
}

// ---- Requests ----

/// The cycle runs at once when a walk begins in OFFLINE, else at its time.
static void take_on(component_t* const component, const pus_token_t* const token)
{
    supersede_pending(component);
    component->has_pending = true;
    component->pending     = *token;
    component->last_code   = 0U;
}

state_answer_t component_request(component_t* const component, const state_t target,
                                 const state_cause_t cause)
{
    const state_answer_t answer = state_machine_request(&component->machine, target, cause);
    if (answer == ANSWER_STARTED) {
        component->last_code = 0U;
        component_after_change(component);
    }
    return answer;
}

pus_reply_t component_request_state(void* const context, const pus_state_order_t* const order,
                                    const pus_token_t* const token, const uint64_t now_ns)
{
    component_t* const component = (component_t*)context;
    const uint8_t target         = order->target;
    component->now_ns            = now_ns;
    uint16_t missing_port        = 0U;
    if (((target == STATE_SAFE_OPERATIONAL) || (target == STATE_OPERATIONAL)) &&
        (component->machine.state < (state_t)target) &&
        !component_has_required_links(component, &missing_port)) {
        return pus_refused(PUS_FAILURE_LINK_MISSING,
                           ((uint32_t)component->descriptor->apid << 16U) | missing_port);
    }
    const state_answer_t verdict = state_machine_verdict(&component->machine, (state_t)target);
    if (verdict == ANSWER_DONE) {
        return pus_done();
    }
    if (verdict != ANSWER_STARTED) {
        return pus_refused(PUS_FAILURE_STATE, target);
    }
    take_on(component, token);
    component->is_medium_pending = false;
    pus_verify_started(&component->process, token, now_ns); // Before the first step of the walk.
    (void)component_request(component, (state_t)target, (state_cause_t)order->cause);
    return pus_started();
}

state_answer_t component_select(component_t* const component, const uint16_t configuration_id)
{
    const descriptor_configuration_t* const configuration =
        descriptor_find_configuration(component->descriptor, configuration_id);
    if (configuration == NULL) {
        return ANSWER_NO;
    }
    const state_answer_t answer = state_machine_configure(&component->machine);
    if (answer == ANSWER_STARTED) {
        component->configuration    = configuration;
        component->configuration_id = configuration_id;
        component->last_code        = 0U;
        component_after_change(component);
    }
    return answer;
}

pus_reply_t component_select_configuration(void* const context, const uint16_t configuration,
                                           const pus_token_t* const token, const uint64_t now_ns)
{
    component_t* const component = (component_t*)context;
    component->now_ns            = now_ns;
    if (descriptor_find_configuration(component->descriptor, configuration) == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, configuration);
    }
    const bool is_at_rest =
        (component->machine.state == STATE_PRE_OPERATIONAL) && (component->machine.action == ACTION_NONE);
    if (!is_at_rest) {
        return pus_refused(PUS_FAILURE_STATE, (uint32_t)component->machine.state);
    }
    take_on(component, token);
    pus_verify_started(&component->process, token, now_ns);
    (void)component_select(component, configuration);
    return pus_started();
}
