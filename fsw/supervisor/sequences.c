// SPDX-License-Identifier: Apache-2.0
// Sequences of the supervisor: bring up the subsystems that the mission marks `autostart`, and shut the
// mission down with `communication` last.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

#define SHUTDOWN_STEP_TIMEOUT_NS 3000000000ULL ///< Longest time of a step of the shutdown.

// ---- Autostart ----

/// Give the next order that takes a subsystem from its present state towards OPERATIONAL. True if it is
/// OPERATIONAL.
static bool bring_up(supervisor_t* const supervisor, const registry_entry_t* const entry)
{
    const uint16_t apid = entry->mission->apid;
    status_t status     = STATUS_OK;
    if (entry->state == STATE_OFFLINE) {
        status = supervisor_order_state(supervisor, apid, STATE_PRE_OPERATIONAL, PUS_CAUSE_REQUEST);
    } else if ((entry->state == STATE_PRE_OPERATIONAL) && (entry->phase == PHASE_UNCONFIGURED)) {
        status = supervisor_order_configuration(supervisor, apid, entry->mission->configurations[0].id);
    } else if ((entry->state == STATE_PRE_OPERATIONAL) && (entry->phase == PHASE_CONFIGURED)) {
        status = supervisor_order_state(supervisor, apid, STATE_SAFE_OPERATIONAL, PUS_CAUSE_REQUEST);
    } else if ((entry->state == STATE_SAFE_OPERATIONAL) && (entry->phase == PHASE_IDLE)) {
        status = supervisor_order_state(supervisor, apid, STATE_OPERATIONAL, PUS_CAUSE_REQUEST);
    } else {
        return (entry->state == STATE_OPERATIONAL) && (entry->phase == PHASE_IDLE);
    }
    (void)status; // If there is no room for an order, the next tick repeats it.
    return false;
}

/// True if `communication` is OFFLINE. The ground cannot command anything then, so the autostart brings
/// `communication` up again.
static bool is_ground_cut_off(supervisor_t* const supervisor)
{
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, COMMUNICATION_APID);
    return (entry != NULL) && entry->mission->is_autostart && entry->is_heard &&
           (entry->process == PROCESS_RUNNING) && (entry->state == STATE_OFFLINE);
}

void supervisor_sequence_autostart(supervisor_t* const supervisor)
{
    if (is_ground_cut_off(supervisor)) {
        supervisor->autostart_step = 0U;
    }
    if ((supervisor->autostart_step != 0U) || (supervisor->shutdown_step != 0U)) {
        return;
    }
    bool are_all_up = true;
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const registry_entry_t* const entry = &supervisor->registry[i];
        const bool is_wanted = entry->mission->is_autostart && (entry->process == PROCESS_RUNNING) &&
                               (entry->mission->configuration_count > 0U) &&
                               (!supervisor->is_continued || (entry->mission->apid == SUPERVISOR_APID));
        if (is_wanted && entry->is_heard) {
            are_all_up = bring_up(supervisor, entry) && are_all_up;
        } else if (is_wanted) {
            are_all_up = false;
        } else {
            // Without autostart, the operator brings the subsystem up.
        }
    }
    supervisor->autostart_step = are_all_up ? 1U : 0U;
    supervisor->is_continued   = supervisor->is_continued && !are_all_up;
}

// ---- Shutdown ----

enum {
    SHUTDOWN_NONE = 0,
    SHUTDOWN_TO_SAFE,       ///< First, all OPERATIONAL subsystems go to SAFE_OPERATIONAL at the same time.
    SHUTDOWN_TO_OFFLINE,    ///< Then all except `communication` and the supervisor go to OFFLINE.
    SHUTDOWN_COMMUNICATION, ///< The request is answered, and `communication` goes to OFFLINE.
    SHUTDOWN_SELF,
    SHUTDOWN_DONE
};

static bool is_in_shutdown_group(const registry_entry_t* const entry)
{
    return (entry->mission->apid != SUPERVISOR_APID) && (entry->mission->apid != COMMUNICATION_APID) &&
           (entry->process == PROCESS_RUNNING);
}

/// Order the subsystems of the group to a state; only those in the state `only_from` (STATE_COUNT: all). The
/// order replaces one that waits, which could take a subsystem to a higher state later.
static void order_group(supervisor_t* const supervisor, const state_t only_from, const state_t target)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const registry_entry_t* const entry = &supervisor->registry[i];
        const bool is_meant                 = (only_from == STATE_COUNT) || (entry->state == only_from);
        const bool is_there                 = (entry->state == target) && !entry->is_order_pending;
        if (is_in_shutdown_group(entry) && is_meant && !is_there) {
            (void)supervisor_order_state(supervisor, entry->mission->apid, target, PUS_CAUSE_SHUTDOWN);
        }
    }
}

