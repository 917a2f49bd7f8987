// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/octets.h"

#include <string.h>

#define MAGIC 0x484DU
#define VERSION 1U
#define KIND_DATA 0U
#define KIND_CREDIT 1U
#define KIND_SYNC 2U
#define KIND_SYNC_ACK 3U
#define FIRST_PROBE 4U         ///< Refusals in a row after which a peer is asked what it has taken.
#define STRAYS_MAX 3U          ///< Frames outside of the window in a row after which SYNC is sent.
#define SYNC_SPACING 1024U     ///< Strays between two SYNCs that nobody answers, at most.
#define LOST_AT_ONCE_MAX 4096U ///< A larger gap is no loss: one of both numbers was forged or damaged.
#define FIRST_LIFE 1U

/// Place of each field in the header.
enum {
    AT_MAGIC     = 0,
    AT_VERSION   = 2,
    AT_KIND      = 3,
    AT_FROM      = 4,
    AT_TO        = 6,
    AT_FROM_LIFE = 8,
    AT_TO_LIFE   = 12,
    AT_SEQUENCE  = 16,
    AT_TAKEN     = 20
};

typedef struct {
    uint8_t kind;
    uint16_t from;
    uint16_t to;
    uint32_t from_life;
    uint32_t to_life;
    uint32_t sequence;
    uint32_t taken;
    size_t size; // Of the payload.
} frame_t;

static message_channel_t* channel_of(message_endpoint_t* const endpoint, const uint16_t peer)
{
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        if (endpoint->channels[i].peer == peer) {
            return &endpoint->channels[i];
        }
    }
    return NULL;
}

void message_open(message_endpoint_t* const endpoint, const uint16_t self, const uint32_t life,
                  const message_carrier_t carrier, uint8_t* const inbox_storage, const size_t inbox_octets)
{
    FSW_ASSERT((endpoint != NULL) && (carrier.send != NULL) && (life >= 1U));
    (void)memset(endpoint, 0, sizeof *endpoint);
    endpoint->self    = self;
    endpoint->life    = life;
    endpoint->carrier = carrier;
    octet_ring_init(&endpoint->inbox, inbox_storage, inbox_octets);
}

status_t message_add_peer(message_endpoint_t* const endpoint, const uint16_t peer)
{
    FSW_ASSERT(endpoint != NULL);
    if (channel_of(endpoint, peer) != NULL) {
        return STATUS_EXISTS;
    }
    if (endpoint->channel_count == MESSAGE_PEERS_MAX) {
        return STATUS_EXHAUSTED;
    }
    endpoint->channels[endpoint->channel_count] = (message_channel_t){.peer = peer, .sync_at = STRAYS_MAX};
    endpoint->channel_count++;
    return STATUS_OK;
}

/// Write a frame around `size` octets of payload and hand it to the carrier.
static status_t send_frame(message_endpoint_t* const endpoint, message_channel_t* const channel,
                           const uint8_t kind, const uint8_t* const octets, const size_t size)
{
    uint8_t* const frame = endpoint->frame;
    octets_put_u16(&frame[AT_MAGIC], MAGIC);
    frame[AT_VERSION] = VERSION;
    frame[AT_KIND]    = kind;
    octets_put_u16(&frame[AT_FROM], endpoint->self);
    octets_put_u16(&frame[AT_TO], channel->peer);
    octets_put_u32(&frame[AT_FROM_LIFE], endpoint->life);
    octets_put_u32(&frame[AT_TO_LIFE], channel->peer_life);
    octets_put_u32(&frame[AT_SEQUENCE], channel->sent);
    octets_put_u32(&frame[AT_TAKEN], channel->taken);
    if (size > 0U) {
        (void)memcpy(&frame[MESSAGE_HEADER_OCTETS], octets, size);
    }
    const status_t status =
        endpoint->carrier.send(endpoint->carrier.context, channel->peer, frame, MESSAGE_HEADER_OCTETS + size);
    if (status == STATUS_OK) {
        channel->told          = channel->taken;
        channel->untold        = 0U;
        channel->is_introduced = true;
    } else if (status != STATUS_FULL) {
        endpoint->counters.unreachable++;
    }
    return status;
}

/// Blocks that may be sent: none where the largest one would not fit the window any more.
static uint32_t credit_of(const message_channel_t* const channel)
{
    return ((channel->under_way + MESSAGE_FRAME_MAX) > MESSAGE_WINDOW_OCTETS)
               ? 0U
               : (MESSAGE_WINDOW - (channel->sent - channel->credited));
}

