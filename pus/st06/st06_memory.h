// SPDX-License-Identifier: Apache-2.0
/// ST[06] memory management, all 22 messages: load, dump and check of raw memory by address and of object
/// memory by base and offset, with data in the request or in a file; atomic load, scrubbing, write
/// protection. Areas, operations and refusals: docs/services/st06.md.
///
/// A memory is a range of addresses base .. base + size - 1, accessed by a port. Loads with data in the
/// request are performed at once. Dumps, checks and loads by reference are operations: each step of the
/// service advances every operation by PUS_MEMORY_SLICE octets.
///
/// Ownership  The caller provides memories, their states and operations.
/// Context    The loop of the process.
/// Time       A step is O(operations in progress and scrubbed memories), times the slice.
#ifndef PUS_ST06_ST06_MEMORY_H
#define PUS_ST06_ST06_MEMORY_H

#include "pus/core/file_port.h"
#include "pus/core/service.h"

/// Octets that one operation processes in one step, a multiple of each access width.
#define PUS_MEMORY_SLICE 1024U
/// Areas of a request that becomes an operation: their addresses, lengths and checksums fit one report.
#ifndef PUS_MEMORY_AREAS_MAX
#define PUS_MEMORY_AREAS_MAX PUS_COUNT_OF(PUS_TM_DATA_MAX - 7U, 10U)
#endif
#define PUS_MEMORY_ATOMIC 4U ///< Octets that TC[6,11] loads in one write.

/// A memory, or a device that is accessed in the same way.
typedef struct {
    uint8_t id;
    uint8_t access; ///< Width of an access: 1, 2, 4 or 8 [octets]; base and size are multiples.
    uint32_t base;  ///< First address.
    uint32_t size;  ///< [octets], >= 1; base + size <= 2^32.
    void* context;
    /// Read `size` octets from an address on; the area is within the memory and aligned. STATUS_OK, or the
    /// error.
    status_t (*read)(void* context, uint32_t address, uint8_t* octets, size_t size);
    /// Write `size` octets, up to PUS_MEMORY_ATOMIC of them without interruption. Null: read-only.
    status_t (*write)(void* context, uint32_t address, const uint8_t* octets, size_t size);
    /// Let the hardware find and correct errors in an area. Null: this memory cannot be scrubbed.
    void (*scrub)(void* context, uint32_t address, size_t size);
    /// Find the address and size of an object in the memory. STATUS_OK, STATUS_NOT_FOUND. Null: the memory
    /// has no objects.
    status_t (*object)(void* context, uint32_t base_id, uint32_t* out_address, uint32_t* out_size);
} pus_memory_t;

typedef struct { // Private.
    bool is_protected;
    bool is_scrubbed;
    uint32_t scrubbed; // Octets scrubbed in the present pass.
} pus_memory_state_t;

typedef struct {  // Private: a request in progress.
    uint8_t kind; // 0: the structure is free.
    bool is_object;
    uint8_t memory; // Index of the memory.
    uint8_t phase;  // Phase of a load by reference.
    uint8_t count;  // Number of areas.
    uint8_t index;  // Index of the present area.
    uint8_t refused;
    uint16_t checksum; // Checksum of the octets of the present area that have been read.
    uint32_t base_id;
    uint32_t origin; // Added to the offsets of areas.
    uint32_t done;   // Octets of the present area that have been processed.
    uint32_t file;
    uint32_t written; // Octets written to the file.
    uint16_t list;    // Offset of the list of areas in `data`.
    uint16_t entry;   // Size of the entry of an area [octets].
    pus_token_t token;
    pus_failure_t failure; // First failure of the request.
    uint16_t checksums[PUS_MEMORY_AREAS_MAX];
    bool is_left_out[PUS_MEMORY_AREAS_MAX]; // The area was refused, or has failed.
    uint8_t data[PUS_TC_DATA_MAX];
} pus_memory_operation_t;

typedef struct {
    pus_app_process_t* process;
    const pus_memory_t* memories;
    pus_memory_state_t* states; ///< One for each memory.
    uint8_t memory_count;
    pus_memory_operation_t* operations;
    uint8_t operation_count;
    const pus_file_port_t* files;         ///< Null: TC[6,19] to [6,22] are refused (PUS_FAILURE_UNKNOWN_ID).
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
} pus_memory_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_memory_config_t config;
    uint8_t running;  // Number of operations in progress.
    uint8_t scrubbed; // Number of memories that are scrubbed.
    struct {
        uint32_t loaded;  ///< Areas loaded.
        uint32_t dumped;  ///< Areas dumped.
        uint32_t checked; ///< Areas checked.
        uint32_t refused; ///< Areas that were refused or failed.
        uint32_t passes;  ///< Number of complete scrubbing passes of a memory.
    } counters;
    uint8_t octets[PUS_MEMORY_SLICE];
    uint8_t echo[PUS_MEMORY_SLICE];
} pus_memory_service_t;

/// Memory ids must differ; nothing is protected or scrubbed. The configuration is copied; the objects to
/// which it points are not.
void pus_memory_init(pus_memory_service_t* memory, const pus_memory_config_t* config);
/// Entry of the service for a dispatcher, with subtypes and step.
pus_service_t pus_memory_service(pus_memory_service_t* memory);
/// Restore a record; `key` is a memory id. STATUS_OK, STATUS_NOT_FOUND (no such memory), STATUS_INVALID (no
/// such record), STATUS_UNSUPPORTED (scrubbing was enabled, but the memory cannot be scrubbed any more).
MUST_USE status_t pus_memory_restore(void* self, uint32_t key, const uint8_t* octets, size_t size);
/// Continue all operations and the scrubbing.
void pus_memory_step(pus_memory_service_t* memory, uint64_t now_ns);

#endif // PUS_ST06_ST06_MEMORY_H
