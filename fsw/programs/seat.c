// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/seat.h"

#include "base/assertion.h"
#include "base/text.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define NS_PER_US 1000U
#define PUMP_PATIENCE_MS 100U
#define PUMP_TRIES 50U      ///< Five seconds of wall-clock time for datagrams that the kernel still has.
#define CUT_PATIENCE_MS 10U ///< The same, where something was lost already: the way may be cut.
#define CUT_TRIES 1U
#define CUT_HOPE 16U     ///< After this many intakes without success only one in this many waits.
#define SWEEP_MAX 4096U  ///< Datagrams of one socket at a time: a flood must not block the reader.
#define HINTS_EVERY 128U ///< Intakes between two readings of the topology service.

// ---- Resolvers ----

/// Index of a bus of the mission, or bus_count.
static uint16_t bus_of(const mission_descriptor_t* const mission, const char* const name)
{
    uint16_t index = 0U;
    while ((index < mission->bus_count) && (strcmp(mission->buses[index].name, name) != 0)) {
        index++;
    }
    return index;
}

/// Names of the run are made unique by its identity; hosts and devices are what the descriptor says they are.
static status_t resolve_flow(void* const context, const endnode_kind_t kind, const char* const name,
                             endnode_address_t* const out_address)
{
    const seat_t* const seat = (const seat_t*)context;
    text_t text              = text_in(out_address->address, sizeof out_address->address);
    if (kind == ENDNODE_CAN) {
        const uint16_t bus = bus_of(seat->mission, name);
        if (bus == seat->mission->bus_count) {
            return STATUS_NOT_FOUND;
        }
        text_add(&text, seat->run->buses[bus].flight);
        out_address->is_fd = (seat->mission->buses[bus].data_bit_rate > 0U);
        return STATUS_OK;
    }
    if ((kind == ENDNODE_SHM) || (kind == ENDNODE_MQUEUE)) {
        text_add(&text, "/");
        text_add(&text, seat->run->identity);
        text_add(&text, ".flow.");
    }
    text_add(&text, name);
    if (text.cut) {
        return STATUS_NOT_FOUND;
    }
    const bool is_of_run = (kind == ENDNODE_SHM) || (kind == ENDNODE_MQUEUE);
    return (is_of_run && (run_block_note_flow(seat->run, out_address->address) != STATUS_OK))
               ? STATUS_NOT_FOUND
               : STATUS_OK;
}

static bool link_name(void* const context, const uint16_t link, char* const out_name, const size_t capacity)
{
    const seat_t* const seat = (const seat_t*)context;
    return run_name(seat->run, "link", link, out_name, capacity);
}

static uint8_t node_of(const seat_t* const seat, const uint16_t apid)
{
    unsigned component = 0U;
    return run_block_find(seat->run, apid, &component) ? seat->run->components[component].node : 0U;
}

static uint32_t node_ipv4(const seat_t* const seat, const uint16_t apid)
{
    return seat->run->node_ipv4[node_of(seat, apid)];
}

/// APID of the consumer of a link, 0 if there is no such link.
static uint16_t consumer_of(const seat_t* const seat, const uint16_t link)
{
    for (uint16_t i = 0U; i < seat->mission->link_count; i++) {
        if (seat->mission->links[i].number == link) {
            return seat->mission->links[i].consumer_apid;
        }
    }
    return 0U;
}

static bool link_route(void* const context, const uint16_t link, osal_socket_t** const out_socket,
                       osal_address_t* const out_consumer)
{
    seat_t* const seat = (seat_t*)context;
    if ((link == 0U) || (link > RUN_LINKS_MAX) || (seat->run->link_ports[link - 1U] == 0U)) {
        return false;
    }
    *out_socket = &seat->link_sender;
    *out_consumer =
        (osal_address_t){node_ipv4(seat, consumer_of(seat, link)), seat->run->link_ports[link - 1U]};
    return true;
}

