// SPDX-License-Identifier: Apache-2.0
/// Examines the media of a journal when it is opened and finds out whether records are lost. Private to the
/// journal.
///
/// A power cut may leave an incomplete transaction after the last commit: that is not damage. Damage means
/// that an acknowledged commit is lost. It is detected in three ways: by the mark on the medium that is not
/// being written to, which contains the length of the other medium after a successful commit; by a commit and
/// a later record, both after the position where reading stops; and, if no medium has a readable commit, by
/// any octets that are not the beginning of a journal.
#ifndef FSW_FRAMEWORK_JOURNAL_JOURNAL_DAMAGE_H
#define FSW_FRAMEWORK_JOURNAL_JOURNAL_DAMAGE_H

#include "fsw/framework/journal/journal_record.h"

typedef struct { // Content of a medium.
    uint64_t size;
    bool has_head;
    bool has_commit;
    bool has_mark;
    uint32_t generation;
    journal_position_t end;  // After the last commit.
    journal_position_t stop; // After the last readable record.
    journal_mark_t mark;
} journal_survey_t;

/// Read a medium and describe its content. STATUS_OK, STATUS_IO.
status_t journal_survey(const medium_t* medium, journal_survey_t* out_survey, uint8_t* buffer);
/// Decide whether the media are damaged; `last` is the index of the one that holds the last commit, or 2.
/// STATUS_OK, STATUS_IO.
status_t journal_assess(const medium_t media[2], const journal_survey_t surveys[2], size_t last,
                        journal_damage_t* out_damage, uint8_t* buffer);

#endif // FSW_FRAMEWORK_JOURNAL_JOURNAL_DAMAGE_H
