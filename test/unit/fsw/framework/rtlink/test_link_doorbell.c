// SPDX-License-Identifier: Apache-2.0
// A reader that sleeps until the producer has written.
#include "fsw/framework/rtlink/link_channel.h"
#include "osal/include/osal/task.h"
#include "test/unit/fsw/framework/rtlink/links.h"
#include "unity.h"

#define THERE 1U
#define BACK 2U
#define SAMPLES 2000U
#define OCTETS 64U
#define TIMEOUT_MS 20000U

typedef struct {
    rtlink_producer_t producer;
    rtlink_consumer_t consumer;
} end_t;

static end_t near_end;
static end_t far_end;

void setUp(void)
{
    links_open();
}

void tearDown(void)
{
    links_close();
}

static void open_link(uint16_t link, rtlink_producer_t* producer, rtlink_consumer_t* consumer)
{
    const rtlink_terms_t terms = links_terms(RTLINK_METHOD_SHARED_MEMORY, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(producer, &links, link, &terms, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(consumer, &links, link, &terms, 1U));
}

/// Sleep until a sample has come that was not read before. Its first octet, or 256 if none came in time.
static unsigned next_sample(rtlink_consumer_t* consumer)
{
    osal_doorbell_t* const bell = rtlink_consumer_doorbell(consumer);
    const uint32_t frames       = consumer->counters.frames;
    for (;;) {
        const uint32_t seen = osal_doorbell_rings(bell);
        (void)rtlink_consumer_read(consumer, 0U);
        if (consumer->counters.frames != frames) {
            return consumer->payload[0];
        }
        if (osal_doorbell_wait(bell, seen, TIMEOUT_MS) != STATUS_OK) {
            return 256U;
        }
    }
}

static void answer(void* context)
{
    (void)context;
    for (unsigned i = 0U; i < SAMPLES; i++) {
        const uint8_t payload[OCTETS] = {(uint8_t)next_sample(&far_end.consumer)};
        (void)rtlink_producer_write(&far_end.producer, 5U, 0U, payload);
    }
}

static void every_sample_wakes_its_reader(void)
{
    open_link(THERE, &near_end.producer, &far_end.consumer);
    open_link(BACK, &far_end.producer, &near_end.consumer);
    osal_task_t task;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_task_start(&task, answer, NULL, 0));
    for (unsigned i = 0U; i < SAMPLES; i++) {
        const uint8_t payload[OCTETS] = {(uint8_t)i};
        TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_write(&near_end.producer, 5U, 0U, payload));
        TEST_ASSERT_EQUAL_UINT(i & 0xFFU, next_sample(&near_end.consumer));
    }
    osal_task_join(&task);
    TEST_ASSERT_EQUAL_UINT32(SAMPLES, far_end.consumer.counters.frames);
    TEST_ASSERT_EQUAL_UINT32(0U, far_end.consumer.counters.lost);
    rtlink_consumer_close(&far_end.consumer);
    rtlink_consumer_close(&near_end.consumer);
    rtlink_producer_close(&near_end.producer);
    rtlink_producer_close(&far_end.producer);
}

static void only_an_open_link_in_shared_memory_has_a_doorbell(void)
{
    rtlink_consumer_t consumer = {0};
    TEST_ASSERT_NULL(rtlink_consumer_doorbell(&consumer));
    open_link(THERE, &near_end.producer, &consumer);
    TEST_ASSERT_NOT_NULL(rtlink_consumer_doorbell(&consumer));
    rtlink_consumer_close(&consumer);
    TEST_ASSERT_NULL(rtlink_consumer_doorbell(&consumer));
    rtlink_producer_close(&near_end.producer);
    const rtlink_terms_t terms = links_terms(RTLINK_METHOD_UDP, OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_open(&consumer, &links, THERE, &terms, 1U));
    TEST_ASSERT_NULL(rtlink_consumer_doorbell(&consumer));
    rtlink_consumer_close(&consumer);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_sample_wakes_its_reader);
    RUN_TEST(only_an_open_link_in_shared_memory_has_a_doorbell);
    return UNITY_END();
}