static bool link_name_route(void* const context, const uint16_t link, osal_socket_t** const out_socket,
                            osal_tipc_name_t* const out_consumer)
{
    seat_t* const seat = (seat_t*)context;
    if ((link == 0U) || (link > RUN_LINKS_MAX) || (seat->run->link_descriptors[link - 1U] < 0)) {
        return false;
    }
    *out_socket   = &seat->link_sender;
    *out_consumer = (osal_tipc_name_t){run_link_type(seat->run), link};
    return true;
}

/// Is it the link asked for (0: any) of this component's port?
static bool is_link_of(const seat_t* const seat, const mission_link_t* const link, const uint16_t port,
                       const uint16_t number)
{
    const bool is_ours = ((link->producer_apid == seat->apid) && (link->producer_port == port)) ||
                         ((link->consumer_apid == seat->apid) && (link->consumer_port == port));
    return is_ours && ((number == 0U) || (number == link->number));
}

/// Shared memory reaches only partners on the same node.
static uint8_t methods_of_port(void* const context, const uint16_t port, const uint16_t number)
{
    const seat_t* const seat    = (const seat_t*)context;
    const uint8_t shared_memory = (uint8_t)(1U << (unsigned)RTLINK_METHOD_SHARED_MEMORY);
    bool has_partner            = false;
    bool is_any_here            = false;
    for (uint16_t i = 0U; i < seat->mission->link_count; i++) {
        const mission_link_t* const link = &seat->mission->links[i];
        if (is_link_of(seat, link, port, number)) {
            has_partner = true;
            is_any_here =
                is_any_here || (node_of(seat, link->producer_apid) == node_of(seat, link->consumer_apid));
        }
    }
    const bool is_reached = is_any_here || !has_partner;
    return is_reached ? seat->run->link_methods
                      : (uint8_t)(seat->run->link_methods & (uint8_t)~shared_memory);
}

void seat_told(seat_t* const seat, const unsigned component, const uint64_t now_ns)
{
    FSW_ASSERT((seat != NULL) && (component < MISSION_SUBSYSTEMS_MAX));
    if (seat->peers[component].told_ns <= run_block_last_beat(seat->run, component).step_ns) {
        seat->peers[component].told_ns = now_ns;
    }
}

uint64_t seat_promise_ns(const seat_t* const seat, osal_calendar_t* const calendar, const unsigned component)
{
    FSW_ASSERT((seat != NULL) && (component < MISSION_SUBSYSTEMS_MAX));
    const run_beat_t beat = run_block_last_beat(seat->run, component);
    if ((beat.wake_ns != OSAL_CALENDAR_NEVER) || (calendar == NULL)) {
        return beat.wake_ns;
    }
    const uint64_t begin_ns = osal_calendar_begin_ns(calendar, run_participant(component));
    return (begin_ns > beat.step_ns) ? begin_ns : OSAL_CALENDAR_NEVER; // In the first life all begin at 0.
}

void seat_watch_supervisor(const seat_t* const seat, osal_calendar_t* const calendar, const uint64_t now_ns)
{
    FSW_ASSERT(seat != NULL);
    unsigned index = 0U;
    if ((calendar == NULL) || (seat->apid == DESCRIPTOR_SUPERVISOR_APID) ||
        !run_block_find(seat->run, DESCRIPTOR_SUPERVISOR_APID, &index)) {
        return;
    }
    const uint64_t promised_ns = seat_promise_ns(seat, calendar, index);
    const uint64_t patience_ns = (uint64_t)seat->mission->subsystems[index].hang_after_us * NS_PER_US;
    if ((now_ns > promised_ns) && ((now_ns - promised_ns) > patience_ns) &&
        osal_calendar_is_present(calendar, run_participant(index))) {
        osal_calendar_kill(calendar, run_participant(index), OSAL_CALENDAR_ANY_LIFE);
    }
}

/// Messages to the supervisor are for whichever life it has: its channels outlive its process.
uint32_t seat_life_of(const seat_t* const seat, const unsigned component)
{
    return (seat->run->components[component].apid == DESCRIPTOR_SUPERVISOR_APID)
               ? OSAL_CALENDAR_ANY_LIFE
               : seat->peers[component].life;
}

