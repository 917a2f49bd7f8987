// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/tipc.h"

#include "base/assertion.h"
#include "osal/posix/socket_receive.h"

#include <errno.h>
#include <linux/tipc.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/// Room for the error code of a returned message, which is the first control data.
#define CONTROL_OCTETS 64U

static struct sockaddr_tipc native(const osal_tipc_name_t name)
{
    struct sockaddr_tipc address;
    (void)memset(&address, 0, sizeof address);
    address.family                  = AF_TIPC;
    address.addrtype                = TIPC_SERVICE_ADDR;
    address.addr.name.name.type     = name.type;
    address.addr.name.name.instance = name.instance;
    return address;
}

static uint64_t identity_of(const struct sockaddr_tipc* const address)
{
    return ((uint64_t)address->addr.id.node << 32U) | address->addr.id.ref;
}

/// Convert to the type by which the calls of the kernel take an address of any kind.
static const struct sockaddr* generic(const struct sockaddr_tipc* const address)
{
    return (const struct sockaddr*)(const void*)address;
}

static status_t status_of_open(const int error)
{
    switch (error) {
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
    case ESOCKTNOSUPPORT:
        return STATUS_UNSUPPORTED;
    case EACCES:
    case EPERM:
        return STATUS_DENIED;
    case EMFILE:
    case ENFILE:
    case ENOBUFS:
    case ENOMEM:
        return STATUS_EXHAUSTED;
    default:
        return STATUS_IO;
    }
}

static status_t status_of_send(const int error)
{
    switch (error) {
    case EAGAIN:
    case ENOBUFS:
    case ENOMEM:
        return STATUS_FULL;
    case EMSGSIZE:
        return STATUS_TOO_LARGE;
    case EHOSTUNREACH:
    case ENETUNREACH:
    case ECONNREFUSED:
    case ECONNRESET:
    case EPIPE:
        return STATUS_CLOSED;
    default:
        return STATUS_IO;
    }
}

