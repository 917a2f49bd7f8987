// SPDX-License-Identifier: Apache-2.0
/// Common parts of the tests of services that release requests: building application data that contain
/// requests.
#ifndef TEST_UNIT_FSW_SUPERVISOR_RELEASES_H
#define TEST_UNIT_FSW_SUPERVISOR_RELEASES_H

#include "base/octets.h"

extern octet_writer_t request_data;

/// Begin application data in request_data.
void request_begin(void);
/// Send request_data to the supervisor without asking for reports of success, and let it make one step.
void request_send(uint8_t service, uint8_t subtype);
/// Send a request whose data is a string literal without its NUL.
#define REQUEST(service, subtype, octets) request_octets((service), (subtype), (octets), sizeof(octets) - 1U)
void request_octets(uint8_t service, uint8_t subtype, const char* octets, size_t size);
/// Append a TC[17,1] of user 1 for `apid`. If it reaches the subsystem LONE, the output of the
/// fixture contains "18 TC 17.1 from 1".
void request_within(uint16_t apid, uint16_t sequence);

/// Enable ST[11] or ST[22] with sub-schedule 1 and group 1.
void schedule_enable(uint8_t service);
/// Insert an activity of ST[11] that releases a TC[17,1] at a time of the run.
void release_at(uint64_t time_ns, uint16_t apid, uint16_t sequence);
/// Insert an activity of ST[22] that releases a TC[17,1] at a position on the orbit.
void release_where(uint64_t position, uint16_t apid, uint16_t sequence);
/// Add and enable an action of ST[19] that releases a TC[17,1] when the subsystem ARM raises this
/// event.
void release_on(uint16_t event, uint16_t apid, uint16_t sequence);
/// Load and activate the sequence SEQ of ST[21] with a TC[17,1].
void release_in_sequence(uint16_t apid, uint16_t sequence);

#endif // TEST_UNIT_FSW_SUPERVISOR_RELEASES_H
