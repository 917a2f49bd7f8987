// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/reports.h"

#include "fsw/framework/base/crc.h"
#include "pus/st01_verification.h"
#include "unity.h"

#include <string.h>

bench_t bench;

static status_t keep(void* const context, const uint8_t* const packet, const size_t size)
{
    bench_t* const self = context;
    if ((self->accepts > 0U) && (self->count >= self->accepts)) {
        return STATUS_FULL;
    }
    if (self->refusals > 0U) {
        self->refusals--;
        return STATUS_FULL;
    }
    TEST_ASSERT_TRUE(self->count < REPORTS_MAX);
    TEST_ASSERT_TRUE(size <= PUS_PACKET_MAX);
    memcpy(self->packets[self->count], packet, size);
    self->sizes[self->count] = size;
    self->count++;
    return STATUS_OK;
}

pus_port_t bench_port(void)
{
    return (pus_port_t){.context = &bench, .send = keep};
}

void bench_start(void)
{
    const pus_port_t port = bench_port();
    memset(&bench, 0, sizeof(bench));
    bench.ack    = PUS_ACK_ALL;
    bench.source = TEST_SOURCE;
    pus_process_init(&bench.process, TEST_APID, TEST_EPOCH_S, &port);
    pus_process_keep(&bench.process, &bench.rings);
    pus_dispatcher_init(&bench.dispatcher, &bench.process, bench.services, 1U);
}

void bench_serve(const pus_service_t service)
{
    bench.services[0] = service;
}

void bench_clear(void)
{
    bench.count = 0U;
}

status_t bench_request(const uint8_t subtype, const void* const data, const size_t size)
{
    uint8_t octets[PUS_PACKET_MAX];
    size_t packet_size = 0U;
    const pus_tc_t tc  = {.apid     = TEST_APID,
                          .sequence = bench.sequence,
                          .ack      = bench.ack,
                          .service  = bench.services[0].type,
                          .subtype  = subtype,
                          .source   = bench.source,
                          .data     = data,
                          .size     = size};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, octets, sizeof(octets), &packet_size));
    bench.request_id = (0x18000000U | (TEST_APID << 16U)) | 0xC000U | bench.sequence;
    bench.sequence   = (uint16_t)((bench.sequence + 1U) % PUS_SEQUENCE_COUNT);
    return pus_dispatch(&bench.dispatcher, octets, packet_size, TEST_NOW_NS);
}

status_t bench_request_large(const uint8_t subtype, const void* const data, const size_t size)
{
    static uint8_t octets[PUS_LARGE_MAX];
    const size_t packet_size = PUS_TC_MIN + size;
    TEST_ASSERT_TRUE(packet_size <= sizeof octets);
    bench.request_id      = (0x18000000U | (TEST_APID << 16U)) | 0xC000U | bench.sequence;
    bench.sequence        = (uint16_t)((bench.sequence + 1U) % PUS_SEQUENCE_COUNT);
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u32(&writer, bench.request_id);
    octet_write_u16(&writer, (uint16_t)(packet_size - 7U));
    octet_write_u8(&writer, (uint8_t)((PUS_VERSION << 4U) | bench.ack));
    octet_write_u8(&writer, bench.services[0].type);
    octet_write_u8(&writer, subtype);
    octet_write_u16(&writer, TEST_SOURCE);
    octet_write_octets(&writer, data, size);
    octet_write_u16(&writer, crc16_ccitt(octets, writer.position));
    return pus_dispatch_large(&bench.dispatcher, octets, packet_size, TEST_NOW_NS);
}

pus_tm_t bench_report(const size_t index)
{
    pus_tm_t tm;
    pus_failure_t failure;
    TEST_ASSERT_TRUE(index < bench.count);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(bench.packets[index], bench.sizes[index], &tm, &failure));
    TEST_ASSERT_EQUAL_UINT16(TEST_APID, tm.apid);
    return tm;
}

octet_reader_t bench_data(const size_t index)
{
    const pus_tm_t tm = bench_report(index);
    return octet_reader(tm.data, tm.size);
}

void expect_messages(const uint8_t* pairs)
{
    size_t index = 0U;
    for (; pairs[0] != 0U; pairs += 2) {
        char place[32] = "report 000";
        place[7]       = (char)('0' + ((index / 100U) % 10U));
        place[8]       = (char)('0' + ((index / 10U) % 10U));
        place[9]       = (char)('0' + (index % 10U));
        TEST_ASSERT_TRUE_MESSAGE(index < bench.count, "a report is missing");
        const pus_tm_t tm = bench_report(index);
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(pairs[0], tm.service, place);
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(pairs[1], tm.subtype, place);
        index++;
    }
    TEST_ASSERT_EQUAL_UINT64_MESSAGE(index, bench.count, "number of reports");
}

void expect_failure(const size_t index, const uint8_t subtype, const uint16_t code,
                    const uint16_t instruction, const uint32_t detail)
{
    pus_verification_t verification;
    const pus_tm_t tm = bench_report(index);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_verification_read(&tm, &verification));
    TEST_ASSERT_EQUAL_UINT8(subtype, verification.subtype);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, verification.request_id);
    TEST_ASSERT_EQUAL_HEX16(code, verification.failure.code);
    TEST_ASSERT_EQUAL_UINT16(instruction, verification.failure.instruction);
    TEST_ASSERT_EQUAL_HEX32(detail, verification.failure.detail);
    TEST_ASSERT_EQUAL_UINT16(TEST_SOURCE, tm.destination);
}

void expect_strict_shape(const uint8_t subtype, const void* const data, const size_t size)
{
    uint8_t octets[PUS_TC_DATA_MAX] = {0};
    if (size > 0U) {
        memcpy(octets, data, size);
    }
    for (size_t length = 0U; length <= (size + 1U); length++) {
        if (length != size) {
            // A copy of exactly this length, so that the sanitizer sees a read past its end.
            uint8_t cut[PUS_TC_DATA_MAX];
            memcpy(cut, octets, length);
            bench_clear();
            TEST_ASSERT_EQUAL(STATUS_INVALID, bench_request(subtype, cut, length));
            TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
            TEST_ASSERT_EQUAL_UINT8(2U, bench_report(0U).subtype);
            octet_reader_t reader = bench_data(0U);
            (void)octet_read_u32(&reader);
            TEST_ASSERT_EQUAL_HEX16(PUS_FAILURE_DATA, octet_read_u16(&reader));
            TEST_ASSERT_EQUAL_UINT16(0U, octet_read_u16(&reader));
            TEST_ASSERT_TRUE(octet_read_u32(&reader) <= length);
        }
    }
    bench_clear();
}
