// SPDX-License-Identifier: Apache-2.0
#include "fsw/procedures/procedure_engine.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/procedures/procedure_sandbox.h"

#include <lua5.4/lauxlib.h>
#include <string.h>

#define OCTETS_PER_UNIT 16U // Memory taken that costs as much as an instruction.
#define REFUSAL_COST 2000U  // Of memory that is not there: the interpreter has looked for it everywhere.
#define CHUNK_NAME_MAX 32U

/// What a procedure is begun with.
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

/// The interpreter's only way to memory.
static void* allocate(void* const context, void* const block, const size_t before, const size_t after)
{
    procedure_slot_t* const slot = context;
    void* result                 = NULL;
    if (after == 0U) {
        if (block != NULL) {
            procedure_heap_give(&slot->heap, block, before);
        }
        return NULL;
    }
    if (block == NULL) {
        result = procedure_heap_take(&slot->heap, after);
    } else {
        result = procedure_heap_resize(&slot->heap, block, before, after);
    }
    slot->spent += (result != NULL) ? (uint32_t)(after / OCTETS_PER_UNIT) : REFUSAL_COST;
    return result;
}

/// Called every PROCEDURE_CHUNK instructions.
static void look_at_budget(lua_State* const state, lua_Debug* const record)
{
    (void)record;
    procedure_slot_t* const slot = procedure_slot_of(state);
    slot->spent += PROCEDURE_CHUNK;
    if (slot->spent >= slot->budget) {
        slot->call.kind = PUS_CALL_PAUSED;
        (void)lua_yield(state, 0);
    }
}

/// Everything that may fail for lack of memory, protected: sandbox, thread, code and arguments.
static int prepare(lua_State* const state)
{
    const beginning_t* const beginning = lua_touserdata(state, 1);
    procedure_slot_t* const slot       = procedure_slot_of(state);
    char name[CHUNK_NAME_MAX]          = {'='};
    (void)strncat(name, beginning->name, sizeof name - 2U);
    procedure_sandbox_open(state);
    lua_State* const thread = lua_newthread(state);
    lua_setfield(state, LUA_REGISTRYINDEX, "procedure"); // Else it would be collected.
    if (luaL_loadbufferx(state, (const char*)beginning->code, beginning->size, name, "t") != LUA_OK) {
        return lua_error(state);
    }
    lua_xmove(state, thread, 1);
    procedure_push_values(thread, beginning->arguments, beginning->arguments_size);
    lua_sethook(thread, look_at_budget, LUA_MASKCOUNT, (int)PROCEDURE_CHUNK);
    slot->thread = thread;
    return 0;
}

/// Line in an error's text "name:line: ..."; 0 if there is none.
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

/// The procedure is over, by the error on top of the stack of `state`.
static void fail(procedure_slot_t* const slot, lua_State* const state)
{
    const bool is_text     = lua_type(state, -1) == LUA_TSTRING;
    const char* const text = is_text ? lua_tostring(state, -1) : "error that is not a text";
    slot->text[0]          = '\0';
    (void)strncat(slot->text, text, sizeof slot->text - 1U);
    slot->is_running = false;
    slot->call = (pus_call_t){.kind = PUS_CALL_FAILED, .number = line_of(slot->text), .text = slot->text};
}

static procedure_slot_t* slot_at(void* const context, const uint16_t index)
{
    const procedure_engine_t* const engine = context;
    FSW_ASSERT(index < engine->count);
    return &engine->slots[index];
}

static status_t start(void* const context, const uint16_t index, const char* const name,
                      const uint8_t* const code, const size_t size, const uint8_t* const arguments,
                      const size_t arguments_size, pus_call_t* const out_call)
{
    procedure_slot_t* const slot = slot_at(context, index);
    FSW_ASSERT(!slot->is_running && (name != NULL) && (code != NULL) && (arguments != NULL));
    beginning_t beginning = {name, code, size, arguments, arguments_size};
    procedure_heap_init(&slot->heap, slot->memory, slot->memory_size, slot->map);
    slot->spent            = 0U;
    slot->budget           = 0U;
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
    slot->spent      = 0U;
    return STATUS_OK;
}

static void grant(void* const context, const uint16_t index, const uint32_t budget)
{
    procedure_slot_t* const slot = slot_at(context, index);
    slot->spent                  = (slot->spent > slot->budget) ? (slot->spent - slot->budget) : 0U;
    slot->budget                 = budget;
}

static void run(void* const context, const uint16_t index, const pus_answer_t* const answer,
                pus_call_t* const out_call)
{
    procedure_slot_t* const slot = slot_at(context, index);
    FSW_ASSERT(slot->is_running && (answer != NULL) && (out_call != NULL));
    lua_State* const thread = slot->thread;
    const int arguments     = (lua_status(thread) == LUA_OK) ? (lua_gettop(thread) - 1) : 0; // First run.
    int results             = 0;
    slot->answer            = *answer;
    slot->call              = (pus_call_t){.text = ""};
    const int status        = lua_resume(thread, NULL, arguments, &results);
    if (status == LUA_OK) {
        slot->is_running = false;
        slot->call.kind  = PUS_CALL_ENDED;
    } else if (status != LUA_YIELD) {
        fail(slot, thread);
    } else {
        // It has called, or its budget is used up.
    }
    *out_call = slot->call;
}

static void kill(void* const context, const uint16_t index)
{
    slot_at(context, index)->is_running = false; // Its memory is begun anew by the next one.
}

pus_procedure_port_t procedure_engine_port(procedure_engine_t* const engine)
{
    FSW_ASSERT(engine != NULL);
    return (pus_procedure_port_t){engine, engine->count, start, grant, run, kill};
}
