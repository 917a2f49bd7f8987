// SPDX-License-Identifier: Apache-2.0
/// Table of running recovery plans (runs). It decides which run a subsystem belongs to and which action is
/// due; the caller performs the actions.
///
/// A subsystem is a member of at most one run, the one of the highest severity. A run of higher severity
/// takes over its members from runs of lower severity, which end. A failure of the same severity in the same
/// real-time network joins the existing run.
///
/// The subsystem that failed is always a member of its run, and no subsystem is a member of two runs. So one
/// entry for each subsystem of a mission is enough: the table cannot be full.
///
/// Ownership  The caller places it; it has no pointers.
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
    uint16_t plan;                        ///< Index in the mission's plans, or PLAN_BUILT_IN.
    uint16_t apid;                        ///< Subsystem that failed.
    uint16_t event_id;                    ///< Event that reported the failure.
    uint16_t members[LINK_GRAPH_MEMBERS]; ///< `apid` first; each is a subsystem of the mission.
    uint16_t member_count;                ///< 0: no run.
    uint16_t lost; ///< Bit n: the process of member n died. It starts again in OFFLINE: no action for it.
    uint16_t next_action;
} plan_run_t;

typedef struct { // All zeros: no run.
    plan_run_t runs[PLAN_RUNS];
} plan_runner_t;

typedef enum {
    PLAN_STARTED,  ///< The run is in the table.
    PLAN_JOINED,   ///< A run of the same severity has the failed subsystem: its members are added to it.
    PLAN_OUTRANKED ///< A run of higher severity has the failed subsystem: nothing is started.
} plan_verdict_t;

/// The run that a subsystem belongs to, or null.
const plan_run_t* supervisor_plan_runner_of(const plan_runner_t* runner, uint16_t apid);
/// End one run of lower severity that has a member in common with `wanted`, and copy it to *out_ended. False:
/// there is none. Call it repeatedly until it returns false, before supervisor_plan_runner_start.
bool supervisor_plan_runner_overrule(plan_runner_t* runner, const plan_run_t* wanted, plan_run_t* out_ended);
/// Start `wanted`, without its members that belong to other runs.
plan_verdict_t supervisor_plan_runner_start(plan_runner_t* runner, const plan_run_t* wanted);
/// Note that the process of a subsystem died.
void supervisor_plan_runner_mark_lost(plan_runner_t* runner, uint16_t apid);
/// True if the actions of `run` apply to a subsystem: false for a member whose process died.
bool supervisor_plan_runner_concerns(const plan_run_t* run, uint16_t apid);
/// Next action of a run that is due; null: none now. A run ends when all its actions were returned.
const mission_action_t* supervisor_plan_runner_next(plan_run_t* run, const mission_descriptor_t* mission,
                                                    uint64_t now_ns);

#endif // FSW_SUPERVISOR_PLAN_RUNNER_H
