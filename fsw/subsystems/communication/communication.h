// SPDX-License-Identifier: Apache-2.0
/// The communication subsystem: frames packets between the ground port (TCP) and the supervisor. It does not
/// check them: requests go to the supervisor unchanged, reports go to the connections of their request or
/// user (ground_routes.h) or, unsolicited, to every connection.
///
/// Stepped time: one client may be a participant of the scheduler. Its connection is expected as soon as the
/// scheduler names its port, and exactly the announced octets are received. The participant is
/// informed in simulated time when its connection is served, and when it has ended. Other clients are
/// accepted at any time and make the run irreproducible, since they show in events and counters.
///
/// Ownership  The program places communication_t (static; about 2.2 MiB).
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
/// Received octets of one client that are not processed yet: one whole packet or protected frame, and more.
#define COMMUNICATION_BUFFER 5120U
CAPACITY_CHECK(buffer_holds_a_packet, COMMUNICATION_BUFFER >= PUS_PACKET_MAX);
CAPACITY_CHECK(buffer_holds_a_frame, COMMUNICATION_BUFFER >= SDLS_FRAME_MAX);
/// A new client may replace one that has sent no valid telecommand for this time; the longest silent first.
#define COMMUNICATION_IDLE_NS 10000000000ULL
/// Without a key, if no client is silent, it may replace one that has been connected for this time; the
/// longest connected first.
#define COMMUNICATION_HOLD_NS 30000000000ULL
CAPACITY_CHECK(silence_is_found_first, COMMUNICATION_IDLE_NS < COMMUNICATION_HOLD_NS);
#define COMMUNICATION_REPORT_NS 1000000000ULL ///< Shortest time between two events GROUND_MISUSED.

typedef struct {
    void* context;
    /// Octets have been sent to the client with this local port at its end.
    void (*sent)(void* context, uint16_t peer_port, uint32_t octets);
    /// Port of the participant of the scheduler, 0 if there is none.
    uint16_t (*participant_port)(void* context);
    /// The connection of the participant with this port is served from now on.
    void (*served)(void* context, uint16_t port);
    /// The connection has ended, though the participant has not left.
    void (*cut)(void* context, uint16_t port);
    /// A client that is not a participant has connected, or one of its telecommands was received.
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
    // Last port that was connected or abandoned; 0: none, or the participant has closed the connection.
    uint16_t participant;
    uint32_t outstanding; // Octets of the participant that are announced and not received yet.
    bool is_uplink_full;  // A request could not go up in this step.
    bool is_drop_reported;
    uint64_t connected_ns[COMMUNICATION_CLIENTS];
    uint64_t heard_ns[COMMUNICATION_CLIENTS]; // Connection, or last valid telecommand.
    uint32_t misuse_reported;                 // Sum of the counters in the last event.
    uint64_t misuse_reported_ns;
    uint32_t not_requests;                 // Packets of the ground that are no telecommands [wraps].
    communication_parameters_t parameters; // Published.
    communication_ground_security_t security;
    communication_ground_queue_t queues[COMMUNICATION_CLIENTS];
    uint8_t buffers[COMMUNICATION_CLIENTS * COMMUNICATION_BUFFER]; // Not cleared by communication_init.
} communication_t;

/// listener: descriptor of the listening socket, opened by the launcher. uplink: where requests go.
void communication_init(communication_t* communication, subsystem_t* generic, const pus_port_t* uplink,
                        const communication_hooks_t* hooks, int listener);
/// Accept only authenticated telecommands. Call it before the subsystem is configured; the receiver must
/// outlive the subsystem.
void communication_secure(communication_t* communication, sdls_receiver_t* receiver);
const subsystem_callbacks_t* communication_callbacks(void);
/// Take in octets from the ground; `octets_due` more were announced for the participant. Call before the
/// component's step. True if the participant still has to be served: its connection, announced octets
/// or, when it has left the scheduler, the end of its connection. Then wait and call again.
bool communication_take_in(communication_t* communication, uint32_t octets_due);
/// No longer expect a connection of the present participant, or the end of the connection of one that has
/// left.
void communication_let_go(communication_t* communication);
/// Send waiting reports. Call after the component's step.
void communication_send_out(communication_t* communication);
/// Open sockets, for the program's wait. Returns their number, <= COMMUNICATION_CLIENTS + 1.
size_t communication_sockets(communication_t* communication, osal_socket_t** out_sockets, size_t capacity);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_COMMUNICATION_H
