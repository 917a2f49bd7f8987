// SPDX-License-Identifier: Apache-2.0
/// The simulator as a process: a participant of the scheduler of a run, a real-time program, or a program
/// without flight software for external tools. See `simulator --help`.
#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/shm.h"
#include "osal/include/osal/task.h"
#include "sim/app/argument_values.h"
#include "sim/app/cosimulation_server.h"
#include "sim/app/losses.h"
#include "sim/app/pace_control.h"
#include "sim/app/process_faults.h"
#include "sim/app/simulator.h"
#include "sim/app/usage.h"
#include "sim/plant/plant.h"

#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXIT_USAGE 2
#define NS_PER_S 1000000000U
#define TOOL_WAIT_MS 100U // Longest wait for a tool before the end of the run is checked.
#define REAL_PRIORITY 80  // Priority SCHED_FIFO of a run in real time.
#define NO_LIMIT UINT64_MAX

typedef enum {
    PACE_SCHEDULER, ///< The scheduler of the run grants each step.
    PACE_REAL,      ///< Simulated time follows the wall clock.
    PACE_NONE       ///< Simulated time runs as fast as possible.
} pace_t;

typedef struct {
    simulator_config_t simulator;
    process_faults_t processes;
    pace_t pace;
    bool is_stepped;           ///< --time stepped, the default.
    bool is_free;              ///< --free-run.
    bool waits_for_wall_clock; ///< Simulated time of the scheduler does not pass the wall clock.
    const char* scheduler_name;
    unsigned participant;
    uint64_t origin_ns;
    bool has_origin;
    uint64_t end_ns;
    cosimulation_config_t cosimulation;
} options_t;

static simulator_t* dying_simulator; // Only the signal handler uses it.

enum {
    OPTION_SCHEDULER = 256,
    OPTION_PARTICIPANT,
    OPTION_TIME,
    OPTION_ORIGIN,
    OPTION_DURATION,
    OPTION_FREE_RUN,
    OPTION_PROCESS,
    OPTION_BUS,
    OPTION_PUBLISH,
    OPTION_REDUNDANT,
    OPTION_FLOWS,
    OPTION_CLASSIC,
    OPTION_BIT_RATE,
    OPTION_WORLD,
    OPTION_SCENARIO,
    OPTION_SEED,
    OPTION_DEVICES,
    OPTION_OUT,
    OPTION_LIVE,
    OPTION_SOCKETCAND,
    OPTION_IN_STEP,
    OPTION_QUANTUM,
    OPTION_COSIMULATION,
    OPTION_COSIMULATION_NAME,
    OPTION_COSIMULATION_PARTICIPANT,
    OPTION_COSIMULATION_RECEIVER,
    OPTION_HELP
};

static const struct option long_options[] = {
    {"scheduler", required_argument, NULL, OPTION_SCHEDULER},
    {"participant", required_argument, NULL, OPTION_PARTICIPANT},
    {"time", required_argument, NULL, OPTION_TIME},
    {"origin", required_argument, NULL, OPTION_ORIGIN},
    {"duration", required_argument, NULL, OPTION_DURATION},
    {"free-run", required_argument, NULL, OPTION_FREE_RUN},
    {"process", required_argument, NULL, OPTION_PROCESS},
    {"bus", required_argument, NULL, OPTION_BUS},
    {"publish", required_argument, NULL, OPTION_PUBLISH},
    {"redundant", required_argument, NULL, OPTION_REDUNDANT},
    {"flows", required_argument, NULL, OPTION_FLOWS},
    {"classic", no_argument, NULL, OPTION_CLASSIC},
    {"bit-rate", required_argument, NULL, OPTION_BIT_RATE},
    {"scenario", required_argument, NULL, OPTION_SCENARIO},
    {"world", required_argument, NULL, OPTION_WORLD},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"devices", required_argument, NULL, OPTION_DEVICES},
    {"out", required_argument, NULL, OPTION_OUT},
    {"live", no_argument, NULL, OPTION_LIVE},
    {"socketcand", required_argument, NULL, OPTION_SOCKETCAND},
    {"in-step", no_argument, NULL, OPTION_IN_STEP},
    {"quantum", required_argument, NULL, OPTION_QUANTUM},
    {"cosimulation", required_argument, NULL, OPTION_COSIMULATION},
    {"cosimulation-name", required_argument, NULL, OPTION_COSIMULATION_NAME},
    {"cosimulation-participant", required_argument, NULL, OPTION_COSIMULATION_PARTICIPANT},
    {"cosimulation-receiver", required_argument, NULL, OPTION_COSIMULATION_RECEIVER},
    {"help", no_argument, NULL, OPTION_HELP},
    {NULL, 0, NULL, 0}};

