// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/canopen/two_drives.h"

#include "unity.h"

#include <string.h>

#define CYCLES_MAX 4000U

scripted_bus_t bus;
canopen_network_t network;
scripted_node_t* joints[2];
uint64_t now_ns;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    if (strcmp(name, "robot") != 0) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, bus.address);
    return STATUS_OK;
}

const flow_resolver_t resolver        = {NULL, resolve};
const canopen_network_config_t config = {.master              = {.node_id              = 1U,
                                                                 .heartbeat_ns         = 20000000U,
                                                                 .heartbeat_timeout_ns = 60000000U,
                                                                 .sdo_timeout_ns       = 50000000U},
                                         .lost_after_syncs    = 3U,
                                         .boot_retry_ns       = 300000000U,
                                         .silence_reported_ns = 100000000U,
                                         .quick_stop_limit_ns = 200000000U};

status_t add_device(const char* const type, const uint8_t node)
{
    static canopen_network_device_t slots[NETWORK_DEVICES_MAX + 1U];
    return canopen_network_add(&network, &slots[network.device_count], type, node);
}

void two_drives_open(void)
{
    scripted_bus_open(&bus, "test-network");
    joints[0] = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    joints[1] = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x12U);
    now_ns    = 0U;
    canopen_network_init(&network, &config);
    TEST_ASSERT_EQUAL(STATUS_OK, add_device("joint-drive", 0x11U));
    TEST_ASSERT_EQUAL(STATUS_OK, add_device("joint-drive", 0x12U));
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_open(&network, &resolver, "robot", NULL));
}

void two_drives_close(void)
{
    canopen_network_close(&network);
    scripted_bus_close(&bus);
}

status_t cycle(const action_t action)
{
    canopen_network_sense(&network, now_ns);
    const status_t status = (action != NULL) ? action(&network, now_ns) : STATUS_OK;
    canopen_network_emit(&network, now_ns);
    scripted_bus_run(&bus);
    now_ns += CYCLE_NS;
    if ((now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&bus);
    }
    return status;
}

/// Run cycles until the action ends. Returns its status.
status_t run_action(const action_t action)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < CYCLES_MAX); i++) {
        status = cycle(action);
    }
    return status;
}

void idle(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        (void)cycle(NULL);
    }
}

void set(const uint8_t index, const uint16_t object, const uint8_t subindex, const uint8_t octets,
         const uint32_t value)
{
    const canopen_setting_t setting = {
        .index = object, .subindex = subindex, .octets = octets, .kind = SETTING_WRITE, .value = value};
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_set(&network, index, &setting));
}

/// Set the settings of torque mode as a descriptor contains them.
void set_torque_mode(void)
{
    for (uint8_t i = 0U; i < 2U; i++) {
        set(i, 0x1400U, 1U, 4U, 0x80000211U + i);
        set(i, 0x1401U, 1U, 4U, 0x80000311U + i);
        set(i, 0x1401U, 1U, 4U, 0x00000311U + i);
        set(i, 0x6060U, 0U, 1U, 10U);
    }
}

status_t at_goal(canopen_network_t* const self, const uint64_t time_ns)
{
    (void)time_ns;
    return canopen_network_is_at_goal(self) ? STATUS_OK : STATUS_BUSY;
}

void go(const canopen_cia402_goal_t goal)
{
    canopen_network_set_goal(&network, goal, goal == CIA402_GOAL_STANDBY);
    (void)cycle(NULL);
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(at_goal));
}

void run_to(const canopen_cia402_goal_t goal)
{
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_boot));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_configure));
    TEST_ASSERT_EQUAL(STATUS_OK, run_action(canopen_network_start));
    if (goal != CIA402_GOAL_DISABLED) {
        go(CIA402_GOAL_STANDBY);
    }
    if (goal == CIA402_GOAL_ENABLED) {
        go(CIA402_GOAL_ENABLED);
    }
}

void expect_no_fault(void)
{
    canopen_network_fault_t fault;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_network_take_fault(&network, &fault));
}

void expect_refusal(const uint8_t node, const canopen_network_refusal_t refusal, const uint32_t object,
                    const uint32_t detail)
{
    canopen_network_fault_t fault = {.node = 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_take_fault(&network, &fault));
    TEST_ASSERT_EQUAL(NETWORK_DEVICE_REFUSED, fault.kind);
    TEST_ASSERT_EQUAL_HEX8(node, fault.node);
    TEST_ASSERT_EQUAL(refusal, fault.refusal);
    TEST_ASSERT_EQUAL_HEX32(object, fault.object);
    TEST_ASSERT_EQUAL_HEX32(detail, fault.detail);
    expect_no_fault();
}

void expect_fault(const canopen_network_fault_kind_t kind, const uint8_t node, const uint16_t code)
{
    canopen_network_fault_t fault = {.node = 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_network_take_fault(&network, &fault));
    TEST_ASSERT_EQUAL(kind, fault.kind);
    TEST_ASSERT_EQUAL_HEX8(node, fault.node);
    TEST_ASSERT_EQUAL_HEX16(code, fault.code);
}
