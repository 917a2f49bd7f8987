// SPDX-License-Identifier: Apache-2.0
// Latches between two free bodies: when they close and open, and that momentum is conserved when they do.
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
#define SECOND 2000U // Steps of a second.
#define MOMENTUM_NS 1e-11
#define MOMENTUM_NMS 1e-4
#define INERTIA(mass, xx, yy, zz)                                                                            \
    "<inertial><origin xyz=\"0.02 -0.01 0.03\"/><mass value=\"" mass "\"/><inertia ixx=\"" xx                \
    "\" ixy=\"0.5\" ixz=\"-1\" iyy=\"" yy "\" iyz=\"0.8\" izz=\"" zz "\"/></inertial>"
#define WELD(child, x)                                                                                       \
    "<link name=\"" child "\"/><joint name=\"weld\" type=\"fixed\"><origin xyz=\"" x                         \
    " 0.1 0\"/><parent link=\"base\"/><child link=\"" child "\"/></joint>"
#define SHAPE(size) "<collision><geometry><box size=\"" size "\"/></geometry></collision>"
#define SMALL(mass, shape)                                                                                   \
    "<inertial><mass value=\"" mass "\"/><inertia ixx=\"1e-4\" ixy=\"0\" ixz=\"0\" iyy=\"1e-4\" iyz=\"0\" "  \
    "izz=\"1e-4\"/></inertial>" shape
#define FINGER(name, child, y, axis, more)                                                                   \
    "<link name=\"" child                                                                                    \
    "\">" SMALL("0.15", SHAPE("0.04 0.01 0.04")) "</link><joint name=\"" name                                \
                                                 "\" type=\"prismatic\"><origin xyz=\"0.8 " y                \
                                                 " 0\"/><parent link=\"base\"/><child link=\"" child         \
                                                 "\"/><axis xyz=\"" axis                                     \
                                                 "\"/><limit lower=\"-0.03\" upper=\"0.03\" effort=\"1\" "   \
                                                 "velocity=\"1\"/>" more "</joint>"
#define LATCH(a, b, more)                                                                                    \
    "<Latch name=\"DOCK\" a=\"" a "\" b=\"" b "\" distance=\"0.02\" angle=\"0.1\" speed=\"0.05\" " more "/>"
#define BETWEEN(a, b) "<Contact a=\"" a "\" b=\"" b "\" stiffness=\"3e4\" damping=\"150\" friction=\"0.3\"/>"
#define WORLD(gripper, state, more)                                                                          \
    "<World name=\"w\" step=\"500us\" gravity=\"0 0 0\">\n<Robot name=\"s\" urdf=\"" gripper                 \
    ".urdf\" base=\"free\"/><Robot name=\"c\" urdf=\"c.urdf\" base=\"free\"><State " state                   \
    "/></Robot>\n" more "</World>\n"
#define TYPE                                                                                                 \
    "<DriveType name=\"t\" ratio=\"100\" rotorInertia=\"0.5\" stiffness=\"1e5\" damping=\"100\" "            \
    "coulomb=\"0.5\" stiction=\"0.5\" stribeck=\"0.001\" viscous=\"2\" brake=\"100\" stopStiffness=\"2e4\" " \
    "stopDamping=\"200\" encoderCounts=\"65536\"><TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" "        \
    "range=\"90\"/></DriveType>"
#define GRIPPER                                                                                              \
    TYPE "<Gripper name=\"G\" joint=\"s.close\" type=\"t\" bus=\"b\" node=\"11\" eds=\"e\" force=\"20\"/>"
#define BOX "<ValveBox name=\"V\" bus=\"b\" node=\"12\" eds=\"e\"/>"
/// The bar of the target in front of the port: 8 mm and 3 degrees off, tumbling and drifting.
#define DRIFTING                                                                                             \
    "at=\"1.408 0.1 0\" rpy=\"0.05 0 0\" velocity=\"0.003 -0.005 0.002\" rate=\"0.05 0.03 -0.02\""

static world_t world;
static plant_t* plant;
static const plant_truth_t* truth;
static plant_input_t input;
static char error[DOCUMENT_ERROR_MAX];
static double wanted_m;
static double before_ns[3];
static double before_nms[3];
static double worst_ns;
static double worst_nms;

