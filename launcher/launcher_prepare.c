// SPDX-License-Identifier: Apache-2.0
// Preparation of a run before its first process: mission, directory, shared memory, buses, sockets.
#include "launcher/launcher_internal.h"

#include "fsw/programs/ground_key.h"
#include "generated/device_classes.h"
#include "launcher/launcher_relay.h"
#include "launcher/run_summary.h"
#include "fsw/framework/rtlink/agreement.h"
#include "fsw/supervisor/checkpoint.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/file.h"

#include <string.h>

#define IDENTITY "hirosco-"
#define FAMILY "/" IDENTITY ///< Beginning of the names of all shared objects of runs.
/// Longest wall-clock time for which a stopped process may block the scheduler in real time.
#define REAL_TIMEOUT_NS 40000000ULL
#define PORT_TRIES 200U
#define DIRECTORY_TRIES 1000U

// ---- Mission and directory ----

static bool load_mission(launcher_t* const launcher, char* const path, const size_t capacity)
{
    (void)text_join(path, capacity,
                    (const char* const[]){"descriptors/missions/", launcher->options.mission, ".xml", NULL});
    if (!osal_file_exists(path)) {
        return launcher_fail(launcher, "no such mission (run hirosco in the project's directory): ", path);
    }
    descriptor_loader_init(&launcher->loader);
    if (descriptor_load_mission(&launcher->loader, path, MISSION_ANY_TARGET, &descriptor_mission_whole,
                                &launcher->mission, &launcher->scratch) != STATUS_OK) {
        return launcher_fail(launcher, descriptor_error(&launcher->loader), "");
    }
    return true;
}

static bool refuse_program(launcher_t* const launcher, const char* const mission_path,
                           const mission_subsystem_t* const subsystem, const char* const expected,
                           const char* const name, const char* const next)
{
    char line[16];
    text_t text = text_in(line, sizeof line);
    text_add_unsigned(&text, subsystem->line);
    return launcher_refuse(
        launcher, (const char* const[]){mission_path, ":", line, ": executable=\"", subsystem->executable,
                                        "\" of <Subsystem>: expected ", expected, name, next, NULL});
}

/// Check that the program of each subsystem is in the directory of the launcher. A program has static storage
/// for one subsystem, and the image contains each program once.
static bool find_programs(launcher_t* const launcher, const char* const mission_path)
{
    const mission_subsystem_t* const all = launcher->mission.subsystems;
    for (uint16_t i = 0U; i < launcher->mission.subsystem_count; i++) {
        char path[LAUNCH_PATH_MAX];
        const char* const words[] = {launcher->program_directory, all[i].executable, NULL};
        if (!text_join(path, sizeof path, words) || !osal_file_exists(path)) {
            return refuse_program(launcher, mission_path, &all[i], "a program in ",
                                  launcher->program_directory, "; `make` builds each fsw/programs/*_main.c");
        }
        for (uint16_t k = 0U; launcher->options.is_image && (k < i); k++) {
            if (strcmp(all[k].executable, all[i].executable) == 0) {
                return refuse_program(launcher, mission_path, &all[i], "another program than that of ",
                                      all[k].name, ", which the image contains once; use --form processes");
            }
        }
    }
    return true;
}