/// True if a subsystem of the group is OPERATIONAL or, with is_operational false, not OFFLINE.
static bool is_any_in(const supervisor_t* const supervisor, const bool is_operational)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const registry_entry_t* const entry = &supervisor->registry[i];
        const bool is_meant =
            is_operational ? (entry->state == STATE_OPERATIONAL) : (entry->state != STATE_OFFLINE);
        if (is_in_shutdown_group(entry) && is_meant) {
            return true;
        }
    }
    return false;
}

static void enter_step(supervisor_t* const supervisor, const unsigned step)
{
    // Time since the order of the previous step: a request that is older was sent before that order.
    const uint64_t passed_ns  = supervisor->now_ns - supervisor->shutdown_ns;
    supervisor->shutdown_step = step;
    supervisor->shutdown_ns   = supervisor->now_ns;
    switch (step) {
    case SHUTDOWN_TO_SAFE:
        order_group(supervisor, STATE_OPERATIONAL, STATE_SAFE_OPERATIONAL);
        break;
    case SHUTDOWN_TO_OFFLINE:
        order_group(supervisor, STATE_COUNT, STATE_OFFLINE);
        break;
    case SHUTDOWN_COMMUNICATION:
        // A subsystem in OFFLINE has answered all requests that it received before the order for OFFLINE.
        // Unanswered requests were lost.
        supervisor_registry_end_unanswered(supervisor, passed_ns);
        if (supervisor->has_shutdown_token) {
            pus_verify_completed(subsystem_process(&supervisor->subsystem), &supervisor->shutdown_token,
                                 supervisor->now_ns);
        }
        if (supervisor_registry_find(supervisor, COMMUNICATION_APID) != NULL) { // A mission may have none.
            (void)supervisor_order_state(supervisor, COMMUNICATION_APID, STATE_OFFLINE, PUS_CAUSE_SHUTDOWN);
        }
        break;
    case SHUTDOWN_SELF:
        (void)subsystem_request(&supervisor->subsystem, STATE_OFFLINE, CAUSE_SHUTDOWN);
        break;
    default:
        supervisor_mode_end(supervisor);
        supervisor->is_finished = true;
        supervisor_output_commit_finish(supervisor);
        break;
    }
}

void supervisor_sequence_shutdown_begin(supervisor_t* const supervisor, const pus_token_t* const token)
{
    if (supervisor->shutdown_step != SHUTDOWN_NONE) {
        return;
    }
    supervisor->has_shutdown_token = (token != NULL);
    if (token != NULL) {
        supervisor->shutdown_token = *token;
    }
    enter_step(supervisor, SHUTDOWN_TO_SAFE);
}

static bool is_step_done(supervisor_t* const supervisor)
{
    const registry_entry_t* const communication = supervisor_registry_find(supervisor, COMMUNICATION_APID);
    switch (supervisor->shutdown_step) {
    case SHUTDOWN_TO_SAFE:
        return !is_any_in(supervisor, true);
    case SHUTDOWN_TO_OFFLINE:
        return !is_any_in(supervisor, false);
    case SHUTDOWN_COMMUNICATION:
        return (communication == NULL) || (communication->process != PROCESS_RUNNING) ||
               (communication->state == STATE_OFFLINE);
    default:
        return supervisor->subsystem.machine.state == STATE_OFFLINE;
    }
}

void supervisor_sequence_left_offline(supervisor_t* const supervisor, const registry_entry_t* const entry)
{
    if (supervisor_sequence_is_ending(supervisor) && is_in_shutdown_group(entry)) {
        (void)supervisor_order_state(supervisor, entry->mission->apid, STATE_OFFLINE, PUS_CAUSE_SHUTDOWN);
    }
}

bool supervisor_sequence_is_ending(const supervisor_t* const supervisor)
{
    return supervisor->shutdown_step >= (unsigned)SHUTDOWN_TO_OFFLINE;
}

void supervisor_sequence_shutdown(supervisor_t* const supervisor)
{
    if ((supervisor->shutdown_step == SHUTDOWN_NONE) || supervisor->is_finished) {
        return;
    }
    const bool is_late = (supervisor->now_ns - supervisor->shutdown_ns) > SHUTDOWN_STEP_TIMEOUT_NS;
    if (is_step_done(supervisor) || is_late) {
        enter_step(supervisor, supervisor->shutdown_step + 1U);
    }
}
