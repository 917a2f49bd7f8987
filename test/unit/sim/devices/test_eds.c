// SPDX-License-Identifier: Apache-2.0
// Reading data sheets: accepted content, and every error with its line.
#include "sim/devices/eds.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define GOOD_HEAD "[DeviceInfo]\nVendorName=x\n\n[1000]\nParameterName=Device type\n"

static dictionary_t dictionary;
static char error[EDS_ERROR_MAX];
static char path[] = "/tmp/hirosco-eds-XXXXXX";

void setUp(void)
{
    memcpy(path, "/tmp/hirosco-eds-XXXXXX", sizeof path);
    const int file = mkstemp(path);
    TEST_ASSERT_TRUE(file >= 0);
    (void)close(file);
}

void tearDown(void)
{
    dictionary_destroy(&dictionary);
    (void)unlink(path);
}

static status_t load(const char* text)
{
    FILE* file = fopen(path, "w");
    TEST_ASSERT_NOT_NULL(file);
    (void)fputs(text, file);
    (void)fclose(file);
    error[0] = '\0';
    return eds_load(path, 0x11U, &dictionary, error);
}

/// Expect that the text is refused with a message that begins with file:line and contains `words`.
static void expect_error(const char* text, unsigned line, const char* words)
{
    char begin[64];
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, load(text));
    (void)snprintf(begin, sizeof begin, "%s:%u: ", path, line);
    if ((strncmp(error, begin, strlen(begin)) != 0) || (strstr(error, words) == NULL)) {
        TEST_ASSERT_EQUAL_STRING(begin, error);
    }
    TEST_ASSERT_EQUAL_UINT(0U, dictionary.count);
}

/// Variables and arrays of manufacturer-specific objects are found by their names; other objects are not.
static void a_manufacturer_object_is_found_by_its_name(void)
{
    TEST_ASSERT_EQUAL_INT(
        STATUS_OK, load("[6064]\nParameterName=Position\nDataType=4\nAccessType=ro\n"
                        "[2A00]\nParameterName=Position\nDataType=4\nAccessType=ro\n"
                        "[2B00]\nParameterName=Gains\nObjectType=0x8\nSubNumber=2\n"
                        "[2B00sub0]\nParameterName=Number\nDataType=5\nAccessType=const\nDefaultValue=1\n"
                        "[2B00sub1]\nParameterName=First\nDataType=5\nAccessType=rw\n"));
    TEST_ASSERT_EQUAL_HEX16(0x2A00U, dictionary_index_of(&dictionary, "POSITION"));
    TEST_ASSERT_EQUAL_HEX16(0x2B00U, dictionary_index_of(&dictionary, "Gains"));
    TEST_ASSERT_EQUAL_HEX16(0U, dictionary_index_of(&dictionary, "First")); // The name of an array's member.
    TEST_ASSERT_EQUAL_HEX16(0U, dictionary_index_of(&dictionary, "Gain"));
}

