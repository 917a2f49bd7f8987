// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/supervisor/supervisor_fixture.h"

#include "test/unit/fsw/supervisor/supervisor_fixture_mission.h"
#include "pus/private/st130_codec.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

fixture_t fixture;
void (*fixture_configure)(supervisor_config_t* config);

static mission_descriptor_t mission;
static subsystem_descriptor_t own_descriptor;
static char directory[64];
static uint16_t next_number;

// ---- Platform ----

static fixture_member_t* member_of(uint16_t apid)
{
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        if (fixture.members[i].apid == apid) {
            return &fixture.members[i];
        }
    }
    return NULL;
}

static void open_member(fixture_member_t* member);

static status_t start(void* context, uint16_t apid, uint32_t link_floor, uint64_t boot_ns)
{
    (void)context;
    fixture.link_floor             = link_floor;
    fixture.boot_ns                = boot_ns;
    fixture_member_t* const member = member_of(apid);
    if (fixture.start_result != STATUS_OK) {
        return fixture.start_result;
    }
    if (member == NULL) {
        return STATUS_NOT_FOUND;
    }
    fixture.starts++;
    member->start_count++;
    member->is_running = true;
    // The promise of the earlier life is no longer valid.
    fixture.promise_ns = (apid == fixture.late_apid) ? UINT64_MAX : fixture.promise_ns;
    open_member(member);
    return STATUS_OK;
}

static status_t stop(void* context, uint16_t apid)
{
    (void)context;
    fixture_member_t* const member = member_of(apid);
    fixture.stops++;
    if (member != NULL) {
        member->is_running = false;
    }
    return STATUS_OK;
}

static status_t kill_process(void* context, uint16_t apid)
{
    fixture.kills++;
    return stop(context, apid);
}

static uint64_t promise(void* context, uint16_t apid)
{
    (void)context;
    return (apid == fixture.late_apid) ? fixture.promise_ns : UINT64_MAX;
}

static bool is_running(void* context, uint16_t apid)
{
    (void)context;
    const fixture_member_t* const member = member_of(apid);
    return (member != NULL) && member->is_running;
}

static bool is_stop_requested(void* context)
{
    (void)context;
    return fixture.is_stop_requested;
}

static void finished(void* context)
{
    (void)context;
    TEST_ASSERT_FALSE_MESSAGE(fixture.is_finished, "finished twice");
    fixture.is_finished = true;
}

// ---- Members ----

static void delivered(void* context, uint16_t to)
{
    (void)context;
    (void)to;
}

static status_t send_up(void* context, const uint8_t* packet, size_t size)
{
    fixture_member_t* const member = context;
    return message_send(&member->endpoint, SUPERVISOR_APID, packet, size);
}

static void open_member(fixture_member_t* member)
{
    const pus_port_t port = {member, send_up};
    message_open(&member->endpoint, member->apid, member->start_count,
                 message_ring_carrier_port(&fixture.hub), member->inbox,
                 sizeof member->inbox / sizeof member->inbox[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&member->endpoint, SUPERVISOR_APID));
    pus_app_process_init(&member->process, member->apid, mission.epoch_s, &port);
    member->state         = STATE_OFFLINE;
    member->phase         = PHASE_IDLE;
    member->configuration = 0U;
}

void fixture_report(unsigned index, uint8_t service, uint8_t subtype, const void* data, size_t size)
{
    fixture_member_t* const member = &fixture.members[index];
    octet_writer_t writer = pus_tm_begin(&member->process, service, subtype, PUS_USER_GROUND, fixture.now_ns);
    octet_write_octets(&writer, data, size);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&member->process, &writer));
}

static void report_state(fixture_member_t* member, state_t previous)
{
    const pus_transition_t made = {.previous      = (uint8_t)previous,
                                   .state         = (uint8_t)member->state,
                                   .phase         = (uint8_t)member->phase,
                                   .configuration = member->configuration};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_transition_report(&member->process, &made, fixture.now_ns));
}