void seat_delivered(void* const context, const uint16_t to)
{
    seat_t* const seat = (seat_t*)context;
    unsigned component = 0U;
    if (run_block_find(seat->run, to, &component)) {
        seat_told(seat, component, osal_clock_now_ns(&seat->clock));
        osal_clock_deliver(&seat->clock, run_participant(component), seat_life_of(seat, component), 1U, 0U);
    }
}

/// A consumer that was started again does not take frames of links of its earlier life.
static void link_delivered(void* const context, const uint16_t link, const uint32_t epoch)
{
    seat_t* const seat  = (seat_t*)context;
    const uint16_t apid = consumer_of(seat, link);
    unsigned component  = 0U;
    if (run_block_find(seat->run, apid, &component) && (epoch > seat->peers[component].link_floor)) {
        seat_delivered(seat, apid);
    }
}

static bool has_ended(const run_component_t* const one, const uint32_t life)
{
    return (__atomic_load_n(&one->found_life, __ATOMIC_ACQUIRE) == life) &&
           (__atomic_load_n(&one->process, __ATOMIC_ACQUIRE) != (uint32_t)RUN_PROCESS_RUNNING);
}

/// The lives of all components, from the run. They change only in grants of the supervisor, so they are
/// constant during another component's grant. Where time is real, a process may end at any instant: this
/// looks before the sockets are read, so that its last words are known before its end.
static void learn_lives(seat_t* const seat)
{
    for (unsigned i = 0U; i < seat->run->component_count; i++) {
        const run_component_t* const one = &seat->run->components[i];
        const uint32_t life              = __atomic_load_n(&one->life, __ATOMIC_ACQUIRE);
        seat->peers[i].is_gone           = has_ended(one, life);
        if (life != seat->peers[i].life) {
            seat->peers[i].life       = life;
            seat->peers[i].link_floor = __atomic_load_n(&one->link_floor, __ATOMIC_RELAXED);
            message_set_life(&seat->endpoint, one->apid, life);
        }
    }
}

/// Packets of this component to the supervisor.
static status_t send_up(void* const context, const uint8_t* const packet, const size_t size)
{
    seat_t* const seat = (seat_t*)context;
    return (pus_class_of(packet, size) == PUS_CLASS_FIRM)
               ? message_send(&seat->endpoint, DESCRIPTOR_SUPERVISOR_APID, packet, size)
               : message_send_plain(&seat->endpoint, DESCRIPTOR_SUPERVISOR_APID, packet, size);
}

CAPACITY_CHECK(peers_fit, MESSAGE_PEERS_MAX >= (MISSION_SUBSYSTEMS_MAX - 1U));
// A wait watches the sockets of messages and of the links that the component consumes, and eight of its own.
CAPACITY_CHECK(sockets_fit, SEAT_SOCKETS_MAX >= (1U + CAPACITY_SUBSYSTEM_LINKS + 8U));

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

static status_t adopt_link_socket(seat_t* const seat, const int descriptor)
{
    if (seat->link_socket_count >= CAPACITY_SUBSYSTEM_LINKS) {
        return STATUS_EXHAUSTED;
    }
    const status_t status = osal_socket_adopt(&seat->link_sockets[seat->link_socket_count], descriptor);
    seat->link_socket_count += (status == STATUS_OK) ? 1U : 0U;
    return status;
}

static status_t open_link_sockets(seat_t* const seat)
{
    const run_block_t* const run = seat->run;
    const bool is_tipc = ((run->link_methods & (uint8_t)(1U << (unsigned)RTLINK_METHOD_TIPC)) != 0U);
    status_t status =
        is_tipc ? osal_tipc_open(&seat->link_sender, OSAL_TIPC_SAMPLE, NULL, OSAL_TIPC_NODE)
                : osal_udp_open(&seat->link_sender, (osal_address_t){node_ipv4(seat, seat->apid), 0U}, 0U);
    for (uint16_t i = 0U; (i < seat->mission->link_count) && (status == STATUS_OK); i++) {
        const mission_link_t* const link = &seat->mission->links[i];
        const unsigned slot              = (unsigned)link->number - 1U;
        if ((link->consumer_apid == seat->apid) && (slot < RUN_LINKS_MAX) &&
            (run->link_descriptors[slot] >= 0)) {
            status = adopt_link_socket(seat, run->link_descriptors[slot]);
        }
    }
    return status;
}

