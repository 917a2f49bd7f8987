// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/procedures/procedures.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    host_start();
}

void tearDown(void)
{
}

/// Expect that a procedure without an end uses its budgets and no more, and can be killed.
static void expect_endless(const char* const code)
{
    host.call = (pus_call_t){.kind = PUS_CALL_PAUSED};
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, host_begin(code), host.call.text);
    TEST_ASSERT_FALSE_MESSAGE(host_run(300U), host.call.text);
    TEST_ASSERT_UINT_WITHIN(1U, 300U, host.pauses); // The last budget may have ended within another call.
    host.port.kill(host.port.context, 0U);
    TEST_ASSERT_FALSE(host.slots[0].is_running);
    expect_events("event(1)", "1"); // A new procedure can use the slot.
}

static void a_procedure_can_call_its_host(void)
{
    static const char code[] = "step(5) wait(1.5)\n"
                               "local ok, code, detail = send(16, 17, 1)\n"
                               "if ok and code == 0 then event(1) end\n"
                               "ok, code, detail = send(17, 20, 3, '\\0\\1x', true)\n"
                               "if not ok and code == 0x402 and detail == 7 then event(2) end\n"
                               "if get(77) == -2 and get(0) == nil and get('VALUE') == 5 then event(3) end\n"
                               "local list = parameters(3)\n"
                               "if #list == 2 and list[1] == 0x1234 and list[2] == true then event(4) end\n"
                               "parameters()\n"
                               "if event(5) and not event(1005) then event(6) end\n";
    expect_events(code, "1 2 3 4 5 1005 6");
    TEST_ASSERT_EQUAL_STRING(
        "step 5 ;wait 0 ;send 0 ;event 1 ;send 0 ;event 2 ;get 77 ;get 0 ;named 0 VALUE;event 3 ;"
        "parameters 0 ;event 4 ;parameters 0 ;event 5 ;event 1005 ;event 6 ;ended 0 ;",
        host.log);
}

