// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/master.h"

#include "base/assertion.h"

#include <stddef.h>

#define NO_NODE 0xFFU

void canopen_master_init(canopen_master_t* const master, const canopen_master_config_t* const config,
                         flow_can_t* const flow)
{
    FSW_ASSERT((master != NULL) && (config != NULL) && (flow != NULL));
    FSW_ASSERT((config->node_id >= 1U) && (config->node_id <= CANOPEN_NODE_MAX) &&
               (config->heartbeat_ns > 0U));
    *master = (canopen_master_t){.config = *config, .flow = flow};
}

void canopen_master_clear(canopen_master_t* const master)
{
    FSW_ASSERT(master != NULL);
    master->node_count        = 0U;
    master->route_count       = 0U;
    master->emergency_count   = 0U;
    master->is_sync_on        = false;
    master->is_sync_sent      = false;
    master->next_heartbeat_ns = 0U;
}

void canopen_master_use_flow(canopen_master_t* const master, flow_can_t* const flow)
{
    FSW_ASSERT((master != NULL) && (flow != NULL));
    master->flow              = flow;
    master->next_heartbeat_ns = 0U;
}

static uint8_t index_of(const canopen_master_t* const master, const uint8_t id)
{
    for (uint8_t i = 0U; i < master->node_count; i++) {
        if (master->nodes[i].id == id) {
            return i;
        }
    }
    return NO_NODE;
}

status_t canopen_master_add_node(canopen_master_t* const master, const uint8_t id, uint8_t* const out_index)
{
    FSW_ASSERT((master != NULL) && (out_index != NULL));
    if ((id < 1U) || (id > CANOPEN_NODE_MAX) || (id == master->config.node_id)) {
        return STATUS_INVALID;
    }
    if (index_of(master, id) != NO_NODE) {
        return STATUS_EXISTS;
    }
    if (master->node_count == MASTER_NODES_MAX) {
        return STATUS_EXHAUSTED;
    }
    canopen_master_node_t* const node = &master->nodes[master->node_count];
    *node                             = (canopen_master_node_t){.id = id};
    canopen_sdo_client_init(&node->sdo, master->config.sdo_timeout_ns);
    *out_index = master->node_count;
    master->node_count++;
    return STATUS_OK;
}

static uint8_t route_of(const canopen_master_t* const master, const uint16_t cob)
{
    uint8_t route = 0U;
    while ((route < master->route_count) && (master->routes[route].cob != cob)) {
        route++;
    }
    return route;
}

status_t canopen_master_route(canopen_master_t* const master, const uint16_t cob,
                              const canopen_master_taker_t take, void* const context)
{
    FSW_ASSERT((master != NULL) && (take != NULL));
    if (route_of(master, cob) < master->route_count) {
        return STATUS_EXISTS;
    }
    if (master->route_count == MASTER_ROUTES_MAX) {
        return STATUS_EXHAUSTED;
    }
    master->routes[master->route_count] =
        (canopen_master_route_t){.cob = cob, .take = take, .context = context};
    master->route_count++;
    return STATUS_OK;
}

void canopen_master_unroute(canopen_master_t* const master, const uint16_t cob)
{
    FSW_ASSERT(master != NULL);
    const uint8_t route = route_of(master, cob);
    if (route < master->route_count) {
        master->route_count--;
        master->routes[route] = master->routes[master->route_count];
    }
}

static void take_emergency(canopen_master_t* const master, const uint8_t node,
                           const osal_can_frame_t* const frame)
{
    if (frame->length != EMERGENCY_OCTETS) {
        master->counters.malformed++;
    } else if (master->emergency_count == MASTER_EMERGENCIES_MAX) {
        master->counters.emergencies_lost++;
    } else {
        const unsigned position =
            (master->emergency_first + (unsigned)master->emergency_count) % MASTER_EMERGENCIES_MAX;
        master->emergencies[position] = canopen_emergency_decode(node, frame->data);
        master->emergency_count++;
        master->counters.emergencies++;
    }
}

