// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/executive.h"

#include "fsw/programs/foreign.h"
#include "fsw/programs/loop_tasks.h"
#include "fsw/programs/program.h"
#include "base/text.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/task.h"

#include <string.h>

#define REAL_WAIT_MAX_NS 50000000ULL ///< Real time: look at least so often whether the run has ended.

typedef struct { // All storage that the program itself needs, in addition to its component's.
    seat_t seat;
    const mission_scope_t* scope;
    mission_descriptor_t mission;
    subsystem_descriptor_t own;
    seat_reader_t reader;
    osal_shm_t run_shm;
    osal_shm_t calendar_shm;
    loop_tasks_t loop_tasks;
    foreign_t foreign;
    bool is_foreign; // Takes part by way of a stand-in.
} executive_t;

static executive_t storage;

static int complain(const char* const executable, const char* const what)
{
    char line[SEAT_ERROR_MAX + 64U];
    text_t text = text_in(line, sizeof line);
    text_add(&text, executable);
    text_add(&text, ": ");
    text_add(&text, what);
    osal_console_complain(line);
    return 1;
}

/// Number of decimal text, or UINT32_MAX.
static unsigned number_of(const char* const digits)
{
    unsigned number = 0U;
    for (const char* next = digits; *next != '\0'; next++) {
        if ((*next < '0') || (*next > '9') || (number > 9999U)) {
            return UINT32_MAX;
        }
        number = (number * 10U) + (unsigned)(*next - '0');
    }
    return number;
}

/// Null, or what is wrong.
static const char* take_seat(run_block_t* const run, const unsigned component,
                             osal_calendar_t* const calendar)
{
    seat_reader_init(&storage.reader);
    if (descriptor_load_mission(&storage.reader.loader, run->mission_path, run->components[component].apid,
                                storage.scope, &storage.mission, &storage.own) != STATUS_OK) {
        return descriptor_error(&storage.reader.loader);
    }
    const seat_surroundings_t surroundings = {
        .run = run, .mission = &storage.mission, .reader = &storage.reader, .calendar = calendar};
    return (seat_take(&storage.seat, &surroundings, &storage.own, component) == STATUS_OK)
               ? NULL
               : storage.seat.error;
}

static const char* open_run(const char* const name, const unsigned component,
                            osal_calendar_t** const out_calendar)
{
    run_block_t* run = NULL;
    char calendar_name[RUN_NAME_MAX];
    *out_calendar = NULL;
    if (run_block_attach(&storage.run_shm, name, &run) != STATUS_OK) {
        return "there is no such run; programs of a mission are started by `hirosco run`";
    }
    if (component >= run->component_count) {
        return "the run has no such component";
    }
    if (run->is_stepped) {
        if (!run_name(run, "calendar", 0U, calendar_name, sizeof calendar_name) ||
            (osal_shm_open(&storage.calendar_shm, calendar_name) != STATUS_OK)) {
            return "the run's calendar is gone";
        }
        *out_calendar = osal_calendar_attach(osal_shm_address(&storage.calendar_shm));
    }
    return take_seat(run, component, *out_calendar);
}

/// Null, or what is wrong.
static const char* join_by_stand_in(const unsigned descriptor)
{
    foreign_t* const foreign = &storage.foreign;
    storage.is_foreign       = true;
    const status_t joined =
        (descriptor != UINT32_MAX) ? foreign_join(foreign, (int)descriptor) : STATUS_INVALID;
    if (joined != STATUS_OK) {
        return "the stand-in has sent no run; `hirosco run --foreign SUBSYSTEM` starts both";
    }
    const char* const error = take_seat(&foreign->run, foreign->component, NULL);
    if (error == NULL) {
        foreign_serve(foreign, &storage.seat);
    }
    return error;
}

/// In real time each service loop has its own task.
static bool start_loop_tasks(const program_t* const program)
{
    const seat_t* const seat = &storage.seat;
    return (seat->clock.mode != OSAL_CLOCK_REAL) || (program->component == NULL) ||
           (loop_tasks_start(&storage.loop_tasks, program->component, seat->run->origin_ns) == STATUS_OK);
}

/// Report on the console the real-time attributes that the system has not granted.
static void note_attributes(const char* const executable)
{
    const osal_clock_t* const clock = &storage.seat.clock;
    if (clock->mode != OSAL_CLOCK_REAL) {
        return;
    }
    if (!clock->attributes.is_memory_locked) {
        (void)complain(executable, "note: locked memory is not permitted here");
    }
    if (!clock->attributes.is_slack_minimal) {
        (void)complain(executable, "note: the timer slack cannot be reduced here");
    }
}

