// SPDX-License-Identifier: Apache-2.0
#include "sim/app/supply.h"

static void hear(void* const context, const osal_can_frame_t* const frame)
{
    power_unit_hear(context, frame);
}

void supply_open(power_unit_t* const unit, segment_t* const segments, const unsigned segment_count,
                 const unsigned arm, const bus_t* const channel_b, drive_t* const* const drives,
                 const unsigned drive_count)
{
    power_unit_init(unit, SUPPLY_NODE);
    for (unsigned i = 0U; i < segment_count; i++) {
        if ((i == arm) || ((channel_b != NULL) && (segments[i].bus == channel_b))) {
            segments[i].listen   = hear;
            segments[i].listener = unit;
        }
    }
    for (unsigned i = 0U; i < drive_count; i++) {
        power_unit_add(unit, drive_node(drives[i]));
    }
}
