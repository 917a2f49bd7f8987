// SPDX-License-Identifier: Apache-2.0
// Faults that a random flight must find: RANDOM_FLIGHT_FAULT names one of them; without it, every function is
// the real one.
#include "base/assertion.h"
#include "base/pool.h"
#include "fsw/canopen/cia402.h"
#include "fsw/framework/subsystem/subsystem_internal.h"
#include "fsw/supervisor/ground_backlog.h"
#include "pus/st01/st01_verification.h"
#include "test/fuzz/flight/violations.h"

#include <stdlib.h>
#include <string.h>

/// Reads the environment once.
bool random_flight_is_planted(const char* const name)
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
    if (!random_flight_is_planted("links") || (strcmp(name, "LINK_STALE") != 0)) {
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
    const bool is_wrong = random_flight_is_planted("brakes") && (goal == CIA402_GOAL_STANDBY);
    return __real_canopen_cia402_controlword(state, is_wrong ? CIA402_GOAL_ENABLED : goal, may_reset,
                                             previous);
}

/// "order": a subsystem that should enter PRE_OPERATIONAL enters OPERATIONAL.
void __real_subsystem_state_machine_outcome(state_machine_t* machine, state_outcome_t outcome);
void __wrap_subsystem_state_machine_outcome(state_machine_t* machine, state_outcome_t outcome);
void __wrap_subsystem_state_machine_outcome(state_machine_t* const machine, const state_outcome_t outcome)
{
    __real_subsystem_state_machine_outcome(machine, outcome);
    if (random_flight_is_planted("order") && (machine->state == STATE_PRE_OPERATIONAL)) {
        machine->state = STATE_OPERATIONAL;
    }
}

/// "pool": a block that was returned still counts as taken.
status_t __real_pool_release(pool_t* pool, void* block);
status_t __wrap_pool_release(pool_t* pool, void* block);
status_t __wrap_pool_release(pool_t* const pool, void* const block)
{
    const status_t status = __real_pool_release(pool, block);
    pool->stats.taken     = (uint16_t)(pool->stats.taken + (random_flight_is_planted("pool") ? 1U : 0U));
    return status;
}

/// "backlog": the supervisor does not return the blocks of reports.
void __real_supervisor_ground_backlog_give(ground_backlog_t* backlog, uint8_t* block);
void __wrap_supervisor_ground_backlog_give(ground_backlog_t* backlog, uint8_t* block);
void __wrap_supervisor_ground_backlog_give(ground_backlog_t* const backlog, uint8_t* const block)
{
    if (!random_flight_is_planted("backlog")) {
        __real_supervisor_ground_backlog_give(backlog, block);
    }
}

/// The supervisor and the subsystems reject requests. "answers": without the report TM[1,2]; "twice": with
/// two; "assertion": an assertion fails.
void __real_pus_verify_rejected(pus_app_process_t* process, const pus_token_t* token,
                                const pus_failure_t* failure, uint64_t now_ns);
void __wrap_pus_verify_rejected(pus_app_process_t* process, const pus_token_t* token,
                                const pus_failure_t* failure, uint64_t now_ns);
void __wrap_pus_verify_rejected(pus_app_process_t* const process, const pus_token_t* const token,
                                const pus_failure_t* const failure, const uint64_t now_ns)
{
    FSW_ASSERT(!random_flight_is_planted("assertion"));
    if (!random_flight_is_planted("answers")) {
        __real_pus_verify_rejected(process, token, failure, now_ns);
    }
    if (random_flight_is_planted("twice")) {
        __real_pus_verify_rejected(process, token, failure, now_ns);
    }
}
