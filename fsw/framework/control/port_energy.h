// SPDX-License-Identifier: Apache-2.0
/// Energy that a port with two axes takes in, and a watch on it: at rest a passive port gives nothing away. A
/// loop that oscillates does, although its mean force and position are right.
///
/// Two ports that a link with delay connects tell each other the energy that they have received since they
/// were engaged: a sum that does not fall, so a lost or late sample delays energy and never adds any. What
/// has arrived is a reserve, which the other port may give away.
///
/// Ownership  The caller places control_port_energy_t and control_reserve_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_CONTROL_PORT_ENERGY_H
#define FSW_FRAMEWORK_CONTROL_PORT_ENERGY_H

#include <stdbool.h>

#define CONTROL_PORT_AXES 2U

typedef struct {
    double limit_j;  ///< May be given away in `time_s` at rest.
    double time_s;   ///< Length of a window; windows follow each other.
    double rest_rad; ///< An axis that moves further is not at rest; a new window begins there.
    double period_s;
} control_port_watch_t;

typedef struct { // Read-only outside.
    bool is_started;
    double taken_j;    ///< Taken in, minus given away.
    double given_j;    ///< Given away; does not fall.
    double received_j; ///< Taken in, without what it has given away; does not fall.
    double position_rad[CONTROL_PORT_AXES];
    double begin_rad[CONTROL_PORT_AXES]; ///< When the window began.
    double begin_j;
    double elapsed_s;
} control_port_energy_t;

typedef struct { // Read-only outside; all zero at the start.
    bool is_started;
    double told_j;    ///< Latest sum of the other port.
    double reserve_j; ///< May be given away; below 0: more was given away than had arrived.
} control_reserve_t;

/// All sums zero.
void control_port_energy_reset(control_port_energy_t* energy);
/// One cycle: position, and the torque by which the other side has driven the port since the last cycle.
/// Returns what was given away in a window that ends now and passes the limit [J], else 0.
double control_port_energy_step(control_port_energy_t* energy, const control_port_watch_t* watch,
                                const double torque_nm[CONTROL_PORT_AXES],
                                const double position_rad[CONTROL_PORT_AXES]);
/// Read the sum of the other port and add its increase to the reserve. The first sum adds nothing, and
/// neither does a sum that has fallen (the other port was reset) or is NaN.
void control_reserve_take_sum(control_reserve_t* reserve, double sum_j);
/// Add what this port takes in (below 0: gives away), and drop what is above `cap_j`: an old reserve must not
/// pay for a new oscillation.
void control_reserve_add(control_reserve_t* reserve, double taken_j, double cap_j);

#endif // FSW_FRAMEWORK_CONTROL_PORT_ENERGY_H
