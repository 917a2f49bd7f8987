// SPDX-License-Identifier: Apache-2.0
// Manager of real-time links: negotiates between two subsystems on request, opens both ends with one epoch,
// and keeps the graph of open links. A link's id is its number in the mission.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

#include <string.h>

#define SESSION_TIMEOUT_NS 2000000000ULL ///< Longest time between two steps of a session.

// ---- Sessions ----

static link_session_t* session_of_link(supervisor_t* const supervisor, const uint16_t link)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        if ((supervisor->sessions[i].step != SESSION_FREE) && (supervisor->sessions[i].link == link)) {
            return &supervisor->sessions[i];
        }
    }
    return NULL;
}

static link_session_t* new_session(supervisor_t* const supervisor, const uint16_t link,
                                   const session_step_t step, const pus_token_t* const token)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        link_session_t* const session = &supervisor->sessions[i];
        if (session->step == SESSION_FREE) {
            *session = (link_session_t){.step        = step,
                                        .link        = link,
                                        .token       = *token,
                                        .deadline_ns = supervisor->now_ns + SESSION_TIMEOUT_NS};
            return session;
        }
    }
    return NULL;
}

/// True if the supervisor itself has started the session, so that there is no request to answer.
static bool is_own(const link_session_t* const session)
{
    return session->token.source == 0U;
}

static void end_session(supervisor_t* const supervisor, link_session_t* const session, const uint16_t code,
                        const uint32_t detail)
{
    pus_app_process_t* const process = subsystem_process(&supervisor->subsystem);
    if (!is_own(session)) {
        pus_verify_ended(process, &session->token, pus_failure(code, detail), supervisor->now_ns);
    }
    session->step = SESSION_FREE;
}

/// Returns the link with this number if both ends have agreed on it; otherwise null.
static link_edge_t* accepted_of(supervisor_t* const supervisor, const uint16_t link)
{
    const bool is_link = (link >= 1U) && (link <= MISSION_LINKS_MAX);
    return (is_link && (supervisor->accepted[link - 1U].link == link)) ? &supervisor->accepted[link - 1U]
                                                                       : NULL;
}

static bool is_end(const pus_link_ends_t* const ends, const uint16_t apid)
{
    return (ends->producer_apid == apid) || (ends->consumer_apid == apid);
}

// ---- Requests to subsystems ----

static status_t ask_member(supervisor_t* const supervisor, const uint16_t apid,
                           const link_session_t* const session, const pus_link_properties_t* const properties)
{
    const pus_link_request_t request = {.transaction = session->transaction,
                                        .link        = session->link,
                                        .ends        = session->ends,
                                        .properties  = *properties};
    octet_writer_t writer =
        pus_tc_begin(&supervisor->requester, apid, PUS_SERVICE_RTLINK, PUS_LINK_REQUEST, 0U);
    pus_link_request_write(&writer, &request);
    return pus_tc_send(&supervisor->requester, &writer, NULL);
}

static status_t open_member(supervisor_t* const supervisor, const uint16_t apid,
                            const link_session_t* const session)
{
    const pus_link_open_t open = {.link = session->link, .epoch = session->epoch};
    octet_writer_t writer = pus_tc_begin(&supervisor->requester, apid, PUS_SERVICE_RTLINK, PUS_LINK_OPEN, 0U);
    pus_link_open_write(&writer, &open);
    return pus_tc_send(&supervisor->requester, &writer, NULL);
}

static status_t close_member(supervisor_t* const supervisor, const uint16_t apid, const uint16_t link,
                             const uint8_t reason)
{
    const pus_link_close_t close = {.link = link, .reason = reason};
    octet_writer_t writer =
        pus_tc_begin(&supervisor->requester, apid, PUS_SERVICE_RTLINK, PUS_LINK_CLOSE, 0U);
    pus_link_close_write(&writer, &close);
    return pus_tc_send(&supervisor->requester, &writer, NULL);
}

/// Record that a link is no longer agreed or open.
static void drop_link(supervisor_t* const supervisor, const uint16_t link)
{
    link_edge_t* const accepted = accepted_of(supervisor, link);
    (void)supervisor_link_graph_remove(&supervisor->graph, link);
    if (accepted != NULL) {
        accepted->link = 0U;
    }
}

