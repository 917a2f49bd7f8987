// SPDX-License-Identifier: Apache-2.0
/// Sockets: UDP datagrams and TCP streams over IPv4, and local streams. A UDP or TCP socket is bound to the
/// address that the caller names; ipv4 0 is every interface of the machine. Non-blocking, except the
/// functions whose comment says that they wait. Interrupted calls are repeated inside.
///
/// Ownership  The caller provides osal_socket_t; closed by osal_socket_close.
/// Errors     Each function lists its statuses. On a system without a network, calls that open a socket of a
///            kind that it does not have return STATUS_UNSUPPORTED, and so does osal_socket_local_address.
#ifndef OSAL_SOCKET_H
#define OSAL_SOCKET_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct { // Private; descriptor < 0 when closed.
    int descriptor;
    uint8_t waits_to_skip; // Number of next waits that sleep without polling first.
    uint8_t backoff; // Value of waits_to_skip after the last polling: 0 after a success, then 1, 3, 7 .. 127.
    bool is_deferred; // osal_socket_defer was called.
    bool is_kept;     // The datagram that was received last is still in the socket.
} osal_socket_t;

typedef struct {
    uint32_t ipv4; ///< Host byte order; loopback 0x7F000001.
    uint16_t port; ///< Host byte order; 0 asks for any free port.
} osal_address_t;

#define OSAL_IPV4_LOOPBACK 0x7F000001U
/// Loopback addresses of the devices of a run and of its flight software. Each run has addresses of its own
/// in 127.0.0.0/8, so that the ports of a descriptor are free in each run. `run` is the number of the run,
/// below 2^22.
#define OSAL_IPV4_OF_DEVICES(run) (0x7F400000U + ((run)&0x3FFFFFU))
#define OSAL_IPV4_OF_FLIGHT(run) (0x7F800000U + ((run)&0x3FFFFFU))
#define OSAL_SOCKET_POLL_NS 20000U ///< Time for which osal_socket_wait_readable polls [ns].

/// Closed socket, for initialisation.
#define OSAL_SOCKET_CLOSED                                                                                   \
    {                                                                                                        \
        -1, 0U, 0U, false, false                                                                             \
    }

/// Open a UDP socket and bind it; `receive_bytes` requests a receive buffer of that size from the kernel (0:
/// default). Returns STATUS_OK, STATUS_EXISTS (port in use), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_udp_open(osal_socket_t* socket, osal_address_t local, size_t receive_bytes);
/// Use a UDP, TCP, TIPC or local socket that the parent process has passed as a descriptor number. STATUS_OK,
/// STATUS_INVALID (no such descriptor, or no socket).
MUST_USE status_t osal_socket_adopt(osal_socket_t* socket, int descriptor);
/// Send a datagram. STATUS_OK, STATUS_FULL (kernel buffer), STATUS_CLOSED (no route; a port without a
/// listener is not detected), STATUS_TOO_LARGE, STATUS_IO.
MUST_USE status_t osal_udp_send(osal_socket_t* socket, osal_address_t to, const uint8_t* octets, size_t size);
/// Receive a datagram. STATUS_OK, STATUS_EMPTY, STATUS_TOO_LARGE (datagram longer than capacity, dropped),
/// STATUS_IO.
MUST_USE status_t osal_udp_receive(osal_socket_t* socket, osal_address_t* out_from, uint8_t* octets,
                                   size_t capacity, size_t* out_size);

/// From now on a datagram stays in the UDP or TIPC socket until the next call that receives from the socket.
/// If the process dies in between, its successor receives the datagram again.
void osal_socket_defer(osal_socket_t* socket);

/// Open a TCP socket that listens. Returns STATUS_OK, STATUS_EXISTS (port in use), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_tcp_listen(osal_socket_t* socket, osal_address_t local);
/// Accept a connection. STATUS_OK, STATUS_EMPTY, STATUS_EXHAUSTED (no descriptor or memory), STATUS_IO.
MUST_USE status_t osal_tcp_accept(osal_socket_t* listener, osal_socket_t* out_client,
                                  osal_address_t* out_peer);
/// Start to connect, without waiting. STATUS_OK (connected), STATUS_BUSY (call osal_tcp_connect_result),
/// STATUS_CLOSED (refused, or no route), STATUS_EXHAUSTED (no descriptor or memory), STATUS_IO. The socket is
/// open only with the first two.
MUST_USE status_t osal_tcp_connect_begin(osal_socket_t* socket, osal_address_t to);
/// Result of osal_tcp_connect_begin. STATUS_OK, STATUS_BUSY (no result yet), STATUS_CLOSED (refused, no
/// route, or no answer), STATUS_IO; with the last two the socket is closed.
MUST_USE status_t osal_tcp_connect_result(osal_socket_t* socket);
/// Send as much of `size` octets (>= 1) as the kernel takes. STATUS_OK with *out_sent >= 1, STATUS_FULL,
/// STATUS_CLOSED, STATUS_IO.
MUST_USE status_t osal_stream_send(osal_socket_t* socket, const uint8_t* octets, size_t size,
                                   size_t* out_sent);
/// Receive at most `capacity` octets (>= 1). STATUS_OK with *out_size >= 1, STATUS_EMPTY, STATUS_CLOSED (the
/// peer has ended the stream), STATUS_IO.
MUST_USE status_t osal_stream_receive(osal_socket_t* socket, uint8_t* octets, size_t capacity,
                                      size_t* out_size);

/// Open a local (UNIX) stream socket that listens: for the co-simulation port of the scheduler and for
/// control channels. Path 1 to 100 characters. Accept with osal_tcp_accept (peer address 0:0). The path stays
/// until removed as a file. STATUS_OK, STATUS_EXISTS, STATUS_INVALID (path), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_local_listen(osal_socket_t* socket, const char* path);
/// Make the two ends of a local stream, one of them for a child process. STATUS_OK, STATUS_IO.
MUST_USE status_t osal_local_pair(osal_socket_t* socket, osal_socket_t* out_peer);

/// Wait (wall-clock) until the socket is readable, at most timeout_ms. Before the call sleeps it polls for
/// OSAL_SOCKET_POLL_NS, since waking a sleeping processor takes longer. After polling without success the
/// next wait sleeps at once; with each further failure more waits do so: 1, 3, 7, up to 127. STATUS_OK,
/// STATUS_TIMEOUT, STATUS_IO.
MUST_USE status_t osal_socket_wait_readable(osal_socket_t* socket, uint32_t timeout_ms);
/// Wait (wall-clock) until the socket is writable, that is, until osal_tcp_connect_begin has a result, at
/// most timeout_ms (<= INT32_MAX). STATUS_OK, STATUS_TIMEOUT, STATUS_IO.
MUST_USE status_t osal_socket_wait_writable(osal_socket_t* socket, uint32_t timeout_ms);
/// Local address of a bound UDP or TCP socket. STATUS_OK, STATUS_IO (also: another kind of socket).
MUST_USE status_t osal_socket_local_address(const osal_socket_t* socket, osal_address_t* out_local);
/// Returns the descriptor number, for osal_process_start_t.descriptors and osal_socket_adopt in the child;
/// -1: closed.
int osal_socket_descriptor(const osal_socket_t* socket);
bool osal_socket_is_open(const osal_socket_t* socket);
void osal_socket_close(osal_socket_t* socket);

#endif // OSAL_SOCKET_H
