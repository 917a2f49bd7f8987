// SPDX-License-Identifier: Apache-2.0
// Robots of any shape: trees of joints about any axis, several in a world, on fixed and free bases; and
// worlds that the plant does not support, refused with file and line.
#include "sim/plant/parameters.h"
#include "sim/plant/plant.h"
#include "sim/plant/plant_internal.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "test/unit/sim/plant/plant_state.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define STEP_NS 500000U
#define HALF_TURN 3.14159265358979323846

#define INERTIAL(xyz, mass)                                                                                  \
    "<inertial><origin xyz=\"" xyz "\" rpy=\"0.3 -0.2 0.5\"/><mass value=\"" mass                            \
    "\"/><inertia ixx=\"0.02\" ixy=\"0.001\" ixz=\"-0.002\" iyy=\"0.03\" iyz=\"0.003\" "                     \
    "izz=\"0.025\"/></inertial>"
#define LINK(name, xyz, mass) "<link name=\"" name "\">" INERTIAL(xyz, mass) "</link>\n"
#define BALL(name, xyz, mass)                                                                                \
    "<link name=\"" name                                                                                     \
    "\">" INERTIAL(xyz, mass) "<collision><geometry><sphere radius=\"0.1\"/></geometry>"                     \
                              "</collision></link>\n"
#define JOINT(name, type, parent, child, origin, axis)                                                       \
    "<joint name=\"" name "\" type=\"" type "\"><origin " origin "/><parent link=\"" parent                  \
    "\"/><child link=\"" child "\"/><axis xyz=\"" axis                                                       \
    "\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint>\n"

/// A trunk that turns, with two branches: one has two revolute joints, the other a prismatic joint.
#define TREE                                                                                                 \
    "<robot name=\"tree\">\n" BALL("base", "0 0 0", "5") LINK("trunk", "0.02 0.01 0.2", "4")                 \
        LINK("upper", "0.15 0.01 0", "2") BALL("lower", "0.1 0 0.02", "1") LINK("rod", "0 0 0.1", "1.5")     \
            JOINT("turn", "continuous", "base", "trunk", "xyz=\"0 0 0.1\"", "0 0 1")                         \
                JOINT("fold1", "revolute", "trunk", "upper", "xyz=\"0.1 0 0.3\" rpy=\"0.4 0 0\"", "0 1 0")   \
                    JOINT("fold2", "revolute", "upper", "lower", "xyz=\"0.3 0 0\"", "0 1 0.2")               \
                        JOINT("slide", "prismatic", "trunk", "rod", "xyz=\"-0.1 0 0.3\" rpy=\"0 -0.7 0\"",   \
                              "0 0 1") "</robot>\n"

#define TYPE                                                                                                 \
    "<DriveType name=\"t\" ratio=\"100\" rotorInertia=\"0.2\" stiffness=\"8000\" damping=\"8\" "             \
    "coulomb=\"0.5\" stiction=\"0.5\" stribeck=\"0.02\" viscous=\"1\" brake=\"100\" stopStiffness=\"2e4\" "  \
    "stopDamping=\"200\" encoderCounts=\"65536\"><TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" "        \
    "range=\"90\"/></DriveType>\n"
#define DRIVE(name, joint, node)                                                                             \
    "<Drive name=\"" name "\" joint=\"" joint "\" type=\"t\" bus=\"b\" node=\"" node                         \
    "\" eds=\"joint-drive.eds\"/>\n"
#define FOLDS(robot) DRIVE("B" robot, robot ".fold1", "12") DRIVE("C" robot, robot ".fold2", "13")
#define DRIVES(robot)                                                                                        \
    DRIVE("A" robot, robot ".turn", "11") FOLDS(robot) DRIVE("D" robot, robot ".slide", "14")
#define IN_WORLD(gravity, text)                                                                              \
    "<World name=\"w\" step=\"500us\" gravity=\"" gravity "\">\n" text "</World>\n"
#define START "<Start turn=\"0.7\" fold1=\"0.4\" fold2=\"-0.9\" slide=\"0.2\"/>"

static world_t world;
static plant_t* plant;
static char error[DOCUMENT_ERROR_MAX];
static double wanted[PLANT_JOINTS_MAX];

