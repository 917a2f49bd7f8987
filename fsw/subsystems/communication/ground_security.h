// SPDX-License-Identifier: Apache-2.0
/// Reads the octets of the ground: packets or, if the mission has a key, protected frames
/// (fsw/framework/sdls). With a key, only the header of a frame that is not authentic is read. A connection
/// is ended at its third refused frame, or at once if the start of the next frame cannot be found.
///
/// Ownership  Part of communication_t; the receiver outlives it.
/// Context    One loop.
#ifndef FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H
#define FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H

#include "fsw/framework/sdls/sdls.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "generated/communication_descriptor.h"

#define GROUND_CLIENTS 8U
#define GROUND_REFUSALS_MAX 3U     ///< Frames; the last of them ends the connection.
#define GROUND_TELLING_CYCLES 100U ///< From one event of refused frames to the next.

typedef struct {               // Private.
    sdls_receiver_t* receiver; // Null: packets without protection.
    sdls_session_t sessions[GROUND_CLIENTS];
    uint8_t refusals[GROUND_CLIENTS];
    uint32_t since[GROUND_CLIENTS]; // Cycle of the connection.
    uint32_t cycle;
    uint32_t reported; // Refused frames reported by events so far.
    uint32_t lost;     // Number of those that could not be kept.
    uint32_t quiet;    // Cycles until the next event.
} communication_ground_security_t;

typedef struct {
    const uint8_t* packet; ///< Null: the octets contain no whole packet yet.
    size_t size;
    size_t taken; ///< Octets to remove when the packet was processed.
} communication_ground_unit_t;

/// receiver: null for packets without protection.
void communication_ground_security_init(communication_ground_security_t* security, sdls_receiver_t* receiver);
void communication_ground_security_connected(communication_ground_security_t* security, unsigned client);
/// The client to replace by a new one: of the clients that have sent no authentic frame although the receiver
/// was ready to read, the one that is connected longest; never `spared`. GROUND_CLIENTS: there is none, or no
/// key is needed.
unsigned communication_ground_security_unauthenticated(const communication_ground_security_t* security,
                                                       unsigned spared);
/// The unit at the start of a client's octets. STATUS_OK; STATUS_TRUNCATED: it is incomplete.
/// STATUS_CLOSED: end the connection.
MUST_USE status_t communication_ground_security_next(communication_ground_security_t* security,
                                                     unsigned client, const uint8_t* octets, size_t size,
                                                     communication_ground_unit_t* out_unit);
/// The packet returned last was processed. Without this call it is returned again.
void communication_ground_security_accept(communication_ground_security_t* security, unsigned client);
/// Call once a cycle: write the counters to the parameter, which the caller has locked.
void communication_ground_security_publish(const communication_ground_security_t* security,
                                           communication_security_t* out_parameter);
/// Call once a cycle: raise events for the frames refused since the last events.
void communication_ground_security_report(communication_ground_security_t* security, subsystem_t* generic);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H
