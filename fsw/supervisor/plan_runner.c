// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/plan_runner.h"

#include "base/assertion.h"
#include "base/capacities.h"

#include <stddef.h>

CAPACITY_CHECK(run_has_room_for_every_subsystem, LINK_GRAPH_MEMBERS >= MISSION_SUBSYSTEMS_MAX);
CAPACITY_CHECK(lost_has_a_bit_for_every_member, LINK_GRAPH_MEMBERS <= 16U);

/// The only action of the plan PLAN_BUILT_IN.
static const mission_action_t built_in = {.kind     = MISSION_ACTION_STATE,
                                          .target   = MISSION_NETWORK,
                                          .state    = 0U, // OFFLINE.
                                          .after_us = PLAN_BUILT_IN_DELAY_US};

/// Returns the index of a subsystem in the members of a run; member_count if it is not a member.
static uint16_t position_in(const plan_run_t* const run, const uint16_t apid)
{
    uint16_t position = 0U;
    while ((position < run->member_count) && (run->members[position] != apid)) {
        position++;
    }
    return position;
}

static bool has_member(const plan_run_t* const run, const uint16_t apid)
{
    return position_in(run, apid) < run->member_count;
}

/// Returns the index of the run to which a subsystem belongs; PLAN_RUNS if it belongs to none.
static size_t index_of(const plan_runner_t* const runner, const uint16_t apid)
{
    size_t index = 0U;
    while ((index < PLAN_RUNS) && !has_member(&runner->runs[index], apid)) {
        index++;
    }
    return index;
}

static plan_run_t* run_of(plan_runner_t* const runner, const uint16_t apid)
{
    const size_t index = index_of(runner, apid);
    return (index < PLAN_RUNS) ? &runner->runs[index] : NULL;
}

const plan_run_t* supervisor_plan_runner_of(const plan_runner_t* const runner, const uint16_t apid)
{
    FSW_ASSERT(runner != NULL);
    const size_t index = index_of(runner, apid);
    return (index < PLAN_RUNS) ? &runner->runs[index] : NULL;
}

bool supervisor_plan_runner_overrule(plan_runner_t* const runner, const plan_run_t* const wanted,
                                     plan_run_t* const out_ended)
{
    FSW_ASSERT((runner != NULL) && (wanted != NULL) && (out_ended != NULL));
    for (uint16_t i = 0U; i < wanted->member_count; i++) {
        plan_run_t* const run = run_of(runner, wanted->members[i]);
        if ((run != NULL) && (run->severity < wanted->severity)) {
            *out_ended        = *run;
            run->member_count = 0U;
            return true;
        }
    }
    return false;
}

/// Add those members of `wanted` that do not belong to a run.
static void add_members(plan_runner_t* const runner, plan_run_t* const run, const plan_run_t* const wanted)
{
    for (uint16_t i = 0U; i < wanted->member_count; i++) {
        if (run_of(runner, wanted->members[i]) == NULL) {
            FSW_ASSERT(run->member_count < LINK_GRAPH_MEMBERS);
            run->members[run->member_count] = wanted->members[i];
            run->member_count++;
        }
    }
}

static plan_run_t* free_run(plan_runner_t* const runner)
{
    size_t index = 0U;
    while ((index < PLAN_RUNS) && (runner->runs[index].member_count > 0U)) {
        index++;
    }
    // There is a free entry, because each run has a different failed subsystem, and this one has no run yet.
    FSW_ASSERT(index < PLAN_RUNS);
    return &runner->runs[index];
}

plan_verdict_t supervisor_plan_runner_start(plan_runner_t* const runner, const plan_run_t* const wanted)
{
    FSW_ASSERT((runner != NULL) && (wanted != NULL) && (wanted->member_count >= 1U) &&
               (wanted->members[0] == wanted->apid));
    plan_run_t* const present = run_of(runner, wanted->apid);
    if (present == NULL) {
        plan_run_t* const run = free_run(runner);
        *run                  = *wanted;
        run->member_count     = 0U;
        run->lost             = 0U;
        run->next_action      = 0U;
        add_members(runner, run, wanted);
        return PLAN_STARTED;
    }
    if (present->severity == wanted->severity) {
        add_members(runner, present, wanted);
        return PLAN_JOINED;
    }
    FSW_ASSERT(present->severity > wanted->severity); // The caller has ended runs of lower severity before.
    return PLAN_OUTRANKED;
}

void supervisor_plan_runner_mark_lost(plan_runner_t* const runner, const uint16_t apid)
{
    FSW_ASSERT(runner != NULL);
    plan_run_t* const run = run_of(runner, apid);
    if (run != NULL) {
        run->lost = (uint16_t)(run->lost | (1UL << position_in(run, apid)));
    }
}

bool supervisor_plan_runner_concerns(const plan_run_t* const run, const uint16_t apid)
{
    FSW_ASSERT(run != NULL);
    const uint16_t position = position_in(run, apid);
    return (position == run->member_count) || (((run->lost >> position) & 1U) == 0U);
}

const mission_action_t* supervisor_plan_runner_next(plan_run_t* const run,
                                                    const mission_descriptor_t* const mission,
                                                    const uint64_t now_ns)
{
    FSW_ASSERT((run != NULL) && (mission != NULL));
    if (run->member_count == 0U) {
        return NULL;
    }
    const bool is_built_in           = (run->plan == PLAN_BUILT_IN);
    const mission_plan_t* const plan = is_built_in ? NULL : &mission->plans[run->plan];
    const uint16_t count             = is_built_in ? 1U : plan->action_count;
    if (run->next_action >= count) {
        run->member_count = 0U;
        return NULL;
    }
    const mission_action_t* const action =
        is_built_in ? &built_in : &mission->actions[plan->first_action + run->next_action];
    if ((now_ns - run->start_ns) < ((uint64_t)action->after_us * 1000U)) {
        return NULL;
    }
    run->next_action++;
    return action;
}
