// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_fitting.h"

#include "fsw/canopen/network.h"
#include "fsw/drives/drives.h"
#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

#define OBJECT_MODE_OF_OPERATION 0x6060U
#define OBJECT_INTERPOLATION_PERIOD 0x60C2U
#define AXIS_OFFSET 0x800U
#define MODE_CYCLIC_POSITION 8U
#define PERIOD_EXPONENT_MIN (-6) // Cycles are whole microseconds.
#define PERIOD_EXPONENT_MAX 1

static bool refuse(subsystem_misfit_t* const misfit, const uint32_t line, const char* const reason)
{
    *misfit = (subsystem_misfit_t){line, reason, 0U};
    return false;
}

/// Refuse items that exceed a capacity.
static bool refuse_above(subsystem_misfit_t* const misfit, const uint32_t line, const char* const items,
                         const uint32_t most)
{
    *misfit = (subsystem_misfit_t){line, items, most};
    return false;
}

typedef struct { // Nodes of all configurations, each listed once, and their buses.
    const descriptor_endnode_t* nodes[DRIVES_DEVICES_MAX];
    uint8_t node_count;
    uint8_t bus_count;
} nodes_t;

/// Check that the device has exactly one end node, and that it is on CAN.
static bool endnode_fits(const subsystem_descriptor_t* const descriptor,
                         const descriptor_device_t* const device, subsystem_misfit_t* const out_misfit)
{
    if (device->endnode_count == 0U) {
        return refuse(out_misfit, device->line, "<Device> has no <Endnode type=\"CAN\">");
    }
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
    if (endnode->type != DESCRIPTOR_ENDNODE_CAN) {
        return refuse(out_misfit, endnode->line, "type of <Endnode>: expected CAN");
    }
    if (device->endnode_count > 1U) {
        return refuse(out_misfit, descriptor->endnodes[device->first_endnode + 1U].line,
                      "a second <Endnode>: expected one, channel B is its redundantBus");
    }
    return true;
}

/// Add a node, unless it is already listed.
static bool node_fits(nodes_t* const nodes, const descriptor_endnode_t* const endnode,
                      subsystem_misfit_t* const out_misfit)
{
    uint8_t on_bus = 0U;
    for (uint8_t i = 0U; i < nodes->node_count; i++) {
        const descriptor_endnode_t* const other = nodes->nodes[i];
        const bool is_same_bus                  = strcmp(other->bus, endnode->bus) == 0;
        on_bus                                  = (uint8_t)(on_bus + (is_same_bus ? 1U : 0U));
        if ((strcmp(other->redundant_bus, endnode->bus) == 0) ||
            (strcmp(other->bus, endnode->redundant_bus) == 0)) {
            return refuse(out_misfit, endnode->line, "bus of <Endnode>: expected one that is no channel B");
        }
        if (is_same_bus && (strcmp(other->redundant_bus, endnode->redundant_bus) != 0)) {
            return refuse(out_misfit, endnode->line,
                          "redundantBus of <Endnode>: expected that of the first device on this bus");
        }
        if ((other->node == endnode->node) && !is_same_bus) {
            return refuse(out_misfit, endnode->line,
                          "node of <Endnode>: expected one that the subsystem has on no other bus");
        }
        if (other->node == endnode->node) {
            return true;
        }
    }
    nodes->bus_count = (uint8_t)(nodes->bus_count + ((on_bus == 0U) ? 1U : 0U));
    if (nodes->bus_count > DRIVES_BUSES_MAX) {
        return refuse_above(out_misfit, endnode->line, "buses of one subsystem", DRIVES_BUSES_MAX);
    }
    if (on_bus == NETWORK_DEVICES_MAX) {
        return refuse_above(out_misfit, endnode->line, "nodes on one bus", NETWORK_DEVICES_MAX);
    }
    if (nodes->node_count == DRIVES_DEVICES_MAX) {
        return refuse_above(out_misfit, endnode->line, "nodes of one subsystem", DRIVES_DEVICES_MAX);
    }
    nodes->nodes[nodes->node_count] = endnode;
    nodes->node_count++;
    return true;
}