/// True if a subsystem is in OFFLINE or on the way there: it then closes its links by itself.
static bool is_going_offline(supervisor_t* const supervisor, const uint16_t apid)
{
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, apid);
    FSW_ASSERT(entry != NULL); // Both ends of a link are subsystems of the mission.
    return (entry->state == STATE_OFFLINE) || (entry->state >= STATE_POST_OPERATIONAL);
}

/// Close the other end of a link if it has not closed by itself.
static void close_now(supervisor_t* const supervisor, const uint16_t link)
{
    const uint16_t apid = supervisor->closings[link - 1U];
    if ((apid != 0U) && !is_going_offline(supervisor, apid)) {
        (void)close_member(supervisor, apid, link, (uint8_t)PUS_LINK_REASON_PEER);
    }
    supervisor->closings[link - 1U] = 0U;
}

/// Close the link at both ends, but not at the end with the APID `without`, which has nothing to close (0:
/// close both).
static void forget_link(supervisor_t* const supervisor, const uint16_t link,
                        const pus_link_ends_t* const ends, const uint16_t without)
{
    drop_link(supervisor, link);
    if (ends->producer_apid != without) {
        (void)close_member(supervisor, ends->producer_apid, link, (uint8_t)PUS_LINK_REASON_PEER);
    }
    if (ends->consumer_apid != without) {
        (void)close_member(supervisor, ends->consumer_apid, link, (uint8_t)PUS_LINK_REASON_PEER);
    }
}

/// Abort a session: close each end that is open or has accepted, but not that of `failed` (an APID, or 0).
static void give_up(supervisor_t* const supervisor, link_session_t* const session, const uint16_t failed,
                    const uint16_t code, const uint32_t detail)
{
    const bool is_agreed = (accepted_of(supervisor, session->link) != NULL);
    const bool is_open   = (supervisor_link_graph_find(&supervisor->graph, session->link) != NULL);
    if (session->step == SESSION_CLOSING) {
        drop_link(supervisor, session->link); // Both ends have been requested to close.
    } else if ((session->step != SESSION_ASK_PRODUCER) ||
               (is_agreed && !((code == PUS_FAILURE_LINK_REFUSED) && is_open))) {
        forget_link(supervisor, session->link, &session->ends, failed);
    } else {
        // No end has accepted yet, or the producer refuses and keeps the end that it has open.
    }
    end_session(supervisor, session, code, detail);
}

// ---- Port of service 130 ----

static bool no_offer(void* const context, const uint16_t index, pus_link_offer_t* const out_offer)
{
    (void)context;
    (void)index;
    (void)out_offer;
    return false; // The supervisor has no ports; the subsystems report their own.
}

static bool is_configured(supervisor_t* const supervisor, const uint16_t apid)
{
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, apid);
    return (entry != NULL) && (entry->state == STATE_PRE_OPERATIONAL) && (entry->phase == PHASE_CONFIGURED);
}

static void refuse(pus_link_answer_t* const answer, const pus_link_reason_t reason,
                   const pus_link_field_t field, const pus_link_properties_t* const wanted)
{
    answer->is_accepted      = false;
    answer->refuse.reason    = (uint8_t)reason;
    answer->refuse.field     = (uint8_t)field;
    answer->refuse.supported = *wanted;
}

/// Begin to negotiate a link. Null if the link already has a session, no session is free, or the request to
/// the producer cannot be sent.
static link_session_t* begin_negotiation(supervisor_t* const supervisor, const mission_link_t* const link,
                                         const pus_link_properties_t* const wanted,
                                         const pus_token_t* const token)
{
    link_session_t* const session = (session_of_link(supervisor, link->number) == NULL)
                                        ? new_session(supervisor, link->number, SESSION_ASK_PRODUCER, token)
                                        : NULL;
    if (session == NULL) {
        return NULL;
    }
    close_now(supervisor, link->number); // A pending close must precede the new negotiation.
    supervisor->link_transaction++;
    session->ends =
        (pus_link_ends_t){link->producer_apid, link->producer_port, link->consumer_apid, link->consumer_port};
    session->transaction = supervisor->link_transaction;
    session->wanted      = *wanted;
    if (ask_member(supervisor, link->producer_apid, session, wanted) != STATUS_OK) {
        session->step = SESSION_FREE;
        return NULL;
    }
    return session;
}