void setUp(void)
{
    (void)temporary_variant("heavy.urdf", temporary_file("tree.urdf", TREE), "<mass value=\"5\"/>",
                            "<mass value=\"200\"/>");
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
    temporary_files_remove();
}

static void begin(const char* text)
{
    plant_destroy(plant);
    plant = NULL;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    memcpy(wanted, plant_truth(plant)->link_position_rad, sizeof wanted);
}

static void hold(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    (void)substep;
    for (unsigned i = 0U; i < plant_truth(plant)->joint_count; i++) {
        out_torque_nm[i] = 4000.0 * (wanted[i] - motor[i].position_rad) - 200.0 * motor[i].velocity_rad_s;
    }
}

static void run(double seconds)
{
    static plant_input_t input;
    input.drive = hold;
    for (unsigned i = 0U; i < (unsigned)lround(seconds * 2000.0); i++) {
        plant_step(plant, &input, STEP_NS);
    }
}

// ---- At rest ----

/// Pose of a body of the tree at joint positions, computed from the model.
static pose_t pose_at(const double q[], unsigned body)
{
    const robot_model_t* model = &world.robot[0].model;
    if (body == 0U) {
        return world.robot[0].pose;
    }
    const robot_joint_t* joint = &model->joint[body - 1U];
    const double* a            = joint->axis;
    const bool slides          = joint->kind == ROBOT_JOINT_PRISMATIC;
    const double c             = slides ? 1.0 : cos(q[body - 1U]);
    const double s             = slides ? 0.0 : sin(q[body - 1U]);
    const double d             = slides ? q[body - 1U] : 0.0;
    const pose_t moved         = {.rotation   = {{{c + (1 - c) * a[0] * a[0], (1 - c) * a[0] * a[1] - s * a[2],
                                                   (1 - c) * a[0] * a[2] + s * a[1]},
                                                  {(1 - c) * a[0] * a[1] + s * a[2], c + (1 - c) * a[1] * a[1],
                                                   (1 - c) * a[1] * a[2] - s * a[0]},
                                                  {(1 - c) * a[0] * a[2] - s * a[1], (1 - c) * a[1] * a[2] + s * a[0],
                                                   c + (1 - c) * a[2] * a[2]}}},
                                  .position_m = {d * a[0], d * a[1], d * a[2]}};
    const pose_t parent        = pose_at(q, joint->parent);
    const pose_t before        = pose_compose(&parent, &joint->origin);
    return pose_compose(&before, &moved);
}

static double potential(const double q[])
{
    const robot_model_t* model = &world.robot[0].model;
    double energy              = 0.0;
    for (unsigned i = 0U; i <= model->joint_count; i++) {
        double centre[3];
        const pose_t pose = pose_at(q, i);
        pose_apply(&pose, model->body[i].com_m, centre);
        for (unsigned k = 0U; k < 3U; k++) {
            energy -= model->body[i].mass_kg * world.gravity[k] * centre[k];
        }
    }
    return energy;
}

static void gears_carry_the_weight_of_a_tree(void)
{
    begin(IN_WORLD("1 -2 -9.81", "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"><State at=\"1 2 3\" "
                                 "rpy=\"0.2 0.3 -0.4\"/>" START "</Robot>\n" TYPE DRIVES("r")));
    run(3.0);
    const plant_truth_t* truth = plant_truth(plant);
    TEST_ASSERT_EQUAL_UINT(4U, truth->joint_count);
    for (unsigned i = 0U; i < 4U; i++) {
        double up[4];
        double down[4];
        memcpy(up, truth->link_position_rad, sizeof up);
        memcpy(down, truth->link_position_rad, sizeof down);
        up[i] += 1e-5;
        down[i] -= 1e-5;
        EXPECT_WITHIN(0.0, 0.02, truth->link_position_rad[i] - wanted[i]);
        EXPECT_WITHIN((potential(up) - potential(down)) / 2e-5, 1e-3, truth->joint_torque_nm[i]);
    }
}

