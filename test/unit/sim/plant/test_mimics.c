// SPDX-License-Identifier: Apache-2.0
// Joints that follow others: positions, forces between leader and mimic, momentum of a free robot, and
// refusals. test_plant_reference.py compares their motion with MuJoCo.
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
#define LINK(name, mass)                                                                                     \
    "<link name=\"" name "\"><inertial><mass value=\"" mass                                                  \
    "\"/><inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" "                                  \
    "izz=\"0.02\"/></inertial></link>\n"
#define SLIDE(name, child, y, axis, more)                                                                    \
    "<joint name=\"" name "\" type=\"prismatic\"><origin xyz=\"0.3 " y                                       \
    " 0\"/><parent link=\"palm\"/><child link=\"" child "\"/><axis xyz=\"" axis                              \
    "\"/><limit lower=\"-0.2\" upper=\"0.2\" effort=\"1\" velocity=\"1\"/>" more "</joint>\n"
/// Two fingers that slide apart: 0.4 kg, and 0.2 kg, which moves half as far plus 0.01 m.
#define HAND                                                                                                 \
    "<robot name=\"hand\">\n" LINK("palm", "20") LINK("left", "0.4") LINK("right", "0.2")                    \
        SLIDE("open", "left", "0.1", "0 1 0", "")                                                            \
            SLIDE("other", "right", "-0.1", "0 -1 0",                                                        \
                  "<mimic joint=\"open\" multiplier=\"0.5\" offset=\"0.01\"/>") "</robot>\n"
/// A crank that carries a rod; the rod's joint is of another type and follows the crank.
#define CRANK                                                                                                \
    "<robot name=\"crank\">\n" LINK("palm", "20") LINK("arm", "2") LINK(                                     \
        "rod",                                                                                               \
        "1") "<joint name=\"turn\" type=\"continuous\"><origin xyz=\"0.2 0.1 0\"/><parent link=\"palm\"/>"   \
             "<child link=\"arm\"/><axis xyz=\"0 1 1\"/></joint>\n"                                          \
             "<joint name=\"stroke\" type=\"prismatic\"><origin xyz=\"0.3 0 0.1\"/><parent link=\"arm\"/>"   \
             "<child link=\"rod\"/><axis xyz=\"1 0 0\"/><limit lower=\"-9\" upper=\"9\" effort=\"1\" "       \
             "velocity=\"1\"/><mimic joint=\"turn\" multiplier=\"0.3\"/></joint>\n</robot>\n"
#define IN_WORLD(gravity, text)                                                                              \
    "<World name=\"w\" step=\"500us\" gravity=\"" gravity "\">\n" text "</World>\n"

static world_t world;
static plant_t* plant;
static const plant_truth_t* truth;
static plant_input_t input;
static char error[DOCUMENT_ERROR_MAX];
static double pull; // Force on joint 0.

void setUp(void)
{
    input = (plant_input_t){0};
    (void)temporary_file("hand.urdf", HAND);
    (void)temporary_file("crank.urdf", CRANK);
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
    out_torque_nm[0] = pull;
}

static void begin(const char* text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, world_read(temporary_file("w.xml", text), &world, error), error);
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, plant_create(&world, &plant, error), error);
    truth       = plant_truth(plant);
    input.drive = drive;
    pull        = 0.0;
}

static void run(double seconds)
{
    for (unsigned i = 0U; i < (unsigned)lround(seconds * 2000.0); i++) {
        plant_step(plant, &input, STEP_NS);
    }
}

static void a_mimic_starts_and_stays_at_the_position_that_follows_from_its_leader(void)
{
    begin(IN_WORLD("0 0 0",
                   "<Robot name=\"h\" urdf=\"hand.urdf\" base=\"fixed\"><Start open=\"-0.1\"/></Robot>\n"));
    EXPECT_WITHIN(-0.04, 1e-15, truth->link_position_rad[1]);
    pull = 0.02;
    run(2.0);
    EXPECT_ABOVE(-0.05, truth->link_position_rad[0]);
    EXPECT_WITHIN(0.5 * truth->link_position_rad[0] + 0.01, 1e-12, truth->link_position_rad[1]);
    EXPECT_WITHIN(0.5 * truth->link_velocity_rad_s[0], 1e-12, truth->link_velocity_rad_s[1]);
    // The mass of the mimic counts with the square of the ratio: 0.4 + 0.25 * 0.2 kg.
    EXPECT_WITHIN(0.02 / 0.45 * 2.0, 1e-4, truth->link_velocity_rad_s[0]);
    EXPECT_WITHIN(0.2 * 0.5 * 0.02 / 0.45, 1e-9, truth->joint_torque_nm[1]);
}

