// SPDX-License-Identifier: Apache-2.0
/// The live port: programs on this machine send lines of the actors `hand` and `fault` and set the pace of
/// simulated time while the flight runs; they receive frames of the buses and the true state of the plant.
/// docs/live.md describes the lines and their answers.
///
/// A line acts at the start of the next step, like a line of the scenario with that time. The port appends it
/// to live.scn in the run directory, so that the flight can be repeated. It also writes a mark to
/// operator.log (without an operator to standard output) for each line and each change of the pace; of
/// consecutive `aim` lines of a client, only the first gets a mark. A refused line changes nothing. If no
/// line follows an `aim`, the port makes the hand hold after LIVE_HOLD_NS and let go after LIVE_LET_GO_NS of
/// simulated time, and records both as lines.
///
/// Ownership  live_open allocates, live_close frees. Hand, faults and world must outlive it.
/// Context    The task of the simulator. No function waits.
/// Errors     A client whose line does not end, or that reads no answers, is disconnected. A client that
///            reads too slowly loses whole frames and rows; the line `dropped` gives it their number.
#ifndef SIM_APP_LIVE_H
#define SIM_APP_LIVE_H

#include "base/status.h"
#include "sim/app/faults.h"
#include "sim/operator/hand.h"
#include "sim/plant/plant.h"
#include "sim/world/world.h"

#include <stdbool.h>
#include <stdint.h>

#define LIVE_CLIENTS_MAX 8U
#define LIVE_HOLD_NS 500000000ULL    ///< Time without a line after which the hand holds.
#define LIVE_LET_GO_NS 5000000000ULL ///< Time without a line after which the hand lets go.
#define LIVE_SPEED_MAX 100.0         ///< Largest ratio of simulated to wall-clock time.

typedef struct {
    const char* directory; ///< Run directory: live.port and live.scn are written there.
    hand_t* hand;          ///< Null: the world has no hand, and lines of the hand are refused.
    faults_t* faults;
    const fault_world_t* targets; ///< Targets of faults, by their names.
    const world_t* world;
    const plant_truth_t* truth;
    /// True if simulated time can be held; otherwise lines that pause, step or set the speed are refused.
    bool is_paced;
} live_config_t;

typedef struct live live_t;

/// Open the port. STATUS_OK; else *out_live is null: STATUS_IO (no port, or the directory cannot be written),
/// STATUS_EXHAUSTED (memory).
MUST_USE status_t live_open(const live_config_t* config, live_t** out_live);
/// Take the lines that have arrived; they act at `now_ns`, the start of the next step, which must not be
/// earlier than in the last call.
void live_take(live_t* live, uint64_t now_ns);
/// Send a frame of bus `name` to the clients that have requested frames of it. The port is not a node
/// of the bus: it does not acknowledge frames.
void live_frame(live_t* live, const char* name, const osal_can_frame_t* frame);
/// At the end of a step: send the octets that wait, and the true state to the clients for which it is due.
void live_report(live_t* live);
/// True while simulated time must stand still at `now_ns`.
bool live_is_held(const live_t* live, uint64_t now_ns);
/// Returns the wanted ratio of simulated to wall-clock time, initially 1; 0: as fast as possible.
double live_speed(const live_t* live);
/// Close the port; null is allowed. STATUS_OK, STATUS_IO (live.scn or a mark is not complete).
status_t live_close(live_t* live);

#endif // SIM_APP_LIVE_H
