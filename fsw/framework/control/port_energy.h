// SPDX-License-Identifier: Apache-2.0
/// Energy that a port with two axes receives, and a monitor of that energy. A passive port at rest gives no
/// energy away; a control loop that oscillates does, although its mean force and position are correct.
///
/// Two ports that a link with delay connects send each other the sum of the energy that they have received
/// since their last reset, which is when their actuators are switched on. This sum never decreases, so a lost
/// or late sample delays energy but never adds any. The increase of the sum is a reserve of the receiver:
/// energy that its port may give away.
///
/// Ownership  The caller provides control_port_energy_t and control_reserve_t.
/// Context    One task.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_CONTROL_PORT_ENERGY_H
#define FSW_FRAMEWORK_CONTROL_PORT_ENERGY_H

#include <stdbool.h>

#define CONTROL_PORT_AXES 2U

typedef struct {
    double limit_j;  ///< Energy that may be given away during one window at rest.
    double time_s;   ///< Length of a window of the monitor; the windows follow each other without gaps.
    double rest_rad; ///< An axis that moves further than this is not at rest; a new window then begins.
    double period_s; ///< Time between two steps.
} control_port_watch_t;

typedef struct { // Read-only outside.
    bool is_started;
    double taken_j;    ///< Net energy: energy received minus energy given away.
    double given_j;    ///< Energy given away; never decreases.
    double received_j; ///< Energy received; energy given away is not subtracted, so it never decreases.
    double position_rad[CONTROL_PORT_AXES];
    double begin_rad[CONTROL_PORT_AXES]; ///< Position when the window began.
    /// Value of `taken_j` when the window began.
    double begin_j;
    double elapsed_s;
} control_port_energy_t;

typedef struct { // Read-only outside; all zero at the start.
    bool is_started;
    double last_sum_j; ///< Latest sum that the other port has sent.
    double reserve_j;  ///< Energy that may be given away; below 0: more was given away than had arrived.
} control_reserve_t;

/// Set all sums to zero.
void control_port_energy_reset(control_port_energy_t* energy);
/// Process one cycle: the position, and the torque with which the hand or the environment has driven the port
/// since the last cycle. Returns the energy that was given away in the window [J] if the window ends now, the
/// port was at rest in it, and the energy exceeds the limit; otherwise 0.
double control_port_energy_step(control_port_energy_t* energy, const control_port_watch_t* watch,
                                const double torque_nm[CONTROL_PORT_AXES],
                                const double position_rad[CONTROL_PORT_AXES]);
/// Read the sum of the other port and add its increase to the reserve. The first sum adds nothing, and
/// neither does a sum that has fallen (the other port was reset) or is NaN.
void control_reserve_take_sum(control_reserve_t* reserve, double sum_j);
/// Add the energy that this port receives (negative: gives away), and limit the reserve to `cap_j`, so that
/// an old reserve cannot feed a new oscillation.
void control_reserve_add(control_reserve_t* reserve, double taken_j, double cap_j);

#endif // FSW_FRAMEWORK_CONTROL_PORT_ENERGY_H