/// Choose the carrier of messages and the transfer method of links: those of the command line, otherwise
/// those of the mission.
static bool choose_methods(launcher_t* const launcher, const char* const mission_path)
{
    launch_options_t* const options = &launcher->options;
    const uint8_t messages          = launcher->mission.message_method;
    const uint8_t links             = launcher->mission.link_method;
    if (options->transport[0] == '\0') {
        if ((messages != (uint8_t)DESCRIPTOR_UDP) && (messages != (uint8_t)DESCRIPTOR_TIPC)) {
            return launcher_fail(
                launcher, mission_path,
                ": <Transports messages>: expected UDP or TIPC; or give --transport udp|tipc");
        }
        options->transport = (messages == (uint8_t)DESCRIPTOR_TIPC) ? "tipc" : "udp";
    }
    if (options->links[0] == '\0') {
        if (links >= (uint8_t)RTLINK_METHOD_COUNT) {
            return launcher_fail(
                launcher, mission_path,
                ": <Transports links>: expected SHARED_MEMORY, UDP or TIPC; or give --links shm|udp|tipc");
        }
        static const char* const names[] = {"shm", "tipc", "udp"};
        const bool is_spread = (options->computers > 1U) && (links == (uint8_t)RTLINK_METHOD_SHARED_MEMORY);
        options->links       = names[links];
        // Links within a computer use shared memory; links between computers use the carrier of messages.
        if (is_spread) {
            options->links = (strcmp(options->transport, "tipc") == 0) ? "shm tipc" : "shm udp";
        }
    }
    return true;
}

/// Returns the bit set of the methods in a list of names.
static uint8_t link_methods(const char* const names)
{
    const unsigned shm  = (strstr(names, "shm") != NULL) ? (1U << (unsigned)RTLINK_METHOD_SHARED_MEMORY) : 0U;
    const unsigned tipc = (strstr(names, "tipc") != NULL) ? (1U << (unsigned)RTLINK_METHOD_TIPC) : 0U;
    const unsigned udp  = (strstr(names, "udp") != NULL) ? (1U << (unsigned)RTLINK_METHOD_UDP) : 0U;
    return (uint8_t)(shm | tipc | udp);
}

/// Write the path of a scenario. True if the file exists.
static bool has_scenario(launcher_t* const launcher, const char* const scenario)
{
    const bool is_path = launch_is_path(scenario, ".scn");
    (void)text_join(
        launcher->scenario_path, sizeof launcher->scenario_path,
        (const char* const[]){is_path ? "" : "sim/scenarios/", scenario, is_path ? "" : ".scn", NULL});
    return osal_file_exists(launcher->scenario_path);
}

static bool find_scenario(launcher_t* const launcher)
{
    if (launcher->options.scenario[0] == '\0') {
        const bool has_own         = has_scenario(launcher, launcher->options.mission);
        launcher->options.scenario = has_own ? launcher->options.mission : LAUNCH_SCENARIO;
    }
    launcher->has_operator     = (strcmp(launcher->options.scenario, "none") != 0);
    launcher->scenario_path[0] = '\0';
    return !launcher->has_operator || has_scenario(launcher, launcher->options.scenario) ||
           launcher_refuse(launcher, (const char* const[]){"no such scenario: ", launcher->scenario_path,
                                                           "; choose another one with --scenario", NULL});
}

/// Find the world of the mission; a run with real devices has none.
static bool find_world(launcher_t* const launcher)
{
    const bool is_path = launch_is_path(launcher->options.world, ".xml");
    (void)text_join(launcher->world_path, sizeof launcher->world_path,
                    (const char* const[]){is_path ? "" : "descriptors/worlds/", launcher->options.world,
                                          is_path ? "" : ".xml", NULL});
    return !launch_has_simulator(&launcher->options) || osal_file_exists(launcher->world_path) ||
           launcher_refuse(launcher,
                           (const char* const[]){"no world for the simulator: ", launcher->world_path,
                                                 "; choose another one with --world", NULL});
}

static bool find_inputs(launcher_t* const launcher)
{
    return find_scenario(launcher) && find_world(launcher);
}

/// Add the file name of the scenario, without directories and ending.
static void add_scenario_name(text_t* const text, const char* const scenario)
{
    const char* const slash = strrchr(scenario, '/');
    for (const char* next = (slash != NULL) ? &slash[1] : scenario; *next != '\0'; next++) {
        if (strcmp(next, ".scn") == 0) {
            break;
        }
        text_add_character(text, *next);
    }
}

static bool is_used(const char* const directory)
{
    char path[LAUNCH_PATH_MAX + 16U];
    (void)text_join(path, sizeof path, (const char* const[]){directory, "/run.json", NULL});
    return osal_file_exists(path);
}

