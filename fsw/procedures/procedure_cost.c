// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_cost.h"

#include "fsw/procedures/procedure_sandbox.h"

#include <lua5.4/lauxlib.h>
#include <string.h>

#define OBJECT_HEAD 24U // Size of the head of a text in the interpreter [octets].
#define NODE_OCTETS 24U // Size of a key and its value in a table.
// Longer texts are not shared: the interpreter creates and hashes each one separately.
#define SHORT_TEXT 40U
#define OPERATION_MASK 0x7FU // Operation code in an instruction.
#define OPERANDS_SHIFT 16U   // Position of the number of values in OP_CONCAT.
#define OPERANDS_MASK 0xFFU
#define OPERATIONS 83U

// Work that costs one unit.
#define OCTETS_HASHED 20U    // Octets of a text whose hash is computed.
#define OCTETS_READ 24U      // Octets of a text that is converted to a number.
#define OCTETS_COMPARED 512U // Octets of two texts without NUL.
// Octets of two texts that may contain NUL: each NUL needs a further call of strcoll.
#define NULS_COMPARED 4U
#define NODES_SEARCHED 12U // Colliding keys of a table that are searched.
// Pairs of colliding keys. Inserting n keys counts as n * n pairs, of which the interpreter compares half.
#define PAIRS_SEARCHED 24ULL
// Colliding keys, in the search for the length of a table, which consists of several searches.
#define NODES_LENGTH 3U
#define STACK_MOVED 768U       // Octets of a stack that are moved.
#define OCTETS_TAKEN 32U       // Octets of a new object that are allocated.
#define COLLECTION_OCTETS 256U // Octets in use that a garbage collection visits.

// Prices [units].
#define OPERAND 14U           // Conversion of a number to a text.
#define OBJECT 2U             // Allocation of an object and its later collection.
#define PRICE_MAX (1U << 20U) // Limit of a price, so that no sum overflows.

/// Quantities on which the price of an operation depends, in addition to its base.
typedef enum {
    PLAIN,
    KEY,       // Keys that collide.
    LENGTH,    // Keys that collide, in the search for the length of a table.
    ORDER,     // Two texts.
    EQUALITY,  // Two long texts.
    STACK,     // All values on the stack.
    OPERANDS,  // Values joined to a text.
    CONVERSION // Texts that are numbers.
} dependence_t;

typedef struct {
    uint8_t base;
    uint8_t on; // dependence_t.
} price_t;

/// Prices by operation code of Lua 5.4.
static const price_t prices[OPERATIONS] = {{1, PLAIN},    {1, PLAIN},  {1, PLAIN},
                                           {1, PLAIN},    {1, PLAIN},  {1, PLAIN}, // MOVE .. LOADFALSE
                                           {1, PLAIN},    {1, PLAIN},  {4, PLAIN},
                                           {1, PLAIN},    {1, PLAIN},  {2, PLAIN}, // LFALSESKIP .. GETTABUP
                                           {2, KEY},      {2, KEY},    {2, PLAIN},
                                           {2, PLAIN},    {2, KEY},    {2, KEY}, // GETTABLE .. SETI
                                           {2, PLAIN},    {6, PLAIN},  {2, PLAIN},
                                           {1, PLAIN},    {1, PLAIN},  {1, PLAIN}, // SETFIELD .. SUBK
                                           {1, PLAIN},    {4, PLAIN},  {4, PLAIN},
                                           {1, PLAIN},    {2, PLAIN},  {1, PLAIN}, // MULK .. BANDK
                                           {1, PLAIN},    {1, PLAIN},  {1, PLAIN},
                                           {1, PLAIN},    {1, PLAIN},  {1, PLAIN}, // BORK .. SUB
                                           {1, PLAIN},    {4, PLAIN},  {4, PLAIN},
                                           {1, PLAIN},    {2, PLAIN},  {1, PLAIN}, // MUL .. BAND
                                           {1, PLAIN},    {1, PLAIN},  {1, PLAIN},
                                           {1, PLAIN},    {2, PLAIN},  {2, PLAIN}, // BOR .. MMBINI
                                           {2, PLAIN},    {1, PLAIN},  {1, PLAIN},
                                           {1, PLAIN},    {2, LENGTH}, {6, OPERANDS}, // MMBINK .. CONCAT
                                           {2, PLAIN},    {2, PLAIN},  {1, PLAIN},
                                           {1, EQUALITY}, {1, ORDER},  {1, ORDER}, // CLOSE .. LE
                                           {1, EQUALITY}, {1, PLAIN},  {1, PLAIN},
                                           {1, PLAIN},    {1, PLAIN},  {1, PLAIN}, // EQK .. GEI
                                           {1, PLAIN},    {1, PLAIN},  {3, STACK},
                                           {3, STACK},    {3, STACK},  {2, PLAIN}, // TEST .. RETURN0
                                           {2, PLAIN},    {1, PLAIN},  {3, CONVERSION},
                                           {1, PLAIN},    {3, STACK},  {1, PLAIN}, // RETURN1 .. TFORLOOP
                                           {4, STACK},    {6, PLAIN},  {3, STACK},
                                           {2, STACK},    {1, PLAIN}}; // SETLIST .. EXTRAARG

