// SPDX-License-Identifier: Apache-2.0
/// Data flow of octet streams that this end opens: a serial line, a TCP connection as client, a file or I/O
/// device. It carries frames in both directions. After a loss it reconnects without limit, with back-off.
///
/// Call flow_stream_step once a cycle, then send and receive. Before the first connection and between two
/// connections, send and receive return STATUS_CLOSED; a frame that was cut by the end of a connection is
/// lost in both directions.
///
/// Ownership  The caller provides flow_stream_t and the buffers; the name, the resolver and the quota outlive
///            it.
/// Context    One task. Blocks only in stepped time, until announced octets have arrived (osal/hand_over.h).
/// Time       O(octets), bounded in each call.
/// Errors     Each function lists its statuses; each refusal is counted.
///
///     flow_stream_init(&flow, &(flow_stream_setup_t){.kind = ENDNODE_SERIAL, .name = "imu", ...});
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_STREAM_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_STREAM_H

#include "base/flow_format.h"
#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/dataflow/framing.h"
#include "fsw/framework/dataflow/link.h"
#include "fsw/framework/dataflow/record.h"
#include "base/quota.h"
#include "osal/include/osal/device.h"
#include "osal/include/osal/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FLOW_STREAM_CHUNK 256U ///< Octets that one read from the system takes at most.

typedef struct {
    flow_endnode_kind_t kind; ///< ENDNODE_SERIAL, ENDNODE_TCP or ENDNODE_FILE.
    const char* name;
    flow_format_t format;
    uint8_t* frame; ///< Payload being received.
    size_t frame_octets;
    /// Octets of frames that the system has not accepted yet; must have room for the longest frame.
    uint8_t* outbox;
    size_t outbox_octets;
    uint64_t retry_first_ns; ///< Delay after the first failure, >= 1.
    uint64_t retry_longest_ns;
    quota_t* quota; ///< Quota of open connections; null: not counted.
} flow_stream_setup_t;

typedef struct {        // All counters wrap.
    uint32_t sent;      ///< Frames sent.
    uint32_t received;  ///< Frames received.
    uint32_t refused;   ///< Frames not sent: no connection, outbox full, malformed, or too long.
    uint32_t discarded; ///< Octets that were in the outbox when a connection ended.
    uint32_t unfit;     ///< Frames received that were not records of the expected layout.
    uint32_t octets_in;
    uint32_t octets_out;
} flow_stream_counters_t;

typedef struct { // Private; read-only for housekeeping: counters, link, assembler.counters.
    flow_stream_setup_t setup;
    const flow_resolver_t* resolver;
    osal_device_t device;
    osal_socket_t socket;
    osal_hand_over_t counts;
    flow_link_t link;
    flow_frame_assembler_t assembler;
    uint8_t chunk[FLOW_STREAM_CHUNK];
    size_t chunk_size;
    size_t chunk_used;
    size_t outbox_held;
    flow_stream_counters_t counters;
} flow_stream_t;

/// Initialise as not connected, with counters zero. A wrong kind or a missing buffer is a coding error.
void flow_stream_init(flow_stream_t* flow, const flow_stream_setup_t* setup, const flow_resolver_t* resolver);
/// Connect if an attempt is due, and pass queued octets to the system. STATUS_OK (connected), STATUS_BUSY
/// (the partner has not answered), STATUS_CLOSED (not connected); then `link.failure` is the reason:
/// STATUS_NOT_FOUND (resolver or device), STATUS_INVALID (address or device), STATUS_OUT_OF_RANGE (bit rate),
/// STATUS_BUSY (in use), STATUS_CLOSED (refused), STATUS_EXHAUSTED (quota or descriptors), STATUS_DENIED or
/// STATUS_IO.
status_t flow_stream_step(flow_stream_t* flow, uint64_t now_ns);
/// Queue one frame. STATUS_OK, STATUS_FULL, STATUS_INVALID and STATUS_TOO_LARGE as flow_frame_encode,
/// STATUS_CLOSED.
MUST_USE status_t flow_stream_send(flow_stream_t* flow, const uint8_t* payload, size_t size);
/// Read the next frame, which is valid until the next call. STATUS_OK, STATUS_EMPTY, STATUS_CLOSED.
MUST_USE status_t flow_stream_receive(flow_stream_t* flow, const uint8_t** out_payload, size_t* out_size);
/// Send a struct as one frame, in the flow's byte order. A layout of more than RECORD_OCTETS_MAX is a coding
/// error. RAW framing does not mark the end of a record: the receiver may get its octets in several pieces.
/// Statuses of flow_stream_send.
MUST_USE status_t flow_stream_send_record(flow_stream_t* flow, const flow_record_layout_t* layout,
                                          const void* record);
/// Read the next frame as a struct, which changes only with STATUS_OK. Statuses of flow_stream_receive;
/// STATUS_TRUNCATED, STATUS_TOO_LARGE, STATUS_INVALID: the frame is not such a record; it is dropped and
/// counted.
MUST_USE status_t flow_stream_receive_record(flow_stream_t* flow, const flow_record_layout_t* layout,
                                             void* out_record);
/// End the connection, if there is one, and drop an incomplete frame; connect again after the delay.
void flow_stream_give_up(flow_stream_t* flow);
/// End the connection; the next step connects again.
void flow_stream_close(flow_stream_t* flow);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_STREAM_H
