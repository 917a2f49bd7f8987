// SPDX-License-Identifier: Apache-2.0
/// Private to ST[06] and ST[20]: the memory or object to which a request refers, and its areas.
#ifndef PUS_ST06_ST06_AREAS_H
#define PUS_ST06_ST06_AREAS_H

#include "pus/st06/st06_memory.h"

/// The memory that a request names, or one object in a memory.
typedef struct {
    const pus_memory_t* memory;
    uint8_t index; ///< Index of the memory.
    bool is_object;
    uint32_t base_id; ///< Id of the object.
    uint32_t origin;  ///< The address is origin + offset in the request.
    uint32_t first;   ///< Smallest offset that a request may contain.
    uint32_t size;    ///< Size from `first` on [octets].
} memory_target_t;

/// Read memory id and, for objects, base id. PUS_FAILURE_NONE, or PUS_FAILURE_UNKNOWN_ID.
pus_failure_t memory_find(const pus_memory_t* memories, uint8_t count, octet_reader_t* reader, bool is_object,
                          memory_target_t* out_target);
/// True if an area is aligned and inside of the target; an end beyond the address range makes it false.
bool memory_is_inside(const memory_target_t* target, uint32_t address, uint32_t length);

#endif // PUS_ST06_ST06_AREAS_H
