// SPDX-License-Identifier: Apache-2.0
#include "sim/clock/cosimulation_port.h"

#include "osal/include/osal/clock.h"
#include "osal/include/osal/file.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define NS_PER_MS 1000000ULL
#define SLICE_MS 50U   ///< Longest wait between two checks whether the run has ended.
#define ACCEPT_MS 500U ///< Longest wait for a client in one round of cosimulation_port_serve.

// ---- Lines ----

/// Read a decimal number up to `max` at *text, followed by `end`; moves *text past `end`.
static bool take_number(const char** const text, const char end, const uint64_t max,
                        uint64_t* const out_value)
{
    const char* at = *text;
    uint64_t value = 0U;
    while ((*at >= '0') && (*at <= '9')) {
        const uint64_t digit = (uint64_t)(*at - '0');
        if (value > ((max - digit) / 10U)) {
            return false;
        }
        value = (value * 10U) + digit;
        at++;
    }
    const bool is_good = (at != *text) && (*at == end);
    *text              = at + ((end != '\0') ? 1 : 0);
    *out_value         = value;
    return is_good;
}

/// True if *text begins with `word`: then *text is moved past it.
static bool take_word(const char** const text, const char* const word)
{
    const size_t length = strlen(word);
    if (strncmp(*text, word, length) != 0) {
        return false;
    }
    *text += length;
    return true;
}

static bool parse_join(const char* const line, const char* const participant, uint16_t* const out_port)
{
    const char* at = line;
    uint64_t port  = 0U;
    if (!take_word(&at, "join ") || !take_word(&at, participant) || !take_word(&at, " ") ||
        !take_number(&at, '\0', UINT16_MAX, &port)) {
        return false;
    }
    *out_port = (uint16_t)port;
    return true;
}

static bool parse_done(const char* const line, uint64_t* const out_wake_ns, uint32_t* const out_octets,
                       uint16_t* const out_port)
{
    const char* at  = line;
    uint64_t octets = 0U;
    uint64_t port   = 0U;
    if (!take_word(&at, "done ")) {
        return false;
    }
    if (take_word(&at, "never ")) {
        *out_wake_ns = OSAL_LOCKSTEP_NEVER;
    } else if (!take_number(&at, ' ', UINT64_MAX, out_wake_ns)) {
        return false;
    } else {
        // The word was a time.
    }
    if (!take_number(&at, ' ', UINT32_MAX, &octets) || !take_number(&at, '\0', UINT16_MAX, &port)) {
        return false;
    }
    *out_octets = (uint32_t)octets;
    *out_port   = (uint16_t)port;
    return true;
}

// ---- The client ----

static void disconnect_client(cosimulation_port_t* const cosimulation, uint32_t* const reason)
{
    (*reason)++;
    osal_socket_close(&cosimulation->client);
    cosimulation->line_size   = 0U;
    cosimulation->stream_port = 0U;
}

/// Move one line out of the received octets, and replace its end by '\0'. False if no line is complete yet.
static bool take_line(cosimulation_port_t* const cosimulation, char* const out_line)
{
    const char* const end = memchr(cosimulation->line, '\n', cosimulation->line_size);
    if (end == NULL) {
        return false;
    }
    const size_t length = (size_t)(end - cosimulation->line);
    memcpy(out_line, cosimulation->line, length);
    out_line[length] = '\0';
    cosimulation->line_size -= length + 1U;
    memmove(cosimulation->line, &cosimulation->line[length + 1U], cosimulation->line_size);
    return strlen(out_line) == length; // A line that contains '\0' is refused.
}

/// Wait for a line. STATUS_OK, STATUS_TIMEOUT (the client is still connected), STATUS_CLOSED (it was
/// disconnected, or the run ended).
static status_t wait_for_line(cosimulation_port_t* const cosimulation, char* const out_line,
                              const uint64_t until_ns)
{
    while (memchr(cosimulation->line, '\n', cosimulation->line_size) == NULL) {
        size_t size = 0U;
        if (cosimulation->line_size == COSIMULATION_PORT_LINE_OCTETS) {
            disconnect_client(cosimulation, &cosimulation->count.malformed);
            return STATUS_CLOSED;
        }
        const status_t status =
            osal_stream_receive(&cosimulation->client, (uint8_t*)&cosimulation->line[cosimulation->line_size],
                                COSIMULATION_PORT_LINE_OCTETS - cosimulation->line_size, &size);
        cosimulation->line_size += size;
        if (status == STATUS_EMPTY) {
            if (osal_lockstep_is_closed(cosimulation->scheduler)) {
                osal_socket_close(&cosimulation->client);
                return STATUS_CLOSED;
            }
            if (osal_clock_monotonic_ns() >= until_ns) {
                return STATUS_TIMEOUT;
            }
            (void)!osal_socket_wait_readable(&cosimulation->client, SLICE_MS);
        } else if (status != STATUS_OK) {
            disconnect_client(cosimulation, &cosimulation->count.vanished);
            return STATUS_CLOSED;
        } else {
            // Octets were received: search for a line again.
        }
    }
    if (!take_line(cosimulation, out_line)) {
        disconnect_client(cosimulation, &cosimulation->count.malformed);
        return STATUS_CLOSED;
    }
    return STATUS_OK;
}

