// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/run_flow_address.h"

#include "unity.h"

#include <string.h>

static run_state_t run;
static flow_endnode_address_t address;

void setUp(void)
{
    (void)memset(&run, 0, sizeof run);
    (void)strcpy(run.identity, "hirosco-4660");
    run.instance      = 4660U; // 0x1234
    run.has_simulator = true;
    run.is_stepped    = true;
}

void tearDown(void)
{
}

static void expect(const flow_endnode_kind_t kind, const char* const name, const char* const expected,
                   const char* const counts)
{
    (void)memset(&address, 0, sizeof address);
    TEST_ASSERT_EQUAL(STATUS_OK, run_flow_address(&run, kind, name, &address));
    TEST_ASSERT_EQUAL_STRING(expected, address.address);
    TEST_ASSERT_EQUAL_STRING(counts, address.counts);
}

static void simulated_devices_are_at_addresses_of_the_run(void)
{
    expect(ENDNODE_UDP, "192.168.7.2:15001", "127.64.18.52:15001", "/hirosco-4660.flow.udp.15001.n");
    expect(ENDNODE_UDP, ":15001", "127.128.18.52:15001", "");
    expect(ENDNODE_TCP, "host:80", "127.64.18.52:80", "/hirosco-4660.flow.tcp.80.n");
    expect(ENDNODE_SERIAL, "/dev/ttyS1", "/dev/shm/hirosco-4660.flow.dev.ttyS1",
           "/hirosco-4660.flow.dev.ttyS1.n");
    expect(ENDNODE_FILE, "adc", "/dev/shm/hirosco-4660.flow.adc", "/hirosco-4660.flow.adc.n");
    run.is_stepped = false;
    expect(ENDNODE_UDP, "192.168.7.2:15001", "127.64.18.52:15001", "");
    expect(ENDNODE_SERIAL, "/dev/ttyS1", "/dev/shm/hirosco-4660.flow.dev.ttyS1", "");
}

static void real_devices_have_the_addresses_of_the_descriptor(void)
{
    run.has_simulator = false;
    expect(ENDNODE_UDP, "192.168.7.2:15001", "192.168.7.2:15001", "");
    expect(ENDNODE_UDP, ":15001", "0.0.0.0:15001", "");
    expect(ENDNODE_TCP, "10.0.0.1:80", "10.0.0.1:80", "");
    expect(ENDNODE_SERIAL, "/dev/ttyS1", "/dev/ttyS1", "");
}

static void queues_have_names_of_the_run_and_are_recorded(void)
{
    expect(ENDNODE_SHM, "x.in", "/hirosco-4660.flow.x.in", "");
    expect(ENDNODE_MQUEUE, "x.out", "/hirosco-4660.flow.x.out", "");
    TEST_ASSERT_EQUAL_STRING("/hirosco-4660.flow.x.in", run.flows[0].name);
    TEST_ASSERT_EQUAL_STRING("/hirosco-4660.flow.x.out", run.flows[1].name);
    for (unsigned i = 2U; i < RUN_FLOWS_MAX; i++) {
        const char name[] = {(char)('0' + (i / 10U)), (char)('0' + (i % 10U)), '\0'};
        TEST_ASSERT_EQUAL(STATUS_OK, run_flow_address(&run, ENDNODE_SHM, name, &address));
    }
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_flow_address(&run, ENDNODE_SHM, "more", &address));
}

static void addresses_that_are_too_long_or_have_no_port_are_refused(void)
{
    char name[80];
    (void)memset(name, 'x', sizeof name);
    name[sizeof name - 1U] = '\0';
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_flow_address(&run, ENDNODE_SHM, name, &address));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_flow_address(&run, ENDNODE_SERIAL, name, &address));
    name[43] = '\0'; // The path and its counts just fit.
    TEST_ASSERT_EQUAL(STATUS_OK, run_flow_address(&run, ENDNODE_SERIAL, name, &address));
    run.has_simulator = false;
    name[43]          = 'x';
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, run_flow_address(&run, ENDNODE_TCP, name, &address));
    run.has_simulator = true;
    expect(ENDNODE_TCP, "host", "127.64.18.52", ""); // No socket has this address.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(simulated_devices_are_at_addresses_of_the_run);
    RUN_TEST(real_devices_have_the_addresses_of_the_descriptor);
    RUN_TEST(queues_have_names_of_the_run_and_are_recorded);
    RUN_TEST(addresses_that_are_too_long_or_have_no_port_are_refused);
    return UNITY_END();
}
