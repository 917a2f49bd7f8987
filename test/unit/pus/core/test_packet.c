// SPDX-License-Identifier: Apache-2.0
// Encoding and decoding of space packets, their time code, and the division of a stream into packets.
#include "pus/core/packet.h"

#include "base/crc.h"
#include "unity.h"

#include <string.h>

// TC[17,1] of APID 100, sequence 25, all acknowledgements, source 1; composed by an independent
// implementation.
static const uint8_t golden_tc[13] = {0x18, 0x64, 0xC0, 0x19, 0x00, 0x06, 0x2F,
                                      0x11, 0x01, 0x00, 0x01, 0xEB, 0xE6};

void setUp(void)
{
}

void tearDown(void)
{
}

/// Write the correct checksum at the end.
static void sign(uint8_t* const packet, const size_t size)
{
    const uint16_t crc = crc16_ccitt(packet, size - 2U);
    packet[size - 2U]  = (uint8_t)(crc >> 8U);
    packet[size - 1U]  = (uint8_t)(crc & 0xFFU);
}

static void a_golden_request_is_decoded_and_encoded(void)
{
    pus_tc_t tc;
    pus_failure_t failure;
    uint8_t octets[64];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(golden_tc, sizeof golden_tc, &tc, &failure));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_NONE, failure.code);
    TEST_ASSERT_EQUAL_UINT32(0U, failure.detail);
    TEST_ASSERT_EQUAL_UINT16(100U, tc.apid);
    TEST_ASSERT_EQUAL_UINT16(25U, tc.sequence);
    TEST_ASSERT_EQUAL_HEX8(0xFU, tc.ack);
    TEST_ASSERT_EQUAL_UINT8(17U, tc.service);
    TEST_ASSERT_EQUAL_UINT8(1U, tc.subtype);
    TEST_ASSERT_EQUAL_UINT16(1U, tc.source);
    TEST_ASSERT_EQUAL_HEX32(0x1864C019U, tc.request_id);
    TEST_ASSERT_EQUAL_UINT64(0U, tc.size);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(sizeof golden_tc, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(golden_tc, octets, size);
}

static void a_packet_nested_in_a_request_is_kept_unchanged(void)
{
    // TC[11,4] of the same source: sub-schedule 1, one activity whose time has another code, with the request
    // above in it.
    static const uint8_t golden[36] = {0x18, 0x64, 0xC0, 0x48, 0x00, 0x1D, 0x2F, 0x0B, 0x04,
                                       0x00, 0x01, 0x01, 0x01, 0x2F, 0x00, 0x00, 0x00, 0x2A,
                                       0x80, 0x00, 0x00, 0x18, 0x64, 0xC0, 0x19, 0x00, 0x06,
                                       0x2F, 0x11, 0x01, 0x00, 0x01, 0xEB, 0xE6, 0x05, 0x9C};
    pus_tc_t tc;
    pus_failure_t failure;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(golden, sizeof golden, &tc, &failure));
    TEST_ASSERT_EQUAL_UINT8(11U, tc.service);
    TEST_ASSERT_EQUAL_UINT64(23U, tc.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(golden_tc, &tc.data[10], sizeof golden_tc);
}

static void a_report_with_the_time_of_the_mission_is_decoded(void)
{
    // The golden TM[17,2] of 42.5 s, with the P-field of the epoch 1958.
    uint8_t packet[23] = {0x08, 0x64, 0xC0, 0x02, 0x00, 0x10, 0x20, 0x11, 0x02, 0x00, 0x02, 0x00,
                          0x01, 0x1F, 0x00, 0x00, 0x00, 0x2A, 0x80, 0x00, 0x00, 0x00, 0x00};
    pus_tm_t tm;
    pus_failure_t failure;
    uint8_t octets[64];
    size_t size = 0U;
    sign(packet, sizeof packet);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, sizeof packet, &tm, &failure));
    TEST_ASSERT_EQUAL_UINT16(2U, tm.counter);
    TEST_ASSERT_EQUAL_UINT16(1U, tm.destination);
    TEST_ASSERT_EQUAL_UINT64(42500000000ULL, tm.time_ns);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_encode(&tm, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL_UINT64(sizeof packet, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(packet, octets, size);

    packet[13] = 0x2FU; // The golden packet itself has the agency epoch, not the epoch of this mission.
    sign(packet, sizeof packet);
    TEST_ASSERT_EQUAL_HEX8(0xE2U, packet[21]);
    TEST_ASSERT_EQUAL_HEX8(0x9DU, packet[22]);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tm_decode(packet, sizeof packet, &tm, &failure));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_DATA, failure.code);
    TEST_ASSERT_EQUAL_UINT32(13U, failure.detail);
    packet[6] = 0x10U; // The PUS version is wrong as well: the first wrong field is reported.
    sign(packet, sizeof packet);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tm_decode(packet, sizeof packet, &tm, &failure));
    TEST_ASSERT_NOT_EQUAL(PUS_FAILURE_DATA, failure.code);
}

