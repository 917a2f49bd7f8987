// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/permission_matrix.h"

#include "base/assertion.h"

#include <string.h>

/// Subtypes of ST[11] and ST[22] that request reports: about activities (by filter, by id, or all), and about
/// the states of sub-schedules and groups.
#define SCHEDULE_REPORTS                                                                                     \
    ((1ULL << 9U) | (1ULL << 11U) | (1ULL << 12U) | (1ULL << 14U) | (1ULL << 16U) | (1ULL << 17U) |          \
     (1ULL << 18U) | (1ULL << 26U))
#define STATE_OFFLINE 0U
#define STATE_PRE_OPERATIONAL 3U
#define STATE_OPERATIONAL 5U
#define STATE_ERROR_OPERATIONAL 6U

/// True for requests that are always permitted: those for reports and values, those of the test service, and
/// those that close a link or shut the mission down.
static bool is_always_permitted(const uint8_t service, const uint8_t subtype)
{
    // Service, and a bit set of its subtypes: 1 << subtype.
    static const struct {
        uint8_t service;
        uint64_t subtypes;
    } always[] = {
        {3U, (1ULL << 9U) | (1ULL << 11U) | (1ULL << 27U) | (1ULL << 28U) | (1ULL << 33U) | (1ULL << 34U) |
                 (1ULL << 40U)},
        {4U, 1ULL << 8U},
        {5U, 1ULL << 7U},
        {11U, SCHEDULE_REPORTS},
        {12U, (1ULL << 8U) | (1ULL << 10U) | (1ULL << 13U) | (1ULL << 25U) | (1ULL << 27U)},
        {14U, (1ULL << 3U) | (1ULL << 7U) | (1ULL << 11U) | (1ULL << 15U)},
        {15U, (1ULL << 5U) | (1ULL << 12U) | (1ULL << 18U) | (1ULL << 22U) | (1ULL << 35U) | (1ULL << 37U) |
                  (1ULL << 39U)},
        {17U, UINT64_MAX},
        {18U, 1ULL << 8U},
        {19U, (1ULL << 6U) | (1ULL << 10U)},
        {20U, (1ULL << 1U) | (1ULL << 6U)},
        {21U, (1ULL << 6U) | (1ULL << 9U) | (1ULL << 11U)},
        {22U, SCHEDULE_REPORTS},
        {23U, (1ULL << 3U) | (1ULL << 7U) | (1ULL << 12U)},
        {129U, 1ULL << 4U},
        {130U, (1ULL << 1U) | (1ULL << 7U) | (1ULL << 8U)},
        {131U, (1ULL << 5U) | (1ULL << 8U) | (1ULL << 10U)},
    };
    for (size_t i = 0U; i < (sizeof always / sizeof always[0]); i++) {
        if (always[i].service == service) {
            return (subtype < 64U) && (((always[i].subtypes >> subtype) & 1U) != 0U);
        }
    }
    return false;
}

/// True for a request for OFFLINE or ERROR_OPERATIONAL, or for a rest state not above the present one.
static bool is_downwards(const permission_request_t* const request)
{
    if ((request->service != 129U) || (request->subtype != 1U)) {
        return false;
    }
    if ((request->number == STATE_OFFLINE) || (request->number == STATE_ERROR_OPERATIONAL)) {
        return true;
    }
    return (request->number >= STATE_PRE_OPERATIONAL) && (request->state <= STATE_OPERATIONAL) &&
           (request->number <= request->state);
}

static bool is_selected(const mission_rule_t* const rule, const permission_request_t* const request)
{
    if (rule->is_any) {
        return true;
    }
    if (rule->is_numbered) {
        return rule->number == request->number;
    }
    return (request->select != NULL) && (strcmp(rule->select, request->select) == 0);
}

static bool has_bit(const uint16_t bits, const uint8_t index)
{
    return (index < 16U) && (((bits >> index) & 1U) != 0U);
}

status_t supervisor_permission_check(const mission_descriptor_t* const mission,
                                     const permission_request_t* const request, int* const out_rule)
{
    FSW_ASSERT((mission != NULL) && (request != NULL) && (out_rule != NULL));
    *out_rule = PERMISSION_RULE_ALWAYS;
    if (is_always_permitted(request->service, request->subtype) || is_downwards(request)) {
        return STATUS_OK;
    }
    for (uint16_t i = 0U; i < mission->rule_count; i++) {
        const mission_rule_t* const rule = &mission->rules[i];
        if ((rule->service == request->service) &&
            ((rule->subtype == 0U) || (rule->subtype == request->subtype)) &&
            ((rule->target == MISSION_ANY_TARGET) || (rule->target == request->target)) &&
            has_bit(rule->modes, request->mode) && has_bit(rule->states, request->state) &&
            is_selected(rule, request)) {
            *out_rule = (int)i;
            return STATUS_OK;
        }
    }
    *out_rule = PERMISSION_RULE_NONE;
    return STATUS_FORBIDDEN;
}
