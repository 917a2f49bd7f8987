// SPDX-License-Identifier: Apache-2.0
// SocketCAN ("can:INTERFACE"): one raw socket, non-blocking.
#define _GNU_SOURCE
#include "osal/common/can_port.h"

#include "osal/include/osal/clock.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <stddef.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

/// Size of the receive buffer. The kernel doubles it and counts about 770 octets for each frame: room for
/// about 2 700 frames.
#define RECEIVE_OCTETS 1048576
#define NS_PER_MS 1000000U

typedef char flags_are_those_of_linux[((OSAL_CAN_FLAG_BRS == CANFD_BRS) && (OSAL_CAN_FLAG_ESI == CANFD_ESI) &&
                                       (OSAL_CAN_EXTENDED == CAN_EFF_FLAG) &&
                                       (OSAL_CAN_ERROR == CAN_ERR_FLAG) && (OSAL_CAN_REMOTE == CAN_RTR_FLAG))
                                          ? 1
                                          : -1];
typedef char classes_are_those_of_linux
    [((OSAL_CAN_ERROR_TX_TIMEOUT == CAN_ERR_TX_TIMEOUT) &&
      (OSAL_CAN_ERROR_LOST_ARBITRATION == CAN_ERR_LOSTARB) && (OSAL_CAN_ERROR_CONTROLLER == CAN_ERR_CRTL) &&
      (OSAL_CAN_ERROR_PROTOCOL == CAN_ERR_PROT) && (OSAL_CAN_ERROR_TRANSCEIVER == CAN_ERR_TRX) &&
      (OSAL_CAN_ERROR_NO_ACK == CAN_ERR_ACK) && (OSAL_CAN_ERROR_BUS_OFF == CAN_ERR_BUSOFF) &&
      (OSAL_CAN_ERROR_BUS == CAN_ERR_BUSERROR) && (OSAL_CAN_ERROR_RESTARTED == CAN_ERR_RESTARTED))
         ? 1
         : -1];

static status_t status_of(const int error)
{
    switch (error) {
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
    case ESOCKTNOSUPPORT:
        return STATUS_UNSUPPORTED;
    case ENODEV:
    case ENXIO:
        return STATUS_NOT_FOUND;
    case ENETDOWN:
        return STATUS_CLOSED;
    case EPERM:
    case EACCES:
        return STATUS_DENIED;
    default:
        return STATUS_IO;
    }
}

/// Enable FD frames, error frames of all classes, the receive time, and the count of frames that the kernel
/// drops. A controller does not receive its own frames: that is the default of the kernel.
static bool configure(const int descriptor)
{
    const int on                    = 1;
    const int octets                = RECEIVE_OCTETS;
    const can_err_mask_t all_errors = CAN_ERR_MASK;
    bool is_good = (setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) == 0);
    is_good      = is_good &&
              (setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &all_errors, sizeof all_errors) == 0);
    is_good = is_good && (setsockopt(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) == 0);
    is_good = is_good && (setsockopt(descriptor, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) == 0);
    // Only a process with CAP_NET_ADMIN may pass the limit net.core.rmem_max; SO_RCVBUF is cut to it.
    if (is_good && (setsockopt(descriptor, SOL_SOCKET, SO_RCVBUFFORCE, &octets, sizeof octets) != 0)) {
        is_good = (setsockopt(descriptor, SOL_SOCKET, SO_RCVBUF, &octets, sizeof octets) == 0);
    }
    return is_good;
}

/// Check the interface: it exists, is for CAN, and is up. Note whether it carries FD frames;
/// the users of FD check that.
static status_t inspect(osal_can_t* const can, const int descriptor, const char* const interface,
                        int* const out_index)
{
    struct ifreq request;
    (void)memset(&request, 0, sizeof request);
    (void)memcpy(request.ifr_name, interface, strlen(interface));
    if (ioctl(descriptor, SIOCGIFINDEX, &request) != 0) {
        return status_of(errno);
    }
    *out_index = request.ifr_ifindex;
    if (ioctl(descriptor, SIOCGIFHWADDR, &request) != 0) {
        return status_of(errno);
    }
    if (request.ifr_hwaddr.sa_family != ARPHRD_CAN) {
        return STATUS_UNSUPPORTED;
    }
    if (ioctl(descriptor, SIOCGIFFLAGS, &request) != 0) {
        return status_of(errno);
    }
    if (((unsigned)request.ifr_flags & (unsigned)IFF_UP) == 0U) {
        return STATUS_CLOSED;
    }
    if (ioctl(descriptor, SIOCGIFMTU, &request) != 0) {
        return status_of(errno);
    }
    can->carries_fd = (request.ifr_mtu >= (int)CANFD_MTU);
    return STATUS_OK;
}

status_t can_socket_open(osal_can_t* const can, const char* const interface)
{
    struct sockaddr_can address = {.can_family = AF_CAN};
    const int descriptor        = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    if (descriptor < 0) {
        return status_of(errno);
    }
    int index       = 0;
    status_t status = inspect(can, descriptor, interface, &index);
    if (status == STATUS_OK) {
        address.can_ifindex = index;
        if (!configure(descriptor)) {
            status = STATUS_IO;
        } else if (bind(descriptor, (const struct sockaddr*)(const void*)&address, sizeof address) != 0) {
            status = status_of(errno);
        } else {
            can->descriptor = descriptor;
        }
    }
    if (status != STATUS_OK) {
        (void)close(descriptor);
    }
    return status;
}

