// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/journal/journal.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "fsw/framework/journal/journal_damage.h"
#include "fsw/framework/journal/journal_index.h"
#include "fsw/framework/journal/journal_record.h"

#include <string.h>

#define LIMIT_MIN 256U
#define LIMIT_MAX 0x80000000U

static const medium_t* medium_of(const journal_t* const journal, const size_t index)
{
    return &journal->configuration.media[index];
}

static const medium_t* active_of(const journal_t* const journal)
{
    return medium_of(journal, journal->active);
}

static journal_slot_t* find(const journal_t* const journal, const uint8_t table, const uint32_t key)
{
    return journal_index_find(journal->configuration.slots, journal->slot_count, table, key);
}

/// Note the record at `offset` as the valid one of its key. `slot` is the slot of the key, or null if the key
/// is new.
static void note_put(journal_t* const journal, journal_slot_t* slot, const journal_record_t* const record,
                     const uint32_t offset)
{
    if (slot == NULL) {
        slot = journal_index_insert(journal->configuration.slots, journal->slot_count, record->table,
                                    record->key);
        journal->stats.records++;
    } else {
        journal->stats.live -= JOURNAL_RECORD_SIZE(slot->size);
    }
    slot->offset = offset;
    slot->size   = record->size;
    journal->stats.live += JOURNAL_RECORD_SIZE(record->size);
}

static void note_erased(journal_t* const journal, const journal_slot_t* const slot)
{
    journal->stats.records--;
    journal->stats.live -= JOURNAL_RECORD_SIZE(slot->size);
    journal_index_remove(journal->configuration.slots, journal->slot_count, slot);
}

/// Count a failure. Returns STATUS_IO.
static status_t failed(journal_t* const journal)
{
    journal->stats.failed++;
    return STATUS_IO;
}

// ---- Writing ----

/// Append a record whose octets are in the buffer. STATUS_OK, STATUS_FULL, STATUS_IO.
static status_t append(journal_t* const journal, const journal_record_t* const record)
{
    const medium_t* const medium = active_of(journal);
    if (journal->is_tail_unclean) {
        // A failed write may have left octets after the tail. After the next records, a reader could take
        // them for a valid record.
        if (medium->resize(medium->context, journal->tail.offset) != STATUS_OK) {
            return STATUS_IO;
        }
        journal->is_tail_unclean = false;
    }
    const status_t status    = journal_write_record(medium, &journal->tail, record, journal->buffer);
    journal->is_tail_unclean = (status != STATUS_OK);
    journal->stats.used      = journal->tail.offset;
    return status;
}

/// True if a log of `used` octets can take another record and, after it, the commit and one erasure for each
/// record, the new one included.
static bool has_room(const journal_t* const journal, const uint32_t used, const size_t size)
{
    const uint64_t erasures = ((uint64_t)journal->stats.records + 1U) * JOURNAL_RECORD_SIZE(0U);
    const uint64_t needed   = used + JOURNAL_RECORD_SIZE((uint64_t)size) + erasures + JOURNAL_RECORD_SIZE(0U);
    return needed <= journal->configuration.limit;
}

/// Empty a medium so that a power cut cannot bring its content back. One octet is kept: a size of 0 then
/// means that the medium was never used, and such a medium needs no sync.
static status_t empty_medium(const medium_t* const medium)
{
    const status_t status = medium->resize(medium->context, 1U);
    return (status == STATUS_OK) ? medium->sync(medium->context) : status;
}

/// Empty a medium and write the head of a generation.
static status_t begin_generation(const medium_t* const medium, const uint32_t generation)
{
    const status_t status = empty_medium(medium);
    return (status == STATUS_OK) ? journal_write_head(medium, generation) : status;
}

/// Make the medium `index` the active one and continue at `tail`. Its generation contains no commit yet.
static void go_on(journal_t* const journal, const size_t index, const uint32_t generation,
                  const journal_position_t* const tail)
{
    journal->active           = index;
    journal->is_provisional   = true;
    journal->is_tail_unclean  = false;
    journal->is_suspect       = false;
    journal->tail             = *tail;
    journal->synced           = journal_first_position(generation);
    journal->stats.generation = generation;
    journal->stats.used       = tail->offset;
}

// ---- Compaction ----

