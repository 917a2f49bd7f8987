// SPDX-License-Identifier: Apache-2.0
#include "test/support/scripted_bus.h"

#include "osal/include/osal/process.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void must(const status_t status, const char* const what)
{
    if (status != STATUS_OK) {
        (void)fprintf(stderr, "scripted bus: %s: %s\n", what, status_text(status));
        abort();
    }
}

void scripted_bus_open(scripted_bus_t* const bus, const char* const name)
{
    memset(bus, 0, sizeof *bus);
    (void)snprintf(bus->address, sizeof bus->address, "shm:%s-%ld", name, (long)osal_process_own_id());
    (void)osal_can_destroy(bus->address); // May be left from a run that was killed.
    must(osal_can_create(bus->address), "create");
    must(osal_can_open(&bus->wire, bus->address, OSAL_CAN_WIRE), "open");
}

void scripted_bus_close(scripted_bus_t* const bus)
{
    osal_can_close(&bus->wire);
    (void)osal_can_destroy(bus->address);
}

scripted_object_t* scripted_object(scripted_node_t* const node, const uint16_t index, const uint8_t subindex)
{
    for (unsigned i = 0U; i < node->object_count; i++) {
        if ((node->objects[i].index == index) && (node->objects[i].subindex == subindex)) {
            return &node->objects[i];
        }
    }
    if (node->object_count == SCRIPTED_OBJECTS) {
        must(STATUS_EXHAUSTED, "objects");
    }
    scripted_object_t* const object = &node->objects[node->object_count++];
    *object                         = (scripted_object_t){.index = index, .subindex = subindex, .octets = 4U};
    return object;
}

static void give(scripted_node_t* const node, const uint16_t index, const uint8_t subindex,
                 const uint8_t octets, const uint32_t value)
{
    scripted_object_t* const object = scripted_object(node, index, subindex);
    object->octets                  = octets;
    object->value                   = value;
}

/// Set the mapping of one PDO; 0 ends the entries.
static void map(scripted_node_t* const node, const uint16_t index, const uint32_t* const entries)
{
    uint8_t count = 0U;
    while (entries[count] != 0U) {
        give(node, index, (uint8_t)(count + 1U), 4U, entries[count]);
        count++;
    }
    give(node, index, 0U, 1U, count);
}

static void give_drive(scripted_node_t* const node)
{
    static const uint32_t status[]   = {0x60410010U, 0x60640020U, 0x60770010U, 0U};
    static const uint32_t extra[]    = {0x606C0020U, 0x60780010U, 0x22100010U, 0U};
    static const uint32_t position[] = {0x60400010U, 0x607A0020U, 0x60B20010U, 0U};
    static const uint32_t torque[]   = {0x60400010U, 0x60710010U, 0x60FF0020U, 0U};
    give(node, 0x1000U, 0U, 4U, 0x00020192U);
    give(node, 0x1018U, 2U, 4U, 0x00004010U);
    give(node, 0x6076U, 0U, 4U, 10000U);
    give(node, 0x6072U, 0U, 2U, 4000U);
    give(node, 0x60A8U, 0U, 4U, 0xFA100000U);
    give(node, 0x60A9U, 0U, 4U, 0xFA100300U);
    map(node, 0x1A00U, status);
    map(node, 0x1A01U, extra);
    map(node, 0x1600U, position);
    map(node, 0x1601U, torque);
}

static void give_joystick(scripted_node_t* const node)
{
    static const uint32_t position[] = {0x60640020U, 0x68640020U, 0U};
    static const uint32_t status[]   = {0x60410010U, 0x68410010U, 0x60FD0020U, 0U};
    static const uint32_t command[]  = {0x60710010U, 0x68710010U, 0x60400010U, 0x68400010U, 0U};
    give(node, 0x1000U, 0U, 4U, 0xFFFF0192U);
    give(node, 0x1018U, 2U, 4U, 0x00002015U);
    give(node, 0x6076U, 0U, 4U, 100U);
    give(node, 0x6072U, 0U, 2U, 15000U);
    give(node, 0x6876U, 0U, 4U, 100U);
    give(node, 0x6872U, 0U, 2U, 15000U);
    for (uint16_t axis = 0U; axis < 2U; axis++) {
        give(node, (uint16_t)(0x60A8U + (axis * 0x800U)), 0U, 4U, 0xFA100000U);
        give(node, (uint16_t)(0x60A9U + (axis * 0x800U)), 0U, 4U, 0xFA100300U);
    }
    map(node, 0x1A00U, position);
    map(node, 0x1A01U, status);
    map(node, 0x1600U, command);
}

