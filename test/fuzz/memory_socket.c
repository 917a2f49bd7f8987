// SPDX-License-Identifier: Apache-2.0
// osal/socket.h in memory; it replaces the port in the fuzz targets. A sent datagram is discarded; a datagram
// arrives only if the target provides one. No call waits.
#include "test/fuzz/memory_socket.h"

#include "test/fuzz/fuzz.h"

#include <string.h>

#define ENDS 32
#define STREAM_OCTETS 16384U
#define BACKLOG 8U
#define LOCAL_PORT 1U // Port of every local socket.
#define FIRST_PORT 40000U

typedef struct {
    bool is_used;
    bool is_listener;
    int peer; // -1: the peer is closed.
    uint16_t port;
    int waiting[BACKLOG]; // In a listener: ends that wait to be accepted.
    unsigned waiting_count;
    size_t first;
    size_t held;
    uint8_t octets[STREAM_OCTETS]; // Octets received.
} end_t;

static end_t ends[ENDS];
static size_t send_limit  = SIZE_MAX;
static uint16_t next_port = FIRST_PORT; // Each port is used once, so that it identifies a connection.

static struct {
    bool is_there;
    osal_address_t from;
    size_t size;
    uint8_t octets[STREAM_OCTETS];
} datagram;

void memory_sockets_reset(void)
{
    datagram.is_there = false;
    for (int i = 0; i < ENDS; i++) {
        ends[i].is_used = false;
    }
    send_limit = SIZE_MAX;
    next_port  = FIRST_PORT;
}

void memory_sockets_limit(const size_t octets)
{
    send_limit = octets;
}

void memory_sockets_datagram(const osal_address_t from, const uint8_t* const octets, const size_t size)
{
    datagram.is_there = true;
    datagram.from     = from;
    datagram.size     = (size < sizeof datagram.octets) ? size : sizeof datagram.octets;
    (void)memcpy(datagram.octets, octets, datagram.size);
}

unsigned memory_sockets_open(void)
{
    unsigned count = 0U;
    for (int i = 0; i < ENDS; i++) {
        count += ends[i].is_used ? 1U : 0U;
    }
    return count;
}

static end_t* end_of(const osal_socket_t* const socket)
{
    const int index = socket->descriptor;
    return ((index >= 0) && (index < ENDS) && ends[index].is_used) ? &ends[index] : NULL;
}

static status_t make(osal_socket_t* const socket, const bool is_listener, const uint16_t port)
{
    for (int i = 0; i < ENDS; i++) {
        if (!ends[i].is_used) {
            ends[i].is_used       = true;
            ends[i].is_listener   = is_listener;
            ends[i].peer          = -1;
            ends[i].port          = (port != 0U) ? port : next_port++;
            ends[i].waiting_count = 0U;
            ends[i].first         = 0U;
            ends[i].held          = 0U;
            socket->descriptor    = i;
            return STATUS_OK;
        }
    }
    return STATUS_IO;
}

static status_t join(osal_socket_t* const socket, osal_socket_t* const other)
{
    if ((make(socket, false, 0U) != STATUS_OK) || (make(other, false, 0U) != STATUS_OK)) {
        return STATUS_IO;
    }
    ends[socket->descriptor].peer = other->descriptor;
    ends[other->descriptor].peer  = socket->descriptor;
    return STATUS_OK;
}

static status_t connect_to(osal_socket_t* const socket, const uint16_t port)
{
    osal_socket_t other = OSAL_SOCKET_CLOSED;
    for (int i = 0; i < ENDS; i++) {
        if (ends[i].is_used && ends[i].is_listener && (ends[i].port == port) &&
            (ends[i].waiting_count < BACKLOG) && (join(socket, &other) == STATUS_OK)) {
            ends[i].waiting[ends[i].waiting_count] = other.descriptor;
            ends[i].waiting_count++;
            return STATUS_OK;
        }
    }
    return STATUS_CLOSED;
}

status_t memory_sockets_connect_local(osal_socket_t* const socket)
{
    return connect_to(socket, LOCAL_PORT);
}

// ---- The contract ----

status_t osal_udp_open(osal_socket_t* const socket, const osal_address_t local, const size_t receive_bytes)
{
    (void)receive_bytes;
    return make(socket, false, local.port);
}

status_t osal_socket_adopt(osal_socket_t* const socket, const int descriptor)
{
    const osal_socket_t wanted = {.descriptor = descriptor};
    if (end_of(&wanted) == NULL) {
        return STATUS_INVALID;
    }
    *socket = wanted;
    return STATUS_OK;
}

status_t osal_udp_send(osal_socket_t* const socket, const osal_address_t to, const uint8_t* const octets,
                       const size_t size)
{
    (void)to;
    (void)octets;
    (void)size;
    return (end_of(socket) != NULL) ? STATUS_OK : STATUS_IO;
}

