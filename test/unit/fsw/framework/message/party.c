// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/framework/message/party.h"
#include "osal/include/osal/process.h"
#include "test/support/consistent_message.h"

#include "unity.h"

#include <string.h>

#define ARRIVAL_MS 1000U

unsigned party_forms(void)
{
    osal_socket_t probe = OSAL_SOCKET_CLOSED;
    if (osal_udp_open(&probe, (osal_address_t){OSAL_IPV4_LOOPBACK, 0U}, 0U) != STATUS_OK) {
        return PARTY_UDP;
    }
    osal_socket_close(&probe);
    if (osal_tipc_open(&probe, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE) != STATUS_OK) {
        return PARTY_TIPC;
    }
    osal_socket_close(&probe);
    return PARTY_FORMS;
}

uint16_t party_id(unsigned index)
{
    return (uint16_t)(16U + index);
}

static void delivered(void* context, uint16_t to)
{
    party_t* const party = context;
    party->members[to - party_id(0U)].announced++;
}

/// The carrier of each endpoint: it counts frames and asks the test what to do with each.
static status_t send(void* context, uint16_t to, const uint8_t* frame, size_t size)
{
    party_member_t* const member = context;
    party_t* const party         = member->party;
    const unsigned index         = to - party_id(0U);
    const status_t outcome =
        (party->outcome != NULL) ? party->outcome(party, member->index, index, frame, size) : STATUS_OK;
    if (outcome == STATUS_EMPTY) {
        return STATUS_OK;
    }
    const status_t status =
        (outcome == STATUS_OK) ? member->carrier.send(member->carrier.context, to, frame, size) : outcome;
    if (status == STATUS_OK) {
        party->frames[member->index][index]++;
    }
    return status;
}

static void open_endpoint(party_member_t* member, uint32_t epoch)
{
    party_t* const party = member->party;
    message_open(&member->endpoint, party_id(member->index), epoch, (message_carrier_t){member, send},
                 member->inbox, PARTY_MEMBERS);
    for (unsigned i = 0U; i < PARTY_MEMBERS; i++) {
        if (i != member->index) {
            TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&member->endpoint, party_id(i)));
        }
    }
    if (party->form == PARTY_RING) {
        member->announced = 0U;
    }
}

static void open_udp(party_t* party)
{
    const message_delivery_notice_t notice = {party, delivered};
    for (unsigned i = 0U; i < PARTY_MEMBERS; i++) {
        party_member_t* const member = &party->members[i];
        const osal_address_t any     = {OSAL_IPV4_LOOPBACK, 0U};
        TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&member->socket, any, 4194304U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&member->socket, &member->address));
        message_udp_carrier_init(&member->udp, &member->socket, notice);
        member->carrier = message_udp_carrier_port(&member->udp);
    }
    for (unsigned i = 0U; i < (PARTY_MEMBERS * PARTY_MEMBERS); i++) {
        party_member_t* const member = &party->members[i / PARTY_MEMBERS];
        const unsigned peer          = i % PARTY_MEMBERS;
        if (peer != member->index) {
            TEST_ASSERT_EQUAL(STATUS_OK, message_udp_carrier_add_peer(&member->udp, party_id(peer),
                                                                      party->members[peer].address));
        }
    }
}

static void open_tipc(party_t* party)
{
    const message_delivery_notice_t notice = {party, delivered};
    const uint32_t type                    = 0x50000000U | ((uint32_t)osal_process_own_id() & 0x00FFFFFFU);
    uint64_t identities[PARTY_MEMBERS]     = {0U};
    for (unsigned i = 0U; i < PARTY_MEMBERS; i++) {
        party_member_t* const member = &party->members[i];
        const osal_tipc_name_t name  = {type, party_id(i)};
        TEST_ASSERT_EQUAL(STATUS_OK,
                          osal_tipc_open(&member->socket, OSAL_TIPC_MESSAGE, &name, OSAL_TIPC_NODE));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_identity(&member->socket, &identities[i]));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_watch_open(&member->watch, type));
        message_tipc_carrier_init(&member->tipc, &member->socket, &member->watch, type, notice);
        member->carrier = message_tipc_carrier_port(&member->tipc);
    }
    for (unsigned i = 0U; i < (PARTY_MEMBERS * PARTY_MEMBERS); i++) {
        party_member_t* const member = &party->members[i / PARTY_MEMBERS];
        const unsigned peer          = i % PARTY_MEMBERS;
        if (peer != member->index) {
            TEST_ASSERT_EQUAL(STATUS_OK,
                              message_tipc_carrier_add_peer(&member->tipc, party_id(peer), identities[peer]));
        }
    }
}

