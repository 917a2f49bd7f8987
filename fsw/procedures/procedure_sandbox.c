// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_sandbox.h"

#include "base/assertion.h"
#include "fsw/procedures/procedure_cost.h"

#include <lua5.4/lauxlib.h>
#include <lua5.4/lualib.h>
#include <string.h>

#define UNPACK_MAX 250      // Largest number of values that `unpack` returns.
#define KEY_PRICE 4U        // Price of taking a key from a table, and of comparing two keys.
#define TEXT_COMPARED 512U  // Octets that one unit compares.
#define METATABLE_PRICE 40U // Price of copying a metatable.
#define NUMBER_PRICE 18U    // Price of a conversion of a number to a text.
#define PIECE_PRICE 2U      // Price of a text that is copied into another one.
#define PIECES 4U           // Copies of a text that one unit makes in `rep`.

procedure_slot_t* procedure_slot_of(lua_State* const state)
{
    void* slot = NULL;
    (void)memcpy(&slot, lua_getextraspace(state), sizeof(void*));
    FSW_ASSERT(slot != NULL);
    return slot;
}

void procedure_slot_bind(lua_State* const state, procedure_slot_t* const slot)
{
    void* const address = slot;
    (void)memcpy(lua_getextraspace(state), &address, sizeof(void*)); // New threads inherit the extra space.
}

// Variants of functions of the language that do not call the procedure, do not run long without a charge,
// and do not return addresses.

/// Make the text of a value; of values that have an address, the text is the name of the type.
static int make_text(lua_State* const state, const int status, const lua_KContext context)
{
    (void)status;
    (void)context;
    switch (lua_type(state, 1)) {
    case LUA_TNUMBER:
    case LUA_TSTRING:
        (void)lua_tolstring(state, 1, NULL);
        break;
    case LUA_TBOOLEAN:
        lua_pushstring(state, (lua_toboolean(state, 1) != 0) ? "true" : "false");
        break;
    default:
        lua_pushstring(state, luaL_typename(state, 1));
        break;
    }
    return 1;
}

static int to_text(lua_State* const state)
{
    luaL_checkany(state, 1);
    lua_settop(state, 1);
    return procedure_pay(state, NUMBER_PRICE, make_text, 0);
}

/// Copy the fields of a metatable (index 2) into a new one that the procedure cannot change: it cannot add a
/// finalizer, a closer or a weak mode later, nor lengthen a chain of metatables that has been checked. Index
/// 3 and 4 are functions that continue in the tables of __index and __newindex, or nil.
static void copy_metatable(lua_State* const state)
{
    static const char* const events[] = {"__metatable", "__call", "__concat", "__len", "__eq",   "__lt",
                                         "__le",        "__add",  "__sub",    "__mul", "__mod",  "__pow",
                                         "__div",       "__idiv", "__band",   "__bor", "__bxor", "__shl",
                                         "__shr",       "__unm",  "__bnot"};
    lua_newtable(state);
    for (size_t i = 0U; i < (sizeof events / sizeof events[0]); i++) {
        lua_pushstring(state, events[i]);
        lua_pushvalue(state, -1);
        if (lua_rawget(state, 2) != LUA_TNIL) {
            lua_rawset(state, -3);
        } else {
            lua_pop(state, 2);
        }
    }
    lua_pushvalue(state, 3);
    lua_setfield(state, -2, "__index");
    lua_pushvalue(state, 4);
    lua_setfield(state, -2, "__newindex");
    lua_pushvalue(state, 2);
    lua_rawseti(state, -2, 1); // get_metatable returns the original.
}

static int put_metatable(lua_State* const state, const int status, const lua_KContext context)
{
    (void)status;
    (void)context;
    if (lua_type(state, 2) == LUA_TTABLE) {
        copy_metatable(state);
    } else {
        lua_pushnil(state);
    }
    (void)lua_setmetatable(state, 1);
    lua_settop(state, 1);
    return 1;
}

