// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/journal/journal_record.h"

#include "base/crc.h"
#include "base/octets.h"

#define MAGIC 0x484A524EU // "HJRN"
#define MARK 0x484A4D4BU  // "HJMK"
#define VERSION 1U
#define CRC_SIZE 4U

enum { // Offsets in a record.
    TABLE    = 1,
    SIZE     = 2,
    SEQUENCE = 4,
    KEY      = 8,
    CHAIN    = 12
};

/// Encode a head; returns its checksum.
static uint32_t make_head(const uint32_t generation, uint8_t* const head)
{
    octets_put_u32(head, MAGIC);
    octets_put_u32(&head[4], VERSION << 16U);
    octets_put_u32(&head[8], generation);
    const uint32_t crc = crc32_iso(head, JOURNAL_HEAD_SIZE - CRC_SIZE);
    octets_put_u32(&head[JOURNAL_HEAD_SIZE - CRC_SIZE], crc);
    return crc;
}

journal_position_t journal_first_position(const uint32_t generation)
{
    uint8_t head[JOURNAL_HEAD_SIZE];
    return (journal_position_t){
        .offset = JOURNAL_HEAD_SIZE, .chain = make_head(generation, head), .sequence = 1U};
}

status_t journal_write_head(const medium_t* const medium, const uint32_t generation)
{
    uint8_t head[JOURNAL_HEAD_SIZE];
    (void)make_head(generation, head);
    return medium->write(medium->context, 0U, head, sizeof head);
}

/// Read from a medium; at its end the status is STATUS_EMPTY.
static status_t read_up_to_end(const medium_t* const medium, const uint32_t offset, uint8_t* const octets,
                               const size_t size)
{
    const status_t status = medium->read(medium->context, offset, octets, size);
    return (status == STATUS_TRUNCATED) ? STATUS_EMPTY : status;
}

status_t journal_read_head(const medium_t* const medium, uint32_t* const out_generation)
{
    uint8_t head[JOURNAL_HEAD_SIZE];
    uint8_t expected[JOURNAL_HEAD_SIZE];
    const status_t status = read_up_to_end(medium, 0U, head, sizeof head);
    if (status != STATUS_OK) {
        return status;
    }
    *out_generation    = octets_u32_at(&head[8]);
    const uint32_t crc = make_head(*out_generation, expected);
    const bool is_head = (octets_u32_at(head) == MAGIC) &&
                         (octets_u32_at(&head[4]) == octets_u32_at(&expected[4])) &&
                         (octets_u32_at(&head[JOURNAL_HEAD_SIZE - CRC_SIZE]) == crc);
    return is_head ? STATUS_OK : STATUS_EMPTY;
}

status_t journal_write_mark(const medium_t* const medium, const journal_mark_t* const mark)
{
    uint8_t octets[JOURNAL_HEAD_SIZE];
    octets_put_u32(octets, MARK);
    octets_put_u32(&octets[4], mark->generation);
    octets_put_u32(&octets[8], mark->offset);
    octets_put_u32(&octets[12], crc32_iso(octets, JOURNAL_HEAD_SIZE - CRC_SIZE));
    return medium->write(medium->context, 0U, octets, sizeof octets);
}

status_t journal_read_mark(const medium_t* const medium, journal_mark_t* const out_mark)
{
    uint8_t octets[JOURNAL_HEAD_SIZE];
    const status_t status = read_up_to_end(medium, 0U, octets, sizeof octets);
    if (status != STATUS_OK) {
        return status;
    }
    *out_mark =
        (journal_mark_t){.generation = octets_u32_at(&octets[4]), .offset = octets_u32_at(&octets[8])};
    const uint32_t crc = crc32_iso(octets, JOURNAL_HEAD_SIZE - CRC_SIZE);
    return ((octets_u32_at(octets) == MARK) && (octets_u32_at(&octets[12]) == crc)) ? STATUS_OK
                                                                                    : STATUS_EMPTY;
}

static void advance(journal_position_t* const position, const size_t size, const uint32_t crc)
{
    position->offset += (uint32_t)JOURNAL_RECORD_SIZE(size);
    position->chain = crc;
    position->sequence++;
}

status_t journal_write_record(const medium_t* const medium, journal_position_t* const position,
                              const journal_record_t* const record, uint8_t* const buffer)
{
    const size_t end = JOURNAL_OCTETS_AT + (size_t)record->size;
    buffer[0]        = record->kind;
    buffer[TABLE]    = record->table;
    octets_put_u16(&buffer[SIZE], record->size);
    octets_put_u32(&buffer[SEQUENCE], position->sequence);
    octets_put_u32(&buffer[KEY], record->key);
    octets_put_u32(&buffer[CHAIN], position->chain);
    const uint32_t crc = crc32_iso(buffer, end);
    octets_put_u32(&buffer[end], crc);
    const status_t status = medium->write(medium->context, position->offset, buffer, end + CRC_SIZE);
    if (status == STATUS_OK) {
        advance(position, record->size, crc);
    }
    return status;
}

