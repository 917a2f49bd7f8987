// SPDX-License-Identifier: Apache-2.0
// Invariants of the supervisor, checked after each of its steps: openings of links have different epochs, its
// queues and pools are consistent, and its counters count each request and report that it has taken, once.
#include "fsw/framework/message/message.h"
#include "fsw/subsystems/communication/communication.h"
#include "fsw/supervisor/supervisor.h"
#include "pus/core/packet.h"
#include "test/fuzz/flight/violations.h"
#include "test/support/consistent_ground.h"
#include "test/support/consistent_message.h"
#include "test/support/consistent_pool.h"

static struct {
    const message_endpoint_t* endpoint; // Endpoint of the supervisor whose step runs.
    const supervisor_t* counted;        // Supervisor whose packets are counted.
    uint32_t requests;                  // Packets that it has taken.
    uint32_t reports;
    uint32_t stale; // Reports of ended lives before the count began.
    uint32_t epochs[SUPERVISOR_LINK_SESSIONS];
    bool is_opening[SUPERVISOR_LINK_SESSIONS]; // At the end of the step before.
    uint32_t last_epoch;
} seen;

status_t __real_message_receive_if(message_endpoint_t* endpoint, const message_filter_t* filter,
                                   uint16_t* out_from, uint8_t* octets, size_t capacity, size_t* out_size);
status_t __wrap_message_receive_if(message_endpoint_t* endpoint, const message_filter_t* filter,
                                   uint16_t* out_from, uint8_t* octets, size_t capacity, size_t* out_size);
status_t __wrap_message_receive_if(message_endpoint_t* const endpoint, const message_filter_t* const filter,
                                   uint16_t* const out_from, uint8_t* const octets, const size_t capacity,
                                   size_t* const out_size)
{
    const status_t status = __real_message_receive_if(endpoint, filter, out_from, octets, capacity, out_size);
    if (endpoint == seen.endpoint) {
        const bool is_request =
            (status == STATUS_OK) && (*out_size > 0U) && pus_packet_is_tc(octets, *out_size);
        seen.requests += is_request ? 1U : 0U;
        seen.reports += is_request ? 0U : 1U;
    }
    return status;
}

/// Each request is routed or refused for one reason, each report is routed or dropped for one reason.
static void check_counters(const supervisor_t* const supervisor)
{
    const supervisor_counters_t* const counters = &supervisor->counters;
    HOLDS((counters->tc_routed + counters->tc_unroutable + counters->tc_forbidden + counters->tc_malformed) ==
              seen.requests,
          SUPERVISOR_APID);
    const uint32_t stale = supervisor->config.endpoint->counters.stale - seen.stale;
    // `tm_malformed` also counts a routed report whose state does not exist.
    HOLDS(counters->tm_routed <= seen.reports, SUPERVISOR_APID);
    HOLDS((counters->tm_routed + counters->tm_malformed + stale) >= seen.reports, SUPERVISOR_APID);
}

/// The epoch of an opening is larger than those of all openings before.
static void check_epochs(const supervisor_t* const supervisor)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        const link_session_t* const session = &supervisor->sessions[i];
        const bool is_opening = (session->step >= SESSION_OPEN_PRODUCER) && (session->epoch != 0U);
        if (is_opening && (!seen.is_opening[i] || (session->epoch != seen.epochs[i]))) {
            HOLDS(session->epoch > seen.last_epoch, SUPERVISOR_APID);
            seen.epochs[i] = session->epoch;
            for (size_t k = 0U; k < SUPERVISOR_LINK_SESSIONS; k++) {
                HOLDS((k == i) || (seen.epochs[k] != session->epoch), SUPERVISOR_APID);
            }
        }
        seen.is_opening[i] = is_opening;
    }
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        seen.last_epoch = (seen.epochs[i] > seen.last_epoch) ? seen.epochs[i] : seen.last_epoch;
    }
}

uint64_t __real_supervisor_step(supervisor_t* supervisor, uint64_t now_ns);
uint64_t __wrap_supervisor_step(supervisor_t* supervisor, uint64_t now_ns);
uint64_t __wrap_supervisor_step(supervisor_t* const supervisor, const uint64_t now_ns)
{
    if (seen.counted == NULL) {
        seen.counted = supervisor;
        seen.stale   = supervisor->config.endpoint->counters.stale;
    }
    if (random_flight_is_planted("epoch")) { // Each opening gets epoch 1.
        supervisor->link_epoch = 0U;
    }
    const uint32_t forbidden = supervisor->counters.tc_forbidden;
    seen.endpoint            = supervisor->config.endpoint;
    const uint64_t wake_ns   = __real_supervisor_step(supervisor, now_ns);
    seen.endpoint            = NULL;
    if (random_flight_is_planted("counters")) { // Refusals are not counted.
        supervisor->counters.tc_forbidden = forbidden;
    }
    HOLDS(seen.counted == supervisor, SUPERVISOR_APID);
    HOLDS(supervisor->graph.count <= LINK_GRAPH_EDGES, SUPERVISOR_APID);
    HOLDS(supervisor->own_event_count <= SUPERVISOR_OWN_EVENTS, SUPERVISOR_APID);
    HOLDS(supervisor->log.failures == 0U, SUPERVISOR_APID);
    HOLDS(ground_backlog_is_consistent(&supervisor->ground_backlog), SUPERVISOR_APID);
    HOLDS(message_is_consistent(supervisor->config.endpoint), SUPERVISOR_APID);
    check_counters(supervisor);
    check_epochs(supervisor);
    return wake_ns;
}