/// Sets a metatable without __gc, __close and __mode: finalizers and closers would run without a budget,
/// and weak tables would reveal when garbage is collected.
static int set_metatable(lua_State* const state)
{
    static const char* const refused[] = {"__gc", "__close", "__mode"};
    luaL_checktype(state, 1, LUA_TTABLE);
    luaL_argexpected(state, lua_isnoneornil(state, 2) || lua_istable(state, 2), 2, "nil or table");
    lua_settop(state, 4);
    if (luaL_getmetafield(state, 1, "__metatable") != LUA_TNIL) {
        return luaL_error(state, "cannot change a protected metatable");
    }
    for (size_t i = 0U; (lua_type(state, 2) == LUA_TTABLE) && (i < (sizeof refused / sizeof refused[0]));
         i++) {
        lua_pushstring(state, refused[i]);
        if (lua_rawget(state, 2) != LUA_TNIL) {
            return luaL_error(state, "%s is not allowed", refused[i]);
        }
        lua_pop(state, 1);
    }
    if (lua_type(state, 2) == LUA_TTABLE) {
        lua_pushliteral(state, "__call");
        const int type = lua_rawget(state, 2);
        luaL_argcheck(state, (type == LUA_TNIL) || (type == LUA_TFUNCTION), 2, "__call: expected a function");
        lua_pop(state, 1);
    }
    return procedure_pay(state, METATABLE_PRICE, put_metatable, 0);
}

static int get_metatable(lua_State* const state)
{
    luaL_checkany(state, 1);
    procedure_charge(procedure_slot_of(state), KEY_PRICE);
    if (lua_getmetatable(state, 1) == 0) {
        lua_pushnil(state);
        return 1;
    }
    lua_pushliteral(state, "__metatable");
    if (lua_rawget(state, -2) == LUA_TNIL) {
        lua_pop(state, 1);
        (void)lua_rawgeti(state, -1, 1);
    }
    return 1;
}

static int make_repeated(lua_State* const state, const int status, const lua_KContext context)
{
    (void)status;
    size_t size            = 0U;
    size_t between         = 0U;
    const char* const text = luaL_checklstring(state, 1, &size);
    const char* const glue = luaL_optlstring(state, 3, "", &between);
    luaL_Buffer buffer;
    luaL_buffinit(state, &buffer);
    for (lua_KContext i = 0; i < context; i++) {
        luaL_addlstring(&buffer, glue, (i == 0) ? 0U : between);
        luaL_addlstring(&buffer, text, size);
    }
    luaL_pushresult(&buffer);
    return 1;
}

static int repeat(lua_State* const state)
{
    size_t size             = 0U;
    size_t between          = 0U;
    const lua_Integer count = luaL_checkinteger(state, 2);
    (void)luaL_checklstring(state, 1, &size);
    (void)luaL_optlstring(state, 3, "", &between);
    if ((count <= 0) || ((size + between) == 0U)) {
        lua_pushliteral(state, "");
        return 1;
    }
    if ((size + between) > (PROCEDURE_STRING_MAX / (lua_Unsigned)count)) {
        return luaL_error(state, "resulting string too large");
    }
    return procedure_pay(state, KEY_PRICE + ((lua_Unsigned)count / PIECES), make_repeated,
                         (lua_KContext)count);
}

/// The values that `concat` reads.
typedef struct {
    const char* glue;
    size_t between;
    lua_Integer first;
    lua_Integer last;
} pieces_t;

static pieces_t pieces_of(lua_State* const state)
{
    pieces_t pieces;
    luaL_checktype(state, 1, LUA_TTABLE);
    pieces.glue  = luaL_optlstring(state, 2, "", &pieces.between);
    pieces.first = luaL_optinteger(state, 3, 1);
    pieces.last  = luaL_optinteger(state, 4, (lua_Integer)lua_rawlen(state, 1));
    return pieces;
}

