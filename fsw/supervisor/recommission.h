// SPDX-License-Identifier: Apache-2.0
/// Leads a subsystem whose process was started again, and the members of its real-time network, back to where
/// they were: those that the mission marks `recommission="true"`. Configuration, links (negotiated anew, with
/// other epochs) and states follow one another as by telecommand, each step within permissions and gates. It
/// waits while a recovery plan has the member, and stops with an event where a step is refused, does not come
/// within RECOMMISSION_STEP_NS, or the member fails again.
///
/// Context  The supervisor's loop; each step.
#ifndef FSW_SUPERVISOR_RECOMMISSION_H
#define FSW_SUPERVISOR_RECOMMISSION_H

#include "fsw/framework/subsystem/state_machine.h"

#include <stdbool.h>
#include <stdint.h>

#define RECOMMISSION_STEP_NS 5000000000ULL ///< Longest time without progress.
/// A member in ERROR_OPERATIONAL for longer than this before the death of another did not fail by it.
#define RECOMMISSION_CAUSE_NS 100000000ULL
#define RECOMMISSION_RENEWALS 3U ///< Attempts to open a link again.

typedef struct { // Private: of one subsystem.
    bool is_active;
    bool is_walking; // It has left OFFLINE again.
    state_t target;
    uint16_t configuration;
    state_t ordered; // From where it rests; STATE_COUNT: nothing yet.
    state_t seen;
    state_phase_t seen_phase;
    uint64_t since_ns; // Of the last progress.
} recommission_t;

struct supervisor;

/// A process died: note where its network was, before links and states are forgotten.
void recommission_begin(struct supervisor* supervisor, uint16_t apid);
/// What is due for every member that is on its way back.
void recommission_step(struct supervisor* supervisor);

#endif // FSW_SUPERVISOR_RECOMMISSION_H
