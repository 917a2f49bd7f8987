// SPDX-License-Identifier: Apache-2.0
// The supervisor of the mission rokviss receives arbitrary octets from the members, as correct messages or as
// raw frames. It forwards only well-formed packets, and each request to its addressee. The packet log keeps
// every record, rings and pools of the supervisor stay consistent, and a shutdown completes.
//
// Records by kind (the argument names the member of kinds 0..5, 8 and 9):
//   0..5  the member sends the octets as a message
//   6     argument x 10 ms pass
//   7     the supervisor receives the octets as a frame
//   8     the process of the member ends, or starts again
//   9     the member receives all messages of its inbox
#include "fsw/supervisor/supervisor.h"
#include "test/fuzz/fuzz.h"
#include "test/support/consistent_ground.h"
#include "test/support/consistent_message.h"
#include "test/support/consistent_pool.h"

#include <string.h>

#define MISSION "descriptors/missions/rokviss.xml"
#define DESCRIPTOR "descriptors/subsystems/supervisor.xml"
#define MEMBERS 3U
#define SLOTS 8U
#define TICK_NS 10000000U
#define SHUTDOWN_TICKS 6000U

static mission_descriptor_t mission;
static subsystem_descriptor_t descriptor;
static supervisor_t supervisor;
static message_endpoint_t endpoint;
static message_slot_t inbox[SLOTS];
static char log_directory[128];
static uint64_t now_ns;
static bool is_stop_requested;
static bool is_finished;

static const uint16_t apids[MEMBERS] = {COMMUNICATION_APID, 16U, 17U};
static struct {
    message_endpoint_t endpoint;
    message_slot_t inbox[SLOTS];
    bool is_running;
} members[MEMBERS];

// ---- Environment of the supervisor ----

static unsigned member_of(const uint16_t apid)
{
    unsigned at = 0U;
    while ((at < MEMBERS) && (apids[at] != apid)) {
        at++;
    }
    return at;
}

static status_t to_member(void* const context, const uint16_t to, const uint8_t* const frame,
                          const size_t size)
{
    (void)context;
    const unsigned at = member_of(to);
    FUZZ_CHECK(at < MEMBERS);
    return members[at].is_running ? message_deliver(&members[at].endpoint, frame, size) : STATUS_CLOSED;
}

static status_t to_supervisor(void* const context, const uint16_t to, const uint8_t* const frame,
                              const size_t size)
{
    (void)context;
    FUZZ_CHECK(to == SUPERVISOR_APID);
    return message_deliver(&endpoint, frame, size);
}

static status_t start(void* const context, const uint16_t apid, const uint32_t link_floor,
                      const uint64_t boot_ns)
{
    (void)link_floor;
    (void)boot_ns;
    (void)context;
    const unsigned at = member_of(apid);
    if (at == MEMBERS) {
        return STATUS_NOT_FOUND;
    }
    const status_t status  = members[at].is_running ? STATUS_EXISTS : STATUS_OK;
    members[at].is_running = true;
    return status;
}

static status_t stop(void* const context, const uint16_t apid)
{
    (void)context;
    const unsigned at = member_of(apid);
    if (at == MEMBERS) {
        return STATUS_NOT_FOUND;
    }
    members[at].is_running = false;
    return STATUS_OK;
}

static uint64_t promise(void* const context, const uint16_t apid)
{
    (void)context;
    (void)apid;
    return UINT64_MAX;
}

static bool is_running(void* const context, const uint16_t apid)
{
    (void)context;
    const unsigned at = member_of(apid);
    return (apid == SUPERVISOR_APID) || ((at < MEMBERS) && members[at].is_running);
}

static bool stop_requested(void* const context)
{
    (void)context;
    return is_stop_requested;
}

static void finished(void* const context)
{
    (void)context;
    is_finished = true;
}

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    static descriptor_loader_t loader;
    (void)argc;
    (void)argv;
    descriptor_loader_init(&loader);
    FUZZ_CHECK(descriptor_load_mission(&loader, MISSION, MISSION_ANY_TARGET, &descriptor_mission_whole,
                                       &mission, &descriptor) == STATUS_OK);
    FUZZ_CHECK(descriptor_load_subsystem(&loader, DESCRIPTOR, &descriptor) == STATUS_OK);
    (void)strcpy(log_directory, fuzz_directory("supervisor"));
    fuzz_link(log_directory, "packets.ascii", "/dev/null");
    fuzz_link(log_directory, "packets.spool", "/dev/null");
    fuzz_link(log_directory, "packets.ring", "/dev/null");
    return 0;
}

// ---- One input ----

