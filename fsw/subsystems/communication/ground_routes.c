// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/communication/ground_routes.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <stdbool.h>
#include <string.h>

#define SEQUENCE_OFFSET 2U
#define ACK_OFFSET 6U
#define SOURCE_OFFSET 9U
#define SERVICE_OFFSET 7U // Offset of the service type in a report.
#define SUBTYPE_OFFSET 8U
#define APID_MASK 0x7FFU
#define SEQUENCE_MASK 0x3FFFU
#define REQUEST_ID_SIZE 4U

#define ACCEPTANCE_FAILED 2U
// The start of one instruction has failed: reports about other instructions of the request may follow.
#define START_FAILED 4U
#define COMPLETED 7U
#define COMPLETION_FAILED 8U
#define NOT_ROUTED 10U

void communication_ground_routes_init(communication_ground_routes_t* const routes)
{
    FSW_ASSERT(routes != NULL);
    (void)memset(routes, 0, sizeof *routes);
}

/// Note that a client uses a user id. If no entry is free, the last one is used again.
static void note_user(communication_ground_routes_t* const routes, const uint16_t user, const uint32_t client)
{
    size_t index = GROUND_USERS;
    for (size_t i = GROUND_USERS; i > 0U; i--) {
        const bool is_free = (routes->users[i - 1U].clients == 0U);
        if (!is_free && (routes->users[i - 1U].user == user)) {
            routes->users[i - 1U].clients |= client;
            return;
        }
        index = is_free ? (i - 1U) : index;
    }
    if (index == GROUND_USERS) {
        index = GROUND_USERS - 1U;
        routes->forgotten++;
    }
    routes->users[index].user    = user;
    routes->users[index].clients = client;
}

static ground_request_t* find(communication_ground_routes_t* const routes, const uint16_t user,
                              const uint16_t apid, const uint16_t sequence)
{
    for (size_t i = 0U; i < GROUND_REQUESTS; i++) {
        ground_request_t* const request = &routes->requests[i];
        if ((request->clients != 0U) && (request->sequence == sequence) && (request->apid == apid) &&
            (request->user == user)) {
            return request;
        }
    }
    return NULL;
}

/// Returns a free entry. If there is none, returns that of the oldest request whose end is not awaited,
/// otherwise that of the oldest request.
static ground_request_t* entry_for(communication_ground_routes_t* const routes)
{
    ground_request_t* found = &routes->requests[0];
    for (size_t i = 0U; (i < GROUND_REQUESTS) && (found->clients != 0U); i++) {
        ground_request_t* const request = &routes->requests[i];
        const bool is_older             = (routes->order - request->order) > (routes->order - found->order);
        if ((request->clients == 0U) || (request->is_awaited < found->is_awaited) ||
            ((request->is_awaited == found->is_awaited) && is_older)) {
            found = request;
        }
    }
    if ((found->clients != 0U) && (found->is_awaited != 0U)) {
        routes->forgotten++;
    }
    return found;
}

void communication_ground_routes_note(communication_ground_routes_t* const routes, const unsigned client,
                                      const uint8_t* const packet)
{
    FSW_ASSERT((routes != NULL) && (client < 32U) && (packet != NULL));
    const uint32_t bit      = (uint32_t)1U << client;
    const uint16_t user     = octets_u16_at(&packet[SOURCE_OFFSET]);
    const uint16_t apid     = octets_u16_at(packet) & APID_MASK;
    const uint16_t sequence = octets_u16_at(&packet[SEQUENCE_OFFSET]) & SEQUENCE_MASK;
    note_user(routes, user, bit);
    ground_request_t* request = find(routes, user, apid, sequence);
    if (request == NULL) {
        request  = entry_for(routes);
        *request = (ground_request_t){.user = user, .apid = apid, .sequence = sequence};
    }
    request->clients |= bit; // Two connections may have used the same sequence number: both get the report.
    request->order = routes->order;
    if ((packet[ACK_OFFSET] & PUS_ACK_COMPLETION) != 0U) {
        request->is_awaited = 1U;
    }
    routes->order++;
}

void communication_ground_routes_left(communication_ground_routes_t* const routes, const unsigned client)
{
    FSW_ASSERT((routes != NULL) && (client < 32U));
    const uint32_t others = ~((uint32_t)1U << client);
    for (size_t i = 0U; i < GROUND_USERS; i++) {
        routes->users[i].clients &= others;
    }
    for (size_t i = 0U; i < GROUND_REQUESTS; i++) {
        routes->requests[i].clients &= others;
    }
}

static uint32_t of_user(const communication_ground_routes_t* const routes, const uint16_t user)
{
    for (size_t i = 0U; i < GROUND_USERS; i++) {
        if ((routes->users[i].clients != 0U) && (routes->users[i].user == user)) {
            return routes->users[i].clients;
        }
    }
    return 0U;
}

uint32_t communication_ground_routes_of(communication_ground_routes_t* const routes, const uint16_t user,
                                        const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((routes != NULL) && (packet != NULL));
    if ((size < (PUS_TM_HEADER_SIZE + REQUEST_ID_SIZE)) ||
        (packet[SERVICE_OFFSET] != PUS_SERVICE_VERIFICATION)) {
        return of_user(routes, user);
    }
    const uint8_t* const id         = &packet[PUS_TM_HEADER_SIZE];
    ground_request_t* const request = find(routes, user, octets_u16_at(id) & APID_MASK,
                                           octets_u16_at(&id[SEQUENCE_OFFSET]) & SEQUENCE_MASK);
    if (request == NULL) {
        // The request was longer than a packet (ST[13]), or its entry was used again.
        return of_user(routes, user);
    }
    const uint32_t clients = request->clients;
    const uint8_t subtype  = packet[SUBTYPE_OFFSET];
    if (subtype == START_FAILED) {
        request->is_awaited = 0U;
    } else if ((subtype == ACCEPTANCE_FAILED) || (subtype == COMPLETED) || (subtype == COMPLETION_FAILED) ||
               (subtype == NOT_ROUTED)) {
        request->clients = 0U;
    } else {
        // More reports follow.
    }
    return clients;
}
