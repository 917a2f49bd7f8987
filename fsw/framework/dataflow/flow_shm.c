// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_shm.h"

#include "base/assertion.h"

#include <string.h>

// The memory is read while the other end writes it, so every access to it is atomic, word by word (GNU
// builtins: C99 has no atomics). With LATEST, a sequence number that is odd during a write protects the words
// (seqlock): a reader repeats its read if the number is odd or has changed.

#define MAGIC 0x464C4F57U
#define ENDED 0x454E4445U // Replaces the magic number when no more values follow.
#define VALUE_OCTETS_MAX 65536U
#define DEPTH_MAX 65536U
#define READ_ATTEMPTS 4U

typedef struct {
    uint32_t magic; // MAGIC, written last by the creator; ENDED: the memory was closed or replaced.
    uint32_t kind;
    uint32_t value_octets;
    uint32_t depth;
    // QUEUE: number of values written so far. LATEST: sequence, odd while a value is being written.
    uint64_t written;
    uint64_t read; // QUEUE: number of values read so far.
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

static bool is_alive(const osal_shm_t* const shm)
{
    const region_t* const region = osal_shm_address(shm);
    return (osal_shm_size(shm) >= sizeof(region_t)) &&
           (__atomic_load_n(&region->magic, __ATOMIC_ACQUIRE) == MAGIC);
}

/// Mark a memory as ended: its readers get no more values.
static void end_region(const osal_shm_t* const shm)
{
    if (is_alive(shm)) {
        region_t* const region = osal_shm_address(shm);
        __atomic_store_n(&region->magic, ENDED, __ATOMIC_RELEASE);
    }
}

/// Remove the memory that a predecessor did not close, if there is one. It is marked as ended, so that its
/// readers open the new memory.
static void end_predecessor(const flow_shm_t* const flow)
{
    osal_shm_t left;
    if (osal_shm_open(&left, flow->address) == STATUS_OK) {
        end_region(&left);
        osal_shm_close(&left);
    }
    (void)osal_shm_remove(flow->address);
}

static status_t create_region(flow_shm_t* const flow)
{
    end_predecessor(flow);
    const flow_shm_shape_t shape = flow->setup.shape;
    const status_t status        = osal_shm_create(&flow->shm, flow->address, region_octets(shape));
    if (status == STATUS_OK) {
        region_t* const region = region_of(flow);
        region->kind           = (uint32_t)shape.kind;
        region->value_octets   = shape.value_octets;
        region->depth          = shape.depth;
        __atomic_store_n(&region->magic, MAGIC, __ATOMIC_RELEASE);
    }
    return status;
}

static status_t open_region(flow_shm_t* const flow)
{
    const flow_shm_shape_t shape = flow->setup.shape;
    const status_t status        = osal_shm_open(&flow->shm, flow->address);
    if (status != STATUS_OK) {
        return status;
    }
    if (!is_alive(&flow->shm)) {
        return STATUS_NOT_FOUND;
    }
    const region_t* const region = region_of(flow);
    const bool is_same           = (region->kind == (uint32_t)shape.kind) &&
                         (region->value_octets == shape.value_octets) && (region->depth == shape.depth) &&
                         (osal_shm_size(&flow->shm) >= region_octets(shape));
    flow->last_sequence = 0U;
    return is_same ? STATUS_OK : STATUS_INVALID;
}

static status_t open_memory(void* const context)
{
    flow_shm_t* const flow = context;
    flow_endnode_address_t address;
    const status_t status = flow_endnode_resolve(flow->resolver, ENDNODE_SHM, flow->setup.name, &address);
    if (status != STATUS_OK) {
        return status;
    }
    (void)memcpy(flow->address, address.address, sizeof flow->address);
    return flow->setup.is_writer ? create_region(flow) : open_region(flow);
}

static void close_memory(void* const context)
{
    osal_shm_close(&((flow_shm_t*)context)->shm);
}

void flow_shm_init(flow_shm_t* const flow, const flow_shm_setup_t* const setup,
                   const flow_resolver_t* const resolver)
{
    static const flow_link_actions_t actions = {open_memory, close_memory};
    FSW_ASSERT((flow != NULL) && (setup != NULL) && (resolver != NULL) && (setup->name != NULL));
    FSW_ASSERT(is_shape_valid(setup->shape));
    *flow = (flow_shm_t){.setup = *setup, .resolver = resolver};
    flow_link_init(&flow->link, &actions, flow, setup->quota, setup->retry_first_ns, setup->retry_longest_ns);
}

status_t flow_shm_step(flow_shm_t* const flow, const uint64_t now_ns)
{
    FSW_ASSERT(flow != NULL);
    return flow_link_step(&flow->link, now_ns);
}

void flow_shm_close(flow_shm_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    // If the memory is marked as ended, a successor already uses the name.
    if (flow->link.is_open && flow->setup.is_writer && is_alive(&flow->shm)) {
        end_region(&flow->shm);
        (void)osal_shm_remove(flow->address);
    }
    flow_link_close(&flow->link);
}

static status_t write_value(const flow_shm_t* const flow, region_t* const region, const void* const value)
{
    const flow_shm_shape_t shape = flow->setup.shape;
    const uint64_t written       = __atomic_load_n(&region->written, __ATOMIC_RELAXED);
    if (shape.kind == FLOW_SHM_LATEST) {
        __atomic_store_n(&region->written, written + 1U, __ATOMIC_RELAXED);
        // A reader that sees a changed word must also see the odd sequence.
        __atomic_thread_fence(__ATOMIC_RELEASE);
        store_words(region->words, value, shape.value_octets);
        __atomic_store_n(&region->written, written + 2U, __ATOMIC_RELEASE);
    } else {
        if ((written - __atomic_load_n(&region->read, __ATOMIC_ACQUIRE)) >= shape.depth) {
            return STATUS_FULL;
        }
        const size_t offset = (size_t)(written % shape.depth) * words_of(shape);
        store_words(&region->words[offset], value, shape.value_octets);
        __atomic_store_n(&region->written, written + 1U, __ATOMIC_RELEASE);
    }
    return STATUS_OK;
}

status_t flow_shm_write(flow_shm_t* const flow, const void* const value)
{
    FSW_ASSERT((flow != NULL) && (value != NULL));
    const bool is_ready   = flow->link.is_open && flow->setup.is_writer;
    const status_t status = is_ready ? write_value(flow, region_of(flow), value) : STATUS_CLOSED;
    if (status == STATUS_OK) {
        flow->counters.written++;
    } else {
        flow->counters.refused++;
    }
    return status;
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
        load_words(region->words, out_value, flow->setup.shape.value_octets);
        __atomic_thread_fence(__ATOMIC_ACQUIRE); // Read all words before the sequence is read again.
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
    const size_t offset = (size_t)(read % flow->setup.shape.depth) * words_of(flow->setup.shape);
    load_words(&region->words[offset], out_value, flow->setup.shape.value_octets);
    __atomic_store_n(&region->read, read + 1U, __ATOMIC_RELEASE);
    flow->counters.read++;
    return STATUS_OK;
}

status_t flow_shm_read(flow_shm_t* const flow, void* const out_value)
{
    FSW_ASSERT((flow != NULL) && (out_value != NULL));
    if (!flow->link.is_open || flow->setup.is_writer) {
        return STATUS_CLOSED;
    }
    // Test this before the read: after the read, the last value before the end could be missed.
    const bool was_alive   = is_alive(&flow->shm);
    region_t* const region = region_of(flow);
    const status_t status = (flow->setup.shape.kind == FLOW_SHM_LATEST) ? read_latest(flow, region, out_value)
                                                                        : read_queue(flow, region, out_value);
    if ((status == STATUS_OK) || was_alive) {
        return status;
    }
    flow_link_lose(&flow->link, STATUS_CLOSED);
    return STATUS_CLOSED;
}

status_t flow_shm_write_record(flow_shm_t* const flow, const flow_record_layout_t* const layout,
                               const void* const record)
{
    FSW_ASSERT((flow != NULL) && (flow_record_octets(layout) == flow->setup.shape.value_octets));
    uint8_t octets[RECORD_OCTETS_MAX];
    size_t size = 0U;
    const status_t status =
        flow_record_encode(layout, flow->setup.order, record, octets, sizeof octets, &size);
    FSW_ASSERT(status == STATUS_OK);
    return flow_shm_write(flow, octets);
}

status_t flow_shm_read_record(flow_shm_t* const flow, const flow_record_layout_t* const layout,
                              void* const out_record)
{
    FSW_ASSERT((flow != NULL) && (flow_record_octets(layout) == flow->setup.shape.value_octets));
    FSW_ASSERT(flow->setup.shape.value_octets <= RECORD_OCTETS_MAX);
    uint8_t octets[RECORD_OCTETS_MAX];
    status_t status = flow_shm_read(flow, octets);
    if (status == STATUS_OK) {
        status =
            flow_record_decode(layout, flow->setup.order, octets, flow->setup.shape.value_octets, out_record);
        flow->counters.unfit += (status != STATUS_OK) ? 1U : 0U;
    }
    return status;
}
