// SPDX-License-Identifier: Apache-2.0
// Routing: every packet between subsystems and ground is checked, logged and forwarded here.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

#define HOUSEKEEPING_REPORT 25U
#define DIAGNOSTIC_REPORT 26U
#define APID_MASK 0x07FFU               // Mask of the APID in the first word of a packet.
#define REQUEST_TIMEOUT_NS 100000000ULL ///< Longest time in which a running subsystem takes a packet.
#define INTAKE_PACKETS_MAX (MESSAGE_PEERS_MAX * MESSAGE_WINDOW)

/// Report when the ring begins to replace the selected strategy of the packet log, and when this ends; each
/// once.
static void report_log(supervisor_t* const supervisor)
{
    const packet_log_t* const log         = &supervisor->log;
    const bool has_failed                 = (log->strategy != log->wanted);
    const uint8_t wanted                  = (uint8_t)log->wanted;
    const pus_log_transition_t transition = {.previous     = has_failed ? wanted : (uint8_t)PACKET_LOG_RING,
                                             .strategy     = (uint8_t)log->strategy,
                                             .first_record = log->first_number,
                                             .code         = has_failed ? PUS_FAILURE_IO : PUS_FAILURE_NONE};
    if (has_failed == supervisor->is_log_failure_reported) {
        return;
    }
    supervisor->is_log_failure_reported = has_failed;
    if (has_failed) {
        (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_LOG_FAILED, &wanted, 1U);
    }
    (void)pus_log_transition_report(subsystem_process(&supervisor->subsystem), &transition,
                                    supervisor->now_ns);
}

/// Log a packet. A request that is longer than a packet is already in the log, in parts.
void supervisor_router_log(supervisor_t* const supervisor, const uint8_t* const packet, const size_t size)
{
    if (size <= PUS_PACKET_MAX) {
        const bool is_tc = pus_packet_is_tc(packet, size);
        supervisor_packet_log_append(&supervisor->log, supervisor->now_ns, is_tc, packet, size);
    }
}

void supervisor_router_flush_log(supervisor_t* const supervisor)
{
    supervisor_packet_log_step(&supervisor->log, supervisor->now_ns);
    report_log(supervisor);
}

/// Send a packet that may be lost; the endpoint counts losses.
static void send_now(supervisor_t* const supervisor, const uint16_t apid, const uint8_t* const packet,
                     const size_t size)
{
    const status_t status = message_send_plain(supervisor->config.endpoint, apid, packet, size);
    (void)status;
}

static bool is_ground(const uint16_t user)
{
    return user < PUS_USER_ONBOARD;
}

// ---- Reports ----

/// Update the supervisor's data from a report.
static void learn_from(supervisor_t* const supervisor, const pus_tm_t* const tm)
{
    pus_verification_t verification;
    if (pus_verification_read(tm, &verification) == STATUS_OK) {
        supervisor_doubt_verification(supervisor, tm, &verification);
        supervisor_pending_report(&supervisor->pending, tm->apid, tm->destination, &verification);
    }
    supervisor_registry_report(supervisor, tm);
    supervisor_link_manager_report(supervisor, tm);
    pus_event_occurrence_t occurrence;
    if (pus_event_occurrence_read(tm, &occurrence) == STATUS_OK) {
        supervisor_error_event(supervisor, &occurrence);
    }
}

/// Check, log and forward a report. `block` is the block that contains the packet; null if it is not in a
/// block.
static void route_report(supervisor_t* const supervisor, const uint16_t from, const uint8_t* const packet,
                         const size_t size, uint8_t* const block)
{
    pus_tm_t tm;
    pus_failure_t failure;
    const status_t status = pus_tm_decode(packet, size, &tm, &failure);
    if ((status != STATUS_OK) || (tm.apid != from)) {
        supervisor->counters.tm_malformed++;
        return;
    }
    supervisor_router_log(supervisor, packet, size);
    supervisor->counters.tm_routed++;
    // A report is logged and sent to ground before those that the supervisor makes in reaction to it.
    if (is_ground(tm.destination) && spacecraft_forwards(supervisor, &tm)) {
        supervisor_ground_send(supervisor, tm.apid, packet, size, block);
    }
    learn_from(supervisor, &tm);
    spacecraft_observe(supervisor, &tm, packet, size);
}

// ---- Requests ----

