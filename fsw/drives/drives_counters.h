// SPDX-License-Identifier: Apache-2.0
/// Counters of a subsystem with drives: its cycles, frames on its bus, commands, links and refusals, for the
/// parameter COUNTERS. The descriptor names those that are published, by the names in drives_counters.c, each
/// a UINT32; PDO_MISSED is one for each device of the configuration.
#ifndef FSW_DRIVES_DRIVES_COUNTERS_H
#define FSW_DRIVES_DRIVES_COUNTERS_H

#include "fsw/drives/drives.h"

/// Once, in software_init: where the counters are published. `storage` is that of the parameter; other fields
/// than UINT32 of a known name are left alone.
void drives_counters_place(drives_t* drives, const parameter_definition_t* definition, void* storage);
/// Each cycle, between parameter_lock and parameter_unlock. `limited` is added to the COMMAND_LIMITED of the
/// axes.
void drives_counters_publish(drives_t* drives, uint32_t limited);

#endif // FSW_DRIVES_DRIVES_COUNTERS_H
