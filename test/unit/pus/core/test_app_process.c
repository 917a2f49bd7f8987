// SPDX-License-Identifier: Apache-2.0
// Reports of an application process: their counts, the two queues of reports that the port has refused (firm
// reports and plain ones), and which reports overtake others.
#include "pus/core/app_process.h"

#include "pus/st05/st05_events.h"
#include "test/support/assertion.h"
#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

void setUp(void)
{
    bench_start();
}

void tearDown(void)
{
}

static octet_writer_t begin(const uint8_t service, const uint8_t subtype, const uint16_t destination)
{
    return pus_tm_begin(&bench.process, service, subtype, destination, TEST_NOW_NS);
}

/// Send a report of one octet that identifies it.
static status_t send(const uint8_t name)
{
    octet_writer_t writer = begin(5U, 1U, 0U);
    octet_write_u8(&writer, name);
    return pus_tm_send(&bench.process, &writer);
}

static status_t post(const uint8_t name)
{
    octet_writer_t writer = begin(5U, 1U, 0U);
    octet_write_u8(&writer, name);
    return pus_tm_post(&bench.process, &writer);
}

static void a_report_is_a_complete_packet(void)
{
    octet_writer_t writer = begin(3U, 25U, 9U);
    octet_write_u32(&writer, 0xC0FFEE01U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&bench.process, &writer));
    const pus_tm_t tm = bench_report(0U);
    TEST_ASSERT_EQUAL_UINT16(0U, tm.sequence);
    TEST_ASSERT_EQUAL_UINT8(0U, tm.time_status);
    TEST_ASSERT_EQUAL_UINT8(3U, tm.service);
    TEST_ASSERT_EQUAL_UINT8(25U, tm.subtype);
    TEST_ASSERT_EQUAL_UINT16(0U, tm.counter);
    TEST_ASSERT_EQUAL_UINT16(9U, tm.destination);
    TEST_ASSERT_EQUAL_UINT64((TEST_EPOCH_S * 1000000000ULL) + TEST_NOW_NS, tm.time_ns);
    TEST_ASSERT_EQUAL_UINT64(4U, tm.size);
    TEST_ASSERT_EQUAL_HEX8(0xC0U, tm.data[0]);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.sent);
}

static void types_and_destinations_are_counted_separately(void)
{
    static const uint8_t messages[][2] = {{3U, 25U}, {3U, 25U}, {5U, 1U}, {3U, 25U}, {3U, 10U}, {5U, 1U}};
    static const uint16_t counters[]   = {0U, 1U, 0U, 2U, 0U, 1U};
    for (size_t i = 0U; i < 6U; i++) {
        octet_writer_t writer = begin(messages[i][0], messages[i][1], 0U);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&bench.process, &writer));
        TEST_ASSERT_EQUAL_UINT16(counters[i], bench_report(i).counter);
        TEST_ASSERT_EQUAL_UINT16(i, bench_report(i).sequence);
    }
    octet_writer_t writer = begin(3U, 25U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&bench.process, &writer));
    TEST_ASSERT_EQUAL_UINT16(0U, bench_report(6U).counter);
}

static void a_refused_report_leaves_no_gap(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, send(0U));
    bench.refusals = 3U;
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(STATUS_FULL, send(99U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, send(1U));
    TEST_ASSERT_EQUAL_UINT64(2U, bench.count);
    TEST_ASSERT_EQUAL_UINT16(1U, bench_report(1U).sequence);
    TEST_ASSERT_EQUAL_UINT16(1U, bench_report(1U).counter);
    TEST_ASSERT_EQUAL_UINT32(3U, bench.process.counters.refused);
}

static void the_sequence_wraps_after_16384(void)
{
    for (unsigned i = 0U; i <= PUS_SEQUENCE_COUNT; i++) {
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_OK, send(0U));
        TEST_ASSERT_EQUAL_UINT16(i % PUS_SEQUENCE_COUNT, bench_report(0U).sequence);
        TEST_ASSERT_EQUAL_UINT16(i, bench_report(0U).counter);
    }
}

