// SPDX-License-Identifier: Apache-2.0
// Named memory that the tasks of the program share, taken from a static store. A block becomes free when its
// name is removed and no task maps it.
#include "osal/include/osal/shm.h"

#include "base/assertion.h"

#include <FreeRTOS.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <task.h>

#define BLOCKS_MAX 16U
#define NAME_OCTETS 62U
#ifndef SHM_STORE_OCTETS
#define SHM_STORE_OCTETS 786432U
#endif
#define ALIGNMENT 64U

typedef struct {
    char name[NAME_OCTETS]; ///< Empty if the name was removed.
    size_t offset;
    size_t size; ///< Size that the creator has given [octets]; 0: the entry is free.
    unsigned mappings;
    bool is_zero; ///< The creator has cleared the block: others may open it.
} block_t;

static uint8_t store[SHM_STORE_OCTETS] __attribute__((aligned(64)));
static block_t blocks[BLOCKS_MAX];

static bool is_name(const char* const name)
{
    static const char allowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    const size_t length         = strlen(name);
    return (length >= 2U) && (length < NAME_OCTETS) && (name[0] == '/') &&
           (strspn(&name[1], allowed) == (length - 1U)) && (strcmp(name, "/.") != 0) &&
           (strcmp(name, "/..") != 0);
}

static block_t* find(const char* const name)
{
    for (unsigned i = 0U; i < BLOCKS_MAX; i++) {
        if ((blocks[i].size > 0U) && (strcmp(blocks[i].name, name) == 0)) {
            return &blocks[i];
        }
    }
    return NULL;
}

/// Returns the number of octets that a block takes in the store.
static size_t span_of(const size_t size)
{
    return (size + (ALIGNMENT - 1U)) & ~(size_t)(ALIGNMENT - 1U);
}

/// Returns the first octet from which `size` octets are free, or SHM_STORE_OCTETS.
static size_t find_room(const size_t size)
{
    size_t at    = 0U;
    bool is_good = false;
    while (!is_good && ((at + size) <= SHM_STORE_OCTETS)) {
        is_good = true;
        for (unsigned i = 0U; i < BLOCKS_MAX; i++) {
            const block_t* const one = &blocks[i];
            if ((one->size > 0U) && (at < (one->offset + span_of(one->size))) &&
                (one->offset < (at + size))) {
                at      = one->offset + span_of(one->size);
                is_good = false;
            }
        }
    }
    return is_good ? at : SHM_STORE_OCTETS;
}

/// Create an entry of this name and size, mapped once. STATUS_OK, STATUS_EXISTS, STATUS_EXHAUSTED. The caller
/// has suspended the other tasks.
static status_t reserve(const char* const name, const size_t size, block_t** const out_block)
{
    block_t* entry = NULL;
    if (find(name) != NULL) {
        return STATUS_EXISTS;
    }
    for (unsigned i = 0U; (i < BLOCKS_MAX) && (entry == NULL); i++) {
        entry = (blocks[i].size == 0U) ? &blocks[i] : NULL;
    }
    const size_t at = (size <= SHM_STORE_OCTETS) ? find_room(span_of(size)) : SHM_STORE_OCTETS;
    if ((entry == NULL) || (at == SHM_STORE_OCTETS)) {
        return STATUS_EXHAUSTED;
    }
    *entry = (block_t){.offset = at, .size = size, .mappings = 1U};
    (void)memcpy(entry->name, name, strlen(name) + 1U);
    *out_block = entry;
    return STATUS_OK;
}

status_t osal_shm_create(osal_shm_t* const shm, const char* const name, const size_t size)
{
    FSW_ASSERT((shm != NULL) && (name != NULL));
    block_t* block = NULL;
    *shm           = (osal_shm_t){NULL, 0U};
    if (!is_name(name) || (size == 0U)) {
        return STATUS_INVALID;
    }
    if (size > SHM_STORE_OCTETS) {
        return STATUS_EXHAUSTED;
    }
    vTaskSuspendAll();
    const status_t status = reserve(name, size, &block);
    (void)xTaskResumeAll();
    if (status == STATUS_OK) {
        *shm = (osal_shm_t){&store[block->offset], size};
        (void)memset(shm->address, 0, span_of(size)); // After the resume, because it takes long.
        __atomic_store_n(&block->is_zero, true, __ATOMIC_RELEASE);
    }
    return status;
}

status_t osal_shm_open(osal_shm_t* const shm, const char* const name)
{
    FSW_ASSERT((shm != NULL) && (name != NULL));
    *shm = (osal_shm_t){NULL, 0U};
    if (!is_name(name)) {
        return STATUS_INVALID;
    }
    vTaskSuspendAll();
    block_t* const block = find(name);
    const bool is_there  = (block != NULL) && block->is_zero;
    if (is_there) {
        block->mappings++;
        *shm = (osal_shm_t){&store[block->offset], block->size};
    }
    (void)xTaskResumeAll();
    return is_there ? STATUS_OK : STATUS_NOT_FOUND;
}

void* osal_shm_address(const osal_shm_t* const shm)
{
    FSW_ASSERT(shm != NULL);
    return shm->address;
}

size_t osal_shm_size(const osal_shm_t* const shm)
{
    FSW_ASSERT(shm != NULL);
    return shm->size;
}

static void release_unused(block_t* const block)
{
    if ((block->mappings == 0U) && (block->name[0] == '\0')) {
        block->size = 0U;
    }
}

void osal_shm_close(osal_shm_t* const shm)
{
    FSW_ASSERT(shm != NULL);
    vTaskSuspendAll();
    for (unsigned i = 0U; (shm->address != NULL) && (i < BLOCKS_MAX); i++) {
        if ((blocks[i].size > 0U) && (&store[blocks[i].offset] == (const uint8_t*)shm->address)) {
            FSW_ASSERT(blocks[i].mappings > 0U);
            blocks[i].mappings--;
            release_unused(&blocks[i]);
        }
    }
    (void)xTaskResumeAll();
    *shm = (osal_shm_t){NULL, 0U};
}

status_t osal_shm_remove(const char* const name)
{
    FSW_ASSERT(name != NULL);
    if (!is_name(name)) {
        return STATUS_INVALID;
    }
    vTaskSuspendAll();
    block_t* const block = find(name);
    if (block != NULL) {
        block->name[0] = '\0';
        release_unused(block);
    }
    (void)xTaskResumeAll();
    return (block != NULL) ? STATUS_OK : STATUS_NOT_FOUND;
}

status_t osal_shm_each(const char* const prefix, void (*visit)(void* context, const char* name),
                       void* const context)
{
    FSW_ASSERT((prefix != NULL) && (prefix[0] == '/') && (visit != NULL));
    for (unsigned i = 0U; i < BLOCKS_MAX; i++) {
        char name[NAME_OCTETS];
        vTaskSuspendAll();
        const bool is_listed =
            (blocks[i].size > 0U) && (strncmp(blocks[i].name, prefix, strlen(prefix)) == 0);
        (void)memcpy(name, blocks[i].name, sizeof name);
        (void)xTaskResumeAll();
        if (is_listed) { // The other tasks run during `visit`, which may remove the block.
            visit(context, name);
        }
    }
    return STATUS_OK;
}
