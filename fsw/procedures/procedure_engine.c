// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_engine.h"

#include "base/assertion.h"
#include "base/text.h"
#include "fsw/procedures/procedure_cost.h"
#include "fsw/procedures/procedure_sandbox.h"

#include <lua5.4/lauxlib.h>
#include <string.h>

#define CHUNK_NAME_MAX 32U
#define SHORTEST 40U // Texts up to this size are shared, and cost only the instruction [octets].
// The garbage collector works in small steps: pause and speed [percent], log2 of the step size.
#define COLLECTOR_PAUSE 200
#define COLLECTOR_SPEED 100
#define COLLECTOR_STEP 8

/// Arguments of the start of a procedure.
typedef struct {
    const char* name;
    const uint8_t* code;
    size_t size;
    const uint8_t* arguments;
    size_t arguments_size;
} beginning_t;

void procedure_engine_init(procedure_engine_t* const engine, procedure_slot_t* const slots,
                           const uint16_t count, uint64_t* const memory, const size_t memory_size,
                           uint8_t* const map)
{
    FSW_ASSERT((engine != NULL) && (slots != NULL) && (memory != NULL) && (map != NULL));
    *engine = (procedure_engine_t){.slots = slots, .count = count};
    for (uint16_t i = 0U; i < count; i++) {
        slots[i] = (procedure_slot_t){.memory      = &memory[i * (memory_size / sizeof(uint64_t))],
                                      .memory_size = memory_size,
                                      .map         = &map[i * PROCEDURE_BLOCKS(memory_size)]};
    }
}

static void note_stack(procedure_slot_t* const slot, const void* const stack, const size_t size)
{
    slot->stack      = stack;
    slot->stack_size = (size > slot->stack_size) ? (uint32_t)size : slot->stack_size;
}

/// Track address and size of the procedure's stack. The interpreter allocates it together with the thread;
/// to change its size, it allocates a new list, copies the content and frees the old list. `result` is null
/// if `block` was freed.
static void follow_stack(procedure_slot_t* const slot, const void* const block, const size_t before,
                         const void* const result, const size_t after)
{
    if ((block == NULL) && (before == 0U)) {
        slot->list      = result;
        slot->list_size = after;
        if (slot->is_making_thread) {
            note_stack(slot, result, after);
        }
    } else if ((block != NULL) && (block == slot->stack)) {
        note_stack(slot, (result != NULL) ? result : slot->list, (result != NULL) ? after : slot->list_size);
    } else {
        // The block is not the stack.
    }
}

/// Allocator of the interpreter; the interpreter uses no other memory.
static void* allocate(void* const context, void* const block, const size_t before, const size_t after)
{
    procedure_slot_t* const slot = context;
    void* result                 = NULL;
    if (after == 0U) {
        if (block != NULL) {
            follow_stack(slot, block, before, NULL, 0U);
            procedure_heap_give(&slot->heap, block, before);
        }
        return NULL;
    }
    if (!procedure_may_take(slot, block, before, after)) {
        procedure_charge_collection(slot);
        return NULL;
    }
    if (block == NULL) {
        result = procedure_heap_take(&slot->heap, after);
    } else {
        result = procedure_heap_resize(&slot->heap, block, before, after);
    }
    if (result == NULL) {
        procedure_charge_collection(slot);
        return NULL;
    }
    slot->is_too_long = false;
    follow_stack(slot, block, before, result, after);
    return result;
}

/// Prepare sandbox, thread, code and arguments. It runs in protected mode, because each step may fail for
/// lack of memory.
static int prepare(lua_State* const state)
{
    const beginning_t* const beginning = lua_touserdata(state, 1);
    procedure_slot_t* const slot       = procedure_slot_of(state);
    char name[CHUNK_NAME_MAX]          = {'='};
    (void)strncat(name, beginning->name, sizeof name - 2U);
    (void)lua_gc(state, LUA_GCINC, COLLECTOR_PAUSE, COLLECTOR_SPEED, COLLECTOR_STEP);
    procedure_sandbox_open(state);
    slot->is_making_thread  = true;
    lua_State* const thread = lua_newthread(state);
    slot->is_making_thread  = false;
    // Without this reference the thread would be collected as garbage.
    lua_setfield(state, LUA_REGISTRYINDEX, "procedure");
    if (luaL_loadbufferx(state, (const char*)beginning->code, beginning->size, name, "t") != LUA_OK) {
        return lua_error(state);
    }
    lua_xmove(state, thread, 1);
    procedure_push_values(thread, beginning->arguments, beginning->arguments_size);
    lua_sethook(thread, procedure_cost_hook, LUA_MASKCOUNT, 1);
    slot->thread = thread;
    return 0;
}

/// Returns the line in an error text "name:line: ..."; 0 if there is none.
static uint32_t line_of(const char* const text)
{
    const char* digit = strchr(text, (int)':');
    uint32_t line     = 0U;
    if (digit == NULL) {
        return 0U;
    }
    for (digit++; (*digit >= '0') && (*digit <= '9') && (line < 100000U); digit++) {
        line = (line * 10U) + (uint32_t)(*digit - '0');
    }
    return (*digit == ':') ? line : 0U;
}

