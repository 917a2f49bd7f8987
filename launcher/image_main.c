// SPDX-License-Identifier: Apache-2.0
// The image: all flight components and the simulator in one address space. One loop runs them in order;
// messages pass through rings in memory. The launcher starts the image instead of the processes.
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/programs/descriptor_files.h"
#include "launcher/launcher_relay.h"
#include "launcher/return_budget.h"
#include "base/assertion.h"
#include "base/number.h"
#include "base/text.h"
#include "base/take_check.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/process.h"
#include "sim/app/losses.h"
#include "sim/app/process_faults.h"
#include "sim/app/simulator.h"
#include "sim/clock/cosimulation_port.h"

#include <string.h>

CAPACITY_CHECK(simulator_has_all_buses, SIMULATOR_BUSES_MAX >= MISSION_BUSES_MAX);

/// Time for which the operator's client may be silent [ms]; longer than the launcher waits until simulated
/// time advances.
#define COSIMULATION_PORT_TIMEOUT_MS 200000U
/// Time for which the image waits for the operator to join: 180 s, in rounds after each of which it checks
/// whether the run must end.
#define COSIMULATION_PORT_ROUND_MS 100U
#define COSIMULATION_PORT_ROUNDS 1800U

typedef struct { // Storage of the image in addition to that of its components.
    run_state_t* run;
    osal_shm_t run_shm;
    osal_shm_t scheduler_shm;
    osal_lockstep_t* scheduler;
    mission_descriptor_t mission;
    descriptor_files_t files; // Descriptor files, from which each component loads its own descriptor.
    component_descriptors_t descriptors;
    component_play_outs_t play_outs;
    launcher_relay_t relay;
    message_ring_carrier_t ring_carrier;
    component_runtime_t runtimes[MISSION_SUBSYSTEMS_MAX];
    subsystem_descriptor_t own[MISSION_SUBSYSTEMS_MAX];
    component_instance_t programs[MISSION_SUBSYSTEMS_MAX];
    bool is_open[MISSION_SUBSYSTEMS_MAX];
    process_faults_t process_faults;
    simulator_t* simulator;
    cosimulation_port_t cosimulation;
    bool has_cosimulation;
    // Participant of the communication component, which receives the octets that the operator sends.
    unsigned communication;
    return_budget_t returns;
    uint64_t abandon_ns; // Time at which a run without supervisor ends; 0: the run has a supervisor.
    unsigned running;    // Participant that holds the grant.
    char error[SIMULATOR_ERROR_MAX];
} image_t;

typedef struct {
    const char* run;
    const char* scenario;
    const char* world;
    const char* cosimulation;
    uint64_t seed;
} image_options_t;

static image_t image;

static int report_error(const char* const what)
{
    char line[SIMULATOR_ERROR_MAX + 16U];
    (void)text_join(line, sizeof line, (const char* const[]){"image: ", what, NULL});
    osal_console_print_error(line);
    return 1;
}

/// Wake component `to`, because the running component has put a frame into its inbox.
static void delivered(void* const context, const uint16_t to)
{
    image_t* const self = (image_t*)context;
    unsigned component  = 0U;
    if (run_state_find(self->run, to, &component)) {
        FSW_ASSERT(self->running > RUN_SIMULATOR); // Components send only in their own turns.
        component_runtime_note_sent(&self->runtimes[self->running - 1U], component,
                                    osal_lockstep_now_ns(self->scheduler));
        // The delivery of 0 octets only wakes the receiver: the frame is already in its inbox.
        osal_lockstep_deliver(self->scheduler, self->running, run_participant(component),
                              component_runtime_life_of(&self->runtimes[self->running - 1U], component), 0U,
                              0U);
    }
}

// ---- Assembly ----

