// SPDX-License-Identifier: Apache-2.0
/// Cost of a procedure's work, in units that depend only on its program, not on a clock. A running procedure
/// has one budget of units in each cycle (docs/services/st18.md). Private to fsw/procedures.
///
/// A unit is about 20 ns of a processor of 2024; a plain instruction costs one. The count hook charges the
/// worst-case cost of each instruction before it is executed: by its operation code, and by the longest text,
/// the largest table and the deepest stack that this procedure has had so far. Library functions charge for
/// octets and values before they use them (procedure_pay). Memory is charged when it is allocated.
///
/// One exception: if text keys are removed from a table and others are added, the hash seed of the
/// interpreter decides how often the table is rebuilt. Therefore rebuilding is charged when a table becomes
/// larger than any table before; other rebuilding is charged only beyond PROCEDURE_GRACE units per cycle,
/// which is more than such a program needs.
///
/// The operation code is read at the address in the program counter of Lua 5.4. An unknown code costs
/// PROCEDURE_ACT_MAX.
#ifndef FSW_PROCEDURES_PROCEDURE_COST_H
#define FSW_PROCEDURES_PROCEDURE_COST_H

#include "fsw/procedures/procedure_engine.h"

#include <lua5.4/lua.h>

#define PROCEDURE_ACT_MAX 2048U ///< Largest cost of one instruction or call; a call that costs more fails.
#define PROCEDURE_GRACE 256U    ///< Units of table rebuilding per cycle that are not charged.
/// Largest list of values or stack of a running procedure [octets]. A list that grows doubles its size, so it
/// ends at 1024 values.
#define PROCEDURE_LIST_MAX 32752U
#define PROCEDURE_NODES_MAX 256U ///< Largest number of keys in a table that are not consecutive numbers.

/// The count hook of the interpreter, called before every instruction.
void procedure_cost_hook(lua_State* state, lua_Debug* record);
/// Charge a call of a function of the library. The call fails if it costs more than PROCEDURE_ACT_MAX, and
/// waits for the next cycle if the rest of the budget does not cover it. Calls `body` and returns its result.
int procedure_pay(lua_State* state, uint64_t price, lua_KFunction body, lua_KContext context);
/// True if the budget of this cycle is used up: work that is divided into pieces must then yield.
bool procedure_must_wait(lua_State* state);
/// Charge work that is already done.
void procedure_charge(procedure_slot_t* slot, uint64_t price);
/// Returns the worst-case price of finding one key in a table.
uint32_t procedure_price_of_key(const procedure_slot_t* slot);
/// Check the text at `index`; if it contains NUL, note that such texts exist, because comparing them is
/// expensive.
void procedure_note_text(lua_State* state, int index);
/// True if the interpreter may allocate or resize this block, which is then recorded and charged. For a new
/// block `before` is the kind of object.
bool procedure_may_take(procedure_slot_t* slot, const void* block, size_t before, size_t after);
/// Charge the full garbage collection that follows a refused allocation.
void procedure_charge_collection(procedure_slot_t* slot);

#endif // FSW_PROCEDURES_PROCEDURE_COST_H
