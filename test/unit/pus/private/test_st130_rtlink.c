// SPDX-License-Identifier: Apache-2.0
// The subsystem's side of ST[130]: offers, opening, closing and status of real-time links. The numbers of
// requests and reports are subtypes; pus/catalogue/private/st130_links.txt has their names and fields.
#include "pus/private/st130_rtlink.h"

#include "test/unit/pus/fixtures/reports.h"
#include "unity.h"

#include <string.h>

static struct {
    pus_reply_t reply;
    unsigned calls;
    unsigned offers;   // Number of offers; their ids are 1, 2 ..
    unsigned statuses; // Number of links with a status; their ids are 1, 2 ..
    pus_link_answer_t answer;
    pus_link_request_t request;
    pus_link_open_t open;
    pus_link_close_t close;
} seen;

static const pus_link_properties_t properties = {.layout_hash        = 0x01020304U,
                                                 .layout_size        = 0x11121314U,
                                                 .byte_order         = 1U,
                                                 .period_us          = 500U,
                                                 .tolerance_permille = 10U,
                                                 .method             = PUS_METHOD_UDP,
                                                 .depth              = 3U,
                                                 .age_max_us         = 2000U};
static const uint8_t properties_octets[21]    = {1, 2,    3, 4,  0x11, 0x12, 0x13, 0x14, 1, 0,   0,
                                                 1, 0xF4, 0, 10, 2,    3,    0,    0,    7, 0xD0};

static bool offer(void* const context, const uint16_t index, pus_link_offer_t* const out_offer)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    *out_offer = (pus_link_offer_t){
        .port = (uint16_t)(index + 1U), .role = PUS_LINK_CONSUMER, .properties = properties};
    return index < seen.offers;
}

static bool link_status(void* const context, const uint16_t index, pus_link_status_t* const out_status)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    *out_status = (pus_link_status_t){.link          = (uint16_t)(index + 1U),
                                      .state         = PUS_LINK_STATE_OPEN,
                                      .ends          = {16U, 1U, 17U, 2U},
                                      .properties    = properties,
                                      .sent          = 1U,
                                      .received      = 2U,
                                      .lost          = 3U,
                                      .late          = 4U,
                                      .last_sequence = 5U};
    return index < seen.statuses;
}

static pus_reply_t request_link(void* const context, const pus_link_request_t* const request,
                                pus_link_answer_t* const out_answer, const pus_token_t* const token,
                                const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, now_ns);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, token->request_id);
    seen.calls++;
    seen.request = *request;
    *out_answer  = seen.answer;
    return seen.reply;
}

static pus_reply_t open_link(void* const context, const pus_link_open_t* const open,
                             const pus_token_t* const token, const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, now_ns);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, token->request_id);
    seen.calls++;
    seen.open = *open;
    return seen.reply;
}

static pus_reply_t close_link(void* const context, const pus_link_close_t* const close,
                              const pus_token_t* const token, const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&seen, context);
    TEST_ASSERT_EQUAL_UINT64(TEST_NOW_NS, now_ns);
    TEST_ASSERT_EQUAL_HEX32(bench.request_id, token->request_id);
    seen.calls++;
    seen.close = *close;
    return seen.reply;
}

static pus_rtlink_t rtlink;

void setUp(void)
{
    const pus_rtlink_port_t port = {.context = &seen,
                                    .offer   = offer,
                                    .request = request_link,
                                    .open    = open_link,
                                    .close   = close_link,
                                    .status  = link_status};
    memset(&seen, 0, sizeof seen);
    seen.offers   = 3U;
    seen.statuses = 3U;
    bench_start();
    memset(&rtlink, 0xA5, sizeof rtlink);
    pus_rtlink_init(&rtlink, &port);
    bench_serve(pus_rtlink_service(&rtlink));
}

void tearDown(void)
{
}

/// Expect that report 2 is TM[130,2] with the offers of exactly these ports.
static void expect_offers(const uint8_t* const ports, const uint16_t count)
{
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL_UINT16(count, octet_read_u16(&reader));
    for (uint16_t i = 0U; i < count; i++) {
        TEST_ASSERT_EQUAL_UINT16(ports[i], octet_read_u16(&reader));
        TEST_ASSERT_EQUAL_UINT8(PUS_LINK_CONSUMER, octet_read_u8(&reader));
        TEST_ASSERT_EQUAL_HEX8_ARRAY(properties_octets, octet_read_octets(&reader, 21U), 21U);
    }
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
}

