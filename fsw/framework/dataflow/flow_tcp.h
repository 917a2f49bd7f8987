// SPDX-License-Identifier: Apache-2.0
/// Data flow of streams, server side: a listening port and a bounded number of clients.
///
/// Received octets are collected per client and passed to the caller's framer, which removes complete frames
/// from the front. Sent octets go directly to the kernel, as many as it accepts; the caller queues the rest
/// and decides what to drop if a reader is slow.
///
/// Ownership  The caller provides flow_tcp_t, the clients and their buffers; all outlive the flow.
/// Context    One task, never blocks.
/// Time       O(clients + octets).
/// Errors     Each function lists its statuses; each refusal is counted.
///
///     static flow_tcp_client_t clients[4];
///     static uint8_t           buffers[4][8192];
///     flow_tcp_init(&flow, clients, 4, &buffers[0][0], sizeof buffers[0]);
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_TCP_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_TCP_H

#include "base/status.h"
#include "base/quota.h"
#include "osal/include/osal/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FLOW_TCP_UNLIMITED SIZE_MAX ///< No limit on the octets that one call receives.

typedef struct { // Private; `epoch` counts the connections that have used this slot.
    osal_socket_t socket;
    osal_address_t peer;
    uint8_t* buffer;
    size_t held;        ///< Octets in the buffer, not yet taken by the framer.
    uint32_t octets_in; ///< Octets received on this connection [wraps].
    uint32_t epoch;
} flow_tcp_client_t;

typedef struct {     // All counters wrap.
    uint32_t failed; ///< Attempts to listen that were refused.
    uint32_t accepted;
    uint32_t turned_away; ///< Connections closed at once: no slot was free, or the quota was used up.
    uint32_t evicted;     ///< Connections ended to make room for a new one.
    uint32_t ended;       ///< All connections that ended, `evicted` and `malformed` ones included.
    uint32_t malformed;   ///< Connections ended because a frame was malformed or did not fit the buffer.
    uint32_t octets_in;
    uint32_t octets_out;
} flow_tcp_counters_t;

/// Reactions of the caller to connections and octets. `client` is 0..capacity-1. Each callback may be null,
/// except `frame`.
typedef struct {
    void* context;
    void (*connected)(void* context, unsigned client);
    void (*disconnected)(void* context, unsigned client);
    /// Take complete frames from the front of `octets`; returns the number of octets taken, 0..size. Called
    /// repeatedly as long as it takes octets. FLOW_TCP_MALFORMED ends the connection. FLOW_TCP_BUSY: the
    /// first frame cannot be taken now; the flow passes it again in the next step, and until then reads no
    /// more octets from this client.
    size_t (*frame)(void* context, unsigned client, const uint8_t* octets, size_t size);
    /// Returns the number of octets that may be read from a client in this step. Null: no limit.
    size_t (*allowance)(void* context, unsigned client);
    /// Called if a client connects and no slot is free. Returns the client whose connection is ended;
    /// `capacity` or more refuses the new connection. Null: the new connection is always refused.
    unsigned (*make_room)(void* context);
} flow_tcp_user_t;

#define FLOW_TCP_MALFORMED SIZE_MAX
#define FLOW_TCP_BUSY (SIZE_MAX - 1U)

typedef struct { // Private, except counters: read-only.
    osal_socket_t listener;
    flow_tcp_client_t* clients;
    unsigned capacity;
    size_t buffer_octets;
    quota_t* quota; // Quota of sockets; null: not counted.
    flow_tcp_counters_t counters;
    unsigned first; // First client of the next step: the one after the client served last.
} flow_tcp_t;

/// Initialise as closed, without clients. `buffers` holds capacity x buffer_octets octets; buffer_octets >=
/// the longest frame.
void flow_tcp_init(flow_tcp_t* flow, flow_tcp_client_t* clients, unsigned capacity, uint8_t* buffers,
                   size_t buffer_octets);
/// Count the listening socket and every connection in `quota`, which outlives the flow. Call it before
/// flow_tcp_adopt.
void flow_tcp_set_quota(flow_tcp_t* flow, quota_t* quota);
/// Listen with a socket inherited from the parent. STATUS_OK, STATUS_EXISTS (open already), STATUS_INVALID
/// (no such descriptor), STATUS_EXHAUSTED (quota).
MUST_USE status_t flow_tcp_adopt(flow_tcp_t* flow, int descriptor);
/// End every connection; each is reported to `user`.
void flow_tcp_end_all(flow_tcp_t* flow, const flow_tcp_user_t* user);

/// Accept new connections, then read from the clients in turn, at most `limit_octets` from all and
/// buffer_octets from each, and pass frames to `user`. *out_octets is the number of octets read. STATUS_OK,
/// STATUS_CLOSED (not listening).
MUST_USE status_t flow_tcp_step(flow_tcp_t* flow, const flow_tcp_user_t* user, size_t limit_octets,
                                size_t* out_octets);
/// Send as many octets as the kernel accepts now. STATUS_OK with *out_sent >= 1; STATUS_FULL (no octet);
/// STATUS_CLOSED (no such client, or its connection has ended, which the next step reports).
MUST_USE status_t flow_tcp_send(flow_tcp_t* flow, unsigned client, const uint8_t* octets, size_t size,
                                size_t* out_sent);
/// End one connection; reported to `user`. No effect on an empty slot.
void flow_tcp_end(flow_tcp_t* flow, const flow_tcp_user_t* user, unsigned client);

/// Returns the octets received on the present connection [wraps]; 0 for an empty slot.
uint32_t flow_tcp_octets_in(const flow_tcp_t* flow, unsigned client);
/// Get the address of the other end. STATUS_OK, STATUS_CLOSED (no such client).
MUST_USE status_t flow_tcp_peer(const flow_tcp_t* flow, unsigned client, osal_address_t* out_peer);
bool flow_tcp_is_connected(const flow_tcp_t* flow, unsigned client);
/// List the open sockets, the listener first, for which the executive waits. Returns their number, <=
/// capacity.
size_t flow_tcp_sockets(flow_tcp_t* flow, osal_socket_t** out_sockets, size_t capacity);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_TCP_H
