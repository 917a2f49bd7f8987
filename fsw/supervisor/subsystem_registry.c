// SPDX-License-Identifier: Apache-2.0
// Registry of the known data of each subsystem: process, last reported state, heartbeat, power.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

/// Longest silence of a running subsystem, which sends its status once per second.
#define SILENT_NS 3000000000ULL
/// Pause before the second consecutive start; RESTART_PAUSE_MAX_NS before each further one.
#define SHORT_PAUSE_NS 100000000ULL
#define NS_PER_MS 1000000ULL
#define NS_PER_US 1000ULL

void supervisor_registry_init(supervisor_t* const supervisor)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        registry_entry_t* const entry = &supervisor->registry[i];
        entry->mission                = &supervisor->mission->subsystems[i];
        // The launcher starts all processes; supervisor_registry_watch corrects the state.
        entry->process = PROCESS_RUNNING;
        entry->state   = STATE_OFFLINE;
    }
}

registry_entry_t* supervisor_registry_find(supervisor_t* const supervisor, const uint16_t apid)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        if (supervisor->mission->subsystems[i].apid == apid) {
            return &supervisor->registry[i];
        }
    }
    return NULL;
}

/// True for a rest state other than ERROR_OPERATIONAL.
static bool is_rest(const registry_entry_t* const entry)
{
    const bool is_still = (entry->phase == PHASE_IDLE) || (entry->phase == PHASE_UNCONFIGURED) ||
                          (entry->phase == PHASE_CONFIGURED);
    const bool is_rest_state = (entry->state == STATE_OFFLINE) || ((entry->state >= STATE_PRE_OPERATIONAL) &&
                                                                   (entry->state <= STATE_OPERATIONAL));
    return is_still && is_rest_state;
}

/// Store a reported state; an invalid one is ignored.
static void keep(supervisor_t* const supervisor, registry_entry_t* const entry, const uint8_t state,
                 const uint8_t phase, const uint16_t configuration)
{
    if ((state >= (uint8_t)STATE_COUNT) || (phase > (uint8_t)PHASE_UNSECURED)) {
        supervisor->counters.tm_malformed++;
        return;
    }
    if ((state == (uint8_t)STATE_ERROR_OPERATIONAL) && (entry->state != STATE_ERROR_OPERATIONAL)) {
        entry->error_ns = supervisor->now_ns;
    }
    const bool has_left_offline = (entry->state == STATE_OFFLINE) && (state != (uint8_t)STATE_OFFLINE);
    entry->state                = (state_t)state;
    entry->phase                = (state_phase_t)phase;
    entry->configuration        = configuration;
    if (has_left_offline) {
        supervisor_sequence_left_offline(supervisor, entry);
    }
    if (is_rest(entry)) {
        entry->rested      = entry->state;
        entry->rested_with = configuration;
    }
}

static void raise_difference(supervisor_t* const supervisor, const uint16_t event_id, const uint16_t apid,
                             const uint64_t expected, const uint64_t found)
{
    uint8_t octets[18];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, apid);
    octet_write_u64(&writer, expected);
    octet_write_u64(&writer, found);
    (void)subsystem_raise(&supervisor->subsystem, event_id, octets, writer.position);
}

/// Compare the descriptor hashes of a subsystem with those of the mission, because the subsystem may run on
/// another computer with its own files. Each change is reported once.
static void compare_descriptors(supervisor_t* const supervisor, registry_entry_t* const entry,
                                const pus_subsystem_status_t* const status)
{
    const mission_subsystem_t* const own = entry->mission;
    entry->is_interface_mismatched       = (status->interface_hash != own->interface_hash);
    if (entry->is_interface_mismatched && (status->interface_hash != entry->interface_hash)) {
        raise_difference(supervisor, SUPERVISOR_EVENT_INTERFACE_DIFFERS, own->apid, own->interface_hash,
                         status->interface_hash);
    }
    if ((status->configuration_hash != own->configuration_hash) &&
        (status->configuration_hash != entry->configuration_hash)) {
        raise_difference(supervisor, SUPERVISOR_EVENT_CONFIGURATION_DIFFERS, own->apid,
                         own->configuration_hash, status->configuration_hash);
    }
    entry->interface_hash     = status->interface_hash;
    entry->configuration_hash = status->configuration_hash;
}

