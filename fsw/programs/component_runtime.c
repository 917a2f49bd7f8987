// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/component_runtime.h"

#include "fsw/programs/run_flow_address.h"
#include "base/assertion.h"
#include "base/text.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define NS_PER_US 1000U
#define PUMP_TIMEOUT_MS 100U
#define PUMP_TRIES 50U     ///< Waits for announced datagrams: together five seconds of wall-clock time.
#define CUT_TIMEOUT_MS 10U ///< Time of one wait after a loss, because the connection may be cut.
#define CUT_INTERVAL 16U   ///< After this number of intakes without success, only every n-th one waits.
#define SWEEP_MAX 4096U    ///< Datagrams read from one socket at a time: a flood must not block the reader.
/// Of the intakes for which no datagram was announced, every n-th one reads the sockets.
#define SWEEP_EVERY 16U
#define HINTS_EVERY 128U ///< Number of intakes between two reads of the topology service.

// ---- Resolvers ----

/// Returns the index of a bus of the mission; bus_count if there is no such bus.
static uint16_t bus_of(const mission_descriptor_t* const mission, const char* const name)
{
    uint16_t index = 0U;
    while ((index < mission->bus_count) && (strcmp(mission->buses[index].name, name) != 0)) {
        index++;
    }
    return index;
}

static status_t resolve_flow(void* const context, const flow_endnode_kind_t kind, const char* const name,
                             flow_endnode_address_t* const out_address)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    if (kind != ENDNODE_CAN) {
        return run_flow_address(runtime->run, kind, name, out_address);
    }
    const uint16_t bus = bus_of(runtime->mission, name);
    if (bus == runtime->mission->bus_count) {
        return STATUS_NOT_FOUND;
    }
    text_t text = text_in(out_address->address, sizeof out_address->address);
    text_add(&text, runtime->run->buses[bus].flight);
    out_address->is_fd = (runtime->mission->buses[bus].data_bit_rate > 0U);
    return STATUS_OK;
}

static bool link_name(void* const context, const uint16_t link, char* const out_name, const size_t capacity)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    return run_name(runtime->run, "link", link, out_name, capacity);
}

static uint8_t computer_of(const component_runtime_t* const runtime, const uint16_t apid)
{
    unsigned component = 0U;
    return run_state_find(runtime->run, apid, &component) ? runtime->run->components[component].computer : 0U;
}

static uint32_t computer_ipv4(const component_runtime_t* const runtime, const uint16_t apid)
{
    return runtime->run->computer_ipv4[computer_of(runtime, apid)];
}

/// Returns the address of a component for links: it receives and sends the frames of its links there.
static uint32_t link_ipv4(const component_runtime_t* const runtime, const uint16_t apid)
{
    return computer_ipv4(runtime, apid) + (runtime->run->relay.is_network ? RUN_LINK_NETWORK : 0U);
}

static bool has_relay(const component_runtime_t* const runtime)
{
    return (runtime->run->relay.delay_us > 0U) && !runtime->run->relay.is_network;
}

/// Returns the APID of the consumer of a link; 0 if there is no such link.
static uint16_t consumer_of(const component_runtime_t* const runtime, const uint16_t link)
{
    for (uint16_t i = 0U; i < runtime->mission->link_count; i++) {
        if (runtime->mission->links[i].number == link) {
            return runtime->mission->links[i].consumer_apid;
        }
    }
    return 0U;
}

static bool link_route(void* const context, const uint16_t link, osal_socket_t** const out_socket,
                       osal_address_t* const out_consumer)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    if ((link == 0U) || (link > RUN_LINKS_MAX) || (runtime->run->link_ports[link - 1U] == 0U)) {
        return false;
    }
    const uint16_t* const ports = has_relay(runtime) ? runtime->run->relay.ports : runtime->run->link_ports;
    *out_socket                 = &runtime->link_sender;
    *out_consumer = (osal_address_t){link_ipv4(runtime, consumer_of(runtime, link)), ports[link - 1U]};
    return true;
}