/// Create the requested directory, or the first unused one of this scenario, form and seed.
static bool create_directory(launcher_t* const launcher, char* const directory, const size_t capacity)
{
    const launch_options_t* const options = &launcher->options;
    text_t text                           = text_in(directory, capacity);
    if (options->output[0] != '\0') {
        text_add(&text, options->output);
        if (is_used(directory)) {
            return launcher_fail(
                launcher, "there is a run in this directory already; choose another --out: ", directory);
        }
    } else {
        bool is_free = false;
        for (unsigned number = 1U; !is_free && (number < DIRECTORY_TRIES); number++) {
            text = text_in(directory, capacity);
            text_add(&text, "runs/");
            add_scenario_name(&text, options->scenario);
            text_add(&text, options->is_image ? "-image-" : "-processes-");
            text_add_unsigned(&text, options->seed);
            text_add(&text, "-");
            text_add_digits(&text, number, 3U);
            is_free = !osal_file_exists(directory);
        }
    }
    if (text.cut || (osal_file_create_directory(directory) != STATUS_OK)) {
        return launcher_refuse(launcher,
                               (const char* const[]){"cannot create the output directory ", directory,
                                                     "; choose another one with --out", NULL});
    }
    const char* const base = (strncmp(directory, "runs/", 5U) == 0) ? &directory[5] : NULL;
    if (base != NULL) {
        const status_t status = osal_file_link(base, "runs/latest");
        (void)status; // The link runs/latest is optional: another run may have created it at the same time.
    }
    return true;
}

/// Find the key of the ground link: that of the command line, otherwise that of the mission, whose path is
/// relative to the mission's file. It is opened once before the run begins, because a mission with a key
/// must not fly without it.
static bool check_key(launcher_t* const launcher, const char* const mission_path)
{
    const char* const asked = launcher->options.key;
    const char* const named = launcher->mission.ground_key;
    const char* const slash = strrchr(mission_path, '/');
    text_t text             = text_in(launcher->key_path, sizeof launcher->key_path);
    if (asked[0] != '\0') {
        text_add(&text, asked);
    } else if (named[0] != '\0') {
        for (const char* next = mission_path; (named[0] != '/') && (slash != NULL) && (next <= slash);
             next++) {
            text_add_character(&text, *next);
        }
        text_add(&text, named);
    } else {
        return true;
    }
    ground_key_t key;
    char error[GROUND_KEY_ERROR_MAX];
    if (text.cut) {
        return launcher_fail(
            launcher, "the path of the ground link's key has more than 255 characters: ", launcher->key_path);
    }
    if (!ground_key_open(&key, launcher->key_path, error)) {
        return launcher_fail(launcher, error, "");
    }
    ground_key_close(&key);
    return true;
}

// ---- Remains of earlier runs ----

int32_t launcher_owner_of(const char* const identity)
{
    int32_t owner          = 0;
    const size_t length    = sizeof IDENTITY - 1U;
    const char* const from = (strncmp(identity, IDENTITY, length) == 0) ? &identity[length] : "";
    for (const char* next = from; (*next >= '0') && (*next <= '9') && (owner < 100000000); next++) {
        owner = (owner * 10) + (int32_t)(*next - '0');
    }
    return owner;
}

/// Remove a name if its launcher has ended; a killed launcher could not remove it.
static void sweep(void* const context, const char* const name)
{
    (void)context;
    osal_process_t owner  = {.id = 0, .descriptor = -1};
    const int32_t id      = launcher_owner_of(&name[1]);
    const status_t status = (id > 0) ? osal_process_watch(&owner, id) : STATUS_OK;
    if (status == STATUS_NOT_FOUND) {
        (void)osal_shm_remove(name); // The co-simulation port also has such a name.
        char identity[RUN_IDENTITY_MAX];
        text_t text = text_in(identity, sizeof identity);
        text_add(&text, &FAMILY[1]);
        text_add_unsigned(&text, (uint64_t)id);
        launcher_remove_computers(identity);
    }
    osal_process_release(&owner);
}

