// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/power_unit.h"

#define PROCESS_DATA_ID 0x200U
#define PULSE_OCTETS 3U
#define EXPONENT_MAX 7U

void power_unit_reset(power_unit_t* const unit)
{
    for (unsigned i = 0U; i < (2U * POWER_UNIT_RELAYS_MAX); i++) {
        unit->move_ns[i] = BUS_NEVER;
    }
}

void power_unit_init(power_unit_t* const unit, const uint8_t id)
{
    *unit = (power_unit_t){.id = id};
    for (unsigned i = 0U; i < NODE_CHANNELS; i++) {
        unit->port[i] = (power_unit_port_t){unit, i};
    }
    power_unit_reset(unit);
}

void power_unit_plug(power_unit_t* const unit, const bool is_connected)
{
    unit->is_unplugged = !is_connected;
    power_unit_reset(unit);
}

void power_unit_cut(power_unit_t* const unit, const unsigned channel, const bool is_cut)
{
    unit->is_cut[channel] = is_cut;
}

void power_unit_add(power_unit_t* const unit, node_t* const node)
{
    if (unit->count < POWER_UNIT_RELAYS_MAX) {
        unit->node[unit->count] = node;
        unit->count++;
    }
}

void power_unit_receive(const power_unit_port_t* const port, const osal_can_frame_t* const frame)
{
    power_unit_t* unit = port->unit;
    if (unit->is_unplugged || unit->is_cut[port->channel]) {
        return;
    }
    if ((frame->id != (PROCESS_DATA_ID + unit->id)) || (frame->length != PULSE_OCTETS) ||
        (frame->data[2] > EXPONENT_MAX)) {
        return;
    }
    const unsigned line      = (unsigned)frame->data[0] | ((unsigned)frame->data[1] << 8U);
    const uint64_t length_ns = (uint64_t)POWER_UNIT_PULSE_NS << frame->data[2];
    if ((line >= 1U) && (line <= (2U * unit->count)) && (length_ns >= POWER_UNIT_LATCH_NS)) {
        unit->move_ns[line - 1U] = frame->time_ns + POWER_UNIT_LATCH_NS;
    }
}

void power_unit_step(power_unit_t* const unit, const uint64_t now_ns)
{
    for (unsigned i = 0U; i < (2U * unit->count); i++) {
        if (unit->move_ns[i] > now_ns) {
            continue;
        }
        node_t* node      = unit->node[i / 2U];
        const bool closes = (i % 2U) == 0U;
        unit->move_ns[i]  = BUS_NEVER;
        if (closes == node_is_powered(node)) {
            continue; // The relay is already in that position.
        }
        if (closes) {
            node_power_on(node);
        } else {
            node_power_off(node);
        }
    }
}
