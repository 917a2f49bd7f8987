// SPDX-License-Identifier: Apache-2.0
// A whole subsystem, the manipulator with its drives, receives packets, link frames and CAN frames in any
// order. They reach the dispatcher, every service of a subsystem, the state machine, parameters and
// devices. Every report is well-formed, and the reported state is the present one. OPERATIONAL is entered
// only from SAFE_OPERATIONAL. When OPERATIONAL has been left and both drives have obeyed for 50 cycles, no
// drive has torque, so every brake holds. No request ends twice, and no report of a request follows its end.
// Afterwards the subsystem can go to OFFLINE, where its pool of call tokens is full again.
//
// Records by kind:
//   0..4  the subsystem receives the packet, then runs for argument cycles
//   5     the master receives the CAN frame
//   6     the subsystem receives the link frame
//   7     the bits of the argument select faults of a drive, and the number of reports that are refused
#include "fsw/framework/subsystem/subsystem_core.h"
#include "fsw/subsystems/manipulator/manipulator.h"
#include "pus/st01/st01_verification.h"
#include "test/fuzz/can_records.h"
#include "test/fuzz/memory_socket.h"
#include "test/support/scripted_bus.h"
#include "test/support/consistent_pool.h"

#include <string.h>

#define DESCRIPTOR "descriptors/subsystems/manipulator.xml"
#define STEPS_TO_OFFLINE 100000U
#define STEPS_MAX 3000U          // Maximum number of steps of the records of one input.
#define CYCLES_TO_SECURE 50U     // From leaving OPERATIONAL until each drive that obeys has its brake on.
#define ENABLE_OPERATION 0x000FU // Controlword of CiA 402: torque, the brake is released.
#define REQUESTS_MAX 1024U       // Request ids of one input that are watched; later ones are not.
#define ID_OCTETS 4U             // Packet id and sequence control, the request id of ST[01].

typedef struct { // Packets with the same request id.
    uint32_t id;
    uint32_t accepted; // Packets that the subsystem has received.
    uint32_t ended;    // Reports that end such a request.
} watched_t;

static subsystem_descriptor_t descriptor;
static subsystem_t component;
static manipulator_t manipulator;
static scripted_bus_t bus;
static scripted_node_t* joints[2];
static uint64_t now_ns;
static unsigned steps_left;
static unsigned idle_cycles; // Cycles in which the drives obeyed, since OPERATIONAL was left.
static unsigned refusals;    // Number of reports that the port refuses before it accepts one.
static watched_t watched[REQUESTS_MAX];
static unsigned watched_count;
static bool is_watching_all; // Each request id is in the list.

static watched_t* find_watched(const uint32_t id)
{
    for (unsigned i = 0U; i < watched_count; i++) {
        if (watched[i].id == id) {
            return &watched[i];
        }
    }
    return NULL;
}

static void watch_request(const uint8_t* const packet, const size_t size)
{
    if (size < ID_OCTETS) {
        return; // It has no request id.
    }
    const uint32_t id = octets_u32_at(packet);
    watched_t* found  = find_watched(id);
    if ((found == NULL) && (watched_count < REQUESTS_MAX)) {
        found  = &watched[watched_count];
        *found = (watched_t){.id = id};
        watched_count++;
    }
    if (found != NULL) {
        found->accepted++;
    } else {
        is_watching_all = false;
    }
}

/// A request ends with its rejection, the failure of its start as a whole, or its completion.
static void check_verification(const pus_verification_t* const verification)
{
    watched_t* const request = find_watched(verification->request_id);
    FUZZ_CHECK((request != NULL) || !is_watching_all);
    if (request == NULL) {
        return;
    }
    FUZZ_CHECK(request->ended < request->accepted);
    const bool is_of_instruction = (verification->subtype == 4U) && (verification->failure.instruction > 0U);
    const bool is_end            = pus_verification_is_final(verification) && !is_of_instruction;
    request->ended += is_end ? 1U : 0U;
}

static status_t take_report(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    pus_tm_t tm;
    pus_failure_t failure;
    pus_verification_t verification;
    if (refusals > 0U) {
        refusals--;
        return STATUS_FULL;
    }
    FUZZ_CHECK(pus_tm_decode(packet, size, &tm, &failure) == STATUS_OK);
    FUZZ_CHECK(tm.apid == MANIPULATOR_APID);
    if (tm.service == PUS_SERVICE_VERIFICATION) {
        FUZZ_CHECK(pus_verification_read(&tm, &verification) == STATUS_OK);
        check_verification(&verification);
    }
    octet_reader_t reader = octet_reader(tm.data, tm.size);
    pus_subsystem_status_t status;
    if ((tm.service == PUS_SERVICE_MANAGEMENT) && (tm.subtype == PUS_MANAGEMENT_STATUS)) {
        FUZZ_CHECK(pus_subsystem_status_read(&reader, &status) == STATUS_OK);
        FUZZ_CHECK(pus_app_process_is_waiting(&component.process) ||
                   status.state == (uint8_t)subsystem_state(&component));
    }
    return STATUS_OK;
}

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, "shm:fuzz");
    return STATUS_OK;
}

static bool route(void* const context, const uint16_t link, osal_socket_t** const out_socket,
                  osal_address_t* const out_consumer)
{
    static osal_socket_t socket = OSAL_SOCKET_CLOSED;
    (void)context;
    (void)link;
    if (!osal_socket_is_open(&socket)) {
        const osal_address_t any = {OSAL_IPV4_LOOPBACK, 0U};
        FUZZ_CHECK(osal_udp_open(&socket, any, 0U) == STATUS_OK);
    }
    *out_socket   = &socket;
    *out_consumer = (osal_address_t){OSAL_IPV4_LOOPBACK, 9U};
    return true;
}

