// SPDX-License-Identifier: Apache-2.0
// Starts the children of a run, each with its arguments.
#include "launcher/launcher_internal.h"

#include "base/assertion.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/file.h"

// The simulator has the largest number of arguments: its name, up to four options with a value for each bus,
// two for each subsystem and seventeen others, one option without a value, and the null at the end.
CAPACITY_CHECK(arguments_fit,
               ARGUMENTS_MAX >= ((8U * MISSION_BUSES_MAX) + (4U * MISSION_SUBSYSTEMS_MAX) + 37U));
CAPACITY_CHECK(children_are_waited_for, OSAL_PROCESS_WAIT_MAX >= LAUNCHER_CHILDREN_MAX);
CAPACITY_CHECK(children_are_noted, RUN_PROCESSES_MAX >= LAUNCHER_CHILDREN_MAX);

#define PYTHON_VENV "build/venv/bin/python"
#define PYTHON_SYSTEM "/usr/bin/python3"

static child_t* new_child(launcher_t* const launcher, const char* const name, const unsigned participant)
{
    FSW_ASSERT(launcher->child_count < LAUNCHER_CHILDREN_MAX);
    child_t* const child = &launcher->children[launcher->child_count];
    launcher->child_count++;
    *child = (child_t){.name = name, .process = {.id = 0, .descriptor = -1}, .participant = participant};
    return child;
}

void launcher_start_child(launcher_t* const launcher, child_t* const child,
                          const arguments_t* const arguments, const int* const descriptors,
                          const size_t descriptor_count)
{
    char output[LAUNCH_PATH_MAX + 32U];
    (void)text_join(output, sizeof output,
                    (const char* const[]){launcher->run->directory, "/console.log", NULL});
    // In stepped time only one process runs at a time: all processes of the run share one processor, because
    // the grant then passes fastest. The id of the launcher selects the processor, so that simultaneous runs
    // use two processors.
    osal_process_start_t start = {.arguments        = arguments->list,
                                  .descriptors      = descriptors,
                                  .descriptor_count = descriptor_count,
                                  .processor   = launcher->run->is_stepped ? (osal_process_own_id() % 2) : -1,
                                  .output_path = child->is_seen ? NULL : output,
                                  // The launcher shuts the mission down. Only the report, which is made
                                  // afterwards, ends by Ctrl-C.
                                  .ignores_terminal = !child->is_seen};
    launcher_limit(launcher, child, &start);
    const status_t status = osal_process_start(&child->process, &start);
    if (status == STATUS_OK) {
        run_state_t* const run = launcher->run;
        child->is_alive        = true;
        child->has_run         = true;
        __atomic_store_n(&run->processes[run->process_count % RUN_PROCESSES_MAX], child->process.id,
                         __ATOMIC_RELEASE);
        run->process_count++;
    } else {
        (void)launcher_refuse(launcher, (const char* const[]){"cannot start ", arguments->list[0], ": ",
                                                              status_text(status), NULL});
    }
}

void launcher_start_component(launcher_t* const launcher, child_t* const child)
{
    run_component_t* const component = &launcher->run->components[child->component];
    int descriptors[2U + RUN_LINKS_MAX];
    size_t count           = 0U;
    arguments_t arguments  = {.count = 0U};
    child->life            = __atomic_load_n(&component->wanted_life, __ATOMIC_ACQUIRE);
    child->asked_to_end_ns = 0U;
    child->started_ns      = osal_clock_monotonic_ns();
    // The recorded beat of the supervisor is still that of its earlier life.
    if (!launcher->options.is_stepped) {
        run_state_beat(launcher->run, child->component, 0U, OSAL_LOCKSTEP_NEVER);
    }
    __atomic_store_n(&component->process, (uint32_t)RUN_PROCESS_RUNNING, __ATOMIC_RELEASE);
    __atomic_store_n(&component->found_life, child->life, __ATOMIC_RELEASE);
    descriptors[count++] = component->message_descriptor;
    descriptors[count++] = launcher->run->ground_descriptor;
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        if (launcher->run->link_descriptors[i] >= 0) {
            descriptors[count++] = launcher->run->link_descriptors[i];
        }
    }
    launcher_add_component(launcher, child->component, &arguments);
    if (launcher_enter_computer(launcher, component->computer)) {
        launcher_start_child(launcher, child, &arguments, descriptors, count);
        launcher_leave_computer(launcher);
    }
}

/// Add the arguments about the simulated world, which simulator and image need.
static void add_world(arguments_t* const arguments, const launcher_t* const launcher)
{
    arguments_add_option(arguments, "--world", launcher->world_path);
    if (launcher->has_operator) {
        arguments_add_option(arguments, "--scenario", launcher->scenario_path);
    }
    arguments_add_number(arguments, "--seed", launcher->options.seed);
}

