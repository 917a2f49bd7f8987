// SPDX-License-Identifier: Apache-2.0
/// What a procedure's work costs, in units that depend on the program alone and never on a clock. Internal to
/// fsw/procedures.
///
/// A unit stands for about 20 ns of a processor of 2024; a plain instruction costs one. The count hook sees
/// each instruction before it is done and charges what that one may take at worst: by its operation code,
/// and by the longest text, the largest table and the deepest stack this procedure has ever had. So an
/// instruction is done only in a cycle whose budget has paid for it. Functions of the library charge for the
/// octets and values they touch, before they touch them (procedure_pay). Memory is charged when it is taken.
///
/// What is charged depends on the program, not on the processor, the time or the addresses of a run, with
/// one exception: how often a table is rebuilt from which text keys are removed and to which others are
/// added depends on the interpreter's hash seed. So rebuilding is charged when a table becomes larger than
/// any before; the rest only beyond PROCEDURE_GRACE per budget, which is more than such a program needs.
///
/// The operation code is read where the interpreter (5.4) keeps its program counter. One that is unknown
/// costs PROCEDURE_ACT_MAX, so another interpreter makes procedures slow and not expensive.
#ifndef FSW_PROCEDURES_PROCEDURE_COST_H
#define FSW_PROCEDURES_PROCEDURE_COST_H

#include "fsw/procedures/procedure_engine.h"

#include <lua5.4/lua.h>

#define PROCEDURE_ACT_MAX 2048U ///< What one instruction or call may cost; a call that costs more fails.
#define PROCEDURE_GRACE 256U    ///< Rebuilding of tables in a budget that costs nothing.
#define PROCEDURE_LIST_MAX                                                                                   \
    32752U ///< Largest list or stack of a running procedure; 1024 values as it grows [octets].
#define PROCEDURE_NODES_MAX 256U ///< Most keys in a table that are not numbers in sequence.

/// The count hook; every 1 instruction.
void procedure_cost_hook(lua_State* state, lua_Debug* record);
/// Charge a call of a function of the library. It fails if it costs more than PROCEDURE_ACT_MAX, and waits
/// for the next budget if this one does not cover it. Returns what `body` returns.
int procedure_pay(lua_State* state, uint64_t price, lua_KFunction body, lua_KContext context);
/// True if the budget is used up: what goes on piece by piece must yield then.
bool procedure_must_wait(lua_State* state);
/// Charge what has been done already.
void procedure_charge(procedure_slot_t* slot, uint64_t price);
/// Price of finding one key in a table, at worst.
uint32_t procedure_price_of_key(const procedure_slot_t* slot);
/// Note that a text with NULs in it may exist: comparing such texts is expensive.
void procedure_note_text(lua_State* state, int index);
/// Whether the interpreter may have this memory, and note and charge it. `tag` is its kind of object, or 0.
bool procedure_may_take(procedure_slot_t* slot, const void* block, size_t before, size_t after);
/// Charge a collection of all garbage, as it follows memory refused.
void procedure_charge_collection(procedure_slot_t* slot);

#endif // FSW_PROCEDURES_PROCEDURE_COST_H
