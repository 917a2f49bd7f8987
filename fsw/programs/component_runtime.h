// SPDX-License-Identifier: Apache-2.0
/// The connection of one component to a run: its clock, its message endpoint, and the resolvers that convert
/// logical names into addresses of this run. In the form `processes` each program has one runtime; the image
/// has one for each component.
///
/// Ownership  The caller provides the runtimes (static).
/// Context    One task.
#ifndef FSW_PROGRAMS_COMPONENT_RUNTIME_H
#define FSW_PROGRAMS_COMPONENT_RUNTIME_H

#include "fsw/programs/run_state.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/ring_carrier.h"
#include "fsw/framework/message/tipc_carrier.h"
#include "fsw/framework/message/udp_carrier.h"
#include "fsw/framework/rtlink/link_channel.h"
#include "osal/include/osal/clock.h"
#include "pus/core/app_process.h"

#define COMPONENT_RUNTIME_SOCKETS_MAX OSAL_CLOCK_SOCKETS_MAX
#define COMPONENT_RUNTIME_ERROR_MAX 512U

/// Source of a program's descriptors: files (descriptor_files.h), or constants that were compiled into it
/// (compiled_descriptors.h).
typedef struct {
    void* context;
    /// Get the mission and the descriptor of component `index` of the run. Null, or the error text.
    const char* (*load)(void* context, const run_state_t* run, unsigned index,
                        const mission_descriptor_t** out_mission, subsystem_descriptor_t** out_own);
    /// Read a descriptor from `path` into the spare model, which is valid until the next call. STATUS_OK; any
    /// other status: the error text is appended.
    status_t (*read)(void* context, const char* path, subsystem_descriptor_t** out_spare, text_t* error);
    /// Use the spare model from now on; `old`, the model that was used until now, becomes the spare one.
    void (*exchange)(void* context, subsystem_descriptor_t* old);
} component_descriptors_t;

#ifndef COMPONENT_PLAY_OUTS_MAX
#define COMPONENT_PLAY_OUTS_MAX 4U ///< Links with a relay that one program consumes.
#endif

typedef struct {                             // Play-out buffers of a program; private, all zero at first.
    uint16_t links[COMPONENT_PLAY_OUTS_MAX]; // Number of the link that uses the buffer; 0: none.
    rtlink_play_out_t buffers[COMPONENT_PLAY_OUTS_MAX];
} component_play_outs_t;

typedef struct { // Private to fsw/programs.
    run_state_t* run;
    const mission_descriptor_t* mission;
    unsigned component; ///< Index in run->components.
    uint16_t apid;
    /// The component's descriptor, which was read with the mission; the component may reload it.
    subsystem_descriptor_t* own;
    const component_descriptors_t* descriptors; ///< Reads a descriptor again.
    component_play_outs_t* play_outs;
    osal_clock_t clock;
    osal_deliveries_t deliveries; // Used if the program cannot access the scheduler.
    message_endpoint_t endpoint;
    message_udp_carrier_t udp;
    message_tipc_carrier_t tipc;
    osal_socket_t topology; // Notices of the kernel about TIPC names.
    uint32_t life;          // Life of this component.
    uint32_t link_floor;    // Links of this life have epochs above this number.
    // For each component, from the run state at the last call of component_runtime_pump.
    struct {
        uint32_t life;
        uint32_t link_floor;
        uint64_t reported_ns; // Time of the first message sent to it since its last step.
        bool is_gone;         // The process of that life has ended, and its messages were received.
    } peers[MISSION_SUBSYSTEMS_MAX];
    /// Number of calls of component_runtime_pump.
    uint32_t pumps;
    uint32_t outstanding; // Datagrams that were announced and not received yet: the connection may be cut.
    // Consecutive intakes (calls of component_runtime_pump) that received less than was announced.
    uint32_t short_intakes;
    osal_socket_t message_socket;
    osal_socket_t link_sockets[CAPACITY_SUBSYSTEM_LINKS]; // Sockets of links that this component consumes.
    uint32_t link_socket_count;                           // Number of link_sockets in use.
    osal_socket_t link_sender;                            // Socket for links that it produces.
    flow_resolver_t flows;
    rtlink_resolver_t links;
    pus_port_t uplink; ///< Port for packets to the supervisor.
    char error[COMPONENT_RUNTIME_ERROR_MAX];
    bool is_kept;                         // The message channels continue although the component restarts.
    message_ring_carrier_t* ring_carrier; // Null: messages by UDP or TIPC, as the run selects.
} component_runtime_t;

