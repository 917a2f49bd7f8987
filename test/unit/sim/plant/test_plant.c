// SPDX-License-Identifier: Apache-2.0
// The robot and its environment: friction, brakes, contour, spring, stops, repeatability. The numbers are
// those of descriptors/worlds/rokviss.xml and rokviss.urdf. Links: 0.22 m with 3 kg and 0.25 m with 2 kg.
// Gear: 8000 Nm/rad. Friction of a drive: Coulomb 2 Nm, static 2.4 Nm, Stribeck 0.02 rad/s, viscous 1
// Nms/rad. Contour: its flat part is touched with the tip at z = -0.030 m, its bump is a cylinder of 0.1 m
// radius about (0.325, -0.135) m; the finger has a radius of 0.012 m; contact 5000 N/m, friction 0.3. Spring:
// hook at (0.327, 0.155) m, end of the cable at (0.327, 0.005) m, preload 5 N, 500 N/m, the hook slips off at
// 60 N. Stick: 2e-3 kgm2, 0.01 Nms/rad, stops 200 Nm/rad. The joints start with the tip at (0.3265, 0.0655).
#include "sim/plant/plant.h"
#include "sim/plant/plant_internal.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "test/unit/sim/plant/plant_state.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#define STEP_NS 500000U
#define JOINTS 2U

/// Motors that hold a pose: proportional and damping torques plus a constant torque.
typedef struct {
    double wanted_rad[JOINTS];
    double extra_nm[JOINTS];
    double stiffness;
    double damping;
} holder_t;

static world_t world; // The world of the mission with the changes of a test.
static plant_t* plant;
static plant_input_t input;
static holder_t holder;

static void hold_pose(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    const holder_t* own = context;
    (void)substep;
    for (unsigned i = 0U; i < JOINTS; i++) {
        out_torque_nm[i] = own->extra_nm[i] + own->stiffness * (own->wanted_rad[i] - motor[i].position_rad) -
                           own->damping * motor[i].velocity_rad_s;
    }
}

static plant_t* plant_in(const world_t* of)
{
    char error[DOCUMENT_ERROR_MAX];
    plant_t* made = NULL;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(of, &made, error), error);
    return made;
}

static void begin(bool gravity)
{
    if (!gravity) {
        memset(world.gravity, 0, sizeof world.gravity);
    }
    plant_destroy(plant);
    plant  = plant_in(&world);
    holder = (holder_t){.stiffness = 4000.0, .damping = 100.0};
    memcpy(holder.wanted_rad, world.robot[0].start, sizeof holder.wanted_rad);
    input = (plant_input_t){.drive = hold_pose, .drive_context = &holder};
}

void setUp(void)
{
    world = rokviss()->world;
    begin(true);
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
}

static void run(double seconds)
{
    const unsigned steps = (unsigned)lround(seconds * 2000.0);
    for (unsigned i = 0U; i < steps; i++) {
        plant_step(plant, &input, STEP_NS);
    }
}

/// Motors that apply a constant torque only.
static void push(double first_nm, double second_nm)
{
    holder = (holder_t){.extra_nm = {first_nm, second_nm}};
}

/// Command the joint angles at which the tip is at (x, z) with the elbow up, by the law of cosines.
static void aim(double x, double z)
{
    const double l1 = rokviss()->scene.link_length_m[0];
    const double l2 = rokviss()->scene.link_length_m[1];
    const double d2 = x * x + z * z;
    const double d  = sqrt(d2);

    holder.wanted_rad[0] = atan2(z, x) + acos((l1 * l1 + d2 - l2 * l2) / (2.0 * l1 * d));
    holder.wanted_rad[1] = acos((l1 * l1 + l2 * l2 - d2) / (2.0 * l1 * l2)) - acos(-1.0);
}