int drives_mode(const subsystem_descriptor_t* const descriptor, const descriptor_device_t* const device)
{
    FSW_ASSERT((descriptor != NULL) && (device != NULL));
    int mode = 0;
    for (uint16_t i = 0U; i < device->setting_count; i++) {
        const descriptor_setting_t* const setting = &descriptor->settings[device->first_setting + i];
        if ((setting->index == OBJECT_MODE_OF_OPERATION) && (setting->subindex == 0U)) {
            mode = (int)(int8_t)(uint8_t)setting->bits;
        }
    }
    return mode;
}

static bool is_one_of(const int* const modes, const int mode)
{
    for (const int* next = modes; *next != 0; next++) {
        if (*next == mode) {
            return true;
        }
    }
    return false;
}

/// Returns the message about a setting that canopen_device_profile_map has refused with `status`.
static const char* reason_of(const status_t status)
{
    if (status == STATUS_FORBIDDEN) {
        return "<Setting>: expected the order of CiA 301: disable the PDO (bit 31 of its COB-ID), number of "
               "entries 0, entries, their number";
    }
    return (status == STATUS_NOT_FOUND) ? "<Setting>: expected a PDO of the class, and an object that its "
                                          "data sheet allows there, with "
                                          "its length"
                                        : "<Setting>: expected at most 8 entries of 8 octets together in a "
                                          "PDO, and 16 values of a device";
}

/// Check the settings of the mapping: each configuration must disable a PDO before it changes the PDO.
static bool mapping_fits(const subsystem_descriptor_t* const descriptor,
                         const descriptor_device_t* const device,
                         const canopen_device_profile_t* const profile, subsystem_misfit_t* const out_misfit)
{
    canopen_device_profile_t own = *profile;
    for (uint8_t i = 0U; i < PROFILE_PDOS_MAX; i++) {
        own.transmit[i].is_valid = true;
        own.receive[i].is_valid  = true;
    }
    for (uint16_t i = 0U; i < device->setting_count; i++) {
        const descriptor_setting_t* const setting = &descriptor->settings[device->first_setting + i];
        const status_t status =
            canopen_device_profile_map(&own, setting->index, setting->subindex, (uint32_t)setting->bits);
        if (status != STATUS_OK) {
            return refuse(out_misfit, setting->line, reason_of(status));
        }
    }
    return true;
}

/// Check that a setting of a unit has the value of the class, because commands and measurements are
/// converted with that unit.
static bool units_fit(const subsystem_descriptor_t* const descriptor, const descriptor_device_t* const device,
                      const canopen_device_profile_t* const profile, subsystem_misfit_t* const out_misfit)
{
    for (uint16_t i = 0U; i < device->setting_count; i++) {
        const descriptor_setting_t* const setting = &descriptor->settings[device->first_setting + i];
        for (uint8_t k = 0U; k < (profile->axis_count * PROFILE_UNITS_MAX); k++) {
            const canopen_profile_axis_t* const axis = &profile->axes[k / PROFILE_UNITS_MAX];
            const canopen_profile_unit_t* const unit = &axis->units[k % PROFILE_UNITS_MAX];
            const bool is_unit                       = ((k % PROFILE_UNITS_MAX) < axis->unit_count) &&
                                 (setting->index == unit->index) && (setting->subindex == unit->subindex);
            if (is_unit && ((uint32_t)setting->bits != unit->value)) {
                return refuse(out_misfit, setting->line,
                              "value of <Setting>: expected the unit of the data sheet");
            }
        }
    }
    return true;
}