static status_t reload(void* const context, const subsystem_descriptor_t** const out_descriptor)
{
    *out_descriptor = &descriptor;
    return (*(const bool*)context) ? STATUS_OK : STATUS_INVALID;
}

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    static descriptor_loader_t loader;
    (void)argc;
    (void)argv;
    descriptor_loader_init(&loader);
    FUZZ_CHECK(descriptor_load_subsystem(&loader, DESCRIPTOR, &descriptor) == STATUS_OK);
    return 0;
}

static void begin(void)
{
    static const flow_resolver_t flows   = {NULL, resolve};
    static const rtlink_resolver_t links = {.udp_route = route};
    static const bool is_good            = true;
    const subsystem_config_t config      = {.descriptor            = &descriptor,
                                            .is_descriptor_valid   = true,
                                            .callbacks             = manipulator_callbacks(),
                                            .self                  = &manipulator,
                                            .mission_epoch_s       = 1000U,
                                            .start_count           = 1U,
                                            .port                  = {NULL, take_report},
                                            .links                 = &links,
                                            .link_methods          = 1U << RTLINK_METHOD_UDP,
                                            .supervisor_timeout_ns = 3000000000U,
                                            .status_interval_ns    = SUBSYSTEM_STATUS_INTERVAL_NS,
                                            .reload                = reload,
                                            .reload_context        = (void*)(uintptr_t)&is_good};
    scripted_bus_open(&bus, "shm:fuzz");
    joints[0]       = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    joints[1]       = scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x12U);
    now_ns          = 0U;
    refusals        = 0U;
    idle_cycles     = 0U;
    watched_count   = 0U;
    is_watching_all = true;
    manipulator_init(&manipulator, &component, &flows);
    subsystem_init(&component, &config);
}

/// True if the cable, the process data and the power state of a drive work: it follows its last command.
static bool obeys(const scripted_node_t* const joint)
{
    return joint->is_plugged && !joint->is_sdo_mute && !joint->is_pdo_mute && !joint->is_stuck;
}

static void check_state(const state_t before)
{
    const state_t state = subsystem_state(&component);
    FUZZ_CHECK((state != STATE_OPERATIONAL) || (before == STATE_OPERATIONAL) ||
               (before == STATE_SAFE_OPERATIONAL));
    const bool is_good = obeys(joints[0]) && obeys(joints[1]);
    idle_cycles        = ((state == STATE_OPERATIONAL) || !is_good) ? 0U : (idle_cycles + 1U);
    for (unsigned i = 0U; (i < 2U) && (idle_cycles > CYCLES_TO_SECURE); i++) {
        FUZZ_CHECK((joints[i]->control[0] & ENABLE_OPERATION) != ENABLE_OPERATION);
    }
}

static void step(const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        const state_t before   = subsystem_state(&component);
        const uint64_t wake_ns = subsystem_step(&component, now_ns);
        check_state(before);
        FUZZ_CHECK(wake_ns > now_ns);
        scripted_bus_run(&bus);
        scripted_bus_heartbeat(&bus);
        now_ns = wake_ns;
        FUZZ_CHECK(pool_is_consistent(&component.call_tokens));
    }
}

static void act(const fuzz_record_t* const record)
{
    osal_can_frame_t frame;
    scripted_node_t* const joint = joints[record->argument >> 7U];
    switch (record->kind % 8U) {
    case 5U:
        frame = fuzz_can_frame(record);
        if (osal_can_send(&bus.wire, &frame) != STATUS_OK) {
            return; // The bus has no room for the frame.
        }
        break;
    case 6U:
        subsystem_link_datagram(&component, record->octets, record->size);
        break;
    case 7U:
        joint->is_plugged  = ((record->argument & 1U) == 0U);
        joint->is_sdo_mute = ((record->argument & 2U) != 0U);
        joint->is_pdo_mute = ((record->argument & 4U) != 0U);
        joint->is_stuck    = ((record->argument & 8U) != 0U);
        refusals           = (record->argument >> 4U) & 7U;
        break;
    default:
        watch_request(record->octets, record->size);
        subsystem_accept(&component, record->octets, record->size, now_ns);
        step((record->argument < steps_left) ? record->argument : steps_left);
        steps_left -= (record->argument < steps_left) ? record->argument : steps_left;
        break;
    }
}

/// After any input the subsystem reaches OFFLINE, and no call token is taken.
static void end(void)
{
    for (unsigned i = 0U; (i < STEPS_TO_OFFLINE) && (subsystem_state(&component) != STATE_OFFLINE); i++) {
        if ((i % 1000U) == 0U) { // Again, because an action that fails may lead to ERROR_OPERATIONAL.
            (void)subsystem_request(&component, STATE_OFFLINE, CAUSE_SHUTDOWN);
        }
        step(1U);
    }
    FUZZ_CHECK(subsystem_state(&component) == STATE_OFFLINE);
    FUZZ_CHECK(component.call_tokens.stats.taken == 0U);
    scripted_bus_close(&bus);
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    steps_left = STEPS_MAX;
    step(1U);
    while (fuzz_next(&input, &record)) {
        act(&record);
    }
    end();
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    if ((kind % 8U) < 5U) {
        if ((size > 2U) && ((fuzz_random(random) % 8U) != 0U)) { // A request to the manipulator.
            octets[0] = 0x18U;
            octets[1] = MANIPULATOR_APID;
        }
        fuzz_repair_packet(kind, octets, size, random);
    } else if ((kind % 8U) == 5U) {
        fuzz_repair_can(kind, octets, size, random);
    } else {
        // fuzz_link_frame.c mutates the fields of link frames.
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, repair);
}
