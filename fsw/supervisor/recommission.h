// SPDX-License-Identifier: Apache-2.0
/// Recommissioning: returns a subsystem whose process was started again, and the members of its real-time
/// network, to their earlier states. It applies to subsystems that the mission marks `recommission="true"`.
/// Configuration, links (negotiated again, with new epochs) and states follow as by telecommand; each step
/// must be permitted. It waits while a recovery plan concerns the subsystem. It stops with an event if
/// a step is refused, if a step takes longer than RECOMMISSION_STEP_NS, or if the subsystem fails again.
///
/// Context  The supervisor's loop; each step.
#ifndef FSW_SUPERVISOR_RECOMMISSION_H
#define FSW_SUPERVISOR_RECOMMISSION_H

#include "fsw/framework/subsystem/state_machine.h"

#include <stdbool.h>
#include <stdint.h>

#define RECOMMISSION_STEP_NS 5000000000ULL ///< Longest time without progress.
/// A subsystem that was in ERROR_OPERATIONAL for longer than this before another one died has failed by
/// itself.
#define RECOMMISSION_CAUSE_NS 100000000ULL
#define RECOMMISSION_RENEWALS 3U ///< Attempts to open a link again.

typedef struct { // Private: of one subsystem.
    bool is_active;
    bool has_left_offline; // It has left OFFLINE again.
    state_t target;
    uint16_t configuration;
    state_t ordered; // State ordered in its present rest state; STATE_COUNT: no order yet.
    state_t seen;
    state_phase_t seen_phase;
    uint64_t since_ns; // Time of the last progress.
} recommission_t;

struct supervisor;

/// A process died: note the states and links of its network before they are cleared.
void supervisor_recommission_begin(struct supervisor* supervisor, uint16_t apid);
/// Perform the steps that are due for subsystems under recommissioning.
void supervisor_recommission_step(struct supervisor* supervisor);

#endif // FSW_SUPERVISOR_RECOMMISSION_H