/// Expect this failure for the golden request with `value` at octet `offset` and a correct checksum.
static void expect_header_failure(const size_t offset, const uint8_t value, const uint16_t code,
                                  const uint32_t detail)
{
    uint8_t packet[sizeof golden_tc];
    pus_tc_t tc;
    pus_failure_t failure;
    memcpy(packet, golden_tc, sizeof packet);
    packet[offset] = value;
    sign(packet, sizeof packet);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tc_decode(packet, sizeof packet, &tc, &failure));
    TEST_ASSERT_EQUAL_HEX16(code, failure.code);
    TEST_ASSERT_EQUAL_UINT16(0U, failure.instruction);
    TEST_ASSERT_EQUAL_HEX32(detail, failure.detail);
    TEST_ASSERT_EQUAL_UINT16(1U, tc.source); // The header is complete, so that the failure can be reported.
    TEST_ASSERT_EQUAL_UINT8(17U, tc.service);
    TEST_ASSERT_NULL(tc.data);
}

static void each_wrong_header_field_has_its_own_failure(void)
{
    for (unsigned version = 1U; version < 8U; version++) {
        expect_header_failure(0U, (uint8_t)(0x18U | (version << 5U)), PUS_FAILURE_PACKET_VERSION, version);
    }
    expect_header_failure(0U, 0x08U, PUS_FAILURE_PACKET_TYPE, 0U);
    expect_header_failure(0U, 0x10U, PUS_FAILURE_SECONDARY_HEADER, 0U);
    for (unsigned flags = 0U; flags < 3U; flags++) {
        expect_header_failure(2U, (uint8_t)(flags << 6U), PUS_FAILURE_SEQUENCE_FLAGS, flags);
    }
    for (unsigned version = 0U; version < 16U; version++) {
        if (version != 2U) {
            expect_header_failure(6U, (uint8_t)((version << 4U) | 0xFU), PUS_FAILURE_PUS_VERSION, version);
        }
    }
    expect_header_failure(5U, 7U, PUS_FAILURE_LENGTH, 13U);
    expect_header_failure(5U, 5U, PUS_FAILURE_LENGTH, 13U);
    expect_header_failure(4U, 1U, PUS_FAILURE_LENGTH, 13U);
}

static void every_single_bit_error_is_detected(void)
{
    for (size_t bit = 0U; bit < (8U * sizeof golden_tc); bit++) {
        uint8_t packet[sizeof golden_tc];
        pus_tc_t tc;
        pus_failure_t failure;
        memcpy(packet, golden_tc, sizeof packet);
        packet[bit / 8U]      = (uint8_t)(packet[bit / 8U] ^ (1U << (bit % 8U)));
        const bool is_length  = (bit / 8U == 4U) || (bit / 8U == 5U);
        const status_t status = pus_tc_decode(packet, sizeof packet, &tc, &failure);
        TEST_ASSERT_EQUAL(is_length ? STATUS_INVALID : STATUS_CHECKSUM, status);
        TEST_ASSERT_EQUAL_HEX16(is_length ? PUS_FAILURE_LENGTH : PUS_FAILURE_CHECKSUM, failure.code);
        if (!is_length) {
            TEST_ASSERT_EQUAL_HEX32(crc16_ccitt(packet, 11U), failure.detail);
        }
    }
}

static void every_truncated_size_is_refused(void)
{
    for (size_t size = 0U; size < sizeof golden_tc; size++) {
        pus_tc_t tc;
        pus_tm_t tm;
        pus_failure_t failure;
        uint8_t packet[sizeof golden_tc];
        memcpy(packet, golden_tc, size);
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, pus_tc_decode(packet, size, &tc, &failure));
        TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_LENGTH, failure.code);
        TEST_ASSERT_EQUAL_UINT32(size, failure.detail);
        TEST_ASSERT_EQUAL_HEX32((size >= 4U) ? 0x1864C019U : (size >= 2U) ? 0x18640000U : 0U, tc.request_id);
        TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, tc.source);
        TEST_ASSERT_NULL(tc.data);
        TEST_ASSERT_EQUAL_UINT64(0U, tc.size);
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, pus_tm_decode(packet, size, &tm, &failure));
    }
}

