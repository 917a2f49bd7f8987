// SPDX-License-Identifier: Apache-2.0
/// Telepresence: an operator's hand moves the tool of an arm in two directions. The arm keeps the other
/// components of the tool's pose, or of its position if it has fewer than six joints.
///
/// The tool follows the hand, scaled, as a critically damped system of second order. It slows down, if
/// necessary to rest, where a joint would exceed its speed or its range, or where the arm approaches a
/// singular pose; it moves on when the hand goes back. The only state is the desired motion itself, so no
/// difference accumulates meanwhile. Without samples of the hand the tool comes to rest; when samples arrive
/// (again), the hand is coupled at the present pose. See docs/arm.md.
///
/// Ownership  The caller provides the structures.
/// Context    One task.
/// Time       O(joints).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_HAND_H
#define FSW_SUBSYSTEMS_ARM_ARM_HAND_H

#include "fsw/subsystems/arm/arm_model.h"
#include "fsw/subsystems/arm/arm_path.h"

#include <stdbool.h>

#define ARM_HAND_AXES 2U

typedef struct {
    /// Perpendicular vectors of length 1; with length 0 the axis of the hand has no effect.
    arm_vector_t direction[ARM_HAND_AXES];
    double scale_m_rad;
    double dead_band_rad;
    double range_m; ///< Largest offset on both sides, in each direction.
    double bandwidth_rad_s;
} arm_hand_settings_t;

/// Cause that slows the tool down; telemetry contains these numbers.
typedef enum {
    ARM_HAND_LEADS    = 0, ///< None: the tool follows the hand.
    ARM_HAND_MISSING  = 1, ///< There is no sample of the hand.
    ARM_HAND_POSITION = 2, ///< A joint is near the end of its range.
    ARM_HAND_SPEED    = 3, ///< A joint has its largest speed.
    ARM_HAND_SINGULAR = 4  ///< The arm is near a singular pose.
} arm_hand_state_t;

typedef struct {
    const arm_model_t* model;
    const arm_limits_t* limits;
    arm_hand_settings_t settings;
    double period_s;
} arm_hand_setup_t;

typedef struct { // Read-only outside.
    bool is_coupled;
    arm_hand_state_t state;
    /// Pose of the tool when the hand was coupled; offsets are relative to it.
    arm_pose_t anchor;
    double hand_rad[ARM_HAND_AXES]; ///< Last sample of the hand.
    double zero_rad[ARM_HAND_AXES]; ///< Angle of the hand when it was coupled.
    double start_m[ARM_HAND_AXES];  ///< Offset of the tool at that time.
    double goal_m[ARM_HAND_AXES];   ///< Offset to which the tool goes.
    double offset_m[ARM_HAND_AXES]; ///< Present offset of the desired motion.
} arm_hand_t;

/// Make two perpendicular unit vectors from any two vectors: the first is normalised, and the component along
/// it is removed from the second. A vector without a direction left results in length 0.
void arm_hand_directions(const double components[6], arm_vector_t out_direction[ARM_HAND_AXES]);
/// Prepare to couple a hand at the present pose.
void arm_hand_begin(arm_hand_t* hand, const arm_model_t* model, const arm_motion_t* motion);
/// Replace `motion` by the next point of the motion. `hand_rad` is null while there is no sample of the
/// hand; an angle that is not finite is not a sample.
void arm_hand_step(arm_hand_t* hand, const arm_hand_setup_t* setup, const double* hand_rad,
                   arm_motion_t* motion);

#endif // FSW_SUBSYSTEMS_ARM_ARM_HAND_H
