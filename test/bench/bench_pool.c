// SPDX-License-Identifier: Apache-2.0
/// Taking and releasing a block of a pool. Baselines: a bare free list that refuses free blocks and
/// blocks of other pools; malloc and free of the same size, in a program with threads.
#include "base/pool.h"
#include "osal/include/osal/task.h"
#include "test/bench/measure.h"

#include <stdlib.h>

#define BLOCK_OCTETS 64U
#define BLOCKS 256U
#define WORK 64U
#define NONE 0xFFFFU

static pool_t pool;
static uint64_t storage[POOL_STORAGE_WORDS(BLOCK_OCTETS, BLOCKS)];
static pool_slot_t slots[BLOCKS];
static void* volatile sink; // Keeps the compiler from removing the work.

static struct {
    uint16_t first;
    uint16_t next[BLOCKS];
    bool is_taken[BLOCKS];
    uint8_t octets[BLOCKS * BLOCK_OCTETS];
} list;

static void take_and_release(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        sink = pool_take(&pool);
        if (pool_release(&pool, sink) != STATUS_OK) {
            abort();
        }
    }
}

static void* __attribute__((noinline)) list_take(void)
{
    const uint16_t index = list.first;
    if (index == NONE) {
        return NULL;
    }
    list.first           = list.next[index];
    list.is_taken[index] = true;
    return &list.octets[index * BLOCK_OCTETS];
}

static bool __attribute__((noinline)) list_give(const void* block)
{
    const uintptr_t offset = (uintptr_t)block - (uintptr_t)list.octets;
    const uintptr_t index  = offset / BLOCK_OCTETS;
    if ((index >= BLOCKS) || ((offset % BLOCK_OCTETS) != 0U) || !list.is_taken[index]) {
        return false;
    }
    list.is_taken[index] = false;
    list.next[index]     = list.first;
    list.first           = (uint16_t)index;
    return true;
}

static void bare_free_list(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        sink = list_take();
        if (!list_give(sink)) {
            abort();
        }
    }
}

static void malloc_and_free(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        sink = malloc(BLOCK_OCTETS);
        free(sink);
    }
}

static void end_at_once(void* context)
{
    (void)context;
}

int main(void)
{
    const pool_setup_t setup = {.block_octets  = BLOCK_OCTETS,
                                .block_count   = BLOCKS,
                                .warn_percent  = POOL_WARN_PERCENT,
                                .clear_percent = POOL_CLEAR_PERCENT};
    osal_task_t task;
    // malloc and free use locks only after the program has started a thread.
    if (osal_task_start(&task, end_at_once, NULL, 0) != STATUS_OK) {
        return 1;
    }
    osal_task_join(&task);
    pool_init(&pool, storage, slots, &setup);
    for (uint16_t i = 0U; i < BLOCKS; i++) {
        list.next[i] = ((i + 1U) < BLOCKS) ? (uint16_t)(i + 1U) : NONE;
    }
    measure_compare("pool_take_and_release", take_and_release, bare_free_list, WORK, "ns", 1.0);
    measure_compare("pool_take_and_release_by_malloc", take_and_release, malloc_and_free, WORK, "ns", 1.0);
    return 0;
}
