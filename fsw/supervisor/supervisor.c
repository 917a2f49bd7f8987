// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/supervisor.h"

#include "base/assertion.h"
#include "fsw/supervisor/services/monitoring.h"
#include "fsw/supervisor/supervisor_internal.h"

#include <stddef.h>

#define ROUNDS 2U           ///< Commits in one step: outputs that fail or add log records need another one.
#define TICK_NS 10000000ULL ///< Interval of the supervisor's checks.
#define UNANSWERED_NS 10000000000ULL ///< Longest wait for the acceptance of a request.
/// Heartbeats in the time for which a subsystem stays OPERATIONAL without the supervisor.
#define HEARTBEATS 3U

// ---- The supervisor as a subsystem ----

static status_t publish(void* const self)
{
    supervisor_t* const supervisor = (supervisor_t*)self;
    const struct {
        const parameter_definition_t* definition;
        void* storage;
    } rows[]        = {{&supervisor_definitions[SUPERVISOR_INDEX_STATUS], &supervisor->status},
                       {&supervisor_definitions[SUPERVISOR_INDEX_COUNTERS], &supervisor->counters},
                       {&supervisor_definitions[SUPERVISOR_INDEX_ORBIT_PERIOD], &supervisor->orbit_period_ms},
                       {&supervisor_definitions[SUPERVISOR_INDEX_ORBIT], &supervisor->orbit},
                       {&supervisor_definitions[SUPERVISOR_INDEX_BLOCKS], &supervisor->blocks},
                       {&supervisor_definitions[SUPERVISOR_INDEX_REACTIONS], &supervisor->reactions},
                       {&supervisor_definitions[SUPERVISOR_INDEX_GROUND], &supervisor->ground},
                       {&supervisor_definitions[SUPERVISOR_INDEX_MESSAGES], &supervisor->messages}};
    status_t status = STATUS_OK;
    for (size_t i = 0U; (i < (sizeof rows / sizeof rows[0])) && (status == STATUS_OK); i++) {
        status = subsystem_publish(&supervisor->subsystem, rows[i].definition, rows[i].storage);
    }
    return status;
}

static uint16_t count_networks(const link_graph_t* const graph)
{
    uint16_t count = 0U;
    for (uint16_t i = 0U; i < graph->count; i++) {
        count = (uint16_t)(count + (supervisor_link_graph_is_first(graph, i) ? 1U : 0U));
    }
    return count;
}

static void update_status(void* const self)
{
    supervisor_t* const supervisor     = (supervisor_t*)self;
    parameter_dictionary_t* dictionary = subsystem_dictionary(&supervisor->subsystem);
    pool_t* const requests             = &supervisor->spacecraft.schedules.chains.pool;
    pool_t* const sequences            = &supervisor->spacecraft.sequences.chains.pool;
    const bool is_request_news         = pool_poll_warning(requests);
    if (pool_poll_warning(sequences) || is_request_news) {
        (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_POOL_WARNING, NULL, 0U);
    }
    parameter_lock(dictionary);
    supervisor->status                = (supervisor_status_t){.mode         = supervisor->mode,
                                                              .log_strategy = (uint8_t)supervisor->log.strategy,
                                                              .subsystems   = supervisor->mission->subsystem_count,
                                                              .networks     = count_networks(&supervisor->graph),
                                                              .links        = supervisor->graph.count,
                                                              .pending      = supervisor->pending.count,
                                                              .records      = supervisor->log.next_number - 1U};
    supervisor->counters.pool_peak    = supervisor->subsystem.call_tokens.stats.peak;
    supervisor->counters.pool_refused = supervisor->subsystem.call_tokens.stats.refused;
    subsystem_health_t health;
    subsystem_health(&supervisor->subsystem, &health);
    supervisor->counters.events_suppressed = health.events_suppressed;
    supervisor->counters.reports_lost      = health.reports_lost;
    supervisor->blocks                     = (supervisor_blocks_t){.request_peak     = requests->stats.peak,
                                                                   .request_refused  = requests->stats.refused,
                                                                   .sequence_peak    = sequences->stats.peak,
                                                                   .sequence_refused = sequences->stats.refused};
    const uint64_t position = pus_position_schedule_now(&supervisor->spacecraft.schedules.position);
    supervisor->orbit       = (supervisor_orbit_t){.number = (uint32_t)(position / PUS_POSITION_TICKS),
                                                   .angle  = (uint16_t)(position % PUS_POSITION_TICKS)};
    supervisor_ground_update(supervisor);
    const message_counters_t* const messages = &supervisor->config.endpoint->counters;
    supervisor->messages                     = (supervisor_messages_t){.lost      = messages->lost,
                                                                       .stale     = messages->stale,
                                                                       .malformed = messages->malformed,
                                                                       .overruns  = messages->overruns,
                                                                       .abandoned = messages->abandoned,
                                                                       .syncs     = messages->syncs};
    parameter_unlock(dictionary);
}

