// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/framework/subsystem/subsystem_fixture_lines.h"

#include "pus/st01/st01_verification.h"
#include "pus/private/st129_management.h"
#include "pus/private/st130_rtlink.h"
#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <stdio.h>

void fixture_note(const char* text)
{
    fixture_line("%s", text);
}

// ---- Reports ----

static const char* phase_name(uint8_t phase)
{
    static const char* const names[] = {"IDLE",       "ENTERING", "INVALID", "UNCONFIGURED", "CONFIGURING",
                                        "CONFIGURED", "LEAVING",  "SECURED", "UNSECURED"};
    TEST_ASSERT_TRUE(phase < (sizeof names / sizeof names[0]));
    return names[phase];
}

static void verification_line(const pus_tm_t* tm)
{
    pus_verification_t report;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_verification_read(tm, &report));
    const unsigned number = report.request_id & 0x3FFFU;
    if ((report.subtype == 2U) || (report.subtype == 7U) || (report.subtype == 8U)) {
        fixture_end(number);
    }
    char text[64] = "";
    int used      = 0;
    if ((report.subtype == 5U) || (report.subtype == 6U)) {
        used = snprintf(text, sizeof text, " step %u", (unsigned)report.step);
    }
    if (report.failure.code != PUS_FAILURE_NONE) {
        used += snprintf(&text[used], sizeof text - (size_t)used, " %04X %lX", (unsigned)report.failure.code,
                         (unsigned long)report.failure.detail);
    }
    if (report.failure.instruction != 0U) {
        (void)snprintf(&text[used], sizeof text - (size_t)used, " in %u",
                       (unsigned)report.failure.instruction);
    }
    fixture_line("1.%u #%u%s", (unsigned)report.subtype, number, text);
    TEST_ASSERT_TRUE_MESSAGE(fixture.has_many_users || (fixture.source == tm->destination),
                             "a report to the wrong user");
}

static void transition_line(octet_reader_t* reader)
{
    pus_transition_t report;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_transition_read(reader, &report));
    fixture_line("129.2 %u>%u %s cause %u code %04X cfg %u", report.previous, report.state,
                 phase_name(report.phase), report.cause, report.code, report.configuration);
}

static void status_line(octet_reader_t* reader)
{
    pus_subsystem_status_t report;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_subsystem_status_read(reader, &report));
    fixture_line("129.5 %u %s target %u cfg %u epoch %lu cycle %lu", report.state, phase_name(report.phase),
                 report.target, report.configuration, (unsigned long)report.epoch,
                 (unsigned long)report.cycle);
}

static void hex_line(const pus_tm_t* tm, const char* start)
{
    char text[128] = "";
    for (size_t i = 0U; (i < tm->size) && (i < 60U); i++) {
        (void)snprintf(&text[2U * i], 3U, "%02X", tm->data[i]);
    }
    fixture_line("%s %s", start, text);
}

static void event_line(const pus_tm_t* tm)
{
    char start[48];
    pus_tm_t auxiliary = *tm;
    TEST_ASSERT_TRUE(tm->size >= 2U);
    const unsigned event = ((unsigned)tm->data[0] << 8U) | tm->data[1];
    auxiliary.data += 2U;
    auxiliary.size -= 2U;
    (void)snprintf(start, sizeof start, "5.%u event %u aux", tm->subtype, event);
    hex_line(&auxiliary, start);
}

static void link_line(const pus_tm_t* tm, octet_reader_t* reader)
{
    pus_link_transition_t made;
    pus_link_accept_t accepted;
    pus_link_refuse_t refused;
    if (tm->subtype == PUS_LINK_TRANSITION) {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_link_transition_read(reader, &made));
        fixture_line("130.10 link %u %u>%u reason %u", made.link, made.previous, made.state, made.cause);
    } else if (tm->subtype == PUS_LINK_ACCEPT) {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_link_accept_read(reader, &accepted));
        char name[8];
        (void)snprintf(name, sizeof name, "link-%02u", accepted.link % 100U);
        TEST_ASSERT_EQUAL_UINT8(accepted.properties.method, accepted.endpoint.kind);
        TEST_ASSERT_EQUAL_UINT8(sizeof name - 1U, accepted.endpoint.size);
        TEST_ASSERT_EQUAL_MEMORY(name, accepted.endpoint.octets, sizeof name - 1U);
        fixture_line("130.4 link %u method %u period %lu age %lu", accepted.link, accepted.properties.method,
                     (unsigned long)accepted.properties.period_us,
                     (unsigned long)accepted.properties.age_max_us);
    } else if (tm->subtype == PUS_LINK_REFUSE) {
        TEST_ASSERT_EQUAL(STATUS_OK, pus_link_refuse_read(reader, &refused));
        fixture.supported = refused.supported;
        fixture_line("130.5 reason %u field %u period %lu", refused.reason, refused.field,
                     (unsigned long)refused.supported.period_us);
    } else {
        char start[16];
        (void)snprintf(start, sizeof start, "130.%u", tm->subtype);
        hex_line(tm, start);
    }
}

void fixture_line_of_report(const uint8_t* packet, size_t size)
{
    pus_tm_t tm;
    pus_failure_t failure;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_decode(packet, size, &tm, &failure));
    TEST_ASSERT_EQUAL(FIXTURE_APID, tm.apid);
    TEST_ASSERT_EQUAL_MESSAGE(fixture.next_sequence, tm.sequence, "a report is missing or was sent twice");
    fixture.next_sequence = (uint16_t)((tm.sequence + 1U) % PUS_SEQUENCE_COUNT);
    octet_reader_t reader = octet_reader(tm.data, tm.size);
    if (tm.service == PUS_SERVICE_VERIFICATION) {
        verification_line(&tm);
    } else if ((tm.service == PUS_SERVICE_MANAGEMENT) && (tm.subtype == PUS_MANAGEMENT_TRANSITION)) {
        transition_line(&reader);
    } else if ((tm.service == PUS_SERVICE_EVENTS) && (tm.subtype <= 4U)) {
        event_line(&tm);
    } else if (tm.service == PUS_SERVICE_RTLINK) {
        link_line(&tm, &reader);
    } else if ((tm.service == PUS_SERVICE_MANAGEMENT) && fixture.shows_status) {
        status_line(&reader);
    } else if ((tm.service == PUS_SERVICE_MANAGEMENT) ||
               ((tm.service == PUS_SERVICE_HOUSEKEEPING) && (tm.subtype == 25U) && !fixture.shows_status)) {
        // Periodic reports are shown on request.
    } else {
        char start[16];
        (void)snprintf(start, sizeof start, "%u.%u", tm.service, tm.subtype);
        hex_line(&tm, start);
    }
}
