// SPDX-License-Identifier: Apache-2.0
// Sensors of a world: which part of the truth they measure, and the noise, bias and losses that the seed
// determines.
#include "sim/app/sensors.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/temporary_file.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define COUNT 4000U
#define LINK                                                                                                 \
    "<robot name=\"b\"><link name=\"base\"><inertial><mass value=\"10\"/><inertia ixx=\"1\" ixy=\"0\" "      \
    "ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><link name=\"unit\"/><joint name=\"mount\" " \
    "type=\"fixed\"><origin xyz=\"1 0 0\" rpy=\"0 0 1.5707963267948966\"/><parent link=\"base\"/>"           \
    "<child link=\"unit\"/></joint></robot>"
#define WORLD(sensor)                                                                                        \
    "<World name=\"w\" step=\"500us\" gravity=\"0 0 0\">\n"                                                  \
    "<Robot name=\"s\" urdf=\"b.urdf\" base=\"free\"><State at=\"1 2 3\" rpy=\"0 0 1.5707963267948966\" "    \
    "rate=\"0.1 0.2 0.3\"/></Robot>\n"                                                                       \
    "<Robot name=\"t\" urdf=\"b.urdf\" base=\"fixed\"><State at=\"1 5 3\" rpy=\"3 0 0\"/></Robot>\n" sensor  \
    "</World>\n"
#define SENSOR(kind, on, more)                                                                               \
    "<" kind " name=\"S\" on=\"" on "\" bus=\"b\" node=\"7\" eds=\"e\" " more "/>\n"

static world_t world;
static plant_t* plant;
static sensor_t sensor;
static char error[DOCUMENT_ERROR_MAX];

void setUp(void)
{
    (void)temporary_file("b.urdf", LINK);
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
    sensor = (sensor_t){.plant = plant, .element = &world.sensor[0], .seed = 1U, .device = 7U};
}

static void expect_values(const double wanted[], unsigned count, uint64_t number)
{
    double found[SENSOR_VALUES_MAX];
    TEST_ASSERT_EQUAL_UINT(count, sensor_values(world.sensor[0].kind));
    TEST_ASSERT_TRUE(sensor_measure(&sensor, number, found));
    for (unsigned i = 0U; i < count; i++) {
        EXPECT_WITHIN(wanted[i], 1e-12, found[i]);
    }
}

static void a_gyro_measures_in_the_axes_of_its_link(void)
{
    begin(WORLD(SENSOR("Gyro", "s.base", "noise=\"0\" bias=\"0\"")));
    expect_values((const double[]){0.2, -0.1, 0.3}, 3U, 1U);
    begin(WORLD(SENSOR("Gyro", "s.unit", "noise=\"0\" bias=\"0\"")));
    expect_values((const double[]){-0.1, -0.2, 0.3}, 3U, 1U);
    begin(WORLD(SENSOR("Gyro", "t.unit", "noise=\"0\" bias=\"0\"")));
    expect_values((const double[]){0.0, 0.0, 0.0}, 3U, 1U);
}

static void the_seed_determines_noise_and_bias(void)
{
    double bias[2][3];
    double sum[3]    = {0.0};
    double square[3] = {0.0};
    begin(WORLD(SENSOR("Gyro", "t.base", "noise=\"1e-3\" bias=\"5e-3\"")));
    for (uint64_t number = 0U; number < COUNT; number++) {
        double found[3];
        double again[3];
        TEST_ASSERT_TRUE(sensor_measure(&sensor, number, found));
        TEST_ASSERT_TRUE(sensor_measure(&sensor, number, again));
        TEST_ASSERT_EQUAL_MEMORY(found, again, sizeof found);
        for (unsigned i = 0U; i < 3U; i++) {
            sum[i] += found[i] / COUNT;
            square[i] += found[i] * found[i] / COUNT;
        }
    }
    for (unsigned i = 0U; i < 3U; i++) {
        EXPECT_WITHIN(1e-3, 5e-5, sqrt(square[i] - sum[i] * sum[i]));
        TEST_ASSERT_TRUE(fabs(sum[i]) < 5.1e-3);
        EXPECT_ABOVE(1e-4, fabs(sum[i] - sum[(i + 1U) % 3U])); // Each axis has another bias.
        bias[0][i] = sum[i];
    }
    sensor.seed = 2U;
    TEST_ASSERT_TRUE(sensor_measure(&sensor, 1U, bias[1]));
    EXPECT_ABOVE(1e-4, fabs(bias[0][0] - bias[1][0]));
}

