// SPDX-License-Identifier: Apache-2.0
#include "launcher/target_link.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "osal/include/osal/file.h"

#include <string.h>

#define PAUSE_MS 1U ///< Between two attempts to write to a full pipe.
#define SWEEP_MAX 4096U

static const osal_device_t no_device = OSAL_DEVICE_CLOSED;
static const osal_socket_t no_socket = OSAL_SOCKET_CLOSED;

status_t target_link_open(target_link_t* const link, const run_state_t* const run, const unsigned component)
{
    FSW_ASSERT((link != NULL) && (run != NULL) && (component < run->component_count));
    (void)memset(link, 0, sizeof *link);
    link->run       = run;
    link->component = component;
    link->sender    = no_socket;
    status_t status = osal_device_pipe(&link->in, &link->peer_out);
    if (status == STATUS_OK) {
        status = osal_device_pipe(&link->peer_in, &link->out);
    }
    if (status == STATUS_OK) {
        const uint8_t computer = run->components[component].computer;
        status = osal_udp_open(&link->sender, (osal_address_t){run->computer_ipv4[computer], 0U}, 0U);
    }
    return ((status == STATUS_OK) || (status == STATUS_EXHAUSTED)) ? status : STATUS_IO;
}

int target_link_peer_in(const target_link_t* const link)
{
    FSW_ASSERT(link != NULL);
    return osal_device_descriptor(&link->peer_in);
}

int target_link_peer_out(const target_link_t* const link)
{
    FSW_ASSERT(link != NULL);
    return osal_device_descriptor(&link->peer_out);
}

void target_link_release_peer(target_link_t* const link)
{
    FSW_ASSERT(link != NULL);
    osal_device_close(&link->peer_in);
    osal_device_close(&link->peer_out);
}

void target_link_close(target_link_t* const link)
{
    FSW_ASSERT(link != NULL);
    target_link_release_peer(link);
    osal_device_close(&link->in);
    osal_device_close(&link->out);
    osal_socket_close(&link->sender);
    for (size_t i = 0U; i < link->socket_count; i++) {
        osal_socket_close(&link->sockets[i]);
    }
    link->socket_count = 0U;
    link->in           = no_device;
    link->out          = no_device;
}

uint32_t target_link_lost(const target_link_t* const link)
{
    FSW_ASSERT(link != NULL);
    return link->lost;
}

static void count_loss(target_link_t* const link)
{
    link->lost += (link->lost < UINT32_MAX) ? 1U : 0U;
}

// ---- To the program ----

/// Write all octets. The program reads them, because it waits for this process.
static status_t write_all(target_link_t* const link, const uint8_t* const octets, const size_t size)
{
    status_t status = STATUS_OK;
    size_t done     = 0U;
    while ((done < size) && (status == STATUS_OK)) {
        size_t sent = 0U;
        status      = osal_device_write(&link->out, &octets[done], size - done, &sent);
        done += sent;
        if (status == STATUS_FULL) {
            // Pause until there is room. The end of the program ends the pause, because it makes `in`
            // readable.
            const status_t waited = osal_device_wait_readable(&link->in, PAUSE_MS);
            status = ((waited == STATUS_OK) || (waited == STATUS_TIMEOUT)) ? STATUS_OK : waited;
        }
    }
    return status;
}

/// Send the record whose content of `size` octets was written after the header in `leaving`.
static status_t send_record(target_link_t* const link, const target_wire_kind_t kind, const size_t size)
{
    octets_put_u32(link->leaving, (uint32_t)(size + 1U));
    link->leaving[4] = (uint8_t)kind;
    return write_all(link, link->leaving, TARGET_WIRE_HEADER_OCTETS + size);
}

/// Pass on what has arrived at a socket. STATUS_OK, STATUS_CLOSED, STATUS_IO.
static status_t sweep_socket(target_link_t* const link, osal_socket_t* const socket)
{
    uint8_t* const content = &link->leaving[TARGET_WIRE_HEADER_OCTETS];
    status_t status        = STATUS_OK;
    for (unsigned i = 0U; (i < SWEEP_MAX) && (status == STATUS_OK); i++) {
        osal_address_t from         = {0U, 0U};
        size_t size                 = 0U;
        const status_t has_received = osal_udp_receive(socket, &from, &content[TARGET_WIRE_DATAGRAM_OCTETS],
                                                       TARGET_WIRE_DATAGRAM_MAX, &size);
        if (has_received == STATUS_TOO_LARGE) {
            count_loss(link); // Longer than any message or frame.
            continue;
        }
        if (has_received != STATUS_OK) {
            break;
        }
        octets_put_u32(content, (uint32_t)osal_socket_descriptor(socket));
        octets_put_u32(&content[4], from.ipv4);
        octets_put_u16(&content[8], from.port);
        status = send_record(link, TARGET_WIRE_DATAGRAM, TARGET_WIRE_DATAGRAM_OCTETS + size);
    }
    return status;
}

