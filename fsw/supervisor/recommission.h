// SPDX-License-Identifier: Apache-2.0
/// Recommissioning: returns a subsystem whose process was started again, and the members of its real-time
/// network, to their earlier states. It applies to subsystems for which the mission sets
/// `recommission="true"`. Configurations, links (negotiated again, with new epochs) and states are requested
/// as by telecommand; the permission matrix must permit each step. Recommissioning waits while a recovery
/// plan concerns the subsystem. It stops with an event if a step is refused, if a step takes longer than
/// RECOMMISSION_STEP_NS, or if the subsystem fails again.
///
/// Context  The supervisor's loop; each step.
#ifndef FSW_SUPERVISOR_RECOMMISSION_H
#define FSW_SUPERVISOR_RECOMMISSION_H

#include "fsw/framework/subsystem/state_machine.h"

#include <stdbool.h>
#include <stdint.h>

#define RECOMMISSION_STEP_NS 5000000000ULL ///< Longest time without progress.
/// A subsystem that was in ERROR_OPERATIONAL for longer than this when another one died has failed
/// independently of it.
#define RECOMMISSION_CAUSE_NS 100000000ULL
#define RECOMMISSION_RENEWALS 3U ///< Attempts to open a link again.

typedef struct { // Private: state of one subsystem's recommissioning.
    bool is_active;
    bool has_left_offline; // The subsystem has left OFFLINE again.
    state_t target;
    uint16_t configuration;
    state_t ordered; // State that was ordered in the present rest state; STATE_COUNT: no order yet.
    state_t seen;
    state_phase_t seen_phase;
    uint64_t since_ns; // Time of the last progress.
} recommission_t;

struct supervisor;

/// Call when a process has died: store the states and links of its network before they are cleared.
void supervisor_recommission_begin(struct supervisor* supervisor, uint16_t apid);
/// Perform the steps that are due for subsystems under recommissioning.
void supervisor_recommission_step(struct supervisor* supervisor);

#endif // FSW_SUPERVISOR_RECOMMISSION_H
