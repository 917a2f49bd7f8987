// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/network_internal.h"

#include "base/assertion.h"

#include <stddef.h>

#define ALL_NODES 0U

void canopen_network_init(canopen_network_t* const network, const canopen_network_config_t* const config)
{
    FSW_ASSERT((network != NULL) && (config != NULL) && (config->lost_after_syncs >= 1U));
    *network = (canopen_network_t){.config = *config};
    flow_can_init(&network->flows[NETWORK_CHANNEL_A]);
    flow_can_init(&network->flows[NETWORK_CHANNEL_B]);
    network->flow = &network->flows[NETWORK_CHANNEL_A];
    canopen_master_init(&network->master, &config->master, network->flow);
}

void canopen_network_clear(canopen_network_t* const network)
{
    FSW_ASSERT((network != NULL) && !flow_can_is_open(network->flow));
    canopen_master_clear(&network->master);
    network->device_count = 0U;
}

uint8_t canopen_network_find(const canopen_network_t* const network, const uint8_t node)
{
    FSW_ASSERT(network != NULL);
    for (uint8_t i = 0U; i < network->device_count; i++) {
        if (network->devices[i]->device.node == node) {
            return i;
        }
    }
    return NETWORK_NO_DEVICE;
}

status_t canopen_network_add(canopen_network_t* const network, canopen_network_device_t* const entry,
                             const char* const type, const uint8_t node)
{
    FSW_ASSERT((network != NULL) && (entry != NULL) && (type != NULL));
    const canopen_device_profile_t* const profile = canopen_device_profile_find(type);
    if (profile == NULL) {
        return STATUS_NOT_FOUND;
    }
    if (network->device_count == NETWORK_DEVICES_MAX) {
        return STATUS_EXHAUSTED;
    }
    const status_t status = canopen_device_attach(&entry->device, &network->master, profile, node);
    if (status == STATUS_OK) {
        entry->missed                           = 0U;
        entry->is_idle                          = false;
        entry->setting_count                    = 0U;
        network->devices[network->device_count] = entry;
        network->device_count++;
    }
    return status;
}

static void enter(canopen_network_t* const network, const canopen_network_phase_t phase,
                  const uint64_t now_ns)
{
    network->phase          = phase;
    network->phase_start_ns = now_ns;
}

status_t canopen_network_open(canopen_network_t* const network, const flow_resolver_t* const resolver,
                              const char* const bus, const char* const redundant_bus)
{
    FSW_ASSERT((network != NULL) && (resolver != NULL) && (bus != NULL));
    const char* const buses[NETWORK_CHANNELS] = {bus, redundant_bus};
    if (buses[network->channel] == NULL) {
        return STATUS_NOT_FOUND;
    }
    const status_t status = flow_can_open(network->flow, resolver, buses[network->channel]);
    if (status != STATUS_OK) {
        return status;
    }
    const uint8_t standby = (uint8_t)(NETWORK_CHANNELS - 1U - network->channel);
    network->is_standby_missing =
        (buses[standby] != NULL) &&
        (flow_can_open(&network->flows[standby], resolver, buses[standby]) != STATUS_OK);
    for (uint8_t i = 0U; i < NETWORK_CHANNELS; i++) {
        network->reported[i] = canopen_network_conditions(&network->flows[i]);
    }
    return STATUS_OK;
}

bool canopen_network_has_channel(const canopen_network_t* const network, const uint8_t channel)
{
    FSW_ASSERT((network != NULL) && (channel < NETWORK_CHANNELS));
    return !flow_can_is_open(network->flow) || flow_can_is_open(&network->flows[channel]);
}

