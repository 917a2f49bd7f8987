// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>

/// Returns the largest torque of dry friction at this speed: Coulomb friction with the Stribeck rise, and the
/// brake.
static double dry_friction(const plant_drive_t* const drive, const double velocity_rad_s, const bool brake)
{
    const double ratio  = velocity_rad_s / drive->stribeck_rad_s;
    const double excess = (drive->stiction_nm - drive->coulomb_nm) / (1.0 + ratio * ratio);
    return drive->coulomb_nm + excess + (brake ? drive->brake_torque_nm : 0.0);
}

/// Returns the torque of one-sided springs and dampers at both ends of a range; zero inside.
static double end_stop(const double position, const double velocity, const double lower, const double upper,
                       const double stiffness, const double damping)
{
    const double beyond = (position > upper) ? (position - upper) : (lower - position);
    if (beyond <= 0.0) {
        return 0.0;
    }
    const double side = (position > upper) ? 1.0 : -1.0;
    const double push = stiffness * beyond + damping * velocity * side;
    return (push > 0.0) ? -side * push : 0.0;
}

double joint_rotor_step(const plant_drive_t* const drive, plant_rotor_t* const rotor, const bool brake,
                        const double torque_nm, const double gear_torque_nm, const double h_s)
{
    const double inertia = drive->rotor_inertia_kgm2;
    const double viscous = drive->viscous_nms_rad * rotor->velocity_rad_s;
    const double stop    = end_stop(rotor->position_rad, rotor->velocity_rad_s, drive->lower_rad,
                                    drive->upper_rad, drive->stop_nm_rad, drive->stop_nms_rad);

    const double ripple  = torque_ripple(&drive->ripple, rotor->position_rad);
    const double driving = torque_nm + ripple;

    // Exact dry friction reduces the speed as much as possible in this substep, but never reverses it. This
    // is stable for any slope, and a rotor at rest keeps its position to the last bit.
    const double free = rotor->velocity_rad_s + h_s * (driving - gear_torque_nm - viscous + stop) / inertia;
    const double most = h_s * dry_friction(drive, rotor->velocity_rad_s, brake) / inertia;
    const double next = (fabs(free) <= most) ? 0.0 : free - ((free > 0.0) ? most : -most);

    rotor->velocity_rad_s = next;
    rotor->position_rad += h_s * next;
    return (free - next) * inertia / h_s + viscous;
}

void stick_step(const world_joystick_t* const joystick, const double torque_nm, const double h_s,
                double* const position_rad, double* const velocity_rad_s)
{
    const double stop = end_stop(*position_rad, *velocity_rad_s, -joystick->range, joystick->range,
                                 joystick->stop_stiffness, joystick->stop_damping);
    const double sum  = torque_nm + stop - joystick->friction * *velocity_rad_s;
    *velocity_rad_s += h_s * sum / joystick->inertia;
    *position_rad += h_s * *velocity_rad_s;
}
