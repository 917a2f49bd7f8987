// SPDX-License-Identifier: Apache-2.0
/// Data flow of messages to and from a device: one interface for all end nodes except CAN. The descriptor
/// selects the end node that carries the messages, so that a device can be moved to another kind of end
/// node without a change of code.
///
///     UDP                datagrams, one message each
///     TCP, SERIAL, FILE  frames in a stream of octets (framing.h)
///     SHM, MQUEUE        a queue of messages in each direction: NAME.in to flight, NAME.out to the device
///
/// Call flow_step once a cycle, then send and receive. After a loss, flow_step opens the end node again, with
/// back-off and without limit. A message longer than its limit is dropped and counted.
///
/// Ownership  The caller provides flow_t, which must not be moved; name, resolver and quota outlive it.
/// Context    One task. Blocks only in stepped time, until announced octets have arrived (osal/hand_over.h).
/// Time       O(octets), bounded in each call.
/// Errors     Each function lists its statuses.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_H

#include "base/flow_format.h"
#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/dataflow/flow_mqueue.h"
#include "fsw/framework/dataflow/flow_shm.h"
#include "fsw/framework/dataflow/flow_stream.h"
#include "fsw/framework/dataflow/flow_udp.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FLOW_OCTETS_MAX 136U ///< Longest message.
#define FLOW_OUTBOX_OCTETS 1024U
#define FLOW_DEPTH 8U ///< Messages in a queue.

typedef struct {
    flow_endnode_kind_t kind; ///< Any kind except ENDNODE_CAN.
    const char* name;         ///< Name that the resolver gets: object, path, or "HOST:PORT".
    flow_format_t format;
    uint32_t octets_in;  ///< Size of a message to flight [octets], at most FLOW_OCTETS_MAX; 0: no messages.
    uint32_t octets_out; ///< Size of a message to the device, at most FLOW_OCTETS_MAX; 0: no messages.
    uint64_t retry_first_ns;   ///< Delay after the first failure, >= 1.
    uint64_t retry_longest_ns; ///< Longest delay: each failure doubles the delay up to this.
    quota_t* quota;            ///< Quota of open end nodes; null: not counted.
} flow_setup_t;

typedef struct { // Private.
    flow_setup_t setup;
    char local[ENDNODE_ADDRESS_MAX]; // UDP: address of the bound socket. SHM, MQUEUE: NAME.in.
    char peer[ENDNODE_ADDRESS_MAX];  // SHM, MQUEUE: NAME.out.
    flow_udp_t udp;
    flow_stream_t stream;
    flow_shm_t shm[2];
    flow_mqueue_t mqueue[2];
    uint8_t frame[FLOW_OCTETS_MAX];
    uint8_t outbox[FLOW_OUTBOX_OCTETS];
} flow_t;

typedef struct {        // All counters wrap.
    uint32_t connected; ///< How often the end node was opened.
    uint32_t lost;      ///< How often an open end node was lost.
    uint32_t malformed; ///< Messages dropped: malformed frame, too long, or cut.
    uint32_t octets;    ///< Octets received on a stream; 0 on other end nodes.
} flow_counters_t;

/// Initialise a flow as closed. An end node whose name is too long stays closed.
void flow_init(flow_t* flow, const flow_setup_t* setup, const flow_resolver_t* resolver);
/// Open the end node if an attempt is due, and pass queued octets to the system. STATUS_OK (open),
/// STATUS_BUSY (an attempt is pending), STATUS_CLOSED (not open).
status_t flow_step(flow_t* flow, uint64_t now_ns);
/// Send one message of octets_out octets, > 0. STATUS_OK, STATUS_FULL, STATUS_CLOSED, STATUS_INVALID (LINE:
/// the message contains a line end), STATUS_TOO_LARGE (UDP: the system sends no such datagram).
MUST_USE status_t flow_send(flow_t* flow, const uint8_t* octets, size_t size);
/// Read the next message; on UDP and streams it may have any size up to FLOW_OCTETS_MAX. STATUS_OK,
/// STATUS_EMPTY, STATUS_CLOSED.
MUST_USE status_t flow_receive(flow_t* flow, uint8_t octets[FLOW_OCTETS_MAX], size_t* out_size);
flow_counters_t flow_counters(const flow_t* flow);
/// Call it if no valid message has arrived for too long: a stream closes and connects again after its delay,
/// because invalid octets may have announced a long frame. No effect on other end nodes.
void flow_give_up(flow_t* flow);
/// Close the end node; the next step opens it again.
void flow_close(flow_t* flow);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_H
