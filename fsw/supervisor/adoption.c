// SPDX-License-Identifier: Apache-2.0
// Takeover by the next supervisor if one dies. At the end of each step, all data that other components
// depend on are committed to the checkpoint. Only committed outputs are performed (output_commit.c, undo.h,
// packet_log.h), and frames that arrive later are stored in an annex. Therefore the next supervisor
// continues without losing or repeating a packet, at whatever instant the previous one died.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"
#include "base/capacities.h"

#include <string.h>

CAPACITY_CHECK(released_requests_have_room, CHECKPOINT_RELEASED_OCTETS >= SPACECRAFT_RELEASE_OCTETS);
CAPACITY_CHECK(every_link_has_room, LINK_GRAPH_EDGES >= MISSION_LINKS_MAX);
CAPACITY_CHECK(all_counters_have_room,
               sizeof(supervisor_counters_t) <= (CHECKPOINT_COUNTERS * sizeof(uint32_t)));

/// Index of the ring of the packet log; 0: backlog to ground, 1: released requests, 3: outputs.
#define LOG_RING 2U
#define FIRST_INBOX 4U ///< Index of the ring with the frames of the first peer.

static checkpoint_rings_t rings_of(supervisor_t* const supervisor)
{
    checkpoint_rings_t rings = {{&supervisor->ground_kept, &supervisor->spacecraft.released,
                                 &supervisor->log.ring, &supervisor->outputs}};
    for (size_t i = 0U; i < MESSAGE_PEERS_MAX; i++) {
        rings.list[FIRST_INBOX + i] = message_waiting(supervisor->config.endpoint, i);
    }
    return rings;
}

// ---- Subsystems ----

static void keep_subsystems(const supervisor_t* const supervisor, checkpoint_state_t* const state)
{
    state->subsystem_count = supervisor->mission->subsystem_count;
    for (uint16_t i = 0U; i < state->subsystem_count; i++) {
        const registry_entry_t* const entry = &supervisor->registry[i];
        state->subsystems[i] =
            (checkpoint_subsystem_t){.heard_ns                = entry->heard_ns,
                                     .started_ns              = entry->started_ns,
                                     .interface_hash          = entry->interface_hash,
                                     .configuration_hash      = entry->configuration_hash,
                                     .apid                    = entry->mission->apid,
                                     .configuration           = entry->configuration,
                                     .process                 = (uint8_t)entry->process,
                                     .state                   = (uint8_t)entry->state,
                                     .phase                   = (uint8_t)entry->phase,
                                     .is_heard                = entry->is_heard,
                                     .restarts                = entry->restarts,
                                     .deaths                  = entry->deaths,
                                     .is_start_due            = entry->is_start_due,
                                     .restart_ns              = entry->restart_ns,
                                     .has_doubt               = (entry->doubt != DOUBT_NONE),
                                     .is_order_pending        = entry->is_order_pending,
                                     .ordered                 = (uint8_t)entry->ordered,
                                     .order_cause             = (uint8_t)entry->order_cause,
                                     .is_interface_mismatched = entry->is_interface_mismatched,
                                     .is_restarted            = entry->is_restarted,
                                     .error_ns                = entry->error_ns,
                                     .rested                  = (uint8_t)entry->rested,
                                     .rested_with             = entry->rested_with,
                                     .recommission            = entry->recommission};
    }
}

/// Take over the states of the subsystems. The supervisor itself starts again in OFFLINE; all others
/// continue.
static void take_subsystems(supervisor_t* const supervisor, const checkpoint_state_t* const state)
{
    for (uint16_t i = 0U; i < state->subsystem_count; i++) {
        const checkpoint_subsystem_t* const subsystem = &state->subsystems[i];
        registry_entry_t* const entry                 = &supervisor->registry[i];
        entry->restarts                               = subsystem->restarts;
        entry->deaths                                 = subsystem->deaths;
        if (subsystem->apid == SUPERVISOR_APID) {
            entry->restarts = (uint8_t)(supervisor->lives - 1U); // The launcher has started it again.
            continue;
        }
        entry->process      = (process_state_t)subsystem->process;
        entry->is_start_due = subsystem->is_start_due;
        entry->restart_ns   = subsystem->restart_ns;
        // The request for the status is sent again, because its answer would not be recognized.
        entry->doubt                   = subsystem->has_doubt ? DOUBT_SILENT : DOUBT_NONE;
        entry->is_heard                = subsystem->is_heard;
        entry->state                   = (state_t)subsystem->state;
        entry->phase                   = (state_phase_t)subsystem->phase;
        entry->configuration           = subsystem->configuration;
        entry->is_order_pending        = subsystem->is_order_pending;
        entry->ordered                 = (state_t)subsystem->ordered;
        entry->order_cause             = (pus_cause_t)subsystem->order_cause;
        entry->heard_ns                = subsystem->heard_ns;
        entry->started_ns              = subsystem->started_ns;
        entry->interface_hash          = subsystem->interface_hash;
        entry->configuration_hash      = subsystem->configuration_hash;
        entry->is_interface_mismatched = subsystem->is_interface_mismatched;
        entry->is_restarted            = subsystem->is_restarted;
        entry->error_ns                = subsystem->error_ns;
        entry->rested                  = (state_t)subsystem->rested;
        entry->rested_with             = subsystem->rested_with;
        entry->recommission            = subsystem->recommission;
        entry->is_state_adopted        = (entry->process == PROCESS_RUNNING);
        entry->are_links_adopted       = entry->is_state_adopted;
    }
}