static void default_values_of_all_types_are_read(void)
{
    TEST_ASSERT_EQUAL_INT(
        STATUS_OK, load("[1000]\r\nParameterName=Device type\r\nDataType=0x0007\r\nAccessType=ro\r\n"
                        "DefaultValue=0x20192\r\n\r\n"
                        "[1800]\nParameterName=TPDO\nObjectType=0x9\nSubNumber=2\n"
                        "[1800sub0]\nParameterName=n\nDataType=5\nAccessType=const\nDefaultValue=2\n"
                        "[1800sub1]\nparametername=COB\ndatatype=0x7\naccesstype=RW\n"
                        "defaultvalue=$NODEID+0x40000180\npdomapping=0\n"
                        "; comment\n# comment\n"
                        "[2000]\nParameterName=text\nDataType=0x9\nAccessType=rw\nDefaultValue=some words\n"
                        "[2001]\nParameterName=low\nDataType=3\nAccessType=wo\nLowLimit=-5\nHighLimit=5\n"
                        "DefaultValue=-5\nPDOMapping=1\n"
                        "[2002]\nParameterName=long\nDataType=0x15\nAccessType=rww\n"
                        "DefaultValue=-9000000000\n"
                        "[2003]\nParameterName=empty\nDataType=6\nAccessType=rwr\nDefaultValue=\n"));
    TEST_ASSERT_EQUAL_UINT(7U, dictionary.count);
    TEST_ASSERT_EQUAL_HEX64(0x20192U, dictionary_find(&dictionary, 0x1000U, 0U)->value);
    TEST_ASSERT_FALSE(dictionary_find(&dictionary, 0x1000U, 0U)->is_writable);
    TEST_ASSERT_EQUAL_HEX64(0x40000191U, dictionary_find(&dictionary, 0x1800U, 1U)->value);
    TEST_ASSERT_TRUE(dictionary_find(&dictionary, 0x1800U, 1U)->is_writable);
    TEST_ASSERT_NULL(dictionary_find(&dictionary, 0x1800U, 2U));
    TEST_ASSERT_TRUE(dictionary_has_index(&dictionary, 0x1800U));
    TEST_ASSERT_FALSE(dictionary_has_index(&dictionary, 0x1801U));
    const object_t* text = dictionary_find(&dictionary, 0x2000U, 0U);
    TEST_ASSERT_EQUAL_UINT8(10U, text->size);
    TEST_ASSERT_EQUAL_MEMORY("some words", text->text, 10U);
    const object_t* low = dictionary_find(&dictionary, 0x2001U, 0U);
    TEST_ASSERT_EQUAL_INT64(-5, object_signed(low));
    TEST_ASSERT_EQUAL_HEX64(0xFFFBU, low->value);
    TEST_ASSERT_FALSE(low->is_readable);
    TEST_ASSERT_TRUE(low->is_mappable && low->has_low && low->has_high);
    TEST_ASSERT_EQUAL_INT64(-9000000000, object_signed(dictionary_find(&dictionary, 0x2002U, 0U)));
    TEST_ASSERT_EQUAL_HEX64(0U, dictionary_find(&dictionary, 0x2003U, 0U)->value);
}

static void errors_name_file_and_line(void)
{
    expect_error("[1000\n", 1U, "']'");
    expect_error("nonsense\n", 1U, "key=value");
    expect_error("[1000]\nDataType=7\nAccessType=ro\n", 1U, "ParameterName");
    expect_error(GOOD_HEAD "AccessType=ro\n", 4U, "DataType");
    expect_error(GOOD_HEAD "DataType=7\n[1001]\n", 4U, "AccessType");
    expect_error(GOOD_HEAD "DataType=0\nAccessType=ro\n", 6U, "DataType");
    expect_error(GOOD_HEAD "DataType=0x260\nAccessType=ro\n", 6U, "DataType");
    expect_error(GOOD_HEAD "DataType=seven\nAccessType=ro\n", 6U, "a number");
    expect_error(GOOD_HEAD "DataType=7\nAccessType=rx\n", 7U, "AccessType ro");
    expect_error(GOOD_HEAD "ObjectType=0x4\n", 6U, "ObjectType");
    expect_error(GOOD_HEAD "ObjectType=0xA\n", 6U, "ObjectType");
    expect_error(GOOD_HEAD "DataType=7\nAccessType=ro\nDefaultValue=many\n", 8U, "a number as DefaultValue");
    expect_error(GOOD_HEAD "DataType=7\nAccessType=ro\nDefaultValue=$NODEID+\n", 8U,
                 "a number as DefaultValue");
    expect_error(GOOD_HEAD "DataType=5\nAccessType=ro\nDefaultValue=256\n", 8U, "inside DataType");
    expect_error(GOOD_HEAD "DataType=5\nAccessType=ro\nDefaultValue=-1\n", 8U, "inside DataType");
    expect_error(GOOD_HEAD "DataType=2\nAccessType=ro\nDefaultValue=128\n", 8U, "inside DataType");
    expect_error(GOOD_HEAD "DataType=2\nAccessType=ro\nDefaultValue=0x100\n", 8U, "inside DataType");
    expect_error(GOOD_HEAD "DataType=1\nAccessType=ro\nDefaultValue=2\n", 8U, "inside DataType");
    expect_error(GOOD_HEAD "DataType=5\nAccessType=ro\nHighLimit=9\nDefaultValue=10\n", 9U, "HighLimit");
    expect_error(GOOD_HEAD "DataType=9\nAccessType=ro\nDefaultValue="
                           "12345678901234567890123456789012345678901234567890123456789012345\n",
                 8U, "64 characters");
}