/// Add "--OPTION BUS=ADDRESS" if the address is not empty.
static void add_bus(arguments_t* const arguments, const char* const option, const char* const name,
                    const char* const address)
{
    char bus[RUN_NAME_MAX];
    if (address[0] != '\0') {
        (void)text_join(bus, sizeof bus, (const char* const[]){name, "=", address, NULL});
        arguments_add_option(arguments, option, bus);
    }
}

static void add_buses(arguments_t* const arguments, const launcher_t* const launcher)
{
    for (uint16_t i = 0U; i < launcher->mission.bus_count; i++) {
        const mission_bus_t* const bus = &launcher->mission.buses[i];
        const run_bus_t* const address = &launcher->run->buses[i];
        add_bus(arguments, "--bus", bus->name, address->simulator);
        add_bus(arguments, "--publish", bus->name, address->published);
        char rates[32];
        text_t text = text_in(rates, sizeof rates);
        text_add_unsigned(&text, bus->bit_rate);
        text_add(&text, ",");
        text_add_unsigned(&text, bus->data_bit_rate);
        add_bus(arguments, "--bit-rate", bus->name, (address->simulator[0] != '\0') ? rates : "");
    }
    // --redundant must name buses that earlier options have added.
    for (uint16_t i = 0U; i < launcher->mission.bus_count; i++) {
        const mission_bus_t* const bus = &launcher->mission.buses[i];
        const bool is_there            = (launcher->run->buses[i].simulator[0] != '\0');
        if (is_there && (bus->redundant_to[0] != '\0')) {
            add_bus(arguments, "--redundant", bus->name, bus->redundant_to);
        }
    }
}

/// True if the run has a relay as a separate process.
static bool has_relay(const launcher_t* const launcher)
{
    return (launcher->options.delay_ms > 0U) && !launcher->run->relay.is_network;
}

/// Tell the simulator the names of the processes of the run. A component has two options: the name of its
/// program (as in run.json) and its own name, each with its number as participant. Other processes have no
/// number.
static void add_processes(arguments_t* const arguments, const launcher_t* const launcher)
{
    for (uint16_t i = 0U; i < launcher->mission.subsystem_count; i++) {
        const mission_subsystem_t* const subsystem = &launcher->mission.subsystems[i];
        const char* const names[]                  = {subsystem->executable, subsystem->name};
        for (size_t k = 0U; k < 2U; k++) {
            char process[RUN_NAME_MAX];
            text_t text = text_in(process, sizeof process);
            text_add(&text, names[k]);
            text_add(&text, "=");
            text_add_unsigned(&text, run_participant(i));
            arguments_add_option(arguments, "--process", process);
        }
    }
    arguments_add_words(arguments, (const char* const[]){"--process", "launcher", "--process", "simulator",
                                                         "--process", "packet-archive-sqlite", NULL});
    if (launcher->has_operator) {
        arguments_add_option(arguments, "--process", "operator");
    }
    if (has_relay(launcher)) {
        arguments_add_option(arguments, "--process", "relay");
    }
}

static void start_simulator(launcher_t* const launcher)
{
    arguments_t arguments = {.count = 0U};
    char name[RUN_NAME_MAX];
    arguments_add_joined(&arguments, launcher->program_directory, "simulator");
    add_world(&arguments, launcher);
    arguments_add_option(&arguments, "--out", launcher->run->directory);
    add_buses(&arguments, launcher);
    arguments_add_option(&arguments, "--flows", launcher->run->identity);
    unsigned communication = 0U;
    if (launcher->scheduler != NULL) {
        FSW_ASSERT(run_name(launcher->run, "scheduler", 0U, name, sizeof name));
        arguments_add_option(&arguments, "--scheduler", name);
    }
    add_processes(&arguments, launcher);
    if ((launcher->scheduler != NULL) && launcher->has_operator &&
        run_state_find(launcher->run, COMMUNICATION_APID, &communication)) {
        arguments_add_option(&arguments, "--cosimulation", launcher->cosimulation);
        arguments_add_number(&arguments, "--cosimulation-participant", run_operator(launcher->run));
        arguments_add_number(&arguments, "--cosimulation-receiver", run_participant(communication));
    }
    // In real time, the simulator or the scheduler follows the clock of the machine.
    if (!launcher->options.is_stepped) {
        arguments_add_option(&arguments, "--time", "real");
        arguments_add_number(&arguments, "--origin", launcher->run->origin_ns);
        arguments_add(&arguments, "--live");
    }
    if (launcher->options.tools != 0U) {
        arguments_add_number(&arguments, "--socketcand", launcher->options.tools);
    }
    launcher_start_child(launcher, new_child(launcher, "simulator", RUN_SIMULATOR), &arguments, NULL, 0U);
}

