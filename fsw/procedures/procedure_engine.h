// SPDX-License-Identifier: Apache-2.0
/// On-board control procedures in Lua 5.4, each in a sandbox with its own memory. The engine implements
/// pus/core/procedure_port.h. Functions, limits and the restrictions of the sandbox: docs/services/st18.md.
///
/// Instructions, library calls and memory have prices (procedure_cost.h) that do not depend on a clock. A
/// procedure executes an instruction only if its budget covers it, even if the procedure catches errors.
/// All its memory is in the arena of its slot.
///
/// Ownership  The caller provides engine, slots and arenas.
/// Context    One loop.
#ifndef FSW_PROCEDURES_PROCEDURE_ENGINE_H
#define FSW_PROCEDURES_PROCEDURE_ENGINE_H

#include "fsw/procedures/procedure_heap.h"
#include "pus/core/procedure_port.h"

#define PROCEDURE_TEXT_MAX 96U     ///< Longest text of an error, with its NUL [octets].
#define PROCEDURE_DATA_MAX 1024U   ///< Maximum size of the data of a request [octets].
#define PROCEDURE_NAME_MAX 64U     ///< Longest name of a parameter, with its NUL [octets].
#define PROCEDURE_STRING_MAX 4096U ///< Longest text [octets].

typedef struct { // Private.
    bool is_running;
    void* state;  // Main thread of the interpreter.
    void* thread; // Thread of the procedure.
    procedure_heap_t heap;
    uint64_t* memory;
    size_t memory_size;
    uint8_t* map;
    uint32_t budget;
    uint32_t spent; // Part of the budget that is spent; an excess is subtracted from the next budget.
    uint32_t used;  // Cost since `budget` was given, including what was not charged.
    uint32_t grace; // The part of `used` for lists that are perhaps rebuilt ones (procedure_cost.h).
    // The largest values that this procedure has had; prices depend on them.
    uint32_t longest;    // Text [octets].
    uint32_t nodes;      // Keys in a table.
    uint32_t largest;    // List [octets].
    uint32_t stack_size; // [octets]
    const void* stack;   // Address of the procedure's stack, by which a change of its size is recognised.
    const void* list;    // Block allocated last.
    size_t list_size;    // Size of that block [octets].
    uint32_t code_size;
    bool is_making_thread;
    bool has_nul;     // A text that contains NUL may exist.
    bool is_too_long; // A text was refused because of its length.
    pus_call_t call;
    pus_answer_t answer;
    uint8_t data[PROCEDURE_DATA_MAX];
    char text[PROCEDURE_TEXT_MAX];
} procedure_slot_t;

typedef struct {
    procedure_slot_t* slots;
    uint16_t count;
} procedure_engine_t;

/// Initialise an engine. `memory` has count * memory_size octets, `map` has PROCEDURE_BLOCKS(count *
/// memory_size) octets; each slot gets an equal part of both. memory_size: a multiple of PROCEDURE_BLOCK up
/// to 1 MiB, of which the interpreter itself needs about 48 KiB.
void procedure_engine_init(procedure_engine_t* engine, procedure_slot_t* slots, uint16_t count,
                           uint64_t* memory, size_t memory_size, uint8_t* map);
pus_procedure_port_t procedure_engine_port(procedure_engine_t* engine);

#endif // FSW_PROCEDURES_PROCEDURE_ENGINE_H
