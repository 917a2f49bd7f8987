// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_cost.h"
#include "test/support/hostile_procedures.h"
#include "test/unit/fsw/procedures/procedures.h"
#include "unity.h"

#include <string.h>

#define BUDGET 2048U
#define CYCLES 60U
/// Units beyond the budget: memory that is requested and refused is charged afterwards.
#define OVERSHOOT (2U * PROCEDURE_ACT_MAX)
#define MANY_CYCLES 3000U

static char code[HOSTILE_CODE_MAX];

void setUp(void)
{
    host_start();
}

void tearDown(void)
{
}

static void begin(const uint16_t slot, const char* const text)
{
    static const uint8_t none[] = {0};
    host.call                   = (pus_call_t){.kind = PUS_CALL_PAUSED};
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK,
                              host.port.start(host.port.context, slot, "TEST", (const uint8_t*)text,
                                              strlen(text), none, 1U, &host.call),
                              host.call.text);
}

/// Run one cycle of a procedure whose calls return no value. Returns the units used.
static uint32_t cycle(const uint16_t slot)
{
    const pus_answer_t answer = {.kind = PUS_ANSWER_MISSING};
    host.port.grant(host.port.context, slot, BUDGET);
    do {
        host.port.run(host.port.context, slot, &answer, &host.call);
    } while ((host.call.kind != PUS_CALL_PAUSED) && host.slots[slot].is_running);
    return host.port.used(host.port.context, slot);
}

/// Units that a program uses until it ends without error.
static uint32_t units_of(const char* const text)
{
    uint32_t units = 0U;
    begin(0U, text);
    for (unsigned i = 0U; (i < MANY_CYCLES) && host.slots[0].is_running; i++) {
        units += cycle(0U);
    }
    TEST_ASSERT_EQUAL_MESSAGE(PUS_CALL_ENDED, host.call.kind,
                              (host.call.text[0] != '\0') ? host.call.text : text);
    return units;
}

static void no_program_uses_more_than_its_share(void)
{
    for (size_t i = 0U; i < HOSTILE_PROCEDURES; i++) {
        uint64_t all = 0U;
        begin(0U, hostile_code(&hostile_procedures[i], code));
        for (unsigned k = 1U; k <= CYCLES; k++) {
            const uint32_t used = cycle(0U);
            all += used;
            TEST_ASSERT_TRUE_MESSAGE(used <= (BUDGET + PROCEDURE_GRACE + OVERSHOOT),
                                     hostile_procedures[i].name);
            TEST_ASSERT_TRUE_MESSAGE(all <= ((k * (BUDGET + PROCEDURE_GRACE)) + OVERSHOOT),
                                     hostile_procedures[i].name);
            TEST_ASSERT_TRUE_MESSAGE(host.slots[0].is_running, host.call.text);
        }
        // Endless loops use their budget completely.
        TEST_ASSERT_TRUE_MESSAGE(all >= ((CYCLES - 4U) * BUDGET), hostile_procedures[i].name);
        host.port.kill(host.port.context, 0U);
    }
}

/// Neither addresses nor the interpreter's hash seed, which differ between slots, change the number of units
/// used. Exception: the seed decides how often a table with texts as keys is rebuilt (procedure_cost.h).
static void the_cost_of_a_procedure_depends_on_its_code_alone(void)
{
    static uint32_t first[CYCLES];
    for (size_t i = 0U; i < HOSTILE_PROCEDURES; i++) {
        const bool depends = strcmp(hostile_procedures[i].name, "tables rebuilt for texts") == 0;
        for (uint16_t slot = 0U; (slot < HOST_SLOTS) && !depends; slot++) {
            begin(slot, hostile_code(&hostile_procedures[i], code));
            for (unsigned k = 0U; k < CYCLES; k++) {
                (void)cycle(slot);
                const uint32_t spent = host.slots[slot].spent;
                TEST_ASSERT_TRUE_MESSAGE(host.slots[slot].is_running, hostile_procedures[i].name);
                if (slot == 0U) {
                    first[k] = spent;
                } else {
                    TEST_ASSERT_EQUAL_UINT32_MESSAGE(first[k], spent, hostile_procedures[i].name);
                }
            }
            host.port.kill(host.port.context, slot);
        }
    }
}