static void send_status(fixture_member_t* member)
{
    const mission_subsystem_t* const own =
        descriptor_mission_find_subsystem(fixture.supervisor.mission, member->apid);
    const pus_subsystem_status_t status = {.state          = (uint8_t)member->state,
                                           .phase          = (uint8_t)member->phase,
                                           .target         = (uint8_t)member->state,
                                           .configuration  = member->configuration,
                                           .interface_hash = own->interface_hash + member->interface_offset,
                                           .configuration_hash =
                                               own->configuration_hash + member->configuration_offset};
    (void)pus_subsystem_status_report(&member->process, PUS_USER_GROUND, &status, fixture.now_ns);
}

static void enter(fixture_member_t* member, state_t state)
{
    const state_t previous = member->state;
    member->state          = state;
    if (state == STATE_PRE_OPERATIONAL) {
        member->configuration = (previous == STATE_OFFLINE) ? 0U : member->configuration;
        member->phase         = (member->configuration != 0U) ? PHASE_CONFIGURED : PHASE_UNCONFIGURED;
    } else if (state == STATE_ERROR_OPERATIONAL) {
        member->phase = PHASE_SECURED;
    } else {
        member->phase         = PHASE_IDLE;
        member->configuration = (state == STATE_OFFLINE) ? 0U : member->configuration;
    }
    report_state(member, previous);
}

void fixture_put_in_state(unsigned index, state_t state)
{
    fixture_member_t* const member = &fixture.members[index];
    if (state >= STATE_PRE_OPERATIONAL) {
        member->configuration = 2U;
    }
    // In this state a request for PRE_OPERATIONAL keeps the configuration.
    member->state = STATE_SAFE_OPERATIONAL;
    enter(member, state);
    fixture_step();
}

static uint32_t bit_of(uint16_t link)
{
    return ((link >= 1U) && (link <= 32U)) ? ((uint32_t)1U << (link - 1U)) : 0U;
}

static void close_link(fixture_member_t* member, uint16_t link)
{
    member->open_links &= ~bit_of(link);
    fixture_link_changed((unsigned)(member - fixture.members), link, PUS_LINK_STATE_OPEN,
                         PUS_LINK_STATE_CLOSED);
}

static void answer_link_request(fixture_member_t* member, octet_reader_t* reader)
{
    pus_link_request_t request;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_link_request_read(reader, &request));
    if (member->refuses_links != 0U) {
        const pus_link_refuse_t refused = {request.transaction, member->refuses_links, PUS_LINK_FIELD_PERIOD,
                                           request.properties};
        (void)pus_link_refuse_report(&member->process, FIXTURE_USER, &refused, fixture.now_ns);
        return;
    }
    if ((member->open_links & bit_of(request.link)) != 0U) { // An agreement replaces an open link.
        close_link(member, request.link);
    }
    pus_link_accept_t accepted = {
        .transaction = request.transaction, .link = request.link, .properties = request.properties};
    // A change that the tests can observe.
    accepted.properties.depth = (uint8_t)(request.properties.depth + 1U);
    fixture_link_changed((unsigned)(member - fixture.members), request.link, PUS_LINK_STATE_CLOSED,
                         PUS_LINK_STATE_ACCEPTED);
    (void)pus_link_accept_report(&member->process, PUS_USER_SUPERVISOR, &accepted, fixture.now_ns);
}

/// Send TM[130,9] of the links that the member considers open.
static void report_links(fixture_member_t* member)
{
    uint16_t count        = 0U;
    octet_writer_t writer = pus_tm_begin(&member->process, PUS_SERVICE_RTLINK, PUS_LINK_STATUS,
                                         PUS_USER_SUPERVISOR, fixture.now_ns);
    for (uint16_t i = 0U; i < 32U; i++) {
        count = (uint16_t)(count + ((member->open_links >> i) & 1U));
    }
    octet_write_u16(&writer, count);
    for (uint16_t i = 0U; i < 32U; i++) {
        const pus_link_status_t status = {.link = (uint16_t)(i + 1U), .state = PUS_LINK_STATE_OPEN};
        if (((member->open_links >> i) & 1U) != 0U) {
            pus_codec_write(&writer, link_status_fields, &status);
        }
    }
    (void)pus_tm_post(&member->process, &writer);
}

