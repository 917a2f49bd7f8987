// SPDX-License-Identifier: Apache-2.0
/// The true state of the plant as text for the live port: the names of the columns, and a row of numbers.
#ifndef SIM_APP_LIVE_ROWS_H
#define SIM_APP_LIVE_ROWS_H

#include "sim/plant/plant.h"
#include "sim/world/world.h"

#include <stddef.h>

#define LIVE_ROW_OCTETS 16384U ///< More than the columns or a row of the largest world.

/// Write the line of column names, "columns time ROBOT.JOINT.position ...": time [s]; each joint: position
/// [rad], torque [Nm], brake (1: engaged); each axis of a joystick: position [rad], torque of the motor and
/// of the hand [Nm]; each contact and each spring: whether it acts (1), force x, y, z [N]; each free base:
/// position [m], rotation (w, x, y, z); each wheel: momentum [Nms]; each valve: whether it is open (1).
/// Returns the length.
size_t live_rows_columns(const world_t* world, char text[LIVE_ROW_OCTETS]);
/// Write the line "truth 25.1 ..." with the values of these columns. Returns the length.
size_t live_rows_row(const world_t* world, const plant_truth_t* truth, char text[LIVE_ROW_OCTETS]);

#endif // SIM_APP_LIVE_ROWS_H
