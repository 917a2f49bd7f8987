// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message.h"

#include "base/assertion.h"
#include "fsw/framework/message/message_frame.h"
#include "fsw/framework/message/message_window.h"

#include <string.h>

#define FIRST_PROBE 4U         ///< Refusals in a row after which the endpoint sends a SYNC to the peer.
#define STRAYS_MAX 3U          ///< Frames with impossible numbers in a row after which a SYNC is sent.
#define SYNC_SPACING 1024U     ///< Largest number of strays or refusals between two SYNCs.
#define LOST_AT_ONCE_MAX 4096U ///< A larger gap is not a loss: a number was forged or damaged.
#define FIRST_LIFE 1U

void message_open(message_endpoint_t* const endpoint, const uint16_t self, const uint32_t life,
                  const message_carrier_t carrier, message_slot_t* const slots, const size_t slot_count)
{
    FSW_ASSERT((endpoint != NULL) && (carrier.send != NULL) && (slots != NULL) && (life >= 1U));
    FSW_ASSERT(slot_count <= MESSAGE_PEERS_MAX);
    (void)memset(endpoint, 0, sizeof *endpoint);
    endpoint->self       = self;
    endpoint->life       = life;
    endpoint->window     = MESSAGE_ROOM_OCTETS;
    endpoint->carrier    = carrier;
    endpoint->outlet     = carrier;
    endpoint->slots      = slots;
    endpoint->slot_count = slot_count;
}

status_t message_add_peer(message_endpoint_t* const endpoint, const uint16_t peer)
{
    FSW_ASSERT(endpoint != NULL);
    if (message_channel_of(endpoint, peer) != NULL) {
        return STATUS_EXISTS;
    }
    if (endpoint->channel_count == endpoint->slot_count) {
        return STATUS_EXHAUSTED;
    }
    message_slot_t* const slot = &endpoint->slots[endpoint->channel_count];
    slot->channel =
        (message_channel_t){.position.peer = peer, .window = MESSAGE_WINDOW_OCTETS, .sync_at = STRAYS_MAX};
    message_inbox_init(&slot->channel.inbox, slot->octets, sizeof slot->octets);
    endpoint->channel_count++;
    return STATUS_OK;
}

/// Complete the frame of `size` octets of payload, and pass it to the carrier.
static status_t send_frame(message_endpoint_t* const endpoint, message_channel_t* const channel,
                           const uint8_t kind, const uint8_t* const octets, const size_t size)
{
    uint8_t* const frame         = endpoint->frame;
    const message_frame_t header = {.kind      = kind,
                                    .from      = endpoint->self,
                                    .to        = channel->position.peer,
                                    .from_life = endpoint->life,
                                    .to_life   = channel->position.peer_life,
                                    .sequence  = channel->position.sent,
                                    .taken     = channel->position.taken};
    message_frame_write(&header, frame);
    if (size > 0U) {
        (void)memcpy(&frame[MESSAGE_HEADER_OCTETS], octets, size);
    }
    const status_t status = endpoint->outlet.send(endpoint->outlet.context, channel->position.peer, frame,
                                                  MESSAGE_HEADER_OCTETS + size);
    if (status == STATUS_OK) {
        channel->position.acknowledged   = channel->position.taken;
        channel->position.unacknowledged = 0U;
        channel->is_introduced           = true;
    }
    endpoint->counters.unreachable += ((status != STATUS_OK) && (status != STATUS_FULL)) ? 1U : 0U;
    return status;
}

/// Record that the peer has taken all frames before number `taken`, which frees their room in the window.
static void credit_up_to(message_channel_t* const channel, const uint32_t taken)
{
    for (; channel->position.credited != taken; channel->position.credited++) {
        channel->position.under_way -= channel->position.sizes[channel->position.credited % MESSAGE_WINDOW];
    }
}

