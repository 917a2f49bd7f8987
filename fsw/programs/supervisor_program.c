// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/file_store.h"
#include "fsw/programs/member.h"
#include "fsw/programs/program.h"
#include "fsw/programs/record_store.h"
#include "fsw/programs/store_files.h"
#include "base/text.h"
#include "fsw/framework/subsystem/fitting.h"
#include "fsw/supervisor/supervisor.h"
#include "fsw/supervisor/undo.h"
#include "generated/supervisor_services.h"
#include "osal/include/osal/console.h"

/// Of a process on a clock of its own, on a computer that others use as well.
#define REAL_LATENESS_NS 200000000ULL
#define SLOW_DISK_MS 100U
#define RECORDS_MAX 20480U ///< Lasting records: schedules, definitions, stores and files.

typedef struct {
    seat_t* seat;
    supervisor_t supervisor;
    subsystem_descriptor_t other; // The last order.
    record_store_t records;
    osal_directory_t files;
    store_files_t stores;
    supervisor_services_t services;
    journal_slot_t slots[JOURNAL_SLOTS(RECORDS_MAX)];
    osal_shm_t vitals;
    undo_medium_t journal_media[2];
    undo_medium_t guarded[ONBOARD_STORES];
    medium_t store_media[ONBOARD_STORES];
} supervisor_program_t;

static supervisor_program_t storage;
/// In the image its content outlives the supervisor.
static message_place_t inbox[MISSION_SUBSYSTEMS_MAX - 1U];

// ---- Platform: processes, by way of the launcher ----

static run_component_t* component_of(void* const context, const uint16_t apid)
{
    seat_t* const seat = (seat_t*)context;
    unsigned index     = 0U;
    return run_block_find(seat->run, apid, &index) ? &seat->run->components[index] : NULL;
}

/// In stepped time the calendar knows the running processes, otherwise the launcher.
static bool is_alive(const seat_t* const seat, const run_component_t* const component)
{
    if (seat->clock.mode == OSAL_CLOCK_STEPPED) {
        uint32_t life = 0U;
        return (osal_calendar_presence(seat->clock.calendar,
                                       run_participant((unsigned)(component - seat->run->components)),
                                       &life) != OSAL_CALENDAR_ABSENT) &&
               (life == component->life);
    }
    const unsigned index = (unsigned)(component - seat->run->components);
    const bool is_gone   = seat->peers[index].is_gone && (seat->peers[index].life == component->life);
    return (component->wanted_life == component->life) && !is_gone; // Not started yet, or running.
}

