// SPDX-License-Identifier: Apache-2.0
// SocketCAN with a counted hand-over ("can:INTERFACE@NAME"). The shared memory has for each direction the
// numbers of frames announced and taken. Their difference, the frames on the way, is limited to the capacity
// of a ring of the "shm:" carrier, so that a full queue has the same effect on both carriers.
#define _GNU_SOURCE
#include "osal/common/can_port.h"

#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/shm.h"

#include <stddef.h>
#include <sys/mman.h>

#define COUNTS_MAGIC 0x68697263616E636EULL
#define TIMEOUT_NS (OSAL_CAN_TIMEOUT_MS * 1000000ULL)
// If no frame arrives for so long [ns], none is on the way: delivery takes milliseconds.
#define QUIET_NS 50000000ULL

typedef struct {
    uint32_t announced; ///< Frames that the sender has announced [wraps].
    uint32_t taken;     ///< Frames that the receiver has taken [wraps].
} direction_t;

typedef struct {
    uint64_t magic;
    uint32_t carries_errors; ///< The wire end's interface is virtual, and so passes error frames on.
    uint32_t overruns;       ///< Frames for the node that were lost because its queue was full.
    direction_t to_wire;
    direction_t to_node;
    uint32_t frames;
    uint32_t late;
    uint32_t lost;
    uint32_t external;
    uint32_t cuts;
} counts_t;

static uint32_t load(const uint32_t* const number)
{
    return __atomic_load_n(number, __ATOMIC_ACQUIRE);
}

static void store(uint32_t* const number, const uint32_t value)
{
    __atomic_store_n(number, value, __ATOMIC_RELEASE);
}

static void count(uint32_t* const number, const uint32_t more)
{
    (void)__atomic_add_fetch(number, more, __ATOMIC_RELAXED);
}

status_t can_counted_create(const char* const name, const char* const interface)
{
    osal_can_interface_t seen;
    osal_shm_t shm;
    status_t status = osal_can_interface_look(interface, &seen);
    if (status != STATUS_OK) {
        return status;
    }
    status = osal_shm_create(&shm, name, sizeof(counts_t));
    if (status != STATUS_OK) {
        return (status == STATUS_EXHAUSTED) ? STATUS_IO : status;
    }
    counts_t* const counts = osal_shm_address(&shm);
    counts->carries_errors = seen.is_virtual ? 1U : 0U;
    __atomic_store_n(&counts->magic, COUNTS_MAGIC, __ATOMIC_RELEASE);
    osal_shm_close(&shm);
    return STATUS_OK;
}

/// Map the shared counts of a bus. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID (name), STATUS_DENIED,
/// STATUS_IO.
static status_t attach(const char* const name, counts_t** const out_counts)
{
    osal_shm_t shm;
    const status_t status = osal_shm_open(&shm, name);
    if (status != STATUS_OK) {
        return status;
    }
    *out_counts = osal_shm_address(&shm);
    if ((osal_shm_size(&shm) < sizeof(counts_t)) ||
        (__atomic_load_n(&(*out_counts)->magic, __ATOMIC_ACQUIRE) != COUNTS_MAGIC)) {
        osal_shm_close(&shm);
        return STATUS_NOT_FOUND;
    }
    return STATUS_OK;
}

/// Returns the direction in which this end receives, or the one in which it sends.
static direction_t* direction_of(const osal_can_t* const can, const bool is_received)
{
    counts_t* const counts = can->shared;
    return ((can->end == OSAL_CAN_NODE) == is_received) ? &counts->to_node : &counts->to_wire;
}

/// Discard the frames that were sent before this end was opened, also those that are still on the way; the
/// "shm:" carrier does the same. If they were received later, they would be taken for frames that are
/// announced later.
static void discard_pending(osal_can_t* const can, direction_t* const direction)
{
    const uint32_t announced = load(&direction->announced);
    const uint64_t limit_ns  = osal_clock_monotonic_ns() + TIMEOUT_NS;
    bool is_quiet            = (direction->taken == announced);
    while (!is_quiet && (osal_clock_monotonic_ns() < limit_ns)) {
        osal_can_frame_t frame;
        is_quiet = !can_socket_wait(can, osal_clock_monotonic_ns() + QUIET_NS) ||
                   (can_socket_receive(can, &frame) == STATUS_CLOSED);
    }
    store(&direction->taken, announced);
}

