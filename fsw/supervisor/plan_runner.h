// SPDX-License-Identifier: Apache-2.0
/// Table of running recovery plans (runs). It decides to which run a subsystem belongs, and which action is
/// due; the caller performs the actions.
///
/// A subsystem is a member of at most one run, the one of the highest severity. A run of higher severity
/// ends runs of lower severity that have members in common with it. A failure of the same severity in the
/// same real-time network joins the existing run.
///
/// The failed subsystem is always a member of its run, and no subsystem is a member of two runs. Therefore
/// one entry for each subsystem of a mission is enough, and the table cannot become full.
///
/// Ownership  The caller provides plan_runner_t, which has no pointers.
/// Context    One loop.
/// Time       O(runs * members).
#ifndef FSW_SUPERVISOR_PLAN_RUNNER_H
#define FSW_SUPERVISOR_PLAN_RUNNER_H

#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/supervisor/link_graph.h"

#include <stdbool.h>
#include <stdint.h>

#define PLAN_RUNS MISSION_SUBSYSTEMS_MAX
#define PLAN_BUILT_IN 0xFFFFU ///< plan_run_t.plan: members to OFFLINE after PLAN_BUILT_IN_DELAY_US.
#define PLAN_BUILT_IN_DELAY_US 500000U

typedef struct {
    uint64_t start_ns;
    descriptor_severity_t severity;
    uint16_t plan;     ///< Index in the mission's plans, or PLAN_BUILT_IN.
    uint16_t apid;     ///< Subsystem that failed.
    uint16_t event_id; ///< Event that reported the failure.
    /// Members of the run, `apid` first; each is a subsystem of the mission.
    uint16_t members[LINK_GRAPH_MEMBERS];
    uint16_t member_count; ///< Number of members; 0: the entry is free.
    /// Bit n: the process of member n has died. It starts again in OFFLINE, so it gets no action.
    uint16_t lost;
    uint16_t next_action;
} plan_run_t;

typedef struct { // All zeros: no run.
    plan_run_t runs[PLAN_RUNS];
} plan_runner_t;

typedef enum {
    PLAN_STARTED, ///< The run is in the table.
    /// The failed subsystem belongs to a run of the same severity: the members were added to that run.
    PLAN_JOINED,
    PLAN_OUTRANKED ///< The failed subsystem belongs to a run of higher severity: no run was started.
} plan_verdict_t;

/// Returns the run to which a subsystem belongs, or null.
const plan_run_t* supervisor_plan_runner_of(const plan_runner_t* runner, uint16_t apid);
/// End one run of lower severity that has a member in common with `wanted`, and copy it to *out_ended. False
/// if there is none. Call it repeatedly until it returns false, before supervisor_plan_runner_start.
bool supervisor_plan_runner_overrule(plan_runner_t* runner, const plan_run_t* wanted, plan_run_t* out_ended);
/// Start `wanted`, without its members that belong to other runs.
plan_verdict_t supervisor_plan_runner_start(plan_runner_t* runner, const plan_run_t* wanted);
/// Record that the process of a subsystem has died.
void supervisor_plan_runner_mark_lost(plan_runner_t* runner, uint16_t apid);
/// False for a member of `run` whose process has died, to which its actions no longer apply; true for every
/// other subsystem, also one that is no member.
bool supervisor_plan_runner_concerns(const plan_run_t* run, uint16_t apid);
/// Returns the next action of a run if it is due; null if none is due now. A run ends when all its actions
/// have been returned.
const mission_action_t* supervisor_plan_runner_next(plan_run_t* run, const mission_descriptor_t* mission,
                                                    uint64_t now_ns);

#endif // FSW_SUPERVISOR_PLAN_RUNNER_H