typedef struct { // Shared by the components of a program.
    run_state_t* run;
    const mission_descriptor_t* mission;
    const component_descriptors_t* descriptors;
    component_play_outs_t* play_outs;
    /// Null: real time, or a granted clock (osal_clock_take_grant) in a stepped run.
    osal_lockstep_t* scheduler;
    message_ring_carrier_t* ring_carrier; ///< Null: messages by UDP or TIPC, as the run selects.
} component_runtime_surroundings_t;

/// Initialise the runtime for component `index` of the run, whose descriptor is `own`. The component then
/// opens its inbox. STATUS_OK; any other status: `error` contains the reason.
MUST_USE status_t component_runtime_take(component_runtime_t* runtime,
                                         const component_runtime_surroundings_t* surroundings,
                                         subsystem_descriptor_t* own, unsigned index);
/// Give the endpoint the slots in which messages to this component wait: one for each peer. The peers of the
/// supervisor are all other components; the only peer of another component is the supervisor. `slots` must
/// remain valid as long as the runtime. No message is received before this call.
/// STATUS_OK (at once after component_runtime_keep); any other status: `error` contains the reason.
MUST_USE status_t component_runtime_open_inbox(component_runtime_t* runtime, message_slot_t* slots,
                                               size_t slot_count);
/// Call it instead of component_runtime_take if a component restarts in the same program and continues its
/// earlier life: the message endpoint and the messages in its inbox are kept.
void component_runtime_keep(component_runtime_t* runtime);
/// List the sockets that wake this component, for the program's wait. Returns their number.
size_t component_runtime_sockets(component_runtime_t* runtime, osal_socket_t** out_sockets, size_t capacity);
/// Receive the datagrams that have arrived; frames of links go to `link_datagram`. In stepped time, wait for
/// those of the announced `messages` that the kernel has not delivered yet, but not longer than five seconds:
/// the run then continues without them and is marked as lossy. Datagrams to an earlier life of this component
/// are dropped; they are not among the announced ones.
void component_runtime_pump(component_runtime_t* runtime, uint32_t messages,
                            void (*link_datagram)(void* context, const uint8_t*, size_t), void* context);
/// Announce to the scheduler a message to component `to`, in the life to which it was sent.
void component_runtime_delivered(void* context, uint16_t to);
/// Record that a message was sent to another component at `now_ns` [ns of the run].
void component_runtime_note_sent(component_runtime_t* runtime, unsigned component, uint64_t now_ns);
/// Returns the latest time of the next step of another component: the promise of its last step, or, before
/// the first step of a life, the beginning of that life. OSAL_LOCKSTEP_NEVER if it is unknown. `scheduler`
/// may be null.
uint64_t component_runtime_promise_ns(const component_runtime_t* runtime, osal_lockstep_t* scheduler,
                                      unsigned component);
/// Kill the supervisor if it is later than its promise by more than the mission allows. Each component must
/// do this, because the supervisor, which detects hanging components, cannot detect that it hangs itself.
/// Call it after each step. No effect with a null scheduler (time is not stepped).
void component_runtime_watch_supervisor(const component_runtime_t* runtime, osal_lockstep_t* scheduler,
                                        uint64_t now_ns);
/// Returns the life of another component to which messages are delivered now, as the scheduler counts lives.
uint32_t component_runtime_life_of(const component_runtime_t* runtime, unsigned component);
/// Close everything that the runtime itself has opened; inherited sockets stay open for the next life.
void component_runtime_leave(component_runtime_t* runtime);

#endif // FSW_PROGRAMS_COMPONENT_RUNTIME_H
