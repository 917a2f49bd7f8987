// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_shm.h"

#include "fsw/framework/base/assertion.h"

#include <string.h>

// The memory is read while the other end writes it, so every access to it is atomic, word by word (GNU
// builtins: C99 has no atomics). LATEST guards the words with a sequence that is odd while they change.

#define MAGIC 0x464C4F57U
#define VALUE_OCTETS_MAX 65536U
#define DEPTH_MAX 65536U
#define READ_ATTEMPTS 4U

typedef struct {
    uint32_t magic; // Written last by the creator.
    uint32_t kind;
    uint32_t value_octets;
    uint32_t depth;
    uint64_t written; // QUEUE: values ever written. LATEST: sequence, odd while a value is being written.
    uint64_t read;    // QUEUE: values ever read.
    uint64_t words[];
} region_t;

static size_t words_of(const flow_shm_shape_t shape)
{
    return ((size_t)shape.value_octets + 7U) / 8U;
}

static size_t region_octets(const flow_shm_shape_t shape)
{
    return sizeof(region_t) + (words_of(shape) * shape.depth * sizeof(uint64_t));
}

static bool is_shape_valid(const flow_shm_shape_t shape)
{
    const bool is_depth_valid = (shape.depth >= 1U) && (shape.depth <= DEPTH_MAX);
    const bool is_kind_valid =
        (shape.kind == FLOW_SHM_QUEUE) || ((shape.kind == FLOW_SHM_LATEST) && (shape.depth == 1U));
    return is_depth_valid && is_kind_valid && (shape.value_octets >= 1U) &&
           (shape.value_octets <= VALUE_OCTETS_MAX);
}

static region_t* region_of(const flow_shm_t* const flow)
{
    return osal_shm_address(&flow->shm);
}

static void store_words(uint64_t* const words, const void* const value, const uint32_t octets)
{
    const uint8_t* source = value;
    uint32_t left         = octets;
    for (size_t i = 0U; left > 0U; i++) {
        const uint32_t part = (left < 8U) ? left : 8U;
        uint64_t word       = 0U;
        (void)memcpy(&word, source, part);
        __atomic_store_n(&words[i], word, __ATOMIC_RELAXED);
        source += part;
        left -= part;
    }
}

static void load_words(const uint64_t* const words, void* const out_value, const uint32_t octets)
{
    uint8_t* target = out_value;
    uint32_t left   = octets;
    for (size_t i = 0U; left > 0U; i++) {
        const uint32_t part = (left < 8U) ? left : 8U;
        const uint64_t word = __atomic_load_n(&words[i], __ATOMIC_RELAXED);
        (void)memcpy(target, &word, part);
        target += part;
        left -= part;
    }
}

void flow_shm_init(flow_shm_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    *flow = (flow_shm_t){.is_open = false};
}

status_t flow_shm_create(flow_shm_t* const flow, const flow_resolver_t* const resolver,
                         const char* const name, const flow_shm_shape_t shape)
{
    FSW_ASSERT((flow != NULL) && (resolver != NULL) && (name != NULL));
    if (flow->is_open) {
        return STATUS_EXISTS;
    }
    if (!is_shape_valid(shape)) {
        return STATUS_INVALID;
    }
    endnode_address_t address;
    status_t status = endnode_resolve(resolver, ENDNODE_SHM, name, &address);
    if (status != STATUS_OK) {
        return status;
    }
    status = osal_shm_create(&flow->shm, address.address, region_octets(shape));
    if (status != STATUS_OK) {
        return status;
    }
    region_t* const region = region_of(flow);
    region->kind           = (uint32_t)shape.kind;
    region->value_octets   = shape.value_octets;
    region->depth          = shape.depth;
    __atomic_store_n(&region->magic, MAGIC, __ATOMIC_RELEASE);
    (void)memcpy(flow->name, address.address, sizeof flow->name);
    flow->shape     = shape;
    flow->is_writer = true;
    flow->is_open   = true;
    return STATUS_OK;
}

