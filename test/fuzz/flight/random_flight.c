// SPDX-License-Identifier: Apache-2.0
// The image of a mission, commanded by random telecommands in each of its time steps, with invariants that
// are checked in each cycle of each subsystem. It is linked with launcher/image_main.c; the checks are in
// wrappers (-Wl,--wrap) of functions of the flight software and of the simulator.
// test/fuzz/random_flight.py starts it by `hirosco run`.
//
// Environment: RANDOM_FLIGHT="SEED TELECOMMANDS POOL RESULT". After a violation the program writes the seed,
// the reason and the last telecommands to RESULT.failure, in a format that pusdump reads, and aborts. The
// same seed repeats the flight.
#include "fsw/framework/subsystem/subsystem_core.h"
#include "fsw/programs/run_state.h"
#include "fsw/subsystems/communication/communication.h"
#include "fsw/supervisor/packet_log.h"
#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/socket.h"
#include "sim/app/simulator.h"
#include "sim/truth/truth.h"
#include "test/fuzz/flight/telecommands.h"
#include "test/fuzz/flight/violations.h"
#include "test/fuzz/fuzz.h"
#include "test/support/consistent_pool.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SUBSYSTEMS 4096U // Size of the tables whose index is an APID.
#define HISTORY 64U
#define DRIVES 32U
#define BEGIN_NS 300000000ULL       // The supervisor and communication are up.
#define QUIET_NS 15000000000ULL     // Time from the last telecommand until the shutdown of the mission.
#define SECURED_CYCLES 400U         // Most cycles from leaving OPERATIONAL until each brake holds: 200 ms.
#define LINKLESS_CYCLES 2U          // Most cycles in OPERATIONAL after the loss of a required link.
#define CALM_STEPS 40U              // Time steps between two telecommands of phase CALM, on average.
#define SCRIPT_STEP_NS 200000000ULL // Time between two requests of the script.
#define SCRIPT_NS 4000000000ULL
#define POOL_MAX 1048576U

/// Phases of a flight, which differ in the telecommands that are sent.
enum {
    LOAD = 0, // On average three telecommands in two time steps, of all kinds.
    CALM,     // Few telecommands, which bring subsystems up in any order.
    SCRIPT    // The telecommands of the script in order, which lead to operation with links.
};
enum { // Stages of a telecommand.
    UNSENT = 0,
    SENT,
    ACCEPTED,
    STARTED,
    ENDED
};

static struct {
    uint64_t seed;
    uint32_t wanted;
    char result[256];
    telecommands_t telecommands;
    run_state_t* run;
    osal_lockstep_t* scheduler;
    osal_socket_t socket;
    telecommand_t waiting; // The last telecommand; the octets from `waiting_from` on are not sent yet.
    size_t waiting_from;
    uint64_t now_ns;
    uint64_t last_ns; // Time of the last telecommand.
    uint32_t sent;
    uint32_t followed;
    uint32_t accepted;
    uint32_t refused;
    uint32_t unrouted;
    uint32_t arrived;   // Requests that reached the supervisor, on-board ones included.
    uint32_t reports;   // Reports of all processes of the spacecraft.
    uint32_t retrieved; // Reports that a packet store has sent to ground once more.
    uint32_t forwarded; // Reports that arrived on ground.
    uint32_t connections;
    uint32_t cycles_operational;
    uint32_t operational_entries;
    uint32_t linked_cycles; // Cycles in OPERATIONAL of subsystems that need links.
    uint64_t phase_end_ns;
    uint32_t phase;     // LOAD, CALM or SCRIPT.
    uint32_t script_at; // Number of the next request of the script.
    bool is_shut_down;
    bool is_retrieving;              // A packet store is sending a report that was followed before.
    const pus_tm_t* followed_report; // The report that is being followed, for the message of a violation.
} flight = {.socket = OSAL_SOCKET_CLOSED};

static uint8_t pool[POOL_MAX];
static uint8_t stage[2048][16384]; // Stage of each followed telecommand, by APID and sequence count.
static telecommand_t history[HISTORY];
static uint64_t history_ns[HISTORY];
static struct {
    state_t state;
    uint32_t cycles_out; // Cycles since OPERATIONAL was left.
    uint32_t cycles_linkless;
} seen[SUBSYSTEMS];
static struct {
    const char* bus;
    uint8_t node;
    bool is_plugged;
    bool is_braked;
} drives[DRIVES];
static unsigned drive_count;