const subsystem_callbacks_t* supervisor_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {.software_init = publish,
                                                    .control       = update_status,
                                                    .memories      = spacecraft_memories,
                                                    .watched       = spacecraft_watched};
    return &callbacks;
}

// ---- Life ----

/// Returns the interval of the supervisor's status reports, which are its heartbeat: a third of the shortest
/// time for which a subsystem waits for them, at most SUBSYSTEM_STATUS_INTERVAL_NS.
static uint64_t heartbeat_interval_ns(const supervisor_t* const supervisor)
{
    uint64_t interval_ns = SUBSYSTEM_STATUS_INTERVAL_NS;
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const uint64_t share_ns =
            ((uint64_t)supervisor->mission->subsystems[i].supervisor_timeout_us * 1000U) / HEARTBEATS;
        interval_ns = (share_ns < interval_ns) ? share_ns : interval_ns;
    }
    return interval_ns;
}

static void init_component(supervisor_t* const supervisor)
{
    const supervisor_config_t* const config = &supervisor->config;
    const pus_port_t port                   = {supervisor, supervisor_router_send};
    const pus_mission_port_t mission        = supervisor_mission_service_port(supervisor);
    const pus_rtlink_port_t links           = supervisor_link_manager_port(supervisor);
    pus_mission_init(&supervisor->mission_service, &mission);
    pus_rtlink_init(&supervisor->link_service, &links);
    supervisor->services[0] = pus_mission_service(&supervisor->mission_service);
    supervisor->services[1] = pus_rtlink_service(&supervisor->link_service);
    const size_t count      = 2U + spacecraft_open(supervisor, &supervisor->services[2]);
    pus_requester_init(&supervisor->requester, SUPERVISOR_APID, &port);
    const subsystem_config_t subsystem = {.descriptor          = config->descriptor,
                                          .is_descriptor_valid = config->is_descriptor_valid,
                                          .callbacks           = supervisor_callbacks(),
                                          .self                = supervisor,
                                          .mission_epoch_s     = supervisor->mission->epoch_s,
                                          .start_count         = config->start_count,
                                          .port                = port,
                                          .status_interval_ns  = heartbeat_interval_ns(supervisor),
                                          .persistence         = spacecraft_persistence(supervisor),
                                          .services            = supervisor->services,
                                          .service_count       = count,
                                          .optional            = config->optional};
    subsystem_init(&supervisor->subsystem, &subsystem);
}

status_t supervisor_init(supervisor_t* const supervisor, const supervisor_config_t* const config)
{
    FSW_ASSERT((supervisor != NULL) && (config != NULL) && (config->mission != NULL) &&
               (config->endpoint != NULL));
    supervisor->config  = *config;
    supervisor->mission = config->mission;
    supervisor->mode    = (uint8_t)config->mission->initial_mode;
    supervisor_registry_init(supervisor);
    supervisor_pending_init(&supervisor->pending);
    supervisor_ground_backlog_init(&supervisor->ground_backlog);
    message_ring_init(&supervisor->ground_kept, supervisor->ground_storage,
                      sizeof supervisor->ground_storage);
    supervisor_pending_init(&supervisor->own);
    supervisor_output_commit_init(supervisor);
    init_component(supervisor);
    // The adoption comes first: the data of the predecessor say how the log continues.
    supervisor_adoption_begin(supervisor);
    const status_t status = supervisor_packet_log_open(
        &supervisor->log, config->log_directory, (packet_log_strategy_t)supervisor->log_strategy,
        &supervisor->log_past, config->mission->log_ring_records);
    if ((status == STATUS_OK) && config->has_log_writer) {
        const status_t started = supervisor_packet_log_start_writer(&supervisor->log);
        (void)started; // Without the task, the supervisor itself waits for the disk.
    }
    // Called after the log was opened, because reports of the supervisor are logged, too.
    spacecraft_restore(supervisor);
    return status;
}