/// Move the commanded tip position along a line at constant speed.
static void glide(double from_x, double from_z, double to_x, double to_z, double seconds)
{
    const unsigned steps = (unsigned)lround(seconds * 2000.0);
    for (unsigned i = 0U; i < steps; i++) {
        const double s = (double)(i + 1U) / (double)steps;
        aim(from_x + s * (to_x - from_x), from_z + s * (to_z - from_z));
        plant_step(plant, &input, STEP_NS);
    }
}

static void pull_spring(void)
{
    glide(0.3265, 0.0655, 0.327, 0.145, 1.0);
    glide(0.327, 0.145, 0.327, 0.215, 2.0);
    run(1.0);
}

// ---- Joints ----

static void gear_carries_gravity_when_at_rest(void)
{
    run(2.0);
    const plant_truth_t* truth = plant_truth(plant);
    const double q1            = truth->link_position_rad[0];
    const double q12           = q1 + truth->link_position_rad[1];
    const double g2            = 2.0 * 9.81 * 0.125 * cos(q12);
    const double g1            = (3.0 * 0.11 + 2.0 * 0.22) * 9.81 * cos(q1) + g2;
    EXPECT_WITHIN(g1, 1e-3, truth->joint_torque_nm[0]);
    EXPECT_WITHIN(g2, 1e-3, truth->joint_torque_nm[1]);
    EXPECT_WITHIN(g1 / 8000.0, 1e-6, truth->motor[0].position_rad - truth->link_position_rad[0]);
    EXPECT_WITHIN(truth->joint_torque_nm[0] + truth->friction_nm[0], 1e-9, truth->motor_torque_nm[0]);
}

static void the_tip_position_follows_from_the_joint_angles(void)
{
    run(0.5);
    const plant_truth_t* truth = plant_truth(plant);
    const double q1            = truth->link_position_rad[0];
    const double q12           = q1 + truth->link_position_rad[1];
    EXPECT_WITHIN(0.22 * cos(q1) + 0.25 * cos(q12), 1e-7, truth->contact[0].place_m[0]);
    EXPECT_WITHIN(0.22 * sin(q1) + 0.25 * sin(q12), 1e-7, truth->contact[0].place_m[2]);
    EXPECT_WITHIN(0.0, 1e-9, truth->contact[0].place_m[1]);
}

static void a_joint_sticks_below_the_static_friction_and_moves_above(void)
{
    begin(false);
    const double start = plant_truth(plant)->motor[0].position_rad;
    push(1.9, -1.9);
    run(2.0);
    TEST_ASSERT_TRUE(plant_truth(plant)->motor[0].position_rad == start);
    EXPECT_WITHIN(1.9, 1e-12, plant_truth(plant)->friction_nm[0]);
    push(2.35, 0.0); // Between Coulomb and static friction.
    run(1.0);
    TEST_ASSERT_TRUE(plant_truth(plant)->motor[0].position_rad == start);
    push(2.5, 0.0);
    run(1.0);
    EXPECT_ABOVE(0.02, plant_truth(plant)->motor[0].position_rad - start);
}

static void a_moving_rotor_has_coulomb_and_viscous_friction(void)
{
    world.robot[0].model.joint[0].upper = 100.0;
    begin(false);
    push(2.6, 0.0);
    run(8.0);
    const plant_truth_t* truth = plant_truth(plant);
    const double speed         = truth->motor[0].velocity_rad_s;
    EXPECT_ABOVE(0.3, speed);
    EXPECT_WITHIN(2.0 + 0.4 / (1.0 + speed * speed / 4.0e-4) + speed, 2e-3, truth->friction_nm[0]);
    // Less than Coulomb friction: the joint comes to rest and does not reverse.
    push(0.0, 0.0);
    run(2.0);
    const double rest = truth->motor[0].position_rad;
    TEST_ASSERT_TRUE(truth->motor[0].velocity_rad_s == 0.0);
    run(1.0);
    TEST_ASSERT_TRUE(truth->motor[0].position_rad == rest);
}

