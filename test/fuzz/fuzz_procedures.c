// SPDX-License-Identifier: Apache-2.0
// An arbitrary on-board procedure uses a bounded number of units in a cycle, and bounded processor time for
// these units. If the first octet is even, the rest is the code; if it is odd, each octet selects a piece of
// code that is expensive by itself.
#include "fsw/procedures/procedure_cost.h"
#include "test/fuzz/fuzz.h"

#include <string.h>
#include <time.h>

#define MEMORY 262144U
#define BUDGET 2048U
#define CYCLES 40U
#define CODE_MAX 16384U
/// Units beyond the budget: memory that is requested, refused and collected is charged afterwards.
#define OVERSHOOT ((4U * PROCEDURE_ACT_MAX) + PROCEDURE_GRACE)
/// Limit of a cycle [ns]. The most expensive known program takes 0.1 ms.
#define CYCLE_NS_MAX 20000000.0
#define NS_PER_S 1e9

static procedure_slot_t slot;
static uint64_t memory[MEMORY / sizeof(uint64_t)];
static uint8_t map[PROCEDURE_BLOCKS(MEMORY)];

static const char before[] =
    "local s, z, d, f = ('x'):rep(3000), ('\\0'):rep(4096), ('1'):rep(4000), 1.2345e-300 local t, u = {}, {} "
    "local n, k, x = 0, 255, nil for i = 1, 200 do t[i * 255] = i u[i] = i end local m = {__index = t} "
    "while true do n = n + 1 ";

static const char* const pieces[] = {"x = z < z ",
                                     "x = s .. n ",
                                     "x = f .. f .. f ",
                                     "x = t[k] ",
                                     "t[k] = n ",
                                     "k = k + 255 ",
                                     "t[k] = nil ",
                                     "x = #t ",
                                     "u[#u + 1] = n ",
                                     "u = {} ",
                                     "x = {a = 1, b = n} ",
                                     "x = setmetatable({}, m) ",
                                     "m.__index = x ",
                                     "x = x and x.y ",
                                     "pcall(error, s) ",
                                     "pcall(function() local a = nil + 1 end) ",
                                     "x = tonumber(d) ",
                                     "x = tonumber(d, 36) ",
                                     "x = s:upper() ",
                                     "x = s:sub(n % 3000) ",
                                     "x = ('%99.99f'):format(n) ",
                                     "x = ('%q'):format(s:sub(1, 900)) ",
                                     "pcall(string.pack, 'c9000', '') ",
                                     "x = string.packsize(('b'):rep(900)) ",
                                     "x = table.concat(u) ",
                                     "table.sort(u) ",
                                     "for a in pairs(t) do x = a end ",
                                     "x = {table.unpack(u, 1, 200)} ",
                                     "x = select('#', table.unpack(u, 1, 200)) ",
                                     "x = s:find('x-y') ",
                                     "x = s:gsub('x', 'yy', 9) ",
                                     "x = function() return n, k, t, u end ",
                                     "get(n) ",
                                     "event(n % 99 + 1) ",
                                     "if n % 3 == 0 then ",
                                     "end ",
                                     "for i = 1, 9 do ",
                                     "pcall(function() ",
                                     "end) ",
                                     "repeat ",
                                     "until n > 5 ",
                                     "x = ('x'):rep(n % 5000) ",
                                     "x = s:byte(1, 200) ",
                                     "x = math.max(table.unpack(u, 1, 99)) ",
                                     "x = math.fmod(1e308, n) ",
                                     "x = n % 5e-324 ",
                                     "table.insert(u, 1, n) ",
                                     "table.remove(u, 1) ",
                                     "x = rawget(t, k) ",
                                     "x = next "};

/// Make the code from an input. Returns its size.
static size_t make_code(const uint8_t* const data, const size_t size, char* const code)
{
    if ((data[0] & 1U) == 0U) {
        const size_t left = ((size - 1U) < CODE_MAX) ? (size - 1U) : CODE_MAX;
        (void)memcpy(code, &data[1], left);
        return left;
    }
    size_t length = sizeof before - 1U;
    (void)memcpy(code, before, length);
    for (size_t i = 1U; i < size; i++) {
        const char* const piece = pieces[data[i] % (sizeof pieces / sizeof pieces[0])];
        const size_t add        = strlen(piece);
        if ((length + add + 4U) < CODE_MAX) {
            (void)memcpy(&code[length], piece, add);
            length += add;
        }
    }
    (void)memcpy(&code[length], "end", 3U);
    return length + 3U;
}

static double now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return ((double)now.tv_sec * NS_PER_S) + (double)now.tv_nsec;
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    static const uint8_t none[] = {0};
    static char code[CODE_MAX];
    procedure_engine_t engine;
    pus_call_t call;
    if (size < 2U) {
        return 0;
    }
    procedure_engine_init(&engine, &slot, 1U, memory, MEMORY, map);
    const pus_procedure_port_t port = procedure_engine_port(&engine);
    const size_t length             = make_code(data, size, code);
    if (port.start(port.context, 0U, "FUZZ", (const uint8_t*)code, length, none, 1U, &call) != STATUS_OK) {
        FUZZ_CHECK((call.kind == PUS_CALL_FAILED) && (call.text[0] != '\0'));
        return 0;
    }
    uint64_t all = 0U;
    for (unsigned i = 1U; (i <= CYCLES) && slot.is_running; i++) {
        const pus_answer_t answer = {.kind = PUS_ANSWER_MISSING};
        const double begin        = now_ns();
        port.grant(port.context, 0U, BUDGET);
        do {
            port.run(port.context, 0U, &answer, &call);
        } while (slot.is_running && (call.kind != PUS_CALL_PAUSED));
        FUZZ_CHECK((now_ns() - begin) < CYCLE_NS_MAX);
        const uint32_t used = port.used(port.context, 0U);
        all += used;
        FUZZ_CHECK(used <= (BUDGET + OVERSHOOT));
        FUZZ_CHECK(all <= ((i * (uint64_t)(BUDGET + PROCEDURE_GRACE)) + OVERSHOOT));
        FUZZ_CHECK(slot.heap.peak <= MEMORY);
    }
    port.kill(port.context, 0U);
    return 0;
}