// ---- Violations ----

static void write_history(FILE* const file)
{
    for (uint32_t i = (flight.sent > HISTORY) ? (flight.sent - HISTORY) : 0U; i < flight.sent; i++) {
        const telecommand_t* const telecommand = &history[i % HISTORY];
        (void)fprintf(file, "%" PRIu64 ".%09" PRIu64 " TC ", history_ns[i % HISTORY] / 1000000000U,
                      history_ns[i % HISTORY] % 1000000000U);
        for (size_t k = 0U; k < telecommand->size; k++) {
            (void)fprintf(file, "%02X", telecommand->octets[k]);
        }
        (void)fprintf(file, "\n");
    }
}

void random_flight_violated(const char* const condition, const unsigned apid)
{
    char path[300];
    (void)snprintf(path, sizeof path, "%s.failure", flight.result);
    FILE* const file = fopen(path, "w");
    if (file != NULL) {
        (void)fprintf(file, "# seed %" PRIu64 ", telecommand %u, %.6f s, APID %u: does not hold: %s\n",
                      flight.seed, flight.sent, (double)flight.now_ns * 1e-9, apid, condition);
        if (flight.followed_report != NULL) {
            const uint32_t request = octets_u32_at(flight.followed_report->data);
            (void)fprintf(file, "# report TM[1,%u] #%u about request %08" PRIX32 ", which is in stage %u\n",
                          flight.followed_report->subtype, flight.followed_report->sequence, request,
                          stage[(request >> 16U) & 0x7FFU][request & 0x3FFFU]);
        }
        write_history(file);
        (void)fclose(file);
    }
    abort();
}

/// An assertion that a telecommand makes fail is a violation.
void fsw_assertion_failed(const char* const file, const int line)
{
    char text[256];
    (void)snprintf(text, sizeof text, "assertion at %s:%d", file, line);
    random_flight_violated(text, 0U);
    abort();
}

void fuzz_fail(const char* const file, const int line, const char* const condition)
{
    (void)fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, condition);
    abort();
}

// ---- Invariants of each cycle ----

status_t __real_truth_drive(truth_t* truth, uint64_t time_ns, const truth_drive_t* drive);
status_t __wrap_truth_drive(truth_t* truth, uint64_t time_ns, const truth_drive_t* drive);
status_t __wrap_truth_drive(truth_t* const truth, const uint64_t time_ns, const truth_drive_t* const drive)
{
    unsigned at = 0U;
    while ((at < drive_count) &&
           ((drives[at].node != drive->node) || (strcmp(drives[at].bus, drive->bus) != 0))) {
        at++;
    }
    FUZZ_CHECK(at < DRIVES);
    drive_count           = (at == drive_count) ? (at + 1U) : drive_count;
    drives[at].bus        = drive->bus;
    drives[at].node       = drive->node;
    drives[at].is_plugged = drive->plugged;
    drives[at].is_braked  = drive->brake_engaged;
    return __real_truth_drive(truth, time_ns, drive);
}

/// Check that the brakes of a subsystem's drives hold, according to the simulated drives.
static void check_brakes(const subsystem_t* const subsystem)
{
    const subsystem_descriptor_t* const descriptor = subsystem->descriptor;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        const descriptor_device_t* const device = &descriptor->devices[i];
        if (strcmp(device->type, "joint-drive") != 0) {
            continue;
        }
        const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
        for (unsigned k = 0U; k < drive_count; k++) {
            const bool is_its =
                (drives[k].node == endnode->node) && (strcmp(drives[k].bus, endnode->bus) == 0);
            HOLDS(!is_its || drives[k].is_braked, descriptor->apid);
        }
    }
}