status_t canopen_network_select_channel(canopen_network_t* const network, const uint8_t channel)
{
    FSW_ASSERT(network != NULL);
    if (channel >= NETWORK_CHANNELS) {
        return STATUS_OUT_OF_RANGE;
    }
    if (channel == network->channel) {
        return STATUS_OK;
    }
    if (!canopen_network_has_channel(network, channel)) {
        return STATUS_NOT_FOUND;
    }
    if (flow_can_is_open(network->flow)) {
        canopen_network_stop(network);
        network->is_booted = false;
    }
    network->channel        = channel;
    network->flow           = &network->flows[channel];
    network->is_channel_new = true;
    canopen_master_use_flow(&network->master, network->flow);
    return STATUS_OK;
}

void canopen_network_doubt_channel(canopen_network_t* const network)
{
    FSW_ASSERT(network != NULL);
    network->is_channel_new = true;
}

void canopen_network_add_counters(const canopen_network_t* const network,
                                  canopen_network_bus_counters_t* const sum)
{
    FSW_ASSERT((network != NULL) && (sum != NULL));
    for (uint8_t i = 0U; i < NETWORK_CHANNELS; i++) {
        const flow_can_t* const flow = &network->flows[i];
        sum->sent += flow->counters.sent;
        sum->received += flow->counters.received;
        sum->refused += flow->counters.refused;
        sum->full += flow->counters.full;
        sum->errors += flow->counters.errors;
        sum->overruns += flow->counters.overruns;
        sum->bus_offs += flow->errors.bus_offs;
        sum->restarts += flow->errors.restarts;
        sum->missing_acknowledges += flow->errors.missing_acknowledges;
        sum->transmit_timeouts += flow->errors.transmit_timeouts;
        sum->lost_arbitrations += flow->errors.lost_arbitrations;
        sum->lost += flow->counters.lost;
    }
}

// ---- Commissioning ----

static bool has_two_channels(const canopen_network_t* const network)
{
    return flow_can_is_open(&network->flows[NETWORK_CHANNEL_A]) &&
           flow_can_is_open(&network->flows[NETWORK_CHANNEL_B]);
}

/// True when every node has been heard on this channel since NETWORK_SELECTING began, or when `selection_ns`
/// has passed.
static bool is_selection_over(const canopen_network_t* const network, const uint64_t now_ns)
{
    const bool is_late = (now_ns - network->phase_start_ns) >= network->config.selection_ns;
    bool have_all      = true;
    for (uint8_t i = 0U; i < network->device_count; i++) {
        const canopen_master_node_t* const node = &network->master.nodes[network->devices[i]->device.index];
        have_all                                = have_all && (node->heard_ns > network->phase_start_ns);
    }
    return have_all || is_late;
}

static void begin_boot(canopen_network_t* const network, const uint64_t now_ns)
{
    for (uint8_t i = 0U; i < network->device_count; i++) {
        canopen_network_device_t* const entry = network->devices[i];
        canopen_device_reset(&entry->device);
        entry->device.boots        = network->master.nodes[entry->device.index].boots;
        entry->is_lost             = false;
        entry->is_faulty           = false;
        entry->is_refusal_reported = false;
    }
    network->is_booted = false; // The boot-up message after this reset must not count as the loss of a node.
    (void)canopen_master_command(&network->master, ALL_NODES, NMT_RESET_NODE);
    enter(network, NETWORK_BOOTING, now_ns);
}

/// Report once per boot or start why a device is not commissioned yet. The network continues to wait for it.
static void report_waiting(canopen_network_t* const network, canopen_network_device_t* const entry,
                           const canopen_network_refusal_t refusal)
{
    if (!entry->is_refusal_reported) {
        entry->is_refusal_reported = true;
        canopen_network_report_refusal(network, entry, refusal);
    }
}

/// True when every node has booted. After each boot_retry_ns, the nodes that have not booted are reset again.
static bool have_all_booted(canopen_network_t* const network, const uint64_t now_ns)
{
    const bool is_retry = (now_ns - network->phase_start_ns) >= network->config.boot_retry_ns;
    bool have_all       = true;
    for (uint8_t i = 0U; i < network->device_count; i++) {
        const canopen_device_t* const device = &network->devices[i]->device;
        if (network->master.nodes[device->index].boots == device->boots) {
            have_all = false;
            if (is_retry) {
                report_waiting(network, network->devices[i], REFUSAL_NOT_BOOTED);
            }
            if (is_retry && !network->flow->health.is_unacknowledged) {
                (void)canopen_master_command(&network->master, device->node, NMT_RESET_NODE);
            }
        }
    }
    if (is_retry) {
        network->phase_start_ns = now_ns;
    }
    return have_all;
}

