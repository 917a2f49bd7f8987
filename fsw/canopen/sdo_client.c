// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/sdo_client.h"

#include "fsw/canopen/cob.h"
#include "base/assertion.h"

#include <string.h>

// Command specifiers, the upper three bits of octet 0.
#define CLIENT_SEGMENT_DOWNLOAD 0U
#define CLIENT_INITIATE_DOWNLOAD 1U
#define CLIENT_INITIATE_UPLOAD 2U
#define CLIENT_SEGMENT_UPLOAD 3U
#define SERVER_SEGMENT_UPLOAD 0U
#define SERVER_SEGMENT_DOWNLOAD 1U
#define SERVER_INITIATE_UPLOAD 2U
#define SERVER_INITIATE_DOWNLOAD 3U
#define ABORT 4U

#define BIT_SIZE 0x01U
#define BIT_EXPEDITED 0x02U
#define BIT_LAST 0x01U
#define BIT_TOGGLE 0x10U
#define SEGMENT_OCTETS 7U
#define EXPEDITED_OCTETS 4U

void canopen_sdo_client_init(canopen_sdo_client_t* const client, const uint64_t timeout_ns)
{
    FSW_ASSERT((client != NULL) && (timeout_ns > 0U));
    *client = (canopen_sdo_client_t){.timeout_ns = timeout_ns, .phase = SDO_IDLE, .result = STATUS_EMPTY};
}

void canopen_sdo_client_reset(canopen_sdo_client_t* const client)
{
    FSW_ASSERT(client != NULL);
    client->phase       = SDO_IDLE;
    client->result      = STATUS_EMPTY;
    client->has_request = false;
}

/// Prepare a request that contains the address of the object.
static void address_request(canopen_sdo_client_t* const client, const uint8_t command)
{
    (void)memset(client->request, 0, SDO_FRAME_OCTETS);
    canopen_put(&client->request[1], client->index, 2U);
    client->request[0]   = command;
    client->request[3]   = client->subindex;
    client->has_request  = true;
    client->is_clock_due = true;
}

static void begin(canopen_sdo_client_t* const client, const canopen_sdo_phase_t phase, const uint16_t index,
                  const uint8_t subindex)
{
    client->phase      = phase;
    client->result     = STATUS_BUSY;
    client->abort_code = 0U;
    client->index      = index;
    client->subindex   = subindex;
    client->toggle     = false;
    client->moved      = 0U;
}

status_t canopen_sdo_client_download(canopen_sdo_client_t* const client, const uint16_t index,
                                     const uint8_t subindex, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((client != NULL) && (octets != NULL));
    if (client->phase != SDO_IDLE) {
        return STATUS_BUSY;
    }
    if (size == 0U) {
        return STATUS_INVALID;
    }
    if (size > SDO_OCTETS_MAX) {
        return STATUS_TOO_LARGE;
    }
    begin(client, SDO_INITIATE_DOWNLOAD, index, subindex);
    (void)memcpy(client->data, octets, size);
    client->size = size;
    if (size <= EXPEDITED_OCTETS) {
        const unsigned unused = (unsigned)(EXPEDITED_OCTETS - size);
        address_request(
            client, (uint8_t)((CLIENT_INITIATE_DOWNLOAD << 5) | (unused << 2) | BIT_EXPEDITED | BIT_SIZE));
        (void)memcpy(&client->request[4], octets, size);
        client->moved = size;
    } else {
        address_request(client, (uint8_t)((CLIENT_INITIATE_DOWNLOAD << 5) | BIT_SIZE));
        canopen_put(&client->request[4], size, 4U);
    }
    return STATUS_OK;
}

status_t canopen_sdo_client_upload(canopen_sdo_client_t* const client, const uint16_t index,
                                   const uint8_t subindex)
{
    FSW_ASSERT(client != NULL);
    if (client->phase != SDO_IDLE) {
        return STATUS_BUSY;
    }
    begin(client, SDO_INITIATE_UPLOAD, index, subindex);
    address_request(client, (uint8_t)(CLIENT_INITIATE_UPLOAD << 5));
    return STATUS_OK;
}

status_t canopen_sdo_client_result(const canopen_sdo_client_t* const client, uint32_t* const out_abort_code)
{
    FSW_ASSERT(client != NULL);
    if (out_abort_code != NULL) {
        *out_abort_code = client->abort_code;
    }
    return client->result;
}

