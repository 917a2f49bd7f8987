// SPDX-License-Identifier: Apache-2.0
/// Writes the plant to the truth log: the names of its parts once, and its state after every step.
#ifndef SIM_APP_PLANT_LOG_H
#define SIM_APP_PLANT_LOG_H

#include "sim/plant/plant.h"
#include "sim/truth/truth.h"

/// Write the names of the entries of the plant's channels (truth_world, truth_names). STATUS_OK or STATUS_IO.
MUST_USE status_t plant_log_names(truth_t* log, const world_t* world);
/// Write the state after a step, on the channel of each kind of part that the world has. STATUS_OK or
/// STATUS_IO.
MUST_USE status_t plant_log_state(truth_t* log, const world_t* world, const plant_truth_t* truth);
/// Write the latches that have changed since the last call, whose states are in `is_closed`. STATUS_OK or
/// STATUS_IO.
MUST_USE status_t plant_log_latches(truth_t* log, const world_t* world, const plant_truth_t* truth,
                                    bool is_closed[WORLD_LATCHES_MAX]);

#endif // SIM_APP_PLANT_LOG_H
