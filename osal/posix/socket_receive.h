// SPDX-License-Identifier: Apache-2.0
/// Reception of a datagram, for UDP and TIPC.
#ifndef OSAL_POSIX_SOCKET_RECEIVE_H
#define OSAL_POSIX_SOCKET_RECEIVE_H

#include "osal/include/osal/socket.h"

#include <sys/socket.h>

/// Like recvmsg without waiting; after osal_socket_defer the datagram stays in the socket until the next
/// call.
ssize_t socket_receive(osal_socket_t* sock, struct msghdr* message);

#endif // OSAL_POSIX_SOCKET_RECEIVE_H
