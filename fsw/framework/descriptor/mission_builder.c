// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

#define EPOCH_FIRST_YEAR 1958U
#define EPOCH_LAST_YEAR 2093U

/// Returns the number of days since 1958-01-01, or UINT32_MAX if there is no such day.
static uint32_t days_of(const uint32_t year, const uint32_t month, const uint32_t day)
{
    static const uint16_t before[] = {0U,   31U,  59U,  90U,  120U, 151U, 181U,
                                      212U, 243U, 273U, 304U, 334U, 365U}; // Days of the year before a month.
    if ((year < EPOCH_FIRST_YEAR) || (year > EPOCH_LAST_YEAR) || (month < 1U) || (month > 12U)) {
        return UINT32_MAX;
    }
    const bool is_leap      = (year % 4U) == 0U; // True for all years that the epoch can have.
    const uint32_t leap_day = (is_leap && (month == 2U)) ? 1U : 0U;
    if ((day < 1U) || (day > ((before[month] - before[month - 1U]) + leap_day))) {
        return UINT32_MAX;
    }
    const uint32_t years = year - EPOCH_FIRST_YEAR; // (years + 1) / 4 leap days before: 1960 is the first.
    return (years * 365U) + ((years + 1U) / 4U) + before[month - 1U] + ((is_leap && (month > 2U)) ? 1U : 0U) +
           (day - 1U);
}

/// Read the numbers of a time like 2026-06-01T12:00:00, from year to second. False if malformed.
static bool read_numbers(const char* const words, uint32_t* const out_numbers)
{
    static const char shape[] = "0000-00-00T00:00:00";
    size_t number             = 0U;
    for (size_t i = 0U; i < sizeof shape; i++) { // The NUL at the end is compared, too.
        if (shape[i] != '0') {
            number++;
            if (words[i] != shape[i]) {
                return false;
            }
        } else if ((words[i] >= '0') && (words[i] <= '9')) {
            out_numbers[number] = (out_numbers[number] * 10U) + (uint32_t)(words[i] - '0');
        } else {
            return false;
        }
    }
    return true;
}

/// Returns the attribute `epoch` as TAI seconds since 1958-01-01.
static uint32_t read_epoch(source_t* const source)
{
    uint32_t time[6] = {0U, 0U, 0U, 0U, 0U, 0U};
    uint32_t days    = UINT32_MAX;
    if (read_numbers(descriptor_source_raw(source, "epoch"), time) && (time[3] < 24U) && (time[4] < 60U) &&
        (time[5] < 60U)) {
        days = days_of(time[0], time[1], time[2]);
    }
    if (days == UINT32_MAX) {
        descriptor_source_wrong(source, "epoch", "a TAI time like 2026-06-01T12:00:00, years 1958 to 2093");
        return 0U;
    }
    return (((((days * 24U) + time[3]) * 60U) + time[4]) * 60U) + time[5];
}

void descriptor_mission_builder_mission(source_t* const source)
{
    mission_descriptor_t* const mission = source->item;
    mission->epoch_s                    = read_epoch(source);
}

void descriptor_mission_builder_whole(source_t* const source)
{
    const mission_scope_t* const scope = descriptor_mission_builder_of(source)->scope;
    if (scope != NULL) {
        scope->element(source);
    }
}

void descriptor_mission_builder_end(source_t* const source)
{
    mission_descriptor_t* const mission = source->item;
    if (descriptor_mission_builder_of(source)->scope != NULL) {
        mission->configuration_hash = source->hash;
    } else {
        // Without a scope the names in rules and plans stay unresolved, so the model contains neither.
        mission->rule_count   = 0U;
        mission->plan_count   = 0U;
        mission->action_count = 0U;
    }
}
