// SPDX-License-Identifier: Apache-2.0
/// Data plane of one real-time link: one producer; a reader gets the complete latest sample, which is stale
/// above an age.
///
/// The reader of a link of datagrams may have a play-out buffer, which makes the delay constant (play_out.h).
///
/// Shared memory: a sequence lock around one frame; any number of readers, wait-free for the writer. UDP and
/// TIPC: the program pumps datagrams into rtlink_consumer_deliver. Frames of an old producer are refused by
/// their epoch; sequence numbers show losses. A consumer whose period is a multiple of the producer's sees
/// every n-th sample.
///
/// Ownership  The caller places the ends.
/// Context    One task an end; ends of one link may be in different processes. Never blocks.
/// Time       O(payload); a reader that finds the writer busy LINK_READ_ATTEMPTS times keeps its last sample.
/// Errors     Each function lists every status it returns; a null argument is a coding error (FSW_ASSERT).
#ifndef FSW_FRAMEWORK_RTLINK_LINK_CHANNEL_H
#define FSW_FRAMEWORK_RTLINK_LINK_CHANNEL_H

#include "base/status.h"
#include "fsw/framework/rtlink/agreement.h"
#include "fsw/framework/rtlink/link_frame.h"
#include "fsw/framework/rtlink/play_out.h"
#include "osal/include/osal/shm.h"
#include "osal/include/osal/socket.h"
#include "osal/include/osal/tipc.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LINK_READ_ATTEMPTS 8U

typedef enum { // On the wire (TM[130,9] and TM[130,10]).
    LINK_CLOSED    = 0,
    LINK_REQUESTED = 1,
    LINK_ACCEPTED  = 2,
    LINK_OPEN      = 3,
    LINK_STALE     = 4,
    LINK_FAILED    = 5
} rtlink_state_t;

/// Resolves a logical link number to a name or address; these are never put into a packet.
typedef struct {
    void* context;
    /// Name of the shared memory of a link. False if there is none.
    bool (*shm_name)(void* context, uint16_t link, char* out_name, size_t capacity);
    /// Where to send, and through which socket, frames of a link over UDP. False if there is none.
    bool (*udp_route)(void* context, uint16_t link, osal_socket_t** out_socket, osal_address_t* out_consumer);
    /// Called after each frame of that epoch sent by UDP or TIPC, so the program can announce it to the
    /// scheduler. May be null.
    void (*delivered)(void* context, uint16_t link, uint32_t epoch);
    /// Like udp_route, over TIPC. May be null: there is no route over TIPC.
    bool (*tipc_route)(void* context, uint16_t link, osal_socket_t** out_socket,
                       osal_tipc_name_t* out_consumer);
    /// Methods by which the partner of a port can be reached over a link, or any of its partners (link 0):
    /// bit set of 1 << rtlink_method_t. May be null: all.
    uint8_t (*methods)(void* context, uint16_t port, uint16_t link);
    /// Play-out buffer for the consumer of a link of datagrams; null: its samples are read as they arrive.
    /// STATUS_OK, STATUS_EXHAUSTED (it needs one, and there is none). May be null: no link needs one.
    status_t (*play_out)(void* context, uint16_t link, rtlink_play_out_t** out_buffer);
} rtlink_resolver_t;

typedef struct {
    uint32_t frames;  ///< Sent, or received and used.
    uint32_t lost;    ///< Missing in the sequence, of those that the decimation selects, when they were due.
    uint32_t late;    ///< Read when older than allowed [reads].
    uint32_t torn;    ///< Reads that failed because the writer was always busy.
    uint32_t refused; ///< Frames of another epoch, link or layout, or with a wrong CRC.
    uint32_t last_sequence;
} rtlink_counters_t;

typedef struct { // Private, except counters.
    rtlink_terms_t terms;
    uint16_t link;
    uint32_t epoch;
    uint32_t sequence;
    bool is_open;
    osal_shm_t shm;
    struct link_slot* slot; // In the shared memory; null: it sends datagrams.
    const rtlink_resolver_t* resolver;
    osal_socket_t* socket;
    osal_address_t consumer;
    osal_tipc_name_t consumer_name;
    rtlink_counters_t counters;
} rtlink_producer_t;

typedef struct { // Private, except counters, peer_state and sample_time_ns.
    rtlink_terms_t terms;
    uint16_t link;
    uint32_t epoch;
    bool is_open;
    bool has_sample;
    osal_shm_t shm;
    struct link_slot* slot;      // In the shared memory; null: its samples arrive as datagrams.
    rtlink_play_out_t* play_out; // Null: none.
    uint32_t guard;              // Value of the guard when the last sample was read.
    uint32_t sequence;
    uint8_t peer_state;      ///< State number of the producer in its last frame.
    uint64_t sample_time_ns; ///< Time of the last sample [ns of the run].
    rtlink_counters_t counters;
    uint8_t payload[RTLINK_PAYLOAD_MAX]; // Producer's byte order.
} rtlink_consumer_t;

/// Create the shared memory of a link (producer's side), before the consumer opens it. Memory that is left
/// from an earlier opening is replaced. STATUS_OK, STATUS_NOT_FOUND (no name or route), STATUS_EXHAUSTED,
/// STATUS_DENIED, STATUS_IO.
MUST_USE status_t rtlink_producer_open(rtlink_producer_t* producer, const rtlink_resolver_t* resolver,
                                       uint16_t link, const rtlink_terms_t* agreed, uint32_t epoch);
/// Publish a sample. STATUS_OK, STATUS_CLOSED (not open), STATUS_FULL or STATUS_IO (UDP, TIPC; the sample is
/// lost and counted).
status_t rtlink_producer_write(rtlink_producer_t* producer, uint8_t state, uint64_t now_ns,
                               const uint8_t* payload);
void rtlink_producer_close(rtlink_producer_t* producer);

/// STATUS_OK, STATUS_NOT_FOUND (nothing to open, or a method that is not in this build), STATUS_DENIED,
/// STATUS_IO, STATUS_EXHAUSTED (no play-out buffer).
MUST_USE status_t rtlink_consumer_open(rtlink_consumer_t* consumer, const rtlink_resolver_t* resolver,
                                       uint16_t link, const rtlink_terms_t* agreed, uint32_t epoch);
/// Read the newest sample. STATUS_OK (sample in payload, not stale), STATUS_EMPTY (none yet), STATUS_STALE,
/// STATUS_CLOSED (not open).
status_t rtlink_consumer_read(rtlink_consumer_t* consumer, uint64_t now_ns);
/// A datagram for this link has arrived. STATUS_OK, STATUS_INVALID (refused and counted), STATUS_CLOSED.
status_t rtlink_consumer_deliver(rtlink_consumer_t* consumer, const uint8_t* frame, size_t size);
/// Age beyond which a sample of an open link is stale [us].
uint64_t rtlink_consumer_patience_us(const rtlink_consumer_t* consumer);
void rtlink_consumer_close(rtlink_consumer_t* consumer);

#endif // FSW_FRAMEWORK_RTLINK_LINK_CHANNEL_H
