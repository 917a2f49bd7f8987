// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_trajectory.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

// A blend changes a velocity in proportion to s(x) = 3 x^2 - 2 x^3; x is the elapsed share of its duration.
#define PEAK_ACCELERATION 1.5 // Peak acceleration if a velocity changes by 1 in time 1.
#define DISTANCE 0.09375      // Distance of the motion from the point in the middle of that blend.

#define LINE_MIN_S 0.1
#define BLEND_MIN_S 0.05
// Factor by which a duration that is too short for its line grows in each round of planning.
#define GROWTH 1.05

#define TWO_PI 6.2831853071795865
#define TOOL_COORDINATES 6U
#define VECTOR 3U // Coordinates of the position of the tool; those of its rotation follow.
// If the square of the angle is smaller, rate_of uses the first terms of its series.
#define SMALL_SQUARE 1.0e-6
// The axis of a rotation by less than this angle is noise.
#define AXIS_MIN_RAD 1.0e-9
// Largest angular acceleration if a rotation vector changes evenly with 1 rad/s: 1 / pi, at half a turn.
#define CURVATURE 0.32

static double larger(const double a, const double b)
{
    return (a > b) ? a : b;
}

static bool is_rotation(const arm_trajectory_t* const trajectory, const unsigned i)
{
    return trajectory->is_tool && (i >= VECTOR);
}

static double acceleration_of(const arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                              const unsigned i)
{
    const double tool =
        (i < VECTOR) ? limits->tool_acceleration_m_s2 : limits->tool_angular_acceleration_rad_s2;
    return trajectory->share * (trajectory->is_tool ? tool : limits->acceleration_rad_s2[i]);
}

static double speed_of(const arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                       const unsigned i)
{
    const double tool  = (i < VECTOR) ? limits->tool_speed_m_s : limits->tool_rate_rad_s;
    const double speed = trajectory->share * (trajectory->is_tool ? tool : limits->speed_rad_s[i]);
    // Speed at which the even change of a rotation vector needs half of the angular acceleration: the other
    // half is left for the blends.
    const double even =
        is_rotation(trajectory, i) ? sqrt(0.5 * acceleration_of(trajectory, limits, i) / CURVATURE) : speed;
    return (even < speed) ? even : speed;
}

/// Returns the magnitude of a coordinate: for a joint the coordinate itself, for the tool the length of the
/// vector to which the coordinate belongs.
static double magnitude(const arm_trajectory_t* const trajectory, const double values[ARM_JOINTS_MAX],
                        const unsigned i)
{
    return trajectory->is_tool ? arm_length(arm_vector(&values[i - (i % VECTOR)]))
                               : control_absolute(values[i]);
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
    trajectory->is_tool     = false;
    trajectory->joint_count = model->joint_count;
    trajectory->point_count++;
    for (unsigned i = 0U; i < model->joint_count; i++) {
        trajectory->point[trajectory->point_count][i] = point_rad[i];
    }
    return STATUS_OK;
}

status_t arm_trajectory_add_pose(arm_trajectory_t* const trajectory, const double position_m[3],
                                 const double rotation_rad[3])
{
    FSW_ASSERT((trajectory != NULL) && (position_m != NULL) && (rotation_rad != NULL));
    if (trajectory->point_count >= ARM_POINTS_MAX) {
        return STATUS_EXHAUSTED;
    }
    trajectory->is_tool     = true;
    trajectory->joint_count = TOOL_COORDINATES;
    trajectory->point_count++;
    for (unsigned i = 0U; i < VECTOR; i++) {
        trajectory->point[trajectory->point_count][i]          = position_m[i];
        trajectory->point[trajectory->point_count][VECTOR + i] = rotation_rad[i];
    }
    return STATUS_OK;
}

/// Returns the velocity of a joint on a line.
static double velocity_on(const arm_trajectory_t* const trajectory, const unsigned line, const unsigned joint)
{
    return (trajectory->point[line + 1U][joint] - trajectory->point[line][joint]) / trajectory->line_s[line];
}

/// Returns the velocity of a joint on the line before a point; 0 at the start.
static double velocity_before(const arm_trajectory_t* const trajectory, const unsigned point,
                              const unsigned joint)
{
    return (point == 0U) ? 0.0 : velocity_on(trajectory, point - 1U, joint);
}