static void an_arm_without_torque_or_brake_falls(void)
{
    run(1.0);
    const double before = plant_truth(plant)->link_position_rad[0];
    push(0.0, 0.0);
    run(0.3);
    EXPECT_BELOW(before - 0.2, plant_truth(plant)->link_position_rad[0]);
}

/// Returns the largest motion of a link after the motors lose their current and the brakes engage.
static double brake_drop(double seconds)
{
    const plant_truth_t* truth = plant_truth(plant);
    const double first         = truth->link_position_rad[0];
    const double second        = truth->link_position_rad[1];
    double worst               = 0.0;
    push(0.0, 0.0);
    input.brake_engaged[0] = true;
    input.brake_engaged[1] = true;
    for (unsigned i = 0U; i < (unsigned)lround(seconds * 2000.0); i++) {
        plant_step(plant, &input, STEP_NS);
        worst = fmax(worst, fabs(truth->link_position_rad[0] - first));
        worst = fmax(worst, fabs(truth->link_position_rad[1] - second));
    }
    return worst;
}

static void brake_holds_against_gravity(void)
{
    run(1.0);
    EXPECT_BELOW(1e-4, brake_drop(10.0));
    TEST_ASSERT_TRUE(plant_truth(plant)->brake_engaged[1]);
    TEST_ASSERT_TRUE(plant_truth(plant)->motor[0].velocity_rad_s == 0.0);
}

static void brake_holds_against_the_spring(void)
{
    pull_spring();
    EXPECT_BELOW(-30.0, plant_truth(plant)->spring[0].force_n[2]);
    EXPECT_BELOW(1e-4, brake_drop(10.0));
}

static void brake_stops_a_moving_joint(void)
{
    begin(false);
    push(10.0, 0.0);
    run(0.05);
    const plant_truth_t* truth = plant_truth(plant);
    const double speed         = truth->motor[0].velocity_rad_s;
    const double from          = truth->motor[0].position_rad;
    EXPECT_ABOVE(0.3, speed);
    input.brake_engaged[0] = true;
    run(0.02);
    TEST_ASSERT_TRUE(truth->motor[0].velocity_rad_s == 0.0);
    // The brake of 100 Nm absorbs the kinetic energy of the rotor (0.256 kgm2) and of at most 0.25 kgm2 of
    // the links, on the other side of the elastic gear.
    EXPECT_BELOW(speed * speed * (0.256 + 0.25) / 2.0 / 100.0, truth->motor[0].position_rad - from);
}

static void joint_stops_at_its_range(void)
{
    begin(false);
    push(10.0, 0.0);
    run(4.0);
    EXPECT_WITHIN(world.robot[0].model.joint[0].upper, 2e-3, plant_truth(plant)->motor[0].position_rad);
    EXPECT_WITHIN(0.0, 1e-3, plant_truth(plant)->motor[0].velocity_rad_s);
}

// ---- Contour ----

/// Press on the flat part at x: command a tip position that is below the surface by `below_m`.
static void press_at(double x, double below_m)
{
    glide(0.3265, 0.0655, x, -0.02, 1.0);
    glide(x, -0.02, x, -0.030 - below_m, 1.0);
    run(1.0);
}

static void a_contact_has_the_given_stiffness(void)
{
    const double stiffness[] = {2000.0, 5000.0, 20000.0};
    for (unsigned i = 0U; i < 3U; i++) {
        world.contact[0].stiffness = stiffness[i];
        begin(true);
        press_at(0.25, 0.005);
        const plant_truth_t* truth = plant_truth(plant);
        const double depth =
            rokviss()->scene.contour_top_m + rokviss()->scene.tip_radius_m - truth->contact[0].place_m[2];
        TEST_ASSERT_TRUE(truth->contact[0].is_touching);
        EXPECT_ABOVE(5.0, truth->contact[0].force_n[2]);
        EXPECT_WITHIN(1.0, 1e-3, truth->contact[0].force_n[2] / (stiffness[i] * depth));
        EXPECT_WITHIN(truth->contact[0].place_m[2] - 0.012, 1e-6, truth->contact[0].point_m[2]);
    }
}

