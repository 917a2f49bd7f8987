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

/// Expect that this expression is true.
static void expect_true(const char* const expression)
{
    char code[512] = "if (";
    TEST_ASSERT_TRUE(strlen(expression) < (sizeof code - 32U));
    strcat(code, expression);
    strcat(code, ") == true then event(1) end");
    host.call = (pus_call_t){.kind = PUS_CALL_PAUSED};
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, host_begin(code), host.call.text);
    TEST_ASSERT_TRUE_MESSAGE(host_run(100U), expression);
    TEST_ASSERT_EQUAL_MESSAGE(PUS_CALL_ENDED, host.call.kind, host.call.text);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("event 1 ;ended 0 ;", host.log, expression);
}

static void texts_are_composed_and_decomposed(void)
{
    static const char* const cases[] = {
        "('ab'):rep(3) == 'ababab'",
        "('ab'):rep(3, '-') == 'ab-ab-ab'",
        "('ab'):rep(0) == '' and ('ab'):rep(-1) == ''",
        "('ab'):rep(1, '-') == 'ab'",
        "#('x'):rep(4096) == 4096",
        "('Ab'):lower() == 'ab' and ('Ab'):upper() == 'AB' and ('ab'):reverse() == 'ba' and #'abc' == "
        "('abc'):len()",
        "('abc'):byte(2) == 98 and string.char(97, 98) == 'ab' and ('abc'):sub(-2) == 'bc'",
        "string.pack('>I2I4', 1, 2) == '\\0\\1\\0\\0\\0\\2' and string.unpack('>i2', '\\xff\\xfe') == -2",
        "string.packsize('>I2I4') == 6",
        "('%d %5.2f %s %q %% %x'):format(7, 1.5, 'a', 'b', 255) == '7  1.50 a \"b\" % ff'",
        "('%s %s'):format(nil, true) == 'nil true'",
        "tostring(12) == '12' and tostring(1.5) == '1.5' and tostring(true) == 'true' and tostring('a') == "
        "'a'",
        "tostring(false) == 'false' and tostring(nil) == 'nil' and tostring({}) == 'table'",
        "tonumber('0x10') == 16 and tonumber('z', 36) == 35 and tonumber('x') == nil",
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        expect_true(cases[i]);
    }
}

static void patterns_find_the_text_they_describe(void)
{
    static const char* const cases[] = {
        "('hello world'):find('wor') == 7",
        "select(2, ('hello world'):find('wor')) == 9",
        "('a.b'):find('.', 1, true) == 2 and ('a.b'):find('.', 3, true) == nil",
        "('abc'):find('') == 1 and ('abc'):find('', 4) == 4 and ('abc'):find('', 5) == nil",
        "('abc'):find('c', -1) == 3 and ('abc'):find('a', -9) == 1",
        "('key = value'):match('^(%w+)%s*=%s*(%w+)$') == 'key'",
        "select(2, ('key = value'):match('^(%w+)%s*=%s*(%w+)$')) == 'value'",
        "('abc'):match('()c') == 3",
        "('abc'):match('b') == 'b' and ('abc'):match('x') == nil and ('abc'):match('a', 9) == nil",
        "('aaa'):match('a-') == '' and ('aaab'):match('a-b') == 'aaab' and ('aaac'):match('^a-b') == nil",
        "('aXb'):match('%u') == 'X' and ('aXb'):match('%U') == 'a' and ('a1'):match('%d') == '1'",
        "('a1'):match('%D') == 'a' and (' x'):match('%S') == 'x' and ('\\t'):match('%s') == '\\t'",
        "('-a'):match('%p') == '-' and ('zF'):match('%x') == 'F' and ('\\1a'):match('%c') == '\\1'",
        "('abc'):match('%l+') == 'abc' and ('_a1'):match('%w+') == 'a1' and ('a.b'):match('%.') == '.'",
        "('x]y'):match('[]]') == ']' and ('x-y'):match('[a%-]') == '-' and ('xyz'):match('[^x]') == 'y'",
        "('q7'):match('[0-9]') == '7' and ('q7'):match('[%d]') == '7' and ('ab'):match('[^%a]') == nil",
        "('a-'):match('[a-]+') == 'a-' and ('b'):match('[^a]') == 'b'",
        "('color colour'):match('colou?r', 2) == 'colour' and ('ab'):match('a?ab') == 'ab'",
        "('aab'):match('a?ab') == 'aab' and ('b'):match('a?b') == 'b'",
        "('a$'):match('a$') == nil and ('a$'):match('$$') == '$' and ('a.'):match('.$') == '.'",
        "('xay'):match('(x)(a)(y)') == 'x' and ('nested'):match('((n)e)') == 'ne'",
        "('a,b,,c'):gsub(',', ';') == 'a;b;;c' and select(2, ('a,b,,c'):gsub(',', ';')) == 3",
        "('abc'):gsub('', '-') == '-a-b-c-'",
        "('abc'):gsub('%w', '%0%0', 2) == 'aabbc' and ('abc'):gsub('(a)(b)', '%2%1') == 'bac'",
        "('abc'):gsub('b', '%1') == 'abc' and ('abc'):gsub('b', '%%') == 'a%c' and ('abc'):gsub('b', 7) == "
        "'a7c'",
        "('abc'):gsub('%w', {a = 'x', b = false}) == 'xbc'",
        "('abc'):gsub('%w', function(c) if c ~= 'b' then return c .. c end end) == 'aabcc'",
        "('hello'):gsub('^h', 'j') == 'jello' and ('hhh'):gsub('^h', 'j') == 'jhh' and ('ab'):gsub('^b', "
        "'c') == 'ab'",
        "(function() local n = 0 for w in ('one two  three'):gmatch('%a+') do n = n + #w end return n end)() "
        "== 11",
        "(function() local s = '' for k, v in ('a=1, b=2'):gmatch('(%w+)=(%w+)') do s = s .. k .. v end "
        "return s end)() "
        "== 'a1b2'",
        "(function() local n = 0 for _ in ('abc'):gmatch('') do n = n + 1 end return n end)() == 4",
        "string.find(12345, '34') == 3",
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        expect_true(cases[i]);
    }
    expect_error("return string.find({}, 'a')", "string expected");
    expect_error("return ('a'):find(1)", "string expected");
    expect_error("return ('abc'):gsub('a', '%2')", "invalid use");
    expect_error("return ('abc'):gsub('a', '%')", "invalid use");
    expect_error("return ('abc'):find('(a')", "malformed pattern");
    expect_error("return ('abc'):find('a[b')", "malformed pattern");
}

