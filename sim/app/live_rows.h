// SPDX-License-Identifier: Apache-2.0
/// The true state of the plant as text for the live port: the names of the columns, and a row of numbers.
#ifndef SIM_APP_LIVE_ROWS_H
#define SIM_APP_LIVE_ROWS_H

#include "sim/plant/plant.h"
#include "sim/world/world.h"

#include <stddef.h>

#define LIVE_ROW_OCTETS 16384U ///< More than the columns or a row of the largest world.

/// Write the line of column names, "columns time ROBOT.JOINT.position ...": time [s]; for each joint position
/// [rad], torque [Nm] and brake (1: engaged); for each axis of a joystick position [rad], motor torque and
/// torque of the hand [Nm]; for each contact and spring whether it acts (1), and its force [N]; for each free
/// base position [m] and rotation (w, x, y, z); for each wheel its momentum [Nms]; for each valve whether it
/// is open (1). Returns the length.
size_t live_rows_columns(const world_t* world, char text[LIVE_ROW_OCTETS]);
/// Write the line "truth 25.1 ..." with the values of these columns. Returns the length.
size_t live_rows_row(const world_t* world, const plant_truth_t* truth, char text[LIVE_ROW_OCTETS]);

#endif // SIM_APP_LIVE_ROWS_H