/// Add the sockets of the relay's links.
static size_t add_relay_descriptors(const run_state_t* const run, int* const descriptors, size_t count)
{
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        if (run->relay.descriptors[i] >= 0) {
            descriptors[count++] = run->relay.descriptors[i];
        }
    }
    return count;
}

static void start_relay(launcher_t* const launcher)
{
    arguments_t arguments = {.count = 0U};
    char name[RUN_NAME_MAX];
    int descriptors[RUN_LINKS_MAX];
    const size_t count = add_relay_descriptors(launcher->run, descriptors, 0U);
    FSW_ASSERT(run_name(launcher->run, "run", 0U, name, sizeof name));
    arguments_add_joined(&arguments, launcher->program_directory, "relay");
    arguments_add_option(&arguments, "--run", name);
    launcher_start_child(launcher, new_child(launcher, "relay", run_relay(launcher->run)), &arguments,
                         descriptors, count);
}

static void start_image(launcher_t* const launcher)
{
    arguments_t arguments = {.count = 0U};
    char name[RUN_NAME_MAX];
    FSW_ASSERT(run_name(launcher->run, "run", 0U, name, sizeof name));
    int descriptors[1U + (2U * RUN_LINKS_MAX)];
    size_t count         = 0U;
    descriptors[count++] = launcher->run->ground_descriptor;
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        if (launcher->run->link_descriptors[i] >= 0) {
            descriptors[count++] = launcher->run->link_descriptors[i];
        }
    }
    count = add_relay_descriptors(launcher->run, descriptors, count);
    for (unsigned i = 0U; i < launcher->run->component_count; i++) {
        launcher->run->components[i].found_life = 1U;
        launcher->run->components[i].process    = (uint32_t)RUN_PROCESS_RUNNING;
    }
    arguments_add_joined(&arguments, launcher->program_directory, "image");
    arguments_add_option(&arguments, "--run", name);
    add_world(&arguments, launcher);
    if (launcher->has_operator) {
        arguments_add_option(&arguments, "--cosimulation", launcher->cosimulation);
    }
    launcher_start_child(launcher, new_child(launcher, "image", LAUNCHER_NO_PARTICIPANT), &arguments,
                         descriptors, count);
}

const char* launcher_python(void)
{
    return osal_file_exists(PYTHON_VENV) ? PYTHON_VENV : PYTHON_SYSTEM;
}

static void start_operator(launcher_t* const launcher)
{
    arguments_t arguments = {.count = 0U};
    arguments_add_words(&arguments, (const char* const[]){launcher_python(), "gse/gse", "script",
                                                          launcher->scenario_path, NULL});
    arguments_add_number(&arguments, "--port", launcher->run->ground_port);
    arguments_add_option(&arguments, "--run", launcher->run->directory);
    if (launcher->run->key[0] != '\0') {
        arguments_add_option(&arguments, "--key", launcher->run->key);
    }
    if (launcher->run->is_stepped) {
        arguments_add_option(&arguments, "--cosimulation", launcher->cosimulation);
    }
    // The image creates a scheduler of its own, in which the operator takes part.
    const bool is_ours = (launcher->scheduler != NULL) && !launcher->options.is_image;
    child_t* const child =
        new_child(launcher, "operator", is_ours ? run_operator(launcher->run) : LAUNCHER_NO_PARTICIPANT);
    launcher_start_child(launcher, child, &arguments, NULL, 0U);
}

static void start_archive(launcher_t* const launcher)
{
    arguments_t arguments = {.count = 0U};
    arguments_add_joined(&arguments, launcher->program_directory, "packet-archive-sqlite");
    arguments_add_option(&arguments, "follow", launcher->run->directory);
    launcher_start_child(launcher, new_child(launcher, "packet-archive-sqlite", LAUNCHER_NO_PARTICIPANT),
                         &arguments, NULL, 0U);
}

void launcher_start_all(launcher_t* const launcher)
{
    if (launcher->options.is_image) {
        start_image(launcher);
    } else {
        if (launch_has_simulator(&launcher->options)) {
            start_simulator(launcher);
        }
        if (has_relay(launcher)) {
            start_relay(launcher);
        }
        for (unsigned i = 0U; i < launcher->run->component_count; i++) {
            child_t* const child =
                new_child(launcher, launcher->mission.subsystems[i].executable, run_participant(i));
            child->is_component = true;
            child->component    = i;
            launcher_start_component(launcher, child);
        }
    }
    start_archive(launcher);
    if (launcher->has_operator) {
        start_operator(launcher);
    }
}
