// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message_window.h"

#include "base/assertion.h"

// The smallest window is larger than the reserve and the largest block together, so that
// message_window_interval is never 0.
CAPACITY_CHECK(smallest_window_has_room_for_any_block,
               MESSAGE_SMALL_WINDOW_OCTETS >
                   (MESSAGE_RESERVE_OCTETS(MESSAGE_SMALL_WINDOW_OCTETS) + MESSAGE_FRAME_MAX));

message_channel_t* message_channel_of(const message_endpoint_t* const endpoint, const uint16_t peer)
{
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        if (endpoint->slots[i].channel.position.peer == peer) {
            return &endpoint->slots[i].channel;
        }
    }
    return NULL;
}

status_t message_set_window(message_endpoint_t* const endpoint, const uint16_t component,
                            const uint32_t octets)
{
    FSW_ASSERT(endpoint != NULL);
    const bool is_own                = (component == endpoint->self);
    message_channel_t* const channel = message_channel_of(endpoint, component);
    if (!is_own && (channel == NULL)) {
        return STATUS_NOT_FOUND;
    }
    const uint32_t wanted = (octets > 0U) ? octets : MESSAGE_WINDOW_OCTETS;
    if ((wanted < MESSAGE_SMALL_WINDOW_OCTETS) ||
        (wanted > (is_own ? MESSAGE_ROOM_OCTETS : MESSAGE_WINDOW_OCTETS))) {
        return STATUS_OUT_OF_RANGE;
    }
    uint32_t* const window = is_own ? &endpoint->window : &channel->window;
    *window                = wanted;
    return STATUS_OK;
}

uint32_t message_window_credit(const message_channel_t* const channel, const bool is_plain)
{
    const uint32_t blocks = is_plain ? MESSAGE_RESERVE : 0U;
    const uint32_t octets = is_plain ? MESSAGE_RESERVE_OCTETS(channel->window) : 0U;
    const uint32_t left   = MESSAGE_WINDOW - (channel->position.sent - channel->position.credited);
    return (((channel->position.under_way + MESSAGE_FRAME_MAX + octets) > channel->window) ||
            (left <= blocks))
               ? 0U
               : (left - blocks);
}

uint32_t message_window_interval(const uint32_t window)
{
    const uint32_t most = window - MESSAGE_RESERVE_OCTETS(window) - MESSAGE_FRAME_MAX;
    return ((window / 2U) < most) ? (window / 2U) : most;
}

static uint32_t credit_to(const message_endpoint_t* const endpoint, const uint16_t peer, const bool is_plain)
{
    FSW_ASSERT(endpoint != NULL);
    const message_channel_t* const channel = message_channel_of(endpoint, peer);
    return (channel != NULL) ? message_window_credit(channel, is_plain) : 0U;
}

uint32_t message_credit(const message_endpoint_t* const endpoint, const uint16_t peer)
{
    return credit_to(endpoint, peer, false);
}

uint32_t message_credit_plain(const message_endpoint_t* const endpoint, const uint16_t peer)
{
    return credit_to(endpoint, peer, true);
}
