// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/socket.h"

#include "base/assertion.h"
#include "osal/include/osal/clock.h"
#include "osal/posix/socket_receive.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define LOCAL_PATH_MAX 100U
#define BACKLOG 16
#define NS_PER_MS 1000000ULL
#define SKIPPED_WAITS_MAX 127U // Largest number of waits that skip polling; a mask.

static struct sockaddr_in native(const osal_address_t address)
{
    struct sockaddr_in result = {.sin_family = AF_INET, .sin_port = htons(address.port)};
    result.sin_addr.s_addr    = htonl(address.ipv4);
    return result;
}

static osal_address_t osal_address(const struct sockaddr_in* const address)
{
    return (osal_address_t){.ipv4 = ntohl(address->sin_addr.s_addr), .port = ntohs(address->sin_port)};
}

/// Convert to the type by which the calls of the kernel take an address of any kind.
static const struct sockaddr* generic(const void* const address)
{
    return (const struct sockaddr*)address;
}

static bool is_again(const int error)
{
    return (error == EAGAIN) || (error == EWOULDBLOCK);
}

static bool is_out_of_resources(const int error)
{
    return (error == EMFILE) || (error == ENFILE) || (error == ENOBUFS) || (error == ENOMEM);
}

static status_t status_of_bind(const int error)
{
    switch (error) {
    case EADDRINUSE:
    case EEXIST:
        return STATUS_EXISTS;
    case EACCES:
    case EPERM:
        return STATUS_DENIED;
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
    case EPIPE:
    case ECONNRESET:
    case ECONNREFUSED:
    case ECONNABORTED:
    case EHOSTUNREACH:
    case ENETUNREACH:
    case ENOTCONN:
    case ETIMEDOUT:
        return STATUS_CLOSED;
    default:
        return STATUS_IO;
    }
}

static void set_option(const int descriptor, const int level, const int option, const int value)
{
    (void)setsockopt(descriptor, level, option, &value, (socklen_t)sizeof value);
}