/// Get the play-out buffer of a link; the link keeps it when its consumer restarts in the same program.
static status_t link_play_out(void* const context, const uint16_t link, rtlink_play_out_t** const out_buffer)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    component_play_outs_t* const play_outs   = runtime->play_outs;
    *out_buffer                              = NULL;
    if (runtime->run->relay.delay_us == 0U) {
        return STATUS_OK;
    }
    for (size_t i = 0U; i < COMPONENT_PLAY_OUTS_MAX; i++) {
        if ((play_outs->links[i] == link) || (play_outs->links[i] == 0U)) {
            play_outs->links[i]      = link;
            *out_buffer              = &play_outs->buffers[i];
            (*out_buffer)->delay_us  = runtime->run->relay.delay_us;
            (*out_buffer)->budget_us = runtime->run->relay.jitter_us;
            return STATUS_OK;
        }
    }
    return STATUS_EXHAUSTED;
}

static bool link_name_route(void* const context, const uint16_t link, osal_socket_t** const out_socket,
                            osal_tipc_name_t* const out_consumer)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    if ((link == 0U) || (link > RUN_LINKS_MAX) || (runtime->run->link_descriptors[link - 1U] < 0)) {
        return false;
    }
    *out_socket   = &runtime->link_sender;
    *out_consumer = (osal_tipc_name_t){run_link_type(runtime->run), link};
    return true;
}

/// True if this is link `number` (0: any link) of this port of the component.
static bool is_link_of(const component_runtime_t* const runtime, const mission_link_t* const link,
                       const uint16_t port, const uint16_t number)
{
    const bool is_of_port = ((link->producer_apid == runtime->apid) && (link->producer_port == port)) ||
                            ((link->consumer_apid == runtime->apid) && (link->consumer_port == port));
    return is_of_port && ((number == 0U) || (number == link->number));
}

/// Returns the methods for a port. Shared memory requires that both partners are on the same on-board
/// computer.
static uint8_t methods_of_port(void* const context, const uint16_t port, const uint16_t number)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    const uint8_t shared_memory              = (uint8_t)(1U << (unsigned)RTLINK_METHOD_SHARED_MEMORY);
    bool has_partner                         = false;
    bool is_any_on_node                      = false;
    for (uint16_t i = 0U; i < runtime->mission->link_count; i++) {
        const mission_link_t* const link = &runtime->mission->links[i];
        if (is_link_of(runtime, link, port, number)) {
            has_partner    = true;
            is_any_on_node = is_any_on_node || (computer_of(runtime, link->producer_apid) ==
                                                computer_of(runtime, link->consumer_apid));
        }
    }
    return (is_any_on_node || !has_partner) ? runtime->run->link_methods
                                            : (uint8_t)(runtime->run->link_methods & (uint8_t)~shared_memory);
}

void component_runtime_note_sent(component_runtime_t* const runtime, const unsigned component,
                                 const uint64_t now_ns)
{
    FSW_ASSERT((runtime != NULL) && (component < MISSION_SUBSYSTEMS_MAX));
    if (runtime->peers[component].reported_ns <= run_state_last_beat(runtime->run, component).step_ns) {
        runtime->peers[component].reported_ns = now_ns;
    }
}

uint64_t component_runtime_promise_ns(const component_runtime_t* const runtime,
                                      osal_lockstep_t* const scheduler, const unsigned component)
{
    FSW_ASSERT((runtime != NULL) && (component < MISSION_SUBSYSTEMS_MAX));
    const run_beat_t beat = run_state_last_beat(runtime->run, component);
    if ((beat.wake_ns != OSAL_LOCKSTEP_NEVER) || (scheduler == NULL)) {
        return beat.wake_ns;
    }
    const uint64_t begin_ns = osal_lockstep_begin_ns(scheduler, run_participant(component));
    return (begin_ns > beat.step_ns) ? begin_ns : OSAL_LOCKSTEP_NEVER; // In the first life, begin_ns is 0.
}