static void begin(void)
{
    message_open(&endpoint, SUPERVISOR_APID, 1U, (message_carrier_t){NULL, to_member}, inbox, SLOTS);
    for (unsigned i = 0U; i < MEMBERS; i++) {
        members[i].is_running = false;
        message_open(&members[i].endpoint, apids[i], 1U, (message_carrier_t){NULL, to_supervisor},
                     members[i].inbox, SLOTS);
        FUZZ_CHECK((message_add_peer(&endpoint, apids[i]) == STATUS_OK) &&
                   (message_add_peer(&members[i].endpoint, SUPERVISOR_APID) == STATUS_OK));
    }
    const supervisor_config_t config = {.mission             = &mission,
                                        .descriptor          = &descriptor,
                                        .is_descriptor_valid = true,
                                        .endpoint            = &endpoint,
                                        .platform            = {.start             = start,
                                                                .stop              = stop,
                                                                .kill              = stop,
                                                                .is_running        = is_running,
                                                                .promise           = promise,
                                                                .is_stop_requested = stop_requested,
                                                                .finished          = finished},
                                        .log_directory       = log_directory,
                                        .start_count         = 1U};
    now_ns                           = 0U;
    is_stop_requested                = false;
    is_finished                      = false;
    memset(&supervisor, 0, sizeof supervisor);
    FUZZ_CHECK(supervisor_init(&supervisor, &config) == STATUS_OK);
}

/// Receive all frames to a member. Each comes from the supervisor and is a complete request to this member,
/// or a complete report.
static void empty_inbox(const unsigned at)
{
    static uint8_t packet[PUS_PACKET_MAX];
    uint16_t from = 0U;
    size_t size   = 0U;
    pus_tc_t tc;
    pus_tm_t tm;
    pus_failure_t failure;
    while (message_receive(&members[at].endpoint, &from, packet, sizeof packet, &size) == STATUS_OK) {
        FUZZ_CHECK(from == SUPERVISOR_APID);
        if (pus_packet_is_tc(packet, size)) {
            FUZZ_CHECK((pus_tc_decode(packet, size, &tc, &failure) == STATUS_OK) && (tc.apid == apids[at]));
        } else {
            FUZZ_CHECK(pus_tm_decode(packet, size, &tm, &failure) == STATUS_OK);
        }
    }
    FUZZ_CHECK(members[at].endpoint.counters.malformed == 0U);
}

static void step(void)
{
    const uint64_t wake_ns = supervisor_step(&supervisor, now_ns);
    FUZZ_CHECK(wake_ns > now_ns);
    FUZZ_CHECK(ground_backlog_is_consistent(&supervisor.ground_backlog) && message_is_consistent(&endpoint));
    FUZZ_CHECK(pool_is_consistent(&supervisor.subsystem.call_tokens));
    FUZZ_CHECK(supervisor.graph.count <= LINK_GRAPH_EDGES);
    FUZZ_CHECK(supervisor.log.failures == 0U);
}

static void act(const fuzz_record_t* const record)
{
    const unsigned at = record->argument % MEMBERS;
    switch (record->kind % 10U) {
    case 6U:
        for (unsigned i = 0U; i < record->argument; i++) {
            now_ns += TICK_NS;
            step();
        }
        break;
    case 7U:
        (void)!message_deliver(&endpoint, record->octets, record->size);
        step();
        break;
    case 8U:
        members[at].is_running = !members[at].is_running;
        break;
    case 9U:
        empty_inbox(at);
        break;
    default:
        (void)!message_send(&members[at].endpoint, SUPERVISOR_APID, record->octets, record->size);
        step();
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    step();
    while (fuzz_next(&input, &record)) {
        act(&record);
    }
    is_stop_requested = true;
    for (unsigned i = 0U; (i < SHUTDOWN_TICKS) && !is_finished; i++) {
        for (unsigned at = 0U; at < MEMBERS; at++) {
            empty_inbox(at);
        }
        now_ns += TICK_NS;
        step();
    }
    FUZZ_CHECK(is_finished);
    supervisor_close(&supervisor);
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    if ((kind % 10U) == 7U) {
        return; // fuzz_message.c mutates the fields of raw frames.
    }
    if ((size > 12U) && ((fuzz_random(random) % 4U) != 0U)) { // A request of user 1, or a report.
        const bool is_tc = ((octets[0] & 0x10U) != 0U);
        octets[0] &= 0xF8U;
        octets[1] = is_tc ? (uint8_t[]){1U, 2U, 16U, 17U}[fuzz_random(random) % 4U] : octets[1];
        if (is_tc) {
            octets[9]  = 0U;
            octets[10] = 1U;
        }
    }
    fuzz_repair_packet(kind, octets, size, random);
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, repair);
}
