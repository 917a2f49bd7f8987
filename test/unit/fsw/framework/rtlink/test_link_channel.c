// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/rtlink/link_channel.h"

#include "test/unit/fsw/framework/rtlink/links.h"
#include "unity.h"

#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define LINK 1U
#define OCTETS 20U
#define PAGE_MAX 65536U
#define SLOT_OCTETS 56U // Counter, header and a sample of three words.
#define MS 1000000ULL

static rtlink_producer_t producer;
static rtlink_consumer_t consumer;
static rtlink_method_t method;

void setUp(void)
{
    links_open();
}

void tearDown(void)
{
    rtlink_consumer_close(&consumer);
    rtlink_producer_close(&producer);
    links_close();
}

static void open_both(uint32_t epoch)
{
    const rtlink_terms_t terms = links_terms(method, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &links, LINK, &terms, epoch));
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(&consumer, &links, LINK, &terms, epoch));
}

static void write_number(uint32_t number, uint64_t now_ns)
{
    uint8_t payload[OCTETS];
    (void)memset(payload, (int)(number & 0xFFU), sizeof payload);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_write(&producer, (uint8_t)(number % 10U), now_ns, payload));
}

/// Receive what arrived by UDP, then read.
static status_t read_at(uint64_t now_ns)
{
    while (links_under_way() > 0U) {
        uint8_t frame[LINK_FRAME_MAX];
        const size_t size = links_receive(frame);
        (void)rtlink_consumer_deliver(&consumer, frame, size);
    }
    return rtlink_consumer_read(&consumer, now_ns);
}

static void expect_number(uint32_t number)
{
    for (size_t i = 0U; i < OCTETS; i++) {
        TEST_ASSERT_EQUAL_HEX8(number & 0xFFU, consumer.payload[i]);
    }
    TEST_ASSERT_EQUAL(number % 10U, consumer.peer_state);
}

static void over_each_method(void (*act)(void))
{
    static const rtlink_method_t methods[] = {RTLINK_METHOD_SHARED_MEMORY, RTLINK_METHOD_UDP,
                                              RTLINK_METHOD_TIPC};
    for (unsigned i = 0U; i < (sizeof methods / sizeof methods[0]); i++) {
        method = methods[i];
        act();
        rtlink_consumer_close(&consumer);
        rtlink_producer_close(&producer);
        while (links_under_way() > 0U) {
            uint8_t frame[LINK_FRAME_MAX];
            (void)links_receive(frame);
        }
    }
}

// ---- Samples ----

static void open_write_and_close(void)
{
    const uint8_t payload[OCTETS] = {0U};
    rtlink_producer_close(&producer);
    rtlink_consumer_close(&consumer);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_producer_write(&producer, 3U, 0U, payload));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_consumer_read(&consumer, 0U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_consumer_deliver(&consumer, payload, sizeof payload));
    open_both(1U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(0U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(100U * MS));
    write_number(5U, 100U * MS);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(100U * MS));
    expect_number(5U);
    TEST_ASSERT_EQUAL(100U * MS, consumer.sample_time_ns);
    rtlink_producer_close(&producer);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_producer_write(&producer, 3U, 0U, payload));
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(101U * MS)); // A value is available until it is stale.
    TEST_ASSERT_EQUAL(STATUS_STALE, read_at(103U * MS));
    rtlink_consumer_close(&consumer);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_consumer_read(&consumer, 0U));
}

static void a_link_exists_from_open_to_close(void)
{
    over_each_method(open_write_and_close);
}

static void overwrite(void)
{
    open_both(1U);
    for (uint32_t i = 0U; i < 100U; i++) {
        write_number(i, i * MS);
        if ((i % 7U) == 6U) {
            TEST_ASSERT_EQUAL(STATUS_OK, read_at(i * MS));
            expect_number(i);
            TEST_ASSERT_EQUAL(i, consumer.counters.last_sequence);
            // Read again: the same sample, and no sample is missing.
            TEST_ASSERT_EQUAL(STATUS_OK, read_at(i * MS));
            expect_number(i);
        }
    }
    TEST_ASSERT_EQUAL(100U, producer.counters.frames);
    TEST_ASSERT_EQUAL(0U, producer.counters.lost + consumer.counters.torn + consumer.counters.refused);
}