// ---- Command line ----

/// Find the bus that an option names, or add it; null if that is refused.
static simulator_bus_t* bus_of(options_t* const options, const char* const option, const char* const name)
{
    simulator_config_t* config = &options->simulator;
    for (size_t i = 0U; i < config->bus_count; i++) {
        if (strcmp(config->bus[i].name, name) == 0) {
            return &config->bus[i];
        }
    }
    const bool is_long = strlen(name) > OSAL_CAN_INTERFACE_NAME_MAX;
    if (is_long || (config->bus_count == SIMULATOR_BUSES_MAX)) {
        (void)argument_refuse(option, name,
                              is_long ? "a name of a bus with at most 15 characters" : "at most 8 buses");
        return NULL;
    }
    config->bus[config->bus_count] = (simulator_bus_t){.name = name};
    config->bus_count++;
    return &config->bus[config->bus_count - 1U];
}

/// Parse "NAME=ADDRESS" of the flight software's controller, or of the interface that publishes the bus; the
/// text is split in place.
static bool take_bus(options_t* const options, const char* const option, char* const text)
{
    char* equals = strchr(text, '=');
    if ((equals == NULL) || (equals == text) || (equals[1] == '\0')) {
        return argument_refuse(option, text, "NAME=ADDRESS");
    }
    *equals              = '\0';
    simulator_bus_t* bus = bus_of(options, option, text);
    if (bus == NULL) {
        return false;
    }
    if (strcmp(option, "bus") == 0) {
        bus->address = &equals[1];
    } else {
        bus->published = &equals[1];
    }
    return true;
}

/// Parse "NAME=PARTICIPANT", or "NAME" of a process that is no participant; the text is split in place.
static bool take_process(options_t* const options, char* const text)
{
    char* equals         = strchr(text, '=');
    unsigned participant = PROCESS_FAULTS_OTHER;
    if ((equals == text) || (text[0] == '\0')) {
        return argument_refuse("process", text, "NAME=PARTICIPANT or NAME");
    }
    if (equals != NULL) {
        *equals = '\0';
    }
    return ((equals == NULL) ||
            argument_unsigned("process", &equals[1], OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U, &participant)) &&
           (process_faults_name(&options->processes, text, participant) ||
            argument_refuse("process", text, "at most two names for each participant"));
}

/// Parse "NAME=RATE,RATE"; the text is split in place.
static bool take_bit_rates(options_t* const options, char* const text)
{
    char* equals = strchr(text, '=');
    char* comma  = strchr(text, ',');
    if ((equals == NULL) || (comma == NULL) || (comma < equals)) {
        return argument_refuse("bit-rate", text, "NAME=RATE,RATE in bit/s");
    }
    *equals              = '\0';
    *comma               = '\0';
    simulator_bus_t* bus = bus_of(options, "bit-rate", text);
    return (bus != NULL) && argument_unsigned("bit-rate", &equals[1], 8000000U, &bus->bit_rate) &&
           argument_unsigned("bit-rate", &comma[1], 8000000U, &bus->data_bit_rate);
}

/// Parse "NAME=OF" for a bus that an earlier option names; the text is split in place.
static bool take_redundant(options_t* const options, char* const text)
{
    simulator_config_t* config = &options->simulator;
    char* equals               = strchr(text, '=');
    if (equals != NULL) {
        *equals = '\0';
        for (size_t i = 0U; i < config->bus_count; i++) {
            if (strcmp(config->bus[i].name, text) == 0) {
                config->bus[i].redundant_to = &equals[1];
                return true;
            }
        }
    }
    return argument_refuse("redundant", text, "NAME=OF with a NAME that --bus has named before");
}