static bool has_required_links(const subsystem_t* const subsystem)
{
    const descriptor_configuration_t* const configuration = subsystem->configuration;
    bool has_all                                          = (configuration != NULL);
    for (uint16_t i = 0U; has_all && (i < configuration->port_count); i++) {
        const descriptor_port_t* const port = &subsystem->descriptor->ports[configuration->first_port + i];
        bool has_link                       = !port->is_required;
        for (size_t k = 0U; k < SUBSYSTEM_LINKS; k++) {
            const subsystem_link_t* const link = &subsystem->links[k];
            has_link                           = has_link || (link->is_used && (link->port->id == port->id) &&
                                    ((link->state == LINK_OPEN) || (link->state == LINK_STALE)));
        }
        has_all = has_link;
    }
    return has_all;
}

static bool needs_links(const subsystem_t* const subsystem)
{
    const descriptor_configuration_t* const configuration = subsystem->configuration;
    bool needs                                            = false;
    for (uint16_t i = 0U; (configuration != NULL) && (i < configuration->port_count); i++) {
        needs = needs || subsystem->descriptor->ports[configuration->first_port + i].is_required;
    }
    return needs;
}

static void check_subsystem(subsystem_t* const subsystem)
{
    const uint16_t apid = subsystem->descriptor->apid;
    FUZZ_CHECK(apid < SUBSYSTEMS);
    const state_t before = seen[apid].state;
    const state_t state  = subsystem->machine.state;
    HOLDS(state < STATE_COUNT, apid);
    HOLDS((state != STATE_OPERATIONAL) || (before == STATE_OPERATIONAL) || (before == STATE_SAFE_OPERATIONAL),
          apid);
    HOLDS(pool_is_consistent(&subsystem->call_tokens), apid);
    const bool is_operational  = (state == STATE_OPERATIONAL);
    const bool is_linkless     = is_operational && !has_required_links(subsystem);
    seen[apid].cycles_linkless = is_linkless ? (seen[apid].cycles_linkless + 1U) : 0U;
    HOLDS(seen[apid].cycles_linkless <= LINKLESS_CYCLES, apid);
    seen[apid].cycles_out = is_operational ? 0U : (seen[apid].cycles_out + 1U);
    if (seen[apid].cycles_out > SECURED_CYCLES) {
        check_brakes(subsystem);
    }
    if (apid >= 16U) {
        flight.cycles_operational += is_operational ? 1U : 0U;
        flight.linked_cycles += (is_operational && needs_links(subsystem)) ? 1U : 0U;
        flight.operational_entries += (is_operational && (before != STATE_OPERATIONAL)) ? 1U : 0U;
    }
    seen[apid].state = state;
}

uint64_t __real_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
uint64_t __wrap_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
uint64_t __wrap_subsystem_step(subsystem_t* const subsystem, const uint64_t now_ns)
{
    const uint64_t wake_ns = __real_subsystem_step(subsystem, now_ns);
    check_subsystem(subsystem);
    HOLDS(wake_ns > now_ns, subsystem->descriptor->apid);
    return wake_ns;
}

/// A life of a program begins in OFFLINE.
void __real_subsystem_init(subsystem_t* subsystem, const subsystem_config_t* config);
void __wrap_subsystem_init(subsystem_t* subsystem, const subsystem_config_t* config);
void __wrap_subsystem_init(subsystem_t* const subsystem, const subsystem_config_t* const config)
{
    __real_subsystem_init(subsystem, config);
    seen[config->descriptor->apid].state = STATE_OFFLINE;
}

// ---- Reports ----

static void follow(const pus_tm_t* const tm)
{
    if ((tm->service != 1U) || (tm->size < 4U) || (tm->destination != TELECOMMAND_USER)) {
        return;
    }
    const uint32_t request = octets_u32_at(tm->data);
    uint8_t* const at      = &stage[(request >> 16U) & 0x7FFU][request & 0x3FFFU];
    // A request of several instructions has a report of each failed one, with its number.
    const bool is_whole = (tm->size < 8U) || (octets_u16_at(&tm->data[6]) == 0U);
    const bool is_end   = (tm->subtype == 2U) || (tm->subtype == 7U) || (tm->subtype == 10U) ||
                        (((tm->subtype == 4U) || (tm->subtype == 8U)) && is_whole);
    if (*at == UNSENT) {
        return; // The report answers a packet of random octets, which is not followed.
    }
    flight.followed_report = tm;
    switch (tm->subtype) {
    case 1U:
        HOLDS(*at == SENT, tm->apid);
        flight.accepted++;
        *at = ACCEPTED;
        break;
    case 2U:
        HOLDS(*at == SENT, tm->apid);
        flight.refused++;
        break;
    case 3U:
        HOLDS(*at == ACCEPTED, tm->apid);
        *at = STARTED;
        break;
    default:
        flight.unrouted += (*at == SENT) ? 1U : 0U;
        HOLDS((*at != ENDED) || !is_end, tm->apid);
        break;
    }
    if (is_end) {
        *at = ENDED;
    }
    flight.followed_report = NULL;
}