static void reject(supervisor_t* const supervisor, const pus_tc_t* const tc,
                   const pus_failure_t* const failure)
{
    const pus_token_t token = pus_token_of(tc);
    if ((failure->code == PUS_FAILURE_NO_ROUTE) || (failure->code == PUS_FAILURE_UNAVAILABLE) ||
        (failure->code == PUS_FAILURE_QUEUE_FULL)) {
        supervisor->counters.tc_unroutable++;
        pus_verify_unrouted(subsystem_process(&supervisor->subsystem), &token, failure, supervisor->now_ns);
    } else {
        supervisor->counters.tc_forbidden++;
        pus_verify_rejected(subsystem_process(&supervisor->subsystem), &token, failure, supervisor->now_ns);
    }
}

/// True if a request comes from the right component: ground users send through `communication`, and on-board
/// users are the components themselves.
static bool is_known_user(const supervisor_t* const supervisor, const uint16_t source, const uint16_t from)
{
    if (!is_ground(source)) {
        // `communication` has no requests of its own: it passes on the requests of ground users.
        return (source == (PUS_USER_ONBOARD | from)) && (from != COMMUNICATION_APID);
    }
    for (uint16_t i = 0U; i < supervisor->mission->user_count; i++) {
        if ((supervisor->mission->users[i].id == source) && (from == COMMUNICATION_APID)) {
            return true;
        }
    }
    return false;
}

/// True for a TC[129,8] with the supervisor as its source. The supervisor sends its own orders without this
/// check; a routed one is the request of a procedure, which has the rights of the user who has loaded it.
static bool is_foreign_order(const pus_tc_t* const tc)
{
    return (tc->source == PUS_USER_SUPERVISOR) && (tc->service == PUS_SERVICE_MANAGEMENT) &&
           (tc->subtype == (uint8_t)PUS_MANAGEMENT_ORDER_STATE);
}

/// Returns PUS_FAILURE_NONE if the request is permitted, otherwise the reason of its refusal.
static pus_failure_t refusal_of(supervisor_t* const supervisor, const pus_tc_t* const tc, const uint16_t from)
{
    if (!is_known_user(supervisor, tc->source, from) || is_foreign_order(tc)) {
        return pus_failure(PUS_FAILURE_SOURCE, tc->source);
    }
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, tc->apid);
    if (entry == NULL) {
        return pus_failure(PUS_FAILURE_NO_ROUTE, tc->apid);
    }
    if (!supervisor_registry_is_there(entry)) {
        return pus_failure(PUS_FAILURE_UNAVAILABLE, tc->apid);
    }
    return supervisor_permission_of(supervisor, tc);
}

/// Send a request to its addressee, which is a subsystem or the supervisor itself.
static status_t deliver_request(supervisor_t* const supervisor, const pus_tc_t* const tc,
                                const uint8_t* const packet, const size_t size)
{
    if (tc->apid == SUPERVISOR_APID) {
        const pus_token_t own = pus_token_of(tc);
        (void)supervisor_pending_add(&supervisor->own, tc->apid, &own, supervisor->now_ns);
        subsystem_accept_large(&supervisor->subsystem, packet, size, supervisor->now_ns);
        return STATUS_OK;
    }
    message_endpoint_t* const endpoint = supervisor->config.endpoint;
    const status_t status              = (pus_class_of(packet, size) == PUS_CLASS_FIRM)
                                             ? message_send(endpoint, tc->apid, packet, size)
                                             : message_send_plain(endpoint, tc->apid, packet, size);
    if (status == STATUS_OK) {
        const pus_token_t token = pus_token_of(tc);
        (void)supervisor_pending_add(&supervisor->pending, tc->apid, &token, supervisor->now_ns);
    }
    return status;
}

/// Log and check a request, then send it to its addressee or refuse it.
static void route_request(supervisor_t* const supervisor, const uint16_t from, const uint8_t* const packet,
                          const size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    supervisor_router_log(supervisor, packet, size);
    const status_t decoded = pus_tc_decode_large(packet, size, &tc, &failure);
    if (decoded != STATUS_OK) {
        supervisor->counters.tc_malformed++;
        const pus_token_t token = pus_token_of(&tc);
        if (size >= PUS_PRIMARY_HEADER_SIZE) { // The packet is long enough to contain a request id.
            pus_verify_rejected(subsystem_process(&supervisor->subsystem), &token, &failure,
                                supervisor->now_ns);
        }
        return;
    }
    failure = refusal_of(supervisor, &tc, from);
    if (failure.code == PUS_FAILURE_NONE) {
        const status_t status = deliver_request(supervisor, &tc, packet, size);
        if (status == STATUS_OK) {
            supervisor->counters.tc_routed++;
            return;
        }
        failure =
            pus_failure((status == STATUS_FULL) ? PUS_FAILURE_QUEUE_FULL : PUS_FAILURE_UNAVAILABLE, tc.apid);
    }
    reject(supervisor, &tc, &failure);
}

