// SPDX-License-Identifier: Apache-2.0
/// Windows of the channels of an endpoint: what may still be sent, and when credit is due. Internal to
/// message/.
///
/// Context    As the endpoint.
/// Time       O(channels).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_WINDOW_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_WINDOW_H

#include "fsw/framework/message/message.h"

#include <stdbool.h>
#include <stdint.h>

/// Returns the channel to a peer; null if there is none.
message_channel_t* message_channel_of(const message_endpoint_t* endpoint, uint16_t peer);
/// Returns the number of blocks that may be sent, without the reserve of the window if they are plain; 0 if
/// the largest block does not fit.
uint32_t message_window_credit(const message_channel_t* channel, bool is_plain);
/// Returns the number of taken octets after which credit is sent: half of a window, or less in a small one. A
/// sender that waits only for fewer octets than this can send the largest plain block.
uint32_t message_window_interval(uint32_t window);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_WINDOW_H
