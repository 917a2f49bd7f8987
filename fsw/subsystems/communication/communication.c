// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/communication/communication.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "pus/core/packet.h"
#include "pus/st09/st09_time.h"

#include <stddef.h>
#include <string.h>

#define SOURCE_OFFSET 9U       ///< Source id of a request.
#define DESTINATION_OFFSET 11U ///< Destination id of a report.
#define NO_CLIENT COMMUNICATION_CLIENTS
/// Room for reports that a client's queue must have before a request of the client is accepted [octets].
#define ANSWERS_ROOM 32768U

// ---- Connections ----

/// Returns the first connected client with this number or above, or NO_CLIENT.
static unsigned connected_from(const communication_t* const self, const unsigned first)
{
    unsigned client = first;
    while ((client < COMMUNICATION_CLIENTS) && !flow_tcp_is_connected(&self->flow, client)) {
        client++;
    }
    return client;
}

/// True if a client is the operator that takes part in the scheduler.
static bool is_participant(const communication_t* const self, const unsigned client)
{
    osal_address_t peer   = {0U, 0U};
    const uint16_t wanted = self->hooks.participant_port(self->hooks.context);
    return (wanted != 0U) && (flow_tcp_peer(&self->flow, client, &peer) == STATUS_OK) &&
           (peer.ipv4 == OSAL_IPV4_LOOPBACK) && (peer.port == wanted);
}

static void connected(void* const context, const unsigned client)
{
    communication_t* const self = (communication_t*)context;
    communication_ground_queue_init(&self->queues[client]);
    communication_ground_security_connected(&self->security, client);
    self->connected_ns[client] = subsystem_now_ns(self->generic);
    self->heard_ns[client]     = self->connected_ns[client];
    self->parameters.counters.connected++;
    (void)subsystem_raise(self->generic, COMMUNICATION_EVENT_GROUND_CONNECTED, NULL, 0U);
    if (!is_participant(self, client)) {
        // The client, not the simulation, determines the instant of this event.
        self->hooks.intruded(self->hooks.context);
    }
}

static void disconnected(void* const context, const unsigned client)
{
    communication_t* const self = (communication_t*)context;
    self->parameters.counters.disconnected++;
    communication_ground_routes_left(&self->routes, client);
    (void)subsystem_raise(self->generic, COMMUNICATION_EVENT_GROUND_LOST, NULL, 0U);
}

/// Returns the client with the earliest time in `since_ns`, if that time is at least `bound_ns` ago. The
/// participant of the scheduler is never returned, because simulated time waits for it.
static unsigned oldest(const communication_t* const self, const uint64_t since_ns[COMMUNICATION_CLIENTS],
                       const uint64_t bound_ns)
{
    const uint64_t now_ns = subsystem_now_ns(self->generic);
    uint64_t oldest_ns    = bound_ns;
    unsigned found        = NO_CLIENT;
    for (unsigned client = 0U; client < COMMUNICATION_CLIENTS; client++) {
        const uint64_t passed_ns = now_ns - since_ns[client];
        if ((passed_ns >= oldest_ns) && !is_participant(self, client) &&
            ((found == NO_CLIENT) || (passed_ns > oldest_ns))) {
            found     = client;
            oldest_ns = passed_ns;
        }
    }
    return found;
}

// ---- Up: requests ----

static bool is_valid(const uint8_t* const packet, const size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    return pus_tc_decode(packet, size, &tc, &failure) == STATUS_OK;
}

/// Store which client has sent a request. A request with the source id of an on-board user is counted
/// instead, which informs the ground: the supervisor refuses such a request, but sends the refusal to that
/// user.
static void note_source(communication_t* const self, const uint8_t* const packet, const size_t size,
                        const unsigned client)
{
    if (size < PUS_TC_MIN) {
        return; // There is no source id.
    }
    if ((octets_u16_at(&packet[SOURCE_OFFSET]) & PUS_USER_ONBOARD) != 0U) {
        self->not_requests++;
    } else {
        communication_ground_routes_note(&self->routes, client, packet);
    }
}