static void all_or_some_offers_are_reported(void)
{
    static const uint8_t some[] = {2, 0, 3, 0, 1};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, "\0", 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 130, 2, 1, 7);
    expect_offers((const uint8_t[]){1, 2, 3}, 3U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, some, sizeof some));
    EXPECT_MESSAGES(1, 1, 1, 3, 130, 2, 1, 7);
    expect_offers((const uint8_t[]){1, 3}, 2U); // The offers are in the order of the table.
}

static void unknown_ports_are_refused_alone_and_no_offers_are_an_empty_list(void)
{
    static const uint8_t some[] = {2, 0, 9, 0, 2};
    static const uint8_t none[] = {1, 0, 9};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, some, sizeof some));
    EXPECT_MESSAGES(1, 1, 1, 4, 1, 3, 130, 2, 1, 8);
    expect_failure(1U, 4U, PUS_FAILURE_UNKNOWN_ID, 1U, 9U);
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, none, sizeof none));
    EXPECT_MESSAGES(1, 1, 1, 4);
    bench_clear();
    seen.offers = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(1U, "\0", 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 130, 2, 1, 7);
    TEST_ASSERT_EQUAL_UINT64(2U, bench_report(2U).size);
}

static void more_entries_than_a_report_holds_fail_the_request(void)
{
    const unsigned room = (PUS_TM_DATA_MAX - 2U) / 52U; // A count of 2 octets and entries of 52 octets.
    seen.statuses       = room;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, "\0", 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 130, 9, 1, 7);
    bench_clear();
    seen.statuses = room + 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, "\0", 1U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 8);
    expect_failure(2U, 8U, PUS_FAILURE_TABLE_FULL, 0U, PUS_TM_DATA_MAX);
    static const uint8_t one[] = {1, 0, 2}; // One of the entries still fits into the packet.
    bench_clear();
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, one, sizeof one));
    EXPECT_MESSAGES(1, 1, 1, 3, 130, 9, 1, 7);
}

static void status_contains_ends_properties_and_counters(void)
{
    static const uint8_t one[] = {1, 0, 2};
    // One link: link 2, state 3, producer 16 port 1, consumer 17 port 2; at the end the five counters.
    static const uint8_t head[] = {0, 1, 0, 2, 3, 0, 16, 0, 1, 0, 17, 0, 2};
    static const uint8_t tail[] = {0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0, 5};
    pus_link_status_t read;
    uint16_t count = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, one, sizeof one));
    const pus_tm_t tm = bench_report(2U);
    TEST_ASSERT_EQUAL_UINT64(54U, tm.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(head, tm.data, sizeof head);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(properties_octets, &tm.data[13], 21U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(tail, &tm.data[34], sizeof tail);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_link_statuses_read(&reader, &count));
    pus_link_status_read(&reader, &read);
    TEST_ASSERT_TRUE(octet_reader_is_done(&reader));
    TEST_ASSERT_EQUAL_UINT16(17U, read.ends.consumer_apid);
    TEST_ASSERT_EQUAL_UINT32(5U, read.last_sequence);
    for (size_t size = 0U; size < tm.size; size++) {
        reader = octet_reader(tm.data, size);
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_link_statuses_read(&reader, &count));
        TEST_ASSERT_EQUAL_UINT16(0U, count);
    }
}

/// Compose TC[130,3] as a manager does.
static size_t write_request(uint8_t* const octets, const size_t capacity)
{
    const pus_link_request_t request = {
        .transaction = 0x51525354U, .link = 7U, .ends = {16U, 1U, 17U, 2U}, .properties = properties};
    octet_writer_t writer = octet_writer(octets, capacity);
    pus_link_request_write(&writer, &request);
    TEST_ASSERT_FALSE(writer.failed);
    return writer.position;
}

