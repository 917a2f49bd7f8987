// SPDX-License-Identifier: Apache-2.0
// Functions of the interpreter's library that neither call the procedure nor reveal addresses. Each is
// called through `priced`, which first charges the worst-case cost for its arguments.
#include "fsw/procedures/procedure_cost.h"
#include "fsw/procedures/procedure_sandbox.h"

#include <lua5.4/lauxlib.h>
#include <string.h>

#define OCTETS_READ 20U   // Octets of a text that are read for one unit.
#define CODE_SEARCHED 16U // Octets of code that are searched for one unit, to make the text of an error.
// Prices of the conversions of `format` [units].
#define ANY_CONVERSION 20U
#define FLOAT_CONVERSION 80U
#define LONG_CONVERSION 400U // %f of a large number has about 400 digits.
#define QUOTED 2U            // Units for each octet that %q quotes.
#define ROWS_MAX 32U         // Largest number of functions of a library.
#define LENGTH_SEARCHES 8U   // Searches of keys that find the end of a table.
#define FLAGS "-+ \0430123456789."

/// Parts of a price in addition to base and arguments.
typedef enum {
    NOTHING,
    KEY,     // A key is found in a table.
    LENGTH,  // The end of a table is searched for.
    ERROR,   // An error may be caught whose text was made from the code.
    TEXT,    // The function makes a text that may contain NUL.
    RANGE,   // The function returns an octet for each position from the second argument to the third.
    TEMPLATE // The function is `format`.
} extra_t;

typedef struct {
    const char* name;
    uint8_t base;
    // Octets of the first argument, a text, that cost one unit; 0: the function does not read it.
    uint8_t first;
    uint8_t arguments; // Number of arguments that cost one unit; 0: arguments are not charged.
    uint8_t extra;     // extra_t.
} row_t;

static const row_t base_rows[] = {{"assert", 3, 0, 8, NOTHING},    {"error", 20, 16, 0, NOTHING},
                                  {"pcall", 20, 0, 8, ERROR},      {"rawequal", 3, 0, 0, NOTHING},
                                  {"rawget", 3, 0, 0, KEY},        {"rawlen", 3, 0, 0, LENGTH},
                                  {"rawset", 3, 0, 0, KEY},        {"select", 3, OCTETS_READ, 8, NOTHING},
                                  {"tonumber", 5, 12, 0, NOTHING}, {"type", 2, 0, 0, NOTHING},
                                  {NULL, 0, 0, 0, NOTHING}};

static const row_t string_rows[] = {
    {"byte", 3, 0, 0, RANGE},       {"char", 4, OCTETS_READ, 4, TEXT}, {"format", 5, 8, 0, TEMPLATE},
    {"len", 2, 0, 0, NOTHING},      {"lower", 4, 40, 0, NOTHING},      {"pack", 6, 2, 1, TEXT},
    {"packsize", 6, 4, 0, NOTHING}, {"reverse", 4, 40, 0, NOTHING},    {"sub", 4, 0, 0, NOTHING},
    {"unpack", 6, 2, 0, NOTHING},   {"upper", 4, 40, 0, NOTHING},      {NULL, 0, 0, 0, NOTHING}};

static const row_t math_rows[] = {
    {"abs", 3, OCTETS_READ, 0, NOTHING},       {"ceil", 3, OCTETS_READ, 0, NOTHING},
    {"floor", 3, OCTETS_READ, 0, NOTHING},     {"fmod", 6, OCTETS_READ, 0, NOTHING},
    {"max", 3, OCTETS_READ, 1, NOTHING},       {"min", 3, OCTETS_READ, 1, NOTHING},
    {"modf", 5, OCTETS_READ, 0, NOTHING},      {"sqrt", 3, OCTETS_READ, 0, NOTHING},
    {"tointeger", 3, OCTETS_READ, 0, NOTHING}, {"type", 2, 0, 0, NOTHING},
    {"ult", 3, OCTETS_READ, 0, NOTHING},       {NULL, 0, 0, 0, NOTHING}};

static const row_t* const libraries[] = {base_rows, string_rows, math_rows};

static uint64_t octets_at(lua_State* const state, const int index)
{
    return (lua_type(state, index) == LUA_TSTRING) ? (uint64_t)lua_rawlen(state, index) : 0U;
}