/// Take the first packet from a client's octets and pass it to the supervisor (framer of flow_tcp.h).
static size_t frame(void* const context, const unsigned client, const uint8_t* const octets,
                    const size_t size)
{
    communication_t* const self = (communication_t*)context;
    communication_ground_unit_t unit;
    const status_t status = communication_ground_security_next(&self->security, client, octets, size, &unit);
    if (status == STATUS_TRUNCATED) {
        return 0U;
    }
    if (status != STATUS_OK) {
        return FLOW_TCP_MALFORMED;
    }
    if (unit.packet == NULL) {
        return unit.taken; // The packet is incomplete, or there is none.
    }
    if (!pus_packet_is_tc(unit.packet, unit.size)) {
        communication_ground_security_accept(&self->security, client);
        self->not_requests++; // The ground must not send reports.
        return unit.taken;
    }
    if (communication_ground_queue_room(&self->queues[client]) < ANSWERS_ROOM) {
        self->is_uplink_full = true; // The client must first read its reports.
        return FLOW_TCP_BUSY;
    }
    if (self->uplink.send(self->uplink.context, unit.packet, unit.size) != STATUS_OK) {
        self->is_uplink_full = true; // The supervisor's inbox is full: the packet stays in the buffer.
        return FLOW_TCP_BUSY;
    }
    // The session advances only now, because a packet that stays in the buffer is checked again.
    communication_ground_security_accept(&self->security, client);
    self->parameters.counters.tc_received++;
    if (is_valid(unit.packet, unit.size)) {
        self->heard_ns[client] = subsystem_now_ns(self->generic);
    }
    note_source(self, unit.packet, unit.size, client);
    if (!is_participant(self, client)) {
        self->hooks.intruded(self->hooks.context);
    }
    return unit.taken;
}

/// Returns how many octets of a client may be read: from the participant only those that it has announced.
static size_t allowance(void* const context, const unsigned client)
{
    const communication_t* const self = (const communication_t*)context;
    return is_participant(self, client) ? self->outstanding : FLOW_TCP_UNLIMITED;
}

static unsigned participant_client(const communication_t* const self)
{
    for (unsigned client = connected_from(self, 0U); client != NO_CLIENT;
         client          = connected_from(self, client + 1U)) {
        if (is_participant(self, client)) {
            return client;
        }
    }
    return NO_CLIENT;
}

/// Choose the client to disconnect for a new one. With a key, it is a client that has not proved that it has
/// the key, otherwise a silent one. Without a key the operator cannot be distinguished from other clients:
/// it is a silent client, otherwise the one that has been connected longest. The participant of the
/// scheduler gets a slot immediately, because simulated time does not pass while it waits.
static unsigned make_room(void* const context)
{
    const communication_t* const self = (const communication_t*)context;
    const unsigned participant        = participant_client(self);
    if ((participant == NO_CLIENT) && (self->hooks.participant_port(self->hooks.context) != 0U)) {
        return oldest(self, self->connected_ns, 0U); // The new client may be the participant.
    }
    const unsigned unauthenticated =
        communication_ground_security_unauthenticated(&self->security, participant);
    if (unauthenticated < COMMUNICATION_CLIENTS) {
        return unauthenticated;
    }
    const unsigned silent = oldest(self, self->heard_ns, COMMUNICATION_IDLE_NS);
    return ((silent == NO_CLIENT) && (self->security.receiver == NULL))
               ? oldest(self, self->connected_ns, COMMUNICATION_HOLD_NS)
               : silent;
}

static flow_tcp_user_t user_of(communication_t* const self)
{
    return (flow_tcp_user_t){.context      = self,
                             .connected    = connected,
                             .disconnected = disconnected,
                             .frame        = frame,
                             .make_room    = make_room,
                             .allowance    = allowance};
}