/// ST[15] sends stored reports to ground once more, unchanged.
status_t __real_supervisor_router_send_stored(void* context, uint8_t virtual_channel, const uint8_t* packet,
                                              size_t size);
status_t __wrap_supervisor_router_send_stored(void* context, uint8_t virtual_channel, const uint8_t* packet,
                                              size_t size);
status_t __wrap_supervisor_router_send_stored(void* const context, const uint8_t virtual_channel,
                                              const uint8_t* const packet, const size_t size)
{
    flight.is_retrieving  = true;
    const status_t status = __real_supervisor_router_send_stored(context, virtual_channel, packet, size);
    flight.is_retrieving  = false;
    return status;
}

/// Each packet passes the packet log, also those that ST[14] does not forward to ground.
void __real_supervisor_packet_log_append(packet_log_t* log, uint64_t time_ns, bool is_tc,
                                         const uint8_t* packet, size_t size);
void __wrap_supervisor_packet_log_append(packet_log_t* log, uint64_t time_ns, bool is_tc,
                                         const uint8_t* packet, size_t size);
void __wrap_supervisor_packet_log_append(packet_log_t* const log, const uint64_t time_ns, const bool is_tc,
                                         const uint8_t* const packet, const size_t size)
{
    pus_tm_t tm;
    pus_failure_t failure;
    if (is_tc) {
        flight.arrived++;
    } else {
        HOLDS(pus_tm_decode(packet, size, &tm, &failure) == STATUS_OK, 0U);
        flight.reports++;
        if (flight.is_retrieving) {
            flight.retrieved++;
        } else {
            follow(&tm);
        }
    }
    __real_supervisor_packet_log_append(log, time_ns, is_tc, packet, size);
}

static void take_reports(void)
{
    static uint8_t octets[65536];
    static size_t size;
    size_t more = 0U;
    while (osal_socket_is_open(&flight.socket)) {
        const status_t status =
            osal_stream_receive(&flight.socket, &octets[size], sizeof octets - size, &more);
        if (status != STATUS_OK) {
            if (status != STATUS_EMPTY) {
                osal_socket_close(&flight.socket);
                size = 0U;
            }
            return;
        }
        size += more;
        size_t at     = 0U;
        size_t packet = 0U;
        while (pus_packet_frame(&octets[at], size - at, &packet) == STATUS_OK) {
            flight.forwarded++;
            at += packet;
        }
        size -= at;
        (void)memmove(octets, &octets[at], size);
    }
}

// ---- Telecommands ----

static void connect_again(void)
{
    osal_address_t own          = {0U, 0U};
    const osal_address_t ground = {OSAL_IPV4_LOOPBACK, flight.run->ground_port};
    if (osal_socket_is_open(&flight.socket) ||
        (osal_tcp_connect_begin(&flight.socket, ground) == STATUS_CLOSED)) {
        return;
    }
    if ((osal_socket_wait_writable(&flight.socket, 1000U) != STATUS_OK) ||
        (osal_socket_local_address(&flight.socket, &own) != STATUS_OK)) {
        osal_socket_close(&flight.socket);
        return;
    }
    osal_lockstep_set_stream_port(flight.scheduler, run_operator(flight.run), own.port);
    flight.waiting_from = flight.waiting.size;
    flight.connections++;
}