static void give_valves(scripted_node_t* const node)
{
    static const uint32_t inputs[]  = {0x60000108U, 0x60000208U, 0U};
    static const uint32_t outputs[] = {0x62000108U, 0x62000208U, 0x21000010U, 0U};
    give(node, 0x1000U, 0U, 4U, 0x00030191U);
    give(node, 0x1018U, 2U, 4U, 0x00004030U);
    map(node, 0x1A00U, inputs);
    map(node, 0x1600U, outputs);
}

static void give_gyro(scripted_node_t* const node)
{
    static const uint32_t first[]  = {0x91300120U, 0x91300220U, 0U};
    static const uint32_t second[] = {0x91300320U, 0x21030010U, 0x61500108U, 0U};
    give(node, 0x1000U, 0U, 4U, 0x00020194U);
    give(node, 0x1018U, 2U, 4U, 0x00002039U);
    map(node, 0x1A00U, first);
    map(node, 0x1A01U, second);
}

scripted_node_t* scripted_bus_add(scripted_bus_t* const bus, const scripted_kind_t kind, const uint8_t id)
{
    if (bus->node_count == SCRIPTED_NODES) {
        must(STATUS_EXHAUSTED, "nodes");
    }
    scripted_node_t* const node = &bus->nodes[bus->node_count++];
    memset(node, 0, sizeof *node);
    node->id         = id;
    node->kind       = kind;
    node->is_plugged = true;
    node->nmt        = 0x7FU;
    node->status[0]  = 0x0250U;
    node->status[1]  = 0x0250U;
    if (kind == SCRIPTED_DRIVE) {
        give_drive(node);
    } else if (kind == SCRIPTED_VALVES) {
        give_valves(node);
    } else if (kind == SCRIPTED_GYRO) {
        give_gyro(node);
    } else {
        give_joystick(node);
    }
    return node;
}

void scripted_bus_deliver(scripted_bus_t* const bus, const uint32_t id, const uint8_t* const octets,
                          const uint8_t length)
{
    osal_can_frame_t frame = {.id = id, .length = length};
    if (length > 0U) {
        memcpy(frame.data, octets, length);
    }
    must(osal_can_send(&bus->wire, &frame), "deliver");
}

void scripted_bus_emergency(scripted_bus_t* const bus, const uint8_t node, const uint16_t code)
{
    const uint8_t octets[8] = {(uint8_t)code, (uint8_t)(code >> 8), 0x01U};
    scripted_bus_deliver(bus, 0x080U + node, octets, sizeof octets);
}

void scripted_bus_error(scripted_bus_t* const bus, const uint32_t class, const uint8_t detail)
{
    const uint8_t octets[8] = {0U, detail, 0U, 0U, 0U, 0U, 96U, 0U};
    scripted_bus_deliver(bus, OSAL_CAN_ERROR | class, octets, sizeof octets);
}

unsigned scripted_bus_count(const scripted_bus_t* const bus, const uint32_t id)
{
    unsigned count = 0U;
    for (unsigned i = 0U; i < bus->seen_count; i++) {
        count += (bus->seen[i].id == id) ? 1U : 0U;
    }
    return count;
}

// ---- CiA 402 ----

typedef struct { // In state `from`, a controlword with `mask` bits equal to `value` leads to `to`.
    uint16_t from;
    uint16_t mask;
    uint16_t value;
    uint16_t to;
} transition_t;

static const transition_t transitions[] = {
    {0x40U, 0x87U, 0x06U, 0x21U}, {0x21U, 0x87U, 0x07U, 0x23U}, {0x21U, 0x82U, 0x00U, 0x40U},
    {0x21U, 0x86U, 0x02U, 0x40U}, {0x23U, 0x8FU, 0x0FU, 0x27U}, {0x23U, 0x87U, 0x06U, 0x21U},
    {0x23U, 0x82U, 0x00U, 0x40U}, {0x23U, 0x86U, 0x02U, 0x40U}, {0x27U, 0x8FU, 0x07U, 0x23U},
    {0x27U, 0x87U, 0x06U, 0x21U}, {0x27U, 0x82U, 0x00U, 0x40U}, {0x27U, 0x86U, 0x02U, 0x07U},
    {0x07U, 0x82U, 0x00U, 0x40U},
};