static status_t identify_all(canopen_network_t* const network)
{
    bool is_busy = false;
    for (uint8_t i = 0U; i < network->device_count; i++) {
        canopen_network_device_t* const entry = network->devices[i];
        if (network->master.nodes[entry->device.index].boots != entry->device.boots) {
            canopen_network_report_refusal(network, entry, REFUSAL_REBOOTED);
            return STATUS_CLOSED;
        }
        const status_t status = canopen_device_identify_step(&entry->device);
        if ((status != STATUS_OK) && (status != STATUS_BUSY)) {
            canopen_network_report_access(network, entry, status);
            return status;
        }
        is_busy = is_busy || (status == STATUS_BUSY);
    }
    return is_busy ? STATUS_BUSY : STATUS_OK;
}

status_t canopen_network_boot(canopen_network_t* const network, const uint64_t now_ns)
{
    FSW_ASSERT(network != NULL);
    if (!flow_can_is_open(network->flow)) {
        return STATUS_CLOSED;
    }
    if (network->phase == NETWORK_RESTING) {
        enter(network, NETWORK_SELECTING, now_ns);
    }
    if (network->phase == NETWORK_SELECTING) {
        if (has_two_channels(network) && !is_selection_over(network, now_ns)) {
            return STATUS_BUSY;
        }
        if (network->is_channel_new) {
            // A reset node returns to the channel on which it last heard a heartbeat of the master. A node
            // that has just arrived has heard none on this channel: make one due before the reset.
            network->is_channel_new = false;
            canopen_master_use_flow(&network->master, network->flow);
        } else {
            begin_boot(network, now_ns);
        }
        return STATUS_BUSY;
    }
    if (network->phase == NETWORK_BOOTING) {
        if (have_all_booted(network, now_ns)) {
            for (uint8_t i = 0U; i < network->device_count; i++) {
                canopen_device_t* const device = &network->devices[i]->device;
                device->boots                  = network->master.nodes[device->index].boots;
                canopen_device_identify(device);
            }
            enter(network, NETWORK_IDENTIFYING, now_ns);
        }
        return STATUS_BUSY;
    }
    const status_t status = identify_all(network);
    if (status != STATUS_BUSY) {
        network->is_booted = (status == STATUS_OK);
        if (network->is_booted && network->is_standby_missing) {
            canopen_network_report_condition(network, (uint8_t)(NETWORK_CHANNELS - 1U - network->channel),
                                             NETWORK_BUS_MISSING);
        }
        enter(network, NETWORK_RESTING, now_ns);
    }
    return status;
}

void canopen_network_set_lost_after(canopen_network_t* const network, const uint32_t syncs)
{
    FSW_ASSERT((network != NULL) && (syncs >= 1U));
    network->config.lost_after_syncs = syncs;
}

void canopen_network_clear_settings(canopen_network_t* const network)
{
    FSW_ASSERT(network != NULL);
    for (uint8_t i = 0U; i < network->device_count; i++) {
        network->devices[i]->setting_count = 0U;
        network->devices[i]->is_idle       = true;
    }
}

void canopen_network_include(canopen_network_t* const network, const uint8_t index)
{
    FSW_ASSERT((network != NULL) && (index < network->device_count));
    network->devices[index]->is_idle = false;
}

