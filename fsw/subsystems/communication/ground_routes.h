// SPDX-License-Identifier: Apache-2.0
/// Selects the connections to which a report to a ground user is sent. Several connections may use the same
/// user id. A verification report is sent to the connection that has sent the request, as long as the
/// request is stored here. All other reports to a user are sent to each connection that has sent a request
/// as this user, so that none is lost.
///
/// Ownership  Part of communication_t.
/// Context    One loop.
/// Time       O(GROUND_REQUESTS).
#ifndef FSW_SUBSYSTEMS_COMMUNICATION_GROUND_ROUTES_H
#define FSW_SUBSYSTEMS_COMMUNICATION_GROUND_ROUTES_H

#include "pus/core/tailoring.h"

#include <stddef.h>
#include <stdint.h>

#define GROUND_USERS 16U ///< Number of users that are stored; further users replace the last one.
/// Number of requests that are stored. A further request replaces the oldest one whose end is not awaited, or
/// the oldest one if all ends are awaited.
#define GROUND_REQUESTS 256U

typedef struct {      // Private.
    uint32_t clients; // One bit for each connection; 0: the slot is free.
    uint32_t order;   // Order of arrival [wraps].
    uint16_t user;
    uint16_t apid;
    uint16_t sequence;
    uint16_t is_awaited; // A report about its end is still expected.
} ground_request_t;

typedef struct { // Private, except `forgotten`.
    struct {
        uint32_t clients;
        uint16_t user;
    } users[GROUND_USERS];
    ground_request_t requests[GROUND_REQUESTS];
    uint32_t order;
    uint32_t forgotten; ///< Users, and requests whose end was awaited, that were replaced [wraps].
} communication_ground_routes_t;

void communication_ground_routes_init(communication_ground_routes_t* routes);
/// Store that connection `client` (0..31) has sent a request, which has at least PUS_TC_HEADER_SIZE octets.
void communication_ground_routes_note(communication_ground_routes_t* routes, unsigned client,
                                      const uint8_t* packet);
/// Remove a connection that has ended.
void communication_ground_routes_left(communication_ground_routes_t* routes, unsigned client);
/// Returns the connections to which a report to `user` is sent, one bit each. If the report ends a request,
/// its slot becomes free.
uint32_t communication_ground_routes_of(communication_ground_routes_t* routes, uint16_t user,
                                        const uint8_t* packet, size_t size);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_GROUND_ROUTES_H
