// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_supply.h"

#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"

#define UNIT_SHIFT 8U
#define LINE_MASK 0xFFU
#define PROCESS_DATA_ID 0x200U
#define PULSE_OCTETS 3U

typedef struct {
    uint16_t unit;
    uint16_t line;
    uint8_t exponent;
} pulse_t;

static pulse_t pulse_of(const pus_device_action_t* const action)
{
    if (action->kind == PUS_DEVICE_SWITCH) {
        return (pulse_t){.unit     = (uint16_t)(action->device >> UNIT_SHIFT),
                         .line     = (uint16_t)(action->device & LINE_MASK),
                         .exponent = DRIVES_SUPPLY_EXPONENT};
    }
    return (pulse_t){.unit = action->device, .line = action->command, .exponent = action->exponent};
}

/// True if the line of the pulse switches the device of the supply.
static bool is_switched_by(const descriptor_supply_t* const supply, const pulse_t* const pulse)
{
    return (supply->unit == pulse->unit) && ((supply->on == pulse->line) || (supply->off == pulse->line));
}

bool drives_supply_is(const pus_device_action_t* const action)
{
    FSW_ASSERT(action != NULL);
    return (action->kind == PUS_DEVICE_SWITCH) || (action->kind == PUS_DEVICE_PULSE);
}

status_t drives_supply_check(const drives_t* const drives, const pus_device_action_t* const action)
{
    FSW_ASSERT((drives != NULL) && drives_supply_is(action));
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    const pulse_t pulse                            = pulse_of(action);
    bool has_unit                                  = false;
    bool has_line                                  = false;
    for (uint16_t i = 0U; i < descriptor->supply_count; i++) {
        const descriptor_supply_t* const supply = &descriptor->supplies[i];
        has_unit                                = has_unit || (supply->unit == pulse.unit);
        has_line                                = has_line || is_switched_by(supply, &pulse);
    }
    if (!has_line) {
        return (has_unit && (action->kind == PUS_DEVICE_PULSE)) ? STATUS_OUT_OF_RANGE : STATUS_NOT_FOUND;
    }
    return STATUS_OK;
}

/// Returns the end node of the first device that a pulse switches; the power unit is on the same bus.
static const descriptor_endnode_t* endnode_of(const drives_t* const drives, const pulse_t* const pulse)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    const descriptor_endnode_t* endnode            = NULL;
    for (uint16_t i = 0U; (endnode == NULL) && (i < descriptor->device_count); i++) {
        const descriptor_device_t* const device = &descriptor->devices[i];
        for (uint16_t k = 0U; k < device->supply_count; k++) {
            if (is_switched_by(&descriptor->supplies[device->first_supply + k], pulse)) {
                endnode = drives_endnode(descriptor, device);
            }
        }
    }
    FSW_ASSERT(endnode != NULL); // The check of the request has found the pulse in the descriptor.
    return endnode;
}

status_t drives_supply_send(drives_t* const drives, const pus_device_action_t* const action)
{
    FSW_ASSERT((drives != NULL) && drives_supply_is(action));
    const pulse_t pulse                       = pulse_of(action);
    const uint8_t octets[PULSE_OCTETS]        = {(uint8_t)(pulse.line & LINE_MASK),
                                                 (uint8_t)(pulse.line >> UNIT_SHIFT), pulse.exponent};
    const uint16_t identifier                 = (uint16_t)(PROCESS_DATA_ID + pulse.unit);
    drives->access.pulse_end_ns               = subsystem_now_ns(drives->generic) + DRIVES_SUPPLY_LEAVE_NS;
    const status_t status                     = drives_borrow(drives);
    const descriptor_endnode_t* const endnode = endnode_of(drives, &pulse);
    return (status == STATUS_OK)
               ? flow_can_send(drives_network(drives, endnode)->flow, identifier, octets, PULSE_OCTETS)
               : status;
}

status_t drives_supply_poll(drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    if (subsystem_now_ns(drives->generic) < drives->access.pulse_end_ns) {
        return STATUS_BUSY;
    }
    drives_give_back(drives);
    return STATUS_OK;
}
