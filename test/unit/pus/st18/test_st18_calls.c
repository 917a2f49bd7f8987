// SPDX-License-Identifier: Apache-2.0
// Calls of a procedure that are answered at once: values and events.
#include "test/unit/pus/fixtures/st18_fixture.h"
#include "unity.h"

void setUp(void)
{
    st18_fixture_start();
    st18_fixture_load("ABCD", 10U, 'x');
}

void tearDown(void)
{
}

static void values_are_read_by_id_and_name(void)
{
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_call(0U, PUS_CALL_GET, 77U);
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_call(0U, PUS_CALL_GET, 78U);
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_call(0U, PUS_CALL_GET_NAMED, 0U);
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_call(0U, PUS_CALL_GET_NAMED, 0U);
    st18_fixture.slots[0].calls[6].text = "OTHER";
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_call(0U, PUS_CALL_GET, 77U);
    st18_fixture_call(0U, PUS_CALL_STEP, 3U); // A call without an answer does not keep the previous answer.
    static const pus_answer_kind_t expected[] = {PUS_ANSWER_VALUE, PUS_ANSWER_MISSING, PUS_ANSWER_VALUE,
                                                 PUS_ANSWER_MISSING, PUS_ANSWER_NONE};
    for (size_t i = 0U; i < (sizeof expected / sizeof expected[0]); i++) {
        st18_fixture_step(1U);
        TEST_ASSERT_EQUAL(expected[i], st18_fixture.slots[0].answer.kind);
        TEST_ASSERT_TRUE((expected[i] != PUS_ANSWER_VALUE) || (st18_fixture.slots[0].answer.bits == 4711U));
    }
}

static void events_are_raised(void)
{
    st18_fixture_activate("ABCD", 0U);
    st18_fixture_call(0U, PUS_CALL_STEP, 9U);
    st18_fixture_call(0U, PUS_CALL_EVENT, ST18_FIXTURE_KNOWN_EVENT);
    st18_fixture_call(0U, PUS_CALL_PAUSED, 0U);
    st18_fixture_call(0U, PUS_CALL_EVENT, 1U);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_UINT16(ST18_FIXTURE_KNOWN_EVENT, st18_fixture.events.id);
    TEST_ASSERT_EQUAL_UINT64(10U, st18_fixture.events.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("ABCD\0\0\0\0\0\11", st18_fixture.events.auxiliary, 10U);
    TEST_ASSERT_EQUAL_HEX16(0U, st18_fixture.slots[0].answer.code);
    st18_fixture_step(1U);
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_UNKNOWN_ID, st18_fixture.slots[0].answer.code);
    TEST_ASSERT_EQUAL_UINT(1U, st18_fixture.events.count);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(values_are_read_by_id_and_name);
    RUN_TEST(events_are_raised);
    return UNITY_END();
}
