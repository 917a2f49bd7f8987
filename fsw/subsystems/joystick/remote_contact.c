// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/joystick/remote_contact.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

void joystick_remote_contact_reset(joystick_remote_contact_t* const contact)
{
    FSW_ASSERT(contact != NULL);
    *contact = (joystick_remote_contact_t){.taken_j = 0.0};
}

/// Limit the force to a possible contact force: along the normal it only pushes; across the normal, friction
/// limits it.
static void bound(const joystick_remote_t* const gains, const double normal[CONTROL_PLANAR_AXES],
                  double force_n[CONTROL_PLANAR_AXES])
{
    const double along   = (force_n[0] * normal[0]) + (force_n[1] * normal[1]);
    const double across  = (force_n[1] * normal[0]) - (force_n[0] * normal[1]);
    const double push    = (along > 0.0) ? along : 0.0;
    const double most    = gains->tangential * push;
    const double bounded = control_clamp(across, -most, most);
    force_n[0]           = (push * normal[0]) - (bounded * normal[1]);
    force_n[1]           = (push * normal[1]) + (bounded * normal[0]);
}

void joystick_remote_contact_feel(const joystick_remote_t* const gains,
                                  const joystick_robot_contact_payload_t* const robot,
                                  const double position_rad[STICK_AXES], double out_felt_nm[STICK_AXES])
{
    FSW_ASSERT((gains != NULL) && (robot != NULL));
    double shown[CONTROL_PLANAR_AXES];
    double modelled[CONTROL_PLANAR_AXES];
    double moved[STICK_AXES];
    const double fade =
        control_clamp((robot->push - gains->fade_from) / (gains->fade_to - gains->fade_from), 0.0, 1.0);
    if (control_planar_is_regular(robot->jacobian)) {
        for (unsigned i = 0U; i < STICK_AXES; i++) {
            moved[i] = gains->position_scale * (robot->echo[i] - position_rad[i]);
        }
        control_planar_force(robot->jacobian, robot->external_torque, shown);
        control_planar_move(robot->jacobian, moved, modelled);
        for (unsigned i = 0U; i < CONTROL_PLANAR_AXES; i++) {
            shown[i] += gains->stiffness * modelled[i];
        }
        bound(gains, robot->normal, shown);
        control_planar_torque(robot->jacobian, shown, out_felt_nm);
    } else { // In a singular pose, torques determine no force: they are passed on unchanged.
        out_felt_nm[0] = robot->external_torque[0];
        out_felt_nm[1] = robot->external_torque[1];
    }
    out_felt_nm[0] *= fade;
    out_felt_nm[1] *= fade;
}

double joystick_remote_contact_damp(joystick_remote_contact_t* const contact,
                                    const joystick_remote_t* const gains, const double period_s,
                                    const double taken_j, const double velocity_rad_s[STICK_AXES])
{
    FSW_ASSERT((contact != NULL) && (gains != NULL));
    control_reserve_add(&contact->reserve, taken_j - contact->taken_j, gains->reserve);
    contact->taken_j    = taken_j;
    const double square = (velocity_rad_s[0] * velocity_rad_s[0]) + (velocity_rad_s[1] * velocity_rad_s[1]);
    const double debt   = -contact->reserve.reserve_j;
    if (!(debt > 0.0) || !(square > 0.0)) {
        return 0.0;
    }
    return control_clamp(debt / (square * period_s), 0.0, gains->damping_max);
}
