// SPDX-License-Identifier: Apache-2.0
/// Table of recovery plans under way (runs). It decides which run a subsystem belongs to, and which action is
/// due; the caller performs the actions.
///
/// A subsystem is a member of one run at most, that of the highest severity. A run of higher severity takes
/// its members from lesser runs, which end. A failure of the same severity in the same real-time network
/// joins the run that is there.
///
/// Every run has the subsystem that failed as a member, so one run for each subsystem of a mission is always
/// enough: the table cannot be full.
///
/// Ownership: the caller places it; it has no pointers. Context: one loop. Time: O(runs * members).
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
    bool is_used;
    descriptor_severity_t severity;
    uint16_t plan;                        ///< Index in the mission's plans, or PLAN_BUILT_IN.
    uint16_t apid;                        ///< Subsystem that failed,
    uint16_t event_id;                    ///< by this event.
    uint16_t members[LINK_GRAPH_MEMBERS]; ///< `apid` first; each is a subsystem of the mission.
    uint16_t member_count;                ///< >= 1.
    uint16_t lost; ///< Bit n: the process of member n died. It begins anew in OFFLINE: no action concerns it.
    uint16_t next_action;
    uint64_t start_ns;
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
const plan_run_t* plan_runner_of(const plan_runner_t* runner, uint16_t apid);
/// End one run of lower severity that has a member in common with `wanted`, and copy it to *out_ended. False:
/// there is none (left). To be called until then, before plan_runner_start.
bool plan_runner_overrule(plan_runner_t* runner, const plan_run_t* wanted, plan_run_t* out_ended);
/// Start `wanted` without those of its members that belong to other runs.
plan_verdict_t plan_runner_start(plan_runner_t* runner, const plan_run_t* wanted);
/// The process of a subsystem died.
void plan_runner_mark_lost(plan_runner_t* runner, uint16_t apid);
/// True if the actions of `run` concern a subsystem: all but a member whose process died.
bool plan_runner_concerns(const plan_run_t* run, uint16_t apid);
/// Next action of a run that is due; null: none now. A run whose actions are all taken ends.
const mission_action_t* plan_runner_next(plan_run_t* run, const mission_descriptor_t* mission,
                                         uint64_t now_ns);

#endif // FSW_SUPERVISOR_PLAN_RUNNER_H