static bool is_by_tipc(const seat_t* const seat)
{
    return seat->run->transport == (uint8_t)RUN_TRANSPORT_TIPC;
}

static status_t add_peers(seat_t* const seat)
{
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (i < seat->run->component_count) && (status == STATUS_OK); i++) {
        const run_component_t* const peer = &seat->run->components[i];
        const bool is_needed =
            (seat->apid == DESCRIPTOR_SUPERVISOR_APID) || (peer->apid == DESCRIPTOR_SUPERVISOR_APID);
        if ((i == seat->component) || !is_needed) {
            continue; // Subsystems talk to the supervisor only.
        }
        status = message_add_peer(&seat->endpoint, peer->apid);
        if ((status != STATUS_OK) || !osal_socket_is_open(&seat->message_socket)) {
            continue;
        }
        if (is_by_tipc(seat)) {
            status = tipc_carrier_add_peer(&seat->tipc, peer->apid, peer->message_identity);
        } else {
            const osal_address_t address = {node_ipv4(seat, peer->apid), peer->message_port};
            status                       = udp_carrier_add_peer(&seat->udp, peer->apid, address);
        }
    }
    return status;
}

static status_t open_messages(seat_t* const seat, message_place_t* const places, const size_t place_count)
{
    const run_component_t* const self = &seat->run->components[seat->component];
    if (seat->hub != NULL) {
        message_open(&seat->endpoint, seat->apid, seat->life, ring_carrier_port(seat->hub), places,
                     place_count);
        return ring_carrier_attach(seat->hub, &seat->endpoint);
    }
    const delivery_notice_t notice = {seat, seat_delivered};
    message_carrier_t carrier      = {NULL, NULL};
    status_t status                = osal_socket_adopt(&seat->message_socket, self->message_descriptor);
    if ((status == STATUS_OK) && is_by_tipc(seat)) {
        const uint32_t type = run_message_type(seat->run);
        status              = osal_tipc_watch_open(&seat->topology, type);
        tipc_carrier_init(&seat->tipc, &seat->message_socket, &seat->topology, type, notice);
        carrier = tipc_carrier_port(&seat->tipc);
    } else {
        udp_carrier_init(&seat->udp, &seat->message_socket, notice);
        carrier = udp_carrier_port(&seat->udp);
    }
    if (status == STATUS_OK) {
        message_open(&seat->endpoint, seat->apid, seat->life, carrier, places, place_count);
    }
    return status;
}

void seat_reader_init(seat_reader_t* const reader)
{
    FSW_ASSERT(reader != NULL);
    descriptor_loader_init(&reader->loader);
    reader->spare = &reader->model;
}

status_t seat_open_inbox(seat_t* const seat, message_place_t* const places, const size_t place_count)
{
    FSW_ASSERT((seat != NULL) && (places != NULL));
    if (seat->is_kept) {
        return STATUS_OK;
    }
    status_t status = open_messages(seat, places, place_count);
    if (status != STATUS_OK) {
        return fail(seat, "cannot open its message socket", status);
    }
    status = add_peers(seat);
    learn_lives(seat);
    return (status == STATUS_OK) ? STATUS_OK : fail(seat, "too many components", status);
}

/// The supervisor is restarted without an order, and its messages continue in their present life.
static uint32_t process_life(const run_component_t* const component)
{
    return (component->apid == DESCRIPTOR_SUPERVISOR_APID)
               ? __atomic_load_n(&component->found_life, __ATOMIC_ACQUIRE)
               : __atomic_load_n(&component->life, __ATOMIC_ACQUIRE);
}

