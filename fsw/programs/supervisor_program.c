// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/file_store.h"
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/programs/record_store.h"
#include "fsw/programs/store_files.h"
#include "base/text.h"
#include "fsw/framework/subsystem/fitting.h"
#include "fsw/supervisor/supervisor.h"
#include "fsw/supervisor/undo.h"
#include "generated/supervisor_services.h"
#include "osal/include/osal/console.h"

/// Permitted lateness of a step in real time: other programs also use the computer.
#define REAL_LATENESS_NS 200000000ULL
#define SLOW_DISK_MS 100U ///< A write to the packet log that takes at least this long is reported.
/// Largest number of persistent records: schedules, definitions, stores and files.
#define RECORDS_MAX 20480U

typedef struct {
    component_runtime_t* runtime;
    supervisor_t supervisor;
    record_store_t records;
    osal_directory_t files;
    store_files_t stores;
    supervisor_services_t services;
    journal_slot_t slots[JOURNAL_SLOTS(RECORDS_MAX)];
    osal_shm_t checkpoint;
    undo_medium_t journal_media[2];
    undo_medium_t wrapped[SPACECRAFT_STORES];
    medium_t store_media[SPACECRAFT_STORES];
} supervisor_program_t;

static supervisor_program_t storage;
/// Messages to the supervisor. In the image (all components in one process) they are kept when the
/// supervisor restarts.
static message_slot_t inbox[MISSION_SUBSYSTEMS_MAX - 1U];

// ---- Platform: processes, which the launcher starts and ends ----

static run_component_t* component_of(void* const context, const uint16_t apid)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    unsigned index                     = 0U;
    return run_state_find(runtime->run, apid, &index) ? &runtime->run->components[index] : NULL;
}

/// True if the process of a component runs. In stepped time the scheduler decides this, otherwise the
/// launcher.
static bool is_alive(const component_runtime_t* const runtime, const run_component_t* const component)
{
    if (runtime->clock.mode == OSAL_CLOCK_STEPPED) {
        uint32_t life = 0U;
        return (osal_lockstep_presence(runtime->clock.scheduler,
                                       run_participant((unsigned)(component - runtime->run->components)),
                                       &life) != OSAL_LOCKSTEP_ABSENT) &&
               (life == component->life);
    }
    const unsigned index = (unsigned)(component - runtime->run->components);
    const bool is_gone   = runtime->peers[index].is_gone && (runtime->peers[index].life == component->life);
    return (component->wanted_life == component->life) && !is_gone; // The process is being started, or runs.
}

/// Command a new life of a component; the launcher then starts the process. In stepped time the life begins
/// `boot_ns` from now, independent of the wall-clock time that the launcher needs.
static status_t start_process(void* const context, const uint16_t apid, const uint32_t link_floor,
                              const uint64_t boot_ns)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    run_component_t* const component   = component_of(context, apid);
    if (component == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (is_alive(runtime, component)) {
        return STATUS_EXISTS;
    }
    const unsigned index = (unsigned)(component - runtime->run->components);
    // No promise is valid before the first step.
    run_state_beat(runtime->run, index, 0U, OSAL_LOCKSTEP_NEVER);
    // The order of the stores matters: a reader of the new life must also read its link floor, and the
    // launcher must start the process only when the scheduler expects it.
    __atomic_store_n(&component->link_floor, link_floor, __ATOMIC_RELAXED);
    __atomic_store_n(&component->life, component->life + 1U, __ATOMIC_RELEASE);
    if (runtime->clock.mode == OSAL_CLOCK_STEPPED) {
        osal_lockstep_expect(runtime->clock.scheduler, run_participant(index), component->life,
                             osal_lockstep_now_ns(runtime->clock.scheduler) + boot_ns);
    }
    __atomic_store_n(&component->wanted_life, component->life, __ATOMIC_RELEASE);
    return STATUS_OK;
}

static status_t stop_process(void* const context, const uint16_t apid)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    run_component_t* const component   = component_of(context, apid);
    if (component == NULL) {
        return STATUS_NOT_FOUND;
    }
    __atomic_store_n(&component->wanted_life, 0U, __ATOMIC_RELEASE);
    if (runtime->clock.mode == OSAL_CLOCK_STEPPED) {
        osal_lockstep_dismiss(runtime->clock.scheduler,
                              run_participant((unsigned)(component - runtime->run->components)),
                              component->life);
    }
    return STATUS_OK;
}

