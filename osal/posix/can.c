// SPDX-License-Identifier: Apache-2.0
// Two carriers behind one contract: rings in shared memory ("shm:") and SocketCAN ("can:"). Each ring has one
// writer and one reader and needs no lock: the writer alone moves `head`, the reader alone moves `tail`.
#define _GNU_SOURCE
#include "osal/include/osal/can.h"

#include "fsw/framework/base/assertion.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/shm.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stddef.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define ADDRESS_LENGTH_MAX 64U
#define BUS_MAGIC 0x68697263616E6275ULL
#define RING_MASK (OSAL_CAN_RING_FRAMES - 1U)
#define CLASSIC_LENGTH_MAX 8U

typedef char ring_size_is_a_power_of_two[((OSAL_CAN_RING_FRAMES & RING_MASK) == 0U) ? 1 : -1];
typedef char flags_are_those_of_linux[((OSAL_CAN_FLAG_BRS == CANFD_BRS) && (OSAL_CAN_FLAG_ESI == CANFD_ESI) &&
                                       (OSAL_CAN_EXTENDED == CAN_EFF_FLAG) &&
                                       (OSAL_CAN_ERROR == CAN_ERR_FLAG) && (OSAL_CAN_REMOTE == CAN_RTR_FLAG))
                                          ? 1
                                          : -1];

typedef struct {
    uint32_t head; ///< Frames ever written, modulo 2^32.
    uint32_t head_line[15];
    uint32_t tail; ///< Frames ever read.
    uint32_t tail_line[15];
    osal_can_frame_t frames[OSAL_CAN_RING_FRAMES];
} ring_t;

typedef struct {
    uint64_t magic;
    uint32_t overruns; ///< Frames for the node that found its ring full.
    uint32_t line[13];
    ring_t to_wire;
    ring_t to_node;
} bus_t;

// --- Rings ---------------------------------------------------------------------------------------------

static bool ring_put(ring_t* ring, const osal_can_frame_t* frame)
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

static bool ring_take(ring_t* ring, osal_can_frame_t* out_frame)
{
    const uint32_t tail = ring->tail;
    if (__atomic_load_n(&ring->head, __ATOMIC_ACQUIRE) == tail) {
        return false;
    }
    *out_frame = ring->frames[tail & RING_MASK];
    __atomic_store_n(&ring->tail, tail + 1U, __ATOMIC_RELEASE);
    return true;
}

/// A controller that is switched on has received nothing yet.
static void ring_discard(ring_t* ring)
{
    __atomic_store_n(&ring->tail, __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE), __ATOMIC_RELEASE);
}

/// "shm:NAME" as the name of a shared memory, "/NAME"; false if the address is not of that kind.
static bool shm_name_of(const char* address, char* out_name)
{
    const size_t length = strlen(address);
    if ((strncmp(address, "shm:", 4U) != 0) || (length > ADDRESS_LENGTH_MAX)) {
        return false;
    }
    out_name[0] = '/';
    (void)memcpy(&out_name[1], &address[4], length - 3U);
    return true;
}

status_t osal_can_create(const char* address)
{
    FSW_ASSERT(address != NULL);
    char name[ADDRESS_LENGTH_MAX + 1U];
    osal_shm_t shm;
    if (!shm_name_of(address, name)) {
        return STATUS_INVALID;
    }
    const status_t status = osal_shm_create(&shm, name, sizeof(bus_t));
    if (status != STATUS_OK) {
        return (status == STATUS_EXHAUSTED) ? STATUS_IO : status;
    }
    bus_t* const bus = osal_shm_address(&shm);
    __atomic_store_n(&bus->magic, BUS_MAGIC, __ATOMIC_RELEASE);
    osal_shm_close(&shm);
    return STATUS_OK;
}

status_t osal_can_destroy(const char* address)
{
    FSW_ASSERT(address != NULL);
    char name[ADDRESS_LENGTH_MAX + 1U];
    if (!shm_name_of(address, name) || (osal_shm_remove(name) != STATUS_OK)) {
        return STATUS_NOT_FOUND;
    }
    return STATUS_OK;
}

static status_t open_rings(osal_can_t* can, const char* name, osal_can_end_t end)
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
    can->shared = bus;
    if (end == OSAL_CAN_NODE) {
        ring_discard(&bus->to_node);
        can->overruns = __atomic_load_n(&bus->overruns, __ATOMIC_RELAXED);
    }
    return STATUS_OK;
}

static status_t send_to_ring(osal_can_t* can, const osal_can_frame_t* frame)
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

