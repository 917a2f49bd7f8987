// SPDX-License-Identifier: Apache-2.0
// Proves: without a rule that allows it, every request outside the built-in set is forbidden; this set
//     has exactly the requests that is_read and is_down list: no function, and no request for a higher state
//     except ERROR_OPERATIONAL. A rule allows only requests that have its service, subtype, target, mode,
//     state and selector, and a request that matches a rule is allowed.
// Bounds: every request, with a function name or without; every mission with 0 to 2 rules, which are examined
//     one after the other.
// Replaced: strcmp decides arbitrarily, for the name of each rule, whether it equals the name in the request.
// Sources: fsw/supervisor/permission_matrix.c
// Options: --unwind 18
// Fault: fsw/supervisor/permission_matrix.c
//   - *out_rule = PERMISSION_RULE_NONE;
//   + *out_rule = PERMISSION_RULE_NONE; return STATUS_OK;
// Fault: fsw/supervisor/permission_matrix.c
//   - (request->number <= request->state);
//   + (request->number <= (request->state + 1U));
// Fault: fsw/supervisor/permission_matrix.c
//   - return (request->number >= STATE_PRE_OPERATIONAL) && (request->state <= STATE_OPERATIONAL) &&
//   + return (request->number >= STATE_PRE_OPERATIONAL) &&
// Fault: fsw/supervisor/permission_matrix.c
//   - {131U, (1ULL << 5U) | (1ULL << 8U) | (1ULL << 10U)},
//   + {131U, (1ULL << 1U) | (1ULL << 5U) | (1ULL << 8U) | (1ULL << 10U)},
// Fault: fsw/supervisor/permission_matrix.c
//   - return (index < 16U) && (((bits >> index) & 1U) != 0U);
//   + return (bits >> (index & 15U)) != 0U;
#include "fsw/supervisor/permission_matrix.h"
#include "test/proof/proof.h"

#define RULES 2U

static mission_rule_t rules[RULES];
static mission_descriptor_t mission = {.rules = rules};
static bool is_named[RULES];
static const char names[RULES + 1U] = "01r";

int strcmp(const char* one, const char* other)
{
    PROVE((other == &names[RULES]) && ((one == &names[0]) || (one == &names[1])),
          "the name of a rule is compared with that of the request");
    return is_named[one == &names[1]] ? 0 : 1;
}

static bool selects(const mission_rule_t* const rule, const permission_request_t* const request)
{
    return rule->is_any || (rule->is_numbered && (rule->number == request->number)) ||
           (!rule->is_numbered && (request->select != NULL) && is_named[rule == &rules[1]]);
}

static bool allows(const mission_rule_t* const rule, const permission_request_t* const request)
{
    return (rule->service == request->service) &&
           ((rule->subtype == 0U) || (rule->subtype == request->subtype)) &&
           ((rule->target == MISSION_ANY_TARGET) || (rule->target == request->target)) &&
           (request->mode < 16U) && (((1U << request->mode) & rule->modes) != 0U) && (request->state < 16U) &&
           (((1U << request->state) & rule->states) != 0U) && selects(rule, request);
}

/// Requests for reports, reads, tests, to close a link, and to shut the mission down.
static bool is_read(const uint8_t service, const uint8_t n)
{
    switch (service) {
    case 3U:
        return (n == 9U) || (n == 11U) || (n == 27U) || (n == 28U) || (n == 33U) || (n == 34U) || (n == 40U);
    case 4U:
    case 18U:
        return n == 8U;
    case 5U:
        return n == 7U;
    case 11U:
    case 22U:
        return (n == 9U) || (n == 11U) || (n == 12U) || (n == 14U) || ((n >= 16U) && (n <= 18U)) ||
               (n == 26U);
    case 12U:
        return (n == 8U) || (n == 10U) || (n == 13U) || (n == 25U) || (n == 27U);
    case 14U:
        return (n == 3U) || (n == 7U) || (n == 11U) || (n == 15U);
    case 15U:
        return (n == 5U) || (n == 12U) || (n == 18U) || (n == 22U) || (n == 35U) || (n == 37U) || (n == 39U);
    case 17U:
        return n < 64U;
    case 19U:
        return (n == 6U) || (n == 10U);
    case 20U:
        return (n == 1U) || (n == 6U);
    case 21U:
        return (n == 6U) || (n == 9U) || (n == 11U);
    case 23U:
        return (n == 3U) || (n == 7U) || (n == 12U);
    case 129U:
        return n == 4U;
    case 130U:
        return (n == 1U) || (n == 7U) || (n == 8U);
    case 131U:
        return (n == 5U) || (n == 8U) || (n == 10U);
    default:
        return false;
    }
}

/// A request for OFFLINE, ERROR_OPERATIONAL, or from a rest state for one that is not higher.
static bool is_down(const permission_request_t* const request)
{
    return (request->service == 129U) && (request->subtype == 1U) &&
           ((request->number == 0U) || (request->number == 6U) ||
            ((request->number >= 3U) && (request->number <= request->state) && (request->state <= 5U)));
}

void proof(void)
{
    is_named[0] = nondet_bool();
    is_named[1] = nondet_bool();
    for (unsigned i = 0U; i < RULES; i++) {
        mission_rule_t rule;
        rule.is_any      = nondet_bool();
        rule.is_numbered = nondet_bool();
        rule.select      = (rule.is_any || rule.is_numbered) ? NULL : &names[i];
        rules[i]         = rule;
    }
    mission.rule_count = nondet_u16();
    ASSUME(mission.rule_count <= RULES);
    permission_request_t request;
    request.select = nondet_bool() ? &names[RULES] : NULL;

    int rule              = 0;
    const status_t status = supervisor_permission_check(&mission, &request, &rule);
    PROVE((status == STATUS_OK) || (status == STATUS_FORBIDDEN), "allowed or forbidden");
    PROVE((status == STATUS_OK) == (rule != PERMISSION_RULE_NONE),
          "an allowed request has a rule or is in the built-in set");
    PROVE((rule == PERMISSION_RULE_ALWAYS) ==
              (is_read(request.service, request.subtype) || is_down(&request)),
          "the built-in set has exactly the requests that read, test, close, shut down or go down");
    PROVE(IMPLIES((rule != PERMISSION_RULE_NONE) && (rule != PERMISSION_RULE_ALWAYS),
                  (rule >= 0) && (rule < (int)mission.rule_count)),
          "the rule exists");
    for (int i = 0; i < (int)RULES; i++) {
        PROVE(IMPLIES(rule == i, allows(&rules[i], &request)), "the reported rule allows the request");
        PROVE(IMPLIES((status == STATUS_FORBIDDEN) && (i < (int)mission.rule_count),
                      !allows(&rules[i], &request)),
              "no rule allows a forbidden request");
    }
}