static void posted_reports_wait_and_keep_their_order(void)
{
    bench.refusals = 2U; // The port refuses the first post, and the flush before the second.
    TEST_ASSERT_EQUAL(STATUS_OK, post(1U));
    TEST_ASSERT_EQUAL(STATUS_OK, post(2U));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_EQUAL_UINT32(2U, bench.process.counters.kept);
    bench.refusals = 1U;
    TEST_ASSERT_EQUAL(STATUS_FULL, send(99U)); // A later report must not overtake the reports that wait.
    bench.refusals = 1U;
    TEST_ASSERT_EQUAL(STATUS_FULL, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL(STATUS_OK, post(3U)); // The kept reports are sent first.
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL_UINT64(3U, bench.count);
    for (size_t i = 0U; i < 3U; i++) {
        const pus_tm_t tm = bench_report(i);
        TEST_ASSERT_EQUAL_UINT8(i + 1U, tm.data[0]);
        TEST_ASSERT_EQUAL_UINT16(i, tm.sequence);
        TEST_ASSERT_EQUAL_UINT16(i, tm.counter);
    }
}

/// Post a report of `size` octets of data. The port refuses this report and all kept reports before it.
static status_t post_refused(const uint8_t service, const uint8_t subtype, const uint16_t destination,
                             const size_t size)
{
    static uint8_t data[PUS_TM_DATA_MAX];
    octet_writer_t writer = begin(service, subtype, destination);
    octet_write_octets(&writer, data, size);
    bench.refusals        = 1U;
    const status_t status = pus_tm_post(&bench.process, &writer);
    bench.refusals        = 0U;
    return status;
}

#define KEPT(size) (PUS_KEPT_PREFIX + PUS_TM_MIN + (size))

static void a_full_ring_drops_and_counts_reports_and_takes_new_ones_later(void)
{
    // Reports that do not answer a request of the ground.
    const unsigned plain = (PUS_PLAIN_SIZE - PUS_ANSWER_ROOM) / KEPT(2U);
    const unsigned firm  = PUS_FIRM_SIZE / KEPT(2U);
    for (unsigned round = 1U; round <= 2U; round++) {
        bench_clear();
        for (unsigned i = 0U; i < (plain + 5U); i++) {
            TEST_ASSERT_EQUAL((i < plain) ? STATUS_OK : STATUS_EXHAUSTED, post_refused(5U, 2U, 0U, 2U));
        }
        for (unsigned i = 0U; i < (firm + 3U); i++) {
            TEST_ASSERT_EQUAL((i < firm) ? STATUS_OK : STATUS_EXHAUSTED, post_refused(5U, 4U, 0U, 2U));
        }
        TEST_ASSERT_EQUAL_UINT32(round * 8U, bench.process.counters.lost);
        TEST_ASSERT_EQUAL_UINT32(round * 3U, bench.process.counters.lost_firm);
        TEST_ASSERT_EQUAL_UINT32(round * (plain + firm), bench.process.counters.kept);
        TEST_ASSERT_TRUE(pus_app_process_is_waiting(&bench.process));
        TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
        TEST_ASSERT_FALSE(pus_app_process_is_waiting(&bench.process));
        TEST_ASSERT_EQUAL_UINT64(plain + firm, bench.count);
        // The sequence counts have no gap, whichever reports were lost.
        for (unsigned i = 0U; i < (plain + firm); i++) {
            TEST_ASSERT_EQUAL_UINT16(((round - 1U) * (plain + firm)) + i, bench_report(i).sequence);
        }
    }
}

static void a_firm_report_overtakes_and_each_class_keeps_its_order(void)
{
    static const uint8_t expected[][2] = {{5, 4},   {1, 8}, {129, 2}, {130, 10},
                                          {131, 2}, {5, 2}, {17, 2},  {5, 1}};
    static const uint8_t order[]       = {5, 0, 6, 1, 7, 2, 3, 4};
    for (unsigned i = 0U; i < 8U; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, post_refused(expected[order[i]][0], expected[order[i]][1], 0U, 4U));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    for (unsigned i = 0U; i < 8U; i++) {
        TEST_ASSERT_EQUAL_UINT8(expected[i][0], bench_report(i).service);
        TEST_ASSERT_EQUAL_UINT8(expected[i][1], bench_report(i).subtype);
        TEST_ASSERT_EQUAL_UINT16(i, bench_report(i).sequence);
    }
}

static void the_end_of_a_request_follows_its_answer(void)
{
    static const uint8_t expected[][3] = {{5, 4, 0}, {1, 7, 2},  {5, 2, 0}, {17, 2, 1},
                                          {1, 7, 1}, {20, 2, 1}, {1, 8, 1}};
    static const uint8_t order[]       = {2, 3, 4, 0, 1, 5, 6};
    for (unsigned i = 0U; i < 7U; i++) {
        const uint8_t* const report = expected[order[i]];
        TEST_ASSERT_EQUAL(STATUS_OK, post_refused(report[0], report[1], report[2], 4U));
    }
    bench.refusals        = 1U;
    octet_writer_t writer = begin(1U, 7U, 1U);
    TEST_ASSERT_EQUAL(STATUS_FULL, pus_tm_send(&bench.process, &writer));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    for (unsigned i = 0U; i < 7U; i++) {
        TEST_ASSERT_EQUAL_UINT8(expected[i][0], bench_report(i).service);
        TEST_ASSERT_EQUAL_UINT16(expected[i][2], bench_report(i).destination);
    }
    // A notice of an event is not an answer; if an answer leaves no room for the completion, the completion
    // is sent first.
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(129U, 7U, 3U, 3U));
    while (post_refused(20U, 2U, 4U, 1000U) == STATUS_OK) {
    }
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(1U, 7U, 3U, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(1U, 8U, 4U, 2000U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL_UINT16(3U, bench_report(0U).destination);
    TEST_ASSERT_EQUAL_UINT8(8U, bench_report(1U).subtype);
    TEST_ASSERT_EQUAL_UINT8(129U, bench_report(2U).service);
}

static void a_process_with_one_ring_keeps_the_order_of_all_classes(void)
{
    static uint8_t queue[256];
    const pus_port_t port = bench_port();
    pus_app_process_init(&bench.process, TEST_APID, TEST_EPOCH_S, &port);
    pus_app_process_keep_in_order(&bench.process, queue, sizeof queue);
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(20U, 2U, 1U, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(5U, 2U, 0U, 4U));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(1U, 7U, 1U, 4U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, post_refused(20U, 2U, 1U, 256U - (4U * KEPT(0U)) - 11U));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(20U, 2U, 1U, 256U - (4U * KEPT(0U)) - 12U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL_UINT8(20U, bench_report(0U).service);
    TEST_ASSERT_EQUAL_UINT8(5U, bench_report(1U).service);
    TEST_ASSERT_EQUAL_UINT8(1U, bench_report(2U).service);
}

static void a_firm_report_does_not_wait_for_plain_ones(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(5U, 2U, 0U, 2U));
    octet_writer_t writer = begin(5U, 4U, 0U);
    octet_write_u16(&writer, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_post(&bench.process, &writer)); // The port takes it now.
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
    TEST_ASSERT_EQUAL_UINT8(4U, bench_report(0U).subtype);
    TEST_ASSERT_TRUE(pus_app_process_is_waiting(&bench.process));
}

static void reports_of_class_bulk_are_never_kept(void)
{
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, post_refused(3U, 25U, 0U, 2U));
    TEST_ASSERT_FALSE(pus_app_process_is_waiting(&bench.process));
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.lost);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.process.counters.kept);
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(5U, 2U, 0U, 2U));
    bench.refusals        = 1U;
    octet_writer_t writer = begin(3U, 25U, 0U);
    // A bulk report does not overtake other reports.
    TEST_ASSERT_EQUAL(STATUS_FULL, pus_tm_send(&bench.process, &writer));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
}

