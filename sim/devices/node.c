// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/node.h"

#include "sim/devices/node_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_MS 1000000U
#define BOOT_STEP_NS 10000U // Delay for each node id, so that nodes do not all send at once.

#define NMT_ID 0x000U
#define HEARTBEAT_ID 0x700U
#define SDO_REQUEST_ID 0x600U
#define SDO_ANSWER_ID 0x580U
#define ALL_NODES 0U // Node id of an NMT command to all nodes.

#define NMT_START 1U
#define NMT_STOP 2U
#define NMT_ENTER_PRE_OPERATIONAL 128U
#define NMT_RESET_NODE 129U
#define NMT_RESET_COMMUNICATION 130U

#define REPORT_OVERFLOW 0x01U // data[1] of a controller's error frame: the receiver was full.

#define COMMUNICATION_FIRST 0x1000U
#define COMMUNICATION_LAST 0x1FFFU

// 0x1029:01, what a communication error does to the NMT state.
#define BEHAVIOUR_PRE_OPERATIONAL 0U
#define BEHAVIOUR_STOP 2U

void node_wake_by(node_t* const node, const uint64_t time_ns)
{
    if (time_ns < node->wake_ns) {
        node->wake_ns = time_ns;
        bus_set_wake(node->bus, node->bus_index, time_ns);
    }
}

void node_send(node_t* const node, const uint32_t id, const uint8_t* const data, const uint8_t length,
               const uint64_t time_ns)
{
    osal_can_frame_t frame = {.id = id, .length = length};
    memcpy(frame.data, data, length);
    (void)bus_submit(node->bus, node->bus_index, &frame, time_ns);
}

// ---- Emergencies ----

static void send_emergency(node_t* const node, const uint8_t message[EMERGENCY_OCTETS], const uint64_t now_ns)
{
    const uint64_t cob  = node->emergency_cob->value;
    const bool may_send = (node->state == NODE_OPERATIONAL) || (node->state == NODE_PRE_OPERATIONAL);
    if (may_send && ((cob & PDO_INVALID) == 0U)) {
        node_send(node, (uint32_t)cob & OSAL_CAN_ID_MASK, message, EMERGENCY_OCTETS, now_ns);
    }
}

void node_raise(node_t* const node, const uint16_t code, const uint8_t axis, const int32_t raw,
                const uint64_t now_ns)
{
    uint8_t message[EMERGENCY_OCTETS];
    if (emergency_raise(&node->emergencies, code, axis, raw, message)) {
        send_emergency(node, message, now_ns);
    }
}

void node_clear(node_t* const node, const uint16_t code, const uint8_t axis, const uint64_t now_ns)
{
    uint8_t message[EMERGENCY_OCTETS];
    if (emergency_clear(&node->emergencies, code, axis, message)) {
        send_emergency(node, message, now_ns);
    }
}

bool node_has_error(const node_t* const node, const uint16_t code, const uint8_t axis)
{
    return emergency_is_present(&node->emergencies, code, axis);
}

// ---- NMT ----

static void set_state(node_t* const node, const node_state_t state, const uint64_t now_ns)
{
    const node_state_t before = node->state;
    if (before == state) {
        return;
    }
    node->state = state;
    if (state == NODE_OPERATIONAL) {
        node_start_pdos(node, now_ns);
    } else if (before == NODE_OPERATIONAL) {
        node_stop_pdos(node);
        node->application.connection_lost(node->application.context, now_ns);
    }
}

/// Reset the values of the range to those of the EDS; the node sends nothing until boot-up.
static void reset(node_t* const node, const uint16_t first, const uint16_t last, const uint64_t delay_ns)
{
    const uint64_t now_ns = bus_now_ns(node->bus);
    node->state           = NODE_INITIALISING;
    node->toggle_ns       = BUS_NEVER;
    dictionary_reset_range(&node->dictionary, first, last);
    emergencies_reset(&node->emergencies);
    node_stop_pdos(node);
    node_configure_pdos(node);
    sdo_server_reset(&node->sdo);
    node->has_answer   = false;
    node->heartbeat_ns = BUS_NEVER;
    for (unsigned i = 0U; i < NODE_CONSUMERS_MAX; i++) {
        node->consumer[i].deadline_ns = BUS_NEVER;
    }
    node->boot_ns = now_ns + delay_ns;
    node_wake_by(node, node->boot_ns);
}