status_t can_counted_open(osal_can_t* const can, const char* const name, const char* const interface)
{
    counts_t* counts = NULL;
    status_t status  = attach(name, &counts);
    if (status != STATUS_OK) {
        return status;
    }
    status = can_socket_open(can, interface);
    if (status != STATUS_OK) {
        (void)munmap(counts, sizeof(counts_t));
        return status;
    }
    can->shared = counts;
    discard_pending(can, direction_of(can, true));
    can->overruns = (can->end == OSAL_CAN_NODE) ? load(&counts->overruns) : 0U;
    return STATUS_OK;
}

void can_counted_close(osal_can_t* const can)
{
    (void)munmap(can->shared, sizeof(counts_t));
    can_socket_close(can);
}

status_t can_counted_send(osal_can_t* const can, const osal_can_frame_t* const frame)
{
    counts_t* const counts       = can->shared;
    direction_t* const direction = direction_of(can, false);
    const uint32_t announced     = direction->announced;
    if (((frame->id & OSAL_CAN_ERROR) != 0U) && (counts->carries_errors == 0U)) {
        return STATUS_UNSUPPORTED;
    }
    status_t status = STATUS_FULL;
    if ((announced - load(&direction->taken)) < OSAL_CAN_RING_FRAMES) {
        status = can_socket_send(can, frame);
    } else {
        can->refused++;
    }
    if (status == STATUS_OK) {
        store(&direction->announced, announced + 1U);
    } else if ((status == STATUS_FULL) && (can->end == OSAL_CAN_WIRE)) {
        count(&counts->overruns, 1U);
    } else if (status == STATUS_CLOSED) {
        count(&counts->cuts, 1U);
    } else {
        // A frame that was not sent is not announced.
    }
    return status;
}

/// Wait for an announced frame. STATUS_OK, STATUS_EMPTY (the frame has not arrived in time), STATUS_CLOSED.
static status_t receive_late(osal_can_t* const can, osal_can_frame_t* const out_frame, const uint32_t due)
{
    counts_t* const counts  = can->shared;
    const uint64_t until_ns = osal_clock_monotonic_ns() + TIMEOUT_NS;
    status_t status         = STATUS_EMPTY;
    while ((status == STATUS_EMPTY) && can_socket_wait(can, until_ns)) {
        status = can_socket_receive(can, out_frame);
    }
    if (status == STATUS_OK) {
        count(&counts->late, 1U);
    } else if (status == STATUS_EMPTY) {
        count(&counts->lost, due);
        direction_t* const direction = direction_of(can, true);
        // If one of these frames arrives later, it is counted as external.
        store(&direction->taken, direction->taken + due);
    } else {
        // STATUS_CLOSED: the caller opens the bus again.
    }
    return status;
}

/// Set the overruns of the node: the frames that the kernel dropped and those that the wire end could not
/// send.
static void note_overruns(osal_can_t* const can, const counts_t* const counts, const uint32_t by_kernel)
{
    if (can->end == OSAL_CAN_NODE) {
        can->overruns = by_kernel + load(&counts->overruns);
    }
}

status_t can_counted_receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    counts_t* const counts       = can->shared;
    direction_t* const direction = direction_of(can, true);
    const uint32_t due           = load(&direction->announced) - direction->taken;
    status_t status              = can_socket_receive(can, out_frame);
    note_overruns(can, counts, can->kernel_overruns);
    if ((status == STATUS_EMPTY) && (due > 0U)) {
        status = receive_late(can, out_frame, due);
    }
    if (status != STATUS_OK) {
        count(&counts->cuts, (status == STATUS_CLOSED) ? 1U : 0U);
        return status;
    }
    const bool is_own_report = ((out_frame->id & OSAL_CAN_ERROR) != 0U) && (counts->carries_errors == 0U);
    if (is_own_report) {
        return STATUS_OK; // A real controller reports its own errors; the wire end did not send this frame.
    }
    if (due > 0U) {
        store(&direction->taken, direction->taken + 1U);
        count(&counts->frames, 1U);
    } else {
        count(&counts->external, 1U);
    }
    return STATUS_OK;
}

void can_counted_add_external(osal_can_t* const can, const uint32_t frames)
{
    counts_t* const counts = can->shared;
    count(&counts->external, frames);
}

status_t can_counted_look(const char* const name, osal_can_hand_over_t* const out_counts)
{
    counts_t* counts = NULL;
    if (attach(name, &counts) != STATUS_OK) {
        return STATUS_NOT_FOUND;
    }
    *out_counts = (osal_can_hand_over_t){.frames   = load(&counts->frames),
                                         .late     = load(&counts->late),
                                         .lost     = load(&counts->lost),
                                         .external = load(&counts->external),
                                         .cuts     = load(&counts->cuts)};
    (void)munmap(counts, sizeof(counts_t));
    return STATUS_OK;
}
