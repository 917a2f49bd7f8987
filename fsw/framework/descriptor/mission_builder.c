// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

#define EPOCH_FIRST_YEAR 1958U
#define EPOCH_LAST_YEAR 2093U

mission_builder_t* mission_builder_of(const source_t* const source)
{
    return source->builder;
}

/// Number of `count` digits, or UINT32_MAX.
static uint32_t digits(const char* const words, const uint32_t count)
{
    uint32_t number = 0U;
    for (uint32_t i = 0U; i < count; i++) {
        if ((words[i] < '0') || (words[i] > '9')) {
            return UINT32_MAX;
        }
        number = (number * 10U) + (uint32_t)(words[i] - '0');
    }
    return number;
}

static bool is_leap(const uint32_t year)
{
    return ((year % 4U) == 0U) && (((year % 100U) != 0U) || ((year % 400U) == 0U));
}

/// Days from 1958-01-01, or UINT32_MAX if there is no such day.
static uint32_t days_of(const uint32_t year, const uint32_t month, const uint32_t day)
{
    static const uint8_t lengths[] = {31U, 28U, 31U, 30U, 31U, 30U, 31U, 31U, 30U, 31U, 30U, 31U};
    if ((year < EPOCH_FIRST_YEAR) || (year > EPOCH_LAST_YEAR) || (month < 1U) || (month > 12U) ||
        (day < 1U) || (day > (lengths[month - 1U] + (((month == 2U) && is_leap(year)) ? 1U : 0U)))) {
        return UINT32_MAX;
    }
    uint32_t days = day - 1U;
    for (uint32_t y = EPOCH_FIRST_YEAR; y < year; y++) {
        days += is_leap(y) ? 366U : 365U;
    }
    for (uint32_t m = 1U; m < month; m++) {
        days += lengths[m - 1U] + (((m == 2U) && is_leap(year)) ? 1U : 0U);
    }
    return days;
}

/// TAI seconds since 1958-01-01 of a time like 2026-06-01T12:00:00.
static uint32_t read_epoch(source_t* const source)
{
    static const char shape[] = "0000-00-00T00:00:00";
    const char* const words   = source_raw(source, "epoch");
    bool is_right             = (strlen(words) == (sizeof shape - 1U));
    for (size_t i = 0U; is_right && (i < (sizeof shape - 1U)); i++) {
        is_right = (shape[i] == '0') || (shape[i] == words[i]);
    }
    if (is_right) {
        const uint32_t days   = days_of(digits(words, 4U), digits(&words[5], 2U), digits(&words[8], 2U));
        const uint32_t hour   = digits(&words[11], 2U);
        const uint32_t minute = digits(&words[14], 2U);
        const uint32_t second = digits(&words[17], 2U);
        if ((days != UINT32_MAX) && (hour < 24U) && (minute < 60U) && (second < 60U)) {
            return (((((days * 24U) + hour) * 60U) + minute) * 60U) + second;
        }
    }
    (void)source_wrong(source, "epoch", "a TAI time like 2026-06-01T12:00:00, years 1958 to 2093");
    return 0U;
}

void mission_builder_mission(source_t* const source)
{
    mission_descriptor_t* const mission = source->item;
    mission->epoch_s                    = read_epoch(source);
}

void mission_builder_listed(source_t* const source)
{
    mission_builder_of(source)->power_seen = 0U;
}

void mission_builder_power(source_t* const source)
{
    mission_builder_t* const builder     = source->builder;
    mission_subsystem_t* const subsystem = source->item;
    uint8_t state                        = 0U;
    if (descriptor_state_of(source_raw(source, "state"), &state) != STATUS_OK) {
        (void)source_wrong(source, "state", "the name of a state");
    } else if ((((uint32_t)builder->power_seen >> state) & 1U) != 0U) {
        (void)source_wrong(source, "state", "each state once");
    } else {
        builder->power_seen       = (uint16_t)(builder->power_seen | (1U << state));
        subsystem->power_w[state] = source_value(source, 1U);
    }
}

void mission_builder_modes_end(source_t* const source)
{
    mission_descriptor_t* const mission = source->item;
    uint32_t initial                    = 0U;
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        if (mission->modes[i].is_initial) {
            mission->initial_mode = mission->modes[i].id;
            initial++;
        }
    }
    if (initial != 1U) {
        (void)source_fail(source, source->line, "exactly one <Mode> must have initial=\"true\"");
    }
}

void mission_builder_lists(source_t* const source)
{
    const mission_descriptor_t* const mission = source->item;
    if (((mission->subsystem_count == 0U) || (mission->mode_count == 0U)) &&
        source_fail(source, source->line, "expected <Subsystems> and <Modes>, not empty, before <")) {
        text_add(source->error, source->open[source->depth - 1U]->name);
        text_add(source->error, ">");
    }
}

void mission_builder_end(source_t* const source)
{
    mission_descriptor_t* const mission = source->item;
    mission->configuration_hash         = source->hash;
}
