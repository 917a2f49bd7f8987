// SPDX-License-Identifier: Apache-2.0
// Noise, torque sensors and encoders of the world rokviss.
#include "sim/plant/parameters.h"
#include "sim/plant/sensor.h"
#include "test/support/bounds.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "unity.h"

#include <math.h>

#define SAMPLES 200000U

void setUp(void)
{
}

void tearDown(void)
{
}

static void noise_is_nearly_standard_normal(void)
{
    double moment[5] = {0.0};
    unsigned beyond  = 0U;
    for (uint64_t step = 0U; step < SAMPLES; step++) {
        const double x = sensor_noise(1U, 0x111U, step);
        moment[1] += x;
        moment[2] += x * x;
        moment[3] += x * x * x;
        moment[4] += x * x * x * x;
        beyond += (fabs(x) > 1.96) ? 1U : 0U;
        EXPECT_BELOW(6.0 + 1e-9, fabs(x));
    }
    EXPECT_WITHIN(0.0, 0.01, moment[1] / SAMPLES);
    EXPECT_WITHIN(1.0, 0.01, moment[2] / SAMPLES);
    EXPECT_WITHIN(0.0, 0.03, moment[3] / SAMPLES);
    // The noise is a sum of twelve uniform numbers, whose fourth moment is 3 - 1.2 / 12.
    EXPECT_WITHIN(2.9, 0.06, moment[4] / SAMPLES);
    EXPECT_WITHIN(0.05, 0.003, (double)beyond / SAMPLES);
}

static double correlation(uint64_t seed_a, uint32_t device_a, uint64_t seed_b, uint32_t device_b,
                          uint64_t lag)
{
    double sum = 0.0;
    for (uint64_t step = 0U; step < SAMPLES; step++) {
        sum += sensor_noise(seed_a, device_a, step) * sensor_noise(seed_b, device_b, step + lag);
    }
    return sum / SAMPLES;
}

static void noise_depends_on_seed_device_and_step(void)
{
    EXPECT_WITHIN(1.0, 0.02, correlation(1U, 1U, 1U, 1U, 0U));
    EXPECT_WITHIN(0.0, 0.01, correlation(1U, 1U, 1U, 2U, 0U));
    EXPECT_WITHIN(0.0, 0.01, correlation(1U, 1U, 2U, 1U, 0U));
    EXPECT_WITHIN(0.0, 0.01, correlation(1U, 1U, 1U, 1U, 1U));
    EXPECT_WITHIN(0.0, 0.01, correlation(1U, 2U, 2U, 1U, 0U)); // Seed and device are not interchangeable.
    EXPECT_WITHIN(0.0, 0.01, correlation(0U, 0U, 0U, 0U, 1U));
}

static void noise_is_the_same_in_any_order(void)
{
    const double late  = sensor_noise(7U, 3U, 1000000U);
    const double early = sensor_noise(7U, 3U, 0U);
    TEST_ASSERT_TRUE(early == sensor_noise(7U, 3U, 0U));
    TEST_ASSERT_TRUE(late == sensor_noise(7U, 3U, 1000000U));
}

static void uniform_noise_fills_its_interval(void)
{
    double lowest  = 1.0;
    double highest = -1.0;
    double sum     = 0.0;
    for (uint64_t step = 0U; step < SAMPLES; step++) {
        const double x = sensor_uniform(5U, 2U, step);
        lowest         = fmin(lowest, x);
        highest        = fmax(highest, x);
        sum += x;
    }
    EXPECT_WITHIN(-1.0, 1e-3, lowest);
    EXPECT_WITHIN(1.0, 1e-3, highest);
    EXPECT_BELOW(1.0, highest);
    EXPECT_WITHIN(0.0, 0.01, sum / SAMPLES);
}