status_t seat_take(seat_t* const seat, const seat_surroundings_t* const surroundings,
                   subsystem_descriptor_t* const own, const unsigned index)
{
    FSW_ASSERT((seat != NULL) && (surroundings != NULL) && (surroundings->run != NULL) &&
               (surroundings->mission != NULL) && (surroundings->reader != NULL) && (own != NULL) &&
               (index < surroundings->run->component_count));
    run_block_t* const run = surroundings->run;
    (void)memset(seat, 0, sizeof *seat);
    seat->run                       = run;
    seat->mission                   = surroundings->mission;
    seat->own                       = own;
    seat->reader                    = surroundings->reader;
    seat->hub                       = surroundings->hub;
    seat->component                 = index;
    seat->apid                      = run->components[index].apid;
    seat->life                      = __atomic_load_n(&run->components[index].life, __ATOMIC_ACQUIRE);
    seat->link_floor                = __atomic_load_n(&run->components[index].link_floor, __ATOMIC_RELAXED);
    seat->message_socket.descriptor = -1;
    seat->link_sender.descriptor    = -1;
    seat->topology.descriptor       = -1;
    seat->flows                     = (flow_resolver_t){seat, resolve_flow};
    seat->links                     = (link_resolver_t){.context    = seat,
                                                        .shm_name   = link_name,
                                                        .udp_route  = link_route,
                                                        .tipc_route = link_name_route,
                                                        .methods    = methods_of_port,
                                                        .delivered  = link_delivered};
    seat->uplink                    = (pus_port_t){seat, send_up};
    if (surroundings->calendar != NULL) {
        osal_clock_open_stepped(&seat->clock, surroundings->calendar, run_participant(index),
                                process_life(&run->components[index]));
    } else if (run->is_stepped) {
        osal_clock_open_granted(&seat->clock, &seat->deliveries);
    } else {
        osal_clock_open_real(&seat->clock, run->origin_ns);
    }
    const status_t status = open_link_sockets(seat);
    return (status == STATUS_OK) ? STATUS_OK : fail(seat, "cannot open its link sockets", status);
}

size_t seat_sockets(seat_t* const seat, osal_socket_t** const out_sockets, const size_t capacity)
{
    size_t count = 0U;
    if (osal_socket_is_open(&seat->message_socket) && (count < capacity)) {
        out_sockets[count] = &seat->message_socket;
        count++;
    }
    for (size_t i = 0U; (i < seat->link_socket_count) && (count < capacity); i++) {
        out_sockets[count] = &seat->link_sockets[i];
        count++;
    }
    return count;
}

void seat_leave(seat_t* const seat)
{
    FSW_ASSERT(seat != NULL);
    osal_socket_close(&seat->link_sender);
    osal_socket_close(&seat->topology);
}

// ---- Taking in ----

static status_t receive_sample(const seat_t* const seat, osal_socket_t* const socket,
                               uint8_t frame[LINK_FRAME_MAX], size_t* const out_size)
{
    osal_address_t from = {0U, 0U};
    uint64_t identity   = 0U;
    const bool is_tipc  = ((seat->run->link_methods & (uint8_t)(1U << (unsigned)RTLINK_METHOD_TIPC)) != 0U);
    return is_tipc ? osal_tipc_receive(socket, &identity, frame, LINK_FRAME_MAX, out_size)
                   : osal_udp_receive(socket, &from, frame, LINK_FRAME_MAX, out_size);
}

/// Datagrams of the message socket. Returns those that were meant for this life.
static uint32_t sweep_messages(seat_t* const seat)
{
    uint32_t taken = 0U;
    for (unsigned i = 0U; (i < SWEEP_MAX) && osal_socket_is_open(&seat->message_socket); i++) {
        const status_t status = is_by_tipc(seat) ? tipc_carrier_pump(&seat->tipc, &seat->endpoint)
                                                 : udp_carrier_pump(&seat->udp, &seat->endpoint);
        if ((status != STATUS_OK) && (status != STATUS_NOT_OURS)) {
            break;
        }
        taken += (status == STATUS_OK) ? 1U : 0U;
    }
    return taken;
}

