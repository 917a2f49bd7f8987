// SPDX-License-Identifier: Apache-2.0
/// The launcher: the parent of all processes of a run. It creates the directory and the shared objects of the
/// run, starts the processes, starts processes again when the supervisor orders this, and removes the shared
/// objects at the end.
///
/// Ownership  The program provides launcher_t.
/// Context    One task.
#ifndef LAUNCHER_LAUNCHER_H
#define LAUNCHER_LAUNCHER_H

#include "launcher/launch_options.h"
#include "launcher/return_budget.h"
#include "fsw/programs/run_state.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/network.h"
#include "osal/include/osal/process.h"
#include "osal/include/osal/socket.h"

#define LAUNCHER_CHILDREN_MAX (MISSION_SUBSYSTEMS_MAX + 4U)
#define LAUNCHER_REASON_MAX 512U

typedef struct { // Private: one child process.
    const char* name;
    osal_process_t process;
    bool is_alive;
    bool has_run;
    bool is_component;
    bool is_seen;             // The output of the process appears on the terminal instead of in console.log.
    unsigned component;       // Index of the component that the process runs, if is_component.
    unsigned participant;     // Number as participant of the scheduler; OSAL_LOCKSTEP_PARTICIPANTS_MAX: none.
    uint32_t life;            // Life of the component that it was started for.
    uint64_t started_ns;      // Wall-clock time at which this life of a component was started.
    uint64_t asked_to_end_ns; // Wall-clock time since which the process must end; 0: it must run.
    bool is_asked;            // A signal has asked the process to end.
    osal_process_result_t result;
    uint64_t memory_high_kib; // Peak memory of all its lives.
} child_t;

typedef struct { // Private: the interfaces of one bus; "" if there is none.
    char flight[OSAL_CAN_INTERFACE_NAME_MAX + 1U];
    char simulator[OSAL_CAN_INTERFACE_NAME_MAX + 1U];
    char published[OSAL_CAN_INTERFACE_NAME_MAX + 1U];
    bool is_fd;
    bool is_flight_made; // The interface was created by this launcher or a killed one, and must be removed.
    bool is_published_made;
    osal_can_claim_t claim;
} launcher_bus_t;

// Private: the process that holds the grant of the scheduler; in a run without a scheduler, the supervisor.
typedef struct {
    unsigned holder;
    uint32_t grants;
    // Wall-clock time at which the launcher first saw that it holds this grant; 0: no holder.
    uint64_t since_ns;
    uint64_t processor_ns; // Processor time that it had used at that time.
    uint64_t step_ns;      // Without a scheduler: last step of the supervisor at that time.
    // Wall-clock time since which simulated time has waited for a participant to join; 0: none.
    uint64_t join_ns;
} launcher_watch_t;

typedef struct { // Private, except `guard`, `exit_code` and `reason`.
    launch_options_t options;
    const char* program_directory;
    mission_descriptor_t mission;
    subsystem_descriptor_t scratch;
    descriptor_loader_t loader;
    run_state_t* run;
    osal_shm_t run_shm;
    osal_shm_t scheduler_shm;
    osal_lockstep_t* scheduler;
    osal_network_t home; // Network namespace of the launcher itself, while it has entered another one.
    osal_socket_t ground;
    char key_path[RUN_PATH_MAX]; // Key of telecommands; "": telecommands need none.
    osal_socket_t messages[MISSION_SUBSYSTEMS_MAX];
    osal_socket_t links[RUN_LINKS_MAX];
    osal_socket_t relays[RUN_LINKS_MAX]; // Sockets to which the producers send, if there is a relay.
    launcher_bus_t buses[MISSION_BUSES_MAX];
    uint32_t late_frames; // Sum over all buses with announced frames, as the next two fields.
    uint32_t lost_frames;
    uint32_t external_frames;
    // Number of times that an interface was lost while it was in use.
    uint32_t bus_cuts;
    int tool_code;                                     // Exit code of the last tool.
    uint32_t memory_limit_kib[MISSION_SUBSYSTEMS_MAX]; // Limits of the address space of the components.
    child_t children[LAUNCHER_CHILDREN_MAX];
    size_t child_count;
    struct guard* guard; // Process that cleans up if this one is killed; null: there is no guard.
    bool is_taken_over;  // This process is the guard, and the launcher was killed.
    char cosimulation[LAUNCH_PATH_MAX];
    char scenario_path[LAUNCH_PATH_MAX];
    bool has_operator;
    char world_path[LAUNCH_PATH_MAX]; // File of the world that the simulator simulates.
    uint64_t first_wall_ns;           // Wall-clock time at which simulated time first advanced.
    uint64_t first_simulated_ns;
    uint64_t last_wall_ns;
    uint64_t last_simulated_ns;
    uint64_t abandon_ns; // Simulated time at which a run that does not shut down by itself is ended.
    // Simulated time at which the operator ended with exit code 0, plus 1; 0: it has not ended.
    uint64_t left_ns;
    // Simulated time when its last advance was seen; the next field has the wall-clock time.
    uint64_t moved_simulated_ns;
    uint64_t moved_wall_ns;
    launcher_watch_t watch;
    bool is_cut_short;       // The run was ended at an instant that simulated time does not determine.
    bool is_ended_by_user;   // Ended by Ctrl-C or --duration, which cut the script of the operator.
    bool is_broken;          // A process of the run has died.
    return_budget_t returns; // Limits how often the supervisor is started again.
    uint64_t return_wall_ns; // Wall-clock time at which the launcher must start the supervisor again.
    bool is_undetermined;    // A process died at an instant that simulated time does not determine.
    int exit_code;
    char reason[LAUNCHER_REASON_MAX];
} launcher_t;

/// Read the mission, and create the directory and the shared objects. False: `reason` contains the error and
/// the next step.
bool launcher_prepare(launcher_t* launcher, const launch_options_t* options, const char* program_directory);
/// Start all processes and wait until the run has ended. exit_code and reason are the result.
void launcher_fly(launcher_t* launcher);
/// End remaining processes, remove every name of the run (shared memory, queues, sockets, interfaces and
/// namespaces), complete the logs, write run.json and the report.
void launcher_clean_up(launcher_t* launcher);

#endif // LAUNCHER_LAUNCHER_H
