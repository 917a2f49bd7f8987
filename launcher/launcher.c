// SPDX-License-Identifier: Apache-2.0
// Supervises a run: its child processes, and the consequences when one ends.
#include "launcher/launcher_guard.h"
#include "launcher/launcher_internal.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define PROGRESS_NS 1000000000ULL      ///< Wall-clock time between lines of progress on a terminal.
#define PROGRESS_FILE_NS 5000000000ULL ///< Wall-clock time between lines if the output is no terminal.
/// Simulated time for which a mission continues after its operator has ended.
#define LEFT_NS 2000000000ULL
#define STALL_NS 30000000000ULL ///< Longest wall-clock time without progress of simulated time.
/// Longest wall-clock time until simulated time first advances, because all programs must start.
#define START_NS 120000000000ULL
/// Wall-clock time after its last grant in which a process should end by itself; after it the launcher asks
/// the process to end.
#define ASK_NS 1000000000ULL
#define KILL_NS 2000000000ULL ///< Wall-clock time after its last grant until a process is killed.
/// Simulated time in which the mission must shut down; the supervisor needs 12 s.
#define DOWN_NS 30000000000ULL
/// Value of abandon_ns that ends the run immediately, even before simulated time begins.
#define ABANDONED 1U

bool launcher_refuse(launcher_t* const launcher, const char* const* const words)
{
    if (launcher->reason[0] == '\0') {
        (void)text_join(launcher->reason, sizeof launcher->reason, words);
    }
    launcher->exit_code = 1;
    return false;
}

bool launcher_fail(launcher_t* const launcher, const char* const what, const char* const detail)
{
    return launcher_refuse(launcher, (const char* const[]){what, detail, NULL});
}

/// Returns mission time: simulated time; without a scheduler, the time of the machine.
uint64_t launcher_now_ns(const launcher_t* const launcher)
{
    if (launcher->scheduler != NULL) {
        return osal_lockstep_now_ns(launcher->scheduler);
    }
    const uint64_t wall_ns = osal_clock_monotonic_ns();
    return (wall_ns > launcher->run->origin_ns) ? (wall_ns - launcher->run->origin_ns) : 0U;
}

/// Record the end of a participant of the scheduler. True if simulated time determines the instant of the
/// end: either the holder of a grant has already ended the participant's life, or the participant itself held
/// the grant.
static bool end_participant(const launcher_t* const launcher, const child_t* const child)
{
    if (launcher->scheduler == NULL) {
        return false;
    }
    uint32_t grants      = 0U;
    uint32_t life        = 0U;
    const uint32_t of    = child->is_component ? child->life : OSAL_LOCKSTEP_ANY_LIFE;
    const bool is_holder = osal_lockstep_holder(launcher->scheduler, &grants) == child->participant;
    const bool is_absent =
        osal_lockstep_presence(launcher->scheduler, child->participant, &life) == OSAL_LOCKSTEP_ABSENT;
    const bool is_ended = is_absent || (child->is_component && (life != child->life));
    osal_lockstep_end(launcher->scheduler, child->participant, of);
    // SIGKILL and SIGTERM come from another process and may arrive at any instant; an error of the process
    // itself happens at a determined instant.
    const bool is_from_outside = child->result.was_signalled && ((child->result.code == OSAL_SIGNAL_KILL) ||
                                                                 (child->result.code == OSAL_SIGNAL_END));
    return is_ended || (is_holder && !is_from_outside);
}

bool launcher_is_set(const uint32_t* const flag)
{
    return __atomic_load_n(flag, __ATOMIC_ACQUIRE) != 0U;
}

/// Request the shutdown of the mission. If no process can follow the request, the flight is ended after
/// DOWN_NS.
static void request_stop(launcher_t* const launcher)
{
    __atomic_store_n(&launcher->run->is_stop_requested, 1U, __ATOMIC_RELEASE);
    if (launcher->scheduler != NULL) {
        // Simulated time must run, so that a paused mission can shut down.
        osal_lockstep_hold(launcher->scheduler, false);
    }
    if (launcher->abandon_ns == 0U) {
        launcher->abandon_ns = launcher_now_ns(launcher) + DOWN_NS;
    }
}

/// Let the run fail, with the end of a child as the reason.
static void note_end(launcher_t* const launcher, const child_t* const child, const char* const consequence)
{
    char code[24];
    text_t text = text_in(code, sizeof code);
    text_add_unsigned(&text, (uint64_t)child->result.code);
    const char* const how = child->result.was_signalled ? " was ended by signal " : " ended with exit code ";
    launcher->is_broken   = true;
    (void)launcher_refuse(launcher, (const char* const[]){child->name, how, code, consequence, NULL});
}

