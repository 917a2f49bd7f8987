// SPDX-License-Identifier: Apache-2.0
/// Carries octet blocks between components, in order, with sequence numbers and end-to-end credits. Frame,
/// credits, SYNC and lives: docs/framework.md, "Messages".
///
/// An endpoint has an address (the component's id) and a channel to each peer. If the window of a channel has
/// no room for the largest block, message_send returns STATUS_FULL and nothing is lost. The last
/// MESSAGE_RESERVE blocks and a quarter of the octets of a window are reserved for message_send;
/// message_send_plain does not use them. Each peer has its own inbox, which holds a full window of that peer:
/// a peer that floods its window, or whose blocks are not taken, does not block other peers.
///
/// Ownership  The caller provides the endpoint and its slots.
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
#define MESSAGE_WINDOW 32U ///< Blocks that may be on their way on a channel in one direction.
/// Octets of these blocks, including their headers, unless both ends of the channel set a smaller number
/// (message_set_window).
#define MESSAGE_WINDOW_OCTETS 32768U
/// Smallest number: the window to a component whose program runs on a board.
#define MESSAGE_SMALL_WINDOW_OCTETS 8192U
/// Largest window for which the inboxes of a program have room. A build for a board defines a smaller one.
#ifndef MESSAGE_ROOM_OCTETS
#define MESSAGE_ROOM_OCTETS MESSAGE_WINDOW_OCTETS
#endif
#define MESSAGE_PEERS_MAX CAPACITY_SUBSYSTEMS
#define MESSAGE_HEAD_OCTETS 16U ///< Octets of a waiting block that can be read in place.
#define MESSAGE_RESERVE 8U      ///< Blocks of a window reserved for message_send.
/// Octets of a window reserved for message_send.
#define MESSAGE_RESERVE_OCTETS(window) ((window) / 4U)
/// Inboxes that hold full windows of `peers` channels: each block needs the octets of its frame plus four.
#define MESSAGE_INBOX_OCTETS(peers) ((peers) * (MESSAGE_WINDOW_OCTETS + (MESSAGE_WINDOW * 4U)))
CAPACITY_CHECK(inboxes_have_room_for_a_window, (MESSAGE_ROOM_OCTETS >= MESSAGE_SMALL_WINDOW_OCTETS) &&
                                                   (MESSAGE_ROOM_OCTETS <= MESSAGE_WINDOW_OCTETS));

/// Function that sends a frame to a peer. STATUS_OK: the frame counts as sent; STATUS_FULL: try again; any
/// other status: the peer cannot be reached now.
typedef struct {
    void* context;
    status_t (*send)(void* context, uint16_t to, const uint8_t* frame, size_t size);
} message_carrier_t;

/// Callback that gets each frame that was stored in an inbox, before the carrier releases the frame.
typedef struct {
    void* context;
    void (*arrived)(void* context, const uint8_t* frame, size_t size);
} message_arrival_t;

typedef struct {
    uint32_t sent;        ///< Blocks accepted by message_send.
    uint32_t received;    ///< Blocks taken, those too large for the caller included.
    uint32_t no_credit;   ///< Sends refused for lack of credit.
    uint32_t lost;        ///< Blocks missing in the sequence.
    uint32_t stale;       ///< Frames of another life or outside of the window, dropped.
    uint32_t malformed;   ///< Octets that do not form a valid frame of a peer, dropped.
    uint32_t overruns;    ///< Frames beyond the window of their sender, dropped.
    uint32_t unreachable; ///< Frames that the carrier could not deliver.
    uint32_t syncs;       ///< SYNC frames sent.
    /// Blocks that were sent to an earlier life of a peer, and for which it returned no credit.
    uint32_t abandoned;
} message_counters_t;

// Position of a channel: the numbers that another process needs in order to continue the channel.
typedef struct {
    uint32_t peer_life;      // 0: no frame of the peer has arrived.
    uint32_t sent;           // Data frames sent to this life of the peer.
    uint32_t credited;       // Sent frames that the peer has taken.
    uint32_t expected;       // Next sequence number from the peer.
    uint32_t taken;          // Data frames that the caller has taken; lost ones are included.
    uint32_t acknowledged;   // Value of `taken` that was last sent to the peer.
    uint32_t under_way;      // Octets of frames that were sent and not credited.
    uint32_t unacknowledged; // Octets of frames taken since credit was last sent.
    uint16_t peer;
    uint16_t reserved;
    // Sizes of the frames that are not credited; index: sequence number modulo the window.
    uint16_t sizes[MESSAGE_WINDOW];
} message_position_t;

typedef struct { // Private.
    message_position_t position;
    message_inbox_t inbox; // Frames from this peer.
    uint32_t window;       // Octets that may be on their way to this peer.
    bool is_life_set;      // Set by message_set_life: received frames do not change it.
    bool is_introduced;    // A frame was sent to the peer in this life of the endpoint.
    bool is_syncing;       // A SYNC was sent and not answered yet.
    uint32_t strays;       // Frames in a row that were dropped because their numbers were impossible.
    uint32_t sync_at;      // Number of strays at which the next SYNC is due.
    uint32_t refusals;     // Sends refused for lack of credit since the channel had credit last.
} message_channel_t;

/// Private: storage for one peer, its channel and the octets of its inbox.
typedef struct {
    message_channel_t channel;
    uint8_t octets[MESSAGE_ROOM_OCTETS + (MESSAGE_WINDOW * 4U)];
} message_slot_t;