static void move(scripted_node_t* const node, const unsigned axis, const uint16_t control)
{
    const uint16_t before = node->control[axis];
    const uint16_t status = node->status[axis];
    node->control[axis]   = control;
    if (node->is_stuck) {
        return;
    }
    const bool is_fault = (status & 0x4FU) == 0x08U;
    const uint16_t rest = (uint16_t)(status & ~0x6FU);
    if (is_fault && ((control & 0x80U) != 0U) && ((before & 0x80U) == 0U)) {
        node->status[axis] = (uint16_t)(rest | 0x40U);
        return;
    }
    const bool is_disabled = (status & 0x4FU) == 0x40U;
    const uint16_t from    = is_disabled ? 0x40U : (uint16_t)(status & 0x6FU);
    for (unsigned i = 0U; i < (sizeof transitions / sizeof transitions[0]); i++) {
        const transition_t* const row = &transitions[i];
        if (!is_fault && (row->from == from) && ((control & row->mask) == row->value)) {
            node->status[axis] = (uint16_t)(rest | row->to);
            return;
        }
    }
}

// ---- CiA 301 ----

static void boot(scripted_bus_t* const bus, scripted_node_t* const node)
{
    const uint8_t zero = 0U;
    node->status[0]    = 0x0250U;
    node->status[1]    = 0x0250U;
    node->nmt          = 0x7FU;
    if (!node->is_boot_mute) {
        node->boots++;
        scripted_bus_deliver(bus, 0x700U + node->id, &zero, 1U);
    }
}

static void obey(scripted_bus_t* const bus, scripted_node_t* const node, const uint8_t command)
{
    switch (command) {
    case 0x01U:
        node->nmt = 0x05U;
        break;
    case 0x02U:
        node->nmt = 0x04U;
        break;
    case 0x80U:
        node->nmt = 0x7FU;
        break;
    default:
        boot(bus, node);
        break;
    }
}

static void serve(scripted_bus_t* const bus, scripted_node_t* const node, const uint8_t* const request)
{
    const uint16_t index            = (uint16_t)(request[1] | ((unsigned)request[2] << 8));
    scripted_object_t* const object = scripted_object(node, index, request[3]);
    uint8_t answer[8]               = {0U, request[1], request[2], request[3]};
    uint32_t value                  = object->value;
    if (object->abort_code != 0U) {
        answer[0] = 0x80U;
        value     = object->abort_code;
    } else if ((request[0] >> 5) == 1U) {
        answer[0]      = 0x60U;
        object->octets = (uint8_t)(4U - ((request[0] >> 2) & 3U));
        object->value  = 0U;
        for (unsigned i = 0U; i < object->octets; i++) {
            object->value |= (uint32_t)request[4U + i] << (8U * i);
        }
        value = 0U;
        node->writes++;
    } else if ((request[0] >> 5) == 2U) {
        answer[0] = (uint8_t)(0x43U | ((4U - object->octets) << 2));
    } else {
        return; // The client has aborted the transfer.
    }
    for (unsigned i = 0U; i < 4U; i++) {
        answer[4U + i] = (uint8_t)(value >> (8U * i));
    }
    scripted_bus_deliver(bus, 0x580U + node->id, answer, sizeof answer);
}

static uint16_t u16(const uint8_t* const octets)
{
    return (uint16_t)(octets[0] | ((unsigned)octets[1] << 8));
}

static uint32_t u32(const uint8_t* const octets)
{
    return (uint32_t)u16(octets) | ((uint32_t)u16(&octets[2]) << 16);
}

static void take_pdo(scripted_node_t* const node, const unsigned number, const uint8_t* const octets)
{
    node->pdos_received++;
    node->last_pdo = number;
    if (node->kind == SCRIPTED_VALVES) {
        memcpy(node->outputs, octets, sizeof node->outputs);
    } else if (node->kind == SCRIPTED_JOYSTICK) {
        node->target_torque[0] = (int16_t)u16(octets);
        node->target_torque[1] = (int16_t)u16(&octets[2]);
        move(node, 0U, u16(&octets[4]));
        move(node, 1U, u16(&octets[6]));
    } else if (number == 1U) {
        move(node, 0U, u16(octets));
        node->target_position = (int32_t)u32(&octets[2]);
        node->torque_offset   = (int16_t)u16(&octets[6]);
        give(node, 0x60B2U, 0U, 2U, u16(&octets[6]));
    } else {
        move(node, 0U, u16(octets));
        node->target_torque[0] = (int16_t)u16(&octets[2]);
        give(node, 0x6071U, 0U, 2U, u16(&octets[2]));
        give(node, 0x60FFU, 0U, 4U, u32(&octets[4]));
    }
}

