// SPDX-License-Identifier: Apache-2.0
/// What has arrived from one peer: frames with data in order of arrival, and of the frames without data the
/// newest of each kind, since each says all that an earlier one of its kind said. So whoever takes no data
/// any more still takes credit, and frames without data never need room.
///
/// Each frame is judged once, in order of arrival among those of its peer (message_inbox_next); data that is
/// not dropped then waits to be taken.
///
/// Ownership  The endpoint places it; `storage` outlives it. Context: one task. Time O(size).
#ifndef FSW_FRAMEWORK_MESSAGE_MESSAGE_INBOX_H
#define FSW_FRAMEWORK_MESSAGE_MESSAGE_INBOX_H

#include "fsw/framework/base/status.h"
#include "fsw/framework/message/octet_ring.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MESSAGE_INBOX_HEADER 24U ///< Octets of a frame's header.
#define MESSAGE_INBOX_NOTES 3U   ///< Kinds of frames without data: 1, 2, 3.

typedef struct { // Private. A frame without data.
    uint8_t header[MESSAGE_INBOX_HEADER];
    uint32_t after; // So many frames with data came before it.
    uint32_t stamp; // When it came.
    bool is_set;
} message_note_t;

typedef struct {         // Private, except `blocks`, to be read.
    octet_ring_t blocks; ///< Frames with data: judged ones first.
    uint32_t arrived;    // Frames with data that ever came.
    uint32_t judged;     // Of these, judged.
    size_t place;        // Where the next one to judge lies, from the first octet of the ring on.
    size_t last;         // Where the one that was judged last lies.
    uint32_t notes_set;  // How many of the notes are there.
    message_note_t notes[MESSAGE_INBOX_NOTES];
} message_inbox_t;

void message_inbox_init(message_inbox_t* inbox, uint8_t* storage, size_t octets);
/// Keep a frame of MESSAGE_INBOX_HEADER octets or more; kind 0 has data. `stamp` counts all frames of the
/// endpoint. STATUS_OK; STATUS_FULL: no room for its data.
MUST_USE status_t message_inbox_put(message_inbox_t* inbox, uint8_t kind, uint32_t stamp,
                                    const uint8_t* frame, size_t size);
/// The next frame to be judged: its header, without magic, version and kind, its kind and its size. False if
/// all are judged.
bool message_inbox_next(message_inbox_t* inbox, uint8_t header[MESSAGE_INBOX_HEADER], uint8_t* out_kind,
                        size_t* out_size);
/// The frame with data that was judged last is not for the caller.
void message_inbox_drop(message_inbox_t* inbox);
/// Where there is no room: forget the oldest block if it is of a life before `life`, judged or not. False if
/// it is not, or there is none.
bool message_inbox_forget(message_inbox_t* inbox, uint32_t life);
/// Stamp of the oldest block that was judged and not dropped. False if there is none.
bool message_inbox_oldest(message_inbox_t* inbox, uint32_t* out_stamp);
/// True if a frame waits to be judged.
static inline bool message_inbox_has_news(const message_inbox_t* inbox)
{
    return (inbox->judged != inbox->arrived) || (inbox->notes_set > 0U);
}
/// Take that block, which message_inbox_oldest has found. STATUS_OK, STATUS_TOO_LARGE (dropped, but the
/// header is there).
MUST_USE status_t message_inbox_take(message_inbox_t* inbox, uint8_t header[MESSAGE_INBOX_HEADER],
                                     uint8_t* octets, size_t capacity, size_t* out_size);

#endif // FSW_FRAMEWORK_MESSAGE_MESSAGE_INBOX_H
