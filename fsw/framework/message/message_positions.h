// SPDX-License-Identifier: Apache-2.0
/// Positions of the channels of a message endpoint, as plain numbers. With them, the endpoint of a new
/// process continues the channels of a process that died, in the same life; the peers do not notice the
/// change. For this purpose the caller can store the frames that are sent and received.
///
/// Ownership  The caller provides positions.
/// Context    As the endpoint.
/// Time       O(MESSAGE_WINDOW).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_POSITIONS_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_POSITIONS_H

#include "fsw/framework/message/message.h"

#include <stdbool.h>

/// Get the position of the channel with this index. False if there is no such channel.
bool message_position(const message_endpoint_t* endpoint, size_t index, message_position_t* out_position);
/// True if the fields of a position do not contradict each other: the position is consistent.
bool message_position_is_sound(const message_position_t* position);
/// Continue the channel at `position`, which must be consistent. If message_set_life has set another life of
/// the peer, the channel restarts in that life; waiting blocks of the earlier life can still be taken. No
/// effect if the endpoint does not have that peer.
void message_resume(message_endpoint_t* endpoint, const message_position_t* position);
/// Returns the blocks that wait in the inbox of the channel with this index; null if there is no such
/// channel. All of them must have been checked, which is the case directly after a message_receive. To
/// restore them, refill the ring before message_resume.
message_ring_t* message_waiting(message_endpoint_t* endpoint, size_t index);
/// Get the life of the endpoint that its peers know, and the number that the next arriving frame gets.
void message_clock(const message_endpoint_t* endpoint, uint32_t* out_life, uint32_t* out_stamp);
/// Continue with the values of message_clock, before the first message_resume.
void message_resume_clock(message_endpoint_t* endpoint, uint32_t life, uint32_t stamp);

/// Pass frames to `outlet` instead of the carrier. The caller passes them to message_forward later, in
/// their order; until then they count as sent.
void message_divert(message_endpoint_t* endpoint, message_carrier_t outlet);
/// Pass a diverted frame to the carrier. STATUS_OK; STATUS_FULL: try again; any other status: the carrier
/// cannot reach the peer, which will detect the loss by the sequence numbers.
MUST_USE status_t message_forward(message_endpoint_t* endpoint, uint16_t to, const uint8_t* frame,
                                  size_t size);
/// Call `arrival` for each frame that arrives from now on.
void message_watch(message_endpoint_t* endpoint, message_arrival_t arrival);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_POSITIONS_H
