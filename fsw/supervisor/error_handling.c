// SPDX-License-Identifier: Apache-2.0
// Reaction to events by severity and reason (paper, 4.3 and 5). HIGH: all members of the real-time network go
// to ERROR_OPERATIONAL at once, then the recovery plan (default: OFFLINE). MEDIUM: the plan (default: the
// subsystem to SAFE_OPERATIONAL). LOW and informative: the log has them.
#include "fsw/supervisor/supervisor_internal.h"

#include "fsw/framework/base/assertion.h"

#define DEFAULT_PLAN_DELAY_NS 500000000ULL ///< HIGH without a plan of the mission: OFFLINE after this time.

void raise_u16(supervisor_t* const supervisor, const uint16_t event_id, const uint16_t first)
{
    uint8_t octets[2];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, first);
    (void)subsystem_raise(&supervisor->component, event_id, octets, writer.position);
}

void raise_u16_u16(supervisor_t* const supervisor, const uint16_t event_id, const uint16_t first,
                   const uint16_t second)
{
    uint8_t octets[4];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, first);
    octet_write_u16(&writer, second);
    (void)subsystem_raise(&supervisor->component, event_id, octets, writer.position);
}

void error_set_mode(supervisor_t* const supervisor, const uint8_t mode, const uint8_t cause)
{
    if (supervisor->mode == mode) {
        return;
    }
    const pus_mode_transition_t transition = {.previous = supervisor->mode, .mode = mode, .cause = cause};
    const uint8_t octets[2]                = {supervisor->mode, mode};
    supervisor->mode                       = mode;
    (void)pus_mode_transition_report(component_process(&supervisor->component), &transition,
                                     supervisor->now_ns);
    (void)subsystem_raise(&supervisor->component, SUPERVISOR_EVENT_MODE_CHANGED, octets, sizeof octets);
}

static plan_run_t* free_plan(supervisor_t* const supervisor)
{
    for (size_t i = 0U; i < SUPERVISOR_PLANS; i++) {
        if (!supervisor->plans[i].is_used) {
            return &supervisor->plans[i];
        }
    }
    return NULL;
}

/// A plan for the network of `apid` is under way: a second error of the same failure starts no second plan.
static bool is_planned(const supervisor_t* const supervisor, const uint16_t apid)
{
    for (size_t i = 0U; i < SUPERVISOR_PLANS; i++) {
        const plan_run_t* const run = &supervisor->plans[i];
        for (uint16_t k = 0U; run->is_used && (k < run->member_count); k++) {
            if (run->members[k] == apid) {
                return true;
            }
        }
    }
    return false;
}

/// `lost`: a member whose process died; it begins anew in OFFLINE and is no part of the plan. 0: none.
static void start_plan(supervisor_t* const supervisor, const mission_plan_t* const plan, const uint16_t apid,
                       const uint16_t event_id, const uint16_t lost)
{
    plan_run_t* const run = free_plan(supervisor);
    if (run == NULL) {
        return; // Every member named by the plans under way is on its way down already.
    }
    *run              = (plan_run_t){.is_used = true, .plan = plan, .apid = apid, .lost = lost};
    run->start_ns     = supervisor->now_ns;
    run->member_count = link_graph_members(&supervisor->graph, apid, run->members);
    supervisor->counters.plans_started++;
    raise_u16_u16(supervisor, SUPERVISOR_EVENT_PLAN_STARTED, apid, event_id);
}

/// All other members of the network to ERROR_OPERATIONAL, at once. The failed one goes there by itself.
static void shut_network_down(supervisor_t* const supervisor, const uint16_t apid)
{
    uint16_t members[LINK_GRAPH_MEMBERS];
    const uint16_t count = link_graph_members(&supervisor->graph, apid, members);
    for (uint16_t i = 1U; i < count; i++) {
        const roster_entry_t* const member = roster_find(supervisor, members[i]);
        if ((member != NULL) && (member->process == PROCESS_RUNNING) &&
            (member->state != STATE_ERROR_OPERATIONAL)) {
            (void)order_state(supervisor, members[i], STATE_ERROR_OPERATIONAL);
        }
    }
    if (count > 1U) {
        raise_u16_u16(supervisor, SUPERVISOR_EVENT_NETWORK_SHUT_DOWN,
                      link_graph_network(&supervisor->graph, apid), apid);
    }
}

static void member_failed(supervisor_t* const supervisor, const mission_plan_t* const plan,
                          const uint16_t apid, const uint16_t event_id, const uint16_t lost)
{
    if (!is_planned(supervisor, apid) && (supervisor->shutdown_step == 0U)) {
        shut_network_down(supervisor, apid);
        start_plan(supervisor, plan, apid, event_id, lost);
    }
}

