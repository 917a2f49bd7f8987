// SPDX-License-Identifier: Apache-2.0
/// The buses of a run: those of its world and of its configuration, and their redundant channels.
#ifndef SIM_APP_CHANNELS_H
#define SIM_APP_CHANNELS_H

#include "sim/app/segment.h"
#include "sim/app/simulator.h"
#include "sim/devices/node.h"
#include "sim/world/world.h"

/// Returns the name of bus `index`: first the buses of the world, then the others in the order of the
/// configuration. Null: there are fewer.
const char* channels_bus_name(const world_t* world, const simulator_config_t* config, unsigned index);
/// Print a line for each bus that programs of this run cannot use, because only the world has it. If the run
/// has no programs (no bus in the configuration), print nothing.
void channels_report_unused(const segment_t* segments, unsigned count, const simulator_config_t* config);
/// Create the channels B of the configuration. out_channel_b has `count` entries, one per segment, initially
/// null. STATUS_OK; else `error` is filled: STATUS_INVALID (no such bus, or it has a channel B already).
MUST_USE status_t channels_pair(const segment_t* segments, unsigned count, const simulator_config_t* config,
                                bus_t** out_channel_b, char error[SIMULATOR_ERROR_MAX]);
/// Connect a node to channel B of its bus. No effect if `channel_b` is null, because the bus then has none.
/// STATUS_OK; else `error` is filled: STATUS_EXHAUSTED.
MUST_USE status_t channels_connect(node_t* node, bus_t* channel_b, const char* bus_name,
                                   char error[SIMULATOR_ERROR_MAX]);

#endif // SIM_APP_CHANNELS_H
