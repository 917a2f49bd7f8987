// SPDX-License-Identifier: Apache-2.0
/// Sockets in memory for the fuzz targets: osal/socket.h without an operating system. A target connects with
/// osal_tcp_connect_begin or memory_sockets_connect_local, as a peer would; the connection exists at once.
#ifndef TEST_FUZZ_MEMORY_SOCKET_H
#define TEST_FUZZ_MEMORY_SOCKET_H

#include "osal/include/osal/socket.h"

/// Close all sockets, and remove the limit of sends.
void memory_sockets_reset(void);
/// From now on a send accepts at most this many octets; 0: no octets.
void memory_sockets_limit(size_t octets);
/// A datagram arrives at the socket that receives next; it replaces one that was not received. At most 16
/// KiB.
void memory_sockets_datagram(osal_address_t from, const uint8_t* octets, size_t size);
/// Connect to the socket of osal_local_listen. STATUS_OK, STATUS_CLOSED (no listener, or no end is free).
status_t memory_sockets_connect_local(osal_socket_t* socket);
/// Returns the number of open ends, including listeners.
unsigned memory_sockets_open(void);

#endif // TEST_FUZZ_MEMORY_SOCKET_H