/// Returns the price of the conversions in a template. Raises an error for a conversion that prints an
/// address.
static uint64_t price_of_template(lua_State* const state)
{
    const int count    = lua_gettop(state);
    const char* format = luaL_checkstring(state, 1);
    uint64_t octets    = 0U;
    uint64_t price     = 0U;
    for (int i = 2; i <= count; i++) {
        luaL_argexpected(state, lua_type(state, i) <= LUA_TSTRING, i, "nil, boolean, number or string");
        octets += octets_at(state, i);
    }
    for (format = strchr(format, (int)'%'); format != NULL; format = strchr(format, (int)'%')) {
        format += 1U + strspn(&format[1], FLAGS);
        luaL_argcheck(state, *format != 'p', 1, "%p is not allowed");
        if ((*format == 'f') || (*format == 'F')) {
            price += LONG_CONVERSION;
        } else if (strchr("aAeEgG", (int)*format) != NULL) {
            price += FLOAT_CONVERSION;
        } else if (*format == 'q') {
            price += ANY_CONVERSION + (QUOTED * octets);
        } else {
            price += ANY_CONVERSION;
        }
        format += (*format != '\0') ? 1U : 0U;
    }
    return price;
}

static uint64_t price_of_range(lua_State* const state)
{
    const uint64_t size     = octets_at(state, 1);
    const lua_Integer first = luaL_optinteger(state, 2, 1);
    const lua_Integer last  = luaL_optinteger(state, 3, first);
    return (first == last) ? 0U : (size / 4U);
}

/// Returns the worst-case price of a call with the arguments on the stack.
static uint64_t price_of(lua_State* const state, const row_t* const row)
{
    const procedure_slot_t* const slot = procedure_slot_of(state);
    const int count                    = lua_gettop(state);
    uint64_t price                     = row->base;
    price += (row->first > 0U) ? (octets_at(state, 1) / row->first) : 0U;
    price += (row->arguments > 0U) ? ((uint64_t)count / row->arguments) : 0U;
    for (int i = 2; i <= count; i++) {
        price += octets_at(state, i) / OCTETS_READ;
    }
    switch ((extra_t)row->extra) {
    case KEY:
        return price + procedure_price_of_key(slot);
    case LENGTH:
        return price + ((uint64_t)procedure_price_of_key(slot) * LENGTH_SEARCHES);
    case ERROR:
        return price + (slot->code_size / CODE_SEARCHED);
    case RANGE:
        return price + price_of_range(state);
    case TEMPLATE:
        return price + price_of_template(state);
    case TEXT:
    case NOTHING:
    default:
        return price;
    }
}

/// Returns the row of the function. The upvalues of `priced` are the function and its row.
static const row_t* row_of(lua_State* const state)
{
    const uint32_t index = (uint32_t)lua_tointeger(state, lua_upvalueindex(2));
    return &libraries[index / ROWS_MAX][index % ROWS_MAX];
}

static int call(lua_State* const state, const int status, const lua_KContext context)
{
    (void)status;
    (void)context;
    const uint8_t extra          = row_of(state)->extra;
    const lua_CFunction function = lua_tocfunction(state, lua_upvalueindex(1));
    const int results            = function(state);
    if ((extra == (uint8_t)TEXT) || (extra == (uint8_t)TEMPLATE)) {
        procedure_note_text(state, -1);
    }
    return results;
}

static int priced(lua_State* const state)
{
    return procedure_pay(state, price_of(state, row_of(state)), call, 0);
}

void procedure_library_copy(lua_State* const state, const procedure_library_t library)
{
    static const char* const constants[] = {"huge", "maxinteger", "mininteger", "pi"};
    const row_t* const rows              = libraries[library];
    for (uint32_t i = 0U; rows[i].name != NULL; i++) {
        (void)lua_getfield(state, -1, rows[i].name);
        lua_pushinteger(state, ((lua_Integer)library * (lua_Integer)ROWS_MAX) + (lua_Integer)i);
        lua_pushcclosure(state, priced, 2);
        lua_setfield(state, -3, rows[i].name);
    }
    for (size_t i = 0U; (library == PROCEDURE_MATH) && (i < (sizeof constants / sizeof constants[0])); i++) {
        (void)lua_getfield(state, -1, constants[i]);
        lua_setfield(state, -3, constants[i]);
    }
    lua_pop(state, 1);
}
