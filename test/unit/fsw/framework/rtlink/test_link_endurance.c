// SPDX-License-Identifier: Apache-2.0
// Links at their rates for a long time: no sample is lost, torn or out of order, and every read gets the
// latest sample. The processes run in lock-step, so that simulated minutes take seconds and every figure is
// exact.
#include "fsw/framework/rtlink/link_channel.h"

#include "osal/include/osal/lockstep_scheduler.h"
#include "test/support/repetitions.h"
#include "test/unit/fsw/framework/rtlink/links.h"
#include "unity.h"

#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define LINK 1U
#define OCTETS 64U ///< Octets of a payload.
#define WORDS (OCTETS / sizeof(uint32_t))
#define READERS 8U
#define DECIMATION 5U
#define EPOCH 7U

typedef struct { // Figures of all readers of one process; all must be zero.
    uint32_t reads;
    uint32_t torn;     ///< Payloads whose words are of different samples.
    uint32_t not_last; ///< Reads of a sample other than the last one written.
    uint32_t not_ok;   ///< Reads with another status.
    uint32_t lost;     ///< Sum of the counters of the consumers.
} figures_t;

static rtlink_producer_t producer;
static rtlink_consumer_t readers[READERS];
static rtlink_consumer_t decimated;
static unsigned reader_count; // Readers of the present test, at most READERS.

void setUp(void)
{
    links_open();
    reader_count = READERS;
}

void tearDown(void)
{
    rtlink_producer_close(&producer);
    for (unsigned i = 0U; i < READERS; i++) {
        rtlink_consumer_close(&readers[i]);
    }
    rtlink_consumer_close(&decimated);
    links_close();
}

static rtlink_terms_t terms(rtlink_method_t method, uint32_t period_us)
{
    rtlink_terms_t agreed = links_terms(method, OCTETS);
    agreed.period_us      = period_us;
    agreed.max_age_us     = 4U * period_us;
    return agreed;
}

/// Every word of the payload follows from the number of the sample and the word's index.
static void fill(uint32_t number, uint32_t payload[WORDS])
{
    for (uint32_t i = 0U; i < WORDS; i++) {
        payload[i] = (number + i) * 2654435761U;
    }
}

static void write_sample(uint32_t number, uint64_t now_ns)
{
    uint32_t payload[WORDS];
    fill(number, payload);
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_write(&producer, (uint8_t)(number % 10U), now_ns,
                                                       (const uint8_t*)payload));
}

/// Expect that the sample read at `now_ns` is sample `number`, which was written at that time.
static void read_sample(rtlink_consumer_t* consumer, uint32_t number, uint64_t now_ns, figures_t* figures)
{
    uint32_t expected[WORDS];
    fill(number, expected);
    figures->reads++;
    figures->not_ok += (rtlink_consumer_read(consumer, now_ns) != STATUS_OK) ? 1U : 0U;
    figures->torn += (memcmp(consumer->payload, expected, OCTETS) != 0) ? 1U : 0U;
    figures->not_last += ((consumer->sequence != number) || (consumer->sample_time_ns != now_ns) ||
                          (consumer->peer_state != (number % 10U)))
                             ? 1U
                             : 0U;
}

static bool open_readers(const rtlink_terms_t* agreed)
{
    rtlink_terms_t every_fifth = *agreed;
    every_fifth.decimation     = DECIMATION;
    bool is_open               = true;
    for (unsigned i = 0U; i < reader_count; i++) {
        is_open = is_open && (rtlink_consumer_open(&readers[i], &links, LINK, agreed, EPOCH) == STATUS_OK);
    }
    return is_open && (rtlink_consumer_open(&decimated, &links, LINK, &every_fifth, EPOCH) == STATUS_OK);
}

static void read_all(uint32_t number, uint64_t now_ns, figures_t* figures)
{
    for (unsigned i = 0U; i < reader_count; i++) {
        read_sample(&readers[i], number, now_ns, figures);
    }
    if ((number % DECIMATION) == 0U) {
        read_sample(&decimated, number, now_ns, figures);
    }
}

