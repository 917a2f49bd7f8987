// SPDX-License-Identifier: Apache-2.0
/// Carries octet blocks between components, in order, with sequence numbers and end-to-end credits. Frame,
/// credits, SYNC and lives: docs/framework.md, "Messages".
///
/// An endpoint has an address (the component's id) and a channel to each peer. If the window of a channel has
/// no room for the largest block, message_send returns STATUS_FULL and nothing is lost. The last
/// MESSAGE_RESERVE blocks and MESSAGE_RESERVE_OCTETS of a window are reserved for message_send;
/// message_send_plain does not use them. Each peer has its own inbox, which holds a full window of that peer:
/// a peer that floods its window, or whose blocks are not taken, does not block other peers.
///
/// Ownership  The caller places the endpoint and its places.
/// Context    One task. Never blocks.
/// Time       O(size).
/// Errors     Each function lists every status it returns; a null argument is a coding error (FSW_ASSERT).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_H

#include "base/capacities.h"
#include "base/status.h"
#include "fsw/framework/message/message_inbox.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MESSAGE_HEADER_OCTETS 24U
#define MESSAGE_PAYLOAD_MAX 4096U
#define MESSAGE_FRAME_MAX (MESSAGE_HEADER_OCTETS + MESSAGE_PAYLOAD_MAX)
#define MESSAGE_WINDOW 32U           ///< Blocks under way on a channel and direction.
#define MESSAGE_WINDOW_OCTETS 32768U ///< Octets of these with their headers.
#define MESSAGE_PEERS_MAX CAPACITY_SUBSYSTEMS
#define MESSAGE_HEAD_OCTETS 16U      ///< Octets of a waiting block that can be read in place.
#define MESSAGE_RESERVE 8U           ///< Blocks of a window reserved for message_send.
#define MESSAGE_RESERVE_OCTETS 8192U ///< Octets of a window reserved for message_send.
/// Inboxes that hold full windows of `peers` channels: each block takes its frame and four octets more.
#define MESSAGE_INBOX_OCTETS(peers) ((peers) * (MESSAGE_WINDOW_OCTETS + (MESSAGE_WINDOW * 4U)))

/// How a frame reaches a peer: STATUS_OK, STATUS_FULL (try again), anything else: the peer cannot be reached
/// now. Only a frame that was taken counts as sent.
typedef struct {
    void* context;
    status_t (*send)(void* context, uint16_t to, const uint8_t* frame, size_t size);
} message_carrier_t;

/// Called with each frame that is kept, before the carrier releases it.
typedef struct {
    void* context;
    void (*arrived)(void* context, const uint8_t* frame, size_t size);
} message_arrival_t;

typedef struct {
    uint32_t sent;        ///< Blocks accepted by message_send.
    uint32_t received;    ///< Blocks taken by message_receive.
    uint32_t no_credit;   ///< Sends refused for lack of credit.
    uint32_t lost;        ///< Blocks missing in the sequence.
    uint32_t stale;       ///< Frames of another life or outside of the window, dropped.
    uint32_t malformed;   ///< Octets that are no valid frame, dropped.
    uint32_t overruns;    ///< Frames beyond the window of a peer, dropped.
    uint32_t unreachable; ///< Frames the carrier could not deliver.
    uint32_t syncs;       ///< SYNC frames sent.
    uint32_t abandoned;   ///< Blocks sent to an earlier life of a peer and not credited by it.
} message_counters_t;

typedef struct {             // Position of a channel: all that another process needs to continue it.
    uint32_t peer_life;      // 0: no frame of the peer has arrived.
    uint32_t sent;           // Data frames sent in this incarnation of the channel.
    uint32_t credited;       // Sent frames that the peer has taken.
    uint32_t expected;       // Next sequence number from the peer.
    uint32_t taken;          // Data frames taken here by the caller, lost ones included.
    uint32_t acknowledged;   // `taken` as last sent to the peer.
    uint32_t under_way;      // Octets of frames that were sent and not credited.
    uint32_t unacknowledged; // Octets of frames taken since credit was last sent.
    uint16_t peer;
    uint16_t reserved;
    uint16_t sizes[MESSAGE_WINDOW]; // Sizes of the frames under way, by their number.
} message_position_t;

typedef struct { // Private.
    message_position_t position;
    message_inbox_t inbox; // Frames from this peer.
    bool is_life_set;      // Set by message_set_life: received frames do not change it.
    bool is_introduced;    // The peer was sent a frame in this life of the endpoint.
    bool is_syncing;       // A SYNC was sent and not answered yet.
    uint32_t strays;       // Frames dropped in a row.
    uint32_t sync_at;      // Strays at which the next SYNC is due.
    uint32_t refusals;     // Sends refused for lack of credit since the peer was last heard.
} message_channel_t;

