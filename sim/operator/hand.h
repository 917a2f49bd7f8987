// SPDX-License-Identifier: Apache-2.0
/// The operator's hand on the joystick: an impedance whose rest point, the intent, follows a script. The
/// lines of the actor `hand` are listed in docs/scenarios.md.
///
/// A hand that only follows positions never reaches the intended force. Therefore the hand has a model of the
/// scene: it computes the torque of contour and spring at the wanted pose, and moves its rest point to
/// produce it,
///     intent = (wanted joint position - home) / s_p - s_f x expected torque / grip stiffness,
/// where the wanted position is corrected by the compliance of the arm. Without a scene, the script commands
/// the intent directly (`aim`, `circle`), and the hand expects no torque.
///
/// Ownership  hand_load allocates, hand_destroy frees.
/// Use        hand_step once per plant step; hand_torque in each rotor substep, or hand_act, which has the
///            type of plant_input_t.hand.
#ifndef SIM_OPERATOR_HAND_H
#define SIM_OPERATOR_HAND_H

#include "base/status.h"
#include "sim/operator/scenario.h"
#include "sim/operator/scene.h"
#include "sim/world/world.h"

#include <stdbool.h>
#include <stdint.h>

#define HAND_AXES SCENE_JOINTS ///< Each axis of the stick commands one joint.

typedef struct {
    double grip_stiffness_nm_rad; ///< Initial value: a line `grip` changes it.
    double grip_damping_nms_rad;  ///< Initial value: a line `grip` changes it.
    double position_scale;        ///< s_p: joint angle per stick angle.
    double force_scale;           ///< s_f: stick torque per joint torque.
    double arm_stiffness_nm_rad;  ///< Arm stiffness of a joint under control, as the operator has learned it.
} hand_parameters_t;

/// Present action of the hand, for the truth log.
typedef struct {
    double intent_rad[HAND_AXES];
    double wanted_tip_m[2]; ///< x, z.
    double wanted_joint_rad[SCENE_JOINTS];
    double expected_torque_nm[SCENE_JOINTS]; ///< Torque of contour and spring on the arm.
    /// Share of the grip that acts: 0 (the hand is off the stick) to 1.
    double grip;
    const char* verb; ///< Static text; "rest" before the first line.
} hand_intent_t;

typedef struct hand hand_t;

hand_parameters_t hand_parameters_of(const world_hand_t* hand);

/// Create a hand that plays the `hand` lines of a scenario; if `path` is null, the hand rests. Parameters and
/// scene (null: the hand knows no scene) are copied. Returns STATUS_OK; else *out_hand is null and `error`
/// contains file:line, value and expectation: STATUS_NOT_FOUND, STATUS_INVALID, STATUS_EXHAUSTED (no memory).
MUST_USE status_t hand_load(const hand_parameters_t* parameters, const scene_t* scene, const char* path,
                            hand_t** out_hand, char error[SCENARIO_ERROR_MAX]);

/// Check the scenario of a world without a hand (null: none). STATUS_OK if no line is for the hand; else
/// `error` is filled as by hand_load: STATUS_NOT_FOUND, STATUS_INVALID.
MUST_USE status_t hand_check_no_lines(const char* path, char error[SCENARIO_ERROR_MAX]);

/// Add one line of the actor `hand`; its time must not be before that of the last hand_step. The line acts
/// after earlier lines of the same time. A refused line changes nothing. STATUS_OK; else `error` is filled:
/// STATUS_INVALID, STATUS_EXHAUSTED (no memory).
MUST_USE status_t hand_add(hand_t* hand, const scenario_line_t* line, char error[SCENARIO_ERROR_MAX]);

/// Null is allowed.
void hand_destroy(hand_t* hand);

/// Advance the intent to `time_ns`, which must not be earlier than that of the last call.
void hand_step(hand_t* hand, uint64_t time_ns);

/// Torque on the stick for its position and velocity, at the present intent.
void hand_torque(const hand_t* hand, const double stick_position_rad[HAND_AXES],
                 const double stick_velocity_rad_s[HAND_AXES], double out_torque_nm[HAND_AXES]);

/// hand_torque in the form of plant_input_t.hand; `context` is the hand_t.
void hand_act(void* context, unsigned substep, const double* stick_position_rad,
              const double* stick_velocity_rad_s, double* out_torque_nm);

/// Present intent; updated by hand_step.
const hand_intent_t* hand_intent(const hand_t* hand);

#endif // SIM_OPERATOR_HAND_H