static void the_latest_sample_is_read(void)
{
    over_each_method(overwrite);
}

static void age(void)
{
    open_both(1U);
    write_number(1U, 50U * MS);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(50U * MS));
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(52U * MS)); // max_age_us is 2000.
    TEST_ASSERT_EQUAL(0U, consumer.counters.late);
    TEST_ASSERT_EQUAL(STATUS_STALE, read_at((52U * MS) + 1U));
    TEST_ASSERT_EQUAL(STATUS_STALE, read_at(UINT64_MAX));
    TEST_ASSERT_EQUAL(2U, consumer.counters.late);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U)); // A sample of a producer whose clock is ahead is not stale.
    expect_number(1U);
    write_number(2U, 60U * MS);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(61U * MS));
    expect_number(2U);
}

static void a_sample_is_stale_only_beyond_the_largest_age(void)
{
    over_each_method(age);
}

static void skip(uint32_t decimation, const uint32_t* steps, uint32_t count, uint32_t expected_lost)
{
    method                     = RTLINK_METHOD_SHARED_MEMORY; // UDP would deliver every frame.
    const rtlink_terms_t terms = links_terms(method, OCTETS);
    rtlink_terms_t own         = terms;
    own.decimation             = decimation;
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &links, LINK, &terms, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(&consumer, &links, LINK, &own, 1U));
    uint32_t number = 0U;
    for (uint32_t i = 0U; i < count; i++) {
        for (uint32_t k = 0U; k < steps[i]; k++) {
            write_number(number++, 0U);
        }
        TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U));
        TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U)); // Reading the same value again gives no new sample.
    }
    TEST_ASSERT_EQUAL(expected_lost, consumer.counters.lost);
    TEST_ASSERT_EQUAL(count, consumer.counters.frames);
    rtlink_consumer_close(&consumer);
    rtlink_producer_close(&producer);
}

static void losses_are_counted_in_samples_that_were_due(void)
{
    static const uint32_t each[] = {1U, 1U, 1U, 1U};
    // Samples written before the first read do not count as missed.
    static const uint32_t gaps[]     = {5U, 1U, 3U, 1U, 2U};
    static const uint32_t fourths[]  = {4U, 4U, 4U};
    static const uint32_t missing[]  = {4U, 8U, 12U, 4U};
    static const uint32_t wavering[] = {4U, 5U, 3U, 4U, 7U, 1U, 2U, 6U};
    skip(1U, each, 4U, 0U);
    skip(1U, gaps, 5U, 3U);
    skip(4U, fourths, 3U, 0U);
    skip(4U, missing, 4U, 3U);
    skip(4U, wavering, 8U, 0U);
    skip(0U, gaps, 5U, 3U); // An agreement without decimation delivers every sample.
}

static void wrap(void)
{
    open_both(1U);
    producer.sequence = UINT32_MAX - 2U;
    for (uint32_t i = 0U; i < 6U; i++) {
        write_number(i, i);
        TEST_ASSERT_EQUAL(STATUS_OK, read_at(i));
        expect_number(i);
    }
    TEST_ASSERT_EQUAL(0U, consumer.counters.lost);
    TEST_ASSERT_EQUAL(6U, consumer.counters.frames);
}

static void the_sequence_number_wraps(void)
{
    over_each_method(wrap);
}

// ---- Epochs ----

static void reopen(void)
{
    open_both(1U);
    write_number(1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U));
    rtlink_consumer_close(&consumer);
    rtlink_producer_close(&producer);
    open_both(2U);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_EMPTY, read_at(0U), "expected no sample from before the last opening");
    write_number(2U, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(1U));
    expect_number(2U);
}

