// SPDX-License-Identifier: Apache-2.0
// A gripper of two fingers on a free satellite grasps a free bar by friction, carries it, and lets it go.
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
#define FORCE 20.0
#define FRICTION 0.4
#define LINK(name, mass, inertia, shape)                                                                     \
    "<link name=\"" name "\"><inertial><mass value=\"" mass "\"/><inertia ixx=\"" inertia                    \
    "\" ixy=\"0\" ixz=\"0\" iyy=\"" inertia "\" iyz=\"0\" izz=\"" inertia "\"/></inertial>" shape            \
    "</link>\n"
#define SHAPE(size) "<collision><geometry><box size=\"" size "\"/></geometry></collision>"
#define FINGER(name, child, y, axis, more)                                                                   \
    "<joint name=\"" name "\" type=\"prismatic\"><origin xyz=\"0.3 " y                                       \
    " 0\"/><parent link=\"base\"/><child link=\"" child "\"/><axis xyz=\"" axis                              \
    "\"/><limit lower=\"-0.03\" upper=\"0.03\" effort=\"1\" velocity=\"1\"/>" more "</joint>\n"
#define CONTACT_WITH_BAR(finger)                                                                             \
    "<Contact a=\"s." finger "\" b=\"c.bar\" stiffness=\"3e4\" damping=\"150\" friction=\"0.4\"/>\n"
#define TYPE                                                                                                 \
    "<DriveType name=\"t\" ratio=\"100\" rotorInertia=\"0.5\" stiffness=\"1e5\" damping=\"100\" "            \
    "coulomb=\"0.5\" stiction=\"0.5\" stribeck=\"0.001\" viscous=\"2\" brake=\"100\" stopStiffness=\"2e4\" " \
    "stopDamping=\"200\" encoderCounts=\"65536\"><TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" "        \
    "range=\"90\"/></DriveType>\n"
#define GRIPPER(joint)                                                                                       \
    "<Gripper name=\"G\" joint=\"" joint                                                                     \
    "\" type=\"t\" bus=\"b\" node=\"11\" eds=\"joint-drive.eds\" force=\"20\"/>\n"
#define IN_WORLD(text) "<World name=\"w\" step=\"500us\" gravity=\"0 0 0\">\n" text "</World>\n"
#define SCENE                                                                                                \
    "<Robot name=\"s\" urdf=\"s.urdf\" base=\"free\"/>\n<Robot name=\"c\" urdf=\"c.urdf\" base=\"free\">"    \
    "<State at=\"0.3 0.002 0\"/></Robot>\n" CONTACT_WITH_BAR("left") CONTACT_WITH_BAR("right")               \
        TYPE GRIPPER("s.close")

static world_t world;
static plant_t* plant;
static const plant_truth_t* truth;
static plant_input_t input;
static char error[DOCUMENT_ERROR_MAX];
static double wanted_m;

void setUp(void)
{
    input = (plant_input_t){0};
    (void)temporary_file("s.urdf", "<robot name=\"s\">\n" LINK("base", "100", "10", "")
                                       LINK("left", "0.15", "1e-4", SHAPE("0.04 0.01 0.04"))
                                           LINK("right", "0.15", "1e-4", SHAPE("0.04 0.01 0.04"))
                                               FINGER("close", "left", "0.035", "0 -1 0", "")
                                                   FINGER("follow", "right", "-0.035", "0 1 0",
                                                          "<mimic joint=\"close\"/>") "</robot>\n");
    (void)temporary_file(
        "c.urdf", "<robot name=\"c\">\n" LINK("bar", "2", "0.01", SHAPE("0.12 0.02 0.02")) "</robot>\n");
}

void tearDown(void)
{
    plant_destroy(plant);
    plant = NULL;
    temporary_files_remove();
}

/// The position loop of the motor; its force is limited to the value of the world.
static void drive(void* context, unsigned substep, const plant_rotor_t* motor, double* out_torque_nm)
{
    (void)context;
    (void)substep;
    const double asked = 4000.0 * (wanted_m - motor[0].position_rad) - 60.0 * motor[0].velocity_rad_s;
    out_torque_nm[0]   = fmax(-world.drive[0].force, fmin(world.drive[0].force, asked));
}

static void run(double seconds)
{
    for (unsigned i = 0U; i < (unsigned)lround(seconds * 2000.0); i++) {
        plant_step(plant, &input, STEP_NS);
    }
}

static void begin(const char* text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    truth       = plant_truth(plant);
    input.drive = drive;
    wanted_m    = 0.0;
}

/// Returns the position of the bar relative to the satellite along one axis of the world; the satellite
/// hardly turns, so its axes are nearly the same.
static double offset_m(unsigned axis)
{
    return truth->base[1].position_m[axis] - truth->base[0].position_m[axis];
}

static double grip_n(unsigned finger)
{
    return fabs(truth->contact[finger].force_n[1]);
}

static void grasp(void)
{
    for (unsigned i = 0U; i < 500U; i++) { // 40 mm/s
        wanted_m = 0.02 * (i + 1U) / 500.0;
        run(0.001);
    }
    wanted_m = 0.03; // The bar between the fingers prevents them from reaching this position.
    run(0.5);
}