void component_runtime_watch_supervisor(const component_runtime_t* const runtime,
                                        osal_lockstep_t* const scheduler, const uint64_t now_ns)
{
    FSW_ASSERT(runtime != NULL);
    unsigned index = 0U;
    if ((scheduler == NULL) || (runtime->apid == SUPERVISOR_APID) ||
        !run_state_find(runtime->run, SUPERVISOR_APID, &index)) {
        return;
    }
    const uint64_t promised_ns = component_runtime_promise_ns(runtime, scheduler, index);
    const uint64_t timeout_ns  = (uint64_t)runtime->mission->subsystems[index].hang_after_us * NS_PER_US;
    if ((now_ns > promised_ns) && ((now_ns - promised_ns) > timeout_ns) &&
        osal_lockstep_is_present(scheduler, run_participant(index))) {
        osal_lockstep_kill(scheduler, run_participant(index), OSAL_LOCKSTEP_ANY_LIFE);
    }
}

/// Returns the life to which messages are sent. For the supervisor it is any life, because its channels
/// outlive its process.
uint32_t component_runtime_life_of(const component_runtime_t* const runtime, const unsigned component)
{
    return (runtime->run->components[component].apid == SUPERVISOR_APID) ? OSAL_LOCKSTEP_ANY_LIFE
                                                                         : runtime->peers[component].life;
}

void component_runtime_delivered(void* const context, const uint16_t to)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    unsigned component                 = 0U;
    if (run_state_find(runtime->run, to, &component)) {
        component_runtime_note_sent(runtime, component, osal_clock_now_ns(&runtime->clock));
        osal_clock_deliver(&runtime->clock, run_participant(component),
                           component_runtime_life_of(runtime, component), 1U, 0U);
    }
}

/// Announce a frame of a link to the scheduler, unless the link belongs to an earlier life of the consumer:
/// the present life does not receive such frames.
static void link_delivered(void* const context, const uint16_t link, const uint32_t epoch)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    const uint16_t apid                = consumer_of(runtime, link);
    unsigned component                 = 0U;
    if (runtime->run->relay.is_network) {
        // Frames are not announced, because simulated time does not wait for the network.
    } else if (has_relay(runtime)) {
        osal_clock_deliver(&runtime->clock, run_relay(runtime->run), OSAL_LOCKSTEP_ANY_LIFE, 1U, 0U);
    } else if (run_state_find(runtime->run, apid, &component) &&
               (epoch > runtime->peers[component].link_floor)) {
        component_runtime_delivered(runtime, apid);
    } else {
        // The link belongs to an earlier life of the consumer.
    }
}

/// True if the process of a life has ended.
static bool has_ended(const run_component_t* const one, const uint32_t life)
{
    return (__atomic_load_n(&one->found_life, __ATOMIC_ACQUIRE) == life) &&
           (__atomic_load_n(&one->process, __ATOMIC_ACQUIRE) != (uint32_t)RUN_PROCESS_RUNNING);
}

/// Read the lives of all components from the run state. They change only in grants of the supervisor, so they
/// are constant during another component's grant. In real time a process may end at any instant; therefore
/// the lives are read before the sockets, so that a life's last messages are received before its end is
/// noticed.
static void read_lives(component_runtime_t* const runtime)
{
    for (unsigned i = 0U; i < runtime->run->component_count; i++) {
        const run_component_t* const one = &runtime->run->components[i];
        const uint32_t life              = __atomic_load_n(&one->life, __ATOMIC_ACQUIRE);
        runtime->peers[i].is_gone        = has_ended(one, life);
        if (life != runtime->peers[i].life) {
            runtime->peers[i].life       = life;
            runtime->peers[i].link_floor = __atomic_load_n(&one->link_floor, __ATOMIC_RELAXED);
            message_set_life(&runtime->endpoint, one->apid, life);
        }
    }
}

/// Send a packet of this component to the supervisor.
static status_t send_up(void* const context, const uint8_t* const packet, const size_t size)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    return (pus_class_of(packet, size) == PUS_CLASS_FIRM)
               ? message_send(&runtime->endpoint, SUPERVISOR_APID, packet, size)
               : message_send_plain(&runtime->endpoint, SUPERVISOR_APID, packet, size);
}

