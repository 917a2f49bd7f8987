// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "fsw/framework/dataflow/flow_shm.h"

#include "test/support/assertion.h"
#include "test/unit/fsw/framework/dataflow/sample_record.h"
#include "unity.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define WORDS 37U // Prime, so that no alignment divides it.

static char address[64]; // Unique to this process.
static flow_shm_t writer;
static flow_shm_t reader;
static quota_t quota;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    if ((kind != ENDNODE_SHM) || (strcmp(name, "moon") == 0)) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, (strcmp(name, "bad") == 0) ? "no name" : address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};
static const flow_shm_shape_t latest  = {
     .kind = FLOW_SHM_LATEST, .value_octets = (WORDS * 4U) - 1U, .depth = 1U};
static const flow_shm_shape_t queue = {.kind = FLOW_SHM_QUEUE, .value_octets = 5U, .depth = 3U};

static void begin(flow_shm_t* const flow, const char* const name, const bool is_writer,
                  const flow_shm_shape_t shape)
{
    const flow_shm_setup_t setup = {.name             = name,
                                    .is_writer        = is_writer,
                                    .shape            = shape,
                                    .retry_first_ns   = 10U,
                                    .retry_longest_ns = 40U,
                                    .quota            = &quota};
    flow_shm_init(flow, &setup, &resolver);
}

void setUp(void)
{
    (void)snprintf(address, sizeof address, "/test-flow-shm-%ld", (long)getpid());
    (void)osal_shm_remove(address);
    quota_init(&quota, 4U);
    begin(&writer, "x", true, queue);
    begin(&reader, "x", false, queue);
}

void tearDown(void)
{
    flow_shm_close(&reader);
    flow_shm_close(&writer);
    TEST_ASSERT_EQUAL_UINT16(0U, quota.stats.used);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_shm_remove(address)); // No object remains.
}

static void both_ends(const flow_shm_shape_t shape)
{
    begin(&writer, "x", true, shape);
    begin(&reader, "x", false, shape);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&writer, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&reader, 0U));
    TEST_ASSERT_EQUAL_UINT16(2U, quota.stats.used);
}

static void the_latest_value_is_read_once(void)
{
    uint8_t value[WORDS * 4U] = {0U};
    uint8_t found[WORDS * 4U];
    both_ends(latest);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_shm_read(&reader, found));
    for (uint8_t i = 1U; i < 10U; i++) {
        memset(value, i, sizeof value);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, value));
    }
    memset(found, 0xEE, sizeof found);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, found));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value, found, latest.value_octets);
    TEST_ASSERT_EQUAL_HEX8(0xEEU, found[latest.value_octets]); // The octet after the value was not written.
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_shm_read(&reader, found));
    TEST_ASSERT_EQUAL_UINT32(9U, writer.counters.written);
    TEST_ASSERT_EQUAL_UINT32(1U, reader.counters.read);
}

static void a_queue_keeps_order_and_refuses_when_full(void)
{
    uint8_t found[5];
    both_ends(queue);
    for (unsigned round = 0U; round < 10U; round++) {
        for (uint8_t i = 0U; i < 3U; i++) {
            const uint8_t value[5] = {i, (uint8_t)round};
            TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, value));
        }
        TEST_ASSERT_EQUAL(STATUS_FULL, flow_shm_write(&writer, found));
        for (uint8_t i = 0U; i < 3U; i++) {
            TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, found));
            TEST_ASSERT_EQUAL_UINT8(i, found[0]);
            TEST_ASSERT_EQUAL_UINT8(round, found[1]);
        }
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_shm_read(&reader, found));
    }
    TEST_ASSERT_EQUAL_UINT32(10U, writer.counters.refused);
    TEST_ASSERT_EQUAL_UINT32(30U, writer.counters.written);
    TEST_ASSERT_EQUAL_UINT32(30U, reader.counters.read);
}

static void a_reader_cannot_write_and_a_writer_cannot_read(void)
{
    uint8_t value[5] = {0U};
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_write(&writer, value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&reader, value));
    both_ends(queue);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_write(&reader, value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&writer, value));
    TEST_ASSERT_EQUAL_UINT32(1U, reader.counters.refused);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&reader, 1U)); // The flow stays open.
    TEST_ASSERT_TRUE(reader.link.is_open && writer.link.is_open);
}

