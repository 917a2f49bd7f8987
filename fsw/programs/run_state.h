// SPDX-License-Identifier: Apache-2.0
/// Data that the processes of one run share: components, their addresses, and requests between the launcher
/// and the supervisor. It is the shared memory "/<identity>.run", which the launcher creates before it
/// starts any other process. Packets must not contain any of these data.
///
/// Participants of the scheduler: 0 simulator, then the mission's subsystems in its order, then the operator,
/// then the relay of links.
#ifndef FSW_PROGRAMS_RUN_STATE_H
#define FSW_PROGRAMS_RUN_STATE_H

#include "base/capacities.h"
#include "base/status.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "osal/include/osal/shm.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RUN_LINKS_MAX CAPACITY_LINKS
// A program on a board, which has its own copy of the run state, defines smaller values of both.
#ifndef RUN_FLOWS_MAX
#define RUN_FLOWS_MAX 32U
#define RUN_PROCESSES_MAX 64U
#endif
#define RUN_IDENTITY_MAX 24U
#define RUN_PATH_MAX 256U
#define RUN_NAME_MAX 64U
#define RUN_SIMULATOR 0U                     ///< Number of the simulator as participant.
#define RUN_COMPUTERS_MAX CAPACITY_COMPUTERS ///< On-board computers.
#define RUN_STEP_NS 500000U                  ///< Time step of the scheduler [ns].

typedef enum { // Carrier of messages between processes.
    RUN_TRANSPORT_UDP  = 0,
    RUN_TRANSPORT_TIPC = 1
} run_transport_t;

typedef enum {
    RUN_PROCESS_STOPPED = 0,
    RUN_PROCESS_RUNNING = 1,
    RUN_PROCESS_LOST    = 2
} run_process_t;

typedef struct {
    uint16_t apid;
    char name[DESCRIPTOR_NAME_MAX + 1U];
    uint8_t computer;          ///< Index of the on-board computer that it runs on.
    int message_descriptor;    ///< UDP or TIPC socket that the process inherits; -1 in the image.
    uint16_t message_port;     ///< UDP port of the message socket.
    uint64_t message_identity; ///< TIPC identity of the message socket.
    uint32_t message_window;   ///< Window of its channels (message_set_window); 0: MESSAGE_WINDOW_OCTETS.
    /// Written by the supervisor (the first life by the launcher):
    uint32_t life;        ///< Number of the last start that was commanded, from 1.
    uint32_t link_floor;  ///< Links of the life `life` have epochs above this number.
    uint32_t wanted_life; ///< The life that must run; 0: none.
    uint32_t kill_life;   ///< The last life that must be killed because it hangs.
    /// Written by the launcher:
    uint32_t found_life; ///< Life of the process that was started last.
    uint32_t process;    ///< State of that process: run_process_t.
    uint32_t hung_life;  ///< The last life that the launcher has found to hang, and has suspended.
} run_component_t;

#define RUN_LATENESS 5U ///< Classes of lateness.

typedef struct {      // Last step of one component, in its own cache line; only the component writes it.
    uint64_t step_ns; ///< Time of its last step [ns of the run].
    uint64_t wake_ns; ///< Latest time of its next step, as promised.
    /// Steps at a promised time that were late by less than 0.1 ms, 1 ms, 10 ms, 100 ms, and more.
    uint32_t late[RUN_LATENESS];
    /// Padding to a cache line.
    uint32_t line[7];
} run_beat_t;

typedef struct {               // Addresses of one CAN bus (osal/can.h); in the mission's order.
    char flight[RUN_NAME_MAX]; ///< Controller of the flight software.
    /// Wire end of the simulator; "": the simulator does not simulate this bus.
    char simulator[RUN_NAME_MAX];
    char published[RUN_NAME_MAX]; ///< Address where the simulator publishes the bus to tools; "": none.
} run_bus_t;

typedef struct {    // A shared memory or message queue that a component creates for one of its flows.
    uint32_t state; ///< 0: free; 1: is being written; 2: contains a name.
    char name[RUN_NAME_MAX];
} run_flow_t;

/// Difference between the address of an on-board computer and the address of its end of the delayed network
/// for links.
#define RUN_LINK_NETWORK 4U

// The relay that delays the links; frames pass through it from producers to consumers.
typedef struct {
    uint32_t delay_us; ///< Mean delay of a frame; 0: links have no delay.
    /// There is no relay: a network between two computers delays the frames, in wall-clock time.
    bool is_network;
    uint32_t jitter_us; ///< The delay of a frame differs by at most this from the mean.
    uint64_t seed;      ///< Seed from which jitter and loss are drawn.
    /// UDP socket to which the producer of link number i + 1 sends; -1 if there is none.
    int descriptors[RUN_LINKS_MAX];
    uint16_t ports[RUN_LINKS_MAX];    ///< UDP port of that socket.
    uint8_t consumers[RUN_LINKS_MAX]; ///< Component that receives the frames of the link.
    /// Written by the relay:
    uint64_t delayed;   ///< Frames passed on.
    uint64_t lost;      ///< Frames lost.
    uint64_t reordered; ///< Frames passed on after a later one.
} run_relay_t;