static status_t receive_from_ring(osal_can_t* can, osal_can_frame_t* out_frame)
{
    bus_t* const bus = can->shared;
    can->overruns    = __atomic_load_n(&bus->overruns, __ATOMIC_RELAXED);
    return ring_take((can->end == OSAL_CAN_NODE) ? &bus->to_node : &bus->to_wire, out_frame) ? STATUS_OK
                                                                                             : STATUS_EMPTY;
}

// --- SocketCAN -----------------------------------------------------------------------------------------

static status_t status_of(int error)
{
    switch (error) {
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
    case ESOCKTNOSUPPORT:
        return STATUS_UNSUPPORTED;
    case ENODEV:
    case ENXIO:
        return STATUS_NOT_FOUND;
    case EPERM:
    case EACCES:
        return STATUS_DENIED;
    default:
        return STATUS_IO;
    }
}

/// FD frames, error frames, receive time, and the count of frames the kernel had to drop. Its own frames a
/// controller does not receive: that is how the kernel begins.
static bool configure(int descriptor)
{
    const int on                    = 1;
    const can_err_mask_t all_errors = CAN_ERR_MASK;
    bool is_good = (setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof(on)) == 0);
    is_good      = is_good &&
              (setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &all_errors, sizeof(all_errors)) == 0);
    is_good = is_good && (setsockopt(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof(on)) == 0);
    is_good = is_good && (setsockopt(descriptor, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof(on)) == 0);
    return is_good;
}

static status_t open_socketcan(osal_can_t* can, const char* interface)
{
    struct sockaddr_can address = {.can_family = AF_CAN};
    if ((interface[0] == '\0') || (strlen(interface) >= (size_t)IFNAMSIZ)) {
        return STATUS_INVALID;
    }
    if (can->end == OSAL_CAN_WIRE) {
        return STATUS_UNSUPPORTED;
    }
    const int descriptor = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    if (descriptor < 0) {
        return status_of(errno);
    }
    const unsigned index = if_nametoindex(interface);
    address.can_ifindex  = (int)index;
    status_t status      = STATUS_OK;
    if (index == 0U) {
        status = STATUS_NOT_FOUND;
    } else if (!configure(descriptor)) {
        status = STATUS_IO;
    } else if (bind(descriptor, (const struct sockaddr*)(const void*)&address, sizeof(address)) != 0) {
        status = status_of(errno);
    } else {
        can->descriptor = descriptor;
    }
    if (status != STATUS_OK) {
        (void)close(descriptor);
    }
    return status;
}

static status_t send_to_kernel(osal_can_t* can, const osal_can_frame_t* frame)
{
    struct canfd_frame raw = {.can_id = frame->id, .len = frame->length};
    const bool is_fd       = ((frame->flags & OSAL_CAN_FLAG_FD) != 0U);
    raw.flags              = is_fd ? (uint8_t)(frame->flags & (OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI)) : 0U;
    (void)memcpy(raw.data, frame->data, frame->length);
    ssize_t sent = 0;
    do {
        sent = send(can->descriptor, &raw, is_fd ? CANFD_MTU : CAN_MTU, 0);
    } while ((sent < 0) && (errno == EINTR));
    if (sent >= 0) {
        return STATUS_OK;
    }
    if ((errno == EAGAIN) || (errno == ENOBUFS)) {
        can->refused++;
        return STATUS_FULL;
    }
    return (errno == EINVAL) ? STATUS_INVALID : STATUS_CLOSED; // EINVAL: the interface carries no FD frames.
}

/// Receive time on the monotonic clock, from the kernel's time stamp on the wall clock.
static uint64_t monotonic_of(const struct timespec* stamp)
{
    struct timespec wall  = {0, 0};
    const uint64_t now_ns = osal_clock_monotonic_ns();
    (void)clock_gettime(CLOCK_REALTIME, &wall);
    const int64_t age_ns =
        ((int64_t)(wall.tv_sec - stamp->tv_sec) * 1000000000) + (int64_t)(wall.tv_nsec - stamp->tv_nsec);
    return ((age_ns > 0) && ((uint64_t)age_ns < now_ns)) ? (now_ns - (uint64_t)age_ns) : now_ns;
}