/// End the procedure with the error on top of the stack of `state`.
static void fail(procedure_slot_t* const slot, lua_State* const state)
{
    const bool is_text = lua_type(state, -1) == LUA_TSTRING;
    text_t text        = text_in(slot->text, sizeof slot->text);
    if (slot->is_too_long) {
        text_add_pattern(&text, "a text is longer than # octets", NULL, NULL, PROCEDURE_STRING_MAX);
    } else {
        text_add(&text, is_text ? lua_tostring(state, -1) : "error that is not a text");
    }
    slot->is_running = false;
    slot->call = (pus_call_t){.kind = PUS_CALL_FAILED, .number = line_of(slot->text), .text = slot->text};
}

static procedure_slot_t* slot_at(void* const context, const uint16_t index)
{
    const procedure_engine_t* const engine = context;
    FSW_ASSERT(index < engine->count);
    return &engine->slots[index];
}

/// True if the code contains a NUL or an escape sequence for it in a text: `\0`, `\x00`, `\u{0}`.
static bool may_have_nul(const uint8_t* const code, const size_t size)
{
    bool may = false;
    for (size_t i = 0U; i < size; i++) {
        const bool is_escape = (code[i] == (uint8_t)'\\') && ((i + 1U) < size);
        const uint8_t kind   = is_escape ? code[i + 1U] : 0U;
        may =
            may || (code[i] == 0U) || (is_escape && ((kind == 0x30U) || (kind == 0x75U) || (kind == 0x78U)));
    }
    return may;
}

static status_t start(void* const context, const uint16_t index, const char* const name,
                      const uint8_t* const code, const size_t size, const uint8_t* const arguments,
                      const size_t arguments_size, pus_call_t* const out_call)
{
    procedure_slot_t* const slot = slot_at(context, index);
    FSW_ASSERT(!slot->is_running && (name != NULL) && (code != NULL) && (arguments != NULL));
    beginning_t beginning = {name, code, size, arguments, arguments_size};
    *slot                 = (procedure_slot_t){.memory      = slot->memory,
                                               .memory_size = slot->memory_size,
                                               .map         = slot->map,
                                               .longest     = SHORTEST,
                                               .code_size   = (uint32_t)size,
                                               .has_nul     = may_have_nul(code, size),
                                               .call        = {.text = ""}};
    procedure_heap_init(&slot->heap, slot->memory, slot->memory_size, slot->map);
    lua_State* const state = lua_newstate(allocate, slot);
    if (state == NULL) {
        *out_call = (pus_call_t){.kind = PUS_CALL_FAILED, .text = "not enough memory"};
        return STATUS_EXHAUSTED;
    }
    procedure_slot_bind(state, slot);
    lua_pushcfunction(state, prepare);
    lua_pushlightuserdata(state, &beginning);
    const int status = lua_pcall(state, 1, 0, 0);
    if (status != LUA_OK) {
        fail(slot, state);
        *out_call = slot->call;
        return (status == LUA_ERRMEM) ? STATUS_EXHAUSTED : STATUS_INVALID;
    }
    slot->is_running = true;
    slot->spent      = 0U; // A start is not charged: the size of the code limits its cost.
    slot->budget     = 0U;
    slot->used       = 0U;
    slot->grace      = 0U;
    return STATUS_OK;
}

static void grant(void* const context, const uint16_t index, const uint32_t budget)
{
    procedure_slot_t* const slot = slot_at(context, index);
    slot->spent                  = (slot->spent > slot->budget) ? (slot->spent - slot->budget) : 0U;
    slot->budget                 = budget;
    slot->used                   = 0U;
    slot->grace                  = 0U;
}

static uint32_t used(void* const context, const uint16_t index)
{
    return slot_at(context, index)->used;
}

static void run(void* const context, const uint16_t index, const pus_answer_t* const answer,
                pus_call_t* const out_call)
{
    procedure_slot_t* const slot = slot_at(context, index);
    FSW_ASSERT(slot->is_running && (answer != NULL) && (out_call != NULL));
    if ((slot->spent > slot->budget) && (slot->call.kind == PUS_CALL_PAUSED)) {
        *out_call = slot->call; // This budget does not cover the excess of the previous one.
        return;
    }
    lua_State* const thread = slot->thread;
    // Arguments on the stack, in the first run.
    const int arguments = (lua_status(thread) == LUA_OK) ? (lua_gettop(thread) - 1) : 0;
    int results         = 0;
    slot->answer        = *answer;
    slot->call          = (pus_call_t){.text = ""};
    const int status    = lua_resume(thread, NULL, arguments, &results);
    if (status == LUA_OK) {
        slot->is_running = false;
        slot->call.kind  = PUS_CALL_ENDED;
    } else if (status != LUA_YIELD) {
        fail(slot, thread);
    } else {
        // The procedure has made a call, or its budget is used up.
    }
    *out_call = slot->call;
}

static void kill(void* const context, const uint16_t index)
{
    // The memory is cleared when the next procedure starts in this slot.
    slot_at(context, index)->is_running = false;
}

pus_procedure_port_t procedure_engine_port(procedure_engine_t* const engine)
{
    FSW_ASSERT(engine != NULL);
    return (pus_procedure_port_t){engine, engine->count, start, grant, used, run, kill};
}
