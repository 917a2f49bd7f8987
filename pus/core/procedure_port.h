// SPDX-License-Identifier: Apache-2.0
/// The port to an engine that runs on-board control procedures, in any language. The engine has slots. Each
/// slot runs one procedure in small steps and returns control with a call: a request of the procedure to the
/// host (ST[18]). The host answers the call and continues the procedure. The engine has no access to packets
/// or clocks: a procedure depends only on its code, its arguments and the answers.
#ifndef PUS_CORE_PROCEDURE_PORT_H
#define PUS_CORE_PROCEDURE_PORT_H

#include "base/status.h"
#include "base/value.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    PUS_CALL_PAUSED,     ///< The budget is used up; the procedure continues when the slot gets a new budget.
    PUS_CALL_STEP,       ///< Step `number` (1..65535) begins.
    PUS_CALL_WAIT,       ///< Wait for `seconds` (0 .. 1e9).
    PUS_CALL_SEND,       ///< Release a request of `apid`, `service`, `subtype`, `octets`; answer: VERDICT.
    PUS_CALL_GET,        ///< Get the value of parameter `number`; answer: VALUE or MISSING.
    PUS_CALL_GET_NAMED,  ///< Get the value of the parameter with the name `text`; answer as PUS_CALL_GET.
    PUS_CALL_EVENT,      ///< Raise event `number`; answer: VERDICT.
    PUS_CALL_PARAMETERS, ///< Wait up to `seconds` for parameters (TC[18,7]); answer: VALUES or MISSING.
    PUS_CALL_ENDED,      ///< The procedure has ended; the slot is free.
    PUS_CALL_FAILED      ///< Ended with error `text` at line `number` (0: unknown); the slot is free.
} pus_call_kind_t;

typedef struct {
    pus_call_kind_t kind;
    uint32_t number;
    double seconds;
    uint16_t apid;
    uint8_t service;
    uint8_t subtype;
    bool does_wait;        ///< PUS_CALL_SEND: the procedure waits for the end of the request.
    const uint8_t* octets; ///< Valid until the slot runs again.
    size_t size;
    const char* text; ///< NUL-terminated, never null; valid until the slot runs again.
} pus_call_t;

typedef enum {
    PUS_ANSWER_NONE,
    PUS_ANSWER_VERDICT, ///< Success if `code` is 0; else failure code and detail.
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
    uint16_t slots; ///< Number of procedures that can run at the same time.
    /// Begin a procedure in a free slot. Its error messages contain `name`. `arguments` are well-formed, as
    /// for PUS_ANSWER_VALUES. Code and arguments are not needed after the call. STATUS_OK; STATUS_INVALID
    /// (not a program) or STATUS_EXHAUSTED (no memory): *out_call is PUS_CALL_FAILED, and the slot stays
    /// free.
    status_t (*start)(void* context, uint16_t slot, const char* name, const uint8_t* code, size_t size,
                      const uint8_t* arguments, size_t arguments_size, pus_call_t* out_call);
    /// Give a running slot a new budget [units of the engine], from which the overrun of the last budget is
    /// subtracted.
    void (*grant)(void* context, uint16_t slot, uint32_t budget);
    /// Units that a slot has used since it was given its budget; they may exceed it.
    uint32_t (*used)(void* context, uint16_t slot);
    /// Continue until the next call of the procedure. `answer` is the answer to its last call.
    void (*run)(void* context, uint16_t slot, const pus_answer_t* answer, pus_call_t* out_call);
    /// Abort a procedure immediately. The slot is free.
    void (*kill)(void* context, uint16_t slot);
} pus_procedure_port_t;

#endif // PUS_CORE_PROCEDURE_PORT_H