void party_open(party_t* party, party_form_t form)
{
    if ((unsigned)form >= party_forms()) {
        TEST_IGNORE_MESSAGE("this port has no network");
    }
    (void)memset(party, 0, sizeof *party);
    party->form = form;
    message_ring_carrier_init(&party->hub, (message_delivery_notice_t){party, delivered});
    for (unsigned i = 0U; i < PARTY_MEMBERS; i++) {
        party->members[i].party             = party;
        party->members[i].index             = i;
        party->members[i].socket.descriptor = -1;
        party->members[i].watch.descriptor  = -1;
        party->members[i].carrier           = message_ring_carrier_port(&party->hub);
    }
    if (form == PARTY_UDP) {
        open_udp(party);
    } else if (form == PARTY_TIPC) {
        open_tipc(party);
    }
    for (unsigned i = 0U; i < PARTY_MEMBERS; i++) {
        open_endpoint(&party->members[i], 1U);
        TEST_ASSERT_EQUAL(STATUS_OK, message_ring_carrier_attach(&party->hub, &party->members[i].endpoint));
    }
}

void party_close(party_t* party)
{
    for (unsigned i = 0U; i < PARTY_MEMBERS; i++) {
        TEST_ASSERT_TRUE(message_is_consistent(&party->members[i].endpoint));
        if (osal_socket_is_open(&party->members[i].socket)) {
            osal_socket_close(&party->members[i].socket);
        }
        osal_socket_close(&party->members[i].watch);
    }
}

void party_in_each_form(party_t* party, void (*act)(void))
{
    for (unsigned form = PARTY_RING; form < party_forms(); form++) {
        party_open(party, (party_form_t)form);
        act();
        party_close(party);
    }
}

void party_restart(party_t* party, unsigned index, uint32_t epoch)
{
    open_endpoint(&party->members[index], epoch);
}

status_t party_send(party_t* party, unsigned from, unsigned to, const void* octets, size_t size)
{
    return message_send(&party->members[from].endpoint, party_id(to), octets, size);
}

/// Receive the announced datagrams; on loopback they may be late by a moment.
static void pump(party_member_t* member)
{
    while ((member->party->form != PARTY_RING) && (member->announced > 0U)) {
        const status_t status = (member->party->form == PARTY_TIPC)
                                    ? message_tipc_carrier_pump(&member->tipc, &member->endpoint)
                                    : message_udp_carrier_pump(&member->udp, &member->endpoint);
        if (status == STATUS_EMPTY) {
            TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_wait_readable(&member->socket, ARRIVAL_MS));
        } else {
            // A datagram for another life is not accepted.
            TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_NOT_OURS));
            member->announced--;
        }
    }
}

void party_take_in(party_t* party, unsigned index)
{
    pump(&party->members[index]);
}

status_t party_receive(party_t* party, unsigned index, unsigned* out_from, uint8_t* octets, size_t capacity,
                       size_t* out_size)
{
    party_member_t* const member = &party->members[index];
    uint16_t from                = party_id(0U);
    pump(member);
    const status_t status = message_receive(&member->endpoint, &from, octets, capacity, out_size);
    *out_from             = (unsigned)(from - party_id(0U));
    return status;
}

void party_inject(party_t* party, unsigned from, unsigned to, const uint8_t* octets, size_t size)
{
    party_member_t* const sender = &party->members[from];
    TEST_ASSERT_EQUAL(STATUS_OK, sender->carrier.send(sender->carrier.context, party_id(to), octets, size));
}
