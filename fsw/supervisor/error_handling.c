// SPDX-License-Identifier: Apache-2.0
// Reaction to events by severity and reason (4.3 and 5 of the paper that docs/glossary.md names), in layers:
//     0  the subsystem itself, in its cycle (fsw/framework/subsystem)
//     1  always, by this file: HIGH takes the real-time network to ERROR_OPERATIONAL, MEDIUM the subsystem
//        from OPERATIONAL to SAFE_OPERATIONAL
//     2  the recovery plan of the mission, or the built-in one for HIGH: the network to OFFLINE
// Layer 1 reacts independently of the plans that run and of their content. LOW and informative events
// have no reaction of layer 1.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

#define ORDER_STANDS_NS 1000000000ULL ///< After this time an unanswered order is repeated.

typedef struct { // An event, and the subsystem that it is about.
    descriptor_severity_t severity;
    uint16_t apid; ///< The subsystem that failed; SUPERVISOR_APID for an event about the supervisor itself.
    uint16_t event_id;
    const mission_plan_t* plan; ///< Recovery plan; null: the mission has none for this event.
    /// The supervisor has detected the failure: the subsystem itself has not reacted.
    bool is_finding;
} failure_t;

void supervisor_raise_u16(supervisor_t* const supervisor, const uint16_t event_id, const uint16_t first)
{
    uint8_t octets[2];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, first);
    (void)subsystem_raise(&supervisor->subsystem, event_id, octets, writer.position);
}

void supervisor_raise_u16_u16(supervisor_t* const supervisor, const uint16_t event_id, const uint16_t first,
                              const uint16_t second)
{
    uint8_t octets[4];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, first);
    octet_write_u16(&writer, second);
    (void)subsystem_raise(&supervisor->subsystem, event_id, octets, writer.position);
}

/// Returns the index of a plan in the mission; PLAN_BUILT_IN for null.
static uint16_t number_of(const supervisor_t* const supervisor, const mission_plan_t* const plan)
{
    return (plan != NULL) ? (uint16_t)(plan - supervisor->mission->plans) : PLAN_BUILT_IN;
}

// ---- Orders ----

/// True if an order for the state `open` also has the effect of an order for `state`: it takes the subsystem
/// to that state, or safely to a lower one.
static bool is_covered(const state_t open, const state_t state)
{
    switch (state) {
    case STATE_SAFE_OPERATIONAL:
        return (open == STATE_OFFLINE) || (open == STATE_PRE_OPERATIONAL) ||
               (open == STATE_SAFE_OPERATIONAL) || (open == STATE_ERROR_OPERATIONAL);
    case STATE_PRE_OPERATIONAL:
        return (open == STATE_OFFLINE) || (open == STATE_PRE_OPERATIONAL);
    default:
        return open == state;
    }
}

/// True if an order that waits to be sent, or that was not answered yet, has the effect of an order for
/// `state`.
static bool is_ordered(const supervisor_t* const supervisor, const registry_entry_t* const entry,
                       const state_t state)
{
    const bool is_recent =
        (entry->order.request_id != 0U) && ((supervisor->now_ns - entry->order.time_ns) < ORDER_STANDS_NS);
    const bool is_open = entry->is_order_pending ||
                         (is_recent && supervisor_pending_is_open(&supervisor->pending, entry->mission->apid,
                                                                  entry->order.request_id));
    return is_open && is_covered(entry->ordered, state);
}

/// True if a state is lower: a reaction to an error never takes a subsystem to a higher state.
static bool is_downwards(const state_t from, const state_t to)
{
    const bool is_in_operation = (from >= STATE_PRE_OPERATIONAL) && (from <= STATE_OPERATIONAL);
    switch (to) {
    case STATE_OFFLINE:
        return from != STATE_OFFLINE;
    case STATE_ERROR_OPERATIONAL:
        return (from != STATE_OFFLINE) && (from != STATE_ERROR_OPERATIONAL);
    default:
        return is_in_operation && (from > to);
    }
}

/// Order a subsystem to a lower state. True if an order was given. Only the shutdown takes the supervisor
/// itself to a lower state.
static bool order_down(supervisor_t* const supervisor, const uint16_t apid, const state_t state,
                       const pus_cause_t cause)
{
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, apid);
    const bool is_due = (entry != NULL) && (apid != SUPERVISOR_APID) && (entry->process == PROCESS_RUNNING) &&
                        is_downwards(entry->state, state) && !is_ordered(supervisor, entry, state);
    if (is_due) {
        (void)supervisor_order_state(supervisor, apid, state, cause);
    }
    return is_due;
}

// ---- Layer 1 ----