static pus_reply_t request_link(void* const context, const pus_link_request_t* const request,
                                pus_link_answer_t* const out_answer, const pus_token_t* const token,
                                const uint64_t now_ns)
{
    supervisor_t* const supervisor    = (supervisor_t*)context;
    supervisor->now_ns                = now_ns;
    const pus_link_ends_t* const ends = &request->ends;
    const mission_link_t* const link =
        descriptor_mission_find_link(supervisor->mission, ends->producer_apid, ends->producer_port,
                                     ends->consumer_apid, ends->consumer_port);
    if (link == NULL) {
        refuse(out_answer, PUS_LINK_REASON_PORT, PUS_LINK_FIELD_PORT, &request->properties);
        return pus_done();
    }
    if (!is_configured(supervisor, ends->producer_apid) || !is_configured(supervisor, ends->consumer_apid)) {
        refuse(out_answer, PUS_LINK_REASON_STATE, PUS_LINK_FIELD_NONE, &request->properties);
        return pus_done();
    }
    link_session_t* const session = begin_negotiation(supervisor, link, &request->properties, token);
    if (session == NULL) {
        refuse(out_answer, PUS_LINK_REASON_RESOURCE, PUS_LINK_FIELD_NONE, &request->properties);
        return pus_done();
    }
    session->asked = request->transaction;
    return pus_later();
}

/// Begin to open a link with a new epoch. False: the request to the producer could not be sent, and the
/// session has ended.
static bool begin_opening(supervisor_t* const supervisor, link_session_t* const session,
                          const link_edge_t* const accepted)
{
    supervisor->link_epoch++;
    session->epoch = supervisor->link_epoch;
    session->ends  = accepted->ends;
    if (open_member(supervisor, accepted->ends.producer_apid, session) != STATUS_OK) {
        session->step = SESSION_FREE;
        return false;
    }
    return true;
}

static pus_reply_t open_link(void* const context, const pus_link_open_t* const open,
                             const pus_token_t* const token, const uint64_t now_ns)
{
    supervisor_t* const supervisor    = (supervisor_t*)context;
    supervisor->now_ns                = now_ns;
    const link_edge_t* const accepted = accepted_of(supervisor, open->link);
    if (accepted == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, open->link);
    }
    if ((session_of_link(supervisor, open->link) != NULL) ||
        (supervisor_link_graph_find(&supervisor->graph, open->link) != NULL)) {
        return pus_refused(PUS_FAILURE_STATE, open->link); // A time-out would close an open link.
    }
    link_session_t* const session = new_session(supervisor, open->link, SESSION_OPEN_PRODUCER, token);
    if (session == NULL) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, SUPERVISOR_LINK_SESSIONS);
    }
    return begin_opening(supervisor, session, accepted)
               ? pus_later()
               : pus_failed(PUS_FAILURE_NO_ANSWER, accepted->ends.producer_apid);
}

bool supervisor_link_manager_renew(supervisor_t* const supervisor, const uint16_t link)
{
    static const pus_token_t no_request = {.source = 0U};
    FSW_ASSERT((link >= 1U) && (link <= supervisor->mission->link_count));
    const mission_link_t* const mission_link  = &supervisor->mission->links[link - 1U];
    const link_edge_t* const accepted         = accepted_of(supervisor, link);
    const pus_link_properties_t* const wanted = &supervisor->wanted[link - 1U];
    if ((session_of_link(supervisor, link) != NULL) || (wanted->layout_size == 0U)) {
        return false;
    }
    if (accepted != NULL) {
        link_session_t* const session = new_session(supervisor, link, SESSION_OPEN_PRODUCER, &no_request);
        return (session != NULL) && begin_opening(supervisor, session, accepted);
    }
    return is_configured(supervisor, mission_link->producer_apid) &&
           is_configured(supervisor, mission_link->consumer_apid) &&
           (begin_negotiation(supervisor, mission_link, wanted, &no_request) != NULL);
}

static pus_reply_t close_link(void* const context, const pus_link_close_t* const close,
                              const pus_token_t* const token, const uint64_t now_ns)
{
    supervisor_t* const supervisor = (supervisor_t*)context;
    supervisor->now_ns             = now_ns;
    link_edge_t* const accepted    = accepted_of(supervisor, close->link);
    if (accepted == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, close->link);
    }
    if (session_of_link(supervisor, close->link) != NULL) {
        return pus_refused(PUS_FAILURE_STATE, close->link);
    }
    link_session_t* const session = new_session(supervisor, close->link, SESSION_CLOSING, token);
    if (session == NULL) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, SUPERVISOR_LINK_SESSIONS);
    }
    session->ends = accepted->ends;
    (void)close_member(supervisor, accepted->ends.consumer_apid, close->link, close->reason);
    (void)close_member(supervisor, accepted->ends.producer_apid, close->link, close->reason);
    return pus_later();
}

