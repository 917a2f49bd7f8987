// SPDX-License-Identifier: Apache-2.0
/// An on-board user that sends requests, with source id 0x8000 | APID and a sequence count for each
/// addressee.
///
///     octet_writer_t writer = pus_tc_begin(&requester, 16U, 129U, 1U, PUS_ACK_ALL);
///     octet_write_u8(&writer, target);
///     status_t status = pus_tc_send(&requester, &writer, &token);
///
/// A request that the port refuses leaves no gap in the sequence count.
///
/// Ownership  The caller provides the requester.
/// Context    One loop.
#ifndef PUS_CORE_REQUESTER_H
#define PUS_CORE_REQUESTER_H

#include "pus/core/app_process.h"

#define PUS_ADDRESSEES 64U ///< Maximum number of addressees of a requester.

typedef struct pus_requester { // All fields are private, except `counters`.
    uint16_t source;
    pus_port_t port;
    struct pus_requester* counting; // Requester whose sequence counts this one uses; null: its own.
    bool is_building;
    uint16_t apid;
    uint16_t addressee_count;
    struct {
        uint16_t apid;
        uint16_t sequence;
    } addressees[PUS_ADDRESSEES];
    uint8_t building[PUS_PACKET_MAX];
    struct {
        uint32_t sent;      ///< Requests that the port took.
        uint32_t refused;   ///< Requests that the port refused.
        uint32_t oversized; ///< Requests that did not fit a packet.
        uint32_t discarded; ///< Requests begun and not sent, or sent without having been begun.
    } counters;
} pus_requester_t;

/// Begin; the sequence count of each addressee starts at 0. apid: APID of the user itself, 1..2046.
void pus_requester_init(pus_requester_t* requester, uint16_t apid, const pus_port_t* port);
/// Use the sequence counts of `other`, a requester of the same user with another port and with its own
/// counts; `other` must exist as long as this one. Together the two use each count once, so that a
/// verification report identifies one request.
void pus_requester_count_with(pus_requester_t* requester, pus_requester_t* other);
/// Begin a request to `apid`; the writer takes up to PUS_TC_DATA_MAX octets. An unfinished request is
/// discarded.
octet_writer_t pus_tc_begin(pus_requester_t* requester, uint16_t apid, uint8_t service, uint8_t subtype,
                            uint8_t ack);
/// Finish and send the request; *out_token (may be null) is the token that its verification reports contain.
/// STATUS_OK, STATUS_FULL (the port refused), STATUS_TOO_LARGE, STATUS_EXHAUSTED (too many addressees),
/// STATUS_INVALID (no request was begun).
MUST_USE status_t pus_tc_send(pus_requester_t* requester, octet_writer_t* writer, pus_token_t* out_token);

#endif // PUS_CORE_REQUESTER_H
