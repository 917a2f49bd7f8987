// SPDX-License-Identifier: Apache-2.0
/// Positions of the channels of a message endpoint, as plain numbers: so that an endpoint goes on where the
/// one of a process that died has ended, in the same life of its channels, and no peer notices.
///
/// Ownership  The caller places positions. Context: as the endpoint. Time: O(MESSAGE_WINDOW).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_POSITIONS_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_POSITIONS_H

#include "fsw/framework/message/message.h"

#include <stdbool.h>

typedef struct { // Of one channel; see message_channel_t.
    uint32_t peer_life;
    uint32_t sent;
    uint32_t credited;
    uint32_t expected;
    uint32_t taken;
    uint32_t told;
    uint32_t under_way;
    uint32_t untold;
    uint16_t peer;
    uint16_t reserved;
    uint16_t sizes[MESSAGE_WINDOW];
} message_position_t;

/// Position of the channel of that index. False: there is no such channel.
bool message_position(const message_endpoint_t* endpoint, size_t index, message_position_t* out_position);
/// True if a channel can be there.
bool message_position_is_sound(const message_position_t* position);
/// Go on there. `position` is sound; no effect if its peer is none of the endpoint's.
void message_resume(message_endpoint_t* endpoint, const message_position_t* position);
/// The peers may have been sent up to `blocks` more than is known: numbers that may be used already are left
/// out.
void message_leave_out(message_endpoint_t* endpoint, uint32_t blocks);
/// What waits in the inbox of the channel of that index: all of it was judged, which is so when
/// message_receive has just said STATUS_EMPTY or left some to wait. To be refilled before message_resume.
/// Null: no such channel.
octet_ring_t* message_waiting(message_endpoint_t* endpoint, size_t index);
/// Life of the channels of the endpoint, by which its peers know it, and the stamp of the next frame.
void message_clock(const message_endpoint_t* endpoint, uint32_t* out_life, uint32_t* out_stamp);
void message_resume_clock(message_endpoint_t* endpoint, uint32_t life, uint32_t stamp);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_POSITIONS_H