static void answer_link(fixture_member_t* member, const pus_tc_t* tc, octet_reader_t* reader)
{
    const unsigned index = (unsigned)(member - fixture.members);
    if (member->ignores_links) {
        return;
    }
    if (tc->subtype == PUS_LINK_REQUEST) {
        answer_link_request(member, reader);
    } else if (tc->subtype == PUS_LINK_OPEN) {
        const uint16_t link = octet_read_u16(reader);
        if ((member->open_links & bit_of(link)) != 0U) {
            return; // A member refuses to open a link again.
        }
        member->open_links |= member->fails_to_open ? 0U : bit_of(link);
        fixture_link_changed(index, link, PUS_LINK_STATE_ACCEPTED,
                             member->fails_to_open ? PUS_LINK_STATE_FAILED : PUS_LINK_STATE_OPEN);
    } else if (tc->subtype == PUS_LINK_CLOSE) {
        close_link(member, octet_read_u16(reader));
    } else if (tc->subtype == PUS_LINK_REPORT_STATUS) {
        report_links(member);
    } else {
        // Other requests have no effect.
    }
}

static void answer(fixture_member_t* member, const pus_tc_t* tc)
{
    octet_reader_t reader   = octet_reader(tc->data, tc->size);
    const pus_token_t token = pus_token_of(tc);
    pus_verify_accepted(&member->process, &token, fixture.now_ns);
    pus_verify_started(&member->process, &token, fixture.now_ns);
    if ((tc->service == PUS_SERVICE_MANAGEMENT) &&
        ((tc->subtype == PUS_MANAGEMENT_REQUEST_STATE) || (tc->subtype == PUS_MANAGEMENT_ORDER_STATE))) {
        enter(member, (state_t)octet_read_u8(&reader));
    } else if ((tc->service == PUS_SERVICE_MANAGEMENT) && (tc->subtype == PUS_MANAGEMENT_SELECT)) {
        member->configuration = octet_read_u16(&reader);
        member->phase         = PHASE_CONFIGURED;
        report_state(member, member->state);
    } else if ((tc->service == PUS_SERVICE_MANAGEMENT) && (tc->subtype == PUS_MANAGEMENT_REPORT_STATUS)) {
        send_status(member);
    } else if (tc->service == PUS_SERVICE_RTLINK) {
        answer_link(member, tc, &reader);
    } else {
        // Other requests have no effect and are reported as completed.
    }
    pus_verify_completed(&member->process, &token, fixture.now_ns);
}

static void take_in(fixture_member_t* member)
{
    static uint8_t packet[PUS_PACKET_MAX];
    uint16_t from = 0U;
    size_t size   = 0U;
    while (message_receive(&member->endpoint, &from, packet, sizeof packet, &size) == STATUS_OK) {
        pus_tc_t tc;
        pus_failure_t failure;
        TEST_ASSERT_EQUAL(SUPERVISOR_APID, from);
        fixture_line_of_packet(member, packet, size);
        if (pus_packet_is_tc(packet, size) && !member->is_passive) {
            TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_decode(packet, size, &tc, &failure));
            answer(member, &tc);
        }
    }
}

// ---- Time ----

void fixture_step(void)
{
    const uint64_t wake_ns = supervisor_step(&fixture.supervisor, fixture.now_ns);
    TEST_ASSERT_TRUE((wake_ns > fixture.now_ns) && (wake_ns <= (fixture.now_ns + FIXTURE_TICK_NS)));
    const bool is_status_due = (fixture.now_ns >= fixture.next_status_ns);
    fixture.next_status_ns   = is_status_due ? (fixture.now_ns + 500000000U) : fixture.next_status_ns;
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        fixture_member_t* const member = &fixture.members[i];
        if (member->is_running && !member->takes_nothing) {
            take_in(member);
        }
        if (member->is_running && !member->is_silent && is_status_due) {
            send_status(member);
        }
    }
}

void fixture_tick(void)
{
    fixture_step();
    fixture.now_ns += FIXTURE_TICK_NS;
}

void fixture_run(unsigned ticks)
{
    for (unsigned i = 0U; i < ticks; i++) {
        fixture_tick();
    }
}

