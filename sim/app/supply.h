// SPDX-License-Identifier: Apache-2.0
/// Connects the power unit of a world. The unit receives on both channels of its bus, but is not a node of
/// the bus.
#ifndef SIM_APP_SUPPLY_H
#define SIM_APP_SUPPLY_H

#include "sim/app/devices.h"
#include "sim/app/segment.h"
#include "sim/devices/power_unit.h"

/// Connect the unit to its segment and to that of `channel_b` (null: there is none), and to the devices that
/// it supplies, in their order. The unit must not be moved afterwards.
void supply_open(power_unit_t* unit, const world_power_unit_t* description, segment_t* segments,
                 unsigned segment_count, const bus_t* channel_b, const devices_t* devices);

#endif // SIM_APP_SUPPLY_H
