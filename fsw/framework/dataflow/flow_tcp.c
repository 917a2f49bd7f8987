// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow_tcp.h"

#include "base/assertion.h"

#include <string.h>

static const osal_socket_t closed_socket = OSAL_SOCKET_CLOSED;

void flow_tcp_init(flow_tcp_t* const flow, flow_tcp_client_t* const clients, const unsigned capacity,
                   uint8_t* const buffers, const size_t buffer_octets)
{
    FSW_ASSERT((flow != NULL) && (clients != NULL) && (buffers != NULL));
    FSW_ASSERT((capacity > 0U) && (buffer_octets > 0U));
    *flow = (flow_tcp_t){.listener      = OSAL_SOCKET_CLOSED,
                         .clients       = clients,
                         .capacity      = capacity,
                         .buffer_octets = buffer_octets};
    for (unsigned i = 0U; i < capacity; i++) {
        clients[i] = (flow_tcp_client_t){.socket = OSAL_SOCKET_CLOSED, .buffer = &buffers[i * buffer_octets]};
    }
}

void flow_tcp_set_quota(flow_tcp_t* const flow, quota_t* const quota)
{
    FSW_ASSERT((flow != NULL) && !osal_socket_is_open(&flow->listener));
    flow->quota = quota;
}

status_t flow_tcp_adopt(flow_tcp_t* const flow, const int descriptor)
{
    FSW_ASSERT(flow != NULL);
    if (osal_socket_is_open(&flow->listener)) {
        return STATUS_EXISTS;
    }
    status_t status = quota_take(flow->quota);
    if (status == STATUS_OK) {
        status = osal_socket_adopt(&flow->listener, descriptor);
        if (status != STATUS_OK) {
            quota_give(flow->quota);
        }
    }
    flow->counters.failed += (status != STATUS_OK) ? 1U : 0U;
    return status;
}

bool flow_tcp_is_connected(const flow_tcp_t* const flow, const unsigned client)
{
    FSW_ASSERT(flow != NULL);
    return (client < flow->capacity) && osal_socket_is_open(&flow->clients[client].socket);
}

void flow_tcp_end(flow_tcp_t* const flow, const flow_tcp_user_t* const user, const unsigned client)
{
    FSW_ASSERT((flow != NULL) && (user != NULL));
    if (!flow_tcp_is_connected(flow, client)) {
        return;
    }
    osal_socket_close(&flow->clients[client].socket);
    quota_give(flow->quota);
    flow->clients[client].held = 0U;
    flow->counters.ended++;
    if (user->disconnected != NULL) {
        user->disconnected(user->context, client);
    }
}

void flow_tcp_end_all(flow_tcp_t* const flow, const flow_tcp_user_t* const user)
{
    FSW_ASSERT((flow != NULL) && (user != NULL));
    for (unsigned i = 0U; i < flow->capacity; i++) {
        flow_tcp_end(flow, user, i);
    }
}

static unsigned free_slot(const flow_tcp_t* const flow)
{
    unsigned slot = 0U;
    while ((slot < flow->capacity) && osal_socket_is_open(&flow->clients[slot].socket)) {
        slot++;
    }
    return slot;
}

/// Find a slot for a new connection; if all are taken, the user may choose a client whose connection is
/// ended. Returns `capacity` if there is no slot.
static unsigned take_slot(flow_tcp_t* const flow, const flow_tcp_user_t* const user)
{
    const unsigned slot = free_slot(flow);
    if ((slot < flow->capacity) || (user->make_room == NULL)) {
        return slot;
    }
    const unsigned gone = user->make_room(user->context);
    if (gone < flow->capacity) {
        flow->counters.evicted++;
        flow_tcp_end(flow, user, gone);
    }
    return free_slot(flow);
}

/// Accept the connections that wait, and refuse those for which there is no slot or no quota.
static void accept_clients(flow_tcp_t* const flow, const flow_tcp_user_t* const user)
{
    for (unsigned i = 0U; i <= flow->capacity; i++) {
        osal_socket_t arrived = closed_socket;
        osal_address_t from   = {0};
        if (osal_tcp_accept(&flow->listener, &arrived, &from) != STATUS_OK) {
            return;
        }
        // The slot comes first, because a client that is ended for it returns its quota.
        const unsigned slot   = take_slot(flow, user);
        const bool is_granted = (quota_take(flow->quota) == STATUS_OK);
        if (!is_granted || (slot == flow->capacity)) {
            if (is_granted) {
                quota_give(flow->quota);
            }
            flow->counters.turned_away++;
            osal_socket_close(&arrived);
            continue;
        }
        flow->clients[slot].socket    = arrived;
        flow->clients[slot].peer      = from;
        flow->clients[slot].held      = 0U;
        flow->clients[slot].octets_in = 0U;
        flow->clients[slot].epoch++;
        flow->counters.accepted++;
        if (user->connected != NULL) {
            user->connected(user->context, slot);
        }
    }
}

typedef enum {
    OFFER_MORE, ///< The framer can take more octets.
    OFFER_BUSY, ///< The first frame cannot be taken now.
    OFFER_OVER  ///< The connection has ended.
} offer_t;

