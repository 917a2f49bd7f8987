// SPDX-License-Identifier: Apache-2.0
/// Private to ST[06]: the areas of a request, the checks whether they may be accessed, and the operations
/// that take several steps.
#ifndef PUS_ST06_ST06_OPERATIONS_H
#define PUS_ST06_ST06_OPERATIONS_H

#include "pus/st06/st06_areas.h"

typedef enum {
    MEMORY_DUMP = 1,
    MEMORY_CHECK,
    MEMORY_CHECK_OBJECT, ///< A whole object, TC[6,17]; TC[6,7] is a MEMORY_CHECK of areas of an object.
    MEMORY_LOAD_FILE,
    MEMORY_DUMP_FILE
} memory_kind_t;

/// Read memory id and, for objects, base id. PUS_FAILURE_NONE, or the failure that refuses the request.
pus_failure_t memory_target(const pus_memory_service_t* service, octet_reader_t* reader, bool is_object,
                            memory_target_t* out_target);
/// Check the access to an area. PUS_FAILURE_NONE, or the failure that refuses it. `position`: octet offset of
/// the entry of the area in the request.
pus_failure_t memory_check_access(const pus_memory_service_t* service, const memory_target_t* target,
                                  uint32_t address, uint32_t length, bool is_write, size_t position);
/// Read back `size` octets and compare. PUS_FAILURE_NONE, PUS_FAILURE_VERIFY or PUS_FAILURE_IO.
pus_failure_t memory_verify(pus_memory_service_t* service, const pus_memory_t* memory, uint32_t address,
                            const uint8_t* expected, size_t size);
/// Count an area that failed, and return its failure.
pus_failure_t memory_fail(pus_memory_service_t* service, uint16_t code, uint32_t detail);

/// Begin the operation for a request.
pus_reply_t memory_start(pus_memory_service_t* service, pus_request_t* request, memory_kind_t kind,
                         bool is_object);
/// End all dumps.
void memory_abort_dumps(pus_memory_service_t* service, uint64_t now_ns);

#endif // PUS_ST06_ST06_OPERATIONS_H