static const char* attach(image_t* const self, const char* const run_name_text)
{
    char name[RUN_NAME_MAX];
    if ((run_state_attach(&self->run_shm, run_name_text, &self->run) != STATUS_OK) ||
        !run_name(self->run, "scheduler", 0U, name, sizeof name) ||
        (osal_shm_open(&self->scheduler_shm, name) != STATUS_OK)) {
        return "there is no such run; the image is started by `hirosco run --form image`";
    }
    self->scheduler   = osal_lockstep_attach(osal_shm_address(&self->scheduler_shm));
    self->descriptors = descriptor_files(&self->files, &descriptor_mission_whole);
    if (descriptor_load_mission(&self->files.loader, self->run->mission_path, MISSION_ANY_TARGET,
                                &descriptor_mission_whole, &self->mission, &self->own[0]) != STATUS_OK) {
        return descriptor_error(&self->files.loader);
    }
    return (self->scheduler == NULL)
               ? "the run's scheduler is of another version; build all programs with `make`"
               : NULL;
}

static component_runtime_surroundings_t surroundings_of(image_t* const self)
{
    return (component_runtime_surroundings_t){.run          = self->run,
                                              .mission      = &self->mission,
                                              .descriptors  = &self->descriptors,
                                              .play_outs    = &self->play_outs,
                                              .scheduler    = self->scheduler,
                                              .ring_carrier = &self->ring_carrier};
}

/// Open a component, which loads its descriptor into `own`. Returns null, or the error text.
static const char* open_component(image_t* const self, const unsigned index,
                                  subsystem_descriptor_t* const own)
{
    const component_runtime_surroundings_t surroundings = surroundings_of(self);
    char path[RUN_PATH_MAX];
    text_t error = text_in(self->runtimes[index].error, sizeof self->runtimes[index].error);
    if (descriptor_path_of(&error, self->run->mission_path, &self->mission.subsystems[index], path,
                           sizeof path) != STATUS_OK) {
        return self->runtimes[index].error;
    }
    if (descriptor_load_subsystem(&self->files.loader, path, own) != STATUS_OK) {
        return descriptor_error(&self->files.loader);
    }
    if (!self->runtimes[index].is_kept &&
        (component_runtime_take(&self->runtimes[index], &surroundings, own, index) != STATUS_OK)) {
        return self->runtimes[index].error;
    }
    const component_open_t open = component_find(self->mission.subsystems[index].executable);
    if (open == NULL) {
        return "the image contains no program for one of the mission's executables; use --form processes";
    }
    if (!open(&self->runtimes[index], &self->programs[index])) {
        return self->runtimes[index].error;
    }
    self->is_open[index] = true;
    return NULL;
}

static const char* open_components(image_t* const self)
{
    message_ring_carrier_init(&self->ring_carrier, (message_delivery_notice_t){self, delivered});
    for (unsigned i = 0U; i < self->run->component_count; i++) {
        const char* const error = open_component(self, i, &self->own[i]);
        if (error != NULL) {
            return error;
        }
        if (self->runtimes[i].apid == COMMUNICATION_APID) {
            self->communication = run_participant(i);
        }
    }
    return NULL;
}

// ---- Lives ----

/// Close all objects that a component has opened, as the end of its process would.
static void close_component(image_t* const self, const unsigned index)
{
    if (self->is_open[index]) {
        self->programs[index].close(self->programs[index].self);
        component_runtime_leave(&self->runtimes[index]);
        self->is_open[index] = false;
    }
}

/// Close the components whose life has ended in the last turn.
static void close_ended(image_t* const self)
{
    for (unsigned i = 0U; i < self->run->component_count; i++) {
        if (!osal_lockstep_is_present(self->scheduler, run_participant(i))) {
            if (self->run->components[i].apid == SUPERVISOR_APID) {
                // The channels of the supervisor continue in its next life.
                component_runtime_keep(&self->runtimes[i]);
            }
            close_component(self, i);
        }
    }
}