/// Add up the counters of the readers.
static void close_figures(uint32_t samples, figures_t* figures)
{
    for (unsigned i = 0U; i <= reader_count; i++) {
        const rtlink_consumer_t* const reader   = (i < reader_count) ? &readers[i] : &decimated;
        const rtlink_counters_t* const counters = &reader->counters;
        const uint32_t expected                 = (i < reader_count) ? samples : (samples / DECIMATION);
        figures->lost += counters->lost + counters->late + counters->torn + counters->refused;
        figures->lost += (counters->frames != expected) ? 1U : 0U;
    }
}

static void expect_clean(const figures_t* figures, uint32_t samples)
{
    TEST_ASSERT_EQUAL_UINT32((samples * reader_count) + (samples / DECIMATION), figures->reads);
    TEST_ASSERT_EQUAL_UINT32(0U, figures->not_ok);
    TEST_ASSERT_EQUAL_UINT32(0U, figures->torn);
    TEST_ASSERT_EQUAL_UINT32(0U, figures->not_last);
    TEST_ASSERT_EQUAL_UINT32(0U, figures->lost);
}

static void no_sample_is_lost_at_two_kilohertz(void)
{
    static const uint32_t samples = REPETITIONS(2000U * 60U * 30U);
    const rtlink_terms_t agreed   = terms(RTLINK_METHOD_SHARED_MEMORY, 500U);
    figures_t figures             = {0};
    reader_count                  = 1U; // In addition to the decimated one; the other tests have many.
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &links, LINK, &agreed, EPOCH));
    TEST_ASSERT_TRUE(open_readers(&agreed));
    for (uint32_t number = 0U; number < samples; number++) {
        const uint64_t now_ns = (uint64_t)number * 500000U;
        write_sample(number, now_ns);
        read_all(number, now_ns, &figures);
    }
    close_figures(samples, &figures);
    expect_clean(&figures, samples);
}

// ---- Two processes, in turn by a scheduler ----

#define STEP_NS 100000U             ///< 10 kHz.
#define MINUTE REPETITIONS(600000U) ///< Samples.

typedef struct { // In shared memory.
    uint64_t scheduler[OSAL_LOCKSTEP_OCTETS / sizeof(uint64_t)];
    figures_t figures;
    uint32_t failed; ///< Processes that have failed.
} meeting_t;

enum {
    PRODUCER,
    CONSUMER,
    PROCESSES
};

enum { // How a process ended.
    WELL = 0,
    NOT_OPENED,
    NOT_GRANTED,
    WRONG_TIME,
    NOT_WRITTEN
};

/// Run the scheduler up to sample `number`. Returns WELL or the failure.
static int await(osal_lockstep_t* scheduler, unsigned participant, uint32_t number)
{
    const uint64_t wake_ns = (uint64_t)number * STEP_NS;
    osal_grant_t grant     = {0U, 0U, 0U};
    if (osal_lockstep_wait(scheduler, participant, OSAL_LOCKSTEP_ANY_LIFE, wake_ns, &grant) != STATUS_OK) {
        return NOT_GRANTED;
    }
    return (grant.now_ns == wake_ns) ? WELL : WRONG_TIME;
}

/// Read all samples; the figures get the findings. Returns the exit code.
static int consume(osal_lockstep_t* scheduler, figures_t* figures)
{
    const rtlink_terms_t agreed = terms(RTLINK_METHOD_SHARED_MEMORY, STEP_NS / 1000U);
    int code                    = await(scheduler, CONSUMER, 0U);
    // The producer has its turn before and has created the link.
    if ((code == WELL) && !open_readers(&agreed)) {
        return NOT_OPENED;
    }
    for (uint32_t number = 0U; (number < MINUTE) && (code == WELL); number++) {
        read_all(number, (uint64_t)number * STEP_NS, figures);
        code = await(scheduler, CONSUMER, number + 1U);
    }
    close_figures(MINUTE, figures);
    osal_lockstep_end(scheduler, CONSUMER, OSAL_LOCKSTEP_ANY_LIFE);
    return code;
}