/// The octets at the position of the source id are then those of the checksum.
static void a_request_without_room_for_a_source_has_none(void)
{
    for (size_t size = PUS_TC_HEADER_SIZE; size < PUS_TC_MIN; size++) {
        pus_tc_t tc;
        pus_failure_t failure;
        uint8_t packet[sizeof golden_tc];
        memcpy(packet, golden_tc, size);
        packet[5] = (uint8_t)(size - 7U);
        sign(packet, size);
        TEST_ASSERT_NOT_EQUAL(0U, octets_u16_at(&packet[9]));
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, pus_tc_decode(packet, size, &tc, &failure));
        TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_LENGTH, failure.code);
        TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, tc.source);
        TEST_ASSERT_EQUAL_HEX32(0x1864C019U, tc.request_id);
    }
    uint8_t packet[sizeof golden_tc]; // The length field is too small, but the request is long enough.
    memcpy(packet, golden_tc, sizeof packet);
    packet[5] = 4U;
    pus_tc_t tc;
    pus_failure_t failure;
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tc_decode(packet, sizeof packet, &tc, &failure));
    TEST_ASSERT_EQUAL_UINT16(1U, tc.source);
}

static void the_largest_packet_passes_and_the_next_does_not(void)
{
    static uint8_t data[PUS_TC_DATA_MAX + 1U];
    static uint8_t packet[PUS_PACKET_MAX + 16U];
    size_t size = 0U;
    pus_tc_t tc = {.apid = 1U, .service = 1U, .subtype = 1U, .data = data, .size = PUS_TC_DATA_MAX};
    pus_tm_t tm = {.apid = 1U, .service = 1U, .subtype = 1U, .data = data, .size = PUS_TM_DATA_MAX};
    pus_failure_t failure;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, sizeof packet, &size));
    TEST_ASSERT_EQUAL_UINT64(PUS_PACKET_MAX, size);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(packet, size, &tc, &failure));
    TEST_ASSERT_EQUAL_UINT64(PUS_TC_DATA_MAX, tc.size);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_encode(&tm, packet, sizeof packet, &size));
    TEST_ASSERT_EQUAL_UINT64(PUS_PACKET_MAX, size);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, size, &tm, &failure));

    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tc_encode(&tc, packet, PUS_PACKET_MAX - 1U, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    // There is not enough room for the headers.
    for (size_t capacity = 0U; capacity < PUS_TC_MIN; capacity++) {
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tc_encode(&tc, packet, capacity, &size));
        TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tm_encode(&tm, packet, capacity, &size));
        TEST_ASSERT_EQUAL_UINT64(0U, size);
    }
    tc.size = PUS_TC_DATA_MAX + 1U;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tc_encode(&tc, packet, sizeof packet, &size));
    tm.size = PUS_TM_DATA_MAX + 1U;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tm_encode(&tm, packet, sizeof packet, &size));
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tc_decode(packet, PUS_PACKET_MAX + 1U, &tc, &failure));
    TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_LENGTH, failure.code);
}

static void a_stream_is_framed_by_its_length_fields(void)
{
    size_t size = 99U;
    for (size_t have = 0U; have < sizeof golden_tc; have++) {
        TEST_ASSERT_EQUAL(STATUS_TRUNCATED, pus_packet_frame(golden_tc, have, &size));
        TEST_ASSERT_EQUAL_UINT64((have < 6U) ? 0U : 13U, size);
    }
    uint8_t stream[64] = {0};
    memcpy(stream, golden_tc, sizeof golden_tc);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_frame(stream, sizeof stream, &size));
    TEST_ASSERT_EQUAL_UINT64(13U, size);
    stream[4] = 0x0FU; // 4095 + 7
    stream[5] = 0xFFU;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_packet_frame(stream, sizeof stream, &size));
    stream[5] = 0xF9U; // 4089 + 7 = 4096
    TEST_ASSERT_EQUAL(STATUS_TRUNCATED, pus_packet_frame(stream, sizeof stream, &size));
    TEST_ASSERT_EQUAL_UINT64(PUS_PACKET_MAX, size);
    TEST_ASSERT_TRUE(pus_packet_is_tc(golden_tc, 1U));
    TEST_ASSERT_FALSE(pus_packet_is_tc(golden_tc, 0U));
    TEST_ASSERT_FALSE(pus_packet_is_tc((const uint8_t*)"\x08", 1U));
}