/// A byte order mark, and objects of types that simulated devices do not have, as in the sheets of makers.
static void objects_of_other_types_are_left_out(void)
{
    TEST_ASSERT_EQUAL_INT(
        STATUS_OK,
        load("\xEF\xBB\xBF[1000]\nParameterName=Device type\nDataType=7\nAccessType=ro\nDefaultValue=1\n"
             "[0020]\nParameterName=PDO\nObjectType=0x6\n"
             "[1F50]\nParameterName=Program data\nObjectType=0x8\nDataType=0x000F\n"
             "[1F50Sub0]\nParameterName=Number\nDataType=5\nAccessType=const\nDefaultValue=1\n"
             "[1F50Sub1]\nParameterName=Program\nObjectType=0x2\nDataType=0x000F\nAccessType=wo\n"
             "[2000]\nParameterName=Gain\nDataType=0xC\nAccessType=rw\nLowLimit=-0.5\nDefaultValue=0.5\n"
             "[2001]\nParameterName=Domain\nObjectType=2\nAccessType=rw\n"
             "[2002]\nParameterName=Angle\nDataType=0xD\nAccessType=ro\nDefaultValue=1.5\n"));
    TEST_ASSERT_EQUAL_UINT(2U, dictionary.count);
    TEST_ASSERT_EQUAL_HEX64(1U, dictionary_find(&dictionary, 0x1000U, 0U)->value);
    TEST_ASSERT_EQUAL_HEX64(1U, dictionary_find(&dictionary, 0x1F50U, 0U)->value);
    TEST_ASSERT_EQUAL_HEX16(0U, dictionary_index_of(&dictionary, "Gain"));
    TEST_ASSERT_EQUAL_HEX16(0U, dictionary_index_of(&dictionary, "Domain"));
}

#define REAL_HEAD(kind) "[2000]\nParameterName=a\nDataType=" kind "\nAccessType=rw\n"

/// REAL32 and REAL64, bit by bit.
static void real_numbers_are_read(void)
{
    static const struct {
        const char* text;
        uint8_t size;
        uint64_t bits;
    } cases[] = {{REAL_HEAD("8") "LowLimit=-0.5\nHighLimit=1e3\nDefaultValue=0.1\n", 4U, 0x3DCCCCCDU},
                 {REAL_HEAD("0x0008") "DefaultValue=-2\n", 4U, 0xC0000000U},
                 {REAL_HEAD("8") "DefaultValue=\n", 4U, 0U},
                 {REAL_HEAD("8") "DefaultValue=-3.4028234663852886e38\n", 4U, 0xFF7FFFFFU},
                 {REAL_HEAD("0x11") "DefaultValue=0.1\n", 8U, 0x3FB999999999999AU},
                 {REAL_HEAD("0x11") "DefaultValue=1e300\n", 8U, 0x7E37E43C8800759CU}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, load(cases[i].text), error);
        TEST_ASSERT_EQUAL_UINT8(cases[i].size, dictionary.objects[0].size);
        TEST_ASSERT_EQUAL_HEX64(cases[i].bits, dictionary.objects[0].value);
        TEST_ASSERT_EQUAL_HEX64(cases[i].bits, dictionary.objects[0].initial);
        TEST_ASSERT_EQUAL(i == 0U, dictionary.objects[0].has_low);
        TEST_ASSERT_EQUAL(i == 0U, dictionary.objects[0].has_high);
        dictionary_destroy(&dictionary);
    }
    expect_error(REAL_HEAD("8") "DefaultValue=half\n", 5U, "a finite number as DefaultValue");
    expect_error(REAL_HEAD("8") "DefaultValue=0.5V\n", 5U, "a finite number as DefaultValue");
    expect_error(REAL_HEAD("8") "DefaultValue=nan\n", 5U, "a finite number as DefaultValue");
    expect_error(REAL_HEAD("8") "DefaultValue=-inf\n", 5U, "a finite number as DefaultValue");
    expect_error(REAL_HEAD("8") "DefaultValue=0x10\n", 5U, "a finite number as DefaultValue");
    expect_error(REAL_HEAD("0x11") "DefaultValue=1e400\n", 5U, "a finite number as DefaultValue");
    expect_error(REAL_HEAD("8") "DefaultValue=1e39\n", 5U, "inside DataType");
    expect_error(REAL_HEAD("8") "LowLimit=0.25\nDefaultValue=0\n", 6U, "LowLimit");
    expect_error(REAL_HEAD("8") "HighLimit=0.25\nDefaultValue=0.5\n", 6U, "HighLimit");
    expect_error(REAL_HEAD("8") "LowLimit=low\n", 5U, "a finite number");
}