CAPACITY_CHECK(peers_fit, MESSAGE_PEERS_MAX >= (MISSION_SUBSYSTEMS_MAX - 1U));
// A wait polls the message socket, those of the links that the component consumes, and up to eight others.
CAPACITY_CHECK(sockets_fit, COMPONENT_RUNTIME_SOCKETS_MAX >= (1U + CAPACITY_SUBSYSTEM_LINKS + 8U));

// ---- Opening a runtime ----

/// Write the error text of the runtime. Returns `status`.
static status_t fail(component_runtime_t* const runtime, const char* const what, const status_t status)
{
    text_t text = text_in(runtime->error, sizeof runtime->error);
    text_add(&text, runtime->run->components[runtime->component].name);
    text_add(&text, ": ");
    text_add(&text, what);
    text_add(&text, ": ");
    text_add(&text, status_text(status));
    return status;
}

static status_t adopt_link_socket(component_runtime_t* const runtime, const int descriptor)
{
    if (runtime->link_socket_count >= CAPACITY_SUBSYSTEM_LINKS) {
        return STATUS_EXHAUSTED;
    }
    const status_t status = osal_socket_adopt(&runtime->link_sockets[runtime->link_socket_count], descriptor);
    runtime->link_socket_count += (status == STATUS_OK) ? 1U : 0U;
    return status;
}

static status_t open_link_sockets(component_runtime_t* const runtime)
{
    const run_state_t* const run = runtime->run;
    const bool is_tipc = ((run->link_methods & (uint8_t)(1U << (unsigned)RTLINK_METHOD_TIPC)) != 0U);
    status_t status = is_tipc ? osal_tipc_open(&runtime->link_sender, OSAL_TIPC_SAMPLE, NULL, OSAL_TIPC_NODE)
                              : osal_udp_open(&runtime->link_sender,
                                              (osal_address_t){link_ipv4(runtime, runtime->apid), 0U}, 0U);
    for (uint16_t i = 0U; (i < runtime->mission->link_count) && (status == STATUS_OK); i++) {
        const mission_link_t* const link = &runtime->mission->links[i];
        const unsigned slot              = (unsigned)link->number - 1U;
        if ((link->consumer_apid == runtime->apid) && (slot < RUN_LINKS_MAX) &&
            (run->link_descriptors[slot] >= 0)) {
            status = adopt_link_socket(runtime, run->link_descriptors[slot]);
        }
    }
    return status;
}

static bool is_by_tipc(const component_runtime_t* const runtime)
{
    return runtime->run->transport == (uint8_t)RUN_TRANSPORT_TIPC;
}

static status_t add_peers(component_runtime_t* const runtime)
{
    status_t status = message_set_window(&runtime->endpoint, runtime->apid,
                                         runtime->run->components[runtime->component].message_window);
    for (unsigned i = 0U; (i < runtime->run->component_count) && (status == STATUS_OK); i++) {
        const run_component_t* const peer = &runtime->run->components[i];
        const bool is_needed = (runtime->apid == SUPERVISOR_APID) || (peer->apid == SUPERVISOR_APID);
        if ((i == runtime->component) || !is_needed) {
            continue; // Subsystems communicate with the supervisor only.
        }
        status = message_add_peer(&runtime->endpoint, peer->apid);
        status = (status == STATUS_OK)
                     ? message_set_window(&runtime->endpoint, peer->apid, peer->message_window)
                     : status;
        if ((status != STATUS_OK) || !osal_socket_is_open(&runtime->message_socket)) {
            continue;
        }
        if (is_by_tipc(runtime)) {
            status = message_tipc_carrier_add_peer(&runtime->tipc, peer->apid, peer->message_identity);
        } else {
            const osal_address_t address = {computer_ipv4(runtime, peer->apid), peer->message_port};
            status                       = message_udp_carrier_add_peer(&runtime->udp, peer->apid, address);
        }
    }
    return status;
}