/// Wait for a line, at most `timeout_ms` of the port. False: the client was disconnected, or the run ended.
static bool receive_line(cosimulation_port_t* const cosimulation, char* const out_line)
{
    const uint64_t until_ns = osal_clock_monotonic_ns() + ((uint64_t)cosimulation->timeout_ms * NS_PER_MS);
    const status_t status   = wait_for_line(cosimulation, out_line, until_ns);
    if (status == STATUS_TIMEOUT) {
        disconnect_client(cosimulation, &cosimulation->count.silent);
    }
    return status == STATUS_OK;
}

/// Wait for the connected client to join. STATUS_OK: it has joined correctly; STATUS_TIMEOUT: it has not
/// joined yet and has time left; STATUS_CLOSED: it was disconnected, or the run ended.
static status_t admit(cosimulation_port_t* const cosimulation, const uint64_t until_ns)
{
    char line[COSIMULATION_PORT_LINE_OCTETS];
    const uint64_t deadline_ns =
        cosimulation->connected_ns + ((uint64_t)cosimulation->timeout_ms * NS_PER_MS);
    const status_t status =
        wait_for_line(cosimulation, line, (until_ns < deadline_ns) ? until_ns : deadline_ns);
    if ((status == STATUS_TIMEOUT) && (osal_clock_monotonic_ns() >= deadline_ns)) {
        disconnect_client(cosimulation, &cosimulation->count.silent);
        return STATUS_CLOSED;
    }
    if (status != STATUS_OK) {
        return status;
    }
    if (!parse_join(line, cosimulation->participant, &cosimulation->stream_port)) {
        disconnect_client(cosimulation, &cosimulation->count.malformed);
        return STATUS_CLOSED;
    }
    cosimulation->count.joined++;
    return STATUS_OK;
}

static uint32_t rest_ms(const uint64_t until_ns)
{
    const uint64_t now_ns = osal_clock_monotonic_ns();
    return (until_ns > now_ns) ? (uint32_t)((until_ns - now_ns + NS_PER_MS - 1U) / NS_PER_MS) : 0U;
}

// ---- Functions of sim/clock/cosimulation_port.h ----

status_t cosimulation_port_open(cosimulation_port_t* const cosimulation, const char* const path,
                                const char* const participant, const osal_lockstep_t* const scheduler,
                                const uint32_t timeout_ms)
{
    *cosimulation = (cosimulation_port_t){.listener    = OSAL_SOCKET_CLOSED,
                                          .client      = OSAL_SOCKET_CLOSED,
                                          .scheduler   = scheduler,
                                          .path        = path,
                                          .participant = participant,
                                          .timeout_ms  = timeout_ms};
    return osal_local_listen(&cosimulation->listener, path);
}

void cosimulation_port_close(cosimulation_port_t* const cosimulation)
{
    osal_socket_close(&cosimulation->client);
    if (osal_socket_is_open(&cosimulation->listener)) {
        osal_socket_close(&cosimulation->listener);
        (void)osal_file_remove(cosimulation->path);
    }
}

/// Accept a waiting client, or wait for one. STATUS_OK, STATUS_TIMEOUT, STATUS_IO.
static status_t accept_client(cosimulation_port_t* const cosimulation, const uint64_t until_ns)
{
    osal_address_t peer;
    const status_t status = osal_tcp_accept(&cosimulation->listener, &cosimulation->client, &peer);
    if (status == STATUS_OK) {
        cosimulation->line_size    = 0U;
        cosimulation->connected_ns = osal_clock_monotonic_ns();
        return STATUS_OK;
    }
    if (status != STATUS_EMPTY) {
        return STATUS_IO;
    }
    const uint32_t left_ms = rest_ms(until_ns);
    (void)!osal_socket_wait_readable(&cosimulation->listener, (left_ms < SLICE_MS) ? left_ms : SLICE_MS);
    return STATUS_TIMEOUT;
}