/// Check the time over which an axis interpolates its set points, value x 10^exponent s. If a setting states
/// it, it is the cycle of the configuration. Otherwise the default of the class is at most the cycle, so that
/// the axis reaches each set point before the next one. A class without the object follows each set point at
/// its SYNC.
static bool period_fits(const subsystem_descriptor_t* const descriptor,
                        const descriptor_device_t* const device, const uint32_t axis,
                        const canopen_profile_axis_t* const profile, const uint32_t cycle_us,
                        subsystem_misfit_t* const out_misfit)
{
    uint32_t line     = 0U; // Of a setting of the period; 0 if there is none.
    uint32_t period   = profile->period;
    int8_t exponent   = profile->period_exponent;
    uint32_t mode     = 0U;
    const uint32_t at = axis * AXIS_OFFSET;
    for (uint16_t i = 0U; i < device->setting_count; i++) {
        const descriptor_setting_t* const setting = &descriptor->settings[device->first_setting + i];
        const uint32_t bits                       = (uint32_t)setting->bits;
        if (setting->index == (OBJECT_INTERPOLATION_PERIOD + at)) {
            line     = setting->line;
            period   = (setting->subindex == 1U) ? bits : period;
            exponent = (setting->subindex == 2U) ? (int8_t)(uint8_t)bits : exponent;
        }
        mode = (setting->index == (OBJECT_MODE_OF_OPERATION + at)) ? bits : mode;
    }
    const bool is_known = (exponent >= PERIOD_EXPONENT_MIN) && (exponent <= PERIOD_EXPONENT_MAX);
    for (; is_known && (exponent > PERIOD_EXPONENT_MIN); exponent--) {
        period *= 10U;
    }
    const bool is_short = (line == 0U) && ((period < cycle_us) || (mode != MODE_CYCLIC_POSITION));
    return is_short || (is_known && (period == cycle_us)) ||
           refuse(out_misfit, (line != 0U) ? line : device->line,
                  "0x60C2: expected samplingTime of the <Configuration>");
}

static bool periods_fit(const subsystem_descriptor_t* const descriptor,
                        const descriptor_configuration_t* const configuration,
                        const descriptor_device_t* const device, subsystem_misfit_t* const out_misfit)
{
    const canopen_device_profile_t* const profile = canopen_device_profile_find(device->type);
    bool fits                                     = true;
    for (uint8_t i = 0U; fits && (i < profile->axis_count); i++) {
        fits = period_fits(descriptor, device, i, &profile->axes[i], configuration->sampling_us, out_misfit);
    }
    return fits;
}

/// Returns the first setting of a device that changes a mapping; null if there is none.
static const descriptor_setting_t* mapping_setting(const subsystem_descriptor_t* const descriptor,
                                                   const descriptor_device_t* const device)
{
    for (uint16_t i = 0U; i < device->setting_count; i++) {
        const descriptor_setting_t* const setting = &descriptor->settings[device->first_setting + i];
        if (canopen_device_profile_is_mapping(setting->index)) {
            return setting;
        }
    }
    return NULL;
}

bool drives_is_mapped(const subsystem_descriptor_t* const descriptor, const uint8_t node)
{
    FSW_ASSERT(descriptor != NULL);
    bool is_mapped = false;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        const descriptor_device_t* const device   = &descriptor->devices[i];
        const descriptor_endnode_t* const endnode = drives_endnode(descriptor, device);
        is_mapped = is_mapped || ((endnode != NULL) && (endnode->node == node) &&
                                  (mapping_setting(descriptor, device) != NULL));
    }
    return is_mapped;
}

/// Check the number of nodes whose mapping is changed by a configuration; each node counts once.
static bool mappings_fit(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    uint8_t nodes[DRIVES_MAPPINGS_MAX];
    uint8_t count = 0U;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        const descriptor_setting_t* const setting = mapping_setting(descriptor, &descriptor->devices[i]);
        const descriptor_endnode_t* const endnode = drives_endnode(descriptor, &descriptor->devices[i]);
        if ((endnode == NULL) || (setting == NULL) ||
            ((count > 0U) && (memchr(nodes, endnode->node, count) != NULL))) {
            continue;
        }
        if (count == DRIVES_MAPPINGS_MAX) {
            return refuse_above(out_misfit, setting->line,
                                "devices whose <Setting> changes the mapping of their class",
                                DRIVES_MAPPINGS_MAX);
        }
        nodes[count] = endnode->node;
        count++;
    }
    return true;
}

static bool device_fits(const subsystem_descriptor_t* const descriptor,
                        const descriptor_device_t* const device, const drives_need_t* const need,
                        const int first_mode, subsystem_misfit_t* const out_misfit)
{
    const canopen_device_profile_t* const profile = canopen_device_profile_find(device->type);
    if (profile == NULL) {
        return refuse(out_misfit, device->line, canopen_device_classes.refusal);
    }
    const bool is_module = need->takes_modules && (profile->axis_count == 0U);
    const bool is_drive  = (profile->profile == PROFILE_DRIVE) && (profile->axis_count == need->axes);
    if (!is_module && !is_drive) {
        return refuse(out_misfit, device->line, need->reason_type);
    }
    if (device->setting_count > NETWORK_SETTINGS_MAX) {
        return refuse(out_misfit, device->line, "too many <Setting> of one <Device>, at most 32");
    }
    if (!mapping_fits(descriptor, device, profile, out_misfit) ||
        !units_fit(descriptor, device, profile, out_misfit)) {
        return false;
    }
    const int mode     = drives_mode(descriptor, device);
    const bool is_same = need->takes_modules || (mode == first_mode);
    if (!is_module && (!is_one_of(need->modes, mode) || !is_same)) {
        return refuse(out_misfit, device->line, need->reason_mode);
    }
    return true;
}

