// SPDX-License-Identifier: Apache-2.0
/// The serving side of osal/target_wire.h: two pipes to a program on a processor without network. It carries
/// the program's stream (remote_endian_carrier_t) and passes datagrams on between the program and the sockets
/// of its component.
///
/// Ownership  The caller provides target_link_t (static).
/// Context    One task. Waits for the program only.
#ifndef LAUNCHER_TARGET_LINK_H
#define LAUNCHER_TARGET_LINK_H

#include "fsw/programs/remote_endian_wire.h"
#include "osal/include/osal/device.h"
#include "osal/include/osal/target_wire.h"

#define TARGET_LINK_SOCKETS_MAX (1U + CAPACITY_SUBSYSTEM_LINKS)
#define TARGET_LINK_BUFFER_OCTETS 65536U

typedef struct { // Private.
    const run_state_t* run;
    unsigned component;
    osal_device_t in; ///< From the program.
    osal_device_t out;
    osal_device_t peer_in; ///< The program's ends, until it has inherited them.
    osal_device_t peer_out;
    osal_socket_t sender;
    osal_socket_t sockets[TARGET_LINK_SOCKETS_MAX]; ///< Sockets that the program has requested.
    size_t socket_count;
    size_t stream_rest; ///< Octets of the present record of the stream that were not taken yet.
    size_t at;          ///< Octets [at, end) of `arrived` are not taken yet.
    size_t end;
    uint32_t lost; ///< Datagrams that could not be passed on.
    uint8_t arrived[TARGET_LINK_BUFFER_OCTETS];
    uint8_t leaving[TARGET_WIRE_HEADER_OCTETS + TARGET_WIRE_CONTENT_MAX];
} target_link_t;

/// Create the pipes and the socket of a component's outgoing frames. STATUS_OK, STATUS_EXHAUSTED, STATUS_IO.
MUST_USE status_t target_link_open(target_link_t* link, const run_state_t* run, unsigned component);
/// Return the descriptors of the ends that the program inherits.
int target_link_peer_in(const target_link_t* link);
int target_link_peer_out(const target_link_t* link);
/// Close the ends of the program; call it when the program has inherited them.
void target_link_release_peer(target_link_t* link);
remote_endian_carrier_t target_link_carrier(target_link_t* link);
/// Returns the number of datagrams that were lost here: those of the program that could not be sent, and
/// those to the program that are longer than any message or frame.
uint32_t target_link_lost(const target_link_t* link);
void target_link_close(target_link_t* link);

#endif // LAUNCHER_TARGET_LINK_H