/// NMT reset of the node: reset all objects except Bdefault, which only power-on resets.
static void reset_by_master(node_t* const node)
{
    const int64_t channel = (node->default_channel != NULL) ? (int64_t)node->default_channel->value : 0;
    reset(node, 0U, UINT16_MAX, NODE_BOOT_NS);
    if (node->default_channel != NULL) {
        object_set(node->default_channel, channel);
    }
}

static void boot(node_t* const node, const uint64_t now_ns)
{
    node->boot_ns = BUS_NEVER;
    node_select_default_channel(node, now_ns);
    const uint8_t message[] = {NODE_INITIALISING};
    node_send(node, HEARTBEAT_ID + node->id, message, 1U, now_ns);
    node->state           = NODE_PRE_OPERATIONAL;
    const uint64_t period = node->producer_time->value * NS_PER_MS;
    node->heartbeat_ns    = (period != 0U) ? (now_ns + period) : BUS_NEVER;
}

static void take_nmt(node_t* const node, const osal_can_frame_t* const frame)
{
    const uint64_t now_ns = frame->time_ns;
    if ((frame->length != 2U) || ((frame->data[1] != ALL_NODES) && (frame->data[1] != node->id))) {
        return;
    }
    switch (frame->data[0]) {
    case NMT_START:
        set_state(node, NODE_OPERATIONAL, now_ns);
        break;
    case NMT_STOP:
        set_state(node, NODE_STOPPED, now_ns);
        break;
    case NMT_ENTER_PRE_OPERATIONAL:
        set_state(node, NODE_PRE_OPERATIONAL, now_ns);
        break;
    case NMT_RESET_NODE:
        reset_by_master(node);
        node->application.reset(node->application.context, now_ns);
        break;
    case NMT_RESET_COMMUNICATION:
        node->application.connection_lost(node->application.context, now_ns);
        reset(node, COMMUNICATION_FIRST, COMMUNICATION_LAST, NODE_BOOT_NS);
        break;
    default:
        break;
    }
}

// ---- SDO ----

static uint32_t check_sync_counter(const node_t* const node, const int64_t value)
{
    const object_t* period = dictionary_find(&node->dictionary, 0x1006U, 0U);
    if ((period != NULL) && (period->value != 0U)) {
        return SDO_ABORT_STATE;
    }
    return (value == 1) ? SDO_ABORT_VALUE : 0U;
}

static uint32_t check_write(void* const context, const object_t* const object, const int64_t value)
{
    const node_t* node = context;
    for (unsigned i = 0U; i < node->receive_count; i++) {
        if (pdo_owns(&node->receive[i], object)) {
            return pdo_check(&node->receive[i], &node->dictionary, object, value);
        }
    }
    for (unsigned i = 0U; i < node->transmit_count; i++) {
        if (pdo_owns(&node->transmit[i], object)) {
            return pdo_check(&node->transmit[i], &node->dictionary, object, value);
        }
    }
    if (object == node->sync_counter) {
        return check_sync_counter(node, value);
    }
    if ((object->index == 0x1003U) && (value != 0)) {
        return SDO_ABORT_VALUE; // A client may only clear the history.
    }
    return (node->application.check != NULL)
               ? node->application.check(node->application.context, object, value)
               : 0U;
}

static void note_written(void* const context, object_t* const object)
{
    node_t* node          = context;
    const uint64_t now_ns = node->request_ns;
    if ((object->index >= COMMUNICATION_FIRST) && (object->index <= COMMUNICATION_LAST)) {
        node_configure_pdos(node);
    }
    if (object == node->producer_time) {
        node->heartbeat_ns = (object->value != 0U) ? (now_ns + (object->value * NS_PER_MS)) : BUS_NEVER;
        node_wake_by(node, node->heartbeat_ns);
    }
    for (unsigned i = 0U; i < NODE_CONSUMERS_MAX; i++) {
        if (object == node->consumer[i].entry) {
            node->consumer[i].deadline_ns = BUS_NEVER;
        }
    }
    if (object->index == 0x1003U) {
        dictionary_reset_range(&node->dictionary, 0x1003U, 0x1003U);
    }
    node->application.written(node->application.context, object, now_ns);
}

static void note_read(void* const context, object_t* const object)
{
    const node_t* node = context;
    if (object->index > COMMUNICATION_LAST) {
        node->application.sample(node->application.context, node->request_ns);
    }
}

