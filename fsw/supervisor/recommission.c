// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/recommission.h"

#include "base/assertion.h"
#include "base/capacities.h"
#include "fsw/supervisor/supervisor_internal.h"

#include <string.h>

#define MANAGEMENT_OCTETS 2U

CAPACITY_CHECK(each_link_has_a_bit, MISSION_LINKS_MAX <= 32U);

// ---- Beginning ----

/// Determine the state to which a member of the network must return. `entry` may also be the subsystem that
/// failed.
static void begin_member(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    recommission_t* const run = &entry->recommission;
    const bool has_failed     = (entry->state == STATE_ERROR_OPERATIONAL) &&
                            ((supervisor->now_ns - entry->error_ns) > RECOMMISSION_CAUSE_NS);
    const bool was_up = (entry->rested >= STATE_PRE_OPERATIONAL) && (entry->rested <= STATE_OPERATIONAL);
    if (!entry->mission->is_recommissioned || has_failed || (!was_up && !run->is_active)) {
        return;
    }
    // If the process has died again during its recommissioning, the earlier target stays.
    const state_t target         = run->is_active ? run->target : entry->rested;
    const uint16_t configuration = run->is_active ? run->configuration : entry->rested_with;
    *run                         = (recommission_t){.is_active     = true,
                                                    .target        = target,
                                                    .configuration = configuration,
                                                    .ordered       = STATE_COUNT,
                                                    .seen          = STATE_COUNT,
                                                    .since_ns      = supervisor->now_ns};
}

void supervisor_recommission_begin(supervisor_t* const supervisor, const uint16_t apid)
{
    uint16_t members[LINK_GRAPH_MEMBERS];
    const uint16_t count                = supervisor_link_graph_members(&supervisor->graph, apid, members);
    const registry_entry_t* const first = supervisor_registry_find(supervisor, apid);
    FSW_ASSERT(first != NULL);
    if (!first->mission->is_recommissioned || (supervisor->shutdown_step != 0U)) {
        return; // Only for a subsystem with recommission="true" is its network recommissioned.
    }
    for (uint16_t i = 0U; i < count; i++) {
        registry_entry_t* const member = supervisor_registry_find(supervisor, members[i]);
        if (member != NULL) {
            begin_member(supervisor, member);
        }
    }
    for (uint16_t i = 0U; i < supervisor->graph.count; i++) {
        const link_edge_t* const edge = &supervisor->graph.edges[i];
        if (supervisor_link_graph_network(&supervisor->graph, edge->ends.producer_apid) ==
            supervisor_link_graph_network(&supervisor->graph, apid)) {
            supervisor->renewed |= (uint32_t)1U << (edge->link - 1U);
        }
    }
    // All links get new attempts. Links that were recorded before stay recorded, because a link that was
    // being opened when its subsystem died again is not in the graph.
    (void)memset(supervisor->renewals, (int)RECOMMISSION_RENEWALS, sizeof supervisor->renewals);
}

// ---- One step of one subsystem ----

static void report_end(supervisor_t* const supervisor, registry_entry_t* const entry, const uint16_t code)
{
    uint8_t octets[6];
    octet_writer_t writer         = octet_writer(octets, sizeof octets);
    entry->recommission.is_active = false;
    octet_write_u16(&writer, entry->mission->apid);
    octet_write_u16(&writer, (uint16_t)entry->state);
    if (code != PUS_FAILURE_NONE) {
        octet_write_u16(&writer, code);
    }
    (void)subsystem_raise(&supervisor->subsystem,
                          (code == PUS_FAILURE_NONE) ? SUPERVISOR_EVENT_RECOMMISSIONED
                                                     : SUPERVISOR_EVENT_RECOMMISSION_STOPPED,
                          octets, writer.position);
}