/// True if the supervisor may start again, because its budget is not used up. Takes one start from the
/// budget.
static bool may_return(image_t* const self)
{
    const uint64_t now_ns = osal_lockstep_now_ns(self->scheduler);
    uint64_t delay_ns     = 0U; // Delay in wall-clock time, which the image does not use.
    const bool may        = return_budget_take(&self->returns, now_ns, &delay_ns);
    if (!may) {
        self->abandon_ns = now_ns + RETURN_ABANDON_NS;
        (void)report_error(
            "the supervisor has died too often; subsystems go to their safe state on their own");
    }
    return may;
}

/// End a participant for the rest of the run: it has no successor.
static void give_up(image_t* const self, const unsigned participant)
{
    osal_lockstep_set_succession(self->scheduler, participant, 0U);
    osal_lockstep_end(self->scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE);
}

/// Begin a life of a component. Its storage is cleared, as in a new process.
static void begin_life(image_t* const self, const unsigned participant)
{
    const unsigned index              = participant - 1U;
    run_component_t* const component  = &self->run->components[index];
    subsystem_descriptor_t* const own = self->runtimes[index].own;
    uint32_t life                     = 0U;
    FSW_ASSERT(!self->is_open[index] && (index < self->run->component_count));
    if ((component->apid == SUPERVISOR_APID) && !may_return(self)) {
        give_up(self, participant);
        return;
    }
    (void)osal_lockstep_presence(self->scheduler, participant, &life);
    __atomic_store_n(&component->found_life, life, __ATOMIC_RELEASE);
    (void)memset(self->programs[index].storage, 0, self->programs[index].size);
    const char* const error = open_component(self, index, own);
    if (error != NULL) {
        (void)report_error(error);
        give_up(self, participant);
        return;
    }
    // The beat of the earlier life is no longer valid.
    run_state_beat(self->run, index, 0U, OSAL_LOCKSTEP_NEVER);
    osal_lockstep_done(self->scheduler, participant, 0U);
}

static const char* open_simulator(image_t* const self, const image_options_t* const options)
{
    static const char* const others[] = {"launcher", "image", "operator", "packet-archive-sqlite"};
    self->process_faults.scheduler    = self->scheduler;
    for (uint16_t i = 0U; i < self->mission.subsystem_count; i++) {
        const mission_subsystem_t* const subsystem = &self->mission.subsystems[i];
        const bool is_named =
            process_faults_name(&self->process_faults, subsystem->executable, run_participant(i)) &&
            process_faults_name(&self->process_faults, subsystem->name, run_participant(i));
        FSW_ASSERT(is_named); // The table has a slot for each participant of the scheduler.
    }
    for (size_t i = 0U; i < (sizeof others / sizeof others[0]); i++) {
        FSW_ASSERT(process_faults_name(&self->process_faults, others[i], PROCESS_FAULTS_OTHER));
    }
    simulator_config_t config = {.process_fault     = process_faults_act,
                                 .process_check     = process_faults_check,
                                 .process_context   = &self->process_faults,
                                 .scenario_path     = options->scenario,
                                 .world_path        = options->world,
                                 .output_path       = self->run->directory,
                                 .flows             = self->run->identity,
                                 .are_flows_counted = true,
                                 .seed              = options->seed};
    for (uint16_t i = 0U; (i < self->mission.bus_count) && (i < SIMULATOR_BUSES_MAX); i++) {
        const char* const channel_a = self->mission.buses[i].redundant_to;
        const run_bus_t* const bus  = &self->run->buses[i];
        const bool is_channel_b     = (channel_a[0] != '\0') && (bus->simulator[0] != '\0');
        config.bus[i]               = (simulator_bus_t){.name          = self->mission.buses[i].name,
                                                        .address       = bus->simulator,
                                                        .published     = bus->published,
                                                        .bit_rate      = self->mission.buses[i].bit_rate,
                                                        .data_bit_rate = self->mission.buses[i].data_bit_rate,
                                                        .redundant_to  = is_channel_b ? channel_a : NULL};
        config.bus_count++;
    }
    return (simulator_open(&config, &self->simulator, self->error) == STATUS_OK) ? NULL : self->error;
}