static const struct {
    const char* before;
    const char* again; // Statement that is executed ten times.
    uint32_t units;    // The statement costs at least this much more than a plain assignment.
} paid[] = {
    {"local a, b, x = 7.5, 2.5", "x = a % b", 3U},
    {"local a, b, x = ('\\0'):rep(4096), ('\\0'):rep(4096)", "x = a < b", 1024U},
    {"local a, b, x = string.char(0):rep(4096), ''", "x = a <= b", 1024U},
    {"local a, b, x = string.pack('I2', 1):rep(2048), ''", "x = a < b", 1024U},
    {"local a, b, x = ('\\x00'):rep(4096), ''", "x = a < b", 1024U},
    {"local a, b, x = ('\\u{0}'):rep(4096), ''", "x = a < b", 1024U},
    {"local a, b, x = ('%c'):format(0):rep(4096), ''", "x = a < b", 1024U},
    {"local a, b, x = ('x'):rep(4096), ''", "x = a < b", 8U},
    {"local a, b, x = ('x'):rep(4096), ''", "x = a == b", 7U},
    {"local x", "x = 1.5 .. 2.5", 28U},
    {"local a, x = ('x'):rep(2000)", "x = a .. a", 200U},
    {"local d = ('1'):rep(4096)", "pcall(function() for i = 1, d do break end end)", 340U},
    {"local t, x = {} for i = 1, 256 do t[i * 255] = i end", "x = t[255]", 21U},
    {"local t, x = {} for i = 1, 256 do t[i * 255] = i end", "t[255] = 2", 21U},
    {"local t, k, x = {}, 255 for i = 1, 256 do t[i * 255] = i end", "x = t[k]", 21U},
    {"local t, k = {}, 255 for i = 1, 256 do t[i * 255] = i end", "t[k] = 2", 21U},
    {"local t, k = {}, 255 for i = 1, 256 do t[i * 255] = i end", "rawget(t, k)", 21U},
    {"local t, k = {}, 255 for i = 1, 256 do t[i * 255] = i end", "rawset(t, k, 1)", 21U},
    {"local t, x = {} for i = 1, 256 do t[i * 255] = i end", "x = #t", 80U},
    {"local t, x = {} for i = 1, 256 do t[i * 255] = i end", "rawlen(t)", 80U},
    {"local u, v = table.unpack, {} for i = 1, 200 do v[i] = i end", "u(v)", 200U},
    {"local x", "x = {}", 7U},
    {"local x", "x = function() end", 6U},
    {"local a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, x",
     "x = function() return a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t end", 25U},
    {"local x", "x = setmetatable({}, {})", 40U},
    {"local x", "get(1)", 64U},
    {"local x = ('1'):rep(4096)", "get(('a'):rep(60))", 64U},
    {"", "pcall(error, 'x')", 20U},
    {"local f = '%.99f'", "f:format(1e308)", 400U},
    {"local f = '%.99e'", "f:format(1e308)", 80U},
    {"local f, s = '%q', ('x'):rep(500)", "f:format(s)", 1000U},
    {"local f, s = '%.0s', ('x'):rep(4096)", "f:format(s)", 200U},
    {"local f = ('x'):rep(4096)", "f:format()", 512U},
    {"local f = ('b'):rep(4096)", "string.packsize(f)", 1024U},
    {"local f = ('x'):rep(4000)", "string.pack(f)", 2000U},
    {"local f, s = ('x'):rep(3000), ('x'):rep(3000)", "string.unpack(f, s)", 1500U},
    {"local s = ('1'):rep(4096)", "tonumber(s)", 340U},
    {"local s = ('1'):rep(4096)", "tonumber(s, 36)", 340U},
    {"local s = ('1'):rep(4096)", "pcall(math.floor, s)", 200U},
    {"local s = ('1'):rep(4096)", "math.fmod(s, s)", 400U},
    {"local s = ('1'):rep(4096)", "pcall(s.sub, s, s)", 200U},
    {"local s = ('x'):rep(4096)", "s:upper()", 300U},
    {"local s = ('x'):rep(4096)", "s:reverse()", 300U},
    {"local s = ('x'):rep(4096)", "s:sub(2)", 204U},
    {"local s = ('x'):rep(800)", "s:byte(1, -1)", 200U},
    {"local r = string.rep", "r('x', 4096)", 1200U},
    {"local t = {} for i = 1, 100 do t[i] = i + 0.5 end", "table.concat(t)", 1800U},
    {"local t = {} for i = 1, 1000 do t[i] = '' end", "table.concat(t)", 3000U},
    {"local x = 1.5", "tostring(x)", 18U},
    {"local t = {} for i = 1, 100 do t['k' .. i] = i end", "pairs(t)", 4000U},
};