static journal_record_t record_in(const uint8_t* const buffer)
{
    return (journal_record_t){.kind  = buffer[0],
                              .table = buffer[TABLE],
                              .size  = octets_u16_at(&buffer[SIZE]),
                              .key   = octets_u32_at(&buffer[KEY])};
}

/// True if the fields are possible in the header of a record.
static bool is_header(const journal_record_t* const record)
{
    const bool is_kind = (record->kind == JOURNAL_PUT) || (record->kind == JOURNAL_ERASE) ||
                         (record->kind == JOURNAL_COMMIT) || (record->kind == JOURNAL_MARK);
    return is_kind && (record->size <= JOURNAL_RECORD_MAX);
}

/// True if the header in the buffer has the sequence number and the chain of the next record.
static bool is_next(const journal_position_t* const position, const journal_record_t* const record,
                    const uint8_t* const buffer)
{
    return is_header(record) && (octets_u32_at(&buffer[SEQUENCE]) == position->sequence) &&
           (octets_u32_at(&buffer[CHAIN]) == position->chain);
}

status_t journal_read_record(const medium_t* const medium, journal_position_t* const position,
                             journal_record_t* const out_record, uint8_t* const buffer)
{
    status_t status = read_up_to_end(medium, position->offset, buffer, JOURNAL_OCTETS_AT);
    if (status != STATUS_OK) {
        return status;
    }
    *out_record = record_in(buffer);
    if (!is_next(position, out_record, buffer)) {
        return STATUS_EMPTY;
    }
    const size_t end = JOURNAL_OCTETS_AT + (size_t)out_record->size;
    status = read_up_to_end(medium, position->offset + JOURNAL_OCTETS_AT, &buffer[JOURNAL_OCTETS_AT],
                            (size_t)out_record->size + CRC_SIZE);
    if (status != STATUS_OK) {
        return status;
    }
    const uint32_t crc = crc32_iso(buffer, end);
    if (octets_u32_at(&buffer[end]) != crc) {
        return STATUS_EMPTY;
    }
    advance(position, out_record->size, crc);
    return STATUS_OK;
}

/// Returns the offset in the buffer where a record may begin that lies at or after `position` and ends at
/// `end` at the latest. If there is none, returns the first offset that leaves no room for an empty record:
/// the search continues there.
static size_t candidate_in(const uint8_t* const buffer, const size_t size,
                           const journal_position_t* const position, const uint64_t end)
{
    const uint64_t left = end - position->offset;
    // Between `position` and the end, at most this number of records has room.
    const uint64_t sequence = position->sequence + (left / JOURNAL_RECORD_SIZE(0U));
    size_t at               = 0U;
    bool is_candidate       = false;
    while (!is_candidate && ((at + JOURNAL_RECORD_SIZE(0U)) <= size)) {
        const journal_record_t record = record_in(&buffer[at]);
        const uint32_t found          = octets_u32_at(&buffer[at + SEQUENCE]);
        is_candidate = is_header(&record) && (found >= position->sequence) && (found <= sequence) &&
                       ((at + JOURNAL_RECORD_SIZE((size_t)record.size)) <= left);
        at += is_candidate ? 0U : 1U;
    }
    return at;
}

status_t journal_find_record(const medium_t* const medium, const uint64_t end,
                             journal_position_t* const position, journal_record_t* const out_record,
                             uint8_t* const buffer)
{
    while ((position->offset + JOURNAL_RECORD_SIZE((uint64_t)0U)) <= end) {
        const uint64_t left = end - position->offset;
        const size_t size   = (left < JOURNAL_RECORD_SIZE((uint64_t)JOURNAL_RECORD_MAX))
                                  ? (size_t)left
                                  : JOURNAL_RECORD_SIZE(JOURNAL_RECORD_MAX);
        if (medium->read(medium->context, position->offset, buffer, size) != STATUS_OK) {
            return STATUS_IO;
        }
        const size_t at = candidate_in(buffer, size, position, end);
        *out_record     = record_in(buffer);
        if (at > 0U) {
            // The next round reads from the candidate, so that the whole record is in the buffer.
            position->offset += (uint32_t)at;
        } else {
            const size_t covered = JOURNAL_OCTETS_AT + (size_t)out_record->size;
            const uint32_t crc   = crc32_iso(buffer, covered);
            if (octets_u32_at(&buffer[covered]) == crc) {
                position->sequence = octets_u32_at(&buffer[SEQUENCE]);
                advance(position, out_record->size, crc);
                return STATUS_OK;
            }
            position->offset++;
        }
    }
    return STATUS_EMPTY;
}
