// SPDX-License-Identifier: Apache-2.0
#include "sim/operator/scenario.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SEPARATORS " \t\r\n"
#define ROOM_FIRST 64U ///< Number of records for which memory is allocated initially.
#define LATEST_S 1.0e6 ///< Eleven days; a later time is refused as a typing error.

static const char* const actors[] = {"hand", "fault", "operator", "ground"};
#define ACTOR_COUNT (sizeof actors / sizeof actors[0])

void scenario_list(char words[SCENARIO_LIST_MAX], const char* const name)
{
    const size_t used = strlen(words);
    (void)snprintf(&words[used], SCENARIO_LIST_MAX - used, " %s", name);
}

status_t scenario_error(const scenario_line_t* const line, const char* const found,
                        const char* const expected, char error[SCENARIO_ERROR_MAX])
{
    (void)snprintf(error, SCENARIO_ERROR_MAX, "%s:%u: found '%.60s', expected %.250s", line->path, line->line,
                   found, expected);
    return STATUS_INVALID;
}

status_t scenario_list_error(const scenario_line_t* const line, const char* const found,
                             char expected[SCENARIO_LIST_MAX], char error[SCENARIO_ERROR_MAX])
{
    const size_t last = strlen(expected) - 1U;
    if (expected[last] == ':') {
        (void)snprintf(&expected[last], SCENARIO_LIST_MAX - last, ", but there is none");
    }
    return scenario_error(line, found, expected, error);
}

status_t scenario_number(const scenario_line_t* const line, const size_t index, const char* const name,
                         const double low, const double high, double* const out_value,
                         char error[SCENARIO_ERROR_MAX])
{
    char expected[128];
    (void)snprintf(expected, sizeof expected, "%s from %g to %g", name, low, high);
    if (index >= line->word_count) {
        return scenario_error(line, "end of line", expected, error);
    }
    char* end          = NULL;
    const char* word   = line->word[index];
    const double value = strtod(word, &end);
    // NaN fails both comparisons, so "nan" is refused.
    if ((end == word) || (*end != '\0') || !((value >= low) && (value <= high))) {
        return scenario_error(line, word, expected, error);
    }
    *out_value = value;
    return STATUS_OK;
}

status_t scenario_arguments(const scenario_line_t* const line, const size_t count, const char* const usage,
                            char error[SCENARIO_ERROR_MAX])
{
    if (line->word_count < count + 1U) {
        return scenario_error(line, "end of line", usage, error);
    }
    if (line->word_count > count + 1U) {
        return scenario_error(line, line->word[count + 1U], usage, error);
    }
    return STATUS_OK;
}

static bool is_actor(const char* const word)
{
    for (size_t i = 0U; i < ACTOR_COUNT; i++) {
        if (strcmp(word, actors[i]) == 0) {
            return true;
        }
    }
    return false;
}

/// Split text into at most `most` words, without the comment. Returns the number of words, most + 1 if there
/// are more.
static size_t split(char* const text, const char** const out_words, const size_t most)
{
    char* const comment = strchr(text, '#');
    if (comment != NULL) {
        *comment = '\0';
    }
    size_t count = 0U;
    char* rest   = NULL;
    for (char* word = strtok_r(text, SEPARATORS, &rest); word != NULL;
         word       = strtok_r(NULL, SEPARATORS, &rest)) {
        if (count == most) {
            return most + 1U;
        }
        out_words[count++] = word;
    }
    return count;
}

void scenario_words(scenario_line_t* const line)
{
    line->word_count = split(line->text, line->word, SCENARIO_WORDS_MAX);
}