static void a_process_without_rings_keeps_nothing(void)
{
    const pus_port_t port = bench_port();
    pus_app_process_init(&bench.process, TEST_APID, TEST_EPOCH_S, &port);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, post_refused(1U, 7U, 1U, 4U));
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, post_refused(5U, 2U, 0U, 4U));
    TEST_ASSERT_EQUAL_UINT32(2U, bench.process.counters.lost);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
}

static void an_answer_has_room_however_many_unrequested_reports_wait(void)
{
    while (post_refused(5U, 2U, 0U, 2U) == STATUS_OK) {
    }
    // The notice of an event that is not HIGH does not answer a request, either.
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, post_refused(129U, 7U, PUS_USER_SUPERVISOR, 3U));
    TEST_ASSERT_TRUE(pus_app_process_may_answer(&bench.process));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(20U, 2U, 1U, PUS_TM_DATA_MAX));
    TEST_ASSERT_FALSE(pus_app_process_may_answer(&bench.process));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_TRUE(pus_app_process_may_answer(&bench.process));
}

static void an_answer_is_possible_down_to_the_exact_room_that_it_needs(void)
{
    size_t rest = PUS_PLAIN_SIZE - PUS_ANSWER_ROOM;
    while (rest > 0U) { // Unrequested reports that together leave exactly this room.
        const size_t size = (rest < (2U * KEPT(200U))) ? rest : KEPT(200U);
        TEST_ASSERT_EQUAL(STATUS_OK, post_refused(5U, 2U, 0U, size - KEPT(0U)));
        rest -= size;
    }
    TEST_ASSERT_TRUE(pus_app_process_may_answer(&bench.process));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(20U, 2U, 1U, 0U));
    TEST_ASSERT_FALSE(pus_app_process_may_answer(&bench.process));
}

