// SPDX-License-Identifier: Apache-2.0
/// A host for procedures under test: it answers every call at once and writes the call down as text.
#ifndef TEST_UNIT_FSW_PROCEDURES_PROCEDURES_H
#define TEST_UNIT_FSW_PROCEDURES_PROCEDURES_H

#include "fsw/procedures/procedure_engine.h"

#define HOST_SLOTS 2U
#define HOST_MEMORY (256U * 1024U)
#define HOST_BUDGET 1000U
#define HOST_LOG_MAX 8192U

typedef struct {
    procedure_engine_t engine;
    pus_procedure_port_t port;
    procedure_slot_t slots[HOST_SLOTS];
    pus_call_t call;        ///< The last call.
    unsigned pauses;        ///< Budgets used up since the start.
    uint32_t worst;         ///< Largest number of units spent in one budget.
    char log[HOST_LOG_MAX]; ///< Each call as `kind number text;`.
} host_t;

extern host_t host;

void host_start(void);
/// Begin a procedure in slot 0, without arguments.
status_t host_begin(const char* code);
/// Run the procedure and answer its calls, for at most `budgets` budgets. Returns true if it has ended, with
/// or without error.
bool host_run(unsigned budgets);
/// Run a procedure from its beginning. Expect that it ends without error and has raised exactly these events
/// ("1 2 3").
void expect_events(const char* code, const char* events);
/// Expect that the procedure fails with a message that contains this text.
void expect_error(const char* code, const char* part);

#endif // TEST_UNIT_FSW_PROCEDURES_PROCEDURES_H