/// Place of one peer, private: its channel and the octets of its inbox.
typedef struct {
    message_channel_t channel;
    uint8_t octets[MESSAGE_INBOX_OCTETS(1U)];
} message_place_t;

typedef struct { // Private, except `counters`.
    message_carrier_t carrier;
    message_carrier_t outlet; // Where frames go: the carrier, unless they are diverted.
    message_arrival_t arrival;
    uint16_t self;
    uint32_t life;
    message_place_t* places;
    size_t place_count;
    size_t channel_count; // Places in use, the first ones.
    uint32_t stamp;       // Stamp of the next frame that arrives.
    bool has_arrivals;    // Frames have arrived that were not checked yet.
    bool is_past;         // The block taken last was sent by an earlier life of its peer.
    uint8_t frame[MESSAGE_FRAME_MAX];
    message_counters_t counters;
} message_endpoint_t;

/// Selects the peers whose blocks may be taken now.
typedef struct {
    void* context;
    bool (*admits)(void* context, uint16_t peer);
} message_filter_t;

/// life >= 1: the start count of this component. places: one for each peer, at most MESSAGE_PEERS_MAX; they
/// need not be cleared.
void message_open(message_endpoint_t* endpoint, uint16_t self, uint32_t life, message_carrier_t carrier,
                  message_place_t* places, size_t place_count);
/// STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED: no place is left.
MUST_USE status_t message_add_peer(message_endpoint_t* endpoint, uint16_t peer);
/// Set the life of a peer, >= 1. A life other than the known one resets the channel at once. No effect for an
/// unknown peer.
void message_set_life(message_endpoint_t* endpoint, uint16_t peer, uint32_t life);
/// STATUS_OK; STATUS_FULL: no credit or carrier full, nothing sent; STATUS_NOT_FOUND: no such peer;
/// STATUS_TOO_LARGE: more than MESSAGE_PAYLOAD_MAX octets; STATUS_CLOSED: the carrier cannot reach the peer.
MUST_USE status_t message_send(message_endpoint_t* endpoint, uint16_t to, const uint8_t* octets, size_t size);
/// Like message_send, for a block that may wait: STATUS_FULL also if only the reserve of the window is left.
MUST_USE status_t message_send_plain(message_endpoint_t* endpoint, uint16_t to, const uint8_t* octets,
                                     size_t size);
/// For carriers: a frame has arrived. STATUS_OK: kept, or malformed and counted; STATUS_FULL: beyond the
/// window.
MUST_USE status_t message_deliver(message_endpoint_t* endpoint, const uint8_t* frame, size_t size);
/// Process everything in the arrived frames except their blocks: credit, SYNC, lives. Sends the answers.
void message_take_control(message_endpoint_t* endpoint);
/// Do the work of message_take_control, then take the block that arrived first. STATUS_OK, STATUS_EMPTY,
/// STATUS_TOO_LARGE (dropped); after the last two the content of `octets` is undefined.
MUST_USE status_t message_receive(message_endpoint_t* endpoint, uint16_t* out_from, uint8_t* octets,
                                  size_t capacity, size_t* out_size);
/// Sender, size and first octets (up to MESSAGE_HEAD_OCTETS) of the block that message_receive_if would take;
/// the octets are valid until the next call for this endpoint. STATUS_OK, STATUS_EMPTY.
MUST_USE status_t message_next(message_endpoint_t* endpoint, const message_filter_t* filter,
                               uint16_t* out_from, const uint8_t** out_head, size_t* out_size);
/// Like message_receive, but only from peers that the filter admits. Blocks of other peers wait, and their
/// credit is not returned.
MUST_USE status_t message_receive_if(message_endpoint_t* endpoint, const message_filter_t* filter,
                                     uint16_t* out_from, uint8_t* octets, size_t capacity, size_t* out_size);
/// True if the block taken last was sent by an earlier life of its peer, which has ended since it arrived.
bool message_is_of_past(const message_endpoint_t* endpoint);
/// The connection to a peer works again: exchange SYNC with it. No effect if nothing was under way.
void message_probe(message_endpoint_t* endpoint, uint16_t peer);
/// For carriers: `received` is the outcome of receiving `size` octets into endpoint->frame. A frame is
/// delivered; a frame beyond the window of its sender is counted. STATUS_OK; STATUS_NOT_OURS (too large; or
/// to another life of this endpoint from a peer with a life set by message_set_life, which the scheduler did
/// not announce to this one: dropped and counted); or `received`.
MUST_USE status_t message_accept(message_endpoint_t* endpoint, status_t received, size_t size);
/// Blocks that may be sent to a peer now, as long as their octets fit. If this is not 0, the next block fits,
/// whatever its size. 0 for an unknown peer.
uint32_t message_credit(const message_endpoint_t* endpoint, uint16_t peer);
/// Like message_credit, but without the reserve, for message_send_plain.
uint32_t message_credit_plain(const message_endpoint_t* endpoint, uint16_t peer);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_H
