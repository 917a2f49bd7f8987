// SPDX-License-Identifier: Apache-2.0
// Paths, names and patterns of files in requests: accepted forms, refused forms and lengths.
#include "pus/core/file_path.h"

#include "unity.h"

#include <string.h>

static pus_file_path_t path;
static uint8_t octets[300];

void setUp(void)
{
    path.text[0] = '\0';
}

void tearDown(void)
{
}

/// Returns a text in the form that it has in a request.
static octet_reader_t text(const char* const characters, const size_t size)
{
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, (uint16_t)size);
    octet_write_octets(&writer, (const uint8_t*)characters, size);
    return octet_reader(octets, writer.position);
}

static bool reads(const char* const characters)
{
    octet_reader_t reader = text(characters, strlen(characters));
    const bool is_path    = pus_file_path_read(&reader, &path);
    TEST_ASSERT_TRUE(!is_path || octet_reader_is_done(&reader));
    return is_path;
}

static bool reads_name(const char* const characters, const size_t size)
{
    octet_reader_t reader = text(characters, size);
    return pus_file_path_read_name(&reader, &path);
}

static void a_path_has_the_same_form_with_and_without_a_leading_slash(void)
{
    static const char* const same[][2] = {
        {"", ""}, {"/", ""}, {"a", "a"}, {"/a", "a"}, {"/a/b", "a/b"}, {"a b/~c", "a b/~c"}, {"a.b", "a.b"}};
    for (size_t i = 0U; i < (sizeof same / sizeof same[0]); i++) {
        TEST_ASSERT_TRUE(reads(same[i][0]));
        TEST_ASSERT_EQUAL_STRING(same[i][1], path.text);
    }
    TEST_ASSERT_FALSE(reads("a-/..a"));
}