static void a_tracker_measures_the_attitude(void)
{
    begin(WORLD(SENSOR("StarTracker", "s.base", "rate=\"5\" noise=\"0 0 0\"")));
    expect_values((const double[]){sqrt(0.5), 0.0, 0.0, sqrt(0.5)}, 4U, 1U);
    begin(WORLD(SENSOR("StarTracker", "s.unit", "rate=\"5\" noise=\"0 0 0\"")));
    expect_values((const double[]){0.0, 0.0, 0.0, 1.0}, 4U, 1U);
    begin(WORLD(SENSOR("StarTracker", "t.base", "rate=\"5\" noise=\"0 0 0\"")));
    expect_values((const double[]){cos(1.5), sin(1.5), 0.0, 0.0}, 4U, 1U);
}

static void a_tracker_has_noise_about_each_axis(void)
{
    double square[3] = {0.0};
    begin(WORLD(SENSOR("StarTracker", "t.base", "rate=\"5\" noise=\"1e-4 2e-4 3e-4\"")));
    for (uint64_t number = 0U; number < COUNT; number++) {
        double q[4];
        TEST_ASSERT_TRUE(sensor_measure(&sensor, number, q));
        EXPECT_WITHIN(1.0, 1e-12, q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        const double c        = cos(1.5);
        const double s        = sin(1.5);
        const double turned[] = {c * q[1] - s * q[0], c * q[2] + s * q[3], c * q[3] - s * q[2]};
        for (unsigned i = 0U; i < 3U; i++) {
            square[i] += 4.0 * turned[i] * turned[i] / COUNT;
        }
    }
    for (unsigned i = 0U; i < 3U; i++) {
        EXPECT_WITHIN(1e-4 * (i + 1.0), 1e-5, sqrt(square[i]));
    }
}

#define CAMERA(mount, sees, noise, loss)                                                                     \
    SENSOR("PoseCamera", "s.base",                                                                           \
           mount " sees=\"" sees "\" rate=\"20\" delay=\"80ms\" noise=\"" noise "\" angleNoise=\"" noise     \
                 "\" loss=\"" loss "\"")

static void a_camera_measures_a_pose_in_its_own_axes(void)
{
    // In the axes of the satellite, the target is 3 m along x, which is the y of the world.
    begin(WORLD(CAMERA("", "t.base", "0 0 0", "0")));
    const double half = sqrt(0.5); // Relative attitude: -90 deg about z, then 3 rad about x of the world.
    expect_values((const double[]){3.0, 0.0, 0.0, half * sin(1.5), half * sin(1.5) * -1.0, -half * cos(1.5)},
                  6U, 1U);
    begin(WORLD(CAMERA("at=\"0.5 0 0.25\"", "t.base", "0 0 0", "0")));
    expect_values(
        (const double[]){2.5, 0.0, -0.25, half * sin(1.5), half * sin(1.5) * -1.0, -half * cos(1.5)}, 6U, 1U);
    begin(WORLD(CAMERA("rpy=\"0 0 1.5707963267948966\"", "s.base", "0 0 0", "0")));
    expect_values((const double[]){0.0, 0.0, 0.0, 0.0, 0.0, -half}, 6U, 1U);
    begin(WORLD(CAMERA("rpy=\"3.1415926535897931 0 0\"", "s.base", "0 0 0", "0")));
    double found[6];
    TEST_ASSERT_TRUE(sensor_measure(&sensor, 1U, found));
    EXPECT_WITHIN(1.0, 1e-12, fabs(found[3]));
    begin(WORLD(CAMERA("rpy=\"0 3.1415926535897931 0\"", "s.base", "0 0 0", "0")));
    TEST_ASSERT_TRUE(sensor_measure(&sensor, 1U, found));
    EXPECT_WITHIN(1.0, 1e-12, fabs(found[4]));
    begin(WORLD(CAMERA("rpy=\"0 0 3.1415926535897931\"", "s.base", "0 0 0", "0")));
    TEST_ASSERT_TRUE(sensor_measure(&sensor, 1U, found));
    EXPECT_WITHIN(1.0, 1e-12, fabs(found[5]));
}

static void a_camera_loses_poses_and_has_noise(void)
{
    unsigned lost = 0U;
    double square = 0.0;
    begin(WORLD(CAMERA("", "t.base", "1e-3 1e-3 1e-3", "0.2")));
    for (uint64_t number = 0U; number < COUNT; number++) {
        double found[6];
        if (sensor_measure(&sensor, number, found)) {
            square += (found[0] - 3.0) * (found[0] - 3.0);
        } else {
            lost++;
        }
    }
    EXPECT_WITHIN(0.2, 0.03, (double)lost / COUNT);
    EXPECT_WITHIN(1e-3, 1e-4, sqrt(square / (COUNT - lost)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_gyro_measures_in_the_axes_of_its_link);
    RUN_TEST(the_seed_determines_noise_and_bias);
    RUN_TEST(a_tracker_measures_the_attitude);
    RUN_TEST(a_tracker_has_noise_about_each_axis);
    RUN_TEST(a_camera_measures_a_pose_in_its_own_axes);
    RUN_TEST(a_camera_loses_poses_and_has_noise);
    return UNITY_END();
}
