// SPDX-License-Identifier: Apache-2.0
/// Telepresence: an operator's hand leads the tool of an arm in two directions; the arm keeps the rest of the
/// tool's pose (with fewer than six joints: of its position).
///
/// The tool follows the hand, scaled, as a critically damped system of second order. It slows down, to
/// rest if need be, where a joint would exceed its speed or its range, or where the arm comes near a
/// singular pose; a hand that goes back leads it on. The state is the desired motion itself: nothing
/// winds up meanwhile. Without a hand the tool comes to rest where it is. A hand that comes (back) takes
/// over from there. See docs/arm.md.
///
/// Ownership  The caller places the structures.
/// Context    One task.
/// Time       O(joints).
#ifndef FSW_SUBSYSTEMS_ARM_ARM_HAND_H
#define FSW_SUBSYSTEMS_ARM_ARM_HAND_H

#include "fsw/subsystems/arm/arm_model.h"
#include "fsw/subsystems/arm/arm_path.h"

#include <stdbool.h>

#define ARM_HAND_AXES 2U

typedef struct {
    arm_vector_t
        direction[ARM_HAND_AXES]; ///< Perpendicular, of length 1; of length 0: the axis has no effect.
    double scale_m_rad;
    double dead_band_rad;
    double range_m; ///< On both sides, in each direction.
    double bandwidth_rad_s;
} arm_hand_settings_t;

/// What slows the tool down; the numbers are in telemetry.
typedef enum {
    ARM_HAND_LEADS    = 0,
    ARM_HAND_MISSING  = 1, ///< No sample of the hand.
    ARM_HAND_POSITION = 2, ///< A joint near the end of its range.
    ARM_HAND_SPEED    = 3, ///< A joint at its largest speed.
    ARM_HAND_SINGULAR = 4  ///< Near a singular pose.
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
    /// Pose of the tool when the hand began to lead; offsets count from here.
    arm_pose_t anchor;
    double hand_rad[ARM_HAND_AXES]; ///< Last sample.
    double zero_rad[ARM_HAND_AXES]; ///< Angle at which the hand took over ..
    double start_m[ARM_HAND_AXES];  ///< .. the tool at this offset.
    double goal_m[ARM_HAND_AXES];   ///< Offset to which the tool goes.
    double offset_m[ARM_HAND_AXES]; ///< Present offset of the desired motion.
} arm_hand_t;

/// Two directions as an arm needs them, from any two vectors: the part of the second along the first is
/// removed.
void arm_hand_directions(const double components[6], arm_vector_t out_direction[ARM_HAND_AXES]);
/// Lead from the present pose on, when a hand comes.
void arm_hand_begin(arm_hand_t* hand, const arm_model_t* model, const arm_motion_t* motion);
/// The next point of the motion replaces `motion`. `hand_rad`: null while the hand is not known.
void arm_hand_step(arm_hand_t* hand, const arm_hand_setup_t* setup, const double* hand_rad,
                   arm_motion_t* motion);

#endif // FSW_SUBSYSTEMS_ARM_ARM_HAND_H
