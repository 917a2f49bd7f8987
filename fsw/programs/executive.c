// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/executive.h"

#include "fsw/programs/remote_endian.h"
#include "fsw/programs/loop_tasks.h"
#include "fsw/programs/component_instance.h"
#include "base/number.h"
#include "base/text.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/task.h"
#include "osal/include/osal/watchdog.h"

#include <string.h>

/// Longest time between two checks in real time whether the run has ended.
#define REAL_WAIT_MAX_NS 50000000ULL
// On a computer with a watchdog, longest times [ms]: from the start of the program to its first step, and
// from one step to the next.
#define WATCHDOG_START_MS 5000U
#define WATCHDOG_MS 1000U

typedef struct { // All storage that the program itself needs, in addition to its component's.
    component_runtime_t runtime;
    const component_descriptors_t* descriptors;
    const mission_descriptor_t* mission;
    subsystem_descriptor_t* own;
    component_play_outs_t play_outs;
    osal_shm_t run_shm;
    osal_shm_t scheduler_shm;
    loop_tasks_t loop_tasks;
    remote_endian_t remote;
    bool is_remote_endian; // The program takes part in the run through a proxy.
} executive_t;

static executive_t storage;

/// Print an error text of the program. Returns 1, the exit status.
static int report_error(const char* const executable, const char* const what)
{
    char line[COMPONENT_RUNTIME_ERROR_MAX + 64U];
    text_t text = text_in(line, sizeof line);
    text_add(&text, executable);
    text_add(&text, ": ");
    text_add(&text, what);
    osal_console_print_error(line);
    return 1;
}

/// Returns the number in a text; UINT32_MAX if it is malformed.
static unsigned number_of(const char* const digits)
{
    const char* next    = digits;
    uint64_t number     = 0U;
    const bool is_valid = (number_read_unsigned(&next, &number) == STATUS_OK) && number_is_end(next);
    return (is_valid && (number < UINT32_MAX)) ? (unsigned)number : UINT32_MAX;
}

/// Returns null, or the error text.
static const char* take_runtime(run_state_t* const run, const unsigned component,
                                osal_lockstep_t* const scheduler)
{
    const char* const error = storage.descriptors->load(storage.descriptors->context, run, component,
                                                        &storage.mission, &storage.own);
    if (error != NULL) {
        return error;
    }
    const component_runtime_surroundings_t surroundings = {.run         = run,
                                                           .mission     = storage.mission,
                                                           .descriptors = storage.descriptors,
                                                           .play_outs   = &storage.play_outs,
                                                           .scheduler   = scheduler};
    return (component_runtime_take(&storage.runtime, &surroundings, storage.own, component) == STATUS_OK)
               ? NULL
               : storage.runtime.error;
}

/// Attach to the run and its scheduler, and load the descriptors. Returns null, or the error text.
static const char* open_run(const char* const name, const unsigned component,
                            osal_lockstep_t** const out_scheduler)
{
    run_state_t* run = NULL;
    char scheduler_name[RUN_NAME_MAX];
    *out_scheduler = NULL;
    if (run_state_attach(&storage.run_shm, name, &run) != STATUS_OK) {
        return "there is no such run; `hirosco run` starts the programs";
    }
    if (component >= run->component_count) {
        return "the run has no such component; `hirosco run` starts it";
    }
    if (run->is_stepped) {
        if (!run_name(run, "scheduler", 0U, scheduler_name, sizeof scheduler_name) ||
            (osal_shm_open(&storage.scheduler_shm, scheduler_name) != STATUS_OK)) {
            return "the run's scheduler is gone; start the mission again";
        }
        *out_scheduler = osal_lockstep_attach(osal_shm_address(&storage.scheduler_shm));
    }
    return take_runtime(run, component, *out_scheduler);
}

/// Returns null, or the error text.
static const char* join_by_proxy(const unsigned descriptor)
{
    remote_endian_t* const remote = &storage.remote;
    storage.is_remote_endian      = true;
    const status_t joined =
        (descriptor != UINT32_MAX) ? remote_endian_join(remote, (int)descriptor) : STATUS_INVALID;
    if (joined != STATUS_OK) {
        return "the proxy has sent no run; `hirosco run --remote-endian SUBSYSTEM` starts both";
    }
    const char* const error = take_runtime(&remote->run, remote->component, NULL);
    if (error == NULL) {
        remote_endian_serve(remote, &storage.runtime);
    }
    return error;
}

/// Start the tasks of the loops of services, which exist only in real time.
static bool start_loop_tasks(const component_instance_t* const instance)
{
    const component_runtime_t* const runtime = &storage.runtime;
    return (runtime->clock.mode != OSAL_CLOCK_REAL) || (instance->component == NULL) ||
           (loop_tasks_start(&storage.loop_tasks, instance->component, runtime->run->origin_ns) == STATUS_OK);
}

/// Report on the console that a real clock has no locked memory.
static void note_memory(const char* const executable)
{
    const osal_clock_t* const clock = &storage.runtime.clock;
    if ((clock->mode == OSAL_CLOCK_REAL) && !clock->is_memory_locked) {
        (void)report_error(executable,
                           "note: locked memory is not permitted here; run as root, or raise `ulimit -l`");
    }
}