/// Send the sequence numbers of both directions and request those of the peer. After a loss of whole windows
/// no other frame would follow, and forged or damaged frames may have changed the numbers of either side.
static void sync(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    if (send_frame(endpoint, channel, MESSAGE_SYNC, NULL, 0U) == STATUS_OK) {
        channel->is_syncing = true;
        endpoint->counters.syncs++;
    }
}

/// Count a refusal, and send a SYNC at growing intervals, up to one in SYNC_SPACING refusals: SYNCs must not
/// fill a congested connection.
static void refused_for_credit(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    endpoint->counters.no_credit++;
    channel->refusals++;
    const bool is_power_of_two = ((channel->refusals & (channel->refusals - 1U)) == 0U);
    const bool is_due          = is_power_of_two || ((channel->refusals % SYNC_SPACING) == 0U);
    if ((channel->refusals >= FIRST_PROBE) && is_due) {
        sync(endpoint, channel);
    }
}

void message_probe(message_endpoint_t* const endpoint, const uint16_t peer)
{
    FSW_ASSERT(endpoint != NULL);
    message_channel_t* const channel = message_channel_of(endpoint, peer);
    if ((channel != NULL) && (channel->position.sent != channel->position.credited)) {
        sync(endpoint, channel);
    }
}

bool message_is_of_past(const message_endpoint_t* const endpoint)
{
    FSW_ASSERT(endpoint != NULL);
    return endpoint->is_past;
}