static status_t kill_process(void* const context, const uint16_t apid)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    run_component_t* const component   = component_of(context, apid);
    if (component == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (runtime->clock.mode == OSAL_CLOCK_STEPPED) {
        osal_lockstep_kill(runtime->clock.scheduler,
                           run_participant((unsigned)(component - runtime->run->components)),
                           component->life);
    }
    __atomic_store_n(&component->kill_life, component->life, __ATOMIC_RELEASE);
    __atomic_store_n(&component->wanted_life, 0U, __ATOMIC_RELEASE);
    return STATUS_OK;
}

static bool is_running(void* const context, const uint16_t apid)
{
    const run_component_t* const component = component_of(context, apid);
    return (component != NULL) && is_alive((const component_runtime_t*)context, component);
}

/// Returns the time until which a component must have made a step; 0 if it hangs.
static uint64_t promise_of(void* const context, const uint16_t apid)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    unsigned index                           = 0U;
    if (!run_state_find(runtime->run, apid, &index)) {
        return OSAL_LOCKSTEP_NEVER;
    }
    const run_component_t* const component = &runtime->run->components[index];
    if (__atomic_load_n(&component->hung_life, __ATOMIC_ACQUIRE) == component->life) {
        return 0U; // The launcher has detected that the process hangs.
    }
    const run_beat_t beat = run_state_last_beat(runtime->run, index);
    if (beat.wake_ns == OSAL_LOCKSTEP_NEVER) {
        // The life has made no step yet.
        return component_runtime_promise_ns(runtime, runtime->clock.scheduler, index);
    }
    const bool is_late = (runtime->clock.mode == OSAL_CLOCK_REAL);
    // A message makes the component step before the promised time.
    const uint64_t reported_ns = runtime->peers[index].reported_ns;
    const uint64_t due_ns =
        ((reported_ns > beat.step_ns) && (reported_ns < beat.wake_ns)) ? reported_ns : beat.wake_ns;
    return is_late ? (due_ns + REAL_LATENESS_NS) : due_ns;
}

static bool is_stop_requested(void* const context)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    return __atomic_load_n(&runtime->run->is_stop_requested, __ATOMIC_ACQUIRE) != 0U;
}

static void finished(void* const context)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    __atomic_store_n(&runtime->run->is_finished, 1U, __ATOMIC_RELEASE);
    if (runtime->clock.mode == OSAL_CLOCK_STEPPED) {
        // The scheduler is closed within this step, so that the run ends at a defined simulated time.
        osal_lockstep_close(runtime->clock.scheduler);
    }
}

// ---- Program ----

/// Publish the number of records. At the end of the run the merge of the packet log compares it with the
/// files, to detect that the last records are missing.
static void count_records(supervisor_program_t* const program)
{
    const uint64_t records = program->supervisor.log.next_number - 1U;
    __atomic_store_n(&program->runtime->run->log_records, records, __ATOMIC_RELEASE);
}