/// Send the waiting telecommand, or its rest. False if a part is not sent yet.
static bool send_waiting(void)
{
    unsigned component = 0U;
    size_t sent        = 0U;
    const size_t left  = flight.waiting.size - flight.waiting_from;
    if ((left == 0U) || !osal_socket_is_open(&flight.socket) ||
        !run_state_find(flight.run, COMMUNICATION_APID, &component) ||
        !osal_lockstep_is_present(flight.scheduler, run_participant(component))) {
        return left == 0U;
    }
    if (osal_stream_send(&flight.socket, &flight.waiting.octets[flight.waiting_from], left, &sent) !=
        STATUS_OK) {
        return false;
    }
    flight.waiting_from += sent;
    osal_lockstep_deliver(flight.scheduler, RUN_SIMULATOR, run_participant(component), OSAL_LOCKSTEP_ANY_LIFE,
                          0U, (uint32_t)sent);
    return flight.waiting_from == flight.waiting.size;
}

static void note(const telecommand_t* const telecommand)
{
    history[flight.sent % HISTORY]    = *telecommand;
    history_ns[flight.sent % HISTORY] = flight.now_ns;
    flight.sent++;
    flight.last_ns = flight.now_ns;
    if (telecommand->is_followed) {
        const uint32_t request                              = octets_u32_at(telecommand->octets);
        stage[(request >> 16U) & 0x7FFU][request & 0x3FFFU] = SENT;
        flight.followed++;
    } else if (telecommand->size >= 4U) {
        // The octets may repeat the request id of another telecommand, which is then no longer followed.
        const uint32_t request = octets_u32_at(telecommand->octets);
        uint8_t* const at      = &stage[(request >> 16U) & 0x7FFU][request & 0x3FFFU];
        flight.followed -= ((*at == SENT)) ? 1U : 0U;
        *at = UNSENT;
    } else {
        // The telecommand is too short for a request id.
    }
}

/// Begin the next phase: after LOAD either CALM or SCRIPT, after these LOAD again.
static void begin_phase(void)
{
    static const uint32_t longest_ms[] = {[LOAD] = 1600U, [CALM] = 3000U, [SCRIPT] = 1U};
    flight.phase     = (flight.phase == LOAD) ? (CALM + telecommands_random(&flight.telecommands, 2U)) : LOAD;
    flight.script_at = 0U;
    const uint32_t ms   = telecommands_random(&flight.telecommands, longest_ms[flight.phase]) + 1U;
    flight.phase_end_ns = flight.now_ns + ((flight.phase == SCRIPT) ? SCRIPT_NS : ((uint64_t)ms * 1000000U));
}

/// Get the next telecommand of this time step. False if there is no further one.
static bool next_telecommand(telecommand_t* const out)
{
    telecommands_t* const telecommands = &flight.telecommands;
    if (flight.phase == LOAD) { // True in 3 of 5 calls: 1.5 telecommands in a time step, on average.
        const bool is_due = (telecommands_random(telecommands, 5U) > 1U);
        if (is_due) {
            telecommands_draw(telecommands, out);
        }
        return is_due;
    }
    if (flight.phase == CALM) {
        const bool is_due = (telecommands_random(telecommands, CALM_STEPS) == 0U);
        if (is_due) {
            telecommands_draw_usual(telecommands, out);
        }
        return is_due;
    }
    const bool is_due = (flight.now_ns >= (flight.last_ns + SCRIPT_STEP_NS));
    flight.script_at += is_due ? 1U : 0U;
    return is_due && telecommands_take_script(telecommands, flight.script_at - 1U, out);
}

static void command(void)
{
    connect_again();
    take_reports();
    if (flight.now_ns >= flight.phase_end_ns) {
        begin_phase();
    }
    while ((flight.sent < flight.wanted) && send_waiting()) {
        telecommand_t next = {.size = 0U};
        if (!next_telecommand(&next)) {
            break;
        }
        flight.waiting      = next;
        flight.waiting_from = 0U;
        note(&flight.waiting);
    }
    (void)send_waiting();
    if ((flight.sent >= flight.wanted) && !flight.is_shut_down &&
        (flight.now_ns >= (flight.last_ns + QUIET_NS))) {
        flight.is_shut_down = true;
        __atomic_store_n(&flight.run->is_stop_requested, 1U, __ATOMIC_RELEASE);
    }
}