static void a_contact_only_pushes(void)
{
    press_at(0.25, 0.005);
    const unsigned lift = 2000U;
    for (unsigned i = 0U; i < lift; i++) {
        aim(0.25, -0.035 + 0.02 * (double)i / lift);
        plant_step(plant, &input, STEP_NS);
        TEST_ASSERT_TRUE(plant_truth(plant)->contact[0].force_n[2] >= 0.0);
    }
    TEST_ASSERT_FALSE(plant_truth(plant)->contact[0].is_touching);
    EXPECT_WITHIN(0.0, 0.0, plant_truth(plant)->contact[0].point_m[0]);
}

// ODE computes the limit of friction from the normal force without friction. Here that force, and so the
// limit, is up to 1 % larger than with friction.
static void friction_is_within_its_cone_and_opposes_the_motion(void)
{
    world.contact[0].shear = 0.0; // The contact slides as soon as the finger moves.
    begin(true);
    press_at(0.22, 0.005);
    const plant_truth_t* truth = plant_truth(plant);
    unsigned sliding           = 0U;
    for (unsigned i = 0U; i < 4000U; i++) { // 50 mm along the flat part in 2 s; the rotors stick and slip.
        const double before = truth->contact[0].place_m[0];
        aim(0.22 + 0.05 * (double)i / 4000.0, -0.035);
        plant_step(plant, &input, STEP_NS);
        const double normal  = truth->contact[0].force_n[2];
        const double tangent = truth->contact[0].force_n[0];
        EXPECT_BELOW(0.303 * normal + 1e-6, fabs(tangent));
        if (truth->contact[0].place_m[0] - before > 2.0e-6) { // The finger slides, faster than 4 mm/s.
            EXPECT_WITHIN(-0.3 * normal, 0.004 * normal, tangent);
            sliding++;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT(1000U, sliding);
}

static void a_sticking_finger_does_not_creep(void)
{
    press_at(0.25, 0.005);
    run(2.0);
    const double x = plant_truth(plant)->contact[0].place_m[0];
    run(5.0);
    EXPECT_WITHIN(x, 1e-6, plant_truth(plant)->contact[0].place_m[0]);
}

static void the_bump_pushes_along_its_normal(void)
{
    world.contact[0].friction = 0.0;
    begin(true);
    glide(0.3265, 0.0655, 0.345, 0.0, 1.0);
    glide(0.345, 0.0, 0.345, -0.03, 1.0);
    run(1.0);
    const plant_truth_t* truth = plant_truth(plant);
    const double x             = truth->contact[0].place_m[0] - 0.325;
    const double z             = truth->contact[0].place_m[2] - (-0.042 + 0.007 - 0.10);
    const double depth         = 0.112 - sqrt(x * x + z * z);
    EXPECT_ABOVE(0.0, depth);
    EXPECT_WITHIN(x / z, 1e-6, truth->contact[0].force_n[0] / truth->contact[0].force_n[2]);
    EXPECT_WITHIN(5000.0 * depth, 0.02,
                  sqrt(truth->contact[0].force_n[0] * truth->contact[0].force_n[0] +
                       truth->contact[0].force_n[2] * truth->contact[0].force_n[2]));
}

static void external_torque_balances_gear_and_gravity(void)
{
    // At rest the sensor measures gravity minus the external forces: a second way to the same value.
    press_at(0.25, 0.005);
    run(3.0);
    const plant_truth_t* truth = plant_truth(plant);
    const double q1            = truth->link_position_rad[0];
    const double q12           = q1 + truth->link_position_rad[1];
    const double g2            = 2.0 * 9.81 * 0.125 * cos(q12);
    const double g1            = (3.0 * 0.11 + 2.0 * 0.22) * 9.81 * cos(q1) + g2;
    EXPECT_ABOVE(2.0, truth->external_torque_nm[0]);
    EXPECT_WITHIN(g1 - truth->joint_torque_nm[0], 1e-3, truth->external_torque_nm[0]);
    EXPECT_WITHIN(g2 - truth->joint_torque_nm[1], 1e-3, truth->external_torque_nm[1]);
}

// ---- Spring ----

static double pull_at(spring_t* spring, double x, double z)
{
    const double tip[3] = {x, 0.0, z};
    double force[3];
    spring_force(&world.spring[0], spring, tip, force);
    return -force[2];
}

static void the_spring_pulls_with_preload_and_stiffness_and_never_pushes(void)
{
    spring_t spring = {.below = true};
    EXPECT_WITHIN(0.0, 0.0, pull_at(&spring, 0.327, 0.150));
    EXPECT_WITHIN(3.0, 1e-9, pull_at(&spring, 0.327, 0.156)); // Half the preload and 0.5 N.
    EXPECT_WITHIN(6.0, 1e-9, pull_at(&spring, 0.327, 0.157));
    EXPECT_WITHIN(35.0, 1e-9, pull_at(&spring, 0.327, 0.215));
    EXPECT_WITHIN(6.0, 1e-9, pull_at(&spring, 0.327, 0.157)); // The same force on the way back.
    EXPECT_WITHIN(0.0, 0.0, pull_at(&spring, 0.327, 0.154));  // A cable does not push.
    TEST_ASSERT_FALSE(spring.hooked);
    EXPECT_WITHIN(35.0, 1e-9, pull_at(&spring, 0.327, 0.215)); // Hooked again.
}

static void spring_pulls_towards_its_anchor(void)
{
    spring_t spring     = {.below = true};
    const double tip[3] = {0.340, 0.0, 0.200};
    double force[3];
    (void)pull_at(&spring, 0.330, 0.155);
    spring_force(&world.spring[0], &spring, tip, force);
    EXPECT_WITHIN((0.340 - 0.327) / (0.200 - 0.005), 1e-12, force[0] / force[2]);
    EXPECT_BELOW(0.0, force[0]);
}

static void the_finger_does_not_catch_the_hook_beside_it(void)
{
    spring_t spring = {.below = true};
    EXPECT_WITHIN(0.0, 0.0, pull_at(&spring, 0.36, 0.160));
    // The finger is already above the hook and does not catch it.
    EXPECT_WITHIN(0.0, 0.0, pull_at(&spring, 0.327, 0.160));
    TEST_ASSERT_FALSE(spring.hooked);
}

static void a_hook_slips_off_at_its_limit_and_can_be_hooked_again(void)
{
    spring_t spring = {.below = true};
    EXPECT_WITHIN(59.5, 1e-9, pull_at(&spring, 0.327, 0.264));
    EXPECT_WITHIN(0.0, 0.0, pull_at(&spring, 0.327, 0.266)); // The force would be 60.5 N.
    EXPECT_WITHIN(0.0, 0.0, pull_at(&spring, 0.327, 0.215));
    EXPECT_WITHIN(0.0, 0.0, pull_at(&spring, 0.327, 0.150));
    EXPECT_WITHIN(35.0, 1e-9, pull_at(&spring, 0.327, 0.215));
}

static void the_spring_force_loads_the_joints_of_the_arm(void)
{
    pull_spring();
    const plant_truth_t* truth = plant_truth(plant);
    TEST_ASSERT_TRUE(truth->spring[0].is_hooked);
    const double force = truth->spring[0].force_n[2];
    EXPECT_WITHIN(5.0 + 500.0 * (truth->contact[0].place_m[2] - 0.155), 0.05, -force);
    EXPECT_WITHIN(truth->contact[0].place_m[0] * force, 0.1, truth->external_torque_nm[0]);
    EXPECT_BELOW(-10.0, truth->external_torque_nm[0]);
    EXPECT_BELOW(-7.0, truth->external_torque_nm[1]);
}

// ---- Joystick ----

static void push_stick(void* context, unsigned substep, const double* stick_position_rad,
                       const double* stick_velocity_rad_s, double* out_torque_nm)
{
    (void)context;
    (void)substep;
    out_torque_nm[0] = 3.0 * (0.1 - stick_position_rad[0]) - 0.1 * stick_velocity_rad_s[0];
    out_torque_nm[1] = 0.0;
}

static void stick_balances_hand_and_motor(void)
{
    input.hand[0]               = push_stick;
    input.stick_torque_nm[0][0] = -0.15;
    run(3.0);
    const plant_truth_t* truth = plant_truth(plant);
    EXPECT_WITHIN(0.05, 1e-5, truth->stick[0].position_rad[0]);
    EXPECT_WITHIN(0.15, 1e-4, truth->stick[0].hand_torque_nm[0]);
    EXPECT_WITHIN(-0.15, 0.0, truth->stick[0].torque_nm[0]);
    EXPECT_WITHIN(0.0, 0.0, truth->stick[0].position_rad[1]);
}

static void stick_accelerates_by_its_inertia(void)
{
    input.stick_torque_nm[0][1] = 0.02; // 10 rad/s2
    run(0.1);
    EXPECT_WITHIN(1.0, 0.3, plant_truth(plant)->stick[0].velocity_rad_s[1]);
    EXPECT_WITHIN(0.02 / 0.01 * (1.0 - exp(-0.1 * 0.01 / 2e-3)), 2e-3,
                  plant_truth(plant)->stick[0].velocity_rad_s[1]);
}

static void stick_stops_at_its_range(void)
{
    input.stick_torque_nm[0][0] = 1.5;
    input.stick_torque_nm[0][1] = -1.5;
    run(1.0);
    const plant_truth_t* truth = plant_truth(plant);
    EXPECT_WITHIN(world.joystick[0].range + 1.5 / 200.0, 1e-4, truth->stick[0].position_rad[0]);
    EXPECT_WITHIN(-world.joystick[0].range - 1.5 / 200.0, 1e-4, truth->stick[0].position_rad[1]);
}

// ---- Repeatability ----

/// Run a motion with all effects. Returns the checksum of the final state.
static uint64_t eventful_run(void)
{
    begin(true);
    input.hand[0] = push_stick;
    press_at(0.28, 0.003);
    glide(0.28, -0.033, 0.36, -0.033, 1.0);
    glide(0.36, -0.033, 0.327, 0.145, 1.0);
    glide(0.327, 0.145, 0.327, 0.215, 1.0);
    input.brake_engaged[0] = true;
    run(0.5);
    return plant_hash(plant);
}

static void equal_runs_are_bit_identical(void)
{
    const uint64_t first = eventful_run();
    TEST_ASSERT_TRUE(first == eventful_run());
}

static void worlds_do_not_disturb_each_other(void)
{
    const uint64_t alone     = eventful_run();
    plant_t* const other     = plant_in(&world);
    const plant_input_t idle = {0};
    for (unsigned i = 0U; i < 500U; i++) {
        plant_step(other, &idle, STEP_NS);
    }
    TEST_ASSERT_TRUE(alone == eventful_run());
    for (unsigned i = 0U; i < 500U; i++) {
        plant_step(other, &idle, STEP_NS);
    }
    plant_t* const again = plant_in(&world);
    for (unsigned i = 0U; i < 1000U; i++) {
        plant_step(again, &idle, STEP_NS);
    }
    TEST_ASSERT_TRUE(plant_hash(other) == plant_hash(again));
    plant_destroy(other);
    plant_destroy(again);
}

static void the_checksum_changes_with_the_state_only(void)
{
    const uint64_t before = plant_hash(plant);
    plant_step(plant, &input, STEP_NS);
    const uint64_t after = plant_hash(plant);
    TEST_ASSERT_FALSE(before == after);
    TEST_ASSERT_TRUE(after == plant_hash(plant));
}

#if defined(__SSE2__)
static void a_contact_leaves_no_denormal_numbers(void)
{
    press_at(0.25, 0.003);
    glide(0.25, -0.033, 0.327, 0.06, 1.0);
    run(20.0);
    for (unsigned i = 0U; i < JOINTS; i++) {
        for (unsigned axis = 0U; axis < 3U; axis++) {
            TEST_ASSERT_FALSE(fpclassify(dBodyGetLinearVel(plant->robot[0].body[i + 1U])[axis]) ==
                              FP_SUBNORMAL);
            TEST_ASSERT_FALSE(fpclassify(dBodyGetAngularVel(plant->robot[0].body[i + 1U])[axis]) ==
                              FP_SUBNORMAL);
            TEST_ASSERT_FALSE(fpclassify(dBodyGetPosition(plant->robot[0].body[i + 1U])[axis]) ==
                              FP_SUBNORMAL);
        }
        TEST_ASSERT_FALSE(fpclassify(plant_truth(plant)->motor[i].velocity_rad_s) == FP_SUBNORMAL);
    }
}

static unsigned mode_inside;

static void note_mode(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    (void)substep;
    (void)motor;
    (void)out_torque_nm;
    mode_inside = _mm_getcsr();
}

static void the_floating_point_mode_of_the_caller_is_restored(void)
{
    const unsigned before  = _mm_getcsr(); // 0x8040: denormal numbers are zero. 0x6000: rounding.
    const unsigned modes[] = {before & ~0x8040U, before | 0x8040U, (before & ~0x6000U) | 0x2000U};
    input.drive            = note_mode;
    for (unsigned i = 0U; i < 3U; i++) {
        _mm_setcsr(modes[i]);
        plant_step(plant, &input, STEP_NS);
        const unsigned after = _mm_getcsr();
        _mm_setcsr(before);
        TEST_ASSERT_EQUAL_HEX32(modes[i], after);
        TEST_ASSERT_EQUAL_HEX32(0x8040U, mode_inside & 0x8040U);
    }
}
#endif

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(gear_carries_gravity_when_at_rest);
    RUN_TEST(the_tip_position_follows_from_the_joint_angles);
    RUN_TEST(a_joint_sticks_below_the_static_friction_and_moves_above);
    RUN_TEST(a_moving_rotor_has_coulomb_and_viscous_friction);
    RUN_TEST(an_arm_without_torque_or_brake_falls);
    RUN_TEST(brake_holds_against_gravity);
    RUN_TEST(brake_holds_against_the_spring);
    RUN_TEST(brake_stops_a_moving_joint);
    RUN_TEST(joint_stops_at_its_range);
    RUN_TEST(a_contact_has_the_given_stiffness);
    RUN_TEST(a_contact_only_pushes);
    RUN_TEST(friction_is_within_its_cone_and_opposes_the_motion);
    RUN_TEST(a_sticking_finger_does_not_creep);
    RUN_TEST(the_bump_pushes_along_its_normal);
    RUN_TEST(external_torque_balances_gear_and_gravity);
    RUN_TEST(the_spring_pulls_with_preload_and_stiffness_and_never_pushes);
    RUN_TEST(spring_pulls_towards_its_anchor);
    RUN_TEST(the_finger_does_not_catch_the_hook_beside_it);
    RUN_TEST(a_hook_slips_off_at_its_limit_and_can_be_hooked_again);
    RUN_TEST(the_spring_force_loads_the_joints_of_the_arm);
    RUN_TEST(stick_balances_hand_and_motor);
    RUN_TEST(stick_accelerates_by_its_inertia);
    RUN_TEST(stick_stops_at_its_range);
    RUN_TEST(equal_runs_are_bit_identical);
    RUN_TEST(worlds_do_not_disturb_each_other);
    RUN_TEST(the_checksum_changes_with_the_state_only);
#if defined(__SSE2__)
    RUN_TEST(a_contact_leaves_no_denormal_numbers);
    RUN_TEST(the_floating_point_mode_of_the_caller_is_restored);
#endif
    return UNITY_END();
}
