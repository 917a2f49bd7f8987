// SPDX-License-Identifier: Apache-2.0
// Supervision of a network: what came, what stayed away, and what the devices complain about.
#include "fsw/canopen/network_internal.h"

#include "fsw/framework/base/assertion.h"

#include <stddef.h>

void network_tell(canopen_network_t* const network, const network_fault_t* const fault)
{
    FSW_ASSERT((network != NULL) && (fault != NULL));
    if (network->fault_count == NETWORK_FAULTS_MAX) {
        network->faults_lost++;
        return;
    }
    const unsigned place   = ((unsigned)network->fault_first + network->fault_count) % NETWORK_FAULTS_MAX;
    network->faults[place] = *fault;
    network->fault_count++;
}

static void tell(canopen_network_t* const network, const network_fault_kind_t kind, const uint8_t node,
                 const uint16_t code)
{
    const network_fault_t fault = {.kind = kind, .node = node, .code = code};
    network_tell(network, &fault);
}

void network_tell_refusal(canopen_network_t* const network, const network_device_t* const place,
                          const network_refusal_t refusal)
{
    FSW_ASSERT((network != NULL) && (place != NULL));
    const network_fault_t fault = {
        .kind = NETWORK_DEVICE_REFUSED, .node = place->device.node, .refusal = refusal};
    network_tell(network, &fault);
}

void network_tell_access(canopen_network_t* const network, const network_device_t* const place,
                         const status_t status)
{
    FSW_ASSERT((network != NULL) && (place != NULL));
    const setting_run_t* const run = &place->device.run;
    FSW_ASSERT(run->position < run->count);
    const canopen_setting_t* const setting = &run->settings[run->position];
    network_fault_t fault                  = {.kind    = NETWORK_DEVICE_REFUSED,
                                              .node    = place->device.node,
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
        // Of another size, too long, or against the protocol.
    }
    network_tell(network, &fault);
}

static void tell_drive_fault(canopen_network_t* const network, network_device_t* const place,
                             const uint16_t code)
{
    if (!place->is_faulty) {
        place->is_faulty = true;
        tell(network, NETWORK_DRIVE_FAULT, place->device.node, code);
    }
}

static void watch_presence(canopen_network_t* const network, network_device_t* const place)
{
    const canopen_device_t* const device = &place->device;
    const master_node_t* const node      = &network->master.nodes[device->index];
    const flow_can_health_t* const bus   = &network->flow.health;
    const uint32_t silence               = network->is_running ? device_silence(device) : 0U;
    if (silence > 0U) {
        place->missed++;
    }
    const bool is_gone = (silence >= network->config.lost_after_syncs) || node->is_heartbeat_lost ||
                         (node->boots != device->boots) || (bus->state == FLOW_CAN_BUS_OFF) ||
                         bus->is_unacknowledged;
    if (is_gone && !place->is_lost) {
        place->is_lost = true;
        tell(network, NETWORK_DEVICE_LOST, device->node, 0U);
    }
}

static void watch_axes(canopen_network_t* const network, network_device_t* const place)
{
    for (uint8_t i = 0U; i < place->device.profile->axis_count; i++) {
        cia402_axis_t* const axis = &place->device.axes[i];
        cia402_axis_observe(axis);
        const cia402_state_t state = cia402_axis_state(axis);
        const bool is_in_fault     = (state == CIA402_FAULT) || (state == CIA402_FAULT_REACTION);
        if (axis->has_dropped || (is_in_fault && !axis->may_reset_fault)) {
            tell_drive_fault(network, place, axis->statusword);
        }
    }
}

static void take_emergencies(canopen_network_t* const network)
{
    emergency_t emergency;
    while (master_take_emergency(&network->master, &emergency) == STATUS_OK) {
        uint8_t index = 0U;
        if (!network->is_booted || (network_find(network, emergency.node, &index) != STATUS_OK)) {
            continue; // The life of a node before it was commissioned does not matter.
        }
        switch (emergency_class(emergency.code)) {
        case EMERGENCY_HIGH:
            tell_drive_fault(network, &network->devices[index], emergency.code);
            break;
        case EMERGENCY_MEDIUM:
            tell(network, NETWORK_DRIVE_WARNING, emergency.node, emergency.code);
            break;
        case EMERGENCY_LOW:
            tell(network, NETWORK_BUS_WARNING, emergency.node, emergency.code);
            break;
        case EMERGENCY_CLEARED:
        default:
            break;
        }
    }
}

static void watch_bus(canopen_network_t* const network)
{
    const flow_can_state_t state = network->flow.health.state;
    if (network->is_booted && (state > network->told_bus_state)) {
        tell(network, NETWORK_BUS_WARNING, 0U, (uint16_t)state);
    }
    network->told_bus_state = state;
}

void network_sense(canopen_network_t* const network, const uint64_t now_ns)
{
    FSW_ASSERT(network != NULL);
    if (!flow_can_is_open(&network->flow)) {
        return;
    }
    flow_can_attend(&network->flow, now_ns);
    master_receive(&network->master, now_ns);
    take_emergencies(network);
    watch_bus(network);
    for (uint8_t i = 0U; network->is_booted && (i < network->device_count); i++) {
        network_device_t* const place = &network->devices[i];
        watch_presence(network, place);
        if (network->is_running && !place->is_lost) {
            watch_axes(network, place);
        }
    }
}

status_t network_take_fault(canopen_network_t* const network, network_fault_t* const out_fault)
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