static bool link_status(void* const context, const uint16_t index, pus_link_status_t* const out_status)
{
    const supervisor_t* const supervisor = (const supervisor_t*)context;
    if (index >= supervisor->graph.count) {
        return false;
    }
    const link_edge_t* const edge = &supervisor->graph.edges[index];
    const uint8_t state           = (uint8_t)(edge->is_stale ? PUS_LINK_STATE_STALE : PUS_LINK_STATE_OPEN);
    *out_status = (pus_link_status_t){.link = edge->link, .state = state, .ends = edge->ends};
    return true;
}

pus_rtlink_port_t supervisor_link_manager_port(supervisor_t* const supervisor)
{
    return (pus_rtlink_port_t){supervisor, no_offer, request_link, open_link, close_link, link_status};
}

// ---- Answers of subsystems ----

/// Returns the session that waits for the answer of this end to this transaction; null if there is none.
static link_session_t* session_asking(supervisor_t* const supervisor, const uint16_t apid,
                                      const uint32_t transaction)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        link_session_t* const session = &supervisor->sessions[i];
        const bool is_producer =
            (session->step == SESSION_ASK_PRODUCER) && (session->ends.producer_apid == apid);
        const bool is_consumer =
            (session->step == SESSION_ASK_CONSUMER) && (session->ends.consumer_apid == apid);
        if ((is_producer || is_consumer) && (session->transaction == transaction)) {
            return session;
        }
    }
    return NULL;
}

/// Process the acceptance of an end: first the producer accepts, then the consumer; then the link is agreed.
static void member_accepts(supervisor_t* const supervisor, const uint16_t apid,
                           const pus_link_accept_t* const accept)
{
    link_session_t* const session = session_asking(supervisor, apid, accept->transaction);
    if (session == NULL) {
        return;
    }
    session->deadline_ns = supervisor->now_ns + SESSION_TIMEOUT_NS;
    if (session->step == SESSION_ASK_PRODUCER) {
        session->step = SESSION_ASK_CONSUMER;
        if (ask_member(supervisor, session->ends.consumer_apid, session, &accept->properties) != STATUS_OK) {
            give_up(supervisor, session, session->ends.consumer_apid, PUS_FAILURE_NO_ANSWER,
                    session->ends.consumer_apid);
        }
        return;
    }
    FSW_ASSERT(session->link <= MISSION_LINKS_MAX);
    pus_link_accept_t agreed                 = *accept;
    agreed.transaction                       = session->asked;
    supervisor->accepted[session->link - 1U] = (link_edge_t){.link = session->link, .ends = session->ends};
    supervisor->wanted[session->link - 1U]   = session->wanted;
    if (!is_own(session)) {
        (void)pus_link_accept_report(subsystem_process(&supervisor->subsystem), session->token.source,
                                     &agreed, supervisor->now_ns);
    }
    end_session(supervisor, session, PUS_FAILURE_NONE, 0U);
}

static void member_refuses(supervisor_t* const supervisor, const uint16_t apid,
                           const pus_link_refuse_t* const refused)
{
    link_session_t* const session = session_asking(supervisor, apid, refused->transaction);
    if (session == NULL) {
        return;
    }
    pus_link_refuse_t forwarded = *refused;
    forwarded.transaction       = session->asked;
    if (!is_own(session)) {
        (void)pus_link_refuse_report(subsystem_process(&supervisor->subsystem), session->token.source,
                                     &forwarded, supervisor->now_ns);
    }
    give_up(supervisor, session, 0U, PUS_FAILURE_LINK_REFUSED,
            ((uint32_t)refused->reason << 8U) | (uint32_t)refused->field);
}