/// Send a message; a plain one leaves the reserve of the window free.
static status_t send_block(message_endpoint_t* const endpoint, const uint16_t to, const uint8_t* const octets,
                           const size_t size, const bool is_plain)
{
    FSW_ASSERT((endpoint != NULL) && ((octets != NULL) || (size == 0U)));
    message_channel_t* const channel = message_channel_of(endpoint, to);
    if (channel == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (size > MESSAGE_PAYLOAD_MAX) {
        return STATUS_TOO_LARGE;
    }
    if (message_window_credit(channel, is_plain) == 0U) {
        refused_for_credit(endpoint, channel);
        return STATUS_FULL;
    }
    const status_t status = send_frame(endpoint, channel, MESSAGE_DATA, octets, size);
    if (status == STATUS_OK) {
        const uint16_t frame_size = (uint16_t)(MESSAGE_HEADER_OCTETS + size);
        channel->position.sizes[channel->position.sent % MESSAGE_WINDOW] = frame_size;
        channel->position.under_way += frame_size;
        channel->position.sent++;
        endpoint->counters.sent++;
    }
    return ((status == STATUS_OK) || (status == STATUS_FULL)) ? status : STATUS_CLOSED;
}

status_t message_send(message_endpoint_t* const endpoint, const uint16_t to, const uint8_t* const octets,
                      const size_t size)
{
    return send_block(endpoint, to, octets, size, false);
}

status_t message_send_plain(message_endpoint_t* const endpoint, const uint16_t to,
                            const uint8_t* const octets, const size_t size)
{
    return send_block(endpoint, to, octets, size, true);
}

/// Returns the channel of the sender of a frame; null if there is none, or if the frame is malformed.
static message_channel_t* channel_of_frame(const message_endpoint_t* const endpoint,
                                           const uint8_t* const frame, const size_t size)
{
    FSW_ASSERT((endpoint != NULL) && ((frame != NULL) || (size == 0U)));
    return message_frame_is_well_formed(frame, size, endpoint->self)
               ? message_channel_of(endpoint, message_frame_from(frame))
               : NULL;
}

status_t message_deliver(message_endpoint_t* const endpoint, const uint8_t* const frame, const size_t size)
{
    message_channel_t* const channel = channel_of_frame(endpoint, frame, size);
    if (channel == NULL) {
        endpoint->counters.malformed++;
        return STATUS_OK;
    }
    const uint32_t life = message_frame_life(frame);
    status_t status     = STATUS_FULL;
    bool has_room       = true;
    while ((status == STATUS_FULL) && has_room) {
        status   = message_inbox_put(&channel->inbox, frame[MESSAGE_AT_KIND], endpoint->stamp, frame, size);
        has_room = (status == STATUS_FULL) && message_inbox_forget(&channel->inbox, life);
        // The removed frames belong to an earlier life of the peer.
        endpoint->counters.stale += has_room ? 1U : 0U;
    }
    if (status != STATUS_OK) { // A correct sender never sends beyond its window.
        endpoint->counters.overruns++;
        return STATUS_FULL;
    }
    endpoint->stamp++;
    endpoint->has_arrivals = true;
    if (endpoint->arrival.arrived != NULL) {
        endpoint->arrival.arrived(endpoint->arrival.context, frame, size);
    }
    return STATUS_OK;
}

/// Begin with another life of the peer: both directions are numbered from 0 again. In its first life a peer
/// may have taken frames before its own first frame arrived: the sent numbers then continue.
static void begin_peer_life(message_endpoint_t* const endpoint, message_channel_t* const channel,
                            const uint32_t life)
{
    const bool is_restart            = (channel->position.peer_life != 0U) || (life > FIRST_LIFE);
    channel->position.peer_life      = life;
    channel->position.expected       = 0U;
    channel->position.taken          = 0U;
    channel->position.acknowledged   = 0U;
    channel->position.unacknowledged = 0U;
    channel->is_syncing              = false;
    channel->strays                  = 0U;
    channel->sync_at                 = STRAYS_MAX;
    channel->refusals                = 0U;
    if (is_restart) { // Frames on the way to the earlier life are lost.
        endpoint->counters.abandoned += channel->position.sent - channel->position.credited;
        channel->position.sent      = 0U;
        channel->position.credited  = 0U;
        channel->position.under_way = 0U;
    }
}

void message_set_life(message_endpoint_t* const endpoint, const uint16_t peer, const uint32_t life)
{
    FSW_ASSERT((endpoint != NULL) && (life >= FIRST_LIFE));
    message_channel_t* const channel = message_channel_of(endpoint, peer);
    if (channel == NULL) {
        return;
    }
    if (life != channel->position.peer_life) {
        begin_peer_life(endpoint, channel, life);
    }
    channel->is_life_set = true;
}

/// Count a frame whose numbers are impossible. One frame may be late; several in a row show that both sides
/// count differently.
static void count_mismatch(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    channel->strays++;
    const bool is_due = (channel->strays >= channel->sync_at);
    if (is_due) {
        channel->sync_at += (channel->strays < SYNC_SPACING) ? channel->strays : SYNC_SPACING;
    }
    if (is_due || (!channel->is_life_set && !channel->is_introduced)) {
        sync(endpoint, channel);
    }
}

/// Count and drop a frame that is outside of the window, or belongs to another life of this component or to
/// an earlier one of the peer.
static void drop_stray(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    endpoint->counters.stale++;
    count_mismatch(endpoint, channel);
}

static void clear_mismatch(message_channel_t* const channel)
{
    channel->strays  = 0U;
    channel->sync_at = STRAYS_MAX;
}

/// Return to an earlier life of the peer. Only its present life answers a SYNC, so the later life was read
/// from a forged or damaged frame. A further exchange of SYNC determines the sequence numbers.
static void correct_life(message_endpoint_t* const endpoint, message_channel_t* const channel,
                         const message_frame_t* const frame)
{
    begin_peer_life(endpoint, channel, frame->from_life);
    channel->position.expected     = frame->sequence;
    channel->position.taken        = frame->sequence;
    channel->position.acknowledged = frame->sequence;
    sync(endpoint, channel);
}

/// Update the channel to the life of its peer. False if the frame is of another life.
static bool is_of_this_life(message_endpoint_t* const endpoint, message_channel_t* const channel,
                            const message_frame_t* const frame)
{
    if (channel->is_life_set) {
        endpoint->counters.stale += (frame->from_life != channel->position.peer_life) ? 1U : 0U;
        return frame->from_life == channel->position.peer_life;
    }
    if (frame->from_life > channel->position.peer_life) {
        begin_peer_life(endpoint, channel, frame->from_life);
    } else if (frame->from_life == channel->position.peer_life) {
        // The frame is of the known life.
    } else if ((frame->kind == MESSAGE_SYNC_ACK) && channel->is_syncing) {
        correct_life(endpoint, channel, frame);
        return false;
    } else {
        drop_stray(endpoint, channel);
        return false;
    }
    return true;
}

static void answer(message_endpoint_t* const endpoint, message_channel_t* const channel,
                   const message_frame_t* const frame)
{
    if (frame->kind == MESSAGE_SYNC) {
        // If it is not sent, the peer repeats its SYNC.
        (void)send_frame(endpoint, channel, MESSAGE_SYNC_ACK, NULL, 0U);
    }
}

/// True if the frame is addressed to this life. A sender that has not received a frame of this endpoint
/// does not know its life: its frame may be addressed to a predecessor, if there was one.
static bool is_own_life(const message_endpoint_t* const endpoint, const uint32_t life)
{
    return (life == endpoint->life) || ((life == 0U) && (endpoint->life == FIRST_LIFE));
}

/// True if a frame is addressed to another life of this endpoint.
static bool is_for_other_life(message_endpoint_t* const endpoint, const uint8_t* const frame,
                              const size_t size)
{
    const message_channel_t* const channel = channel_of_frame(endpoint, frame, size);
    const bool is_past                     = (channel != NULL) && channel->is_life_set &&
                         !is_own_life(endpoint, message_frame_read(frame, MESSAGE_DATA, size).to_life);
    endpoint->counters.stale += is_past ? 1U : 0U;
    return is_past;
}

status_t message_accept(message_endpoint_t* const endpoint, const status_t received, const size_t size)
{
    FSW_ASSERT(endpoint != NULL);
    if (received == STATUS_TOO_LARGE) {
        endpoint->counters.malformed++;
        return STATUS_NOT_OURS;
    }
    if (received != STATUS_OK) {
        return received;
    }
    if (is_for_other_life(endpoint, endpoint->frame, size)) {
        return STATUS_NOT_OURS;
    }
    const status_t delivered = message_deliver(endpoint, endpoint->frame, size);
    (void)delivered; // Frames beyond the window of their sender have been counted.
    return STATUS_OK;
}

/// Update the channel with a frame of its peer. False if the frame must be dropped.
static bool is_current(message_endpoint_t* const endpoint, message_channel_t* const channel,
                       const message_frame_t* const frame)
{
    if (!is_of_this_life(endpoint, channel, frame)) {
        return false;
    }
    const bool is_for_us = is_own_life(endpoint, frame->to_life);
    if (!is_for_us && (frame->kind == MESSAGE_SYNC)) {
        // The numbers in the frame belong to another life; the answer tells the peer this life.
        endpoint->counters.stale++;
        answer(endpoint, channel, frame);
        return false;
    }
    if (!is_for_us) {
        drop_stray(endpoint, channel);
        return false;
    }
    return true;
}

/// Return the credit of lost blocks once the caller has taken all blocks before them.
static void catch_up(message_channel_t* const channel)
{
    uint32_t stamp = 0U;
    if (!message_inbox_oldest(&channel->inbox, &stamp)) {
        channel->position.taken = channel->position.expected;
    }
}

/// Adopt the peer's numbers from a SYNC or the answer to one: no earlier frame of the peer is on its way.
static void resync(message_endpoint_t* const endpoint, message_channel_t* const channel,
                   const message_frame_t* const frame)
{
    const uint32_t ahead     = frame->sequence - channel->position.expected;
    const uint32_t under_way = channel->position.sent - frame->taken;
    endpoint->counters.lost += (ahead <= LOST_AT_ONCE_MAX) ? ahead : 0U;
    channel->position.expected = frame->sequence;
    catch_up(channel);
    if (ahead > LOST_AT_ONCE_MAX) {
        channel->position.acknowledged = channel->position.taken;
    }
    if ((under_way <= MESSAGE_WINDOW) && (under_way <= channel->position.sent)) {
        channel->position.credited  = frame->taken;
        channel->position.under_way = 0U;
        for (uint32_t i = frame->taken; i != channel->position.sent; i++) {
            channel->position.under_way += channel->position.sizes[i % MESSAGE_WINDOW];
        }
    }
    channel->is_syncing = channel->is_syncing && (frame->kind != MESSAGE_SYNC_ACK);
    clear_mismatch(channel);
    answer(endpoint, channel, frame);
}

/// True if a data frame is the next or a later one of its sequence. Credit carries the number of the next
/// data frame: it reveals a loss even if the whole window was lost and no data frame can follow.
static bool is_in_sequence(message_endpoint_t* const endpoint, message_channel_t* const channel,
                           const message_frame_t* const frame)
{
    const uint32_t ahead = frame->sequence - channel->position.expected;
    const uint32_t limit = (frame->kind == MESSAGE_DATA) ? (MESSAGE_WINDOW - 1U) : MESSAGE_WINDOW;
    const bool is_claim_good =
        (frame->taken - channel->position.credited) <= (channel->position.sent - channel->position.credited);
    if (is_claim_good) {
        credit_up_to(channel, frame->taken);
    }
    if (ahead > limit) { // A sender may neither exceed its credit nor repeat a number.
        drop_stray(endpoint, channel);
        return false;
    }
    if (is_claim_good) {
        clear_mismatch(channel);
    } else { // The credit is impossible, but the block is valid.
        count_mismatch(endpoint, channel);
    }
    endpoint->counters.lost += ahead;
    channel->position.expected = frame->sequence + ((frame->kind == MESSAGE_DATA) ? 1U : 0U);
    return frame->kind == MESSAGE_DATA;
}

static void return_credit(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    FSW_ASSERT(channel != NULL);
    if (((channel->position.taken - channel->position.acknowledged) >= (MESSAGE_WINDOW / 2U)) ||
        (channel->position.unacknowledged >= message_window_interval(endpoint->window))) {
        // If this frame is not sent, the next receive sends it again.
        (void)send_frame(endpoint, channel, MESSAGE_CREDIT, NULL, 0U);
    }
}

/// Update the channel from a frame. True if the frame carries a block for the caller.
static bool is_block(message_endpoint_t* const endpoint, message_channel_t* const channel,
                     const message_frame_t* const frame)
{
    if (!is_current(endpoint, channel, frame)) {
        return false;
    }
    if (frame->kind >= MESSAGE_SYNC) {
        resync(endpoint, channel, frame);
        return false;
    }
    return is_in_sequence(endpoint, channel, frame);
}

static void process_all_of(message_endpoint_t* const endpoint, message_channel_t* const channel)
{
    uint8_t header[MESSAGE_HEADER_OCTETS];
    uint8_t kind = MESSAGE_DATA;
    size_t size  = 0U;
    bool waits   = false;
    while (message_inbox_has_arrivals(&channel->inbox) &&
           message_inbox_next(&channel->inbox, header, &kind, &size)) {
        const message_frame_t frame = message_frame_read(header, kind, size);
        if (is_block(endpoint, channel, &frame)) {
            waits = true;
        } else if (kind == MESSAGE_DATA) {
            message_inbox_drop(&channel->inbox);
        } else {
            // The frame had no block; the channel has been updated.
        }
    }
    if (!waits) {
        catch_up(channel);
    }
    // A frame that brings no credit does not prove that no frame was lost: refusals continue to count.
    if (message_window_credit(channel, false) > 0U) {
        channel->refusals = 0U;
    }
}

static void process_arrivals(message_endpoint_t* const endpoint)
{
    for (size_t i = 0U; endpoint->has_arrivals && (i < endpoint->channel_count); i++) {
        if (message_inbox_has_arrivals(&endpoint->slots[i].channel.inbox)) {
            process_all_of(endpoint, &endpoint->slots[i].channel);
        }
    }
    endpoint->has_arrivals = false;
}

static void return_all_credit(message_endpoint_t* const endpoint)
{
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        return_credit(endpoint, &endpoint->slots[i].channel);
    }
}