static bool take_tools(options_t* const options, const char* const text)
{
    unsigned port                  = 0U;
    options->simulator.serve_tools = strcmp(text, "off") != 0;
    if (options->simulator.serve_tools && !argument_unsigned("socketcand", text, UINT16_MAX, &port)) {
        return false;
    }
    options->simulator.tool_port = (uint16_t)port;
    return true;
}

static bool take_tool_option(options_t* const options, const int option, const char* const text)
{
    uint64_t quantum_us = 0U;
    switch (option) {
    case OPTION_SOCKETCAND:
        return take_tools(options, text);
    case OPTION_LIVE:
        options->simulator.is_live = true;
        return true;
    case OPTION_IN_STEP:
        options->simulator.tools_in_step = true;
        return true;
    case OPTION_QUANTUM:
        if (!argument_count("quantum", text, NS_PER_S, &quantum_us)) {
            return false;
        }
        options->simulator.tool_quantum_ns = quantum_us * 1000U;
        return true;
    case OPTION_COSIMULATION:
        options->cosimulation.path = text;
        return true;
    case OPTION_COSIMULATION_NAME:
        options->cosimulation.name = text;
        return true;
    case OPTION_COSIMULATION_PARTICIPANT:
        return argument_unsigned("cosimulation-participant", text, OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U,
                                 &options->cosimulation.participant);
    default:
        return argument_unsigned("cosimulation-receiver", text, OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U,
                                 &options->cosimulation.receiver);
    }
}

static bool take_time_option(options_t* const options, const int option, const char* const text)
{
    switch (option) {
    case OPTION_SCHEDULER:
        options->scheduler_name = text;
        return true;
    case OPTION_PARTICIPANT:
        return argument_unsigned("participant", text, OSAL_LOCKSTEP_PARTICIPANTS_MAX - 1U,
                                 &options->participant);
    case OPTION_TIME:
        options->is_stepped = strcmp(text, "stepped") == 0;
        return options->is_stepped || (strcmp(text, "real") == 0) ||
               argument_refuse("time", text, "stepped or real");
    case OPTION_ORIGIN:
        options->has_origin = true;
        return argument_count("origin", text, UINT64_MAX, &options->origin_ns);
    case OPTION_FREE_RUN:
        options->is_free = true;
        return argument_seconds("free-run", text, &options->end_ns);
    default:
        return argument_seconds("duration", text, &options->end_ns);
    }
}

static bool take_option(options_t* const options, const int option, char* const text)
{
    switch (option) {
    case OPTION_BUS:
        return take_bus(options, "bus", text);
    case OPTION_PROCESS:
        return take_process(options, text);
    case OPTION_PUBLISH:
        return take_bus(options, "publish", text);
    case OPTION_FLOWS:
        options->simulator.flows = text;
        return true;
    case OPTION_BIT_RATE:
        return take_bit_rates(options, text);
    case OPTION_REDUNDANT:
        return take_redundant(options, text);
    case OPTION_CLASSIC:
        options->simulator.classic_bus = true;
        return true;
    case OPTION_SCENARIO:
        options->simulator.scenario_path = text;
        return true;
    case OPTION_WORLD:
        options->simulator.world_path = text;
        return true;
    case OPTION_SEED:
        return argument_count("seed", text, UINT64_MAX, &options->simulator.seed);
    case OPTION_DEVICES:
        options->simulator.devices_path = text;
        return true;
    case OPTION_OUT:
        options->simulator.output_path = text;
        return true;
    default:
        return ((option >= OPTION_SCHEDULER) && (option <= OPTION_FREE_RUN))
                   ? take_time_option(options, option, text)
                   : take_tool_option(options, option, text);
    }
}