/// Continue to open a link. The producer opens first, because its end creates the shared memory.
static void member_opened(supervisor_t* const supervisor, link_session_t* const session, const uint16_t apid)
{
    if ((session->step == SESSION_OPEN_PRODUCER) && (apid == session->ends.producer_apid)) {
        session->step        = SESSION_OPEN_CONSUMER;
        session->deadline_ns = supervisor->now_ns + SESSION_TIMEOUT_NS;
        if (open_member(supervisor, session->ends.consumer_apid, session) != STATUS_OK) {
            give_up(supervisor, session, 0U, PUS_FAILURE_NO_ANSWER, session->ends.consumer_apid);
        }
    } else if ((session->step == SESSION_OPEN_CONSUMER) && (apid == session->ends.consumer_apid)) {
        const status_t status =
            supervisor_link_graph_add(&supervisor->graph, &supervisor->accepted[session->link - 1U]);
        end_session(supervisor, session, (status == STATUS_OK) ? PUS_FAILURE_NONE : PUS_FAILURE_TABLE_FULL,
                    LINK_GRAPH_EDGES);
    } else {
        // This step waits for another answer. If that answer does not arrive, the time-out ends the session.
    }
}

/// React to an end that has closed the link: the other end must close, too.
static void member_closed(supervisor_t* const supervisor, const uint16_t link, const uint16_t apid,
                          const pus_link_ends_t* const ends)
{
    link_session_t* const session = session_of_link(supervisor, link);
    if (session == NULL) {
        const bool is_producer = (ends->producer_apid == apid);
        drop_link(supervisor, link);
        // The other end often closes at the same time: supervisor_link_manager_settle closes it otherwise.
        supervisor->closings[link - 1U] = is_producer ? ends->consumer_apid : ends->producer_apid;
        return;
    }
    // While a link is being closed, the report of the first end removes the edge, and that of the second
    // one ends the session.
    const bool had_edge = supervisor_link_graph_remove(&supervisor->graph, link);
    if ((session->step == SESSION_CLOSING) && !had_edge) {
        drop_link(supervisor, link);
        end_session(supervisor, session, PUS_FAILURE_NONE, 0U);
    }
}

/// Process a state that an end of an agreed link has reported.
static void end_changed(supervisor_t* const supervisor, const uint16_t apid,
                        const pus_link_transition_t* const transition, const pus_link_ends_t* const ends)
{
    link_session_t* const session = session_of_link(supervisor, transition->link);
    link_edge_t* const edge       = supervisor_link_graph_find(&supervisor->graph, transition->link);
    switch (transition->state) {
    case PUS_LINK_STATE_OPEN:
        if ((edge != NULL) && (transition->previous == PUS_LINK_STATE_STALE)) {
            edge->is_stale = false;
        } else if (session != NULL) {
            member_opened(supervisor, session, apid);
        } else {
            // The end has opened without a request of this manager.
        }
        break;
    case PUS_LINK_STATE_STALE:
        if (edge != NULL) {
            edge->is_stale = true;
        }
        break;
    case PUS_LINK_STATE_CLOSED:
        member_closed(supervisor, transition->link, apid, ends);
        break;
    case PUS_LINK_STATE_FAILED:
        if (session != NULL) {
            give_up(supervisor, session, apid, PUS_FAILURE_IO, apid);
        }
        break;
    default: // Requested or accepted: the link is not open yet.
        break;
    }
}

/// Process a report about a link; it is accepted only from the two subsystems of the link.
static void member_changed(supervisor_t* const supervisor, const uint16_t apid,
                           const pus_link_transition_t* const transition)
{
    const bool is_link = (transition->link >= 1U) && (transition->link <= MISSION_LINKS_MAX);
    if (is_link && (transition->state == (uint8_t)PUS_LINK_STATE_CLOSED) &&
        (supervisor->closings[transition->link - 1U] == apid)) {
        supervisor->closings[transition->link - 1U] = 0U;
    }
    const link_edge_t* const accepted = accepted_of(supervisor, transition->link);
    if (accepted != NULL) {
        const pus_link_ends_t ends = accepted->ends;
        if (is_end(&ends, apid)) {
            end_changed(supervisor, apid, transition, &ends);
        }
    }
}