static void a_request_is_accepted_while_its_verification_has_room(void)
{
    const size_t needed = PUS_FIRM_OF_REQUEST + PUS_FIRM_STANDING + PUS_FIRM_EVENTS;
    // The remaining room is exactly the room that is needed.
    const size_t data = PUS_FIRM_SIZE - needed - KEPT(0U);
    TEST_ASSERT_TRUE(pus_app_process_has_firm_room(&bench.process));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(5U, 4U, 0U, data));
    TEST_ASSERT_TRUE(pus_app_process_may_answer(&bench.process));
    TEST_ASSERT_TRUE(pus_app_process_has_firm_room(&bench.process));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(5U, 4U, 0U, data + 1U));
    TEST_ASSERT_FALSE(pus_app_process_may_answer(&bench.process));
    TEST_ASSERT_FALSE(pus_app_process_has_firm_room(&bench.process));
    for (unsigned i = 0U; i < 8U; i++) { // The longest verification report: a step has failed.
        TEST_ASSERT_EQUAL(STATUS_OK, post_refused(1U, 6U, 1U, 4U + 2U + 8U));
    }
    TEST_ASSERT_TRUE(KEPT(4U + 2U + 8U) <= PUS_FIRM_REPORT);
}

/// Post a report with the id of an event in its first two octets; the port refuses it.
static void post_of_event(const uint8_t service, const uint8_t subtype, const uint16_t event_id)
{
    octet_writer_t writer = begin(service, subtype, 0U);
    octet_write_u16(&writer, event_id);
    octet_write_u8(&writer, (uint8_t)PUS_SEVERITY_HIGH); // Position of the severity in a notice.
    bench.refusals = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_post(&bench.process, &writer));
    bench.refusals = 0U;
}

