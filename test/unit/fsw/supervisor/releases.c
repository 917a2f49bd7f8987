// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/supervisor/releases.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

octet_writer_t request_data;

void request_begin(void)
{
    static uint8_t octets[256];
    request_data = octet_writer(octets, sizeof octets);
}

void request_octets(uint8_t service, uint8_t subtype, const char* octets, size_t size)
{
    fixture.ack = 0U;
    (void)fixture_tc(SUPERVISOR_APID, service, subtype, octets, size);
    fixture_step();
}

void request_send(uint8_t service, uint8_t subtype)
{
    TEST_ASSERT_FALSE(request_data.failed);
    request_octets(service, subtype, (const char*)request_data.octets, request_data.position);
}

void request_within(uint16_t apid, uint16_t sequence)
{
    uint8_t packet[64];
    size_t size       = 0U;
    const pus_tc_t tc = {.apid     = apid,
                         .sequence = sequence,
                         .service  = PUS_SERVICE_TEST,
                         .subtype  = 1U,
                         .source   = FIXTURE_USER};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, sizeof packet, &size));
    octet_write_octets(&request_data, packet, size);
}

void schedule_enable(uint8_t service)
{
    REQUEST(service, 22U, "\1\1\1"); // Create one group, 1, enabled.
    REQUEST(service, 1U, "");
}

/// Begin TC[11,4] or TC[22,4]: sub-schedule 1, one activity of group 1 with a tag of the service.
static void begin_activity(void)
{
    request_begin();
    octet_write_u8(&request_data, 1U);
    octet_write_u8(&request_data, 1U);
    octet_write_u8(&request_data, 1U);
}

static void insert(uint8_t service, uint16_t apid, uint16_t sequence)
{
    request_within(apid, sequence);
    request_send(service, 4U);
    REQUEST(service, 20U, "\1\1");
}

void release_at(uint64_t time_ns, uint16_t apid, uint16_t sequence)
{
    begin_activity();
    pus_time_write(&request_data, ((uint64_t)fixture.supervisor.mission->epoch_s * 1000000000U) + time_ns);
    insert(PUS_SERVICE_TIME_SCHEDULE, apid, sequence);
}

void release_where(uint64_t position, uint16_t apid, uint16_t sequence)
{
    begin_activity();
    octet_write_u32(&request_data, (uint32_t)(position / PUS_POSITION_TICKS));
    octet_write_u16(&request_data, (uint16_t)(position % PUS_POSITION_TICKS));
    insert(PUS_SERVICE_POSITION_SCHEDULE, apid, sequence);
}

void release_on(uint16_t event, uint16_t apid, uint16_t sequence)
{
    request_begin();
    octet_write_u8(&request_data, 1U);
    octet_write_u16(&request_data, ARM);
    octet_write_u16(&request_data, event);
    request_within(apid, sequence);
    request_send(PUS_SERVICE_EVENT_ACTION, 1U);
    request_begin();
    octet_write_u8(&request_data, 1U);
    octet_write_u16(&request_data, ARM);
    octet_write_u16(&request_data, event);
    request_send(PUS_SERVICE_EVENT_ACTION, 4U);
    REQUEST(PUS_SERVICE_EVENT_ACTION, 8U, "");
}

void release_in_sequence(uint16_t apid, uint16_t sequence)
{
    request_begin();
    octet_write_octets(&request_data, (const uint8_t*)"SEQ\0\0\0\0\0\1", 9U); // A sequence of one request.
    request_within(apid, sequence);
    octet_write_octets(&request_data, (const uint8_t*)"\0\0\0\0\0\0\0", 7U); // Its delay.
    request_send(PUS_SERVICE_SEQUENCES, 1U);
    REQUEST(PUS_SERVICE_SEQUENCES, 4U, "SEQ\0\0\0\0\0");
}
