// SPDX-License-Identifier: Apache-2.0
/// Data plane of one real-time link with one producer. A reader gets the latest complete sample; the sample
/// is stale when its age exceeds a limit.
///
/// The consumer of a link that uses datagrams may have a play-out buffer, which makes the delay constant
/// (play_out.h).
///
/// Shared memory: a sequence lock around one frame, for any number of readers; the writer never waits. UDP
/// and TIPC: the program passes received datagrams to rtlink_consumer_deliver. The epoch identifies frames
/// of an earlier producer, which are refused; sequence numbers show losses. A consumer whose period is n
/// times the producer's reads every n-th sample.
///
/// Ownership  The caller provides the ends.
/// Context    One task for each end; the ends may be in different processes. Never blocks.
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

/// Functions of the program that resolve the number of a link to a name or address. Names and addresses
/// never enter a packet.
typedef struct {
    void* context;
    /// Get the name of the shared memory of a link. False if there is none.
    bool (*shm_name)(void* context, uint16_t link, char* out_name, size_t capacity);
    /// Get the socket and the address of the consumer of a link over UDP. False if there is no route.
    bool (*udp_route)(void* context, uint16_t link, osal_socket_t** out_socket, osal_address_t* out_consumer);
    /// Called after each frame sent by UDP or TIPC, with its epoch, so that the program can announce the
    /// frame to the scheduler. May be null.
    void (*delivered)(void* context, uint16_t link, uint32_t epoch);
    /// Like udp_route, over TIPC. Null: there is no route over TIPC.
    bool (*tipc_route)(void* context, uint16_t link, osal_socket_t** out_socket,
                       osal_tipc_name_t* out_consumer);
    /// Returns the methods that reach the partner of a port over a link, or over any of its links (link 0):
    /// bit set of 1 << rtlink_method_t. Null: all methods.
    uint8_t (*methods)(void* context, uint16_t port, uint16_t link);
    /// Get the play-out buffer for the consumer of a link with datagrams; a null buffer: samples are read
    /// as they arrive. STATUS_OK, STATUS_EXHAUSTED (the link needs a buffer, and none is free). Null: no
    /// link needs a buffer.
    status_t (*play_out)(void* context, uint16_t link, rtlink_play_out_t** out_buffer);
} rtlink_resolver_t;

typedef struct {
    uint32_t frames; ///< Frames sent, or received and used.
    /// Producer: samples that could not be sent. Consumer: samples that were missing when they were due; only
    /// those that the decimation selects.
    uint32_t lost;
    uint32_t late;          ///< Reads of a stale sample.
    uint32_t torn;          ///< Reads that failed because the writer was busy in each attempt.
    uint32_t refused;       ///< Frames of another epoch, link or layout, or with a wrong CRC.
    uint32_t last_sequence; ///< Number of the last frame that was sent or lost, or received and used.
} rtlink_counters_t;

typedef struct { // Private, except counters.
    rtlink_terms_t terms;
    uint16_t link;
    uint32_t epoch;
    uint32_t sequence;
    bool is_open;
    osal_shm_t shm;
    struct link_slot* slot; // Slot in the shared memory; null if the link sends datagrams.
    const rtlink_resolver_t* resolver;
    osal_socket_t* socket;
    osal_address_t consumer;
    osal_tipc_name_t consumer_name;
    rtlink_counters_t counters;
} rtlink_producer_t;

typedef struct { // Private, except counters, peer_state, sample_time_ns and payload.
    rtlink_terms_t terms;
    uint16_t link;
    uint32_t epoch;
    bool is_open;
    bool has_sample;
    osal_shm_t shm;
    struct link_slot* slot;      // Slot in the shared memory; null if the samples arrive as datagrams.
    rtlink_play_out_t* play_out; // Play-out buffer, or null.
    uint32_t sequence_counter;   // Sequence counter of the slot when the last sample was read.
    uint32_t sequence;
    uint8_t peer_state;      ///< State number of the producer in its last frame.
    uint64_t sample_time_ns; ///< Time of the last sample [ns of the run].
    rtlink_counters_t counters;
    uint8_t payload[RTLINK_PAYLOAD_MAX]; ///< Last sample, in the byte order of the producer.
} rtlink_consumer_t;

/// Open the producer's end of a link, before the consumer opens its end. With shared memory, creates the
/// memory, and replaces memory left from an earlier opening. STATUS_OK, STATUS_NOT_FOUND (no name or
/// route), STATUS_EXHAUSTED, STATUS_DENIED, STATUS_IO.
MUST_USE status_t rtlink_producer_open(rtlink_producer_t* producer, const rtlink_resolver_t* resolver,
                                       uint16_t link, const rtlink_terms_t* agreed, uint32_t epoch);
/// Publish a sample of the agreed size (`layout_octets`), with the state number of the producer and the time
/// [ns of the run]. STATUS_OK, STATUS_CLOSED (not open), STATUS_FULL or STATUS_IO (UDP, TIPC; the sample is
/// lost and counted).
status_t rtlink_producer_write(rtlink_producer_t* producer, uint8_t state, uint64_t now_ns,
                               const uint8_t* payload);
void rtlink_producer_close(rtlink_producer_t* producer);

/// Open the consumer's end. STATUS_OK, STATUS_NOT_FOUND (no memory or route, or a method that this build
/// does not include), STATUS_DENIED, STATUS_IO, STATUS_EXHAUSTED (no play-out buffer).
MUST_USE status_t rtlink_consumer_open(rtlink_consumer_t* consumer, const rtlink_resolver_t* resolver,
                                       uint16_t link, const rtlink_terms_t* agreed, uint32_t epoch);
/// Read the newest sample. STATUS_OK (the sample is in `payload` and not stale), STATUS_STALE (the sample in
/// `payload` is stale), STATUS_EMPTY (no sample yet), STATUS_CLOSED (not open).
status_t rtlink_consumer_read(rtlink_consumer_t* consumer, uint64_t now_ns);
/// Process a datagram that has arrived for this link. STATUS_OK (an old or repeated sample is dropped),
/// STATUS_INVALID (refused and counted), STATUS_CLOSED.
status_t rtlink_consumer_deliver(rtlink_consumer_t* consumer, const uint8_t* frame, size_t size);
/// Returns the age beyond which a sample of an open link is stale [us].
uint64_t rtlink_consumer_max_age_us(const rtlink_consumer_t* consumer);
void rtlink_consumer_close(rtlink_consumer_t* consumer);

#endif // FSW_FRAMEWORK_RTLINK_LINK_CHANNEL_H
