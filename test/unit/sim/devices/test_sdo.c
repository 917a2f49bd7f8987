// SPDX-License-Identifier: Apache-2.0
// The SDO server, octet by octet: expedited and segmented in both directions, every abort, and random
// requests.
#include "sim/devices/sdo.h"
#include "unity.h"

#include <string.h>

#define OBJECTS 10U

static object_t objects[OBJECTS];
static uint8_t texts[2][OBJECT_TEXT_MAX];
static dictionary_t dictionary = {.objects = objects, .count = OBJECTS};
static sdo_server_t server;
static uint8_t reply[SDO_OCTETS];
static uint32_t check_answer;
static unsigned writes;
static unsigned reads;

static uint32_t check(void* context, const object_t* object, int64_t value)
{
    (void)context;
    (void)object;
    (void)value;
    return check_answer;
}

static void written(void* context, object_t* object)
{
    (void)context;
    (void)object;
    writes++;
}

static void about_to_read(void* context, object_t* object)
{
    (void)context;
    (void)object;
    reads++;
}

static const sdo_access_t device = {.check = check, .written = written, .read = about_to_read};

static object_t number(uint16_t index, uint8_t subindex, object_type_t type, uint64_t value)
{
    return (object_t){.index       = index,
                      .subindex    = subindex,
                      .type        = type,
                      .size        = object_type_size(type),
                      .is_readable = true,
                      .is_writable = true,
                      .value       = value};
}

void setUp(void)
{
    sdo_server_reset(&server);
    check_answer           = 0U;
    writes                 = 0U;
    reads                  = 0U;
    objects[0]             = number(0x1000U, 0U, OBJECT_UNSIGNED32, 0x00020192U);
    objects[1]             = number(0x1017U, 0U, OBJECT_UNSIGNED16, 20U);
    objects[2]             = number(0x2000U, 0U, OBJECT_UNSIGNED64, 0x1122334455667788U);
    objects[3]             = number(0x2001U, 1U, OBJECT_INTEGER8, 0xFFU);
    objects[4]             = number(0x2002U, 0U, OBJECT_VISIBLE_STRING, 0U);
    objects[5]             = number(0x2003U, 0U, OBJECT_OCTET_STRING, 0U);
    objects[6]             = number(0x2004U, 0U, OBJECT_BOOLEAN, 0U);
    objects[7]             = number(0x2005U, 0U, OBJECT_INTEGER16, 0U);
    objects[8]             = number(0x2006U, 0U, OBJECT_REAL32, 0U);
    objects[9]             = number(0x2007U, 0U, OBJECT_REAL64, 0U);
    objects[8].has_low     = true;
    objects[8].real_low    = -0.5;
    objects[8].has_high    = true;
    objects[8].real_high   = 2.0;
    objects[0].is_writable = false;
    objects[6].is_readable = false;
    objects[7].has_low     = true;
    objects[7].low         = -10;
    objects[7].has_high    = true;
    objects[7].high        = 10;
    objects[4].text        = texts[0];
    objects[5].text        = texts[1];
    memcpy(texts[0], "a name of 20 letters", 20U);
    objects[4].size = 20U;
    objects[5].size = 0U;
}

void tearDown(void)
{
}

static bool ask(const char* octets)
{
    uint8_t request[SDO_OCTETS];
    memset(reply, 0xEE, sizeof reply);
    for (unsigned i = 0U; i < SDO_OCTETS; i++) {
        unsigned value = 0U;
        for (unsigned k = 0U; k < 2U; k++) {
            const char digit = octets[(3U * i) + k];
            value = (value * 16U) + (unsigned)((digit <= '9') ? (digit - '0') : (digit - 'A' + 10));
        }
        request[i] = (uint8_t)value;
    }
    return sdo_server_request(&server, &dictionary, &device, request, reply);
}

