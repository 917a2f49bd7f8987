// SPDX-License-Identifier: Apache-2.0
// A file of its own: a test that replaces the sockets of socket.c still links the ports that receive by this.
#define _GNU_SOURCE
#include "osal/posix/socket_receive.h"

#include <errno.h>
#include <sys/socket.h>
#include <sys/types.h>

ssize_t socket_receive(osal_socket_t* const sock, struct msghdr* const message)
{
    uint8_t octet = 0U;
    while (sock->is_held) { // The error refers to a datagram sent earlier; this one is unchanged.
        sock->is_held = (recv(sock->descriptor, &octet, sizeof octet, MSG_DONTWAIT) < 0) &&
                        ((errno == EINTR) || (errno == ECONNREFUSED));
    }
    const ssize_t size =
        recvmsg(sock->descriptor, message, MSG_DONTWAIT | (sock->is_deferred ? MSG_PEEK : 0));
    sock->is_held = sock->is_deferred && (size >= 0);
    return size;
}
