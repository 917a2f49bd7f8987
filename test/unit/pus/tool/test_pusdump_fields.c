// SPDX-License-Identifier: Apache-2.0
// Decoding of application and source data by the generated layouts of pusdump.
#include "pus/tool/pusdump_fields.h"

#include "pus/tool/pusdump_messages.h"
#include "unity.h"

#include <string.h>

static char text[4096];

void setUp(void)
{
}

void tearDown(void)
{
}

/// Expect that the brackets of the JSON text are balanced and that every field has a value.
static void expect_balanced(const char* const json)
{
    char open[16];
    size_t depth = 0U;
    for (const char* at = json; *at != '\0'; at++) {
        if ((*at == '{') || (*at == '[')) {
            TEST_ASSERT_TRUE(depth < sizeof open);
            open[depth] = *at;
            depth++;
        } else if ((*at == '}') || (*at == ']')) {
            TEST_ASSERT_TRUE(depth > 0U);
            depth--;
            TEST_ASSERT_EQUAL((*at == '}') ? '{' : '[', open[depth]);
        }
    }
    TEST_ASSERT_EQUAL_UINT64(0U, depth);
    TEST_ASSERT_NULL(strstr(json, ":,"));
    TEST_ASSERT_NULL(strstr(json, ":}"));
    TEST_ASSERT_NULL(strstr(json, ",,"));
}

static void every_layout_takes_exactly_one_size_of_zeros(void)
{
    unsigned layouts = 0U;
    for (unsigned service = 0U; service < 256U; service++) {
        for (unsigned subtype = 0U; subtype < 256U; subtype++) {
            static const uint8_t zeros[80];
            const char* const layout = message_layout((uint8_t)service, (uint8_t)subtype);
            unsigned fitting         = 0U;
            if (layout == NULL) {
                continue;
            }
            layouts++;
            TEST_ASSERT_NULL(strstr(message_name((uint8_t)service, (uint8_t)subtype), "unknown"));
            TEST_ASSERT_NOT_EQUAL(
                0, strcmp("mission message", message_name((uint8_t)service, (uint8_t)subtype)));
            for (size_t size = 0U; size < sizeof zeros; size++) {
                const bool fits = dump_fields(layout, zeros, size, true, text, sizeof text);
                TEST_ASSERT_EQUAL(fits, dump_fields(layout, zeros, size, false, text, sizeof text));
                (void)dump_fields(layout, zeros, size, true, text, sizeof text);
                if (fits) {
                    expect_balanced(text);
                    fitting++;
                }
            }
            // A time of zeros has no known code; the field `rest` has any size.
            const bool is_open = (strstr(layout, ":rest") != NULL);
            const bool is_time = (strstr(layout, ":time") != NULL);
            TEST_ASSERT_TRUE_MESSAGE(is_open ? (fitting > 1U) : (fitting == (is_time ? 0U : 1U)), layout);
        }
    }
    TEST_ASSERT_TRUE(layouts > 50U);
}

static void a_text_that_does_not_fit_is_refused(void)
{
    static const uint8_t data[] = {2, 0, 1, 0, 2};
    const char* const layout    = message_layout(5U, 5U);
    TEST_ASSERT_TRUE(dump_fields(layout, data, sizeof data, false, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("events=[event=1, event=2]", text);
    for (size_t capacity = 1U; capacity <= 25U; capacity++) {
        TEST_ASSERT_FALSE(dump_fields(layout, data, sizeof data, false, text, capacity));
        TEST_ASSERT_TRUE(strlen(text) < capacity);
    }
    TEST_ASSERT_TRUE(dump_fields(layout, data, sizeof data, false, text, 26U));
    TEST_ASSERT_TRUE(dump_fields(layout, data, sizeof data, true, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("{\"events\":[{\"event\":1},{\"event\":2}]}", text);
}

static void fields_after_empty_lists_are_decoded(void)
{
    static const uint8_t data[] = {0, 2, 0, 1, 0, 0, 0, 1, 0, 7, 0, 2, 0, 1, 0, 16, 0, 0};
    TEST_ASSERT_TRUE(dump_fields(message_layout(131U, 11U), data, sizeof data, false, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING(
        "networks=[network=1 members=[] links=[link=7], network=2 members=[apid=16] links=[]]", text);
}

static void special_characters_of_a_name_are_printed_as_question_marks(void)
{
    static const uint8_t data[] = {'A', '"', '\\', '\n', 0xFF, ' ', 'Z', 0, 0};
    TEST_ASSERT_TRUE(dump_fields(message_layout(8U, 1U), data, sizeof data, true, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("{\"function\":\"A\?\?\?\?\?Z\",\"n\":0,\"arguments\":\"\"}", text);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_layout_takes_exactly_one_size_of_zeros);
    RUN_TEST(a_text_that_does_not_fit_is_refused);
    RUN_TEST(fields_after_empty_lists_are_decoded);
    RUN_TEST(special_characters_of_a_name_are_printed_as_question_marks);
    return UNITY_END();
}
