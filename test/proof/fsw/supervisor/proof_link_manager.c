// SPDX-License-Identifier: Apache-2.0
// Proves: an epoch has one owner. Each opening of a link gets an epoch that is larger than all earlier ones,
//     and the supervisor first orders the producer of that link to open with this epoch; when the producer
//     has reported that it is open, the supervisor orders the consumer of the same link to open with the same
//     epoch. Two openings never have the same epoch, and a link never has two sessions. A consumer accepts
//     only frames with the epoch of its own opening (test/proof/fsw/framework/rtlink/proof_link_channel.c),
//     so it accepts frames of only one producer.
// Bounds: two sessions in any sound state, two links between any subsystems, one call of any kind (by
//     induction any number of calls), up to 2^32 - 1 openings.
// Replaced: the sending of a request may fail; reports of subsystems have any content, and name at most two
//     links; the registry, the mission and the graph of links return any result; verification and events do
//     nothing. The supervisor has only the members that its link manager uses.
// Sources: base/octets.c
// Options: --unwind 4
// Reduced: fsw/supervisor/checkpoint.h
//   - #define SUPERVISOR_LINK_SESSIONS 8U
//   + #define SUPERVISOR_LINK_SESSIONS 2U
// Reduced: fsw/supervisor/link_graph.h
//   - #define LINK_GRAPH_EDGES 32U
//   + #define LINK_GRAPH_EDGES 1U
// Reduced: fsw/framework/descriptor/mission_descriptor.h
//   - #define MISSION_LINKS_MAX CAPACITY_LINKS
//   + #define MISSION_LINKS_MAX 2U
// Fault: fsw/supervisor/link_manager.c
//   - supervisor->link_epoch++;
//   + supervisor->link_epoch |= 1U;
// Fault: fsw/supervisor/link_manager.c
//   - if ((session->step == SESSION_OPEN_PRODUCER) && (apid == session->ends.producer_apid)) {
//   + if (session->step == SESSION_OPEN_PRODUCER) {
// Fault: fsw/supervisor/link_manager.c
//   - if ((session_of_link(supervisor, open->link) != NULL) ||
//   + if ((open->link == 0U) ||
// The supervisor with only the members that its link manager uses.
#define FSW_SUPERVISOR_SUPERVISOR_H
#define FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_CORE_H
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/subsystem/state_machine.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "fsw/supervisor/checkpoint.h"
#include "fsw/supervisor/link_graph.h"
#include "generated/supervisor_descriptor.h"
#include "pus/core/app_process.h"
#include "pus/core/requester.h"
#include "pus/core/traffic_class.h"
#include "pus/private/st129_management.h"
#include "pus/private/st130_rtlink.h"
#include "pus/private/st131_mission.h"
#include "pus/st01/st01_verification.h"
#include "pus/st05/st05_events.h"
struct subsystem {
    int unused;
};
pus_app_process_t* subsystem_process(subsystem_t* subsystem);
typedef struct {
    const mission_subsystem_t* mission;
    state_t state;
    state_phase_t phase;
    bool are_links_adopted;
} registry_entry_t;
typedef struct supervisor {
    const mission_descriptor_t* mission;
    subsystem_t subsystem;
    uint64_t now_ns;
    pus_requester_t requester;
    link_graph_t graph;
    link_session_t sessions[SUPERVISOR_LINK_SESSIONS];
    uint16_t closings[MISSION_LINKS_MAX];
    link_edge_t accepted[MISSION_LINKS_MAX];
    uint32_t link_epoch;
    uint32_t link_transaction;
    pus_link_properties_t wanted[MISSION_LINKS_MAX];
} supervisor_t;
#include "fsw/supervisor/link_manager.c"

#include "test/proof/proof.h"

static supervisor_t supervisor;
static mission_link_t links[MISSION_LINKS_MAX];
static mission_descriptor_t mission = {.links = links, .link_count = MISSION_LINKS_MAX};
static registry_entry_t entry;         // Entry of any subsystem that the manager looks up.
static link_edge_t edge;               // Edge of any link that the manager looks up.
static uint16_t addressee;             // Addressee of the request that is being written.
static pus_link_transition_t reported; // Report of a subsystem about a link.
static pus_link_open_t ordered;        // The order to open.
static uint16_t ordered_apid;          // Addressee of the order.
static unsigned orders;                // Number of orders to open.

