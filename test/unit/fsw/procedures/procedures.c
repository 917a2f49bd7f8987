// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/procedures/procedures.h"

#include "pus/core/tailoring.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define MANY_BUDGETS 20000U

host_t host;

static uint64_t memory[HOST_SLOTS * HOST_MEMORY / sizeof(uint64_t)];
static uint8_t map[HOST_SLOTS * PROCEDURE_BLOCKS(HOST_MEMORY)];

void host_start(void)
{
    memset(&host, 0, sizeof host);
    procedure_engine_init(&host.engine, host.slots, HOST_SLOTS, memory, HOST_MEMORY, map);
    host.port = procedure_engine_port(&host.engine);
}

status_t host_begin(const char* const code)
{
    static const uint8_t none[] = {0};
    host.port.kill(host.port.context, 0U);
    host.pauses = 0U;
    host.worst  = 0U;
    host.log[0] = '\0';
    return host.port.start(host.port.context, 0U, "TEST", (const uint8_t*)code, strlen(code), none, 1U,
                           &host.call);
}

/// Returns the answer to a call: a request that waits for its completion gets a failure; an event is known if
/// its number is below 1000.
static pus_answer_t answer_to(const pus_call_t* const call)
{
    static const uint8_t list[] = {2, 1, 0x12, 0x34, 10, 1}; // Two values: UINT16 0x1234, BOOL true.
    switch (call->kind) {
    case PUS_CALL_SEND:
        return (pus_answer_t){.kind = PUS_ANSWER_VERDICT,
                              .code = (uint16_t)(call->does_wait ? PUS_FAILURE_NO_ANSWER : PUS_FAILURE_NONE),
                              .detail = 7U};
    case PUS_CALL_EVENT:
        return (pus_answer_t){.kind = PUS_ANSWER_VERDICT,
                              .code = (uint16_t)((call->number < 1000U) ? 0U : 1U)};
    case PUS_CALL_GET:
        return (call->number == 0U)
                   ? (pus_answer_t){.kind = PUS_ANSWER_MISSING}
                   : (pus_answer_t){.kind = PUS_ANSWER_VALUE, .type = VALUE_INT16, .bits = 0xFFFEU};
    case PUS_CALL_GET_NAMED:
        return (pus_answer_t){.kind = PUS_ANSWER_VALUE, .type = VALUE_UINT8, .bits = strlen(call->text)};
    case PUS_CALL_PARAMETERS:
        return (pus_answer_t){.kind = PUS_ANSWER_VALUES, .octets = list, .size = sizeof list};
    default:
        return (pus_answer_t){.kind = PUS_ANSWER_NONE};
    }
}

static void note(const pus_call_t* const call)
{
    static const char* const names[] = {"paused", "step",  "wait",       "send",  "get",
                                        "named",  "event", "parameters", "ended", "failed"};
    char line[160];
    (void)snprintf(line, sizeof line, "%s %lu %s;", names[call->kind], (unsigned long)call->number,
                   call->text);
    if ((strlen(host.log) + strlen(line)) < sizeof host.log) {
        strcat(host.log, line);
    }
}

bool host_run(const unsigned budgets)
{
    pus_answer_t answer = {.kind = PUS_ANSWER_NONE};
    for (unsigned i = 0U; i < budgets;) {
        if (host.call.kind == PUS_CALL_PAUSED) {
            host.port.grant(host.port.context, 0U, HOST_BUDGET);
            i++;
        }
        host.port.run(host.port.context, 0U, &answer, &host.call);
        if ((host.call.kind == PUS_CALL_ENDED) || (host.call.kind == PUS_CALL_FAILED)) {
            note(&host.call);
            return true;
        }
        answer = answer_to(&host.call);
        if (host.call.kind == PUS_CALL_PAUSED) {
            host.worst = (host.slots[0].spent > host.worst) ? host.slots[0].spent : host.worst;
            host.pauses++;
        } else {
            note(&host.call);
        }
    }
    return false;
}

void expect_events(const char* const code, const char* const events)
{
    char found[512] = "";
    host.call       = (pus_call_t){.kind = PUS_CALL_PAUSED};
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, host_begin(code), host.call.text);
    TEST_ASSERT_TRUE_MESSAGE(host_run(MANY_BUDGETS), "the procedure does not end within MANY_BUDGETS");
    TEST_ASSERT_EQUAL_MESSAGE(PUS_CALL_ENDED, host.call.kind, host.call.text);
    for (const char* place = strstr(host.log, "event "); place != NULL; place = strstr(place, "event ")) {
        place += 6U;
        const size_t size = strcspn(place, " ");
        (void)strncat(found, (found[0] == '\0') ? "" : " ", 2U);
        (void)strncat(found, place, size);
    }
    TEST_ASSERT_EQUAL_STRING(events, found);
}

void expect_error(const char* const code, const char* const part)
{
    host.call             = (pus_call_t){.kind = PUS_CALL_PAUSED};
    const status_t status = host_begin(code);
    if (status == STATUS_OK) {
        TEST_ASSERT_TRUE_MESSAGE(host_run(MANY_BUDGETS), "the procedure does not end within MANY_BUDGETS");
    }
    TEST_ASSERT_EQUAL_MESSAGE(PUS_CALL_FAILED, host.call.kind, code);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(host.call.text, part), host.call.text);
    TEST_ASSERT_FALSE(host.slots[0].is_running);
}
