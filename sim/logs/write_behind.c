// SPDX-License-Identifier: Apache-2.0
#include "sim/logs/write_behind.h"

#define WITHOUT_LIMIT UINT32_MAX

/// The two events order all accesses: the task uses the structure only between `filled` and `consumed`.
static void consume_halves(void* const context)
{
    write_behind_t* buffer = context;
    osal_task_unpin();
    for (;;) {
        while (osal_event_wait(&buffer->filled, WITHOUT_LIMIT) != STATUS_OK) {
        }
        if (buffer->is_ending) {
            return;
        }
        buffer->consume(buffer->context, buffer->octets[buffer->half ^ 1U], buffer->passed);
        osal_event_signal(&buffer->consumed);
    }
}

void write_behind_open(write_behind_t* const buffer, const write_behind_consume_t consume,
                       void* const context)
{
    buffer->consume   = consume;
    buffer->context   = context;
    buffer->is_busy   = false;
    buffer->is_ending = false;
    buffer->half      = 0U;
    buffer->used      = 0U;
    osal_event_create(&buffer->filled);
    osal_event_create(&buffer->consumed);
    buffer->has_task = osal_task_start(&buffer->task, consume_halves, buffer, 0) == STATUS_OK;
}

/// True if the task is idle.
static bool wait_for_task(write_behind_t* const buffer, const uint32_t timeout_ms)
{
    if (buffer->is_busy && (osal_event_wait(&buffer->consumed, timeout_ms) == STATUS_OK)) {
        buffer->is_busy = false;
    }
    return !buffer->is_busy;
}

/// Consume the half of the caller. The task must be idle.
static void consume_own(write_behind_t* const buffer)
{
    if (buffer->used > 0U) {
        buffer->consume(buffer->context, buffer->octets[buffer->half], buffer->used);
        buffer->used = 0U;
    }
}

/// Pass the half of the caller to the task.
static void pass(write_behind_t* const buffer)
{
    if (!buffer->has_task) {
        consume_own(buffer);
    } else if (buffer->used > 0U) {
        (void)wait_for_task(buffer, WITHOUT_LIMIT);
        buffer->passed = buffer->used;
        buffer->half ^= 1U;
        buffer->used    = 0U;
        buffer->is_busy = true;
        osal_event_signal(&buffer->filled);
    } else {
        // There is nothing to pass.
    }
}

uint8_t* write_behind_room(write_behind_t* const buffer, const size_t octets)
{
    if ((buffer->used + octets) > WRITE_BEHIND_HALF) {
        pass(buffer);
    }
    return &buffer->octets[buffer->half][buffer->used];
}

void write_behind_add(write_behind_t* const buffer, const size_t octets)
{
    buffer->used += octets;
}

void write_behind_flush(write_behind_t* const buffer, const bool waits)
{
    if (!waits) {
        pass(buffer);
    } else if (wait_for_task(buffer, WRITE_BEHIND_TIMEOUT_MS)) {
        consume_own(buffer);
    } else {
        // The file system is too slow: the records stay in the buffer.
    }
}

void write_behind_close(write_behind_t* const buffer)
{
    (void)wait_for_task(buffer, WITHOUT_LIMIT);
    consume_own(buffer);
    if (buffer->has_task) {
        buffer->is_ending = true;
        osal_event_signal(&buffer->filled);
        osal_task_join(&buffer->task);
        buffer->has_task = false;
    }
}
