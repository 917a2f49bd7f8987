// SPDX-License-Identifier: Apache-2.0
/// The power unit of the arm: node SUPPLY_NODE, on both channels of its bus.
#ifndef SIM_APP_SUPPLY_H
#define SIM_APP_SUPPLY_H

#include "sim/app/segment.h"
#include "sim/devices/drive.h"
#include "sim/devices/power_unit.h"

#define SUPPLY_NODE 0x1FU

/// Let it listen on segment `arm` and on that of `channel_b` (null: there is none), and supply the drives in
/// their order. The unit must not be moved afterwards.
void supply_open(power_unit_t* unit, segment_t* segments, unsigned segment_count, unsigned arm,
                 const bus_t* channel_b, drive_t* const* drives, unsigned drive_count);

#endif // SIM_APP_SUPPLY_H