static bool check_options(options_t* const options)
{
    options->simulator.are_flows_counted = (options->scheduler_name != NULL);
    if (options->simulator.world_path == NULL) {
        osal_console_print_error(
            "simulator: give --world FILE, e.g. one of descriptors/worlds/ (see --help)");
        return false;
    }
    if (options->is_free) {
        options->pace = options->is_stepped ? PACE_NONE : PACE_REAL;
        if (options->scheduler_name != NULL) {
            return argument_refuse("scheduler", options->scheduler_name, "no --free-run beside it");
        }
    } else if (options->scheduler_name != NULL) {
        options->pace                 = PACE_SCHEDULER;
        options->waits_for_wall_clock = !options->is_stepped;
    } else if (options->is_stepped) {
        osal_console_print_error(
            "simulator: give --scheduler NAME, or --time real, or --free-run SECONDS (see --help)");
        return false;
    } else {
        options->pace = PACE_REAL;
    }
    if (options->simulator.tools_in_step && (!options->simulator.serve_tools || !options->is_free)) {
        osal_console_print_error("simulator: --in-step needs --socketcand PORT and --free-run SECONDS");
        return false;
    }
    if ((options->cosimulation.path != NULL) && (options->pace != PACE_SCHEDULER)) {
        return argument_refuse("cosimulation", options->cosimulation.path,
                               "--scheduler NAME with a co-simulation port");
    }
    if (options->simulator.tools_in_step) {
        options->pace = PACE_NONE;
    }
    if (options->simulator.is_live && (options->simulator.output_path == NULL)) {
        osal_console_print_error(
            "simulator: --live needs --out DIR, where live.port and live.scn are written");
        return false;
    }
    options->simulator.is_paced = options->waits_for_wall_clock;
    return true;
}

/// Parse the command line. Returns 0 to continue, else the exit code + 1.
static int parse(options_t* const options, const int count, char* arguments[])
{
    opterr = 0;
    for (;;) {
        const int option = getopt_long(count, arguments, "", long_options, NULL);
        if (option == -1) {
            break;
        }
        if (option == OPTION_HELP) {
            osal_console_print(simulator_usage);
            return EXIT_SUCCESS + 1;
        }
        if (option == '?') {
            argument_refuse_word(arguments[optind - 1], "a known option with its value");
            return EXIT_USAGE + 1;
        }
        if (!take_option(options, option, optarg)) {
            return EXIT_USAGE + 1;
        }
    }
    if (optind < count) {
        argument_refuse_word(arguments[optind], "options only");
        return EXIT_USAGE + 1;
    }
    return check_options(options) ? 0 : (EXIT_USAGE + 1);
}

// ---- The run ----

/// Write the buffered log records when the simulator crashes.
static void save_logs(const int signal_number)
{
    if (dying_simulator != NULL) {
        // NOLINTNEXTLINE(bugprone-signal-handler,cert-sig30-c): the program ends anyway.
        simulator_flush(dying_simulator, true);
    }
    // The signal then ends the process as it does without this handler.
    (void)signal(signal_number, SIG_DFL);
    (void)raise(signal_number);
}

/// Step until the run is over.
static void run(simulator_t* const simulator, const options_t* const options, osal_clock_t* const clock,
                osal_lockstep_t* const scheduler)
{
    uint64_t now_ns     = 0U;
    uint64_t wake_ns    = 0U;
    uint64_t flush_ns   = NS_PER_S;
    status_t status     = STATUS_OK;
    osal_grant_t grant  = {0U, 0U, 0U};
    const bool is_paced = options->pace != PACE_NONE;
    pace_control_t pace = {.speed = 1.0};
    if (options->waits_for_wall_clock) {
        pace_control_open(&pace, options->has_origin ? options->origin_ns : osal_clock_monotonic_ns());
    }
    while ((now_ns < options->end_ns) && (osal_process_stop_count() == 0U) &&
           (simulator_failure(simulator) == NULL)) {
        if (!is_paced) {
            if (!simulator_may_step(simulator, TOOL_WAIT_MS)) {
                continue;
            }
            now_ns = wake_ns;
        } else if (scheduler == NULL) {
            status = osal_clock_wait(clock, wake_ns, NULL, 0U);
            now_ns = osal_clock_now_ns(clock);
        } else {
            status =
                osal_lockstep_wait(scheduler, options->participant, OSAL_LOCKSTEP_ANY_LIFE, wake_ns, &grant);
            now_ns = grant.now_ns;
        }
        if (status != STATUS_OK) {
            break;
        }
        if (options->waits_for_wall_clock) {
            pace_control_wait(&pace, simulator, scheduler, now_ns);
        }
        wake_ns = simulator_step(simulator, now_ns);
        if (now_ns >= flush_ns) { // At most one second is lost if the simulator is killed.
            simulator_flush(simulator, false);
            flush_ns = now_ns + NS_PER_S;
        }
    }
}

