// SPDX-License-Identifier: Apache-2.0
// Faults that a random flight must find: RANDOM_FLIGHT_FAULT names one of them; without it, every function is
// the real one.
#include "fsw/canopen/cia402.h"
#include "fsw/framework/subsystem/subsystem_internal.h"
#include "pus/st01/st01_verification.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static bool is_planted(const char* const name)
{
    static const char* wish;
    static bool is_read;
    if (!is_read) {
        wish    = getenv("RANDOM_FLIGHT_FAULT");
        is_read = true;
    }
    return (wish != NULL) && (strcmp(wish, name) == 0);
}

/// "links": the loss of a required link in OPERATIONAL raises no event.
void __real_subsystem_raise_named(subsystem_t* subsystem, const char* name);
void __wrap_subsystem_raise_named(subsystem_t* subsystem, const char* name);
void __wrap_subsystem_raise_named(subsystem_t* const subsystem, const char* const name)
{
    if (!is_planted("links") || (strcmp(name, "LINK_STALE") != 0)) {
        __real_subsystem_raise_named(subsystem, name);
    }
}

/// "brakes": drives that should stand by are enabled, so their brakes open in SAFE_OPERATIONAL.
uint16_t __real_canopen_cia402_controlword(canopen_cia402_state_t state, canopen_cia402_goal_t goal,
                                           bool may_reset, uint16_t previous);
uint16_t __wrap_canopen_cia402_controlword(canopen_cia402_state_t state, canopen_cia402_goal_t goal,
                                           bool may_reset, uint16_t previous);
uint16_t __wrap_canopen_cia402_controlword(const canopen_cia402_state_t state,
                                           const canopen_cia402_goal_t goal, const bool may_reset,
                                           const uint16_t previous)
{
    const bool is_wrong = is_planted("brakes") && (goal == CIA402_GOAL_STANDBY);
    return __real_canopen_cia402_controlword(state, is_wrong ? CIA402_GOAL_ENABLED : goal, may_reset,
                                             previous);
}

/// "answers": the supervisor and the subsystems reject requests without the report TM[1,2].
void __real_pus_verify_rejected(pus_app_process_t* process, const pus_token_t* token,
                                const pus_failure_t* failure, uint64_t now_ns);
void __wrap_pus_verify_rejected(pus_app_process_t* process, const pus_token_t* token,
                                const pus_failure_t* failure, uint64_t now_ns);
void __wrap_pus_verify_rejected(pus_app_process_t* const process, const pus_token_t* const token,
                                const pus_failure_t* const failure, const uint64_t now_ns)
{
    if (!is_planted("answers")) {
        __real_pus_verify_rejected(process, token, failure, now_ns);
    }
}
