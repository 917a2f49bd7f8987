// SPDX-License-Identifier: Apache-2.0
// Linked to the program of a subsystem for a board: its step at 3 s of simulated time never ends.
#include "fsw/framework/subsystem/subsystem_core.h"

#define HANG_NS 3000000000ULL

uint64_t __real_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
uint64_t __wrap_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);

uint64_t __wrap_subsystem_step(subsystem_t* const subsystem, const uint64_t now_ns)
{
    while (now_ns == HANG_NS) {
    }
    return __real_subsystem_step(subsystem, now_ns);
}