/// Perform the checks that are due every 10 ms.
static void tick(supervisor_t* const supervisor)
{
    supervisor_registry_watch(supervisor);
    supervisor_doubt_watch(supervisor);
    supervisor_registry_end_unanswered(supervisor, UNANSWERED_NS);
    supervisor_send_pending_orders(supervisor);
    supervisor_link_manager_watch(supervisor);
    supervisor_error_run_plans(supervisor);
    supervisor_sequence_autostart(supervisor);
    if (supervisor->config.platform.is_stop_requested(supervisor->config.platform.context)) {
        supervisor_sequence_shutdown_begin(supervisor, NULL);
    }
    supervisor_sequence_shutdown(supervisor);
}

/// Perform the outputs of the step. A failure of an output is handled in the same step.
static void finish_step(supervisor_t* const supervisor)
{
    bool has_changed = true;
    for (unsigned round = 0U; has_changed && (round < ROUNDS); round++) {
        supervisor_error_own_events(supervisor);
        supervisor_adoption_commit(supervisor);
        // The outputs come before the log: a report about a failure of the log is not part of this commit. If
        // it were sent now, and the supervisor died before the next commit, its successor would repeat the
        // sequence number, and the receiver would drop the successor's frame.
        const uint64_t next_number = supervisor->log.next_number;
        has_changed                = supervisor_output_commit_perform(supervisor);
        supervisor_router_flush_log(supervisor);
        has_changed = has_changed || (supervisor->log.next_number != next_number);
    }
    if (has_changed) {
        supervisor_adoption_commit(supervisor); // The next step performs what is left.
    }
}

/// Perform the step of the supervisor as a subsystem. SOFTWARE_INIT sets all parameters to their initial
/// values; what was counted before, or by an earlier life of the supervisor, stays counted.
static uint64_t step_component(supervisor_t* const supervisor, const uint64_t now_ns)
{
    const bool is_initialised              = subsystem_state(&supervisor->subsystem) > STATE_SOFTWARE_INIT;
    const supervisor_counters_t counters   = supervisor->counters;
    const supervisor_reactions_t reactions = supervisor->reactions;
    const uint64_t wake_ns                 = subsystem_step(&supervisor->subsystem, now_ns);
    if (!is_initialised) {
        supervisor->counters  = counters;
        supervisor->reactions = reactions;
    }
    return wake_ns;
}

uint64_t supervisor_step(supervisor_t* const supervisor, const uint64_t now_ns)
{
    FSW_ASSERT(supervisor != NULL);
    supervisor->now_ns = now_ns;
    // Set the time now, because messages are processed before subsystem_step, and events about them must
    // have the time of this step.
    subsystem_set_time(&supervisor->subsystem, now_ns);
    // Outputs that remain from the previous step, or from the previous life.
    (void)supervisor_output_commit_perform(supervisor);
    if (!supervisor->has_begun) {
        supervisor_adoption_reopen(supervisor);
        spacecraft_report_damage(supervisor);
        supervisor_mode_begin(supervisor);
        supervisor->has_begun = true;
    }
    supervisor_ground_flush(supervisor);
    supervisor_router_take_in(supervisor);
    supervisor_link_manager_settle(supervisor);
    supervisor_adoption_report(supervisor);
    // The messages taken in may have returned credit, so waiting reports can be sent now.
    supervisor_ground_flush(supervisor);
    supervisor_ground_report(supervisor);
    const uint64_t component_wake_ns = step_component(supervisor, now_ns);
    if (now_ns >= supervisor->next_tick_ns) {
        tick(supervisor);
        supervisor->next_tick_ns = ((now_ns / TICK_NS) + 1U) * TICK_NS;
    }
    supervisor_recommission_step(supervisor);
    const uint64_t spacecraft_wake_ns = spacecraft_step(supervisor, now_ns);
    finish_step(supervisor);
    uint64_t wake_ns = (component_wake_ns < spacecraft_wake_ns) ? component_wake_ns : spacecraft_wake_ns;
    return (wake_ns < supervisor->next_tick_ns) ? wake_ns : supervisor->next_tick_ns;
}

void supervisor_close(supervisor_t* const supervisor)
{
    FSW_ASSERT(supervisor != NULL);
    supervisor_packet_log_close(&supervisor->log);
}

void supervisor_abandon(supervisor_t* const supervisor)
{
    FSW_ASSERT(supervisor != NULL);
    supervisor_packet_log_abandon(&supervisor->log);
}