void message_take_control(message_endpoint_t* const endpoint)
{
    FSW_ASSERT(endpoint != NULL);
    process_arrivals(endpoint);
    return_all_credit(endpoint);
}

/// Returns the channel whose oldest block arrived first; null if there is none.
static message_channel_t* next_channel(message_endpoint_t* const endpoint,
                                       const message_filter_t* const filter)
{
    message_channel_t* found = NULL;
    uint32_t first           = 0U;
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        message_channel_t* const channel = &endpoint->slots[i].channel;
        uint32_t stamp                   = 0U;
        if (message_inbox_oldest(&channel->inbox, &stamp) &&
            ((found == NULL) || ((first - stamp) < (UINT32_MAX / 2U))) &&
            ((filter == NULL) || filter->admits(filter->context, channel->position.peer))) {
            found = channel;
            first = stamp;
        }
    }
    return found;
}

status_t message_next(message_endpoint_t* const endpoint, const message_filter_t* const filter,
                      uint16_t* const out_from, const uint8_t** const out_head, size_t* const out_size)
{
    FSW_ASSERT((endpoint != NULL) && (out_from != NULL) && (out_head != NULL) && (out_size != NULL));
    process_arrivals(endpoint);
    const message_channel_t* const channel = next_channel(endpoint, filter);
    if (channel == NULL) {
        return_all_credit(endpoint);
        return STATUS_EMPTY;
    }
    (void)message_ring_look(&channel->inbox.blocks, 0U, endpoint->frame,
                            MESSAGE_HEADER_OCTETS + MESSAGE_HEAD_OCTETS, out_size);
    *out_from = channel->position.peer;
    *out_head = &endpoint->frame[MESSAGE_HEADER_OCTETS];
    *out_size -= MESSAGE_HEADER_OCTETS;
    return STATUS_OK;
}