static status_t sweep(target_link_t* const link)
{
    status_t status = STATUS_OK;
    for (size_t i = 0U; (i < link->socket_count) && (status == STATUS_OK); i++) {
        status = sweep_socket(link, &link->sockets[i]);
    }
    return status;
}

/// Send octets of the stream, after the datagrams that have arrived before them.
static status_t send(void* const context, const uint8_t* const octets, const size_t size,
                     size_t* const out_sent)
{
    target_link_t* const link = (target_link_t*)context;
    status_t status           = sweep(link);
    *out_sent                 = 0U;
    while ((*out_sent < size) && (status == STATUS_OK)) {
        const size_t rest  = size - *out_sent;
        const size_t piece = (rest < TARGET_WIRE_STREAM_MAX) ? rest : TARGET_WIRE_STREAM_MAX;
        (void)memcpy(&link->leaving[TARGET_WIRE_HEADER_OCTETS], &octets[*out_sent], piece);
        status = send_record(link, TARGET_WIRE_STREAM, piece);
        *out_sent += piece;
    }
    return status;
}

// ---- From the program ----

/// True if the run has given a socket of this number to its processes.
static bool is_inherited(const target_link_t* const link, const int number)
{
    bool is_found = (number >= 0) && (link->run->components[link->component].message_descriptor == number);
    for (size_t i = 0U; (i < RUN_LINKS_MAX) && !is_found; i++) {
        is_found = (number >= 0) && (link->run->link_descriptors[i] == number);
    }
    return is_found;
}

static osal_socket_t* find_socket(target_link_t* const link, const uint32_t number)
{
    for (size_t i = 0U; i < link->socket_count; i++) {
        if ((uint32_t)osal_socket_descriptor(&link->sockets[i]) == number) {
            return &link->sockets[i];
        }
    }
    return (number == TARGET_WIRE_SENDER) ? &link->sender : NULL;
}

static status_t adopt(target_link_t* const link, const uint32_t number)
{
    if (!is_inherited(link, (int)number) || (link->socket_count >= TARGET_LINK_SOCKETS_MAX) ||
        (find_socket(link, number) != NULL) ||
        (osal_socket_adopt(&link->sockets[link->socket_count], (int)number) != STATUS_OK)) {
        return STATUS_INVALID;
    }
    link->socket_count++;
    return STATUS_OK;
}

/// A datagram that cannot be sent is lost, as it is for a native program, and counted.
static status_t pass_on(target_link_t* const link, const uint8_t* const content, const size_t size)
{
    osal_socket_t* const socket =
        (size >= TARGET_WIRE_DATAGRAM_OCTETS) ? find_socket(link, octets_u32_at(content)) : NULL;
    if (socket == NULL) {
        return STATUS_INVALID;
    }
    const osal_address_t to = {octets_u32_at(&content[4]), octets_u16_at(&content[8])};
    const status_t status =
        osal_udp_send(socket, to, &content[TARGET_WIRE_DATAGRAM_OCTETS], size - TARGET_WIRE_DATAGRAM_OCTETS);
    if ((status != STATUS_OK) && (status != STATUS_IO)) {
        count_loss(link);
    }
    return (status == STATUS_IO) ? STATUS_IO : STATUS_OK;
}

static status_t wait_for_program(target_link_t* const link, const uint8_t* const content)
{
    osal_socket_t* const socket = find_socket(link, octets_u32_at(content));
    if (socket == NULL) {
        return STATUS_INVALID;
    }
    status_t status = osal_socket_wait_readable(socket, octets_u32_at(&content[4]));
    status          = ((status == STATUS_OK) || (status == STATUS_TIMEOUT)) ? sweep(link) : status;
    return (status == STATUS_OK) ? send_record(link, TARGET_WIRE_WAITED, 0U) : status;
}

/// Force a file of the program, or the names in its directory, to the disk.
static status_t sync_file(target_link_t* const link, const uint8_t* const content, const size_t size)
{
    char path[TARGET_WIRE_PATH_MAX + 1U];
    if ((size < 2U) || (size > sizeof path) || (content[0] > TARGET_WIRE_SYNC_NAMES) ||
        (memchr(&content[1], '\0', size - 1U) != NULL)) {
        return STATUS_INVALID;
    }
    (void)memcpy(path, &content[1], size - 1U);
    path[size - 1U] = '\0';
    status_t status = STATUS_OK;
    if (content[0] == TARGET_WIRE_SYNC_NAMES) {
        status = osal_file_sync_names(path);
    } else {
        osal_file_t file;
        status = osal_file_open_read(&file, path);
        if (status == STATUS_OK) {
            status = osal_file_sync(&file);
            osal_file_close(&file);
        }
    }
    link->leaving[TARGET_WIRE_HEADER_OCTETS] = (status == STATUS_OK) ? 1U : 0U;
    return send_record(link, TARGET_WIRE_SYNCED, 1U);
}