/// Begin to move the live records to the other medium. The present one must contain the last commit.
/// STATUS_OK, STATUS_FULL, STATUS_IO.
static status_t begin_move(journal_t* const journal)
{
    const uint32_t generation = journal->stats.generation + 1U;
    journal->move.from        = journal_first_position(journal->stats.generation);
    journal->move.to          = journal_first_position(generation);
    journal->move.begin       = journal->tail.offset;
    journal->is_cut_due       = true;
    const status_t status     = begin_generation(medium_of(journal, 1U - journal->active), generation);
    journal->is_moving        = (status == STATUS_OK);
    return status;
}

/// True if the record at `offset` must be moved: it is live, or it erases a record that may have been moved.
/// If it is live, its slot gets the new offset.
static bool is_needed(journal_t* const journal, const journal_record_t* const record, const uint32_t offset)
{
    if (record->kind != JOURNAL_PUT) {
        return (record->kind == JOURNAL_ERASE) && (offset >= journal->move.begin);
    }
    journal_slot_t* const slot = find(journal, record->table, record->key);
    const bool is_live         = (slot != NULL) && (slot->offset == offset);
    if (is_live) {
        slot->moved = journal->move.to.offset;
    }
    return is_live;
}

/// Move at most `most` records, and read at most JOURNAL_READS_PER_MOVE times as many. STATUS_OK;
/// STATUS_FULL, STATUS_IO: the compaction must begin again.
static status_t move(journal_t* const journal, const uint64_t most)
{
    const medium_t* const other = medium_of(journal, 1U - journal->active);
    uint64_t reads              = most * JOURNAL_READS_PER_MOVE;
    uint64_t moves              = most;
    status_t status             = STATUS_OK;
    while ((status == STATUS_OK) && (journal->move.from.offset < journal->tail.offset) && (reads > 0U) &&
           (moves > 0U)) {
        journal_record_t record;
        const uint32_t offset = journal->move.from.offset;
        // Each record up to the tail has been written: another status than STATUS_OK is an error.
        status = (journal_read_record(active_of(journal), &journal->move.from, &record, journal->buffer) ==
                  STATUS_OK)
                     ? STATUS_OK
                     : STATUS_IO;
        reads--;
        if ((status == STATUS_OK) && is_needed(journal, &record, offset)) {
            status = journal_write_record(other, &journal->move.to, &record, journal->buffer);
            moves--;
        }
    }
    journal->is_moving = (status == STATUS_OK);
    return status;
}

/// Continue on the other medium. All records are moved.
static void end_move(journal_t* const journal)
{
    for (size_t i = 0U; i < journal->slot_count; i++) {
        journal->configuration.slots[i].offset = journal->configuration.slots[i].moved;
    }
    go_on(journal, 1U - journal->active, journal->stats.generation + 1U, &journal->move.to);
    journal->is_moving = false;
    journal->stats.compactions++;
}

/// Continue with the live records on the other medium. The present one must contain the last commit.
/// STATUS_OK; STATUS_FULL, STATUS_IO: nothing has changed.
static status_t compact(journal_t* const journal)
{
    // A compaction in progress begins again: it may have moved records that are dead now, so the other medium
    // may lack the room.
    status_t status = begin_move(journal);
    if (status == STATUS_OK) {
        status = move(journal, UINT32_MAX);
    }
    if (status == STATUS_OK) {
        end_move(journal);
    }
    return status;
}

/// Make room for a record. STATUS_OK, STATUS_FULL, STATUS_IO.
static status_t make_room(journal_t* const journal, const size_t size)
{
    if (has_room(journal, journal->tail.offset, size)) {
        return STATUS_OK;
    }
    // While the generation is provisional, the other medium contains the last commit and must not be
    // overwritten.
    const bool has_other = !journal->is_provisional;
    if (!has_other || !has_room(journal, JOURNAL_HEAD_SIZE + journal->stats.live, size)) {
        return STATUS_FULL;
    }
    return compact(journal);
}