/// Gravity along y pulls both fingers to one side: the leader holds its own weight minus half the weight of
/// the mimic.
static void the_load_of_a_mimic_acts_on_its_leader(void)
{
    begin(IN_WORLD("0 -1 0", "<Robot name=\"h\" urdf=\"hand.urdf\" base=\"fixed\"/>\n"));
    pull = 0.4 - 0.5 * 0.2;
    run(1.0);
    EXPECT_WITHIN(0.0, 1e-9, truth->link_velocity_rad_s[0]);
    EXPECT_WITHIN(-0.2, 1e-9, truth->joint_torque_nm[1]);
}

/// The leader meets its stop: both joints rest, and then come back.
static void a_mimic_rests_with_its_leader_at_a_stop(void)
{
    begin(IN_WORLD("0 0 0", "<Robot name=\"h\" urdf=\"hand.urdf\" base=\"fixed\"/>\n"));
    pull = 1.0;
    run(2.0);
    EXPECT_WITHIN(0.2, 1e-6, truth->link_position_rad[0]);
    EXPECT_WITHIN(0.11, 1e-6, truth->link_position_rad[1]);
    pull = -1.0;
    run(0.2);
    EXPECT_BELOW(0.17, truth->link_position_rad[0]);
    EXPECT_WITHIN(0.5 * truth->link_position_rad[0] + 0.01, 1e-9, truth->link_position_rad[1]);
}

static void expect_momentum_conserved(const char* text, double seconds)
{
    double p0[3];
    double l0[3];
    double worst_p = 0.0;
    double worst_l = 0.0;
    double error_m = 0.0;
    begin(text);
    const mimic_t* mimic = &plant->mimic[0];
    plant_momentum(plant, p0, l0);
    for (unsigned i = 0U; i < (unsigned)lround(seconds * 2000.0); i++) {
        double p[3];
        double l[3];
        pull = 0.3 * sin(3.0 * i / 2000.0);
        plant_step(plant, &input, STEP_NS);
        plant_momentum(plant, p, l);
        for (unsigned k = 0U; k < 3U; k++) {
            worst_p = fmax(worst_p, fabs(p[k] - p0[k]));
            worst_l = fmax(worst_l, fabs(l[k] - l0[k]));
        }
        error_m =
            fmax(error_m, fabs(truth->link_position_rad[mimic->joint] -
                               mimic->multiplier * truth->link_position_rad[mimic->leader] - mimic->offset));
    }
    printf("%.0f s: %.1e Ns, %.1e Nms, joints apart by %.1e\n", seconds, worst_p, worst_l, error_m);
    EXPECT_BELOW(1e-12, worst_p);
    EXPECT_BELOW(1e-5, worst_l);
    EXPECT_BELOW(1e-9, error_m);
}

static void momentum_of_a_free_robot_is_conserved(void)
{
    expect_momentum_conserved(
        IN_WORLD("0 0 0",
                 "<Robot name=\"c\" urdf=\"crank.urdf\" base=\"free\"><State rate=\"0.02 0.01 -0.03\"/>"
                 "</Robot>\n"),
        3.0);
}

static void equal_steps_are_bit_identical(void)
{
    static const char* const text = IN_WORLD(
        "0 0 0", "<Robot name=\"h\" urdf=\"crank.urdf\" base=\"free\"/>\n"
                 "<Robot name=\"i\" urdf=\"hand.urdf\" base=\"free\"><State at=\"3 0 0\"/></Robot>\n");
    begin(text);
    pull = 0.3;
    run(1.0);
    const uint64_t first = plant_hash(plant);
    EXPECT_WITHIN(0.0, 1e-9, truth->link_velocity_rad_s[3] - 0.5 * truth->link_velocity_rad_s[2]);
    plant_destroy(plant);
    begin(text);
    pull = 0.3;
    run(1.0);
    TEST_ASSERT_EQUAL_HEX64(first, plant_hash(plant));
}