// ---- State of the supervisor ----

static void keep_channels(const supervisor_t* const supervisor, checkpoint_state_t* const state)
{
    const message_endpoint_t* const endpoint = supervisor->config.endpoint;
    message_clock(endpoint, &state->message_life, &state->message_stamp);
    state->channel_count = 0U;
    while ((state->channel_count < MESSAGE_PEERS_MAX) &&
           message_position(endpoint, state->channel_count, &state->channels[state->channel_count])) {
        state->channel_count++;
    }
}

static void keep(supervisor_t* const supervisor, checkpoint_state_t* const state)
{
    (void)memset(state, 0, sizeof *state);
    state->interface_hash          = supervisor->mission->interface_hash;
    state->now_ns                  = supervisor->now_ns;
    state->log_number              = supervisor->log.next_number;
    state->log_written             = supervisor->log.written_number;
    state->log_strategy            = (uint8_t)supervisor->log.wanted;
    state->is_log_failure_reported = supervisor->is_log_failure_reported;
    state->lives                   = supervisor->lives;
    state->mode                    = supervisor->mode;
    state->autostart_step          = (uint8_t)supervisor->autostart_step;
    state->shutdown_step           = (uint8_t)supervisor->shutdown_step;
    state->shutdown_ns             = supervisor->shutdown_ns;
    state->orbit_state             = supervisor->orbit_state;
    state->has_shutdown_token      = supervisor->has_shutdown_token;
    state->shutdown_token          = supervisor->shutdown_token;
    (void)memcpy(state->log_sizes, supervisor->log.whole, sizeof state->log_sizes);
    (void)memcpy((uint8_t*)state->counters, (const uint8_t*)&supervisor->counters,
                 sizeof supervisor->counters);
    keep_subsystems(supervisor, state);
    state->link_epoch       = supervisor->link_epoch;
    state->link_transaction = supervisor->link_transaction;
    state->renewed          = supervisor->renewed;
    state->graph            = supervisor->graph;
    (void)memcpy(state->accepted, supervisor->accepted, sizeof state->accepted);
    (void)memcpy(state->sessions, supervisor->sessions, sizeof state->sessions);
    (void)memcpy(state->wanted, supervisor->wanted, sizeof state->wanted);
    (void)memcpy(state->renewals, supervisor->renewals, sizeof state->renewals);
    state->plans   = supervisor->plans;
    state->pending = supervisor->pending;
    state->own     = supervisor->own;
    keep_channels(supervisor, state);
    pus_counts(subsystem_process(&supervisor->subsystem), &supervisor->requester, &state->counts);
}

void supervisor_adoption_commit(supervisor_t* const supervisor)
{
    if (supervisor->config.checkpoint != NULL) {
        const checkpoint_rings_t rings = rings_of(supervisor);
        keep(supervisor, &supervisor->checkpoint_state);
        supervisor_ground_keep(supervisor);
        supervisor_checkpoint_commit(supervisor->config.checkpoint, &supervisor->checkpoint_state, &rings);
        supervisor->performed = 0U;
    }
}

/// True if the request belongs to a negotiation or to the shutdown, which continue.
static bool is_going_on(const supervisor_t* const supervisor, const pus_token_t* const token)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        const link_session_t* const session = &supervisor->sessions[i];
        if ((session->step != SESSION_FREE) && (session->token.request_id == token->request_id) &&
            (session->token.source == token->source)) {
            return true;
        }
    }
    return supervisor->has_shutdown_token && (supervisor->shutdown_token.request_id == token->request_id) &&
           (supervisor->shutdown_token.source == token->source);
}

/// Divide the requests to the supervisor itself: those that continue stay in `own`; the others go to `left`,
/// and end_own ends them.
static void leave_own(supervisor_t* const supervisor)
{
    supervisor->left = supervisor->own;
    supervisor_pending_init(&supervisor->own);
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        const pus_token_t token = supervisor->left.entries[i].token;
        if ((supervisor->left.entries[i].apid != 0U) && is_going_on(supervisor, &token)) {
            (void)supervisor_pending_add(&supervisor->own, SUPERVISOR_APID, &token,
                                         supervisor->left.entries[i].since_ns);
            supervisor->left.entries[i].apid = 0U;
        }
    }
}