/// Returns the velocity of a joint on the line after a point; 0 at the last point.
static double velocity_after(const arm_trajectory_t* const trajectory, const unsigned point,
                             const unsigned joint)
{
    return (point == trajectory->point_count) ? 0.0 : velocity_on(trajectory, point, joint);
}

/// Returns the shortest duration of a line alone: at full speed, but the first line long enough for half of a
/// blend from rest, the last line for half of a blend to rest.
static double shortest_s(const arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                         const unsigned line)
{
    const double ends = ((line == 0U) ? 1.0 : 0.0) + (((line + 1U) == trajectory->point_count) ? 1.0 : 0.0);
    double duration_s = LINE_MIN_S;
    double way[ARM_JOINTS_MAX];
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        way[i] = trajectory->point[line + 1U][i] - trajectory->point[line][i];
    }
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        const double length       = magnitude(trajectory, way, i);
        const double acceleration = acceleration_of(trajectory, limits, i);
        duration_s                = larger(duration_s, length / speed_of(trajectory, limits, i));
        duration_s = larger(duration_s, sqrt(0.5 * ends * PEAK_ACCELERATION * length / acceleration));
    }
    return duration_s;
}

static void begin(arm_trajectory_t* const trajectory, const arm_limits_t* const limits, const double share,
                  const double blend)
{
    FSW_ASSERT((trajectory->point_count > 0U) && (share > 0.0) && (blend > 0.0));
    trajectory->share  = share;
    trajectory->blend  = blend;
    trajectory->rounds = 0U;
    for (unsigned line = 0U; line < trajectory->point_count; line++) {
        trajectory->line_s[line] = shortest_s(trajectory, limits, line);
    }
}

void arm_trajectory_begin(arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                          const arm_motion_t* const from, const double share, const double blend)
{
    FSW_ASSERT((trajectory != NULL) && (limits != NULL) && (from != NULL) && !trajectory->is_tool);
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        trajectory->point[0][i] = from->position_rad[i];
    }
    begin(trajectory, limits, share, blend);
}

/// Returns, of all rotation vectors that turn to the same orientation as `vector_rad`, the one nearest to
/// `before_rad`, the vector of the previous point. After a whole turn the axis is undefined; the axis of
/// `before_rad` then applies.
static arm_vector_t nearest(const arm_vector_t vector_rad, const arm_vector_t before_rad)
{
    const double angle_rad   = arm_length(vector_rad);
    const bool has_axis      = (angle_rad > AXIS_MIN_RAD);
    const arm_vector_t about = has_axis ? vector_rad : before_rad;
    const double length      = arm_length(about);
    if (!(length > 0.0)) {
        return vector_rad;
    }
    const double along_rad = (arm_dot(before_rad, about) / length) - (has_axis ? angle_rad : 0.0);
    const double turns     = floor((along_rad / TWO_PI) + 0.5);
    return arm_times(about, (has_axis ? 1.0 : 0.0) + (turns * TWO_PI / length));
}

void arm_trajectory_begin_tool(arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                               const arm_pose_t* const from, const double share, const double blend)
{
    FSW_ASSERT((trajectory != NULL) && (limits != NULL) && (from != NULL) && trajectory->is_tool);
    static const arm_rotation_t none = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    arm_vector_t before_rad          = {{0.0, 0.0, 0.0}};
    trajectory->start                = from->rotation;
    for (unsigned i = 0U; i < VECTOR; i++) {
        trajectory->point[0][i]          = from->position_m.at[i];
        trajectory->point[0][VECTOR + i] = 0.0;
    }
    for (unsigned point = 1U; point <= trajectory->point_count; point++) {
        double* const rotation_rad = &trajectory->point[point][VECTOR];
        const arm_rotation_t goal  = arm_rotation_turned_by(&none, arm_vector(rotation_rad));
        before_rad                 = nearest(arm_rotation_between(&from->rotation, &goal), before_rad);
        for (unsigned i = 0U; i < VECTOR; i++) {
            rotation_rad[i] = before_rad.at[i];
        }
    }
    begin(trajectory, limits, share, blend);
}