static void expect_refusal(const char* text, unsigned line, const char* words)
{
    char location[64];
    const char* path      = temporary_file("w.xml", text);
    const status_t status = world_read(path, &world, error);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID,
                          (status == STATUS_OK) ? plant_create(&world, &plant, error) : status);
    (void)snprintf(location, sizeof location, "w.xml:%u: found '", line);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, location), error);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

static void unsupported_uses_of_mimic_joints_are_refused(void)
{
    expect_refusal(IN_WORLD("0 0 0", "<Robot name=\"h\" urdf=\"hand.urdf\" base=\"fixed\">\n<Start "
                                     "other=\"0.1\"/></Robot>\n"),
                   3U, "'other', expected a joint that is not itself a mimic");
    (void)temporary_file("wide.urdf", "<robot name=\"hand\">\n" LINK("palm", "20") LINK("left", "0.4")
                                          LINK("right", "0.2") SLIDE("open", "left", "0.1", "0 1 0", "")
                                              SLIDE("other", "right", "-0.1", "0 -1 0",
                                                    "<mimic joint=\"open\" multiplier=\"4\"/>") "</robot>\n");
    expect_refusal(IN_WORLD("0 0 0", "<Robot name=\"h\" urdf=\"wide.urdf\" base=\"fixed\">\n<Start "
                                     "open=\"0.1\"/></Robot>\n"),
                   3U, "'other', expected a mimic that starts inside of its limits");
    expect_refusal(
        IN_WORLD(
            "0 0 0",
            "<Robot name=\"h\" urdf=\"hand.urdf\" base=\"fixed\"/>\n"
            "<DriveType name=\"t\" ratio=\"100\" rotorInertia=\"0.2\" stiffness=\"8000\" damping=\"8\" "
            "coulomb=\"0.5\" stiction=\"0.5\" stribeck=\"0.02\" viscous=\"1\" brake=\"100\" "
            "stopStiffness=\"2e4\" stopDamping=\"200\" encoderCounts=\"65536\"><TorqueSensor noise=\"0\" "
            "offset=\"0\" drift=\"0\" range=\"90\"/></DriveType>\n"
            "<Drive name=\"D\" joint=\"h.other\" type=\"t\" bus=\"b\" node=\"11\" eds=\"x.eds\"/>\n"),
        4U, "'h.other', expected a joint that is not itself a mimic");
    char many[4000];
    size_t used = (size_t)snprintf(many, sizeof many,
                                   "<robot name=\"many\">\n" LINK("palm", "20") LINK("l", "1")
                                       SLIDE("lead", "l", "0", "0 1 0", ""));
    for (unsigned i = 0U; i < 9U; i++) {
        used += (size_t)snprintf(
            &many[used], sizeof many - used,
            "<link name=\"l%u\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" "
            "ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
            "<joint name=\"j%u\" type=\"continuous\"><parent link=\"palm\"/><child link=\"l%u\"/>"
            "<mimic joint=\"lead\"/></joint>\n",
            i, i, i);
    }
    (void)snprintf(&many[used], sizeof many - used, "</robot>\n");
    (void)temporary_file("many.urdf", many);
    expect_refusal(IN_WORLD("0 0 0", "<Robot name=\"h\" urdf=\"many.urdf\" base=\"fixed\"/>\n"), 2U,
                   "'j8', expected at most 8 joints of a world that mimic others");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_mimic_starts_and_stays_at_the_position_that_follows_from_its_leader);
    RUN_TEST(the_load_of_a_mimic_acts_on_its_leader);
    RUN_TEST(a_mimic_rests_with_its_leader_at_a_stop);
    RUN_TEST(momentum_of_a_free_robot_is_conserved);
    RUN_TEST(equal_steps_are_bit_identical);
    RUN_TEST(unsupported_uses_of_mimic_joints_are_refused);
    return UNITY_END();
}