/// Continue the channels in their present life, then process the frames that arrived after the commit.
static void take_messages(supervisor_t* const supervisor, const checkpoint_state_t* const state)
{
    message_endpoint_t* const endpoint   = supervisor->config.endpoint;
    const checkpoint_t* const checkpoint = supervisor->config.checkpoint;
    size_t position                      = 0U;
    size_t size                          = 0U;
    message_resume_clock(endpoint, state->message_life, state->message_stamp);
    for (uint16_t i = 0U; i < state->channel_count; i++) {
        message_resume(endpoint, &state->channels[i]);
    }
    const uint8_t* frame = supervisor_checkpoint_next(checkpoint, &checkpoint->arrivals, &position, &size);
    for (; frame != NULL;
         frame = supervisor_checkpoint_next(checkpoint, &checkpoint->arrivals, &position, &size)) {
        const status_t status = message_deliver(endpoint, frame, size);
        (void)status; // The ring has room, because it had room for the frame before.
    }
}

static void take(supervisor_t* const supervisor, const checkpoint_state_t* const state)
{
    supervisor->now_ns                  = state->now_ns;
    supervisor->lives                   = state->lives + 1U;
    supervisor->is_adopted              = true;
    supervisor->is_log_failure_reported = state->is_log_failure_reported;
    supervisor->mode                    = state->mode;
    supervisor->is_continued            = state->autostart_step != 0U;
    supervisor->shutdown_step           = state->shutdown_step;
    supervisor->shutdown_ns             = state->shutdown_ns;
    supervisor->orbit_state             = state->orbit_state;
    supervisor->has_shutdown_token      = state->has_shutdown_token;
    supervisor->shutdown_token          = state->shutdown_token;
    (void)memcpy((uint8_t*)&supervisor->counters, (const uint8_t*)state->counters,
                 sizeof supervisor->counters);
    take_subsystems(supervisor, state);
    supervisor->link_epoch       = state->link_epoch;
    supervisor->link_transaction = state->link_transaction;
    supervisor->renewed          = state->renewed;
    supervisor->graph            = state->graph;
    (void)memcpy(supervisor->accepted, state->accepted, sizeof supervisor->accepted);
    (void)memcpy(supervisor->sessions, state->sessions, sizeof supervisor->sessions);
    (void)memcpy(supervisor->wanted, state->wanted, sizeof supervisor->wanted);
    (void)memcpy(supervisor->renewals, state->renewals, sizeof supervisor->renewals);
    supervisor->plans   = state->plans;
    supervisor->pending = state->pending;
    supervisor->own     = state->own;
    leave_own(supervisor);
    supervisor_ground_resume(supervisor);
    // If the endpoint has outlived the component (image), its channels continue by themselves.
    if (!supervisor->config.is_endpoint_kept) {
        take_messages(supervisor, state);
    }
    pus_counts_resume(subsystem_process(&supervisor->subsystem), &supervisor->requester, &state->counts);
    subsystem_set_time(&supervisor->subsystem, state->now_ns);
}

void supervisor_adoption_begin(supervisor_t* const supervisor)
{
    const checkpoint_limits_t limits = {.mission = supervisor->mission, .now_ns = UINT64_MAX};
    checkpoint_rings_t rings         = rings_of(supervisor);
    supervisor->lives                = 1U;
    supervisor->log_strategy         = (uint8_t)supervisor->mission->log_strategy;
    supervisor->log_past             = (packet_log_past_t){.next_number    = supervisor->config.log_records + 1U,
                                                           .written_number = supervisor->config.log_records};
    if (supervisor->config.checkpoint == NULL) {
        return;
    }
    for (size_t i = 0U; (i < MESSAGE_PEERS_MAX) && supervisor->config.is_endpoint_kept; i++) {
        rings.list[FIRST_INBOX + i] = NULL;
    }
    rings.list[LOG_RING]  = NULL; // The packet log restores its ring itself.
    bool is_older         = false;
    const status_t status = supervisor_checkpoint_adopt(supervisor->config.checkpoint, &limits,
                                                        &supervisor->checkpoint_state, &rings, &is_older);
    if (status == STATUS_OK) {
        take(supervisor, &supervisor->checkpoint_state);
        supervisor_output_commit_resume(supervisor);
        const checkpoint_state_t* const kept = &supervisor->checkpoint_state;
        supervisor->log_strategy             = kept->log_strategy;
        supervisor->log_past =
            (packet_log_past_t){.next_number = kept->log_number, .written_number = kept->log_written};
        (void)memcpy(supervisor->log_past.sizes, kept->log_sizes, sizeof kept->log_sizes);
        supervisor->log_past.ring = supervisor_checkpoint_waiting(supervisor->config.checkpoint, LOG_RING,
                                                                  &supervisor->log_past.ring_octets);
    }
    if ((status == STATUS_INVALID) || is_older) {
        supervisor->checkpoint_damage = (status == STATUS_OK) ? ADOPTION_OLDER : ADOPTION_NOTHING;
        supervisor->is_checkpoint_copied =
            (supervisor->config.keep_checkpoint != NULL) &&
            supervisor->config.keep_checkpoint(supervisor->config.platform.context,
                                               supervisor->config.checkpoint);
    }
}