/// True if a request is permitted now. Missing links, failed partners and unknown states may still change;
/// any other refusal ends the recommissioning.
static bool may_pass(supervisor_t* const supervisor, registry_entry_t* const entry, const uint8_t subtype,
                     const uint8_t* const octets, const size_t size)
{
    const pus_tc_t tc               = {.apid    = entry->mission->apid,
                                       .service = PUS_SERVICE_MANAGEMENT,
                                       .subtype = subtype,
                                       .data    = octets,
                                       .size    = size};
    const pus_failure_t failure     = supervisor_permission_of(supervisor, &tc);
    const bool may_become_permitted = (failure.code == PUS_FAILURE_LINK_MISSING) ||
                                      (failure.code == PUS_FAILURE_MEMBER_ACTIVE) ||
                                      (failure.code == PUS_FAILURE_STATE_IN_DOUBT);
    if ((failure.code != PUS_FAILURE_NONE) && !may_become_permitted) {
        report_end(supervisor, entry, (uint16_t)failure.code);
    }
    return failure.code == PUS_FAILURE_NONE;
}

/// Order a state, once for each rest state that is reached.
static void order(supervisor_t* const supervisor, registry_entry_t* const entry, const state_t state)
{
    const uint8_t octets[1] = {(uint8_t)state};
    if ((entry->recommission.ordered != state) &&
        may_pass(supervisor, entry, PUS_MANAGEMENT_REQUEST_STATE, octets, sizeof octets)) {
        (void)supervisor_order_state(supervisor, entry->mission->apid, state, PUS_CAUSE_REQUEST);
        entry->recommission.ordered = state;
        entry->recommission.has_left_offline =
            entry->recommission.has_left_offline || (state != STATE_OFFLINE);
    }
}

/// Order the earlier configuration, or end the recommissioning if there was none.
static void configure(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    const uint16_t wanted                   = entry->recommission.configuration;
    const uint8_t octets[MANAGEMENT_OCTETS] = {(uint8_t)(wanted >> 8U), (uint8_t)wanted};
    if (wanted == 0U) {
        // The subsystem had no configuration before its process died.
        report_end(supervisor, entry, PUS_FAILURE_NONE);
    } else if ((entry->recommission.ordered != STATE_PRE_OPERATIONAL) &&
               may_pass(supervisor, entry, PUS_MANAGEMENT_SELECT, octets, sizeof octets) &&
               (supervisor_order_configuration(supervisor, entry->mission->apid, wanted) == STATUS_OK)) {
        entry->recommission.ordered = STATE_PRE_OPERATIONAL;
    } else {
        // The order was sent, or the next step tries again.
    }
}

static bool is_to_be_open(const supervisor_t* const supervisor, const uint16_t link)
{
    return (supervisor->renewed & ((uint32_t)1U << (link - 1U))) != 0U;
}

/// True if every link of a subsystem that was open before is open again.
static bool is_linked(supervisor_t* const supervisor, const uint16_t apid)
{
    for (uint16_t i = 0U; i < supervisor->mission->link_count; i++) {
        const mission_link_t* const link = &supervisor->mission->links[i];
        const bool is_of_subsystem       = (link->producer_apid == apid) || (link->consumer_apid == apid);
        if (is_of_subsystem && is_to_be_open(supervisor, link->number) &&
            (supervisor_link_graph_find(&supervisor->graph, link->number) == NULL)) {
            return false;
        }
    }
    return true;
}

static bool has_arrived(const registry_entry_t* const entry)
{
    const bool is_still = (entry->phase == PHASE_IDLE) || (entry->phase == PHASE_CONFIGURED);
    return is_still && (entry->state == entry->recommission.target);
}

