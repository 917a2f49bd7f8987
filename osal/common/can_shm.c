// SPDX-License-Identifier: Apache-2.0
// Rings in shared memory ("shm:"). Each ring has one writer and one reader and needs no lock: the writer
// alone moves `head`, the reader alone moves `tail`.
#include "osal/common/can_port.h"

#include "osal/include/osal/shm.h"

#include <stddef.h>

#define BUS_MAGIC 0x68697263616E6275ULL
#define RING_MASK (OSAL_CAN_RING_FRAMES - 1U)

typedef char ring_size_is_a_power_of_two[((OSAL_CAN_RING_FRAMES & RING_MASK) == 0U) ? 1 : -1];

typedef struct {
    uint32_t head;          ///< Frames ever written, modulo 2^32.
    uint32_t head_line[15]; ///< Padding: head and tail are in cache lines of their own.
    uint32_t tail;          ///< Frames ever read.
    uint32_t tail_line[15]; ///< Padding.
    osal_can_frame_t frames[OSAL_CAN_RING_FRAMES];
} ring_t;

typedef struct {
    uint64_t magic;
    uint32_t overruns; ///< Frames for the node that were lost because its ring was full.
    uint32_t line[13]; ///< Padding.
    ring_t to_wire;
    ring_t to_node;
} bus_t;

static bool ring_put(ring_t* const ring, const osal_can_frame_t* const frame)
{
    const uint32_t head = ring->head;
    const uint32_t tail = __atomic_load_n(&ring->tail, __ATOMIC_ACQUIRE);
    if ((head - tail) >= OSAL_CAN_RING_FRAMES) {
        return false;
    }
    ring->frames[head & RING_MASK] = *frame;
    __atomic_store_n(&ring->head, head + 1U, __ATOMIC_RELEASE);
    return true;
}

static bool ring_take(ring_t* const ring, osal_can_frame_t* const out_frame)
{
    const uint32_t tail = ring->tail;
    if (__atomic_load_n(&ring->head, __ATOMIC_ACQUIRE) == tail) {
        return false;
    }
    *out_frame = ring->frames[tail & RING_MASK];
    __atomic_store_n(&ring->tail, tail + 1U, __ATOMIC_RELEASE);
    return true;
}

/// Empty the ring: frames that were sent before a controller is switched on do not reach it.
static void ring_discard(ring_t* const ring)
{
    __atomic_store_n(&ring->tail, __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE), __ATOMIC_RELEASE);
}

status_t can_shm_create(const char* const name)
{
    osal_shm_t shm;
    const status_t status = osal_shm_create(&shm, name, sizeof(bus_t));
    if (status != STATUS_OK) {
        return (status == STATUS_EXHAUSTED) ? STATUS_IO : status;
    }
    bus_t* const bus = osal_shm_address(&shm);
    __atomic_store_n(&bus->magic, BUS_MAGIC, __ATOMIC_RELEASE);
    osal_shm_close(&shm);
    return STATUS_OK;
}

status_t can_shm_open(osal_can_t* const can, const char* const name)
{
    osal_shm_t shm;
    const status_t status = osal_shm_open(&shm, name);
    if (status != STATUS_OK) {
        return status;
    }
    bus_t* const bus = osal_shm_address(&shm);
    if ((osal_shm_size(&shm) < sizeof(bus_t)) ||
        (__atomic_load_n(&bus->magic, __ATOMIC_ACQUIRE) != BUS_MAGIC)) {
        osal_shm_close(&shm);
        return STATUS_NOT_FOUND;
    }
    can->shared     = bus;
    can->carries_fd = true;
    if (can->end == OSAL_CAN_NODE) {
        ring_discard(&bus->to_node);
        can->overruns = __atomic_load_n(&bus->overruns, __ATOMIC_RELAXED);
    }
    return STATUS_OK;
}

void can_shm_close(osal_can_t* const can)
{
    osal_shm_t shm = {can->shared, sizeof(bus_t)};
    osal_shm_close(&shm);
}

status_t can_shm_send(osal_can_t* const can, const osal_can_frame_t* const frame)
{
    bus_t* const bus = can->shared;
    if (ring_put((can->end == OSAL_CAN_NODE) ? &bus->to_wire : &bus->to_node, frame)) {
        return STATUS_OK;
    }
    can->refused++;
    if (can->end == OSAL_CAN_WIRE) {
        (void)__atomic_add_fetch(&bus->overruns, 1U, __ATOMIC_RELAXED);
    }
    return STATUS_FULL;
}

status_t can_shm_receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    bus_t* const bus = can->shared;
    can->overruns    = __atomic_load_n(&bus->overruns, __ATOMIC_RELAXED);
    return ring_take((can->end == OSAL_CAN_NODE) ? &bus->to_node : &bus->to_wire, out_frame) ? STATUS_OK
                                                                                             : STATUS_EMPTY;
}
