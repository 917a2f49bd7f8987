// SPDX-License-Identifier: Apache-2.0
// Faults of a bus that a caller orders: disconnected nodes, injected faults, and the restart of a controller.
#include "sim/bus/bus_internal.h"

void bus_unplug(bus_t* const bus, const unsigned index)
{
    bus_node_t* node    = &bus->node[index];
    const uint32_t self = 1U << index;
    node->is_plugged    = false;
    node->recover_ns    = BUS_NEVER;
    bus_note_presence(bus, index);
    bus_find_next_wake(bus);
    bus_drop_queue(bus, index);
    if (bus->is_sending && ((bus->senders & self) != 0U)) {
        bus->senders &= ~self;
        if (bus->senders == 0U) {
            bus_break_frame(bus, CONTROLLER_TRANSMIT_ERROR);
        }
    }
}

void bus_plug(bus_t* const bus, const unsigned index)
{
    bus_node_t* node = &bus->node[index];
    node->is_plugged = true;
    node->suspend_ns = 0U;
    controller_reset(&node->controller);
    bus_note_presence(bus, index);
}

bool bus_is_plugged(const bus_t* const bus, const unsigned node)
{
    return bus->node[node].is_plugged;
}

const controller_t* bus_controller(const bus_t* const bus, const unsigned node)
{
    return &bus->node[node].controller;
}

void bus_set_loss(bus_t* const bus, const double probability)
{
    bus->loss = probability;
}

void bus_set_corruption(bus_t* const bus, const double probability)
{
    bus->corruption = probability;
}

void bus_set_duplication(bus_t* const bus, const double probability)
{
    bus->duplication = probability;
}

void bus_set_delay(bus_t* const bus, const unsigned node, const uint64_t delay_ns)
{
    bus->node[node].delay_ns = delay_ns;
}

void bus_set_babbling(bus_t* const bus, const unsigned node, const bool on)
{
    // At the end of a frame `is_babbling` decides whether the frame came from the queue: destroy the present
    // frame before the value changes.
    if (bus->is_sending && ((bus->senders & (1U << node)) != 0U)) {
        bus_break_frame(bus, CONTROLLER_TRANSMIT_ERROR);
    }
    bus->node[node].is_babbling = on;
    bus_note_waiting(bus, node);
}

void bus_set_stuck(bus_t* const bus, const bool on)
{
    if (on && !bus->is_stuck) {
        // Every controller counts one error for each 8 dominant bits in a row (ISO 11898-1).
        bus->stuck_ticks   = 0U;
        bus->stuck_tick_ns = bus->now_ns + (8U * bus->nominal_ns);
        if (bus->is_sending) {
            bus_break_frame(bus, CONTROLLER_TRANSMIT_ERROR);
        } else {
            bus->senders = 0U;
        }
    } else if (!on && bus->is_stuck) {
        bus->stuck_tick_ns = BUS_NEVER;
        // A controller takes the bus for idle after 11 recessive bits.
        bus->idle_ns = bus->now_ns + (11U * bus->nominal_ns);
    }
    bus->is_stuck = on;
    bus_find_next_wake(bus);
}

void bus_lose_next(bus_t* const bus, const unsigned node, const unsigned frames)
{
    bus->node[node].overflows = frames;
}

void bus_force_off(bus_t* const bus, const unsigned index)
{
    const bus_node_t* node = &bus->node[index];
    if (bus->is_sending && ((bus->senders & (1U << index)) != 0U)) {
        bus_break_frame(bus, CONTROLLER_TRANSMIT_ERROR);
    }
    while (node->is_plugged && (node->controller.state != CONTROLLER_STATE_BUS_OFF)) {
        bus_account(bus, index, CONTROLLER_TRANSMIT_ERROR);
    }
}

void bus_set_restart(bus_t* const bus, const unsigned index, const bool is_automatic)
{
    bus->node[index].restarts_by_order = !is_automatic;
}

void bus_restart(bus_t* const bus, const unsigned index)
{
    bus_node_t* node = &bus->node[index];
    if (node->is_plugged && (node->controller.state == CONTROLLER_STATE_BUS_OFF) &&
        (node->recover_ns == BUS_NEVER)) {
        node->recover_ns = bus->now_ns + (CONTROLLER_RECOVERY_BITS * bus->nominal_ns);
        bus_find_next_wake(bus);
    }
}

void bus_set_arbitration_reports(bus_t* const bus, const unsigned node, const bool on)
{
    const uint32_t bit = 1U << node;
    bus->reporting     = on ? (bus->reporting | bit) : (bus->reporting & ~bit);
}

void bus_set_transmit_timeout(bus_t* const bus, const unsigned node, const uint64_t timeout_ns)
{
    bus->node[node].timeout_ns = timeout_ns;
}