/// The first members of the interpreter's record of a call, which contain the program counter.
typedef struct {
    void* function;
    void* top;
    void* previous;
    void* next;
    const uint32_t* counter; // Points after the present instruction.
} call_head_t;

static uint32_t instruction_of(const lua_Debug* const record)
{
    call_head_t head;
    (void)memcpy(&head, record->i_ci, sizeof head);
    return head.counter[-1];
}

uint32_t procedure_price_of_key(const procedure_slot_t* const slot)
{
    return slot->nodes / NODES_SEARCHED;
}

/// Returns the worst-case price of an instruction.
static uint32_t price_of(const procedure_slot_t* const slot, const uint32_t instruction)
{
    const uint32_t operation = instruction & OPERATION_MASK;
    const bool is_known      = operation < OPERATIONS;
    const uint32_t base      = is_known ? prices[operation].base : PROCEDURE_ACT_MAX;
    switch (is_known ? (dependence_t)prices[operation].on : PLAIN) {
    case KEY:
        return base + procedure_price_of_key(slot);
    case LENGTH:
        return base + (slot->nodes / NODES_LENGTH);
    case ORDER:
        return base + (slot->longest / (slot->has_nul ? NULS_COMPARED : OCTETS_COMPARED));
    case EQUALITY:
        return base + (slot->longest / OCTETS_COMPARED);
    case STACK:
        return base + (slot->stack_size / STACK_MOVED);
    case OPERANDS:
        return base + (OPERAND * ((instruction >> OPERANDS_SHIFT) & OPERANDS_MASK)) +
               (slot->longest / OCTETS_COMPARED);
    case CONVERSION:
        return base + (2U * (slot->longest / OCTETS_READ));
    case PLAIN:
    default:
        return base;
    }
}

void procedure_charge(procedure_slot_t* const slot, const uint64_t price)
{
    const uint32_t units = (price < PRICE_MAX) ? (uint32_t)price : PRICE_MAX;
    slot->spent += units;
    slot->used += units;
}

bool procedure_must_wait(lua_State* const state)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    const bool must              = (slot->spent > slot->budget) && (lua_isyieldable(state) != 0);
    if (must) {
        slot->call.kind = PUS_CALL_PAUSED;
    }
    return must;
}

void procedure_cost_hook(lua_State* const state, lua_Debug* const record)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    procedure_charge(slot, price_of(slot, instruction_of(record)));
    if (procedure_must_wait(state)) {
        (void)lua_yield(state, 0); // The instruction is paid; it is executed after the next grant.
    }
}

int procedure_pay(lua_State* const state, const uint64_t price, const lua_KFunction body,
                  const lua_KContext context)
{
    if (price > PROCEDURE_ACT_MAX) {
        return luaL_error(state, "this call costs more than %d units", (int)PROCEDURE_ACT_MAX);
    }
    procedure_charge(procedure_slot_of(state), price);
    return procedure_must_wait(state) ? lua_yieldk(state, 0, context, body) : body(state, LUA_OK, context);
}