/// Where time is real, the loop runs at the priority that the descriptor gives it.
static void follow_priority(const char* const executable, const program_t* const program,
                            uint8_t* const priority)
{
    if ((storage.seat.clock.mode != OSAL_CLOCK_REAL) || (program->component == NULL)) {
        return;
    }
    const uint8_t wanted = component_priority(program->component);
    if (wanted == *priority) {
        return;
    }
    *priority = wanted;
    if ((osal_task_set_priority((int)wanted) != STATUS_OK) && (wanted > 0U)) {
        (void)complain(executable, "note: real-time priorities are not permitted here");
    }
}

/// Run until the end of the run, or until the process is asked to end. STATUS_OK, STATUS_CLOSED; others:
/// protocol error between the stand-in and this program.
static status_t loop(const char* const executable, const program_t* const program)
{
    seat_t* const seat = &storage.seat;
    uint64_t wake_ns   = 0U;
    uint8_t priority   = 0U;
    for (;;) {
        osal_socket_t* sockets[SEAT_SOCKETS_MAX];
        size_t count = seat_sockets(seat, sockets, SEAT_SOCKETS_MAX);
        if (program->sockets != NULL) {
            count += program->sockets(program->self, &sockets[count], SEAT_SOCKETS_MAX - count);
        }
        if (seat->clock.mode == OSAL_CLOCK_REAL) {
            const uint64_t latest_ns = osal_clock_now_ns(&seat->clock) + REAL_WAIT_MAX_NS;
            wake_ns                  = (wake_ns < latest_ns) ? wake_ns : latest_ns;
        }
        const status_t status = storage.is_foreign ? foreign_wait(&storage.foreign, wake_ns)
                                                   : osal_clock_wait(&seat->clock, wake_ns, sockets, count);
        if ((status != STATUS_OK) || (osal_process_stop_count() > 0U)) {
            return status;
        }
        if (seat->clock.mode == OSAL_CLOCK_REAL) {
            run_block_wake(seat->run, seat->component, osal_clock_now_ns(&seat->clock));
        }
        seat_pump(seat, osal_clock_messages_due(&seat->clock), program->link_datagram, program->self);
        wake_ns = program->step(program->self, osal_clock_now_ns(&seat->clock),
                                osal_clock_octets_due(&seat->clock));
        run_block_beat(seat->run, seat->component, osal_clock_now_ns(&seat->clock), wake_ns);
        seat_watch_supervisor(seat, seat->clock.calendar, osal_clock_now_ns(&seat->clock));
        follow_priority(executable, program, &priority);
    }
}

int executive_main(const int argument_count, char* const arguments[], const char* const executable,
                   const program_open_t open, const mission_scope_t* const scope)
{
    static const char usage[] = "usage: --run NAME --component INDEX (the launcher `hirosco run` starts it)";
    if (osal_console_introduce(argument_count, arguments, executable, usage)) {
        return 0;
    }
    storage.scope             = scope;
    const bool is_well_called = (argument_count == 5) && (strcmp(arguments[1], "--run") == 0);
    const bool is_foreign     = is_well_called && (strcmp(arguments[3], "--stand-in") == 0);
    if (!is_foreign && (!is_well_called || (strcmp(arguments[3], "--component") != 0))) {
        (void)complain(executable, usage);
        return 2;
    }
    osal_process_catch_stop();
    osal_process_ignore_interrupt();
    osal_calendar_t* calendar = NULL;
    const unsigned number     = number_of(arguments[4]);
    const char* const error =
        is_foreign ? join_by_stand_in(number) : open_run(arguments[2], number, &calendar);
    if (error != NULL) {
        return complain(executable, error);
    }
    program_t program = {0};
    if (!open(&storage.seat, &program)) {
        return complain(executable, storage.seat.error);
    }
    if (!start_loop_tasks(&program)) {
        return complain(executable, "cannot start the tasks of its loops");
    }
    note_attributes(executable);
    run_block_beat(storage.seat.run, storage.seat.component, 0U,
                   OSAL_CALENDAR_NEVER); // Its earlier life's counts no more.
    const status_t status = loop(executable, &program);
    loop_tasks_stop(&storage.loop_tasks);
    program.close(program.self);
    if (storage.is_foreign) {
        foreign_leave(&storage.foreign);
    }
    return ((status == STATUS_OK) || (status == STATUS_CLOSED)) ? 0
                                                                : complain(executable, status_text(status));
}
