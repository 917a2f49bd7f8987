// SPDX-License-Identifier: Apache-2.0
#include "fsw/app/seat.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/text.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define PUMP_PATIENCE_MS 100U
#define PUMP_TRIES 50U ///< Five seconds of wall-clock time for what the kernel owes.
#define RECEIVE_BUFFER_OCTETS 425984U

// ---- Resolvers ----

static const mission_bus_t* bus_of(const mission_descriptor_t* const mission, const char* const name)
{
    for (uint16_t i = 0U; i < mission->bus_count; i++) {
        if (strcmp(mission->buses[i].name, name) == 0) {
            return &mission->buses[i];
        }
    }
    return NULL;
}

/// Names of the run are made unique by its identity; hosts and devices are what the descriptor says they are.
static status_t resolve_flow(void* const context, const endnode_kind_t kind, const char* const name,
                             endnode_address_t* const out_address)
{
    const seat_t* const seat       = (const seat_t*)context;
    const mission_bus_t* const bus = (kind == ENDNODE_CAN) ? bus_of(seat->mission, name) : NULL;
    text_t text                    = text_in(out_address->address, sizeof out_address->address);
    if (kind == ENDNODE_CAN) {
        if (bus == NULL) {
            return STATUS_NOT_FOUND;
        }
        text_add(&text, "shm:");
        text_add(&text, seat->run->identity);
        text_add(&text, ".can.");
        out_address->is_fd = (bus->data_bit_rate > 0U);
    } else if ((kind == ENDNODE_SHM) || (kind == ENDNODE_MQUEUE)) {
        text_add(&text, "/");
        text_add(&text, seat->run->identity);
        text_add(&text, ".flow.");
    } else {
        // As it is.
    }
    text_add(&text, name);
    return text.cut ? STATUS_NOT_FOUND : STATUS_OK;
}

static bool link_name(void* const context, const uint16_t link, char* const out_name, const size_t capacity)
{
    const seat_t* const seat = (const seat_t*)context;
    return run_name(seat->run, "link", link, out_name, capacity);
}

static bool link_route(void* const context, const uint16_t link, osal_socket_t** const out_socket,
                       osal_address_t* const out_consumer)
{
    seat_t* const seat = (seat_t*)context;
    if ((link == 0U) || (link > RUN_LINKS_MAX) || (seat->run->link_ports[link - 1U] == 0U)) {
        return false;
    }
    *out_socket   = &seat->link_sender;
    *out_consumer = (osal_address_t){OSAL_IPV4_LOOPBACK, seat->run->link_ports[link - 1U]};
    return true;
}

void seat_delivered(void* const context, const uint16_t to)
{
    seat_t* const seat = (seat_t*)context;
    unsigned component = 0U;
    if (run_block_find(seat->run, to, &component)) {
        osal_clock_deliver(&seat->clock, run_participant(component), 1U, 0U);
    }
}

static void link_delivered(void* const context, const uint16_t link)
{
    seat_t* const seat = (seat_t*)context;
    for (uint16_t i = 0U; i < seat->mission->link_count; i++) {
        if (seat->mission->links[i].number == link) {
            seat_delivered(seat, seat->mission->links[i].consumer_apid);
        }
    }
}

/// Packets of this component to the supervisor.
static status_t send_up(void* const context, const uint8_t* const packet, const size_t size)
{
    seat_t* const seat = (seat_t*)context;
    return message_send(&seat->endpoint, 1U, packet, size);
}

// ---- Taking a seat ----

static status_t fail(seat_t* const seat, const char* const what, const status_t status)
{
    text_t text = text_in(seat->error, sizeof seat->error);
    text_add(&text, seat->run->components[seat->component].name);
    text_add(&text, ": ");
    text_add(&text, what);
    text_add(&text, ": ");
    text_add(&text, status_text(status));
    return status;
}

static status_t open_link_sockets(seat_t* const seat)
{
    status_t status = osal_udp_open(&seat->link_sender, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U);
    for (uint16_t i = 0U; (i < seat->mission->link_count) && (status == STATUS_OK); i++) {
        const mission_link_t* const link = &seat->mission->links[i];
        const unsigned slot              = (unsigned)link->number - 1U;
        if ((link->consumer_apid == seat->apid) && (slot < RUN_LINKS_MAX) &&
            (seat->run->link_descriptors[slot] >= 0)) {
            status = osal_socket_adopt(&seat->link_sockets[slot], seat->run->link_descriptors[slot]);
        }
    }
    return status;
}

static status_t add_peers(seat_t* const seat)
{
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i < seat->run->component_count) && (status == STATUS_OK); i++) {
        const run_component_t* const peer = &seat->run->components[i];
        const bool is_needed              = (seat->apid == 1U) || (peer->apid == 1U);
        if ((i == seat->component) || !is_needed) {
            continue; // Subsystems talk to the supervisor only.
        }
        status = message_add_peer(&seat->endpoint, peer->apid);
        if ((status == STATUS_OK) && (seat->message_socket.descriptor >= 0)) {
            status = udp_carrier_add_peer(&seat->udp, peer->apid,
                                          (osal_address_t){OSAL_IPV4_LOOPBACK, peer->message_port});
        }
    }
    return status;
}

