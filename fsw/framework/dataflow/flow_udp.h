// SPDX-License-Identifier: Apache-2.0
/// Data flow of datagrams: one bound socket, one peer. If the port is in use or the socket fails, the flow
/// opens the socket again with back-off. A datagram for which there is no receiver is refused or lost, and
/// the flow stays open. Call flow_udp_step once a cycle, then send and receive.
///
/// Ownership  The caller provides flow_udp_t; names, the resolver and the quota outlive it.
/// Context    One task. Blocks only in stepped time, until announced octets have arrived (osal/hand_over.h).
/// Errors     Each function lists its statuses; each refusal is counted.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_UDP_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_UDP_H

#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/dataflow/link.h"
#include "fsw/framework/dataflow/record.h"
#include "base/quota.h"
#include "osal/include/osal/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    const char* local;       ///< End node whose address is bound.
    const char* peer;        ///< The only peer. The resolver gives both addresses.
    flow_order_t order;      ///< Byte order of the numbers in records.
    size_t receive_octets;   ///< Receive buffer requested from the system; 0: default.
    uint64_t retry_first_ns; ///< Delay after the first failure, >= 1.
    uint64_t retry_longest_ns;
    quota_t* quota; ///< Quota of open sockets; null: not counted.
} flow_udp_setup_t;

typedef struct { // [datagrams, wraps]
    uint32_t sent;
    uint32_t received;
    uint32_t refused;       ///< Not sent: kernel buffer full, no receiver, too large, closed.
    uint32_t other_senders; ///< Received from an address other than the peer's, and dropped.
    uint32_t oversize;      ///< Received, but longer than the caller's buffer, and dropped.
    uint32_t unfit;         ///< Received, but not a record of the expected layout.
} flow_udp_counters_t;

typedef struct { // Private; read-only for housekeeping: counters, link.
    flow_udp_setup_t setup;
    const flow_resolver_t* resolver;
    osal_socket_t socket;
    osal_address_t peer;
    osal_hand_over_t counts;
    flow_link_t link;
    flow_udp_counters_t counters;
} flow_udp_t;

void flow_udp_init(flow_udp_t* flow, const flow_udp_setup_t* setup, const flow_resolver_t* resolver);
/// Open the socket if an attempt is due. STATUS_OK (open), STATUS_CLOSED; then `link.failure` is the reason:
/// STATUS_NOT_FOUND or STATUS_INVALID (address), STATUS_EXISTS (port in use), STATUS_EXHAUSTED (quota),
/// STATUS_DENIED or STATUS_IO.
status_t flow_udp_step(flow_udp_t* flow, uint64_t now_ns);

/// Send one datagram. STATUS_OK, STATUS_FULL, STATUS_TOO_LARGE, STATUS_CLOSED (no socket, or no route).
MUST_USE status_t flow_udp_send(flow_udp_t* flow, const uint8_t* octets, size_t size);
/// Receive one datagram of the peer. Datagrams of other senders and oversize ones are counted and skipped, at
/// most 64 in a call. STATUS_OK, STATUS_EMPTY, STATUS_CLOSED (no socket).
MUST_USE status_t flow_udp_receive(flow_udp_t* flow, uint8_t* octets, size_t capacity, size_t* out_size);
/// Send a struct as one datagram, in the flow's byte order. A layout of more than RECORD_OCTETS_MAX is a
/// coding error. Statuses of flow_udp_send.
MUST_USE status_t flow_udp_send_record(flow_udp_t* flow, const flow_record_layout_t* layout,
                                       const void* record);
/// Receive the next datagram as a struct, which changes only with STATUS_OK. Statuses of flow_udp_receive;
/// STATUS_TRUNCATED, STATUS_TOO_LARGE, STATUS_INVALID: the datagram is not such a record; it is dropped and
/// counted.
MUST_USE status_t flow_udp_receive_record(flow_udp_t* flow, const flow_record_layout_t* layout,
                                          void* out_record);
bool flow_udp_is_open(const flow_udp_t* flow);
void flow_udp_close(flow_udp_t* flow);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_UDP_H
