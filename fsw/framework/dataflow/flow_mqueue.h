// SPDX-License-Identifier: Apache-2.0
/// Data flow of messages through a queue of the operating system. One receiver creates the queue; any
/// number of senders open it.
///
/// The receiver of an end node is one component: a queue that exists when it starts was left by its
/// predecessor, and is replaced. A sender detects that; a sender that starts first waits for its receiver,
/// with back-off. Call flow_mqueue_step once a cycle, then send or receive.
///
/// Ownership  The caller provides flow_mqueue_t; the name, the resolver and the quota outlive it.
/// Context    One task. Never blocks.
/// Time       O(message).
/// Errors     Each function lists its statuses; each refusal is counted.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_MQUEUE_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_MQUEUE_H

#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/dataflow/link.h"
#include "fsw/framework/dataflow/record.h"
#include "base/quota.h"
#include "osal/include/osal/mqueue.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    const char* name;
    bool is_receiver;
    uint32_t depth;          ///< Messages that the queue holds; the receiver's value applies.
    uint32_t message_octets; ///< Longest message; a sender refuses a queue of shorter ones.
    flow_order_t order;      ///< Byte order of the numbers in records.
    uint64_t retry_first_ns; ///< Delay after the first failure, >= 1.
    uint64_t retry_longest_ns;
    quota_t* quota; ///< Quota of open queues; null: not counted.
} flow_mqueue_setup_t;

typedef struct { // [messages, wraps]
    uint32_t sent;
    uint32_t received;
    uint32_t refused; ///< Not sent: no queue, full, or too large.
    uint32_t unfit;   ///< Received, but not a record of the expected layout.
} flow_mqueue_counters_t;

typedef struct { // Private; read-only for housekeeping: counters, link.
    flow_mqueue_setup_t setup;
    const flow_resolver_t* resolver;
    char address[ENDNODE_ADDRESS_MAX];
    osal_mqueue_t queue;
    flow_link_t link;
    flow_mqueue_counters_t counters;
} flow_mqueue_t;

void flow_mqueue_init(flow_mqueue_t* flow, const flow_mqueue_setup_t* setup, const flow_resolver_t* resolver);
/// Create or open the queue if an attempt is due. STATUS_OK (open), STATUS_CLOSED; then `link.failure` is the
/// reason: STATUS_NOT_FOUND (resolver, or no receiver yet), STATUS_INVALID (name, or a queue of shorter
/// messages), STATUS_EXHAUSTED (quota or limits of the system), STATUS_EXISTS, STATUS_UNSUPPORTED,
/// STATUS_DENIED or STATUS_IO.
status_t flow_mqueue_step(flow_mqueue_t* flow, uint64_t now_ns);
/// Send one message. STATUS_OK, STATUS_FULL, STATUS_TOO_LARGE, STATUS_CLOSED (no queue, it failed, or the
/// receiver restarts).
MUST_USE status_t flow_mqueue_send(flow_mqueue_t* flow, const uint8_t* octets, size_t size);
/// Receive one message; capacity >= message_octets. STATUS_OK, STATUS_EMPTY, STATUS_CLOSED.
MUST_USE status_t flow_mqueue_receive(flow_mqueue_t* flow, uint8_t* octets, size_t capacity,
                                      size_t* out_size);
/// Send a struct as one message, in the flow's byte order. A layout of more than RECORD_OCTETS_MAX is a
/// coding error. Statuses of flow_mqueue_send.
MUST_USE status_t flow_mqueue_send_record(flow_mqueue_t* flow, const flow_record_layout_t* layout,
                                          const void* record);
/// Receive the next message as a struct, which changes only with STATUS_OK; message_octets <=
/// RECORD_OCTETS_MAX. Statuses of flow_mqueue_receive; STATUS_TRUNCATED, STATUS_TOO_LARGE, STATUS_INVALID:
/// the message is not such a record; it is dropped and counted.
MUST_USE status_t flow_mqueue_receive_record(flow_mqueue_t* flow, const flow_record_layout_t* layout,
                                             void* out_record);
bool flow_mqueue_is_open(const flow_mqueue_t* flow);
/// Close the queue; the receiver also removes its name.
void flow_mqueue_close(flow_mqueue_t* flow);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_MQUEUE_H
