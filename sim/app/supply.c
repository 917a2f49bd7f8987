// SPDX-License-Identifier: Apache-2.0
#include "sim/app/supply.h"

static void hear(void* context, const osal_can_frame_t* frame)
{
    power_unit_hear(context, frame);
}

void supply_open(power_unit_t* unit, segment_t* segments, unsigned segment_count, unsigned arm,
                 const bus_t* channel_b, drive_t* const* drives, unsigned drive_count)
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