static bool is_stop_requested(const image_t* const self)
{
    return __atomic_load_n(&self->run->is_stop_requested, __ATOMIC_ACQUIRE) != 0U;
}

static const char* open_cosimulation(image_t* const self, const char* const path)
{
    const unsigned participant = run_operator(self->run);
    if (path == NULL) {
        return NULL;
    }
    if (cosimulation_port_open(&self->cosimulation, path, "operator", self->scheduler,
                               COSIMULATION_PORT_TIMEOUT_MS) != STATUS_OK) {
        return "cannot open the operator's co-simulation port in /dev/shm; is it full?";
    }
    self->has_cosimulation = true;
    status_t status        = STATUS_TIMEOUT;
    for (unsigned i = 0U;
         (status == STATUS_TIMEOUT) && (i < COSIMULATION_PORT_ROUNDS) && !is_stop_requested(self); i++) {
        status = cosimulation_port_accept(&self->cosimulation, COSIMULATION_PORT_ROUND_MS);
    }
    if ((status == STATUS_TIMEOUT) && is_stop_requested(self)) {
        // The operator ended before it joined: shut the mission down.
        osal_lockstep_end(self->scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE);
        return NULL;
    }
    if (status != STATUS_OK) {
        return "the operator did not join; see console.log for its error";
    }
    osal_lockstep_set_stream_port(self->scheduler, participant, self->cosimulation.stream_port);
    osal_lockstep_done(self->scheduler, participant, 0U);
    return NULL;
}

// ---- Loop ----

static void run_operator_turn(image_t* const self, const osal_grant_t* const grant)
{
    const unsigned participant = run_operator(self->run);
    uint64_t wake_ns           = OSAL_LOCKSTEP_NEVER;
    if (cosimulation_port_turn(&self->cosimulation, self->scheduler, participant, self->communication, grant,
                               &wake_ns) == STATUS_OK) {
        osal_lockstep_done(self->scheduler, participant, wake_ns);
    } else {
        __atomic_store_n(&self->run->has_operator_left, 1U, __ATOMIC_RELEASE);
    }
}

static void run_component(image_t* const self, const unsigned participant, const osal_grant_t* const grant)
{
    const unsigned component                  = participant - 1U;
    const component_instance_t* const program = &self->programs[component];
    component_runtime_pump(&self->runtimes[component], grant->messages, program->link_datagram,
                           program->self);
    const uint64_t wake_ns = program->step(program->self, grant->now_ns, grant->octets);
    run_state_beat(self->run, component, grant->now_ns, wake_ns);
    component_runtime_watch_supervisor(&self->runtimes[component], self->scheduler, grant->now_ns);
    osal_lockstep_done(self->scheduler, participant, wake_ns);
}

/// Step the components until the supervisor or the launcher has closed the scheduler.
static void loop(image_t* const self)
{
    osal_lockstep_done(self->scheduler, RUN_SIMULATOR, 0U);
    for (unsigned i = 0U; i < self->run->component_count; i++) {
        osal_lockstep_done(self->scheduler, run_participant(i), 0U);
    }
    if (self->run->relay.delay_us > 0U) {
        osal_lockstep_done(self->scheduler, run_relay(self->run), 0U);
    }
    while ((osal_process_stop_count() == 0U) &&
           ((self->abandon_ns == 0U) || (osal_lockstep_now_ns(self->scheduler) < self->abandon_ns))) {
        osal_grant_t grant    = {0U, 0U, 0U};
        const status_t status = osal_lockstep_next(self->scheduler, &self->running, &grant);
        if (status == STATUS_BUSY) {
            begin_life(self, self->running);
        } else if (status != STATUS_OK) {
            return;
        } else if (self->running == RUN_SIMULATOR) {
            const uint64_t wake_ns = simulator_step(self->simulator, grant.now_ns);
            if (simulator_failure(self->simulator) != NULL) {
                return;
            }
            osal_lockstep_done(self->scheduler, RUN_SIMULATOR, wake_ns);
            close_ended(self);
        } else if (self->running == run_operator(self->run)) {
            run_operator_turn(self, &grant);
        } else if (self->running == run_relay(self->run)) {
            osal_lockstep_done(self->scheduler, self->running, launcher_relay_step(&self->relay, &grant));
        } else {
            run_component(self, self->running, &grant);
            close_ended(self);
        }
    }
}