static void an_earlier_opening_is_forgotten(void)
{
    over_each_method(reopen);
}

static void meet_an_old_producer(void)
{
    const rtlink_terms_t terms = links_terms(method, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &links, LINK, &terms, 1U));
    write_number(1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(&consumer, &links, LINK, &terms, 2U));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(0U));
    TEST_ASSERT_TRUE(consumer.counters.refused > 0U);
    rtlink_producer_t successor = {0};
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&successor, &links, LINK, &terms, 2U));
    write_number(2U, 0U); // The replaced producer still writes.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(0U));
    rtlink_producer_close(&successor);
}

static void an_old_producer_is_not_accepted(void)
{
    over_each_method(meet_an_old_producer);
}

static void an_old_reader_of_replaced_memory_goes_stale(void)
{
    method = RTLINK_METHOD_SHARED_MEMORY;
    open_both(1U);
    write_number(1U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U));
    rtlink_producer_t successor = {0};
    const rtlink_terms_t terms  = links_terms(method, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&successor, &links, LINK, &terms, 2U));
    const uint8_t payload[OCTETS] = {0U};
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_write(&successor, 3U, 100U * MS, payload));
    TEST_ASSERT_EQUAL(STATUS_STALE, read_at(100U * MS));
    expect_number(1U);
    rtlink_producer_close(&successor);
}

// ---- What cannot be opened ----

static void opening_an_impossible_link_is_refused(void)
{
    rtlink_terms_t terms = links_terms(RTLINK_METHOD_SHARED_MEMORY, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_producer_open(&producer, &links, LINK_UNKNOWN, &terms, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_consumer_open(&consumer, &links, LINK_UNKNOWN, &terms, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_consumer_open(&consumer, &links, LINK, &terms, 1U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_consumer_read(&consumer, 0U));
    terms = links_terms(RTLINK_METHOD_UDP, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_producer_open(&producer, &links, LINK_UNKNOWN, &terms, 1U));
    terms = links_terms(RTLINK_METHOD_TIPC, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_producer_open(&producer, &links, LINK_UNKNOWN, &terms, 1U));
    const rtlink_resolver_t without = {.shm_name = links.shm_name, .udp_route = links.udp_route};
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_producer_open(&producer, &without, LINK, &terms, 1U));
    static const uint8_t others[] = {0x0U, 0x3U, 0x5U, 0x8U}; // No method, two methods, unknown methods.
    for (unsigned i = 0U; i < (sizeof others / sizeof others[0]); i++) {
        terms.methods = others[i];
        TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_producer_open(&producer, &links, LINK, &terms, 1U));
        TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_consumer_open(&consumer, &links, LINK, &terms, 1U));
    }
}

static void memory_of_another_size_is_not_read(void)
{
    const rtlink_terms_t terms = links_terms(RTLINK_METHOD_SHARED_MEMORY, OCTETS);
    osal_shm_t other;
    char name[64];
    links_name(LINK, name);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&other, name, 64U));
    TEST_ASSERT_EQUAL(STATUS_IO, rtlink_consumer_open(&consumer, &links, LINK, &terms, 1U));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, rtlink_consumer_read(&consumer, 0U));
    osal_shm_close(&other);
    method = RTLINK_METHOD_SHARED_MEMORY; // The next opening replaces the memory that is left.
    open_both(1U);
    write_number(3U, 0U);
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U));
}

static void a_closed_link_leaves_no_name(void)
{
    method = RTLINK_METHOD_SHARED_MEMORY;
    open_both(1U);
    rtlink_producer_close(&producer);
    char name[64];
    links_name(LINK, name);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_shm_remove(name));
}

