// SPDX-License-Identifier: Apache-2.0
/// Frames that have arrived from one peer: all frames with data in the order of arrival, and only the newest
/// frame of each kind without data, because its content replaces that of earlier frames of its kind.
/// Therefore an endpoint that takes no data can still receive credit, and there is always room for frames
/// without data.
///
/// Each frame is checked once, in the order in which the frames of its peer arrived (message_inbox_next).
/// Data that is not dropped then waits to be taken.
///
/// Ownership  The endpoint contains message_inbox_t; `storage` outlives it.
/// Context    One task.
/// Time       O(size).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_INBOX_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_INBOX_H

#include "base/status.h"
#include "fsw/framework/message/message_ring.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MESSAGE_INBOX_HEADER 24U ///< Octets of a frame's header.
#define MESSAGE_INBOX_NOTES 3U   ///< Kinds of frames without data: 1, 2, 3.

typedef struct { // Private. A frame without data.
    uint8_t header[MESSAGE_INBOX_HEADER];
    uint32_t after; // Number of frames with data that arrived before it.
    uint32_t stamp; // Stamp of its arrival.
    bool is_set;
} message_note_t;

typedef struct {           // Private, except `blocks` (read-only).
    message_ring_t blocks; ///< Frames with data, the checked ones first.
    uint32_t arrived;      // Number of frames with data that have arrived.
    uint32_t checked;      // Number of these frames that were checked.
    size_t next;           // Position of the next frame to check, from the first octet of the ring.
    size_t last;           // Position of the frame that was checked last.
    uint32_t notes_set;    // Number of notes that are set.
    message_note_t notes[MESSAGE_INBOX_NOTES];
} message_inbox_t;

/// Make the inbox empty. `octets`: size of the storage, as for message_ring_init.
void message_inbox_init(message_inbox_t* inbox, uint8_t* storage, size_t octets);
/// Store a frame of at least MESSAGE_INBOX_HEADER octets; kind 0 has data. `stamp` counts all frames of the
/// endpoint. STATUS_OK; STATUS_FULL: no room for its data.
MUST_USE status_t message_inbox_put(message_inbox_t* inbox, uint8_t kind, uint32_t stamp,
                                    const uint8_t* frame, size_t size);
/// Get the next frame to check: its header (without magic, version and kind), kind and size. False if all
/// frames have been checked.
bool message_inbox_next(message_inbox_t* inbox, uint8_t header[MESSAGE_INBOX_HEADER], uint8_t* out_kind,
                        size_t* out_size);
/// Drop the frame with data that was checked last; the caller does not get it.
void message_inbox_drop(message_inbox_t* inbox);
/// Make room: remove the oldest block, checked or not, if it belongs to a life before `life`. False if no
/// block was removed.
bool message_inbox_forget(message_inbox_t* inbox, uint32_t life);
/// Get the stamp of the oldest block that was checked and not dropped. False if there is none.
bool message_inbox_oldest(message_inbox_t* inbox, uint32_t* out_stamp);
/// True if a frame waits to be checked.
static inline bool message_inbox_has_arrivals(const message_inbox_t* inbox)
{
    return (inbox->checked != inbox->arrived) || (inbox->notes_set > 0U);
}
/// Take the block that message_inbox_oldest has found. STATUS_OK, STATUS_TOO_LARGE (dropped, but `header` is
/// filled).
MUST_USE status_t message_inbox_take(message_inbox_t* inbox, uint8_t header[MESSAGE_INBOX_HEADER],
                                     uint8_t* octets, size_t capacity, size_t* out_size);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_INBOX_H