// ---- Shared memory ----

/// Check that the storage belongs to this mission. The file contains the name of the mission; if it is
/// empty, the name is written to it.
static bool check_owner(launcher_t* const launcher, osal_file_t* const file, const char* const path)
{
    char owner[LAUNCH_PATH_MAX] = {'\0'};
    uint64_t size               = 0U;
    status_t status             = osal_file_size(file, &size);
    if (status == STATUS_OK) {
        status =
            osal_file_read_at(file, 0U, owner, (size < sizeof owner) ? (size_t)size : (sizeof owner - 1U));
    }
    // The file is new, or the power was cut while it was being created.
    if ((status == STATUS_OK) && (owner[0] == '\0')) {
        status = osal_file_write(file, launcher->options.mission, strlen(launcher->options.mission));
        status = (status == STATUS_OK) ? osal_file_sync(file) : status;
    } else if ((status == STATUS_OK) && (strcmp(owner, launcher->options.mission) != 0)) {
        return launcher_refuse(
            launcher,
            (const char* const[]){
                "the storage is that of another mission: ", path, " contains '", owner, "', expected '",
                launcher->options.mission,
                "'; choose another directory with --storage, or fly that mission with --mission", NULL});
    } else {
        // The storage belongs to this mission, or the file cannot be read.
    }
    return (status == STATUS_OK) ||
           launcher_refuse(launcher,
                           (const char* const[]){status_text(status), ": the storage cannot be used: ", path,
                                                 "; choose another directory with --storage", NULL});
}

/// Claim the storage for this mission. The storage of another mission is refused, because its schedules,
/// definitions and stores identify subsystems, modes and services by numbers that have another meaning in
/// this mission.
static bool claim_storage(launcher_t* const launcher)
{
    char path[LAUNCH_PATH_MAX + 32U];
    osal_file_t file = {-1};
    (void)text_join(path, sizeof path, (const char* const[]){launcher->run->storage, "/mission", NULL});
    const status_t status = osal_file_update(&file, path);
    if (status != STATUS_OK) {
        return launcher_refuse(
            launcher,
            (const char* const[]){"cannot write the storage: ", path,
                                  "; make it writable, or choose another directory with --storage", NULL});
    }
    const bool is_ours = check_owner(launcher, &file, path);
    osal_file_close(&file);
    return is_ours;
}

