// SPDX-License-Identifier: Apache-2.0
#include "base/octets.h"
#include "fsw/procedures/procedure_cost.h"
#include "fsw/procedures/procedure_sandbox.h"

#include <lua5.4/lauxlib.h>
#include <string.h>

#define SECONDS_MAX 1e9
#define APID_MAX 2046
#define OCTET_MAX 255
#define STEP_MAX 65535
#define CALL_PRICE 64U  // Price of a call of the host, including its work.
#define OCTETS_READ 20U // Octets of arguments that are read for one unit.

void procedure_push_value(lua_State* const state, const value_type_t type, const uint64_t bits)
{
    uint64_t memory = 0U; // Aligned for every type.
    value_store(type, bits, &memory);
    if ((type == VALUE_FLOAT) || (type == VALUE_DOUBLE)) {
        lua_pushnumber(state, value_as_double(type, &memory));
    } else if (type == VALUE_BOOL) {
        lua_pushboolean(state, (bits != 0U) ? 1 : 0);
    } else if ((type >= VALUE_INT8) && (type <= VALUE_INT64)) {
        const uint64_t sign = 1ULL << ((8U * value_size(type)) - 1U);
        lua_pushinteger(state, (lua_Integer)((bits ^ sign) - sign));
    } else {
        lua_pushinteger(state, (lua_Integer)bits);
    }
}

/// Push the next value in `reader`.
static void push_next(lua_State* const state, octet_reader_t* const reader)
{
    const value_type_t type = (value_type_t)octet_read_u8(reader);
    uint64_t bits           = 0U;
    for (size_t i = value_size(type); i > 0U; i--) {
        bits = (bits << 8U) | octet_read_u8(reader);
    }
    procedure_push_value(state, type, bits);
}

void procedure_push_values(lua_State* const state, const uint8_t* const octets, const size_t size)
{
    octet_reader_t reader = octet_reader(octets, size);
    const uint8_t count   = octet_read_u8(&reader);
    luaL_checkstack(state, (int)count, NULL);
    for (uint8_t i = 0U; i < count; i++) {
        push_next(state, &reader);
    }
}

/// Continue the procedure after the answer to a call. It runs in protected mode, like all code of the
/// procedure.
static int answered(lua_State* const state, const int status, const lua_KContext context)
{
    (void)status;
    (void)context;
    const pus_answer_t* const answer = &procedure_slot_of(state)->answer;
    octet_reader_t reader;
    uint8_t count = 0U;
    switch (answer->kind) {
    case PUS_ANSWER_VERDICT:
        lua_pushboolean(state, (answer->code == 0U) ? 1 : 0);
        lua_pushinteger(state, (lua_Integer)answer->code);
        lua_pushinteger(state, (lua_Integer)answer->detail);
        return 3;
    case PUS_ANSWER_VALUE:
        procedure_push_value(state, answer->type, answer->bits);
        return 1;
    case PUS_ANSWER_VALUES:
        reader = octet_reader(answer->octets, answer->size);
        count  = octet_read_u8(&reader);
        lua_createtable(state, (int)count, 0);
        for (lua_Integer i = 1; i <= (lua_Integer)count; i++) {
            push_next(state, &reader);
            lua_rawseti(state, -2, i);
        }
        return 1;
    case PUS_ANSWER_MISSING:
        lua_pushnil(state);
        return 1;
    case PUS_ANSWER_NONE:
    default:
        return 0;
    }
}

/// Charge a call of the host and interrupt the procedure; `answered` continues it after the call.
static int ask(lua_State* const state, const pus_call_kind_t kind)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    const int count              = lua_gettop(state);
    uint64_t octets              = 0U;
    for (int i = 1; i <= count; i++) {
        octets += (lua_type(state, i) == LUA_TSTRING) ? lua_rawlen(state, i) : 1U;
    }
    procedure_charge(slot, CALL_PRICE + (octets / OCTETS_READ));
    slot->call.kind = kind;
    return lua_yieldk(state, 0, 0, answered);
}

/// Returns an integer argument; raises an error if it is not within low..high.
static uint32_t integer_at(lua_State* const state, const int index, const lua_Integer low,
                           const lua_Integer high)
{
    const lua_Integer value = luaL_checkinteger(state, index);
    luaL_argcheck(state, (value >= low) && (value <= high), index,
                  lua_pushfstring(state, "expected %I to %I", (LUAI_UACINT)low, (LUAI_UACINT)high));
    return (uint32_t)value;
}

static double seconds_at(lua_State* const state, const int index)
{
    const double seconds = luaL_checknumber(state, index);
    luaL_argcheck(state, (seconds >= 0.0) && (seconds <= SECONDS_MAX), index, "expected 0 to 1e9 seconds");
    return seconds;
}

static int step(lua_State* const state)
{
    procedure_slot_of(state)->call.number = integer_at(state, 1, 1, STEP_MAX);
    return ask(state, PUS_CALL_STEP);
}

static int wait_for(lua_State* const state)
{
    procedure_slot_of(state)->call.seconds = seconds_at(state, 1);
    return ask(state, PUS_CALL_WAIT);
}

static int send(lua_State* const state)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    size_t size                  = 0U;
    slot->call.apid              = (uint16_t)integer_at(state, 1, 0, APID_MAX);
    slot->call.service           = (uint8_t)integer_at(state, 2, 1, OCTET_MAX);
    slot->call.subtype           = (uint8_t)integer_at(state, 3, 1, OCTET_MAX);
    const char* const data       = luaL_optlstring(state, 4, "", &size);
    luaL_argcheck(state, size <= sizeof slot->data, 4,
                  lua_pushfstring(state, "expected at most %d octets", (int)sizeof slot->data));
    slot->call.does_wait = lua_toboolean(state, 5) != 0;
    slot->call.octets    = slot->data;
    slot->call.size      = size;
    (void)memcpy(slot->data, data, size);
    return ask(state, PUS_CALL_SEND);
}

static int get(lua_State* const state)
{
    procedure_slot_t* const slot = procedure_slot_of(state);
    size_t size                  = 0U;
    if (lua_type(state, 1) == LUA_TNUMBER) {
        slot->call.number = integer_at(state, 1, 0, (lua_Integer)UINT32_MAX);
        return ask(state, PUS_CALL_GET);
    }
    const char* const name = luaL_checklstring(state, 1, &size);
    luaL_argcheck(state, (size < PROCEDURE_NAME_MAX) && (strlen(name) == size), 1,
                  "expected the name of a parameter");
    (void)memcpy(slot->text, name, size + 1U);
    slot->call.text = slot->text;
    return ask(state, PUS_CALL_GET_NAMED);
}

static int event(lua_State* const state)
{
    procedure_slot_of(state)->call.number = integer_at(state, 1, 1, STEP_MAX);
    return ask(state, PUS_CALL_EVENT);
}

static int parameters(lua_State* const state)
{
    procedure_slot_of(state)->call.seconds = (lua_gettop(state) == 0) ? SECONDS_MAX : seconds_at(state, 1);
    return ask(state, PUS_CALL_PARAMETERS);
}

void procedure_calls_open(lua_State* const state)
{
    static const luaL_Reg calls[] = {
        {"step", step},   {"wait", wait_for},         {"send", send}, {"get", get},
        {"event", event}, {"parameters", parameters}, {NULL, NULL},
    };
    luaL_setfuncs(state, calls, 0);
}
