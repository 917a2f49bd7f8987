// SPDX-License-Identifier: Apache-2.0
/// Functions of the language and of the host that a procedure can use. Internal to fsw/procedures.
#ifndef FSW_PROCEDURES_PROCEDURE_SANDBOX_H
#define FSW_PROCEDURES_PROCEDURE_SANDBOX_H

#include "fsw/procedures/procedure_engine.h"

#include <lua5.4/lua.h>

/// Returns the slot of a state to which procedure_slot_bind has bound one.
procedure_slot_t* procedure_slot_of(lua_State* state);
void procedure_slot_bind(lua_State* state, procedure_slot_t* slot);
/// Replace the globals by the sandbox. It may raise errors, so it must be called in protected mode.
void procedure_sandbox_open(lua_State* state);
/// Add the functions that call the host (procedure_calls.c) to the table on top of the stack.
void procedure_calls_open(lua_State* state);
/// Functions of the interpreter's library that are used unchanged, each with a price (procedure_library.c).
typedef enum {
    PROCEDURE_BASE,
    PROCEDURE_STRINGS,
    PROCEDURE_MATH
} procedure_library_t;
/// Copy the functions of a library from the table on top of the stack into the table below it, and pop the
/// upper one.
void procedure_library_copy(lua_State* state, procedure_library_t library);
/// Returns the lines of the part of the library that is written in Lua, with null at the end. This code
/// must be called with the table of globals as argument.
const char* const* procedure_prelude(void);
/// Push the values that `octets` contains (PUS_ANSWER_VALUES). May raise an error.
void procedure_push_values(lua_State* state, const uint8_t* octets, size_t size);
void procedure_push_value(lua_State* state, value_type_t type, uint64_t bits);

#endif // FSW_PROCEDURES_PROCEDURE_SANDBOX_H