static void a_call_returns_the_request_of_the_procedure(void)
{
    const pus_answer_t answer = {.kind = PUS_ANSWER_NONE};
    TEST_ASSERT_EQUAL(STATUS_OK,
                      host_begin("wait(2.5) send(16, 129, 1, 'ab\\0c', true) parameters(4) parameters()"));
    host.port.grant(host.port.context, 0U, HOST_BUDGET);
    host.port.run(host.port.context, 0U, &answer, &host.call);
    TEST_ASSERT_EQUAL(PUS_CALL_WAIT, host.call.kind);
    TEST_ASSERT_TRUE(host.call.seconds == 2.5);
    host.port.run(host.port.context, 0U, &answer, &host.call);
    TEST_ASSERT_EQUAL(PUS_CALL_SEND, host.call.kind);
    TEST_ASSERT_EQUAL_UINT16(16U, host.call.apid);
    TEST_ASSERT_EQUAL_UINT8(129U, host.call.service);
    TEST_ASSERT_EQUAL_UINT8(1U, host.call.subtype);
    TEST_ASSERT_TRUE(host.call.does_wait);
    TEST_ASSERT_EQUAL_UINT64(4U, host.call.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("ab\0c", host.call.octets, 4U);
    host.port.run(host.port.context, 0U, &answer, &host.call);
    TEST_ASSERT_TRUE(host.call.seconds == 4.0);
    host.port.run(host.port.context, 0U, &answer, &host.call);
    TEST_ASSERT_TRUE(host.call.seconds == 1e9);
}

static void arguments_have_their_types(void)
{
    // Six arguments of the types INT8 (4), UINT64 (3), FLOAT (8), BOOL (10), DOUBLE (9) and UINT32 (2).
    static const uint8_t arguments[] = {6,    4, 0x80, 3,    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
                                        0xFF, 8, 0x3F, 0xC0, 0,    0,    10,   0,    9,    0xC0, 0,
                                        0,    0, 0,    0,    0,    0,    2,    0xFF, 0xFF, 0xFF, 0xFF};
    static const char code[] =
        "local a, b, c, d, e, f = ...\n"
        "if a == -128 and b == -1 and c == 1.5 and d == false and e == -2.0 and f == 0xFFFFFFFF\n"
        "and select('#', ...) == 6 then event(1) end";
    host.call = (pus_call_t){.kind = PUS_CALL_PAUSED};
    TEST_ASSERT_EQUAL(STATUS_OK, host.port.start(host.port.context, 0U, "ARGS", (const uint8_t*)code,
                                                 strlen(code), arguments, sizeof arguments, &host.call));
    TEST_ASSERT_TRUE(host_run(100U));
    TEST_ASSERT_EQUAL_STRING("event 1 ;ended 0 ;", host.log);
}

static void errors_contain_their_line(void)
{
    expect_error("local x = 1\n\nerror('no good')", "TEST:3: no good");
    TEST_ASSERT_EQUAL_UINT32(3U, host.call.number);
    expect_error("event(1)\nx = = 2", "TEST:2:");
    TEST_ASSERT_EQUAL_UINT32(2U, host.call.number);
    expect_error("error({})", "error that is not a text");
    TEST_ASSERT_EQUAL_UINT32(0U, host.call.number);
    expect_error("error('a:', 0)", "a:");
    TEST_ASSERT_EQUAL_UINT32(0U, host.call.number);
    expect_error("error('b:12', 0)", "b:12");
    TEST_ASSERT_EQUAL_UINT32(0U, host.call.number);
    expect_error("error('c:99999999999:', 0)", "c:");
    expect_error("error(('yz'):rep(2000), 0)", "yzyz");
    TEST_ASSERT_EQUAL_UINT64(PROCEDURE_TEXT_MAX - 1U, strlen(host.call.text));
}

/// An error contains at most thirty characters of the procedure's name.
static void errors_contain_the_name_of_their_procedure(void)
{
    static const char code[]    = "error('x')";
    static const uint8_t none[] = {0};
    for (unsigned length = 29U; length <= 32U; length++) {
        char name[40]     = "";
        char expected[40] = "";
        (void)memset(name, 'n', length);
        (void)memset(expected, 'n', (length < 30U) ? length : 30U);
        (void)strcat(expected, ":1: x");
        host.port.kill(host.port.context, 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, host.port.start(host.port.context, 0U, name, (const uint8_t*)code,
                                                     sizeof code - 1U, none, 1U, &host.call));
        TEST_ASSERT_TRUE(host_run(10U));
        TEST_ASSERT_EQUAL_STRING(expected, host.call.text);
    }
}

static void a_call_with_an_argument_out_of_its_range_ends_the_procedure_with_an_error(void)
{
    static const char* const bad[] = {
        "step(0)",
        "step(65536)",
        "step()",
        "step(1.5)",
        "wait(-1)",
        "wait(0/0)",
        "wait(1e10)",
        "wait('x')",
        "send(2047, 1, 1)",
        "send(-1, 1, 1)",
        "send(1, 0, 1)",
        "send(1, 256, 1)",
        "send(1, 1, 0)",
        "send(1, 1, 256)",
        "send(1, 1, 1, {})",
        "send(1, 1, 1, ('x'):rep(1025))",
        "get()",
        "get({})",
        "get(-1)",
        "get(1 << 32)",
        "get(('x'):rep(64))",
        "get('a\\0b')",
        "event(0)",
        "event(65536)",
        "parameters(-1)",
        "parameters({})",
    };
    for (size_t i = 0U; i < (sizeof bad / sizeof bad[0]); i++) {
        expect_error(bad[i], "bad argument");
    }
    expect_events("step(65535) send(0, 255, 255, ('x'):rep(1024)) wait(0) wait(1e9) get(0xFFFFFFFF) "
                  "get(('x'):rep(63)) event(1)",
                  "1");
}

static void an_endless_loop_uses_up_its_budget_only(void)
{
    expect_endless("while true do end");
    TEST_ASSERT_TRUE(host.worst < (HOST_BUDGET + 16U));
    expect_endless("while true do get(1) end");
    expect_endless("goto a ::a:: goto a");
    expect_endless("local function f() return f() end f()");
    expect_endless("while true do pcall(error, 'x') end");
    expect_endless("while true do pcall(function() while true do end end) end");
    expect_endless("local t = setmetatable({}, {__index = function(t, k) return t[k + 1] end}) "
                   "while true do pcall(function() return t[1] end) end");
    expect_endless("table.sort({3, 2, 1}, function() while true do end end)");
    expect_endless("(('x'):rep(30)):gsub('x', function() while true do end end)");
    expect_endless("for _ in (function() return true end) do end");
    expect_endless("local t = setmetatable({}, {__lt = function() while true do end end}) return t < t");
    expect_endless(
        "local t = setmetatable({}, {__concat = function() while true do end end}) return t .. 'x'");
    expect_endless(
        "local t = setmetatable({}, {__index = function() while true do end end}) for _ in ipairs(t) do end");
}

static void deep_recursion_is_an_error(void)
{
    expect_error("local function f(n) return 1 + f(n + 1) end f(1)", "");
    expect_error(
        "local t = {} t = setmetatable(t, {__index = function(t, k) return t[k + 1] end}) return t[1]", "");
    expect_error("return ('x'):rep(20000):match(('(x'):rep(20000))", "");
    char nested[4000];
    memset(nested, '(', sizeof nested);
    nested[sizeof nested - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_INVALID, host_begin(nested));
    TEST_ASSERT_NOT_NULL(strstr(host.call.text, "overflow"));
}

static void a_procedure_that_uses_too_much_memory_gets_an_error(void)
{
    expect_error("local t = {} while true do t[#t + 1] = {} end", "not enough memory");
    expect_error("local s = 'x' while true do s = s .. s end", "");
    expect_error("local t = {} for i = 1, 1e9 do t[i] = i end", "not enough memory");
    expect_error("return ('x'):rep(1e9)", "too large");
    expect_error("return (''):rep(1e9, 'xy')", "too large");
    expect_error("return string.pack('c2147483000', '')", "not enough memory");
    expect_events(
        "if ('')  :rep(1e15) == '' then event(1) end "
        "if not pcall(function() local t = {} while true do t[#t + 1] = {} end end) then event(2) end",
        "1 2");
    expect_endless("while true do pcall(function() local t = {} while true do t[#t + 1] = {} end end) end");
    TEST_ASSERT_TRUE(host.slots[0].heap.peak <= HOST_MEMORY);
}

static void pathological_patterns_use_up_the_cost_budget(void)
{
    expect_endless("return ('a'):rep(200):match(('a*'):rep(40) .. 'b')");
    expect_endless("return ('a'):rep(4096):find('.-.-.-.-b')");
    expect_error("return ('x'):find('[')", "malformed pattern");
    expect_error("return ('x'):find('%')", "malformed pattern");
    expect_error("return ('x'):find('%b()')", "malformed pattern");
    expect_error("return ('x'):find('%1')", "malformed pattern");
    expect_error("return ('x'):find(')')", "malformed pattern");
    expect_error("return ('x'):match('(x')", "malformed pattern");
}

static void dangerous_functions_are_absent_from_the_sandbox(void)
{
    static const char* const names[] = {
        "io",         "os",          "package",     "debug",           "require",
        "load",       "loadfile",    "dofile",      "loadstring",      "collectgarbage",
        "print",      "warn",        "xpcall",      "coroutine",       "utf8",
        "next",       "string.dump", "math.random", "math.randomseed", "math.sin",
        "table.move", "_G",          "_VERSION",
    };
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        char code[96] = "if ";
        strcat(code, names[i]);
        strcat(code, " == nil then event(1) end");
        expect_events(code, "1");
    }
    expect_error("return coroutine.wrap(function() end)", "coroutine");
    expect_error("return ('').dump(function() end)", "dump");
    expect_events("if getmetatable('') == false then event(1) end", "1");
    expect_error("return setmetatable({}, {__gc = function() while true do end end})", "__gc is not allowed");
    expect_error("return setmetatable({}, {__close = function() end})", "__close is not allowed");
    expect_error("return setmetatable({}, {__mode = 'k'})", "__mode is not allowed");
    expect_error("return '1' + 1", "arithmetic");
}