/// React to the unexpected end of a process: the run continues as far as possible, and its result is a
/// failure.
void launcher_part_lost(launcher_t* const launcher, child_t* const child)
{
    note_end(launcher, child, "; see console.log");
    if (child->is_component) {
        run_component_t* const component = &launcher->run->components[child->component];
        __atomic_store_n(&component->process, (uint32_t)RUN_PROCESS_LOST, __ATOMIC_RELEASE);
        if (component->apid == SUPERVISOR_APID) {
            // Without the supervisor, the subsystems go to their safe states by themselves.
            launcher->abandon_ns = launcher_now_ns(launcher) + RETURN_ABANDON_NS;
        }
    } else if (strcmp(child->name, "packet-archive-sqlite") != 0) {
        request_stop(launcher);
        // Simulated time does not determine when the supervisor detects this end.
        launcher->is_undetermined = true;
        const bool is_vital  = (strcmp(child->name, "simulator") == 0) || (strcmp(child->name, "image") == 0);
        launcher->abandon_ns = is_vital ? ABANDONED : launcher->abandon_ns;
    } else {
        // Records that it has not written are still in the spool; the merge at the end of the run reads them.
    }
    const bool is_determined =
        (child->participant != LAUNCHER_NO_PARTICIPANT) && end_participant(launcher, child);
    launcher->is_undetermined = launcher->is_undetermined || !is_determined;
}

/// Let a supervisor that has died start again: immediately, after 0.1 s, then after 1 s of wall-clock time.
/// In stepped time the scheduler begins its next life after its boot time. Until then the subsystems
/// continue without a supervisor. False if its budget is used up, or if it died before its first step.
static bool may_return(launcher_t* const launcher, child_t* const child)
{
    run_component_t* const component = &launcher->run->components[child->component];
    const uint64_t now_ns            = launcher_now_ns(launcher);
    uint64_t delay_ns                = 0U;
    if ((component->apid != SUPERVISOR_APID) || (now_ns == 0U) ||
        !return_budget_take(&launcher->returns, now_ns, &delay_ns)) {
        return false;
    }
    launcher->return_wall_ns  = osal_clock_monotonic_ns() + delay_ns;
    launcher->is_undetermined = !end_participant(launcher, child) || launcher->is_undetermined;
    __atomic_store_n(&component->wanted_life, child->life + 1U, __ATOMIC_RELEASE);
    // The run continues, but its result is a failure, as after every death.
    note_end(launcher, child, " and was restarted; see console.log");
    return true;
}

/// The scheduler expects the next life of the supervisor: let this life end at the instant at which it would
/// begin.
static void give_supervisor_up(const launcher_t* const launcher, const child_t* const child)
{
    const bool is_supervisor = (launcher->run->components[child->component].apid == SUPERVISOR_APID);
    if (is_supervisor && (launcher->scheduler != NULL)) {
        osal_lockstep_set_succession(launcher->scheduler, child->participant, 0U);
        osal_lockstep_end(launcher->scheduler, child->participant, child->life + 1U);
    }
}

bool launcher_has_ended_well(const launcher_t* const launcher, const child_t* const child)
{
    const bool was_signalled = child->result.was_signalled;
    // A shutdown by the user cuts the script: the operator may get an unexpected answer or lose its link. An
    // operator that has not connected yet gets SIGTERM.
    const bool is_cut = launcher->is_ended_by_user && (strcmp(child->name, "operator") == 0) &&
                        (!was_signalled || (child->result.code == OSAL_SIGNAL_END));
    return is_cut || (!was_signalled && (child->result.code == 0));
}

static void child_ended(launcher_t* const launcher, child_t* const child)
{
    child->is_alive    = false;
    const bool is_over = launcher_is_set(&launcher->run->is_finished) || (launcher->abandon_ns == ABANDONED);
    const bool is_good = launcher_has_ended_well(launcher, child);
    if (child->is_component && !is_over) {
        run_component_t* const component = &launcher->run->components[child->component];
        if ((__atomic_load_n(&component->wanted_life, __ATOMIC_ACQUIRE) != child->life) && is_good) {
            __atomic_store_n(&component->process, (uint32_t)RUN_PROCESS_STOPPED, __ATOMIC_RELEASE);
            (void)end_participant(launcher, child); // The supervisor has ordered the end of this process.
            return;
        }
        if (may_return(launcher, child)) {
            return;
        }
        give_supervisor_up(launcher, child);
        launcher_part_lost(launcher, child);
    } else if (!is_good) {
        launcher_part_lost(launcher, child);
    } else if (!is_over && (strcmp(child->name, "operator") != 0)) {
        launcher_part_lost(launcher, child); // The exit code is 0, but the process has ended too early.
    } else if (strcmp(child->name, "operator") == 0) {
        launcher->left_ns = launcher_now_ns(launcher) + 1U;
        if (child->participant != LAUNCHER_NO_PARTICIPANT) {
            // The operator may have ended before it joined as a participant.
            (void)end_participant(launcher, child);
        } else if (launcher->options.is_image && (launcher->left_ns == 1U)) {
            // Time has not begun, because the image waits for the operator.
            launcher->is_cut_short = true;
            request_stop(launcher);
        } else {
            // The image detects the end of the operator by itself.
        }
    } else {
        // The end was expected.
    }
}

