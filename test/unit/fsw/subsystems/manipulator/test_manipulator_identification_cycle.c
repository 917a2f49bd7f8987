// SPDX-License-Identifier: Apache-2.0
// Masses and offsets of the sensors in the running subsystem: tare, operation, new parameters.
#include "test/support/bounds.h"
#include "test/unit/fsw/subsystems/manipulator/manipulator_rig.h"

#include "base/octets.h"
#include "unity.h"

void setUp(void)
{
    rig_set_up();
}

void tearDown(void)
{
    rig_tear_down();
}

/// Returns the torque that the subsystem expects in its home pose without contact: gravity plus the offset
/// of the sensor.
static double expected_nm(const unsigned joint)
{
    const manipulator_arm_terms_t terms =
        manipulator_arm_terms(&rig_manipulator.model, rig_manipulator.control.link_rad);
    return terms.gravity_nm[joint] + rig_manipulator.parameters.torque_offset[joint];
}

/// A tare attributes the measured torque to offsets, to masses, or to both.
static void a_tare_is_shared_between_offsets_and_masses(void)
{
    rig_show(GRAVITY1 + 0.2, GRAVITY2 - 0.15);
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_idle(10U);
    EXPECT_WITHIN(GRAVITY1 + 0.2, 0.02, expected_nm(0U));
    EXPECT_WITHIN(GRAVITY2 - 0.15, 0.02, expected_nm(1U));
    EXPECT_ABOVE(3.03, rig_manipulator.parameters.identified.link_mass[0]);
    TEST_ASSERT_EQUAL_UINT32(1U, rig_manipulator.parameters.identified.updates);
    // A new model restarts the identification.
    rig_callbacks->parameter_set(&rig_manipulator, MANIPULATOR_PARAMETER_MODEL);
    TEST_ASSERT_TRUE(rig_manipulator.model.link_mass[0] == 3.0);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_manipulator.identification.updates);
    // New assumptions restart the identification, too.
    rig_idle(20U);
    TEST_ASSERT_EQUAL_UINT32(2U, rig_manipulator.identification.updates);
    rig_callbacks->parameter_set(&rig_manipulator, MANIPULATOR_PARAMETER_IDENTIFICATION);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_manipulator.identification.updates);
}

static void without_identification_a_tare_changes_only_the_offsets(void)
{
    rig_manipulator.parameters.identification.mass_share = 0.0;
    rig_show(GRAVITY1 + 0.2, GRAVITY2 - 0.15);
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_idle(20U);
    EXPECT_WITHIN(0.2, 0.02, rig_manipulator.parameters.torque_offset[0]);
    EXPECT_WITHIN(-0.15, 0.02, rig_manipulator.parameters.torque_offset[1]);
    TEST_ASSERT_TRUE(rig_manipulator.parameters.identified.link_mass[0] == 3.0);
    TEST_ASSERT_EQUAL_UINT32(0U, rig_manipulator.parameters.identified.updates);
}

/// The arm pushes the object that it touches back and forth by 1 mrad.
static void an_arm_that_gives_energy_at_rest_is_reported(void)
{
    rig_show(GRAVITY1, GRAVITY2);
    rig_hand_at(0.0, 0.0);
    rig_bring(MANIPULATOR_CONFIGURATION_TELEPRESENCE, STATE_OPERATIONAL);
    rig_manipulator.parameters.passivity.time  = 0.5;
    rig_manipulator.parameters.passivity.limit = 0.01;
    int32_t moved                              = 0;
    for (unsigned i = 0U; i < 1200U; i++) {
        const bool is_up = ((i / 50U) % 2U) == 0U;
        moved += is_up ? 20 : -20;
        rig_show(GRAVITY1 + (is_up ? 3.0 : -3.0), GRAVITY2);
        rig_joints[0]->position[0] += moved;
        rig_idle(1U);
    }
    TEST_ASSERT_EQUAL_UINT(1U, double_events(&rig_generic, MANIPULATOR_EVENT_PASSIVITY));
    const double_event_t* const event = double_last_event(&rig_generic, MANIPULATOR_EVENT_PASSIVITY);
    octet_reader_t reader             = octet_reader(event->octets, event->size);
    EXPECT_ABOVE(0.01, octet_read_f64(&reader));
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    EXPECT_BELOW(-0.01, rig_manipulator.parameters.energy.taken);
    EXPECT_ABOVE(0.01, rig_manipulator.parameters.energy.given);
}

int main(void)
{
    if (!rig_load()) {
        return 1;
    }
    UNITY_BEGIN();
    RUN_TEST(a_tare_is_shared_between_offsets_and_masses);
    RUN_TEST(without_identification_a_tare_changes_only_the_offsets);
    RUN_TEST(an_arm_that_gives_energy_at_rest_is_reported);
    return UNITY_END();
}
