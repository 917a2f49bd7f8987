// SPDX-License-Identifier: Apache-2.0
/// Carries octet blocks between components, in order, with sequence numbers and end-to-end credits.
///
/// An endpoint has an address (the component's id) and a channel to each peer. A sender may have at most
/// MESSAGE_WINDOW blocks, of MESSAGE_WINDOW_OCTETS together, under way that the receiver has not taken; where
/// these leave no room for the largest block, message_send says STATUS_FULL and nothing is lost. An inbox of
/// MESSAGE_INBOX_OCTETS holds all that its peers may have under way. The frame below is the same over every
/// carrier (a ring of the same program, UDP, TIPC):
///
///     magic u16 0x484D | version u8 1 | kind u8 (0 data, 1 credit, 2 probe) | from u16 | to u16 | from epoch
///     u32 | to epoch u32 (0 unknown) | sequence u32 | taken u32 | payload              (24 octets,
///     big-endian)
///
/// Where the way there was cut, a whole window may be lost in both directions. A sender that is refused again
/// and again without hearing anything asks by a probe; its answer tells what was taken, and gives the credit
/// back.
///
/// The epoch is the start count of a component. A higher one resets the channel, a lower one and a frame
/// that may be for an earlier incarnation of the receiver are dropped and counted: an old peer is never
/// taken for the new. A component that was started again is therefore heard before it can be told anything.
///
/// Ownership  The caller places the endpoint and its inbox. Context: one task. Never blocks. Time O(size).
/// Errors     Each function lists every status it returns; a null argument is a coding error (FSW_ASSERT).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_H

#include "fsw/framework/base/capacities.h"
#include "fsw/framework/base/status.h"
#include "fsw/framework/message/octet_ring.h"

#include <stddef.h>
#include <stdint.h>

#define MESSAGE_HEADER_OCTETS 24U
#define MESSAGE_PAYLOAD_MAX 4096U
#define MESSAGE_FRAME_MAX (MESSAGE_HEADER_OCTETS + MESSAGE_PAYLOAD_MAX)
#define MESSAGE_WINDOW 32U           ///< Blocks under way on a channel and direction.
#define MESSAGE_WINDOW_OCTETS 32768U ///< Octets of these with their headers.
#define MESSAGE_PEERS_MAX CAPACITY_SUBSYSTEMS
#define MESSAGE_ANSWERS 8U ///< Credits and probes on top of a full window, for which an inbox has room.
/// Inbox that holds full windows of `peers` channels: each block takes its frame and four octets more.
#define MESSAGE_INBOX_OCTETS(peers)                                                                          \
    ((peers) *                                                                                               \
     (MESSAGE_WINDOW_OCTETS + (MESSAGE_WINDOW * 4U) + (MESSAGE_ANSWERS * (MESSAGE_HEADER_OCTETS + 4U))))

/// How a frame reaches a peer: STATUS_OK, STATUS_FULL (try again), anything else: nobody there now. Only a
/// frame that was taken counts as sent.
typedef struct {
    void* context;
    status_t (*send)(void* context, uint16_t to, const uint8_t* frame, size_t size);
} message_carrier_t;

typedef struct {
    uint32_t sent;        ///< Blocks accepted by message_send.
    uint32_t received;    ///< Blocks taken by message_receive.
    uint32_t no_credit;   ///< Sends refused for lack of credit.
    uint32_t lost;        ///< Blocks missing in the sequence.
    uint32_t stale;       ///< Frames of an earlier epoch or out of sequence, dropped.
    uint32_t malformed;   ///< Frames that are none, dropped.
    uint32_t unreachable; ///< Frames the carrier could not deliver.
    uint32_t probes;      ///< Peers asked what they have taken.
} message_counters_t;

typedef struct { // Private.
    uint16_t peer;
    uint32_t peer_epoch;            // 0: not heard of yet.
    uint32_t sent;                  // Data frames sent in this incarnation of the channel.
    uint32_t credited;              // Of these, taken by the peer.
    uint32_t expected;              // Next sequence number from the peer.
    uint32_t taken;                 // Data frames taken here.
    uint32_t told;                  // `taken` as last told to the peer.
    uint32_t refusals;              // Sends refused for lack of credit since the peer was last heard.
    uint32_t under_way;             // Octets of frames that were sent and not credited.
    uint32_t untold;                // Octets of frames taken since the peer was last told.
    uint16_t sizes[MESSAGE_WINDOW]; // Of the frames under way, by their number.
} message_channel_t;

typedef struct { // Private, except `counters` and `inbox`.
    message_carrier_t carrier;
    uint16_t self;
    uint32_t epoch;
    message_channel_t channels[MESSAGE_PEERS_MAX];
    size_t channel_count;
    uint8_t frame[MESSAGE_FRAME_MAX];
    octet_ring_t inbox; ///< Received frames; the carrier puts them here.
    message_counters_t counters;
} message_endpoint_t;

/// epoch >= 1: the start count of this component.
void message_open(message_endpoint_t* endpoint, uint16_t self, uint32_t epoch, message_carrier_t carrier,
                  uint8_t* inbox_storage, size_t inbox_octets);
/// STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED.
MUST_USE status_t message_add_peer(message_endpoint_t* endpoint, uint16_t peer);
/// STATUS_OK; STATUS_FULL: no credit or carrier full, nothing sent; STATUS_NOT_FOUND: no such peer;
/// STATUS_TOO_LARGE: more than MESSAGE_PAYLOAD_MAX octets; STATUS_CLOSED: the carrier cannot reach the peer.
MUST_USE status_t message_send(message_endpoint_t* endpoint, uint16_t to, const uint8_t* octets, size_t size);
/// Take the oldest block. STATUS_OK, STATUS_EMPTY, STATUS_TOO_LARGE (dropped); with these, what `octets`
/// holds means nothing.
MUST_USE status_t message_receive(message_endpoint_t* endpoint, uint16_t* out_from, uint8_t* octets,
                                  size_t capacity, size_t* out_size);
/// The way to a peer is there again: ask what it has taken of what was under way. No effect if nothing was.
void message_probe(message_endpoint_t* endpoint, uint16_t peer);
/// Blocks that may be sent to a peer now, as long as their octets have room: the next one has, whatever its
/// size, if this is not 0. 0 for an unknown peer.
uint32_t message_credit(const message_endpoint_t* endpoint, uint16_t peer);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_H
