// SPDX-License-Identifier: Apache-2.0
#include "sim/socketcand/socketcand.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/socket.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INPUT_OCTETS 4096U
#define OUTPUT_OCTETS 65536U
// Calls of socketcand_receive between two checks for new clients, while there is no client.
#define ACCEPT_INTERVAL 64U
#define NO_NODE BUS_NODES_MAX
#define STEPS_MAX 1000U
#define NS_PER_S 1000000000U
#define NS_PER_MS 1000000U
#define NS_PER_US 1000U
#define OK_TIMEOUT_NS 50000000ULL ///< Wall-clock time in which a client reads the answer to rawmode.

typedef struct {
    socketcand_t* server;
    bool is_used;
    bool is_raw; // The client is in raw mode, in which frames are exchanged.
    // The client has read the answer to rawmode: it has sent a message since, or OK_TIMEOUT_NS has passed.
    bool has_heard_ok;
    // Number of steps after which simulated time waits for the client. 0: the client is not in lock-step.
    unsigned step_every;
    unsigned steps_unfinished; // Number of reported steps that it has not finished yet.
    uint64_t raw_ns;           // Wall-clock time of the answer to rawmode.
    osal_socket_t socket;
    bus_t* bus;
    unsigned node;
    size_t input_size;
    size_t output_size;
    char input[INPUT_OCTETS + 1U];
    char output[OUTPUT_OCTETS];
} client_t;

struct socketcand {
    osal_socket_t listener;
    uint16_t port;
    socketcand_bus_t buses[SOCKETCAND_BUSES_MAX];
    size_t bus_count;
    unsigned countdown;
    unsigned client_count;
    unsigned submitted;
    uint64_t dropped;
    uint64_t steps;
    client_t client[SOCKETCAND_CLIENTS_MAX];
};

status_t socketcand_open(const uint16_t port, const socketcand_bus_t* const buses, const size_t bus_count,
                         socketcand_t** const out_server)
{
    *out_server          = NULL;
    socketcand_t* server = calloc(1U, sizeof *server);
    if (server == NULL) {
        return STATUS_EXHAUSTED;
    }
    const osal_address_t local = {.ipv4 = OSAL_IPV4_LOOPBACK, .port = port};
    status_t status            = osal_tcp_listen(&server->listener, local);
    if (status != STATUS_OK) {
        free(server);
        return status;
    }
    osal_address_t bound = {0};
    status               = osal_socket_local_address(&server->listener, &bound);
    if (status != STATUS_OK) {
        osal_socket_close(&server->listener);
        free(server);
        return status;
    }
    server->port      = bound.port;
    server->bus_count = (bus_count < SOCKETCAND_BUSES_MAX) ? bus_count : SOCKETCAND_BUSES_MAX;
    memcpy(server->buses, buses, server->bus_count * sizeof *buses);
    *out_server = server;
    return STATUS_OK;
}

uint16_t socketcand_port(const socketcand_t* const server)
{
    return server->port;
}

uint64_t socketcand_dropped(const socketcand_t* const server)
{
    return server->dropped;
}

static void drop_client(client_t* const client)
{
    if (client->node != NO_NODE) {
        bus_remove_node(client->bus, client->node);
    }
    osal_socket_close(&client->socket);
    client->is_used = false;
    client->server->client_count--;
}

static void queue_text(client_t* const client, const char* const text, const size_t size)
{
    if ((client->output_size + size) > OUTPUT_OCTETS) {
        client->server->dropped++;
        return;
    }
    memcpy(&client->output[client->output_size], text, size);
    client->output_size += size;
}

static void reply(client_t* const client, const char* const text)
{
    queue_text(client, text, strlen(text));
}

/// True if frames may be sent to the client. Some clients compare all octets that one read returns with the
/// answer to rawmode, so no frame may follow that answer directly.
static bool may_send_frames(client_t* const client)
{
    client->has_heard_ok =
        client->has_heard_ok || ((osal_clock_monotonic_ns() - client->raw_ns) > OK_TIMEOUT_NS);
    return client->has_heard_ok;
}

static void on_frame(void* const context, const osal_can_frame_t* const frame)
{
    client_t* client = context;
    char text[SOCKETCAND_MESSAGE_MAX];
    if (client->is_raw && may_send_frames(client)) {
        queue_text(client, text, socketcand_message(frame, text));
    }
}