/// Compare the status of a link that a subsystem reports after the takeover with the known one. The report
/// takes precedence; an end that is open alone is closed.
static void compare_link(supervisor_t* const supervisor, const uint16_t apid, const uint16_t link,
                         const bool is_reported_open)
{
    const link_edge_t* const edge = supervisor_link_graph_find(&supervisor->graph, link);
    if (session_of_link(supervisor, link) != NULL) {
        return; // The link has a session, which determines its state.
    }
    if (edge == NULL) {
        if (is_reported_open) {
            supervisor_raise_u16_u16(supervisor, SUPERVISOR_EVENT_ADOPTION_LINK_DIFFERS, apid, link);
            (void)close_member(supervisor, apid, link, (uint8_t)PUS_LINK_REASON_PEER);
        }
        return;
    }
    const pus_link_ends_t ends = edge->ends;
    if (is_end(&ends, apid) && !is_reported_open) {
        supervisor_raise_u16_u16(supervisor, SUPERVISOR_EVENT_ADOPTION_LINK_DIFFERS, apid, link);
        member_closed(supervisor, link, apid, &ends);
    }
}

/// Compare all links of a subsystem with the first link status that it reports after a takeover.
static void compare_links(supervisor_t* const supervisor, const pus_tm_t* const tm)
{
    registry_entry_t* const entry = supervisor_registry_find(supervisor, tm->apid);
    octet_reader_t reader         = octet_reader(tm->data, tm->size);
    uint32_t open                 = 0U;
    uint16_t count                = 0U;
    if ((entry == NULL) || !entry->are_links_adopted || (tm->destination != PUS_USER_SUPERVISOR) ||
        (pus_link_statuses_read(&reader, &count) != STATUS_OK)) {
        return;
    }
    for (uint16_t i = 0U; i < count; i++) {
        pus_link_status_t status;
        pus_link_status_read(&reader, &status);
        const bool is_open =
            (status.state == (uint8_t)PUS_LINK_STATE_OPEN) || (status.state == (uint8_t)PUS_LINK_STATE_STALE);
        if (is_open && (status.link >= 1U) && (status.link <= MISSION_LINKS_MAX)) {
            open |= (uint32_t)1U << (status.link - 1U);
        }
    }
    entry->are_links_adopted = false;
    for (uint16_t link = 1U; link <= MISSION_LINKS_MAX; link++) {
        compare_link(supervisor, tm->apid, link, ((open >> (link - 1U)) & 1U) != 0U);
    }
}

void supervisor_link_manager_report(supervisor_t* const supervisor, const pus_tm_t* const tm)
{
    if (tm->service != PUS_SERVICE_RTLINK) {
        return;
    }
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    pus_link_accept_t accept;
    pus_link_refuse_t refused;
    pus_link_transition_t transition;
    if ((tm->subtype == PUS_LINK_ACCEPT) && (pus_link_accept_read(&reader, &accept) == STATUS_OK)) {
        member_accepts(supervisor, tm->apid, &accept);
    } else if ((tm->subtype == PUS_LINK_REFUSE) && (pus_link_refuse_read(&reader, &refused) == STATUS_OK)) {
        member_refuses(supervisor, tm->apid, &refused);
    } else if ((tm->subtype == PUS_LINK_TRANSITION) &&
               (pus_link_transition_read(&reader, &transition) == STATUS_OK)) {
        member_changed(supervisor, tm->apid, &transition);
    } else if (tm->subtype == PUS_LINK_STATUS) {
        compare_links(supervisor, tm);
    } else {
        // Only the ground uses offers.
    }
}

void supervisor_link_manager_settle(supervisor_t* const supervisor)
{
    for (uint16_t link = 1U; link <= MISSION_LINKS_MAX; link++) {
        close_now(supervisor, link);
    }
}

void supervisor_link_manager_watch(supervisor_t* const supervisor)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        link_session_t* const session = &supervisor->sessions[i];
        if ((session->step != SESSION_FREE) && (supervisor->now_ns >= session->deadline_ns)) {
            give_up(supervisor, session, 0U, PUS_FAILURE_TIMEOUT, (uint32_t)(SESSION_TIMEOUT_NS / 1000000U));
        }
    }
}

void supervisor_link_manager_member_lost(supervisor_t* const supervisor, const uint16_t apid)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        link_session_t* const session = &supervisor->sessions[i];
        if ((session->step != SESSION_FREE) && is_end(&session->ends, apid)) {
            give_up(supervisor, session, apid, PUS_FAILURE_LOST, apid);
        }
    }
    for (uint16_t link = 1U; link <= MISSION_LINKS_MAX; link++) {
        const link_edge_t* const accepted = accepted_of(supervisor, link);
        if (accepted != NULL) {
            const pus_link_ends_t ends = accepted->ends;
            if (is_end(&ends, apid)) {
                forget_link(supervisor, link, &ends, apid);
            }
        }
    }
}