bool supervisor_router_has_room(const supervisor_t* const supervisor, const uint16_t apid)
{
    return (apid == SUPERVISOR_APID) || (message_credit_plain(supervisor->config.endpoint, apid) > 0U);
}

/// Like supervisor_router_has_room, for the supervisor's own orders, which may use the reserve.
static bool has_firm_room(const supervisor_t* const supervisor, const uint16_t apid)
{
    return (apid == SUPERVISOR_APID) || (message_credit(supervisor->config.endpoint, apid) > 0U);
}

void supervisor_router_route_released(supervisor_t* const supervisor, const uint8_t* const packet,
                                      const size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    const status_t status = pus_tc_decode(packet, size, &tc, &failure);
    (void)status; // route_request checks the packet again and reports the failure.
    route_request(supervisor, is_ground(tc.source) ? COMMUNICATION_APID : SUPERVISOR_APID, packet, size);
}

status_t supervisor_router_route_whole(supervisor_t* const supervisor, const uint8_t* const packet,
                                       const size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    const status_t status = pus_tc_decode_large(packet, size, &tc, &failure);
    FSW_ASSERT(status == STATUS_OK); // The caller has checked the packet.
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, tc.apid);
    const bool is_there                 = (entry != NULL) && supervisor_registry_is_there(entry);
    if (is_there && !supervisor_router_has_room(supervisor, tc.apid)) {
        return STATUS_FULL;
    }
    const uint16_t sender = (uint16_t)(tc.source & ~PUS_USER_ONBOARD);
    route_request(supervisor, is_ground(tc.source) ? COMMUNICATION_APID : sender, packet, size);
    return STATUS_OK;
}

typedef struct { // State of one call of supervisor_router_take_in.
    supervisor_t* supervisor;
    bool is_ground_held;                    // The next request from the ground waits for its addressee.
    uint16_t taken[MISSION_SUBSYSTEMS_MAX]; // Packets taken from each subsystem.
} intake_t;

static uint16_t* taken_of(intake_t* const intake, const uint16_t apid)
{
    const registry_entry_t* const entry = supervisor_registry_find(intake->supervisor, apid);
    return (entry == NULL) ? NULL : &intake->taken[entry - intake->supervisor->registry];
}

/// True if a packet of `peer` may be taken now. The number of packets of each subsystem is limited, so that
/// a flood from one subsystem cannot fill the step of the supervisor. No request from the ground is accepted
/// while there is no room for its answers: it waits in the window, and finally in the connection.
static bool may_receive(void* const context, const uint16_t peer)
{
    intake_t* const intake              = (intake_t*)context;
    const registry_entry_t* const entry = supervisor_registry_find(intake->supervisor, peer);
    const uint16_t* const taken         = taken_of(intake, peer);
    // The first packet of a new life of `communication` must not wait for room, because waiting reports can
    // only be sent after it.
    const bool is_first = (entry != NULL) && (entry->process == PROCESS_RUNNING) && !entry->is_heard;
    return (taken != NULL) && (*taken < MESSAGE_WINDOW) &&
           ((peer != COMMUNICATION_APID) || is_first ||
            (!intake->is_ground_held && supervisor_ground_takes_requests(intake->supervisor) &&
             subsystem_may_accept(&intake->supervisor->subsystem)));
}

static bool is_peer(void* const context, const uint16_t peer)
{
    return *(const uint16_t*)context == peer;
}

/// True if the ground's next packet is a request to a subsystem that has no room for it now. The request,
/// and all later packets from the ground, wait as long as a running subsystem may need to take a packet. If
/// the subsystem needs longer, requests to it are refused immediately until it takes a packet.
static bool must_wait(supervisor_t* const supervisor, const uint8_t* const head, const size_t size)
{
    const bool is_request         = (size >= PUS_TC_HEADER_SIZE) && pus_packet_is_tc(head, size);
    const uint16_t apid           = is_request ? (uint16_t)(octets_u16_at(head) & APID_MASK) : 0U;
    registry_entry_t* const entry = supervisor_registry_find(supervisor, apid);
    if ((entry == NULL) || !supervisor_registry_is_there(entry) ||
        supervisor_router_has_room(supervisor, apid)) {
        supervisor->held_for = 0U;
        if (entry != NULL) {
            entry->is_unresponsive = false;
        }
        return false;
    }
    if (supervisor->held_for != apid) {
        supervisor->held_for = apid;
        supervisor->held_ns  = supervisor->now_ns;
    }
    entry->is_unresponsive =
        entry->is_unresponsive || ((supervisor->now_ns - supervisor->held_ns) >= REQUEST_TIMEOUT_NS);
    return !entry->is_unresponsive;
}