static void time_is_seconds_and_a_rounded_down_fraction(void)
{
    static const struct {
        uint64_t time_ns;
        uint8_t octets[8];
    } cases[] = {
        {0U, {0x1F, 0, 0, 0, 0, 0, 0, 0}},
        {42500000000ULL, {0x1F, 0, 0, 0, 0x2A, 0x80, 0, 0}},
        {59U, {0x1F, 0, 0, 0, 0, 0, 0, 0}}, // One unit is 59.6 ns.
        {60U, {0x1F, 0, 0, 0, 0, 0, 0, 1}},
        {999999999U, {0x1F, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF}},
        {4294967295999999999ULL, {0x1F, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}},
        {4294967296000000000ULL, {0x1F, 0, 0, 0, 0, 0, 0, 0}},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        uint8_t octets[8];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        pus_time_write(&writer, cases[i].time_ns);
        TEST_ASSERT_FALSE(writer.failed);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].octets, octets, 8U);
    }
}

static void a_time_changes_by_less_than_one_unit_when_encoded_and_then_no_more(void)
{
    uint64_t previous = 0U;
    for (uint64_t time_ns = 0U; time_ns < 2000000000U; time_ns += 499979U) {
        uint8_t octets[8];
        uint64_t read         = 0U;
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        pus_time_write(&writer, time_ns);
        octet_reader_t reader = octet_reader(octets, sizeof octets);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_time_read(&reader, &read));
        TEST_ASSERT_TRUE((read <= time_ns) && ((time_ns - read) < 60U));
        TEST_ASSERT_TRUE((read > previous) || (time_ns == 0U));
        previous = read;
        uint8_t again[8];
        writer = octet_writer(again, sizeof again);
        pus_time_write(&writer, read);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(octets, again, sizeof again);
    }
}

static void only_the_time_code_of_the_mission_is_read(void)
{
    for (unsigned p_field = 0U; p_field < 256U; p_field++) {
        const uint8_t octets[8] = {(uint8_t)p_field, 1, 2, 3, 4, 5, 6, 7};
        uint64_t time_ns        = 1U;
        octet_reader_t reader   = octet_reader(octets, sizeof octets);
        TEST_ASSERT_EQUAL((p_field == 0x1FU) ? STATUS_OK : STATUS_INVALID, pus_time_read(&reader, &time_ns));
        for (size_t size = 0U; size < 8U; size++) {
            reader = octet_reader(octets, size);
            TEST_ASSERT_EQUAL(STATUS_TRUNCATED, pus_time_read(&reader, &time_ns));
            TEST_ASSERT_EQUAL_UINT64(0U, time_ns);
        }
    }
}

static void acknowledgement_flags_have_the_bits_of_the_standard(void)
{
    TEST_ASSERT_EQUAL_HEX8(0x1U, PUS_ACK_ACCEPTANCE);
    TEST_ASSERT_EQUAL_HEX8(0x2U, PUS_ACK_START);
    TEST_ASSERT_EQUAL_HEX8(0x4U, PUS_ACK_PROGRESS);
    TEST_ASSERT_EQUAL_HEX8(0x8U, PUS_ACK_COMPLETION);
    // Acceptance only, composed by an independent implementation: 0x21 in the seventh octet.
    static const uint8_t golden[13] = {0x18, 0x64, 0xC0, 0x19, 0x00, 0x06, 0x21,
                                       0x11, 0x01, 0x00, 0x01, 0x24, 0x4E};
    pus_tc_t tc;
    pus_failure_t failure;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(golden, sizeof golden, &tc, &failure));
    TEST_ASSERT_EQUAL_HEX8(PUS_ACK_ACCEPTANCE, tc.ack);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_golden_request_is_decoded_and_encoded);
    RUN_TEST(a_packet_nested_in_a_request_is_kept_unchanged);
    RUN_TEST(a_report_with_the_time_of_the_mission_is_decoded);
    RUN_TEST(each_wrong_header_field_has_its_own_failure);
    RUN_TEST(every_single_bit_error_is_detected);
    RUN_TEST(every_truncated_size_is_refused);
    RUN_TEST(a_request_without_room_for_a_source_has_none);
    RUN_TEST(the_largest_packet_passes_and_the_next_does_not);
    RUN_TEST(a_stream_is_framed_by_its_length_fields);
    RUN_TEST(time_is_seconds_and_a_rounded_down_fraction);
    RUN_TEST(a_time_changes_by_less_than_one_unit_when_encoded_and_then_no_more);
    RUN_TEST(only_the_time_code_of_the_mission_is_read);
    RUN_TEST(acknowledgement_flags_have_the_bits_of_the_standard);
    return UNITY_END();
}
