// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/subsystem_core.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/subsystem_internal.h"

#include "pus/st01/st01_verification.h"

#include <string.h>

#define IDLE_PERIOD_NS 10000000ULL ///< Period if the descriptor does not define one.

void subsystem_set_pool_thresholds(subsystem_t* const subsystem)
{
    const uint8_t warn  = subsystem->descriptor->pool_warn_percent;
    const uint8_t low   = subsystem->descriptor->pool_clear_percent;
    const uint8_t clear = (uint8_t)((low > 0U) ? low : 1U);
    if (warn > clear) { // A descriptor that was refused is empty: its thresholds are 0.
        pool_set_thresholds(&subsystem->call_tokens, warn, clear);
    }
}

static void init_call_tokens(subsystem_t* const subsystem)
{
    const pool_setup_t setup = {.block_octets  = sizeof(pus_token_t),
                                .block_count   = SUBSYSTEM_CALL_TOKENS,
                                .reserve       = 1U,
                                .warn_percent  = (uint8_t)POOL_WARN_PERCENT,
                                .clear_percent = (uint8_t)POOL_CLEAR_PERCENT};
    pool_init(&subsystem->call_tokens, subsystem->call_token_storage, subsystem->call_token_slots, &setup);
    subsystem_set_pool_thresholds(subsystem);
}

void subsystem_set_idle_period(subsystem_t* const subsystem)
{
    const uint64_t period_ns = (uint64_t)subsystem->descriptor->sampling_us * 1000U;
    subsystem->period_ns     = (period_ns > 0U) ? period_ns : IDLE_PERIOD_NS;
}

void subsystem_init(subsystem_t* const subsystem, const subsystem_config_t* const config)
{
    FSW_ASSERT((subsystem != NULL) && (config != NULL) && (config->descriptor != NULL) &&
               (config->callbacks != NULL) && (config->start_count >= 1U) &&
               (config->status_interval_ns > 0U));
    (void)memset(subsystem, 0, sizeof *subsystem);
    subsystem->config     = *config;
    subsystem->descriptor = config->descriptor;
    subsystem_state_machine_init(&subsystem->machine, config->is_descriptor_valid);
    subsystem_set_idle_period(subsystem);
    const status_t status = parameter_init(&subsystem->dictionary, subsystem->entries, SUBSYSTEM_PARAMETERS,
                                           subsystem->bounds, SUBSYSTEM_BOUNDS);
    FSW_ASSERT(status == STATUS_OK);
    init_call_tokens(subsystem);
    pus_app_process_init(&subsystem->process, config->descriptor->apid, config->mission_epoch_s,
                         &config->port);
    pus_app_process_keep(&subsystem->process, &subsystem->queues);
    subsystem_register_services(subsystem);
}

pus_app_process_t* subsystem_process(subsystem_t* const subsystem)
{
    return &subsystem->process;
}

bool subsystem_may_accept(subsystem_t* const subsystem)
{
    FSW_ASSERT(subsystem != NULL);
    if (!pus_app_process_may_answer(&subsystem->process)) {
        // Send waiting reports: the port may have room again.
        (void)pus_app_process_flush(&subsystem->process);
    }
    return pus_app_process_may_answer(&subsystem->process) &&
           !pus_dispatcher_is_answering(&subsystem->dispatcher);
}

void subsystem_accept(subsystem_t* const subsystem, const uint8_t* const packet, const size_t size,
                      const uint64_t now_ns)
{
    FSW_ASSERT((subsystem != NULL) && (packet != NULL));
    subsystem->now_ns = now_ns;
    if (subsystem->config.supervisor_timeout_ns > 0U) {
        subsystem->supervisor_heard_ns = now_ns;
        subsystem->is_supervisor_lost  = false;
    }
    if (pus_packet_is_tc(packet, size)) {
        (void)pus_dispatch(&subsystem->dispatcher, packet, size, now_ns);
    } else if (subsystem->config.callbacks->report != NULL) {
        subsystem->config.callbacks->report(subsystem->config.self, packet, size);
    } else {
        // This was a heartbeat of the supervisor; its arrival was noted above.
    }
}

void subsystem_accept_large(subsystem_t* const subsystem, const uint8_t* const packet, const size_t size,
                            const uint64_t now_ns)
{
    FSW_ASSERT((subsystem != NULL) && (packet != NULL));
    subsystem->now_ns = now_ns;
    (void)pus_dispatch_large(&subsystem->dispatcher, packet, size, now_ns);
}