static status_t open_messages(component_runtime_t* const runtime, message_slot_t* const slots,
                              const size_t slot_count)
{
    const run_component_t* const self = &runtime->run->components[runtime->component];
    if (runtime->ring_carrier != NULL) {
        message_open(&runtime->endpoint, runtime->apid, runtime->life,
                     message_ring_carrier_port(runtime->ring_carrier), slots, slot_count);
        return message_ring_carrier_attach(runtime->ring_carrier, &runtime->endpoint);
    }
    const message_delivery_notice_t notice = {runtime, component_runtime_delivered};
    message_carrier_t carrier              = {NULL, NULL};
    status_t status = osal_socket_adopt(&runtime->message_socket, self->message_descriptor);
    if ((status == STATUS_OK) && is_by_tipc(runtime)) {
        const uint32_t type = run_message_type(runtime->run);
        status              = osal_tipc_watch_open(&runtime->topology, type);
        message_tipc_carrier_init(&runtime->tipc, &runtime->message_socket, &runtime->topology, type, notice);
        carrier = message_tipc_carrier_port(&runtime->tipc);
    } else {
        message_udp_carrier_init(&runtime->udp, &runtime->message_socket, notice);
        carrier = message_udp_carrier_port(&runtime->udp);
    }
    if (status == STATUS_OK) {
        message_open(&runtime->endpoint, runtime->apid, runtime->life, carrier, slots, slot_count);
    }
    return status;
}

status_t component_runtime_open_inbox(component_runtime_t* const runtime, message_slot_t* const slots,
                                      const size_t slot_count)
{
    FSW_ASSERT((runtime != NULL) && (slots != NULL));
    if (runtime->is_kept) {
        return STATUS_OK;
    }
    status_t status = open_messages(runtime, slots, slot_count);
    if (status != STATUS_OK) {
        return fail(runtime, "cannot open its message socket", status);
    }
    status = add_peers(runtime);
    read_lives(runtime);
    return (status == STATUS_OK) ? STATUS_OK : fail(runtime, "too many peers, or a window too large", status);
}

/// Returns the life of this process. The supervisor restarts without a command; its messages keep their life.
static uint32_t process_life(const run_component_t* const component)
{
    return (component->apid == SUPERVISOR_APID) ? __atomic_load_n(&component->found_life, __ATOMIC_ACQUIRE)
                                                : __atomic_load_n(&component->life, __ATOMIC_ACQUIRE);
}

status_t component_runtime_take(component_runtime_t* const runtime,
                                const component_runtime_surroundings_t* const surroundings,
                                subsystem_descriptor_t* const own, const unsigned index)
{
    FSW_ASSERT((runtime != NULL) && (surroundings != NULL) && (surroundings->run != NULL) &&
               (surroundings->mission != NULL) && (surroundings->descriptors != NULL) && (own != NULL) &&
               (index < surroundings->run->component_count));
    run_state_t* const run = surroundings->run;
    (void)memset(runtime, 0, sizeof *runtime);
    runtime->run          = run;
    runtime->mission      = surroundings->mission;
    runtime->own          = own;
    runtime->descriptors  = surroundings->descriptors;
    runtime->play_outs    = surroundings->play_outs;
    runtime->ring_carrier = surroundings->ring_carrier;
    runtime->component    = index;
    runtime->apid         = run->components[index].apid;
    runtime->life         = __atomic_load_n(&run->components[index].life, __ATOMIC_ACQUIRE);
    runtime->link_floor   = __atomic_load_n(&run->components[index].link_floor, __ATOMIC_RELAXED);
    runtime->message_socket.descriptor = -1;
    runtime->link_sender.descriptor    = -1;
    runtime->topology.descriptor       = -1;
    runtime->flows                     = (flow_resolver_t){runtime, resolve_flow};
    runtime->links                     = (rtlink_resolver_t){.context    = runtime,
                                                             .shm_name   = link_name,
                                                             .udp_route  = link_route,
                                                             .tipc_route = link_name_route,
                                                             .methods    = methods_of_port,
                                                             .play_out   = link_play_out,
                                                             .delivered  = link_delivered};
    runtime->uplink                    = (pus_port_t){runtime, send_up};
    if (surroundings->scheduler != NULL) {
        osal_clock_open_stepped(&runtime->clock, surroundings->scheduler, run_participant(index),
                                process_life(&run->components[index]));
    } else if (run->is_stepped) {
        osal_clock_open_granted(&runtime->clock, &runtime->deliveries);
    } else {
        osal_clock_open_real(&runtime->clock, run->origin_ns);
    }
    const status_t status = open_link_sockets(runtime);
    return (status == STATUS_OK) ? STATUS_OK : fail(runtime, "cannot open its link sockets", status);
}