status_t flow_shm_open(flow_shm_t* const flow, const flow_resolver_t* const resolver, const char* const name,
                       const flow_shm_shape_t shape)
{
    FSW_ASSERT((flow != NULL) && (resolver != NULL) && (name != NULL));
    if (flow->is_open) {
        return STATUS_EXISTS;
    }
    endnode_address_t address;
    status_t status = endnode_resolve(resolver, ENDNODE_SHM, name, &address);
    if (status == STATUS_OK) {
        status = osal_shm_open(&flow->shm, address.address);
    }
    if (status != STATUS_OK) {
        return status;
    }
    const region_t* const region = region_of(flow);
    const bool is_ready          = (osal_shm_size(&flow->shm) >= sizeof(region_t)) &&
                          (__atomic_load_n(&region->magic, __ATOMIC_ACQUIRE) == MAGIC);
    const bool is_same = is_ready && (region->kind == (uint32_t)shape.kind) &&
                         (region->value_octets == shape.value_octets) && (region->depth == shape.depth) &&
                         (osal_shm_size(&flow->shm) >= region_octets(shape));
    if (!is_same) {
        osal_shm_close(&flow->shm);
        return is_ready ? STATUS_INVALID : STATUS_NOT_FOUND;
    }
    flow->shape         = shape;
    flow->is_writer     = false;
    flow->is_open       = true;
    flow->last_sequence = 0U;
    return STATUS_OK;
}

void flow_shm_close(flow_shm_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (!flow->is_open) {
        return;
    }
    osal_shm_close(&flow->shm);
    if (flow->is_writer) {
        (void)osal_shm_remove(flow->name); // Already gone is as good.
    }
    flow->is_open = false;
}

status_t flow_shm_write(flow_shm_t* const flow, const void* const value)
{
    FSW_ASSERT((flow != NULL) && (value != NULL));
    if (!flow->is_open || !flow->is_writer) {
        return STATUS_CLOSED;
    }
    region_t* const region = region_of(flow);
    const uint64_t written = __atomic_load_n(&region->written, __ATOMIC_RELAXED);
    if (flow->shape.kind == FLOW_SHM_LATEST) {
        __atomic_store_n(&region->written, written + 1U, __ATOMIC_RELAXED);
        __atomic_thread_fence(__ATOMIC_RELEASE);
        store_words(region->words, value, flow->shape.value_octets);
        __atomic_store_n(&region->written, written + 2U, __ATOMIC_RELEASE);
    } else {
        if ((written - __atomic_load_n(&region->read, __ATOMIC_ACQUIRE)) >= flow->shape.depth) {
            flow->counters.refused++;
            return STATUS_FULL;
        }
        const size_t place = (size_t)(written % flow->shape.depth) * words_of(flow->shape);
        store_words(&region->words[place], value, flow->shape.value_octets);
        __atomic_store_n(&region->written, written + 1U, __ATOMIC_RELEASE);
    }
    flow->counters.written++;
    return STATUS_OK;
}

static status_t read_latest(flow_shm_t* const flow, const region_t* const region, void* const out_value)
{
    for (unsigned i = 0U; i < READ_ATTEMPTS; i++) {
        const uint64_t before = __atomic_load_n(&region->written, __ATOMIC_ACQUIRE);
        if (before == flow->last_sequence) {
            return STATUS_EMPTY;
        }
        if ((before % 2U) != 0U) {
            continue;
        }
        load_words(region->words, out_value, flow->shape.value_octets);
        __atomic_thread_fence(__ATOMIC_ACQUIRE);
        if (__atomic_load_n(&region->written, __ATOMIC_RELAXED) == before) {
            flow->last_sequence = before;
            flow->counters.read++;
            return STATUS_OK;
        }
    }
    flow->counters.torn++;
    return STATUS_BUSY;
}

static status_t read_queue(flow_shm_t* const flow, region_t* const region, void* const out_value)
{
    const uint64_t read = __atomic_load_n(&region->read, __ATOMIC_RELAXED);
    if (__atomic_load_n(&region->written, __ATOMIC_ACQUIRE) == read) {
        return STATUS_EMPTY;
    }
    const size_t place = (size_t)(read % flow->shape.depth) * words_of(flow->shape);
    load_words(&region->words[place], out_value, flow->shape.value_octets);
    __atomic_store_n(&region->read, read + 1U, __ATOMIC_RELEASE);
    flow->counters.read++;
    return STATUS_OK;
}

status_t flow_shm_read(flow_shm_t* const flow, void* const out_value)
{
    FSW_ASSERT((flow != NULL) && (out_value != NULL));
    if (!flow->is_open || flow->is_writer) {
        return STATUS_CLOSED;
    }
    region_t* const region = region_of(flow);
    return (flow->shape.kind == FLOW_SHM_LATEST) ? read_latest(flow, region, out_value)
                                                 : read_queue(flow, region, out_value);
}
