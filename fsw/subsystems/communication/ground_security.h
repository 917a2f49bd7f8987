// SPDX-License-Identifier: Apache-2.0
/// Decodes the octets from the ground: packets or, if the mission has a key, protected frames
/// (fsw/framework/sdls). With a key, only the header of a frame is read before the frame is found to be
/// authentic. A connection is ended after its third refused frame, or immediately if the start of the next
/// frame cannot be found.
///
/// Ownership  Part of communication_t; the receiver outlives it.
/// Context    One loop.
#ifndef FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H
#define FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H

#include "fsw/framework/sdls/sdls.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "generated/communication_descriptor.h"

#define GROUND_CLIENTS 8U
#define GROUND_REFUSALS_MAX 3U   ///< Refused frames of a connection after which it is ended.
#define GROUND_EVENT_CYCLES 100U ///< Smallest number of cycles between two events about refused frames.

typedef struct {               // Private.
    sdls_receiver_t* receiver; // Null: packets are not protected.
    sdls_session_t sessions[GROUND_CLIENTS];
    uint8_t refusals[GROUND_CLIENTS];
    uint32_t since[GROUND_CLIENTS]; // Cycle in which the connection began.
    uint32_t cycle;
    uint32_t reported; // Number of refused frames at the last event.
    uint32_t lost;     // Number of frames at the last event whose session could not be stored.
    uint32_t quiet;    // Cycles until the next event.
} communication_ground_security_t;

typedef struct {
    const uint8_t* packet; ///< Null: the octets do not contain a complete packet yet, or were refused.
    size_t size;
    size_t taken; ///< Octets to be removed after the packet has been processed.
} communication_ground_unit_t;

/// Initialise. `receiver` is null for packets without protection.
void communication_ground_security_init(communication_ground_security_t* security, sdls_receiver_t* receiver);
/// Begin with a new connection in the slot `client`.
void communication_ground_security_connected(communication_ground_security_t* security, unsigned client);
/// Returns the client that a new one should replace: of those that have sent no authentic frame although
/// they could send, the one that has been connected longest, but never `spared`. GROUND_CLIENTS if there is
/// none, or if the mission has no key.
unsigned communication_ground_security_unauthenticated(const communication_ground_security_t* security,
                                                       unsigned spared);
/// Decode the packet or frame at the start of a client's octets. STATUS_OK; STATUS_TRUNCATED: it is
/// incomplete; STATUS_CLOSED: the connection must be ended.
MUST_USE status_t communication_ground_security_next(communication_ground_security_t* security,
                                                     unsigned client, const uint8_t* octets, size_t size,
                                                     communication_ground_unit_t* out_unit);
/// Accept the packet that was returned last, after it has been processed. Without this call it is returned
/// again.
void communication_ground_security_accept(communication_ground_security_t* security, unsigned client);
/// Call once per cycle: write the counters to the parameter, which the caller has locked.
void communication_ground_security_publish(const communication_ground_security_t* security,
                                           communication_security_t* out_parameter);
/// Call once per cycle: raise an event if frames were refused since the last event.
void communication_ground_security_report(communication_ground_security_t* security, subsystem_t* generic);

#endif // FSW_SUBSYSTEMS_COMMUNICATION_GROUND_SECURITY_H