static void a_damaged_slot_is_refused(void)
{
    method = RTLINK_METHOD_SHARED_MEMORY;
    open_both(1U);
    write_number(1U, 0U);
    uint8_t* const memory = osal_shm_address(&producer.shm);
    *(uint64_t*)(void*)&memory[8] ^= 1ULL << 48U; // The magic number, after the sequence counter.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(0U));
    TEST_ASSERT_EQUAL(1U, consumer.counters.refused);
    *(uint32_t*)(void*)&memory[0] |= 1U; // An odd counter: the writer died while it wrote.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(0U));
    TEST_ASSERT_EQUAL(1U, consumer.counters.torn);
}

// A slot over two pages. The second is closed, so that the reader is stopped between two words.
static uint8_t memory_of_pages[3U * PAGE_MAX];
static uint8_t* second_page;
static size_t page_size;
static unsigned stops;

/// The writer writes the sample of the producer's slot into this slot while the reader copies it.
static void write_between_two_words(const int number)
{
    (void)number;
    stops++;
    if (mprotect(second_page, page_size, PROT_READ | PROT_WRITE) != 0) {
        _exit(1);
    }
    (void)memcpy(consumer.slot, osal_shm_address(&producer.shm), SLOT_OCTETS);
}

static void a_slot_that_changes_while_it_is_copied_is_copied_again(void)
{
    struct sigaction before;
    struct sigaction action = {.sa_handler = write_between_two_words};
    method                  = RTLINK_METHOD_SHARED_MEMORY;
    open_both(1U);
    page_size = (size_t)sysconf(_SC_PAGESIZE);
    TEST_ASSERT_TRUE(page_size <= PAGE_MAX);
    second_page        = &memory_of_pages[(2U * page_size) - ((uintptr_t)memory_of_pages % page_size)];
    void* const shared = consumer.slot;
    consumer.slot      = (void*)&second_page[-32]; // The counter and the header are before the second page.
    write_number(1U, 0U);
    (void)memcpy(consumer.slot, osal_shm_address(&producer.shm), SLOT_OCTETS);
    write_number(2U, 0U);
    TEST_ASSERT_EQUAL(0, mprotect(second_page, page_size, PROT_NONE));
    TEST_ASSERT_EQUAL(0, sigaction(SIGSEGV, &action, &before));
    stops                 = 0U;
    const status_t status = read_at(0U);
    (void)sigaction(SIGSEGV, &before, NULL);
    consumer.slot = shared;
    TEST_ASSERT_EQUAL(STATUS_OK, status);
    TEST_ASSERT_EQUAL_UINT(1U, stops);
    expect_number(2U);
    TEST_ASSERT_EQUAL(0U, consumer.counters.torn + consumer.counters.refused + consumer.counters.lost);
}

// ---- Datagrams ----

static void a_datagram_that_is_cut_damaged_or_of_another_link_or_epoch_is_refused_and_counted(void)
{
    uint8_t payload[OCTETS]     = {0U};
    rtlink_frame_header_t frame = {.producer_state = 5U, .link = LINK, .epoch = 3U, .sequence = 7U};
    uint8_t octets[LINK_FRAME_MAX];
    method = RTLINK_METHOD_UDP;
    open_both(3U);
    size_t size = rtlink_frame_encode(&frame, payload, OCTETS, true, octets);
    for (size_t shorter = 0U; shorter < size; shorter++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, rtlink_consumer_deliver(&consumer, octets, shorter));
    }
    octets[size - 1U] ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, rtlink_consumer_deliver(&consumer, octets, size));
    frame.link = 2U;
    size       = rtlink_frame_encode(&frame, payload, OCTETS, true, octets);
    TEST_ASSERT_EQUAL(STATUS_INVALID, rtlink_consumer_deliver(&consumer, octets, size));
    frame.link = LINK;
    for (uint32_t epoch = 2U; epoch <= 4U; epoch += 2U) {
        frame.epoch = epoch;
        size        = rtlink_frame_encode(&frame, payload, OCTETS, true, octets);
        TEST_ASSERT_EQUAL(STATUS_INVALID, rtlink_consumer_deliver(&consumer, octets, size));
    }
    frame.epoch = 3U;
    size        = rtlink_frame_encode(&frame, payload, OCTETS - 1U, true, octets);
    TEST_ASSERT_EQUAL(STATUS_INVALID, rtlink_consumer_deliver(&consumer, octets, size));
    TEST_ASSERT_EQUAL(LINK_FRAME_HEADER_OCTETS + OCTETS + 4U + 5U, consumer.counters.refused);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(0U));
    size = rtlink_frame_encode(&frame, payload, OCTETS, true, octets);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_deliver(&consumer, octets, size));
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U));
}