static void poses_of_bodies_follow_from_the_joints(void)
{
    begin(IN_WORLD("0 0 -9.81", "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"><State at=\"1 2 3\" "
                                "rpy=\"0.2 0.3 -0.4\"/>" START "</Robot>\n" TYPE DRIVES("r")));
    for (unsigned i = 0U; i < 4U; i++) {
        wanted[i] += 0.3;
    }
    run(2.0);
    for (unsigned i = 0U; i < 5U; i++) {
        const double off[3] = {0.3, -0.2, 0.1};
        double found[3];
        double expected[3];
        const pose_t pose = pose_at(plant_truth(plant)->link_position_rad, i);
        robot_point(plant, 0U, i, off, found);
        pose_apply(&pose, off, expected);
        for (unsigned k = 0U; k < 3U; k++) {
            EXPECT_WITHIN(expected[k], 1e-6, found[k]);
        }
    }
}

static void robots_do_not_share_joints(void)
{
    begin(IN_WORLD("0 0 -9.81",
                   "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"/>\n"
                   "<Robot name=\"s\" urdf=\"tree.urdf\" base=\"fixed\"><State at=\"0 5 0\"/>" START
                   "</Robot>\n" TYPE DRIVE("A", "s.fold1", "11")));
    TEST_ASSERT_EQUAL_UINT(8U, plant_truth(plant)->joint_count);
    TEST_ASSERT_EQUAL_UINT(5U, plant_joint(&world, 1U, 1U));
    EXPECT_WITHIN(0.4, 0.0, plant_truth(plant)->link_position_rad[5]);
    TEST_ASSERT_NOT_NULL(plant->joint[5].drive_of);
    TEST_ASSERT_NULL(plant->joint[1].drive_of);
}

static void each_joint_has_its_own_drive(void)
{
    begin(IN_WORLD(
        "0 0 0",
        "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"/>\n" TYPE
        "<DriveType name=\"h\" ratio=\"100\" rotorInertia=\"0.5\" stiffness=\"9000\" damping=\"9\" "
        "coulomb=\"3\" stiction=\"3\" stribeck=\"0.02\" viscous=\"1\" brake=\"100\" "
        "stopStiffness=\"1\" stopDamping=\"1\" encoderCounts=\"4096\"><TorqueSensor noise=\"0\" "
        "offset=\"0\" drift=\"0\" range=\"80\"/></DriveType>\n" DRIVE(
            "A", "r.fold2", "11") "<Drive name=\"B\" joint=\"r.turn\" type=\"h\" bus=\"b\" node=\"12\" "
                                  "eds=\"joint-drive.eds\"/>\n"));
    EXPECT_WITHIN(0.5, 0.0, plant->joint[0].drive.rotor_inertia_kgm2);
    EXPECT_WITHIN(0.2, 0.0, plant->joint[2].drive.rotor_inertia_kgm2);
    EXPECT_WITHIN(2.0, 0.0, plant->joint[2].drive.upper_rad);
    TEST_ASSERT_TRUE(isinf(plant->joint[0].drive.upper_rad)); // A continuous joint has no range.
    EXPECT_WITHIN(80.0, 0.0, torque_sensor_of(&world.drive_type[1]).range_nm);
    TEST_ASSERT_EQUAL_UINT32(4096U, encoder_of(&world.drive_type[1]).counts_per_turn);
    plant_destroy(plant);
    // The drive of fold2.
    world.drive[0].difference = (world_drive_difference_t){.friction = 0.2, .stiffness = -0.1};
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    EXPECT_WITHIN(0.6, 1e-12, plant->joint[2].drive.coulomb_nm);
    EXPECT_WITHIN(0.6, 1e-12, plant->joint[2].drive.stiction_nm);
    EXPECT_WITHIN(1.2, 1e-12, plant->joint[2].drive.viscous_nms_rad);
    EXPECT_WITHIN(7200.0, 1e-9, plant->joint[2].drive.gear_stiffness_nm_rad);
    EXPECT_WITHIN(100.0, 0.0, plant->joint[2].drive.brake_torque_nm);
    EXPECT_WITHIN(3.0, 0.0, plant->joint[0].drive.coulomb_nm);
    EXPECT_WITHIN(9000.0, 0.0, plant->joint[0].drive.gear_stiffness_nm_rad);
}

