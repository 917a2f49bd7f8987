// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/component.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/component_internal.h"

#include "pus/st01/st01_verification.h"

#include <string.h>

#define AUXILIARY_MAX 256U
#define IDLE_PERIOD_NS 10000000ULL ///< Where the descriptor has none.

void component_set_pool_thresholds(component_t* const component)
{
    const uint8_t warn  = component->descriptor->pool_warn_percent;
    const uint8_t low   = component->descriptor->pool_clear_percent;
    const uint8_t clear = (uint8_t)((low > 0U) ? low : 1U);
    if (warn > clear) { // A refused descriptor has no content.
        pool_set_thresholds(&component->tickets, warn, clear);
    }
}

static void init_tickets(component_t* const component)
{
    const pool_setup_t setup = {.block_octets  = sizeof(pus_token_t),
                                .block_count   = COMPONENT_TICKETS,
                                .reserve       = 1U,
                                .warn_percent  = (uint8_t)POOL_WARN_PERCENT,
                                .clear_percent = (uint8_t)POOL_CLEAR_PERCENT};
    pool_init(&component->tickets, component->ticket_storage, component->ticket_slots, &setup);
    component_set_pool_thresholds(component);
}

void component_set_idle_period(component_t* const component)
{
    const uint64_t period_ns = (uint64_t)component->descriptor->sampling_us * 1000U;
    component->period_ns     = (period_ns > 0U) ? period_ns : IDLE_PERIOD_NS;
}

void component_init(component_t* const component, const component_config_t* const config)
{
    FSW_ASSERT((component != NULL) && (config != NULL) && (config->descriptor != NULL) &&
               (config->callbacks != NULL) && (config->start_count >= 1U) &&
               (config->status_interval_ns > 0U));
    (void)memset(component, 0, sizeof *component);
    component->config     = *config;
    component->descriptor = config->descriptor;
    state_machine_init(&component->machine, config->is_descriptor_valid);
    component_set_idle_period(component);
    const status_t status =
        parameter_init(&component->dictionary, component->entries, DESCRIPTOR_PARAMETERS_MAX,
                       component->bounds, DESCRIPTOR_FIELDS_MAX);
    FSW_ASSERT(status == STATUS_OK);
    init_tickets(component);
    pus_process_init(&component->process, config->descriptor->apid, config->mission_epoch_s, &config->port);
    pus_process_keep(&component->process, &component->rings);
    component_register_services(component);
}

pus_process_t* component_process(component_t* const component)
{
    return &component->process;
}

bool component_may_accept(component_t* const component)
{
    FSW_ASSERT(component != NULL);
    if (!pus_process_may_answer(&component->process)) {
        (void)pus_process_flush(&component->process); // The port may take it by now.
    }
    return pus_process_may_answer(&component->process) &&
           !pus_dispatcher_is_answering(&component->dispatcher);
}

void component_accept(component_t* const component, const uint8_t* const packet, const size_t size,
                      const uint64_t now_ns)
{
    FSW_ASSERT((component != NULL) && (packet != NULL));
    component->now_ns = now_ns;
    if (component->config.supervisor_patience_ns > 0U) {
        component->supervisor_heard_ns = now_ns;
        component->is_supervisor_lost  = false;
    }
    if (pus_packet_is_tc(packet, size)) {
        (void)pus_dispatch(&component->dispatcher, packet, size, now_ns);
    } else if (component->config.callbacks->report != NULL) {
        component->config.callbacks->report(component->config.self, packet, size);
    } else {
        // A heartbeat of the supervisor: having come is all it says.
    }
}

void component_accept_large(component_t* const component, const uint8_t* const packet, const size_t size,
                            const uint64_t now_ns)
{
    FSW_ASSERT((component != NULL) && (packet != NULL));
    component->now_ns = now_ns;
    (void)pus_dispatch_large(&component->dispatcher, packet, size, now_ns);
}

/// After a MEDIUM error the component waits a few cycles for the supervisor, then reacts itself.
static void watch_medium(component_t* const component)
{
    if (!component->is_medium_pending) {
        return;
    }
    if (component->machine.state != STATE_OPERATIONAL) {
        component->is_medium_pending = false;
    } else if ((component->cycle - component->medium_cycle) >= COMPONENT_MEDIUM_CYCLES) {
        component->is_medium_pending = false;
        component_machine_event(component, EVENT_MEDIUM_ORDER, CAUSE_OWN_ERROR, component->last_code);
    } else {
        // The order may still come.
    }
}

