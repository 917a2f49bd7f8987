// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <stdio.h>

// ---- Packets ----

static const char* hex(const uint8_t* octets, size_t size)
{
    static char text[160];
    text[0] = '\0';
    for (size_t i = 0U; (i < size) && (i < 70U); i++) {
        (void)snprintf(&text[2U * i], 3U, "%02X", octets[i]);
    }
    return text;
}

static void request_line(const fixture_member_t* member, const uint8_t* packet, size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(packet, size, &tc, &failure));
    TEST_ASSERT_EQUAL(member->apid, tc.apid);
    fixture_line("%u TC %u.%u %s%sfrom %X", tc.apid, tc.service, tc.subtype, hex(tc.data, tc.size),
                 (tc.size > 0U) ? " " : "", tc.source);
}

static void verification_line(const char* who, const pus_tm_t* tm)
{
    pus_verification_t report;
    if (pus_verification_read(tm, &report) != STATUS_OK) { // A malformed report of a member.
        fixture_line("%s 1.%u %s", who, tm->subtype, hex(tm->data, tm->size));
        return;
    }
    const unsigned number = report.request_id & 0x3FFFU;
    const bool is_end     = (report.subtype == 7U) || (report.subtype == 8U);
    if (is_end && (tm->apid == SUPERVISOR_APID)) {
        fixture_end(number);
    }
    if (report.failure.code != PUS_FAILURE_NONE) {
        fixture_line("%s 1.%u #%u %04X %lX", who, report.subtype, number, report.failure.code,
                     (unsigned long)report.failure.detail);
    } else {
        fixture_line("%s 1.%u #%u", who, report.subtype, number);
    }
}

static void report_line(const uint8_t* packet, size_t size)
{
    pus_tm_t tm;
    pus_failure_t failure;
    char who[16] = "G";
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, size, &tm, &failure));
    if (tm.apid != SUPERVISOR_APID) {
        (void)snprintf(who, sizeof who, "G/%u", tm.apid);
    }
    if ((tm.apid == SUPERVISOR_APID) && (tm.service == PUS_SERVICE_EVENTS)) {
        fixture.event_ns = tm.time_ns - ((uint64_t)fixture.supervisor.mission->epoch_s * 1000000000U);
    }
    const bool is_status = (tm.service == PUS_SERVICE_MANAGEMENT) && (tm.subtype == PUS_MANAGEMENT_STATUS);
    const bool is_housekeeping = (tm.service == PUS_SERVICE_HOUSEKEEPING) && (tm.subtype == 25U);
    if (tm.service == PUS_SERVICE_VERIFICATION) {
        verification_line(who, &tm);
    } else if (!is_status && !is_housekeeping) {
        fixture_line("%s %u.%u %s", who, tm.service, tm.subtype, hex(tm.data, tm.size));
    }
}

void fixture_line_of_packet(fixture_member_t* member, const uint8_t* packet, size_t size)
{
    if (pus_packet_is_tc(packet, size)) {
        request_line(member, packet, size);
    } else if (pus_is_time_packet(packet, size)) {
        fixture_line("G time %u", packet[PUS_PRIMARY_HEADER_SIZE]);
    } else if (member->apid == COMMUNICATION_APID) {
        report_line(packet, size);
    } else {
        member->heartbeats++;
    }
}