static void precompiled_code_is_refused(void)
{
    TEST_ASSERT_EQUAL(STATUS_INVALID, host_begin("\x1bLua\x54"));
    TEST_ASSERT_NOT_NULL(strstr(host.call.text, "binary chunk"));
    TEST_ASSERT_FALSE(host.slots[0].is_running);
}

static void an_error_during_error_handling_is_an_error(void)
{
    expect_error("error(setmetatable({}, {__tostring = function() error('again') end}))", "not a text");
    expect_error("local ok, e = pcall(function() error(function() error('x') end) end) e()", "x");
    expect_error("local t = setmetatable({}, {__index = function() error('deep') end}) return t.x", "deep");
    expect_error("local x <close> = setmetatable({}, {}) ", "non-closable");
    expect_events("local mt = {} local t = setmetatable({}, mt) mt.__close = function() event(2) end "
                  "pcall(function() local x <close> = t error('a') end) event(3)",
                  "3");
}

static void the_same_code_gives_the_same_calls_in_every_slot(void)
{
    static const char code[] =
        "local t = {z = 1, [3] = 1, a = 1, [true] = 1, [2.5] = 1, [false] = 1, aa = 1, [1] = 1}\n"
        "for k, v in pairs(t) do get(tostring(k)) end\n"
        "get(tostring({})) get(tostring(print)) get(tostring(event)) get(tostring(nil)) get(tostring(2))\n"
        "for i = 1, 1000 do t[i] = i end local n = 0 for k in pairs(t) do n = n + 1 end step(n)";
    char first[HOST_LOG_MAX];
    host.call = (pus_call_t){.kind = PUS_CALL_PAUSED};
    TEST_ASSERT_EQUAL(STATUS_OK, host_begin(code));
    TEST_ASSERT_TRUE(host_run(1000U));
    TEST_ASSERT_EQUAL_STRING(
        "named 0 1;named 0 2.5;named 0 3;named 0 a;named 0 aa;named 0 z;named 0 false;named 0 true;"
        "named 0 table;named 0 nil;named 0 function;named 0 nil;named 0 2;step 1006 ;ended 0 ;",
        host.log);
    const unsigned pauses = host.pauses;
    memcpy(first, host.log, sizeof first);
    for (unsigned i = 0U; i < 5U; i++) {
        host.call = (pus_call_t){.kind = PUS_CALL_PAUSED};
        TEST_ASSERT_EQUAL(STATUS_OK, host_begin(code));
        TEST_ASSERT_TRUE(host_run(1000U));
        TEST_ASSERT_EQUAL_STRING(first, host.log);
        TEST_ASSERT_EQUAL_UINT(pauses, host.pauses);
    }
    expect_error("for k in pairs({[{}] = 1}) do end", "no order");
    expect_error("return ('%p'):format('x')", "%p is not allowed");
    expect_error("return ('%-5p'):format('x')", "%p is not allowed");
    expect_error("return ('%s'):format({})", "expected");
}