/// True while the connection of a participant that has left the scheduler is open. It disconnects before it
/// leaves, but the kernel may report that later; simulated time waits, so that reports about it have a
/// defined time.
static bool is_disconnecting(communication_t* const self)
{
    osal_address_t peer = {0U, 0U};
    for (unsigned client = 0U; (self->participant != 0U) && (client < COMMUNICATION_CLIENTS); client++) {
        if (flow_tcp_is_connected(&self->flow, client) &&
            (flow_tcp_peer(&self->flow, client, &peer) == STATUS_OK) && (peer.port == self->participant)) {
            return true;
        }
    }
    self->participant = 0U;
    return false;
}

/// Update the state of the participant's connection. The participant has connected before the scheduler
/// names `port`, but the kernel may report it later. True if the connection is still expected.
static bool is_expected(communication_t* const self, const uint16_t port, const bool is_connected)
{
    if (is_connected && (self->participant != port)) {
        self->participant = port;
        self->hooks.served(self->hooks.context, port);
    } else if (!is_connected && (self->participant == port)) {
        self->outstanding = 0U;
        self->hooks.cut(self->hooks.context, port);
    } else {
        // The state of the connection has not changed.
    }
    return !is_connected && (self->participant != port);
}

void communication_stop_waiting(communication_t* const self)
{
    FSW_ASSERT(self != NULL);
    self->participant = self->hooks.participant_port(self->hooks.context);
}

bool communication_take_in(communication_t* const self, const uint32_t octets_due)
{
    FSW_ASSERT(self != NULL);
    const flow_tcp_user_t user = user_of(self);
    const unsigned before      = participant_client(self);
    const uint32_t of_client   = (before != NO_CLIENT) ? flow_tcp_octets_in(&self->flow, before) : 0U;
    const uint32_t of_all      = self->flow.counters.octets_in;
    size_t taken               = 0U;
    self->outstanding += octets_due;
    self->is_uplink_full = false;
    if (flow_tcp_step(&self->flow, &user, FLOW_TCP_UNLIMITED, &taken) != STATUS_OK) {
        return false; // The port is closed in this state; connections wait in the kernel.
    }
    self->parameters.counters.octets_received += (uint64_t)(self->flow.counters.octets_in - of_all);
    const unsigned client = participant_client(self);
    const uint16_t port   = self->hooks.participant_port(self->hooks.context);
    const bool is_awaited =
        (port != 0U) ? is_expected(self, port, client != NO_CLIENT) : is_disconnecting(self);
    if (client == NO_CLIENT) {
        // If the participant has closed its connection, no more octets of it are expected.
        self->outstanding = (before == NO_CLIENT) ? self->outstanding : 0U;
        return is_awaited;
    }
    self->outstanding -= flow_tcp_octets_in(&self->flow, client) - of_client;
    // If the supervisor has no room, the received octets wait, and no further ones are expected now.
    return (self->outstanding > 0U) && !self->is_uplink_full;
}

// ---- Down: reports ----

static void queue_for(communication_t* const self, const unsigned client, const uint8_t* const packet,
                      const size_t size)
{
    if (!flow_tcp_is_connected(&self->flow, client)) {
        return;
    }
    const uint32_t dropped_before = self->queues[client].dropped;
    const status_t status         = communication_ground_queue_put(&self->queues[client], packet, size);
    self->parameters.counters.tm_dropped += self->queues[client].dropped - dropped_before;
    if (status != STATUS_OK) {
        // The client does not read at all: end the connection instead of dropping reports.
        const flow_tcp_user_t user = user_of(self);
        flow_tcp_end(&self->flow, &user, client);
    } else if ((self->queues[client].dropped != dropped_before) && !self->is_drop_reported) {
        self->is_drop_reported = true;
        (void)subsystem_raise(self->generic, COMMUNICATION_EVENT_TM_DROPPED, NULL, 0U);
    } else {
        // The report is queued.
    }
}