static void the_stated_force_holds_the_bar(void)
{
    begin(IN_WORLD(SCENE));
    TEST_ASSERT_EQUAL_STRING("s.close", world.drive[0].joint_name);
    EXPECT_WITHIN(FORCE, 0.0, world.drive[0].force);
    grasp();
    printf("grip %.2f and %.2f N, sensor %.2f N\n", grip_n(0U), grip_n(1U), truth->joint_torque_nm[0]);
    TEST_ASSERT_TRUE(truth->contact[0].is_touching && truth->contact[1].is_touching);
    // The fingers share the motor force minus the dry friction of the drive equally; the sensor measures the
    // sum.
    EXPECT_WITHIN(FORCE, 0.0, truth->motor_torque_nm[0]);
    EXPECT_WITHIN(grip_n(0U) + grip_n(1U), 0.02, truth->joint_torque_nm[0]);
    EXPECT_WITHIN(FORCE, 0.6, truth->joint_torque_nm[0]); // The friction is 0.5 N.
    EXPECT_WITHIN(grip_n(0U), 0.05, grip_n(1U));
    EXPECT_WITHIN(0.0, 1e-4, offset_m(1U)); // The fingers move synchronously and centre the bar.
    EXPECT_WITHIN(truth->link_position_rad[0], 1e-6, truth->link_position_rad[1]);
}

/// A thruster of 180 N pushes the satellite of 100 kg, which holds the bar of 2 kg between two fingers of
/// 0.15 kg; friction must transmit 3.5 N.
static void a_grasped_bar_stays_under_acceleration(void)
{
    begin(IN_WORLD(SCENE "<ValveBox name=\"V\" bus=\"b\" node=\"12\" eds=\"valve-box.eds\"><Valve name=\"A\" "
                         "on=\"s.base\" at=\"0 0 0\" direction=\"1 0 0\" force=\"180\" output=\"1\"/>"
                         "</ValveBox>\n"));
    grasp();
    const double before[3] = {offset_m(0U), offset_m(1U), offset_m(2U)};
    input.valve_open[0]    = true;
    run(0.5);
    printf("slipped %.3f mm, friction %.2f N of %.2f N\n", 1e3 * (offset_m(0U) - before[0]),
           truth->contact[0].force_n[0] + truth->contact[1].force_n[0], FRICTION * (grip_n(0U) + grip_n(1U)));
    EXPECT_ABOVE(0.8, truth->base[0].velocity_m_s[0]);
    for (unsigned k = 0U; k < 3U; k++) {
        EXPECT_WITHIN(before[k], 1e-3, offset_m(k));
    }
    EXPECT_WITHIN(-2.0 * 180.0 / 102.3, 0.1, truth->contact[0].force_n[0] + truth->contact[1].force_n[0]);
    // An open gripper leaves the bar behind.
    wanted_m = -0.02;
    run(0.5);
    TEST_ASSERT_FALSE(truth->contact[0].is_touching || truth->contact[1].is_touching);
    EXPECT_BELOW(before[0] - 0.1, offset_m(0U));
}

/// No external force acts: linear and angular momentum are constant while the fingers close, hold, turn with
/// the satellite and open.
static void momentum_is_conserved_while_a_bar_is_grasped_and_released(void)
{
    double p0[3];
    double l0[3];
    double worst_p = 0.0;
    double worst_l = 0.0;
    begin(IN_WORLD(SCENE));
    dBodySetLinearVel(plant->robot[1].body[0], 0.003, -0.002, 0.004); // The bar drifts and turns.
    dBodySetAngularVel(plant->robot[1].body[0], 0.02, 0.05, -0.03);
    plant_momentum(plant, p0, l0);
    for (unsigned i = 0U; i < 600U; i++) {
        double p[3];
        double l[3];
        wanted_m = (i < 400U) ? fmin(0.03, 0.0001 * i) : -0.02;
        run(0.005);
        plant_momentum(plant, p, l);
        for (unsigned k = 0U; k < 3U; k++) {
            worst_p = fmax(worst_p, fabs(p[k] - p0[k]));
            worst_l = fmax(worst_l, fabs(l[k] - l0[k]));
        }
    }
    printf("3 s: %.1e Ns, %.1e Nms\n", worst_p, worst_l);
    TEST_ASSERT_FALSE(truth->contact[0].is_touching || truth->contact[1].is_touching);
    EXPECT_BELOW(1e-12, worst_p);
    EXPECT_BELOW(1e-5, worst_l);
}

static void a_gripper_without_fingers_that_follow_is_refused(void)
{
    static const char* const worlds[] = {
        IN_WORLD("<Robot name=\"s\" urdf=\"s.urdf\" base=\"free\"/>\n" TYPE GRIPPER("s.follow")),
        IN_WORLD("<Robot name=\"c\" urdf=\"arm.urdf\" base=\"fixed\"/>\n" TYPE GRIPPER("c.close"))};
    static const char* const words[] = {"'s.follow', expected a joint that is not itself a mimic",
                                        "'c.close', expected the joint of a finger that other fingers mimic"};
    (void)temporary_file("arm.urdf",
                         "<robot name=\"c\">\n" LINK("base", "2", "0.01", "") LINK("left", "1", "0.01", "")
                             FINGER("close", "left", "0", "0 1 0", "") "</robot>\n");
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_INT(STATUS_INVALID, world_read(temporary_file("w.xml", worlds[i]), &world, error));
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, "w.xml:4: found"), error);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words[i]), error);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_stated_force_holds_the_bar);
    RUN_TEST(a_grasped_bar_stays_under_acceleration);
    RUN_TEST(momentum_is_conserved_while_a_bar_is_grasped_and_released);
    RUN_TEST(a_gripper_without_fingers_that_follow_is_refused);
    return UNITY_END();
}