static status_t take_record(target_link_t* const link, const target_wire_kind_t kind, const size_t size)
{
    const uint8_t* const content = &link->arrived[link->at];
    status_t status              = STATUS_INVALID;
    if ((kind == TARGET_WIRE_ADOPT) && (size == 4U)) {
        status = adopt(link, octets_u32_at(content));
    } else if (kind == TARGET_WIRE_DATAGRAM) {
        status = pass_on(link, content, size);
    } else if ((kind == TARGET_WIRE_WAIT) && (size == 8U)) {
        status = wait_for_program(link, content);
    } else if (kind == TARGET_WIRE_SYNC) {
        status = sync_file(link, content, size);
    } else {
        // Not a record of a program.
    }
    link->at += size;
    return status;
}

/// Read the octets in the pipe. STATUS_OK (something more has arrived), STATUS_EMPTY, STATUS_CLOSED,
/// STATUS_IO.
static status_t read_more(target_link_t* const link)
{
    size_t size = 0U;
    (void)memmove(link->arrived, &link->arrived[link->at], link->end - link->at);
    link->end -= link->at;
    link->at = 0U;
    const status_t status =
        osal_device_read(&link->in, &link->arrived[link->end], TARGET_LINK_BUFFER_OCTETS - link->end, &size);
    link->end += size;
    return status;
}

/// Take the next record if it is complete; of a record of the stream, take only its header. STATUS_OK,
/// STATUS_EMPTY (more must be read), STATUS_INVALID, STATUS_CLOSED, STATUS_IO.
static status_t take_next(target_link_t* const link)
{
    const size_t there = link->end - link->at;
    if (there < TARGET_WIRE_HEADER_OCTETS) {
        return STATUS_EMPTY;
    }
    const uint32_t size           = octets_u32_at(&link->arrived[link->at]);
    const target_wire_kind_t kind = (target_wire_kind_t)link->arrived[link->at + 4U];
    if ((size < 1U) || (size > (TARGET_WIRE_CONTENT_MAX + 1U))) {
        return STATUS_INVALID;
    }
    const size_t content = (size_t)size - 1U;
    if (kind == TARGET_WIRE_STREAM) {
        link->at += TARGET_WIRE_HEADER_OCTETS;
        link->stream_rest = content;
        return STATUS_OK;
    }
    if ((there - TARGET_WIRE_HEADER_OCTETS) < content) {
        return STATUS_EMPTY;
    }
    link->at += TARGET_WIRE_HEADER_OCTETS;
    return take_record(link, kind, content);
}

/// Take records until there are octets of the stream. STATUS_OK (there are some), STATUS_EMPTY,
/// STATUS_CLOSED, STATUS_INVALID, STATUS_IO.
static status_t take_records(target_link_t* const link)
{
    status_t status = STATUS_OK;
    while ((status == STATUS_OK) && ((link->stream_rest == 0U) || (link->at == link->end))) {
        status = (link->stream_rest == 0U) ? take_next(link) : STATUS_EMPTY;
        status = (status == STATUS_EMPTY) ? read_more(link) : status;
    }
    return status;
}

static status_t receive(void* const context, uint8_t* const octets, const size_t capacity,
                        size_t* const out_size)
{
    target_link_t* const link = (target_link_t*)context;
    *out_size                 = 0U;
    const status_t status     = take_records(link);
    if (status != STATUS_OK) {
        return (status == STATUS_INVALID) ? STATUS_IO : status;
    }
    size_t size = link->end - link->at;
    size        = (size < link->stream_rest) ? size : link->stream_rest;
    size        = (size < capacity) ? size : capacity;
    (void)memcpy(octets, &link->arrived[link->at], size);
    link->at += size;
    link->stream_rest -= size;
    *out_size = size;
    return STATUS_OK;
}

static status_t wait_readable(void* const context, const uint32_t timeout_ms)
{
    target_link_t* const link = (target_link_t*)context;
    return osal_device_wait_readable(&link->in, timeout_ms);
}

remote_endian_carrier_t target_link_carrier(target_link_t* const link)
{
    FSW_ASSERT(link != NULL);
    return (remote_endian_carrier_t){link, send, receive, wait_readable};
}