/// Joints that move at the start, of a free robot that moves, too: all bodies have the velocities that follow
/// from base and joints, so only forces change the rates in the first steps.
static void joints_move_at_the_start(void)
{
    static const double rate[4] = {0.8, -1.5, 2.0, 0.3};
    static plant_input_t input;
    begin(IN_WORLD("0 0 0", "<Robot name=\"r\" urdf=\"heavy.urdf\" base=\"free\">"
                            "<State velocity=\"0.1 -0.2 0.3\" rate=\"0.05 -0.03 0.02\"/>" START
                            "<StartRate turn=\"0.8\" fold1=\"-1.5\" fold2=\"2\" slide=\"0.3\"/></Robot>\n"));
    const plant_truth_t* truth = plant_truth(plant);
    for (unsigned i = 0U; i < 4U; i++) {
        EXPECT_WITHIN(rate[i], 1e-9, truth->link_velocity_rad_s[i]);
        EXPECT_WITHIN(rate[i], 1e-9, truth->motor[i].velocity_rad_s);
    }
    EXPECT_WITHIN(-0.2, 1e-12, truth->base[0].velocity_m_s[1]);
    EXPECT_WITHIN(-0.03, 1e-12, truth->base[0].rate_rad_s[1]);
    for (unsigned k = 0U; k < 20U; k++) {
        plant_step(plant, &input, STEP_NS);
    }
    for (unsigned i = 0U; i < 4U; i++) {
        EXPECT_WITHIN(wanted[i] + 0.01 * rate[i], 5e-4, truth->link_position_rad[i]);
        EXPECT_WITHIN(rate[i], 0.1, truth->link_velocity_rad_s[i]);
    }
}

// ---- Joints without a drive ----

static void a_joint_without_a_drive_swings_freely_up_to_its_limits(void)
{
    begin(IN_WORLD("0 0 -9.81", "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"/>\n"));
    static plant_input_t idle;
    double most_m = 0.0;
    for (unsigned i = 0U; i < 8000U; i++) {
        plant_step(plant, &idle, STEP_NS);
        most_m = fmax(most_m, fabs(plant_truth(plant)->link_position_rad[3]));
    }
    // The rod slides to the end of its range, and the link that folds hangs on its stop or below it.
    EXPECT_WITHIN(2.0, 5e-3, most_m);
    EXPECT_BELOW(2.0 + 5e-3, fabs(plant_truth(plant)->link_position_rad[1]));
    EXPECT_WITHIN(0.0, 0.0, plant_truth(plant)->friction_nm[1]);
    TEST_ASSERT_FALSE(plant_truth(plant)->brake_engaged[1]);
}

// ---- Free bases ----

static void swing(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    const double time_s = ((double)plant_truth(plant)->time_ns + substep * STEP_NS / 4.0) * 1e-9;
    for (unsigned i = 0U; i < plant_truth(plant)->joint_count; i++) {
        const double aim = wanted[i] + 0.2 * (1.0 - cos((0.7 + 0.2 * i) * time_s));
        out_torque_nm[i] = 5.0 * (aim - motor[i].position_rad) - 2.0 * motor[i].velocity_rad_s;
    }
}

/// Expect that linear and angular momentum are constant for 60 s while the joints of a free robot swing.
static void expect_momentum_conserved(const char* text, double most_angular)
{
    static plant_input_t input;
    double p0[3];
    double l0[3];
    double worst_p = 0.0;
    double worst_l = 0.0;
    begin(text);
    input.drive = swing;
    plant_momentum(plant, p0, l0);
    for (unsigned step = 0U; step < 120000U; step++) {
        double p[3];
        double l[3];
        plant_step(plant, &input, STEP_NS);
        plant_momentum(plant, p, l);
        for (unsigned i = 0U; i < 3U; i++) {
            worst_p = fmax(worst_p, fabs(p[i] - p0[i]));
            worst_l = fmax(worst_l, fabs(l[i] - l0[i]));
        }
    }
    printf("60 s: %.1e Ns, %.1e Nms\n", worst_p, worst_l);
    EXPECT_ABOVE(0.2, fabs(plant_truth(plant)->link_position_rad[0] - wanted[0]));
    EXPECT_BELOW(1e-12, worst_p);
    EXPECT_BELOW(most_angular, worst_l);
}

static void a_free_robot_starts_in_its_state_and_moves_with_it(void)
{
    begin(IN_WORLD("0 0 0",
                   "<Robot name=\"s\" urdf=\"tree.urdf\" base=\"fixed\"/>\n"
                   "<Robot name=\"r\" urdf=\"heavy.urdf\" base=\"free\"><State at=\"1 2 3\" "
                   "rpy=\"0 0 1.5707963267948966\" velocity=\"0.1 0.2 0.3\" rate=\"0 0 0.2\"/></Robot>\n"));
    static plant_input_t idle;
    const plant_truth_t* truth = plant_truth(plant);
    const plant_base_t* base   = &truth->base[0];
    TEST_ASSERT_EQUAL_UINT(1U, truth->base_count);
    EXPECT_WITHIN(2.0, 1e-15, base->position_m[1]);
    EXPECT_WITHIN(sqrt(0.5), 1e-15, base->rotation[0]);
    EXPECT_WITHIN(sqrt(0.5), 1e-15, base->rotation[3]);
    EXPECT_WITHIN(0.2, 1e-15, base->velocity_m_s[1]);
    EXPECT_WITHIN(0.2, 0.0, base->rate_rad_s[2]);
    for (unsigned i = 0U; i < 2000U; i++) {
        plant_step(plant, &idle, STEP_NS);
    }
    EXPECT_WITHIN(3.3, 0.05, base->position_m[2]);
    EXPECT_WITHIN(0.3, 0.02, base->velocity_m_s[2]);
}

static void momentum_of_a_free_tree_is_conserved(void)
{
    expect_momentum_conserved(
        IN_WORLD("0 0 0", "<Robot name=\"r\" urdf=\"heavy.urdf\" base=\"free\">" START "</Robot>\n"), 1e-6);
    expect_momentum_conserved(IN_WORLD("0 0 0", "<Robot name=\"r\" urdf=\"heavy.urdf\" base=\"free\">" START
                                                "</Robot>\n" TYPE DRIVES("r")),
                              1e-6);
}

// ---- Refusals ----

static void expect_refusal(const char* text, const char* at, const char* words)
{
    char location[64];
    const char* path = temporary_file("w.xml", text);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(path, &world, error), error);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, plant_create(&world, &plant, error));
    TEST_ASSERT_NULL(plant);
    (void)snprintf(location, sizeof location, "w.xml:%u: found '", line_of(path, at));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, location), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

