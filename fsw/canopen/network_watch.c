// SPDX-License-Identifier: Apache-2.0
// Supervision of a network: process data that arrived or are missing, and errors that devices report.
#include "fsw/canopen/network_internal.h"

#include "base/assertion.h"

#include <stddef.h>

// After a second without loss, the next loss of frames is reported again.
#define OVERRUN_QUIET_NS 1000000000ULL
// After a second without foreign SYNCs, the next one is reported again.
#define SYNC_QUIET_NS 1000000000ULL

void canopen_network_report(canopen_network_t* const network, const canopen_network_fault_t* const fault)
{
    FSW_ASSERT((network != NULL) && (fault != NULL));
    if (network->fault_count == NETWORK_FAULTS_MAX) {
        network->faults_lost++;
        return;
    }
    const unsigned position   = ((unsigned)network->fault_first + network->fault_count) % NETWORK_FAULTS_MAX;
    network->faults[position] = *fault;
    network->fault_count++;
}

static void report_fault(canopen_network_t* const network, const canopen_network_fault_kind_t kind,
                         const uint8_t node, const uint16_t code)
{
    const canopen_network_fault_t fault = {.kind = kind, .node = node, .code = code};
    canopen_network_report(network, &fault);
}

void canopen_network_report_condition(canopen_network_t* const network, const uint8_t channel,
                                      const canopen_network_bus_condition_t condition)
{
    FSW_ASSERT(network != NULL);
    const uint16_t offset = (channel == NETWORK_CHANNEL_B) ? NETWORK_BUS_CHANNEL_B : 0U;
    report_fault(network, NETWORK_BUS_WARNING, 0U, (uint16_t)((uint16_t)condition + offset));
}

void canopen_network_report_refusal(canopen_network_t* const network,
                                    const canopen_network_device_t* const entry,
                                    const canopen_network_refusal_t refusal)
{
    FSW_ASSERT((network != NULL) && (entry != NULL));
    const canopen_network_fault_t fault = {
        .kind = NETWORK_DEVICE_REFUSED, .node = entry->device.node, .refusal = refusal};
    canopen_network_report(network, &fault);
}

void canopen_network_report_access(canopen_network_t* const network,
                                   const canopen_network_device_t* const entry, const status_t status)
{
    FSW_ASSERT((network != NULL) && (entry != NULL));
    const canopen_setting_run_t* const run = &entry->device.run;
    FSW_ASSERT(run->position < run->count);
    const canopen_setting_t* const setting = &run->settings[run->position];
    canopen_network_fault_t fault          = {.kind    = NETWORK_DEVICE_REFUSED,
                                              .node    = entry->device.node,
                                              .refusal = REFUSAL_FORMAT,
                                              .object  = ((uint32_t)setting->index << 8) | setting->subindex};
    if (status == STATUS_TIMEOUT) {
        fault.refusal = REFUSAL_TIMEOUT;
    } else if (status == STATUS_FORBIDDEN) {
        fault.refusal = REFUSAL_ABORTED;
        fault.detail  = run->abort_code;
    } else if (run->is_other_value) {
        fault.refusal = REFUSAL_VALUE;
        fault.detail  = (uint32_t)run->found;
    } else {
        // The answer has another size, is too long, or violates the protocol.
    }
    canopen_network_report(network, &fault);
}

/// Report the first fault of a drive; further ones, also emergencies, belong to the same failure.
static void report_drive_fault(canopen_network_t* const network, canopen_network_device_t* const entry,
                               const uint16_t code)
{
    if (!entry->is_faulty) {
        entry->is_faulty = true;
        report_fault(network, NETWORK_DRIVE_FAULT, entry->device.node, code);
    }
}

static void watch_presence(canopen_network_t* const network, canopen_network_device_t* const entry)
{
    const canopen_device_t* const device    = &entry->device;
    const canopen_master_node_t* const node = &network->master.nodes[device->index];
    const flow_can_health_t* const bus      = &network->flow->health;
    const uint32_t silence                  = network->is_running ? canopen_device_silence(device) : 0U;
    if (silence > 0U) {
        entry->missed++;
    }
    // A device is lost if it is silent, has rebooted, or cannot be reached, because the controller is off
    // the bus or no node acknowledges.
    const bool is_gone = (silence >= network->config.lost_after_syncs) || node->is_heartbeat_lost ||
                         (node->boots != device->boots) || (bus->state == FLOW_CAN_BUS_OFF) ||
                         network->was_bus_off || bus->is_unacknowledged;
    if (is_gone && !entry->is_lost) {
        entry->is_lost = true;
        report_fault(network, NETWORK_DEVICE_LOST, device->node, 0U);
    }
}

static void watch_axes(canopen_network_t* const network, canopen_network_device_t* const entry)
{
    for (uint8_t i = 0U; i < entry->device.profile->axis_count; i++) {
        canopen_cia402_axis_t* const axis = &entry->device.axes[i];
        canopen_cia402_axis_observe(axis);
        const canopen_cia402_state_t state = canopen_cia402_axis_state(axis);
        const bool is_in_fault             = (state == CIA402_FAULT) || (state == CIA402_FAULT_REACTION);
        // A fault is expected while the goal resets it.
        if (axis->has_dropped || (is_in_fault && !axis->may_reset_fault)) {
            report_drive_fault(network, entry, axis->statusword);
        }
    }
}

