// SPDX-License-Identifier: Apache-2.0
/// A store of records that survives power cuts. A table and a key identify each record; the records are
/// written as a log to two media. Media, generations, compaction and damage: docs/framework.md, "Journal".
///
/// A transaction consists of the puts and erasures up to a commit. After a power cut at any write, the store
/// contains the last transaction whose commit was acknowledged, or all of the one whose commit was in
/// progress. A commit that fails changes no earlier one; the next commit writes it again.
///
/// Ownership  The journal borrows media and slots; they outlive it. One owner per pair of media.
/// Context    One loop.
/// Time       Put, erase O(record), sometimes a compaction; commit: one sync, sometimes a compaction or a
///            part of it (`moves`); open, replay O(octets on the medium).
///
///     static journal_slot_t slots[JOURNAL_SLOTS(16384U)];
///     status_t status = journal_open(&journal, &(journal_configuration_t){ ... });
///     status = journal_replay(&journal, restore, services);
#ifndef FSW_FRAMEWORK_JOURNAL_JOURNAL_H
#define FSW_FRAMEWORK_JOURNAL_JOURNAL_H

#include "base/medium.h"
#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef JOURNAL_RECORD_MAX
#define JOURNAL_RECORD_MAX 8192U ///< Largest record [octets].
#endif
/// Number of slots of the index for a number of records: at most three quarters of the slots are used.
#define JOURNAL_SLOTS(records) ((records) + ((records) / 3U) + 1U)

/// Size on a medium: of a record with `size` octets of data (0 for an erasure and for a commit), and of the
/// head.
#define JOURNAL_RECORD_SIZE(size) (20U + (size))
#define JOURNAL_HEAD_SIZE 16U
#define JOURNAL_READS_PER_MOVE 4U ///< Most records that a compaction reads for one that it moves.

typedef struct { // One per slot, placed by the owner. Private.
    uint32_t key;
    uint32_t offset; // Offset of the record on the valid medium.
    uint32_t moved;  // During a compaction: offset of the record on the other medium.
    uint16_t size;   // Size of the record's octets.
    uint8_t table;
    bool is_taken;
} journal_slot_t;

typedef struct {
    medium_t media[2]; ///< Only the journal writes to them.
    uint32_t limit;    ///< Largest size of each medium [octets].
    /// A commit compacts if the dead octets exceed the live ones by more than this [octets].
    uint32_t slack;
    /// 0: a commit compacts at once. Otherwise a compaction is spread over commits: each one moves at most
    /// this number of live records for each put or erasure that it commits, and reads at most
    /// JOURNAL_READS_PER_MOVE times as many.
    uint32_t moves;
    journal_slot_t* slots; ///< JOURNAL_SLOTS(capacity).
    size_t capacity;       ///< Largest number of records, at least 1.
    /// Called by journal_open when the media are damaged, before it changes them; returns true if a copy was
    /// made. Null: no copy is made.
    bool (*keep)(void* context);
    void* keep_context;
} journal_configuration_t;

typedef struct {
    bool is_damaged;
    bool is_kept;     ///< `keep` has copied the media.
    uint32_t records; ///< Puts and erasures recognized after the damage; they are ignored.
    uint64_t octets;  ///< Octets of the media that are ignored.
} journal_damage_t;

typedef struct { // Private: position of a record, and the values that the record must contain to be valid.
    uint32_t offset;
    uint32_t chain; // Checksum of the previous record.
    uint32_t sequence;
} journal_position_t;

typedef struct { // Private, except `stats`, read-only, for telemetry, and `damage`.
    journal_configuration_t configuration;
    size_t slot_count;
    size_t active;             // Index of the medium that is written to.
    bool is_provisional;       // The generation on that medium has no commit yet.
    bool is_tail_unclean;      // The medium may contain octets after `tail`.
    bool is_suspect;           // Octets after `synced` may be lost, even if a read returns them.
    bool is_moving;            // A compaction is in progress.
    bool is_cut_due;           // The other medium may contain more than a mark: cut it before the next mark.
    bool is_replaying;         // The callback of journal_replay is using the buffer.
    uint32_t changes;          // Changes since the last valid commit.
    journal_position_t tail;   // Position of the next record.
    journal_position_t synced; // Position after the last valid commit.
    struct {
        journal_position_t from; // Position of the next record to read on the active medium.
        journal_position_t to;   // Position of the next record to write on the other medium.
        uint32_t begin;          // Tail when the compaction began.
    } move;
    uint8_t buffer[JOURNAL_RECORD_SIZE(JOURNAL_RECORD_MAX)];
    journal_damage_t damage; ///< Damage found when the journal was opened. Read-only.
    struct {
        uint32_t generation;  ///< Generation of the medium written to.
        uint32_t records;     ///< Number of live records.
        uint32_t live;        ///< Octets of live records.
        uint32_t used;        ///< Octets in use on that medium.
        uint32_t commits;     ///< Valid commits that changed something.
        uint32_t compactions; ///< Compactions completed.
        uint32_t full;        ///< Puts refused: no room, or the record is too large.
        uint32_t unknown;     ///< Erasures of records that do not exist.
        uint32_t failed;      ///< Calls and compactions that failed.
        uint32_t unmarked;    ///< Commits whose mark could not be written.
        uint64_t discarded;   ///< Octets after the last commit, cut off at open.
    } stats;
} journal_t;

/// Find the last whole commit, or begin an empty journal if there is none; check for damage.
/// STATUS_OK; STATUS_EXHAUSTED (more records than slots), STATUS_IO, STATUS_FULL: the journal may not be
/// used. 256 <= limit <= 2^31.
MUST_USE status_t journal_open(journal_t* journal, const journal_configuration_t* configuration);

#define JOURNAL_DAMAGE_SIZE 9U ///< Event data: octets u32 (saturates), records u32, is_kept u8.
/// Write the damage, and `refused` records that no service restored, as the data of an event. False if
/// there is no damage to report.
bool journal_report_damage(const journal_t* journal, uint32_t refused, uint8_t octets[JOURNAL_DAMAGE_SIZE]);

/// Callback that restores a record. It must not call the journal; `octets` are valid only during the call.
typedef void (*journal_take_t)(void* context, uint8_t table, uint32_t key, const uint8_t* octets,
                               size_t size);
/// Pass each live record once to `take`, in the order in which they were last put. STATUS_OK; STATUS_IO: the
/// records before the failure were passed.
MUST_USE status_t journal_replay(journal_t* journal, journal_take_t take, void* context);

// ---- The functions of a port to records: `context` is the journal ----

/// Store a record, replacing the previous one with its key. STATUS_OK; STATUS_FULL (no slot, or no room on
/// the medium), STATUS_TOO_LARGE (size > JOURNAL_RECORD_MAX), STATUS_IO: nothing has changed.
status_t journal_put(void* context, uint8_t table, uint32_t key, const uint8_t* octets, size_t size);
/// Erase a record. STATUS_OK; STATUS_NOT_FOUND, STATUS_IO: nothing has changed. There is always room for an
/// erasure.
status_t journal_erase(void* context, uint8_t table, uint32_t key);
/// Commit all puts and erasures since the last commit. STATUS_OK (at once if there were none), STATUS_IO: no
/// change since the last commit is certain to survive a power cut; the next commit tries again with all of
/// them.
status_t journal_commit(void* context);

#endif // FSW_FRAMEWORK_JOURNAL_JOURNAL_H
