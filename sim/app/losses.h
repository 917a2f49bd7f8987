// SPDX-License-Identifier: Apache-2.0
/// The losses that a simulator has counted, which it prints at the end of a run.
///
/// Context    The task of the simulator.
#ifndef SIM_APP_LOSSES_H
#define SIM_APP_LOSSES_H

#include "sim/app/simulator.h"

#include <stdbool.h>

/// Print one line for each kind of loss. Returns true if one of them makes the run not reproducible.
bool losses_report(const simulator_statistics_t* statistics);

#endif // SIM_APP_LOSSES_H
