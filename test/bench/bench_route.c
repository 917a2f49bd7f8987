// SPDX-License-Identifier: Apache-2.0
// Housekeeping of a subsystem passes the supervisor, which logs each packet and forwards it to communication.
// Baseline: the same octets as a message from one component to another. The log is written to /dev/null.
#include "fsw/framework/message/ring_carrier.h"
#include "fsw/supervisor/supervisor.h"
#include "test/bench/measure.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MISSION "descriptors/missions/rokviss.xml"
#define DIRECTORY "build/bench/log"
#define MEMBERS 3U
#define GROUND 0U ///< Communication's index.
#define SOURCE 1U
#define NEAR 100U
#define FAR 101U
#define PACKETS 16U ///< Packets in a step.
#define STEPS 20U
#define VALUES 64U
#define START_STEPS 200U
#define TICK_NS 10000000ULL

static mission_descriptor_t mission;
static subsystem_descriptor_t descriptor;
static descriptor_loader_t loader;
static supervisor_t supervisor;
static message_endpoint_t endpoint;
static message_slot_t inbox[MEMBERS];
static message_ring_carrier_t hub;
static message_endpoint_t ends[2];
static message_slot_t end_inboxes[2];
static pus_app_process_t process;
static pus_report_queues_t report_queues;
static uint8_t packet[PUS_PACKET_MAX];
static size_t packet_size;
static uint64_t now_ns;
static unsigned routed;
static const uint16_t apids[MEMBERS] = {COMMUNICATION_APID, 16U, 17U};
static struct {
    message_endpoint_t endpoint;
    message_slot_t inbox[1];
} members[MEMBERS];

static void ignore_notice(void* context, uint16_t to)
{
    (void)context;
    (void)to;
}

static status_t start(void* context, uint16_t apid, uint32_t link_floor, uint64_t boot_ns)
{
    (void)context;
    (void)apid;
    (void)link_floor;
    (void)boot_ns;
    return STATUS_EXISTS;
}

static status_t stop(void* context, uint16_t apid)
{
    (void)context;
    (void)apid;
    return STATUS_OK;
}

static uint64_t promise(void* context, uint16_t apid)
{
    (void)context;
    (void)apid;
    return UINT64_MAX;
}

static bool is_running(void* context, uint16_t apid)
{
    (void)context;
    (void)apid;
    return true;
}

static bool stop_requested(void* context)
{
    (void)context;
    return false;
}

static void finished(void* context)
{
    (void)context;
}

static status_t send_up(void* context, const uint8_t* octets, size_t size)
{
    (void)context;
    packet_size = size;
    (void)memcpy(packet, octets, size); // The octets that by_message sends.
    return message_send(&members[SOURCE].endpoint, SUPERVISOR_APID, octets, size);
}

static void must(bool is_right)
{
    if (!is_right) {
        abort();
    }
}

/// Receive all packets that are sent to a member; count the housekeeping reports of SOURCE that reach GROUND.
static void empty_inbox(unsigned at)
{
    static uint8_t taken[PUS_PACKET_MAX];
    uint16_t from = 0U;
    size_t size   = 0U;
    pus_tm_t tm;
    pus_failure_t failure;
    while (message_receive(&members[at].endpoint, &from, taken, sizeof taken, &size) == STATUS_OK) {
        routed += ((at == GROUND) && !pus_packet_is_tc(taken, size) &&
                   (pus_tm_decode(taken, size, &tm, &failure) == STATUS_OK) && (tm.apid == apids[SOURCE]) &&
                   (tm.service == 3U))
                      ? 1U
                      : 0U;
    }
}

static void step(void)
{
    now_ns += TICK_NS;
    (void)supervisor_step(&supervisor, now_ns);
    for (unsigned i = 0U; i < MEMBERS; i++) {
        empty_inbox(i);
    }
}

static void by_supervisor(void)
{
    static const uint8_t values[VALUES];
    routed = 0U;
    for (unsigned i = 0U; i < STEPS; i++) {
        for (unsigned k = 0U; k < PACKETS; k++) {
            octet_writer_t writer = pus_tm_begin(&process, 3U, 25U, PUS_USER_GROUND, now_ns);
            octet_write_u16(&writer, 1U);
            octet_write_octets(&writer, values, sizeof values);
            must(pus_tm_send(&process, &writer) == STATUS_OK);
        }
        step();
    }
    step(); // Receive packets that arrived late.
    must(routed >= (STEPS * PACKETS));
}

static void by_message(void)
{
    static uint8_t taken[PUS_PACKET_MAX];
    uint16_t from = 0U;
    size_t size   = 0U;
    for (unsigned i = 0U; i < (STEPS * PACKETS); i++) {
        must(message_send(&ends[0], FAR, packet, packet_size) == STATUS_OK);
        must(message_receive(&ends[1], &from, taken, sizeof taken, &size) == STATUS_OK);
        if ((i % PACKETS) == (PACKETS - 1U)) { // The credits arrive in the sender's inbox.
            (void)!message_receive(&ends[0], &from, taken, sizeof taken, &size);
        }
    }
}

static void open_ends(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        message_open(&ends[i], (uint16_t)(NEAR + i), 1U, message_ring_carrier_port(&hub), &end_inboxes[i],
                     1U);
        must((message_add_peer(&ends[i], (uint16_t)(FAR - i)) == STATUS_OK) &&
             (message_ring_carrier_attach(&hub, &ends[i]) == STATUS_OK));
    }
}

static void open_members(void)
{
    message_open(&endpoint, SUPERVISOR_APID, 1U, message_ring_carrier_port(&hub), inbox, MEMBERS);
    must(message_ring_carrier_attach(&hub, &endpoint) == STATUS_OK);
    for (unsigned i = 0U; i < MEMBERS; i++) {
        message_open(&members[i].endpoint, apids[i], 1U, message_ring_carrier_port(&hub), members[i].inbox,
                     1U);
        must((message_add_peer(&endpoint, apids[i]) == STATUS_OK) &&
             (message_add_peer(&members[i].endpoint, SUPERVISOR_APID) == STATUS_OK) &&
             (message_ring_carrier_attach(&hub, &members[i].endpoint) == STATUS_OK));
    }
}

static void open_supervisor(void)
{
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
                                        .log_directory       = DIRECTORY,
                                        .start_count         = 1U};
    (void)mkdir(DIRECTORY, 0777);
    (void)!symlink("/dev/null", DIRECTORY "/packets.ascii");
    (void)!symlink("/dev/null", DIRECTORY "/packets.spool");
    (void)!symlink("/dev/null", DIRECTORY "/packets.ring");
    must(supervisor_init(&supervisor, &config) == STATUS_OK);
}

int main(void)
{
    const pus_port_t port = {NULL, send_up};
    descriptor_loader_init(&loader);
    must(descriptor_load_mission(&loader, MISSION, SUPERVISOR_APID, &descriptor_mission_whole, &mission,
                                 &descriptor) == STATUS_OK);
    message_ring_carrier_init(&hub, (message_delivery_notice_t){.delivered = ignore_notice});
    open_ends();
    open_members();
    open_supervisor();
    pus_app_process_init(&process, apids[SOURCE], mission.epoch_s, &port);
    pus_app_process_keep(&process, &report_queues);
    for (unsigned i = 0U; i < START_STEPS; i++) {
        step();
    }
    measure_compare("packets_routed", by_supervisor, by_message, STEPS * PACKETS, "ns", 1.0);
    supervisor_close(&supervisor);
    return 0;
}