/// After an event of severity MEDIUM the component waits a few cycles for a command of the supervisor, then
/// reacts by itself.
static void watch_medium(subsystem_t* const subsystem)
{
    if (!subsystem->is_medium_pending) {
        return;
    }
    if (subsystem->machine.state != STATE_OPERATIONAL) {
        subsystem->is_medium_pending = false;
    } else if ((subsystem->cycle - subsystem->medium_cycle) >= SUBSYSTEM_MEDIUM_CYCLES) {
        // The subsystem leaves OPERATIONAL immediately, and the next cycle clears is_medium_pending.
        subsystem_machine_event(subsystem, EVENT_MEDIUM_ORDER, CAUSE_OWN_ERROR, subsystem->last_code);
    } else {
        // The command may still arrive.
    }
}

static bool is_hardware_live(const state_t state)
{
    return (state >= STATE_HARDWARE_INIT) && (state <= STATE_HARDWARE_DEINIT);
}

static bool is_controlled(const subsystem_t* const subsystem)
{
    const state_t state = subsystem->machine.state;
    return ((state >= STATE_SAFE_OPERATIONAL) && (state <= STATE_ERROR_OPERATIONAL)) ||
           ((state == STATE_PRE_OPERATIONAL) && subsystem->machine.is_configured);
}

static void call(void (*const callback)(void*), void* const self)
{
    if (callback != NULL) {
        callback(self);
    }
}

/// Perform one cycle: sense, links, entry action, control, emit, housekeeping.
static void run_cycle(subsystem_t* const subsystem)
{
    const subsystem_callbacks_t* const callbacks = subsystem->config.callbacks;
    void* const self                             = subsystem->config.self;
    const bool is_live                           = is_hardware_live(subsystem->machine.state);
    subsystem->cycle++;
    if (is_live) {
        call(callbacks->sense, self);
    }
    subsystem_watch_links(subsystem);
    watch_medium(subsystem);
    if (subsystem->machine.action != ACTION_NONE) {
        subsystem_run_action(subsystem);
    }
    if (is_controlled(subsystem)) {
        call(callbacks->control, self);
    }
    if ((subsystem->machine.action == ACTION_SECURE) && subsystem->is_action_fresh) {
        // An error has occurred in this cycle: secure the devices before any command is sent to them.
        subsystem_run_action(subsystem);
    }
    // Emit also in the cycle that enters or leaves these states: its action may have set commands.
    if (is_live || is_hardware_live(subsystem->machine.state)) {
        call(callbacks->emit, self);
    }
    if (subsystem->configuration != NULL) {
        pus_hk_step(&subsystem->housekeeping, subsystem->now_ns, subsystem->cycle);
    }
}

/// React once if the supervisor has been silent for too long.
static void watch_supervisor(subsystem_t* const subsystem)
{
    const bool is_silent =
        !subsystem->is_supervisor_lost && (subsystem->supervisor_heard_ns > 0U) &&
        ((subsystem->now_ns - subsystem->supervisor_heard_ns) > subsystem->config.supervisor_timeout_ns);
    if (is_silent) {
        subsystem->is_supervisor_lost = true;
        subsystem_machine_event(subsystem, EVENT_SUPERVISOR_LOST, CAUSE_SUPERVISOR_LOST, 0U);
    }
}

void subsystem_raise_named(subsystem_t* const subsystem, const char* const name)
{
    const descriptor_event_t* const event = descriptor_find_event_name(subsystem->descriptor, name);
    if (event != NULL) {
        (void)subsystem_raise(subsystem, event->id, NULL, 0U);
    }
}

static void watch_pools(subsystem_t* const subsystem)
{
    if (pool_poll_warning(&subsystem->call_tokens)) {
        subsystem_raise_named(subsystem, "POOL_WARNING");
    }
}

static void report_status(subsystem_t* const subsystem)
{
    pus_subsystem_status_t status;
    subsystem->management.port.read_status(subsystem, &status);
    (void)pus_subsystem_status_report(&subsystem->process, PUS_USER_GROUND, &status, subsystem->now_ns);
}

/// Returns the time of the next cycle after `now_ns`: a multiple of the period since the start of the run.
static uint64_t next_on_grid(const uint64_t now_ns, const uint64_t period_ns)
{
    return ((now_ns / period_ns) + 1U) * period_ns;
}

void subsystem_set_time(subsystem_t* const subsystem, const uint64_t now_ns)
{
    FSW_ASSERT(subsystem != NULL);
    subsystem->now_ns = now_ns;
}

/// True if the main loop has cycles. In OFFLINE it has cycles only for optional services.
static bool is_cyclic(const subsystem_t* const subsystem)
{
    return (subsystem->machine.state != STATE_OFFLINE) || (subsystem->optional_count > 0U);
}