/// Makers write negative numbers in hexadecimal as two's complement, in limits, too.
static void numbers_of_24_to_56_bits_are_read(void)
{
    static const struct {
        unsigned type;
        uint8_t size;
        bool is_signed;
    } types[] = {{0x10U, 3U, true},  {0x12U, 5U, true},  {0x13U, 6U, true},  {0x14U, 7U, true},
                 {0x16U, 3U, false}, {0x18U, 5U, false}, {0x19U, 6U, false}, {0x1AU, 7U, false}};
    for (size_t i = 0U; i < (sizeof types / sizeof types[0]); i++) {
        char text[256];
        (void)snprintf(text, sizeof text,
                       "[2000]\nParameterName=a\nDataType=0x%X\nAccessType=rw\nDefaultValue=%s\n",
                       types[i].type, types[i].is_signed ? "-2" : "2");
        TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, load(text), error);
        TEST_ASSERT_EQUAL_UINT(1U, dictionary.count);
        TEST_ASSERT_EQUAL_UINT8(types[i].size, dictionary.objects[0].size);
        TEST_ASSERT_EQUAL_INT64(types[i].is_signed ? -2 : 2, object_signed(&dictionary.objects[0]));
        dictionary_destroy(&dictionary);
    }
    expect_error("[2000]\nParameterName=a\nDataType=0x16\nAccessType=rw\nDefaultValue=0x1000000\n", 5U,
                 "a DefaultValue inside DataType");
}

static void members_of_a_compact_array_are_read(void)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(
        STATUS_OK,
        load("[1003]\nParameterName=errors\nObjectType=8\nDataType=7\nAccessType=ro\n"
             "CompactSubObj=3\nDefaultValue=5\n[1003Name]\nNrOfEntries=0\n"),
        error);
    TEST_ASSERT_EQUAL_UINT(4U, dictionary.count);
    TEST_ASSERT_EQUAL_UINT64(3U, dictionary_find(&dictionary, 0x1003U, 0U)->value);
    TEST_ASSERT_EQUAL_UINT64(5U, dictionary_find(&dictionary, 0x1003U, 3U)->value);
    TEST_ASSERT_FALSE(dictionary_find(&dictionary, 0x1003U, 1U)->is_writable);
    dictionary_destroy(&dictionary);
    expect_error("[1003]\nParameterName=errors\nObjectType=8\nDataType=7\nAccessType=ro\nCompactSubObj=255\n",
                 6U, "found '255', expected a number of sub-objects from 0 to 254");
    expect_error("[1003]\nParameterName=errors\nObjectType=8\nCompactSubObj=3\n", 1U,
                 "DataType in this section");
    expect_error("[1003]\nParameterName=errors\nObjectType=8\nDataType=7\nAccessType=ro\nCompactSubObj=3\n"
                 "[1003Value]\nNrOfEntries=1\n1=9\n",
                 7U, "found '1003Value', expected the values of CompactSubObj as DefaultValue in a section");
}

static void a_hexadecimal_number_of_a_signed_type_may_be_a_twos_complement(void)
{
    TEST_ASSERT_EQUAL_INT(
        STATUS_OK,
        load("[607D]\nParameterName=low\nDataType=4\nAccessType=rw\nLowLimit=0x80000000\n"
             "HighLimit=0x7FFFFFFF\nDefaultValue=0x80000000\n"
             "[2000]\nParameterName=octet\nDataType=2\nAccessType=rw\nDefaultValue=0xFF\n"
             "[2001]\nParameterName=most\nDataType=2\nAccessType=rw\nDefaultValue=0x7F\n"
             "[2002]\nParameterName=without a sign\nDataType=7\nAccessType=rw\nDefaultValue=0x80000000\n"));
    TEST_ASSERT_EQUAL_INT64(INT32_MIN, object_signed(dictionary_find(&dictionary, 0x607DU, 0U)));
    TEST_ASSERT_EQUAL_INT64(INT32_MIN, dictionary_find(&dictionary, 0x607DU, 0U)->low);
    TEST_ASSERT_EQUAL_INT64(INT32_MAX, dictionary_find(&dictionary, 0x607DU, 0U)->high);
    TEST_ASSERT_EQUAL_INT64(-1, object_signed(dictionary_find(&dictionary, 0x2000U, 0U)));
    TEST_ASSERT_EQUAL_INT64(127, object_signed(dictionary_find(&dictionary, 0x2001U, 0U)));
    TEST_ASSERT_EQUAL_HEX64(0x80000000U, dictionary_find(&dictionary, 0x2002U, 0U)->value);
}