/// Check that no earlier device of the configuration is the same node: commands of one would move the other.
static bool is_only_device_of_node(const subsystem_descriptor_t* const descriptor,
                                   const descriptor_configuration_t* const configuration,
                                   const descriptor_device_t* const device,
                                   subsystem_misfit_t* const out_misfit)
{
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
    for (const descriptor_device_t* earlier = &descriptor->devices[configuration->first_device];
         earlier != device; earlier++) {
        const descriptor_endnode_t* const other = drives_endnode(descriptor, earlier);
        if ((other != NULL) && (other->node == endnode->node)) {
            return refuse(out_misfit, endnode->line,
                          "node of <Endnode>: expected one that no device above has");
        }
    }
    return true;
}

static bool configuration_fits(const subsystem_descriptor_t* const descriptor,
                               const descriptor_configuration_t* const configuration,
                               const drives_need_t* const need, subsystem_misfit_t* const out_misfit)
{
    const descriptor_device_t* const devices = &descriptor->devices[configuration->first_device];
    uint16_t count                           = 0U; // Devices on CAN.
    int first_mode                           = 0;
    bool fits                                = true;
    for (uint16_t i = 0U; fits && (i < configuration->device_count); i++) {
        if (!descriptor_is_stream(&devices[i]) || !need->permits_streams) {
            first_mode = (count == 0U) ? drives_mode(descriptor, &devices[i]) : first_mode;
            fits       = device_fits(descriptor, &devices[i], need, first_mode, out_misfit) &&
                   periods_fit(descriptor, configuration, &devices[i], out_misfit) &&
                   is_only_device_of_node(descriptor, configuration, &devices[i], out_misfit);
            count++;
        }
    }
    const bool is_count = (need->count > 0U) ? (count == need->count) : (count > 0U);
    return (fits && !is_count) ? refuse(out_misfit, configuration->line, need->reason_count) : fits;
}

/// True if all nodes of all configurations, each counted once, can be brought up together.
static bool nodes_fit(const subsystem_descriptor_t* const descriptor, const drives_need_t* const need,
                      subsystem_misfit_t* const out_misfit)
{
    nodes_t nodes = {.node_count = 0U};
    bool fits     = true;
    for (uint16_t i = 0U; fits && (i < descriptor->device_count); i++) {
        const descriptor_device_t* const device = &descriptor->devices[i];
        if (!descriptor_is_stream(device) || !need->permits_streams) {
            fits = endnode_fits(descriptor, device, out_misfit) &&
                   node_fits(&nodes, &descriptor->endnodes[device->first_endnode], out_misfit);
        }
    }
    return fits;
}

bool drives_fit(const subsystem_descriptor_t* const descriptor, const drives_need_t* const need,
                subsystem_misfit_t* const out_misfit)
{
    FSW_ASSERT((descriptor != NULL) && (need != NULL) && (out_misfit != NULL));
    bool fits = nodes_fit(descriptor, need, out_misfit) && mappings_fit(descriptor, out_misfit);
    for (uint16_t i = 0U; fits && (i < descriptor->configuration_count); i++) {
        fits = configuration_fits(descriptor, &descriptor->configurations[i], need, out_misfit);
    }
    return fits;
}

const descriptor_endnode_t* drives_endnode(const subsystem_descriptor_t* const descriptor,
                                           const descriptor_device_t* const device)
{
    FSW_ASSERT((descriptor != NULL) && (device != NULL));
    if (descriptor_is_stream(device)) {
        return NULL;
    }
    FSW_ASSERT(device->endnode_count == 1U);
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
    FSW_ASSERT(endnode->type == DESCRIPTOR_ENDNODE_CAN);
    return endnode;
}