// ---- Life ----

const char* fixture_directory(void)
{
    return directory;
}

void fixture_open(void)
{
    static const uint16_t apids[FIXTURE_MEMBERS] = {COMMUNICATION_APID, ARM, HAND, LONE};
    (void)memset(&fixture, 0, sizeof fixture);
    (void)snprintf(directory, sizeof directory, "/tmp/hirosco-fixture-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
    fixture_mission_load(directory, &mission, &own_descriptor);
    fixture.source         = FIXTURE_USER;
    fixture.ack            = PUS_ACK_ALL;
    fixture.link_period_us = 1000U;
    next_number            = 0U;
    fixture_forget_ends();
    message_ring_carrier_init(&fixture.hub, (message_delivery_notice_t){NULL, delivered});
    message_open(&fixture.endpoint, SUPERVISOR_APID, 1U, message_ring_carrier_port(&fixture.hub),
                 fixture.inbox, sizeof fixture.inbox / sizeof fixture.inbox[0]);
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_carrier_attach(&fixture.hub, &fixture.endpoint));
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        fixture.members[i].apid        = apids[i];
        fixture.members[i].is_running  = true;
        fixture.members[i].start_count = 1U;
        open_member(&fixture.members[i]);
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_carrier_attach(&fixture.hub, &fixture.members[i].endpoint));
        TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&fixture.endpoint, apids[i]));
    }
    supervisor_config_t config = {.mission             = &mission,
                                  .descriptor          = &own_descriptor,
                                  .is_descriptor_valid = true,
                                  .endpoint            = &fixture.endpoint,
                                  .platform            = {.start             = start,
                                                          .stop              = stop,
                                                          .kill              = kill_process,
                                                          .is_running        = is_running,
                                                          .promise           = promise,
                                                          .is_stop_requested = is_stop_requested,
                                                          .finished          = finished},
                                  .log_directory       = directory,
                                  .start_count         = 1U};
    if (fixture_configure != NULL) {
        fixture_configure(&config);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_init(&fixture.supervisor, &config));
    fixture_forget();
}

void fixture_open_up(void)
{
    fixture_open();
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_GROUND].state);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.supervisor.subsystem));
    fixture_forget();
}

const char* fixture_log_file(const char* name)
{
    static char content[1048576];
    char path[160];
    size_t size = 0U;
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    const status_t status                      = osal_file_load(path, content, sizeof content - 1U, &size);
    content[(status == STATUS_OK) ? size : 0U] = '\0';
    return content;
}

void fixture_close(void)
{
    static const char* const names[] = {"packets.ascii", "packets.spool", "packets.ring"};
    supervisor_close(&fixture.supervisor);
    for (unsigned i = 0U; i < 3U; i++) {
        char path[160];
        (void)snprintf(path, sizeof path, "%s/%s", directory, names[i]);
        (void)unlink(path);
    }
    TEST_ASSERT_EQUAL(0, rmdir(directory));
}

// ---- Input ----

void fixture_send(unsigned member, const uint8_t* octets, size_t size)
{
    TEST_ASSERT_EQUAL(STATUS_OK,
                      message_send(&fixture.members[member].endpoint, SUPERVISOR_APID, octets, size));
}

uint16_t fixture_tc(uint16_t apid, uint8_t service, uint8_t subtype, const void* data, size_t size)
{
    uint8_t packet[512];
    size_t packet_size = 0U;
    const pus_tc_t tc  = {.apid     = apid,
                          .sequence = next_number,
                          .ack      = fixture.ack,
                          .service  = service,
                          .subtype  = subtype,
                          .source   = fixture.source,
                          .data     = data,
                          .size     = size};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, packet, sizeof packet, &packet_size));
    fixture_sent(next_number);
    fixture_send(FIXTURE_GROUND, packet, packet_size);
    return next_number++;
}

uint16_t fixture_request_state(uint16_t apid, state_t target)
{
    const uint8_t data[1] = {(uint8_t)target};
    return fixture_tc(apid, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REQUEST_STATE, data, 1U);
}