static void announce(const simulator_t* const simulator)
{
    char line[256];
    if (simulator_tool_port(simulator) == 0U) {
        return;
    }
    (void)snprintf(line, sizeof line, "simulator: socketcand on 127.0.0.1:%u, buses",
                   (unsigned)simulator_tool_port(simulator));
    for (unsigned i = 0U; simulator_bus_name(simulator, i) != NULL; i++) {
        const size_t used = strlen(line);
        (void)snprintf(&line[used], sizeof line - used, " %s", simulator_bus_name(simulator, i));
    }
    osal_console_print_line(line);
}

/// True if the world has diverged.
static bool report_unusable_world(const simulator_t* const simulator)
{
    const char* failure = simulator_failure(simulator);
    char line[PLANT_FAILURE_MAX + 16U];
    if (failure == NULL) {
        return false;
    }
    (void)snprintf(line, sizeof line, "simulator: %s", failure);
    osal_console_print_error(line);
    return true;
}

static int fly(options_t* const options, osal_lockstep_t* const scheduler)
{
    static cosimulation_server_t server;
    char error[SIMULATOR_ERROR_MAX];
    simulator_t* simulator = NULL;
    simulator_statistics_t statistics;
    osal_clock_t clock;
    options->processes.scheduler       = scheduler;
    options->simulator.process_fault   = process_faults_act;
    options->simulator.process_check   = process_faults_check;
    options->simulator.process_context = &options->processes;
    if (simulator_open(&options->simulator, &simulator, error) != STATUS_OK) {
        osal_console_print_error(error);
        return EXIT_FAILURE;
    }
    dying_simulator = simulator;
    for (size_t i = 0U; i < 5U; i++) {
        (void)signal((const int[]){SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}[i], save_logs);
    }
    announce(simulator);
    int code = EXIT_FAILURE;
    if (cosimulation_server_open(&server, &options->cosimulation, scheduler)) {
        if (scheduler == NULL) {
            osal_clock_open_real(&clock,
                                 options->has_origin ? options->origin_ns : osal_clock_monotonic_ns());
            const status_t status = osal_task_set_priority(REAL_PRIORITY);
            (void)status; // Without the permission the simulator keeps its priority.
        }
        run(simulator, options, &clock, scheduler);
        simulator_statistics(simulator, &statistics);
        if (losses_report(&statistics) && (scheduler != NULL)) {
            osal_lockstep_note_loss(scheduler);
        }
        code = report_unusable_world(simulator) ? EXIT_FAILURE : EXIT_SUCCESS;
    }
    cosimulation_server_close(&server);
    if (scheduler != NULL) {
        osal_lockstep_end(scheduler, options->participant, OSAL_LOCKSTEP_ANY_LIFE);
    }
    dying_simulator = NULL;
    if (simulator_close(simulator) != STATUS_OK) {
        osal_console_print_error("simulator: a log is not complete; is the disk full?");
        code = EXIT_FAILURE;
    }
    return code;
}

int main(const int count, char* arguments[])
{
    options_t options = {.simulator    = {.seed = 1U},
                         .is_stepped   = true,
                         .end_ns       = NO_LIMIT,
                         .cosimulation = {.name = "operator"}};
    if (osal_console_introduce(count, arguments, "simulator", NULL)) {
        return EXIT_SUCCESS;
    }
    const int usage            = parse(&options, count, arguments);
    osal_shm_t shm             = {0};
    osal_lockstep_t* scheduler = NULL;
    if (usage != 0) {
        return usage - 1;
    }
    osal_process_catch_stop();
    if (!options.is_free) {
        osal_process_ignore_interrupt(); // The launcher decides about Ctrl-C.
    }
    if (options.scheduler_name != NULL) {
        const status_t status = osal_shm_open(&shm, options.scheduler_name);
        scheduler             = (status == STATUS_OK) ? osal_lockstep_attach(osal_shm_address(&shm)) : NULL;
        if (scheduler == NULL) {
            (void)argument_refuse("scheduler", options.scheduler_name,
                                  "the shared memory of a running launcher");
            return EXIT_FAILURE;
        }
    }
    const int code = fly(&options, scheduler);
    if (scheduler != NULL) {
        osal_shm_close(&shm);
    }
    return code;
}
