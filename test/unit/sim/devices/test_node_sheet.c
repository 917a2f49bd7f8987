// SPDX-License-Identifier: Apache-2.0
// A node whose data sheet lacks what a device needs is refused before it is on its bus.
#include "sim/devices/eds.h"
#include "sim/devices/node.h"
#include "sim/devices/pdo.h"
#include "test/unit/sim/devices/master.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>

#define SHEET "descriptors/devices/joint-drive.eds"
#define COPY "build/test/node-with-another-sheet.eds"

static const node_application_t application;
static master_t master;
static char error[EDS_ERROR_MAX];

void setUp(void)
{
    master_open(&master, false);
}

void tearDown(void)
{
    master_close(&master);
}

/// Copy the data sheet. Sections that begin with `section` get the default `value`, or with null, an index
/// that CiA 301 reserves.
static void copy_sheet(const char* section, const char* value)
{
    char line[512];
    bool is_inside   = false;
    FILE* const from = fopen(SHEET, "r");
    FILE* const to   = fopen(COPY, "w");
    while (fgets(line, (int)sizeof line, from) != NULL) {
        is_inside = (line[0] == '[') ? (strncmp(&line[1], section, strlen(section)) == 0) : is_inside;
        if (is_inside && (value == NULL) && (line[0] == '[')) {
            line[1] = '0';
        }
        if (is_inside && (value != NULL) && (strncmp(line, "DefaultValue=", 13U) == 0)) {
            (void)snprintf(line, sizeof line, "DefaultValue=%s\n", value);
        }
        (void)fputs(line, to);
    }
    TEST_ASSERT_EQUAL_INT(0, fclose(from) + fclose(to));
}

static void expect_refusal(const char* words)
{
    node_t* none = NULL;
    TEST_ASSERT_EQUAL_INT(STATUS_INVALID, node_create(master.bus, COPY, 3U, &application, &none, error));
    TEST_ASSERT_NULL(none);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, words), error);
}

static void a_sheet_without_tpdos_is_refused(void)
{
    copy_sheet("180", NULL);
    expect_refusal(COPY ": a device needs objects 1001, 1005, 1014, 1017 and at least one TPDO");
}

/// The frames of the device would otherwise have another layout than its sheet states.
static void a_sheet_that_maps_what_a_device_cannot_transfer_is_refused(void)
{
    copy_sheet("1A00sub2]", "0x77770020"); // There is no such object.
    expect_refusal(COPY ": 1A00:02 maps");
    copy_sheet("1A00sub1]", "0x60410020"); // The object has 16 bits.
    expect_refusal(COPY ": 1A00:01 maps");
    copy_sheet("1A00sub1]", "0x00050008"); // A dummy entry, which only received PDOs may have.
    expect_refusal(COPY ": 1A00:01 maps");
    copy_sheet("1600sub1]", "0x00050010"); // The data type has 8 bits.
    expect_refusal(COPY ": 1600:01 maps");
    copy_sheet("1A01sub0]", "8"); // The sheet has fewer entries.
    expect_refusal(COPY ": 1A01:");
    copy_sheet("1A00sub3]", "0x60410010"); // A second time; all are used.
    node_t* node = NULL;
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, node_create(master.bus, COPY, 3U, &application, &node, error),
                                  error);
    node_destroy(node);
}

/// CiA 301: the octets of a dummy entry are skipped, so that two devices can use one frame.
static void a_dummy_entry_skips_octets_of_a_received_pdo(void)
{
    dictionary_t dictionary;
    pdo_t pdo;
    node_t* node = NULL;
    copy_sheet("1600sub1]", "0x00060010"); // UNSIGNED16
    TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_OK, node_create(master.bus, COPY, 3U, &application, &node, error),
                                  error);
    node_destroy(node);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, eds_load(COPY, 3U, &dictionary, error));
    TEST_ASSERT_TRUE(pdo_init(&pdo, PDO_RECEIVE, 0U, &dictionary));
    TEST_ASSERT_EQUAL_UINT8(0U, pdo_unusable_entry(&pdo));
    memcpy(pdo.data, (const uint8_t[]){1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U}, sizeof pdo.data);
    pdo_unpack(&pdo);
    TEST_ASSERT_EQUAL_HEX16(6U, pdo.entry[0]->index);
    TEST_ASSERT_EQUAL_HEX64(3U, pdo.entry[1]->value & 0xFFU);
    dictionary_destroy(&dictionary);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_sheet_without_tpdos_is_refused);
    RUN_TEST(a_sheet_that_maps_what_a_device_cannot_transfer_is_refused);
    RUN_TEST(a_dummy_entry_skips_octets_of_a_received_pdo);
    return UNITY_END();
}
