// SPDX-License-Identifier: Apache-2.0
// Which packets the router takes in during a step, and which packets of the supervisor it sends. Some
// conditions of the router never change in the missions of the other tests; here each of them alone decides
// the result (make mcdc). Replaced: the channels of messages, for cases that a correct channel never has.
#include "fsw/supervisor/supervisor_internal.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

#define UNKNOWN 99U
#define ROUNDS_MAX 100000U // Ends a loop that has lost its bound.

/// The next block of the channels, while they are replaced.
static struct {
    bool is_on;
    bool is_endless; // There is always a next block, even from senders that the router does not accept.
    uint16_t from;
    size_t size;
    status_t status; // Result of taking the block.
    unsigned taken;
} channel;
static bool may_answer;
static uint8_t request[64]; // A request for a connection test to ARM.
static size_t request_size;

status_t __real_message_next(message_endpoint_t* endpoint, const message_filter_t* filter, uint16_t* out_from,
                             const uint8_t** out_head, size_t* out_size);
status_t __wrap_message_next(message_endpoint_t* endpoint, const message_filter_t* filter, uint16_t* out_from,
                             const uint8_t** out_head, size_t* out_size)
{
    if (!channel.is_on) {
        return __real_message_next(endpoint, filter, out_from, out_head, out_size);
    }
    const bool is_open = channel.is_endless || filter->admits(filter->context, channel.from);
    *out_from          = channel.from;
    *out_head          = request;
    *out_size          = channel.size;
    return (is_open && (channel.taken < ROUNDS_MAX)) ? STATUS_OK : STATUS_EMPTY;
}

status_t __real_message_receive_if(message_endpoint_t* endpoint, const message_filter_t* filter,
                                   uint16_t* out_from, uint8_t* octets, size_t capacity, size_t* out_size);
status_t __wrap_message_receive_if(message_endpoint_t* endpoint, const message_filter_t* filter,
                                   uint16_t* out_from, uint8_t* octets, size_t capacity, size_t* out_size)
{
    if (!channel.is_on) {
        return __real_message_receive_if(endpoint, filter, out_from, octets, capacity, out_size);
    }
    TEST_ASSERT_TRUE(filter->admits(filter->context, channel.from));
    channel.taken++;
    *out_size = (channel.size == 0U) ? 0U : request_size;
    (void)memcpy(octets, request, (capacity < *out_size) ? capacity : *out_size);
    return channel.status;
}

bool __real_subsystem_may_accept(subsystem_t* subsystem);
bool __wrap_subsystem_may_accept(subsystem_t* subsystem)
{
    return may_answer && __real_subsystem_may_accept(subsystem);
}

/// Encode a request of a user. An order of state has its two octets of data.
static size_t encode(uint8_t* const octets, const size_t capacity, const uint16_t apid, const uint16_t source,
                     const uint8_t service, const uint8_t subtype)
{
    static const uint8_t data[2] = {STATE_SAFE_OPERATIONAL, PUS_CAUSE_REQUEST};
    const bool has_data = (service == PUS_SERVICE_MANAGEMENT) && (subtype == PUS_MANAGEMENT_ORDER_STATE);
    size_t size         = 0U;
    const pus_tc_t tc   = {.apid    = apid,
                           .service = service,
                           .subtype = subtype,
                           .source  = source,
                           .data    = data,
                           .size    = has_data ? sizeof data : 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tc_encode(&tc, octets, capacity, &size));
    return size;
}

void setUp(void)
{
    may_answer = true;
    fixture_open_up();
    (void)memset(&channel, 0, sizeof channel);
    channel.from = ARM;
    request_size = encode(request, sizeof request, ARM, FIXTURE_USER, PUS_SERVICE_TEST, 1U);
}

void tearDown(void)
{
    channel.is_on = false;
    fixture_close();
}

static registry_entry_t* entry_of(const uint16_t apid)
{
    registry_entry_t* const entry = supervisor_registry_find(&fixture.supervisor, apid);
    TEST_ASSERT_NOT_NULL(entry);
    return entry;
}

// ---- Intake ----