static void an_accepted_link_is_reported_and_completed(void)
{
    static const uint8_t accept[] = {0x51, 0x52, 0x53, 0x54, 0, 7};
    static const uint8_t end[]    = {2, 3, 'a', 'b', 'c'};
    uint8_t octets[64];
    pus_link_accept_t read;
    const size_t size = write_request(octets, sizeof octets);
    TEST_ASSERT_EQUAL_UINT64(35U, size);
    seen.answer = (pus_link_answer_t){
        .is_accepted = true,
        .accept = {.link = 7U, .properties = properties, .endpoint = {PUS_METHOD_UDP, 3U, {'a', 'b', 'c'}}}};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, octets, size));
    EXPECT_MESSAGES(1, 1, 1, 3, 130, 4, 1, 7);
    TEST_ASSERT_EQUAL_UINT16(7U, seen.request.link);
    TEST_ASSERT_EQUAL_UINT16(2U, seen.request.ends.consumer_port);
    TEST_ASSERT_EQUAL_UINT16(10U, seen.request.properties.tolerance_permille);
    const pus_tm_t tm = bench_report(2U);
    TEST_ASSERT_EQUAL_UINT64(6U + 21U + 5U, tm.size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(accept, tm.data, sizeof accept);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(end, &tm.data[27], sizeof end);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_link_accept_read(&reader, &read));
    TEST_ASSERT_EQUAL_HEX32(0x51525354U, read.transaction);
    TEST_ASSERT_EQUAL_UINT8(3U, read.endpoint.size);
    TEST_ASSERT_EQUAL_MEMORY("abc", read.endpoint.octets, 3U);
    for (size_t cut = 0U; cut < tm.size; cut++) {
        reader = octet_reader(tm.data, cut);
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_link_accept_read(&reader, &read));
    }
}

static void a_refused_link_names_reason_and_field(void)
{
    uint8_t octets[64];
    pus_link_refuse_t read;
    const size_t size = write_request(octets, sizeof octets);
    seen.answer       = (pus_link_answer_t){.refuse = {.reason    = PUS_LINK_REASON_PERIOD,
                                                       .field     = PUS_LINK_FIELD_PERIOD,
                                                       .supported = properties}};
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, octets, size));
    EXPECT_MESSAGES(1, 1, 1, 3, 130, 5, 1, 8);
    expect_failure(3U, 8U, PUS_FAILURE_LINK_REFUSED, 0U, 0x0304U);
    octet_reader_t reader = bench_data(2U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_link_refuse_read(&reader, &read));
    TEST_ASSERT_EQUAL_HEX32(0x51525354U, read.transaction);
    TEST_ASSERT_EQUAL_UINT8(3U, read.reason);
    TEST_ASSERT_EQUAL_UINT32(500U, read.supported.period_us);
    reader = octet_reader(bench_report(2U).data, 26U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_link_refuse_read(&reader, &read));
    bench_clear();
    seen.reply = pus_later(); // The manager must query the members before it answers.
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, octets, size));
    EXPECT_MESSAGES(1, 1, 1, 3);
    bench_clear();
    seen.reply = pus_refused(PUS_FAILURE_STATE, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(3U, octets, size));
    EXPECT_MESSAGES(1, 1, 1, 4);
}

static void a_link_is_opened_and_closed(void)
{
    const pus_link_open_t open    = {.link = 7U, .epoch = 9U};
    const pus_link_close_t close  = {.link = 7U, .reason = PUS_LINK_REASON_PEER};
    static const uint8_t opened[] = {0, 7, 0, 0, 0, 9};
    static const uint8_t closed[] = {0, 7, 10};
    uint8_t octets[64];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    pus_link_open_write(&writer, &open);
    TEST_ASSERT_EQUAL_UINT64(sizeof opened, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(opened, octets, sizeof opened);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(6U, octets, writer.position));
    TEST_ASSERT_EQUAL_UINT16(7U, seen.open.link);
    TEST_ASSERT_EQUAL_UINT32(9U, seen.open.epoch);
    expect_strict_format(6U, opened, sizeof opened);
    writer = octet_writer(octets, sizeof octets);
    pus_link_close_write(&writer, &close);
    TEST_ASSERT_EQUAL_UINT64(sizeof closed, writer.position);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(closed, octets, sizeof closed);
    TEST_ASSERT_EQUAL(STATUS_OK, bench_request(7U, octets, writer.position));
    TEST_ASSERT_EQUAL_UINT8(PUS_LINK_REASON_PEER, seen.close.reason);
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    expect_strict_format(7U, closed, sizeof closed);
}