static int open_descriptor(const int domain, const int type)
{
    return socket(domain, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

// ---- UDP ----

status_t osal_udp_open(osal_socket_t* const sock, const osal_address_t local, const size_t receive_bytes)
{
    FSW_ASSERT(sock != NULL);
    *sock                = (osal_socket_t)OSAL_SOCKET_CLOSED;
    const int descriptor = open_descriptor(AF_INET, SOCK_DGRAM);
    if (descriptor < 0) {
        return STATUS_IO;
    }
    if (receive_bytes > 0U) {
        const int bytes = (receive_bytes < (size_t)INT_MAX) ? (int)receive_bytes : INT_MAX;
        set_option(descriptor, SOL_SOCKET, SO_RCVBUF, bytes);
        // SO_RCVBUFFORCE may exceed the limit of the system. Without the privilege for it, the size set by
        // SO_RCVBUF remains.
        set_option(descriptor, SOL_SOCKET, SO_RCVBUFFORCE, bytes);
    }
    const struct sockaddr_in address = native(local);
    if (bind(descriptor, generic(&address), (socklen_t)sizeof address) != 0) {
        const status_t status = status_of_bind(errno);
        (void)close(descriptor);
        return status;
    }
    sock->descriptor = descriptor;
    return STATUS_OK;
}

status_t osal_socket_adopt(osal_socket_t* const sock, const int descriptor)
{
    FSW_ASSERT(sock != NULL);
    int domain     = 0;
    socklen_t size = (socklen_t)sizeof domain;
    *sock          = (osal_socket_t)OSAL_SOCKET_CLOSED;
    if ((getsockopt(descriptor, SOL_SOCKET, SO_DOMAIN, &domain, &size) != 0) ||
        ((domain != AF_INET) && (domain != AF_UNIX) && (domain != AF_TIPC))) {
        return STATUS_INVALID;
    }
    const int flags = fcntl(descriptor, F_GETFL);
    if ((flags < 0) || (fcntl(descriptor, F_SETFL, flags | O_NONBLOCK) != 0) ||
        (fcntl(descriptor, F_SETFD, FD_CLOEXEC) != 0)) {
        return STATUS_INVALID;
    }
    sock->descriptor = descriptor;
    return STATUS_OK;
}

status_t osal_udp_send(osal_socket_t* const sock, const osal_address_t to, const uint8_t* const octets,
                       const size_t size)
{
    FSW_ASSERT((sock != NULL) && ((octets != NULL) || (size == 0U)));
    const struct sockaddr_in address = native(to);
    ssize_t sent                     = 0;
    do {
        sent = sendto(sock->descriptor, octets, size, MSG_NOSIGNAL, generic(&address),
                      (socklen_t)sizeof address);
    } while ((sent < 0) && (errno == EINTR));
    return (sent >= 0) ? STATUS_OK : status_of_send(errno);
}

void osal_socket_defer(osal_socket_t* const sock)
{
    FSW_ASSERT(sock != NULL);
    sock->is_deferred = true;
}

status_t osal_udp_receive(osal_socket_t* const sock, osal_address_t* const out_from, uint8_t* const octets,
                          const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((sock != NULL) && (out_from != NULL) && (octets != NULL) && (out_size != NULL));
    struct sockaddr_in from = {.sin_family = AF_INET};
    struct iovec buffer     = {.iov_base = octets, .iov_len = capacity};
    struct msghdr message   = {
          .msg_name = &from, .msg_namelen = sizeof from, .msg_iov = &buffer, .msg_iovlen = 1U};
    ssize_t size = 0;
    do {
        size = socket_receive(sock, &message);
        // ECONNREFUSED: a datagram sent earlier had no receiver. This error does not concern the reception.
    } while ((size < 0) && ((errno == EINTR) || (errno == ECONNREFUSED)));
    *out_size = 0U;
    if (size < 0) {
        return is_again(errno) ? STATUS_EMPTY : STATUS_IO;
    }
    if ((message.msg_flags & MSG_TRUNC) != 0) {
        return STATUS_TOO_LARGE;
    }
    *out_from = osal_address(&from);
    *out_size = (size_t)size;
    return STATUS_OK;
}

// ---- Streams ----

static status_t listen_on(osal_socket_t* const sock, const int descriptor, const void* const address,
                          const size_t size)
{
    if ((bind(descriptor, generic(address), (socklen_t)size) != 0) || (listen(descriptor, BACKLOG) != 0)) {
        const status_t status = status_of_bind(errno);
        (void)close(descriptor);
        return status;
    }
    sock->descriptor = descriptor;
    return STATUS_OK;
}

status_t osal_tcp_listen(osal_socket_t* const sock, const osal_address_t local)
{
    FSW_ASSERT(sock != NULL);
    *sock                = (osal_socket_t)OSAL_SOCKET_CLOSED;
    const int descriptor = open_descriptor(AF_INET, SOCK_STREAM);
    if (descriptor < 0) {
        return STATUS_IO;
    }
    set_option(descriptor, SOL_SOCKET, SO_REUSEADDR, 1);
    const struct sockaddr_in address = native(local);
    return listen_on(sock, descriptor, &address, sizeof address);
}

status_t osal_tcp_accept(osal_socket_t* const listener, osal_socket_t* const out_client,
                         osal_address_t* const out_peer)
{
    FSW_ASSERT((listener != NULL) && (out_client != NULL) && (out_peer != NULL));
    union {
        struct sockaddr_in internet;
        struct sockaddr_un local;
    } peer;
    int descriptor      = -1;
    struct pollfd queue = {.fd = listener->descriptor, .events = POLLIN};
    *out_client         = (osal_socket_t)OSAL_SOCKET_CLOSED;
    *out_peer           = (osal_address_t){0U, 0U};
    // poll is faster than accept4, which allocates a socket before it looks for a connection.
    if (poll(&queue, 1U, 0) == 0) {
        return STATUS_EMPTY;
    }
    (void)memset(&peer, 0, sizeof peer);
    do {
        socklen_t size = (socklen_t)sizeof peer;
        descriptor     = accept4(listener->descriptor, (struct sockaddr*)(void*)&peer, &size,
                                 SOCK_CLOEXEC | SOCK_NONBLOCK);
    } while ((descriptor < 0) && ((errno == EINTR) || (errno == ECONNABORTED)));
    if (descriptor < 0) {
        if (is_out_of_resources(errno)) {
            return STATUS_EXHAUSTED;
        }
        return is_again(errno) ? STATUS_EMPTY : STATUS_IO;
    }
    *out_client = (osal_socket_t){.descriptor = descriptor};
    if (peer.internet.sin_family == AF_INET) {
        set_option(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
        *out_peer = osal_address(&peer.internet);
    }
    return STATUS_OK;
}

status_t osal_tcp_connect_begin(osal_socket_t* const sock, const osal_address_t to)
{
    FSW_ASSERT(sock != NULL);
    *sock                = (osal_socket_t)OSAL_SOCKET_CLOSED;
    const int descriptor = open_descriptor(AF_INET, SOCK_STREAM);
    if (descriptor < 0) {
        return is_out_of_resources(errno) ? STATUS_EXHAUSTED : STATUS_IO;
    }
    set_option(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
    const struct sockaddr_in address = native(to);
    const bool is_done = (connect(descriptor, generic(&address), (socklen_t)sizeof address) == 0);
    const int error    = is_done ? 0 : errno;
    // EINTR: the kernel continues to connect, as with EINPROGRESS.
    if (is_done || (error == EINPROGRESS) || (error == EINTR)) {
        sock->descriptor = descriptor;
        return is_done ? STATUS_OK : STATUS_BUSY;
    }
    (void)close(descriptor);
    return (status_of_send(error) == STATUS_CLOSED) ? STATUS_CLOSED : STATUS_IO;
}

status_t osal_tcp_connect_result(osal_socket_t* const sock)
{
    FSW_ASSERT(sock != NULL);
    struct pollfd watched = {.fd = sock->descriptor, .events = POLLOUT};
    int ready             = 0;
    do {
        ready = poll(&watched, 1U, 0);
    } while ((ready < 0) && (errno == EINTR));
    if (ready == 0) {
        return STATUS_BUSY;
    }
    int error      = 0;
    socklen_t size = (socklen_t)sizeof error;
    if ((ready < 0) || (getsockopt(sock->descriptor, SOL_SOCKET, SO_ERROR, &error, &size) != 0)) {
        error = EIO;
    }
    if (error == 0) {
        return STATUS_OK;
    }
    osal_socket_close(sock);
    return (status_of_send(error) == STATUS_CLOSED) ? STATUS_CLOSED : STATUS_IO;
}

status_t osal_stream_send(osal_socket_t* const sock, const uint8_t* const octets, const size_t size,
                          size_t* const out_sent)
{
    FSW_ASSERT((sock != NULL) && (octets != NULL) && (size > 0U) && (out_sent != NULL));
    ssize_t sent = 0;
    do {
        sent = send(sock->descriptor, octets, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    } while ((sent < 0) && (errno == EINTR));
    *out_sent = (sent > 0) ? (size_t)sent : 0U;
    if (sent > 0) {
        return STATUS_OK;
    }
    const status_t status = (sent < 0) ? status_of_send(errno) : STATUS_FULL;
    return (status == STATUS_TOO_LARGE) ? STATUS_IO : status;
}

status_t osal_stream_receive(osal_socket_t* const sock, uint8_t* const octets, const size_t capacity,
                             size_t* const out_size)
{
    FSW_ASSERT((sock != NULL) && (octets != NULL) && (capacity > 0U) && (out_size != NULL));
    ssize_t size = 0;
    do {
        size = recv(sock->descriptor, octets, capacity, MSG_DONTWAIT);
    } while ((size < 0) && (errno == EINTR));
    *out_size = (size > 0) ? (size_t)size : 0U;
    if (size > 0) {
        return STATUS_OK;
    }
    if (size == 0) {
        return STATUS_CLOSED;
    }
    if (is_again(errno)) {
        return STATUS_EMPTY;
    }
    return (status_of_send(errno) == STATUS_CLOSED) ? STATUS_CLOSED : STATUS_IO;
}

// ---- Local streams ----

/// Make the address of a path. False if the path is empty or too long.
static bool local_address(const char* const path, struct sockaddr_un* const out_address)
{
    const size_t length = strlen(path);
    *out_address        = (struct sockaddr_un){.sun_family = AF_UNIX};
    if ((length == 0U) || (length > LOCAL_PATH_MAX)) {
        return false;
    }
    (void)memcpy(out_address->sun_path, path, length + 1U);
    return true;
}

status_t osal_local_listen(osal_socket_t* const sock, const char* const path)
{
    FSW_ASSERT((sock != NULL) && (path != NULL));
    struct sockaddr_un address;
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
    if (!local_address(path, &address)) {
        return STATUS_INVALID;
    }
    const int descriptor = open_descriptor(AF_UNIX, SOCK_STREAM);
    return (descriptor >= 0) ? listen_on(sock, descriptor, &address, sizeof address) : STATUS_IO;
}

status_t osal_local_pair(osal_socket_t* const sock, osal_socket_t* const out_peer)
{
    FSW_ASSERT((sock != NULL) && (out_peer != NULL));
    int pair[2]      = {-1, -1};
    const int result = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, pair);
    *sock            = (osal_socket_t){.descriptor = (result == 0) ? pair[0] : -1};
    *out_peer        = (osal_socket_t){.descriptor = (result == 0) ? pair[1] : -1};
    return (result == 0) ? STATUS_OK : STATUS_IO;
}

// ---- Any socket ----

/// Poll for octets without sleeping, unless polling was unsuccessful recently. Returns what poll returns: 1
/// if there are octets or an error of the socket, 0 if there is nothing yet, -1 if poll failed.
static int poll_briefly(osal_socket_t* const sock, struct pollfd* const watched)
{
    if (sock->waits_to_skip > 0U) {
        sock->waits_to_skip--;
        return 0;
    }
    const uint64_t until_ns = osal_clock_monotonic_ns() + OSAL_SOCKET_POLL_NS;
    int ready               = 0;
    do {
        ready = poll(watched, 1U, 0);
    } while ((ready == 0) && (osal_clock_monotonic_ns() < until_ns));
    // Polling without success wastes time of the processor, so more waits skip it each time: 1, 3, 7 .. 127.
    sock->backoff       = (ready != 0) ? 0U : (uint8_t)(((2U * sock->backoff) + 1U) & SKIPPED_WAITS_MAX);
    sock->waits_to_skip = sock->backoff;
    return ready;
}

status_t osal_socket_wait_readable(osal_socket_t* const sock, const uint32_t timeout_ms)
{
    FSW_ASSERT(sock != NULL);
    struct pollfd watched   = {.fd = sock->descriptor, .events = POLLIN};
    const uint64_t until_ns = osal_clock_monotonic_ns() + ((uint64_t)timeout_ms * NS_PER_MS);
    int ready               = (timeout_ms > 0U) ? poll_briefly(sock, &watched) : 0;
    while ((ready == 0) || ((ready < 0) && (errno == EINTR))) {
        const uint64_t now_ns = osal_clock_monotonic_ns();
        const uint64_t rest_ms =
            (until_ns > now_ns) ? ((until_ns - now_ns + NS_PER_MS - 1U) / NS_PER_MS) : 0U;
        ready = poll(&watched, 1U, (rest_ms < (uint64_t)INT_MAX) ? (int)rest_ms : INT_MAX);
        if (ready == 0) {
            return STATUS_TIMEOUT;
        }
    }
    return ((ready > 0) && ((watched.revents & POLLNVAL) == 0)) ? STATUS_OK : STATUS_IO;
}

status_t osal_socket_wait_writable(osal_socket_t* const sock, const uint32_t timeout_ms)
{
    FSW_ASSERT((sock != NULL) && (timeout_ms <= (uint32_t)INT_MAX));
    struct pollfd watched = {.fd = sock->descriptor, .events = POLLOUT};
    int ready             = 0;
    do {
        ready = poll(&watched, 1U, (int)timeout_ms);
    } while ((ready < 0) && (errno == EINTR));
    if (ready == 0) {
        return STATUS_TIMEOUT;
    }
    return ((ready > 0) && ((watched.revents & POLLNVAL) == 0)) ? STATUS_OK : STATUS_IO;
}

status_t osal_socket_local_address(const osal_socket_t* const sock, osal_address_t* const out_local)
{
    FSW_ASSERT((sock != NULL) && (out_local != NULL));
    struct sockaddr_in address = {.sin_family = AF_INET};
    socklen_t size             = (socklen_t)sizeof address;
    *out_local                 = (osal_address_t){0U, 0U};
    if ((getsockname(sock->descriptor, (struct sockaddr*)(void*)&address, &size) != 0) ||
        (address.sin_family != AF_INET)) {
        return STATUS_IO;
    }
    *out_local = osal_address(&address);
    return STATUS_OK;
}

int osal_socket_descriptor(const osal_socket_t* const sock)
{
    FSW_ASSERT(sock != NULL);
    return sock->descriptor;
}

bool osal_socket_is_open(const osal_socket_t* const sock)
{
    FSW_ASSERT(sock != NULL);
    return sock->descriptor >= 0;
}

void osal_socket_close(osal_socket_t* const sock)
{
    FSW_ASSERT(sock != NULL);
    if (sock->descriptor >= 0) {
        (void)close(sock->descriptor);
    }
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
}
