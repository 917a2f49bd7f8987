// SPDX-License-Identifier: Apache-2.0
/// The subsystem ACTUATORS: drives with one axis each, and modules with digital or analogue inputs and
/// outputs (any class without axes: CiA 401, 404, manufacturer objects), on CAN buses. The descriptor says
/// which, and their modes: CSP (position), CSV (velocity) or homing.
///
/// In OPERATIONAL each axis in CSP follows TARGET with SPEED, each in CSV moves with VELOCITY, and outputs
/// get OUTPUT; in any other state velocities and outputs are 0. HOME searches the references of the axes in
/// mode homing, STOP ends it and holds the axes. Axes, inputs and outputs count in the order of the devices
/// of the applied configuration; the values of a module in the order of its process data.
///
/// Ownership  The program places actuators_t and the generic subsystem; both must not be moved.
/// Context    The task of the generic subsystem; its callbacks never block.
#ifndef FSW_SUBSYSTEMS_ACTUATORS_ACTUATORS_H
#define FSW_SUBSYSTEMS_ACTUATORS_ACTUATORS_H

#include "base/capacities.h"
#include "fsw/drives/drives.h"
#include "fsw/framework/subsystem/subsystem.h"

#include "generated/actuators_descriptor.h"

#include <stddef.h>
#include <stdint.h>

#define ACTUATORS_AXES_MAX 8U ///< As many as the parameters have places.
#define ACTUATORS_VALUES_MAX 16U

typedef struct {     // All fields are private.
    drives_t drives; ///< First: the callbacks of drives.h have the same context.
    subsystem_t* generic;
    actuators_parameters_t parameters;
    double reference_rad[ACTUATORS_AXES_MAX]; ///< On the way to the target.
    uint32_t home_token;                      ///< Token of the search under way; 0: none.
} actuators_t;
CAPACITY_CHECK(actuators_begin_with_drives, offsetof(actuators_t, drives) == 0U);

/// Once, before the generic subsystem runs. Pointers are kept.
void actuators_init(actuators_t* own, subsystem_t* generic, const flow_resolver_t* resolver);
/// Callbacks for the generic subsystem; their context is the actuators_t.
const subsystem_callbacks_t* actuators_callbacks(void);

#endif // FSW_SUBSYSTEMS_ACTUATORS_ACTUATORS_H
