// SPDX-License-Identifier: Apache-2.0
/// Counters of a subsystem with drives: its cycles, frames on all its buses, commands, links and refusals,
/// for the parameter COUNTERS. The descriptor selects the published ones by the names in drives_counters.c;
/// each is a UINT32. PDO_MISSED has one counter for each device of the configuration on CAN, then zeros.
#ifndef FSW_DRIVES_DRIVES_COUNTERS_H
#define FSW_DRIVES_DRIVES_COUNTERS_H

#include "fsw/drives/drives.h"

/// Call once, in software_init. `storage` is that of the parameter; drives_counters_publish writes only its
/// UINT32 fields with a known name.
void drives_counters_bind(drives_t* drives, const parameter_definition_t* definition, void* storage);
/// Call in each cycle, between parameter_lock and parameter_unlock. `limited` is the number of commands that
/// the subsystem itself has limited; COMMAND_LIMITED also counts those that the axes have limited.
void drives_counters_publish(drives_t* drives, uint32_t limited);

#endif // FSW_DRIVES_DRIVES_COUNTERS_H