/// Pass the octets to the framer.
static offer_t offer(flow_tcp_t* const flow, const flow_tcp_user_t* const user, const unsigned index)
{
    flow_tcp_client_t* const client = &flow->clients[index];
    const uint32_t epoch            = client->epoch;
    size_t start                    = 0U;
    size_t taken                    = 1U;
    while ((start < client->held) && (taken > 0U) && (taken != FLOW_TCP_BUSY)) {
        const size_t left = client->held - start;
        taken             = user->frame(user->context, index, &client->buffer[start], left);
        if (!osal_socket_is_open(&client->socket) || (client->epoch != epoch)) {
            return OFFER_OVER; // The user ended the connection from inside its framer.
        }
        if ((taken > left) && (taken != FLOW_TCP_BUSY)) {
            flow->counters.malformed++;
            flow_tcp_end(flow, user, index);
            return OFFER_OVER;
        }
        start += (taken != FLOW_TCP_BUSY) ? taken : 0U;
    }
    client->held -= start;
    if (start > 0U) {
        (void)memmove(client->buffer, &client->buffer[start], client->held);
        // The next step begins with the client after this one.
        flow->first = (index + 1U) % flow->capacity;
    }
    if (taken == FLOW_TCP_BUSY) {
        return OFFER_BUSY;
    }
    // The buffer is full without a complete frame: the frame is too long.
    if (client->held == flow->buffer_octets) {
        flow->counters.malformed++;
        flow_tcp_end(flow, user, index);
        return OFFER_OVER;
    }
    return OFFER_MORE;
}

/// Read from one client until no more octets have arrived, its framer is busy, or `limit` is reached;
/// returns the octets read.
static size_t read_client(flow_tcp_t* const flow, const flow_tcp_user_t* const user, const unsigned index,
                          const size_t limit)
{
    flow_tcp_client_t* const client = &flow->clients[index];
    size_t total                    = 0U;
    offer_t state                   = osal_socket_is_open(&client->socket) ? OFFER_MORE : OFFER_OVER;
    if ((client->held > 0U) && (state == OFFER_MORE)) {
        state = offer(flow, user, index); // The framer may now take the remaining octets.
    }
    // The limit keeps a client that never pauses from delaying the others.
    while ((total < limit) && (total < flow->buffer_octets) && (state == OFFER_MORE)) {
        const size_t room   = flow->buffer_octets - client->held;
        const size_t wanted = (room < (limit - total)) ? room : (limit - total);
        size_t size         = 0U;
        const status_t status =
            osal_stream_receive(&client->socket, &client->buffer[client->held], wanted, &size);
        if (status == STATUS_EMPTY) {
            break;
        }
        if (status != STATUS_OK) {
            flow_tcp_end(flow, user, index);
            break;
        }
        client->held += size;
        total += size;
        client->octets_in += (uint32_t)size;
        flow->counters.octets_in += (uint32_t)size;
        state = offer(flow, user, index);
    }
    return total;
}

status_t flow_tcp_step(flow_tcp_t* const flow, const flow_tcp_user_t* const user, const size_t limit_octets,
                       size_t* const out_octets)
{
    FSW_ASSERT((flow != NULL) && (user != NULL) && (user->frame != NULL) && (out_octets != NULL));
    *out_octets = 0U;
    if (!osal_socket_is_open(&flow->listener)) {
        return STATUS_CLOSED;
    }
    accept_clients(flow, user);
    const unsigned first = flow->first; // A client that sends continuously must not block the next ones.
    for (unsigned k = 0U; k < flow->capacity; k++) {
        const unsigned i   = (first + k) % flow->capacity;
        const size_t left  = limit_octets - *out_octets;
        const size_t share = (user->allowance != NULL) ? user->allowance(user->context, i) : left;
        *out_octets += read_client(flow, user, i, (share < left) ? share : left);
    }
    return STATUS_OK;
}

status_t flow_tcp_send(flow_tcp_t* const flow, const unsigned client, const uint8_t* const octets,
                       const size_t size, size_t* const out_sent)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL) && (size > 0U) && (out_sent != NULL));
    *out_sent = 0U;
    if (!flow_tcp_is_connected(flow, client)) {
        return STATUS_CLOSED;
    }
    const status_t status = osal_stream_send(&flow->clients[client].socket, octets, size, out_sent);
    if ((status == STATUS_OK) || (status == STATUS_FULL)) {
        flow->counters.octets_out += (uint32_t)*out_sent;
        return status;
    }
    *out_sent = 0U;
    return STATUS_CLOSED; // The next step detects the end when it reads, and reports it.
}

size_t flow_tcp_sockets(flow_tcp_t* const flow, osal_socket_t** const out_sockets, const size_t capacity)
{
    FSW_ASSERT((flow != NULL) && (out_sockets != NULL));
    size_t count = 0U;
    if (osal_socket_is_open(&flow->listener) && (count < capacity)) {
        out_sockets[count++] = &flow->listener;
    }
    for (unsigned i = 0U; (i < flow->capacity) && (count < capacity); i++) {
        if (osal_socket_is_open(&flow->clients[i].socket)) {
            out_sockets[count++] = &flow->clients[i].socket;
        }
    }
    return count;
}

status_t flow_tcp_peer(const flow_tcp_t* const flow, const unsigned client, osal_address_t* const out_peer)
{
    FSW_ASSERT((flow != NULL) && (out_peer != NULL));
    if (!flow_tcp_is_connected(flow, client)) {
        return STATUS_CLOSED;
    }
    *out_peer = flow->clients[client].peer;
    return STATUS_OK;
}

uint32_t flow_tcp_octets_in(const flow_tcp_t* const flow, const unsigned client)
{
    return flow_tcp_is_connected(flow, client) ? flow->clients[client].octets_in : 0U;
}
