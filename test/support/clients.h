// SPDX-License-Identifier: Apache-2.0
/// Clients of listening sockets for tests: they are connected when the function returns. Flight code never
/// waits for a connection.
#ifndef TEST_SUPPORT_CLIENTS_H
#define TEST_SUPPORT_CLIENTS_H

#include "osal/include/osal/socket.h"

#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

/// Returns the statuses of osal_tcp_connect_begin, except STATUS_BUSY.
static inline status_t connect_tcp(osal_socket_t* const sock, const osal_address_t to)
{
    status_t status = osal_tcp_connect_begin(sock, to);
    while (status == STATUS_BUSY) {
        status = osal_tcp_connect_result(sock);
    }
    return status;
}

/// Connect to a socket of osal_local_listen. Returns STATUS_OK or STATUS_CLOSED (no listener).
static inline status_t connect_local(osal_socket_t* const sock, const char* const path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int descriptor       = socket(AF_UNIX, SOCK_STREAM, 0);
    (void)strncpy(address.sun_path, path, sizeof address.sun_path - 1U);
    *sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
    if ((connect(descriptor, (const struct sockaddr*)(const void*)&address, (socklen_t)sizeof address) !=
         0) ||
        (osal_socket_adopt(sock, descriptor) != STATUS_OK)) {
        (void)close(descriptor);
    }
    return osal_socket_is_open(sock) ? STATUS_OK : STATUS_CLOSED;
}

#endif // TEST_SUPPORT_CLIENTS_H