/// Handle the ends of children. A process may end because a process that was started earlier has ended. The
/// children are checked from the last to the first, so that the cause is found in the same pass and reported
/// first.
static void reap(launcher_t* const launcher)
{
    bool has_ended[LAUNCHER_CHILDREN_MAX] = {false};
    for (size_t i = launcher->child_count; i > 0U; i--) {
        child_t* const child = &launcher->children[i - 1U];
        has_ended[i - 1U]    = launcher_has_ended(launcher, child);
    }
    for (size_t i = 0U; i < launcher->child_count; i++) {
        if (has_ended[i]) {
            child_ended(launcher, &launcher->children[i]);
        }
    }
}

/// End a process whose life has ended. Participants of the scheduler end by themselves. Other processes, and
/// those that do not end in time, are asked to end by a signal; a process that does not react is killed.
static void end_child(child_t* const child, const run_component_t* const component,
                      const bool is_in_scheduler)
{
    const uint64_t now_ns = osal_clock_monotonic_ns();
    if (child->asked_to_end_ns == 0U) {
        child->asked_to_end_ns = now_ns;
        child->is_asked        = false;
    }
    const uint64_t waited_ns = now_ns - child->asked_to_end_ns;
    const bool is_to_kill    = (__atomic_load_n(&component->kill_life, __ATOMIC_ACQUIRE) == child->life);
    if (is_to_kill || (waited_ns >= KILL_NS)) {
        (void)osal_process_stop(&child->process, true);
    } else if (!child->is_asked && (!is_in_scheduler || (waited_ns >= ASK_NS))) {
        (void)osal_process_stop(&child->process, false);
        child->is_asked = true;
    } else {
        // The process ends by itself, or was asked to end a short time ago: wait.
    }
}

/// Perform the orders of the supervisor: start processes again, or stop them.
static void perform_orders(launcher_t* const launcher)
{
    for (size_t i = 0U; i < launcher->child_count; i++) {
        child_t* const child = &launcher->children[i];
        if (!child->is_component) {
            continue;
        }
        const run_component_t* const component = &launcher->run->components[child->component];
        const uint32_t wanted                  = __atomic_load_n(&component->wanted_life, __ATOMIC_ACQUIRE);
        if (child->is_alive && (wanted != child->life)) {
            end_child(child, component, launcher->scheduler != NULL);
        } else if (!child->is_alive && (wanted != 0U) && (wanted != child->life) &&
                   ((component->apid != SUPERVISOR_APID) ||
                    (osal_clock_monotonic_ns() >= launcher->return_wall_ns))) {
            launcher_start_component(launcher, child);
        } else {
            // Either the process has ended as ordered, or it has died and the supervisor decides about the
            // reaction.
        }
    }
}

/// Print a line of progress if one is due.
static void show_progress(launcher_t* const launcher, const uint64_t wall_ns)
{
    const uint64_t simulated = launcher_now_ns(launcher);
    if ((launcher->first_wall_ns == 0U) && (simulated > 0U)) {
        launcher->first_wall_ns      = wall_ns;
        launcher->first_simulated_ns = simulated;
    }
    const uint64_t wall_past = wall_ns - launcher->last_wall_ns;
    if (wall_past < (osal_console_is_terminal() ? PROGRESS_NS : PROGRESS_FILE_NS)) {
        return;
    }
    const uint64_t tenths = ((simulated - launcher->last_simulated_ns) * 10U) / wall_past;
    char line[96];
    text_t text = text_in(line, sizeof line);
    text_add(&text, osal_console_is_terminal() ? "\r  " : "  ");
    text_add_unsigned(&text, simulated / 1000000000U);
    text_add(&text, ".");
    text_add_digits(&text, (simulated / 100000000U) % 10U, 1U);
    text_add(&text, " s flown, ");
    text_add_unsigned(&text, tenths / 10U);
    text_add(&text, ".");
    text_add_digits(&text, tenths, 1U);
    text_add(&text, " x real time   ");
    text_add(&text, osal_console_is_terminal() ? "" : "\n");
    osal_console_print(line);
    launcher->last_wall_ns      = wall_ns;
    launcher->last_simulated_ns = simulated;
}