static bool is_hardware_live(const state_t state)
{
    return (state >= STATE_HARDWARE_INIT) && (state <= STATE_HARDWARE_DEINIT);
}

static bool is_controlled(const component_t* const component)
{
    const state_t state = component->machine.state;
    return ((state >= STATE_SAFE_OPERATIONAL) && (state <= STATE_ERROR_OPERATIONAL)) ||
           ((state == STATE_PRE_OPERATIONAL) && component->machine.is_configured);
}

static void call(void (*const callback)(void*), void* const self)
{
    if (callback != NULL) {
        callback(self);
    }
}

static void run_cycle(component_t* const component)
{
    const subsystem_callbacks_t* const callbacks = component->config.callbacks;
    void* const self                             = component->config.self;
    const bool is_live                           = is_hardware_live(component->machine.state);
    component->cycle++;
    if (is_live) {
        call(callbacks->sense, self);
    }
    component_watch_links(component);
    watch_medium(component);
    if (component->machine.action != ACTION_NONE) {
        component_run_action(component);
    }
    if (is_controlled(component)) {
        call(callbacks->control, self);
    }
    if ((component->machine.action == ACTION_SECURE) && component->is_action_fresh) {
        component_run_action(component); // An error in this cycle: safe before anything is emitted.
    }
    if (is_live || is_hardware_live(component->machine.state)) {
        call(callbacks->emit, self);
    }
    if (component->configuration != NULL) {
        pus_hk_step(&component->housekeeping, component->now_ns, component->cycle);
    }
}

static void watch_supervisor(component_t* const component)
{
    const bool is_silent =
        !component->is_supervisor_lost && (component->supervisor_heard_ns > 0U) &&
        ((component->now_ns - component->supervisor_heard_ns) > component->config.supervisor_patience_ns);
    if (is_silent) {
        component->is_supervisor_lost = true;
        component_machine_event(component, EVENT_SUPERVISOR_LOST, CAUSE_SUPERVISOR_LOST, 0U);
    }
}

void component_raise(component_t* const component, const char* const name)
{
    const descriptor_event_t* const event = descriptor_find_event_name(component->descriptor, name);
    if (event != NULL) {
        (void)subsystem_raise(component, event->id, NULL, 0U);
    }
}

static void watch_pools(component_t* const component)
{
    if (pool_poll_warning(&component->tickets)) {
        component_raise(component, "POOL_WARNING");
    }
}

static void report_status(component_t* const component)
{
    pus_subsystem_status_t status;
    component->management.port.read_status(component, &status);
    (void)pus_subsystem_status_report(&component->process, PUS_USER_GROUND, &status, component->now_ns);
}

/// The cycle after `now`, on the grid of the period from the start of the run.
static uint64_t next_on_grid(const uint64_t now_ns, const uint64_t period_ns)
{
    return ((now_ns / period_ns) + 1U) * period_ns;
}

void component_tell_time(component_t* const component, const uint64_t now_ns)
{
    FSW_ASSERT(component != NULL);
    component->now_ns = now_ns;
}

/// In OFFLINE only optional services have work.
static bool is_cyclic(const component_t* const component)
{
    return (component->machine.state != STATE_OFFLINE) || (component->optional_count > 0U);
}

static uint64_t step_own_loop(component_t* const component)
{
    const uint64_t now_ns   = component->now_ns;
    const bool is_answering = pus_dispatcher_resume(&component->dispatcher, now_ns);
    if (is_cyclic(component) && (now_ns >= component->next_cycle_ns)) {
        if (component->machine.state != STATE_OFFLINE) {
            run_cycle(component);
        }
        component_step_optional(component);
        component->next_cycle_ns = next_on_grid(now_ns, component->period_ns);
    }
    component_empty_mailboxes(component);
    component_take_reload(component);
    watch_supervisor(component);
    watch_pools(component);
    (void)pus_events_step(&component->events, now_ns); // Others wait for the step of a status report.
    if (now_ns >= component->next_status_ns) {
        report_status(component);
        component->next_status_ns = next_on_grid(now_ns, component->config.status_interval_ns);
    }
    if (is_answering || pus_process_is_waiting(&component->process)) {
        return next_on_grid(now_ns, component->period_ns);
    }
    return (is_cyclic(component) && (component->next_cycle_ns < component->next_status_ns))
               ? component->next_cycle_ns
               : component->next_status_ns;
}