status_t canopen_network_set(canopen_network_t* const network, const uint8_t index,
                             const canopen_setting_t* const setting)
{
    FSW_ASSERT((network != NULL) && (index < network->device_count) && (setting != NULL));
    canopen_network_device_t* const entry = network->devices[index];
    if (entry->setting_count == NETWORK_SETTINGS_MAX) {
        return STATUS_EXHAUSTED;
    }
    entry->settings[entry->setting_count] = *setting;
    entry->setting_count++;
    return STATUS_OK;
}

status_t canopen_network_configure(canopen_network_t* const network, const uint64_t now_ns)
{
    FSW_ASSERT(network != NULL);
    if (!network->is_booted) {
        return STATUS_CLOSED;
    }
    if (network->phase != NETWORK_CONFIGURING) {
        canopen_network_stop(network);
        for (uint8_t i = 0U; i < network->device_count; i++) {
            canopen_network_device_t* const entry = network->devices[i];
            canopen_device_configure(&entry->device, entry->settings, entry->setting_count);
        }
        enter(network, NETWORK_CONFIGURING, now_ns);
    }
    bool is_busy = false;
    for (uint8_t i = 0U; i < network->device_count; i++) {
        const status_t status = canopen_device_configure_step(&network->devices[i]->device);
        if ((status != STATUS_OK) && (status != STATUS_BUSY)) {
            canopen_network_report_access(network, network->devices[i], status);
            enter(network, NETWORK_RESTING, now_ns);
            return status;
        }
        is_busy = is_busy || (status == STATUS_BUSY);
    }
    if (is_busy) {
        return STATUS_BUSY;
    }
    enter(network, NETWORK_RESTING, now_ns);
    return STATUS_OK;
}

static status_t begin_start(canopen_network_t* const network, const uint64_t now_ns)
{
    for (uint8_t i = 0U; i < network->device_count; i++) {
        network->devices[i]->is_refusal_reported = false;
        const status_t status                    = canopen_device_connect(&network->devices[i]->device);
        if (status != STATUS_OK) {
            canopen_network_stop(network);
            return status;
        }
    }
    canopen_network_set_goal(network, CIA402_GOAL_DISABLED, false);
    (void)canopen_master_command(&network->master, ALL_NODES, NMT_START);
    canopen_master_set_sync(&network->master, true);
    enter(network, NETWORK_STARTING, now_ns);
    return STATUS_BUSY;
}

status_t canopen_network_start(canopen_network_t* const network, const uint64_t now_ns)
{
    FSW_ASSERT(network != NULL);
    if (!network->is_booted) {
        return STATUS_CLOSED;
    }
    if (network->is_running) {
        return STATUS_OK;
    }
    if (network->phase != NETWORK_STARTING) {
        return begin_start(network, now_ns);
    }
    const bool is_late = (now_ns - network->phase_start_ns) >= network->config.silence_reported_ns;
    bool are_all_heard = true;
    for (uint8_t i = 0U; i < network->device_count; i++) {
        canopen_network_device_t* const entry = network->devices[i];
        const bool is_heard                   = canopen_device_is_heard(&entry->device);
        are_all_heard                         = are_all_heard && is_heard;
        if (is_late && !is_heard) {
            report_waiting(network, entry, REFUSAL_SILENT);
        }
    }
    if (!are_all_heard) {
        return STATUS_BUSY;
    }
    network->is_running = true;
    enter(network, NETWORK_RESTING, now_ns);
    return STATUS_OK;
}

void canopen_network_stop(canopen_network_t* const network)
{
    FSW_ASSERT(network != NULL);
    canopen_master_set_sync(&network->master, false);
    for (uint8_t i = 0U; i < network->device_count; i++) {
        canopen_device_disconnect(&network->devices[i]->device);
        canopen_sdo_client_reset(&network->master.nodes[network->devices[i]->device.index].sdo);
    }
    if (flow_can_is_open(network->flow) && !network->flow->health.is_unacknowledged) {
        (void)canopen_master_command(&network->master, ALL_NODES, NMT_PRE_OPERATIONAL);
    }
    network->phase       = NETWORK_RESTING;
    network->is_running  = false;
    network->is_securing = false;
}

