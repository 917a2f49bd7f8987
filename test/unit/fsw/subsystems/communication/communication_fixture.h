// SPDX-License-Identifier: Apache-2.0
/// A test fixture for communication: the real subsystem with a real listening port on loopback, ground
/// clients with blocking sockets of their own, and a supervisor that records what it receives.
#ifndef TEST_UNIT_FSW_SUBSYSTEMS_COMMUNICATION_COMMUNICATION_FIXTURE_H
#define TEST_UNIT_FSW_SUBSYSTEMS_COMMUNICATION_COMMUNICATION_FIXTURE_H

#include "fsw/subsystems/communication/communication.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FIXTURE_CLIENTS (COMMUNICATION_CLIENTS + 4U)
#define FIXTURE_PACKETS 4096U

typedef struct {
    uint16_t source;
    uint16_t sequence;
    size_t size;
} fixture_request_t;

typedef struct {
    subsystem_t component;
    communication_t communication;
    subsystem_descriptor_t descriptor;
    osal_socket_t listener;
    osal_address_t address;
    uint64_t now_ns;
    osal_socket_t clients[FIXTURE_CLIENTS];
    uint16_t ports[FIXTURE_CLIENTS]; ///< Ports of the clients' own ends.
    /// Requests that communication has forwarded to the supervisor.
    fixture_request_t requests[FIXTURE_PACKETS];
    unsigned request_count;
    unsigned events[32]; ///< Reports of events, by id.
    bool is_uplink_full;
    unsigned uplink_room;           ///< Requests that the supervisor accepts before it is full; 0: no limit.
    uint16_t participant;           ///< Port of the participant of the scheduler; 0: none.
    unsigned served;                ///< Number of calls of the callback `served`.
    unsigned cut;                   ///< Number of calls of the callback `cut`.
    unsigned intrusions;            ///< Number of calls of the callback `intruded`.
    uint32_t sent[FIXTURE_CLIENTS]; ///< Octets sent to each client, as the callback reports them.
} fixture_t;

extern fixture_t fixture;

/// Open communication with its port, in OFFLINE.
void fixture_open(void);
/// Open it and apply its configuration: it listens.
void fixture_open_up(void);
void fixture_close(void);
/// Receive, step, send: the work of the program at each wake.
void fixture_step(void);
void fixture_run(unsigned steps);
/// Step until the supervisor has this many requests; fails the test otherwise.
void fixture_run_until_requests(unsigned count);

void fixture_connect(unsigned client);
void fixture_disconnect(unsigned client);
void fixture_write(unsigned client, const uint8_t* octets, size_t size);
/// Write a telecommand of a user to APID 16 with this number of octets of data.
void fixture_write_request(unsigned client, uint16_t user, uint16_t sequence, size_t data);
size_t fixture_request(uint8_t packet[PUS_PACKET_MAX], uint16_t user, uint16_t sequence, size_t data);
/// True if communication has closed the connection.
bool fixture_is_ended(unsigned client);
/// Read at most `capacity` octets, waiting a moment for the first.
size_t fixture_read(unsigned client, uint8_t* octets, size_t capacity);

/// A report for a user (0: all) with its number, as the supervisor passes it to communication.
void fixture_report(uint16_t destination, uint8_t service, uint8_t subtype, uint32_t number, size_t data);
/// Returns the number of the next report that a client receives; UINT32_MAX if none comes within a moment.
uint32_t fixture_next_report(unsigned client);

#endif // TEST_UNIT_FSW_SUBSYSTEMS_COMMUNICATION_COMMUNICATION_FIXTURE_H