static void duplicate_objects_and_empty_files_are_refused(void)
{
    static const char* const object = "[1000]\nParameterName=a\nDataType=7\nAccessType=ro\n";
    char twice[256];
    (void)snprintf(twice, sizeof twice, "%s%s", object, object);
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, load(twice));
    TEST_ASSERT_NOT_NULL(strstr(error, "1000:00 is described twice"));
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, load("[Comments]\nLines=0\n"));
    TEST_ASSERT_NOT_NULL(strstr(error, "no object"));
}

static void a_missing_file_is_reported_with_the_next_step(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_NOT_FOUND, eds_load("/nowhere/none.eds", 1U, &dictionary, error));
    TEST_ASSERT_NOT_NULL(strstr(error, "/nowhere/none.eds"));
    TEST_ASSERT_NOT_NULL(strstr(error, "project's root"));
}

static void data_sheets_of_the_mission_are_complete(void)
{
    static const char* const sheets[] = {"descriptors/devices/joint-drive.eds",
                                         "descriptors/devices/joystick.eds"};
    for (unsigned i = 0U; i < 2U; i++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, eds_load(sheets[i], 0x21U, &dictionary, error), error);
        TEST_ASSERT_GREATER_THAN_UINT(100U, dictionary.count);
        // Default mappings name mappable objects of the right size.
        for (size_t k = 0U; k < dictionary.count; k++) {
            const object_t* object = &dictionary.objects[k];
            const bool is_mapping  = ((object->index >= 0x1600U) && (object->index < 0x1800U)) ||
                                    ((object->index >= 0x1A00U) && (object->index < 0x1C00U));
            if (!is_mapping || (object->subindex == 0U) || (object->value == 0U)) {
                continue;
            }
            const object_t* mapped =
                dictionary_find(&dictionary, (uint16_t)(object->value >> 16), (uint8_t)(object->value >> 8));
            TEST_ASSERT_NOT_NULL(mapped);
            TEST_ASSERT_TRUE(mapped->is_mappable);
            TEST_ASSERT_EQUAL_UINT64(8U * mapped->size, object->value & 0xFFU);
        }
        dictionary_destroy(&dictionary);
    }
}

static void reset_restores_initial_values(void)
{
    TEST_ASSERT_EQUAL_INT(STATUS_OK,
                          load("[1000]\nParameterName=a\nDataType=7\nAccessType=rw\nDefaultValue=5\n"
                               "[2000]\nParameterName=b\nDataType=9\nAccessType=rw\nDefaultValue=ab\n"));
    object_t* number = dictionary_find(&dictionary, 0x1000U, 0U);
    object_t* text   = dictionary_find(&dictionary, 0x2000U, 0U);
    object_set(number, 9);
    text->text[0] = 'x';
    text->size    = 1U;
    dictionary_reset_range(&dictionary, 0x1000U, 0x1FFFU);
    TEST_ASSERT_EQUAL_UINT64(5U, number->value);
    TEST_ASSERT_EQUAL_UINT8(1U, text->size);
    dictionary_reset_range(&dictionary, 0U, UINT16_MAX);
    TEST_ASSERT_EQUAL_UINT8(2U, text->size);
    TEST_ASSERT_EQUAL_MEMORY("ab", text->text, 2U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_manufacturer_object_is_found_by_its_name);
    RUN_TEST(default_values_of_all_types_are_read);
    RUN_TEST(errors_name_file_and_line);
    RUN_TEST(objects_of_other_types_are_left_out);
    RUN_TEST(real_numbers_are_read);
    RUN_TEST(numbers_of_24_to_56_bits_are_read);
    RUN_TEST(members_of_a_compact_array_are_read);
    RUN_TEST(a_hexadecimal_number_of_a_signed_type_may_be_a_twos_complement);
    RUN_TEST(duplicate_objects_and_empty_files_are_refused);
    RUN_TEST(a_missing_file_is_reported_with_the_next_step);
    RUN_TEST(data_sheets_of_the_mission_are_complete);
    RUN_TEST(reset_restores_initial_values);
    return UNITY_END();
}
