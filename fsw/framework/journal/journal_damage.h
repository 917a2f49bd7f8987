// SPDX-License-Identifier: Apache-2.0
/// What lies on the media of a journal when it is opened, and whether some of it is lost. For the journal
/// only.
///
/// A power cut leaves a transaction that is not whole behind the last commit: that is no damage. Damage is
/// what takes away a commit that was acknowledged. It is known by the mark on the medium that is not written
/// to, which says how far the other one reached when a commit had succeeded; by a commit with a record behind
/// it, both behind the place where reading ends; and, where no medium holds a commit that can be read, by any
/// octets that are not the beginning of a journal.
#ifndef FSW_FRAMEWORK_JOURNAL_JOURNAL_DAMAGE_H
#define FSW_FRAMEWORK_JOURNAL_JOURNAL_DAMAGE_H

#include "fsw/framework/journal/journal_record.h"

typedef struct { // What a medium holds.
    uint64_t size;
    bool has_head;
    bool has_commit;
    bool has_mark;
    uint32_t generation;
    journal_place_t end;  // Behind the last commit.
    journal_place_t stop; // Behind the last record that can be read.
    journal_mark_t mark;
} journal_survey_t;

/// STATUS_OK, STATUS_IO.
status_t journal_survey(const medium_t* medium, journal_survey_t* out_survey, uint8_t* buffer);
/// Judge both media; `last` is the index of the one that holds the last commit, or 2. STATUS_OK, STATUS_IO.
status_t journal_assess(const medium_t media[2], const journal_survey_t surveys[2], size_t last,
                        journal_damage_t* out_damage, uint8_t* buffer);

#endif // FSW_FRAMEWORK_JOURNAL_JOURNAL_DAMAGE_H