/// Order all members of the network to ERROR_OPERATIONAL. The failed member goes there by itself, unless the
/// supervisor has detected the failure. Returns the number of orders.
static uint16_t secure_network(supervisor_t* const supervisor, const failure_t* const failure,
                               const uint16_t* const members, const uint16_t count)
{
    uint16_t ordered = 0U;
    for (uint16_t i = 0U; i < count; i++) {
        const bool is_meant = failure->is_finding || (members[i] != failure->apid);
        if (is_meant && order_down(supervisor, members[i], STATE_ERROR_OPERATIONAL, PUS_CAUSE_NETWORK)) {
            ordered++;
        }
    }
    return ordered;
}

// ---- Layer 2 ----

/// Returns a run of the plan for a failure, with all members of the real-time network.
static plan_run_t run_for(supervisor_t* const supervisor, const failure_t* const failure)
{
    plan_run_t run   = {.severity = failure->severity,
                        .plan     = number_of(supervisor, failure->plan),
                        .apid     = failure->apid,
                        .event_id = failure->event_id,
                        .start_ns = supervisor->now_ns};
    run.member_count = supervisor_link_graph_members(&supervisor->graph, failure->apid, run.members);
    return run;
}

/// Report that the plan for another event has replaced a running plan.
static void report_overruled(supervisor_t* const supervisor, const plan_run_t* const run,
                             const plan_run_t* const other)
{
    uint8_t octets[8];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, run->apid);
    octet_write_u16(&writer, run->event_id);
    octet_write_u16(&writer, other->apid);
    octet_write_u16(&writer, other->event_id);
    supervisor->reactions.overruled++;
    (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_PLAN_OVERRULED, octets, writer.position);
}

/// Start the plan of a failure, unless a plan of the same or a higher severity concerns the subsystem.
static void start_plan(supervisor_t* const supervisor, const plan_run_t* const wanted)
{
    plan_run_t ended;
    while (supervisor_plan_runner_overrule(&supervisor->plans, wanted, &ended)) {
        report_overruled(supervisor, &ended, wanted);
    }
    const plan_verdict_t verdict = supervisor_plan_runner_start(&supervisor->plans, wanted);
    if (verdict == PLAN_STARTED) {
        supervisor->counters.plans_started++;
        supervisor_raise_u16_u16(supervisor, SUPERVISOR_EVENT_PLAN_STARTED, wanted->apid, wanted->event_id);
    } else if (verdict == PLAN_JOINED) {
        supervisor->reactions.joined++;
    } else {
        report_overruled(supervisor, wanted, supervisor_plan_runner_of(&supervisor->plans, wanted->apid));
    }
}

static void order_members(supervisor_t* const supervisor, const plan_run_t* const run, const state_t state)
{
    for (uint16_t i = 0U; i < run->member_count; i++) {
        if (supervisor_plan_runner_concerns(run, run->members[i])) {
            (void)order_down(supervisor, run->members[i], state, PUS_CAUSE_PLAN);
        }
    }
}

static void perform_action(supervisor_t* const supervisor, const plan_run_t* const run,
                           const mission_action_t* const action)
{
    if (action->kind == MISSION_ACTION_MODE) {
        supervisor_mode_set(supervisor, action->mode, (uint8_t)PUS_CAUSE_PLAN);
    } else if (action->kind == MISSION_ACTION_STATE) {
        const uint16_t target = (action->target == MISSION_SELF) ? run->apid : action->target;
        if (action->target == MISSION_NETWORK) {
            order_members(supervisor, run, (state_t)action->state);
        } else if (supervisor_plan_runner_concerns(run, target)) {
            (void)order_down(supervisor, target, (state_t)action->state, PUS_CAUSE_PLAN);
        } else {
            // A member whose process has died gets no order: it starts again in OFFLINE.
        }
    } else {
        // MISSION_ACTION_LOG: the event itself is in the log.
    }
}

void supervisor_error_run_plans(supervisor_t* const supervisor)
{
    for (size_t i = 0U; i < PLAN_RUNS; i++) {
        plan_run_t* const run = &supervisor->plans.runs[i];
        const mission_action_t* action =
            supervisor_plan_runner_next(run, supervisor->mission, supervisor->now_ns);
        while (action != NULL) {
            perform_action(supervisor, run, action);
            action = supervisor_plan_runner_next(run, supervisor->mission, supervisor->now_ns);
        }
    }
}

// ---- Events ----

