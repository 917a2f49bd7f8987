// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_sandbox.h"

#include "fsw/framework/base/assertion.h"

#include <lua5.4/lauxlib.h>
#include <lua5.4/lualib.h>
#include <string.h>

#define UNPACK_MAX 250 // Values that `unpack` returns.
#define KEY_COST 8U    // Of putting a key into its order [instructions].

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
    (void)memcpy(lua_getextraspace(state), &address, sizeof(void*)); // Threads inherit it.
}

// Functions of the language in a form that neither calls back into the procedure, nor runs on without its
// instructions, nor shows addresses.

static int to_text(lua_State* const state)
{
    luaL_checkany(state, 1);
    lua_settop(state, 1);
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

/// Finalizers and closers run where no budget holds, and weak tables show when memory is collected.
static int set_metatable(lua_State* const state)
{
    static const char* const refused[] = {"__gc", "__close", "__mode"};
    luaL_checktype(state, 1, LUA_TTABLE);
    luaL_argexpected(state, lua_isnoneornil(state, 2) || lua_istable(state, 2), 2, "nil or table");
    lua_settop(state, 2);
    if (luaL_getmetafield(state, 1, "__metatable") != LUA_TNIL) {
        return luaL_error(state, "metatable is protected");
    }
    for (size_t i = 0U; lua_istable(state, 2) && (i < (sizeof refused / sizeof refused[0])); i++) {
        lua_pushstring(state, refused[i]);
        if (lua_rawget(state, 2) != LUA_TNIL) {
            return luaL_error(state, "%s is not allowed", refused[i]);
        }
        lua_pop(state, 1);
    }
    (void)lua_setmetatable(state, 1);
    return 1;
}

static int repeat(lua_State* const state)
{
    size_t size             = 0U;
    size_t between          = 0U;
    const char* const text  = luaL_checklstring(state, 1, &size);
    const lua_Integer count = luaL_checkinteger(state, 2);
    const char* const glue  = luaL_optlstring(state, 3, "", &between);
    luaL_Buffer buffer;
    if ((count <= 0) || ((size + between) == 0U)) {
        lua_pushliteral(state, "");
        return 1;
    }
    if ((size + between) > (PROCEDURE_STRING_MAX / (lua_Unsigned)count)) {
        return luaL_error(state, "resulting string too large");
    }
    luaL_buffinit(state, &buffer);
    for (lua_Integer i = 0; i < count; i++) {
        luaL_addlstring(&buffer, glue, (i == 0) ? 0U : between);
        luaL_addlstring(&buffer, text, size);
    }
    luaL_pushresult(&buffer);
    return 1;
}

/// True if a format has a conversion of this letter.
static bool converts(const char* format, const char letter)
{
    for (format = strchr(format, (int)'%'); format != NULL; format = strchr(format, (int)'%')) {
        format += 1U + strspn(&format[1], "-+ #0123456789.");
        if (*format == letter) {
            return true;
        }
        format += (*format != '\0') ? 1U : 0U;
    }
    return false;
}

/// The library's format, as upvalue, for what shows no address.
static int format(lua_State* const state)
{
    const int count = lua_gettop(state);
    luaL_argcheck(state, !converts(luaL_checkstring(state, 1), 'p'), 1, "no addresses");
    for (int i = 2; i <= count; i++) {
        luaL_argexpected(state, lua_type(state, i) <= LUA_TSTRING, i, "nil, boolean, number or string");
    }
    lua_pushvalue(state, lua_upvalueindex(1));
    lua_insert(state, 1);
    lua_call(state, count, 1);
    return 1;
}

static int concatenate(lua_State* const state)
{
    size_t between = 0U;
    luaL_Buffer buffer;
    luaL_checktype(state, 1, LUA_TTABLE);
    const char* const glue  = luaL_optlstring(state, 2, "", &between);
    const lua_Integer first = luaL_optinteger(state, 3, 1);
    const lua_Integer last  = luaL_optinteger(state, 4, (lua_Integer)lua_rawlen(state, 1));
    size_t total            = 0U;
    luaL_buffinit(state, &buffer);
    for (lua_Integer i = first; i <= last; i++) {
        const int type = lua_rawgeti(state, 1, i);
        if ((type != LUA_TSTRING) && (type != LUA_TNUMBER)) {
            return luaL_error(state, "invalid value in table for 'concat'");
        }
        total += lua_rawlen(state, -1) + between;
        if (total > PROCEDURE_STRING_MAX) {
            return luaL_error(state, "resulting string too large");
        }
        luaL_addvalue(&buffer);
        luaL_addlstring(&buffer, glue, (i == last) ? 0U : between);
    }
    luaL_pushresult(&buffer);
    return 1;
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
    luaL_checkstack(state, UNPACK_MAX, NULL);
    const int count = (int)(last - first) + 1;
    for (int i = 0; i < count; i++) {
        (void)lua_rawgeti(state, 1, first + i);
    }
    return count;
}

// `pairs` in the order of the keys.

/// Numbers, then texts, then truth values; -1 for what has no order.
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
    size_t one_size              = 0U;
    size_t other_size            = 0U;
    const char* const one_text   = lua_tolstring(state, one, &one_size);
    const char* const other_text = lua_tolstring(state, other, &other_size);
    const size_t size            = (one_size < other_size) ? one_size : other_size;
    const int order              = memcmp(one_text, other_text, size);
    return (order < 0) || ((order == 0) && (one_size < other_size));
}