status_t cosimulation_port_accept(cosimulation_port_t* const cosimulation, const uint32_t timeout_ms)
{
    const uint64_t until_ns = osal_clock_monotonic_ns() + ((uint64_t)timeout_ms * NS_PER_MS);
    for (;;) {
        status_t status =
            osal_socket_is_open(&cosimulation->client) ? STATUS_OK : accept_client(cosimulation, until_ns);
        if (osal_lockstep_is_closed(cosimulation->scheduler)) {
            osal_socket_close(&cosimulation->client);
            return STATUS_CLOSED;
        }
        status = (status == STATUS_OK) ? admit(cosimulation, until_ns) : status;
        if ((status == STATUS_OK) || (status == STATUS_IO)) {
            return status;
        }
        if ((status == STATUS_TIMEOUT) && (rest_ms(until_ns) == 0U)) {
            return STATUS_TIMEOUT;
        }
    }
}

status_t cosimulation_port_exchange(cosimulation_port_t* const cosimulation, const osal_grant_t* const grant,
                                    const uint16_t served_port, uint64_t* const out_wake_ns,
                                    uint32_t* const out_octets_sent)
{
    char line[COSIMULATION_PORT_LINE_OCTETS];
    size_t sent      = 0U;
    const int length = snprintf(line, sizeof line, "grant %" PRIu64 " %" PRIu32 " %" PRIu32 " %" PRIu16 "\n",
                                grant->now_ns, grant->messages, grant->octets, served_port);
    if (!osal_socket_is_open(&cosimulation->client)) {
        return STATUS_CLOSED;
    }
    // The socket has at most one unread line. If it does not take this whole line, the client does not read.
    if ((osal_stream_send(&cosimulation->client, (const uint8_t*)line, (size_t)length, &sent) != STATUS_OK) ||
        (sent != (size_t)length)) {
        disconnect_client(cosimulation, &cosimulation->count.vanished);
        return STATUS_CLOSED;
    }
    if (!receive_line(cosimulation, line)) {
        return STATUS_CLOSED;
    }
    if (strcmp(line, "leave") == 0) {
        disconnect_client(cosimulation, &cosimulation->count.left);
        return STATUS_CLOSED;
    }
    if (!parse_done(line, out_wake_ns, out_octets_sent, &cosimulation->stream_port)) {
        disconnect_client(cosimulation, &cosimulation->count.malformed);
        return STATUS_CLOSED;
    }
    return STATUS_OK;
}

status_t cosimulation_port_turn(cosimulation_port_t* const cosimulation, osal_lockstep_t* const scheduler,
                                const unsigned order, const unsigned receiver,
                                const osal_grant_t* const grant, uint64_t* const out_wake_ns)
{
    uint32_t octets       = 0U;
    const uint16_t served = osal_lockstep_served_port(scheduler, order);
    if (cosimulation_port_exchange(cosimulation, grant, served, out_wake_ns, &octets) != STATUS_OK) {
        const bool is_over = osal_lockstep_is_closed(scheduler);
        osal_lockstep_end(scheduler, order, OSAL_LOCKSTEP_ANY_LIFE);
        return is_over ? STATUS_CLOSED : STATUS_NOT_FOUND;
    }
    osal_lockstep_set_stream_port(scheduler, order, cosimulation->stream_port);
    if (octets > 0U) {
        osal_lockstep_deliver(scheduler, order, receiver, OSAL_LOCKSTEP_ANY_LIFE, 0U, octets);
    }
    return STATUS_OK;
}

status_t cosimulation_port_serve(cosimulation_port_t* const cosimulation, osal_lockstep_t* const scheduler,
                                 const unsigned order, const unsigned receiver)
{
    osal_grant_t grant;
    uint64_t wake_ns = 0U;
    status_t status  = STATUS_TIMEOUT;
    while (status == STATUS_TIMEOUT) {
        status = cosimulation_port_accept(cosimulation, ACCEPT_MS);
    }
    if (status != STATUS_OK) {
        return status;
    }
    osal_lockstep_set_stream_port(scheduler, order, cosimulation->stream_port);
    status = osal_lockstep_wait(scheduler, order, OSAL_LOCKSTEP_ANY_LIFE, 0U, &grant);
    while (status == STATUS_OK) {
        status = cosimulation_port_turn(cosimulation, scheduler, order, receiver, &grant, &wake_ns);
        if (status == STATUS_OK) {
            status = osal_lockstep_wait(scheduler, order, OSAL_LOCKSTEP_ANY_LIFE, wake_ns, &grant);
        }
    }
    osal_socket_close(&cosimulation->client);
    // The client has disconnected, or has lost its slot for another reason.
    const bool is_ended =
        (status == STATUS_NOT_FOUND) || ((status == STATUS_CLOSED) && !osal_lockstep_is_closed(scheduler));
    return is_ended ? STATUS_OK : status;
}