status_t osal_udp_receive(osal_socket_t* const socket, osal_address_t* const out_from, uint8_t* const octets,
                          const size_t capacity, size_t* const out_size)
{
    *out_from = (osal_address_t){0U, 0U};
    *out_size = 0U;
    if (end_of(socket) == NULL) {
        return STATUS_IO;
    }
    if (!datagram.is_there) {
        return STATUS_EMPTY;
    }
    datagram.is_there = false;
    if (datagram.size > capacity) {
        return STATUS_TOO_LARGE;
    }
    (void)memcpy(octets, datagram.octets, datagram.size);
    *out_from = datagram.from;
    *out_size = datagram.size;
    return STATUS_OK;
}

void osal_socket_defer(osal_socket_t* const socket)
{
    (void)socket; // In this target no process dies, so there is no successor.
}

status_t osal_tcp_listen(osal_socket_t* const socket, const osal_address_t local)
{
    return make(socket, true, local.port);
}

status_t osal_tcp_accept(osal_socket_t* const listener, osal_socket_t* const out_client,
                         osal_address_t* const out_peer)
{
    end_t* const end = end_of(listener);
    if ((end == NULL) || (end->waiting_count == 0U)) {
        return (end == NULL) ? STATUS_IO : STATUS_EMPTY;
    }
    out_client->descriptor = end->waiting[0];
    end->waiting_count--;
    (void)memmove(&end->waiting[0], &end->waiting[1], end->waiting_count * sizeof end->waiting[0]);
    const int peer = ends[out_client->descriptor].peer;
    *out_peer      = (osal_address_t){OSAL_IPV4_LOOPBACK, (peer >= 0) ? ends[peer].port : 0U};
    return STATUS_OK;
}

status_t osal_tcp_connect_begin(osal_socket_t* const socket, const osal_address_t to)
{
    return connect_to(socket, to.port);
}

status_t osal_tcp_connect_result(osal_socket_t* const socket)
{
    return (end_of(socket) != NULL) ? STATUS_OK : STATUS_CLOSED;
}

status_t osal_stream_send(osal_socket_t* const socket, const uint8_t* const octets, const size_t size,
                          size_t* const out_sent)
{
    end_t* const end = end_of(socket);
    *out_sent        = 0U;
    if ((end == NULL) || (end->peer < 0)) {
        return STATUS_CLOSED;
    }
    end_t* const to   = &ends[end->peer];
    const size_t room = STREAM_OCTETS - to->held;
    size_t count      = (size < room) ? size : room;
    count             = (count < send_limit) ? count : send_limit;
    for (size_t i = 0U; i < count; i++) {
        to->octets[(to->first + to->held + i) % STREAM_OCTETS] = octets[i];
    }
    to->held += count;
    *out_sent = count;
    return (count > 0U) ? STATUS_OK : STATUS_FULL;
}

status_t osal_stream_receive(osal_socket_t* const socket, uint8_t* const octets, const size_t capacity,
                             size_t* const out_size)
{
    end_t* const end = end_of(socket);
    *out_size        = 0U;
    if (end == NULL) {
        return STATUS_IO;
    }
    const size_t count = (capacity < end->held) ? capacity : end->held;
    for (size_t i = 0U; i < count; i++) {
        octets[i] = end->octets[(end->first + i) % STREAM_OCTETS];
    }
    end->first = (end->first + count) % STREAM_OCTETS;
    end->held -= count;
    *out_size = count;
    if (count > 0U) {
        return STATUS_OK;
    }
    return (end->peer < 0) ? STATUS_CLOSED : STATUS_EMPTY;
}

status_t osal_local_listen(osal_socket_t* const socket, const char* const path)
{
    (void)path;
    return make(socket, true, LOCAL_PORT);
}

status_t osal_local_pair(osal_socket_t* const socket, osal_socket_t* const out_peer)
{
    return join(socket, out_peer);
}

status_t osal_socket_wait_readable(osal_socket_t* const socket, const uint32_t timeout_ms)
{
    (void)timeout_ms;
    const end_t* const end = end_of(socket);
    if (end == NULL) {
        return STATUS_IO;
    }
    return ((end->held > 0U) || (end->waiting_count > 0U)) ? STATUS_OK : STATUS_TIMEOUT;
}

status_t osal_socket_wait_writable(osal_socket_t* const socket, const uint32_t timeout_ms)
{
    (void)socket;
    (void)timeout_ms;
    return STATUS_OK;
}

status_t osal_socket_local_address(const osal_socket_t* const socket, osal_address_t* const out_local)
{
    const end_t* const end = end_of(socket);
    *out_local             = (osal_address_t){OSAL_IPV4_LOOPBACK, (end != NULL) ? end->port : 0U};
    return (end != NULL) ? STATUS_OK : STATUS_IO;
}

int osal_socket_descriptor(const osal_socket_t* const socket)
{
    return socket->descriptor;
}

bool osal_socket_is_open(const osal_socket_t* const socket)
{
    return socket->descriptor >= 0;
}

void osal_socket_close(osal_socket_t* const socket)
{
    end_t* const end = end_of(socket);
    if (end != NULL) {
        end->is_used = false;
        if (end->peer >= 0) {
            ends[end->peer].peer = -1;
        }
    }
    socket->descriptor = -1;
}