static void hostile_and_malformed_paths_are_refused(void)
{
    static const char* const hostile[] = {
        "..",  "../a",  "a/..",  "a/../b", ".",   "./a",     "a/.", "a/./b",        "//",
        "//a", "a//b",  "a/",    "/a/",    ".a",  "a/.b",    "*",   "a/b*",         "a?",
        "a\n", "a\x7f", "a\x80", "\x1f",   "/..", "/../etc", "/.",  "a/b/../../..",
    };
    for (size_t i = 0U; i < (sizeof hostile / sizeof hostile[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(reads(hostile[i]), hostile[i]);
    }
    octet_reader_t reader = text("a\0b", 3U);
    TEST_ASSERT_FALSE(pus_file_path_read(&reader, &path));
    reader = octet_reader((const uint8_t*)"\0\5abc", 5U); // The length field announces 5 characters.
    TEST_ASSERT_FALSE(pus_file_path_read(&reader, &path));
    reader = octet_reader((const uint8_t*)"\0", 1U);
    TEST_ASSERT_FALSE(pus_file_path_read(&reader, &path));
}

static void names_and_paths_have_a_maximum_length(void)
{
    char longest[PUS_FILE_PATH_MAX + 3U];
    memset(longest, 'a', sizeof longest);
    longest[63]  = '/';
    longest[127] = '/';
    longest[191] = '\0';
    TEST_ASSERT_TRUE(reads(longest)); // Three names of 63 characters.
    TEST_ASSERT_FALSE(pus_file_path_enter(&path, "b"));
    TEST_ASSERT_FALSE(reads_name("b", 1U));
    longest[127] = 'a';
    TEST_ASSERT_FALSE(reads(longest));
    memset(longest, 'a', sizeof longest);
    for (size_t i = 50U; i < PUS_FILE_PATH_MAX; i += 50U) {
        longest[i] = '/';
    }
    longest[PUS_FILE_PATH_MAX] = '\0';
    TEST_ASSERT_TRUE(reads(longest));
    longest[PUS_FILE_PATH_MAX]      = 'a';
    longest[PUS_FILE_PATH_MAX + 1U] = '\0';
    TEST_ASSERT_FALSE(reads(longest));
    memset(longest, 'a', sizeof longest);
    path.text[0] = '\0';
    TEST_ASSERT_FALSE(reads_name(longest, PUS_FILE_NAME_MAX + 1U));
    TEST_ASSERT_TRUE(reads_name(longest, PUS_FILE_NAME_MAX));
}

static void names_are_appended_to_a_path_and_removed(void)
{
    TEST_ASSERT_TRUE(reads_name("a", 1U));
    TEST_ASSERT_TRUE(reads_name("b.c", 3U));
    TEST_ASSERT_EQUAL_STRING("a/b.c", path.text);
    static const char* const hostile[] = {"", ".", "..", "/", "/a", "a/b", "a/", "*", "?", "a*", ".a", "\t"};
    for (size_t i = 0U; i < (sizeof hostile / sizeof hostile[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(reads_name(hostile[i], strlen(hostile[i])), hostile[i]);
        TEST_ASSERT_FALSE(pus_file_name_is_good(hostile[i]));
        TEST_ASSERT_EQUAL_STRING("a/b.c", path.text);
    }
    TEST_ASSERT_FALSE(reads_name("a\0b", 3U));
    octet_reader_t reader = octet_reader((const uint8_t*)"\0\5abc", 5U);
    TEST_ASSERT_FALSE(pus_file_path_read_name(&reader, &path));
    TEST_ASSERT_TRUE(pus_file_name_is_good("b.c"));
    TEST_ASSERT_EQUAL_STRING("b.c", pus_file_path_name(&path));
    pus_file_path_leave(&path);
    TEST_ASSERT_EQUAL_STRING("a", path.text);
    TEST_ASSERT_EQUAL_STRING("a", pus_file_path_name(&path));
    pus_file_path_leave(&path);
    TEST_ASSERT_EQUAL_STRING("", path.text);
    TEST_ASSERT_TRUE(pus_file_path_enter(&path, "a"));
    TEST_ASSERT_TRUE(pus_file_path_enter(&path, "b"));
    TEST_ASSERT_EQUAL_STRING("a/b", path.text);
}

static void a_path_lies_within_itself_and_the_directories_above(void)
{
    static const pus_file_path_t root = {""};
    static const pus_file_path_t a    = {"a"};
    static const pus_file_path_t ab   = {"a/b"};
    static const pus_file_path_t abc  = {"ab/c"};
    TEST_ASSERT_TRUE(pus_file_path_is_within(&a, &root));
    TEST_ASSERT_TRUE(pus_file_path_is_within(&root, &root));
    TEST_ASSERT_TRUE(pus_file_path_is_within(&ab, &a));
    TEST_ASSERT_TRUE(pus_file_path_is_within(&a, &a));
    TEST_ASSERT_FALSE(pus_file_path_is_within(&a, &ab));
    TEST_ASSERT_FALSE(pus_file_path_is_within(&abc, &a));
    TEST_ASSERT_FALSE(pus_file_path_is_within(&root, &a));
    TEST_ASSERT_TRUE(pus_file_path_is_same(&a, &a));
    TEST_ASSERT_FALSE(pus_file_path_is_same(&a, &ab));
}

static void an_asterisk_matches_any_text_and_a_question_mark_one_character(void)
{
    static const char* const yes[][2] = {
        {"*", "a"},         {"*", "abc"},     {"a*", "a"},        {"a*c", "abc"}, {"a*c", "ac"},
        {"*.txt", "a.txt"}, {"?", "a"},       {"a?c", "abc"},     {"**", "a"},    {"*a*b*c*", "xaxbxcx"},
        {"a*b*", "aab"},    {"*ab", "aabab"}, {"abc", "abc"},     {"?*", "a"},    {"*?", "ab"},
        {"*aab", "aaab"},   {"a*?b", "axyb"}, {"*b?d", "abcabxd"}};
    static const char* const no[][2] = {{"a", "b"},     {"a", "ab"}, {"ab", "a"},       {"?", "ab"},
                                        {"a*c", "abx"}, {"a?", "a"}, {"*.txt", "a.tx"}, {"??*", "a"},
                                        {"*a", "ab"},   {"A", "a"},  {"*ab*cd", "abc"}};
    for (size_t i = 0U; i < (sizeof yes / sizeof yes[0]); i++) {
        TEST_ASSERT_TRUE_MESSAGE(pus_file_pattern_matches(yes[i][0], yes[i][1]), yes[i][0]);
    }
    for (size_t i = 0U; i < (sizeof no / sizeof no[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(pus_file_pattern_matches(no[i][0], no[i][1]), no[i][0]);
    }
}

static void well_formed_patterns_are_read_and_others_are_refused(void)
{
    char pattern[PUS_FILE_NAME_MAX + 1U];
    char longest[PUS_FILE_NAME_MAX + 1U];
    memset(longest, '*', sizeof longest);
    octet_reader_t reader = text("a*?.", 4U);
    TEST_ASSERT_TRUE(pus_file_pattern_read(&reader, pattern));
    TEST_ASSERT_EQUAL_STRING("a*?.", pattern);
    reader = text(longest, PUS_FILE_NAME_MAX);
    TEST_ASSERT_TRUE(pus_file_pattern_read(&reader, pattern));
    reader = text(longest, PUS_FILE_NAME_MAX + 1U);
    TEST_ASSERT_FALSE(pus_file_pattern_read(&reader, pattern));
    reader = text("", 0U);
    TEST_ASSERT_FALSE(pus_file_pattern_read(&reader, pattern));
    reader = text("a/b", 3U);
    TEST_ASSERT_FALSE(pus_file_pattern_read(&reader, pattern));
    reader = text("/a", 2U);
    TEST_ASSERT_FALSE(pus_file_pattern_read(&reader, pattern));
    reader = text("\x1f", 1U);
    TEST_ASSERT_FALSE(pus_file_pattern_read(&reader, pattern));
    reader = text("a\0", 2U);
    TEST_ASSERT_FALSE(pus_file_pattern_read(&reader, pattern));
    reader = octet_reader((const uint8_t*)"\0\5abc", 5U);
    TEST_ASSERT_FALSE(pus_file_pattern_read(&reader, pattern));
}

static void paths_and_names_are_written_with_their_length(void)
{
    static const uint8_t expected[] = {0, 4, '/', 'a', '/', 'b', 0, 1, '/', 0, 2, 'x', 'y'};
    octet_writer_t writer           = octet_writer(octets, sizeof octets);
    TEST_ASSERT_TRUE(pus_file_path_enter(&path, "a"));
    TEST_ASSERT_TRUE(pus_file_path_enter(&path, "b"));
    pus_file_path_write(&writer, &path);
    path.text[0] = '\0';
    pus_file_path_write(&writer, &path);
    pus_file_name_write(&writer, "xy");
    TEST_ASSERT_EQUAL_UINT64(sizeof expected, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, octets, sizeof expected);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_path_has_the_same_form_with_and_without_a_leading_slash);
    RUN_TEST(hostile_and_malformed_paths_are_refused);
    RUN_TEST(names_and_paths_have_a_maximum_length);
    RUN_TEST(names_are_appended_to_a_path_and_removed);
    RUN_TEST(a_path_lies_within_itself_and_the_directories_above);
    RUN_TEST(an_asterisk_matches_any_text_and_a_question_mark_one_character);
    RUN_TEST(well_formed_patterns_are_read_and_others_are_refused);
    RUN_TEST(paths_and_names_are_written_with_their_length);
    return UNITY_END();
}