void supervisor_registry_report(supervisor_t* const supervisor, const pus_tm_t* const tm)
{
    registry_entry_t* const entry = supervisor_registry_find(supervisor, tm->apid);
    if (entry == NULL) {
        return;
    }
    entry->is_heard       = true;
    entry->heard_ns       = supervisor->now_ns;
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    if (tm->service != PUS_SERVICE_MANAGEMENT) {
        return;
    }
    pus_transition_t transition;
    pus_subsystem_status_t status;
    if ((tm->subtype == PUS_MANAGEMENT_TRANSITION) &&
        (pus_transition_read(&reader, &transition) == STATUS_OK)) {
        keep(supervisor, entry, transition.state, transition.phase, transition.configuration);
    } else if ((tm->subtype == PUS_MANAGEMENT_STATUS) &&
               (pus_subsystem_status_read(&reader, &status) == STATUS_OK)) {
        supervisor_adoption_compare(supervisor, entry, status.state, status.configuration);
        keep(supervisor, entry, status.state, status.phase, status.configuration);
        compare_descriptors(supervisor, entry, &status);
    } else {
        // Other reports of the service are not needed here.
    }
}

uint32_t supervisor_registry_power_w(const supervisor_t* const supervisor, const uint16_t apid,
                                     const state_t state)
{
    uint32_t power_w = 0U;
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const registry_entry_t* const entry = &supervisor->registry[i];
        const state_t counted               = (entry->mission->apid == apid) ? state : entry->state;
        power_w += entry->mission->power_w[counted];
    }
    return power_w;
}

void supervisor_registry_end_pending(supervisor_t* const supervisor, const uint16_t apid)
{
    pus_token_t token;
    const pus_failure_t failure = pus_failure(PUS_FAILURE_LOST, apid);
    while (supervisor_pending_take(&supervisor->pending, apid, &token)) {
        pus_verify_failed(subsystem_process(&supervisor->subsystem), &token, &failure, supervisor->now_ns);
    }
}

void supervisor_registry_end_unanswered(supervisor_t* const supervisor, const uint64_t timeout_ns)
{
    if (supervisor->now_ns <= timeout_ns) {
        return;
    }
    pus_token_t token;
    const pus_failure_t failure = pus_failure(PUS_FAILURE_TIMEOUT, (uint32_t)(timeout_ns / NS_PER_MS));
    while (
        supervisor_pending_take_unanswered(&supervisor->pending, supervisor->now_ns - timeout_ns, &token)) {
        pus_verify_failed(subsystem_process(&supervisor->subsystem), &token, &failure, supervisor->now_ns);
    }
}

bool supervisor_registry_is_there(const registry_entry_t* const entry)
{
    return (entry->process == PROCESS_RUNNING) && (entry->is_heard || !entry->is_restarted);
}

void supervisor_registry_start(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    supervisor_output_commit_start(supervisor, entry);
    entry->process      = PROCESS_RUNNING;
    entry->is_heard     = false;
    entry->is_restarted = true;
    entry->is_start_due = false;
    entry->started_ns   = supervisor->now_ns;
    entry->restart_ns   = supervisor->now_ns; // A start by request may come before the one that was due.
}

/// Returns the pause before the next start: none before the first one, then longer ones, so that a process
/// that dies at every start cannot use up the processor.
static uint64_t pause_ns(const uint8_t deaths)
{
    return (deaths <= 1U) ? 0U : ((deaths == 2U) ? SHORT_PAUSE_NS : RESTART_PAUSE_MAX_NS);
}

void supervisor_registry_start_failed(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    entry->process = PROCESS_LOST;
    supervisor_mode_fall_back(supervisor);
}

static void start_again(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    entry->is_start_due = false;
    if (supervisor->shutdown_step != 0U) {
        return; // During the shutdown no process is started.
    }
    entry->restarts++;
    supervisor->counters.restarts++;
    supervisor_registry_start(supervisor, entry);
}