static int join(lua_State* const state, const int status, const lua_KContext context)
{
    (void)status;
    (void)context;
    const pieces_t pieces = pieces_of(state);
    luaL_Buffer buffer;
    luaL_buffinit(state, &buffer);
    for (lua_Integer i = pieces.first; i <= pieces.last; i++) {
        (void)lua_rawgeti(state, 1, i);
        luaL_addvalue(&buffer);
        luaL_addlstring(&buffer, pieces.glue, (i == pieces.last) ? 0U : pieces.between);
    }
    luaL_pushresult(&buffer);
    return 1;
}

static int concatenate(lua_State* const state)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    const pieces_t pieces        = pieces_of(state);
    size_t total                 = 0U;
    uint32_t price               = KEY_PRICE;
    for (lua_Integer i = pieces.first; i <= pieces.last; i++) {
        const int type = lua_rawgeti(state, 1, i);
        if ((type != LUA_TSTRING) && (type != LUA_TNUMBER)) {
            return luaL_error(state, "invalid value in table for 'concat'");
        }
        total += pieces.between + ((type == LUA_TSTRING) ? lua_rawlen(state, -1) : 1U);
        if (total > PROCEDURE_STRING_MAX) {
            return luaL_error(state, "resulting string too large");
        }
        price += (type == LUA_TNUMBER) ? NUMBER_PRICE : PIECE_PRICE;
        procedure_charge(slot, 1U + procedure_price_of_key(slot));
        lua_pop(state, 1);
    }
    return procedure_pay(state, price, join, 0);
}

static int push_list(lua_State* const state, const int status, const lua_KContext context)
{
    (void)status;
    const lua_Integer first = luaL_optinteger(state, 2, 1);
    luaL_checkstack(state, UNPACK_MAX, NULL);
    for (lua_KContext i = 0; i < context; i++) {
        (void)lua_rawgeti(state, 1, first + (lua_Integer)i);
    }
    return (int)context;
}

static int unpack(lua_State* const state)
{
    luaL_checktype(state, 1, LUA_TTABLE);
    const lua_Integer first = luaL_optinteger(state, 2, 1);
    const lua_Integer last  = luaL_optinteger(state, 3, (lua_Integer)lua_rawlen(state, 1));
    if (first > last) {
        return 0;
    }
    if (((lua_Unsigned)last - (lua_Unsigned)first) >= (lua_Unsigned)UNPACK_MAX) {
        return luaL_error(state, "too many results to unpack");
    }
    const lua_KContext count = (lua_KContext)(last - first) + 1;
    const uint64_t each      = 1U + procedure_price_of_key(procedure_slot_of(state));
    return procedure_pay(state, KEY_PRICE + ((uint64_t)count * each), push_list, count);
}

// ---- Iteration in the order of the keys ----

/// Returns the rank of a key's type: numbers, then texts, then booleans; -1 for other types, which have no
/// order.
static int rank_of(lua_State* const state, const int index)
{
    switch (lua_type(state, index)) {
    case LUA_TNUMBER:
        return 0;
    case LUA_TSTRING:
        return 1;
    case LUA_TBOOLEAN:
        return 2;
    default:
        return -1;
    }
}

static bool is_text_before(lua_State* const state, const int one, const int other)
{
    const size_t one_size   = (size_t)lua_rawlen(state, one);
    const size_t other_size = (size_t)lua_rawlen(state, other);
    const size_t size       = (one_size < other_size) ? one_size : other_size;
    const int order         = memcmp(lua_tostring(state, one), lua_tostring(state, other), size);
    return (order < 0) || ((order == 0) && (one_size < other_size));
}

