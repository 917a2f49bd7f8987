// SPDX-License-Identifier: Apache-2.0
/// Data flow through shared memory between two components: the latest value, or a queue of values.
///
/// Latest: one writer, any number of readers; a reader gets the newest complete value, or STATUS_BUSY if
/// the writer kept overwriting it. Queue: one writer, one reader, no value is lost; a write to a full queue
/// is refused.
///
/// The writer of an end node is one component: memory that exists when it starts was left by its predecessor,
/// and is replaced. A reader reads the remaining values, gets STATUS_CLOSED, and then opens the new memory;
/// a reader that starts first waits for its writer. Both repeat attempts with back-off. Call flow_shm_step
/// once a cycle, then write or read.
///
/// Ownership  The caller provides flow_shm_t; the name, the resolver and the quota outlive it.
/// Context    One task per end. Never blocks.
/// Time       O(value size).
/// Errors     Each function lists its statuses; each refusal is counted.
#ifndef FSW_FRAMEWORK_DATAFLOW_FLOW_SHM_H
#define FSW_FRAMEWORK_DATAFLOW_FLOW_SHM_H

#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/dataflow/link.h"
#include "fsw/framework/dataflow/record.h"
#include "base/quota.h"
#include "osal/include/osal/shm.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    FLOW_SHM_LATEST,
    FLOW_SHM_QUEUE
} flow_shm_kind_t;

typedef struct { // Both ends must have the same values.
    flow_shm_kind_t kind;
    uint32_t value_octets; ///< 1..65536.
    uint32_t depth;        ///< Values that a queue holds, 1..65536; 1 for LATEST.
} flow_shm_shape_t;

typedef struct {
    const char* name;
    bool is_writer;
    flow_shm_shape_t shape;
    flow_order_t order;        ///< Byte order of the numbers in records.
    uint64_t retry_first_ns;   ///< Delay after the first failure, >= 1.
    uint64_t retry_longest_ns; ///< Longest delay, >= retry_first_ns.
    quota_t* quota;            ///< Quota of open memories; null: not counted.
} flow_shm_setup_t;

typedef struct { // All counters wrap.
    uint32_t written;
    uint32_t read;
    uint32_t refused; ///< Not written: no memory, the queue is full, or this end is a reader.
    uint32_t torn;    ///< Reads that ended without a value because the writer kept overwriting it.
    uint32_t unfit;   ///< Read, but not a record of the expected layout.
} flow_shm_counters_t;

typedef struct { // Private; read-only for housekeeping: counters, link.
    flow_shm_setup_t setup;
    const flow_resolver_t* resolver;
    char address[ENDNODE_ADDRESS_MAX];
    osal_shm_t shm;
    uint64_t last_sequence;
    flow_link_t link;
    flow_shm_counters_t counters;
} flow_shm_t;

/// Initialise a flow as closed. A shape out of its range is a coding error.
void flow_shm_init(flow_shm_t* flow, const flow_shm_setup_t* setup, const flow_resolver_t* resolver);
/// Create or open the memory if an attempt is due. STATUS_OK (open), STATUS_CLOSED; then `link.failure` is
/// the reason: STATUS_NOT_FOUND (resolver, or no writer yet), STATUS_INVALID (name, or the writer uses
/// another shape), STATUS_EXHAUSTED (quota or memory), STATUS_EXISTS (another program is creating it at this
/// moment), STATUS_DENIED or STATUS_IO.
status_t flow_shm_step(flow_shm_t* flow, uint64_t now_ns);

/// Write one value of value_octets. STATUS_OK, STATUS_FULL (queue), STATUS_CLOSED (no memory, or this end is
/// a reader).
MUST_USE status_t flow_shm_write(flow_shm_t* flow, const void* value);
/// Read a value; LATEST: the newest one if it was not read before, QUEUE: the oldest one. STATUS_OK,
/// STATUS_EMPTY (no new value), STATUS_BUSY (LATEST: the writer kept overwriting it, try again in the next
/// cycle; out_value may contain parts of several values), STATUS_CLOSED (no memory, its writer has closed it
/// or restarts; or this end is the writer).
MUST_USE status_t flow_shm_read(flow_shm_t* flow, void* out_value);
/// Write a struct as one value, in the flow's byte order. A layout whose size is not value_octets, or above
/// RECORD_OCTETS_MAX, is a coding error. Statuses of flow_shm_write.
MUST_USE status_t flow_shm_write_record(flow_shm_t* flow, const flow_record_layout_t* layout,
                                        const void* record);
/// Read a value as flow_shm_read does, into a struct, which changes only with STATUS_OK. The layout has the
/// same restrictions as for flow_shm_write_record. Statuses of flow_shm_read; STATUS_INVALID: the value is
/// not such a record; it is dropped and counted.
MUST_USE status_t flow_shm_read_record(flow_shm_t* flow, const flow_record_layout_t* layout,
                                       void* out_record);
/// Close this end. The writer also removes the name, and its readers get STATUS_CLOSED.
void flow_shm_close(flow_shm_t* flow);

#endif // FSW_FRAMEWORK_DATAFLOW_FLOW_SHM_H
