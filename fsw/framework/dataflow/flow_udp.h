// SPDX-License-Identifier: Apache-2.0
/// Data flow of datagrams: one bound socket, one peer.
///
/// Ownership  The caller places flow_udp_t. Context: one task, never blocks. Errors: status and counter each.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_UDP_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_UDP_H

#include "fsw/framework/base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "osal/include/osal/socket.h"

#include <stddef.h>
#include <stdint.h>

typedef struct { // [datagrams, wrap]
    uint32_t sent;
    uint32_t received;
    uint32_t refused;  ///< Not sent: kernel buffer full, nobody there, too large, closed.
    uint32_t foreign;  ///< Received from somebody else than the peer, dropped.
    uint32_t oversize; ///< Received, longer than the caller's buffer, dropped.
} flow_udp_counters_t;

typedef struct { // Private, except counters: read-only.
    osal_socket_t socket;
    osal_address_t peer;
    flow_udp_counters_t counters;
} flow_udp_t;

void flow_udp_init(flow_udp_t* flow);
/// Bind end node `local`, talk to end node `peer` and to nobody else; both as the resolver says.
/// STATUS_OK, STATUS_EXISTS (open already, or port in use), STATUS_NOT_FOUND, STATUS_INVALID (address),
/// STATUS_DENIED, STATUS_IO.
MUST_USE status_t flow_udp_open(flow_udp_t* flow, const flow_resolver_t* resolver, const char* local,
                                const char* peer, size_t receive_octets);
void flow_udp_close(flow_udp_t* flow);

/// STATUS_OK, STATUS_FULL, STATUS_CLOSED, STATUS_TOO_LARGE, STATUS_IO.
MUST_USE status_t flow_udp_send(flow_udp_t* flow, const uint8_t* octets, size_t size);
/// One datagram of the peer; foreign and oversize ones are counted and passed over.
/// STATUS_OK, STATUS_EMPTY, STATUS_CLOSED, STATUS_IO.
MUST_USE status_t flow_udp_receive(flow_udp_t* flow, uint8_t* octets, size_t capacity, size_t* out_size);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_UDP_H