/// Order the next higher state, or end the recommissioning.
static void order_next_step(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    if ((entry->state == STATE_PRE_OPERATIONAL) && (entry->phase == PHASE_UNCONFIGURED)) {
        configure(supervisor, entry);
    } else if (has_arrived(entry)) {
        if (is_linked(supervisor, entry->mission->apid)) {
            report_end(supervisor, entry, PUS_FAILURE_NONE);
        }
    } else if ((entry->state == STATE_OFFLINE) && (entry->phase == PHASE_IDLE)) {
        order(supervisor, entry, STATE_PRE_OPERATIONAL);
    } else if ((entry->state == STATE_PRE_OPERATIONAL) && (entry->phase == PHASE_CONFIGURED)) {
        order(supervisor, entry, STATE_SAFE_OPERATIONAL);
    } else if ((entry->state == STATE_SAFE_OPERATIONAL) && (entry->phase == PHASE_IDLE)) {
        order(supervisor, entry, STATE_OPERATIONAL);
    } else if ((entry->state == STATE_ERROR_OPERATIONAL) && (entry->phase >= PHASE_SECURED)) {
        order(supervisor, entry, STATE_OFFLINE);
    } else {
        // A transition of the subsystem is running.
    }
}

/// True if the subsystem can get the next order. Ends the recommissioning if the subsystem is lost, and, once
/// it has left OFFLINE, if it fails or a plan concerns it. Before that it waits while a plan concerns it.
static bool is_free(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    recommission_t* const run = &entry->recommission;
    const bool is_restarting  = (entry->process == PROCESS_RUNNING) || entry->is_start_due;
    if (!is_restarting) {
        report_end(supervisor, entry, PUS_FAILURE_LOST);
        return false;
    }
    const bool has_plan = supervisor_plan_runner_of(&supervisor->plans, entry->mission->apid) != NULL;
    if (run->has_left_offline && (has_plan || (entry->state == STATE_ERROR_OPERATIONAL))) {
        report_end(supervisor, entry, PUS_FAILURE_STATE); // The subsystem has failed again.
        return false;
    }
    if (!supervisor_registry_is_there(entry) || has_plan) {
        run->since_ns = supervisor->now_ns;
        return false;
    }
    return true;
}

static void step_member(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    recommission_t* const run = &entry->recommission;
    if (!is_free(supervisor, entry)) {
        return;
    }
    if ((entry->state != run->seen) || (entry->phase != run->seen_phase)) {
        if (run->has_left_offline && (entry->state < run->seen)) {
            // The subsystem went to a lower state for another reason. `seen` is a state, because the
            // subsystem has left OFFLINE.
            report_end(supervisor, entry, PUS_FAILURE_STATE);
            return;
        }
        run->seen       = entry->state;
        run->seen_phase = entry->phase;
        run->ordered    = STATE_COUNT;
        run->since_ns   = supervisor->now_ns;
    }
    if ((supervisor->now_ns - run->since_ns) > RECOMMISSION_STEP_NS) {
        report_end(supervisor, entry, PUS_FAILURE_TIMEOUT);
        return;
    }
    order_next_step(supervisor, entry);
}

// ---- All ----

static void renew_links(supervisor_t* const supervisor)
{
    for (uint16_t link = 1U; link <= supervisor->mission->link_count; link++) {
        uint8_t* const left = &supervisor->renewals[link - 1U];
        if (is_to_be_open(supervisor, link) && (*left > 0U) &&
            (supervisor_link_graph_find(&supervisor->graph, link) == NULL) &&
            supervisor_link_manager_renew(supervisor, link)) {
            (*left)--;
        }
    }
}

void supervisor_recommission_step(supervisor_t* const supervisor)
{
    bool is_any = false;
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        registry_entry_t* const entry = &supervisor->registry[i];
        if (entry->recommission.is_active && (supervisor->shutdown_step != 0U)) {
            entry->recommission.is_active = false;
        } else if (entry->recommission.is_active) {
            step_member(supervisor, entry);
        } else {
            // The subsystem is not being recommissioned.
        }
        is_any = is_any || entry->recommission.is_active;
    }
    if (is_any) {
        renew_links(supervisor);
    } else {
        supervisor->renewed = 0U;
    }
}