static void an_operation_costs_at_least_the_units_of_its_work(void)
{
    for (size_t i = 0U; i < (sizeof paid / sizeof paid[0]); i++) {
        (void)snprintf(code, sizeof code, "%s for i = 1, 10 do end", paid[i].before);
        const uint32_t without = units_of(code);
        (void)snprintf(code, sizeof code, "%s for i = 1, 10 do %s end", paid[i].before, paid[i].again);
        const uint32_t with = units_of(code);
        TEST_ASSERT_TRUE_MESSAGE(with >= (without + (10U * paid[i].units)), paid[i].again);
    }
}

/// Ordinary programs of operators are cheap.
static void ordinary_programs_are_cheap(void)
{
    TEST_ASSERT_TRUE(units_of("local n = 0 for i = 1, 1000 do n = n + i end") <= 2100U);
    TEST_ASSERT_TRUE(units_of("local t = {} for i = 1, 100 do t[i] = i end local n = 0 "
                              "for i, v in ipairs(t) do n = n + v end") <= 1900U);
    const uint32_t filled = units_of("local t = {} for i = 1, 100 do t[i] = i end");
    const uint32_t listed = units_of("local t = {} for i = 1, 100 do t[i] = i end for k in pairs(t) do end");
    // The keys of a list are already in order, so sorting them is cheap.
    TEST_ASSERT_TRUE((listed - filled) <= 1800U);
    TEST_ASSERT_TRUE(units_of("for i = 1, 10 do send(16, 17, 1, string.pack('>I2I4', i, 7), true) end") <=
                     1000U);
}

static void too_much_work_in_one_call_is_an_error(void)
{
    expect_error("return ('%f'):rep(6):format(1, 1, 1, 1, 1, 1)", "this call costs more than 2048 units");
    expect_error("return ('%q'):format(('\\0'):rep(1100))", "this call costs more than 2048 units");
    expect_error("return string.pack(('b'):rep(4096))", "this call costs more than 2048 units");
    expect_error("local t = {} for i = 1, 120 do t[i] = i end return table.concat(t)",
                 "this call costs more than 2048 units");
    expect_error("local s = ('x'):rep(4000) return s .. s", "a text is longer than 4096 octets");
    expect_error("local s = ('x'):rep(4096) return s .. 'x'", "a text is longer than 4096 octets");
    (void)memset(code, (int)'x', sizeof code);
    (void)memcpy(code, "return '", 8U);
    (void)memcpy(&code[8U + PROCEDURE_STRING_MAX + 1U], "'", 2U);
    expect_error(code, "a text is longer than 4096 octets");
    expect_error("local t = {} for i = 1, 2000 do t[i] = i end", "not enough memory");
    expect_error("local t = {} for i = 1, 300 do t['k' .. i] = i end", "not enough memory");
    expect_events(
        "local t = {} for i = 1, 1024 do t[i] = i end for i = 1, 256 do t['k' .. i] = i end "
        "if #(('x'):rep(2048) .. ('x'):rep(2048)) == 4096 then event(1) end "
        "local ok = pcall(function() return ('x'):rep(4096) .. 'x' end) if not ok then event(2) end",
        "1 2");
    expect_error("pcall(function() return ('x'):rep(4096) .. 'x' end) local s = {} error('mine')", "mine");
}