static int produce(osal_lockstep_t* scheduler)
{
    const rtlink_terms_t agreed = terms(RTLINK_METHOD_SHARED_MEMORY, STEP_NS / 1000U);
    if (rtlink_producer_open(&producer, &links, LINK, &agreed, EPOCH) != STATUS_OK) {
        return NOT_OPENED;
    }
    int code = await(scheduler, PRODUCER, 0U);
    for (uint32_t number = 0U; (number < MINUTE) && (code == WELL); number++) {
        uint32_t payload[WORDS];
        fill(number, payload);
        code = (rtlink_producer_write(&producer, (uint8_t)(number % 10U), (uint64_t)number * STEP_NS,
                                      (const uint8_t*)payload) == STATUS_OK)
                   ? await(scheduler, PRODUCER, number + 1U)
                   : NOT_WRITTEN;
    }
    osal_lockstep_end(scheduler, PRODUCER, OSAL_LOCKSTEP_ANY_LIFE);
    return code;
}

static pid_t start(unsigned participant, osal_lockstep_t* scheduler, figures_t* figures)
{
    const pid_t process = fork();
    TEST_ASSERT_TRUE(process >= 0);
    if (process == 0) {
        _exit((participant == PRODUCER) ? produce(scheduler) : consume(scheduler, figures));
    }
    return process;
}

/// The run has no time-out, because the processes may wait long for a processor. If one of them fails, the
/// other one is released.
static void no_sample_is_lost_between_processes_at_ten_kilohertz(void)
{
    osal_shm_t shm;
    char name[64];
    pid_t processes[PROCESSES];
    links_name(2U, name);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&shm, name, sizeof(meeting_t)));
    meeting_t* const meeting         = osal_shm_address(&shm);
    osal_lockstep_t* const scheduler = osal_lockstep_create(meeting->scheduler, STEP_NS, true);
    TEST_ASSERT_NOT_NULL(scheduler);
    osal_lockstep_expect(scheduler, PRODUCER, 1U, 0U);
    osal_lockstep_expect(scheduler, CONSUMER, 1U, 0U);
    for (unsigned i = 0U; i < PROCESSES; i++) {
        processes[i] = start(i, scheduler, &meeting->figures);
    }
    for (unsigned i = 0U; i < PROCESSES; i++) {
        int ended         = 0;
        const pid_t first = wait(&ended);
        TEST_ASSERT_TRUE((first == processes[PRODUCER]) || (first == processes[CONSUMER]));
        const bool is_well = WIFEXITED(ended) && (WEXITSTATUS(ended) == WELL);
        if (!is_well) {
            osal_lockstep_close(scheduler);
            (void)printf("process %s ended with 0x%X\n",
                         (first == processes[PRODUCER]) ? "producer" : "consumer", (unsigned)ended);
        }
        meeting->failed += is_well ? 0U : 1U;
    }
    TEST_ASSERT_EQUAL_UINT32(0U, meeting->failed);
    expect_clean(&meeting->figures, MINUTE);
    osal_shm_close(&shm);
}

// ---- UDP ----

static void no_sample_is_lost_over_udp_at_two_kilohertz(void)
{
    static const uint32_t samples = REPETITIONS(2000U * 30U);
    static uint8_t frame[LINK_FRAME_MAX];
    const rtlink_terms_t agreed = terms(RTLINK_METHOD_UDP, 500U);
    figures_t figures           = {0};
    TEST_ASSERT_EQUAL(STATUS_OK, rtlink_producer_open(&producer, &links, LINK, &agreed, EPOCH));
    TEST_ASSERT_TRUE(open_readers(&agreed));
    for (uint32_t number = 0U; number < samples; number++) {
        const uint64_t now_ns = (uint64_t)number * 500000U;
        write_sample(number, now_ns);
        const size_t size = links_receive(frame);
        for (unsigned i = 0U; i < READERS; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_deliver(&readers[i], frame, size));
        }
        if ((number % DECIMATION) == 0U) {
            TEST_ASSERT_EQUAL(STATUS_OK, rtlink_consumer_deliver(&decimated, frame, size));
        }
        read_all(number, now_ns, &figures);
    }
    close_figures(samples, &figures);
    expect_clean(&figures, samples);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_sample_is_lost_at_two_kilohertz);
    RUN_TEST(no_sample_is_lost_between_processes_at_ten_kilohertz);
    RUN_TEST(no_sample_is_lost_over_udp_at_two_kilohertz);
    return UNITY_END();
}
