// SPDX-License-Identifier: Apache-2.0
/// Datagrams that have arrived and are not received yet, of all sockets, in the order of arrival.
#ifndef OSAL_FREERTOS_DATAGRAMS_H
#define OSAL_FREERTOS_DATAGRAMS_H

#include "base/status.h"
#include "osal/include/osal/socket.h"

/// False if there is no room.
bool datagrams_add(uint32_t number, osal_address_t from, const uint8_t* octets, size_t size);
bool datagrams_has(uint32_t number);
/// The oldest of a socket. STATUS_OK, STATUS_EMPTY, STATUS_TOO_LARGE (dropped).
status_t datagrams_take(uint32_t number, osal_address_t* out_from, uint8_t* octets, size_t capacity,
                        size_t* out_size);
void datagrams_drop(uint32_t number);

#endif // OSAL_FREERTOS_DATAGRAMS_H
