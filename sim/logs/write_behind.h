// SPDX-License-Identifier: Apache-2.0
/// Write-behind buffer of two halves: the caller collects records in one half while a task of the buffer
/// formats and writes those of the other. So the steps of a simulation neither format logs nor wait for the
/// file system while another processor is free. Records are consumed in the order in which they were added.
///
/// Ownership  The caller has the storage and the context of `consume`; both exist until write_behind_close.
/// Context    One task calls; write_behind_flush may also be called from the signal handler of a program that
///            crashes. `consume` runs in the task of the buffer or, in a flush and if no task can be started,
///            in that of the caller, never in both at once.
/// Time       write_behind_room and write_behind_flush without `waits` wait only if a half must be passed to
///            the task and the task has not yet consumed the other half.
#ifndef SIM_LOGS_WRITE_BEHIND_H
#define SIM_LOGS_WRITE_BEHIND_H

#include "osal/include/osal/event.h"
#include "osal/include/osal/task.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Octets of a half, and of the largest record. On a loaded machine the task gets a processor late: the other
/// half of a busy bus then still has room for the frames of one simulated second.
#define WRITE_BEHIND_HALF 262144U
#define WRITE_BEHIND_TIMEOUT_MS 10000U

typedef void (*write_behind_consume_t)(void* context, const uint8_t* octets, size_t size);

typedef struct { // Private.
    write_behind_consume_t consume;
    void* context;
    osal_task_t task;
    osal_event_t filled;   ///< For the task: it may consume the other half, or must end.
    osal_event_t consumed; ///< For the caller.
    bool has_task;
    bool is_busy;   ///< The task has the other half.
    bool is_ending; ///< The task must end.
    unsigned half;  ///< Half of the caller.
    size_t used;    ///< Octets in it.
    size_t passed;  ///< Octets in the half of the task.
    uint8_t octets[2][WRITE_BEHIND_HALF];
} write_behind_t;

/// Start the task. It may run on another processor if the program is pinned to one (osal_task_unpin). If it
/// cannot be started, the caller consumes.
void write_behind_open(write_behind_t* buffer, write_behind_consume_t consume, void* context);
/// Returns the address for one record of up to `octets` octets (<= WRITE_BEHIND_HALF). The caller writes the
/// record there and calls write_behind_add with its size.
uint8_t* write_behind_room(write_behind_t* buffer, size_t octets);
void write_behind_add(write_behind_t* buffer, size_t octets);
/// Pass the records so far to the task. `waits`: return when all are consumed, but wait for the task
/// WRITE_BEHIND_TIMEOUT_MS at most; after that the records of the caller's half stay in the buffer.
void write_behind_flush(write_behind_t* buffer, bool waits);
/// Consume the rest and end the task.
void write_behind_close(write_behind_t* buffer);

#endif // SIM_LOGS_WRITE_BEHIND_H
