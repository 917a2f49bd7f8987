// SPDX-License-Identifier: Apache-2.0
/// Time of a cycle in which eight procedures use up their budgets. All eight run the same code: that which
/// takes the longest of all in test/support/hostile_procedures.h, whose operations take more time than they
/// are charged. The value is microseconds per cycle of 10 ms. Baseline: eight procedures that spend the same
/// budgets on plain additions.
#include "fsw/procedures/procedure_engine.h"
#include "fsw/supervisor/services/procedures.h"
#include "test/bench/measure.h"
#include "test/support/hostile_procedures.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#define SLOTS SPACECRAFT_PROCEDURE_SLOTS
#define WARM_UP 200U  // Cycles in which a procedure reaches its loop.
#define MEASURED 300U // Cycles in which the times are compared.
#define NS_PER_US 1000.0
#define NS_PER_S 1e9

typedef struct {
    procedure_engine_t engine;
    pus_procedure_port_t port;
    procedure_slot_t slots[SLOTS];
    uint64_t memory[SLOTS * (SPACECRAFT_PROCEDURE_OCTETS / sizeof(uint64_t))];
    uint8_t map[SLOTS * PROCEDURE_BLOCKS(SPACECRAFT_PROCEDURE_OCTETS)];
} runner_t;

static runner_t hostile;
static runner_t plain;

static void begin(runner_t* const runner, const hostile_procedure_t* const procedure)
{
    static const uint8_t none[] = {0};
    static char code[HOSTILE_CODE_MAX];
    procedure_engine_init(&runner->engine, runner->slots, SLOTS, runner->memory, SPACECRAFT_PROCEDURE_OCTETS,
                          runner->map);
    runner->port = procedure_engine_port(&runner->engine);
    (void)hostile_code(procedure, code);
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        pus_call_t call;
        if (runner->port.start(runner->port.context, slot, "HOSTILE", (const uint8_t*)code, strlen(code),
                               none, 1U, &call) != STATUS_OK) {
            abort();
        }
    }
}

static void cycle(runner_t* const runner)
{
    const pus_answer_t answer = {.kind = PUS_ANSWER_MISSING};
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        pus_call_t call = {.kind = PUS_CALL_PAUSED};
        runner->port.grant(runner->port.context, slot, SPACECRAFT_PROCEDURE_BUDGET);
        do {
            runner->port.run(runner->port.context, slot, &answer, &call);
        } while ((call.kind != PUS_CALL_PAUSED) && (call.kind != PUS_CALL_FAILED));
        if (call.kind == PUS_CALL_FAILED) {
            abort();
        }
    }
}

static void cycle_hostile(void)
{
    cycle(&hostile);
}

static void cycle_plain(void)
{
    cycle(&plain);
}

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + ((double)now.tv_nsec / NS_PER_S);
}

static double time_of(const hostile_procedure_t* const procedure)
{
    begin(&hostile, procedure);
    for (unsigned i = 0U; i < WARM_UP; i++) {
        cycle(&hostile);
    }
    const double start = seconds();
    for (unsigned i = 0U; i < MEASURED; i++) {
        cycle(&hostile);
    }
    return seconds() - start;
}

int main(void)
{
    const hostile_procedure_t* worst = &hostile_procedures[0];
    double longest                   = 0.0;
    for (size_t i = 0U; i < HOSTILE_PROCEDURES; i++) {
        const double taken = time_of(&hostile_procedures[i]);
        if (taken > longest) {
            longest = taken;
            worst   = &hostile_procedures[i];
        }
    }
    (void)fprintf(stderr, "the most expensive of %zu procedures: %s\n", HOSTILE_PROCEDURES, worst->name);
    begin(&plain, &hostile_procedures[0]); // The procedure of plain additions.
    begin(&hostile, worst);
    for (unsigned i = 0U; i < WARM_UP; i++) {
        cycle(&plain);
        cycle(&hostile);
    }
    measure_compare("procedures_8_worst", cycle_hostile, cycle_plain, 1.0, "us", NS_PER_US);
    return 0;
}