/// Returns the number of blocks that one step takes from the replaced channels.
static unsigned take_in(void)
{
    channel.is_on = true;
    channel.taken = 0U;
    supervisor_router_take_in(&fixture.supervisor);
    channel.is_on = false;
    return channel.taken;
}

static void a_step_takes_at_most_one_window_of_packets_from_a_subsystem(void)
{
    TEST_ASSERT_EQUAL_UINT(MESSAGE_WINDOW, take_in());
}

static void a_step_takes_no_packet_of_a_sender_outside_of_the_mission(void)
{
    channel.from = UNKNOWN;
    TEST_ASSERT_EQUAL_UINT(0U, take_in());
}

static void a_step_takes_at_most_the_windows_of_all_subsystems(void)
{
    channel.is_endless = true;
    TEST_ASSERT_EQUAL_UINT(MESSAGE_PEERS_MAX * MESSAGE_WINDOW, take_in());
}

/// The octets that were received are a request, but it is not routed.
static void a_block_that_could_not_be_taken_is_counted_and_not_routed(void)
{
    const supervisor_counters_t before = fixture.supervisor.counters;
    channel.from                       = COMMUNICATION_APID;
    channel.size                       = request_size;
    channel.status                     = STATUS_TOO_LARGE;
    TEST_ASSERT_EQUAL_UINT(MESSAGE_WINDOW, take_in());
    TEST_ASSERT_EQUAL_UINT32(before.tm_malformed + MESSAGE_WINDOW, fixture.supervisor.counters.tm_malformed);
    TEST_ASSERT_EQUAL_UINT32(before.tc_routed, fixture.supervisor.counters.tc_routed);
    channel.status = STATUS_OK;
    TEST_ASSERT_TRUE(take_in() > 0U);
    TEST_ASSERT_TRUE(fixture.supervisor.counters.tc_routed > before.tc_routed);
}

static void requests_of_the_ground_wait_while_the_supervisor_cannot_answer(void)
{
    const uint32_t routed = fixture.supervisor.counters.tc_routed;
    may_answer            = false;
    (void)fixture_tc(HAND, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT32(routed, fixture.supervisor.counters.tc_routed);
    may_answer = true;
    fixture_run(2U);
    TEST_ASSERT_EQUAL_UINT32(routed + 1U, fixture.supervisor.counters.tc_routed);
}

// ---- Routing ----

static void a_report_that_is_not_forwarded_is_routed_and_stays_on_board(void)
{
    pus_selection_t* const forwarded = &fixture.supervisor.spacecraft.forwarding.service.selection;
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_INFORMATIVE, NOTE);
    (void)subsystem_raise(&fixture.supervisor.subsystem, SUPERVISOR_EVENT_GROUND_BEHIND, NULL, 0U);
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("G/16 5.1") && fixture_has("G 5.2"));
    fixture_forget();
    const uint32_t routed = fixture.supervisor.counters.tm_routed;
    forwarded->count      = 0U; // No report of any subsystem is selected.
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_INFORMATIVE, NOTE);
    (void)subsystem_raise(&fixture.supervisor.subsystem, SUPERVISOR_EVENT_GROUND_BEHIND, NULL, 0U);
    fixture_run(2U);
    fixture_expect("");
    TEST_ASSERT_TRUE(fixture.supervisor.counters.tm_routed > routed);
}

/// Release a request of the supervisor, as a procedure does. Returns the number of refusals.
static uint32_t refusals_of(const uint8_t service, const uint8_t subtype)
{
    const uint32_t before = fixture.supervisor.counters.tc_forbidden;
    uint8_t octets[64];
    const size_t size = encode(octets, sizeof octets, LONE, PUS_USER_SUPERVISOR, service, subtype);
    supervisor_router_route_released(&fixture.supervisor, octets, size);
    return fixture.supervisor.counters.tc_forbidden - before;
}

/// The mission permits TC[129,8] to LONE.
static void only_an_order_of_state_cannot_be_released_in_the_name_of_the_supervisor(void)
{
    TEST_ASSERT_EQUAL_UINT32(1U, refusals_of(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_ORDER_STATE));
    TEST_ASSERT_EQUAL_UINT32(0U, refusals_of(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_REPORT_STATUS));
    TEST_ASSERT_EQUAL_UINT32(0U, refusals_of(PUS_SERVICE_TEST, 1U));
}