static void records_have_the_byte_order_of_the_flow(void)
{
    uint8_t octets[SAMPLE_OCTETS];
    both_ends((flow_shm_shape_t){FLOW_SHM_QUEUE, SAMPLE_OCTETS, 2U});
    for (unsigned order = 0U; order < (unsigned)FLOW_ORDERS; order++) {
        sample_t seen      = {.number = 9U};
        writer.setup.order = (flow_order_t)order;
        reader.setup.order = (flow_order_t)order;
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_shm_read_record(&reader, &sample_layout, &seen));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write_record(&writer, &sample_layout, &sample));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, octets));
        TEST_ASSERT_EQUAL_HEX8_ARRAY(sample_wire[order], octets, SAMPLE_OCTETS);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, octets));
        octets[SAMPLE_OCTETS - 1U] = 2U; // The octet is a BOOL and neither 0 nor 1.
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, octets));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read_record(&reader, &sample_layout, &seen));
        TEST_ASSERT_TRUE(is_sample(&seen));
        seen.number = 9U;
        TEST_ASSERT_EQUAL(STATUS_INVALID, flow_shm_read_record(&reader, &sample_layout, &seen));
        TEST_ASSERT_EQUAL_UINT32(order + 1U, reader.counters.unfit);
        TEST_ASSERT_EQUAL_UINT16(9U, seen.number);
    }
    TEST_ASSERT_EQUAL_UINT32(2U, reader.counters.unfit);
}

static void write_a_value_of_another_size(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write_record(&writer, &sample_layout, &sample));
}

static void read_a_value_of_another_size(void)
{
    sample_t seen;
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read_record(&reader, &sample_layout, &seen));
}

static void write_a_giant(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write_record(&writer, &giant_layout, giant_record));
}

static void records_of_another_size_are_coding_errors(void)
{
    both_ends(queue);
    TEST_ASSERT_TRUE(assertion_fails(write_a_value_of_another_size));
    TEST_ASSERT_TRUE(assertion_fails(read_a_value_of_another_size));
    flow_shm_close(&writer);
    flow_shm_close(&reader);
    both_ends((flow_shm_shape_t){FLOW_SHM_LATEST, sizeof giant_record, 1U});
    TEST_ASSERT_TRUE(assertion_fails(write_a_giant));
}

static void expect_refusal(flow_shm_t* const flow, const uint64_t now_ns, const status_t why)
{
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_step(flow, now_ns));
    TEST_ASSERT_EQUAL(why, flow->link.failure);
    TEST_ASSERT_FALSE(flow->link.is_open);
}

static void a_refused_opening_is_counted_with_its_reason(void)
{
    begin(&reader, "moon", false, queue);
    expect_refusal(&reader, 0U, STATUS_NOT_FOUND);
    begin(&writer, "moon", true, queue);
    expect_refusal(&writer, 0U, STATUS_NOT_FOUND);
    begin(&writer, "bad", true, queue);
    expect_refusal(&writer, 0U, STATUS_INVALID);
    begin(&reader, "bad", false, queue);
    expect_refusal(&reader, 0U, STATUS_INVALID);
    begin(&writer, "x", true, queue);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&writer, 0U));
    const flow_shm_shape_t others[] = {
        {FLOW_SHM_LATEST, 5U, 1U}, {FLOW_SHM_QUEUE, 5U, 4U}, {FLOW_SHM_QUEUE, 6U, 3U}};
    for (unsigned i = 0U; i < (sizeof others / sizeof others[0]); i++) {
        begin(&reader, "x", false, others[i]);
        expect_refusal(&reader, 0U, STATUS_INVALID);
        TEST_ASSERT_EQUAL_UINT32(1U, reader.link.reconnect.failed);
    }
    quota_init(&quota, 1U);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      quota_take(&quota)); // Takes the only unit of the quota, as an open writer does.
    begin(&reader, "x", false, queue);
    expect_refusal(&reader, 0U, STATUS_EXHAUSTED);
}