static void take_sdo(node_t* const node, const osal_can_frame_t* const frame)
{
    const sdo_access_t access = {
        .check = check_write, .written = note_written, .read = note_read, .context = node};
    if (frame->length != SDO_OCTETS) {
        return;
    }
    node->request_ns = frame->time_ns;
    node->has_answer = sdo_server_request(&node->sdo, &node->dictionary, &access, frame->data, node->answer);
    if (node->has_answer) {
        node->answer_ns = frame->time_ns + NODE_ANSWER_NS;
        node_wake_by(node, node->answer_ns);
    }
}

// ---- Heartbeat ----

static void take_heartbeat(node_t* const node, const osal_can_frame_t* const frame)
{
    const uint32_t sender = frame->id - HEARTBEAT_ID;
    for (unsigned i = 0U; i < NODE_CONSUMERS_MAX; i++) {
        heartbeat_consumer_t* consumer = &node->consumer[i];
        if (consumer->entry == NULL) {
            continue;
        }
        const uint64_t period_ns = (consumer->entry->value & 0xFFFFU) * NS_PER_MS;
        if ((((consumer->entry->value >> 16) & 0x7FU) == sender) && (period_ns != 0U)) {
            consumer->deadline_ns = frame->time_ns + period_ns;
            node_wake_by(node, consumer->deadline_ns);
            if (i == 0U) {
                node_master_heard(node);
            }
            node_clear(node, EMERGENCY_HEARTBEAT, 0U, frame->time_ns);
        }
    }
}

static void lose_heartbeat(node_t* const node, const heartbeat_consumer_t* const consumer,
                           const uint64_t now_ns)
{
    const uint32_t sender = (uint32_t)(consumer->entry->value >> 16) & 0x7FU;
    node_raise(node, EMERGENCY_HEARTBEAT, 0U, (int32_t)sender, now_ns);
    node->application.connection_lost(node->application.context, now_ns);
    const uint64_t behaviour = (node->error_behaviour != NULL) ? node->error_behaviour->value : 1U;
    if ((behaviour == BEHAVIOUR_PRE_OPERATIONAL) && (node->state == NODE_OPERATIONAL)) {
        set_state(node, NODE_PRE_OPERATIONAL, now_ns);
    } else if (behaviour == BEHAVIOUR_STOP) {
        set_state(node, NODE_STOPPED, now_ns);
    }
}

static uint64_t run_heartbeats(node_t* const node, const uint64_t now_ns)
{
    if (node->heartbeat_ns <= now_ns) {
        const uint8_t message[] = {(uint8_t)node->state};
        node_send(node, HEARTBEAT_ID + node->id, message, 1U, now_ns);
        node->heartbeat_ns += node->producer_time->value * NS_PER_MS;
    }
    uint64_t next_ns = node->heartbeat_ns;
    for (unsigned i = 0U; i < NODE_CONSUMERS_MAX; i++) {
        heartbeat_consumer_t* consumer = &node->consumer[i];
        if (consumer->deadline_ns <= now_ns) {
            consumer->deadline_ns = BUS_NEVER;
            lose_heartbeat(node, consumer, now_ns);
            if (i == 0U) {
                node_master_lost(node, now_ns);
            }
        }
        next_ns = (consumer->deadline_ns < next_ns) ? consumer->deadline_ns : next_ns;
    }
    return next_ns;
}

// ---- Power and connection to the bus ----

static void on_frame(void* const context, const osal_can_frame_t* const frame)
{
    node_t* node = context;
    if (((frame->id & (OSAL_CAN_EXTENDED | OSAL_CAN_REMOTE)) != 0U) || (node->state == NODE_INITIALISING)) {
        return;
    }
    if (frame->id == node->sync_id) {
        node_take_sync(node, frame);
    } else if (frame->id == NMT_ID) {
        take_nmt(node, frame);
    } else if (frame->id == (SDO_REQUEST_ID + node->id)) {
        if (node->state != NODE_STOPPED) {
            take_sdo(node, frame);
        }
    } else if ((frame->id > HEARTBEAT_ID) && (frame->id <= (HEARTBEAT_ID + 127U))) {
        take_heartbeat(node, frame);
    } else {
        (void)node_take_pdo(node, frame);
    }
}