// ---- Reports and requests after the takeover ----

/// End the requests that the previous supervisor had started and that cannot continue. Returns their number.
static uint16_t end_own(supervisor_t* const supervisor)
{
    const pus_failure_t failure = pus_failure(PUS_FAILURE_RESTARTED, supervisor->lives);
    uint16_t count              = 0U;
    pus_token_t token;
    while (supervisor_pending_take(&supervisor->left, SUPERVISOR_APID, &token)) {
        pus_verify_failed(subsystem_process(&supervisor->subsystem), &token, &failure, supervisor->now_ns);
        count++;
    }
    return count;
}

/// Request the states of all subsystems, and their links if some were taken over: these reports take
/// precedence over the checkpoint.
static void ask_subsystems(supervisor_t* const supervisor)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const registry_entry_t* const entry = &supervisor->registry[i];
        if ((entry->process != PROCESS_RUNNING) || (entry->mission->apid == SUPERVISOR_APID)) {
            continue;
        }
        octet_writer_t writer = pus_tc_begin(&supervisor->requester, entry->mission->apid,
                                             PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REPORT_STATUS, 0U);
        status_t status       = pus_tc_send(&supervisor->requester, &writer, NULL);
        if (entry->are_links_adopted) {
            writer = pus_tc_begin(&supervisor->requester, entry->mission->apid, PUS_SERVICE_RTLINK,
                                  PUS_LINK_REPORT_STATUS, 0U);
            octet_write_u8(&writer, 0U);
            status = pus_tc_send(&supervisor->requester, &writer, NULL);
        }
        // If the request cannot be sent, the subsystem still reports its status once per second.
        (void)status;
    }
}

void supervisor_adoption_reopen(supervisor_t* const supervisor)
{
    if (supervisor->checkpoint_damage != ADOPTION_NOTHING) {
        return;
    }
    // message_probe sends a SYNC only to a peer that has uncredited frames: these requests are such frames.
    // They may be lost, because the peers may expect other sequence numbers, so they are repeated after the
    // SYNC.
    ask_subsystems(supervisor);
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        message_probe(supervisor->config.endpoint, supervisor->mission->subsystems[i].apid);
    }
    ask_subsystems(supervisor);
}

void supervisor_adoption_report(supervisor_t* const supervisor)
{
    if (supervisor->checkpoint_damage != ADOPTION_WHOLE) {
        const uint8_t left            = (supervisor->checkpoint_damage == ADOPTION_OLDER) ? 1U : 0U;
        const uint8_t octets[2]       = {left, supervisor->is_checkpoint_copied ? 1U : 0U};
        supervisor->checkpoint_damage = ADOPTION_WHOLE;
        (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_CHECKPOINT_DAMAGED, octets,
                              sizeof octets);
        if (left == 0U) {
            supervisor_mode_fall_back(supervisor);
        }
    }
    if (!supervisor->is_adopted) {
        return;
    }
    subsystem_set_time(&supervisor->subsystem, supervisor->now_ns);
    supervisor->is_adopted = false;
    const uint16_t ended   = end_own(supervisor);
    uint8_t octets[6];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u32(&writer, supervisor->lives);
    octet_write_u16(&writer, ended);
    (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_SUPERVISOR_RESTARTED, octets,
                          writer.position);
    ask_subsystems(supervisor);
}

void supervisor_adoption_compare(supervisor_t* const supervisor, registry_entry_t* const entry,
                                 const uint8_t state, const uint16_t configuration)
{
    const bool differs = ((uint8_t)entry->state != state) || (entry->configuration != configuration);
    if (entry->is_state_adopted && differs) {
        uint8_t octets[8];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_u16(&writer, entry->mission->apid);
        octet_write_u8(&writer, (uint8_t)entry->state);
        octet_write_u16(&writer, entry->configuration);
        octet_write_u8(&writer, state);
        octet_write_u16(&writer, configuration);
        (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_ADOPTION_DIFFERS, octets,
                              writer.position);
    }
    entry->is_state_adopted = false;
}