/// In real time, set the priority that the descriptor defines for the loop, when it has changed.
static void follow_priority(const char* const executable, const component_instance_t* const instance,
                            uint8_t* const priority)
{
    if ((storage.runtime.clock.mode != OSAL_CLOCK_REAL) || (instance->component == NULL)) {
        return;
    }
    const uint8_t wanted = subsystem_component_priority(instance->component);
    if (wanted == *priority) {
        return;
    }
    *priority = wanted;
    if ((osal_task_set_priority((int)wanted) != STATUS_OK) && (wanted > 0U)) {
        (void)report_error(
            executable,
            "note: real-time priorities are not permitted here; run as root, or raise `ulimit -r`");
    }
}

/// Start the watchdog of a computer that has one, or give it another period.
static void start_watchdog(const char* const executable, const uint32_t period_ms)
{
    const status_t status = osal_watchdog_start(period_ms);
    if ((status != STATUS_OK) && (status != STATUS_UNSUPPORTED)) {
        (void)report_error(executable, "note: the watchdog cannot be started");
    }
}

/// Run until the end of the run, or until the process is asked to end. STATUS_OK, STATUS_CLOSED; any other
/// status: protocol error between the proxy and this program.
static status_t loop(const char* const executable, const component_instance_t* const instance)
{
    component_runtime_t* const runtime = &storage.runtime;
    uint64_t wake_ns                   = 0U;
    uint8_t priority                   = 0U;
    for (;;) {
        osal_socket_t* sockets[COMPONENT_RUNTIME_SOCKETS_MAX];
        size_t count = component_runtime_sockets(runtime, sockets, COMPONENT_RUNTIME_SOCKETS_MAX);
        if (instance->sockets != NULL) {
            count +=
                instance->sockets(instance->self, &sockets[count], COMPONENT_RUNTIME_SOCKETS_MAX - count);
        }
        if (runtime->clock.mode == OSAL_CLOCK_REAL) {
            const uint64_t latest_ns = osal_clock_now_ns(&runtime->clock) + REAL_WAIT_MAX_NS;
            wake_ns                  = (wake_ns < latest_ns) ? wake_ns : latest_ns;
        }
        const status_t status = storage.is_remote_endian
                                    ? remote_endian_wait(&storage.remote, wake_ns)
                                    : osal_clock_wait(&runtime->clock, wake_ns, sockets, count);
        if ((status != STATUS_OK) || (osal_process_stop_count() > 0U)) {
            return status;
        }
        // Feed the watchdog only here, so that a step that hangs stops the feeding. The watchdog itself does
        // not detect a task of lower priority that hangs, so feed it only if none does.
        if (loop_tasks_are_alive(&storage.loop_tasks, osal_clock_now_ns(&runtime->clock))) {
            osal_watchdog_feed();
        }
        if (runtime->clock.mode == OSAL_CLOCK_REAL) {
            run_state_wake(runtime->run, runtime->component, osal_clock_now_ns(&runtime->clock));
        }
        component_runtime_pump(runtime, osal_clock_messages_due(&runtime->clock), instance->link_datagram,
                               instance->self);
        wake_ns = instance->step(instance->self, osal_clock_now_ns(&runtime->clock),
                                 osal_clock_octets_due(&runtime->clock));
        run_state_beat(runtime->run, runtime->component, osal_clock_now_ns(&runtime->clock), wake_ns);
        component_runtime_watch_supervisor(runtime, runtime->clock.scheduler,
                                           osal_clock_now_ns(&runtime->clock));
        follow_priority(executable, instance, &priority);
    }
}

int executive_run(const int argument_count, char* const arguments[], const char* const executable,
                  const component_open_t open, const component_descriptors_t* const descriptors)
{
    static const char usage[] = "usage: --run NAME --component INDEX (the launcher `hirosco run` starts it)";
    if (osal_console_introduce(argument_count, arguments, executable, usage)) {
        return 0;
    }
    storage.descriptors            = descriptors;
    const bool are_arguments_valid = (argument_count == 5) && (strcmp(arguments[1], "--run") == 0);
    const bool is_remote_endian    = are_arguments_valid && (strcmp(arguments[3], "--proxy") == 0);
    if (!is_remote_endian && (!are_arguments_valid || (strcmp(arguments[3], "--component") != 0))) {
        (void)report_error(executable, usage);
        return 2;
    }
    start_watchdog(executable, WATCHDOG_START_MS);
    osal_process_catch_stop();
    osal_process_ignore_interrupt();
    osal_lockstep_t* scheduler = NULL;
    const unsigned number      = number_of(arguments[4]);
    const char* const error =
        is_remote_endian ? join_by_proxy(number) : open_run(arguments[2], number, &scheduler);
    if (error != NULL) {
        return report_error(executable, error);
    }
    component_instance_t instance = {0};
    if (!open(&storage.runtime, &instance)) {
        return report_error(executable, storage.runtime.error);
    }
    if (!start_loop_tasks(&instance)) {
        return report_error(executable, "cannot start the tasks of its loops; raise `ulimit -u`");
    }
    note_memory(executable);
    // The promise of the earlier life is not valid.
    run_state_beat(storage.runtime.run, storage.runtime.component, 0U, OSAL_LOCKSTEP_NEVER);
    start_watchdog(executable, WATCHDOG_MS);
    const status_t status = loop(executable, &instance);
    osal_watchdog_stop();
    loop_tasks_stop(&storage.loop_tasks);
    instance.close(instance.self);
    if (storage.is_remote_endian) {
        remote_endian_leave(&storage.remote);
    }
    return ((status == STATUS_OK) || (status == STATUS_CLOSED))
               ? 0
               : report_error(executable, status_text(status));
}