static bool create_run(launcher_t* const launcher, const char* const path, const char* const directory)
{
    char identity[RUN_IDENTITY_MAX];
    text_t text = text_in(identity, sizeof identity);
    text_add(&text, IDENTITY);
    text_add_unsigned(&text, (uint64_t)osal_process_own_id());
    if (run_state_create(&launcher->run_shm, identity, &launcher->run) != STATUS_OK) {
        return launcher_fail(launcher, "cannot create shared memory (is /dev/shm full?) for the run ",
                             identity);
    }
    run_state_t* const run  = launcher->run;
    const char* const asked = launcher->options.storage;
    const bool is_asked     = (asked[0] != '\0');
    (void)text_join(run->mission_path, sizeof run->mission_path, (const char* const[]){path, NULL});
    (void)text_join(run->directory, sizeof run->directory, (const char* const[]){directory, NULL});
    const char* const storage[] = {is_asked ? asked : directory, is_asked ? "" : "/storage", NULL};
    if (!text_join(run->storage, sizeof run->storage, storage) ||
        (osal_file_create_directory(run->storage) != STATUS_OK)) {
        return launcher_refuse(launcher,
                               (const char* const[]){"cannot create the storage directory ", run->storage,
                                                     "; choose another one with --storage", NULL});
    }
    if (!claim_storage(launcher)) {
        return false;
    }
    (void)text_join(run->key, sizeof run->key, (const char* const[]){launcher->key_path, NULL});
    // A scheduler is also used in real time, because simulated devices need it; only a run with TIME=free or
    // without a simulator has none.
    run->is_stepped      = launch_has_scheduler(&launcher->options);
    run->has_simulator   = launch_has_simulator(&launcher->options);
    run->is_real         = !launcher->options.is_stepped;
    run->link_methods    = link_methods(launcher->options.links);
    run->transport       = (uint8_t)((strcmp(launcher->options.transport, "tipc") == 0) ? RUN_TRANSPORT_TIPC
                                                                                        : RUN_TRANSPORT_UDP);
    run->instance        = (uint32_t)osal_process_own_id();
    run->component_count = launcher->mission.subsystem_count;
    run->mission_hash    = launcher->mission.configuration_hash;
    for (uint16_t i = 0U; i < run->component_count; i++) {
        run_component_t* const component           = &run->components[i];
        const mission_subsystem_t* const subsystem = &launcher->mission.subsystems[i];
        component->apid                            = subsystem->apid;
        component->message_descriptor              = -1;
        component->message_window                  = launcher_message_window(launcher, i);
        component->life                            = 1U;
        component->wanted_life                     = 1U;
        run_state_beat(run, i, 0U, OSAL_LOCKSTEP_NEVER);
        (void)text_join(component->name, sizeof component->name,
                        (const char* const[]){subsystem->name, NULL});
    }
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        run->link_descriptors[i]  = -1;
        run->relay.descriptors[i] = -1;
    }
    run->relay.delay_us =
        // The delay of one direction is half of the round trip.
        ((uint32_t)launcher->options.delay_ms * 1000U) / 2U;
    run->relay.jitter_us  = (uint32_t)((double)run->relay.delay_us * LAUNCHER_RELAY_JITTER);
    run->relay.is_network = (launcher->options.delay_ms > 0U) && (launcher->options.computers > 1U);
    run->relay.seed       = launcher->options.seed;
    return true;
}

/// Let the scheduler begin the next life of the supervisor one boot time after its death.
static void let_supervisor_return(const launcher_t* const launcher)
{
    unsigned index = 0U;
    if (run_state_find(launcher->run, SUPERVISOR_APID, &index)) {
        osal_lockstep_set_succession(launcher->scheduler, run_participant(index),
                                     (uint64_t)launcher->mission.subsystems[index].boot_time_us * 1000U);
    }
}

static bool create_scheduler(launcher_t* const launcher)
{
    char name[RUN_NAME_MAX];
    if (!launcher->run->is_stepped) {
        return true; // There is no scheduler: each component has its own clock.
    }
    if (!run_name(launcher->run, "scheduler", 0U, name, sizeof name) ||
        (osal_shm_create(&launcher->scheduler_shm, name, OSAL_LOCKSTEP_OCTETS) != STATUS_OK)) {
        return launcher_fail(launcher, "cannot create shared memory (is /dev/shm full?) for the scheduler ",
                             name);
    }
    launcher->scheduler = osal_lockstep_create(osal_shm_address(&launcher->scheduler_shm), RUN_STEP_NS,
                                               !launcher->options.is_image);
    if (launcher->scheduler == NULL) {
        return launcher_fail(
            launcher, "this system has no lock that survives the death of its holder; use --form image", "");
    }
    if (!launcher->options.is_stepped) {
        osal_lockstep_set_timeout(launcher->scheduler, REAL_TIMEOUT_NS);
    }
    const unsigned last = run_operator(launcher->run);
    for (unsigned participant = 0U; participant <= last; participant++) {
        if ((participant != last) || launcher->has_operator) {
            osal_lockstep_expect(launcher->scheduler, participant, 1U, 0U);
        }
    }
    if ((launcher->options.delay_ms > 0U) && !launcher->run->relay.is_network) {
        osal_lockstep_expect(launcher->scheduler, run_relay(launcher->run), 1U, 0U);
    }
    let_supervisor_return(launcher);
    return true;
}

