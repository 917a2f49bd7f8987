// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_fitting.h"

#include "fsw/canopen/network.h"
#include "fsw/drives/drives.h"
#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

static bool refuse(subsystem_misfit_t* const misfit, const uint32_t line, const char* const says)
{
    *misfit = (subsystem_misfit_t){line, says};
    return false;
}

/// One end node, on CAN. `first` is that of the first device, or null: this is it.
static bool endnode_fits(const subsystem_descriptor_t* const descriptor,
                         const descriptor_device_t* const device, const descriptor_endnode_t** const first,
                         subsystem_misfit_t* const out_misfit)
{
    if (device->endnode_count == 0U) {
        return refuse(out_misfit, device->line, "<Device> has no <Endnode type=\"CAN\">");
    }
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
    if (endnode->type != DESCRIPTOR_ENDNODE_CAN) {
        return refuse(out_misfit, endnode->line,
                      "type of <Endnode>: expected CAN, by which this subsystem reaches its devices");
    }
    if (device->endnode_count > 1U) {
        return refuse(out_misfit, descriptor->endnodes[device->first_endnode + 1U].line,
                      "a second <Endnode>: expected one, channel B is its redundantBus");
    }
    *first = (*first == NULL) ? endnode : *first;
    if ((strcmp((*first)->bus, endnode->bus) != 0) ||
        (strcmp((*first)->redundant_bus, endnode->redundant_bus) != 0)) {
        return refuse(out_misfit, endnode->line,
                      "bus of <Endnode>: expected bus and redundantBus of the subsystem's first device");
    }
    return true;
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

static bool configuration_fits(const subsystem_descriptor_t* const descriptor,
                               const descriptor_configuration_t* const configuration,
                               const drives_need_t* const need, subsystem_misfit_t* const out_misfit)
{
    const descriptor_device_t* const devices = &descriptor->devices[configuration->first_device];
    if (configuration->device_count != need->count) {
        return refuse(out_misfit, configuration->line, need->says_count);
    }
    for (uint16_t i = 0U; i < configuration->device_count; i++) {
        if (strcmp(devices[i].type, need->type) != 0) {
            return refuse(out_misfit, devices[i].line, need->says_type);
        }
        if (devices[i].setting_count > NETWORK_SETTINGS_MAX) {
            return refuse(out_misfit, devices[i].line, "too many <Setting> of one <Device>, at most 32");
        }
        const int mode = drives_mode(descriptor, &devices[i]);
        if (!is_one_of(need->modes, mode) || (mode != drives_mode(descriptor, &devices[0]))) {
            return refuse(out_misfit, devices[i].line, need->says_mode);
        }
    }
    return true;
}

/// Every node of every configuration is brought up, each once.
static bool nodes_fit(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    const descriptor_endnode_t* first  = NULL;
    uint8_t nodes[NETWORK_DEVICES_MAX] = {0U};
    uint8_t count                      = 0U;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        const descriptor_device_t* const device = &descriptor->devices[i];
        if (!endnode_fits(descriptor, device, &first, out_misfit)) {
            return false;
        }
        const uint8_t node = descriptor->endnodes[device->first_endnode].node;
        if (memchr(nodes, node, count) != NULL) {
            continue;
        }
        if (count == NETWORK_DEVICES_MAX) {
            return refuse(out_misfit, device->line, "too many nodes of one subsystem, at most 4");
        }
        nodes[count] = node;
        count++;
    }
    return true;
}

bool drives_fit(const subsystem_descriptor_t* const descriptor, const drives_need_t* const need,
                subsystem_misfit_t* const out_misfit)
{
    FSW_ASSERT((descriptor != NULL) && (need != NULL) && (out_misfit != NULL));
    bool fits = nodes_fit(descriptor, out_misfit);
    for (uint16_t i = 0U; fits && (i < descriptor->configuration_count); i++) {
        fits = configuration_fits(descriptor, &descriptor->configurations[i], need, out_misfit);
    }
    return fits;
}

const descriptor_endnode_t* drives_endnode(const subsystem_descriptor_t* const descriptor,
                                           const descriptor_device_t* const device)
{
    FSW_ASSERT((descriptor != NULL) && (device != NULL) && (device->endnode_count == 1U));
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
    FSW_ASSERT(endnode->type == DESCRIPTOR_ENDNODE_CAN);
    return endnode;
}