status_t journal_put(void* const context, const uint8_t table, const uint32_t key,
                     const uint8_t* const octets, const size_t size)
{
    journal_t* const journal = context;
    FSW_ASSERT((journal != NULL) && ((octets != NULL) || (size == 0U)) && !journal->is_replaying);
    if (size > JOURNAL_RECORD_MAX) {
        journal->stats.full++;
        return STATUS_TOO_LARGE;
    }
    const journal_record_t record = {.kind = JOURNAL_PUT, .table = table, .size = (uint16_t)size, .key = key};
    journal_slot_t* const slot    = find(journal, table, key); // Compaction does not move slots.
    status_t status               = STATUS_FULL;
    if ((slot != NULL) || (journal->stats.records < journal->configuration.capacity)) {
        status = make_room(journal, size);
    }
    const uint32_t offset = journal->tail.offset;
    if (status == STATUS_OK) {
        if (size > 0U) {
            (void)memcpy(&journal->buffer[JOURNAL_OCTETS_AT], octets, size);
        }
        status = append(journal, &record);
    }
    if (status == STATUS_OK) {
        note_put(journal, slot, &record, offset);
        journal->changes++;
    } else if (status == STATUS_FULL) {
        journal->stats.full++;
    } else {
        status = failed(journal);
    }
    return status;
}

status_t journal_erase(void* const context, const uint8_t table, const uint32_t key)
{
    journal_t* const journal = context;
    FSW_ASSERT((journal != NULL) && !journal->is_replaying);
    const journal_slot_t* const slot = find(journal, table, key);
    if (slot == NULL) {
        journal->stats.unknown++;
        return STATUS_NOT_FOUND;
    }
    const journal_record_t record = {.kind = JOURNAL_ERASE, .table = table, .key = key};
    if (append(journal, &record) != STATUS_OK) {
        return failed(journal);
    }
    note_erased(journal, slot);
    journal->changes++;
    return STATUS_OK;
}

/// Write all records after the last commit again. STATUS_OK; STATUS_IO: the medium failed, or its octets are
/// not those that were written.
static status_t write_again(journal_t* const journal)
{
    const medium_t* const medium = active_of(journal);
    journal_position_t position  = journal->synced;
    status_t status              = STATUS_OK;
    if (journal->is_provisional) {
        status = journal_write_head(medium, journal->stats.generation);
    }
    while ((status == STATUS_OK) && (position.offset < journal->tail.offset)) {
        journal_record_t record;
        journal_position_t same = position;
        status                  = journal_read_record(medium, &position, &record, journal->buffer);
        if (status == STATUS_OK) {
            status = journal_write_record(medium, &same, &record, journal->buffer);
        }
    }
    return (status == STATUS_OK) ? STATUS_OK : STATUS_IO;
}

/// Write the offset of the last commit to the other medium. No sync is needed: if the mark is lost, the
/// journal is still valid.
static void write_mark(journal_t* const journal)
{
    const medium_t* const other = medium_of(journal, 1U - journal->active);
    const journal_mark_t mark   = {.generation = journal->stats.generation, .offset = journal->synced.offset};
    status_t status             = STATUS_OK;
    if (journal->is_moving) {
        const journal_record_t record = {.kind = JOURNAL_MARK, .key = mark.offset};
        status             = journal_write_record(other, &journal->move.to, &record, journal->buffer);
        journal->is_moving = (status == STATUS_OK);
    } else {
        if (journal->is_cut_due) {
            // Remove the old log first: a file system that never overwrites in place would copy it at each
            // mark.
            status              = other->resize(other->context, JOURNAL_HEAD_SIZE);
            journal->is_cut_due = (status != STATUS_OK);
        }
        if (status == STATUS_OK) {
            status = journal_write_mark(other, &mark);
        }
    }
    journal->stats.unmarked += (status == STATUS_OK) ? 0U : 1U;
}

/// Close the transaction and make it valid. STATUS_OK, STATUS_IO.
static status_t close_transaction(journal_t* const journal)
{
    const medium_t* const medium  = active_of(journal);
    const journal_record_t record = {.kind = JOURNAL_COMMIT};
    status_t status               = journal->is_suspect ? write_again(journal) : STATUS_OK;
    if (status == STATUS_OK) {
        status = append(journal, &record);
    }
    if (status == STATUS_OK) {
        status              = medium->sync(medium->context);
        journal->is_suspect = (status != STATUS_OK);
    }
    if (status != STATUS_OK) {
        return STATUS_IO;
    }
    journal->synced         = journal->tail;
    journal->changes        = 0U;
    journal->is_provisional = false;
    write_mark(journal);
    return STATUS_OK;
}