status_t message_receive_if(message_endpoint_t* const endpoint, const message_filter_t* const filter,
                            uint16_t* const out_from, uint8_t* const octets, const size_t capacity,
                            size_t* const out_size)
{
    FSW_ASSERT((endpoint != NULL) && (out_from != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    process_arrivals(endpoint);
    message_channel_t* const channel = next_channel(endpoint, filter);
    if (channel == NULL) {
        return_all_credit(endpoint);
        return STATUS_EMPTY;
    }
    uint8_t header[MESSAGE_HEADER_OCTETS];
    size_t size           = 0U;
    const status_t status = message_inbox_take(&channel->inbox, header, octets, capacity, &size);
    endpoint->is_past     = (message_frame_life(header) != channel->position.peer_life);
    if (!endpoint->is_past) { // A block of an earlier life gives no credit to this one.
        channel->position.taken = message_frame_sequence(header) + 1U;
        channel->position.unacknowledged += (uint32_t)size;
    }
    catch_up(channel);
    endpoint->counters.received++;
    *out_from = channel->position.peer;
    *out_size = (status == STATUS_OK) ? (size - MESSAGE_HEADER_OCTETS) : 0U;
    return_credit(endpoint, channel);
    return status;
}

status_t message_receive(message_endpoint_t* const endpoint, uint16_t* const out_from, uint8_t* const octets,
                         const size_t capacity, size_t* const out_size)
{
    return message_receive_if(endpoint, NULL, out_from, octets, capacity, out_size);
}
