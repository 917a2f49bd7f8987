// SPDX-License-Identifier: Apache-2.0
/// A power unit: latching relays that switch the supply of nodes. Each relay has a coil that closes it and a
/// coil that opens it.
///
/// The unit receives process data at 0x200 + its node id and sends no frame and no acknowledge bit. Such a
/// frame commands a pulse on an output line: line (u16, lowest octet first), exponent (u8, 0..7). The pulse
/// lasts POWER_UNIT_PULSE_NS x 2^exponent. Line 2k - 1 closes the relay of the k-th node, line 2k opens it. A
/// relay moves when its coil has had current for POWER_UNIT_LATCH_NS, so that a shorter pulse has no effect.
/// Other frames are ignored.
///
/// Ownership  The caller provides power_unit_t; the nodes outlive it.
/// Context    One task.
/// Time       Simulated time, as an argument or that of the frame.
#ifndef SIM_DEVICES_POWER_UNIT_H
#define SIM_DEVICES_POWER_UNIT_H

#include "osal/include/osal/can.h"
#include "sim/devices/node.h"

#include <stdbool.h>
#include <stdint.h>

#define POWER_UNIT_RELAYS_MAX 4U
#define POWER_UNIT_PULSE_NS 10000000U ///< Length of a pulse with exponent 0.
#define POWER_UNIT_LATCH_NS 20000000U ///< Shortest pulse that moves a relay.

struct power_unit;

/// A channel of the bus on which the unit receives.
typedef struct {
    struct power_unit* unit;
    unsigned channel; ///< NODE_CHANNEL_A, _B.
} power_unit_port_t;

typedef struct power_unit { // Private, except port.
    power_unit_port_t port[NODE_CHANNELS];
    bool is_unplugged;
    bool is_cut[NODE_CHANNELS];
    uint8_t id;
    unsigned count;
    node_t* node[POWER_UNIT_RELAYS_MAX];
    // Time at which each line moves its relay; BUS_NEVER: no pulse.
    uint64_t move_ns[2U * POWER_UNIT_RELAYS_MAX];
} power_unit_t;

/// Initialize the unit with all relays closed.
void power_unit_init(power_unit_t* unit, uint8_t id);
/// Connect the next relay to the supply of this node; at most POWER_UNIT_RELAYS_MAX relays.
void power_unit_add(power_unit_t* unit, node_t* node);
/// Process a frame on a channel of the bus of the unit.
void power_unit_receive(const power_unit_port_t* port, const osal_can_frame_t* frame);
/// Set by a scenario: connect or disconnect the unit. Pulses end; the relays keep their positions.
void power_unit_plug(power_unit_t* unit, bool is_connected);
/// Set by a scenario: disconnect one channel only, or connect it again.
void power_unit_cut(power_unit_t* unit, unsigned channel, bool is_cut);
/// Set by a scenario: restart the unit. Pulses end.
void power_unit_reset(power_unit_t* unit);
/// Move the relays that are due at `now_ns`, the present time of the nodes' buses.
void power_unit_step(power_unit_t* unit, uint64_t now_ns);

#endif // SIM_DEVICES_POWER_UNIT_H