static void open_bus(client_t* const client, const char* const name)
{
    socketcand_t* server            = client->server;
    const bus_callbacks_t callbacks = {.on_frame = on_frame, .on_error = on_frame, .context = client};
    for (size_t i = 0U; (i < server->bus_count) && (client->node == NO_NODE); i++) {
        if (strcmp(server->buses[i].name, name) != 0) {
            continue;
        }
        client->bus = server->buses[i].bus;
        if (bus_add_node(client->bus, &callbacks, &client->node) != STATUS_OK) {
            client->node = NO_NODE;
        }
    }
    reply(client, (client->node != NO_NODE) ? "< ok >" : "< error could not open bus >");
}

/// Handle `< step N >`; `text` is N.
static void take_step(client_t* const client, const char* const text)
{
    char* end                 = NULL;
    const unsigned long every = strtoul(text, &end, 10);
    if ((end == text) || (*end != '\0') || (every < 1U) || (every > STEPS_MAX)) {
        reply(client, "< error syntax of step >");
        return;
    }
    client->steps_unfinished -= (client->steps_unfinished > 0U) ? 1U : 0U;
    client->step_every = (unsigned)every;
}

/// Handle one message, without its brackets and outer blanks.
static void handle(client_t* const client, const char* const text)
{
    osal_can_frame_t frame;
    if ((strncmp(text, "open ", 5U) == 0) && (client->node == NO_NODE)) {
        open_bus(client, &text[5]);
    } else if ((strcmp(text, "rawmode") == 0) && (client->node != NO_NODE)) {
        reply(client, "< ok >");
        client->is_raw = true;
        client->raw_ns = osal_clock_monotonic_ns();
    } else if (strncmp(text, "step ", 5U) == 0) {
        take_step(client, &text[5]);
    } else if (strcmp(text, "echo") == 0) {
        reply(client, "< echo >");
    } else if ((strncmp(text, "send ", 5U) == 0) && client->is_raw) {
        client->has_heard_ok = true;
        if (socketcand_parse_send(text, &frame) != STATUS_OK) {
            reply(client, "< error syntax of send >");
        } else {
            (void)bus_submit(client->bus, client->node, &frame, bus_now_ns(client->bus));
            client->server->submitted++;
        }
    } else {
        reply(client, "< error unknown command >");
    }
}

/// Read complete messages from the received octets. Octets outside of brackets are skipped.
static void handle_input(client_t* const client)
{
    char* rest                        = client->input;
    client->input[client->input_size] = '\0';
    for (;;) {
        char* start = strchr(rest, '<');
        char* end   = (start != NULL) ? strchr(start, '>') : NULL;
        if (end == NULL) {
            rest = (start != NULL) ? start : &client->input[client->input_size];
            break;
        }
        start++;
        while (*start == ' ') {
            start++;
        }
        rest = end + 1;
        while ((end > start) && (end[-1] == ' ')) {
            end--;
        }
        *end = '\0';
        handle(client, start);
    }
    const size_t left = client->input_size - (size_t)(rest - client->input);
    memmove(client->input, rest, left);
    client->input_size = (left < INPUT_OCTETS) ? left : 0U; // Discard a text that is too long for a message.
}

static void receive_from(client_t* const client)
{
    // Read while the transmit queue has room. Other octets wait in the socket, and when this is full, in the
    // client.
    while (client->is_used) {
        size_t size = 0U;
        if ((client->node != NO_NODE) && (bus_queued(client->bus, client->node) > (BUS_QUEUE_FRAMES / 2U))) {
            return;
        }
        // Read short pieces, so that there is room for their frames in the transmit queue.
        const size_t room  = INPUT_OCTETS - client->input_size;
        const size_t piece = (room < 128U) ? room : 128U;
        const status_t status =
            osal_stream_receive(&client->socket, (uint8_t*)&client->input[client->input_size], piece, &size);
        if (status == STATUS_EMPTY) {
            return;
        }
        if (status != STATUS_OK) {
            drop_client(client);
            return;
        }
        client->input_size += size;
        handle_input(client);
    }
}

static void accept_clients(socketcand_t* const server)
{
    osal_socket_t socket = OSAL_SOCKET_CLOSED;
    osal_address_t peer  = {0};
    while ((server->client_count < SOCKETCAND_CLIENTS_MAX) &&
           (osal_tcp_accept(&server->listener, &socket, &peer) == STATUS_OK)) {
        client_t* client = server->client;
        while (client->is_used) {
            client++;
        }
        client->server           = server;
        client->is_used          = true;
        client->is_raw           = false;
        client->has_heard_ok     = false;
        client->step_every       = 0U;
        client->steps_unfinished = 0U;
        client->socket           = socket;
        client->node             = NO_NODE;
        client->input_size       = 0U;
        client->output_size      = 0U;
        server->client_count++;
        reply(client, "< hi >");
    }
}