static void a_datagram_overtaken_by_a_later_one_is_ignored(void)
{
    static const uint32_t order[] = {5U, 5U, 4U, 8U, 6U, 9U};
    rtlink_frame_header_t frame   = {.producer_state = 5U, .link = LINK, .epoch = 1U};
    uint8_t payload[OCTETS];
    uint8_t octets[LINK_FRAME_MAX];
    method = RTLINK_METHOD_UDP;
    open_both(1U);
    for (unsigned i = 0U; i < (sizeof order / sizeof order[0]); i++) {
        frame.sequence = order[i];
        (void)memset(payload, (int)order[i], sizeof payload);
        const size_t size = rtlink_frame_encode(&frame, payload, OCTETS, true, octets);
        TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_deliver(&consumer, octets, size));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, read_at(0U));
    TEST_ASSERT_EQUAL(9U, consumer.payload[0]);
    TEST_ASSERT_EQUAL(3U, consumer.counters.frames);
    TEST_ASSERT_EQUAL(2U, consumer.counters.lost);
    TEST_ASSERT_EQUAL(0U, consumer.counters.refused);
}

static void a_link_by_shared_memory_refuses_datagrams(void)
{
    uint8_t octets[LINK_FRAME_MAX];
    const uint8_t payload[OCTETS]     = {0xEEU};
    const rtlink_frame_header_t frame = {.producer_state = 5U, .link = LINK, .epoch = 1U, .sequence = 7U};
    const size_t size                 = rtlink_frame_encode(&frame, payload, OCTETS, true, octets);
    method                            = RTLINK_METHOD_SHARED_MEMORY;
    open_both(1U);
    TEST_ASSERT_EQUAL(STATUS_INVALID, rtlink_consumer_deliver(&consumer, octets, size));
    TEST_ASSERT_EQUAL(1U, consumer.counters.refused);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, read_at(0U));
}

static void a_datagram_that_cannot_be_sent_is_counted(void)
{
    const uint8_t payload[OCTETS] = {0U};
    method                        = RTLINK_METHOD_UDP;
    open_both(1U);
    osal_socket_t gone = OSAL_SOCKET_CLOSED;
    producer.socket    = &gone;
    TEST_ASSERT_EQUAL(STATUS_IO, rtlink_producer_write(&producer, 3U, 0U, payload));
    TEST_ASSERT_EQUAL(1U, producer.counters.lost);
    TEST_ASSERT_EQUAL(0U, producer.counters.frames);
    TEST_ASSERT_EQUAL(0U, links_under_way());
}

/// A full queue is distinguished from all other reasons; in each case the sample is lost and the next one
/// is sent.
static void the_reason_why_a_frame_was_not_sent_over_tipc_is_reported(void)
{
    static const status_t refusals[][2] = {{STATUS_FULL, STATUS_FULL},
                                           {STATUS_CLOSED, STATUS_IO},
                                           {STATUS_TOO_LARGE, STATUS_IO},
                                           {STATUS_IO, STATUS_IO}};
    const uint8_t payload[OCTETS]       = {0U};
    method                              = RTLINK_METHOD_TIPC;
    open_both(1U);
    for (unsigned i = 0U; i < 4U; i++) {
        links_tipc_status = refusals[i][0];
        TEST_ASSERT_EQUAL(refusals[i][1], rtlink_producer_write(&producer, 3U, 0U, payload));
        TEST_ASSERT_EQUAL(i + 1U, producer.counters.lost);
    }
    TEST_ASSERT_EQUAL(0U, producer.counters.frames);
    TEST_ASSERT_EQUAL(0U, links_under_way());
    links_tipc_status = STATUS_OK;
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_write(&producer, 3U, 0U, payload));
    TEST_ASSERT_EQUAL(1U, producer.counters.frames);
    TEST_ASSERT_EQUAL(1U, links_under_way());
}

