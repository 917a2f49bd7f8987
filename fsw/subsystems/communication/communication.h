// SPDX-License-Identifier: Apache-2.0
/// The communication subsystem: transfers packets between the ground port (TCP) and the supervisor. Requests
/// go to the supervisor unchanged and unchecked. Reports go to the connections of their request or user
/// (ground_routes.h); unsolicited reports go to every connection.
///
/// In stepped time, one client may be a participant of the scheduler. Its connection is expected as soon as
/// the scheduler names its port, and exactly the announced octets are received. The participant is informed
/// in simulated time when its connection is served, and when it has ended. Other clients are accepted at any
/// time, but make the run irreproducible, because events and counters report them.
///
/// Ownership  The program provides communication_t (static; about 2.1 MiB).
/// Context    One loop; never blocks.
#ifndef FSW_SUBSYSTEMS_COMMUNICATION_COMMUNICATION_H
#define FSW_SUBSYSTEMS_COMMUNICATION_COMMUNICATION_H

#include "fsw/framework/dataflow/flow_tcp.h"
#include "fsw/framework/subsystem/subsystem_core.h"
#include "fsw/subsystems/communication/ground_queue.h"
#include "fsw/subsystems/communication/ground_routes.h"
#include "fsw/subsystems/communication/ground_security.h"
#include "generated/communication_descriptor.h"

#define COMMUNICATION_CLIENTS GROUND_CLIENTS
/// Received octets of one client that are not processed yet: at least one complete packet or protected
/// frame.
#define COMMUNICATION_BUFFER 5120U
CAPACITY_CHECK(buffer_holds_a_packet, COMMUNICATION_BUFFER >= PUS_PACKET_MAX);
CAPACITY_CHECK(buffer_holds_a_frame, COMMUNICATION_BUFFER >= SDLS_FRAME_MAX);
/// Silence [ns] after which a new client may replace a client: the one that has sent no valid telecommand for
/// the longest time.
#define COMMUNICATION_IDLE_NS 10000000000ULL
/// Without a key, if no client is silent: time of a connection [ns] after which a new client may replace the
/// client that has been connected longest.
#define COMMUNICATION_HOLD_NS 30000000000ULL
CAPACITY_CHECK(silence_is_found_first, COMMUNICATION_IDLE_NS < COMMUNICATION_HOLD_NS);
#define COMMUNICATION_REPORT_NS 1000000000ULL ///< Shortest time between two events GROUND_MISUSED.

typedef struct { // No function may be null.
    void* context;
    /// Called when octets have been sent to the client whose own port is `peer_port`.
    void (*sent)(void* context, uint16_t peer_port, uint32_t octets);
    /// Returns the port of the participant of the scheduler; 0 if there is none.
    uint16_t (*participant_port)(void* context);
    /// Called when the connection of the participant with this port begins to be served.
    void (*served)(void* context, uint16_t port);
    /// Called when the connection has ended although the participant has not left the scheduler.
    void (*cut)(void* context, uint16_t port);
    /// Called when a client that is not a participant has connected or has sent a telecommand.
    void (*intruded)(void* context);
} communication_hooks_t;

typedef struct { // Private.
    subsystem_t* generic;
    pus_port_t uplink;
    communication_hooks_t hooks;
    int listener;
    flow_tcp_t flow;
    quota_t sockets;
    flow_tcp_client_t clients[COMMUNICATION_CLIENTS];
    communication_ground_routes_t routes;
    // Last port of a participant that was connected or given up; 0: none, or the participant has closed its
    // connection.
    uint16_t participant;
    uint32_t outstanding; // Octets of the participant that were announced and not received yet.
    bool is_uplink_full;  // A request could not be passed to the supervisor in this step.
    bool is_drop_reported;
    uint64_t connected_ns[COMMUNICATION_CLIENTS];
    uint64_t heard_ns[COMMUNICATION_CLIENTS]; // Time of the connection, or of the last valid telecommand.
    uint32_t misuse_reported;                 // Sum of the counters in the last event.
    uint64_t misuse_reported_ns;
    uint32_t not_requests;                 // Packets that are no request of a ground user [wraps].
    communication_parameters_t parameters; // Published parameters.
    communication_ground_security_t security;
    communication_ground_queue_t queues[COMMUNICATION_CLIENTS];
    uint8_t buffers[COMMUNICATION_CLIENTS * COMMUNICATION_BUFFER]; // Not cleared by communication_init.
} communication_t;

/// Initialise. listener: descriptor of the listening socket, which the launcher has opened. uplink: port to
/// which requests are sent.
void communication_init(communication_t* communication, subsystem_t* generic, const pus_port_t* uplink,
                        const communication_hooks_t* hooks, int listener);
/// Accept only authenticated telecommands. Call it before the subsystem is configured; the receiver must
/// outlive the subsystem.
void communication_secure(communication_t* communication, sdls_receiver_t* receiver);
const subsystem_callbacks_t* communication_callbacks(void);
/// Receive octets from the ground; `octets_due` more were announced for the participant. Call it before the
/// component's step. True if something of the participant is still missing: its connection, announced octets
/// or, when it has left the scheduler, the end of its connection. Then wait and call again.
bool communication_take_in(communication_t* communication, uint32_t octets_due);
/// Give up waiting for the connection of the participant, or for the end of its connection if it has left.
void communication_stop_waiting(communication_t* communication);
/// Send waiting reports. Call it after the component's step.
void communication_send_out(communication_t* communication);
/// List the open sockets for which the program waits. Returns their number, <= COMMUNICATION_CLIENTS + 1.
size_t communication_sockets(communication_t* communication, osal_socket_t** out_sockets, size_t capacity);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_COMMUNICATION_H
