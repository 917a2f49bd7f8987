// SPDX-License-Identifier: Apache-2.0
/// Server of the socketcand protocol on loopback: a tool (python-can, Kayak, SavvyCAN) becomes an additional
/// node of a simulated bus. There is one TCP port; `< open NAME >` selects the bus; raw mode.
///
/// Time stamps are simulated time. Messages that a slow client does not read are dropped and counted, so that
/// it never delays the simulation. FD frames are sent without a flag, because the protocol has no flag for
/// them.
///
/// One message extends the protocol: a client that sends `< step N >` (1 to 1000) is in lock-step from then
/// on. It receives `< step SEC.USEC >` after the frames of every N-th step, and simulated time waits until
/// the client sends `< step N >` again. The frames that it has sent before are on the bus in the next step,
/// however slow the client is.
///
/// Ownership  socketcand_open allocates; the buses outlive the server.
/// Context    The task that runs the buses, between two calls of bus_run_until.
#ifndef SIM_SOCKETCAND_SOCKETCAND_H
#define SIM_SOCKETCAND_SOCKETCAND_H

#include "base/status.h"
#include "sim/bus/bus.h"

#include <stddef.h>
#include <stdint.h>

#define SOCKETCAND_CLIENTS_MAX 4U
#define SOCKETCAND_BUSES_MAX 8U

typedef struct {
    const char* name; ///< NAME of `< open NAME >`; must outlive the server.
    bus_t* bus;
} socketcand_bus_t;

typedef struct socketcand socketcand_t;

/// Listen on loopback; port 0 takes any free one. Returns STATUS_OK; else *out_server is null: STATUS_EXISTS
/// (port in use), STATUS_EXHAUSTED (memory), STATUS_DENIED, STATUS_IO.
MUST_USE status_t socketcand_open(uint16_t port, const socketcand_bus_t* buses, size_t bus_count,
                                  socketcand_t** out_server);
/// Close the server and remove the clients' nodes from their buses. Null is allowed.
void socketcand_close(socketcand_t* server);
uint16_t socketcand_port(const socketcand_t* server);

/// Accept new clients, and submit the frames that clients have sent at the present time of the bus.
/// Returns the number of frames submitted.
unsigned socketcand_receive(socketcand_t* server);
/// Send the frames that the clients' nodes have received.
void socketcand_send(socketcand_t* server);
/// End a step at now_ns: report it to the clients in lock-step, and wait (wall-clock, at most timeout_ms for
/// all of them together) until each has finished it. The clients that have not finished it are disconnected.
/// Returns the number of these clients.
unsigned socketcand_end_step(socketcand_t* server, uint64_t now_ns, uint32_t timeout_ms);
/// Wait (wall-clock) until a client has sent octets or connects, at most timeout_ms.
void socketcand_wait(socketcand_t* server, uint32_t timeout_ms);

/// Returns the number of messages that were dropped because a client did not read them.
uint64_t socketcand_dropped(const socketcand_t* server);

/// Write the message for a received frame, with terminator, into text[SOCKETCAND_MESSAGE_MAX]. Returns its
/// length.
#define SOCKETCAND_MESSAGE_MAX 192U
size_t socketcand_message(const osal_can_frame_t* frame, char* text);
/// Read a `send` message without its brackets ("send 123 2 a b"). Returns STATUS_OK or STATUS_INVALID.
MUST_USE status_t socketcand_parse_send(const char* text, osal_can_frame_t* out_frame);

#endif // SIM_SOCKETCAND_SOCKETCAND_H
