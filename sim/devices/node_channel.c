// SPDX-License-Identifier: Apache-2.0
// The two channels of a redundant bus (ECSS-E-ST-50-15C, object 0x2000): selection of the channel that the
// node uses, and search for the master.
#include "sim/devices/node_internal.h"

#define OBJECT_REDUNDANCY 0x2000U // Bdefault, Ttoggle, Ntoggle, Ctoggle.
#define NS_PER_MS 1000000U

void node_find_channels(node_t* const node)
{
    node->default_channel = dictionary_find(&node->dictionary, OBJECT_REDUNDANCY, 1U);
    node->toggle_factor   = dictionary_find(&node->dictionary, OBJECT_REDUNDANCY, 2U);
    node->toggle_limit    = dictionary_find(&node->dictionary, OBJECT_REDUNDANCY, 3U);
    node->toggle_count    = dictionary_find(&node->dictionary, OBJECT_REDUNDANCY, 4U);
}

/// True if the node has two channels, a complete object 0x2000 and a master to monitor, and the search is
/// enabled.
static bool may_search(const node_t* const node)
{
    return (node->channel[NODE_CHANNEL_B].bus != NULL) && (node->default_channel != NULL) &&
           (node->toggle_factor != NULL) && (node->toggle_limit != NULL) && (node->toggle_count != NULL) &&
           (node->consumer[0].entry != NULL) && ((node->consumer[0].entry->value & 0xFFFFU) != 0U) &&
           (node->toggle_factor->value != 0U);
}

/// Consumer heartbeat time of the master.
static uint64_t heartbeat_time_ns(const node_t* const node)
{
    return (node->consumer[0].entry->value & 0xFFFFU) * NS_PER_MS;
}

/// Connect the node to the bus of the active channel if it has power and the channel is not cut; else
/// disconnect it.
static void connect_active(node_t* const node)
{
    const bool wanted = node->is_plugged && node->is_powered && !node->channel[node->active].is_cut;
    if (wanted && !bus_is_plugged(node->bus, node->bus_index)) {
        bus_plug(node->bus, node->bus_index);
    } else if (!wanted && bus_is_plugged(node->bus, node->bus_index)) {
        bus_unplug(node->bus, node->bus_index);
    } else {
        // The channel is already in the wanted state.
    }
}

static void use_channel(node_t* const node, const unsigned channel, const uint64_t now_ns)
{
    if (channel == node->active) {
        return;
    }
    bus_set_wake(node->bus, node->bus_index, BUS_NEVER);
    if (bus_is_plugged(node->bus, node->bus_index)) {
        bus_unplug(node->bus, node->bus_index);
    }
    node->active    = channel;
    node->bus       = node->channel[channel].bus;
    node->bus_index = node->channel[channel].index;
    node->wake_ns   = BUS_NEVER;
    connect_active(node);
    node_wake_by(node, now_ns); // on_wake of the new bus handles everything that is due.
}

/// End the search on the active channel, and make it the channel after a reset (Bdefault).
static void keep_channel(node_t* const node)
{
    node->toggle_ns = BUS_NEVER;
    object_set(node->default_channel, (int64_t)node->active);
}

void node_select_default_channel(node_t* const node, const uint64_t now_ns)
{
    node->toggle_ns = BUS_NEVER;
    if (may_search(node)) {
        use_channel(node, (unsigned)node->default_channel->value, now_ns);
        node->toggle_ns = now_ns + (heartbeat_time_ns(node) * node->toggle_factor->value);
        node_wake_by(node, node->toggle_ns);
    }
}

void node_master_heard(node_t* const node)
{
    if (may_search(node)) {
        keep_channel(node);
        object_set(node->toggle_count, 0);
    }
}

void node_master_lost(node_t* const node, const uint64_t now_ns)
{
    if (may_search(node)) { // One consumer heartbeat time has passed since the last heartbeat.
        node->toggle_ns = now_ns + (heartbeat_time_ns(node) * (node->toggle_factor->value - 1U));
        node_wake_by(node, node->toggle_ns);
    }
}

uint64_t node_run_search(node_t* const node, const uint64_t now_ns)
{
    if (node->toggle_ns > now_ns) {
        return node->toggle_ns;
    }
    node->toggle_ns = BUS_NEVER;
    if (may_search(node) && (node->toggle_count->value < node->toggle_limit->value)) {
        use_channel(node, 1U - node->active, now_ns);
        object_set(node->toggle_count, (int64_t)node->toggle_count->value + 1);
        // Send a heartbeat on the new channel at once.
        node->heartbeat_ns = (node->heartbeat_ns != BUS_NEVER) ? now_ns : BUS_NEVER;
        node->toggle_ns    = now_ns + (heartbeat_time_ns(node) * node->toggle_factor->value);
    }
    if (may_search(node) && (node->toggle_count->value >= node->toggle_limit->value)) {
        keep_channel(node); // This was the last change (Ntoggle): stay here, with or without a master.
    }
    return node->toggle_ns;
}

status_t node_connect_redundant(node_t* const node, bus_t* const bus, const bus_callbacks_t* const callbacks)
{
    node_channel_t* channel = &node->channel[NODE_CHANNEL_B];
    const status_t status   = bus_add_node(bus, callbacks, &channel->index);
    if (status == STATUS_OK) {
        channel->bus = bus;
        bus_unplug(bus, channel->index);
    }
    return status;
}

void node_connect(node_t* const node, const bool is_plugged)
{
    node->is_plugged = is_plugged;
    connect_active(node);
}

void node_supply(node_t* const node, const bool is_powered)
{
    node->is_powered = is_powered;
    connect_active(node);
}

void node_cut(node_t* const node, const unsigned channel, const bool is_cut)
{
    node->channel[channel].is_cut = is_cut;
    connect_active(node);
}
