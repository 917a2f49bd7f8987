// SPDX-License-Identifier: Apache-2.0
/// ST[06] memory management, all 22 messages: load, dump and check of raw memory by address and of object
/// memory by base and offset, by data in the request or by reference to a file; atomic load, scrubbing, write
/// protection.
///
/// A memory is a run of addresses base .. base + size - 1 behind a port. Addresses and lengths must be
/// multiples of its access width. An object of it is a part that has a base id; offsets count from the
/// object's begin. Memory ids are in every message.
///
/// Each area of a request stands on its own. At start of execution an area is refused by its own TM[1,4]:
/// PUS_FAILURE_ADDRESS (outside the memory or object, or not aligned), PUS_FAILURE_OUT_OF_RANGE (no octets,
/// or outside the file), PUS_FAILURE_PROTECTED (write-protected or read-only), PUS_FAILURE_DATA_CHECKSUM (its
/// data differ from their checksum). An unknown memory or object, or a file that cannot be opened, refuses
/// the request as a whole. The others are performed. What is loaded is read back: a difference, or a file
/// whose octets differ from their checksum, or an access that fails, ends the request with TM[1,8]
/// (PUS_FAILURE_VERIFY, or PUS_FAILURE_IO with the status) that names the first such area; all areas without
/// such a failure are loaded nevertheless.
///
/// Loads with data in the request are done at once. Dumps, checks and loads by reference are operations: each
/// step of the service moves every one on by PUS_MEMORY_SLICE octets, so that a dump larger than a packet
/// becomes as many TM[6,4] or [6,6] as are needed, in the order of the addresses. An operation waits while
/// the process takes no report. TC[6,12] ends all dumps, to file too, with TM[1,8] (PUS_FAILURE_ABORTED). A
/// file dumped to is created, and holds the octets of the areas one behind the other; after a failure it
/// holds what was read before it.
///
/// A memory that is scrubbed is read through again and again, PUS_MEMORY_SLICE octets in each step, by the
/// port's `scrub`. Write protection and scrubbing outlive a power cut by their records (key: memory id).
///
/// Ownership  The caller places memories, their states and operations.
/// Context    The loop of the process.
/// Time       A step is O(operations under way and memories scrubbed), times the slice; nothing if there are
///            none.
#ifndef PUS_ST06_ST06_MEMORY_H
#define PUS_ST06_ST06_MEMORY_H

#include "pus/core/file_port.h"
#include "pus/core/service.h"

#define PUS_MEMORY_SLICE                                                                                     \
    1024U                    ///< Moved by one operation in one step [octets], a multiple of any access width.
#define PUS_MEMORY_ATOMIC 4U ///< Octets that TC[6,11] loads at once.

/// A memory, or a device that looks like one.
typedef struct {
    uint8_t id;
    uint8_t access; ///< Width of an access: 1, 2, 4 or 8 [octets]; base and size are multiples.
    uint32_t base;  ///< First address.
    uint32_t size;  ///< [octets], >= 1; base + size <= 2^32.
    void* context;
    /// `size` octets from an address on, within the memory and aligned. STATUS_OK or what is wrong.
    status_t (*read)(void* context, uint32_t address, uint8_t* octets, size_t size);
    /// The same for writing; of up to PUS_MEMORY_ATOMIC octets without an interruption. Null: read-only.
    status_t (*write)(void* context, uint32_t address, const uint8_t* octets, size_t size);
    /// Let the hardware find and mend errors there. Null: this memory cannot be scrubbed.
    void (*scrub)(void* context, uint32_t address, size_t size);
    /// Begin and size of an object, inside the memory. STATUS_OK, STATUS_NOT_FOUND. Null: there are none.
    status_t (*object)(void* context, uint32_t base_id, uint32_t* out_address, uint32_t* out_size);
} pus_memory_t;

typedef struct { // Private.
    bool is_protected;
    bool is_scrubbed;
    uint32_t scrubbed; // Octets of this pass.
} pus_memory_state_t;

typedef struct {  // Private: a request under way.
    uint8_t kind; // 0: free.
    bool is_object;
    uint8_t memory; // Its place in the list.
    uint8_t phase;  // Of a load by reference.
    uint8_t count;  // Areas.
    uint8_t index;  // Area under way, from 0.
    uint8_t refused;
    uint16_t checksum; // Of the area under way, as far as it has been read.
    uint32_t base_id;
    uint32_t origin; // Added to the offsets of areas.
    uint32_t done;   // Octets of the area under way.
    uint32_t file;
    uint32_t written; // Octets of the file.
    uint16_t list;    // Where the areas begin in `data`.
    uint16_t entry;   // Octets of an area's entry.
    pus_token_t token;
    pus_failure_t failure; // The first.
    uint16_t checksums[PUS_COUNT_MAX];
    bool is_left_out[PUS_COUNT_MAX]; // Refused or failed.
    uint8_t data[PUS_TC_DATA_MAX];
} pus_memory_operation_t;

typedef struct {
    pus_process_t* process;
    const pus_memory_t* memories;
    pus_memory_state_t* states; ///< One for each memory.
    uint8_t memory_count;
    pus_memory_operation_t* operations;
    uint8_t operation_count;
    const pus_file_port_t* files;         ///< Null: TC[6,19] to [6,22] are refused (PUS_FAILURE_UNKNOWN_ID).
    const pus_persistence_t* persistence; ///< Null: nothing is kept.
} pus_memory_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_memory_config_t config;
    uint8_t running;  // Operations under way.
    uint8_t scrubbed; // Memories.
    struct {
        uint32_t loaded;  ///< Areas loaded.
        uint32_t dumped;  ///< Areas dumped.
        uint32_t checked; ///< Areas checked.
        uint32_t refused; ///< Areas refused, or failed later.
        uint32_t passes;  ///< Times a memory has been scrubbed through.
    } counters;
    uint8_t octets[PUS_MEMORY_SLICE];
    uint8_t echo[PUS_MEMORY_SLICE];
} pus_memory_service_t;

/// Memory ids must differ; nothing is protected or scrubbed. The configuration is copied, what it points to
/// is not.
void pus_memory_init(pus_memory_service_t* memory, const pus_memory_config_t* config);
/// The service's entry for a dispatcher; subtypes and step included.
pus_service_t pus_memory_service(pus_memory_service_t* memory);
/// Take back a record, `key` being a memory id. STATUS_OK, STATUS_NOT_FOUND (no such memory), STATUS_INVALID
/// (no such record), STATUS_UNSUPPORTED (it cannot be scrubbed any more).
MUST_USE status_t pus_memory_restore(void* self, uint32_t key, const uint8_t* octets, size_t size);
/// Move all operations and scrubbing on.
void pus_memory_step(pus_memory_service_t* memory, uint64_t now_ns);

#endif // PUS_ST06_ST06_MEMORY_H
