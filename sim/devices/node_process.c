// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/node_internal.h"

#include <string.h>

bool node_find_pdos(node_t* const node)
{
    while ((node->receive_count < NODE_PDOS_MAX) &&
           pdo_init(&node->receive[node->receive_count], PDO_RECEIVE, (uint16_t)node->receive_count,
                    &node->dictionary)) {
        node->receive_count++;
    }
    while ((node->transmit_count < NODE_PDOS_MAX) &&
           pdo_init(&node->transmit[node->transmit_count], PDO_TRANSMIT, (uint16_t)node->transmit_count,
                    &node->dictionary)) {
        node->transmit_count++;
    }
    return node->transmit_count != 0U; // A device that only measures has no RPDO.
}

void node_configure_pdos(node_t* const node)
{
    for (unsigned i = 0U; i < node->receive_count; i++) {
        pdo_configure(&node->receive[i], &node->dictionary);
    }
    for (unsigned i = 0U; i < node->transmit_count; i++) {
        pdo_configure(&node->transmit[i], &node->dictionary);
    }
    node->sync_id = (uint32_t)node->sync_cob->value & OSAL_CAN_ID_MASK;
}

static void send_pdo(node_t* const node, pdo_t* const pdo, const uint64_t now_ns)
{
    pdo->sync_count = 0U;
    if (pdo->event_ns != 0U) {
        pdo->deadline_ns = now_ns + pdo->event_ns;
        node_wake_by(node, pdo->deadline_ns);
    }
    osal_can_frame_t frame;
    frame.id          = pdo->cob_id;
    frame.length      = pdo->octets;
    frame.flags       = bus_is_fd(node->bus) ? (OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS) : 0U;
    frame.reserved[0] = 0U;
    frame.reserved[1] = 0U;
    memcpy(frame.data, pdo->data, PDO_OCTETS_MAX);
    (void)bus_submit(node->bus, node->bus_index, &frame, now_ns + NODE_PROCESSING_NS);
}

void node_start_pdos(node_t* const node, const uint64_t now_ns)
{
    node->syncs        = 0U;
    node->last_sync_ns = now_ns;
    node->application.sample(node->application.context, now_ns);
    for (unsigned i = 0U; i < node->transmit_count; i++) {
        pdo_t* pdo      = &node->transmit[i];
        pdo->sync_count = 0U;
        pdo->is_waiting = (pdo->start_entry != NULL) && (pdo->start_entry->value != 0U) &&
                          (node->sync_counter != NULL) && (node->sync_counter->value != 0U);
        (void)pdo_pack(pdo);
        if (pdo->is_valid && (pdo->type >= PDO_EVENT_MANUFACTURER)) {
            send_pdo(node, pdo, now_ns);
        }
    }
}

void node_stop_pdos(node_t* const node)
{
    for (unsigned i = 0U; i < node->receive_count; i++) {
        node->receive[i].is_pending  = false;
        node->receive[i].deadline_ns = BUS_NEVER;
    }
    for (unsigned i = 0U; i < node->transmit_count; i++) {
        node->transmit[i].deadline_ns = BUS_NEVER;
    }
}

static void apply_pdo(node_t* const node, pdo_t* const pdo, const uint64_t now_ns)
{
    pdo->is_pending = false;
    pdo_unpack(pdo);
    for (unsigned k = 0U; k < pdo->entry_count; k++) {
        node->application.written(node->application.context, pdo->entry[k], now_ns);
    }
}

static void transmit_at_sync(node_t* const node, pdo_t* const pdo, const osal_can_frame_t* const sync,
                             const uint64_t now_ns)
{
    if (!pdo->is_valid || (pdo->type > PDO_SYNCHRONOUS_MAX)) {
        return;
    }
    if (pdo->is_waiting) {
        pdo->is_waiting = (sync->length == 0U) || (sync->data[0] != pdo->start_entry->value);
        if (pdo->is_waiting) {
            return;
        }
        pdo->sync_count = pdo->type; // A cyclic PDO is sent with this SYNC, and then with every n-th.
    } else {
        pdo->sync_count++;
    }
    if (pdo->type == 0U) {
        if (pdo_pack(pdo)) {
            send_pdo(node, pdo, now_ns);
        }
    } else if (pdo->sync_count >= pdo->type) {
        (void)pdo_pack(pdo);
        send_pdo(node, pdo, now_ns);
    }
}