const uint8_t* canopen_sdo_client_value(const canopen_sdo_client_t* const client, size_t* const out_size)
{
    FSW_ASSERT((client != NULL) && (out_size != NULL));
    *out_size = client->moved;
    return client->data;
}

static void end(canopen_sdo_client_t* const client, const status_t result)
{
    client->phase       = SDO_IDLE;
    client->result      = result;
    client->has_request = false;
    if (result == STATUS_OK) {
        client->counters.transfers++;
    }
}

/// End the transfer and send the server an abort with the reason.
static void abort_transfer(canopen_sdo_client_t* const client, const uint32_t code, const status_t result)
{
    end(client, result);
    client->abort_code = code;
    address_request(client, (uint8_t)(ABORT << 5));
    canopen_put(&client->request[4], code, 4U);
    client->is_clock_due = false;
    if (result == STATUS_TIMEOUT) {
        client->counters.timeouts++;
    } else {
        client->counters.violations++;
    }
}

static void send_segment(canopen_sdo_client_t* const client)
{
    const size_t left   = client->size - client->moved;
    const size_t part   = (left < SEGMENT_OCTETS) ? left : SEGMENT_OCTETS;
    const unsigned last = (part == left) ? BIT_LAST : 0U;
    (void)memset(client->request, 0, SDO_FRAME_OCTETS);
    client->request[0] = (uint8_t)((CLIENT_SEGMENT_DOWNLOAD << 5) | (client->toggle ? BIT_TOGGLE : 0U) |
                                   ((SEGMENT_OCTETS - (unsigned)part) << 1) | last);
    (void)memcpy(&client->request[1], &client->data[client->moved], part);
    client->moved += part;
    client->has_request  = true;
    client->is_clock_due = true;
}

static void ask_segment(canopen_sdo_client_t* const client)
{
    (void)memset(client->request, 0, SDO_FRAME_OCTETS);
    client->request[0]   = (uint8_t)((CLIENT_SEGMENT_UPLOAD << 5) | (client->toggle ? BIT_TOGGLE : 0U));
    client->has_request  = true;
    client->is_clock_due = true;
}

/// True if an answer to an initiate request, or an abort, contains the object of the transfer.
static bool names_our_object(const canopen_sdo_client_t* const client, const uint8_t* const octets)
{
    return (canopen_at(&octets[1], 2U) == client->index) && (octets[3] == client->subindex);
}

static void answer_initiate_download(canopen_sdo_client_t* const client)
{
    if (client->moved == client->size) {
        end(client, STATUS_OK);
    } else {
        client->phase = SDO_SEGMENT_DOWNLOAD;
        send_segment(client);
    }
}

static void answer_segment_download(canopen_sdo_client_t* const client, const uint8_t* const octets)
{
    if (((octets[0] & BIT_TOGGLE) != 0U) != client->toggle) {
        abort_transfer(client, SDO_ABORT_TOGGLE, STATUS_INVALID);
    } else if (client->moved == client->size) {
        end(client, STATUS_OK);
    } else {
        client->toggle = !client->toggle;
        send_segment(client);
    }
}

static void answer_initiate_upload(canopen_sdo_client_t* const client, const uint8_t* const octets)
{
    const bool has_size = (octets[0] & BIT_SIZE) != 0U;
    if ((octets[0] & BIT_EXPEDITED) != 0U) {
        const size_t unused = has_size ? ((octets[0] >> 2) & 0x03U) : 0U;
        client->moved       = EXPEDITED_OCTETS - unused;
        (void)memcpy(client->data, &octets[4], client->moved);
        end(client, STATUS_OK);
        return;
    }
    const uint32_t size = has_size ? canopen_u32_at(&octets[4]) : 0U;
    if (size > SDO_OCTETS_MAX) {
        abort_transfer(client, SDO_ABORT_MEMORY, STATUS_TOO_LARGE);
        return;
    }
    client->size  = size;
    client->phase = SDO_SEGMENT_UPLOAD;
    ask_segment(client);
}

