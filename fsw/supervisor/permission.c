// SPDX-License-Identifier: Apache-2.0
// Decides whether a request is permitted: by the mission's permission matrix, and for a request of a state
// also by power, links and the states of the other members of the network.
#include "fsw/supervisor/permission_matrix.h"
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

#include <string.h>

/// Selector of a request for the matrix: a function, a state, a configuration or a link.
typedef struct {
    char text[PUS_NAME_SIZE + 1U];
    bool has_text;
    uint16_t number;
} selector_t;

static uint16_t mission_link_of_ends(const supervisor_t* const supervisor, const pus_link_ends_t* const ends)
{
    const mission_link_t* const link =
        descriptor_mission_find_link(supervisor->mission, ends->producer_apid, ends->producer_port,
                                     ends->consumer_apid, ends->consumer_port);
    return (link != NULL) ? link->number : 0U;
}

/// Returns the selector of a request; it is empty if the request has none.
static selector_t selector_of(const supervisor_t* const supervisor, const pus_tc_t* const tc)
{
    selector_t selector   = {.text = {0}, .has_text = false, .number = 0U};
    octet_reader_t reader = octet_reader(tc->data, tc->size);
    if (tc->service == PUS_SERVICE_FUNCTIONS) {
        const uint8_t* const name = octet_read_octets(&reader, PUS_NAME_SIZE);
        if (name != NULL) {
            (void)memcpy(selector.text, name, PUS_NAME_SIZE);
        }
        selector.has_text = (name != NULL);
    } else if ((tc->service == PUS_SERVICE_MANAGEMENT) && (tc->subtype == PUS_MANAGEMENT_REQUEST_STATE)) {
        selector.number = octet_read_u8(&reader);
    } else if ((tc->service == PUS_SERVICE_MANAGEMENT) && (tc->subtype == PUS_MANAGEMENT_SELECT)) {
        selector.number = octet_read_u16(&reader);
    } else if ((tc->service == PUS_SERVICE_RTLINK) && (tc->subtype == PUS_LINK_REQUEST)) {
        pus_link_request_t request;
        if (pus_link_request_read(&reader, &request) == STATUS_OK) {
            selector.number = mission_link_of_ends(supervisor, &request.ends);
        }
    } else if (tc->service == PUS_SERVICE_RTLINK) {
        selector.number = octet_read_u16(&reader); // A link's id is its number in the mission.
    } else if (tc->service == PUS_SERVICE_MISSION) {
        selector.number = octet_read_u8(&reader);
    } else {
        // The request has no selector.
    }
    return selector;
}

// ---- Conditions of a state ----

/// Check the links: every required port of the target's configuration must have an open link with fresh
/// samples.
static pus_failure_t check_links(const supervisor_t* const supervisor, const registry_entry_t* const target)
{
    for (uint16_t i = 0U; i < target->mission->port_count; i++) {
        const mission_port_t* const port = &target->mission->ports[i];
        const bool is_needed = port->is_required && (port->configuration == target->configuration);
        const link_edge_t* const edge =
            supervisor_link_graph_into(&supervisor->graph, target->mission->apid, port->id);
        if (is_needed && ((edge == NULL) || edge->is_stale)) {
            return pus_failure(PUS_FAILURE_LINK_MISSING, ((uint32_t)target->mission->apid << 16U) | port->id);
        }
    }
    return pus_failure(PUS_FAILURE_NONE, 0U);
}

/// Check that no other member of the target's network is in `state`. Returns MEMBER_ACTIVE if a member is in
/// it, and STATE_IN_DOUBT if it is the last known state of a member that is in doubt. With `is_certain`, each
/// member in doubt causes STATE_IN_DOUBT.
static pus_failure_t check_members(supervisor_t* const supervisor, const uint16_t apid, const state_t state,
                                   const bool is_certain)
{
    uint16_t members[LINK_GRAPH_MEMBERS];
    const uint16_t count = supervisor_link_graph_members(&supervisor->graph, apid, members);
    uint16_t doubted     = 0U;
    for (uint16_t i = 1U; i < count; i++) { // The first member is the subsystem itself.
        const registry_entry_t* const member = supervisor_registry_find(supervisor, members[i]);
        FSW_ASSERT(member != NULL); // Both ends of a link are subsystems of the mission.
        const bool is_in_state = (member->state == state);
        if (is_in_state && !supervisor_doubt_exists(member)) {
            return pus_failure(PUS_FAILURE_MEMBER_ACTIVE, members[i]);
        }
        doubted = (supervisor_doubt_exists(member) && (is_in_state || is_certain)) ? members[i] : doubted;
    }
    return (doubted != 0U) ? pus_failure(PUS_FAILURE_STATE_IN_DOUBT, doubted)
                           : pus_failure(PUS_FAILURE_NONE, 0U);
}