static void an_event_that_waits_is_kept_until_it_is_sent(void)
{
    TEST_ASSERT_FALSE(pus_app_process_keeps_event(&bench.process, 7U));
    post_of_event(1U, 7U, 7U); // This report is not an event, although its octets look like one.
    post_of_event(5U, 2U, 7U); // pus_app_process_keeps_event finds only HIGH events.
    TEST_ASSERT_FALSE(pus_app_process_keeps_event(&bench.process, 7U));
    post_of_event(5U, 4U, 7U);
    post_of_event(129U, 7U, 8U); // The notice of another event.
    post_of_event(129U, 2U, 9U); // A transition.
    TEST_ASSERT_TRUE(pus_app_process_keeps_event(&bench.process, 7U));
    TEST_ASSERT_TRUE(pus_app_process_keeps_event(&bench.process, 8U));
    TEST_ASSERT_FALSE(pus_app_process_keeps_event(&bench.process, 9U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL_UINT64(5U, bench.count);
    TEST_ASSERT_FALSE(pus_app_process_keeps_event(&bench.process, 7U));
    TEST_ASSERT_FALSE(pus_app_process_keeps_event(&bench.process, 8U));
}

static void the_largest_answer_can_be_queued(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, post_refused(20U, 2U, 9U, PUS_TM_DATA_MAX));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL_UINT64(PUS_PACKET_MAX, bench.sizes[0]);
    TEST_ASSERT_EQUAL_UINT64(PUS_TM_DATA_MAX, bench_report(0U).size);
}

static void a_report_that_does_not_fit_is_refused_completely(void)
{
    static uint8_t data[PUS_TM_DATA_MAX + 1U];
    octet_writer_t writer = begin(3U, 25U, 0U);
    octet_write_octets(&writer, data, sizeof data);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, pus_tm_send(&bench.process, &writer));
    TEST_ASSERT_EQUAL_UINT64(0U, bench.count);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.oversized);
    TEST_ASSERT_EQUAL(STATUS_OK, send(1U));
    TEST_ASSERT_EQUAL_UINT16(0U, bench_report(0U).sequence);
}

/// Build a report with `room` octets for its data, of which it uses `used`. Returns the status of its end.
static status_t close_large(const size_t room, const size_t used, size_t* const out_size)
{
    static uint8_t octets[PUS_LARGE_MAX + 1U];
    static const uint8_t data[PUS_LARGE_MAX + 1U];
    octet_writer_t writer =
        pus_tm_begin_large(&bench.process, octets, PUS_TM_MIN + room, 3U, 25U, 0U, TEST_NOW_NS);
    octet_write_octets(&writer, data, used);
    return pus_tm_close_large(&bench.process, &writer, out_size);
}

static void a_large_report_is_limited_by_its_buffer_and_by_the_length_field(void)
{
    const size_t most = PUS_LARGE_MAX - PUS_TM_MIN;
    size_t size       = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, close_large(most, most, &size));
    TEST_ASSERT_EQUAL_UINT64(PUS_LARGE_MAX, size);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, close_large(most + 1U, most + 1U, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, close_large(8U, 9U, &size));
    TEST_ASSERT_EQUAL_UINT64(0U, size);
    TEST_ASSERT_EQUAL_UINT32(2U, bench.process.counters.oversized);
}

static void a_report_begun_within_another_is_sent_and_the_outer_one_is_refused(void)
{
    octet_writer_t outer = begin(3U, 25U, 0U);
    octet_write_u8(&outer, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, send(2U));
    octet_write_u8(&outer, 3U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tm_send(&bench.process, &outer));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tm_post(&bench.process, &outer));
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
    TEST_ASSERT_EQUAL_UINT8(2U, bench_report(0U).data[0]);
    TEST_ASSERT_EQUAL_UINT32(3U, bench.process.counters.discarded);
}

static void a_report_is_sent_once_and_can_be_cancelled(void)
{
    octet_writer_t writer = begin(3U, 25U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&bench.process, &writer));
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tm_send(&bench.process, &writer));
    writer = begin(3U, 25U, 0U);
    pus_tm_cancel(&bench.process);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_tm_send(&bench.process, &writer));
    TEST_ASSERT_EQUAL_UINT64(1U, bench.count);
}