void fixture_fill(unsigned member)
{
    fixture_member_t* const full = &fixture.members[member];
    const uint8_t ack            = fixture.ack;
    full->takes_nothing          = true;
    fixture.ack                  = 0U;
    while (message_credit_plain(&fixture.endpoint, full->apid) > 0U) {
        (void)fixture_tc(full->apid, PUS_SERVICE_TEST, 1U, NULL, 0U);
        fixture_step();
    }
    while (message_credit(&fixture.endpoint, full->apid) > 0U) { // The requests go into the inbox.
        TEST_ASSERT_EQUAL(STATUS_OK, message_send(&fixture.endpoint, full->apid, NULL, 0U));
    }
    fixture.ack = ack;
    fixture_forget();
}

void fixture_event(unsigned member, uint8_t severity, uint16_t event)
{
    const uint8_t data[2] = {(uint8_t)(event >> 8U), (uint8_t)event};
    fixture_report(member, PUS_SERVICE_EVENTS, severity, data, sizeof data);
}

void fixture_verify(unsigned index, uint8_t subtype, uint16_t number)
{
    fixture_member_t* const member = &fixture.members[index];
    const pus_token_t token = {.request_id = ((0x1800U | (uint32_t)member->apid) << 16U) | 0xC000U | number,
                               .source     = FIXTURE_USER,
                               .ack        = PUS_ACK_ALL};
    const pus_failure_t failure = pus_failure(PUS_FAILURE_STATE, 0U);
    switch (subtype) {
    case 1U:
        pus_verify_accepted(&member->process, &token, fixture.now_ns);
        break;
    case 4U:
        pus_verify_start_failed(&member->process, &token, &failure, fixture.now_ns);
        break;
    default:
        TEST_ASSERT_EQUAL(7U, subtype);
        pus_verify_completed(&member->process, &token, fixture.now_ns);
        break;
    }
}

// ---- Links ----

void fixture_link_changed(unsigned member, uint16_t link, uint8_t previous, uint8_t state)
{
    const pus_link_transition_t made = {
        .link = link, .previous = previous, .state = state, .time_ns = fixture.now_ns};
    (void)pus_link_transition_report(&fixture.members[member].process, &made, fixture.now_ns);
}

uint16_t fixture_request_link(uint16_t link)
{
    static const pus_link_ends_t ends[] = {{ARM, 1U, HAND, 2U}, {HAND, 1U, ARM, 2U}, {ARM, 1U, LONE, 3U}};
    uint8_t data[64];
    octet_writer_t writer            = octet_writer(data, sizeof data);
    const pus_link_request_t request = {
        .transaction = 7U,
        .ends        = ends[link - 1U],
        .properties  = {.layout_size = 8U, .period_us = fixture.link_period_us, .depth = 1U}};
    pus_link_request_write(&writer, &request);
    return fixture_tc(SUPERVISOR_APID, PUS_SERVICE_RTLINK, PUS_LINK_REQUEST, data, writer.position);
}

uint16_t fixture_open_link(uint16_t link)
{
    uint8_t data[64];
    octet_writer_t writer      = octet_writer(data, sizeof data);
    const pus_link_open_t open = {.link = link};
    pus_link_open_write(&writer, &open);
    return fixture_tc(SUPERVISOR_APID, PUS_SERVICE_RTLINK, PUS_LINK_OPEN, data, writer.position);
}

uint16_t fixture_close_link(uint16_t link)
{
    const uint8_t data[3] = {(uint8_t)(link >> 8U), (uint8_t)link, 0U};
    return fixture_tc(SUPERVISOR_APID, PUS_SERVICE_RTLINK, PUS_LINK_CLOSE, data, sizeof data);
}

void fixture_link_up(state_t state)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    for (uint16_t link = LINK_ARM_STATE; link <= LINK_HAND_POS; link++) {
        (void)fixture_request_link(link);
        fixture_run(4U);
        (void)fixture_open_link(link);
        fixture_run(4U);
    }
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
    if (state != STATE_PRE_OPERATIONAL) {
        fixture_put_in_state(FIXTURE_ARM, state);
        fixture_put_in_state(FIXTURE_HAND, state);
    }
    fixture_run(1U);
    fixture_forget();
}