/// True if key `one` of the list at index 2 comes before key `other`.
static bool is_before(lua_State* const state, const lua_Integer one, const lua_Integer other)
{
    (void)lua_rawgeti(state, 2, one);
    (void)lua_rawgeti(state, 2, other);
    const int one_rank   = rank_of(state, -2);
    const int other_rank = rank_of(state, -1);
    bool result          = one_rank < other_rank;
    if ((one_rank == 0) && (other_rank == 0)) {
        result = lua_compare(state, -2, -1, LUA_OPLT) != 0;
    } else if ((one_rank == 1) && (other_rank == 1)) {
        result = is_text_before(state, -2, -1);
    } else if (one_rank == other_rank) {
        result = lua_toboolean(state, -2) < lua_toboolean(state, -1);
    } else {
        // The ranks differ and determine the order.
    }
    lua_pop(state, 2);
    return result;
}

static void exchange(lua_State* const state, const lua_Integer one, const lua_Integer other)
{
    (void)lua_rawgeti(state, 2, one);
    (void)lua_rawgeti(state, 2, other);
    lua_rawseti(state, 2, one);
    lua_rawseti(state, 2, other);
}

static void charge_keys(lua_State* const state, const uint32_t keys)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    const uint32_t each          = KEY_PRICE + procedure_price_of_key(slot) + (slot->longest / TEXT_COMPARED);
    procedure_charge(slot, (uint64_t)keys * each);
}

/// Sift a key down to its position in the heap. The whole depth is charged for any order of the keys, because
/// the order of text keys in a table depends on the interpreter's hash seed.
static void sift_down(lua_State* const state, lua_Integer position, const lua_Integer count)
{
    for (lua_Integer level = 2 * position; level <= count; level *= 2) {
        charge_keys(state, 2U);
    }
    for (lua_Integer child = 2 * position; child <= count; child = 2 * position) {
        if ((child < count) && is_before(state, child, child + 1)) {
            child++;
        }
        if (!is_before(state, position, child)) {
            return;
        }
        exchange(state, position, child);
        position = child;
    }
}

/// Iterator. Upvalues: list of keys, table, number of keys passed.
static int next_pair(lua_State* const state)
{
    lua_Integer position = lua_tointeger(state, lua_upvalueindex(3));
    do {
        charge_keys(state, 1U);
        lua_settop(state, 0);
        position++;
        if (lua_rawgeti(state, lua_upvalueindex(1), position) == LUA_TNIL) {
            return 1;
        }
        lua_pushvalue(state, 1);
        // Skip keys that were removed during the iteration.
    } while (lua_rawget(state, lua_upvalueindex(2)) == LUA_TNIL);
    lua_pushinteger(state, position);
    lua_replace(state, lua_upvalueindex(3));
    return 2;
}

/// Continue the heap sort of the keys in the list at index 2 with step `next`: first build the heap, then
/// take its largest key repeatedly. Returns the iterator.
static int sort_on(lua_State* const state, const int status, const lua_KContext next)
{
    (void)status;
    const lua_Integer count = (lua_Integer)lua_rawlen(state, 2);
    const lua_Integer heap  = count / 2;
    for (lua_Integer step = (lua_Integer)next; step < (heap + count - 1); step++) {
        if (procedure_must_wait(state)) {
            return lua_yieldk(state, 0, (lua_KContext)step, sort_on);
        }
        if (step < heap) {
            sift_down(state, heap - step, count);
        } else {
            const lua_Integer left = count - (step - heap);
            exchange(state, 1, left);
            sift_down(state, 1, left - 1);
        }
    }
    lua_pushvalue(state, 1);
    lua_pushinteger(state, 0);
    lua_pushcclosure(state, next_pair, 3);
    return 1;
}