/// Create the shared memory for the data that a restarted supervisor takes over.
static bool create_checkpoint(launcher_t* const launcher)
{
    char name[RUN_NAME_MAX];
    osal_shm_t shm;
    if (!run_name(launcher->run, "checkpoint", 0U, name, sizeof name) ||
        (osal_shm_create(&shm, name, sizeof(checkpoint_t)) != STATUS_OK)) {
        return launcher_fail(launcher, "cannot create shared memory (is /dev/shm full?) for the supervisor ",
                             name);
    }
    osal_shm_close(&shm); // The memory exists until its name is removed.
    return true;
}

// ---- Sockets ----

static bool listen_to_ground(launcher_t* const launcher)
{
    const bool is_asked  = (launcher->options.port != 0U);
    const uint16_t first = is_asked ? launcher->options.port : launcher->mission.ground_port;
    const uint32_t ipv4  = (launcher->mission.is_ground_open != 0U) ? 0U : OSAL_IPV4_LOOPBACK;
    status_t status      = STATUS_EXISTS;
    uint16_t port        = first;
    for (unsigned i = 0U; (status == STATUS_EXISTS) && (i < (is_asked ? 1U : PORT_TRIES)); i++) {
        port   = (uint16_t)(first + i);
        status = osal_tcp_listen(&launcher->ground, (osal_address_t){ipv4, port});
    }
    char endpoint[32];
    text_t text = text_in(endpoint, sizeof endpoint);
    text_add(&text, (ipv4 == OSAL_IPV4_LOOPBACK) ? "127.0.0.1:" : "0.0.0.0:");
    text_add_unsigned(&text, first);
    if (status != STATUS_OK) {
        const bool is_used = (status == STATUS_EXISTS);
        return launcher_refuse(
            launcher, (const char* const[]){is_used ? "the ground port is in use on " : "cannot listen on ",
                                            endpoint, is_used ? "; choose another one with --port" : ": ",
                                            is_used ? "" : status_text(status), NULL});
    }
    launcher->run->ground_port       = port;
    launcher->run->ground_descriptor = osal_socket_descriptor(&launcher->ground);
    return true;
}

/// Write one line of text into a file of the run's directory.
static bool write_line(launcher_t* const launcher, const char* const name, const char* const line)
{
    char path[LAUNCH_PATH_MAX + 32U];
    osal_file_t file = {-1};
    (void)text_join(path, sizeof path, (const char* const[]){launcher->run->directory, name, NULL});
    if (osal_file_create(&file, path) != STATUS_OK) {
        return launcher_refuse(
            launcher, (const char* const[]){"cannot write the output directory: ", path,
                                            "; make it writable, or choose another one with --out", NULL});
    }
    const bool is_written = (osal_file_write(&file, line, strlen(line)) == STATUS_OK) &&
                            (osal_file_write(&file, "\n", 1U) == STATUS_OK);
    osal_file_close(&file);
    return is_written || launcher_fail(launcher, "cannot write (is the disk full?) ", path);
}

/// Write mission, scenario, world, device classes and port to files that ground tools read.
static bool write_ground_files(launcher_t* const launcher)
{
    char digits[16];
    char classes[24];
    text_t text = text_in(classes, sizeof classes);
    text_add_hex(&text, DEVICE_CLASSES_HASH, 16U);
    text = text_in(digits, sizeof digits);
    text_add_unsigned(&text, launcher->run->ground_port);
    return write_line(launcher, "/ground.mission", launcher->options.mission) &&
           write_line(launcher, "/ground.scenario", launcher->options.scenario) &&
           write_line(launcher, "/ground.world", launcher->options.world) &&
           write_line(launcher, "/ground.classes", classes) && write_line(launcher, "/ground.port", digits) &&
           ((launcher->run->key[0] == '\0') ||
            write_line(launcher, "/ground.key-file", launcher->run->key)) &&
           (run_summary_reserve(launcher) ||
            launcher_refuse(launcher,
                            (const char* const[]){"no disk space for run.json in ", launcher->run->directory,
                                                  "; free some, or choose another one with --out", NULL}));
}