static void take_heartbeat(canopen_master_t* const master, canopen_master_node_t* const node,
                           const osal_can_frame_t* const frame, const uint64_t now_ns)
{
    const uint8_t state = frame->data[0] & 0x7FU;
    const bool is_known = (state == NMT_STATE_BOOT_UP) || (state == NMT_STATE_STOPPED) ||
                          (state == NMT_STATE_OPERATIONAL) || (state == NMT_STATE_PRE_OPERATIONAL);
    if ((frame->length != 1U) || !is_known) {
        master->counters.malformed++;
        return;
    }
    if (state == NMT_STATE_BOOT_UP) {
        node->boots++;
        // A node that has rebooted does not answer a request that it received before.
        canopen_sdo_client_reset(&node->sdo);
    }
    node->has_heartbeat = true;
    node->heard_ns      = now_ns;
}

static void take_frame(canopen_master_t* const master, const osal_can_frame_t* const frame,
                       const uint64_t now_ns)
{
    if ((frame->id & OSAL_CAN_REMOTE) != 0U) {
        master->counters.remote++;
        return;
    }
    const uint16_t cob  = (uint16_t)(frame->id & 0x7FFU); // flow_can receives no extended frames.
    const uint8_t route = route_of(master, cob);
    if (route < master->route_count) {
        master->routes[route].take(master->routes[route].context, cob, frame->data, frame->length);
        return;
    }
    if (cob == COB_SYNC) {
        master->counters.conflicting_syncs++; // The controller does not receive its own frames.
        return;
    }
    const uint8_t id    = (uint8_t)(cob & COB_NODE_MASK);
    const uint8_t index = index_of(master, id);
    if (index == NO_NODE) {
        master->counters.unknown++;
        return;
    }
    switch (cob & COB_FUNCTION_MASK) {
    case COB_EMERGENCY:
        take_emergency(master, id, frame);
        break;
    case COB_HEARTBEAT:
        take_heartbeat(master, &master->nodes[index], frame, now_ns);
        break;
    case COB_SDO_ANSWER:
        canopen_sdo_client_answer(&master->nodes[index].sdo, frame->data, frame->length);
        break;
    default:
        master->counters.unknown++;
        break;
    }
}

void canopen_master_receive(canopen_master_t* const master, const uint64_t now_ns)
{
    FSW_ASSERT(master != NULL);
    osal_can_frame_t frame;
    for (unsigned i = 0U; i < MASTER_FRAMES_PER_CYCLE; i++) {
        if (flow_can_receive(master->flow, &frame) != STATUS_OK) {
            break;
        }
        take_frame(master, &frame, now_ns);
    }
    for (uint8_t i = 0U; i < master->node_count; i++) {
        canopen_master_node_t* const node = &master->nodes[i];
        const uint64_t age_ns             = now_ns - node->heard_ns;
        node->is_heartbeat_lost = node->has_heartbeat && (age_ns > master->config.heartbeat_timeout_ns);
    }
}

static status_t send(canopen_master_t* const master, const uint16_t cob, const uint8_t* const octets,
                     const uint8_t length)
{
    const status_t status = flow_can_send(master->flow, cob, octets, length);
    if (status != STATUS_OK) {
        master->counters.refused++;
    }
    return status;
}

status_t canopen_master_command(canopen_master_t* const master, const uint8_t id,
                                const canopen_nmt_command_t command)
{
    FSW_ASSERT(master != NULL);
    const uint8_t octets[2] = {(uint8_t)command, id};
    const status_t status   = send(master, COB_NMT, octets, sizeof octets);
    const bool is_reset     = (status == STATUS_OK) && (command == NMT_RESET_NODE);
    for (uint8_t i = 0U; is_reset && (i < master->node_count); i++) {
        if ((id == 0U) || (id == master->nodes[i].id)) {
            master->nodes[i].has_heartbeat = false;
            canopen_sdo_client_reset(&master->nodes[i].sdo);
        }
    }
    return status;
}

