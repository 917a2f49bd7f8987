// SPDX-License-Identifier: Apache-2.0
/// Datagrams over TIPC, the cluster protocol of the kernel: a service is addressed by its name, independent
/// of its node in the cluster. The kernel repairs transmission errors between nodes; a datagram that a slow
/// receiver has no room for is returned to the sender (osal_tipc_receive), never dropped silently.
///
/// The sockets are those of osal/socket.h: adopted, waited for and closed in the same way. All calls are
/// non-blocking; interrupted ones are repeated inside.
///
/// Ownership  The caller provides osal_socket_t; closed by osal_socket_close.
/// Errors     Each function lists its statuses; on a system without TIPC each returns STATUS_UNSUPPORTED.
#ifndef OSAL_TIPC_H
#define OSAL_TIPC_H

#include "base/status.h"
#include "osal/include/osal/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_TIPC_TYPE_MIN 64U ///< The kernel itself uses the lower service types.

typedef struct {
    uint32_t type; ///< Type of the service, >= OSAL_TIPC_TYPE_MIN.
    uint32_t instance;
} osal_tipc_name_t;

typedef enum {
    OSAL_TIPC_NODE,   ///< The name is known on this node only.
    OSAL_TIPC_CLUSTER ///< The name is known on all nodes that the bearers of this node reach.
} osal_tipc_scope_t;

typedef enum {
    OSAL_TIPC_MESSAGE, ///< Messages that cannot be delivered are returned to the sender.
    OSAL_TIPC_SAMPLE   ///< Datagrams that cannot be delivered at once are dropped.
} osal_tipc_kind_t;

typedef struct { // Event of the kernel's topology service: a hint, which may be late.
    bool is_published;
    uint32_t instance;
} osal_tipc_event_t;

/// Open a socket that receives the datagrams sent to `name`; null: a socket that only sends. STATUS_OK,
/// STATUS_UNSUPPORTED (this kernel has no TIPC, or its module is not loaded), STATUS_DENIED, STATUS_EXHAUSTED
/// (descriptors or memory), STATUS_IO.
MUST_USE status_t osal_tipc_open(osal_socket_t* socket, osal_tipc_kind_t kind, const osal_tipc_name_t* name,
                                 osal_tipc_scope_t scope);
/// Send a datagram; size >= 1, because TIPC does not carry empty datagrams. STATUS_OK, STATUS_FULL (the
/// connection to its node is congested), STATUS_CLOSED (no socket has that name now), STATUS_TOO_LARGE,
/// STATUS_IO.
MUST_USE status_t osal_tipc_send(osal_socket_t* socket, osal_tipc_name_t to, const uint8_t* octets,
                                 size_t size);
/// Receive a datagram. *out_from: the sender's identity (osal_tipc_identity). STATUS_OK, STATUS_EMPTY,
/// STATUS_TOO_LARGE (longer than capacity, dropped), STATUS_FORBIDDEN (a message sent earlier was returned,
/// because its receiver had no room or has ended; its content is lost), STATUS_IO.
MUST_USE status_t osal_tipc_receive(osal_socket_t* socket, uint64_t* out_from, uint8_t* octets,
                                    size_t capacity, size_t* out_size);
/// Number of the socket, unique in the cluster. The number does not change while the socket is open and its
/// node keeps its address. STATUS_OK, STATUS_IO.
MUST_USE status_t osal_tipc_identity(const osal_socket_t* socket, uint64_t* out_identity);

/// Watch the names of one service type: receive an event for each existing name, and later for each name that
/// appears or disappears. STATUS_OK, STATUS_UNSUPPORTED, STATUS_DENIED, STATUS_EXHAUSTED, STATUS_IO.
MUST_USE status_t osal_tipc_watch_open(osal_socket_t* socket, uint32_t type);
/// Take the next event of the watch. STATUS_OK, STATUS_EMPTY, STATUS_CLOSED (the topology service has ended
/// the watch), STATUS_IO.
MUST_USE status_t osal_tipc_watch_next(osal_socket_t* socket, osal_tipc_event_t* out_event);

#endif // OSAL_TIPC_H
