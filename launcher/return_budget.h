// SPDX-License-Identifier: Apache-2.0
/// Limits how often a supervisor that has died is started again: RETURN_BUDGET times in RETURN_PERIOD_NS of
/// mission time.
#ifndef LAUNCHER_RETURN_BUDGET_H
#define LAUNCHER_RETURN_BUDGET_H

#include <stdbool.h>
#include <stdint.h>

#define RETURN_BUDGET 3U
#define RETURN_PERIOD_NS 60000000000ULL
/// Mission time in which the subsystems must reach their safe states before a run without supervisor ends.
#define RETURN_ABANDON_NS 5000000000ULL

typedef struct { // Private. All zeros: the supervisor has not died yet.
    uint64_t died_ns[RETURN_BUDGET];
    unsigned deaths;
} return_budget_t;

/// Record a death of the supervisor. True if it may be started again, after *out_delay_ns of wall-clock time
/// (0, 0.1 s, 1 s).
bool return_budget_take(return_budget_t* budget, uint64_t now_ns, uint64_t* out_delay_ns);

#endif // LAUNCHER_RETURN_BUDGET_H
