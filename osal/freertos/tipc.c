// SPDX-License-Identifier: Apache-2.0
// This system has no TIPC, a protocol of Linux.
#include "osal/include/osal/tipc.h"

#include "base/assertion.h"

#include <stddef.h>

status_t osal_tipc_open(osal_socket_t* const socket, const osal_tipc_kind_t kind,
                        const osal_tipc_name_t* const name, const osal_tipc_scope_t scope)
{
    FSW_ASSERT(socket != NULL);
    (void)name; // Null: a socket that can only send.
    (void)kind;
    (void)scope;
    *socket = (osal_socket_t)OSAL_SOCKET_CLOSED;
    return STATUS_UNSUPPORTED;
}

status_t osal_tipc_send(osal_socket_t* const socket, const osal_tipc_name_t to, const uint8_t* const octets,
                        const size_t size)
{
    FSW_ASSERT((socket != NULL) && (octets != NULL));
    (void)to;
    (void)size;
    return STATUS_UNSUPPORTED;
}

status_t osal_tipc_receive(osal_socket_t* const socket, uint64_t* const out_from, uint8_t* const octets,
                           const size_t capacity, size_t* const out_size)
{
    FSW_ASSERT((socket != NULL) && (out_from != NULL) && (octets != NULL) && (out_size != NULL));
    (void)capacity;
    *out_size = 0U;
    return STATUS_UNSUPPORTED;
}

status_t osal_tipc_identity(const osal_socket_t* const socket, uint64_t* const out_identity)
{
    FSW_ASSERT((socket != NULL) && (out_identity != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_tipc_watch_open(osal_socket_t* const socket, const uint32_t type)
{
    FSW_ASSERT(socket != NULL);
    (void)type;
    *socket = (osal_socket_t)OSAL_SOCKET_CLOSED;
    return STATUS_UNSUPPORTED;
}

status_t osal_tipc_watch_next(osal_socket_t* const socket, osal_tipc_event_t* const out_event)
{
    FSW_ASSERT((socket != NULL) && (out_event != NULL));
    return STATUS_UNSUPPORTED;
}
