// SPDX-License-Identifier: Apache-2.0
#include "launcher/eeprom_image.h"

#include "osal/include/osal/process.h"
#include "test/support/directory.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

static char directory[64];
static char path[96];
static eeprom_image_t image = {{-1}, {-1}};
static uint8_t content[TARGET_EEPROM_OCTETS + 1U];

void setUp(void)
{
    (void)snprintf(directory, sizeof directory, TEST_DIRECTORY "/eeprom-image-%d",
                   (int)osal_process_own_id());
    (void)snprintf(path, sizeof path, "%s.eeprom", directory);
    (void)osal_file_remove(path);
}

void tearDown(void)
{
    eeprom_image_close(&image);
    (void)osal_file_remove(path);
}

/// The image lies beside the directory: the name of the component is the last part of its path.
static status_t open_image(eeprom_image_t* const one)
{
    return eeprom_image_open(one, TEST_DIRECTORY, &directory[sizeof TEST_DIRECTORY]);
}

static void write_whole(const size_t size, const int octet)
{
    osal_file_t file;
    (void)memset(content, octet, size);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, content, size));
    osal_file_close(&file);
}

static void read_whole(void)
{
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(TARGET_EEPROM_OCTETS, size);
}

static void a_missing_image_is_made_blank(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, open_image(&image));
    read_whole();
    TEST_ASSERT_EACH_EQUAL_HEX8(0xFF, content, TARGET_EEPROM_OCTETS);
    TEST_ASSERT_EQUAL(STATUS_IO, osal_file_write(&image.reader, "x", 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&image.file, "x", 1U));
}

static void an_image_that_was_interrupted_is_completed(void)
{
    write_whole(5000U, 0xFF);
    TEST_ASSERT_EQUAL(STATUS_OK, open_image(&image));
    read_whole();
    TEST_ASSERT_EACH_EQUAL_HEX8(0xFF, content, TARGET_EEPROM_OCTETS);
}

static void the_content_is_kept(void)
{
    write_whole(TARGET_EEPROM_OCTETS, 0x5A);
    TEST_ASSERT_EQUAL(STATUS_OK, open_image(&image));
    (void)memset(content, 0, sizeof content);
    read_whole();
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, content, TARGET_EEPROM_OCTETS);
}

static void an_image_has_one_user(void)
{
    eeprom_image_t other;
    TEST_ASSERT_EQUAL(STATUS_OK, open_image(&image));
    TEST_ASSERT_EQUAL(STATUS_BUSY, open_image(&other));
    TEST_ASSERT_EQUAL_INT(-1, osal_file_descriptor(&other.file));
    TEST_ASSERT_EQUAL_INT(-1, osal_file_descriptor(&other.reader));
    eeprom_image_close(&image);
    TEST_ASSERT_EQUAL(STATUS_OK, open_image(&image));
}

static void a_file_that_is_not_an_image_is_refused_and_kept(void)
{
    size_t size = 0U;
    write_whole(sizeof content, 0x5A);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, open_image(&image));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_load(path, content, sizeof content, &size));
    TEST_ASSERT_EQUAL(sizeof content, size);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, eeprom_image_open(&image, "/no/such/directory", "ARM"));
    char long_name[600];
    (void)memset(long_name, 'n', sizeof long_name);
    long_name[sizeof long_name - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, eeprom_image_open(&image, TEST_DIRECTORY, long_name));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_missing_image_is_made_blank);
    RUN_TEST(an_image_that_was_interrupted_is_completed);
    RUN_TEST(the_content_is_kept);
    RUN_TEST(an_image_has_one_user);
    RUN_TEST(a_file_that_is_not_an_image_is_refused_and_kept);
    return UNITY_END();
}
