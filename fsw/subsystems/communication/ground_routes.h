// SPDX-License-Identifier: Apache-2.0
/// Which connections a report to a ground user goes to. Several connections may be the same user: a report of
/// verification goes to the connection that has sent its request, as long as the request is remembered. All
/// other reports of a user go to each connection that has sent a request as this user, so none is lost.
///
/// Ownership  Part of communication_t.
/// Context    One loop.
/// Time       O(GROUND_REQUESTS).
#ifndef FSW_SUBSYSTEMS_COMMUNICATION_GROUND_ROUTES_H
#define FSW_SUBSYSTEMS_COMMUNICATION_GROUND_ROUTES_H

#include "pus/core/tailoring.h"

#include <stddef.h>
#include <stdint.h>

#define GROUND_USERS 16U     ///< If more users than this send requests, the last place is used again.
#define GROUND_REQUESTS 256U ///< If more requests than this wait for their end, the oldest is forgotten.

typedef struct {      // Private.
    uint32_t clients; // One bit for each connection; 0: the place is free.
    uint32_t order;   // Of arrival [wraps].
    uint16_t user;
    uint16_t apid;
    uint16_t sequence;
    uint16_t is_awaited; // A report about its end is still to come.
} ground_request_t;

typedef struct { // Private, except `forgotten`.
    struct {
        uint32_t clients;
        uint16_t user;
    } users[GROUND_USERS];
    ground_request_t requests[GROUND_REQUESTS];
    uint32_t order;
    uint32_t forgotten; ///< Users and requests whose place was needed [wraps].
} communication_ground_routes_t;

void communication_ground_routes_init(communication_ground_routes_t* routes);
/// A connection (0..31) has sent a request, of PUS_TC_HEADER_SIZE octets at least.
void communication_ground_routes_note(communication_ground_routes_t* routes, unsigned client,
                                      const uint8_t* packet);
/// The connection has ended.
void communication_ground_routes_left(communication_ground_routes_t* routes, unsigned client);
/// The connections to which a report to `user` goes, one bit each. Remembers that a request has ended.
uint32_t communication_ground_routes_of(communication_ground_routes_t* routes, uint16_t user,
                                        const uint8_t* packet, size_t size);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_GROUND_ROUTES_H