unsigned socketcand_receive(socketcand_t* const server)
{
    server->submitted = 0U;
    if (server->countdown == 0U) {
        server->countdown = ACCEPT_INTERVAL;
        accept_clients(server);
    }
    server->countdown--;
    for (unsigned i = 0U; (server->client_count != 0U) && (i < SOCKETCAND_CLIENTS_MAX); i++) {
        if (server->client[i].is_used) {
            receive_from(&server->client[i]);
        }
    }
    return server->submitted;
}

static void send_to(client_t* const client)
{
    size_t sent = 0U;
    if (client->output_size == 0U) {
        return;
    }
    const status_t status =
        osal_stream_send(&client->socket, (const uint8_t*)client->output, client->output_size, &sent);
    if ((status == STATUS_CLOSED) || (status == STATUS_IO)) {
        drop_client(client);
    } else if (status == STATUS_OK) {
        client->output_size -= sent;
        memmove(client->output, &client->output[sent], client->output_size);
    }
}

void socketcand_send(socketcand_t* const server)
{
    for (unsigned i = 0U; (server->client_count != 0U) && (i < SOCKETCAND_CLIENTS_MAX); i++) {
        if (server->client[i].is_used) {
            send_to(&server->client[i]);
        }
    }
}

/// True if the client has finished the step, or if its frames fill half of its transmit queue: then the bus
/// has to run first.
static bool is_done(const client_t* const client)
{
    return !client->is_used || (client->steps_unfinished == 0U) ||
           ((client->node != NO_NODE) && (bus_queued(client->bus, client->node) > (BUS_QUEUE_FRAMES / 2U)));
}

/// Wait until the client has finished the step. Returns false if it was dropped at the deadline.
static bool await_client(client_t* const client, const uint64_t deadline_ns)
{
    for (;;) {
        send_to(client);
        // Also after the deadline: the client may have finished the step while another one was awaited.
        receive_from(client);
        if (is_done(client)) {
            return true;
        }
        const uint64_t now_ns = osal_clock_monotonic_ns();
        if (now_ns >= deadline_ns) {
            drop_client(client);
            return false;
        }
        const status_t status =
            osal_socket_wait_readable(&client->socket, (uint32_t)((deadline_ns - now_ns) / NS_PER_MS) + 1U);
        (void)status; // A timeout is detected in the next round.
    }
}

/// True if this step is one after which the server waits for the client.
static bool is_due(const socketcand_t* const server, const client_t* const client)
{
    return client->is_used && (client->step_every > 0U) && ((server->steps % client->step_every) == 0U);
}

unsigned socketcand_end_step(socketcand_t* const server, const uint64_t now_ns, const uint32_t timeout_ms)
{
    bool is_awaited[SOCKETCAND_CLIENTS_MAX] = {false};
    unsigned dropped                        = 0U;
    char text[SOCKETCAND_MESSAGE_MAX];
    server->steps++;
    if (server->client_count == 0U) {
        return 0U;
    }
    (void)snprintf(text, sizeof text, "< step %" PRIu64 ".%06" PRIu64 " >", now_ns / NS_PER_S,
                   (now_ns % NS_PER_S) / NS_PER_US);
    for (unsigned i = 0U; i < SOCKETCAND_CLIENTS_MAX; i++) {
        client_t* client = &server->client[i];
        is_awaited[i]    = is_due(server, client);
        if (is_awaited[i]) {
            client->steps_unfinished++;
            reply(client, text);
            send_to(client); // All clients work on the step at the same time.
        }
    }
    const uint64_t deadline_ns = osal_clock_monotonic_ns() + (timeout_ms * (uint64_t)NS_PER_MS);
    for (unsigned i = 0U; i < SOCKETCAND_CLIENTS_MAX; i++) {
        if (is_awaited[i] && server->client[i].is_used) {
            dropped += await_client(&server->client[i], deadline_ns) ? 0U : 1U;
        }
    }
    return dropped;
}

void socketcand_wait(socketcand_t* const server, const uint32_t timeout_ms)
{
    socketcand_send(server);
    server->countdown     = 0U;
    osal_socket_t* socket = &server->listener;
    for (unsigned i = 0U; i < SOCKETCAND_CLIENTS_MAX; i++) {
        if (server->client[i].is_used) {
            socket = &server->client[i].socket; // In lock-step there is only one tool.
        }
    }
    const status_t status = osal_socket_wait_readable(socket, timeout_ms);
    (void)status; // After a timeout the caller polls again.
}

void socketcand_close(socketcand_t* const server)
{
    if (server == NULL) {
        return;
    }
    for (unsigned i = 0U; i < SOCKETCAND_CLIENTS_MAX; i++) {
        if (server->client[i].is_used) {
            drop_client(&server->client[i]);
        }
    }
    osal_socket_close(&server->listener);
    free(server);
}