/// React to an event of severity HIGH: secure the network (layer 1), then start the plan (layer 2).
static void handle_high(supervisor_t* const supervisor, const failure_t* const failure)
{
    const plan_run_t wanted         = run_for(supervisor, failure);
    const plan_run_t* const present = supervisor_plan_runner_of(&supervisor->plans, failure->apid);
    // NETWORK_SHUT_DOWN is not repeated for a failure that a running plan covers, unless it leads to
    // orders.
    const bool is_new      = (present == NULL) || (present->severity < failure->severity);
    const uint16_t ordered = secure_network(supervisor, failure, wanted.members, wanted.member_count);
    if ((wanted.member_count > 1U) && (is_new || (ordered > 0U))) {
        supervisor_raise_u16_u16(supervisor, SUPERVISOR_EVENT_NETWORK_SHUT_DOWN,
                                 supervisor_link_graph_network(&supervisor->graph, failure->apid),
                                 failure->apid);
    }
    if ((supervisor->shutdown_step == 0U) &&
        ((failure->plan != NULL) || (failure->apid != SUPERVISOR_APID))) {
        start_plan(supervisor, &wanted);
    }
}

/// React to an event of severity MEDIUM. The plan runs before layer 1, so that layer 1 gives no second order
/// if the plan has already ordered a lower state.
static void handle_medium(supervisor_t* const supervisor, const failure_t* const failure)
{
    if ((failure->plan != NULL) && (supervisor->shutdown_step == 0U)) {
        const plan_run_t wanted = run_for(supervisor, failure);
        start_plan(supervisor, &wanted);
        supervisor_error_run_plans(supervisor);
    }
    (void)order_down(supervisor, failure->apid, STATE_SAFE_OPERATIONAL, PUS_CAUSE_OWN_ERROR);
}

/// React to a LOW or informative event: run the plan, if the mission has one for it.
static void handle_low(supervisor_t* const supervisor, const failure_t* const failure)
{
    if ((failure->plan != NULL) && (supervisor->shutdown_step == 0U)) {
        const plan_run_t wanted = run_for(supervisor, failure);
        start_plan(supervisor, &wanted);
    }
}

/// React to a failure. After the shutdown has ordered all subsystems to OFFLINE, no reaction may order
/// another state.
static void react(supervisor_t* const supervisor, const failure_t* const failure)
{
    if (supervisor_sequence_is_ending(supervisor)) {
        return;
    }
    if (failure->severity == DESCRIPTOR_HIGH) {
        handle_high(supervisor, failure);
    } else if (failure->severity == DESCRIPTOR_MEDIUM) {
        handle_medium(supervisor, failure);
    } else {
        handle_low(supervisor, failure);
    }
}

void supervisor_error_event(supervisor_t* const supervisor, const pus_event_occurrence_t* const event)
{
    if ((event->apid == SUPERVISOR_APID) || (supervisor_registry_find(supervisor, event->apid) == NULL)) {
        return;
    }
    const descriptor_severity_t severity = (descriptor_severity_t)event->severity;
    const failure_t failure              = {
                     .severity = severity,
                     .apid     = event->apid,
                     .event_id = event->event,
                     .plan     = descriptor_mission_find_plan(supervisor->mission, severity, event->apid, event->event)};
    react(supervisor, &failure);
}

// ---- Events of the supervisor itself ----

/// Returns the plan for a failure that the supervisor has detected, which is an event of the supervisor. The
/// plan is one for the supervisor; otherwise, if the event is about a subsystem, one for any event of that
/// subsystem.
static const mission_plan_t* plan_of_finding(const supervisor_t* const supervisor,
                                             const descriptor_severity_t severity, const uint16_t apid,
                                             const uint16_t event_id)
{
    const mission_plan_t* const own =
        descriptor_mission_find_plan(supervisor->mission, severity, SUPERVISOR_APID, event_id);
    if ((own != NULL) && (own->apid == SUPERVISOR_APID)) {
        return own;
    }
    return (apid != SUPERVISOR_APID) ? descriptor_mission_find_plan(supervisor->mission, severity, apid, 0U)
                                     : NULL;
}

static void handle_finding(supervisor_t* const supervisor, const descriptor_severity_t severity,
                           const uint16_t apid, const uint16_t event_id)
{
    const failure_t failure = {.severity   = severity,
                               .apid       = apid,
                               .event_id   = event_id,
                               .plan       = plan_of_finding(supervisor, severity, apid, event_id),
                               .is_finding = true};
    react(supervisor, &failure);
}

