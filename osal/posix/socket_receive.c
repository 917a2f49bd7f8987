// SPDX-License-Identifier: Apache-2.0
// In a file of its own, so that a test that replaces socket.c can still link tipc.c, which also calls this
// function.
#define _GNU_SOURCE
#include "osal/posix/socket_receive.h"

#include <errno.h>
#include <sys/socket.h>
#include <sys/types.h>

ssize_t socket_receive(osal_socket_t* const sock, struct msghdr* const message)
{
    uint8_t octet = 0U;
    // Remove the kept datagram first. An error that belongs to an earlier send does not remove it: repeat.
    while (sock->is_kept) {
        sock->is_kept = (recv(sock->descriptor, &octet, sizeof octet, MSG_DONTWAIT) < 0) &&
                        ((errno == EINTR) || (errno == ECONNREFUSED));
    }
    const ssize_t size =
        recvmsg(sock->descriptor, message, MSG_DONTWAIT | (sock->is_deferred ? MSG_PEEK : 0));
    sock->is_kept = sock->is_deferred && (size >= 0);
    return size;
}
