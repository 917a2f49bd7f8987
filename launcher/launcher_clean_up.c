// SPDX-License-Identifier: Apache-2.0
// The end of a run: end the children, remove names, complete the logs, make the report.
#include "launcher/launcher_internal.h"

#include "launcher/run_summary.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/mqueue.h"

/// Wall-clock time after which remaining children are asked to end, and after which they are killed. The
/// `operator` process does not react to the request after it has joined. It ends by itself, which takes long
/// on an emulated or loaded machine.
#define END_ASKED_NS 500000000ULL
#define END_FORCED_NS 30000000000ULL
/// Exit codes of the report.
#define REPORT_FIGURES_FAILED 3
#define REPORT_FIGURES_UNKNOWN 4

static bool is_any_alive(launcher_t* const launcher)
{
    bool is_any = false;
    for (size_t i = 0U; i < launcher->child_count; i++) {
        child_t* const child = &launcher->children[i];
        if (launcher_has_ended(launcher, child)) {
            child->is_alive = false;
            if (!launcher_has_ended_well(launcher, child)) {
                launcher_part_lost(launcher, child);
            }
        }
        is_any = is_any || child->is_alive;
    }
    return is_any;
}

static void stop_all(launcher_t* const launcher, const bool by_force)
{
    for (size_t i = 0U; i < launcher->child_count; i++) {
        if (launcher->children[i].is_alive) {
            (void)osal_process_stop(&launcher->children[i].process, by_force);
        }
    }
}

static void end_children(launcher_t* const launcher)
{
    __atomic_store_n(&launcher->run->is_finished, 1U, __ATOMIC_RELEASE);
    if (launcher->scheduler != NULL) {
        osal_lockstep_close(launcher->scheduler);
    }
    bool is_asked           = false;
    const uint64_t start_ns = osal_clock_monotonic_ns();
    while (is_any_alive(launcher)) {
        const uint64_t past_ns = osal_clock_monotonic_ns() - start_ns;
        if (!is_asked && (past_ns > END_ASKED_NS)) {
            stop_all(launcher, false);
            is_asked = true;
        }
        if (past_ns > END_FORCED_NS) {
            stop_all(launcher, true);
        }
        (void)osal_process_wait_any(NULL, 0U, LAUNCHER_LOOP_MS);
    }
}

/// Remove the names of shared memories and message queues of data flows that a killed component has left.
static void remove_flows(const run_state_t* const run)
{
    for (unsigned i = 0U; i < RUN_FLOWS_MAX; i++) {
        if (run->flows[i].name[0] != '\0') {
            (void)osal_shm_remove(run->flows[i].name);
            (void)osal_mqueue_remove(run->flows[i].name);
        }
    }
}

static void remove_name(void* const context, const char* const name)
{
    (void)context;
    (void)osal_shm_remove(name);
}

void launcher_remove_all(const char* const identity)
{
    char prefix[RUN_NAME_MAX];
    (void)text_join(prefix, sizeof prefix, (const char* const[]){"/", identity, ".", NULL});
    (void)osal_shm_each(prefix, remove_name, NULL); // This also removes the co-simulation port.
    launcher_remove_computers(identity);
}

static void remove_names(launcher_t* const launcher)
{
    char name[RUN_NAME_MAX];
    if (run_name(launcher->run, "remote", 0U, name, sizeof name)) {
        // A remote-endian program that was killed may have left these names.
        (void)osal_shm_each(name, remove_name, NULL);
    }
    if (run_name(launcher->run, "flow", 0U, name, sizeof name)) {
        // A simulator that was killed may have left these names: the device ends of data flows.
        (void)osal_shm_each(name, remove_name, NULL);
    }
    for (unsigned link = 1U; link <= RUN_LINKS_MAX; link++) {
        if (run_name(launcher->run, "link", link, name, sizeof name)) {
            (void)osal_shm_remove(name);
        }
    }
    remove_flows(launcher->run);
    launcher_remove_buses(launcher);
    static const char* const memories[] = {"scheduler", "checkpoint", "run"};
    for (size_t i = 0U; i < (sizeof memories / sizeof memories[0]); i++) {
        if (run_name(launcher->run, memories[i], 0U, name, sizeof name)) {
            (void)osal_shm_remove(name);
        }
    }
    (void)osal_file_remove(launcher->cosimulation);
    launcher_remove_computers(launcher->run->identity);
}

