// SPDX-License-Identifier: Apache-2.0
/// The port to an engine that runs on-board control procedures, whatever their language. It has slots; each
/// runs one procedure in small steps, and returns control with a call: a request of the procedure to its
/// host. The host answers and continues it. The engine knows neither packets nor clocks: what a procedure
/// does depends on its code, its arguments and the answers alone.
#ifndef PUS_CORE_PROCEDURE_PORT_H
#define PUS_CORE_PROCEDURE_PORT_H

#include "base/status.h"
#include "base/value.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    PUS_CALL_PAUSED,     ///< The budget is used up; continues with the next one.
    PUS_CALL_STEP,       ///< Step `number` (1..65535) begins.
    PUS_CALL_WAIT,       ///< For `seconds` (0 .. 1e9).
    PUS_CALL_SEND,       ///< Release a request of `apid`, `service`, `subtype` and `octets`; answer: result.
    PUS_CALL_GET,        ///< Value of parameter `number`; answer value, or missing.
    PUS_CALL_GET_NAMED,  ///< Value of the parameter with the name `text`; answer as for PUS_CALL_GET.
    PUS_CALL_EVENT,      ///< Raise event `number`; answer: result.
    PUS_CALL_PARAMETERS, ///< Communicated parameters, for `seconds` at most; answer values, or missing.
    PUS_CALL_ENDED,      ///< The procedure is done; the slot is free.
    PUS_CALL_FAILED      ///< It ended with an error, at line `number` (0: unknown): `text`; the slot is free.
} pus_call_kind_t;

typedef struct {
    pus_call_kind_t kind;
    uint32_t number;
    double seconds;
    uint16_t apid;
    uint8_t service;
    uint8_t subtype;
    bool does_wait;        ///< For a request: wait for its end.
    const uint8_t* octets; ///< Valid until the slot runs again.
    size_t size;
    const char* text; ///< NUL-terminated, never null; valid until the slot runs again.
} pus_call_t;

typedef enum {
    PUS_ANSWER_NONE,
    PUS_ANSWER_VERDICT, ///< Good if `code` is 0; else failure code and detail.
    PUS_ANSWER_VALUE,   ///< `bits` of `type`.
    PUS_ANSWER_VALUES,  ///< `octets`: count u8, then count x {layout u8, value}, as in TC[18,3].
    PUS_ANSWER_MISSING
} pus_answer_kind_t;

typedef struct {
    pus_answer_kind_t kind;
    uint16_t code;
    uint32_t detail;
    value_type_t type;
    uint64_t bits;
    const uint8_t* octets;
    size_t size;
} pus_answer_t;

typedef struct {
    void* context;
    uint16_t slots; ///< Procedures that run at the same time.
    /// Begin a procedure in a free slot. Its errors contain `name`; `arguments` as in PUS_ANSWER_VALUES,
    /// well- formed. Code and arguments are not needed after the call. STATUS_OK, STATUS_INVALID (no program:
    /// *out_call is PUS_CALL_FAILED; the slot stays free), STATUS_EXHAUSTED (no memory; the same).
    status_t (*start)(void* context, uint16_t slot, const char* name, const uint8_t* code, size_t size,
                      const uint8_t* arguments, size_t arguments_size, pus_call_t* out_call);
    /// Give a running slot a new budget [units of the engine], minus its overrun.
    void (*grant)(void* context, uint16_t slot, uint32_t budget);
    /// Units that a slot has used since it was given its budget; they may exceed it.
    uint32_t (*used)(void* context, uint16_t slot);
    /// Continue until the procedure calls. `answer` is the answer to its last call.
    void (*run)(void* context, uint16_t slot, const pus_answer_t* answer, pus_call_t* out_call);
    /// Abort a procedure at its present place. The slot is free.
    void (*kill)(void* context, uint16_t slot);
} pus_procedure_port_t;

#endif // PUS_CORE_PROCEDURE_PORT_H