/// The peer has taken all frames before number `taken`.
static void credit_up_to(message_channel_t* const channel, const uint32_t taken)
{
    for (; channel->credited != taken; channel->credited++) {
        channel->under_way -= channel->sizes[channel->credited % MESSAGE_WINDOW];
    }
}

/// Say where both directions stand, and ask the same: after a loss of whole windows nobody else would say a
/// word, and what was forged or damaged may have led either side away from the other's numbers.
static void sync(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    if (send_frame(endpoint, channel, KIND_SYNC, NULL, 0U) == STATUS_OK) {
        channel->is_syncing = true;
        endpoint->counters.syncs++;
    }
}

/// The more refusals without a word from the peer, the rarer: what asks must not fill the way that is to be
/// freed.
static void refused_for_credit(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    endpoint->counters.no_credit++;
    channel->refusals++;
    const bool is_power_of_two = ((channel->refusals & (channel->refusals - 1U)) == 0U);
    if ((channel->refusals >= FIRST_PROBE) && is_power_of_two) {
        sync(endpoint, channel);
    }
}

void message_probe(message_endpoint_t* const endpoint, const uint16_t peer)
{
    FSW_ASSERT(endpoint != NULL);
    message_channel_t* const channel = channel_of(endpoint, peer);
    if ((channel != NULL) && (channel->sent != channel->credited)) {
        sync(endpoint, channel);
    }
}

uint32_t message_stale_frames(const message_endpoint_t* const endpoint)
{
    FSW_ASSERT(endpoint != NULL);
    return endpoint->counters.stale;
}

uint32_t message_credit(const message_endpoint_t* const endpoint, const uint16_t peer)
{
    FSW_ASSERT(endpoint != NULL);
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        const message_channel_t* const channel = &endpoint->channels[i];
        if (channel->peer == peer) {
            return credit_of(channel);
        }
    }
    return 0U;
}