static void tables_mathematics_and_protected_calls_work_as_in_lua(void)
{
    static const char* const cases[] = {
        "table.concat({1, 'a', 2.5}, ', ') == '1, a, 2.5' and table.concat({}) == ''",
        "table.concat({'a', 'b', 'c'}, '', 2) == 'bc' and table.concat({'a', 'b', 'c'}, '-', 1, 2) == 'a-b'",
        "(function() local t = {1, 3} table.insert(t, 4) table.insert(t, 2, 2) return table.concat(t) end)() "
        "== '1234'",
        "(function() local t = {1, 2, 3} local r = table.remove(t, 1) return r .. table.concat(t) end)() == "
        "'123'",
        "(function() local t = {1, 2, 3} return table.remove(t) == 3 and #t == 2 and table.remove({}) == nil "
        "end)()",
        "(function() local t = {3, 1, 2, 5, 4} table.sort(t) return table.concat(t) end)() == '12345'",
        "(function() local t = {3, 1, 2} table.sort(t, function(a, b) return a > b end) return "
        "table.concat(t) end)() "
        "== '321'",
        "select('#', table.unpack({1, 2, nil, 4}, 1, 4)) == 4 and select('#', table.unpack({})) == 0",
        "select(2, table.unpack({7, 8, 9}, 2)) == 9",
        "(function() local n = 0 for i, v in ipairs({5, 6, nil, 7}) do n = n + i * v end return n end)() == "
        "17",
        "(function() local t = {a = 1, b = 2} for k in pairs(t) do t.b = nil end return t.a end)() == 1",
        "(function() local s = '' for k in pairs({[true] = 1, [false] = 1}) do s = s .. tostring(k) end "
        "return s end)() == 'falsetrue'",
        "(function() local s = '' for k in pairs({1, [true] = 1, [false] = 1}) do s = s .. tostring(k) end "
        "return s end)() == '1falsetrue'",
        "(function() local s = '' for k in pairs({ba = 1, b = 1, c = 1, a = 1, ab = 1}) do s = s .. k .. ' ' "
        "end return s end)() == 'a ab b ba c '",
        "(function() local s = '' for k in pairs({c = 1, ab = 1, a = 1, ba = 1, b = 1}) do s = s .. k .. ' ' "
        "end return s end)() == 'a ab b ba c '",
        "rawequal('a', 'a') and rawlen({1, 2}) == 2 and rawget({a = 1}, 'a') == 1 and rawset({}, 1, 2)[1] == "
        "2",
        "getmetatable(setmetatable({}, {__metatable = 'no'})) == 'no' and getmetatable({}) == nil",
        "(setmetatable({}, {__index = function(_, k) return k .. '!' end})).x == 'x!'",
        "setmetatable(setmetatable({}, {}), nil) ~= nil",
        "math.floor(2.5) == 2 and math.max(1, 2) == 2 and math.tointeger(3.0) == 3 and math.type(1) == "
        "'integer'",
        "math.sqrt(9) == 3 and math.abs(-1) == 1 and math.huge > math.maxinteger and math.ult(1, -1)",
        "select('#', pcall(error, 'x')) == 2 and pcall(error) == false and type(nil) == 'nil' and assert(1) "
        "== 1",
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        expect_true(cases[i]);
    }
    expect_error("table.insert({}, 3, 1)", "position out of bounds");
    expect_error("table.insert({}, 'x', 1)", "position out of bounds");
    expect_error("table.remove({1}, 3)", "position out of bounds");
    expect_error("table.concat({{}})", "invalid value");
    expect_error("table.concat({'a'}, '', 1, 3)", "invalid value");
    expect_error("table.concat({('x'):rep(2100), ('x'):rep(2100)})", "too large");
    expect_error("table.unpack({}, 1, 251)", "too many results");
    expect_error("table.unpack({}, math.mininteger, math.maxinteger)", "too many results");
    expect_error("setmetatable(setmetatable({}, {__metatable = 1}), {})", "protected");
    expect_error("setmetatable({}, 1)", "nil or table expected");
    expect_error("ipairs(1)", "table expected");
    expect_error("pairs(1)", "table expected");
    expect_error("tostring()", "value expected");
}

static void a_sort_with_an_inconsistent_comparison_ends(void)
{
    expect_events(
        "local t = {} for i = 1, 100 do t[i] = i end table.sort(t, function() return true end) event(1)",
        "1");
    expect_error("table.sort({1, 'a'})", "attempt to compare");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(texts_are_composed_and_decomposed);
    RUN_TEST(patterns_find_the_text_they_describe);
    RUN_TEST(tables_mathematics_and_protected_calls_work_as_in_lua);
    RUN_TEST(a_sort_with_an_inconsistent_comparison_ends);
    return UNITY_END();
}
