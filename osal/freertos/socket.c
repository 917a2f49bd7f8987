// SPDX-License-Identifier: Apache-2.0
// Sockets on a processor without a network: datagrams and one stream, which the serving process transfers
// (osal/target_wire.h). TCP connections and local streams do not exist on this system.
#include "osal/include/osal/socket.h"

#include "base/assertion.h"
#include "osal/freertos/datagrams.h"
#include "osal/freertos/wire.h"
#include "osal/include/osal/target_wire.h"

#include <limits.h>

#define STREAM 0       ///< Descriptor of the stream.
#define SENDER INT_MAX ///< Descriptor of a socket that can only send.

status_t osal_udp_open(osal_socket_t* const sock, const osal_address_t local, const size_t receive_bytes)
{
    FSW_ASSERT(sock != NULL);
    (void)receive_bytes;
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
    if (!wire_is_open() || (local.port != 0U)) {
        return STATUS_UNSUPPORTED;
    }
    sock->descriptor = SENDER;
    return STATUS_OK;
}

status_t osal_socket_adopt(osal_socket_t* const sock, const int descriptor)
{
    FSW_ASSERT(sock != NULL);
    *sock           = (osal_socket_t)OSAL_SOCKET_CLOSED;
    status_t status = STATUS_INVALID;
    if (descriptor == STREAM) {
        status = wire_open();
    } else if (wire_is_open() && (descriptor > 0)) {
        status = wire_adopt((uint32_t)descriptor);
    } else {
        // The descriptor of a socket is never negative.
    }
    if (status == STATUS_OK) {
        sock->descriptor = descriptor;
    }
    return (status == STATUS_OK) ? STATUS_OK : STATUS_INVALID;
}

static uint32_t number_of(const osal_socket_t* const sock)
{
    return (sock->descriptor == SENDER) ? TARGET_WIRE_SENDER : (uint32_t)sock->descriptor;
}

status_t osal_udp_send(osal_socket_t* const sock, const osal_address_t to, const uint8_t* const octets,
                       const size_t size)
{
    FSW_ASSERT((sock != NULL) && ((octets != NULL) || (size == 0U)));
    return (sock->descriptor > STREAM) ? wire_datagram_send(number_of(sock), to, octets, size) : STATUS_IO;
}

status_t osal_udp_receive(osal_socket_t* const sock, osal_address_t* const out_from, uint8_t* const octets,
                          const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((sock != NULL) && (out_from != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    return (sock->descriptor > STREAM)
               ? wire_datagram_receive(number_of(sock), out_from, octets, capacity, out_size)
               : STATUS_IO;
}

/// No effect: datagrams that have arrived in this program are lost when it ends. The mission protocols repeat
/// lost messages.
void osal_socket_defer(osal_socket_t* const sock)
{
    FSW_ASSERT(sock != NULL);
}

status_t osal_tcp_listen(osal_socket_t* const sock, const osal_address_t local)
{
    FSW_ASSERT(sock != NULL);
    (void)local;
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
    return STATUS_UNSUPPORTED;
}

status_t osal_tcp_accept(osal_socket_t* const listener, osal_socket_t* const out_client,
                         osal_address_t* const out_peer)
{
    FSW_ASSERT((listener != NULL) && (out_client != NULL) && (out_peer != NULL));
    *out_client = (osal_socket_t)OSAL_SOCKET_CLOSED;
    *out_peer   = (osal_address_t){0U, 0U};
    return STATUS_UNSUPPORTED;
}

status_t osal_tcp_connect_begin(osal_socket_t* const sock, const osal_address_t to)
{
    FSW_ASSERT(sock != NULL);
    (void)to;
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
    return STATUS_UNSUPPORTED;
}

status_t osal_tcp_connect_result(osal_socket_t* const sock)
{
    FSW_ASSERT(sock != NULL);
    return STATUS_UNSUPPORTED;
}

status_t osal_stream_send(osal_socket_t* const sock, const uint8_t* const octets, const size_t size,
                          size_t* const out_sent)
{
    FSW_ASSERT((sock != NULL) && (octets != NULL) && (size > 0U) && (out_sent != NULL));
    const status_t status = (sock->descriptor == STREAM) ? wire_stream_send(octets, size) : STATUS_IO;
    *out_sent             = (status == STATUS_OK) ? size : 0U;
    return status;
}

/// The port cannot ask whether octets of the stream have arrived: this call waits for octets.
status_t osal_stream_receive(osal_socket_t* const sock, uint8_t* const octets, const size_t capacity,
                             size_t* const out_size)
{
    FSW_ASSERT((sock != NULL) && (octets != NULL) && (capacity > 0U) && (out_size != NULL));
    *out_size = 0U;
    return (sock->descriptor == STREAM) ? wire_stream_receive(octets, capacity, out_size) : STATUS_IO;
}

status_t osal_local_listen(osal_socket_t* const sock, const char* const path)
{
    FSW_ASSERT((sock != NULL) && (path != NULL));
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
    return STATUS_UNSUPPORTED;
}

status_t osal_local_pair(osal_socket_t* const sock, osal_socket_t* const out_peer)
{
    FSW_ASSERT((sock != NULL) && (out_peer != NULL));
    *sock     = (osal_socket_t)OSAL_SOCKET_CLOSED;
    *out_peer = (osal_socket_t)OSAL_SOCKET_CLOSED;
    return STATUS_UNSUPPORTED;
}

status_t osal_socket_wait_readable(osal_socket_t* const sock, const uint32_t timeout_ms)
{
    FSW_ASSERT(sock != NULL);
    if (sock->descriptor == STREAM) {
        return STATUS_OK; // osal_stream_receive waits instead.
    }
    if (sock->descriptor < 0) {
        return STATUS_IO;
    }
    const status_t status = wire_datagram_wait(number_of(sock), timeout_ms);
    return (status == STATUS_CLOSED) ? STATUS_IO : status;
}

status_t osal_socket_wait_writable(osal_socket_t* const sock, const uint32_t timeout_ms)
{
    FSW_ASSERT(sock != NULL);
    (void)timeout_ms;
    return (sock->descriptor >= 0) ? STATUS_OK : STATUS_IO;
}

status_t osal_socket_local_address(const osal_socket_t* const sock, osal_address_t* const out_local)
{
    FSW_ASSERT((sock != NULL) && (out_local != NULL));
    *out_local = (osal_address_t){0U, 0U};
    return STATUS_UNSUPPORTED; // Only the serving process knows the address.
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
    if (sock->descriptor == STREAM) {
        wire_close();
    } else if ((sock->descriptor > STREAM) && (sock->descriptor != SENDER)) {
        datagrams_drop(number_of(sock));
    } else {
        // A socket that can only send has no datagrams.
    }
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
}