typedef struct { // Private, except `counters`.
    message_carrier_t carrier;
    message_carrier_t outlet; // Destination of frames: the carrier, unless message_divert has replaced it.
    message_arrival_t arrival;
    uint16_t self;
    uint32_t life;
    uint32_t window; // Octets that may be on their way from each peer.
    message_slot_t* slots;
    size_t slot_count;
    size_t channel_count; // Number of slots in use, from the first one.
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

/// Open an endpoint. life >= 1: the start count of this component. slots: one for each peer, at most
/// MESSAGE_PEERS_MAX; they need not be cleared.
void message_open(message_endpoint_t* endpoint, uint16_t self, uint32_t life, message_carrier_t carrier,
                  message_slot_t* slots, size_t slot_count);
/// Add a channel to a peer. STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED (no slot is free).
MUST_USE status_t message_add_peer(message_endpoint_t* endpoint, uint16_t peer);
/// Set the window of all channels to `component`, which is a peer or this endpoint: octets that may be on
/// their way to it on one channel; 0: MESSAGE_WINDOW_OCTETS. Both ends of a channel must set the same number
/// before they send a block. STATUS_OK; STATUS_NOT_FOUND (no such peer); STATUS_OUT_OF_RANGE (less than
/// MESSAGE_SMALL_WINDOW_OCTETS, more than MESSAGE_WINDOW_OCTETS, or for this endpoint more than
/// MESSAGE_ROOM_OCTETS).
MUST_USE status_t message_set_window(message_endpoint_t* endpoint, uint16_t component, uint32_t octets);
/// Set the life of a peer, >= 1. If it differs from the known life, the channel is reset immediately. No
/// effect for an unknown peer.
void message_set_life(message_endpoint_t* endpoint, uint16_t peer, uint32_t life);
/// Send a block. STATUS_OK; STATUS_FULL: no credit or carrier full, the block is not sent;
/// STATUS_NOT_FOUND: no such peer; STATUS_TOO_LARGE: more than MESSAGE_PAYLOAD_MAX octets; STATUS_CLOSED:
/// the carrier cannot reach the peer.
MUST_USE status_t message_send(message_endpoint_t* endpoint, uint16_t to, const uint8_t* octets, size_t size);
/// Like message_send, for a block that may be sent later: STATUS_FULL also if only the reserve of the window
/// is left.
MUST_USE status_t message_send_plain(message_endpoint_t* endpoint, uint16_t to, const uint8_t* octets,
                                     size_t size);
/// Called by carriers when a frame has arrived. STATUS_OK: stored, or malformed and counted; STATUS_FULL:
/// the frame is beyond the window (counted).
MUST_USE status_t message_deliver(message_endpoint_t* endpoint, const uint8_t* frame, size_t size);
/// Process credit, SYNC and lives in the frames that have arrived, and send the answers; the blocks stay in
/// the inboxes.
void message_take_control(message_endpoint_t* endpoint);
/// Do the work of message_take_control, then take the block that arrived first. STATUS_OK, STATUS_EMPTY,
/// STATUS_TOO_LARGE (dropped); after the last two the content of `octets` is undefined.
MUST_USE status_t message_receive(message_endpoint_t* endpoint, uint16_t* out_from, uint8_t* octets,
                                  size_t capacity, size_t* out_size);
/// Get sender, size and first octets (up to MESSAGE_HEAD_OCTETS) of the block that message_receive_if would
/// take; the octets are valid until the next call for this endpoint. STATUS_OK, STATUS_EMPTY.
MUST_USE status_t message_next(message_endpoint_t* endpoint, const message_filter_t* filter,
                               uint16_t* out_from, const uint8_t** out_head, size_t* out_size);
/// Like message_receive, but only from peers that the filter admits. Blocks of other peers wait, and their
/// credit is not returned.
MUST_USE status_t message_receive_if(message_endpoint_t* endpoint, const message_filter_t* filter,
                                     uint16_t* out_from, uint8_t* octets, size_t capacity, size_t* out_size);
/// True if the block taken last was sent by an earlier life of its peer, which ended after the block arrived.
bool message_is_of_past(const message_endpoint_t* endpoint);
/// Exchange SYNC with a peer, because the connection to the peer works again. No effect if the peer has
/// credited all frames.
void message_probe(message_endpoint_t* endpoint, uint16_t peer);
/// Called by carriers after receiving `size` octets into endpoint->frame; `received` is the status of that
/// reception. Delivers a frame; counts a frame beyond the window of its sender. STATUS_OK; STATUS_NOT_OURS
/// (dropped and counted: the frame is too large, or a peer whose life message_set_life has set addressed it
/// to another life of this endpoint, so that the scheduler did not announce it to this life); or `received`.
MUST_USE status_t message_accept(message_endpoint_t* endpoint, status_t received, size_t size);
/// Returns the number of blocks that may be sent to a peer now, if their octets fit the window. If the
/// number is not 0, a block of any size can be sent. 0 for an unknown peer.
uint32_t message_credit(const message_endpoint_t* endpoint, uint16_t peer);
/// Like message_credit, but for message_send_plain: without the reserve.
uint32_t message_credit_plain(const message_endpoint_t* endpoint, uint16_t peer);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_H