/// TM[130,4] of 27 octets before the endpoint, whose size is its second octet.
static void an_endpoint_longer_than_32_octets_makes_the_report_invalid(void)
{
    static uint8_t octets[27U + 2U + 255U];
    pus_link_accept_t read;
    for (unsigned size = 0U; size < 256U; size++) {
        octets[28]            = (uint8_t)size;
        octet_reader_t reader = octet_reader(octets, 29U + size);
        const bool fits       = size <= PUS_ENDPOINT_MAX;
        TEST_ASSERT_EQUAL(fits ? STATUS_OK : STATUS_INVALID, pus_link_accept_read(&reader, &read));
        TEST_ASSERT_EQUAL_UINT8(fits ? size : 0U, read.endpoint.size);
    }
}

static void a_transition_is_reported_to_all_with_its_time(void)
{
    const pus_link_transition_t transition = {.link     = 7U,
                                              .previous = PUS_LINK_STATE_OPEN,
                                              .state    = PUS_LINK_STATE_STALE,
                                              .cause    = PUS_LINK_REASON_STALE,
                                              .time_ns  = 500000000U};
    pus_link_transition_t read;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_link_transition_report(&bench.process, &transition, TEST_NOW_NS));
    EXPECT_MESSAGES(130, 10);
    TEST_ASSERT_EQUAL_UINT16(PUS_USER_GROUND, bench_report(0U).destination);
    octet_reader_t reader = bench_data(0U);
    TEST_ASSERT_EQUAL(STATUS_OK, pus_link_transition_read(&reader, &read));
    TEST_ASSERT_EQUAL_UINT16(7U, read.link);
    TEST_ASSERT_EQUAL_UINT8(PUS_LINK_STATE_STALE, read.state);
    TEST_ASSERT_EQUAL_UINT64((TEST_EPOCH_S * 1000000000ULL) + 500000000U, read.time_ns);
    for (size_t size = 0U; size < 13U; size++) {
        reader = octet_reader(bench_report(0U).data, size);
        TEST_ASSERT_EQUAL(STATUS_INVALID, pus_link_transition_read(&reader, &read));
    }
    uint8_t longer[14] = {0U};
    memcpy(longer, bench_report(0U).data, 13U);
    reader = octet_reader(longer, sizeof longer);
    TEST_ASSERT_EQUAL(STATUS_INVALID, pus_link_transition_read(&reader, &read));
}

static void every_request_has_a_strict_format(void)
{
    static const uint8_t list[] = {2, 0, 1, 0, 2};
    uint8_t octets[64];
    const size_t size = write_request(octets, sizeof octets);
    expect_strict_format(1U, list, sizeof list);
    expect_strict_format(8U, list, sizeof list);
    expect_strict_format(3U, octets, size);
    TEST_ASSERT_EQUAL_UINT32(0U, seen.calls);
    for (unsigned count = 0U; count < 256U; count++) {
        uint8_t many[1U + (255U * 2U)] = {0};
        many[0]                        = (uint8_t)count;
        bench_clear();
        TEST_ASSERT_EQUAL(STATUS_OK, bench_request(8U, many, 1U + (2U * count)));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(all_or_some_offers_are_reported);
    RUN_TEST(unknown_ports_are_refused_alone_and_no_offers_are_an_empty_list);
    RUN_TEST(more_entries_than_a_report_holds_fail_the_request);
    RUN_TEST(status_contains_ends_properties_and_counters);
    RUN_TEST(an_accepted_link_is_reported_and_completed);
    RUN_TEST(a_refused_link_names_reason_and_field);
    RUN_TEST(a_link_is_opened_and_closed);
    RUN_TEST(an_endpoint_longer_than_32_octets_makes_the_report_invalid);
    RUN_TEST(a_transition_is_reported_to_all_with_its_time);
    RUN_TEST(every_request_has_a_strict_format);
    return UNITY_END();
}