static void slots_share_no_data(void)
{
    static const uint8_t none[] = {0};
    const pus_answer_t answer   = {.kind = PUS_ANSWER_NONE};
    pus_call_t call;
    TEST_ASSERT_EQUAL(STATUS_OK,
                      host.port.start(host.port.context, 0U, "A", (const uint8_t*)"x = 1 step(1) event(x)",
                                      22U, none, 1U, &call));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      host.port.start(host.port.context, 1U, "B", (const uint8_t*)"step(x and 7 or 2) x = 3",
                                      24U, none, 1U, &call));
    for (uint16_t slot = 0U; slot < 2U; slot++) {
        host.port.grant(host.port.context, slot, HOST_BUDGET);
        host.port.run(host.port.context, slot, &answer, &call);
        TEST_ASSERT_EQUAL(PUS_CALL_STEP, call.kind);
        TEST_ASSERT_EQUAL_UINT32(slot + 1U, call.number);
    }
    host.port.run(host.port.context, 1U, &answer, &call);
    TEST_ASSERT_EQUAL(PUS_CALL_ENDED, call.kind);
    host.port.run(host.port.context, 0U, &answer, &call);
    TEST_ASSERT_EQUAL(PUS_CALL_EVENT, call.kind);
    TEST_ASSERT_EQUAL_UINT32(1U, call.number);
}