/// Queue a report for the clients to which its destination belongs.
static void report(void* const context, const uint8_t* const packet, const size_t size)
{
    communication_t* const self = (communication_t*)context;
    if (size < (DESTINATION_OFFSET + 2U)) {
        return;
    }
    const bool is_time = pus_is_time_packet(packet, size); // A time packet has no destination id.
    const uint16_t destination =
        is_time ? (uint16_t)PUS_USER_GROUND : octets_u16_at(&packet[DESTINATION_OFFSET]);
    const uint32_t clients = (destination == PUS_USER_GROUND)
                                 ? UINT32_MAX
                                 : communication_ground_routes_of(&self->routes, destination, packet, size);
    for (unsigned client = connected_from(self, 0U); client != NO_CLIENT;
         client          = connected_from(self, client + 1U)) {
        if ((clients & ((uint32_t)1U << client)) != 0U) {
            queue_for(self, client, packet, size);
        }
    }
}

/// Send to one client as many octets as the kernel accepts.
static void send_to(communication_t* const self, const unsigned client)
{
    uint32_t total      = 0U;
    size_t size         = 0U;
    const uint8_t* next = communication_ground_queue_next(&self->queues[client], &size);
    while (next != NULL) {
        size_t sent = 0U;
        if (flow_tcp_send(&self->flow, client, next, size, &sent) != STATUS_OK) {
            break;
        }
        communication_ground_queue_sent(&self->queues[client], sent);
        total += (uint32_t)sent;
        self->parameters.counters.tm_sent += (sent == size) ? 1U : 0U;
        next = communication_ground_queue_next(&self->queues[client], &size);
    }
    osal_address_t peer = {0U, 0U};
    if ((total > 0U) && (flow_tcp_peer(&self->flow, client, &peer) == STATUS_OK)) {
        self->parameters.counters.octets_sent += total;
        self->hooks.sent(self->hooks.context, peer.port, total);
    }
}

void communication_send_out(communication_t* const self)
{
    FSW_ASSERT(self != NULL);
    for (unsigned client = connected_from(self, 0U); client != NO_CLIENT;
         client          = connected_from(self, client + 1U)) {
        send_to(self, client);
    }
}

size_t communication_sockets(communication_t* const self, osal_socket_t** const out_sockets,
                             const size_t capacity)
{
    FSW_ASSERT((self != NULL) && (out_sockets != NULL));
    return flow_tcp_sockets(&self->flow, out_sockets, capacity);
}

// ---- As a subsystem ----

static status_t publish(void* const context)
{
    communication_t* const self = (communication_t*)context;
    return subsystem_publish_all(self->generic, communication_definitions, communication_offsets,
                                 COMMUNICATION_PARAMETER_COUNT, &self->parameters);
}

static status_t listen(void* const context, const descriptor_configuration_t* const configuration)
{
    (void)configuration; // The launcher has already opened the port that the configuration defines.
    communication_t* const self = (communication_t*)context;
    const status_t status       = flow_tcp_adopt(&self->flow, self->listener);
    if ((status != STATUS_OK) && (status != STATUS_EXISTS)) {
        (void)subsystem_raise(self->generic, COMMUNICATION_EVENT_PORT_FAILED, NULL, 0U);
        return status;
    }
    return STATUS_OK;
}

/// Raise events about refused and ended connections. The rate is limited, so that clients cannot flood the
/// event log.
static void report_misuse(communication_t* const self)
{
    const communication_clients_t* const misuse = &self->parameters.clients;
    const uint32_t sum =
        misuse->refused + misuse->evicted + misuse->malformed + misuse->no_telecommand + misuse->forgotten;
    const uint64_t now_ns = subsystem_now_ns(self->generic);
    if ((sum != self->misuse_reported) && ((now_ns - self->misuse_reported_ns) >= COMMUNICATION_REPORT_NS)) {
        self->misuse_reported    = sum;
        self->misuse_reported_ns = now_ns;
        (void)subsystem_raise(self->generic, COMMUNICATION_EVENT_GROUND_MISUSED, NULL, 0U);
    }
}

