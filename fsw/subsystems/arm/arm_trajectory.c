// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_trajectory.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

// A blend changes a velocity in proportion to s(x) = 3 x^2 - 2 x^3; x is the elapsed share of its duration.
#define PEAK_ACCELERATION 1.5 // Peak acceleration if a velocity changes by 1 in time 1.
#define DISTANCE 0.09375      // Distance from the point in the middle of that blend.

#define LINE_MIN_S 0.1
#define BLEND_MIN_S 0.05
#define GROWTH 1.05

static double larger(const double a, const double b)
{
    return (a > b) ? a : b;
}

void arm_trajectory_clear(arm_trajectory_t* const trajectory)
{
    FSW_ASSERT(trajectory != NULL);
    trajectory->point_count = 0U;
}

status_t arm_trajectory_add(arm_trajectory_t* const trajectory, const arm_model_t* const model,
                            const double point_rad[ARM_JOINTS_MAX])
{
    FSW_ASSERT((trajectory != NULL) && (model != NULL) && (point_rad != NULL));
    if (trajectory->point_count >= ARM_POINTS_MAX) {
        return STATUS_EXHAUSTED;
    }
    trajectory->joint_count = model->joint_count;
    trajectory->point_count++;
    for (unsigned i = 0U; i < model->joint_count; i++) {
        trajectory->point_rad[trajectory->point_count][i] = point_rad[i];
    }
    return STATUS_OK;
}

/// Velocity of a joint on a line; 0 before the first and behind the last line.
static double velocity_on(const arm_trajectory_t* const trajectory, const unsigned line, const unsigned joint)
{
    return (trajectory->point_rad[line + 1U][joint] - trajectory->point_rad[line][joint]) /
           trajectory->line_s[line];
}

static double velocity_before(const arm_trajectory_t* const trajectory, const unsigned point,
                              const unsigned joint)
{
    return (point == 0U) ? 0.0 : velocity_on(trajectory, point - 1U, joint);
}

static double velocity_behind(const arm_trajectory_t* const trajectory, const unsigned point,
                              const unsigned joint)
{
    return (point == trajectory->point_count) ? 0.0 : velocity_on(trajectory, point, joint);
}

/// Shortest duration of a line alone: at full speed, but long enough for half of a blend from rest and half
/// of a blend to rest.
static double shortest_s(const arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                         const unsigned line)
{
    const double ends = ((line == 0U) ? 1.0 : 0.0) + (((line + 1U) == trajectory->point_count) ? 1.0 : 0.0);
    double duration_s = LINE_MIN_S;
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        const double length =
            control_absolute(trajectory->point_rad[line + 1U][i] - trajectory->point_rad[line][i]);
        const double speed        = limits->speed_rad_s[i] * trajectory->share;
        const double acceleration = limits->acceleration_rad_s2[i] * trajectory->share;
        duration_s                = larger(duration_s, length / speed);
        duration_s = larger(duration_s, sqrt(0.5 * ends * PEAK_ACCELERATION * length / acceleration));
    }
    return duration_s;
}

void arm_trajectory_begin(arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                          const arm_motion_t* const from, const double share, const double blend)
{
    FSW_ASSERT((trajectory != NULL) && (limits != NULL) && (from != NULL) && (trajectory->point_count > 0U) &&
               (share > 0.0) && (blend > 0.0));
    trajectory->share  = share;
    trajectory->blend  = blend;
    trajectory->rounds = 0U;
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        trajectory->point_rad[0][i] = from->position_rad[i];
    }
    for (unsigned line = 0U; line < trajectory->point_count; line++) {
        trajectory->line_s[line] = shortest_s(trajectory, limits, line);
    }
}

/// Set the shortest duration of the blend at a point. Returns the largest distance between a joint and the
/// point.
static double plan_blend(arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                         const unsigned point)
{
    double duration_s = BLEND_MIN_S;
    double change     = 0.0;
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        const double own =
            control_absolute(velocity_behind(trajectory, point, i) - velocity_before(trajectory, point, i));
        change     = larger(change, own);
        duration_s = larger(duration_s,
                            PEAK_ACCELERATION * own / (limits->acceleration_rad_s2[i] * trajectory->share));
    }
    trajectory->blend_s[point] = duration_s;
    return DISTANCE * change * duration_s;
}

