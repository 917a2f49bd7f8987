// SPDX-License-Identifier: Apache-2.0
/// The program's side of osal/target_wire.h, on two pipes that semihosting opens. One task uses it. It lies
/// below the sockets of this port (socket.c).
#ifndef OSAL_FREERTOS_WIRE_H
#define OSAL_FREERTOS_WIRE_H

#include "base/status.h"
#include "osal/include/osal/socket.h"

/// Set the descriptor numbers "IN:OUT" of the inherited pipes; called before main(). False: `numbers` has
/// another form.
bool wire_set(const char* numbers);
/// Open the pipes. STATUS_OK, STATUS_INVALID (the command line names none).
status_t wire_open(void);
bool wire_is_open(void);
/// Datagrams that were lost because there was no room for them.
uint32_t wire_lost(void);
void wire_close(void);

/// Send octets of the stream. STATUS_OK, STATUS_CLOSED.
status_t wire_stream_send(const uint8_t* octets, size_t size);
/// Wait for octets of the stream. STATUS_OK with *out_size >= 1, STATUS_CLOSED.
status_t wire_stream_receive(uint8_t* octets, size_t capacity, size_t* out_size);

/// Have the serving process pass on the datagrams of the inherited socket `number`. STATUS_OK, STATUS_CLOSED.
status_t wire_adopt(uint32_t number);
/// Send a datagram from the inherited socket `number`. STATUS_OK, STATUS_TOO_LARGE, STATUS_CLOSED.
status_t wire_datagram_send(uint32_t number, osal_address_t to, const uint8_t* octets, size_t size);
/// Take the oldest datagram that has arrived at a socket. STATUS_OK, STATUS_EMPTY, STATUS_TOO_LARGE
/// (dropped).
status_t wire_datagram_receive(uint32_t number, osal_address_t* out_from, uint8_t* octets, size_t capacity,
                               size_t* out_size);
/// Wait until a datagram of the socket has arrived. STATUS_OK, STATUS_TIMEOUT, STATUS_CLOSED.
status_t wire_datagram_wait(uint32_t number, uint32_t timeout_ms);

/// Have the serving process force a file, or the names in its directory, to its disk. STATUS_OK, STATUS_IO
/// (it is not on the disk, or the path is too long), STATUS_CLOSED.
status_t wire_sync(const char* path, bool is_of_names);

#endif // OSAL_FREERTOS_WIRE_H
