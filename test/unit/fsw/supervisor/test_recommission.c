// SPDX-License-Identifier: Apache-2.0
// Single steps of recommissioning: the test sets what the supervisor knows of a subsystem, and expects an
// order, or that recommissioning waits. test_supervisor_recommission.c tests whole recommissionings.
#include "fsw/supervisor/recommission.h"

#include "fsw/supervisor/supervisor_internal.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>

static registry_entry_t* entry_of(uint16_t apid)
{
    return supervisor_registry_find(&fixture.supervisor, apid);
}

static recommission_t* run_of(uint16_t apid)
{
    return &entry_of(apid)->recommission;
}

/// The links of ARM and HAND are open, and ARM must return to OPERATIONAL. ARM does not answer orders: the
/// test sets its states.
void setUp(void)
{
    fixture_open_up();
    fixture_link_up(STATE_SAFE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].is_passive = true;
    *run_of(ARM)                            = (recommission_t){.is_active     = true,
                                                               .target        = STATE_OPERATIONAL,
                                                               .configuration = 2U,
                                                               .ordered       = STATE_COUNT,
                                                               .seen          = STATE_COUNT,
                                                               .since_ns      = fixture.now_ns};
}

void tearDown(void)
{
    fixture_close();
}

/// Make the step of ARM in a state. Returns the state that it orders; STATE_COUNT if none.
static state_t step_in(state_t state, state_phase_t phase)
{
    entry_of(ARM)->state = state;
    entry_of(ARM)->phase = phase;
    supervisor_recommission_step(&fixture.supervisor);
    return run_of(ARM)->ordered;
}

// ---- Orders ----

/// Each state at rest has its order; there is no order while the subsystem enters or leaves the state.
static void only_a_state_at_rest_gets_an_order(void)
{
    static const struct {
        state_t state;
        state_phase_t phase;
        state_t ordered;
    } steps[] = {
        {STATE_ERROR_OPERATIONAL, PHASE_ENTERING, STATE_COUNT},
        {STATE_ERROR_OPERATIONAL, PHASE_LEAVING, STATE_COUNT},
        {STATE_ERROR_OPERATIONAL, PHASE_SECURED, STATE_OFFLINE},
        {STATE_POST_OPERATIONAL, PHASE_ENTERING, STATE_COUNT},
        {STATE_HARDWARE_DEINIT, PHASE_UNSECURED, STATE_COUNT}, // A phase that only ERROR_OPERATIONAL has.
        {STATE_OFFLINE, PHASE_INVALID, STATE_COUNT},
        {STATE_OFFLINE, PHASE_IDLE, STATE_PRE_OPERATIONAL},
        {STATE_HARDWARE_INIT, PHASE_ENTERING, STATE_COUNT},
        {STATE_PRE_OPERATIONAL, PHASE_CONFIGURING, STATE_COUNT},
        {STATE_PRE_OPERATIONAL, PHASE_CONFIGURED, STATE_SAFE_OPERATIONAL},
        {STATE_SAFE_OPERATIONAL, PHASE_ENTERING, STATE_COUNT},
        {STATE_SAFE_OPERATIONAL, PHASE_IDLE, STATE_OPERATIONAL}};
    for (size_t i = 0U; i < (sizeof steps / sizeof steps[0]); i++) {
        char row[32];
        (void)snprintf(row, sizeof row, "row %u of the table", (unsigned)i);
        TEST_ASSERT_EQUAL_MESSAGE(steps[i].ordered, step_in(steps[i].state, steps[i].phase), row);
        TEST_ASSERT_TRUE_MESSAGE(run_of(ARM)->is_active, row);
        if (steps[i].ordered == STATE_OFFLINE) { // On the way to OFFLINE, going down is no failure.
            TEST_ASSERT_FALSE_MESSAGE(run_of(ARM)->has_left_offline, row);
        }
    }
}

// ---- Conditions that delay an order ----