static status_t open_messages(seat_t* const seat, ring_carrier_t* const hub)
{
    const run_component_t* const self = &seat->run->components[seat->component];
    if (hub != NULL) {
        message_open(&seat->endpoint, seat->apid, self->start_count, ring_carrier_port(hub), seat->inbox,
                     sizeof seat->inbox);
        return ring_carrier_attach(hub, &seat->endpoint);
    }
    const status_t status = osal_socket_adopt(&seat->message_socket, self->message_descriptor);
    if (status == STATUS_OK) {
        udp_carrier_init(&seat->udp, &seat->message_socket, (delivery_notice_t){seat, seat_delivered});
        message_open(&seat->endpoint, seat->apid, self->start_count, udp_carrier_port(&seat->udp),
                     seat->inbox, sizeof seat->inbox);
    }
    return status;
}

status_t seat_take(seat_t* const seat, run_block_t* const run, const mission_descriptor_t* const mission,
                   const unsigned index, osal_calendar_t* const calendar, ring_carrier_t* const hub)
{
    FSW_ASSERT((seat != NULL) && (run != NULL) && (mission != NULL) && (index < run->component_count));
    (void)memset(seat, 0, sizeof *seat);
    seat->run                       = run;
    seat->mission                   = mission;
    seat->component                 = index;
    seat->apid                      = run->components[index].apid;
    seat->message_socket.descriptor = -1;
    seat->link_sender.descriptor    = -1;
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        seat->link_sockets[i].descriptor = -1;
    }
    seat->flows  = (flow_resolver_t){seat, resolve_flow};
    seat->links  = (link_resolver_t){seat, link_name, link_route, link_delivered};
    seat->uplink = (pus_port_t){seat, send_up};
    if (calendar != NULL) {
        osal_clock_open_stepped(&seat->clock, calendar, run_participant(index));
    } else {
        osal_clock_open_real(&seat->clock, run->origin_ns);
    }
    status_t status = open_messages(seat, hub);
    if (status != STATUS_OK) {
        return fail(seat, "cannot open its message socket", status);
    }
    status = add_peers(seat);
    if (status != STATUS_OK) {
        return fail(seat, "too many components", status);
    }
    status = open_link_sockets(seat);
    return (status == STATUS_OK) ? STATUS_OK : fail(seat, "cannot open its link sockets", status);
}

size_t seat_sockets(seat_t* const seat, osal_socket_t** const out_sockets, const size_t capacity)
{
    size_t count = 0U;
    if (osal_socket_is_open(&seat->message_socket) && (count < capacity)) {
        out_sockets[count] = &seat->message_socket;
        count++;
    }
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        if (osal_socket_is_open(&seat->link_sockets[i]) && (count < capacity)) {
            out_sockets[count] = &seat->link_sockets[i];
            count++;
        }
    }
    return count;
}

// ---- Taking in ----

/// Read the sockets once over. Returns the datagrams taken in.
static uint32_t sweep(seat_t* const seat, const uint32_t limit,
                      void (*const link_datagram)(void* context, const uint8_t*, size_t), void* const context)
{
    uint8_t frame[LINK_FRAME_MAX];
    uint32_t taken = 0U;
    while ((taken < limit) && osal_socket_is_open(&seat->message_socket) &&
           (udp_carrier_pump(&seat->udp, &seat->endpoint) == STATUS_OK)) {
        taken++;
    }
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        osal_socket_t* const socket = &seat->link_sockets[i];
        osal_address_t from         = {0U, 0U};
        size_t size                 = 0U;
        while ((taken < limit) && osal_socket_is_open(socket) &&
               (osal_udp_receive(socket, &from, frame, sizeof frame, &size) == STATUS_OK)) {
            link_datagram(context, frame, size);
            taken++;
        }
    }
    return taken;
}

void seat_pump(seat_t* const seat, const uint32_t messages,
               void (*const link_datagram)(void* context, const uint8_t*, size_t), void* const context)
{
    FSW_ASSERT((seat != NULL) && (link_datagram != NULL));
    if (seat->clock.mode == OSAL_CLOCK_REAL) {
        (void)sweep(seat, UINT32_MAX, link_datagram, context);
        return;
    }
    uint32_t due = messages;
    if (!osal_socket_is_open(&seat->message_socket)) { // Image: messages are in the inbox already.
        due = (messages > seat->endpoint.inbox.blocks) ? (messages - seat->endpoint.inbox.blocks) : 0U;
    }
    for (unsigned attempt = 0U; (due > 0U) && (attempt < PUMP_TRIES); attempt++) {
        due -= sweep(seat, due, link_datagram, context);
        osal_socket_t* sockets[SEAT_SOCKETS_MAX];
        const size_t count = seat_sockets(seat, sockets, SEAT_SOCKETS_MAX);
        for (size_t i = 0U; (i < count) && (due > 0U); i++) {
            if (osal_socket_wait_readable(sockets[i], PUMP_PATIENCE_MS / (uint32_t)count) == STATUS_OK) {
                break;
            }
        }
    }
    if (due > 0U) {
        osal_console_complain("a datagram that was announced has not arrived; the run is not reproducible");
    }
}