/// True if the log is longer than twice its live records and the slack.
static bool is_wasteful(const journal_t* const journal)
{
    const uint64_t live = JOURNAL_HEAD_SIZE + (uint64_t)journal->stats.live;
    return journal->tail.offset > ((2U * live) + journal->configuration.slack);
}

/// Continue a compaction, or begin one if is_wasteful. `changes`: puts and erasures of the transaction that
/// was just committed. STATUS_OK, STATUS_FULL, STATUS_IO.
static status_t advance_compaction(journal_t* const journal, const uint32_t changes)
{
    const uint32_t moves = journal->configuration.moves;
    const bool is_whole  = (moves == 0U);
    status_t status      = STATUS_OK;
    if (!journal->is_moving) {
        if (!is_wasteful(journal)) {
            return STATUS_OK;
        }
        status = begin_move(journal);
        if ((status == STATUS_OK) && !is_whole) {
            write_mark(journal); // The new head has overwritten the last mark.
            return STATUS_OK;
        }
    }
    if (status == STATUS_OK) {
        status = move(journal, is_whole ? UINT32_MAX : ((uint64_t)moves * changes));
    }
    if ((status == STATUS_OK) && (journal->move.from.offset == journal->tail.offset)) {
        end_move(journal);
        status = close_transaction(journal);
    }
    return status;
}

status_t journal_commit(void* const context)
{
    journal_t* const journal = context;
    FSW_ASSERT((journal != NULL) && !journal->is_replaying);
    const uint32_t changes = journal->changes;
    if ((changes == 0U) && !journal->is_provisional) {
        return STATUS_OK;
    }
    if (close_transaction(journal) != STATUS_OK) {
        return failed(journal);
    }
    journal->stats.commits++;
    // The commit stays valid even if the compaction fails.
    if (advance_compaction(journal, changes) != STATUS_OK) {
        journal->stats.failed++;
    }
    return STATUS_OK;
}

// ---- Reading back ----

/// Fill the index from the medium, up to the tail. STATUS_OK, STATUS_EXHAUSTED, STATUS_IO.
static status_t build_index(journal_t* const journal)
{
    journal_position_t position = journal_first_position(journal->stats.generation);
    while (position.offset < journal->tail.offset) {
        journal_record_t record;
        const uint32_t offset = position.offset;
        if (journal_read_record(active_of(journal), &position, &record, journal->buffer) != STATUS_OK) {
            return STATUS_IO;
        }
        journal_slot_t* const slot = find(journal, record.table, record.key);
        if (record.kind == JOURNAL_PUT) {
            if ((slot == NULL) && (journal->stats.records >= journal->configuration.capacity)) {
                return STATUS_EXHAUSTED;
            }
            note_put(journal, slot, &record, offset);
        } else if ((record.kind == JOURNAL_ERASE) && (slot != NULL)) {
            note_erased(journal, slot);
        } else {
            // A mark refers to the previous generation. A commit needs no action: all records up to the tail
            // are committed.
        }
    }
    return STATUS_OK;
}

/// Cut off the octets after the tail. STATUS_OK, STATUS_FULL, STATUS_IO.
static status_t cut_tail(journal_t* const journal)
{
    const medium_t* const medium = active_of(journal);
    uint64_t size                = 0U;
    status_t status              = medium->size(medium->context, &size);
    if ((status != STATUS_OK) || (size <= journal->tail.offset)) {
        return status;
    }
    journal->stats.discarded = size - journal->tail.offset;
    status                   = medium->resize(medium->context, journal->tail.offset);
    return (status == STATUS_OK) ? medium->sync(medium->context) : status;
}

/// Begin an empty journal: remove the content of an earlier one and sync, then write the head and sync.
/// Records are written only after that; therefore a medium that is longer than a head but has none is
/// damaged. STATUS_OK, STATUS_FULL, STATUS_IO.
static status_t begin_journal(journal_t* const journal, const journal_survey_t surveys[2])
{
    const journal_position_t tail = journal_first_position(1U);
    status_t status               = STATUS_OK;
    go_on(journal, 0U, 1U, &tail);
    if (surveys[1].size > 0U) { // A later start must not use a mark of an earlier journal.
        status = empty_medium(medium_of(journal, 1U));
    }
    if ((status == STATUS_OK) && (surveys[0].size > 0U)) {
        status = empty_medium(medium_of(journal, 0U));
    }
    if (status == STATUS_OK) {
        status = journal_write_head(medium_of(journal, 0U), 1U);
    }
    return (status == STATUS_OK) ? active_of(journal)->sync(active_of(journal)->context) : status;
}