size_t component_runtime_sockets(component_runtime_t* const runtime, osal_socket_t** const out_sockets,
                                 const size_t capacity)
{
    size_t count = 0U;
    if (osal_socket_is_open(&runtime->message_socket) && (count < capacity)) {
        out_sockets[count] = &runtime->message_socket;
        count++;
    }
    for (size_t i = 0U; (i < runtime->link_socket_count) && (count < capacity); i++) {
        out_sockets[count] = &runtime->link_sockets[i];
        count++;
    }
    return count;
}

void component_runtime_leave(component_runtime_t* const runtime)
{
    FSW_ASSERT(runtime != NULL);
    osal_socket_close(&runtime->link_sender);
    osal_socket_close(&runtime->topology);
}

// ---- Receiving ----

static status_t receive_sample(const component_runtime_t* const runtime, osal_socket_t* const socket,
                               uint8_t frame[LINK_FRAME_MAX], size_t* const out_size)
{
    osal_address_t from = {0U, 0U};
    uint64_t identity   = 0U;
    const bool is_tipc = ((runtime->run->link_methods & (uint8_t)(1U << (unsigned)RTLINK_METHOD_TIPC)) != 0U);
    return is_tipc ? osal_tipc_receive(socket, &identity, frame, LINK_FRAME_MAX, out_size)
                   : osal_udp_receive(socket, &from, frame, LINK_FRAME_MAX, out_size);
}

/// Receive the datagrams of the message socket. Returns the number of those that were sent to this life.
static uint32_t sweep_messages(component_runtime_t* const runtime)
{
    uint32_t taken = 0U;
    for (unsigned i = 0U; (i < SWEEP_MAX) && osal_socket_is_open(&runtime->message_socket); i++) {
        const status_t status = is_by_tipc(runtime)
                                    ? message_tipc_carrier_pump(&runtime->tipc, &runtime->endpoint)
                                    : message_udp_carrier_pump(&runtime->udp, &runtime->endpoint);
        if ((status != STATUS_OK) && (status != STATUS_NOT_OURS)) {
            break;
        }
        taken += (status == STATUS_OK) ? 1U : 0U;
    }
    return taken;
}

/// Receive the datagrams of a link that the component consumes. Returns a number as sweep_messages does.
static uint32_t sweep_link(component_runtime_t* const runtime, osal_socket_t* const socket,
                           void (*const link_datagram)(void* context, const uint8_t*, size_t),
                           void* const context)
{
    uint8_t frame[LINK_FRAME_MAX];
    uint32_t taken = 0U;
    size_t size    = 0U;
    for (unsigned i = 0U; (i < SWEEP_MAX) && (receive_sample(runtime, socket, frame, &size) == STATUS_OK);
         i++) {
        if (rtlink_frame_epoch(frame, size) > runtime->link_floor) {
            link_datagram(context, frame, size);
            taken++;
        }
    }
    return taken;
}

/// Read the sockets until they are empty. Returns the number of datagrams that may have been announced. An
/// unannounced datagram (an error or an attack) that waits there is counted as announced if it is read in an
/// intake with announced ones; then one of these may be read an intake later.
static uint32_t sweep(component_runtime_t* const runtime,
                      void (*const link_datagram)(void* context, const uint8_t*, size_t), void* const context)
{
    uint32_t taken = sweep_messages(runtime);
    for (size_t i = 0U; i < runtime->link_socket_count; i++) {
        const uint32_t frames = sweep_link(runtime, &runtime->link_sockets[i], link_datagram, context);
        taken += runtime->run->relay.is_network ? 0U : frames;
    }
    return taken;
}