static void take_emergencies(canopen_network_t* const network)
{
    canopen_emergency_t emergency;
    while (canopen_master_take_emergency(&network->master, &emergency) == STATUS_OK) {
        const uint8_t index = canopen_network_find(network, emergency.node);
        if (!network->is_booted || (index == NETWORK_NO_DEVICE)) {
            continue; // Emergencies before the boot is done, or of an unknown node, are ignored.
        }
        const canopen_device_profile_t* const profile = network->devices[index]->device.profile;
        switch (canopen_emergency_severity(profile->emergencies, profile->emergency_count, emergency.code)) {
        case EMERGENCY_HIGH:
            report_drive_fault(network, network->devices[index], emergency.code);
            break;
        case EMERGENCY_MEDIUM:
            report_fault(network, NETWORK_DRIVE_WARNING, emergency.node, emergency.code);
            break;
        case EMERGENCY_LOW:
            report_fault(network, NETWORK_BUS_WARNING, emergency.node, emergency.code);
            break;
        case EMERGENCY_CLEARED:
        default:
            break;
        }
    }
}

canopen_network_conditions_t canopen_network_conditions(const flow_can_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    return (canopen_network_conditions_t){.state             = flow->health.state,
                                          .overruns          = flow->counters.overruns,
                                          .transmit_timeouts = flow->errors.transmit_timeouts,
                                          .bus_offs          = flow->errors.bus_offs,
                                          .restarts          = flow->errors.restarts};
}

static void report_conditions(canopen_network_t* const network, const uint8_t channel,
                              const canopen_network_conditions_t* const reported,
                              const canopen_network_conditions_t* const now)
{
    // Only a change to a worse state is reported.
    if (now->state > reported->state) {
        canopen_network_report_condition(network, channel, (canopen_network_bus_condition_t)now->state);
    }
    const bool is_first =
        (reported->overrun_ns == 0U) || ((now->overrun_ns - reported->overrun_ns) >= OVERRUN_QUIET_NS);
    if ((now->overruns != reported->overruns) && is_first) {
        canopen_network_report_condition(network, channel, NETWORK_BUS_OVERRUN);
    }
    if (now->transmit_timeouts != reported->transmit_timeouts) {
        canopen_network_report_condition(network, channel, NETWORK_BUS_TRANSMIT_TIMEOUT);
    }
    if (now->restarts != reported->restarts) {
        canopen_network_report_condition(network, channel, NETWORK_BUS_RESTARTED);
    }
}

/// Monitor one of the master's controllers. Changes before the boot of the network is done are not reported.
static void watch_bus(canopen_network_t* const network, const uint8_t channel, const uint64_t now_ns)
{
    canopen_network_conditions_t* const reported = &network->reported[channel];
    canopen_network_conditions_t now             = canopen_network_conditions(&network->flows[channel]);
    now.overrun_ns = (now.overruns != reported->overruns) ? now_ns : reported->overrun_ns;
    if (network->is_booted) {
        report_conditions(network, channel, reported, &now);
    }
    if (channel == network->channel) { // The counter also shows a bus-off that has ended meanwhile.
        network->was_bus_off = (now.bus_offs != reported->bus_offs);
    }
    *reported = now;
}

/// Report SYNCs of other nodes. All devices act on SYNC: a foreign SYNC makes them sample and actuate at an
/// instant that the master did not choose, and their answers then belong to no cycle.
static void watch_sync(canopen_network_t* const network, const uint64_t now_ns)
{
    canopen_network_sync_conflict_t* const reported = &network->sync_conflict;
    const uint32_t count                            = network->master.counters.conflicting_syncs;
    if (count == reported->count) {
        return;
    }
    const bool is_first = (reported->time_ns == 0U) || ((now_ns - reported->time_ns) >= SYNC_QUIET_NS);
    if (network->is_booted && is_first) {
        report_fault(network, NETWORK_SYNC_CONFLICT, 0U, 0U);
    }
    reported->count   = count;
    reported->time_ns = network->is_booted ? now_ns : 0U;
}

/// Drop the frames on the channel that is not active: the devices answer on the active one.
static void drain_standby(canopen_network_t* const network)
{
    osal_can_frame_t frame;
    flow_can_t* const standby = &network->flows[NETWORK_CHANNELS - 1U - network->channel];
    for (unsigned i = 0U; i < MASTER_FRAMES_PER_CYCLE; i++) {
        if (flow_can_receive(standby, &frame) != STATUS_OK) {
            break;
        }
    }
}

void canopen_network_sense(canopen_network_t* const network, const uint64_t now_ns)
{
    FSW_ASSERT(network != NULL);
    if (!flow_can_is_open(network->flow)) {
        return;
    }
    for (uint8_t i = 0U; i < NETWORK_CHANNELS; i++) {
        flow_can_attend(&network->flows[i], now_ns);
    }
    canopen_master_receive(&network->master, now_ns);
    drain_standby(network);
    // Emergencies come before the statuswords, so that a fault is reported with the code of its emergency.
    take_emergencies(network);
    watch_sync(network, now_ns);
    for (uint8_t i = 0U; i < NETWORK_CHANNELS; i++) {
        watch_bus(network, i, now_ns);
    }
    for (uint8_t i = 0U; network->is_booted && (i < network->device_count); i++) {
        canopen_network_device_t* const entry = network->devices[i];
        watch_presence(network, entry);
        if (network->is_running && !entry->is_lost) {
            watch_axes(network, entry);
        }
    }
}

status_t canopen_network_take_fault(canopen_network_t* const network,
                                    canopen_network_fault_t* const out_fault)
{
    FSW_ASSERT((network != NULL) && (out_fault != NULL));
    if (network->fault_count == 0U) {
        return STATUS_EMPTY;
    }
    *out_fault           = network->faults[network->fault_first];
    network->fault_first = (uint8_t)((network->fault_first + 1U) % NETWORK_FAULTS_MAX);
    network->fault_count--;
    return STATUS_OK;
}