/// Returns the index of the medium that contains the last commit; 2 if neither does.
static size_t valid_of(const journal_survey_t surveys[2])
{
    if (!surveys[0].has_commit && !surveys[1].has_commit) {
        return 2U;
    }
    const bool is_second =
        surveys[1].has_commit && (!surveys[0].has_commit || (surveys[1].generation > surveys[0].generation));
    return is_second ? 1U : 0U;
}

/// Read both media. STATUS_OK, STATUS_IO.
static status_t read_media(journal_t* const journal, journal_survey_t surveys[2])
{
    status_t status = STATUS_OK;
    for (size_t i = 0U; (i < 2U) && (status == STATUS_OK); i++) {
        status = journal_survey(medium_of(journal, i), &surveys[i], journal->buffer);
    }
    if (status == STATUS_OK) {
        status = journal_assess(journal->configuration.media, surveys, valid_of(surveys), &journal->damage,
                                journal->buffer);
    }
    return status;
}

status_t journal_open(journal_t* const journal, const journal_configuration_t* const configuration)
{
    FSW_ASSERT((journal != NULL) && (configuration != NULL) && (configuration->slots != NULL) &&
               (configuration->capacity >= 1U));
    FSW_ASSERT((configuration->limit >= LIMIT_MIN) && (configuration->limit <= LIMIT_MAX));
    (void)memset(journal, 0, sizeof *journal);
    journal->configuration = *configuration;
    journal->slot_count    = JOURNAL_SLOTS(configuration->capacity);
    (void)memset(configuration->slots, 0, journal->slot_count * sizeof configuration->slots[0]);

    journal_survey_t surveys[2];
    if (read_media(journal, surveys) != STATUS_OK) {
        return STATUS_IO;
    }
    if (journal->damage.is_damaged && (configuration->keep != NULL)) {
        journal->damage.is_kept = configuration->keep(configuration->keep_context);
    }
    const size_t valid = valid_of(surveys);
    if (valid > 1U) {
        return begin_journal(journal, surveys);
    }
    go_on(journal, valid, surveys[valid].generation, &surveys[valid].end);
    journal->is_provisional = false;
    journal->is_cut_due     = (surveys[1U - valid].size > JOURNAL_HEAD_SIZE);
    journal->synced         = surveys[valid].end;
    status_t status         = build_index(journal);
    if (status == STATUS_OK) {
        status = cut_tail(journal);
    }
    if ((status == STATUS_OK) && journal->damage.is_damaged) {
        write_mark(journal); // The next start then does not report the same damage again.
    }
    return status;
}

bool journal_report_damage(const journal_t* const journal, const uint32_t refused,
                           uint8_t octets[JOURNAL_DAMAGE_SIZE])
{
    FSW_ASSERT((journal != NULL) && (octets != NULL));
    const journal_damage_t* const damage = &journal->damage;
    octets_put_u32(octets, (damage->octets < UINT32_MAX) ? (uint32_t)damage->octets : UINT32_MAX);
    octets_put_u32(&octets[4], damage->records + refused);
    octets[8] = damage->is_kept ? 1U : 0U;
    return damage->is_damaged || (refused > 0U);
}

status_t journal_replay(journal_t* const journal, const journal_take_t take, void* const context)
{
    FSW_ASSERT((journal != NULL) && (take != NULL));
    journal_position_t position = journal_first_position(journal->stats.generation);
    while (position.offset < journal->tail.offset) {
        journal_record_t record;
        const uint32_t offset = position.offset;
        if (journal_read_record(active_of(journal), &position, &record, journal->buffer) != STATUS_OK) {
            return failed(journal);
        }
        const journal_slot_t* const slot = find(journal, record.table, record.key);
        if ((record.kind == JOURNAL_PUT) && (slot != NULL) && (slot->offset == offset)) {
            journal->is_replaying = true;
            take(context, record.table, record.key, &journal->buffer[JOURNAL_OCTETS_AT], record.size);
            journal->is_replaying = false;
        }
    }
    return STATUS_OK;
}