void procedure_note_text(lua_State* const state, const int index)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    if (!slot->has_nul && (lua_type(state, index) == LUA_TSTRING)) {
        size_t size            = 0U;
        const char* const text = lua_tolstring(state, index, &size);
        slot->has_nul          = (size > 0U) && (memchr(text, 0, size) != NULL);
    }
}

// ---- Memory ----

/// Returns the number of keys in a list of this size; 0 if the size is not that of such a list. A table keeps
/// keys that are not consecutive numbers in a list whose length is a power of two.
static uint32_t nodes_in(const size_t size)
{
    const size_t nodes = size / NODE_OCTETS;
    return (((size % NODE_OCTETS) == 0U) && ((nodes & (nodes - 1U)) == 0U)) ? (uint32_t)nodes : 0U;
}

/// Charge the work of allocating a list or a stack and of filling it. The keys of a table are inserted one by
/// one; `nodes` is their number, 0 for other lists.
static void charge_list(procedure_slot_t* const slot, const size_t size, const uint32_t nodes)
{
    const uint64_t price = (size / OCTETS_TAKEN) + (((uint64_t)nodes * nodes) / PAIRS_SEARCHED) + OBJECT;
    if (size > slot->largest) {
        slot->largest = (uint32_t)size;
        procedure_charge(slot, price);
    } else { // The list may be a rebuilt one, which is charged only beyond the grace (see procedure_cost.h).
        slot->used += (uint32_t)price;
        slot->grace += (uint32_t)price;
        slot->spent += (slot->grace > PROCEDURE_GRACE) ? (uint32_t)price : 0U;
    }
    slot->nodes = (nodes > slot->nodes) ? nodes : slot->nodes;
}

static bool may_take_text(procedure_slot_t* const slot, const size_t size)
{
    const uint32_t length = (size > OBJECT_HEAD) ? (uint32_t)(size - OBJECT_HEAD - 1U) : 0U;
    if (length > PROCEDURE_STRING_MAX) {
        slot->is_too_long = true;
        return false;
    }
    if (length > SHORT_TEXT) {
        procedure_charge(slot, OBJECT + (length / OCTETS_HASHED));
        slot->longest = (length > slot->longest) ? length : slot->longest;
    }
    return true;
}

/// Charge a new function. It refers to variables outside of it; the interpreter searches each of them among
/// the variables to which other functions refer.
static void charge_function(procedure_slot_t* const slot, const size_t size)
{
    const uint64_t variables = size / sizeof(void*);
    procedure_charge(slot, OBJECT + ((variables * variables) / PAIRS_SEARCHED));
}

/// True if a running procedure may allocate this list of values or stack.
static bool may_take_list(procedure_slot_t* const slot, const void* const block, const size_t before,
                          const size_t after)
{
    const uint32_t nodes = nodes_in(after);
    if ((after > PROCEDURE_LIST_MAX) || (nodes > PROCEDURE_NODES_MAX)) {
        return false;
    }
    if ((block == NULL) || (after > before)) {
        charge_list(slot, after, nodes);
    }
    return true;
}

bool procedure_may_take(procedure_slot_t* const slot, const void* const block, const size_t before,
                        const size_t after)
{
    if (block == NULL) {
        switch (before) { // For a new block, `before` is the kind of object.
        case LUA_TSTRING:
            return may_take_text(slot, after);
        case LUA_TFUNCTION:
            charge_function(slot, after);
            return true;
        case 0U: // A list of values, or a stack.
            break;
        default:
            procedure_charge(slot, OBJECT);
            return true;
        }
    }
    // While the code is being loaded, the size of the code limits the lists.
    return (slot->thread == NULL) || may_take_list(slot, block, before, after);
}

void procedure_charge_collection(procedure_slot_t* const slot)
{
    procedure_charge(slot, slot->heap.used / COLLECTION_OCTETS);
}