/// What the supervisor itself found out about a member is an event of the supervisor: a plan for that event,
/// or else one for any event of the member.
static const mission_plan_t* plan_of_finding(const supervisor_t* const supervisor, const uint16_t apid,
                                             const uint16_t event_id)
{
    const mission_plan_t* const own =
        mission_find_plan(supervisor->mission, DESCRIPTOR_HIGH, SUPERVISOR_APID, event_id);
    const bool is_meant = (own != NULL) && (own->apid == SUPERVISOR_APID);
    return is_meant ? own : mission_find_plan(supervisor->mission, DESCRIPTOR_HIGH, apid, 0U);
}

void error_member_lost(supervisor_t* const supervisor, const uint16_t apid)
{
    const uint16_t event_id = SUPERVISOR_EVENT_PROCESS_LOST;
    member_failed(supervisor, plan_of_finding(supervisor, apid, event_id), apid, event_id, apid);
}

void error_member_silent(supervisor_t* const supervisor, const uint16_t apid)
{
    const uint16_t event_id = SUPERVISOR_EVENT_SUBSYSTEM_SILENT;
    member_failed(supervisor, plan_of_finding(supervisor, apid, event_id), apid, event_id, 0U);
}

/// True if a state is one to go down to: a reaction to an error takes nothing up.
static bool is_downwards(const state_t from, const state_t to)
{
    const bool is_up_there = (from >= STATE_PRE_OPERATIONAL) && (from <= STATE_OPERATIONAL);
    switch (to) {
    case STATE_OFFLINE:
        return from != STATE_OFFLINE;
    case STATE_ERROR_OPERATIONAL:
        return (from != STATE_OFFLINE) && (from != STATE_ERROR_OPERATIONAL);
    default:
        return is_up_there && (from > to);
    }
}

static void order_down(supervisor_t* const supervisor, const uint16_t apid, const state_t state)
{
    const roster_entry_t* const entry = roster_find(supervisor, apid);
    if ((entry != NULL) && (entry->process == PROCESS_RUNNING) && is_downwards(entry->state, state)) {
        (void)order_state(supervisor, apid, state);
    }
}

static void medium(supervisor_t* const supervisor, const uint16_t apid, const uint16_t event_id)
{
    const mission_plan_t* const plan =
        mission_find_plan(supervisor->mission, DESCRIPTOR_MEDIUM, apid, event_id);
    if (plan != NULL) {
        start_plan(supervisor, plan, apid, event_id, 0U);
        error_run_plans(supervisor); // What is due at once goes out in this cycle.
    } else {
        order_down(supervisor, apid, STATE_SAFE_OPERATIONAL);
    }
}

void error_event(supervisor_t* const supervisor, const pus_event_occurrence_t* const event)
{
    if (event->severity == (uint8_t)PUS_SEVERITY_HIGH) {
        const mission_plan_t* const plan =
            mission_find_plan(supervisor->mission, DESCRIPTOR_HIGH, event->apid, event->event);
        member_failed(supervisor, plan, event->apid, event->event, 0U);
    } else if (event->severity == (uint8_t)PUS_SEVERITY_MEDIUM) {
        medium(supervisor, event->apid, event->event);
    } else {
        // Logged, nothing else.
    }
}

// ---- Plans under way ----

static void order_members(supervisor_t* const supervisor, const plan_run_t* const run, const state_t state)
{
    for (uint16_t i = 0U; i < run->member_count; i++) {
        if (run->members[i] != run->lost) {
            order_down(supervisor, run->members[i], state);
        }
    }
}

static void act(supervisor_t* const supervisor, const plan_run_t* const run,
                const mission_action_t* const action)
{
    if (action->kind == MISSION_ACTION_MODE) {
        error_set_mode(supervisor, action->mode, (uint8_t)PUS_CAUSE_PLAN);
    } else if (action->kind == MISSION_ACTION_STATE) {
        const uint16_t target = (action->target == MISSION_SELF) ? run->apid : action->target;
        if (action->target == MISSION_NETWORK) {
            order_members(supervisor, run, (state_t)action->state);
        } else if (target != run->lost) {
            order_down(supervisor, target, (state_t)action->state);
        } else {
            // Its process died: it begins anew in OFFLINE.
        }
    } else {
        // MISSION_ACTION_LOG: the event itself is in the log.
    }
}

static void run_plan(supervisor_t* const supervisor, plan_run_t* const run)
{
    const uint64_t age_ns = supervisor->now_ns - run->start_ns;
    if (run->plan == NULL) { // Built in for HIGH.
        if (age_ns >= DEFAULT_PLAN_DELAY_NS) {
            order_members(supervisor, run, STATE_OFFLINE);
            run->is_used = false;
        }
        return;
    }
    while (run->next_action < run->plan->action_count) {
        const mission_action_t* const action =
            &supervisor->mission->actions[run->plan->first_action + run->next_action];
        if (age_ns < ((uint64_t)action->after_us * 1000U)) {
            return;
        }
        act(supervisor, run, action);
        run->next_action++;
    }
    run->is_used = false;
}

void error_run_plans(supervisor_t* const supervisor)
{
    for (size_t i = 0U; i < SUPERVISOR_PLANS; i++) {
        if (supervisor->plans[i].is_used) {
            run_plan(supervisor, &supervisor->plans[i]);
        }
    }
}
