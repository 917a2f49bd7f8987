// SPDX-License-Identifier: Apache-2.0
// Compares the CiA 402 state machine, for every state and every controlword, with an independent list of the
// standard's transitions. Transitions 0, 1, 13, 14 and 16 are not in the list: the drive makes the first four
// by itself, and does not have the last one.
#include "sim/devices/axis.h"
#include "unity.h"

#include <stdio.h>

void setUp(void)
{
}

void tearDown(void)
{
}

/// A command of the standard: the mask of its bits, and their values.
typedef struct {
    uint16_t mask;
    uint16_t value;
} pattern_t;

static const pattern_t shutdown          = {0x07U, 0x06U};
static const pattern_t switch_on         = {0x0FU, 0x07U};
static const pattern_t disable_voltage   = {0x02U, 0x00U};
static const pattern_t quick_stop        = {0x06U, 0x02U};
static const pattern_t disable_operation = {0x0FU, 0x07U};
static const pattern_t enable_operation  = {0x0FU, 0x0FU};

typedef struct {
    axis_state_t from;
    const pattern_t* command;
    axis_state_t to;
} transition_t;

// The comments are the numbers of the transitions in the standard.
static const transition_t transitions[] = {
    {AXIS_SWITCH_ON_DISABLED, &shutdown, AXIS_READY},              // 2
    {AXIS_READY, &switch_on, AXIS_SWITCHED_ON},                    // 3
    {AXIS_READY, &enable_operation, AXIS_ENABLED},                 // 3 and 4 in one step, as permitted.
    {AXIS_SWITCHED_ON, &enable_operation, AXIS_ENABLED},           // 4
    {AXIS_ENABLED, &disable_operation, AXIS_SWITCHED_ON},          // 5
    {AXIS_SWITCHED_ON, &shutdown, AXIS_READY},                     // 6
    {AXIS_READY, &quick_stop, AXIS_SWITCH_ON_DISABLED},            // 7
    {AXIS_READY, &disable_voltage, AXIS_SWITCH_ON_DISABLED},       // 7
    {AXIS_ENABLED, &shutdown, AXIS_READY},                         // 8
    {AXIS_ENABLED, &disable_voltage, AXIS_SWITCH_ON_DISABLED},     // 9
    {AXIS_SWITCHED_ON, &quick_stop, AXIS_SWITCH_ON_DISABLED},      // 10
    {AXIS_SWITCHED_ON, &disable_voltage, AXIS_SWITCH_ON_DISABLED}, // 10
    {AXIS_ENABLED, &quick_stop, AXIS_QUICK_STOP},                  // 11
    {AXIS_QUICK_STOP, &disable_voltage, AXIS_SWITCH_ON_DISABLED},  // 12
};

static axis_state_t expected_state(axis_state_t state, uint16_t controlword, uint16_t before)
{
    if (state == AXIS_FAULT) { // Transition 15: fault reset, at the rising edge of its bit.
        const bool rises = ((controlword & 0x80U) != 0U) && ((before & 0x80U) == 0U);
        return rises ? AXIS_SWITCH_ON_DISABLED : AXIS_FAULT;
    }
    for (size_t i = 0U; i < (sizeof transitions / sizeof transitions[0]); i++) {
        const transition_t* candidate = &transitions[i];
        if ((candidate->from == state) &&
            ((controlword & candidate->command->mask) == candidate->command->value)) {
            return candidate->to;
        }
    }
    return state;
}

static void every_controlword_in_every_state_leads_to_the_state_of_the_standard(void)
{
    for (unsigned state = 0U; state < AXIS_STATE_COUNT; state++) {
        for (unsigned controlword = 0U; controlword <= 0xFFFFU; controlword++) {
            for (unsigned before = 0U; before <= 0x80U; before += 0x80U) {
                const axis_state_t next =
                    axis_next((axis_state_t)state, (uint16_t)controlword, (uint16_t)before);
                const axis_state_t expected =
                    expected_state((axis_state_t)state, (uint16_t)controlword, (uint16_t)before);
                if (next != expected) { // The text is made only for a failure, because that takes time.
                    char text[64];
                    (void)snprintf(text, sizeof text, "state %u, controlword %04X after %04X", state,
                                   controlword, before);
                    TEST_ASSERT_EQUAL_MESSAGE(expected, next, text);
                }
            }
        }
    }
}

static void statusword_shows_the_state_under_the_masks_of_the_standard(void)
{
    TEST_ASSERT_EQUAL_HEX16(0x00U, axis_state_bits(AXIS_NOT_READY) & 0x4FU);
    TEST_ASSERT_EQUAL_HEX16(0x40U, axis_state_bits(AXIS_SWITCH_ON_DISABLED) & 0x4FU);
    TEST_ASSERT_EQUAL_HEX16(0x21U, axis_state_bits(AXIS_READY) & 0x6FU);
    TEST_ASSERT_EQUAL_HEX16(0x23U, axis_state_bits(AXIS_SWITCHED_ON) & 0x6FU);
    TEST_ASSERT_EQUAL_HEX16(0x27U, axis_state_bits(AXIS_ENABLED) & 0x6FU);
    TEST_ASSERT_EQUAL_HEX16(0x07U, axis_state_bits(AXIS_QUICK_STOP) & 0x6FU);
    TEST_ASSERT_EQUAL_HEX16(0x0FU, axis_state_bits(AXIS_FAULT_REACTION) & 0x4FU);
    TEST_ASSERT_EQUAL_HEX16(0x08U, axis_state_bits(AXIS_FAULT) & 0x4FU);
}

static void the_brake_is_released_only_where_the_drive_controls_the_motor(void)
{
    for (unsigned state = 0U; state < AXIS_STATE_COUNT; state++) {
        const bool moves =
            (state == AXIS_ENABLED) || (state == AXIS_QUICK_STOP) || (state == AXIS_FAULT_REACTION);
        TEST_ASSERT_EQUAL(moves, axis_function_is_enabled((axis_state_t)state));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_controlword_in_every_state_leads_to_the_state_of_the_standard);
    RUN_TEST(statusword_shows_the_state_under_the_masks_of_the_standard);
    RUN_TEST(the_brake_is_released_only_where_the_drive_controls_the_motor);
    return UNITY_END();
}
