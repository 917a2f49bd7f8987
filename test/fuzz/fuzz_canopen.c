// SPDX-License-Identifier: Apache-2.0
// The CANopen master controls two drives. Between their correct answers it receives arbitrary frames. The
// axes stay in range, queues stay within bounds, and the network can be secured in bounded time.
//
// Records by kind:
//   0  the master receives the frame
//   1  the master performs the present step (boot, configure, start, run or secure) for argument cycles
//   2  the argument selects the step
//   3  the bits of the argument select faults of a drive
//   4  the argument selects the goal of the drives
#include "fsw/canopen/network.h"
#include "test/fuzz/can_records.h"
#include "test/support/scripted_bus.h"

#include <string.h>

#define CYCLE_NS 500000U
#define SECURE_CYCLES 1000U
#define CYCLES_MAX 1000U // Maximum number of cycles of one input.

static scripted_bus_t bus;
static canopen_network_t network;
static canopen_network_device_t slots[2];
static scripted_node_t* joints[2];
static uint64_t now_ns;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, "shm:fuzz");
    return STATUS_OK;
}

static void begin(void)
{
    static const flow_resolver_t resolver = {NULL, resolve};
    const canopen_network_config_t config = {.master              = {.node_id              = 1U,
                                                                     .heartbeat_ns         = 20000000U,
                                                                     .heartbeat_timeout_ns = 60000000U,
                                                                     .sdo_timeout_ns       = 5000000U},
                                             .lost_after_syncs    = 3U,
                                             .boot_retry_ns       = 30000000U,
                                             .silence_reported_ns = 10000000U,
                                             .quick_stop_limit_ns = 200000000U};
    scripted_bus_open(&bus, "shm:fuzz");
    joints[0] = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    joints[1] = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x12U);
    now_ns    = 0U;
    canopen_network_init(&network, &config);
    FUZZ_CHECK((canopen_network_add(&network, &slots[0], "joint-drive", 0x11U) == STATUS_OK) &&
               (canopen_network_add(&network, &slots[1], "joint-drive", 0x12U) == STATUS_OK) &&
               (canopen_network_open(&network, &resolver, "robot", NULL) == STATUS_OK));
    for (uint8_t i = 0U; i < 2U; i++) {
        const canopen_setting_t mode = {.index = 0x6060U, .octets = 1U, .kind = SETTING_WRITE, .value = 10U};
        FUZZ_CHECK(canopen_network_set(&network, i, &mode) == STATUS_OK);
    }
}

static void check(void)
{
    canopen_network_fault_t fault;
    FUZZ_CHECK(network.fault_count <= NETWORK_FAULTS_MAX);
    while (canopen_network_take_fault(&network, &fault) == STATUS_OK) {
        FUZZ_CHECK(fault.node <= 0x7FU);
    }
    for (unsigned i = 0U; i < network.device_count; i++) {
        const canopen_cia402_axis_t* const axis = &network.devices[i]->device.axes[0];
        FUZZ_CHECK((canopen_cia402_axis_position_rad(axis) < 1e9) &&
                   (canopen_cia402_axis_position_rad(axis) > -1e9));
        FUZZ_CHECK((canopen_cia402_axis_torque_nm(axis) < 1e12) &&
                   (canopen_cia402_axis_torque_nm(axis) > -1e12));
    }
    FUZZ_CHECK(network.master.emergency_count <= MASTER_EMERGENCIES_MAX);
}

static status_t cycle(status_t (*const action)(canopen_network_t* network, uint64_t now_ns))
{
    canopen_network_sense(&network, now_ns);
    const status_t status = (action != NULL) ? action(&network, now_ns) : STATUS_OK;
    canopen_network_emit(&network, now_ns);
    scripted_bus_run(&bus);
    now_ns += CYCLE_NS;
    if ((now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&bus);
    }
    check();
    return status;
}

static void misbehave(const uint8_t argument)
{
    scripted_node_t* const joint = joints[argument >> 7U];
    joint->is_plugged            = ((argument & 1U) == 0U);
    joint->is_boot_mute          = ((argument & 2U) != 0U);
    joint->is_sdo_mute           = ((argument & 4U) != 0U);
    joint->is_pdo_mute           = ((argument & 8U) != 0U);
    joint->is_stuck              = ((argument & 16U) != 0U);
}

static void act(const fuzz_record_t* const record, unsigned* const step)
{
    static status_t (*const actions[])(canopen_network_t*, uint64_t) = {
        canopen_network_boot, canopen_network_configure, canopen_network_start, NULL, canopen_network_secure};
    const osal_can_frame_t frame = fuzz_can_frame(record);
    switch (record->kind % 5U) {
    case 0U:
        if (osal_can_send(&bus.wire, &frame) != STATUS_OK) {
            return; // The bus has no room for the frame.
        }
        break;
    case 1U:
        for (unsigned i = 0U; (i < record->argument) && (now_ns < (CYCLES_MAX * CYCLE_NS)); i++) {
            const status_t status = cycle(actions[*step]);
            if (status != STATUS_BUSY) {
                *step = ((status == STATUS_OK) && (*step < 3U)) ? (*step + 1U) : 3U;
            }
        }
        break;
    case 2U:
        *step = record->argument % 5U;
        break;
    case 3U:
        misbehave(record->argument);
        break;
    default:
        canopen_network_set_goal(&network, (canopen_cia402_goal_t)(record->argument % 4U),
                                 (record->argument & 4U) != 0U);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    unsigned step      = 0U;
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    while (fuzz_next(&input, &record)) {
        act(&record, &step);
    }
    // A drive that ignores commands cannot be secured; other tests check that this is detected.
    joints[0]->is_stuck = false;
    joints[1]->is_stuck = false;
    status_t status     = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < SECURE_CYCLES); i++) {
        status = cycle(canopen_network_secure);
    }
    FUZZ_CHECK(status == STATUS_OK);
    canopen_network_stop(&network);
    canopen_network_close(&network);
    scripted_bus_close(&bus);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, fuzz_repair_can);
}