/// The same of a link that it consumes.
static uint32_t sweep_link(seat_t* const seat, osal_socket_t* const socket,
                           void (*const link_datagram)(void* context, const uint8_t*, size_t),
                           void* const context)
{
    uint8_t frame[LINK_FRAME_MAX];
    uint32_t taken = 0U;
    size_t size    = 0U;
    for (unsigned i = 0U; i < SWEEP_MAX; i++) {
        if (receive_sample(seat, socket, frame, &size) != STATUS_OK) {
            break;
        }
        if (link_frame_epoch(frame, size) > seat->link_floor) {
            link_datagram(context, frame, size);
            taken++;
        }
    }
    return taken;
}

/// Read the sockets until they are empty: unannounced datagrams are errors or attacks, and would otherwise be
/// taken for the ones announced next. Returns the datagrams that may have been announced.
static uint32_t sweep(seat_t* const seat, void (*const link_datagram)(void* context, const uint8_t*, size_t),
                      void* const context)
{
    uint32_t taken = sweep_messages(seat);
    for (size_t i = 0U; i < seat->link_socket_count; i++) {
        taken += sweep_link(seat, &seat->link_sockets[i], link_datagram, context);
    }
    return taken;
}

/// Wait a moment for more to come in.
static void wait_for_more(seat_t* const seat, const uint32_t patience_ms)
{
    osal_socket_t* sockets[SEAT_SOCKETS_MAX];
    const size_t count = seat_sockets(seat, sockets, SEAT_SOCKETS_MAX);
    for (size_t i = 0U; i < count; i++) {
        const uint32_t share_ms = patience_ms / (uint32_t)count;
        if (osal_socket_wait_readable(sockets[i], (share_ms > 0U) ? share_ms : 1U) == STATUS_OK) {
            return;
        }
    }
}

/// Number of waits for announced datagrams: none at most intakes if none arrived for long.
static unsigned tries_of(const seat_t* const seat)
{
    if (seat->owed == 0U) {
        return PUMP_TRIES;
    }
    return ((seat->vain < CUT_HOPE) || ((seat->vain % CUT_HOPE) == 0U)) ? CUT_TRIES : 0U;
}

/// Take in announced datagrams, and late ones of earlier announcements. If the connection is cut, simulated
/// time continues without the missing ones.
static void take_due(seat_t* const seat, const uint32_t due,
                     void (*const link_datagram)(void* context, const uint8_t*, size_t), void* const context)
{
    const bool is_cut          = (seat->owed > 0U);
    const unsigned tries       = tries_of(seat);
    const uint32_t patience_ms = is_cut ? CUT_PATIENCE_MS : PUMP_PATIENCE_MS;
    uint32_t taken             = sweep(seat, link_datagram, context);
    for (unsigned attempt = 0U; (taken < due) && (attempt < tries); attempt++) {
        wait_for_more(seat, patience_ms);
        taken += sweep(seat, link_datagram, context);
    }
    if (due > 0U) {
        seat->vain = (taken < due) ? (seat->vain + 1U) : 0U;
    }
    const uint32_t awaited = (due < (UINT32_MAX - seat->owed)) ? (seat->owed + due) : UINT32_MAX;
    seat->owed             = (taken < awaited) ? (awaited - taken) : 0U;
    if (!is_cut && (taken < due)) {
        __atomic_store_n(&seat->run->is_lossy, 1U, __ATOMIC_RELAXED);
        osal_console_complain("a datagram that was announced has not arrived; the run is not reproducible");
    }
}

void seat_pump(seat_t* const seat, const uint32_t messages,
               void (*const link_datagram)(void* context, const uint8_t*, size_t), void* const context)
{
    FSW_ASSERT((seat != NULL) && (link_datagram != NULL));
    learn_lives(seat);
    if (seat->clock.mode == OSAL_CLOCK_REAL) {
        (void)sweep(seat, link_datagram, context);
        return;
    }
    take_due(seat, messages, link_datagram, context);
    seat->pumps++;
    if (osal_socket_is_open(&seat->topology) && ((seat->pumps % HINTS_EVERY) == 0U)) {
        tipc_carrier_take_hints(&seat->tipc, &seat->endpoint);
    }
}

void seat_keep(seat_t* const seat)
{
    FSW_ASSERT(seat != NULL);
    seat->is_kept = true;
}