static void more_message_types_than_counters_are_sent_uncounted(void)
{
    for (unsigned i = 0U; i < (PUS_MESSAGE_COUNTERS + 2U); i++) {
        for (unsigned k = 0U; k < 2U; k++) {
            bench_clear();
            octet_writer_t writer = begin(5U, 1U, (uint16_t)i);
            TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_send(&bench.process, &writer));
            TEST_ASSERT_EQUAL_UINT16((i < PUS_MESSAGE_COUNTERS) ? k : 0U, bench_report(0U).counter);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(4U, bench.process.counters.uncounted);
}

static void a_report_of_another_process_gets_new_numbers_and_keeps_its_time(void)
{
    uint8_t packet[PUS_PACKET_MAX];
    TEST_ASSERT_EQUAL(STATUS_OK, send(1U));
    const size_t size = bench.sizes[0];
    (void)memcpy(packet, bench.packets[0], size);
    TEST_ASSERT_EQUAL(STATUS_OK, send(2U));
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_forward(&bench.process, packet, size));
    const pus_tm_t tm = bench_report(2U);
    TEST_ASSERT_EQUAL_UINT16(2U, tm.sequence);
    TEST_ASSERT_EQUAL_UINT16(2U, tm.counter);
    TEST_ASSERT_EQUAL_UINT64((TEST_EPOCH_S * 1000000000ULL) + TEST_NOW_NS, tm.time_ns);
    TEST_ASSERT_EQUAL_UINT64(1U, tm.size);
    TEST_ASSERT_EQUAL_UINT8(1U, tm.data[0]);
    (void)begin(5U, 1U, 0U); // A report that is never sent.
    bench.refusals = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_tm_forward(&bench.process, packet, size)); // The report is kept.
    TEST_ASSERT_EQUAL_UINT32(1U, bench.process.counters.discarded);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_app_process_flush(&bench.process));
    TEST_ASSERT_EQUAL_UINT16(3U, bench_report(3U).sequence);
}

static void start_with_apid_0(void)
{
    const pus_port_t port = bench_port();
    pus_app_process_init(&bench.process, 0U, 0U, &port);
}

static void apid_0_is_refused(void)
{
    TEST_ASSERT_TRUE(assertion_fails(start_with_apid_0));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_report_is_a_complete_packet);
    RUN_TEST(types_and_destinations_are_counted_separately);
    RUN_TEST(a_refused_report_leaves_no_gap);
    RUN_TEST(the_sequence_wraps_after_16384);
    RUN_TEST(posted_reports_wait_and_keep_their_order);
    RUN_TEST(a_full_ring_drops_and_counts_reports_and_takes_new_ones_later);
    RUN_TEST(a_firm_report_overtakes_and_each_class_keeps_its_order);
    RUN_TEST(the_end_of_a_request_follows_its_answer);
    RUN_TEST(a_process_with_one_ring_keeps_the_order_of_all_classes);
    RUN_TEST(a_firm_report_does_not_wait_for_plain_ones);
    RUN_TEST(reports_of_class_bulk_are_never_kept);
    RUN_TEST(a_process_without_rings_keeps_nothing);
    RUN_TEST(an_answer_has_room_however_many_unrequested_reports_wait);
    RUN_TEST(an_answer_is_possible_down_to_the_exact_room_that_it_needs);
    RUN_TEST(a_request_is_accepted_while_its_verification_has_room);
    RUN_TEST(an_event_that_waits_is_kept_until_it_is_sent);
    RUN_TEST(the_largest_answer_can_be_queued);
    RUN_TEST(a_report_that_does_not_fit_is_refused_completely);
    RUN_TEST(a_large_report_is_limited_by_its_buffer_and_by_the_length_field);
    RUN_TEST(a_report_begun_within_another_is_sent_and_the_outer_one_is_refused);
    RUN_TEST(a_report_is_sent_once_and_can_be_cancelled);
    RUN_TEST(more_message_types_than_counters_are_sent_uncounted);
    RUN_TEST(a_report_of_another_process_gets_new_numbers_and_keeps_its_time);
    RUN_TEST(apid_0_is_refused);
    return UNITY_END();
}
