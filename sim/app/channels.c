// SPDX-License-Identifier: Apache-2.0
#include "sim/app/channels.h"

#include <stdio.h>
#include <string.h>

#include "osal/include/osal/console.h"

static bool is_of_world(const world_t* const world, const char* const name)
{
    size_t index = 0U;
    while ((index < world->bus_count) && (strcmp(world->bus[index], name) != 0)) {
        index++;
    }
    return index < world->bus_count;
}

const char* channels_bus_name(const world_t* const world, const simulator_config_t* const config,
                              const unsigned index)
{
    size_t others = world->bus_count;
    if (index < world->bus_count) {
        return world->bus[index];
    }
    for (size_t i = 0U; i < config->bus_count; i++) {
        if (!is_of_world(world, config->bus[i].name)) {
            if (others == index) {
                return config->bus[i].name;
            }
            others++;
        }
    }
    return NULL;
}

/// Returns the index of the bus with this name, or `count` if there is none.
static unsigned find_segment(const segment_t* const segments, const unsigned count, const char* const name)
{
    unsigned index = 0U;
    while ((index < count) && (strcmp(segments[index].name, name) != 0)) {
        index++;
    }
    return index;
}

void channels_report_unused(const segment_t* const segments, const unsigned count,
                            const simulator_config_t* const config)
{
    char line[SIMULATOR_ERROR_MAX];
    for (unsigned i = 0U; (i < count) && (config->bus_count > 0U); i++) {
        size_t k = 0U;
        while ((k < config->bus_count) && (strcmp(config->bus[k].name, segments[i].name) != 0)) {
            k++;
        }
        if (k == config->bus_count) {
            (void)snprintf(
                line, sizeof line,
                "simulator: %.200s: no program of this run is on bus %s, which has devices in this "
                "world; the mission lists its buses",
                config->world_path, segments[i].name);
            osal_console_print_error(line);
        }
    }
}

status_t channels_pair(const segment_t* const segments, const unsigned count,
                       const simulator_config_t* const config, bus_t** const out_channel_b,
                       char error[SIMULATOR_ERROR_MAX])
{
    for (size_t i = 0U; i < config->bus_count; i++) {
        const simulator_bus_t* bus = &config->bus[i];
        if (bus->redundant_to == NULL) {
            continue;
        }
        const unsigned a = find_segment(segments, count, bus->redundant_to);
        const unsigned b = find_segment(segments, count, bus->name);
        if ((a == count) || (b == count) || (a == b) || (out_channel_b[a] != NULL)) {
            (void)snprintf(error, SIMULATOR_ERROR_MAX,
                           "simulator: bus %s cannot be the redundant channel of %s: expected another bus of "
                           "this run that has no channel B yet",
                           bus->name, bus->redundant_to);
            return STATUS_INVALID;
        }
        out_channel_b[a] = segments[b].bus;
    }
    return STATUS_OK;
}

status_t channels_connect(node_t* const node, bus_t* const channel_b, const char* const bus_name,
                          char error[SIMULATOR_ERROR_MAX])
{
    const status_t status = (channel_b != NULL) ? node_add_channel(node, channel_b) : STATUS_OK;
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: no room for node 0x%02X on channel B of bus %s: expected at most %u "
                       "controllers; remove a device from the world",
                       (unsigned)node_id(node), bus_name, BUS_NODES_MAX);
    }
    return status;
}
