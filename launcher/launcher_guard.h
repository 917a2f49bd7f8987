// SPDX-License-Identifier: Apache-2.0
/// The guard of a run: a second process that outlives the launcher. If the launcher is killed, the guard
/// waits for the end of its children, removes every name of the run (launcher.h), completes the logs and
/// writes run.json and the report. If the guard is killed, the launcher starts another one.
///
/// Ownership  The program provides guard_t.
/// Context    One task.
#ifndef LAUNCHER_LAUNCHER_GUARD_H
#define LAUNCHER_LAUNCHER_GUARD_H

#include "launcher/launcher.h"

#define GUARD_ARGUMENTS_MAX 64U

typedef struct guard { // Private, except `starts`.
    const char* arguments[GUARD_ARGUMENTS_MAX];
    char identity[RUN_IDENTITY_MAX];
    osal_process_t process;
    unsigned starts; ///< 1, and one more for each time that a guard was killed and started again.
} guard_t;

/// Start the guard before a run is prepared, with the options of the run, which must stay valid. If it cannot
/// be started, the run has no guard and the console reports it.
void guard_start(guard_t* guard, const char* program, int option_count, char* const options[]);
/// Start another guard if the present one has been killed.
void guard_keep(guard_t* guard);
/// End the guard after the run has ended and is cleaned up.
void guard_stop(guard_t* guard);
/// Main function of the guard: wait until the launcher with this identity ("hirosco-<number>") has ended,
/// and clean up if the launcher could not. Returns the exit code.
int guard_watch(launcher_t* launcher, const launch_options_t* options, const char* program_directory,
                const char* identity);

#endif // LAUNCHER_LAUNCHER_GUARD_H