uint64_t __real_simulator_step(simulator_t* simulator, uint64_t now_ns);
uint64_t __wrap_simulator_step(simulator_t* simulator, uint64_t now_ns);
uint64_t __wrap_simulator_step(simulator_t* const simulator, const uint64_t now_ns)
{
    const uint64_t wake_ns = __real_simulator_step(simulator, now_ns);
    flight.now_ns          = now_ns;
    if (now_ns >= BEGIN_NS) {
        command();
    }
    return wake_ns;
}

// ---- Beginning and end ----

static bool load_pool(const char* const path)
{
    FILE* const file = fopen(path, "rb");
    if (file == NULL) {
        return false;
    }
    const size_t size = fread(pool, 1U, sizeof pool, file);
    (void)fclose(file);
    return telecommands_init(&flight.telecommands, flight.seed, pool, size);
}

status_t __real_run_state_attach(osal_shm_t* shm, const char* name, run_state_t** out_block);
status_t __wrap_run_state_attach(osal_shm_t* shm, const char* name, run_state_t** out_block);
status_t __wrap_run_state_attach(osal_shm_t* const shm, const char* const name, run_state_t** const out_block)
{
    char path[256];
    const char* const wish = getenv("RANDOM_FLIGHT");
    if ((wish == NULL) ||
        (sscanf(wish, "%" SCNu64 " %u %255s %255s", &flight.seed, &flight.wanted, path, // NOLINT
                flight.result) != 4) ||
        !load_pool(path)) {
        (void)fprintf(stderr,
                      "random flight: RANDOM_FLIGHT=\"SEED TELECOMMANDS POOL RESULT\" is missing or wrong\n");
        exit(2);
    }
    const status_t status = __real_run_state_attach(shm, name, out_block);
    flight.run            = *out_block;
    return status;
}

osal_lockstep_t* __real_osal_lockstep_attach(void* memory);
osal_lockstep_t* __wrap_osal_lockstep_attach(void* memory);
osal_lockstep_t* __wrap_osal_lockstep_attach(void* const memory)
{
    flight.scheduler = __real_osal_lockstep_attach(memory);
    return flight.scheduler;
}

/// Returns the number of followed telecommands from one stage to another.
static uint32_t requests_in(const uint8_t first, const uint8_t last)
{
    uint32_t count = 0U;
    for (unsigned apid = 0U; apid < 2048U; apid++) {
        for (unsigned i = 0U; i < 16384U; i++) {
            count += ((stage[apid][i] >= first) && (stage[apid][i] <= last)) ? 1U : 0U;
        }
    }
    return count;
}

/// The end of the flight: write the counts, which random_flight.py compares.
status_t __real_simulator_close(simulator_t* simulator);
status_t __wrap_simulator_close(simulator_t* simulator);
status_t __wrap_simulator_close(simulator_t* const simulator)
{
    FILE* const file = fopen(flight.result, "w");
    FUZZ_CHECK(file != NULL);
    const struct {
        const char* name;
        uint32_t value;
    } counts[] = {
        {"sent", flight.sent},
        {"followed", flight.followed},
        {"accepted", flight.accepted},
        {"refused", flight.refused},
        {"unrouted", flight.unrouted},
        {"unanswered", requests_in(SENT, SENT)},
        {"open", requests_in(ACCEPTED, STARTED)},
        {"arrived", flight.arrived},
        {"reports", flight.reports},
        {"retrieved", flight.retrieved},
        {"forwarded", flight.forwarded},
        {"connections", flight.connections},
        {"operational_cycles", flight.cycles_operational},
        {"operational_entries", flight.operational_entries},
        {"linked_cycles", flight.linked_cycles},
        {"shut_down", flight.is_shut_down ? 1U : 0U},
    };
    (void)fprintf(file, "{\"seed\": %" PRIu64 ", \"seconds\": %.3f", flight.seed,
                  (double)flight.now_ns * 1e-9);
    for (unsigned i = 0U; i < (sizeof counts / sizeof counts[0]); i++) {
        (void)fprintf(file, ", \"%s\": %u", counts[i].name, counts[i].value);
    }
    (void)fprintf(file, "}\n");
    (void)fclose(file);
    return __real_simulator_close(simulator);
}