// ---- Replacements of the services and of the other parts of the supervisor ----

octet_writer_t pus_tc_begin(pus_requester_t* const requester, const uint16_t apid, const uint8_t service,
                            const uint8_t subtype, const uint8_t ack)
{
    (void)requester;
    (void)service;
    (void)subtype;
    (void)ack;
    addressee = apid;
    return (octet_writer_t){0};
}

void pus_link_open_write(octet_writer_t* const writer, const pus_link_open_t* const open)
{
    (void)writer;
    ordered      = *open;
    ordered_apid = addressee;
    orders++;
}

void pus_link_request_write(octet_writer_t* const writer, const pus_link_request_t* const request)
{
    (void)writer;
    (void)request;
}

void pus_link_close_write(octet_writer_t* const writer, const pus_link_close_t* const close)
{
    (void)writer;
    (void)close;
}

status_t pus_tc_send(pus_requester_t* const requester, octet_writer_t* const writer,
                     pus_token_t* const out_token)
{
    (void)requester;
    (void)writer;
    (void)out_token;
    return nondet_bool() ? STATUS_OK : STATUS_FULL;
}

static status_t any_reading(void)
{
    return nondet_bool() ? STATUS_OK : STATUS_INVALID;
}

status_t pus_link_accept_read(octet_reader_t* const reader, pus_link_accept_t* const out_accept)
{
    (void)reader;
    out_accept->transaction = nondet_u32();
    return any_reading();
}

status_t pus_link_refuse_read(octet_reader_t* const reader, pus_link_refuse_t* const out_refuse)
{
    (void)reader;
    out_refuse->transaction = nondet_u32();
    return any_reading();
}

status_t pus_link_transition_read(octet_reader_t* const reader, pus_link_transition_t* const out_transition)
{
    (void)reader;
    reported = (pus_link_transition_t){.link = nondet_u16(), .previous = nondet_u8(), .state = nondet_u8()};
    *out_transition = reported;
    return any_reading();
}

status_t pus_link_statuses_read(octet_reader_t* const reader, uint16_t* const out_count)
{
    (void)reader;
    *out_count = nondet_u16();
    ASSUME(*out_count <= MISSION_LINKS_MAX);
    return any_reading();
}

void pus_link_status_read(octet_reader_t* const reader, pus_link_status_t* const out_status)
{
    (void)reader;
    out_status->link  = nondet_u16();
    out_status->state = nondet_u8();
}

status_t pus_link_accept_report(pus_app_process_t* const process, const uint16_t destination,
                                const pus_link_accept_t* const accept, const uint64_t now_ns)
{
    (void)process;
    (void)destination;
    (void)accept;
    (void)now_ns;
    return STATUS_OK;
}

status_t pus_link_refuse_report(pus_app_process_t* const process, const uint16_t destination,
                                const pus_link_refuse_t* const refuse, const uint64_t now_ns)
{
    (void)process;
    (void)destination;
    (void)refuse;
    (void)now_ns;
    return STATUS_OK;
}

pus_app_process_t* subsystem_process(subsystem_t* const subsystem)
{
    (void)subsystem;
    return NULL;
}

void pus_verify_ended(pus_app_process_t* const process, const pus_token_t* const token,
                      const pus_failure_t failure, const uint64_t now_ns)
{
    (void)process;
    (void)token;
    (void)failure;
    (void)now_ns;
}

pus_failure_t pus_failure(const uint16_t code, const uint32_t detail)
{
    return (pus_failure_t){.code = code, .detail = detail};
}

pus_reply_t pus_done(void)
{
    return (pus_reply_t){0};
}

pus_reply_t pus_later(void)
{
    return (pus_reply_t){0};
}

pus_reply_t pus_refused(const uint16_t code, const uint32_t detail)
{
    (void)code;
    (void)detail;
    return (pus_reply_t){0};
}

pus_reply_t pus_failed(const uint16_t code, const uint32_t detail)
{
    (void)code;
    (void)detail;
    return (pus_reply_t){0};
}

void supervisor_raise_u16_u16(supervisor_t* const self, const uint16_t event_id, const uint16_t first,
                              const uint16_t second)
{
    (void)self;
    (void)event_id;
    (void)first;
    (void)second;
}