status_t scenario_interpret(scenario_line_t* const line, const char* const actor, bool* const out_is_of_actor,
                            char error[SCENARIO_ERROR_MAX])
{
    const char* head[SCENARIO_WORDS_MAX + 2U];
    const size_t count = split(line->text, head, SCENARIO_WORDS_MAX + 2U);
    *out_is_of_actor   = false;
    if (count == 0U) {
        return STATUS_OK;
    }

    char* end           = NULL;
    const double time_s = strtod(head[0], &end);
    if ((*end != '\0') || !((time_s >= 0.0) && (time_s <= LATEST_S))) {
        return scenario_error(line, head[0], "a time in s, 0 to 1000000", error);
    }
    if ((count < 2U) || !is_actor(head[1])) {
        return scenario_error(line, (count < 2U) ? "end of line" : head[1],
                              "an actor: hand, fault, operator or ground", error);
    }
    *out_is_of_actor = strcmp(head[1], actor) == 0;
    if (!*out_is_of_actor) {
        return STATUS_OK; // The reader of that actor checks the rest.
    }
    if (count < 3U) {
        return scenario_error(line, "end of line", "a verb", error);
    }
    if (count > SCENARIO_WORDS_MAX + 2U) {
        return scenario_error(line, "too many words", "at most 11 arguments", error);
    }
    line->word_count = count - 2U;
    memcpy(line->word, &head[2], line->word_count * sizeof line->word[0]);
    line->time_ns = (uint64_t)llround(time_s * 1.0e9);
    return STATUS_OK;
}

static status_t read_lines(FILE* const file, scenario_line_t* const line, const char* const actor,
                           const scenario_taker_t take, void* const context, char error[SCENARIO_ERROR_MAX])
{
    uint64_t latest_ns = 0U;
    while (fgets(line->text, (int)sizeof line->text, file) != NULL) {
        line->line++;
        if ((strchr(line->text, '\n') == NULL) && (feof(file) == 0)) {
            return scenario_error(line, "a line too long", "at most 510 characters", error);
        }
        bool is_of_actor = false;
        status_t status  = scenario_interpret(line, actor, &is_of_actor, error);
        if ((status == STATUS_OK) && is_of_actor) {
            if (line->time_ns < latest_ns) {
                return scenario_error(line, "an earlier time", "times that do not decrease", error);
            }
            latest_ns = line->time_ns;
            status    = take(context, line, error);
        }
        if (status != STATUS_OK) {
            return status;
        }
    }
    return (ferror(file) == 0) ? STATUS_OK : scenario_error(line, strerror(errno), "a readable file", error);
}

status_t scenario_read(const char* const path, const char* const actor, const scenario_taker_t take,
                       void* const context, char error[SCENARIO_ERROR_MAX])
{
    error[0]   = '\0';
    FILE* file = fopen(path, "r");
    if (file == NULL) {
        (void)snprintf(error, SCENARIO_ERROR_MAX, "%s: %s", path, strerror(errno));
        return STATUS_NOT_FOUND;
    }
    scenario_line_t line  = {.path = path};
    const status_t status = read_lines(file, &line, actor, take, context, error);
    (void)fclose(file);
    return status;
}

static bool make_room(scenario_lines_t* const lines, const size_t octets)
{
    uint8_t* const records = lines->record;
    if (lines->count < lines->room) {
        return true;
    }
    if ((lines->next * 2U) > lines->room) {
        lines->count -= lines->next;
        memmove(records, &records[lines->next * octets], lines->count * octets);
        lines->next = 0U;
        return true;
    }
    const size_t room  = (lines->room == 0U) ? ROOM_FIRST : (lines->room * 2U);
    void* const bigger = realloc(lines->record, room * octets);
    if (bigger == NULL) {
        return false;
    }
    lines->record = bigger;
    lines->room   = room;
    return true;
}

static uint64_t time_of(const uint8_t* const record)
{
    uint64_t time_ns = 0U;
    memcpy(&time_ns, record, sizeof time_ns);
    return time_ns;
}

status_t scenario_insert(scenario_lines_t* const lines, const void* const record, const size_t octets)
{
    if (!make_room(lines, octets)) {
        return STATUS_EXHAUSTED;
    }
    uint8_t* const records = lines->record;
    size_t position        = lines->count;
    while ((position > lines->next) && (time_of(&records[(position - 1U) * octets]) > time_of(record))) {
        position--;
    }
    memmove(&records[(position + 1U) * octets], &records[position * octets],
            (lines->count - position) * octets);
    memcpy(&records[position * octets], record, octets);
    lines->count++;
    return STATUS_OK;
}
