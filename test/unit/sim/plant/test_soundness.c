// SPDX-License-Identifier: Apache-2.0
// A diverging world: the plant stops before ODE ends the program, and reports the link, the time and the
// reason.
#include "sim/plant/plant.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define LINK(name, shape)                                                                                    \
    "<link name=\"" name "\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" "        \
    "iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial>" shape "</link>\n"
#define JOINT(name, type, parent, child)                                                                     \
    "<joint name=\"" name "\" type=\"" type "\"><origin xyz=\"0.3 0 0\"/><parent link=\"" parent             \
    "\"/><child link=\"" child "\"/><axis xyz=\"0 1 0\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" "      \
    "velocity=\"1\"/></joint>\n"
#define ARM                                                                                                  \
    "<robot name=\"arm\">\n" LINK("base", "") LINK("upper", "") LINK("lower", "")                            \
        JOINT("shoulder", "continuous", "base", "upper")                                                     \
            JOINT("elbow", "continuous", "upper", "lower") "</robot>\n"
/// A type of drive. The damping of its gear is integrated explicitly, so it can be too high for the step.
#define TYPE(stiffness, damping)                                                                             \
    "<DriveType name=\"t\" ratio=\"100\" rotorInertia=\"0.2\" stiffness=\"" stiffness                        \
    "\" damping=\"" damping                                                                                  \
    "\" coulomb=\"0\" stiction=\"0\" stribeck=\"0.02\" viscous=\"0\" brake=\"100\" stopStiffness=\"2e4\" "   \
    "stopDamping=\"200\" encoderCounts=\"65536\"><TorqueSensor noise=\"0\" offset=\"0\" drift=\"0\" "        \
    "range=\"90\"/></DriveType>\n"
#define DRIVE                                                                                                \
    "<Drive name=\"D\" joint=\"r.elbow\" type=\"t\" bus=\"b\" node=\"11\" eds=\"joint-drive.eds\"/>\n"
#define IN_WORLD(text) "<World name=\"w\" step=\"500us\" gravity=\"0 0 -9.81\">\n" text "</World>\n"

static world_t world;
static plant_t* plant;
static plant_input_t input;
static char error[DOCUMENT_ERROR_MAX];
static double torque; // Torque of the motor of joint 0.

void setUp(void)
{
    input  = (plant_input_t){0};
    torque = 0.0;
    (void)temporary_file("arm.urdf", ARM);
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
    (void)motor;
    out_torque_nm[0] = torque;
}

static void begin(const char* text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    input.drive = drive;
}

static void run(double seconds)
{
    for (unsigned i = 0U; i < (unsigned)lround(seconds * 2000.0); i++) {
        plant_step(plant, &input, 500000U);
    }
}

static void expect_words(const char* words)
{
    const char* failure = plant_failure(plant);
    TEST_ASSERT_NOT_NULL_MESSAGE(failure, words);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(failure, words), failure);
}

static void a_gear_with_too_much_stiffness_or_damping_is_reported_with_its_link(void)
{
    static const char* const worlds[] = {
        IN_WORLD("<Robot name=\"r\" urdf=\"arm.urdf\" base=\"fixed\"/>\n" TYPE("8000", "1e6") DRIVE),
        IN_WORLD("<Robot name=\"r\" urdf=\"arm.urdf\" base=\"fixed\"/>\n" TYPE("1e9", "1e3") DRIVE),
        IN_WORLD("<Robot name=\"r\" urdf=\"arm.urdf\" base=\"free\"/>\n" TYPE("1e8", "1e8") DRIVE)};
    for (unsigned i = 0U; i < 3U; i++) {
        begin(worlds[i]);
        torque = (i == 2U) ? 1.0 : 0.0;
        run(2.0);
        expect_words("w.xml:2: link r.");
        expect_words("s: the world diverges; check ");
        expect_words("and the step of 500 us");
        const uint64_t time_ns = plant_truth(plant)->time_ns;
        TEST_ASSERT_TRUE(time_ns < 2000000000U);
        run(0.1); // The plant no longer moves.
        TEST_ASSERT_EQUAL_UINT64(time_ns, plant_truth(plant)->time_ns);
        plant_destroy(plant);
        plant = NULL;
    }
}

static void a_torque_that_is_nan_is_reported_with_its_joint(void)
{
    begin(IN_WORLD("<Robot name=\"r\" urdf=\"arm.urdf\" base=\"fixed\"/>\n"));
    run(0.01);
    torque = (double)NAN;
    run(0.001);
    expect_words("link r.upper gets a rate of");
    expect_words("nan");
    expect_words("check its joint shoulder,");
    expect_words("at 0.0100 s");
}

static void a_stable_world_reports_no_failure(void)
{
    begin(IN_WORLD("<Robot name=\"r\" urdf=\"arm.urdf\" base=\"free\"/>\n" TYPE("8000", "8") DRIVE));
    run(2.0); // The robot falls.
    TEST_ASSERT_NULL(plant_failure(plant));
    TEST_ASSERT_EQUAL_UINT64(2000000000U, plant_truth(plant)->time_ns);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_gear_with_too_much_stiffness_or_damping_is_reported_with_its_link);
    RUN_TEST(a_torque_that_is_nan_is_reported_with_its_joint);
    RUN_TEST(a_stable_world_reports_no_failure);
    return UNITY_END();
}
