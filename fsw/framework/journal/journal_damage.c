// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/journal/journal_damage.h"

/// Records found after the position where reading stops.
typedef struct {
    uint32_t records;
    bool has_commit;
    bool was_acknowledged; // A commit is followed by further records, so that commit had succeeded.
} orphans_t;

status_t journal_survey(const medium_t* const medium, journal_survey_t* const out_survey,
                        uint8_t* const buffer)
{
    *out_survey     = (journal_survey_t){.size = 0U};
    status_t status = medium->size(medium->context, &out_survey->size);
    if (status == STATUS_OK) {
        status               = journal_read_mark(medium, &out_survey->mark);
        out_survey->has_mark = (status == STATUS_OK);
    }
    if (status == STATUS_EMPTY) {
        status               = journal_read_head(medium, &out_survey->generation);
        out_survey->has_head = (status == STATUS_OK);
    }
    out_survey->stop = journal_first_position(out_survey->generation);
    while ((status == STATUS_OK) && out_survey->has_head) {
        journal_record_t record;
        status = journal_read_record(medium, &out_survey->stop, &record, buffer);
        if ((status == STATUS_OK) && (record.kind == JOURNAL_COMMIT)) {
            out_survey->has_commit = true;
            out_survey->end        = out_survey->stop;
        }
        if ((status == STATUS_OK) && (record.kind == JOURNAL_MARK)) {
            out_survey->has_mark = true;
            out_survey->mark =
                (journal_mark_t){.generation = out_survey->generation - 1U, .offset = record.key};
        }
    }
    return ((status == STATUS_OK) || (status == STATUS_EMPTY)) ? STATUS_OK : STATUS_IO;
}

/// Count the valid puts and erasures after the position where reading stops, and find the commits there.
/// STATUS_OK, STATUS_IO.
static status_t find_orphans(const medium_t* const medium, const journal_survey_t* const survey,
                             orphans_t* const out_orphans, uint8_t* const buffer)
{
    journal_position_t position = survey->stop;
    status_t status             = STATUS_OK;
    *out_orphans                = (orphans_t){.records = 0U};
    while (status == STATUS_OK) {
        journal_record_t record;
        status = journal_find_record(medium, survey->size, &position, &record, buffer);
        if (status == STATUS_OK) {
            const bool is_commit          = (record.kind == JOURNAL_COMMIT);
            const bool is_change          = !is_commit && (record.kind != JOURNAL_MARK);
            out_orphans->was_acknowledged = out_orphans->was_acknowledged || out_orphans->has_commit;
            out_orphans->has_commit       = out_orphans->has_commit || is_commit;
            out_orphans->records += is_change ? 1U : 0U;
        }
    }
    return (status == STATUS_EMPTY) ? STATUS_OK : status;
}

/// Valid part of the media: the records up to the last commit of a generation, if there is a commit.
typedef struct {
    bool is_there;
    uint32_t generation;
    uint32_t end;
} valid_t;

/// True if a successful commit reached further than the valid part.
static bool is_cut(const journal_survey_t surveys[2], const valid_t* const valid)
{
    bool is_found = false;
    for (size_t i = 0U; i < 2U; i++) {
        const journal_mark_t* const mark = &surveys[i].mark;
        const bool is_behind             = !valid->is_there || (mark->generation > valid->generation) ||
                               ((mark->generation == valid->generation) && (mark->offset > valid->end));
        is_found = is_found || (surveys[i].has_mark && is_behind);
    }
    return is_found;
}

status_t journal_assess(const medium_t media[2], const journal_survey_t surveys[2], const size_t last,
                        journal_damage_t* const out_damage, uint8_t* const buffer)
{
    valid_t valid = {.is_there = (last < 2U)};
    if (valid.is_there) {
        valid.generation = surveys[last].generation;
        valid.end        = surveys[last].end.offset;
    }
    journal_damage_t damage = {.is_damaged = is_cut(surveys, &valid)};
    for (size_t i = 0U; i < 2U; i++) {
        // Do not examine a medium without log, or one that is not newer than the valid one: it contains the
        // generation that the valid one has replaced.
        const journal_survey_t* const survey = &surveys[i];
        const bool is_newer                  = survey->has_head && (survey->generation > valid.generation);
        if ((survey->has_head || !survey->has_mark) && (!valid.is_there || (i == last) || is_newer)) {
            orphans_t orphans;
            if (find_orphans(&media[i], survey, &orphans, buffer) != STATUS_OK) {
                return STATUS_IO;
            }
            // The head of a journal is synced before anything else is written.
            const bool is_headless = !survey->has_head && (survey->size > JOURNAL_HEAD_SIZE);
            damage.is_damaged      = damage.is_damaged || orphans.was_acknowledged || is_headless;
            damage.records += orphans.records;
            damage.octets += survey->size - ((i == last) ? valid.end : 0U);
        }
    }
    *out_damage = damage.is_damaged ? damage : (journal_damage_t){.is_damaged = false};
    return STATUS_OK;
}