/// Set the shortest duration of the blend at a point. Returns the largest distance between a joint and the
/// point.
static double plan_blend(arm_trajectory_t* const trajectory, const arm_limits_t* const limits,
                         const unsigned point)
{
    double duration_s = BLEND_MIN_S;
    double largest    = 0.0;
    double before[ARM_JOINTS_MAX];
    double after[ARM_JOINTS_MAX];
    double change[ARM_JOINTS_MAX];
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        before[i] = velocity_before(trajectory, point, i);
        after[i]  = velocity_after(trajectory, point, i);
        change[i] = after[i] - before[i];
    }
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        const double own     = magnitude(trajectory, change, i);
        const double fastest = larger(magnitude(trajectory, before, i), magnitude(trajectory, after, i));
        // The even changes on both sides of the point need a part of the acceleration, too.
        const double even = is_rotation(trajectory, i) ? (CURVATURE * fastest * fastest) : 0.0;
        const double rest = acceleration_of(trajectory, limits, i) - even;
        largest           = larger(largest, own);
        duration_s        = larger(duration_s, PEAK_ACCELERATION * own / rest);
    }
    trajectory->blend_s[point] = duration_s;
    return DISTANCE * largest * duration_s;
}

/// True for points between the start and the last one, which the motion may pass at a distance.
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

/// Compute the motion in the blend at a point, or on the lines before and after it, at `since_s` after the
/// middle of the blend.
static void move_near(const arm_trajectory_t* const trajectory, const unsigned point, const double since_s,
                      arm_motion_t* const motion)
{
    const double duration_s = trajectory->blend_s[point];
    const double x          = control_clamp((since_s / duration_s) + 0.5, 0.0, 1.0);
    const double beyond_s   = larger(since_s - (0.5 * duration_s), 0.0);
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        const double before            = velocity_before(trajectory, point, i);
        const double change            = velocity_after(trajectory, point, i) - before;
        const double gained            = (duration_s * x * x * x * (1.0 - (0.5 * x))) + beyond_s;
        motion->position_rad[i]        = trajectory->point[point][i] + (before * since_s) + (change * gained);
        motion->velocity_rad_s[i]      = before + (change * x * x * (3.0 - (2.0 * x)));
        motion->acceleration_rad_s2[i] = change * 6.0 * x * (1.0 - x) / duration_s;
    }
}

static void rest_at(const arm_trajectory_t* const trajectory, const unsigned point,
                    arm_motion_t* const motion)
{
    for (unsigned i = 0U; i < trajectory->joint_count; i++) {
        motion->position_rad[i]        = trajectory->point[point][i];
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
        // The blend of this point applies until the blend of the next point begins.
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

/// Returns the velocity of rotation when a rotation vector changes with `change`, in the frame in which both
/// are given: the left Jacobian of the rotation vector times `change`.
static arm_vector_t rate_of(const arm_vector_t vector_rad, const arm_vector_t change)
{
    const double square              = arm_dot(vector_rad, vector_rad);
    const double angle_rad           = sqrt(square);
    const control_sine_cosine_t turn = control_sine_cosine(angle_rad);
    const bool is_small              = (square < SMALL_SQUARE);
    const double first               = is_small ? 0.5 : ((1.0 - turn.cosine) / square);
    const double second       = is_small ? (1.0 / 6.0) : ((angle_rad - turn.sine) / (square * angle_rad));
    const arm_vector_t across = arm_cross(vector_rad, change);
    const arm_vector_t twice  = arm_cross(vector_rad, across);
    return arm_sum(change, arm_sum(arm_times(across, first), arm_times(twice, second)));
}

void arm_trajectory_tool_at(const arm_trajectory_t* const trajectory, const double time_s, const double rate,
                            arm_pose_t* const out_pose, arm_twist_t* const out_twist)
{
    FSW_ASSERT((trajectory != NULL) && trajectory->is_tool && (out_pose != NULL) && (out_twist != NULL));
    arm_motion_t motion;
    arm_trajectory_at(trajectory, time_s, &motion);
    const arm_vector_t vector_rad = arm_vector(&motion.position_rad[VECTOR]);
    const arm_vector_t change     = arm_vector(&motion.velocity_rad_s[VECTOR]);
    out_pose->position_m          = arm_vector(motion.position_rad);
    out_pose->rotation            = arm_rotation_turned_by(&trajectory->start, vector_rad);
    out_twist->linear_m_s         = arm_times(arm_vector(motion.velocity_rad_s), rate);
    out_twist->angular_rad_s      = arm_times(rate_of(vector_rad, change), rate);
}