static bool run_tool(launcher_t* const launcher, const arguments_t* const arguments, const char* const name,
                     const bool is_seen)
{
    child_t child = {.name        = name,
                     .process     = {.id = 0, .descriptor = -1},
                     .participant = LAUNCHER_NO_PARTICIPANT,
                     .is_seen     = is_seen};
    launcher_start_child(launcher, &child, arguments, NULL, 0U);
    while (child.is_alive) {
        osal_process_t* const process = &child.process;
        (void)osal_process_wait_any(&process, 1U, 1000U);
        if ((osal_process_poll(&child.process, &child.result) == STATUS_OK) && child.result.has_ended) {
            child.is_alive = false;
        }
    }
    launcher->tool_code = child.result.code;
    return child.has_run && !child.result.was_signalled && (child.result.code == 0);
}

bool launcher_run_tool(launcher_t* const launcher, const arguments_t* const arguments, const char* const name)
{
    return run_tool(launcher, arguments, name, false);
}

static void complete_logs(launcher_t* const launcher)
{
    arguments_t merge = {.count = 0U};
    arguments_add_joined(&merge, launcher->program_directory, "packet-archive-sqlite");
    arguments_add(&merge, "merge");
    arguments_add_number(&merge, launcher->run->directory,
                         __atomic_load_n(&launcher->run->log_records, __ATOMIC_ACQUIRE));
    if (!launcher_run_tool(launcher, &merge, "packet-archive-sqlite")) {
        (void)launcher_fail(launcher, "the packet log is not complete", "; see console.log");
    }
}

static void draw_report(launcher_t* const launcher)
{
    arguments_t report = {.count = 0U};
    arguments_add_words(&report,
                        (const char* const[]){"/usr/bin/env", "PYTHONPATH=gse", launcher_python(), "-m",
                                              "hirosco_gse.report", launcher->run->directory, NULL});
    if (run_tool(launcher, &report, "report", true)) {
        return;
    }
    // The report program has already written this result into run.json.
    if (launcher->tool_code == REPORT_FIGURES_FAILED) {
        (void)launcher_fail(launcher, "figures missing or out of their bounds",
                            "; see report.html and run.json");
    } else if (launcher->tool_code == REPORT_FIGURES_UNKNOWN) {
        (void)launcher_fail(launcher, "the report could not be made, so the figures are not known",
                            "; see console.log");
    } else {
        osal_console_print_error("the report could not be drawn; see console.log in the run's directory");
    }
}

void launcher_clean_up(launcher_t* const launcher)
{
    if (launcher->run == NULL) {
        // Interfaces are created before the run state, so they may exist without it.
        launcher_remove_buses(launcher);
        return;
    }
    end_children(launcher);
    if ((launcher->scheduler != NULL) && osal_lockstep_is_lossy(launcher->scheduler)) {
        __atomic_store_n(&launcher->run->is_lossy, 1U, __ATOMIC_RELAXED);
    }
    remove_names(launcher);
    if ((launcher->child_count > 0U) || launcher->is_taken_over) {
        complete_logs(launcher);
        if (!run_summary_write(launcher)) {
            osal_console_print_error("cannot write run.json into the run's directory (is the disk full?)");
            (void)launcher_fail(launcher, "run.json could not be written", "; is the disk full?");
        }
        // The flight has ended: close its ground port before the report is made.
        osal_socket_close(&launcher->ground);
        if (launcher->options.has_report) {
            draw_report(launcher);
        }
    }
    // Last: if this launcher is killed before, its guard repeats all steps.
    __atomic_store_n(&launcher->run->is_cleaned_up, 1U, __ATOMIC_RELEASE);
    osal_socket_close(&launcher->ground);
}