status_t canopen_master_send_process_data(canopen_master_t* const master, const uint16_t cob,
                                          const uint8_t* const octets, const uint8_t length)
{
    FSW_ASSERT(master != NULL);
    if (master->flow->health.is_unacknowledged) {
        return STATUS_CLOSED;
    }
    const status_t status = flow_can_send_process_data(master->flow, cob, octets, length);
    if (status != STATUS_OK) {
        master->counters.refused++;
    }
    return status;
}

void canopen_master_set_sync(canopen_master_t* const master, const bool is_on)
{
    FSW_ASSERT(master != NULL);
    master->is_sync_on = is_on;
}

/// Send the next requests. Lower node ids win the arbitration: if all devices of a full bus had to answer at
/// the same time, those with the highest ids would exceed their time-out.
static void emit_requests(canopen_master_t* const master, const uint64_t now_ns)
{
    uint8_t request[SDO_FRAME_OCTETS];
    uint8_t waiting = 0U;
    for (uint8_t i = 0U; i < master->node_count; i++) {
        waiting = (uint8_t)(waiting + (canopen_sdo_client_is_waiting(&master->nodes[i].sdo) ? 1U : 0U));
    }
    for (uint8_t i = 0U; i < master->node_count; i++) {
        canopen_sdo_client_t* const sdo = &master->nodes[i].sdo;
        const bool was_waiting          = canopen_sdo_client_is_waiting(sdo);
        if (!was_waiting && (waiting >= MASTER_REQUESTS_MAX)) {
            continue; // Its time-out begins when the request is sent.
        }
        if (canopen_sdo_client_request(sdo, now_ns, request)) {
            (void)send(master, (uint16_t)(COB_SDO_REQUEST + master->nodes[i].id), request, SDO_FRAME_OCTETS);
        }
        const bool is_new = !was_waiting && canopen_sdo_client_is_waiting(sdo);
        waiting           = (uint8_t)(waiting + (is_new ? 1U : 0U));
    }
}

static bool can_send(const canopen_master_t* const master)
{
    return flow_can_is_open(master->flow) && !master->flow->health.is_unacknowledged;
}

static void emit_sync(canopen_master_t* const master)
{
    if (master->is_sync_on && (send(master, COB_SYNC, NULL, 0U) == STATUS_OK)) {
        master->sync_count++;
    }
}

void canopen_master_send_sync(canopen_master_t* const master)
{
    FSW_ASSERT(master != NULL);
    master->is_sync_sent = true;
    if (can_send(master)) {
        emit_sync(master);
    }
}

void canopen_master_emit(canopen_master_t* const master, const uint64_t now_ns)
{
    FSW_ASSERT(master != NULL);
    const bool is_sync_due = !master->is_sync_sent;
    master->is_sync_sent   = false;
    if (!can_send(master)) {
        return;
    }
    emit_requests(master, now_ns);
    if (now_ns >= master->next_heartbeat_ns) {
        const uint8_t state = NMT_STATE_OPERATIONAL;
        (void)send(master, (uint16_t)(COB_HEARTBEAT + master->config.node_id), &state, 1U);
        master->next_heartbeat_ns = now_ns + master->config.heartbeat_ns;
    }
    if (is_sync_due) {
        emit_sync(master);
    }
}

status_t canopen_master_take_emergency(canopen_master_t* const master,
                                       canopen_emergency_t* const out_emergency)
{
    FSW_ASSERT((master != NULL) && (out_emergency != NULL));
    if (master->emergency_count == 0U) {
        return STATUS_EMPTY;
    }
    *out_emergency          = master->emergencies[master->emergency_first];
    master->emergency_first = (uint8_t)((master->emergency_first + 1U) % MASTER_EMERGENCIES_MAX);
    master->emergency_count--;
    return STATUS_OK;
}