/// React to the loss of a process. A process that hangs is killed and then lost; therefore, if no plan is
/// for `event_id`, a plan for PROCESS_LOST applies.
void supervisor_error_member_lost(supervisor_t* const supervisor, const uint16_t apid,
                                  const uint16_t event_id)
{
    const mission_plan_t* const plan =
        descriptor_mission_find_plan(supervisor->mission, DESCRIPTOR_HIGH, SUPERVISOR_APID, event_id);
    const bool is_named = (plan != NULL) && (plan->apid == SUPERVISOR_APID);
    handle_finding(supervisor, DESCRIPTOR_HIGH, apid, is_named ? event_id : SUPERVISOR_EVENT_PROCESS_LOST);
    // The run exists now: its later actions leave out the dead process.
    supervisor_plan_runner_mark_lost(&supervisor->plans, apid);
}

void supervisor_error_member_silent(supervisor_t* const supervisor, const uint16_t apid)
{
    handle_finding(supervisor, DESCRIPTOR_HIGH, apid, SUPERVISOR_EVENT_SUBSYSTEM_SILENT);
}

/// Returns the subsystem that an event of the supervisor is about: the first value of the event, if its name
/// in the descriptor is APID and the mission has that subsystem; otherwise SUPERVISOR_APID.
static uint16_t subject_of(supervisor_t* const supervisor, const pus_tm_t* const tm, const uint16_t event_id)
{
    const subsystem_descriptor_t* const descriptor = supervisor->config.descriptor;
    const descriptor_event_t* const event          = descriptor_find_event(descriptor, event_id);
    octet_reader_t reader                          = octet_reader(tm->data, tm->size);
    if ((event == NULL) || (event->field_count == 0U) || (tm->service != PUS_SERVICE_EVENTS)) {
        return SUPERVISOR_APID;
    }
    const descriptor_field_t* const first = &descriptor->fields[event->first_field];
    (void)octet_read_u16(&reader); // Event id.
    const bool is_named = (strcmp(first->name, "APID") == 0) && (first->type == VALUE_UINT16);
    const uint16_t apid = is_named ? octet_read_u16(&reader) : SUPERVISOR_APID;
    return (supervisor_registry_find(supervisor, apid) != NULL) ? apid : SUPERVISOR_APID;
}

/// True if an event of the supervisor needs a reaction: by a plan, or by layer 1 for the subsystem that it
/// is about.
static bool needs_reaction(const supervisor_t* const supervisor, const own_event_t* const event)
{
    const descriptor_severity_t severity = (descriptor_severity_t)event->severity;
    const bool is_layer_1 = (event->subject != SUPERVISOR_APID) && (severity >= DESCRIPTOR_MEDIUM);
    return is_layer_1 || (plan_of_finding(supervisor, severity, event->subject, event->event_id) != NULL);
}

/// True if an equal event is already stored for the end of the step.
static bool is_noted(const supervisor_t* const supervisor, const own_event_t* const event)
{
    for (uint16_t i = 0U; i < supervisor->own_event_count; i++) {
        const own_event_t* const noted = &supervisor->own_events[i];
        if ((noted->event_id == event->event_id) && (noted->subject == event->subject)) {
            return true;
        }
    }
    return false;
}

void supervisor_error_own_event(supervisor_t* const supervisor, const pus_tm_t* const tm,
                                const pus_event_occurrence_t* const occurrence)
{
    // These events are handled when they are raised.
    const bool is_handled = (occurrence->event == SUPERVISOR_EVENT_PROCESS_LOST) ||
                            (occurrence->event == SUPERVISOR_EVENT_PROCESS_HUNG) ||
                            (occurrence->event == SUPERVISOR_EVENT_SUBSYSTEM_SILENT);
    const own_event_t event = {.event_id = occurrence->event,
                               .severity = occurrence->severity,
                               .subject  = subject_of(supervisor, tm, occurrence->event)};
    // Informative events have no reaction, because PLAN_STARTED would start plans without end.
    if (is_handled || (event.severity < (uint8_t)PUS_SEVERITY_LOW) || is_noted(supervisor, &event) ||
        !needs_reaction(supervisor, &event)) {
        return;
    }
    if (supervisor->own_event_count == SUPERVISOR_OWN_EVENTS) {
        supervisor->reactions.missed++;
        return;
    }
    supervisor->own_events[supervisor->own_event_count] = event;
    supervisor->own_event_count++;
}

void supervisor_error_own_events(supervisor_t* const supervisor)
{
    own_event_t events[SUPERVISOR_OWN_EVENTS];
    const uint16_t count = supervisor->own_event_count;
    (void)memcpy(events, supervisor->own_events, sizeof events);
    supervisor->own_event_count = 0U; // Events that a reaction raises are handled in the next step.
    for (uint16_t i = 0U; i < count; i++) {
        handle_finding(supervisor, (descriptor_severity_t)events[i].severity, events[i].subject,
                       events[i].event_id);
    }
}