void setUp(void)
{
    input    = (plant_input_t){0};
    worst_ns = worst_nms = 0.0;
    (void)temporary_file("s.urdf", "<robot name=\"s\"><link name=\"base\">" INERTIA(
                                       "350", "75", "88", "82") "</link>" WELD("port", "0.8") "</robot>");
    (void)temporary_file("hand.urdf",
                         "<robot name=\"s\"><link name=\"base\">" INERTIA(
                             "350", "75", "88", "82") "</link>" FINGER("close", "left", "0.135", "0 -1 0", "")
                             FINGER("follow", "right", "0.065", "0 1 0", "<mimic joint=\"close\"/>")
                                 WELD("port", "0.8") "</robot>");
    (void)temporary_file(
        "c.urdf",
        "<robot name=\"c\"><link name=\"base\">" INERTIA("224", "32", "38", "45") SHAPE(
            "0.02 0.02 0.12") "</link>"
                              "<link name=\"bar\">" SHAPE(
                                  "0.12 0.02 0.02") "</link>"
                                                    "<joint name=\"weld\" type=\"fixed\"><origin xyz=\"-0.6 "
                                                    "0 0\"/><parent "
                                                    "link=\"base\"/><child link=\"bar\"/></joint></robot>");
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
    temporary_files_remove();
}

static void drive(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    (void)substep;
    const double asked = 4000.0 * (wanted_m - motor[0].position_rad) - 60.0 * motor[0].velocity_rad_s;
    out_torque_nm[0]   = fmax(-world.drive[0].force, fmin(world.drive[0].force, asked));
}

static void begin(const char* text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    truth = plant_truth(plant);
    if (world.drive_count > 0U) {
        input.drive = drive;
    }
    wanted_m = 0.0;
    plant_momentum(plant, before_ns, before_nms);
}

static void run(const unsigned steps)
{
    for (unsigned i = 0U; i < steps; i++) {
        double p[3];
        double l[3];
        plant_step(plant, &input, STEP_NS);
        plant_momentum(plant, p, l);
        for (unsigned k = 0U; k < 3U; k++) {
            worst_ns  = fmax(worst_ns, fabs(p[k] - before_ns[k]));
            worst_nms = fmax(worst_nms, fabs(l[k] - before_nms[k]));
        }
    }
}

static void expect_momentum_conserved(const char* name)
{
    printf("%s: %.1e Ns, %.1e Nms\n", name, worst_ns, worst_nms);
    EXPECT_BELOW(MOMENTUM_NS, worst_ns);
    EXPECT_BELOW(MOMENTUM_NMS, worst_nms);
}

/// The frame of the bar relative to the port: position, then the rows of its attitude.
static void pose_of_bar(double out[12])
{
    plant_base_t port;
    plant_base_t bar;
    dMatrix3 port_axes;
    dMatrix3 bar_axes;
    dMatrix3 turn;
    plant_frame(plant, 0U, (unsigned)robot_model_frame(&world.robot[0].model, "port"), &port);
    plant_frame(plant, 1U, (unsigned)robot_model_frame(&world.robot[1].model, "bar"), &bar);
    dRfromQ(port_axes, port.rotation);
    dRfromQ(bar_axes, bar.rotation);
    dMultiply1_333(turn, port_axes, bar_axes);
    for (unsigned i = 0U; i < 3U; i++) {
        out[i] = 0.0;
        for (unsigned k = 0U; k < 3U; k++) {
            out[i] += port_axes[(4U * k) + i] * (bar.position_m[k] - port.position_m[k]);
            out[3U + (3U * i) + k] = turn[(4U * i) + k];
        }
    }
}

static void expect_same_pose(const double wanted[12])
{
    double found[12];
    pose_of_bar(found);
    for (unsigned i = 0U; i < 12U; i++) {
        EXPECT_WITHIN(wanted[i], 1e-6, found[i]);
    }
}

static double rate_between(void)
{
    double sum = 0.0;
    for (unsigned k = 0U; k < 3U; k++) {
        sum += pow(truth->base[0].rate_rad_s[k] - truth->base[1].rate_rad_s[k], 2.0);
    }
    return sqrt(sum);
}