static status_t route_whole(const uint16_t apid)
{
    uint8_t octets[64];
    const size_t size = encode(octets, sizeof octets, apid, FIXTURE_USER, PUS_SERVICE_TEST, 1U);
    return supervisor_router_route_whole(&fixture.supervisor, octets, size);
}

static void a_whole_request_waits_only_for_a_running_subsystem_without_room(void)
{
    supervisor_counters_t* const counters = &fixture.supervisor.counters;
    const uint32_t routed                 = counters->tc_routed;
    TEST_ASSERT_EQUAL(STATUS_OK, route_whole(ARM));
    TEST_ASSERT_EQUAL_UINT32(routed + 1U, counters->tc_routed);
    fixture_fill(FIXTURE_ARM);
    const uint32_t unroutable = counters->tc_unroutable;
    TEST_ASSERT_EQUAL(STATUS_FULL, route_whole(ARM));
    TEST_ASSERT_EQUAL_UINT32(unroutable, counters->tc_unroutable);
    entry_of(ARM)->process = PROCESS_STOPPED; // It takes no request any more.
    TEST_ASSERT_EQUAL(STATUS_OK, route_whole(ARM));
    TEST_ASSERT_EQUAL_UINT32(unroutable + 1U, counters->tc_unroutable);
    TEST_ASSERT_EQUAL(STATUS_OK, route_whole(UNKNOWN));
    TEST_ASSERT_EQUAL_UINT32(unroutable + 2U, counters->tc_unroutable);
}

// ---- Packets of the supervisor itself ----

static status_t send_housekeeping(const uint8_t subtype)
{
    uint8_t octets[64];
    size_t size       = 0U;
    const pus_tm_t tm = {.apid        = SUPERVISOR_APID,
                         .service     = PUS_SERVICE_HOUSEKEEPING,
                         .subtype     = subtype,
                         .destination = FIXTURE_USER};
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_encode(&tm, octets, sizeof octets, &size));
    return supervisor_router_send(&fixture.supervisor, octets, size);
}

static void without_room_only_sampled_reports_are_dropped(void)
{
    static const uint8_t octets[6]                = {0U};
    fixture.members[FIXTURE_GROUND].takes_nothing = true;
    while (supervisor_ground_accepts(&fixture.supervisor, PUS_CLASS_BULK, 64U)) {
        fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 25U, octets, sizeof octets);
        fixture_step();
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send_housekeeping(25U));
    TEST_ASSERT_EQUAL(STATUS_OK, send_housekeeping(26U));
    TEST_ASSERT_EQUAL(STATUS_FULL, send_housekeeping(10U)); // A structure: its sender sends it again.
}

static void a_stored_order_waits_until_its_subsystem_runs(void)
{
    registry_entry_t* const arm = entry_of(ARM);
    arm->is_order_pending       = true;
    arm->ordered                = STATE_OFFLINE;
    arm->process                = PROCESS_STOPPED;
    supervisor_send_pending_orders(&fixture.supervisor);
    TEST_ASSERT_TRUE(arm->is_order_pending);
    arm->process = PROCESS_RUNNING;
    supervisor_send_pending_orders(&fixture.supervisor);
    TEST_ASSERT_FALSE(arm->is_order_pending);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_step_takes_at_most_one_window_of_packets_from_a_subsystem);
    RUN_TEST(a_step_takes_no_packet_of_a_sender_outside_of_the_mission);
    RUN_TEST(a_step_takes_at_most_the_windows_of_all_subsystems);
    RUN_TEST(a_block_that_could_not_be_taken_is_counted_and_not_routed);
    RUN_TEST(requests_of_the_ground_wait_while_the_supervisor_cannot_answer);
    RUN_TEST(a_report_that_is_not_forwarded_is_routed_and_stays_on_board);
    RUN_TEST(only_an_order_of_state_cannot_be_released_in_the_name_of_the_supervisor);
    RUN_TEST(a_whole_request_waits_only_for_a_running_subsystem_without_room);
    RUN_TEST(without_room_only_sampled_reports_are_dropped);
    RUN_TEST(a_stored_order_waits_until_its_subsystem_runs);
    return UNITY_END();
}