/// The device's own controller reports an error, or the end of one.
static void on_error(void* const context, const osal_can_frame_t* const frame)
{
    node_t* node            = context;
    const controller_t* can = bus_controller(node->bus, node->bus_index);
    if (((frame->id & OSAL_CAN_ERROR_CONTROLLER) != 0U) && ((frame->data[1] & REPORT_OVERFLOW) != 0U)) {
        node_raise(node, EMERGENCY_OVERRUN, 0U, 0, frame->time_ns);
        node_clear(node, EMERGENCY_OVERRUN, 0U, frame->time_ns);
    } else if ((frame->id & OSAL_CAN_ERROR_RESTARTED) != 0U) {
        node_raise(node, EMERGENCY_RECOVERED, 0U, 0, frame->time_ns);
        node_clear(node, EMERGENCY_RECOVERED, 0U, frame->time_ns);
    } else if (can->state == CONTROLLER_STATE_BUS_OFF) {
        node->application.connection_lost(node->application.context, frame->time_ns);
    } else if (can->state == CONTROLLER_STATE_PASSIVE) {
        node_raise(node, EMERGENCY_ERROR_PASSIVE, 0U, (int32_t)can->transmit_errors, frame->time_ns);
    } else if (can->state == CONTROLLER_STATE_ACTIVE) {
        node_clear(node, EMERGENCY_ERROR_PASSIVE, 0U, frame->time_ns);
    }
}

static void on_wake(void* const context, const uint64_t now_ns)
{
    node_t* node  = context;
    node->wake_ns = BUS_NEVER;
    if (node->boot_ns <= now_ns) {
        boot(node, now_ns);
    }
    if (node->has_answer && (node->answer_ns <= now_ns)) {
        node->has_answer = false;
        node_send(node, SDO_ANSWER_ID + node->id, node->answer, SDO_OCTETS, now_ns);
    }
    const uint64_t search_ns     = node_run_search(node, now_ns);
    const uint64_t heartbeats_ns = run_heartbeats(node, now_ns);
    node_wake_by(node, search_ns);
    node_wake_by(node, node->toggle_ns);
    node_wake_by(node, node_run_pdo_timers(node, now_ns));
    node_wake_by(node, heartbeats_ns);
    node_wake_by(node, node->boot_ns);
    if (node->has_answer) {
        node_wake_by(node, node->answer_ns);
    }
}

static bool find_objects(node_t* const node)
{
    const dictionary_t* dictionary = &node->dictionary;
    node->sync_cob                 = dictionary_find(dictionary, 0x1005U, 0U);
    node->sync_counter             = dictionary_find(dictionary, 0x1019U, 0U);
    node->emergency_cob            = dictionary_find(dictionary, 0x1014U, 0U);
    node->producer_time            = dictionary_find(dictionary, 0x1017U, 0U);
    node->error_behaviour          = dictionary_find(dictionary, 0x1029U, 1U);
    for (uint8_t i = 0U; i < NODE_CONSUMERS_MAX; i++) {
        node->consumer[i].entry = dictionary_find(dictionary, 0x1016U, (uint8_t)(i + 1U));
    }
    node_find_channels(node);
    emergencies_init(&node->emergencies, dictionary);
    return (node->sync_cob != NULL) && (node->emergency_cob != NULL) && (node->producer_time != NULL) &&
           (node->emergencies.error_register != NULL) && node_find_pdos(node);
}

static bus_callbacks_t callbacks_of(node_t* const node)
{
    return (bus_callbacks_t){.on_frame = on_frame, .on_error = on_error, .on_wake = on_wake, .context = node};
}

/// Refuse a device whose data sheet maps an object that the device cannot transfer.
static status_t check_mappings(const node_t* const node, const char* const eds_path,
                               char error[EDS_ERROR_MAX])
{
    for (unsigned i = 0U; i < (node->receive_count + node->transmit_count); i++) {
        const pdo_t* pdo =
            (i < node->receive_count) ? &node->receive[i] : &node->transmit[i - node->receive_count];
        const uint8_t entry = pdo_unusable_entry(pdo);
        if (entry != 0U) {
            const unsigned first = (pdo->direction == PDO_RECEIVE) ? 0x1600U : 0x1A00U;
            (void)snprintf(
                error, EDS_ERROR_MAX,
                "%s: %04X:%02X maps an object that a simulated device cannot transfer, expected at most 8 "
                "octets of objects with PDOMapping=1, their length, and 8, 16, 32 or 64 bits",
                eds_path, first + pdo->number, entry);
            return STATUS_INVALID;
        }
    }
    return STATUS_OK;
}