/// The latch closes in the first step at the present pose, 8 mm and 3 degrees from the frame of the port; the
/// bodies then move as one.
static void a_latch_joins_two_bodies_at_their_present_pose(void)
{
    double pose[12];
    begin(WORLD("s", DRIFTING, LATCH("s.port", "c.bar", "")));
    pose_of_bar(pose);
    EXPECT_WITHIN(0.008, 1e-9, pose[0]);
    TEST_ASSERT_FALSE(truth->is_latched[0]);
    EXPECT_ABOVE(0.06, rate_between());
    run(1U);
    TEST_ASSERT_TRUE(truth->is_latched[0]);
    EXPECT_BELOW(1e-6, rate_between());
    run(20U * SECOND);
    expect_same_pose(pose);
    EXPECT_BELOW(1e-6, rate_between());
    expect_momentum_conserved("closed for 20 s");
}

/// Each of the three bounds keeps the latch open; it closes when the bodies are within all of them.
static void a_latch_closes_only_within_distance_angle_and_speed(void)
{
    static const char* const outside[] = {
        WORLD("s", "at=\"1.421 0.1 0\" rpy=\"0.05 0 0\"", LATCH("s.port", "c.bar", "")),
        WORLD("s", "at=\"1.408 0.1 0\" rpy=\"0.101 0 0\"", LATCH("s.port", "c.bar", "")),
        WORLD("s", "at=\"1.408 0.1 0\" velocity=\"0 0.051 0\"", LATCH("s.port", "c.bar", ""))};
    static const char* const inside[] = {
        WORLD("s", "at=\"1.419 0.1 0\"", LATCH("s.port", "c.bar", "")),
        WORLD("s", "at=\"1.408 0.1 0\" rpy=\"0.099 0 0\"", LATCH("s.port", "c.bar", "")),
        WORLD("s", "at=\"1.408 0.1 0\" velocity=\"0 0.049 0\"", LATCH("s.port", "c.bar", ""))};
    for (unsigned i = 0U; i < 6U; i++) {
        begin((i < 3U) ? outside[i] : inside[i - 3U]);
        run(2U);
        TEST_ASSERT_EQUAL_INT(i >= 3U, truth->is_latched[0]);
        plant_destroy(plant);
    }
    begin(WORLD("s", "at=\"1.43 0.1 0\" velocity=\"-0.02 0 0\"", LATCH("s.port", "c.bar", "")));
    run(SECOND * 49U / 100U);
    TEST_ASSERT_FALSE(truth->is_latched[0]);
    run(SECOND * 2U / 100U);
    TEST_ASSERT_TRUE(truth->is_latched[0]);
}

/// When its output is off, the latch opens: the bodies continue with the motion that they have. Then it
/// closes again.
static void an_output_closes_and_opens_a_latch(void)
{
    double pose[12];
    begin(WORLD("s", DRIFTING, BOX LATCH("s.port", "c.bar", "when=\"V\" output=\"5\"")));
    run(10U);
    TEST_ASSERT_FALSE(truth->is_latched[0]);
    input.latch_on[0] = true;
    run(2U * SECOND);
    TEST_ASSERT_TRUE(truth->is_latched[0]);
    input.latch_on[0]   = false;
    const double before = truth->base[1].rate_rad_s[0];
    run(1U);
    TEST_ASSERT_FALSE(truth->is_latched[0]);
    EXPECT_WITHIN(before, 1e-5, truth->base[1].rate_rad_s[0]);
    run(SECOND);
    pose_of_bar(pose);
    EXPECT_ABOVE(1e-5, fabs(pose[0] - 0.008) + fabs(pose[1]) + fabs(pose[2])); // The bodies are free again.
    input.latch_on[0] = true;
    run(1U);
    TEST_ASSERT_TRUE(truth->is_latched[0]);
    run(SECOND);
    expect_momentum_conserved("closed, opened, closed");
}