static void read_control(osal_can_t* can, struct msghdr* message, osal_can_frame_t* out_frame)
{
    out_frame->time_ns = 0U;
    for (struct cmsghdr* part = CMSG_FIRSTHDR(message); part != NULL; part = CMSG_NXTHDR(message, part)) {
        if ((part->cmsg_level == SOL_SOCKET) && (part->cmsg_type == SO_TIMESTAMPNS)) {
            struct timespec stamp;
            (void)memcpy(&stamp, CMSG_DATA(part), sizeof(stamp));
            out_frame->time_ns = monotonic_of(&stamp);
        } else if ((part->cmsg_level == SOL_SOCKET) && (part->cmsg_type == SO_RXQ_OVFL)) {
            (void)memcpy(&can->overruns, CMSG_DATA(part), sizeof(can->overruns));
        } else {
            // Nothing else was asked for.
        }
    }
    if (out_frame->time_ns == 0U) {
        out_frame->time_ns = osal_clock_monotonic_ns();
    }
}

static status_t receive_from_kernel(osal_can_t* can, osal_can_frame_t* out_frame)
{
    struct canfd_frame raw;
    struct iovec place = {.iov_base = &raw, .iov_len = sizeof(raw)};
    union {
        struct cmsghdr header; // For its alignment.
        uint8_t octets[CMSG_SPACE(sizeof(struct timespec)) + CMSG_SPACE(sizeof(uint32_t))];
    } control;
    struct msghdr message = {.msg_iov        = &place,
                             .msg_iovlen     = 1U,
                             .msg_control    = control.octets,
                             .msg_controllen = sizeof(control.octets)};
    ssize_t size          = 0;
    do {
        size = recvmsg(can->descriptor, &message, 0);
    } while ((size < 0) && (errno == EINTR));
    if (size < 0) {
        return ((errno == EAGAIN) || (errno == EWOULDBLOCK)) ? STATUS_EMPTY : STATUS_CLOSED;
    }
    if (((size_t)size != CAN_MTU) && ((size_t)size != CANFD_MTU)) {
        return STATUS_CLOSED; // Not a frame: the interface is gone.
    }
    const bool is_fd = ((size_t)size == CANFD_MTU);
    *out_frame       = (osal_can_frame_t){.id = raw.can_id, .length = raw.len};
    out_frame->flags =
        is_fd ? (uint8_t)((raw.flags & (OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI)) | OSAL_CAN_FLAG_FD) : 0U;
    (void)memcpy(out_frame->data, raw.data, is_fd ? sizeof(raw.data) : (size_t)CLASSIC_LENGTH_MAX);
    read_control(can, &message, out_frame);
    return STATUS_OK;
}

// --- The contract --------------------------------------------------------------------------------------

status_t osal_can_open(osal_can_t* can, const char* address, osal_can_end_t end)
{
    FSW_ASSERT((can != NULL) && (address != NULL));
    char name[ADDRESS_LENGTH_MAX + 1U];
    *can = (osal_can_t){.shared = NULL, .descriptor = -1, .end = end};
    if (shm_name_of(address, name)) {
        return open_rings(can, name, end);
    }
    if (strncmp(address, "can:", 4U) == 0) {
        return open_socketcan(can, &address[4]);
    }
    return STATUS_INVALID;
}

void osal_can_close(osal_can_t* can)
{
    FSW_ASSERT(can != NULL);
    if (can->shared != NULL) {
        (void)munmap(can->shared, sizeof(bus_t));
    }
    if (can->descriptor >= 0) {
        (void)close(can->descriptor);
    }
    can->shared     = NULL;
    can->descriptor = -1;
}

/// A length that a frame on the bus can have.
static bool is_length(const osal_can_frame_t* frame)
{
    if ((frame->flags & OSAL_CAN_FLAG_FD) == 0U) {
        return frame->length <= CLASSIC_LENGTH_MAX;
    }
    const uint8_t length = frame->length;
    return (length <= 8U) || (length == 12U) || (length == 16U) || (length == 20U) || (length == 24U) ||
           (length == 32U) || (length == 48U) || (length == 64U);
}

status_t osal_can_send(osal_can_t* can, const osal_can_frame_t* frame)
{
    FSW_ASSERT((can != NULL) && (frame != NULL));
    if (!is_length(frame)) {
        return STATUS_INVALID;
    }
    if (can->shared != NULL) {
        return send_to_ring(can, frame);
    }
    return (can->descriptor >= 0) ? send_to_kernel(can, frame) : STATUS_CLOSED;
}

status_t osal_can_receive(osal_can_t* can, osal_can_frame_t* out_frame)
{
    FSW_ASSERT((can != NULL) && (out_frame != NULL));
    if (can->shared != NULL) {
        return receive_from_ring(can, out_frame);
    }
    return (can->descriptor >= 0) ? receive_from_kernel(can, out_frame) : STATUS_CLOSED;
}
