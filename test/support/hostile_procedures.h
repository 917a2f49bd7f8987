// SPDX-License-Identifier: Apache-2.0
/// Procedures that try to use more time than they are charged: each repeats without end the operation that is
/// most expensive for its charge. The unit tests check that none exceeds its budget; the benchmark measures
/// the time that a charged unit takes.
#ifndef TEST_SUPPORT_HOSTILE_PROCEDURES_H
#define TEST_SUPPORT_HOSTILE_PROCEDURES_H

#include <stdio.h>

#define HOSTILE_CODE_MAX 8192U

typedef struct {
    const char* name;
    const char* before; ///< Code that runs once.
    const char* again;  ///< Code of an endless loop after it.
} hostile_procedure_t;

#define HOSTILE_TEXTS                                                                                        \
    "local z = ('\\0'):rep(4096) local y = ('\\0'):rep(4095) .. 'x' local d = ('1'):rep(4096) "              \
    "local s = ('x'):rep(4096) local f = 1.2345678901234e-300 "
#define HOSTILE_KEYS "local t = {} for i = 1, 256 do t[i * 255] = i end "
#define HOSTILE_LIST "local v = {} for i = 1, 1000 do v[i] = i end "
#define HOSTILE_TEN(code) code code code code code code code code code code

static const hostile_procedure_t hostile_procedures[] = {
    {"plain", "local x = 0", HOSTILE_TEN("x = x + 1 ")},
    {"empty", "", ""},
    {"modulo", "local a, b, x = 1e308, 5e-324", HOSTILE_TEN("x = a % b ")},
    {"power", "local a, b, x = 1.0000001, 123456.7", HOSTILE_TEN("x = a ^ b ")},
    {"order of texts of NUL", HOSTILE_TEXTS "local x", HOSTILE_TEN("x = z < y ")},
    {"order of short texts of NUL", "local a = ('\\0'):rep(40) local b = ('\\0'):rep(39) .. 'x' local x",
     HOSTILE_TEN("x = a <= b ")},
    {"order of texts", "local s = ('x'):rep(4096) local r = ('x'):rep(4095) .. 'y' local x",
     HOSTILE_TEN("x = s < r ")},
    {"equality of texts", HOSTILE_TEXTS "local r = ('\\0'):rep(4096) local x", HOSTILE_TEN("x = z == r ")},
    {"numbers joined", HOSTILE_TEXTS "local x",
     "x = f .. f .. f .. f .. f .. f .. f .. f .. f .. f .. f .. f"},
    {"texts joined", "local s = ('x'):rep(2000) local x", HOSTILE_TEN("x = s .. s ")},
    {"short texts joined", "local i, x = 0", "i = i + 1 x = 'a' .. i"},
    {"texts too long", "local s = ('x'):rep(4096) local function f() return s .. s end", "pcall(f)"},
    {"texts too long in a full memory",
     "local s = ('x'):rep(4096) local function f() return s .. s end local t = {} local n = 0 "
     "pcall(function() while true do n = n + 1 if n > 800 then n = 1 end t[n] = {t[n]} end end) t[1] = nil",
     "pcall(f)"},
    {"a full memory",
     "local t = {} local n = 0 local function f() while true do n = n + 1 if n > 800 then n = 1 end "
     "t[n] = {t[n]} end end",
     "pcall(f)"},
    {"half of memory", "local t = {} for i = 1, 800 do t[i] = {{}} end local n = 0",
     "n = n % 800 + 1 t[n] = {{}}"},
    {"texts that are limits of loops", HOSTILE_TEXTS "local function f() for i = 1, d do break end end",
     "pcall(f)"},
    {"keys that collide", HOSTILE_KEYS "local k, x = 255", HOSTILE_TEN("x = t[k] ")},
    {"keys that collide and are not there", HOSTILE_KEYS "local k, x = 255 * 300", HOSTILE_TEN("x = t[k] ")},
    {"keys that collide, written", HOSTILE_KEYS "local k = 510", HOSTILE_TEN("t[k] = 1 ")},
    {"keys that collide, constant", "local t = {} for i = 0, 255 do t[3 + i * 255] = i end local x",
     HOSTILE_TEN("x = t[3] ")},
    {"keys that collide, raw", HOSTILE_KEYS "local get, set, k = rawget, rawset, 510",
     "get(t, k) set(t, k, 1)"},
    {"tables that collide when they grow", "", "local t = {} for i = 1, 200 do t[i * 255] = i end"},
    {"tables rebuilt", HOSTILE_KEYS "local n = 256", "t[n * 255 - 255 * 255] = nil n = n + 1 t[n * 255] = n"},
    {"tables rebuilt for texts", "local t = {} for i = 1, 128 do t['k' .. i] = i end local n = 128",
     "t['k' .. (n - 127)] = nil n = n + 1 t['k' .. n] = n"},
    {"length",
     HOSTILE_KEYS "local l = {} for i = 0, 7 do for k = 1, 25 do l[(1 << i) + k * 255] = 1 end end "
                  "for i = 0, 40 do l[1 << i] = 1 end local x",
     HOSTILE_TEN("x = #l ")},
    {"length, raw", HOSTILE_KEYS "local n = rawlen", HOSTILE_TEN("n(t) ")},
    {"chain of tables", "local t = {} for i = 1, 400 do t = setmetatable({}, {__index = t}) end local x",
     "pcall(function() x = t.x end)"},
    {"chain of sixteen", "local t = {} for i = 1, 16 do t = setmetatable({}, {__index = t}) end local x",
     HOSTILE_TEN("x = t.x ")},
    {"chain, made behind the check",
     "local m, t = {}, {} for i = 1, 300 do m[i] = {} t[i] = setmetatable({}, m[i]) end "
     "for i = 1, 299 do m[i].__index = t[i + 1] end local x",
     "x = t[1].x"},
    {"chain, written", "local t = {} for i = 1, 100 do t = setmetatable({}, {__newindex = t}) end",
     "t.x = nil"},
    {"many values",
     HOSTILE_LIST "local u = table.unpack local function f(...) return ... end "
                  "local function g(...) return f(...) end local a, b",
     "f(g(u(v, 1, 250)))"},
    {"more and more values", "local function f(...) return f(0, ...) end", "pcall(f)"},
    {"values counted", HOSTILE_LIST "local u, n = table.unpack, select",
     "n('#', u(v, 1, 250)) n(-1, u(v, 1, 250))"},
    {"values held",
     "local n = select local function f(k, ...) if k == 0 then while true do n('#', ...) end end "
     "return f(k - 1, 1, 2, 3, 4, ...) end",
     "f(120)"},
    {"values in a list", HOSTILE_LIST "local u = table.unpack", "local x = {u(v, 1, 250)}"},
    {"deep calls", "local function f(n) if n > 0 then f(n - 1) end end", "pcall(f, 150)"},
    {"deep errors", "local function f(n) return 1 + f(n + 1) end", "pcall(f, 1)"},
    {"errors", "local e = pcall", HOSTILE_TEN("e(error, 'x') ")},
    {"errors with their place", "local function f() local x = nil + 1 end local e = pcall",
     HOSTILE_TEN("e(f) ")},
    {"long errors", HOSTILE_TEXTS, "pcall(error, s:sub(1, 4000), 1)"},
    {"errors at the end of much code",
     "local x = 1 local function f() " HOSTILE_TEN(
         HOSTILE_TEN("x = x + 1 if x == 0 then x = 2 end ")) " x.y.z = 1 end",
     "pcall(f)"},
    {"closures", "local x", "x = function() return x end"},
    {"closures of many variables", "local a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t",
     "local x = function() return a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t end"},
    {"variables closed", "",
     "local a, b, c, d, e, f, g, h local x = function() return a, b, c, d, e, f, g, h end"},
    {"tables", "local x", HOSTILE_TEN("x = {} ")},
    {"tables of keys", "local x", "x = {a = 1, b = 2, c = 3, d = 4, e = 5, f = 6, g = 7, h = 8}"},
    {"metatables", "local m, set = {__add = 1, __index = {}}, setmetatable", "set({}, m)"},
    {"metatables read", "local t, get = setmetatable({}, {}), getmetatable", HOSTILE_TEN("get(t) ")},
    {"keys in order", "local t = {} for i = 1, 250 do t['k' .. i * 7919 % 1000] = i end", "pairs(t)"},
    {"colliding keys in order", HOSTILE_KEYS, "pairs(t)"},
    {"long keys in order", "local t = {} for i = 1, 30 do t[('\\0'):rep(4000) .. i] = i end", "pairs(t)"},
    {"long keys", "local t, s, x = {1}, ('x'):rep(4000)", "x = t[s .. 'y']"},
    {"keys one by one", HOSTILE_LIST, "for k in pairs(v) do end"},
    {"keys taken out meanwhile", "",
     "local t = {} for i = 1, 100 do t[i] = i end for k in pairs(t) do for i = 1, 100 do "
     "t[i] = nil end end"},
    {"packsize", "local p, f = string.packsize, ('b'):rep(4096)", "p(f)"},
    {"pack", "local p, f, u = string.pack, ('!16x'):rep(1000)", "p(f)"},
    {"pack of much", "local p = string.pack", "pcall(p, 'c16000', '')"},
    {"unpack", "local u, f, s = string.unpack, ('b'):rep(800), ('x'):rep(4096)", "u(f, s)"},
    {"unpack of zeros", "local u, f, s = string.unpack, ('x'):rep(3500), ('\\0'):rep(4096)", "u(f, s)"},
    {"number from digits", HOSTILE_TEXTS "local n = tonumber", "n(d)"},
    {"number from a fraction", HOSTILE_TEXTS "local n, g = tonumber, '0.' .. d:sub(1, 4000)", "n(g)"},
    {"number to the base 36", HOSTILE_TEXTS "local n = tonumber", "n(d, 36)"},
    {"number from hexadecimal", HOSTILE_TEXTS "local n, g = tonumber, '0x' .. d:sub(1, 4000)", "n(g)"},
    {"arguments from digits", HOSTILE_TEXTS "local m, q = math.floor, pcall", "q(m, d)"},
    {"place from digits", HOSTILE_TEXTS "local c, q = s.sub, pcall", "q(c, s, d, d)"},
    {"largest of many", HOSTILE_LIST "local m, u = math.max, table.unpack", "m(u(v, 1, 250))"},
    {"remainder", "local r, a, b = math.fmod, 1e308, 5e-324", HOSTILE_TEN("r(a, b) ")},
    {"format of a large number", "local a, g = string.format, ('%.99f'):rep(3)", "a(g, 1e308, 1e308, 1e308)"},
    {"format of a small number", "local a, g = string.format, ('%.99f'):rep(4)",
     "a(g, 5e-324, 5e-324, 5e-324, 1)"},
    {"format with an exponent", "local a, g = string.format, ('%.99e'):rep(10)",
     "a(g, 1e-300, 1e-300, 1e-300, "
     "1e-300, 1e-300, 1e-300, 1e-300, 1e-300, 1e-300, 1e-300)"},
    {"format of nothing", HOSTILE_TEXTS "local a, g = string.format, ('%.0s'):rep(8)",
     "a(g, s, s, s, s, s, s, s, s)"},
    {"format quoted", "local a, q = string.format, ('\\0'):rep(900)", "a('%q', q)"},
    {"format of much text", HOSTILE_TEXTS "local a, g = string.format, ('x'):rep(4000)", "a(g)"},
    {"upper", HOSTILE_TEXTS, "s:upper()"},
    {"reverse", HOSTILE_TEXTS, "s:reverse()"},
    {"sub", HOSTILE_TEXTS, "s:sub(2)"},
    {"sub, short", HOSTILE_TEXTS "local n = 0", "n = n % 4000 + 1 s:sub(n, n + 39)"},
    {"byte", HOSTILE_TEXTS, HOSTILE_TEN("s:byte(7) ")},
    {"bytes", HOSTILE_TEXTS, "s:byte(1, 900)"},
    {"char", "local c = string.char",
     "c(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20)"},
    {"rep", "local r = string.rep", "r('x', 4096)"},
    {"rep of pairs", "local r = string.rep", "r('x', 2048, 'y')"},
    {"rep of nothing", "local r = string.rep", HOSTILE_TEN("r('', 1e15) ")},
    {"concat of numbers", "local c, t = table.concat, {} for i = 1, 100 do t[i] = 1e-300 / i end", "c(t)"},
    {"concat of texts", "local c, t = table.concat, {} for i = 1, 1000 do t[i] = 'abc' end", "c(t)"},
    {"concat of nothing", "local c, t = table.concat, {} for i = 1, 1000 do t[i] = '' end", "c(t)"},
    {"concat that fails", "local c, t = table.concat, {} for i = 1, 1000 do t[i] = '' end t[1000] = {}",
     "pcall(c, t)"},
    {"tostring", "local t, f = tostring, 1.2345678901234e-300", HOSTILE_TEN("t(f) ")},
    {"sort", "local n = 0", "local t = {} for i = 1, 200 do t[i] = i * 7919 % 1000 end table.sort(t)"},
    {"sort of texts of NUL", "local a = ('\\0'):rep(4000) local t = {} for i = 1, 20 do t[i] = a .. i end",
     "table.sort(t)"},
    {"insert", "", "local t = {} for i = 1, 100 do table.insert(t, 1, i) end"},
    {"patterns", "local s = ('a'):rep(200) local p = ('a*'):rep(15) .. 'b'", "s:match(p)"},
    {"replacements", "local s = ('a'):rep(200)", "s:gsub('a', '%0%0')"},
    {"calls of the host", "", "get(1)"},
    {"calls of the host by name", "local n = ('x'):rep(60)", "get(n)"},
    {"calls of the host from digits", HOSTILE_TEXTS, "pcall(get, d)"},
    {"parameters", "", "parameters(0)"},
};

#define HOSTILE_PROCEDURES (sizeof(hostile_procedures) / sizeof(hostile_procedures[0]))

/// Write the code of a procedure to `out_code` of HOSTILE_CODE_MAX.
static inline const char* hostile_code(const hostile_procedure_t* const procedure, char* const out_code)
{
    (void)snprintf(out_code, HOSTILE_CODE_MAX, "%s while true do %s end", procedure->before,
                   procedure->again);
    return out_code;
}

#endif // TEST_SUPPORT_HOSTILE_PROCEDURES_H