static void update_status(void* const context)
{
    communication_t* const self        = (communication_t*)context;
    parameter_dictionary_t* dictionary = subsystem_dictionary(self->generic);
    uint16_t connections               = 0U;
    uint32_t queued                    = 0U;
    for (unsigned client = connected_from(self, 0U); client != NO_CLIENT;
         client          = connected_from(self, client + 1U)) {
        connections++;
        queued += communication_ground_queue_count(&self->queues[client]);
    }
    subsystem_health_t health;
    subsystem_health(self->generic, &health);
    if (quota_poll_warning(&self->sockets)) {
        (void)subsystem_raise(self->generic, COMMUNICATION_EVENT_POOL_WARNING, NULL, 0U);
    }
    parameter_lock(dictionary);
    self->parameters.counters.tc_refused        = self->not_requests + health.requests_refused;
    self->parameters.counters.pool_peak         = health.pool_peak;
    self->parameters.counters.pool_refused      = health.pool_refused;
    self->parameters.counters.events_suppressed = health.events_suppressed;
    self->parameters.counters.reports_lost      = health.reports_lost;
    self->parameters.counters.socket_peak       = self->sockets.stats.peak;
    self->parameters.counters.socket_refused    = self->sockets.stats.refused;
    self->parameters.status.connections         = connections;
    self->parameters.clients = (communication_clients_t){.refused        = self->flow.counters.turned_away,
                                                         .evicted        = self->flow.counters.evicted,
                                                         .malformed      = self->flow.counters.malformed,
                                                         .no_telecommand = self->not_requests,
                                                         .forgotten      = self->routes.forgotten};
    communication_ground_security_publish(&self->security, &self->parameters.security);
    self->parameters.status.queued = (uint16_t)((queued < UINT16_MAX) ? queued : UINT16_MAX);
    parameter_unlock(dictionary);
    // The next dropped report is announced only after all queues were empty.
    self->is_drop_reported = self->is_drop_reported && (queued > 0U);
    communication_ground_security_report(&self->security, self->generic);
    report_misuse(self);
}

/// End every connection as the end of the process would, without a message to the supervisor. The listening
/// socket stays open, because it belongs to the launcher.
static void end_connections(void* const context)
{
    communication_t* const self  = (communication_t*)context;
    const flow_tcp_user_t nobody = {.context = self};
    flow_tcp_end_all(&self->flow, &nobody);
}

const subsystem_callbacks_t* communication_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {.software_init = publish,
                                                    .configure     = listen,
                                                    .control       = update_status,
                                                    .report        = report,
                                                    .release       = end_connections};
    return &callbacks;
}

void communication_init(communication_t* const self, subsystem_t* const generic,
                        const pus_port_t* const uplink, const communication_hooks_t* const hooks,
                        const int listener)
{
    FSW_ASSERT((self != NULL) && (generic != NULL) && (uplink != NULL) && (hooks != NULL));
    (void)memset(self, 0, offsetof(communication_t, queues));
    communication_ground_security_init(&self->security, NULL);
    communication_ground_routes_init(&self->routes);
    self->generic  = generic;
    self->uplink   = *uplink;
    self->hooks    = *hooks;
    self->listener = listener;
    flow_tcp_init(&self->flow, self->clients, COMMUNICATION_CLIENTS, self->buffers, COMMUNICATION_BUFFER);
    quota_init(&self->sockets, COMMUNICATION_CLIENTS + 1U);
    flow_tcp_set_quota(&self->flow, &self->sockets);
}

void communication_secure(communication_t* const self, sdls_receiver_t* const receiver)
{
    FSW_ASSERT((self != NULL) && (receiver != NULL));
    communication_ground_security_init(&self->security, receiver);
}