/// Copy the keys of the table at index 1 into the list at index 2, beginning after the key on top of the
/// stack. `are_sorted`: all keys so far are sorted numbers, whose order in a table is always the same.
static int collect(lua_State* const state, const int status, lua_KContext are_sorted)
{
    (void)status;
    lua_Integer count = (lua_Integer)lua_rawlen(state, 2);
    while (lua_next(state, 1) != 0) {
        lua_pop(state, 1);
        if (rank_of(state, -1) < 0) {
            return luaL_error(state, "keys of type %s have no order", luaL_typename(state, -1));
        }
        count++;
        lua_pushvalue(state, -1);
        lua_rawseti(state, 2, count);
        are_sorted = ((are_sorted != 0) && (lua_type(state, -1) == LUA_TNUMBER) &&
                      ((count == 1) || is_before(state, count - 1, count)))
                         ? 1
                         : 0;
        charge_keys(state, 2U);
        if (procedure_must_wait(state)) {
            return lua_yieldk(state, 0, are_sorted, collect);
        }
    }
    const lua_Integer steps = (count / 2) + count - 1;
    return sort_on(state, LUA_OK, (are_sorted != 0) ? (lua_KContext)steps : 0);
}

static int pairs(lua_State* const state)
{
    luaL_checktype(state, 1, LUA_TTABLE);
    lua_settop(state, 1);
    lua_newtable(state);
    lua_pushnil(state);
    return collect(state, LUA_OK, 1);
}

// ---- The sandbox ----

/// Give texts methods, but no arithmetic, which would call the procedure.
static void protect_strings(lua_State* const state)
{
    lua_pushliteral(state, "");
    lua_createtable(state, 0, 2);
    lua_pushvalue(state, -3); // The table of the library `string`.
    lua_setfield(state, -2, "__index");
    lua_pushboolean(state, 0);
    lua_setfield(state, -2, "__metatable");
    (void)lua_setmetatable(state, -2);
    lua_pop(state, 1);
}

static void open_strings(lua_State* const state)
{
    lua_newtable(state);
    luaL_requiref(state, LUA_STRLIBNAME, luaopen_string, 0);
    procedure_library_copy(state, PROCEDURE_STRINGS);
    lua_pushcfunction(state, repeat);
    lua_setfield(state, -2, "rep");
    protect_strings(state);
    lua_setfield(state, -2, LUA_STRLIBNAME);
}

static void open_base(lua_State* const state)
{
    static const luaL_Reg functions[] = {{"pairs", pairs},
                                         {"getmetatable", get_metatable},
                                         {"setmetatable", set_metatable},
                                         {"tostring", to_text},
                                         {NULL, NULL}};
    luaL_requiref(state, LUA_GNAME, luaopen_base, 0);
    procedure_library_copy(state, PROCEDURE_BASE);
    luaL_setfuncs(state, functions, 0);
}

static void open_rest(lua_State* const state)
{
    static const luaL_Reg functions[] = {{"concat", concatenate}, {"unpack", unpack}, {NULL, NULL}};
    lua_newtable(state);
    luaL_requiref(state, LUA_MATHLIBNAME, luaopen_math, 0);
    procedure_library_copy(state, PROCEDURE_MATH);
    lua_setfield(state, -2, LUA_MATHLIBNAME);
    lua_newtable(state);
    luaL_setfuncs(state, functions, 0);
    lua_setfield(state, -2, LUA_TABLIBNAME);
}

typedef struct {
    const char* const* next;
} cursor_t;

static const char* next_line(lua_State* const state, void* const context, size_t* const out_size)
{
    (void)state;
    cursor_t* const cursor = context;
    const char* const text = *cursor->next;
    *out_size              = (text != NULL) ? strlen(text) : 0U;
    cursor->next++;
    return text;
}

void procedure_sandbox_open(lua_State* const state)
{
    lua_newtable(state);
    open_base(state);
    open_strings(state);
    open_rest(state);
    procedure_calls_open(state);
    // Remove the registry's reference to the complete libraries.
    lua_pushnil(state);
    lua_setfield(state, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pushvalue(state, -1);
    lua_rawseti(state, LUA_REGISTRYINDEX, LUA_RIDX_GLOBALS);
    cursor_t cursor = {.next = procedure_prelude()};
    if (lua_load(state, next_line, &cursor, "=library", "t") != LUA_OK) {
        (void)lua_error(state); // The memory is exhausted.
    }
    lua_insert(state, -2);
    lua_call(state, 1, 0);
}