static int close_all(image_t* const self)
{
    int code = (self->abandon_ns == 0U) ? 0 : 1;
    simulator_statistics_t statistics;
    for (unsigned i = 0U; i < self->run->component_count; i++) {
        close_component(self, i);
    }
    launcher_relay_close(&self->relay);
    simulator_statistics(self->simulator, &statistics);
    if (losses_report(&statistics)) {
        __atomic_store_n(&self->run->is_lossy, 1U, __ATOMIC_RELAXED);
    }
    if (simulator_failure(self->simulator) != NULL) {
        code = report_error(simulator_failure(self->simulator));
    }
    if (simulator_close(self->simulator) != STATUS_OK) {
        code = report_error("a log of the simulator is not complete; is the disk full?");
    }
    if (self->has_cosimulation) {
        cosimulation_port_close(&self->cosimulation);
    }
    return code;
}

// ---- Command line ----

static uint64_t number_of(const char* const digits)
{
    const char* text = digits;
    uint64_t number  = 0U;
    return (number_read_unsigned(&text, &number) == STATUS_OK) ? number : 0U;
}

static bool parse(const int argument_count, char* const arguments[], image_options_t* const options)
{
    for (int i = 1; (i + 1) < argument_count; i += 2) {
        const char* const value = arguments[i + 1];
        if (strcmp(arguments[i], "--run") == 0) {
            options->run = value;
        } else if (strcmp(arguments[i], "--scenario") == 0) {
            options->scenario = value;
        } else if (strcmp(arguments[i], "--world") == 0) {
            options->world = value;
        } else if (strcmp(arguments[i], "--cosimulation") == 0) {
            options->cosimulation = value;
        } else if (strcmp(arguments[i], "--seed") == 0) {
            options->seed = number_of(value);
        } else {
            return false;
        }
    }
    return (options->run != NULL) && (options->world != NULL) && ((argument_count % 2) == 1);
}

// ---- Refusals on demand, in test builds ----

#ifdef RESOURCE_CHECKS
static void arm_refusal(void)
{
    const char* const number = osal_process_environment("HIROSCO_REFUSE_TAKE");
    take_check_refuse((number != NULL) ? (uint32_t)number_of(number) : 0U);
}

/// Print the number of blocks and sockets that were taken, which is the number of refusals that a test can
/// cause.
static void print_takes(void)
{
    char line[64];
    text_t text = text_in(line, sizeof line);
    text_add(&text, "image: takes ");
    text_add_unsigned(&text, take_check_count());
    osal_console_print_line(line);
}
#else
static void arm_refusal(void)
{
}

static void print_takes(void)
{
}
#endif

int main(const int argument_count, char* arguments[])
{
    static const char usage[] =
        "usage: --run NAME [--scenario FILE] --world FILE [--seed N] [--cosimulation PATH] "
        "(started by `hirosco run`)";
    image_options_t options = {.seed = 1U};
    if (osal_console_introduce(argument_count, arguments, "image", usage)) {
        return 0;
    }
    if (!parse(argument_count, arguments, &options)) {
        (void)report_error(usage);
        return 2;
    }
    osal_process_catch_stop();
    osal_process_ignore_interrupt();
    arm_refusal();
    const char* error = attach(&image, options.run);
    error             = (error != NULL) ? error : open_components(&image);
    error             = (error != NULL) ? error : open_simulator(&image, &options);
    error = (error != NULL) ? error : launcher_relay_open(&image.relay, image.run, image.scheduler);
    error = (error != NULL) ? error : open_cosimulation(&image, options.cosimulation);
    if (error != NULL) {
        return report_error(error);
    }
    loop(&image);
    print_takes();
    return close_all(&image);
}
