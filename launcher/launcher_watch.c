// SPDX-License-Identifier: Apache-2.0
// Watchdog of the scheduler. A process that holds the grant and does not pass it on stops simulated time for
// all participants. Such a component hangs: the launcher suspends it, so that the others continue, and the
// supervisor kills it. This decision depends on wall-clock time, so it makes the run irreproducible.
#include "launcher/launcher_internal.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"

#define NS_PER_US 1000U
#define NS_PER_MS 1000000ULL
#define NS_PER_S 1000000000ULL
/// Time for which a holder may compute, or be stopped by a signal, before it counts as hanging. In real
/// time, this is a minimum: `hangAfter` of the mission applies if it is longer.
#define REAL_HANG_NS (20U * NS_PER_MS)
#define STEPPED_HANG_NS (5000U * NS_PER_MS)
#define FREE_HANG_NS (200U * NS_PER_MS) ///< The same time in a run in which each process has its own clock.
/// Time for which a holder may wait for the operating system, for example for a slow disk.
#define REAL_WAIT_NS (5000U * NS_PER_MS)
#define STEPPED_WAIT_NS (20000U * NS_PER_MS)
/// Wall-clock time in which a restarted component must join, because simulated time waits for it.
#define JOIN_NS (10000U * NS_PER_MS)
/// Simulated time by which a life that has not joined is postponed in real time.
#define POSTPONED_NS (20U * NS_PER_MS)

static child_t* child_of(launcher_t* const launcher, const unsigned participant)
{
    for (size_t i = 0U; i < launcher->child_count; i++) {
        child_t* const child = &launcher->children[i];
        if (child->is_alive && (child->participant == participant)) {
            return child;
        }
    }
    return NULL;
}

/// Returns the time for which a holder may compute in real time. For a slower machine, for example an
/// emulated one, the mission can define a longer `hangAfter`.
static uint64_t real_hang_ns(const launcher_t* const launcher, const child_t* const child)
{
    const uint64_t declared_ns =
        (uint64_t)launcher->mission.subsystems[child->component].hang_after_us * NS_PER_US;
    return (declared_ns > REAL_HANG_NS) ? declared_ns : REAL_HANG_NS;
}

/// True if a process hangs. A process that only waits for a processor does not hang, so that the result does
/// not depend on the load of the machine.
static bool is_hanging(const launcher_t* const launcher, const child_t* const child,
                       const osal_process_look_t* const look, const uint64_t granted_ns)
{
    const bool is_stepped  = launcher->options.is_stepped;
    const uint64_t real_ns = (launcher->scheduler != NULL) ? real_hang_ns(launcher, child) : FREE_HANG_NS;
    const uint64_t hang_ns = is_stepped ? STEPPED_HANG_NS : real_ns;
    const uint64_t wait_ns = is_stepped ? STEPPED_WAIT_NS : REAL_WAIT_NS;
    if (look->is_stopped) {
        return granted_ns >= hang_ns;
    }
    return look->is_runnable ? ((look->processor_ns - launcher->watch.processor_ns) >= hang_ns)
                             : (granted_ns >= wait_ns);
}

/// Report that the launcher kills a restarted process that has not done something within JOIN_NS.
static void report_late(const child_t* const child, const char* const what)
{
    char line[LAUNCHER_REASON_MAX];
    text_t text = text_in(line, sizeof line);
    text_add_words(&text, (const char* const[]){child->name, what, " within ", NULL});
    text_add_unsigned(&text, JOIN_NS / NS_PER_S);
    text_add(&text, " s: killed");
    osal_console_print_error(line);
}

/// Report that a process hangs, how long it has made no step, and what the launcher does.
static void report_hang(const child_t* const child, const char* const action, const uint64_t time_ns,
                        const char* const consequence)
{
    char line[LAUNCHER_REASON_MAX];
    text_t text = text_in(line, sizeof line);
    text_add_words(&text, (const char* const[]){child->name, " hangs: ", action, " after ", NULL});
    text_add_unsigned(&text, time_ns / NS_PER_MS);
    text_add_words(&text, (const char* const[]){" ms without the end of a step", consequence, NULL});
    osal_console_print_error(line);
}

/// Suspend a process that has made no step for this time.
static void suspend(launcher_t* const launcher, child_t* const child, const uint64_t time_ns)
{
    run_component_t* const component = &launcher->run->components[child->component];
    launcher->is_undetermined        = true;
    if (component->apid == SUPERVISOR_APID) { // Only the launcher can kill the supervisor.
        report_hang(child, "killed", time_ns, "");
        (void)osal_process_stop(&child->process, true);
        return;
    }
    report_hang(child, "suspended", time_ns, ", so that the others continue; the supervisor kills it");
    (void)osal_process_suspend(&child->process); // The suspended process cannot act without a grant.
    osal_lockstep_suspend(launcher->scheduler, child->participant);
    __atomic_store_n(&component->hung_life, child->life, __ATOMIC_RELEASE);
}

/// Suspend the holder of the grant if it hangs. With each new grant the measurement of the time starts again.
static void watch_holder(launcher_t* const launcher, const uint64_t now_ns)
{
    launcher_watch_t* const watch = &launcher->watch;
    uint32_t grants               = 0U;
    const unsigned holder         = osal_lockstep_holder(launcher->scheduler, &grants);
    child_t* const child          = child_of(launcher, holder);
    osal_process_look_t look;
    if ((child == NULL) || (osal_process_look(&child->process, &look) != STATUS_OK)) {
        watch->since_ns = 0U;
        return;
    }
    if ((watch->since_ns == 0U) || (watch->holder != holder) || (watch->grants != grants)) {
        *watch = (launcher_watch_t){.holder       = holder,
                                    .grants       = grants,
                                    .since_ns     = now_ns,
                                    .join_ns      = watch->join_ns,
                                    .processor_ns = look.processor_ns};
        return;
    }
    if (child->is_component && is_hanging(launcher, child, &look, now_ns - watch->since_ns)) {
        suspend(launcher, child, now_ns - watch->since_ns);
        watch->since_ns = 0U;
    }
}

