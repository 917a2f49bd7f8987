// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/message_inbox.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <string.h>

#define AT_STAMP 0U // In the ring, the stamp replaces magic, version and kind, which have been checked.
// In the ring, this octet replaces the low octet of the addressee; 1 if the frame was dropped.
#define AT_DROPPED 6U
#define AT_LIFE 8U // Offset of the sender's life.
#define KIND_DATA 0U

void message_inbox_init(message_inbox_t* const inbox, uint8_t* const storage, const size_t octets)
{
    FSW_ASSERT(inbox != NULL);
    (void)memset(inbox, 0, sizeof *inbox);
    message_ring_init(&inbox->blocks, storage, octets);
}

status_t message_inbox_put(message_inbox_t* const inbox, const uint8_t kind, const uint32_t stamp,
                           const uint8_t* const frame, const size_t size)
{
    FSW_ASSERT((inbox != NULL) && (frame != NULL) && (size >= MESSAGE_INBOX_HEADER) &&
               (kind <= MESSAGE_INBOX_NOTES));
    if (kind != KIND_DATA) {
        message_note_t* const note = &inbox->notes[kind - 1U];
        (void)memcpy(note->header, frame, sizeof note->header);
        note->after = inbox->arrived;
        note->stamp = stamp;
        inbox->notes_set += note->is_set ? 0U : 1U;
        note->is_set = true;
        return STATUS_OK;
    }
    uint8_t header[MESSAGE_INBOX_HEADER];
    (void)memcpy(header, frame, sizeof header);
    octets_put_u32(&header[AT_STAMP], stamp);
    header[AT_DROPPED]    = 0U;
    const status_t status = message_ring_put_parts(&inbox->blocks, header, sizeof header,
                                                   &frame[sizeof header], size - sizeof header);
    inbox->arrived += (status == STATUS_OK) ? 1U : 0U;
    return status;
}

/// Returns the oldest note that arrived before the next frame with data; null if there is none. Notes are
/// processed in the order of their arrival, because a later one may have newer content.
static message_note_t* next_note(message_inbox_t* const inbox)
{
    message_note_t* found = NULL;
    if (inbox->notes_set == 0U) {
        return NULL;
    }
    for (uint8_t i = 0U; i < MESSAGE_INBOX_NOTES; i++) {
        message_note_t* const note = &inbox->notes[i];
        const bool is_due          = note->is_set && ((inbox->checked - note->after) < (UINT32_MAX / 2U));
        if (is_due && ((found == NULL) || ((found->stamp - note->stamp) < (UINT32_MAX / 2U)))) {
            found = note;
        }
    }
    return found;
}

bool message_inbox_next(message_inbox_t* const inbox, uint8_t header[MESSAGE_INBOX_HEADER],
                        uint8_t* const out_kind, size_t* const out_size)
{
    FSW_ASSERT((inbox != NULL) && (header != NULL) && (out_kind != NULL) && (out_size != NULL));
    message_note_t* const note = next_note(inbox);
    if (note != NULL) {
        (void)memcpy(header, note->header, sizeof note->header);
        note->is_set = false;
        inbox->notes_set--;
        *out_kind = (uint8_t)((note - inbox->notes) + 1);
        *out_size = sizeof note->header;
        return true;
    }
    if (inbox->checked == inbox->arrived) {
        return false;
    }
    inbox->last = inbox->next;
    inbox->next = message_ring_look(&inbox->blocks, inbox->next, header, MESSAGE_INBOX_HEADER, out_size);
    inbox->checked++;
    *out_kind = KIND_DATA;
    return true;
}

void message_inbox_drop(message_inbox_t* const inbox)
{
    FSW_ASSERT(inbox != NULL);
    uint8_t mark[AT_DROPPED + 1U];
    size_t size = 0U;
    (void)message_ring_look(&inbox->blocks, inbox->last, mark, sizeof mark, &size);
    mark[AT_DROPPED] = 1U;
    message_ring_overwrite(&inbox->blocks, inbox->last, mark, sizeof mark);
}

/// Remove the first block of the ring.
static void remove_first(message_inbox_t* const inbox)
{
    uint8_t none          = 0U;
    size_t size           = 0U;
    const size_t before   = inbox->blocks.used;
    const status_t status = message_ring_take(&inbox->blocks, &none, 0U, &size);
    (void)status; // With capacity 0 the block is removed without a copy, and the status has no meaning.
    const size_t gone = before - inbox->blocks.used;
    if (inbox->next >= gone) {
        inbox->next -= gone;
    } else { // The block was removed before it was checked.
        inbox->checked++;
    }
}

bool message_inbox_forget(message_inbox_t* const inbox, const uint32_t life)
{
    FSW_ASSERT(inbox != NULL);
    uint8_t head[AT_LIFE + 4U];
    size_t size = 0U;
    if (inbox->blocks.blocks == 0U) {
        return false;
    }
    (void)message_ring_look(&inbox->blocks, 0U, head, sizeof head, &size);
    if (octets_u32_at(&head[AT_LIFE]) >= life) {
        return false;
    }
    remove_first(inbox);
    return true;
}

bool message_inbox_oldest(message_inbox_t* const inbox, uint32_t* const out_stamp)
{
    FSW_ASSERT((inbox != NULL) && (out_stamp != NULL));
    while (inbox->next > 0U) {
        uint8_t mark[AT_DROPPED + 2U];
        size_t size = 0U;
        (void)message_ring_look(&inbox->blocks, 0U, mark, sizeof mark, &size);
        if (mark[AT_DROPPED] == 0U) {
            *out_stamp = octets_u32_at(&mark[AT_STAMP]);
            return true;
        }
        remove_first(inbox);
    }
    return false;
}

status_t message_inbox_take(message_inbox_t* const inbox, uint8_t header[MESSAGE_INBOX_HEADER],
                            uint8_t* const octets, const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((inbox != NULL) && (inbox->next > 0U)); // message_inbox_oldest has found a checked block.
    const size_t before = inbox->blocks.used;
    const status_t status =
        message_ring_take_parts(&inbox->blocks, header, MESSAGE_INBOX_HEADER, octets, capacity, out_size);
    inbox->next -= before - inbox->blocks.used;
    return status;
}
