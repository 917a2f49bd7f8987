// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/undo.h"

#include "base/assertion.h"
#include "base/octets.h"

#define PIECE 1024U     // Largest number of octets that are saved as one block of the annex.
#define HEAD_OCTETS 17U // Number of the medium u8 | its size u64 | offset u64; the overwritten octets follow.

static void save(const undo_medium_t* const medium, const uint64_t size, const uint64_t offset,
                 const uint8_t* const octets, const size_t count)
{
    uint8_t head[HEAD_OCTETS];
    octet_writer_t writer = octet_writer(head, sizeof head);
    octet_write_u8(&writer, medium->number);
    octet_write_u64(&writer, size);
    octet_write_u64(&writer, offset);
    (void)supervisor_checkpoint_add(medium->checkpoint, &medium->checkpoint->undo, head, sizeof head, octets,
                                    count);
}

/// Save the size of the medium, and the existing octets among the `count` octets from `offset` on. Octets
/// that cannot be read are not saved; the write that follows is performed nevertheless.
static void save_all(const undo_medium_t* const medium, const uint64_t offset, const uint64_t count)
{
    const medium_t* const inner = &medium->inner;
    uint64_t size               = 0U;
    uint8_t octets[PIECE];
    if (inner->size(inner->context, &size) != STATUS_OK) {
        return;
    }
    save(medium, size, offset, NULL, 0U);
    uint64_t left = (offset < size) ? (size - offset) : 0U;
    left          = (left < count) ? left : count;
    for (uint64_t at = offset; left > 0U; at += PIECE) {
        const size_t piece = (left < PIECE) ? (size_t)left : PIECE;
        if (inner->read(inner->context, at, octets, piece) == STATUS_OK) {
            save(medium, size, at, octets, piece);
        }
        left -= piece;
    }
}

static status_t read_medium(void* const context, const uint64_t offset, uint8_t* const octets,
                            const size_t size)
{
    const undo_medium_t* const medium = (const undo_medium_t*)context;
    return medium->inner.read(medium->inner.context, offset, octets, size);
}

static status_t write_medium(void* const context, const uint64_t offset, const uint8_t* const octets,
                             const size_t size)
{
    const undo_medium_t* const medium = (const undo_medium_t*)context;
    save_all(medium, offset, size);
    return medium->inner.write(medium->inner.context, offset, octets, size);
}

static status_t sync_medium(void* const context)
{
    const undo_medium_t* const medium = (const undo_medium_t*)context;
    return medium->inner.sync(medium->inner.context);
}

static status_t size_of_medium(void* const context, uint64_t* const out_size)
{
    const undo_medium_t* const medium = (const undo_medium_t*)context;
    return medium->inner.size(medium->inner.context, out_size);
}

static status_t resize_medium(void* const context, const uint64_t size)
{
    const undo_medium_t* const medium = (const undo_medium_t*)context;
    uint64_t present                  = 0U;
    const bool is_known               = (medium->inner.size(medium->inner.context, &present) == STATUS_OK);
    // Save no octets of a long truncation: its owner empties the medium and no longer needs the content.
    const bool is_long = is_known && (present > size) && ((present - size) > UNDO_CUT_MAX);
    save_all(medium, size, is_long ? 0U : UNDO_CUT_MAX);
    return medium->inner.resize(medium->inner.context, size);
}

/// Undo one write. If that fails, the owner of the medium detects the damage when it reads.
static void undo(const undo_medium_t* const medium, const uint8_t* const block, const size_t block_size)
{
    const medium_t* const inner = &medium->inner;
    octet_reader_t reader       = octet_reader(block, block_size);
    const uint8_t number        = octet_read_u8(&reader);
    const uint64_t size         = octet_read_u64(&reader);
    const uint64_t offset       = octet_read_u64(&reader);
    const size_t count          = octet_reader_left(&reader);
    uint64_t present            = 0U;
    if (reader.failed || (number != medium->number)) {
        return;
    }
    // Restore the octets first, and then the size, because the medium may have grown.
    if (count > 0U) {
        (void)inner->write(inner->context, offset, octet_read_octets(&reader, count), count);
    }
    if ((inner->size(inner->context, &present) == STATUS_OK) && (present > size)) {
        (void)inner->resize(inner->context, size);
    }
}

medium_t supervisor_undo_open(undo_medium_t* const medium, checkpoint_t* const checkpoint,
                              const uint8_t number, const medium_t* const inner)
{
    FSW_ASSERT((medium != NULL) && (inner != NULL));
    if (checkpoint == NULL) {
        return *inner;
    }
    *medium     = (undo_medium_t){.inner = *inner, .checkpoint = checkpoint, .number = number};
    size_t size = 0U;
    size_t from = 0U;
    // Undo the newest write first: where writes overlapped, the octets before the oldest write must remain.
    const uint8_t* block = supervisor_checkpoint_before(checkpoint, &checkpoint->undo, &from, &size);
    for (; block != NULL; block = supervisor_checkpoint_before(checkpoint, &checkpoint->undo, &from, &size)) {
        undo(medium, block, size);
    }
    return (medium_t){.context = medium,
                      .read    = read_medium,
                      .write   = write_medium,
                      .sync    = sync_medium,
                      .size    = size_of_medium,
                      .resize  = resize_medium};
}