/// The gripper presses on the bar and holds it by friction; then the latch closes. Opening the gripper opens
/// the latch. The contacts of the fingers act all the time.
static void a_gripper_that_presses_closes_a_latch(void)
{
    double pose[12];
    begin(WORLD("hand", "at=\"1.4 0.1 0.001\" rate=\"0.01 0.02 -0.01\"",
                BETWEEN("s.left", "c.bar") BETWEEN("s.right", "c.bar") GRIPPER LATCH(
                    "s.port", "c.bar", "when=\"G\" force=\"15\" stall=\"300ms\" release=\"0.004\"")));
    for (unsigned i = 0U; i < 500U; i++) {
        wanted_m = 0.02 * (i + 1U) / 500.0;
        run(2U);
    }
    TEST_ASSERT_FALSE(truth->is_latched[0]);
    wanted_m         = 0.03;
    unsigned pressed = 0U;
    while (!truth->is_latched[0] && (pressed <= 2U * SECOND)) {
        run(1U);
        pressed = (fabs(truth->joint_torque_nm[0]) >= 15.0) ? (pressed + 1U) : 0U;
    }
    printf("closed after %.4f s of pressing\n", pressed / 2000.0);
    TEST_ASSERT_TRUE(truth->is_latched[0]);
    TEST_ASSERT_UINT_WITHIN(1U, 600U, pressed);
    pose_of_bar(pose);
    run(2U * SECOND);
    expect_same_pose(pose);
    TEST_ASSERT_TRUE(truth->contact[0].is_touching && truth->contact[1].is_touching);
    EXPECT_WITHIN(19.5, 0.6, fabs(truth->contact[0].force_n[1]) + fabs(truth->contact[1].force_n[1]));
    wanted_m = -0.02;
    run(SECOND);
    TEST_ASSERT_FALSE(truth->is_latched[0]);
    TEST_ASSERT_FALSE(truth->contact[0].is_touching || truth->contact[1].is_touching);
    expect_momentum_conserved("gripped, closed, opened");
}

/// The bar overlaps a plate of the servicer by 5 mm: the contact pushes it out, but not while the latch is
/// closed.
static void the_contact_of_latched_bodies_does_not_act(void)
{
    double pose[12];
    (void)temporary_file("s.urdf", "<robot name=\"s\"><link name=\"base\">" INERTIA("350", "75", "88", "82")
                                       SHAPE("1.49 1 1") "</link>" WELD("port", "0.8") "</robot>");
    begin(WORLD("s", "at=\"1.4 0.1 0\"",
                BETWEEN("s.base", "c.bar") BOX LATCH("s.port", "c.bar", "when=\"V\" output=\"1\"")));
    input.latch_on[0] = true;
    pose_of_bar(pose);
    run(SECOND);
    TEST_ASSERT_FALSE(truth->contact[0].is_touching);
    expect_same_pose(pose);
    input.latch_on[0] = false;
    run(1U);
    TEST_ASSERT_TRUE(truth->contact[0].is_touching);
    EXPECT_ABOVE(100.0, fabs(truth->contact[0].force_n[0])); // 5 mm at 3e4 N/m.
    run(SECOND);
    TEST_ASSERT_FALSE(truth->contact[0].is_touching);
    expect_momentum_conserved("pushed out");
}

/// A fixed arm holds a free body; the joint of the arm carries the body.
static void a_body_is_latched_to_the_world(void)
{
    begin("<World name=\"w\" step=\"500us\" gravity=\"0 0 -1\">\n<Robot name=\"s\" urdf=\"s.urdf\" "
          "base=\"fixed\"/><Robot name=\"c\" urdf=\"c.urdf\" base=\"free\"><State at=\"1.4 0.1 "
          "0\"/></Robot>" LATCH("s.port", "c.bar", "") "</World>\n");
    run(SECOND);
    TEST_ASSERT_TRUE(truth->is_latched[0]);
    EXPECT_WITHIN(0.0, 1e-5, truth->base[0].position_m[2]);
    EXPECT_WITHIN(0.0, 1e-9, truth->base[0].velocity_m_s[2]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_latch_joins_two_bodies_at_their_present_pose);
    RUN_TEST(a_latch_closes_only_within_distance_angle_and_speed);
    RUN_TEST(an_output_closes_and_opens_a_latch);
    RUN_TEST(a_gripper_that_presses_closes_a_latch);
    RUN_TEST(the_contact_of_latched_bodies_does_not_act);
    RUN_TEST(a_body_is_latched_to_the_world);
    return UNITY_END();
}
