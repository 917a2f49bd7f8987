// SPDX-License-Identifier: Apache-2.0
/// Inside of the plant: the parts that share its state. Private to sim/plant.
#ifndef SIM_PLANT_PLANT_INTERNAL_H
#define SIM_PLANT_PLANT_INTERNAL_H

#include "sim/plant/plant.h"

#include <ode/ode.h>

/// A force on the finger and where it acts.
typedef struct {
    double force_n[3];
    double point_m[3];
} plant_load_t;

/// Cable spring: rests on its hook until the finger picks it up.
typedef struct {
    bool hooked;
    bool below; ///< The finger was below the hook in the last step, so it can pick the cable up.
} spring_t;

#define CONTOUR_SHAPES 2U   ///< Flat part and bump.
#define CONTOUR_CONTACTS 4U ///< Contact points per shape at most.
#define CONTOUR_POINTS (CONTOUR_SHAPES * CONTOUR_CONTACTS)

typedef struct {
    dGeomID finger;
    dGeomID shape[CONTOUR_SHAPES];
    dJointGroupID joints;
    unsigned count; ///< Contact points of the present step.
    dJointFeedback feedback[CONTOUR_POINTS];
    double point_m[CONTOUR_POINTS][3];
} contour_t;

struct plant {
    plant_parameters_t parameters;
    plant_options_t options;
    plant_truth_t truth;
    dWorldID world;
    dBodyID base; ///< Null unless free.
    dBodyID link[PLANT_JOINTS];
    dJointID hinge[PLANT_JOINTS];
    double hinge_angle_rad[PLANT_JOINTS]; ///< Last angle from ODE, for unwrapping.
    contour_t contour;
    spring_t spring;
};

/// Advance one rotor by h_s against gear torque, friction, brake and end stop; `torque_nm` is the motor's.
/// Adds nothing up: returns the friction torque of this substep.
double joint_rotor_step(const plant_drive_t* drive, plant_rotor_t* rotor, bool brake, double torque_nm,
                        double gear_torque_nm, double h_s);

/// Advance one axis of the joystick by h_s under the sum of motor and hand torque.
void stick_step(const plant_parameters_t* parameters, double torque_nm, double h_s, double* position_rad,
                double* velocity_rad_s);

/// Force of the cable on a finger at `tip_m`; picks up and lets go of the hook.
void spring_force(const plant_parameters_t* parameters, spring_t* spring, const double tip_m[3],
                  double out_force_n[3]);

/// Make finger and contour. Needs plant->world; false when memory is out.
bool contour_create(plant_t* plant);

/// Free what contour_create made.
void contour_destroy(plant_t* plant);

/// Add the contact joints of the present pose, for one world step of dt_s.
void contour_touch(plant_t* plant, double dt_s);

/// After the world step: loads of the contact points into `out_load`, contact joints removed. Returns their
/// number.
unsigned contour_loads(plant_t* plant, plant_load_t out_load[CONTOUR_POINTS]);

#endif // SIM_PLANT_PLANT_INTERNAL_H