static void without_memory_no_procedure_starts(void)
{
    static const uint8_t none[] = {0};
    static uint64_t memory[65536U / sizeof(uint64_t)];
    static uint8_t map[PROCEDURE_BLOCKS(65536U)];
    pus_call_t call;
    size_t enough = 0U;
    for (size_t size = PROCEDURE_BLOCK; size <= sizeof memory; size += 512U) {
        procedure_engine_t engine;
        procedure_slot_t slot;
        procedure_engine_init(&engine, &slot, 1U, memory, size - (size % PROCEDURE_BLOCK), map);
        const pus_procedure_port_t port = procedure_engine_port(&engine);
        const status_t status = port.start(port.context, 0U, "A", (const uint8_t*)"", 0U, none, 1U, &call);
        if (status == STATUS_OK) {
            enough = (enough == 0U) ? size : enough;
        } else {
            TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, status);
            TEST_ASSERT_EQUAL_STRING("not enough memory", call.text);
            TEST_ASSERT_FALSE(slot.is_running);
        }
    }
    TEST_ASSERT_TRUE((enough > 0U) && (enough <= 65536U));
}

/// Values that one instruction leaves on the stack for the next are not changed by a pause between the two.
static void a_pause_after_any_instruction_changes_no_result(void)
{
    static const char code[] = "local function three() return 1, 2, 3 end\n"
                               "local function count(...) return select('#', ...) end\n"
                               "local function same(...) return ... end\n"
                               "local list = {three()}\n"
                               "if count(three()) == 3 and count(same(three())) == 3 and #list == 3 and\n"
                               "select(3, three()) == 3 and count(0, three()) == 4 then event(1) end";
    pus_answer_t answer      = {.kind = PUS_ANSWER_NONE};
    unsigned pauses          = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, host_begin(code));
    host.call.kind = PUS_CALL_PAUSED;
    while (host.call.kind == PUS_CALL_PAUSED) {
        host.port.grant(host.port.context, 0U, 1U);
        host.port.run(host.port.context, 0U, &answer, &host.call);
        pauses++;
    }
    TEST_ASSERT_EQUAL_MESSAGE(PUS_CALL_EVENT, host.call.kind, host.call.text);
    TEST_ASSERT_TRUE(pauses > 50U);
}

/// The engine needs this size to compute the cost of a call.
static void the_size_of_the_stack_is_known_before_and_after_it_grows(void)
{
    expect_events("event(1)", "1");
    const uint32_t small = host.slots[0].stack_size;
    TEST_ASSERT_TRUE((small > 16U) && (small < 2048U));
    expect_events("local function f(n) if n > 0 then return 1 + f(n - 1) end return 0 end "
                  "if f(100) == 100 then event(1) end",
                  "1");
    TEST_ASSERT_TRUE(host.slots[0].stack_size >
                     (100U * 3U * 16U)); // Function, argument and sum of each call.
    expect_events("event(1)", "1");
    TEST_ASSERT_EQUAL_UINT32(small, host.slots[0].stack_size);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_procedure_can_call_its_host);
    RUN_TEST(a_call_returns_the_request_of_the_procedure);
    RUN_TEST(arguments_have_their_types);
    RUN_TEST(errors_contain_their_line);
    RUN_TEST(errors_contain_the_name_of_their_procedure);
    RUN_TEST(a_call_with_an_argument_out_of_its_range_ends_the_procedure_with_an_error);
    RUN_TEST(an_endless_loop_uses_up_its_budget_only);
    RUN_TEST(deep_recursion_is_an_error);
    RUN_TEST(a_procedure_that_uses_too_much_memory_gets_an_error);
    RUN_TEST(pathological_patterns_use_up_the_cost_budget);
    RUN_TEST(dangerous_functions_are_absent_from_the_sandbox);
    RUN_TEST(precompiled_code_is_refused);
    RUN_TEST(an_error_during_error_handling_is_an_error);
    RUN_TEST(the_same_code_gives_the_same_calls_in_every_slot);
    RUN_TEST(slots_share_no_data);
    RUN_TEST(without_memory_no_procedure_starts);
    RUN_TEST(a_pause_after_any_instruction_changes_no_result);
    RUN_TEST(the_size_of_the_stack_is_known_before_and_after_it_grows);
    return UNITY_END();
}