/// Place the co-simulation port in the directory of shared memories. Therefore containers, each with its own
/// /dev/shm, have separate ports even if the process numbers are the same, and the clean-up after a killed
/// launcher removes the port.
static void name_cosimulation(launcher_t* const launcher)
{
    (void)text_join(launcher->cosimulation, sizeof launcher->cosimulation,
                    (const char* const[]){"/dev/shm/", launcher->run->identity, ".cosim", NULL});
}

static void begin(launcher_t* const launcher, const launch_options_t* const options,
                  const char* const program_directory)
{
    (void)memset(launcher, 0, sizeof *launcher);
    launcher->options           = *options;
    launcher->program_directory = program_directory;
    launcher->ground.descriptor = -1;
    for (size_t i = 0U; i < MISSION_SUBSYSTEMS_MAX; i++) {
        launcher->messages[i].descriptor = -1;
    }
    for (size_t i = 0U; i < MISSION_BUSES_MAX; i++) {
        launcher->buses[i].claim.descriptor = -1;
    }
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        launcher->links[i].descriptor  = -1;
        launcher->relays[i].descriptor = -1;
    }
}

/// Read the mission and check whether it can be flown on this machine.
static bool read_mission(launcher_t* const launcher, char* const path, const size_t capacity)
{
    return load_mission(launcher, path, capacity) && choose_methods(launcher, path) &&
           find_programs(launcher, path) && check_key(launcher, path) &&
           launcher_set_limits(launcher, path) && launcher_check_device_classes(launcher) &&
           launcher_check_streams(launcher, path);
}

bool launcher_prepare(launcher_t* const launcher, const launch_options_t* const options,
                      const char* const program_directory)
{
    char path[LAUNCH_PATH_MAX];
    char directory[LAUNCH_PATH_MAX];
    begin(launcher, options, program_directory);
    (void)osal_shm_each(FAMILY, sweep, NULL);
    const bool is_ready =
        read_mission(launcher, path, sizeof path) && launcher_check_remote_endian(launcher) &&
        launcher_check_system(launcher) && find_inputs(launcher) && launcher_ready_interfaces(launcher) &&
        create_directory(launcher, directory, sizeof directory) && create_run(launcher, path, directory) &&
        create_scheduler(launcher) && create_checkpoint(launcher) && launcher_create_buses(launcher) &&
        launcher_create_computers(launcher) && launcher_open_sockets(launcher) &&
        listen_to_ground(launcher) && write_ground_files(launcher);
    if (is_ready) {
        name_cosimulation(launcher);
        // Time begins 0.3 s later, when all processes have started.
        launcher->run->origin_ns = osal_clock_monotonic_ns() + 300000000U;
    }
    return is_ready;
}

void launcher_take_over(launcher_t* const launcher, const launch_options_t* const options,
                        const char* const program_directory, run_state_t* const run)
{
    char path[LAUNCH_PATH_MAX];
    begin(launcher, options, program_directory);
    if (load_mission(launcher, path, sizeof path) && choose_methods(launcher, path)) {
        launcher_adopt_interfaces(launcher);
    }
    launcher->run           = run;
    launcher->is_taken_over = true;
    // Simulated time does not determine the instant of the launcher's death.
    launcher->is_undetermined = true;
    launcher->is_broken       = true;
    // An error while the mission was read is dropped: the mission may have become unreadable.
    launcher->reason[0] = '\0';
    (void)launcher_fail(launcher, "the launcher was killed, and all other processes of the run with it", "");
    if (run == NULL) {
        return;
    }
    name_cosimulation(launcher);
    if (run->is_stepped && run_name(run, "scheduler", 0U, path, sizeof path) &&
        (osal_shm_open(&launcher->scheduler_shm, path) == STATUS_OK)) {
        launcher->scheduler = osal_lockstep_attach(osal_shm_address(&launcher->scheduler_shm));
    }
    launcher->last_simulated_ns = launcher_now_ns(launcher);
}