static int open_descriptor(const int type)
{
    return socket(AF_TIPC, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

static bool bind_name(const int descriptor, const osal_tipc_name_t name, const osal_tipc_scope_t scope)
{
    struct sockaddr_tipc address;
    (void)memset(&address, 0, sizeof address);
    address.family   = AF_TIPC;
    address.addrtype = TIPC_SERVICE_RANGE;
    address.scope    = (signed char)((scope == OSAL_TIPC_NODE) ? TIPC_NODE_SCOPE : TIPC_CLUSTER_SCOPE);
    address.addr.nameseq.type  = name.type;
    address.addr.nameseq.lower = name.instance;
    address.addr.nameseq.upper = name.instance;
    return bind(descriptor, generic(&address), (socklen_t)sizeof address) == 0;
}

static bool set_option(const int descriptor, const int option, const uint32_t value)
{
    return setsockopt(descriptor, SOL_TIPC, option, &value, (socklen_t)sizeof value) == 0;
}

status_t osal_tipc_open(osal_socket_t* const sock, const osal_tipc_kind_t kind,
                        const osal_tipc_name_t* const name, const osal_tipc_scope_t scope)
{
    FSW_ASSERT((sock != NULL) && ((name == NULL) || (name->type >= OSAL_TIPC_TYPE_MIN)));
    const bool is_message = (kind == OSAL_TIPC_MESSAGE);
    *sock                 = (osal_socket_t)OSAL_SOCKET_CLOSED;
    const int descriptor  = open_descriptor(is_message ? SOCK_RDM : SOCK_DGRAM);
    if (descriptor < 0) {
        return status_of_open(errno);
    }
    // TIPC gives messages of higher importance more room at the receiver.
    const bool is_ready = (!is_message || (set_option(descriptor, TIPC_DEST_DROPPABLE, 0U) &&
                                           set_option(descriptor, TIPC_IMPORTANCE, TIPC_HIGH_IMPORTANCE))) &&
                          ((name == NULL) || bind_name(descriptor, *name, scope));
    if (!is_ready) {
        const status_t status = status_of_open(errno);
        (void)close(descriptor);
        return status;
    }
    sock->descriptor = descriptor;
    return STATUS_OK;
}

status_t osal_tipc_send(osal_socket_t* const sock, const osal_tipc_name_t to, const uint8_t* const octets,
                        const size_t size)
{
    FSW_ASSERT((sock != NULL) && (octets != NULL) && (size > 0U));
    const struct sockaddr_tipc address = native(to);
    ssize_t sent                       = 0;
    do {
        sent = sendto(sock->descriptor, octets, size, MSG_NOSIGNAL | MSG_DONTWAIT, generic(&address),
                      (socklen_t)sizeof address);
    } while ((sent < 0) && (errno == EINTR));
    return (sent >= 0) ? STATUS_OK : status_of_send(errno);
}

/// True if the message was sent by this socket and returned.
static bool is_returned(struct msghdr* const message)
{
    for (struct cmsghdr* part = CMSG_FIRSTHDR(message); part != NULL; part = CMSG_NXTHDR(message, part)) {
        if ((part->cmsg_level == SOL_TIPC) && (part->cmsg_type == TIPC_ERRINFO)) {
            return true;
        }
    }
    return false;
}

status_t osal_tipc_receive(osal_socket_t* const sock, uint64_t* const out_from, uint8_t* const octets,
                           const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((sock != NULL) && (out_from != NULL) && (octets != NULL) && (out_size != NULL));
    struct sockaddr_tipc from;
    union {
        struct cmsghdr aligned;
        uint8_t octets[CONTROL_OCTETS];
    } control;
    struct iovec buffer   = {.iov_base = octets, .iov_len = capacity};
    struct msghdr message = {.msg_name       = &from,
                             .msg_namelen    = sizeof from,
                             .msg_iov        = &buffer,
                             .msg_iovlen     = 1U,
                             .msg_control    = &control,
                             .msg_controllen = sizeof control};
    ssize_t size          = 0;
    (void)memset(&from, 0, sizeof from);
    do {
        size = socket_receive(sock, &message);
    } while ((size < 0) && (errno == EINTR));
    *out_size = 0U;
    *out_from = identity_of(&from);
    if (size < 0) {
        return ((errno == EAGAIN) || (errno == EWOULDBLOCK)) ? STATUS_EMPTY : STATUS_IO;
    }
    if (is_returned(&message)) {
        return STATUS_FORBIDDEN;
    }
    if ((message.msg_flags & MSG_TRUNC) != 0) {
        return STATUS_TOO_LARGE;
    }
    *out_size = (size_t)size;
    return STATUS_OK;
}

status_t osal_tipc_identity(const osal_socket_t* const sock, uint64_t* const out_identity)
{
    FSW_ASSERT((sock != NULL) && (out_identity != NULL));
    struct sockaddr_tipc address = {.family = AF_TIPC};
    socklen_t size               = (socklen_t)sizeof address;
    if (getsockname(sock->descriptor, (struct sockaddr*)(void*)&address, &size) != 0) {
        return STATUS_IO;
    }
    *out_identity = identity_of(&address);
    return STATUS_OK;
}

status_t osal_tipc_watch_open(osal_socket_t* const sock, const uint32_t type)
{
    FSW_ASSERT((sock != NULL) && (type >= OSAL_TIPC_TYPE_MIN));
    struct tipc_subscr subscription;
    const struct sockaddr_tipc service = native((osal_tipc_name_t){TIPC_TOP_SRV, TIPC_TOP_SRV});
    *sock                              = (osal_socket_t)OSAL_SOCKET_CLOSED;
    const int descriptor               = open_descriptor(SOCK_SEQPACKET);
    if (descriptor < 0) {
        return status_of_open(errno);
    }
    (void)memset(&subscription, 0, sizeof subscription);
    subscription.seq.type  = type;
    subscription.seq.upper = UINT32_MAX;
    subscription.timeout   = (uint32_t)TIPC_WAIT_FOREVER;
    subscription.filter    = TIPC_SUB_PORTS;
    // The subscription is sent together with the connection request, so no wait for an answer is needed.
    const ssize_t sent = sendto(descriptor, &subscription, sizeof subscription, MSG_NOSIGNAL | MSG_DONTWAIT,
                                generic(&service), (socklen_t)sizeof service);
    if (sent < 0) {
        (void)close(descriptor);
        return STATUS_IO;
    }
    sock->descriptor = descriptor;
    return STATUS_OK;
}

status_t osal_tipc_watch_next(osal_socket_t* const sock, osal_tipc_event_t* const out_event)
{
    FSW_ASSERT((sock != NULL) && (out_event != NULL));
    struct tipc_event event;
    ssize_t size = 0;
    do {
        size = recv(sock->descriptor, &event, sizeof event, MSG_DONTWAIT);
    } while ((size < 0) && (errno == EINTR));
    if (size < 0) {
        return ((errno == EAGAIN) || (errno == EWOULDBLOCK)) ? STATUS_EMPTY : STATUS_IO;
    }
    if (size != (ssize_t)sizeof event) {
        return STATUS_CLOSED;
    }
    *out_event =
        (osal_tipc_event_t){.is_published = (event.event == TIPC_PUBLISHED), .instance = event.found_lower};
    return STATUS_OK;
}