uint64_t component_step(component_t* const component, const uint64_t now_ns)
{
    FSW_ASSERT(component != NULL);
    component->now_ns = now_ns;
    (void)component_step_loops(component);
    const uint64_t own_ns   = step_own_loop(component);
    const uint64_t loops_ns = component_step_loops(component); // Those that there are now.
    return (loops_ns < own_ns) ? loops_ns : own_ns;
}

// ---- What a specific subsystem calls (subsystem.h) ----

uint64_t subsystem_now_ns(const subsystem_t* const subsystem)
{
    return subsystem->now_ns;
}

uint32_t subsystem_cycle(const subsystem_t* const subsystem)
{
    return subsystem->cycle;
}

uint64_t subsystem_device_deadline_ns(const subsystem_t* const subsystem)
{
    FSW_ASSERT(subsystem != NULL);
    return subsystem->config.device_deadline_ns;
}

uint64_t subsystem_period_ns(const subsystem_t* const subsystem)
{
    return subsystem->period_ns;
}

state_t subsystem_state(const subsystem_t* const subsystem)
{
    return subsystem->machine.state;
}

uint64_t subsystem_action_age_ns(const subsystem_t* const subsystem)
{
    return subsystem->now_ns - subsystem->action_start_ns;
}

const descriptor_configuration_t* subsystem_configuration(const subsystem_t* const subsystem)
{
    return subsystem->configuration;
}

const subsystem_descriptor_t* subsystem_descriptor(const subsystem_t* const subsystem)
{
    return subsystem->descriptor;
}

parameter_dictionary_t* subsystem_dictionary(subsystem_t* const subsystem)
{
    return &subsystem->dictionary;
}

status_t subsystem_publish(subsystem_t* const subsystem, const parameter_definition_t* const definition,
                           void* const storage)
{
    return parameter_publish(&subsystem->dictionary, definition, storage);
}

status_t subsystem_raise(subsystem_t* const subsystem, const uint16_t event_id,
                         const uint8_t* const auxiliary, const size_t size)
{
    FSW_ASSERT(subsystem != NULL);
    const descriptor_event_t* const event = descriptor_find_event(subsystem->descriptor, event_id);
    if (event == NULL) {
        return STATUS_NOT_FOUND;
    }
    uint8_t sampled[AUXILIARY_MAX];
    const uint8_t* octets = auxiliary;
    size_t octet_count    = size;
    if (size == 0U) {
        octets      = sampled;
        octet_count = component_sample_auxiliary(subsystem, event, sampled, sizeof sampled);
    }
    if (subsystem->config.supervisor_patience_ns == 0U) {
        // Errors of the supervisor concern others: it reports them and keeps its state.
    } else if (event->severity == DESCRIPTOR_HIGH) { // First the safe state, then the report.
        component_machine_event(subsystem, EVENT_OWN_HIGH, CAUSE_OWN_ERROR, event_id);
    } else if ((event->severity == DESCRIPTOR_MEDIUM) && !subsystem->is_medium_pending) {
        subsystem->is_medium_pending = true;
        subsystem->medium_cycle      = subsystem->cycle;
        subsystem->last_code         = event_id;
    } else {
        // Logged only.
    }
    (void)pus_event_raise(&subsystem->events, event_id, octets, octet_count, subsystem->now_ns);
    return STATUS_OK;
}

void subsystem_function_done(subsystem_t* const subsystem, const uint32_t ticket, const uint16_t failure_code,
                             const uint32_t detail)
{
    FSW_ASSERT(subsystem != NULL);
    const bool is_open =
        (ticket >= 1U) && (ticket <= COMPONENT_TICKETS) && (subsystem->open_tickets[ticket - 1U] != NULL);
    if (!is_open) {
        return;
    }
    pus_token_t* const token             = subsystem->open_tickets[ticket - 1U];
    subsystem->open_tickets[ticket - 1U] = NULL;
    pus_verify_ended(&subsystem->process, token, pus_failure(failure_code, detail), subsystem->now_ns);
    const status_t status = pool_release(&subsystem->tickets, token);
    FSW_ASSERT(status == STATUS_OK);
}
