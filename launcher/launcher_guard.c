// SPDX-License-Identifier: Apache-2.0
#include "launcher/launcher_guard.h"

#include "launcher/launcher_internal.h"
#include "base/assertion.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"

#define LOOK_MS 20U     ///< Interval of checks until the launcher has created the run state.
#define STAY_MS 60000U  ///< Interval of checks afterwards; the end of the launcher ends the wait earlier.
#define GONE_MS 30000U  ///< Longest time until killed children have ended.
#define OWN_ARGUMENTS 3 ///< Number of arguments before the options: program, the word `guard`, identity.

// ---- The launcher's side ----

static void start(guard_t* const guard)
{
    const osal_process_start_t how = {.arguments = guard->arguments, .processor = -1, .outlives = true};
    if ((guard->arguments[0] == NULL) || (osal_process_start(&guard->process, &how) != STATUS_OK)) {
        osal_console_print_error("hirosco: this run has no guard: if its launcher is killed, its shared "
                                 "memory, sockets and interfaces remain until the next run");
        return;
    }
    guard->starts++;
}

void guard_start(guard_t* const guard, const char* const program, const int option_count,
                 char* const options[])
{
    FSW_ASSERT((guard != NULL) && (program != NULL) && (options != NULL));
    *guard      = (guard_t){.process = {.id = 0, .descriptor = -1}};
    text_t text = text_in(guard->identity, sizeof guard->identity);
    text_add(&text, "hirosco-");
    text_add_unsigned(&text, (uint64_t)osal_process_own_id());
    // With more options than fit, the list stays empty, and `start` reports that there is no guard.
    if (option_count < ((int)GUARD_ARGUMENTS_MAX - OWN_ARGUMENTS)) {
        guard->arguments[0] = program;
        guard->arguments[1] = "guard";
        guard->arguments[2] = guard->identity;
        for (int i = 0; i < option_count; i++) {
            guard->arguments[OWN_ARGUMENTS + i] = options[i];
        }
    }
    start(guard);
}

void guard_keep(guard_t* const guard)
{
    FSW_ASSERT(guard != NULL);
    osal_process_result_t result;
    if ((osal_process_poll(&guard->process, &result) == STATUS_OK) && result.has_ended) {
        osal_console_print_error("hirosco: the guard of the run was killed; another one is started");
        start(guard);
    }
}

void guard_stop(guard_t* const guard)
{
    FSW_ASSERT(guard != NULL);
    osal_process_t* const one[]  = {&guard->process};
    osal_process_result_t result = {.has_ended = false};
    (void)osal_process_stop(&guard->process, true);
    while ((osal_process_poll(&guard->process, &result) == STATUS_OK) && !result.has_ended) {
        (void)osal_process_wait_any(one, 1U, LOOK_MS);
    }
}

// ---- The guard itself ----

/// Returns the run state of a launcher; null as long as the launcher has not created it.
static run_state_t* run_of(osal_shm_t* const shm, const char* const identity)
{
    char name[RUN_NAME_MAX];
    run_state_t* run    = NULL;
    const bool is_whole = text_join(name, sizeof name, (const char* const[]){"/", identity, ".run", NULL});
    return (is_whole && (run_state_attach(shm, name, &run) == STATUS_OK)) ? run : NULL;
}

/// Wait until the launcher has ended. Returns its run state, or null if it had not created one.
static run_state_t* wait_for_end(osal_shm_t* const shm, const char* const identity)
{
    osal_process_t owner        = {.id = 0, .descriptor = -1};
    osal_process_t* const one[] = {&owner};
    run_state_t* run            = NULL;
    bool is_alive               = (osal_process_watch(&owner, launcher_owner_of(identity)) == STATUS_OK);
    do {
        run = (run == NULL) ? run_of(shm, identity) : run;
        if (is_alive) {
            (void)osal_process_wait_any(one, 1U, (run == NULL) ? LOOK_MS : STAY_MS);
            is_alive = osal_process_is_alive(&owner);
        }
    } while (is_alive);
    osal_process_release(&owner);
    // The launcher may have created the run state after the last look-up and before it ended.
    return (run == NULL) ? run_of(shm, identity) : run;
}

/// Wait for the end of the launcher's children, which are killed with it.
static void wait_for_children(const run_state_t* const run)
{
    const uint64_t until_ns = osal_clock_monotonic_ns() + (GONE_MS * 1000000ULL);
    for (unsigned i = 0U; i < RUN_PROCESSES_MAX; i++) {
        osal_process_t child        = {.id = 0, .descriptor = -1};
        osal_process_t* const one[] = {&child};
        const int32_t id            = __atomic_load_n(&run->processes[i], __ATOMIC_ACQUIRE);
        bool is_alive               = (id > 0) && (osal_process_watch(&child, id) == STATUS_OK);
        while (is_alive && (osal_clock_monotonic_ns() < until_ns)) {
            (void)osal_process_wait_any(one, 1U, LOOK_MS);
            is_alive = osal_process_is_alive(&child);
        }
        osal_process_release(&child);
    }
}

int guard_watch(launcher_t* const launcher, const launch_options_t* const options,
                const char* const program_directory, const char* const identity)
{
    FSW_ASSERT((launcher != NULL) && (options != NULL) && (program_directory != NULL) && (identity != NULL));
    osal_shm_t shm         = {0};
    run_state_t* const run = wait_for_end(&shm, identity);
    if ((run != NULL) && (__atomic_load_n(&run->is_cleaned_up, __ATOMIC_ACQUIRE) != 0U)) {
        return 0;
    }
    if (run != NULL) {
        wait_for_children(run);
    }
    launcher_take_over(launcher, options, program_directory, run);
    launcher_clean_up(launcher);
    launcher_remove_all(identity);
    return 1;
}