/// Start a lost process again while its restart budget lasts; then enter the fallback mode. A life as long
/// as the restart period of the mission resets the count of deaths.
static void restart(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    const mission_subsystem_t* const mission = entry->mission;
    const uint64_t period_ns                 = (uint64_t)mission->restart_period_us * NS_PER_US;
    if ((period_ns != 0U) && ((supervisor->now_ns - entry->restart_ns) >= period_ns)) {
        entry->deaths = 0U;
    }
    if (supervisor->shutdown_step != 0U) {
        return;
    }
    if (entry->deaths >= mission->restart_budget) {
        supervisor_mode_fall_back(supervisor);
        return;
    }
    entry->deaths++;
    entry->is_start_due = true;
    entry->restart_ns   = supervisor->now_ns + pause_ns(entry->deaths);
    if (entry->restart_ns == supervisor->now_ns) {
        start_again(supervisor, entry);
    }
}

static void process_lost(supervisor_t* const supervisor, registry_entry_t* const entry,
                         const uint16_t event_id)
{
    const uint16_t apid = entry->mission->apid;
    supervisor_recommission_begin(supervisor, apid); // Must precede the clearing of states and links.
    entry->process          = PROCESS_LOST;
    entry->state            = STATE_OFFLINE;
    entry->phase            = PHASE_IDLE;
    entry->is_order_pending = false;
    supervisor_registry_end_pending(supervisor, apid);
    supervisor_raise_u16(supervisor, event_id, apid);
    // The reaction needs the links of the subsystem; therefore they are removed after it.
    supervisor_error_member_lost(supervisor, apid, event_id);
    supervisor_link_manager_member_lost(supervisor, apid);
    if (apid == COMMUNICATION_APID) {
        // The ground cannot command now, so the autostart brings `communication` up again.
        supervisor->autostart_step = 0U;
    }
    restart(supervisor, entry);
}

/// True if a process hangs: it is alive, and the promised time of its next step is further in the past than
/// the mission permits. This check needs no message.
static bool is_hung(const supervisor_t* const supervisor, const registry_entry_t* const entry)
{
    const supervisor_platform_t* const platform = &supervisor->config.platform;
    const uint64_t promise_ns                   = platform->promise(platform->context, entry->mission->apid);
    const uint64_t timeout_ns                   = (uint64_t)entry->mission->hang_after_us * NS_PER_US;
    return (promise_ns < supervisor->now_ns) && ((supervisor->now_ns - promise_ns) > timeout_ns);
}

static void watch_process(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    const uint16_t apid = entry->mission->apid;
    if (entry->is_start_due && (supervisor->now_ns >= entry->restart_ns)) {
        start_again(supervisor, entry);
        return;
    }
    if ((entry->process == PROCESS_RUNNING) && !supervisor_output_commit_is_running(supervisor, entry)) {
        process_lost(supervisor, entry, SUPERVISOR_EVENT_PROCESS_LOST);
        return;
    }
    if ((entry->process == PROCESS_RUNNING) && is_hung(supervisor, entry)) {
        supervisor_output_commit_stop(supervisor, entry, true);
        process_lost(supervisor, entry, SUPERVISOR_EVENT_PROCESS_HUNG);
        return;
    }
    const uint64_t since_ns = (entry->heard_ns > entry->started_ns) ? entry->heard_ns : entry->started_ns;
    if ((entry->process == PROCESS_RUNNING) && ((supervisor->now_ns - since_ns) > SILENT_NS)) {
        supervisor_raise_u16(supervisor, SUPERVISOR_EVENT_SUBSYSTEM_SILENT, apid);
        entry->started_ns = supervisor->now_ns; // The next event follows after another SILENT_NS.
        supervisor_error_member_silent(supervisor, apid);
    }
}

void supervisor_registry_watch(supervisor_t* const supervisor)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        if (supervisor->registry[i].mission->apid != SUPERVISOR_APID) {
            watch_process(supervisor, &supervisor->registry[i]);
        }
    }
}