/// A start is a new life, from its declared time of booting on. What the launcher does about it shows only at
/// that instant.
static status_t start_process(void* const context, const uint16_t apid, const uint32_t link_floor,
                              const uint64_t boot_ns)
{
    seat_t* const seat               = (seat_t*)context;
    run_component_t* const component = component_of(context, apid);
    if (component == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (is_alive(seat, component)) {
        return STATUS_EXISTS;
    }
    const unsigned index = (unsigned)(component - seat->run->components);
    run_block_beat(seat->run, index, 0U, OSAL_CALENDAR_NEVER); // Until its first step.
    __atomic_store_n(&component->link_floor, link_floor, __ATOMIC_RELAXED);
    __atomic_store_n(&component->life, component->life + 1U, __ATOMIC_RELEASE);
    if (seat->clock.mode == OSAL_CLOCK_STEPPED) {
        osal_calendar_expect(seat->clock.calendar, run_participant(index), component->life,
                             osal_calendar_now_ns(seat->clock.calendar) + boot_ns);
    }
    __atomic_store_n(&component->wanted_life, component->life, __ATOMIC_RELEASE);
    return STATUS_OK;
}

static status_t stop_process(void* const context, const uint16_t apid)
{
    seat_t* const seat               = (seat_t*)context;
    run_component_t* const component = component_of(context, apid);
    if (component == NULL) {
        return STATUS_NOT_FOUND;
    }
    __atomic_store_n(&component->wanted_life, 0U, __ATOMIC_RELEASE);
    if (seat->clock.mode == OSAL_CLOCK_STEPPED) {
        osal_calendar_dismiss(seat->clock.calendar,
                              run_participant((unsigned)(component - seat->run->components)),
                              component->life);
    }
    return STATUS_OK;
}

static status_t kill_process(void* const context, const uint16_t apid)
{
    seat_t* const seat               = (seat_t*)context;
    run_component_t* const component = component_of(context, apid);
    if (component == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (seat->clock.mode == OSAL_CLOCK_STEPPED) {
        osal_calendar_kill(seat->clock.calendar,
                           run_participant((unsigned)(component - seat->run->components)), component->life);
    }
    __atomic_store_n(&component->kill_life, component->life, __ATOMIC_RELEASE);
    __atomic_store_n(&component->wanted_life, 0U, __ATOMIC_RELEASE);
    return STATUS_OK;
}

static bool is_running(void* const context, const uint16_t apid)
{
    const run_component_t* const component = component_of(context, apid);
    return (component != NULL) && is_alive((const seat_t*)context, component);
}

static uint64_t promise_of(void* const context, const uint16_t apid)
{
    const seat_t* const seat = (const seat_t*)context;
    unsigned index           = 0U;
    if (!run_block_find(seat->run, apid, &index)) {
        return OSAL_CALENDAR_NEVER;
    }
    const run_component_t* const component = &seat->run->components[index];
    if (__atomic_load_n(&component->hung_life, __ATOMIC_ACQUIRE) == component->life) {
        return 0U; // The launcher has seen it.
    }
    const run_beat_t beat = run_block_last_beat(seat->run, index);
    if (beat.wake_ns == OSAL_CALENDAR_NEVER) {
        return seat_promise_ns(seat, seat->clock.calendar, index); // It begins a life.
    }
    const bool is_late     = (seat->clock.mode == OSAL_CLOCK_REAL);
    const uint64_t told_ns = seat->peers[index].told_ns; // Its notices wake the supervisor.
    const uint64_t due_ns  = ((told_ns > beat.step_ns) && (told_ns < beat.wake_ns)) ? told_ns : beat.wake_ns;
    return is_late ? (due_ns + REAL_LATENESS_NS) : due_ns;
}

static bool is_stop_requested(void* const context)
{
    const seat_t* const seat = (const seat_t*)context;
    return __atomic_load_n(&seat->run->is_stop_requested, __ATOMIC_ACQUIRE) != 0U;
}

static void finished(void* const context)
{
    const seat_t* const seat = (const seat_t*)context;
    __atomic_store_n(&seat->run->is_finished, 1U, __ATOMIC_RELEASE);
    if (seat->clock.mode == OSAL_CLOCK_STEPPED) {
        osal_calendar_close(seat->clock.calendar); // Here and now: the run ends at a defined simulated time.
    }
}

// ---- Program ----

/// For the merge at the end: shows missing records after the last one it finds.
static void count_records(supervisor_program_t* const program)
{
    const uint64_t records = program->supervisor.log.next_number - 1U;
    __atomic_store_n(&program->seat->run->log_records, records, __ATOMIC_RELEASE);
}

/// A slow disk delayed the supervisor: reported on the console only, because it is wall-clock time.
static void tell_slow_disk(const supervisor_program_t* const program)
{
    char line[96];
    const uint64_t slowest_ms = program->supervisor.log.slowest_ns / 1000000U;
    if (slowest_ms >= SLOW_DISK_MS) {
        text_t text = text_in(line, sizeof line);
        text_add(&text, "supervisor: one write of the packet log took ");
        text_add_unsigned(&text, slowest_ms);
        text_add(&text, " ms");
        osal_console_complain(line);
    }
}

static uint64_t step(void* const context, const uint64_t now_ns, const uint32_t octets_due)
{
    (void)octets_due;
    supervisor_program_t* const program = (supervisor_program_t*)context;
    const uint64_t wake_ns              = supervisor_step(&program->supervisor, now_ns);
    count_records(program);
    return wake_ns;
}

static void close_program(void* const context)
{
    supervisor_program_t* const program = (supervisor_program_t*)context;
    if (program->seat->is_kept) { // It died in a program that continues.
        supervisor_abandon(&program->supervisor);
    } else {
        supervisor_close(&program->supervisor);
        count_records(program);
        tell_slow_disk(program);
    }
    store_files_close(&program->stores);
    record_store_close(&program->records);
    osal_directory_close(&program->files);
    if (osal_shm_address(&program->vitals) != NULL) {
        osal_shm_close(&program->vitals);
    }
}

static void no_link(void* const context, const uint8_t* const frame, const size_t size)
{
    (void)context;
    (void)frame;
    (void)size;
}

static bool is_fitting(seat_t* const seat)
{
    char path[RUN_PATH_MAX];
    const mission_subsystem_t* const subsystem = mission_find_subsystem(seat->mission, seat->apid);
    const bool is_same = descriptor_path(seat->run, subsystem->descriptor, path, sizeof path) &&
                         (descriptor_check_interface(&seat->reader->loader, path, seat->own,
                                                     SUPERVISOR_INTERFACE_HASH) == STATUS_OK);
    subsystem_misfit_t misfit = {0U, ""};
    const bool fits           = is_same && subsystem_fits(seat->own, supervisor_callbacks(), &misfit);
    if (is_same && !fits) {
        (void)descriptor_refuse(&seat->reader->loader, path, misfit.line, misfit.says);
    }
    if (!fits) {
        text_t text = text_in(seat->error, sizeof seat->error);
        text_add(&text, descriptor_error(&seat->reader->loader));
    }
    return fits;
}

static status_t load_descriptor(void* const context, const uint16_t index,
                                const subsystem_descriptor_t** const out_descriptor)
{
    const seat_t* const seat                   = (const seat_t*)context;
    const mission_subsystem_t* const subsystem = &seat->mission->subsystems[index];
    char path[RUN_PATH_MAX];
    *out_descriptor = &storage.other;
    if (subsystem->apid == seat->apid) {
        *out_descriptor = seat->own;
        return STATUS_OK;
    }
    return descriptor_path(seat->run, subsystem->descriptor, path, sizeof path)
               ? descriptor_load_subsystem(&seat->reader->loader, path, &storage.other)
               : STATUS_TOO_LARGE;
}

/// The folder of ST[23]; no path leaves it.
static bool open_files(seat_t* const seat)
{
    char path[RUN_PATH_MAX];
    text_t text = text_in(path, sizeof path);
    text_add(&text, seat->run->storage);
    text_add(&text, "/files");
    if (!text.cut && (osal_directory_create(path) == STATUS_OK) &&
        (osal_directory_open(&storage.files, path) == STATUS_OK)) {
        return true;
    }
    text = text_in(seat->error, sizeof seat->error);
    text_add(&text, "cannot open the folder of files ");
    text_add(&text, path);
    return false;
}

/// What the supervisor before has left; null: the launcher has made no such memory.
static vitals_t* open_vitals(const seat_t* const seat)
{
    char name[RUN_NAME_MAX];
    const bool is_open = run_name(seat->run, "vitals", 0U, name, sizeof name) &&
                         (osal_shm_open(&storage.vitals, name) == STATUS_OK);
    return (is_open && (osal_shm_size(&storage.vitals) >= sizeof(vitals_t)))
               ? (vitals_t*)osal_shm_address(&storage.vitals)
               : NULL;
}

static bool keep_vitals(void* const context, const vitals_t* const vitals)
{
    return record_store_keep((const seat_t*)context, "vitals", (const uint8_t*)vitals, sizeof *vitals);
}

#define FIRST_STORE 2U ///< Number of its medium, behind those of the journal.

static medium_t guard_journal(void* const context, const unsigned number, const medium_t medium)
{
    return undo_open(&storage.journal_media[number], (vitals_t*)context, (uint8_t)number, &medium);
}

static void guard_stores(vitals_t* const vitals)
{
    for (unsigned i = 0U; i < ONBOARD_STORES; i++) {
        storage.store_media[i] =
            undo_open(&storage.guarded[i], vitals, (uint8_t)(FIRST_STORE + i), &storage.stores.media[i]);
    }
}

static void note_arrival(void* const context, const uint8_t* const frame, const size_t size)
{
    vitals_t* const vitals = (vitals_t*)context;
    (void)vitals_add(vitals, &vitals->arrivals, frame, size, NULL, 0U);
}

/// Datagrams outlive the process: they stay in the socket until they are in the vitals.
static void keep_arrivals(seat_t* const seat, vitals_t* const vitals)
{
    if ((vitals != NULL) && osal_socket_is_open(&seat->message_socket)) {
        osal_socket_defer(&seat->message_socket);
        message_watch(&seat->endpoint, (message_arrival_t){vitals, note_arrival});
    }
}

bool supervisor_open(seat_t* const seat, program_t* const out_program)
{
    vitals_t* const vitals = open_vitals(seat);
    storage.records.guard  = (record_store_guard_t){vitals, guard_journal};
    if (!is_fitting(seat) || (seat_open_inbox(seat, inbox, MISSION_SUBSYSTEMS_MAX - 1U) != STATUS_OK) ||
        !open_files(seat) ||
        (record_store_open(&storage.records, seat, storage.slots, RECORDS_MAX, true) != STATUS_OK)) {
        return false;
    }
    if (store_files_open(&storage.stores, seat, ONBOARD_STORES) != STATUS_OK) {
        record_store_close(&storage.records);
        return false;
    }
    guard_stores(vitals);
    const supervisor_config_t config = {
        .mission             = seat->mission,
        .descriptor          = seat->own,
        .is_descriptor_valid = true,
        .endpoint            = &seat->endpoint,
        .platform            = {.context           = seat,
                                .start             = start_process,
                                .stop              = stop_process,
                                .kill              = kill_process,
                                .is_running        = is_running,
                                .promise           = promise_of,
                                .is_stop_requested = is_stop_requested,
                                .finished          = finished},
        .descriptors         = {seat, load_descriptor},
        .log_folder          = seat->run->folder,
        .has_log_writer      = seat->run->is_real,
        .start_count = __atomic_load_n(&seat->run->components[seat->component].found_life, __ATOMIC_ACQUIRE),
        .is_endpoint_kept = seat->is_kept,
        .files            = file_store(&storage.files),
        .journal          = &storage.records.journal,
        .optional         = {&storage.services, supervisor_add_services},
        .store_media      = storage.store_media,
        .log_records      = __atomic_load_n(&seat->run->log_records, __ATOMIC_ACQUIRE),
        .vitals           = vitals,
        .keep_vitals      = keep_vitals};
    const status_t status = supervisor_init(&storage.supervisor, &config);
    if (status != STATUS_OK) {
        text_t text = text_in(seat->error, sizeof seat->error);
        text_add(&text, "cannot open the packet log in ");
        text_add(&text, seat->run->folder);
        text_add(&text, ": ");
        text_add(&text, status_text(status));
        return false;
    }
    keep_arrivals(seat, vitals);
    storage.seat = seat;
    *out_program = (program_t){.self          = &storage,
                               .step          = step,
                               .link_datagram = no_link,
                               .close         = close_program,
                               .storage       = &storage,
                               .size          = sizeof storage};
    return true;
}
