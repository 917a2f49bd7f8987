// SPDX-License-Identifier: Apache-2.0
/// Losses that a simulator has counted and prints at the end of a run: those of tools and of instruments.
///
/// Context    The task of the simulator.
#ifndef SIM_APP_LOSSES_H
#define SIM_APP_LOSSES_H

#include "sim/app/simulator.h"

#include <stdbool.h>

/// Print one line for each kind of loss. Returns true if one of them makes the run not reproducible.
bool losses_report(const simulator_statistics_t* statistics);

#endif // SIM_APP_LOSSES_H
