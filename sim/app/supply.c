// SPDX-License-Identifier: Apache-2.0
#include "sim/app/supply.h"

#include <string.h>

static void receive_frame(void* const context, const osal_can_frame_t* const frame)
{
    power_unit_receive(context, frame);
}

void supply_open(power_unit_t* const unit, const world_power_unit_t* const description,
                 segment_t* const segments, const unsigned segment_count, const bus_t* const channel_b,
                 const devices_t* const devices)
{
    power_unit_init(unit, (uint8_t)description->device.node);
    for (unsigned i = 0U; i < segment_count; i++) {
        const bool is_channel_b = (channel_b != NULL) && (segments[i].bus == channel_b);
        if (is_channel_b || (i == description->device.bus)) {
            segments[i].listen   = receive_frame;
            segments[i].listener = &unit->port[is_channel_b ? NODE_CHANNEL_B : NODE_CHANNEL_A];
        }
    }
    for (size_t i = 0U; i < description->supply_count; i++) {
        for (size_t k = 0U; k < devices_count(devices); k++) {
            if (strcmp(device_entry(devices, k)->name, description->supply[i]) == 0) {
                power_unit_add(unit, device_model(devices, k)->node);
            }
        }
    }
}
