// SPDX-License-Identifier: Apache-2.0
/// Start of the mission's subsystems: from the first start of a program until all have parsed the
/// descriptors, opened their resources and requested their first turn. Baseline: the same programs, started
/// in the same way, which end at once.
#define _GNU_SOURCE
#include "launcher/launcher_internal.h"
#include "osal/include/osal/clock.h"
#include "test/bench/measure.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#define ROUNDS 15U
#define PROGRAMS "build/bin/"

static launcher_t launcher;

static void give_up(const char* what)
{
    (void)fprintf(stderr, "bench_start: %s\n", what);
    exit(1);
}

static char directory[64];

static void prepare(unsigned round)
{
    char error[LAUNCH_ERROR_MAX];
    char* arguments[] = {"--scenario", "none", "--duration", "60", "--out", directory, "--report", "no"};
    launch_options_t options;
    (void)snprintf(directory, sizeof directory, "build/bench/start-%ld-%u", (long)getpid(), round);
    if (!launch_options_parse(8, arguments, &options, error)) {
        give_up(error);
    }
    if (!launcher_prepare(&launcher, &options, PROGRAMS)) {
        give_up(launcher.reason);
    }
}

/// Milliseconds until every component waits for its turn; only then the simulator gets the first turn.
static double start_until_ready(void)
{
    osal_grant_t grant;
    const uint64_t began_ns = osal_clock_monotonic_ns();
    for (unsigned i = 0U; i < launcher.run->component_count; i++) {
        child_t* const child = &launcher.children[launcher.child_count];
        *child               = (child_t){.name         = launcher.mission.subsystems[i].executable,
                                         .process      = {.id = 0, .descriptor = -1},
                                         .is_component = true,
                                         .component    = i,
                                         .participant  = run_participant(i)};
        launcher.child_count++;
        launcher_start_component(&launcher, child);
    }
    if (osal_lockstep_wait(launcher.scheduler, RUN_SIMULATOR, OSAL_LOCKSTEP_ANY_LIFE, 0U, &grant) !=
        STATUS_OK) {
        give_up("the scheduler is closed");
    }
    return (double)(osal_clock_monotonic_ns() - began_ns) / 1e6;
}

/// Milliseconds to start and end the same programs, which refuse a call without arguments.
static double start_and_end(void)
{
    child_t children[MISSION_SUBSYSTEMS_MAX] = {0};
    const uint64_t began_ns                  = osal_clock_monotonic_ns();
    for (unsigned i = 0U; i < launcher.run->component_count; i++) {
        arguments_t arguments = {.count = 0U};
        arguments_add_joined(&arguments, launcher.program_directory,
                             launcher.mission.subsystems[i].executable);
        launcher_start_child(&launcher, &children[i], &arguments, NULL, 0U);
    }
    for (unsigned i = 0U; i < launcher.run->component_count; i++) {
        (void)waitpid((pid_t)children[i].process.id, NULL, 0);
        (void)close(children[i].process.descriptor);
    }
    return (double)(osal_clock_monotonic_ns() - began_ns) / 1e6;
}

static int remove_one(const char* path, const struct stat* about, int kind, struct FTW* place)
{
    (void)about;
    (void)kind;
    (void)place;
    return remove(path);
}

static void end_all(void)
{
    for (size_t i = 0U; i < launcher.child_count; i++) {
        (void)osal_process_stop(&launcher.children[i].process, true);
    }
    launcher_clean_up(&launcher);
    (void)nftw(directory, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

int main(void)
{
    double ready_ms[ROUNDS];
    double bare_ms[ROUNDS];
    for (unsigned round = 0U; round < ROUNDS; round++) {
        prepare(round);
        bare_ms[round]  = start_and_end();
        ready_ms[round] = start_until_ready();
        end_all();
    }
    measure_report("start_until_ready", ready_ms, bare_ms, ROUNDS, "ms");
    return 0;
}