typedef struct {
    uint32_t magic;
    char identity[RUN_IDENTITY_MAX]; ///< "hirosco-<number>": prefix of every name of this run.
    bool is_stepped;                 ///< The processes take part in the scheduler.
    bool has_simulator;              ///< Devices are simulated, at addresses of the run.
    /// Time follows the clock of the machine, so it continues while a process waits for a disk.
    bool is_real;
    uint8_t transport; ///< run_transport_t.
    uint32_t instance; ///< Number of this mission instance, part of its TIPC names.
    uint8_t computer_count;
    /// Address of each computer: loopback, or its end of the virtual Ethernet (veth).
    uint32_t computer_ipv4[RUN_COMPUTERS_MAX];
    uint8_t link_methods; ///< Bit set of 1 << rtlink_method_t.
    uint64_t origin_ns;   ///< Real time: mission time 0 on the machine's monotonic clock.
    char mission_path[RUN_PATH_MAX];
    uint64_t mission_hash;        ///< Configuration hash of the whole mission.
    char directory[RUN_PATH_MAX]; ///< Output directory.
    char storage[RUN_PATH_MAX];   ///< Directory of persistent data.
    char key[RUN_PATH_MAX];       ///< File with the key of telecommands; "": telecommands need none.
    int ground_descriptor;        ///< Listening TCP socket that `communication` inherits.
    uint16_t ground_port;
    uint16_t component_count;
    run_component_t components[MISSION_SUBSYSTEMS_MAX];
    run_beat_t beats[MISSION_SUBSYSTEMS_MAX];
    run_bus_t buses[MISSION_BUSES_MAX];
    /// Objects of flows. If a component has died, the launcher removes its objects.
    run_flow_t flows[RUN_FLOWS_MAX];
    /// UDP or TIPC socket of the consumer of link number i + 1; -1 if there is none.
    int link_descriptors[RUN_LINKS_MAX];
    uint16_t link_ports[RUN_LINKS_MAX];
    run_relay_t relay;
    uint32_t is_stop_requested; ///< Ctrl-C: the supervisor shuts the mission down.
    uint32_t is_finished;       ///< The supervisor has shut the mission down.
    uint32_t has_operator_left; ///< Image: the operator no longer takes part in simulated time.
    uint32_t is_intruded;       ///< A client outside the scheduler has connected or sent telecommands.
    uint32_t is_lossy;          ///< An octet or a datagram that was announced has not arrived.
    /// Number of records of the packet log so far, including those that are no longer kept.
    uint64_t log_records;
    uint32_t is_cleaned_up; ///< The launcher has cleaned up completely; the guard reads this.
    uint32_t process_count; ///< Children started so far; `processes` has the ids of the last ones.
    int32_t processes[RUN_PROCESSES_MAX];
} run_state_t;

/// Map the run state that the launcher has created. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID (another
/// version), STATUS_DENIED, STATUS_IO.
MUST_USE status_t run_state_attach(osal_shm_t* shm, const char* name, run_state_t** out_block);
/// Create the run state of a run. STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED, STATUS_DENIED, STATUS_IO.
MUST_USE status_t run_state_create(osal_shm_t* shm, const char* identity, run_state_t** out_block);

/// Find the index of the component with an APID. False if there is none.
bool run_state_find(const run_state_t* block, uint16_t apid, unsigned* out_index);
/// Returns the participant number of a component.
static inline unsigned run_participant(const unsigned component)
{
    return component + 1U;
}
/// Record how late a component is that begins a step at `now_ns`. For components with clocks of their own.
void run_state_wake(run_state_t* block, unsigned component, uint64_t now_ns);
/// Record that a component has stepped at `now_ns` and promises to step again at `wake_ns`, which is
/// OSAL_LOCKSTEP_NEVER before the first step of a life.
void run_state_beat(run_state_t* block, unsigned component, uint64_t now_ns, uint64_t wake_ns);
/// Returns the last step of a component, without the classes of lateness.
run_beat_t run_state_last_beat(const run_state_t* block, unsigned component);
/// Returns the participant number of the operator.
static inline unsigned run_operator(const run_state_t* const block)
{
    return (unsigned)block->component_count + 1U;
}
/// Returns the participant number of the relay of links.
static inline unsigned run_relay(const run_state_t* const block)
{
    return (unsigned)block->component_count + 2U;
}
/// Service types of this run's TIPC names: run_message_type for messages (instance: APID), run_link_type for
/// links (instance: number of the link).
static inline uint32_t run_message_type(const run_state_t* const block)
{
    return 0x48000000U | (block->instance & 0x00FFFFFFU);
}
static inline uint32_t run_link_type(const run_state_t* const block)
{
    return 0x4C000000U | (block->instance & 0x00FFFFFFU);
}
/// Record the name of a flow's object before the object is created; each name is recorded once. STATUS_OK,
/// STATUS_EXHAUSTED (RUN_FLOWS_MAX, or longer than RUN_NAME_MAX). Several components may call it at the same
/// time.
MUST_USE status_t run_state_note_flow(run_state_t* block, const char* name);
/// Write "/<identity>.<what>", followed by `number` if it is not 0. False if the name does not fit.
bool run_name(const run_state_t* block, const char* what, unsigned number, char* out_name, size_t capacity);

#endif // FSW_PROGRAMS_RUN_STATE_H