static status_t connect_node(node_t* const node, const char* const eds_path, char error[EDS_ERROR_MAX])
{
    const bus_callbacks_t callbacks = callbacks_of(node);
    status_t status                 = eds_load(eds_path, node->id, &node->dictionary, error);
    if (status != STATUS_OK) {
        return status;
    }
    if (!find_objects(node)) {
        (void)snprintf(error, EDS_ERROR_MAX,
                       "%s: a device needs objects 1001, 1005, 1014, 1017 and at least one TPDO", eds_path);
        return STATUS_INVALID;
    }
    status = check_mappings(node, eds_path, error);
    if (status != STATUS_OK) {
        return status;
    }
    status = bus_add_node(node->bus, &callbacks, &node->bus_index);
    if (status != STATUS_OK) {
        (void)snprintf(error, EDS_ERROR_MAX,
                       "%s: no room for this node on its bus: expected at most %u controllers; remove a "
                       "device from the world",
                       eds_path, BUS_NODES_MAX);
    }
    node->channel[NODE_CHANNEL_A] = (node_channel_t){.bus = node->bus, .index = node->bus_index};
    return status;
}

status_t node_add_channel(node_t* const node, bus_t* const bus)
{
    const bus_callbacks_t callbacks = callbacks_of(node);
    return node_connect_redundant(node, bus, &callbacks);
}

status_t node_create(bus_t* const bus, const char* const eds_path, const uint8_t id,
                     const node_application_t* const application, node_t** const out_node,
                     char error[EDS_ERROR_MAX])
{
    *out_node    = NULL;
    node_t* node = calloc(1U, sizeof *node);
    if (node == NULL) {
        (void)snprintf(error, EDS_ERROR_MAX, "%s: out of memory", eds_path);
        return STATUS_EXHAUSTED;
    }
    node->bus         = bus;
    node->id          = id;
    node->is_plugged  = true;
    node->is_powered  = true;
    node->application = *application;
    node->boot_ns     = BUS_NEVER;
    node->wake_ns     = BUS_NEVER;
    node->toggle_ns   = BUS_NEVER;
    *out_node         = node;
    status_t status   = connect_node(node, eds_path, error);
    if ((status == STATUS_OK) && (application->find != NULL) && !application->find(application->context)) {
        (void)snprintf(error, EDS_ERROR_MAX, "%s: an object that %s needs is missing, zero or without units",
                       eds_path, application->name);
        status = STATUS_INVALID;
    }
    if (status != STATUS_OK) {
        node_destroy(node);
        *out_node = NULL;
    }
    return status;
}

void node_destroy(node_t* const node)
{
    if (node != NULL) {
        dictionary_destroy(&node->dictionary);
        free(node);
    }
}

void node_power_on(node_t* const node)
{
    node_supply(node, true);
    reset(node, 0U, UINT16_MAX, NODE_BOOT_NS + ((uint64_t)node->id * BOOT_STEP_NS));
    node->application.reset(node->application.context, bus_now_ns(node->bus));
}

void node_power_off(node_t* const node)
{
    node_supply(node, false);
    reset(node, 0U, UINT16_MAX, 0U);
    node->boot_ns = BUS_NEVER;
    node->application.reset(node->application.context, bus_now_ns(node->bus));
}

bool node_is_powered(const node_t* const node)
{
    return node->is_powered;
}

void node_unplug(node_t* const node)
{
    node_connect(node, false);
}

void node_plug(node_t* const node)
{
    node_connect(node, true);
    if (node->is_powered) {
        node_power_on(node);
    }
}

bool node_is_plugged(const node_t* const node)
{
    return node->is_plugged;
}

object_t* node_object_named(const node_t* const node, const char* const name, const uint8_t subindex)
{
    const uint16_t index = dictionary_index_of(&node->dictionary, name);
    return (index != 0U) ? dictionary_find(&node->dictionary, index, subindex) : NULL;
}

object_t* node_object(const node_t* const node, const uint16_t index, const uint8_t subindex)
{
    return dictionary_find(&node->dictionary, index, subindex);
}

uint32_t node_syncs(const node_t* const node, uint64_t* const out_last_ns)
{
    *out_last_ns = node->last_sync_ns;
    return node->syncs;
}

uint8_t node_id(const node_t* const node)
{
    return node->id;
}

unsigned node_bus_index(const node_t* const node, const unsigned channel)
{
    return (node->channel[channel].bus != NULL) ? node->channel[channel].index : BUS_NODES_MAX;
}