static flow_shm_shape_t impossible;

static void begin_with_the_impossible_shape(void)
{
    begin(&reader, "x", false, impossible);
}

static void impossible_shapes_are_coding_errors(void)
{
    const flow_shm_shape_t shapes[] = {{FLOW_SHM_LATEST, 0U, 1U},    {FLOW_SHM_LATEST, 8U, 2U},
                                       {FLOW_SHM_QUEUE, 8U, 0U},     {FLOW_SHM_QUEUE, 65537U, 1U},
                                       {FLOW_SHM_QUEUE, 8U, 65537U}, {(flow_shm_kind_t)7, 8U, 1U}};
    for (unsigned i = 0U; i < (sizeof shapes / sizeof shapes[0]); i++) {
        impossible = shapes[i];
        TEST_ASSERT_TRUE(assertion_fails(begin_with_the_impossible_shape));
    }
}

static void a_reader_that_starts_first_waits_with_back_off(void)
{
    // Delays of 10, 20 and 40; 40 is the longest delay.
    static const uint64_t due[] = {0U, 10U, 30U, 70U, 110U};
    uint8_t value[5]            = {7U};
    for (uint32_t i = 0U; i < 5U; i++) {
        if (i > 0U) {
            expect_refusal(&reader, due[i] - 1U, STATUS_NOT_FOUND); // No attempt is made yet.
            TEST_ASSERT_EQUAL_UINT32(i, reader.link.reconnect.failed);
        }
        expect_refusal(&reader, due[i], STATUS_NOT_FOUND);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, reader.link.reconnect.failed);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&writer, 111U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_step(&reader, 149U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&reader, 150U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, value));
    TEST_ASSERT_EQUAL_UINT8(7U, value[0]);
}

/// The reader reads the values that are in the queue when the writer closes it; then it gets STATUS_CLOSED.
static void a_writer_that_closes_is_reported_after_its_last_value(void)
{
    uint8_t value[5] = {1U};
    both_ends(queue);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, value));
    flow_shm_close(&writer);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&reader, value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&reader, value));
    TEST_ASSERT_EQUAL_UINT32(1U, reader.link.reconnect.lost);
    expect_refusal(&reader, 9U, STATUS_CLOSED);
    expect_refusal(&reader, 10U, STATUS_NOT_FOUND); // The writer has not come back.
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&writer, 20U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&reader, 100U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, value));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, value));
}

/// A writer that is killed in another process leaves its memory. Its successor creates the memory again and
/// the reader follows, even if the dead writer was writing a value.
static void a_new_writer_replaces_a_killed_one(void)
{
    static const flow_shm_shape_t shapes[] = {{FLOW_SHM_LATEST, 5U, 1U}, {FLOW_SHM_QUEUE, 5U, 3U}};
    for (unsigned i = 0U; i < 2U; i++) {
        uint8_t value[5] = {(uint8_t)i, 1U};
        begin(&writer, "x", true, shapes[i]);
        begin(&reader, "x", false, shapes[i]);
        const pid_t other = fork();
        if (other == 0) {
            if ((flow_shm_step(&writer, 0U) == STATUS_OK) && (flow_shm_write(&writer, value) == STATUS_OK)) {
                (void)raise(SIGKILL);
            }
            _exit(1);
        }
        int exit_status = 0;
        TEST_ASSERT_EQUAL(other, waitpid(other, &exit_status, 0));
        TEST_ASSERT_TRUE(WIFSIGNALED(exit_status));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&reader, 0U));
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, value)); // The last value of the dead writer.
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_shm_read(&reader, value));
        // As if the writer had been killed while writing the next value.
        if (shapes[i].kind == FLOW_SHM_LATEST) {
            ((uint64_t*)osal_shm_address(&reader.shm))[2]++;
            TEST_ASSERT_EQUAL(STATUS_BUSY, flow_shm_read(&reader, value));
        }
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&writer, 0U));
        TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&reader, value));
        TEST_ASSERT_EQUAL(STATUS_CLOSED, reader.link.failure);
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&reader, 10U));
        TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_shm_read(&reader, value)); // No value of the old memory is read.
        value[1] = 2U;
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, value));
        value[1] = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, value));
        TEST_ASSERT_EQUAL_UINT8(2U, value[1]);
        flow_shm_close(&reader);
        flow_shm_close(&writer);
    }
}