void can_socket_close(osal_can_t* const can)
{
    (void)close(can->descriptor);
}

status_t can_socket_filter(const osal_can_t* const can)
{
    struct can_filter filters[OSAL_CAN_FILTERS_MAX];
    size_t count = 0U;
    for (size_t i = 0U; i < can->filter_count; i++) {
        const uint32_t mask   = can->filters[i].mask;
        const uint32_t wanted = can->filters[i].id & mask;
        // The kernel gives this bit another meaning: in a mask "error frames only", in an identifier "all
        // frames except these". Data frames do not have this bit, so a filter that requires it passes none.
        if ((wanted & OSAL_CAN_ERROR) == 0U) {
            filters[count] = (struct can_filter){.can_id = wanted, .can_mask = mask & ~OSAL_CAN_ERROR};
            count++;
        }
    }
    const socklen_t size = (socklen_t)(count * sizeof filters[0]);
    const void* const at = (size > 0U) ? filters : NULL;
    return (setsockopt(can->descriptor, SOL_CAN_RAW, CAN_RAW_FILTER, at, size) == 0) ? STATUS_OK : STATUS_IO;
}

status_t can_socket_send(osal_can_t* const can, const osal_can_frame_t* const frame)
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
    // EINVAL: an FD frame on an interface for classic frames.
    return (errno == EINVAL) ? STATUS_INVALID : STATUS_CLOSED;
}

/// Receive time on the monotonic clock, from the kernel's time stamp on the wall clock.
static uint64_t monotonic_of(const struct timespec* const stamp)
{
    struct timespec wall  = {0, 0};
    const uint64_t now_ns = osal_clock_monotonic_ns();
    (void)clock_gettime(CLOCK_REALTIME, &wall);
    const int64_t age_ns =
        ((int64_t)(wall.tv_sec - stamp->tv_sec) * 1000000000) + (int64_t)(wall.tv_nsec - stamp->tv_nsec);
    return ((age_ns > 0) && ((uint64_t)age_ns < now_ns)) ? (now_ns - (uint64_t)age_ns) : now_ns;
}

static void read_control(osal_can_t* const can, struct msghdr* const message,
                         osal_can_frame_t* const out_frame)
{
    out_frame->time_ns = 0U;
    for (struct cmsghdr* part = CMSG_FIRSTHDR(message); part != NULL; part = CMSG_NXTHDR(message, part)) {
        if ((part->cmsg_level == SOL_SOCKET) && (part->cmsg_type == SO_TIMESTAMPNS)) {
            struct timespec stamp;
            (void)memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
            out_frame->time_ns = monotonic_of(&stamp);
        } else if ((part->cmsg_level == SOL_SOCKET) && (part->cmsg_type == SO_RXQ_OVFL)) {
            (void)memcpy(&can->kernel_overruns, CMSG_DATA(part), sizeof can->kernel_overruns);
            can->overruns = can->kernel_overruns;
        } else {
            // The kernel sends no other control data, because this program requests none.
        }
    }
    if (out_frame->time_ns == 0U) {
        out_frame->time_ns = osal_clock_monotonic_ns();
    }
}

status_t can_socket_receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    struct canfd_frame raw;
    struct iovec buffer = {.iov_base = &raw, .iov_len = sizeof raw};
    union {
        struct cmsghdr header; // Gives the buffer the alignment of a header.
        uint8_t octets[CMSG_SPACE(sizeof(struct timespec)) + CMSG_SPACE(sizeof(uint32_t))];
    } control;
    struct msghdr message = {.msg_iov        = &buffer,
                             .msg_iovlen     = 1U,
                             .msg_control    = control.octets,
                             .msg_controllen = sizeof control.octets};
    ssize_t size          = 0;
    do {
        size = recvmsg(can->descriptor, &message, 0);
    } while ((size < 0) && (errno == EINTR));
    if (size < 0) {
        return ((errno == EAGAIN) || (errno == EWOULDBLOCK)) ? STATUS_EMPTY : STATUS_CLOSED;
    }
    if (((size_t)size != CAN_MTU) && ((size_t)size != CANFD_MTU)) {
        return STATUS_CLOSED; // No frame has this size: the kernel reports that the interface was removed.
    }
    const bool is_fd = ((size_t)size == CANFD_MTU);
    *out_frame       = (osal_can_frame_t){.id = raw.can_id, .length = raw.len};
    out_frame->flags =
        is_fd ? (uint8_t)((raw.flags & (OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI)) | OSAL_CAN_FLAG_FD) : 0U;
    (void)memcpy(out_frame->data, raw.data, is_fd ? sizeof raw.data : (size_t)CAN_MAX_DLEN);
    read_control(can, &message, out_frame);
    return STATUS_OK;
}

bool can_socket_wait(const osal_can_t* const can, const uint64_t until_ns)
{
    const uint64_t now_ns = osal_clock_monotonic_ns();
    if (now_ns >= until_ns) {
        return false;
    }
    struct pollfd socket      = {.fd = can->descriptor, .events = POLLIN};
    const uint64_t remains_ms = ((until_ns - now_ns) / NS_PER_MS) + 1U;
    const int ready           = poll(&socket, 1U, (int)remains_ms);
    return (ready > 0) || ((ready < 0) && (errno == EINTR));
}