void node_take_sync(node_t* const node, const osal_can_frame_t* const frame)
{
    const uint64_t now_ns = frame->time_ns;
    const uint8_t wanted  = ((node->sync_counter != NULL) && (node->sync_counter->value != 0U)) ? 1U : 0U;
    if (frame->length != wanted) {
        node_raise(node, EMERGENCY_SYNC_LENGTH, 0U, frame->length, now_ns);
    } else {
        node_clear(node, EMERGENCY_SYNC_LENGTH, 0U, now_ns);
    }
    if (node->state != NODE_OPERATIONAL) {
        return;
    }
    node->syncs++;
    node->last_sync_ns = now_ns;
    for (unsigned i = 0U; i < node->receive_count; i++) {
        if (node->receive[i].is_pending) {
            apply_pdo(node, &node->receive[i], now_ns);
        }
    }
    node->application.sample(node->application.context, now_ns);
    for (unsigned i = 0U; i < node->transmit_count; i++) {
        transmit_at_sync(node, &node->transmit[i], frame, now_ns);
    }
}

static void take_data(node_t* const node, pdo_t* const pdo, const osal_can_frame_t* const frame)
{
    const uint64_t now_ns = frame->time_ns;
    if (frame->length < pdo->octets) {
        node_raise(node, EMERGENCY_PDO_LENGTH, 0U, frame->length, now_ns);
        return;
    }
    if (frame->length > pdo->octets) {
        node_raise(node, EMERGENCY_PDO_TOO_LONG, 0U, frame->length, now_ns);
    }
    memcpy(pdo->data, frame->data, pdo->octets);
    if (pdo->event_ns != 0U) {
        pdo->deadline_ns = now_ns + pdo->event_ns;
        node_wake_by(node, pdo->deadline_ns);
    }
    node_clear(node, EMERGENCY_RPDO_TIMEOUT, 0U, now_ns);
    if (pdo->type <= PDO_SYNCHRONOUS_MAX) {
        pdo->is_pending = true;
    } else {
        apply_pdo(node, pdo, now_ns);
    }
}

bool node_take_pdo(node_t* const node, const osal_can_frame_t* const frame)
{
    for (unsigned i = 0U; i < node->receive_count; i++) {
        pdo_t* pdo = &node->receive[i];
        if (pdo->is_valid && (pdo->cob_id == frame->id)) {
            if (node->state == NODE_OPERATIONAL) {
                take_data(node, pdo, frame);
            }
            return true;
        }
    }
    return false;
}

uint64_t node_run_pdo_timers(node_t* const node, const uint64_t now_ns)
{
    uint64_t next_ns = BUS_NEVER;
    for (unsigned i = 0U; i < node->receive_count; i++) {
        pdo_t* pdo = &node->receive[i];
        if (pdo->deadline_ns <= now_ns) {
            pdo->deadline_ns = BUS_NEVER; // No deadline until the next RPDO is received.
            node_raise(node, EMERGENCY_RPDO_TIMEOUT, 0U, (int32_t)i, now_ns);
            node->application.connection_lost(node->application.context, now_ns);
        }
        next_ns = (pdo->deadline_ns < next_ns) ? pdo->deadline_ns : next_ns;
    }
    for (unsigned i = 0U; i < node->transmit_count; i++) {
        pdo_t* pdo = &node->transmit[i];
        if (pdo->deadline_ns <= now_ns) {
            pdo->deadline_ns = BUS_NEVER;
            if (pdo->type >= PDO_EVENT_MANUFACTURER) {
                node->application.sample(node->application.context, now_ns);
                (void)pdo_pack(pdo);
                send_pdo(node, pdo, now_ns);
            }
        }
        next_ns = (pdo->deadline_ns < next_ns) ? pdo->deadline_ns : next_ns;
    }
    return next_ns;
}

void node_event(node_t* const node, const uint64_t now_ns)
{
    if (node->state != NODE_OPERATIONAL) {
        return;
    }
    for (unsigned i = 0U; i < node->transmit_count; i++) {
        pdo_t* pdo = &node->transmit[i];
        if (pdo->is_valid && (pdo->type >= PDO_EVENT_MANUFACTURER) && pdo_pack(pdo)) {
            send_pdo(node, pdo, now_ns);
        }
    }
}