static char wanted_name[64];

static bool name_as_wanted(void* context, uint16_t link, char* out_name, size_t capacity)
{
    (void)context;
    (void)link;
    (void)strncpy(out_name, wanted_name, capacity);
    return wanted_name[0] != '\0';
}

static void an_impossible_name_of_shared_memory_is_refused(void)
{
    rtlink_resolver_t named    = links;
    named.shm_name             = name_as_wanted;
    const rtlink_terms_t terms = links_terms(RTLINK_METHOD_SHARED_MEMORY, OCTETS);
    (void)strcpy(wanted_name, "no/name");
    TEST_ASSERT_EQUAL(STATUS_IO, rtlink_producer_open(&producer, &named, LINK, &terms, 1U));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, rtlink_consumer_open(&consumer, &named, LINK, &terms, 1U));
    links_name(LINK, wanted_name); // Another program keeps the name.
    char directory[80] = "/dev/shm";
    (void)strcat(directory, wanted_name);
    TEST_ASSERT_EQUAL(0, mkdir(directory, 0700));
    TEST_ASSERT_EQUAL(STATUS_IO, rtlink_producer_open(&producer, &named, LINK, &terms, 1U));
    TEST_ASSERT_EQUAL(0, rmdir(directory));
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &named, LINK, &terms, 1U));
    wanted_name[0] = '\0'; // The name is no longer known: the memory disappears with the process.
    rtlink_producer_close(&producer);
    TEST_ASSERT_FALSE(producer.is_open);
    links_name(LINK, wanted_name);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_remove(wanted_name));
}

static void the_callback_for_delivered_samples_is_optional(void)
{
    rtlink_resolver_t silent   = links;
    silent.delivered           = NULL;
    const rtlink_terms_t terms = links_terms(RTLINK_METHOD_UDP, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &silent, LINK, &terms, 1U));
    write_number(1U, 0U);
    TEST_ASSERT_EQUAL(0U, links_under_way());
    TEST_ASSERT_EQUAL(1U, producer.counters.frames);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_link_exists_from_open_to_close);
    RUN_TEST(the_latest_sample_is_read);
    RUN_TEST(a_sample_is_stale_only_beyond_the_largest_age);
    RUN_TEST(losses_are_counted_in_samples_that_were_due);
    RUN_TEST(the_sequence_number_wraps);
    RUN_TEST(an_earlier_opening_is_forgotten);
    RUN_TEST(an_old_producer_is_not_accepted);
    RUN_TEST(an_old_reader_of_replaced_memory_goes_stale);
    RUN_TEST(opening_an_impossible_link_is_refused);
    RUN_TEST(memory_of_another_size_is_not_read);
    RUN_TEST(a_closed_link_leaves_no_name);
    RUN_TEST(a_damaged_slot_is_refused);
    RUN_TEST(a_slot_that_changes_while_it_is_copied_is_copied_again);
    RUN_TEST(a_datagram_that_is_cut_damaged_or_of_another_link_or_epoch_is_refused_and_counted);
    RUN_TEST(a_datagram_overtaken_by_a_later_one_is_ignored);
    RUN_TEST(a_link_by_shared_memory_refuses_datagrams);
    RUN_TEST(a_datagram_that_cannot_be_sent_is_counted);
    RUN_TEST(the_reason_why_a_frame_was_not_sent_over_tipc_is_reported);
    RUN_TEST(an_impossible_name_of_shared_memory_is_refused);
    RUN_TEST(the_callback_for_delivered_samples_is_optional);
    return UNITY_END();
}
