// SPDX-License-Identifier: Apache-2.0
/// Datagrams of all sockets that have arrived but have not been received yet, in the order of arrival.
/// `number` identifies the socket.
#ifndef OSAL_FREERTOS_DATAGRAMS_H
#define OSAL_FREERTOS_DATAGRAMS_H

#include "base/status.h"
#include "osal/include/osal/socket.h"

/// Add a datagram that has arrived. False: there is no room, and the datagram is not stored.
bool datagrams_add(uint32_t number, osal_address_t from, const uint8_t* octets, size_t size);
/// True if a datagram of the socket is stored.
bool datagrams_has(uint32_t number);
/// Take the oldest datagram of the socket. STATUS_OK, STATUS_EMPTY, STATUS_TOO_LARGE (longer than capacity:
/// dropped).
status_t datagrams_take(uint32_t number, osal_address_t* out_from, uint8_t* octets, size_t capacity,
                        size_t* out_size);
/// Drop all datagrams of the socket.
void datagrams_drop(uint32_t number);

#endif // OSAL_FREERTOS_DATAGRAMS_H
