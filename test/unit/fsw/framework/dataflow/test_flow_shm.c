// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_shm.h"

#include "unity.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define WORDS 37U // Not a multiple of anything.

static char address[64]; // Of this process alone.
static flow_shm_t writer;
static flow_shm_t reader;

static status_t resolve(void* const context, const endnode_kind_t kind, const char* const name,
                        endnode_address_t* const out_address)
{
    (void)context;
    if ((kind != ENDNODE_SHM) || (strcmp(name, "moon") == 0)) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};
static const flow_shm_shape_t latest  = {
     .kind = FLOW_SHM_LATEST, .value_octets = (WORDS * 4U) - 1U, .depth = 1U};
static const flow_shm_shape_t queue = {.kind = FLOW_SHM_QUEUE, .value_octets = 5U, .depth = 3U};

void setUp(void)
{
    (void)snprintf(address, sizeof address, "/test-flow-shm-%ld", (long)getpid());
    (void)osal_shm_remove(address);
    flow_shm_init(&writer);
    flow_shm_init(&reader);
}

void tearDown(void)
{
    flow_shm_close(&reader);
    flow_shm_close(&writer);
}

static void both_ends(const flow_shm_shape_t shape)
{
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_create(&writer, &resolver, "x", shape));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_open(&reader, &resolver, "x", shape));
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
    TEST_ASSERT_EQUAL_HEX8(0xEEU, found[latest.value_octets]); // And not an octet more.
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
}

static void each_end_does_its_own_part_only(void)
{
    uint8_t value[5] = {0U};
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_write(&writer, value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&reader, value));
    both_ends(queue);
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_write(&reader, value));
    TEST_ASSERT_EQUAL(STATUS_CLOSED, flow_shm_read(&writer, value));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, flow_shm_create(&writer, &resolver, "x", queue));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, flow_shm_open(&reader, &resolver, "x", queue));
}

static void opening_is_refused_for_a_reason(void)
{
    flow_shm_t second;
    flow_shm_init(&second);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_shm_open(&reader, &resolver, "x", queue)); // No writer yet.
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_shm_open(&reader, &resolver, "moon", queue));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, flow_shm_create(&writer, &resolver, "moon", queue));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_create(&writer, &resolver, "x", queue));
    TEST_ASSERT_EQUAL(STATUS_EXISTS, flow_shm_create(&second, &resolver, "x", queue));
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_shm_open(&reader, &resolver, "x", latest));
    flow_shm_shape_t other = queue;
    other.depth            = 4U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_shm_open(&reader, &resolver, "x", other));
    other              = queue;
    other.value_octets = 6U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, flow_shm_open(&reader, &resolver, "x", other));
    const flow_shm_shape_t impossible[] = {{FLOW_SHM_LATEST, 0U, 1U},    {FLOW_SHM_LATEST, 8U, 2U},
                                           {FLOW_SHM_QUEUE, 8U, 0U},     {FLOW_SHM_QUEUE, 65537U, 1U},
                                           {FLOW_SHM_QUEUE, 8U, 65537U}, {(flow_shm_kind_t)7, 8U, 1U}};
    for (unsigned i = 0U; i < (sizeof impossible / sizeof impossible[0]); i++) {
        TEST_ASSERT_EQUAL(STATUS_INVALID, flow_shm_create(&second, &resolver, "x", impossible[i]));
    }
}

static void a_new_writer_is_met_by_a_new_reader(void)
{
    uint8_t value[5] = {1U};
    both_ends(queue);
    flow_shm_close(&writer);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, flow_shm_read(&reader, value)); // The old memory stays readable.
    flow_shm_close(&reader);
    both_ends(queue);
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_write(&writer, value));
    TEST_ASSERT_EQUAL(STATUS_OK, flow_shm_read(&reader, value));
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

static void a_value_is_never_torn(void)
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
    RUN_TEST(each_end_does_its_own_part_only);
    RUN_TEST(opening_is_refused_for_a_reason);
    RUN_TEST(a_new_writer_is_met_by_a_new_reader);
    RUN_TEST(a_value_is_never_torn);
    return UNITY_END();
}
