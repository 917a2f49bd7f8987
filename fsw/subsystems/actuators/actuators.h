// SPDX-License-Identifier: Apache-2.0
/// The subsystem ACTUATORS: drives with one axis each, and modules with digital or analogue inputs and
/// outputs (any class without axes: CiA 401, 404, manufacturer objects), on CAN buses. The descriptor lists
/// the devices and their modes of operation: CSP (position), CSV (velocity) or homing.
///
/// In OPERATIONAL each axis in CSP follows TARGET with SPEED, each in CSV moves with VELOCITY, and outputs
/// get OUTPUT; in any other state velocities and outputs are 0. HOME starts the search of all axes in mode
/// homing for their references; STOP ends the search and holds the axes. Axes, inputs and outputs are
/// numbered in the order of the devices of the applied configuration; the values of a module are numbered in
/// the order of its process data. The descriptor that the program is built from says how many there are at
/// most: the counts of its parameters TARGET, INPUT and OUTPUT.
///
/// Ownership  The program provides actuators_t and the generic subsystem; both must not be moved.
/// Context    The task of the generic subsystem; its callbacks never block.
#ifndef FSW_SUBSYSTEMS_ACTUATORS_ACTUATORS_H
#define FSW_SUBSYSTEMS_ACTUATORS_ACTUATORS_H

#include "base/capacities.h"
#include "fsw/drives/drives.h"
#include "fsw/framework/subsystem/subsystem.h"

#include "generated/actuators_descriptor.h"

#include <stddef.h>
#include <stdint.h>

/// Numbers of elements of the parameters in the descriptor that the program is built from.
#define ACTUATORS_AXES_MAX (sizeof(((actuators_parameters_t*)NULL)->target) / sizeof(double))
#define ACTUATORS_INPUTS_MAX (sizeof(((actuators_cur_values_t*)NULL)->input) / sizeof(double))
#define ACTUATORS_OUTPUTS_MAX (sizeof(((actuators_parameters_t*)NULL)->output) / sizeof(double))

typedef struct {     // All fields are private.
    drives_t drives; ///< First member, because the callbacks of drives.h get the same context.
    subsystem_t* generic;
    actuators_parameters_t parameters;
    double reference_rad[ACTUATORS_AXES_MAX]; ///< Present position on the way to the target.
    uint32_t home_token;                      ///< Token of the running search; 0: none.
} actuators_t;
CAPACITY_CHECK(actuators_begin_with_drives, offsetof(actuators_t, drives) == 0U);
CAPACITY_CHECK(
    actuators_have_one_number_of_axes,
    (sizeof(((actuators_cur_values_t*)NULL)->position) == (ACTUATORS_AXES_MAX * sizeof(double))) &&
        (sizeof(((actuators_cur_values_t*)NULL)->torque) == (ACTUATORS_AXES_MAX * sizeof(double))) &&
        (sizeof(((actuators_cur_values_t*)NULL)->statusword) == (ACTUATORS_AXES_MAX * sizeof(uint16_t))) &&
        (sizeof(((actuators_parameters_t*)NULL)->velocity) == (ACTUATORS_AXES_MAX * sizeof(double))));

/// Call once, before the generic subsystem runs. The pointers must stay valid.
void actuators_init(actuators_t* own, subsystem_t* generic, const flow_resolver_t* resolver);
/// Returns the callbacks for the generic subsystem; their context is the actuators_t.
const subsystem_callbacks_t* actuators_callbacks(void);

#endif // FSW_SUBSYSTEMS_ACTUATORS_ACTUATORS_H