static void answer_segment_upload(canopen_sdo_client_t* const client, const uint8_t* const octets)
{
    const size_t part  = SEGMENT_OCTETS - ((octets[0] >> 1) & 0x07U);
    const bool is_last = (octets[0] & BIT_LAST) != 0U;
    if (((octets[0] & BIT_TOGGLE) != 0U) != client->toggle) {
        abort_transfer(client, SDO_ABORT_TOGGLE, STATUS_INVALID);
        return;
    }
    if (part > (SDO_OCTETS_MAX - client->moved)) {
        abort_transfer(client, SDO_ABORT_MEMORY, STATUS_TOO_LARGE);
        return;
    }
    (void)memcpy(&client->data[client->moved], &octets[1], part);
    client->moved += part;
    if (is_last) {
        if ((client->size != 0U) && (client->size != client->moved)) {
            abort_transfer(client, SDO_ABORT_LENGTH, STATUS_INVALID);
        } else {
            end(client, STATUS_OK);
        }
    } else if ((part == 0U) || ((client->size != 0U) && (client->moved >= client->size))) {
        // Such a transfer would never end: the segment is empty, or the announced octets are complete and
        // more follow.
        abort_transfer(client, SDO_ABORT_LENGTH, STATUS_INVALID);
    } else {
        client->toggle = !client->toggle;
        ask_segment(client);
    }
}

/// Returns the command specifier of the answer that is expected in a phase.
static unsigned expected_specifier(const canopen_sdo_phase_t phase)
{
    switch (phase) {
    case SDO_INITIATE_DOWNLOAD:
        return SERVER_INITIATE_DOWNLOAD;
    case SDO_SEGMENT_DOWNLOAD:
        return SERVER_SEGMENT_DOWNLOAD;
    case SDO_INITIATE_UPLOAD:
        return SERVER_INITIATE_UPLOAD;
    case SDO_SEGMENT_UPLOAD:
    case SDO_IDLE:
    default:
        return SERVER_SEGMENT_UPLOAD;
    }
}

void canopen_sdo_client_answer(canopen_sdo_client_t* const client, const uint8_t* const octets,
                               const uint8_t length)
{
    FSW_ASSERT((client != NULL) && (octets != NULL));
    if (length != SDO_FRAME_OCTETS) {
        client->counters.malformed++;
        return;
    }
    const unsigned specifier = octets[0] >> 5;
    const bool is_initiate =
        (client->phase == SDO_INITIATE_DOWNLOAD) || (client->phase == SDO_INITIATE_UPLOAD);
    const bool is_addressed = is_initiate || (specifier == ABORT);
    // An answer that arrives before the request was sent belongs to an earlier transfer.
    if ((client->phase == SDO_IDLE) || client->has_request ||
        (is_addressed && !names_our_object(client, octets))) {
        client->counters.unasked++;
        return;
    }
    if (specifier == ABORT) {
        end(client, STATUS_FORBIDDEN);
        client->abort_code = canopen_u32_at(&octets[4]);
        client->counters.aborted++;
    } else if (specifier != expected_specifier(client->phase)) {
        abort_transfer(client, SDO_ABORT_COMMAND, STATUS_INVALID);
    } else if (client->phase == SDO_INITIATE_DOWNLOAD) {
        answer_initiate_download(client);
    } else if (client->phase == SDO_SEGMENT_DOWNLOAD) {
        answer_segment_download(client, octets);
    } else if (client->phase == SDO_INITIATE_UPLOAD) {
        answer_initiate_upload(client, octets);
    } else {
        answer_segment_upload(client, octets);
    }
}

bool canopen_sdo_client_is_waiting(const canopen_sdo_client_t* const client)
{
    FSW_ASSERT(client != NULL);
    return !client->has_request && (client->phase != SDO_IDLE);
}

bool canopen_sdo_client_request(canopen_sdo_client_t* const client, const uint64_t now_ns,
                                uint8_t out_frame[SDO_FRAME_OCTETS])
{
    FSW_ASSERT((client != NULL) && (out_frame != NULL));
    if (!client->has_request && (client->phase != SDO_IDLE) && (now_ns >= client->deadline_ns)) {
        abort_transfer(client, SDO_ABORT_TIMEOUT, STATUS_TIMEOUT);
    }
    if (!client->has_request) {
        return false;
    }
    if (client->is_clock_due) {
        client->deadline_ns  = now_ns + client->timeout_ns;
        client->is_clock_due = false;
    }
    (void)memcpy(out_frame, client->request, SDO_FRAME_OCTETS);
    client->has_request = false;
    return true;
}
