// SPDX-License-Identifier: Apache-2.0
/// Reader of scenario files: one command per line, `<time> <actor> <verb> <argument...>`, time 0 to 1e6 s;
/// `#` starts a comment.
///
/// Actors of the simulator are `hand` and `fault`; `operator` and `ground` belong to the ground segment.
/// Each reader takes the lines of its actor and skips the others; a line with an unknown actor or without a
/// time is an error for every reader. Times of one actor do not decrease. Errors name file:line, the value
/// found and the expected one; if the file cannot be opened, they name the file and the reason.
#ifndef SIM_OPERATOR_SCENARIO_H
#define SIM_OPERATOR_SCENARIO_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SCENARIO_WORDS_MAX 12U
#define SCENARIO_LINE_MAX 512U
#define SCENARIO_ERROR_MAX 480U
#define SCENARIO_LIST_MAX 256U ///< Octets of a list of names in a message.

/// A line of the requested actor. Words point into `text`.
typedef struct {
    const char* path;
    unsigned line;
    uint64_t time_ns;
    size_t word_count;                    ///< Verb and arguments.
    const char* word[SCENARIO_WORDS_MAX]; ///< word[0] is the verb.
    char text[SCENARIO_LINE_MAX];
} scenario_line_t;

/// Handler of one line. On STATUS_INVALID or STATUS_OUT_OF_RANGE it has filled `error` by scenario_error.
typedef status_t (*scenario_taker_t)(void* context, const scenario_line_t* line,
                                     char error[SCENARIO_ERROR_MAX]);

/// Pass every line of `actor` in `path` to `take`, in order; the first error ends the reading.
/// Returns STATUS_OK, STATUS_NOT_FOUND (file), STATUS_INVALID, STATUS_OUT_OF_RANGE, STATUS_EXHAUSTED (from
/// the handler); for every status except STATUS_OK `error` contains the message.
MUST_USE status_t scenario_read(const char* path, const char* actor, scenario_taker_t take, void* context,
                                char error[SCENARIO_ERROR_MAX]);

/// Write "file:line: found 'x', expected y" into error. Returns STATUS_INVALID.
status_t scenario_error(const scenario_line_t* line, const char* found, const char* expected,
                        char error[SCENARIO_ERROR_MAX]);

/// The same for a list of names, which `expected` contains after a colon. If the list is empty, the message
/// says that there is none.
status_t scenario_list_error(const scenario_line_t* line, const char* found, char expected[SCENARIO_LIST_MAX],
                             char error[SCENARIO_ERROR_MAX]);

/// Add a space and a name to a list in a message; what does not fit is cut.
void scenario_list(char words[SCENARIO_LIST_MAX], const char* name);

/// Interpret line->text; line->path and line->line are set. *out_is_of_actor is true if it is a line of
/// `actor`; then `line` contains its words. Returns STATUS_OK (also for an empty line), STATUS_INVALID (error
/// is filled).
MUST_USE status_t scenario_interpret(scenario_line_t* line, const char* actor, bool* out_is_of_actor,
                                     char error[SCENARIO_ERROR_MAX]);

/// Split line->text into line->word, without a comment. word_count is 0 for an empty line, and
/// SCENARIO_WORDS_MAX + 1 if there are more words.
void scenario_words(scenario_line_t* line);

/// The lines of an actor in the order of their times; those before `next` have been played.
typedef struct {
    void* record; ///< Array of `count` records, with room for `room` records.
    size_t count;
    size_t next;
    size_t room;
} scenario_lines_t;

/// Insert a record of `octets` octets that begins with its time (uint64_t, ns), after records of the same
/// time and not before `next`. If the array is full, played records are removed, or it grows. STATUS_OK,
/// STATUS_EXHAUSTED (no memory; nothing is changed).
MUST_USE status_t scenario_insert(scenario_lines_t* lines, const void* record, size_t octets);

/// Read word `index` as a number in [low, high]; `name` is its name in the message. Returns STATUS_OK,
/// STATUS_INVALID (missing, not a number, outside the range; error is filled).
MUST_USE status_t scenario_number(const scenario_line_t* line, size_t index, const char* name, double low,
                                  double high, double* out_value, char error[SCENARIO_ERROR_MAX]);

/// Check that the verb has exactly `count` arguments; `usage` is the expected line in the message. Returns
/// STATUS_OK or STATUS_INVALID (error is filled).
MUST_USE status_t scenario_arguments(const scenario_line_t* line, size_t count, const char* usage,
                                     char error[SCENARIO_ERROR_MAX]);

#endif // SIM_OPERATOR_SCENARIO_H
