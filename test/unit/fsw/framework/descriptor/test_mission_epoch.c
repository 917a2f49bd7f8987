// SPDX-License-Identifier: Apache-2.0
// The epoch of a mission on the first and last day of each month, compared with the C library.
#define _GNU_SOURCE
#include "fsw/framework/descriptor/descriptor.h"
#include "osal/include/osal/file.h"
#include "test/unit/fsw/framework/descriptor/documents.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define FROM_1958_TO_1970_S 378691200

static descriptor_loader_t loader;
static subsystem_descriptor_t scratch;
static mission_descriptor_t mission;
static char directory[] = "/tmp/mission_epoch.XXXXXX";

static const char* path_of(const char* const name)
{
    static char path[64];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static void write_file(const char* const name, const char* const document)
{
    osal_file_t file;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_create(&file, path_of(name)));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_file_write(&file, document, strlen(document)));
    osal_file_close(&file);
}

void setUp(void)
{
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
    descriptor_loader_init(&loader);
    write_file("arm.xml", arm_document);
    write_file("hand.xml", hand_document);
}

void tearDown(void)
{
    (void)unlink(path_of("arm.xml"));
    (void)unlink(path_of("hand.xml"));
    (void)unlink(path_of("flight.xml"));
    TEST_ASSERT_EQUAL(0, rmdir(directory));
}

/// Load the mission with this epoch. If the month has no such day, it must be refused.
static void expect_epoch(const int year, const int month, const int day)
{
    struct tm time     = {.tm_year = year - 1900, .tm_mon = month - 1, .tm_mday = day};
    const time_t epoch = timegm(&time) + FROM_1958_TO_1970_S; // A day after the last one changes tm_mon.
    const bool is_day  = (time.tm_mon == (month - 1));
    char words[64];
    (void)snprintf(words, sizeof words, "%04d-%02d-%02dT00:00:00", year, month, day);
    write_file("flight.xml", damaged(flight_document, "2026-06-01T12:00:00", words));
    const status_t status = descriptor_load_mission(&loader, path_of("flight.xml"), MISSION_ANY_TARGET,
                                                    &descriptor_mission_whole, &mission, &scratch);
    TEST_ASSERT_EQUAL_MESSAGE(is_day ? STATUS_OK : STATUS_INVALID, status, words);
    if (is_day) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE((uint32_t)epoch, mission.epoch_s, words);
    }
}

static void each_month_has_its_days(void)
{
    for (int year = 2027; year <= 2028; year++) { // 2028 is a leap year.
        for (int month = 1; month <= 12; month++) {
            expect_epoch(year, month, 1);
            for (int day = 28; day <= 32; day++) {
                expect_epoch(year, month, day);
            }
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_month_has_its_days);
    return UNITY_END();
}
