// SPDX-License-Identifier: Apache-2.0
/// Components that exchange messages over any carrier: rings in one program, UDP sockets, and TIPC if the
/// kernel has it (the micro-VM does). A party receives exactly what was announced to it, as programs in
/// stepped time do.
#ifndef TEST_UNIT_FSW_FRAMEWORK_MESSAGE_PARTY_H
#define TEST_UNIT_FSW_FRAMEWORK_MESSAGE_PARTY_H

#include "fsw/framework/message/message.h"
#include "fsw/framework/message/ring_carrier.h"
#include "fsw/framework/message/tipc_carrier.h"
#include "fsw/framework/message/udp_carrier.h"
#include "osal/include/osal/socket.h"

#include <stdbool.h>

#define PARTY_MEMBERS 3U

typedef enum {
    PARTY_RING,
    PARTY_UDP,
    PARTY_TIPC,
    PARTY_FORMS
} party_form_t;

typedef struct party party_t;

typedef struct {
    party_t* party;
    unsigned index;
    message_endpoint_t endpoint;
    message_slot_t inbox[PARTY_MEMBERS];
    osal_socket_t socket;
    osal_address_t address;
    message_udp_carrier_t udp;
    osal_socket_t watch;
    message_tipc_carrier_t tipc;
    message_carrier_t carrier; // The carrier under test, which the carrier of the endpoint calls.
    unsigned announced;        // Datagrams on their way to this member.
} party_member_t;

struct party {
    party_form_t form;
    message_ring_carrier_t hub;
    party_member_t members[PARTY_MEMBERS];
    unsigned frames[PARTY_MEMBERS][PARTY_MEMBERS]; ///< Frames accepted by the carrier, from and to.
    /// Fate of a frame: STATUS_OK passes it on, STATUS_EMPTY loses it, any other status is returned by the
    /// carrier. May be null.
    status_t (*outcome)(party_t* party, unsigned from, unsigned to, const uint8_t* frame, size_t size);
};

/// Returns the number of forms that this system supports: the first values of party_form_t.
unsigned party_forms(void);
/// Returns the address of a member: 16, 17, ...
uint16_t party_id(unsigned index);
/// Open all members in life 1, each a peer of all others. A form that this system does not support
/// ends the test with IGNORE.
void party_open(party_t* party, party_form_t form);
void party_close(party_t* party);
/// For each form: open the party, run `act`, and close the party.
void party_in_each_form(party_t* party, void (*act)(void));
/// The member dies and starts again: this loses blocks in its inbox, but not datagrams in its socket.
void party_restart(party_t* party, unsigned index, uint32_t epoch);
status_t party_send(party_t* party, unsigned from, unsigned to, const void* octets, size_t size);
/// Deliver all announced frames that have not been delivered yet.
void party_take_in(party_t* party, unsigned index);
/// Deliver the announced frames, then receive one block. `*out_from` is an index.
status_t party_receive(party_t* party, unsigned index, unsigned* out_from, uint8_t* octets, size_t capacity,
                       size_t* out_size);
/// Deliver octets to a member as if `from` had sent them.
void party_inject(party_t* party, unsigned from, unsigned to, const uint8_t* octets, size_t size);

#endif // TEST_UNIT_FSW_FRAMEWORK_MESSAGE_PARTY_H