/// True if the report taken last was sent by a life that has ended for the supervisor. The requests to that
/// life have ended, and a new life begins with its own first report, so the report must be dropped.
static bool is_of_ended_life(supervisor_t* const supervisor, const uint16_t from)
{
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, from);
    FSW_ASSERT(entry != NULL); // Packets arrive only from peers.
    const bool is_start_ordered = (entry->presumed == PRESUMED_RUNNING);
    return (entry->process != PROCESS_RUNNING) || is_start_ordered ||
           message_is_of_past(supervisor->config.endpoint);
}

/// Take the next packet into a block of its size, log and route it, and release the block: users that need
/// it longer have their own references. Without a free block, the packet is still handled, but it cannot
/// wait. STATUS_OK, STATUS_EMPTY, STATUS_BUSY (a request from the ground must wait).
static status_t take_packet(supervisor_t* const supervisor, const message_filter_t* const filter,
                            uint16_t* const out_from)
{
    message_endpoint_t* const endpoint = supervisor->config.endpoint;
    const uint8_t* head                = NULL;
    size_t size                        = 0U;
    status_t status                    = message_next(endpoint, filter, out_from, &head, &size);
    if (status != STATUS_OK) {
        return status;
    }
    if ((*out_from == COMMUNICATION_APID) && must_wait(supervisor, head, size)) {
        return STATUS_BUSY;
    }
    uint8_t* const block =
        (size > 0U) ? supervisor_ground_backlog_take(&supervisor->ground_backlog, size) : NULL;
    uint8_t* const packet = (block != NULL) ? block : supervisor->packet;
    const size_t capacity = (block != NULL) ? size : sizeof supervisor->packet;
    // Take the packet of this sender, even if the filter would no longer admit it.
    const message_filter_t same = {out_from, is_peer};
    status                      = message_receive_if(endpoint, &same, out_from, packet, capacity, &size);
    if ((status != STATUS_OK) || (size == 0U)) {
        supervisor->counters.tm_malformed++;
    } else if (pus_packet_is_tc(packet, size)) {
        route_request(supervisor, *out_from, packet, size);
    } else if (is_of_ended_life(supervisor, *out_from)) {
        endpoint->counters.stale++;
    } else {
        route_report(supervisor, *out_from, packet, size, block);
    }
    if (block != NULL) {
        supervisor_ground_backlog_give(&supervisor->ground_backlog, block);
    }
    return STATUS_OK;
}

void supervisor_router_take_in(supervisor_t* const supervisor)
{
    intake_t intake               = {.supervisor = supervisor};
    const message_filter_t filter = {&intake, may_receive};
    uint16_t from                 = 0U;
    status_t status               = STATUS_OK;
    for (unsigned i = 0U; (i < INTAKE_PACKETS_MAX) && (status != STATUS_EMPTY); i++) {
        status                = take_packet(supervisor, &filter, &from);
        intake.is_ground_held = intake.is_ground_held || (status == STATUS_BUSY);
        if (status == STATUS_OK) {
            uint16_t* const taken = taken_of(&intake, from);
            FSW_ASSERT(taken != NULL); // Packets arrive only from peers, and each peer has an entry.
            *taken = (uint16_t)(*taken + 1U);
        }
    }
    // Process the control frames of all peers, also of those whose packets must wait.
    message_take_control(supervisor->config.endpoint);
}

// ---- Packets of the supervisor itself ----

/// Send the supervisor's status report to every subsystem as its heartbeat.
static void send_heartbeat(supervisor_t* const supervisor, const uint8_t* const packet, const size_t size)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const uint16_t apid = supervisor->mission->subsystems[i].apid;
        if ((apid != SUPERVISOR_APID) && (apid != COMMUNICATION_APID) &&
            supervisor_registry_is_there(&supervisor->registry[i])) {
            send_now(supervisor, apid, packet, size); // If this one is lost, the next one follows.
        }
    }
}

/// True if the sender of a report sends it again later when the ground has no room now. Periodic reports, in
/// particular the heartbeat, are not sent again; they are only logged.
static bool may_wait(const pus_tm_t* const tm)
{
    const bool is_sampled = (tm->service == PUS_SERVICE_HOUSEKEEPING) &&
                            ((tm->subtype == HOUSEKEEPING_REPORT) || (tm->subtype == DIAGNOSTIC_REPORT));
    const bool is_heartbeat =
        (tm->service == PUS_SERVICE_MANAGEMENT) && (tm->subtype == PUS_MANAGEMENT_STATUS);
    return !is_sampled && !is_heartbeat;
}