/// In stepped time, end a life whose process does not join within JOIN_NS; in real time, let it begin later.
/// Otherwise the other participants would wait for it.
static void watch_joining(launcher_t* const launcher, const uint64_t now_ns)
{
    const unsigned awaited   = osal_lockstep_awaited(launcher->scheduler);
    const uint64_t simulated = osal_lockstep_now_ns(launcher->scheduler);
    const bool is_begun      = (simulated > 0U);
    uint32_t life            = 0U;
    if ((awaited == OSAL_LOCKSTEP_PARTICIPANTS_MAX) || !is_begun) {
        launcher->watch.join_ns = 0U;
        return;
    }
    (void)osal_lockstep_presence(launcher->scheduler, awaited, &life);
    if (!launcher->options.is_stepped) {
        osal_lockstep_postpone(launcher->scheduler, awaited, life, simulated + POSTPONED_NS);
        return;
    }
    if (launcher->watch.join_ns == 0U) {
        launcher->watch.join_ns = now_ns;
    } else if ((now_ns - launcher->watch.join_ns) >= JOIN_NS) {
        child_t* const child      = child_of(launcher, awaited);
        launcher->is_undetermined = true;
        if (child != NULL) {
            report_late(child, " has not joined the run");
            (void)osal_process_stop(&child->process, true);
        }
        osal_lockstep_end(launcher->scheduler, awaited, life);
        launcher->watch.join_ns = 0U;
    } else {
        // The process still has time to join.
    }
}

/// Unless time is stepped, only the launcher detects a restarted process that never makes a step: before its
/// first step it has not announced a wake time that other processes could check.
static void watch_first_steps(launcher_t* const launcher, const uint64_t now_ns)
{
    for (size_t i = 0U; i < launcher->child_count; i++) {
        child_t* const child = &launcher->children[i];
        if (child->is_alive && child->is_component && (child->life > 1U) &&
            ((now_ns - child->started_ns) >= JOIN_NS) &&
            (run_state_last_beat(launcher->run, child->component).wake_ns == OSAL_LOCKSTEP_NEVER)) {
            report_late(child, " has not made a step");
            (void)osal_process_stop(&child->process, true);
            child->started_ns = now_ns;
        }
    }
}

/// Kill a supervisor that hangs, if each process has its own clock. No process on board does this in that
/// case: the others can only detect that the supervisor is late, but it may be waiting for its disk.
static void watch_supervisor(launcher_t* const launcher, const uint64_t now_ns)
{
    launcher_watch_t* const watch = &launcher->watch;
    unsigned index                = 0U;
    osal_process_look_t look;
    child_t* const child  = run_state_find(launcher->run, SUPERVISOR_APID, &index)
                                ? child_of(launcher, run_participant(index))
                                : NULL;
    const run_beat_t beat = run_state_last_beat(launcher->run, index);
    if ((child == NULL) || (beat.wake_ns == OSAL_LOCKSTEP_NEVER) ||
        (osal_process_look(&child->process, &look) != STATUS_OK)) {
        watch->since_ns = 0U;
    } else if ((watch->since_ns == 0U) || (watch->step_ns != beat.step_ns)) {
        *watch = (launcher_watch_t){
            .since_ns = now_ns, .step_ns = beat.step_ns, .processor_ns = look.processor_ns};
    } else if ((look.is_stopped || look.is_runnable) &&
               is_hanging(launcher, child, &look, now_ns - watch->since_ns)) {
        suspend(launcher, child, now_ns - watch->since_ns);
        watch->since_ns = 0U;
    } else {
        // The supervisor still has time, or waits for its disk.
    }
}

void launcher_watch_lives(launcher_t* const launcher)
{
    if (launcher->options.is_image) {
        return; // In the image one loop runs all components.
    }
    const uint64_t now_ns = osal_clock_monotonic_ns();
    if (!launcher->options.is_stepped) {
        watch_first_steps(launcher, now_ns);
    }
    if (launcher->scheduler == NULL) { // Each process has its own clock.
        watch_supervisor(launcher, now_ns);
    } else {
        watch_holder(launcher, now_ns);
        watch_joining(launcher, now_ns);
    }
}

/// Returns the child that was last found to hold the grant; null if there is none.
static const child_t* holder_of(launcher_t* const launcher)
{
    const bool has_holder = (launcher->scheduler != NULL) && (launcher->watch.since_ns != 0U);
    return has_holder ? child_of(launcher, launcher->watch.holder) : NULL;
}

bool launcher_is_starved(launcher_t* const launcher)
{
    osal_process_look_t look;
    const child_t* const child = holder_of(launcher);
    return (child != NULL) && (osal_process_look(&child->process, &look) == STATUS_OK) && look.is_runnable &&
           ((look.processor_ns - launcher->watch.processor_ns) < STEPPED_HANG_NS);
}

const char* launcher_holder(launcher_t* const launcher)
{
    const child_t* const child = holder_of(launcher);
    return (child != NULL) ? child->name : "no process";
}
