// SPDX-License-Identifier: Apache-2.0
/// On-board control procedures in Lua 5.4, each in a sandbox on memory of its own: behind
/// pus/core/procedure_port.h.
///
/// What a procedure may do (a program in text form; its arguments are `...`):
///   step(n)            step n (1..65535) begins: it may be suspended or stopped here
///   wait(seconds)
///   send(apid, service, subtype[, data[, true]])  release a request; with true, wait for its end.
///                      Returns true, or false, failure code, detail
///   get(id or name)    value of a parameter as it was last reported, or nil
///   event(id)          raise an event; true if there is such a definition
///   parameters([seconds])  values that were communicated, as a list; nil if none come within so long
/// and of the language: assert error getmetatable ipairs pairs pcall rawequal rawget rawlen rawset select
/// setmetatable tonumber tostring type; math without random numbers and transcendental functions; string
/// byte char find format gmatch gsub len lower match pack packsize rep reverse sub unpack upper; table concat
/// insert remove sort unpack. Patterns have classes, sets, anchors, the four repetitions and captures; not
/// %b, %f and back references. Values of UINT64 above 2^63 - 1 are negative numbers.
///
/// What it may not: no files, no other modules, no loading of code, no precompiled code, no finalizers
/// (__gc), no coroutines, no message handlers; no address of an object becomes visible and `pairs` goes in
/// the order of the keys (numbers, texts, truth values), so that the same code and answers give the same
/// calls each time.
///
/// Budgets  Instructions, calls of the library and memory have prices (procedure_cost.h) that do not depend
///          on a clock. A procedure continues only while its budget covers its next instruction, also after
///          it has caught errors. The cost of one call is bounded; a call that costs more is an error.
/// Bounds   A text has 4096 octets at most; a list 1024 values; a table 256 other keys. Metatables are copied
///          when they are set: __index and __newindex follow at most 16 tables.
/// Memory   All is in the slot's arena; beyond it the procedure gets an error. It is not freed piece by piece
///          at the end but forgotten: nothing of a procedure runs after its end.
///
/// Ownership  The caller places engine, slots and arenas.
/// Context    One loop; not shared.
#ifndef FSW_PROCEDURES_PROCEDURE_ENGINE_H
#define FSW_PROCEDURES_PROCEDURE_ENGINE_H

#include "fsw/procedures/procedure_heap.h"
#include "pus/core/procedure_port.h"

#define PROCEDURE_TEXT_MAX 96U     ///< Of an error, with its NUL [octets].
#define PROCEDURE_DATA_MAX 1024U   ///< Of a request it sends [octets].
#define PROCEDURE_NAME_MAX 64U     ///< Of a parameter, with its NUL [octets].
#define PROCEDURE_STRING_MAX 4096U ///< Longest text [octets].

typedef struct { // Private.
    bool is_running;
    void* state;  // Of the interpreter: its main thread,
    void* thread; // and the procedure's.
    procedure_heap_t heap;
    uint64_t* memory;
    size_t memory_size;
    uint8_t* map;
    uint32_t budget;
    uint32_t spent; // Of the budget; the excess is taken from the next one.
    uint32_t used;  // Since the last grant.
    uint32_t grace; // Lists made since the last grant that were no larger than one before.
    // The largest values that this procedure has had; prices depend on them.
    uint32_t longest;    // Text [octets].
    uint32_t nodes;      // Keys in a table.
    uint32_t largest;    // List [octets].
    uint32_t stack_size; // [octets]
    const void* stack;
    const void* list; // Taken last,
    size_t list_size; // and its size.
    uint32_t code_size;
    bool is_making_thread;
    bool has_nul;     // A text may have a NUL in it.
    bool is_too_long; // A text was refused.
    pus_call_t call;
    pus_answer_t answer;
    uint8_t data[PROCEDURE_DATA_MAX];
    char text[PROCEDURE_TEXT_MAX];
} procedure_slot_t;

typedef struct {
    procedure_slot_t* slots;
    uint16_t count;
} procedure_engine_t;

/// Each slot gets `memory_size` octets of `memory`, which has count * memory_size, and of `map`, which has
/// PROCEDURE_BLOCKS of that. memory_size: a multiple of PROCEDURE_BLOCK up to 1 MiB; what the interpreter
/// itself needs of it is about 48 KiB.
void procedure_engine_init(procedure_engine_t* engine, procedure_slot_t* slots, uint16_t count,
                           uint64_t* memory, size_t memory_size, uint8_t* map);
pus_procedure_port_t procedure_engine_port(procedure_engine_t* engine);

#endif // FSW_PROCEDURES_PROCEDURE_ENGINE_H