registry_entry_t* supervisor_registry_find(supervisor_t* const self, const uint16_t apid)
{
    (void)self;
    bool is_end_of_link = false;
    for (unsigned i = 0U; i < MISSION_LINKS_MAX; i++) {
        is_end_of_link =
            is_end_of_link || (links[i].producer_apid == apid) || (links[i].consumer_apid == apid);
    }
    entry.state             = (state_t)(nondet_u8() % (unsigned)STATE_COUNT);
    entry.phase             = (state_phase_t)nondet_u8();
    entry.are_links_adopted = nondet_bool();
    return (is_end_of_link || nondet_bool()) ? &entry : NULL;
}

const mission_link_t* descriptor_mission_find_link(const mission_descriptor_t* const descriptor,
                                                   const uint16_t producer_apid, const uint16_t producer_port,
                                                   const uint16_t consumer_apid, const uint16_t consumer_port)
{
    (void)producer_apid;
    (void)producer_port;
    (void)consumer_apid;
    (void)consumer_port;
    return nondet_bool() ? &descriptor->links[nondet_bool() ? 1U : 0U] : NULL;
}

bool supervisor_link_graph_remove(link_graph_t* const graph, const uint16_t link)
{
    (void)graph;
    (void)link;
    return nondet_bool();
}

static pus_link_ends_t ends_of(const uint16_t link)
{
    const mission_link_t* const found = &links[(link - 1U) % MISSION_LINKS_MAX];
    return (pus_link_ends_t){found->producer_apid, found->producer_port, found->consumer_apid,
                             found->consumer_port};
}

link_edge_t* supervisor_link_graph_find(link_graph_t* const graph, const uint16_t link)
{
    (void)graph;
    edge = (link_edge_t){.link = link, .ends = ends_of(link), .is_stale = nondet_bool()};
    return ((link >= 1U) && (link <= MISSION_LINKS_MAX) && nondet_bool()) ? &edge : NULL;
}

status_t supervisor_link_graph_add(link_graph_t* const graph, const link_edge_t* const added)
{
    (void)graph;
    PROVE(added->link != 0U, "only a link that was agreed on is added");
    return nondet_bool() ? STATUS_OK : STATUS_EXHAUSTED;
}

// ---- Statements ----

static bool is_opening(const link_session_t* const session)
{
    return (session->step == SESSION_OPEN_PRODUCER) || (session->step == SESSION_OPEN_CONSUMER);
}

static bool has_its_ends(const uint16_t link, const pus_link_ends_t* const ends)
{
    const pus_link_ends_t own = ends_of(link);
    return (ends->producer_apid == own.producer_apid) && (ends->consumer_apid == own.consumer_apid);
}

static bool is_session_sound(const link_session_t* const one)
{
    if (one->step == SESSION_FREE) {
        return true;
    }
    return (one->step <= SESSION_CLOSING) && (one->link >= 1U) && (one->link <= MISSION_LINKS_MAX) &&
           has_its_ends(one->link, &one->ends) &&
           (!is_opening(one) || ((one->epoch >= 1U) && (one->epoch <= supervisor.link_epoch) &&
                                 (supervisor.accepted[one->link - 1U].link == one->link)));
}

static bool is_sound(void)
{
    bool is_good = true;
    for (uint16_t link = 1U; link <= MISSION_LINKS_MAX; link++) {
        const link_edge_t* const accepted = &supervisor.accepted[link - 1U];
        is_good                           = is_good && ((accepted->link == 0U) ||
                              ((accepted->link == link) && has_its_ends(link, &accepted->ends)));
    }
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        const link_session_t* const one = &supervisor.sessions[i];
        is_good                         = is_good && is_session_sound(one);
        for (size_t j = 0U; j < i; j++) {
            const link_session_t* const other = &supervisor.sessions[j];
            const bool are_used               = (one->step != SESSION_FREE) && (other->step != SESSION_FREE);
            is_good                           = is_good && !(are_used && (one->link == other->link)) &&
                      !(is_opening(one) && is_opening(other) && (one->epoch == other->epoch));
        }
    }
    return is_good;
}

static void any_mission(void)
{
    for (uint16_t i = 0U; i < MISSION_LINKS_MAX; i++) {
        links[i] = (mission_link_t){
            .number = (uint16_t)(i + 1U), .producer_apid = nondet_u16(), .consumer_apid = nondet_u16()};
        ASSUME(links[i].producer_apid != links[i].consumer_apid);
    }
    supervisor.mission = &mission;
}