/// Check that there is enough electrical power for the requested state.
static pus_failure_t check_power(supervisor_t* const supervisor, const uint16_t apid, const state_t state)
{
    const uint32_t needed_w    = supervisor_registry_power_w(supervisor, apid, state);
    const uint32_t available_w = supervisor->mission->power_available_w;
    if ((available_w == 0U) || (needed_w <= available_w)) {
        return pus_failure(PUS_FAILURE_NONE, 0U);
    }
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        if (supervisor_doubt_exists(&supervisor->registry[i])) {
            // In its true state, a subsystem may need less power than in the known one.
            return pus_failure(PUS_FAILURE_STATE_IN_DOUBT, supervisor->registry[i].mission->apid);
        }
    }
    supervisor_raise_u16(supervisor, SUPERVISOR_EVENT_RESOURCE_REFUSED, apid);
    return pus_failure(PUS_FAILURE_RESOURCES, needed_w - available_w);
}

/// Check a request for a state: power, links, and the states of the other members of the network.
static pus_failure_t check_state_request(supervisor_t* const supervisor, const pus_tc_t* const tc)
{
    registry_entry_t* const target = supervisor_registry_find(supervisor, tc->apid);
    const state_t wanted           = (state_t)tc->data[0];
    FSW_ASSERT(target != NULL);
    if (((unsigned)wanted >= (unsigned)STATE_COUNT) || (wanted == STATE_ERROR_OPERATIONAL)) {
        return pus_failure(PUS_FAILURE_NONE, 0U); // The target itself refuses an invalid value.
    }
    const bool is_up = (wanted > target->state) && (target->state <= STATE_OPERATIONAL);
    if (!is_up) {
        // A subsystem may not leave its network while another member is OPERATIONAL.
        return (wanted <= STATE_PRE_OPERATIONAL)
                   ? check_members(supervisor, tc->apid, STATE_OPERATIONAL, false)
                   : pus_failure(PUS_FAILURE_NONE, 0U);
    }
    if (supervisor->shutdown_step != 0U) { // At the end of the shutdown all subsystems must be OFFLINE.
        return pus_failure(PUS_FAILURE_STATE, tc->apid);
    }
    if (supervisor_doubt_exists(target)) {
        return pus_failure(PUS_FAILURE_STATE_IN_DOUBT, tc->apid);
    }
    pus_failure_t failure = check_power(supervisor, tc->apid, wanted);
    if ((failure.code == PUS_FAILURE_NONE) && (wanted >= STATE_SAFE_OPERATIONAL)) {
        failure = check_links(supervisor, target);
    }
    if ((failure.code == PUS_FAILURE_NONE) && (wanted == STATE_OPERATIONAL)) {
        // A member that is in ERROR_OPERATIONAL, or whose state is unknown, forbids OPERATIONAL.
        failure = check_members(supervisor, tc->apid, STATE_ERROR_OPERATIONAL, true);
    }
    return failure;
}

pus_failure_t supervisor_permission_of(supervisor_t* const supervisor, const pus_tc_t* const tc)
{
    const registry_entry_t* const target = supervisor_registry_find(supervisor, tc->apid);
    FSW_ASSERT(target != NULL);
    const selector_t selector          = selector_of(supervisor, tc);
    const permission_request_t request = {.service = tc->service,
                                          .subtype = tc->subtype,
                                          .select  = selector.has_text ? selector.text : NULL,
                                          .number  = selector.number,
                                          .target  = tc->apid,
                                          .mode    = supervisor->mode,
                                          .state   = (uint8_t)target->state};
    int rule                           = PERMISSION_RULE_NONE;
    if (supervisor_permission_check(supervisor->mission, &request, &rule) != STATUS_OK) {
        if (supervisor_doubt_exists(target)) {
            // The request may be permitted in the true state.
            return pus_failure(PUS_FAILURE_STATE_IN_DOUBT, tc->apid);
        }
        return pus_failure(PUS_FAILURE_PERMISSION,
                           ((uint32_t)supervisor->mode << 8U) | (uint32_t)target->state);
    }
    if (target->is_interface_mismatched && (rule != PERMISSION_RULE_ALWAYS)) {
        return pus_failure(PUS_FAILURE_INTERFACE, tc->apid);
    }
    const bool is_state_request = (tc->service == PUS_SERVICE_MANAGEMENT) &&
                                  (tc->subtype == PUS_MANAGEMENT_REQUEST_STATE) && (tc->size == 1U);
    return is_state_request ? check_state_request(supervisor, tc) : pus_failure(PUS_FAILURE_NONE, 0U);
}
