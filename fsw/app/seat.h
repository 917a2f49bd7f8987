// SPDX-License-Identifier: Apache-2.0
/// The place of one component in a run: its clock, its message endpoint, and the resolvers that turn logical
/// names into addresses of this run. The processes form has one seat a program, the image one for each.
///
/// Ownership  The caller places seats (static). Context: one task.
#ifndef FSW_APP_SEAT_H
#define FSW_APP_SEAT_H

#include "fsw/app/run_block.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/ring_carrier.h"
#include "fsw/framework/message/tipc_carrier.h"
#include "fsw/framework/message/udp_carrier.h"
#include "fsw/framework/rtlink/link_channel.h"
#include "osal/include/osal/clock.h"
#include "pus/process.h"

#define SEAT_INBOX_OCTETS MESSAGE_INBOX_OCTETS(MISSION_SUBSYSTEMS_MAX, 512U)
#define SEAT_SOCKETS_MAX 8U
#define SEAT_ERROR_MAX 512U

typedef struct { // Private, except the members named below.
    run_block_t* run;
    const mission_descriptor_t* mission;
    unsigned component; ///< Index in run->components.
    uint16_t apid;
    subsystem_descriptor_t* own; ///< The component's descriptor, read with the mission; it may read it anew.
    osal_clock_t clock;
    osal_deliveries_t deliveries; // Where the calendar is out of reach.
    message_endpoint_t endpoint;
    udp_carrier_t udp;
    tipc_carrier_t tipc;
    osal_socket_t topology; // What the kernel tells of TIPC names.
    uint32_t pumps;
    uint32_t owed; // Datagrams that were announced and have not come yet: the way may be cut.
    osal_socket_t message_socket;
    osal_socket_t link_sockets[RUN_LINKS_MAX]; // Of links that this component consumes.
    osal_socket_t link_sender;                 // Source of frames to others.
    flow_resolver_t flows;
    link_resolver_t links;
    pus_port_t uplink; ///< To the supervisor.
    char error[SEAT_ERROR_MAX];
    uint8_t inbox[SEAT_INBOX_OCTETS]; // Not cleared: nothing is read that did not arrive.
} seat_t;

/// Take the seat of component `index` of the run, whose descriptor is `own`. `calendar` null: real time, or,
/// where the run is stepped, a clock whose grants are brought (osal_clock_take_grant). `hub` null: messages
/// by UDP or TIPC, as the run says. STATUS_OK; else `error` says why: STATUS_EXHAUSTED, STATUS_IO.
MUST_USE status_t seat_take(seat_t* seat, run_block_t* run, const mission_descriptor_t* mission,
                            subsystem_descriptor_t* own, unsigned index, osal_calendar_t* calendar,
                            ring_carrier_t* hub);
/// Sockets that wake this component, for the program's wait. Returns their number.
size_t seat_sockets(seat_t* seat, osal_socket_t** out_sockets, size_t capacity);
/// Take in datagrams. Stepped: exactly the `messages` that were announced with the grant (waiting for those
/// that the kernel has not handed over yet); real: all there are. Frames of links go to `link_datagram`.
void seat_pump(seat_t* seat, uint32_t messages, void (*link_datagram)(void* context, const uint8_t*, size_t),
               void* context);
/// Tell the calendar of messages to another component.
void seat_delivered(void* context, uint16_t to);

#endif // FSW_APP_SEAT_H