static uint64_t step_own_loop(subsystem_t* const subsystem)
{
    const uint64_t now_ns   = subsystem->now_ns;
    const bool is_answering = pus_dispatcher_resume(&subsystem->dispatcher, now_ns);
    if (is_cyclic(subsystem) && (now_ns >= subsystem->next_cycle_ns)) {
        if (subsystem->machine.state != STATE_OFFLINE) {
            run_cycle(subsystem);
        }
        subsystem_step_optional(subsystem);
        subsystem->next_cycle_ns = next_on_grid(now_ns, subsystem->period_ns);
    }
    subsystem_empty_mailboxes(subsystem);
    subsystem_take_reload(subsystem);
    watch_supervisor(subsystem);
    watch_pools(subsystem);
    (void)pus_events_step(&subsystem->events, now_ns); // Reports that find no room follow in later steps.
    if (now_ns >= subsystem->next_status_ns) {
        report_status(subsystem);
        subsystem->next_status_ns = next_on_grid(now_ns, subsystem->config.status_interval_ns);
    }
    if (is_answering || pus_app_process_is_waiting(&subsystem->process)) {
        return next_on_grid(now_ns, subsystem->period_ns);
    }
    return (is_cyclic(subsystem) && (subsystem->next_cycle_ns < subsystem->next_status_ns))
               ? subsystem->next_cycle_ns
               : subsystem->next_status_ns;
}

uint64_t subsystem_step(subsystem_t* const subsystem, const uint64_t now_ns)
{
    FSW_ASSERT(subsystem != NULL);
    subsystem->now_ns = now_ns;
    // The loops come before the main loop too, so that it sends the reports that they have finished.
    (void)subsystem_step_loops(subsystem);
    const uint64_t own_ns = step_own_loop(subsystem);
    // Called last, because the configuration may have changed.
    const uint64_t loops_ns = subsystem_step_loops(subsystem);
    return (loops_ns < own_ns) ? loops_ns : own_ns;
}

// ---- Called by specific subsystems (subsystem.h) ----

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

const descriptor_configuration_t* subsystem_configuration(const subsystem_t* const subsystem)
{
    return subsystem->configuration;
}

const subsystem_descriptor_t* subsystem_descriptor(const subsystem_t* const subsystem)
{
    return subsystem->descriptor;
}

bool subsystem_is_restarted(const subsystem_t* const subsystem)
{
    FSW_ASSERT(subsystem != NULL);
    return subsystem->config.start_count > 1U;
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
    uint8_t sampled[DESCRIPTOR_AUXILIARY_MAX];
    const uint8_t* octets = auxiliary;
    size_t octet_count    = size;
    if (size == 0U) {
        octets      = sampled;
        octet_count = subsystem_sample_auxiliary(subsystem, event, sampled, sizeof sampled);
    }
    if (subsystem->config.supervisor_timeout_ns == 0U) {
        // Events of the supervisor are about other subsystems: it reports them and keeps its state.
    } else if (event->severity == DESCRIPTOR_HIGH) { // React first, then report the event.
        subsystem_machine_event(subsystem, EVENT_OWN_HIGH, CAUSE_OWN_ERROR, event_id);
    } else if ((event->severity == DESCRIPTOR_MEDIUM) && !subsystem->is_medium_pending) {
        subsystem->is_medium_pending = true;
        subsystem->medium_cycle      = subsystem->cycle;
        subsystem->last_code         = event_id;
    } else {
        // Other events are only reported.
    }
    (void)pus_event_raise(&subsystem->events, event_id, octets, octet_count, subsystem->now_ns);
    return STATUS_OK;
}

void subsystem_function_done(subsystem_t* const subsystem, const uint32_t call_token,
                             const uint16_t failure_code, const uint32_t detail)
{
    FSW_ASSERT(subsystem != NULL);
    const bool is_open = (call_token >= 1U) && (call_token <= SUBSYSTEM_CALL_TOKENS) &&
                         (subsystem->open_call_tokens[call_token - 1U] != NULL);
    if (!is_open) {
        return;
    }
    pus_token_t* const token                     = subsystem->open_call_tokens[call_token - 1U];
    subsystem->open_call_tokens[call_token - 1U] = NULL;
    pus_verify_ended(&subsystem->process, token, pus_failure(failure_code, detail), subsystem->now_ns);
    const status_t status = pool_release(&subsystem->call_tokens, token);
    FSW_ASSERT(status == STATUS_OK);
}
