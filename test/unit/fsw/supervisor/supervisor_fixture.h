// SPDX-License-Identifier: Apache-2.0
/// A test fixture for the whole supervisor: a mission of its own, fake members on ring carriers that answer
/// by themselves or stay silent, fake processes, and simulated time. Each packet that reaches a member or
/// the ground is recorded as a line of text:
///
///     "G 1.2 #5 0110 103"          a report of the supervisor to the ground: request number 5, failure code
///                                  (PUS_FAILURE_ in pus/core/tailoring.h) and detail; of APID 16: "G/16 ..."
///     "G 5.4 00010010"             TM[5,4] with event 1 (descriptors/subsystems/supervisor.xml) and its data
///     "G time 2"                   a spacecraft time packet of a report every 2^2 s
///     "16 TC 129.1 05 from 8001"   a request that reached a member, with its data
///
/// Periodic status and housekeeping are left out. fixture_expect checks all lines since the last call.
#ifndef TEST_UNIT_FSW_SUPERVISOR_SUPERVISOR_FIXTURE_H
#define TEST_UNIT_FSW_SUPERVISOR_SUPERVISOR_FIXTURE_H

#include "fsw/framework/message/ring_carrier.h"
#include "fsw/supervisor/supervisor.h"
#include "test/support/fixture_lines.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FIXTURE_MEMBERS 4U
#define FIXTURE_GROUND 0U ///< Index of `communication`; ARM, HAND and LONE follow.
#define FIXTURE_ARM 1U
#define FIXTURE_HAND 2U
#define FIXTURE_LONE 3U
#define ARM 16U
#define HAND 17U
#define LONE 18U
#define LINK_ARM_STATE 1U  ///< ARM port 1 -> HAND port 2.
#define LINK_HAND_POS 2U   ///< HAND port 1 -> ARM port 2.
#define LINK_LONE_STATE 3U ///< ARM port 1 -> LONE port 3: a second reader.
// Events of ARM; HAND and LONE have BROKEN and STRAIN.
#define BROKEN 1U   ///< HIGH; for ARM a plan only logs it, for HAND a plan takes the network to OFFLINE.
#define STRAIN 2U   ///< MEDIUM; ARM and LONE have a plan.
#define TIRED 3U    ///< MEDIUM, without a plan.
#define NOTE 4U     ///< LOW, without a plan.
#define GRIPLESS 5U ///< HIGH, without a plan.
#define TORQUE 6U   ///< MEDIUM; a plan of 20 s.
#define JAMMED 7U   ///< HIGH; a plan of 30 s.
#define WORN 8U     ///< LOW; a plan of 0.1 s.
#define MODE_SAFE 0U
#define MODE_NOMINAL 1U
#define FIXTURE_USER 1U
#define FIXTURE_TICK_NS 10000000ULL

typedef struct {
    uint16_t apid;
    message_endpoint_t endpoint;
    message_slot_t inbox[2];
    pus_app_process_t process;
    state_t state;
    state_phase_t phase;
    uint16_t configuration;
    uint32_t start_count;
    uint32_t open_links; ///< Bit n: the member reports that link n + 1 is open.
    unsigned heartbeats; ///< Heartbeats of the supervisor that reached the member.
    bool is_running;
    bool is_silent;        ///< The member sends no status.
    bool takes_nothing;    ///< The member reads no packets.
    bool is_passive;       ///< The member reads packets, but answers none.
    uint8_t refuses_links; ///< Reason of TM[130,5]; 0: the member accepts links.
    bool ignores_links;    ///< The member answers no request of service 130.
    bool fails_to_open;
    uint64_t interface_offset; ///< Difference of the member's descriptor hashes from those of the supervisor.
    uint64_t configuration_offset;
} fixture_member_t;

typedef struct {
    supervisor_t supervisor;
    message_ring_carrier_t hub;
    message_endpoint_t endpoint; // Endpoint of the supervisor.
    message_slot_t inbox[8];
    fixture_member_t members[FIXTURE_MEMBERS];
    uint64_t now_ns;
    uint64_t next_status_ns;
    uint16_t source;         ///< Source of the next telecommands.
    uint8_t ack;             ///< Acknowledgement flags of the next telecommands.
    uint32_t link_period_us; ///< Period that the next requests for links state.
    bool is_stop_requested;
    bool is_finished;
    status_t start_result;
    uint32_t link_floor; ///< Floor of the link epochs at the last start.
    uint64_t boot_ns;
    unsigned kills;
    /// The only member that has promised its next step, at promise_ns; 0: none has.
    uint16_t late_apid;
    uint64_t promise_ns;
    unsigned starts;
    unsigned stops;
    uint64_t event_ns; ///< Time of the last event of the supervisor that reached the ground.
} fixture_t;

extern fixture_t fixture;
/// If not null, called for the configuration of each supervisor that is opened, to add what the fixture does
/// not have: stores, files, optional services.
extern void (*fixture_configure)(supervisor_config_t* config);

/// Open a supervisor at time 0; all processes run, and no report has been received yet.
void fixture_open(void);
/// Open a supervisor and run until it and communication have started; forget the lines.
void fixture_open_up(void);
void fixture_close(void);
/// Returns the text of a file in the directory of the packet log.
const char* fixture_log_file(const char* name);
const char* fixture_directory(void);

/// One tick: the supervisor steps, then the members read and answer.
void fixture_tick(void);
void fixture_run(unsigned ticks);
/// Like fixture_tick, but the time stays the same.
void fixture_step(void);

/// Send a telecommand of the ground; returns its sequence count (#n).
uint16_t fixture_tc(uint16_t apid, uint8_t service, uint8_t subtype, const void* data, size_t size);
uint16_t fixture_request_state(uint16_t apid, state_t target);
/// Let a member read no more packets, and use up its credit with requests; forget the lines.
void fixture_fill(unsigned member);
/// Send octets from a member unchanged.
void fixture_send(unsigned member, const uint8_t* octets, size_t size);
/// Send a report of a member to all ground users.
void fixture_report(unsigned member, uint8_t service, uint8_t subtype, const void* data, size_t size);
/// Send an event of a member with a PUS_SEVERITY_.
void fixture_event(unsigned member, uint8_t severity, uint16_t event);
/// Send a verification report of this member about request number n of user 1.
void fixture_verify(unsigned member, uint8_t subtype, uint16_t number);
/// Send TM[130,10] of a member.
void fixture_link_changed(unsigned member, uint16_t link, uint8_t previous, uint8_t state);
/// Put a member into a state as if it had reported it, with phase and configuration that fit.
void fixture_put_in_state(unsigned member, state_t state);
/// Bring both members to PRE_OPERATIONAL, negotiate and open their links, then put them into a state; forget
/// the lines.
void fixture_link_up(state_t state);
/// Send TC[130,3] for a link of the mission to the supervisor.
uint16_t fixture_request_link(uint16_t link);
uint16_t fixture_open_link(uint16_t link);
uint16_t fixture_close_link(uint16_t link);

/// Add the line of a packet that reached a member.
void fixture_line_of_packet(fixture_member_t* member, const uint8_t* packet, size_t size);

#endif // TEST_UNIT_FSW_SUPERVISOR_SUPERVISOR_FIXTURE_H