static void worlds_that_the_plant_cannot_simulate_are_refused(void)
{
    expect_refusal(
        IN_WORLD("0 0 0",
                 "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"><Start fold2=\"1.5\"/></Robot>\n"),
        "<Robot", "'fold2', expected a Drive, or limits within half a turn");
    expect_refusal(
        IN_WORLD("0 0 0",
                 "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"/>\n<Fixture name=\"f\" at=\"0 0 0\">"
                 "<Sphere radius=\"1\" at=\"0 0 0\"/></Fixture>\n"
                 "<Contact a=\"r.base\" b=\"f\" stiffness=\"1\" damping=\"1\" friction=\"1\"/>\n"),
        "<Contact", "'r.base', expected a link that moves");
    expect_refusal(
        IN_WORLD("0 0 0",
                 "<Robot name=\"r\" urdf=\"tree.urdf\" base=\"fixed\"/>\n"
                 "<Contact a=\"r.lower\" b=\"r.rod\" stiffness=\"1\" damping=\"1\" friction=\"1\"/>\n"),
        "<Contact", "'r.rod', expected a link with a collision shape");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(gears_carry_the_weight_of_a_tree);
    RUN_TEST(poses_of_bodies_follow_from_the_joints);
    RUN_TEST(robots_do_not_share_joints);
    RUN_TEST(each_joint_has_its_own_drive);
    RUN_TEST(joints_move_at_the_start);
    RUN_TEST(a_joint_without_a_drive_swings_freely_up_to_its_limits);
    RUN_TEST(a_free_robot_starts_in_its_state_and_moves_with_it);
    RUN_TEST(momentum_of_a_free_tree_is_conserved);
    RUN_TEST(worlds_that_the_plant_cannot_simulate_are_refused);
    return UNITY_END();
}