/// A replaced writer that is still alive does not remove its successor's memory.
static void a_replaced_writer_removes_nothing_of_its_successor(void)
{
    flow_shm_t successor;
    uint8_t value[5] = {3U};
    both_ends(queue);
    begin(&successor, "x", true, queue);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&successor, 0U));
    flow_shm_close(&writer);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&reader, value));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&reader, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&successor, value));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, value));
    flow_shm_close(&successor);
}

static void shared_memory_of_another_layout_is_refused(void)
{
    static const size_t sizes[] = {1U, 4096U}; // One size is too small; the other memory has no header.
    for (unsigned i = 0U; i < 2U; i++) {
        osal_shm_t strange;
        TEST_ASSERT_EQUAL(STATUS_OK, osal_shm_create(&strange, address, sizes[i]));
        begin(&reader, "x", false, queue);
        expect_refusal(&reader, 0U, STATUS_NOT_FOUND);
        // The writer creates the memory of this name.
        TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_step(&writer, 0U));
        TEST_ASSERT_EQUAL_HEX8(0U, *(uint8_t*)osal_shm_address(&strange));
        osal_shm_close(&strange);
        flow_shm_close(&writer);
    }
}

static void* write_for_a_while(void* const context)
{
    (void)context;
    uint32_t value[WORDS];
    for (uint32_t i = 1U; i <= 100000U; i++) {
        for (unsigned k = 0U; k < WORDS; k++) {
            value[k] = i;
        }
        if (flow_shm_write(&writer, value) != STATUS_OK) {
            return &writer;
        }
    }
    return NULL;
}

static void a_value_is_never_read_in_part(void)
{
    pthread_t thread;
    uint32_t found[WORDS];
    uint32_t before              = 0U;
    unsigned reads               = 0U;
    const flow_shm_shape_t shape = {.kind = FLOW_SHM_LATEST, .value_octets = sizeof found, .depth = 1U};
    both_ends(shape);
    TEST_ASSERT_EQUAL_INT(0, pthread_create(&thread, NULL, write_for_a_while, NULL));
    while (before < 100000U) {
        const status_t status = flow_shm_read(&reader, found);
        if (status == STATUS_OK) {
            for (unsigned k = 1U; k < WORDS; k++) {
                TEST_ASSERT_EQUAL_UINT32(found[0], found[k]);
            }
            TEST_ASSERT_TRUE(found[0] > before);
            before = found[0];
            reads++;
        } else {
            TEST_ASSERT_TRUE((status == STATUS_EMPTY) || (status == STATUS_BUSY));
        }
    }
    void* failed = NULL;
    TEST_ASSERT_EQUAL_INT(0, pthread_join(thread, &failed));
    TEST_ASSERT_NULL(failed);
    TEST_ASSERT_EQUAL_UINT32(reads, reader.counters.read);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(the_latest_value_is_read_once);
    RUN_TEST(a_queue_keeps_order_and_refuses_when_full);
    RUN_TEST(a_reader_cannot_write_and_a_writer_cannot_read);
    RUN_TEST(a_refused_opening_is_counted_with_its_reason);
    RUN_TEST(records_have_the_byte_order_of_the_flow);
    RUN_TEST(records_of_another_size_are_coding_errors);
    RUN_TEST(impossible_shapes_are_coding_errors);
    RUN_TEST(a_reader_that_starts_first_waits_with_back_off);
    RUN_TEST(a_writer_that_closes_is_reported_after_its_last_value);
    RUN_TEST(a_new_writer_replaces_a_killed_one);
    RUN_TEST(a_replaced_writer_removes_nothing_of_its_successor);
    RUN_TEST(shared_memory_of_another_layout_is_refused);
    RUN_TEST(a_value_is_never_read_in_part);
    return UNITY_END();
}