/// True for points between the start and the last one: only there the motion passes at a distance.
static bool is_via(const arm_trajectory_t* const trajectory, const unsigned point)
{
    return (point > 0U) && (point < trajectory->point_count);
}

status_t arm_trajectory_plan(arm_trajectory_t* const trajectory, const arm_limits_t* const limits)
{
    FSW_ASSERT((trajectory != NULL) && (limits != NULL) && (trajectory->point_count > 0U));
    bool is_slow[ARM_POINTS_MAX + 1U] = {false}; // Lines that need more time.
    bool is_ready                     = true;
    for (unsigned point = 0U; point <= trajectory->point_count; point++) {
        const double distance = plan_blend(trajectory, limits, point);
        if (is_via(trajectory, point) && !(distance <= trajectory->blend)) {
            is_slow[point - 1U] = true;
            is_slow[point]      = true;
        }
    }
    for (unsigned line = 0U; line < trajectory->point_count; line++) {
        const double blends_s = 0.5 * (trajectory->blend_s[line] + trajectory->blend_s[line + 1U]);
        if (is_slow[line] || !(blends_s <= trajectory->line_s[line])) {
            trajectory->line_s[line] *= GROWTH;
            is_ready = false;
        }
    }
    if (is_ready) {
        return STATUS_OK;
    }
    trajectory->rounds++;
    return (trajectory->rounds < ARM_PLAN_ROUNDS) ? STATUS_BUSY : STATUS_EXHAUSTED;
}

double arm_trajectory_duration_s(const arm_trajectory_t* const trajectory)
{
    FSW_ASSERT(trajectory != NULL);
    double sum_s = 0.5 * (trajectory->blend_s[0] + trajectory->blend_s[trajectory->point_count]);
    for (unsigned line = 0U; line < trajectory->point_count; line++) {
        sum_s += trajectory->line_s[line];
    }
    return sum_s;
}

/// Compute the motion in the blend at a point, or on the lines before and behind it, at `since_s` after the
/// middle of the blend.
static void move_near(const arm_trajectory_t* const trajectory, const unsigned point, const double since_s,
                      arm_motion_t* const motion)
{
    const double duration_s = trajectory->blend_s[point];
    const double x          = control_clamp((since_s / duration_s) + 0.5, 0.0, 1.0);
    const double beyond_s   = larger(since_s - (0.5 * duration_s), 0.0);
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        const double before       = velocity_before(trajectory, point, i);
        const double change       = velocity_behind(trajectory, point, i) - before;
        const double gained       = (duration_s * x * x * x * (1.0 - (0.5 * x))) + beyond_s;
        motion->position_rad[i]   = trajectory->point_rad[point][i] + (before * since_s) + (change * gained);
        motion->velocity_rad_s[i] = before + (change * x * x * (3.0 - (2.0 * x)));
        motion->acceleration_rad_s2[i] = change * 6.0 * x * (1.0 - x) / duration_s;
    }
}

static void rest_at(const arm_trajectory_t* const trajectory, const unsigned point,
                    arm_motion_t* const motion)
{
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        motion->position_rad[i]        = trajectory->point_rad[point][i];
        motion->velocity_rad_s[i]      = 0.0;
        motion->acceleration_rad_s2[i] = 0.0;
    }
}

void arm_trajectory_at(const arm_trajectory_t* const trajectory, const double time_s,
                       arm_motion_t* const out_motion)
{
    FSW_ASSERT((trajectory != NULL) && (out_motion != NULL) && (trajectory->point_count > 0U));
    if (!(time_s > 0.0)) {
        rest_at(trajectory, 0U, out_motion);
        return;
    }
    double since_s = time_s - (0.5 * trajectory->blend_s[0]);
    for (unsigned point = 0U; point < trajectory->point_count; point++) {
        // This point is responsible up to the beginning of the next point's blend.
        if (since_s <= (trajectory->line_s[point] - (0.5 * trajectory->blend_s[point + 1U]))) {
            move_near(trajectory, point, since_s, out_motion);
            return;
        }
        since_s -= trajectory->line_s[point];
    }
    if (since_s >= (0.5 * trajectory->blend_s[trajectory->point_count])) {
        rest_at(trajectory, trajectory->point_count, out_motion);
        return;
    }
    move_near(trajectory, trajectory->point_count, since_s, out_motion);
}