static void torque_sensor_has_offset_drift_and_noise(void)
{
    double offsets = 0.0;
    for (uint64_t seed = 1U; seed <= 20U; seed++) {
        torque_sensor_t sensor;
        torque_sensor_init(&sensor, &rokviss()->torque_sensor, seed, 0x111U);
        double early = 0.0;
        double late  = 0.0;
        double rms   = 0.0;
        for (uint64_t step = 0U; step < 20000U; step++) {
            const double reading = torque_sensor_read(&sensor, step, 0U, 5.0, 0.0);
            early += (reading - 5.0) / 20000.0;
            late += (torque_sensor_read(&sensor, step, 1000000000000U, 5.0, 0.0) - 5.0) / 20000.0;
            rms += (reading - 5.0 - sensor.offset_nm) * (reading - 5.0 - sensor.offset_nm) / 20000.0;
        }
        EXPECT_WITHIN(0.0, 0.2, early);
        EXPECT_WITHIN(0.02, 5e-4, sqrt(rms));
        EXPECT_BELOW(0.2 + 1e-9, fabs(late - early)); // 1000 s of at most 2e-4 Nm/s
        EXPECT_ABOVE(1e-6, fabs(late - early));
        offsets += fabs(early);
    }
    EXPECT_ABOVE(0.05, offsets / 20.0);
}

static void torque_sensor_saturates(void)
{
    torque_sensor_t sensor;
    torque_sensor_init(&sensor, &rokviss()->torque_sensor, 1U, 1U);
    EXPECT_WITHIN(60.0, 0.0, torque_sensor_read(&sensor, 1U, 0U, 75.0, 0.0));
    EXPECT_WITHIN(-60.0, 0.0, torque_sensor_read(&sensor, 2U, 0U, -1e9, 0.0));
}

static void an_encoder_rounds_down(void)
{
    const double quantum = 2.0 * acos(-1.0) / 65536.0;
    EXPECT_WITHIN(95.87e-6, 1e-8, quantum);
    for (int64_t count = -70000; count <= 70000; count += 1237) {
        TEST_ASSERT_EQUAL_INT64(count,
                                encoder_count(&rokviss()->stick_encoder, ((double)count + 0.01) * quantum));
        TEST_ASSERT_EQUAL_INT64(count,
                                encoder_count(&rokviss()->stick_encoder, ((double)count + 0.99) * quantum));
    }
    TEST_ASSERT_EQUAL_INT64(-1, encoder_count(&rokviss()->stick_encoder, -1e-9));
}

static void an_encoder_on_the_motor_is_finer_by_the_gear_ratio(void)
{
    for (double position = -3.0; position < 3.0; position += 0.0137) {
        const double joint = position - encoder_read(&rokviss()->joint_encoder, position);
        const double stick = position - encoder_read(&rokviss()->stick_encoder, position);
        TEST_ASSERT_TRUE((joint >= -1e-12) && (joint < 0.6e-6));
        TEST_ASSERT_TRUE((stick >= -1e-12) && (stick < 95.9e-6));
    }
}

/// The ripple of a sensor is added to its reading, by the formula, at every position of the motor.
static void the_torque_sensor_has_a_ripple_with_the_motor_angle(void)
{
    world_drive_type_t type                     = {.ratio             = 160.0,
                                                   .has_torque_sensor = true,
                                                   .torque_range      = 60.0,
                                                   .torque_ripple     = 0.4,
                                                   .torque_periods    = 4.0};
    const torque_sensor_parameters_t parameters = torque_sensor_of(&type);
    torque_sensor_t sensor;
    torque_sensor_init(&sensor, &parameters, 1U, 1U);
    for (unsigned i = 0U; i < 200U; i++) {
        const double position = -0.02 + 0.0003 * i;
        EXPECT_WITHIN(5.0 + 0.4 * sin(4.0 * 160.0 * position), 1e-12,
                      torque_sensor_read(&sensor, i, 0U, 5.0, position));
    }
    EXPECT_WITHIN(60.0, 0.0, torque_sensor_read(&sensor, 1U, 0U, 59.9, 3.14159265 / (8.0 * 160.0)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(noise_is_nearly_standard_normal);
    RUN_TEST(noise_depends_on_seed_device_and_step);
    RUN_TEST(noise_is_the_same_in_any_order);
    RUN_TEST(uniform_noise_fills_its_interval);
    RUN_TEST(torque_sensor_has_offset_drift_and_noise);
    RUN_TEST(torque_sensor_saturates);
    RUN_TEST(an_encoder_rounds_down);
    RUN_TEST(an_encoder_on_the_motor_is_finer_by_the_gear_ratio);
    RUN_TEST(the_torque_sensor_has_a_ripple_with_the_motor_angle);
    return UNITY_END();
}