/// Whether key `one` of the list at index 2 comes before key `other`.
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
        // The rank decides.
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

static void sink(lua_State* const state, lua_Integer place, const lua_Integer count)
{
    for (lua_Integer child = 2 * place; child <= count; child = 2 * place) {
        if ((child < count) && is_before(state, child, child + 1)) {
            child++;
        }
        if (!is_before(state, place, child)) {
            return;
        }
        exchange(state, place, child);
        place = child;
    }
}

static void sort_keys(lua_State* const state, const lua_Integer count)
{
    for (lua_Integer i = count / 2; i >= 1; i--) {
        sink(state, i, count);
    }
    for (lua_Integer left = count; left > 1; left--) {
        exchange(state, 1, left);
        sink(state, 1, left - 1);
    }
    procedure_slot_of(state)->spent += (uint32_t)count * KEY_COST;
}

/// Upvalues: list of keys, table, keys passed.
static int next_pair(lua_State* const state)
{
    lua_Integer place = lua_tointeger(state, lua_upvalueindex(3));
    do {
        lua_settop(state, 0);
        place++;
        if (lua_rawgeti(state, lua_upvalueindex(1), place) == LUA_TNIL) {
            return 1;
        }
        lua_pushvalue(state, 1);
    } while (lua_rawget(state, lua_upvalueindex(2)) == LUA_TNIL); // It was taken out meanwhile.
    lua_pushinteger(state, place);
    lua_replace(state, lua_upvalueindex(3));
    return 2;
}

static int pairs(lua_State* const state)
{
    luaL_checktype(state, 1, LUA_TTABLE);
    lua_settop(state, 1);
    lua_newtable(state);
    lua_Integer count = 0;
    lua_pushnil(state);
    while (lua_next(state, 1) != 0) {
        lua_pop(state, 1);
        if (rank_of(state, -1) < 0) {
            return luaL_error(state, "no order among keys that are a %s", luaL_typename(state, -1));
        }
        count++;
        lua_pushvalue(state, -1);
        lua_rawseti(state, 2, count);
    }
    sort_keys(state, count);
    lua_pushvalue(state, 1);
    lua_pushinteger(state, 0);
    lua_pushcclosure(state, next_pair, 3);
    return 1;
}

// The sandbox.

/// Copy what `names` lists from the table on top of the stack into the one below it, and pop it.
static void copy(lua_State* const state, const char* const* names)
{
    for (; *names != NULL; names++) {
        lua_pushstring(state, *names);
        lua_pushvalue(state, -1);
        (void)lua_rawget(state, -3);
        lua_rawset(state, -4);
    }
    lua_pop(state, 1);
}

/// Texts have methods but no arithmetic, which would call back.
static void protect_strings(lua_State* const state)
{
    lua_pushliteral(state, "");
    lua_createtable(state, 0, 2);
    lua_pushvalue(state, -3); // The table `string`.
    lua_setfield(state, -2, "__index");
    lua_pushboolean(state, 0);
    lua_setfield(state, -2, "__metatable");
    (void)lua_setmetatable(state, -2);
    lua_pop(state, 1);
}

static void open_strings(lua_State* const state)
{
    static const char* const names[] = {"byte",    "char", "len",    "lower", "pack", "packsize",
                                        "reverse", "sub",  "unpack", "upper", NULL};
    lua_newtable(state);
    luaL_requiref(state, LUA_STRLIBNAME, luaopen_string, 0);
    (void)lua_getfield(state, -1, "format");
    lua_pushcclosure(state, format, 1);
    lua_setfield(state, -3, "format");
    copy(state, names);
    lua_pushcfunction(state, repeat);
    lua_setfield(state, -2, "rep");
    protect_strings(state);
    lua_setfield(state, -2, LUA_STRLIBNAME);
}

static void open_base(lua_State* const state)
{
    static const char* const names[]  = {"assert", "error",  "getmetatable", "pcall",    "rawequal", "rawget",
                                         "rawlen", "rawset", "select",       "tonumber", "type",     NULL};
    static const luaL_Reg functions[] = {
        {"pairs", pairs}, {"setmetatable", set_metatable}, {"tostring", to_text}, {NULL, NULL}};
    luaL_requiref(state, LUA_GNAME, luaopen_base, 0);
    copy(state, names);
    luaL_setfuncs(state, functions, 0);
}

static void open_rest(lua_State* const state)
{
    static const char* const names[]  = {"abs",        "ceil", "floor",      "fmod", "huge", "max",
                                         "maxinteger", "min",  "mininteger", "modf", "pi",   "sqrt",
                                         "tointeger",  "type", "ult",        NULL};
    static const luaL_Reg functions[] = {{"concat", concatenate}, {"unpack", unpack}, {NULL, NULL}};
    lua_newtable(state);
    luaL_requiref(state, LUA_MATHLIBNAME, luaopen_math, 0);
    copy(state, names);
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
    // Nothing leads back to the whole libraries.
    lua_pushnil(state);
    lua_setfield(state, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pushvalue(state, -1);
    lua_rawseti(state, LUA_REGISTRYINDEX, LUA_RIDX_GLOBALS);
    cursor_t cursor = {.next = procedure_prelude()};
    if (lua_load(state, next_line, &cursor, "=library", "t") != LUA_OK) {
        (void)lua_error(state); // No memory.
    }
    lua_insert(state, -2);
    lua_call(state, 1, 0);
}