static void a_partner_that_has_failed_delays_the_order(void)
{
    const state_t state   = entry_of(HAND)->state;
    entry_of(HAND)->state = STATE_ERROR_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATE_COUNT, step_in(STATE_SAFE_OPERATIONAL, PHASE_IDLE));
    TEST_ASSERT_TRUE(run_of(ARM)->is_active); // PUS_FAILURE_MEMBER_ACTIVE
    entry_of(HAND)->state = state;
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, step_in(STATE_SAFE_OPERATIONAL, PHASE_IDLE));
}

static void a_partner_in_doubt_delays_the_order(void)
{
    entry_of(HAND)->doubt = DOUBT_SILENT;
    TEST_ASSERT_EQUAL(STATE_COUNT, step_in(STATE_SAFE_OPERATIONAL, PHASE_IDLE));
    TEST_ASSERT_TRUE(run_of(ARM)->is_active); // PUS_FAILURE_STATE_IN_DOUBT
    entry_of(HAND)->doubt = DOUBT_NONE;
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, step_in(STATE_SAFE_OPERATIONAL, PHASE_IDLE));
}

static void a_missing_link_delays_the_order(void)
{
    const uint16_t links           = fixture.supervisor.graph.count;
    fixture.supervisor.graph.count = 0U;
    TEST_ASSERT_EQUAL(STATE_COUNT, step_in(STATE_PRE_OPERATIONAL, PHASE_CONFIGURED));
    TEST_ASSERT_TRUE(run_of(ARM)->is_active); // PUS_FAILURE_LINK_MISSING
    fixture.supervisor.graph.count = links;
    TEST_ASSERT_EQUAL(STATE_SAFE_OPERATIONAL, step_in(STATE_PRE_OPERATIONAL, PHASE_CONFIGURED));
}

/// The request of a configuration for which there is no room is repeated in the next step.
static void a_configuration_that_cannot_be_sent_is_sent_later(void)
{
    fixture.members[FIXTURE_ARM].is_passive = false;
    run_of(ARM)->is_active                  = false;
    fixture_fill(FIXTURE_ARM);
    run_of(ARM)->is_active = true;
    TEST_ASSERT_EQUAL(STATE_COUNT, step_in(STATE_PRE_OPERATIONAL, PHASE_UNCONFIGURED));
    TEST_ASSERT_TRUE(run_of(ARM)->is_active);
    fixture.members[FIXTURE_ARM].takes_nothing = false;
    fixture.members[FIXTURE_ARM].is_passive    = true; // ARM reads the requests and stays in its state.
    run_of(ARM)->is_active                     = false;
    fixture_run(4U);
    run_of(ARM)->is_active = true;
    TEST_ASSERT_EQUAL(STATE_PRE_OPERATIONAL, step_in(STATE_PRE_OPERATIONAL, PHASE_UNCONFIGURED));
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.3 0002"));
}

// ---- Beginning of recommissioning ----

/// The last state at rest can only be OFFLINE or one from PRE_OPERATIONAL to OPERATIONAL. A checkpoint may
/// contain any state.
static void only_a_last_state_from_pre_operational_to_operational_begins(void)
{
    static const struct {
        state_t rested;
        bool begins;
    } cases[]                                                         = {{STATE_HARDWARE_INIT, false},
                                                                         {STATE_PRE_OPERATIONAL, true},
                                                                         {STATE_OPERATIONAL, true},
                                                                         {STATE_ERROR_OPERATIONAL, false}};
    ((mission_subsystem_t*)entry_of(ARM)->mission)->is_recommissioned = true;
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        run_of(ARM)->is_active = false;
        entry_of(ARM)->rested  = cases[i].rested;
        supervisor_recommission_begin(&fixture.supervisor, ARM);
        TEST_ASSERT_EQUAL(cases[i].begins, run_of(ARM)->is_active);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(only_a_state_at_rest_gets_an_order);
    RUN_TEST(a_partner_that_has_failed_delays_the_order);
    RUN_TEST(a_partner_in_doubt_delays_the_order);
    RUN_TEST(a_missing_link_delays_the_order);
    RUN_TEST(a_configuration_that_cannot_be_sent_is_sent_later);
    RUN_TEST(only_a_last_state_from_pre_operational_to_operational_begins);
    return UNITY_END();
}