static void expect(const char* request, const char* wanted)
{
    char got[24];
    static const char digits[] = "0123456789ABCDEF";
    TEST_ASSERT_TRUE(ask(request));
    for (unsigned i = 0U; i < SDO_OCTETS; i++) {
        got[3U * i]        = digits[reply[i] >> 4];
        got[(3U * i) + 1U] = digits[reply[i] & 15U];
        got[(3U * i) + 2U] = (i == 7U) ? '\0' : ' ';
    }
    TEST_ASSERT_EQUAL_STRING(wanted, got);
}

static void an_expedited_upload_returns_the_value(void)
{
    expect("40 00 10 00 00 00 00 00", "43 00 10 00 92 01 02 00");
    expect("40 17 10 00 00 00 00 00", "4B 17 10 00 14 00 00 00");
    expect("40 01 20 01 00 00 00 00", "4F 01 20 01 FF 00 00 00");
    TEST_ASSERT_EQUAL_UINT(3U, reads);
}

static void an_expedited_download_stores_the_value(void)
{
    expect("2B 17 10 00 64 00 00 00", "60 17 10 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(100U, objects[1].value);
    expect("22 17 10 00 32 00 00 00", "60 17 10 00 00 00 00 00"); // The server uses the size of the object.
    TEST_ASSERT_EQUAL_UINT64(50U, objects[1].value);
    expect("2F 01 20 01 80 00 00 00", "60 01 20 01 00 00 00 00");
    TEST_ASSERT_EQUAL_INT64(-128, object_signed(&objects[3]));
    TEST_ASSERT_EQUAL_UINT(3U, writes);
}

static void a_segmented_upload_returns_the_value(void)
{
    expect("40 02 20 00 00 00 00 00", "41 02 20 00 14 00 00 00");
    expect("60 00 00 00 00 00 00 00", "00 61 20 6E 61 6D 65 20");
    expect("70 00 00 00 00 00 00 00", "10 6F 66 20 32 30 20 6C");
    expect("60 00 00 00 00 00 00 00", "03 65 74 74 65 72 73 00");
    expect("40 00 20 00 00 00 00 00", "41 00 20 00 08 00 00 00");
    expect("60 00 00 00 00 00 00 00", "00 88 77 66 55 44 33 22");
    expect("70 00 00 00 00 00 00 00", "1D 11 00 00 00 00 00 00");
    expect("40 03 20 00 00 00 00 00", "41 03 20 00 00 00 00 00"); // Empty string: one empty segment.
    expect("60 00 00 00 00 00 00 00", "0F 00 00 00 00 00 00 00");
}

static void a_segmented_download_stores_the_value(void)
{
    expect("21 02 20 00 0A 00 00 00", "60 02 20 00 00 00 00 00");
    expect("00 30 31 32 33 34 35 36", "20 00 00 00 00 00 00 00");
    expect("19 37 38 39 00 00 00 00", "30 00 00 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT8(10U, objects[4].size);
    TEST_ASSERT_EQUAL_MEMORY("0123456789", texts[0], 10U);
    expect("20 00 20 00 00 00 00 00", "60 00 20 00 00 00 00 00"); // Size not announced.
    expect("00 01 02 03 04 05 06 07", "20 00 00 00 00 00 00 00");
    expect("1D 08 00 00 00 00 00 00", "30 00 00 00 00 00 00 00");
    TEST_ASSERT_EQUAL_HEX64(0x0807060504030201U, objects[2].value);
    TEST_ASSERT_EQUAL_UINT(2U, writes);
}

static void bad_accesses_are_aborted_with_their_code(void)
{
    expect("40 00 30 00 00 00 00 00", "80 00 30 00 00 00 02 06"); // No such object.
    expect("40 17 10 05 00 00 00 00", "80 17 10 05 11 00 09 06"); // No such sub-index.
    expect("23 00 10 00 00 00 00 00", "80 00 10 00 02 00 01 06"); // Read only.
    expect("40 04 20 00 00 00 00 00", "80 04 20 00 01 00 01 06"); // Write only.
    expect("23 17 10 00 00 00 00 00", "80 17 10 00 12 00 07 06"); // Too long.
    expect("2F 17 10 00 00 00 00 00", "80 17 10 00 13 00 07 06"); // Too short.
    expect("2B 05 20 00 0B 00 00 00", "80 05 20 00 31 00 09 06"); // Too high.
    expect("2B 05 20 00 F5 FF 00 00", "80 05 20 00 32 00 09 06"); // Too low.
    expect("2F 04 20 00 02 00 00 00", "80 04 20 00 30 00 09 06"); // Not a boolean.
    check_answer = SDO_ABORT_STATE;
    expect("2B 17 10 00 64 00 00 00", "80 17 10 00 22 00 00 08");
    TEST_ASSERT_EQUAL_UINT64(20U, objects[1].value);
    TEST_ASSERT_EQUAL_UINT(0U, writes);
}

static void real_numbers_are_written_and_read(void)
{
    expect("23 06 20 00 00 00 00 BF", "60 06 20 00 00 00 00 00"); // -0.5.
    TEST_ASSERT_TRUE(object_real(&objects[8]) == -0.5);
    expect("40 06 20 00 00 00 00 00", "43 06 20 00 00 00 00 BF");
    expect("21 07 20 00 08 00 00 00", "60 07 20 00 00 00 00 00");
    expect("00 9A 99 99 99 99 99 B9", "20 00 00 00 00 00 00 00"); // 0.1.
    expect("1D 3F 00 00 00 00 00 00", "30 00 00 00 00 00 00 00");
    TEST_ASSERT_TRUE(object_real(&objects[9]) == 0.1);
    expect("23 06 20 00 01 00 00 40", "80 06 20 00 31 00 09 06"); // Above 2: too high.
    expect("23 06 20 00 01 00 00 BF", "80 06 20 00 32 00 09 06"); // Below -0.5: too low.
    expect("23 06 20 00 00 00 C0 7F", "80 06 20 00 30 00 09 06"); // NaN: no value of a parameter.
    expect("23 06 20 00 00 00 80 FF", "80 06 20 00 30 00 09 06"); // Infinite.
    expect("2B 06 20 00 00 00 00 00", "80 06 20 00 13 00 07 06"); // Too short.
    check_answer = SDO_ABORT_STATE;
    expect("23 06 20 00 00 00 00 00", "80 06 20 00 22 00 00 08");
    TEST_ASSERT_TRUE(object_real(&objects[8]) == -0.5);
}

/// The storage of a REAL32 beyond its range is infinite, of either sign.
static void a_real_is_stored_bit_by_bit(void)
{
    static const struct {
        double value;
        uint64_t single;
        uint64_t whole;
    } cases[] = {{-2.5, 0xC0200000U, 0xC004000000000000U},
                 {1e39, 0x7F800000U, 0x48078287F49C4A1DU},
                 {-1e39, 0xFF800000U, 0xC8078287F49C4A1DU}};
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        object_set_real(&objects[8], cases[i].value);
        object_set_real(&objects[9], cases[i].value);
        TEST_ASSERT_EQUAL_HEX64(cases[i].single, objects[8].value);
        TEST_ASSERT_EQUAL_HEX64(cases[i].whole, objects[9].value);
    }
    TEST_ASSERT_FALSE(object_is_signed(&objects[8]));
    TEST_ASSERT_FALSE(object_is_signed(&objects[9]));
}

static void bad_segments_are_aborted_with_their_code(void)
{
    expect("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"); // No transfer runs.
    expect("00 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
    expect("40 02 20 00 00 00 00 00", "41 02 20 00 14 00 00 00");
    expect("70 00 00 00 00 00 00 00", "80 02 20 00 00 00 03 05"); // Toggle bit.
    expect("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"); // The abort has ended the transfer.
    expect("40 02 20 00 00 00 00 00", "41 02 20 00 14 00 00 00");
    expect("00 00 00 00 00 00 00 00", "80 02 20 00 01 00 04 05"); // Segment of the other direction.
    expect("21 02 20 00 41 00 00 00", "80 02 20 00 12 00 07 06"); // 65 octets announced.
    expect("21 17 10 00 03 00 00 00", "80 17 10 00 12 00 07 06"); // 3 octets announced for an object of 2.
    expect("21 02 20 00 05 00 00 00", "60 02 20 00 00 00 00 00");
    expect("01 30 31 32 33 34 35 36", "80 02 20 00 10 00 07 06"); // 7 octets received, 5 announced.
}

static void a_download_longer_than_any_object_is_aborted(void)
{
    expect("20 02 20 00 00 00 00 00", "60 02 20 00 00 00 00 00");
    for (unsigned i = 0U; i < 9U; i++) {
        TEST_ASSERT_TRUE(ask(((i % 2U) == 0U) ? "00 41 41 41 41 41 41 41" : "10 41 41 41 41 41 41 41"));
        TEST_ASSERT_EQUAL_HEX8(0x20U | ((i % 2U) << 4), reply[0]);
    }
    expect("10 41 41 41 41 41 41 41", "80 02 20 00 12 00 07 06"); // 70 octets.
}

static void block_transfer_is_refused(void)
{
    expect("C2 02 20 00 00 00 00 00", "80 02 20 00 01 00 04 05");
    expect("A0 02 20 00 10 00 00 00", "80 02 20 00 01 00 04 05");
    expect("E0 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
}

static void an_abort_of_the_client_ends_the_transfer_without_a_response(void)
{
    expect("40 02 20 00 00 00 00 00", "41 02 20 00 14 00 00 00");
    TEST_ASSERT_FALSE(ask("80 02 20 00 00 00 04 05"));
    expect("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
}

static void a_new_request_replaces_a_running_transfer(void)
{
    expect("40 02 20 00 00 00 00 00", "41 02 20 00 14 00 00 00");
    expect("40 17 10 00 00 00 00 00", "4B 17 10 00 14 00 00 00");
    expect("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
}

static void random_requests_leave_the_server_working(void)
{
    uint32_t random = 5U;
    for (unsigned i = 0U; i < 500000U; i++) {
        uint8_t request[SDO_OCTETS];
        for (unsigned k = 0U; k < SDO_OCTETS; k++) {
            random     = (random * 1664525U) + 1013904223U;
            request[k] = (uint8_t)(random >> 24);
        }
        if ((random & 0x300U) != 0U) { // Mostly existing objects.
            const object_t* object = &objects[(random >> 10) % OBJECTS];
            request[1]             = (uint8_t)object->index;
            request[2]             = (uint8_t)(object->index >> 8);
            request[3]             = object->subindex;
        }
        (void)sdo_server_request(&server, &dictionary, &device, request, reply);
        TEST_ASSERT_LESS_OR_EQUAL_UINT(OBJECT_TEXT_MAX, objects[4].size);
        TEST_ASSERT_EQUAL_UINT8(4U, objects[0].size);
    }
    TEST_ASSERT_EQUAL_HEX64(0x00020192U, objects[0].value);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_expedited_upload_returns_the_value);
    RUN_TEST(an_expedited_download_stores_the_value);
    RUN_TEST(a_segmented_upload_returns_the_value);
    RUN_TEST(a_segmented_download_stores_the_value);
    RUN_TEST(bad_accesses_are_aborted_with_their_code);
    RUN_TEST(real_numbers_are_written_and_read);
    RUN_TEST(a_real_is_stored_bit_by_bit);
    RUN_TEST(bad_segments_are_aborted_with_their_code);
    RUN_TEST(a_download_longer_than_any_object_is_aborted);
    RUN_TEST(block_transfer_is_refused);
    RUN_TEST(an_abort_of_the_client_ends_the_transfer_without_a_response);
    RUN_TEST(a_new_request_replaces_a_running_transfer);
    RUN_TEST(random_requests_leave_the_server_working);
    return UNITY_END();
}