/// Wait a short time for further datagrams.
static void wait_for_more(component_runtime_t* const runtime, const uint32_t timeout_ms)
{
    osal_socket_t* sockets[COMPONENT_RUNTIME_SOCKETS_MAX];
    const size_t count = component_runtime_sockets(runtime, sockets, COMPONENT_RUNTIME_SOCKETS_MAX);
    for (size_t i = 0U; i < count; i++) {
        const uint32_t share_ms = timeout_ms / (uint32_t)count;
        if (osal_socket_wait_readable(sockets[i], (share_ms > 0U) ? share_ms : 1U) == STATUS_OK) {
            return;
        }
    }
}

/// Returns the number of waits for announced datagrams. It is 0 in most intakes if no datagram has arrived
/// for a long time.
static unsigned tries_of(const component_runtime_t* const runtime)
{
    if (runtime->outstanding == 0U) {
        return PUMP_TRIES;
    }
    const bool is_long_cut = (runtime->short_intakes >= CUT_INTERVAL);
    return (!is_long_cut || ((runtime->short_intakes % CUT_INTERVAL) == 0U)) ? 1U : 0U;
}

/// Receive announced datagrams, and late ones of earlier announcements. If the connection is cut, simulated
/// time continues without the missing ones.
static void take_due(component_runtime_t* const runtime, const uint32_t due,
                     void (*const link_datagram)(void* context, const uint8_t*, size_t), void* const context)
{
    const bool is_cut = (runtime->outstanding > 0U);
    if ((due == 0U) && !is_cut && !runtime->run->relay.is_network && ((runtime->pumps % SWEEP_EVERY) != 0U)) {
        return; // Only unannounced datagrams can be there. A system call in each intake would cost more.
    }
    const unsigned tries      = tries_of(runtime);
    const uint32_t timeout_ms = is_cut ? CUT_TIMEOUT_MS : PUMP_TIMEOUT_MS;
    uint32_t taken            = sweep(runtime, link_datagram, context);
    for (unsigned attempt = 0U; (taken < due) && (attempt < tries); attempt++) {
        wait_for_more(runtime, timeout_ms);
        taken += sweep(runtime, link_datagram, context);
    }
    if (due > 0U) {
        runtime->short_intakes = (taken < due) ? (runtime->short_intakes + 1U) : 0U;
    }
    const uint32_t awaited =
        (due < (UINT32_MAX - runtime->outstanding)) ? (runtime->outstanding + due) : UINT32_MAX;
    runtime->outstanding = (taken < awaited) ? (awaited - taken) : 0U;
    if (!is_cut && (taken < due)) {
        __atomic_store_n(&runtime->run->is_lossy, 1U, __ATOMIC_RELAXED);
        osal_console_print_error("an announced datagram has not arrived; the run is not reproducible");
    }
}

void component_runtime_pump(component_runtime_t* const runtime, const uint32_t messages,
                            void (*const link_datagram)(void* context, const uint8_t*, size_t),
                            void* const context)
{
    FSW_ASSERT((runtime != NULL) && (link_datagram != NULL));
    read_lives(runtime);
    if (runtime->clock.mode == OSAL_CLOCK_REAL) {
        (void)sweep(runtime, link_datagram, context);
        return;
    }
    take_due(runtime, messages, link_datagram, context);
    runtime->pumps++;
    if (osal_socket_is_open(&runtime->topology) && ((runtime->pumps % HINTS_EVERY) == 0U)) {
        message_tipc_carrier_take_hints(&runtime->tipc, &runtime->endpoint);
    }
}

void component_runtime_keep(component_runtime_t* const runtime)
{
    FSW_ASSERT(runtime != NULL);
    runtime->is_kept = true;
}