static void any_sound_state(void)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        link_session_t session;
        supervisor.sessions[i] = session;
    }
    for (uint16_t i = 0U; i < MISSION_LINKS_MAX; i++) {
        const uint16_t link    = (uint16_t)(i + 1U);
        supervisor.accepted[i] = (link_edge_t){.link = nondet_bool() ? link : 0U, .ends = ends_of(link)};
        supervisor.closings[i] = nondet_bool() ? ends_of(link).producer_apid : 0U;
        supervisor.wanted[i].layout_size = nondet_u32();
    }
    supervisor.now_ns           = nondet_u64();
    supervisor.link_transaction = nondet_u32();
    supervisor.link_epoch       = nondet_u32();
    ASSUME((supervisor.link_epoch < UINT32_MAX) && is_sound());
}

/// Make one call of any kind. Returns the APID of the reporting subsystem if the call passes a report;
/// otherwise 0.
static uint16_t call(void)
{
    const pus_token_t token          = {.source = nondet_u16()};
    const pus_link_request_t request = {.transaction = nondet_u32()};
    const pus_link_open_t open       = {.link = nondet_u16(), .epoch = nondet_u32()};
    const pus_link_close_t close     = {.link = nondet_u16()};
    const pus_tm_t tm                = {.apid        = nondet_u16(),
                                        .service     = PUS_SERVICE_RTLINK,
                                        .subtype     = nondet_u8(),
                                        .destination = nondet_u16()};
    const pus_rtlink_port_t port     = supervisor_link_manager_port(&supervisor);
    pus_link_answer_t answer;
    switch (nondet_u8()) {
    case 0:
        (void)port.request(port.context, &request, &answer, &token, nondet_u64());
        return 0U;
    case 1:
        (void)port.open(port.context, &open, &token, nondet_u64());
        return 0U;
    case 2:
        (void)port.close(port.context, &close, &token, nondet_u64());
        return 0U;
    case 3:
        (void)supervisor_link_manager_renew(&supervisor, nondet_bool() ? 1U : 2U);
        return 0U;
    case 4:
        supervisor_link_manager_settle(&supervisor);
        return 0U;
    case 5:
        supervisor_link_manager_watch(&supervisor);
        return 0U;
    case 6:
        supervisor_link_manager_member_lost(&supervisor, nondet_u16());
        return 0U;
    default:
        supervisor_link_manager_report(&supervisor, &tm);
        return tm.apid;
    }
}

void proof(void)
{
    any_mission();
    PROVE(is_sound(), "the initial state of the manager is sound");
    any_sound_state();
    const uint32_t before = supervisor.link_epoch;
    link_session_t sessions_before[SUPERVISOR_LINK_SESSIONS];
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        sessions_before[i] = supervisor.sessions[i];
    }
    const uint16_t reporter = call();
    PROVE(orders <= 1U, "one call sends at most one order to open");
    if (orders == 0U) {
        PROVE(supervisor.link_epoch == before, "only an opening takes an epoch");
    } else if (ordered.epoch > before) {
        PROVE((ordered.epoch == (before + 1U)) && (supervisor.link_epoch == ordered.epoch),
              "the epoch is new");
        PROVE(ordered_apid == ends_of(ordered.link).producer_apid, "the producer gets the first order");
    } else {
        bool is_of_session = false;
        for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
            is_of_session = is_of_session || ((sessions_before[i].step == SESSION_OPEN_PRODUCER) &&
                                              (sessions_before[i].link == ordered.link) &&
                                              (sessions_before[i].epoch == ordered.epoch));
        }
        PROVE(is_of_session, "the order to the consumer has the epoch of the producer's opening");
        PROVE((reporter == ends_of(ordered.link).producer_apid) && (reported.link == ordered.link) &&
                  (reported.state == (uint8_t)PUS_LINK_STATE_OPEN),
              "the consumer is ordered after the producer has reported that it is open");
        PROVE(ordered_apid == ends_of(ordered.link).consumer_apid,
              "the second order goes to the consumer of this link");
        PROVE(supervisor.link_epoch == before, "the order to the consumer takes no epoch");
    }
    PROVE(is_sound(), "the state of the manager stays sound");
}
