// SPDX-License-Identifier: Apache-2.0
/// What the ground's octets are: packets as they come or, where the mission has a key, protected frames
/// (fsw/framework/sdls). With a key nothing is read of what is not authentic but the header of its frame, and
/// a connection is ended at its third refused frame, or at once where the next frame cannot be found.
///
/// Ownership: part of communication_t; the receiver outlives it. Context: one loop.
#ifndef FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H
#define FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H

#include "fsw/framework/sdls/sdls.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "generated/communication_descriptor.h"

#define GROUND_CLIENTS 4U
#define GROUND_REFUSALS_MAX 3U     ///< Frames; the last of them ends the connection.
#define GROUND_TELLING_CYCLES 100U ///< From one event of refused frames to the next.

typedef struct {               // Private.
    sdls_receiver_t* receiver; // Null: packets come as they are.
    sdls_session_t sessions[GROUND_CLIENTS];
    uint8_t refusals[GROUND_CLIENTS];
    uint32_t since[GROUND_CLIENTS]; // Cycle of the connection.
    uint32_t cycle;
    uint32_t told;  // Refused frames that an event told of.
    uint32_t lost;  // Of those, the ones that could not be kept.
    uint32_t quiet; // Cycles until the next event.
} ground_security_t;

typedef struct {
    const uint8_t* packet; ///< Null: the octets make none (yet).
    size_t size;
    size_t taken; ///< Octets that are done with once the packet is.
} ground_unit_t;

/// receiver: null for packets as they are.
void ground_security_init(ground_security_t* security, sdls_receiver_t* receiver);
void ground_security_connected(ground_security_t* security, unsigned client);
/// Of the clients that have shown no key though they were listened to, the one that is connected longest,
/// which others need not wait for; never `spared`. GROUND_CLIENTS: there is none, or nobody needs a key.
unsigned ground_security_stranger(const ground_security_t* security, unsigned spared);
/// The unit at the front of a client's octets. STATUS_OK; STATUS_TRUNCATED: it has not come whole.
/// STATUS_CLOSED: end the connection.
MUST_USE status_t ground_security_next(ground_security_t* security, unsigned client, const uint8_t* octets,
                                       size_t size, ground_unit_t* out_unit);
/// The packet that was shown last is done with. Else it is shown again.
void ground_security_accept(ground_security_t* security, unsigned client);
/// Once a cycle: counters into the parameter, which the caller has locked.
void ground_security_publish(const ground_security_t* security, communication_security_t* out_parameter);
/// Once a cycle: events of what was refused since the last ones.
void ground_security_tell(ground_security_t* security, subsystem_t* generic);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H
