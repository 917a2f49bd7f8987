// SPDX-License-Identifier: Apache-2.0
/// Data flow through shared memory between two components: the latest value, or a queue of values.
///
/// Latest: one writer, any readers; a reader gets the newest whole value, or the word that it got none
/// because the writer kept overtaking it. Queue: one writer, one reader, nothing lost; a full queue is
/// refused.
///
/// Ownership  The caller places flow_shm_t. The writer creates the memory and removes its name on close.
/// Context    One task per end. Never blocks. Time O(value size).
/// Errors     Each function lists its statuses; each refusal is counted.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_SHM_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_SHM_H

#include "fsw/framework/base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "osal/include/osal/shm.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    FLOW_SHM_LATEST,
    FLOW_SHM_QUEUE
} flow_shm_kind_t;

typedef struct { // Both ends must say the same.
    flow_shm_kind_t kind;
    uint32_t value_octets; ///< 1..65536.
    uint32_t depth;        ///< Values a queue holds, 1..65536; 1 for LATEST.
} flow_shm_shape_t;

typedef struct { // [wrap]
    uint32_t written;
    uint32_t read;
    uint32_t refused; ///< Queue full.
    uint32_t torn;    ///< The writer kept overtaking this reader.
} flow_shm_counters_t;

typedef struct { // Private, except counters: read-only.
    osal_shm_t shm;
    flow_shm_shape_t shape;
    char name[ENDNODE_ADDRESS_MAX];
    bool is_writer;
    bool is_open;
    uint64_t last_sequence;
    flow_shm_counters_t counters;
} flow_shm_t;

void flow_shm_init(flow_shm_t* flow);
/// Make the memory and be its writer. STATUS_OK, STATUS_EXISTS (open already, or name taken),
/// STATUS_NOT_FOUND (resolver), STATUS_INVALID (shape, name), STATUS_EXHAUSTED, STATUS_DENIED, STATUS_IO.
MUST_USE status_t flow_shm_create(flow_shm_t* flow, const flow_resolver_t* resolver, const char* name,
                                  flow_shm_shape_t shape);
/// Be a reader. STATUS_OK, STATUS_EXISTS (open already), STATUS_NOT_FOUND (resolver, or no writer yet),
/// STATUS_INVALID (shape differs from the writer's), STATUS_DENIED, STATUS_IO.
MUST_USE status_t flow_shm_open(flow_shm_t* flow, const flow_resolver_t* resolver, const char* name,
                                flow_shm_shape_t shape);
void flow_shm_close(flow_shm_t* flow);

/// Write one value of value_octets. STATUS_OK, STATUS_FULL (queue), STATUS_CLOSED (not open as writer).
MUST_USE status_t flow_shm_write(flow_shm_t* flow, const void* value);
/// LATEST: the newest value not read before. QUEUE: the oldest. STATUS_OK, STATUS_EMPTY (nothing new),
/// STATUS_BUSY (LATEST: overtaken, try in the next cycle), STATUS_CLOSED (not open as reader).
MUST_USE status_t flow_shm_read(flow_shm_t* flow, void* out_value);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_SHM_H
