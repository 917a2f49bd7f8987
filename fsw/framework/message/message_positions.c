// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message_positions.h"

#include "base/assertion.h"

bool message_position(const message_endpoint_t* const endpoint, const size_t index,
                      message_position_t* const out_position)
{
    FSW_ASSERT((endpoint != NULL) && (out_position != NULL));
    if (index >= endpoint->channel_count) {
        return false;
    }
    *out_position = endpoint->slots[index].channel.position;
    return true;
}

bool message_position_is_sound(const message_position_t* const position)
{
    FSW_ASSERT(position != NULL);
    const uint32_t frames = position->sent - position->credited;
    uint32_t octets       = 0U;
    for (uint32_t i = 0U; (i < frames) && (i < MESSAGE_WINDOW); i++) {
        octets += position->sizes[(position->credited + i) % MESSAGE_WINDOW];
    }
    return (frames <= MESSAGE_WINDOW) && (octets == position->under_way) &&
           ((position->expected - position->taken) <= MESSAGE_WINDOW) &&
           ((position->taken - position->acknowledged) <= MESSAGE_WINDOW) &&
           (position->unacknowledged <= MESSAGE_WINDOW_OCTETS);
}

/// Continue a channel at a position that was stored. The peer may have begun another life since then; if
/// message_set_life has set that life, the channel begins at 0.
static void resume(message_channel_t* const channel, const message_position_t* const position)
{
    if (!channel->is_life_set || (channel->position.peer_life == position->peer_life)) {
        channel->position = *position;
    }
    channel->inbox.arrived = channel->inbox.blocks.blocks; // All waiting frames have been checked.
    channel->inbox.checked = channel->inbox.arrived;
    channel->inbox.next    = channel->inbox.blocks.used;
}

void message_resume(message_endpoint_t* const endpoint, const message_position_t* const position)
{
    FSW_ASSERT((endpoint != NULL) && (position != NULL) && message_position_is_sound(position));
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        message_channel_t* const channel = &endpoint->slots[i].channel;
        if (channel->position.peer == position->peer) {
            resume(channel, position);
        }
    }
}

message_ring_t* message_waiting(message_endpoint_t* const endpoint, const size_t index)
{
    FSW_ASSERT(endpoint != NULL);
    return (index < endpoint->channel_count) ? &endpoint->slots[index].channel.inbox.blocks : NULL;
}

void message_clock(const message_endpoint_t* const endpoint, uint32_t* const out_life,
                   uint32_t* const out_stamp)
{
    FSW_ASSERT((endpoint != NULL) && (out_life != NULL) && (out_stamp != NULL));
    *out_life  = endpoint->life;
    *out_stamp = endpoint->stamp;
}

void message_resume_clock(message_endpoint_t* const endpoint, const uint32_t life, const uint32_t stamp)
{
    FSW_ASSERT((endpoint != NULL) && (life >= 1U));
    endpoint->life  = life;
    endpoint->stamp = stamp;
}

void message_divert(message_endpoint_t* const endpoint, const message_carrier_t outlet)
{
    FSW_ASSERT((endpoint != NULL) && (outlet.send != NULL));
    endpoint->outlet = outlet;
}

void message_watch(message_endpoint_t* const endpoint, const message_arrival_t arrival)
{
    FSW_ASSERT(endpoint != NULL);
    endpoint->arrival = arrival;
}

status_t message_forward(message_endpoint_t* const endpoint, const uint16_t to, const uint8_t* const frame,
                         const size_t size)
{
    FSW_ASSERT((endpoint != NULL) && (frame != NULL));
    const status_t status = endpoint->carrier.send(endpoint->carrier.context, to, frame, size);
    endpoint->counters.unreachable += ((status != STATUS_OK) && (status != STATUS_FULL)) ? 1U : 0U;
    return status;
}
