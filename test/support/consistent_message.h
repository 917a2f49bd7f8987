// SPDX-License-Identifier: Apache-2.0
/// Checks whether a message endpoint is consistent, for tests and fuzz targets.
#ifndef TEST_SUPPORT_CONSISTENT_MESSAGE_H
#define TEST_SUPPORT_CONSISTENT_MESSAGE_H

#include "fsw/framework/message/message.h"
#include "test/support/consistent_message_ring.h"

/// True if each inbox is consistent and its checked frames come before the unchecked ones.
static inline bool message_is_consistent(const message_endpoint_t* endpoint)
{
    bool is_sound = true;
    for (size_t i = 0U; i < endpoint->channel_count; i++) {
        const message_channel_t* const channel = &endpoint->slots[i].channel;
        const message_inbox_t* const inbox     = &channel->inbox;
        is_sound                               = is_sound && octet_ring_is_consistent(&inbox->blocks) &&
                   (inbox->next <= inbox->blocks.used) &&
                   ((inbox->next == inbox->blocks.used) == (inbox->checked == inbox->arrived)) &&
                   ((channel->position.sent - channel->position.credited) <= MESSAGE_WINDOW);
    }
    return is_sound;
}

#endif // TEST_SUPPORT_CONSISTENT_MESSAGE_H