/// Report the slowest write to the packet log on the console, if it was slow. It is not telemetry, because
/// telemetry must not depend on wall-clock time.
static void print_slow_disk(const supervisor_program_t* const program)
{
    char line[96];
    const uint64_t slowest_ms = program->supervisor.log.slowest_ns / 1000000U;
    if (slowest_ms >= SLOW_DISK_MS) {
        text_t text = text_in(line, sizeof line);
        text_add(&text, "supervisor: one write of the packet log took ");
        text_add_unsigned(&text, slowest_ms);
        text_add(&text, " ms");
        osal_console_print_error(line);
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
    if (program->runtime->is_kept) { // The component has died, but the program and its channels continue.
        supervisor_abandon(&program->supervisor);
    } else {
        supervisor_close(&program->supervisor);
        count_records(program);
        print_slow_disk(program);
    }
    store_files_close(&program->stores);
    record_store_close(&program->records);
    osal_directory_close(&program->files);
    if (osal_shm_address(&program->checkpoint) != NULL) {
        osal_shm_close(&program->checkpoint);
    }
}

static void no_link(void* const context, const uint8_t* const frame, const size_t size)
{
    (void)context;
    (void)frame;
    (void)size;
}

/// Check that the supervisor's descriptor fits this program. If not, the runtime contains the error text.
static bool is_fitting(component_runtime_t* const runtime)
{
    char path[RUN_PATH_MAX];
    const mission_subsystem_t* const subsystem =
        descriptor_mission_find_subsystem(runtime->mission, runtime->apid);
    text_t error = text_in(runtime->error, sizeof runtime->error);
    const bool is_same =
        (descriptor_path_of(&error, runtime->run->mission_path, subsystem, path, sizeof path) == STATUS_OK) &&
        (descriptor_check_interface(&error, path, runtime->own, SUPERVISOR_INTERFACE_HASH) == STATUS_OK);
    subsystem_misfit_t misfit = {0U, "", 0U};
    const bool fits           = is_same && subsystem_fits(runtime->own, supervisor_callbacks(), &misfit);
    if (is_same && !fits) {
        (void)descriptor_refuse(&error, path, misfit.line, misfit.reason, misfit.most);
    }
    return fits;
}

/// Load the descriptor of a subsystem; it is valid until the next call. The supervisor's own is already
/// loaded.
static status_t load_descriptor(void* const context, const uint16_t index,
                                const subsystem_descriptor_t** const out_descriptor)
{
    const component_runtime_t* const runtime   = (const component_runtime_t*)context;
    const mission_subsystem_t* const subsystem = &runtime->mission->subsystems[index];
    subsystem_descriptor_t* other              = NULL;
    char path[RUN_PATH_MAX];
    char refusal[DESCRIPTOR_ERROR_CHARACTERS];
    text_t error    = text_in(refusal, sizeof refusal);
    *out_descriptor = runtime->own;
    if (subsystem->apid == runtime->apid) {
        return STATUS_OK;
    }
    status_t status = descriptor_path_of(&error, runtime->run->mission_path, subsystem, path, sizeof path);
    if (status == STATUS_OK) {
        status = runtime->descriptors->read(runtime->descriptors->context, path, &other, &error);
    }
    // Descriptors that are compiled into the program are not read.
    if ((status != STATUS_OK) && (status != STATUS_UNSUPPORTED)) {
        osal_console_print_error(refusal);
    }
    *out_descriptor = other;
    return status;
}

/// Open the directory of the files of ST[23]; paths cannot refer to files outside of it.
static bool open_files(component_runtime_t* const runtime)
{
    char path[RUN_PATH_MAX];
    text_t text = text_in(path, sizeof path);
    text_add(&text, runtime->run->storage);
    text_add(&text, "/files");
    if (!text.cut && (osal_file_create_directory(path) == STATUS_OK) &&
        (osal_directory_open(&storage.files, path) == STATUS_OK)) {
        return true;
    }
    text = text_in(runtime->error, sizeof runtime->error);
    text_add(&text, "cannot open the directory of files ");
    text_add(&text, path);
    text_add(&text, "; choose another directory with --storage");
    return false;
}

/// Returns the checkpoint of the previous supervisor; null if the launcher has not created this memory, or
/// it is too small.
static checkpoint_t* open_checkpoint(const component_runtime_t* const runtime)
{
    char name[RUN_NAME_MAX];
    const bool is_open = run_name(runtime->run, "checkpoint", 0U, name, sizeof name) &&
                         (osal_shm_open(&storage.checkpoint, name) == STATUS_OK);
    return (is_open && (osal_shm_size(&storage.checkpoint) >= sizeof(checkpoint_t)))
               ? (checkpoint_t*)osal_shm_address(&storage.checkpoint)
               : NULL;
}

static bool keep_checkpoint(void* const context, const checkpoint_t* const checkpoint)
{
    return record_store_keep((const component_runtime_t*)context, "checkpoint", (const uint8_t*)checkpoint,
                             sizeof *checkpoint);
}

#define FIRST_STORE 2U ///< Medium number of the first packet store; the journal's media are 0 and 1.

/// Wrap a medium of the journal: the writes of an incomplete step are undone after a restart.
static medium_t wrap_journal(void* const context, const unsigned number, const medium_t medium)
{
    return supervisor_undo_open(&storage.journal_media[number], (checkpoint_t*)context, (uint8_t)number,
                                &medium);
}

static void wrap_stores(checkpoint_t* const checkpoint)
{
    for (unsigned i = 0U; i < SPACECRAFT_STORES; i++) {
        storage.store_media[i] = supervisor_undo_open(&storage.wrapped[i], checkpoint,
                                                      (uint8_t)(FIRST_STORE + i), &storage.stores.media[i]);
    }
}

/// Copy an arrived frame to the checkpoint.
static void note_arrival(void* const context, const uint8_t* const frame, const size_t size)
{
    checkpoint_t* const checkpoint = (checkpoint_t*)context;
    (void)supervisor_checkpoint_add(checkpoint, &checkpoint->arrivals, frame, size, NULL, 0U);
}

/// Let each datagram stay in the socket until it is in the checkpoint, so that the death of the process
/// loses none.
static void keep_arrivals(component_runtime_t* const runtime, checkpoint_t* const checkpoint)
{
    if ((checkpoint != NULL) && osal_socket_is_open(&runtime->message_socket)) {
        osal_socket_defer(&runtime->message_socket);
        message_watch(&runtime->endpoint, (message_arrival_t){checkpoint, note_arrival});
    }
}

bool supervisor_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    checkpoint_t* const checkpoint = open_checkpoint(runtime);
    storage.records.wrapper        = (record_store_wrapper_t){checkpoint, wrap_journal};
    if (!is_fitting(runtime) ||
        (component_runtime_open_inbox(runtime, inbox, MISSION_SUBSYSTEMS_MAX - 1U) != STATUS_OK) ||
        !open_files(runtime) ||
        (record_store_open(&storage.records, runtime, storage.slots, RECORDS_MAX, true) != STATUS_OK)) {
        return false;
    }
    if (store_files_open(&storage.stores, runtime, SPACECRAFT_STORES) != STATUS_OK) {
        record_store_close(&storage.records);
        return false;
    }
    wrap_stores(checkpoint);
    const supervisor_config_t config = {
        .mission             = runtime->mission,
        .descriptor          = runtime->own,
        .is_descriptor_valid = true,
        .endpoint            = &runtime->endpoint,
        .platform            = {.context           = runtime,
                                .start             = start_process,
                                .stop              = stop_process,
                                .kill              = kill_process,
                                .is_running        = is_running,
                                .promise           = promise_of,
                                .is_stop_requested = is_stop_requested,
                                .finished          = finished},
        .descriptors         = {runtime, load_descriptor},
        .log_directory       = runtime->run->directory,
        .has_log_writer      = runtime->run->is_real,
        .start_count =
            __atomic_load_n(&runtime->run->components[runtime->component].found_life, __ATOMIC_ACQUIRE),
        .is_endpoint_kept = runtime->is_kept,
        .files            = file_store(&storage.files),
        .journal          = &storage.records.journal,
        .optional         = {&storage.services, supervisor_add_services},
        .store_media      = storage.store_media,
        .log_records      = __atomic_load_n(&runtime->run->log_records, __ATOMIC_ACQUIRE),
        .checkpoint       = checkpoint,
        .keep_checkpoint  = keep_checkpoint};
    const status_t status = supervisor_init(&storage.supervisor, &config);
    if (status != STATUS_OK) {
        text_t text = text_in(runtime->error, sizeof runtime->error);
        text_add(&text, "cannot open the packet log in ");
        text_add(&text, runtime->run->directory);
        text_add(&text, ": ");
        text_add(&text, status_text(status));
        text_add(&text, "; choose another one with --out");
        return false;
    }
    keep_arrivals(runtime, checkpoint);
    storage.runtime = runtime;
    *out_instance   = (component_instance_t){.self          = &storage,
                                             .step          = step,
                                             .link_datagram = no_link,
                                             .close         = close_program,
                                             .storage       = &storage,
                                             .size          = sizeof storage};
    return true;
}