/// True if simulated time has stopped: a process holds the grant and does not pass it on, or has not joined.
static bool has_stalled(launcher_t* const launcher, const uint64_t simulated)
{
    const uint64_t wall_ns = osal_clock_monotonic_ns();
    const bool is_held     = (launcher->scheduler != NULL) && osal_lockstep_is_held(launcher->scheduler);
    if ((simulated != launcher->moved_simulated_ns) || (launcher->moved_wall_ns == 0U) || is_held ||
        launcher_is_starved(launcher)) {
        launcher->moved_simulated_ns = simulated;
        launcher->moved_wall_ns      = wall_ns;
    }
    const bool has = (wall_ns - launcher->moved_wall_ns) > ((simulated == 0U) ? START_NS : STALL_NS);
    if (has) {
        (void)launcher_refuse(launcher,
                              (const char* const[]){"simulated time has stopped; the grant is held by ",
                                                    launcher_holder(launcher), "; see console.log", NULL});
    }
    return has;
}

static bool is_abandoned(launcher_t* const launcher, uint64_t simulated)
{
    if ((launcher->abandon_ns == ABANDONED) || (launcher->abandon_ns == 0U)) {
        return launcher->abandon_ns == ABANDONED;
    }
    const bool is_late = simulated >= launcher->abandon_ns;
    if (is_late) {
        (void)launcher_fail(launcher, "the mission did not shut down in time and was ended",
                            "; see console.log");
    }
    return is_late;
}

/// True if the operator no longer takes part in stepped time: a request of the user cannot cut its script any
/// more, although its process may not have ended yet. Its exit code then counts, however late it ends.
static bool has_operator_left(const launcher_t* const launcher)
{
    uint32_t life = 0U;
    if (!launcher->options.is_stepped) {
        return false;
    }
    return launcher->options.is_image
               ? launcher_is_set(&launcher->run->has_operator_left)
               : (osal_lockstep_presence(launcher->scheduler, run_operator(launcher->run), &life) ==
                  OSAL_LOCKSTEP_ABSENT);
}

/// Handle Ctrl-C, --duration and the end of the operator; true if the run has ended.
static bool is_over(launcher_t* const launcher, unsigned* const stops_seen)
{
    const unsigned stops = osal_process_stop_count();
    if (stops > *stops_seen) {
        *stops_seen                = stops;
        launcher->is_cut_short     = true;
        launcher->is_ended_by_user = launcher->is_ended_by_user || !has_operator_left(launcher);
        request_stop(launcher);
        if (stops >= 3U) {
            (void)launcher_fail(launcher, "interrupted three times: ended at once", "");
            return true;
        }
        osal_console_print_line("\nshutting the mission down (Ctrl-C twice more ends it at once)");
    }
    const uint64_t simulated = launcher_now_ns(launcher);
    const bool is_due  = (launcher->options.duration_ns > 0U) && (simulated >= launcher->options.duration_ns);
    const bool is_left = (launcher->options.duration_ns == 0U) && (launcher->left_ns > 0U) &&
                         (simulated >= (launcher->left_ns + LEFT_NS));
    if ((is_due || is_left) && !launcher->is_cut_short) {
        launcher->is_cut_short     = true;
        launcher->is_ended_by_user = is_due && !has_operator_left(launcher);
        request_stop(launcher);
    }
    return launcher_is_set(&launcher->run->is_finished) || is_abandoned(launcher, simulated) ||
           has_stalled(launcher, simulated);
}

void launcher_fly(launcher_t* const launcher)
{
    unsigned stops_seen    = 0U;
    launcher->last_wall_ns = osal_clock_monotonic_ns();
    launcher_start_all(launcher);
    // A failure before or during the start ends the loop; after the death of a process the run continues.
    while (launcher->exit_code != 1 || launcher->is_broken) {
        osal_process_t* processes[LAUNCHER_CHILDREN_MAX];
        size_t count = 0U;
        for (size_t i = 0U; i < launcher->child_count; i++) {
            if (launcher->children[i].is_alive) {
                processes[count] = &launcher->children[i].process;
                count++;
            }
        }
        const bool is_held_back = (launcher->scheduler != NULL) && !launcher->options.is_stepped;
        (void)osal_process_wait_any(processes, count,
                                    is_held_back ? LAUNCHER_REAL_LOOP_MS : LAUNCHER_LOOP_MS);
        reap(launcher);
        launcher_watch_lives(launcher);
        show_progress(launcher, osal_clock_monotonic_ns());
        if (is_over(launcher, &stops_seen)) {
            break;
        }
        perform_orders(launcher);
        if (launcher->guard != NULL) {
            guard_keep(launcher->guard);
        }
    }
    launcher->last_wall_ns      = osal_clock_monotonic_ns();
    launcher->last_simulated_ns = launcher_now_ns(launcher);
}