static void put(uint8_t* const octets, const uint32_t value, const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        octets[i] = (uint8_t)(value >> (8U * i));
    }
}

static void answer_sync(scripted_bus_t* const bus, const scripted_node_t* const node)
{
    uint8_t octets[8] = {0U};
    if ((node->nmt != 0x05U) || node->is_pdo_mute) {
        return;
    }
    if (node->kind == SCRIPTED_DRIVE) {
        put(octets, node->status[0], 2U);
        put(&octets[2], (uint32_t)node->position[0], 4U);
        put(&octets[6], (uint16_t)node->torque[0], 2U);
        scripted_bus_deliver(bus, 0x180U + node->id, octets, sizeof octets);
    } else if (node->kind == SCRIPTED_VALVES) {
        scripted_bus_deliver(bus, 0x180U + node->id, node->outputs, 2U);
    } else if (node->kind == SCRIPTED_GYRO) {
        put(octets, (uint32_t)node->rate[0], 4U);
        put(&octets[4], (uint32_t)node->rate[1], 4U);
        scripted_bus_deliver(bus, 0x180U + node->id, octets, 8U);
        put(octets, (uint32_t)node->rate[2], 4U);
        put(&octets[4], 0U, 4U);
        scripted_bus_deliver(bus, 0x280U + node->id, octets, 7U);
    } else {
        put(octets, (uint32_t)node->position[0], 4U);
        put(&octets[4], (uint32_t)node->position[1], 4U);
        scripted_bus_deliver(bus, 0x180U + node->id, octets, sizeof octets);
        put(octets, node->status[0], 2U);
        put(&octets[2], node->status[1], 2U);
        put(&octets[4], 0x00010000U, 4U);
        scripted_bus_deliver(bus, 0x280U + node->id, octets, sizeof octets);
    }
}

static void answer(scripted_bus_t* const bus, const osal_can_frame_t* const frame)
{
    for (unsigned i = 0U; i < bus->node_count; i++) {
        scripted_node_t* const node = &bus->nodes[i];
        if (!node->is_plugged) {
            continue;
        }
        if ((frame->id == 0x000U) && ((frame->data[1] == 0U) || (frame->data[1] == node->id))) {
            obey(bus, node, frame->data[0]);
        } else if (frame->id == 0x080U) {
            answer_sync(bus, node);
        } else if ((frame->id == (0x600U + node->id)) && !node->is_sdo_mute) {
            serve(bus, node, frame->data);
        } else if ((frame->id == (0x200U + node->id)) && (node->nmt == 0x05U)) {
            take_pdo(node, 1U, frame->data);
        } else if ((frame->id == (0x300U + node->id)) && (node->nmt == 0x05U)) {
            take_pdo(node, 2U, frame->data);
        } else {
            // A request to another node.
        }
    }
}

void scripted_bus_run(scripted_bus_t* const bus)
{
    osal_can_frame_t frame;
    bool is_heard   = false;
    bus->seen_count = 0U;
    for (unsigned i = 0U; i < bus->node_count; i++) {
        is_heard = is_heard || bus->nodes[i].is_plugged;
    }
    while (osal_can_receive(&bus->wire, &frame) == STATUS_OK) {
        if (bus->seen_count < SCRIPTED_FRAMES) {
            bus->seen[bus->seen_count++] = frame;
        }
        bus->syncs += (frame.id == 0x080U) ? 1U : 0U;
        answer(bus, &frame);
    }
    if (!is_heard && (bus->seen_count > 0U)) {
        scripted_bus_error(bus, OSAL_CAN_ERROR_NO_ACK, 0U);
    }
}

void scripted_bus_heartbeat(scripted_bus_t* const bus)
{
    for (unsigned i = 0U; i < bus->node_count; i++) {
        if (bus->nodes[i].is_plugged) {
            scripted_bus_deliver(bus, 0x700U + bus->nodes[i].id, &bus->nodes[i].nmt, 1U);
        }
    }
}