static void a_metatable_keeps_its_content_after_it_is_set(void)
{
    static const char* const same[] = {
        "local m = {} local t = setmetatable({}, m) m.__index = {x = 1} return t.x == nil",
        "local m = {} local t = setmetatable({}, m) return getmetatable(t) == m",
        "local m = {__index = {x = 1}} m.__index.y = 2 local t = setmetatable({}, m) return t.x == 1 and t.y "
        "== 2",
        "local a = {} local t = setmetatable({}, {__newindex = a}) t.x = 5 return a.x == 5 and rawget(t, "
        "'x') == nil",
        "local t = setmetatable({}, {__newindex = function(t, k, v) rawset(t, k, v + 1) end}) t.x = 1 return "
        "t.x == 2",
        "local C = {} C.__index = C function C.f() return 4 end return setmetatable({}, C).f() == 4",
        "return setmetatable({}, {__call = function(_, x) return x end})(3) == 3",
        "return getmetatable({}) == nil and getmetatable(setmetatable({}, {__metatable = false})) == false",
        "local m = {__add = function() return 1 end, __sub = function() return 2 end, __mul = function() "
        "return 3 end, "
        "__div = function() return 4 end, __mod = function() return 5 end, __pow = function() return 6 end} "
        "local t = setmetatable({}, m) return t + t == 1 and t - t == 2 and t * t == 3 and t / t == 4 and t "
        "% t == 5 "
        "and t ^ t == 6",
        "local m = {__idiv = function() return 1 end, __band = function() return 2 end, __bor = function() "
        "return 3 end, "
        "__bxor = function() return 4 end, __shl = function() return 5 end, __shr = function() return 6 end} "
        "local t = setmetatable({}, m) return t // t == 1 and t & t == 2 and t | t == 3 and t ~ t == 4 and t "
        "<< t == 5 "
        "and t >> t == 6",
        "local m = {__unm = function() return 1 end, __bnot = function() return 2 end, __len = function() "
        "return 3 end, "
        "__concat = function() return 4 end, __eq = function() return true end, __lt = function() return "
        "true end, "
        "__le = function() return false end} local t, u = setmetatable({}, m), setmetatable({}, m) "
        "return -t == 1 and ~t == 2 and #t == 3 and t .. t == 4 and t == u and t < u and not (t <= u)",
        "local t = setmetatable(setmetatable({}, {__index = {x = 1}}), nil) return t.x == nil and "
        "getmetatable(t) == nil",
    };
    for (size_t i = 0U; i < (sizeof same / sizeof same[0]); i++) {
        (void)snprintf(code, sizeof code, "local function f() %s end if f() then event(1) end", same[i]);
        expect_events(code, "1");
    }
    expect_error("return setmetatable({}, {__call = setmetatable({}, {__call = print})})",
                 "__call: expected a function");
    expect_error("return setmetatable(1, {})", "table expected");
    expect_error("return setmetatable({}, 1)", "nil or table expected");
    // A weak table would show when memory is collected.
    expect_events("local m = {} local t = setmetatable({}, m) m.__mode = 'v' t[1] = {} "
                  "for i = 1, 3000 do local x = {} end if t[1] then event(1) end",
                  "1");
}

static void cost_beyond_the_budget_is_deducted_before_the_procedure_continues(void)
{
    const pus_answer_t answer = {.kind = PUS_ANSWER_NONE};
    begin(0U, "local a, b = ('\\0'):rep(4096), ('\\0'):rep(4096) step(1) local c = a < b event(2)");
    while (host.call.kind != PUS_CALL_STEP) {
        host.port.grant(host.port.context, 0U, BUDGET);
        host.port.run(host.port.context, 0U, &answer, &host.call);
    }
    unsigned budgets = 0U;
    for (host.call.kind = PUS_CALL_PAUSED; host.call.kind == PUS_CALL_PAUSED; budgets++) {
        host.port.grant(host.port.context, 0U, 100U);
        host.port.run(host.port.context, 0U, &answer, &host.call);
        TEST_ASSERT_TRUE((budgets == 0U) || (host.call.kind != PUS_CALL_PAUSED) ||
                         (host.port.used(host.port.context, 0U) <= 1100U));
    }
    TEST_ASSERT_EQUAL(PUS_CALL_EVENT, host.call.kind);
    TEST_ASSERT_TRUE((budgets >= 10U) && (budgets <= 30U)); // More than 1024 units, 100 in each.
}

static void a_call_costs_a_unit_more_from_the_twentieth_octet_of_its_arguments(void)
{
    const uint32_t units = units_of("get('123456789012345678')");
    TEST_ASSERT_EQUAL_UINT32(units, units_of("get('1234567890123456789')"));
    TEST_ASSERT_EQUAL_UINT32(units + 1U, units_of("get('12345678901234567890')"));
}

/// Both have a base price of 3 units; math.max costs a unit more for each argument.
static void only_some_functions_cost_more_with_each_argument(void)
{
    TEST_ASSERT_EQUAL_UINT32(units_of("math.ult(1, 2)") + 2U, units_of("math.max(1, 2)"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_program_uses_more_than_its_share);
    RUN_TEST(the_cost_of_a_procedure_depends_on_its_code_alone);
    RUN_TEST(an_operation_costs_at_least_the_units_of_its_work);
    RUN_TEST(ordinary_programs_are_cheap);
    RUN_TEST(too_much_work_in_one_call_is_an_error);
    RUN_TEST(a_metatable_keeps_its_content_after_it_is_set);
    RUN_TEST(cost_beyond_the_budget_is_deducted_before_the_procedure_continues);
    RUN_TEST(a_call_costs_a_unit_more_from_the_twentieth_octet_of_its_arguments);
    RUN_TEST(only_some_functions_cost_more_with_each_argument);
    return UNITY_END();
}