void canopen_network_reset_nodes(canopen_network_t* const network)
{
    FSW_ASSERT(network != NULL);
    canopen_network_stop(network);
    network->is_booted = false;
    if (flow_can_is_open(network->flow) && !network->flow->health.is_unacknowledged) {
        (void)canopen_master_command(&network->master, ALL_NODES, NMT_RESET_NODE);
    }
}

void canopen_network_close(canopen_network_t* const network)
{
    FSW_ASSERT(network != NULL);
    network->phase       = NETWORK_RESTING;
    network->is_booted   = false;
    network->is_running  = false;
    network->is_securing = false;
    network->fault_count = 0U;
    flow_can_close(&network->flows[NETWORK_CHANNEL_A]);
    flow_can_close(&network->flows[NETWORK_CHANNEL_B]);
}

// ---- The cycle ----

void canopen_network_send_sync(canopen_network_t* const network)
{
    FSW_ASSERT(network != NULL);
    canopen_master_send_sync(&network->master);
}

void canopen_network_emit(canopen_network_t* const network, const uint64_t now_ns)
{
    FSW_ASSERT(network != NULL);
    for (uint8_t i = 0U; network->is_running && (i < network->device_count); i++) {
        canopen_device_t* const device = &network->devices[i]->device;
        for (uint8_t k = 0U; k < device->profile->axis_count; k++) {
            canopen_cia402_axis_step(&device->axes[k]);
        }
        canopen_device_emit(device);
    }
    canopen_master_emit(&network->master, now_ns);
}

void canopen_network_set_goal(canopen_network_t* const network, const canopen_cia402_goal_t goal,
                              const bool may_reset_faults)
{
    FSW_ASSERT(network != NULL);
    for (uint8_t i = 0U; i < network->device_count; i++) {
        const bool is_idle                    = network->devices[i]->is_idle;
        canopen_device_t* const device        = &network->devices[i]->device;
        const canopen_cia402_goal_t axis_goal = is_idle ? CIA402_GOAL_DISABLED : goal;
        for (uint8_t k = 0U; k < device->profile->axis_count; k++) {
            canopen_cia402_axis_set_goal(&device->axes[k], axis_goal, may_reset_faults && !is_idle);
        }
    }
}

bool canopen_network_is_at_goal(const canopen_network_t* const network)
{
    FSW_ASSERT(network != NULL);
    for (uint8_t i = 0U; i < network->device_count; i++) {
        const canopen_network_device_t* const entry = network->devices[i];
        for (uint8_t k = 0U; !entry->is_lost && (k < entry->device.profile->axis_count); k++) {
            if (!canopen_cia402_axis_is_at_goal(&entry->device.axes[k])) {
                return false;
            }
        }
    }
    return network->is_running;
}

status_t canopen_network_secure(canopen_network_t* const network, const uint64_t now_ns)
{
    FSW_ASSERT(network != NULL);
    if (!network->is_running) { // Outside NMT OPERATIONAL the drives stop by themselves (object 0x6007).
        network->is_securing = false;
        return STATUS_OK;
    }
    for (uint8_t i = 0U; i < network->device_count; i++) {
        canopen_device_clear_outputs(&network->devices[i]->device);
    }
    if (!network->is_securing) {
        network->is_securing     = true;
        network->secure_start_ns = now_ns;
        canopen_network_set_goal(network, CIA402_GOAL_QUICK_STOP, false);
        return STATUS_BUSY; // The statuswords received so far were sent before this command.
    }
    if ((now_ns - network->secure_start_ns) >= network->config.quick_stop_limit_ns) {
        canopen_network_set_goal(network, CIA402_GOAL_DISABLED, false);
    }
    if (!canopen_network_is_at_goal(network)) {
        return STATUS_BUSY;
    }
    canopen_network_set_goal(network, CIA402_GOAL_DISABLED, false);
    network->is_securing = false;
    return STATUS_OK;
}