status_t supervisor_router_send(void* const context, const uint8_t* const packet, const size_t size)
{
    supervisor_t* const supervisor = (supervisor_t*)context;
    if (pus_packet_is_tc(packet, size)) {
        pus_tc_t tc;
        pus_failure_t failure;
        const status_t decoded = pus_tc_decode(packet, size, &tc, &failure);
        FSW_ASSERT(decoded == STATUS_OK);
        const bool is_firm = (pus_class_of(packet, size) == PUS_CLASS_FIRM);
        if (!(is_firm ? has_firm_room(supervisor, tc.apid)
                      : supervisor_router_has_room(supervisor, tc.apid))) {
            return STATUS_FULL; // Not sent, so not logged.
        }
        supervisor_router_log(supervisor, packet, size); // Log the request before its effects.
        return deliver_request(supervisor, &tc, packet, size);
    }
    pus_tm_t tm;
    pus_failure_t failure;
    const status_t decoded = pus_tm_decode(packet, size, &tm, &failure);
    FSW_ASSERT(decoded == STATUS_OK);
    const bool is_for_ground = is_ground(tm.destination) && spacecraft_forwards(supervisor, &tm);
    if (is_for_ground && may_wait(&tm) &&
        !supervisor_ground_accepts(supervisor, pus_class_of(packet, size), size)) {
        return STATUS_FULL; // Not sent, so not logged.
    }
    supervisor_router_log(supervisor, packet, size);
    pus_verification_t verification;
    if (pus_verification_read(&tm, &verification) == STATUS_OK) {
        supervisor_pending_report(&supervisor->own, SUPERVISOR_APID, tm.destination, &verification);
    }
    if (is_for_ground) {
        // A report that cannot be sent is at least in the log.
        supervisor_ground_send(supervisor, tm.apid, packet, size, NULL);
    }
    if ((tm.service == PUS_SERVICE_MANAGEMENT) && (tm.subtype == PUS_MANAGEMENT_STATUS)) {
        send_heartbeat(supervisor, packet, size);
    }
    supervisor_registry_report(supervisor, &tm);
    pus_event_occurrence_t occurrence;
    if (pus_event_occurrence_read(&tm, &occurrence) == STATUS_OK) {
        supervisor_error_own_event(supervisor, &tm, &occurrence);
    }
    spacecraft_observe(supervisor, &tm, packet, size);
    return STATUS_OK;
}

status_t supervisor_order_state(supervisor_t* const supervisor, const uint16_t apid, const state_t target,
                                const pus_cause_t cause)
{
    registry_entry_t* const entry = supervisor_registry_find(supervisor, apid);
    octet_writer_t writer         = pus_tc_begin(&supervisor->requester, apid, PUS_SERVICE_MANAGEMENT,
                                                 PUS_MANAGEMENT_ORDER_STATE, PUS_ACK_COMPLETION);
    octet_write_u8(&writer, (uint8_t)target);
    octet_write_u8(&writer, (uint8_t)cause);
    pus_token_t token     = {.request_id = 0U};
    const status_t status = pus_tc_send(&supervisor->requester, &writer, &token);
    FSW_ASSERT(entry != NULL); // Only subsystems of the mission receive orders.
    entry->is_order_pending = (status == STATUS_FULL);
    entry->ordered          = target;
    entry->order_cause      = cause;
    entry->order.request_id = token.request_id;
    entry->order.time_ns    = supervisor->now_ns;
    return status;
}

void supervisor_send_pending_orders(supervisor_t* const supervisor)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        const registry_entry_t* const entry = &supervisor->registry[i];
        if (entry->is_order_pending && supervisor_registry_is_there(entry) &&
            has_firm_room(supervisor, entry->mission->apid)) {
            (void)supervisor_order_state(supervisor, entry->mission->apid, entry->ordered,
                                         entry->order_cause);
        }
    }
}

status_t supervisor_order_configuration(supervisor_t* const supervisor, const uint16_t apid,
                                        const uint16_t configuration)
{
    octet_writer_t writer = pus_tc_begin(&supervisor->requester, apid, PUS_SERVICE_MANAGEMENT,
                                         PUS_MANAGEMENT_SELECT, PUS_ACK_COMPLETION);
    octet_write_u16(&writer, configuration);
    return pus_tc_send(&supervisor->requester, &writer, NULL);
}
