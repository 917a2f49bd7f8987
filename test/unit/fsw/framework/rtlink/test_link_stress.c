// SPDX-License-Identifier: Apache-2.0
// One writer and several readers of the same memory, each in a task of its own: no reader gets a torn sample.
#include "fsw/framework/rtlink/link_channel.h"

#include "osal/include/osal/task.h"
#include "test/unit/fsw/framework/rtlink/links.h"
#include "unity.h"

#include <string.h>

#define LINK 1U
#define READERS 3U
#define SAMPLES 800000U // At least this number.
#define READS_MIN                                                                                            \
    10U // Every reader reads at least so often before the writer ends, whatever the scheduling is.
#define OCTETS RTLINK_PAYLOAD_MAX

typedef struct {
    rtlink_consumer_t consumer;
    osal_task_t task;
    uint32_t reads;
    uint32_t torn;      // Payloads whose octets are of different samples.
    uint32_t backwards; // Samples older than one read before.
} reader_t;

static rtlink_producer_t producer;
static reader_t readers[READERS];
static uint32_t is_over;

void setUp(void)
{
    links_open();
}

void tearDown(void)
{
    links_close();
}

/// Payload of a sample: every 32-bit word follows from the sample's number and the word's index.
static void fill(uint32_t number, uint8_t payload[OCTETS])
{
    for (uint32_t i = 0U; i < (OCTETS / 4U); i++) {
        const uint32_t word = (number * 2654435761U) ^ i;
        (void)memcpy(&payload[i * 4U], &word, sizeof word);
    }
}

static void check(reader_t* reader, uint32_t* last)
{
    uint8_t expected[OCTETS];
    const uint32_t number = (uint32_t)reader->consumer.sample_time_ns;
    fill(number, expected);
    reader->torn += (memcmp(expected, reader->consumer.payload, OCTETS) != 0) ? 1U : 0U;
    reader->torn += (reader->consumer.sequence != number) ? 1U : 0U;
    reader->torn += (reader->consumer.peer_state != (number % 10U)) ? 1U : 0U;
    reader->backwards += (number < *last) ? 1U : 0U;
    *last = number;
    __atomic_store_n(&reader->reads, reader->reads + 1U, __ATOMIC_RELAXED);
}

static bool have_all_read(void)
{
    for (unsigned i = 0U; i < READERS; i++) {
        if (__atomic_load_n(&readers[i].reads, __ATOMIC_RELAXED) < READS_MIN) {
            return false;
        }
    }
    return true;
}

static void read_all(void* context)
{
    reader_t* const reader = context;
    uint32_t last          = 0U;
    while (__atomic_load_n(&is_over, __ATOMIC_ACQUIRE) == 0U) {
        if (rtlink_consumer_read(&reader->consumer, 0U) == STATUS_OK) {
            check(reader, &last);
        }
    }
    if (rtlink_consumer_read(&reader->consumer, 0U) == STATUS_OK) {
        check(reader, &last);
    }
}

static void no_sample_is_ever_torn(void)
{
    const rtlink_terms_t terms = links_terms(RTLINK_METHOD_SHARED_MEMORY, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &links, LINK, &terms, 1U));
    for (unsigned i = 0U; i < READERS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(&readers[i].consumer, &links, LINK, &terms, 1U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&readers[i].task, read_all, &readers[i], 0));
    }
    uint32_t number = 0U;
    for (; (number < SAMPLES) || !have_all_read(); number++) {
        uint8_t payload[OCTETS];
        fill(number, payload);
        (void)rtlink_producer_write(&producer, (uint8_t)(number % 10U), number, payload);
    }
    __atomic_store_n(&is_over, 1U, __ATOMIC_RELEASE);
    for (unsigned i = 0U; i < READERS; i++) {
        osal_task_join(&readers[i].task);
        TEST_ASSERT_EQUAL(0U, readers[i].torn);
        TEST_ASSERT_EQUAL(0U, readers[i].backwards);
        TEST_ASSERT_TRUE(readers[i].reads >= READS_MIN);
        TEST_ASSERT_EQUAL(number - 1U, readers[i].consumer.sequence);
        TEST_ASSERT_EQUAL(0U, readers[i].consumer.counters.refused);
        // No sample is both read and counted as missed; samples before the first read are not counted.
        TEST_ASSERT_TRUE((readers[i].consumer.counters.frames + readers[i].consumer.counters.lost) <= number);
        rtlink_consumer_close(&readers[i].consumer);
    }
    rtlink_producer_close(&producer);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_sample_is_ever_torn);
    return UNITY_END();
}
