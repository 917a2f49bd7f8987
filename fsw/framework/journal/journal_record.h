// SPDX-License-Identifier: Apache-2.0
/// Records of a journal on a medium. Private to the journal. Numbers are big-endian. Each `buffer` has
/// JOURNAL_RECORD_SIZE(JOURNAL_RECORD_MAX) octets. Outputs are valid only with STATUS_OK.
///
///     head     "HJRN", version u16 = 1, spare u16, generation u32, CRC-32
///     record   kind u8, table u8, size u16, sequence u32, key u32, chain u32, octets, CRC-32
///     mark     "HJMK", generation u32, offset u32, CRC-32
///
/// The mark is on the medium that is not written to, at the position of its head. While a compaction is in
/// progress, the head of the next generation is there, and records of the kind JOURNAL_MARK take the place of
/// the mark. Their key is the offset; the generation is the one before that of the head.
#ifndef FSW_FRAMEWORK_JOURNAL_JOURNAL_RECORD_H
#define FSW_FRAMEWORK_JOURNAL_JOURNAL_RECORD_H

#include "fsw/framework/journal/journal.h"

enum {
    JOURNAL_PUT    = 0x50,
    JOURNAL_ERASE  = 0x45,
    JOURNAL_COMMIT = 0x43,
    JOURNAL_MARK   = 0x4D
};

#define JOURNAL_OCTETS_AT 16U ///< Offset of a record's octets.

typedef struct {
    uint8_t kind; ///< JOURNAL_*.
    uint8_t table;
    uint16_t size; ///< Number of its octets, which begin in the buffer at JOURNAL_OCTETS_AT.
    uint32_t key;
} journal_record_t;

/// Returns the position of the first record of a generation.
journal_position_t journal_first_position(uint32_t generation);
/// Write a head. Statuses of the medium's `write`.
status_t journal_write_head(const medium_t* medium, uint32_t generation);
/// Read a head. STATUS_OK, STATUS_EMPTY (there is none), STATUS_IO.
status_t journal_read_head(const medium_t* medium, uint32_t* out_generation);

/// Length of the other medium after a successful commit.
typedef struct {
    uint32_t generation;
    uint32_t offset;
} journal_mark_t;

/// Write a mark. Statuses of the medium's `write`.
status_t journal_write_mark(const medium_t* medium, const journal_mark_t* mark);
/// Read a mark. STATUS_OK, STATUS_EMPTY (there is none), STATUS_IO.
status_t journal_read_mark(const medium_t* medium, journal_mark_t* out_mark);

/// Write a record whose octets are in the buffer already, and advance past it. Statuses of the medium's
/// `write`; after an error the position is unchanged.
status_t journal_write_record(const medium_t* medium, journal_position_t* position,
                              const journal_record_t* record, uint8_t* buffer);
/// Read a complete record into the buffer, and advance past it. STATUS_OK, STATUS_EMPTY (not the next record:
/// the position does not change), STATUS_IO.
status_t journal_read_record(const medium_t* medium, journal_position_t* position,
                             journal_record_t* out_record, uint8_t* buffer);
/// Find the next octets from `position` up to `end` that are a valid record with a possible sequence number,
/// even if the record before it is unreadable; set `position` to the octet after it. STATUS_OK, STATUS_EMPTY,
/// STATUS_IO. It takes O(octets read).
status_t journal_find_record(const medium_t* medium, uint64_t end, journal_position_t* position,
                             journal_record_t* out_record, uint8_t* buffer);

#endif // FSW_FRAMEWORK_JOURNAL_JOURNAL_RECORD_H
