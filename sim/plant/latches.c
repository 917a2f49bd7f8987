// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>

#define NS_PER_S 1.0e9

static dBodyID body_of(const plant_t* const plant, const world_side_t* const side)
{
    const robot_frame_t* frame = &plant->world->robot[side->robot].model.frame[side->frame];
    return plant->robot[side->robot].body[frame->body];
}

static double length(const double a[3], const double b[3])
{
    const double off[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
}

/// Returns the angle between two attitudes, from the scalar and the vector of the quaternion from one to the
/// other.
static double angle_between(const double a[4], const double b[4])
{
    const double scalar    = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double vector[3] = {a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
                              a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
                              a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1]};
    const double size      = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    return 2.0 * atan2(size, fabs(scalar));
}

static bool is_near(const plant_t* const plant, const world_latch_t* const latch)
{
    plant_base_t a;
    plant_base_t b;
    plant_frame(plant, latch->side[0].robot, latch->side[0].frame, &a);
    plant_frame(plant, latch->side[1].robot, latch->side[1].frame, &b);
    return (length(a.position_m, b.position_m) <= latch->distance) &&
           (angle_between(a.rotation, b.rotation) <= latch->angle) &&
           (length(a.velocity_m_s, b.velocity_m_s) <= latch->speed);
}

static unsigned joint_of(const plant_t* const plant, const world_latch_t* const latch)
{
    const world_drive_t* drive = &plant->world->drive[latch->drive];
    return plant_joint(plant->world, drive->robot, drive->joint);
}

/// Count the time for which the drive of a latch has pressed without a pause in one direction.
static void count_press(const plant_t* const plant, const world_latch_t* const latch, latch_t* const own,
                        const double dt_s)
{
    const double torque    = plant->truth.joint_torque_nm[joint_of(plant, latch)];
    const double direction = (torque > 0.0) ? 1.0 : -1.0;
    const bool continues   = (fabs(torque) >= latch->force) && (direction == own->direction);
    own->pressed_s         = continues ? (own->pressed_s + dt_s) : 0.0;
    own->direction         = direction;
}

static bool must_close(const plant_t* const plant, const unsigned index, const plant_input_t* const input)
{
    const world_latch_t* latch = &plant->world->latch[index];
    switch (latch->trigger) {
    case WORLD_LATCH_PRESSED:
        return plant->latch[index].pressed_s >= (latch->stall_ns / NS_PER_S);
    case WORLD_LATCH_WIRED:
        return input->latch_on[index];
    case WORLD_LATCH_TOUCHED:
        break;
    }
    return true;
}

static bool must_open(const plant_t* const plant, const unsigned index, const plant_input_t* const input)
{
    const world_latch_t* latch = &plant->world->latch[index];
    const latch_t* own         = &plant->latch[index];
    if (latch->trigger == WORLD_LATCH_PRESSED) {
        const double position = plant->truth.link_position_rad[joint_of(plant, latch)];
        const double back     = own->direction * (own->closed_at_rad - position);
        return (latch->release > 0.0) && (back >= latch->release);
    }
    return (latch->trigger == WORLD_LATCH_WIRED) && !input->latch_on[index];
}

static void close_latch(plant_t* const plant, const unsigned index)
{
    const world_latch_t* latch = &plant->world->latch[index];
    latch_t* own               = &plant->latch[index];
    own->joint                 = dJointCreateFixed(plant->ode, NULL);
    dJointAttach(own->joint, body_of(plant, &latch->side[0]), body_of(plant, &latch->side[1]));
    dJointSetFixed(own->joint);
    if (latch->trigger == WORLD_LATCH_PRESSED) {
        own->closed_at_rad = plant->truth.link_position_rad[joint_of(plant, latch)];
    }
}

static void open_latch(latch_t* const own)
{
    dJointDestroy(own->joint);
    own->joint     = NULL;
    own->pressed_s = 0.0;
}

bool latches_step(plant_t* const plant, const plant_input_t* const input, const double dt_s)
{
    bool has_closed = false;
    for (unsigned i = 0U; i < plant->world->latch_count; i++) {
        const world_latch_t* latch = &plant->world->latch[i];
        latch_t* own               = &plant->latch[i];
        if ((latch->trigger == WORLD_LATCH_PRESSED) && (own->joint == NULL)) {
            count_press(plant, latch, own, dt_s);
        }
        if ((own->joint != NULL) && must_open(plant, i, input)) {
            open_latch(own);
        } else if ((own->joint == NULL) && must_close(plant, i, input) && is_near(plant, latch)) {
            close_latch(plant, i);
            has_closed = true;
        } else {
            // The latch does not change.
        }
        plant->truth.is_latched[i] = own->joint != NULL;
    }
    return has_closed;
}

bool latches_connect(const plant_t* const plant, const dBodyID a, const dBodyID b)
{
    for (unsigned i = 0U; i < plant->world->latch_count; i++) {
        const world_latch_t* latch = &plant->world->latch[i];
        if (plant->latch[i].joint != NULL) {
            const dBodyID first  = body_of(plant, &latch->side[0]);
            const dBodyID second = body_of(plant, &latch->side[1]);
            if (((a == first) && (b == second)) || ((a == second) && (b == first))) {
                return true;
            }
        }
    }
    return false;
}