status_t message_send(message_endpoint_t* const endpoint, const uint16_t to, const uint8_t* const octets,
                      const size_t size)
{
    FSW_ASSERT((endpoint != NULL) && ((octets != NULL) || (size == 0U)));
    message_channel_t* const channel = channel_of(endpoint, to);
    if (channel == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (size > MESSAGE_PAYLOAD_MAX) {
        return STATUS_TOO_LARGE;
    }
    if (credit_of(channel) == 0U) {
        refused_for_credit(endpoint, channel);
        return STATUS_FULL;
    }
    const status_t status = send_frame(endpoint, channel, KIND_DATA, octets, size);
    if (status == STATUS_OK) {
        const uint16_t frame_size                      = (uint16_t)(MESSAGE_HEADER_OCTETS + size);
        channel->sizes[channel->sent % MESSAGE_WINDOW] = frame_size;
        channel->under_way += frame_size;
        channel->sent++;
        endpoint->counters.sent++;
    }
    return ((status == STATUS_OK) || (status == STATUS_FULL)) ? status : STATUS_CLOSED;
}

/// STATUS_OK, or STATUS_INVALID for a header that no frame for us has, or none of its size.
static status_t parse(const message_endpoint_t* const endpoint, const uint8_t* const octets,
                      const size_t size, frame_t* const out_frame)
{
    if ((size < MESSAGE_HEADER_OCTETS) || (size > MESSAGE_FRAME_MAX)) {
        return STATUS_INVALID;
    }
    out_frame->kind         = octets[AT_KIND];
    out_frame->from         = octets_u16_at(&octets[AT_FROM]);
    out_frame->to           = octets_u16_at(&octets[AT_TO]);
    out_frame->from_life    = octets_u32_at(&octets[AT_FROM_LIFE]);
    out_frame->to_life      = octets_u32_at(&octets[AT_TO_LIFE]);
    out_frame->sequence     = octets_u32_at(&octets[AT_SEQUENCE]);
    out_frame->taken        = octets_u32_at(&octets[AT_TAKEN]);
    out_frame->size         = size - MESSAGE_HEADER_OCTETS;
    const bool is_well_made = (octets_u16_at(&octets[AT_MAGIC]) == MAGIC) &&
                              (octets[AT_VERSION] == VERSION) && (out_frame->kind <= KIND_SYNC_ACK) &&
                              (out_frame->to == endpoint->self) && (out_frame->from_life != 0U);
    return is_well_made ? STATUS_OK : STATUS_INVALID;
}

/// Another life of the peer: both directions are numbered from 0 again. Only a peer in its first life may
/// have taken what was sent before it was heard of.
static void meet(message_endpoint_t* const endpoint, message_channel_t* const channel, const uint32_t life)
{
    const bool is_restart = (channel->peer_life != 0U) || (life > FIRST_LIFE);
    channel->peer_life    = life;
    channel->expected     = 0U;
    channel->taken        = 0U;
    channel->told         = 0U;
    channel->untold       = 0U;
    channel->is_syncing   = false;
    channel->strays       = 0U;
    channel->sync_at      = STRAYS_MAX;
    channel->refusals     = 0U;
    if (is_restart) { // What was under way to its predecessor is gone.
        endpoint->counters.abandoned += channel->sent - channel->credited;
        channel->sent      = 0U;
        channel->credited  = 0U;
        channel->under_way = 0U;
    }
}

void message_set_life(message_endpoint_t* const endpoint, const uint16_t peer, const uint32_t life)
{
    FSW_ASSERT((endpoint != NULL) && (life >= FIRST_LIFE));
    message_channel_t* const channel = channel_of(endpoint, peer);
    if (channel == NULL) {
        return;
    }
    if (life != channel->peer_life) {
        meet(endpoint, channel, life);
    }
    channel->is_life_said = true;
}

/// What a frame says cannot be. One frame may be late; several in a row show that both sides count
/// differently.
static void out_of_step(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    channel->strays++;
    const bool is_due = (channel->strays >= channel->sync_at);
    if (is_due) {
        channel->sync_at += (channel->strays < SYNC_SPACING) ? channel->strays : SYNC_SPACING;
    }
    if (is_due || (!channel->is_life_said && !channel->is_introduced)) {
        sync(endpoint, channel);
    }
}

/// A frame that is outside of the window, or names a life that is not ours.
static void stray(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    endpoint->counters.stale++;
    out_of_step(endpoint, channel);
}

static void in_step(message_channel_t* const channel)
{
    channel->strays  = 0U;
    channel->sync_at = STRAYS_MAX;
}

/// What answers a SYNC comes from a peer that lives now: if that is an earlier life than was believed, the
/// later one was forged or damaged. Its numbers have nothing to do with ours: another exchange tells both.
static void correct_life(message_endpoint_t* const endpoint, message_channel_t* const channel,
                         const frame_t* const frame)
{
    meet(endpoint, channel, frame->from_life);
    channel->expected = frame->sequence;
    channel->taken    = frame->sequence;
    channel->told     = frame->sequence;
    sync(endpoint, channel);
}

/// Bring the channel up to the life of its peer. False if the frame is of another one.
static bool is_of_this_life(message_endpoint_t* const endpoint, message_channel_t* const channel,
                            const frame_t* const frame)
{
    if (channel->is_life_said) {
        endpoint->counters.stale += (frame->from_life != channel->peer_life) ? 1U : 0U;
        return frame->from_life == channel->peer_life;
    }
    if (frame->from_life > channel->peer_life) {
        meet(endpoint, channel, frame->from_life);
    } else if (frame->from_life == channel->peer_life) {
        // As known.
    } else if ((frame->kind == KIND_SYNC_ACK) && channel->is_syncing) {
        correct_life(endpoint, channel, frame);
        return false;
    } else {
        stray(endpoint, channel);
        return false;
    }
    return true;
}

static void answer(message_endpoint_t* const endpoint, message_channel_t* const channel,
                   const frame_t* const frame)
{
    if (frame->kind == KIND_SYNC) {
        (void)send_frame(endpoint, channel, KIND_SYNC_ACK, NULL, 0U); // If refused, the peer asks again.
    }
}

/// Bring the channel up to date with a frame of its peer. False if the frame is to be dropped.
static bool is_current(message_endpoint_t* const endpoint, message_channel_t* const channel,
                       const frame_t* const frame)
{
    if (!is_of_this_life(endpoint, channel, frame)) {
        return false;
    }
    // A sender that has not heard of this endpoint may have meant its predecessor, if there was one.
    const bool is_for_us =
        (frame->to_life == endpoint->life) || ((frame->to_life == 0U) && (endpoint->life == FIRST_LIFE));
    if (!is_for_us && (frame->kind == KIND_SYNC)) {
        endpoint->counters.stale++; // Its numbers are of another life, but it shall know ours.
        answer(endpoint, channel, frame);
        return false;
    }
    if (!is_for_us) {
        stray(endpoint, channel);
        return false;
    }
    channel->refusals = 0U;
    return true;
}

/// Both sides say where they stand; nothing that was sent before is on its way any more.
static void resync(message_endpoint_t* const endpoint, message_channel_t* const channel,
                   const frame_t* const frame)
{
    const uint32_t ahead     = frame->sequence - channel->expected;
    const uint32_t under_way = channel->sent - frame->taken;
    endpoint->counters.lost += (ahead <= LOST_AT_ONCE_MAX) ? ahead : 0U;
    channel->expected = frame->sequence;
    channel->taken    = frame->sequence; // Lost blocks give their credit back, too.
    if (ahead > LOST_AT_ONCE_MAX) {
        channel->told = channel->taken;
    }
    if ((under_way <= MESSAGE_WINDOW) && (under_way <= channel->sent)) {
        channel->credited  = frame->taken;
        channel->under_way = 0U;
        for (uint32_t i = frame->taken; i != channel->sent; i++) {
            channel->under_way += channel->sizes[i % MESSAGE_WINDOW];
        }
    }
    channel->is_syncing = channel->is_syncing && (frame->kind != KIND_SYNC_ACK);
    in_step(channel);
    answer(endpoint, channel, frame);
}

/// True if a data frame is the next or a later one of its sequence. Credit carries the number of the next
/// data frame: it shows a loss even where the whole window was lost and no data frame can follow.
static bool is_in_sequence(message_endpoint_t* const endpoint, message_channel_t* const channel,
                           const frame_t* const frame)
{
    const uint32_t ahead     = frame->sequence - channel->expected;
    const uint32_t limit     = (frame->kind == KIND_DATA) ? (MESSAGE_WINDOW - 1U) : MESSAGE_WINDOW;
    const bool is_claim_good = (frame->taken - channel->credited) <= (channel->sent - channel->credited);
    if (is_claim_good) {
        credit_up_to(channel, frame->taken);
    }
    if (ahead > limit) { // No sender may be further ahead than its credit, nor behind.
        stray(endpoint, channel);
        return false;
    }
    if (is_claim_good) {
        in_step(channel);
    } else { // More than was sent, or less than was told before: the block is good nevertheless.
        out_of_step(endpoint, channel);
    }
    endpoint->counters.lost += ahead;
    channel->expected = frame->sequence + ((frame->kind == KIND_DATA) ? 1U : 0U);
    channel->taken    = channel->expected; // Lost blocks give their credit back, too.
    if (frame->kind != KIND_DATA) {
        return false;
    }
    channel->untold += (uint32_t)(MESSAGE_HEADER_OCTETS + frame->size);
    return true;
}

static void return_credit(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    if (((channel->taken - channel->told) >= (MESSAGE_WINDOW / 2U)) ||
        (channel->untold >= (MESSAGE_WINDOW_OCTETS / 2U))) {
        (void)send_frame(endpoint, channel, KIND_CREDIT, NULL, 0U); // If refused, again at the next receive.
    }
}

/// Take note of what a frame tells. True if it carries a block for the caller.
static bool is_block(message_endpoint_t* const endpoint, message_channel_t* const channel,
                     const frame_t* const frame)
{
    if (!is_current(endpoint, channel, frame)) {
        return false;
    }
    if (frame->kind >= KIND_SYNC) {
        resync(endpoint, channel, frame);
        return false;
    }
    return is_in_sequence(endpoint, channel, frame);
}

static void return_all_credit(message_endpoint_t* const endpoint)
{
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        return_credit(endpoint, &endpoint->channels[i]);
    }
}

status_t message_receive(message_endpoint_t* const endpoint, uint16_t* const out_from, uint8_t* const octets,
                         const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((endpoint != NULL) && (out_from != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    for (;;) {
        uint8_t header[MESSAGE_HEADER_OCTETS];
        size_t size = 0U;
        const status_t status =
            octet_ring_take_parts(&endpoint->inbox, header, sizeof header, octets, capacity, &size);
        if (status == STATUS_EMPTY) {
            return_all_credit(endpoint);
            return STATUS_EMPTY;
        }
        frame_t frame;
        const bool is_frame              = parse(endpoint, header, size, &frame) == STATUS_OK;
        message_channel_t* const channel = is_frame ? channel_of(endpoint, frame.from) : NULL;
        if (channel == NULL) {
            endpoint->counters.malformed++;
            continue;
        }
        if (!is_block(endpoint, channel, &frame)) {
            continue;
        }
        const bool fits = (status == STATUS_OK);
        endpoint->counters.received++;
        *out_from = frame.from;
        *out_size = fits ? frame.size : 0U;
        return_credit(endpoint, channel);
        return fits ? STATUS_OK : STATUS_TOO_LARGE;
    }
}
