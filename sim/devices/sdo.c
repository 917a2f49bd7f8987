// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/sdo.h"

#include <math.h>
#include <string.h>

// Command specifiers, the three highest bits of the first octet.
#define CLIENT_DOWNLOAD_SEGMENT 0U
#define CLIENT_DOWNLOAD 1U
#define CLIENT_UPLOAD 2U
#define CLIENT_UPLOAD_SEGMENT 3U
#define CLIENT_ABORT 4U

#define SERVER_DOWNLOADED 0x60U
#define SERVER_SEGMENT_TAKEN 0x20U
#define SERVER_UPLOAD 0x40U
#define SERVER_ABORT 0x80U
#define EXPEDITED 0x02U
#define SIZE_SHOWN 0x01U
#define LAST_SEGMENT 0x01U
#define TOGGLE 0x10U
#define SEGMENT_OCTETS 7U

void sdo_server_reset(sdo_server_t* const server)
{
    server->state = SDO_IDLE;
}

static void put_u32(uint8_t* const octets, const uint32_t value)
{
    for (unsigned i = 0U; i < 4U; i++) {
        octets[i] = (uint8_t)(value >> (8U * i));
    }
}

static void put_multiplexer(uint8_t reply[SDO_OCTETS], const uint8_t command, const uint16_t index,
                            const uint8_t subindex)
{
    memset(reply, 0, SDO_OCTETS);
    reply[0] = command;
    reply[1] = (uint8_t)index;
    reply[2] = (uint8_t)(index >> 8);
    reply[3] = subindex;
}

static void abort_transfer(sdo_server_t* const server, uint8_t reply[SDO_OCTETS], const uint16_t index,
                           const uint8_t subindex, const uint32_t code)
{
    server->state = SDO_IDLE;
    put_multiplexer(reply, SERVER_ABORT, index, subindex);
    put_u32(&reply[4], code);
}

/// Check a received REAL32 or REAL64. A number that is not finite is no value of a parameter.
static uint32_t real_check(const sdo_access_t* const access, const object_t* const object,
                           const object_t* const received)
{
    const double value = object_real(received);
    if (!isfinite(value)) {
        return SDO_ABORT_VALUE;
    }
    if (object->has_low && (value < object->real_low)) {
        return SDO_ABORT_TOO_LOW;
    }
    if (object->has_high && (value > object->real_high)) {
        return SDO_ABORT_TOO_HIGH;
    }
    return (access->check != NULL) ? access->check(access->context, object, (int64_t)received->value) : 0U;
}

static uint32_t number_check(const sdo_access_t* const access, const object_t* const object,
                             const uint8_t* const octets, const size_t size, int64_t* const out_value)
{
    if (size != object->size) {
        return (size > object->size) ? SDO_ABORT_TOO_LONG : SDO_ABORT_TOO_SHORT;
    }
    object_t received = *object;
    received.value    = 0U;
    for (size_t i = 0U; i < size; i++) {
        received.value |= (uint64_t)octets[i] << (8U * i);
    }
    const int64_t value = object_signed(&received);
    *out_value          = value;
    if (object_is_real(object)) {
        return real_check(access, object, &received);
    }
    if ((object->type == OBJECT_BOOLEAN) && (received.value > 1U)) {
        return SDO_ABORT_VALUE;
    }
    if (object->has_low && (value < object->low)) {
        return SDO_ABORT_TOO_LOW;
    }
    if (object->has_high && (value > object->high)) {
        return SDO_ABORT_TOO_HIGH;
    }
    return (access->check != NULL) ? access->check(access->context, object, value) : 0U;
}

/// Write octets into an object. Returns an abort code or 0.
static uint32_t store(const sdo_access_t* const access, object_t* const object, const uint8_t* const octets,
                      const size_t size)
{
    if (object_is_text(object)) {
        if (size > OBJECT_TEXT_MAX) {
            return SDO_ABORT_TOO_LONG;
        }
        memset(object->text, 0, OBJECT_TEXT_MAX);
        memcpy(object->text, octets, size);
        object->size = (uint8_t)size;
    } else {
        int64_t value       = 0;
        const uint32_t code = number_check(access, object, octets, size, &value);
        if (code != 0U) {
            return code;
        }
        object_set(object, value);
    }
    if (access->written != NULL) {
        access->written(access->context, object);
    }
    return 0U;
}

/// Find the object of a request. Returns an abort code or 0.
static uint32_t find(const dictionary_t* const dictionary, const uint16_t index, const uint8_t subindex,
                     const bool is_write, object_t** const out_object)
{
    object_t* object = dictionary_find(dictionary, index, subindex);
    *out_object      = object;
    if (object == NULL) {
        return dictionary_has_index(dictionary, index) ? SDO_ABORT_NO_SUBINDEX : SDO_ABORT_NO_OBJECT;
    }
    if (is_write && !object->is_writable) {
        return SDO_ABORT_READ_ONLY;
    }
    return (!is_write && !object->is_readable) ? SDO_ABORT_WRITE_ONLY : 0U;
}

static uint32_t download(sdo_server_t* const server, const sdo_access_t* const access, object_t* const object,
                         const uint8_t request[SDO_OCTETS])
{
    const bool has_size = (request[0] & SIZE_SHOWN) != 0U;
    if ((request[0] & EXPEDITED) != 0U) {
        size_t size = 4U;
        if (has_size) {
            size = 4U - ((request[0] >> 2) & 3U);
        } else if (!object_is_text(object) && (object->size < 4U)) {
            size = object->size; // The client did not give a size: use that of the object.
        }
        server->state = SDO_IDLE;
        return store(access, object, &request[4], size);
    }
    const size_t limit = object_is_text(object) ? OBJECT_TEXT_MAX : object->size;
    server->state      = SDO_DOWNLOADING;
    server->object     = object;
    server->toggle     = 0U;
    server->offset     = 0U;
    server->has_size   = has_size;
    server->size       = (size_t)request[4] | ((size_t)request[5] << 8) | ((size_t)request[6] << 16) |
                   ((size_t)request[7] << 24);
    return (has_size && (server->size > limit)) ? SDO_ABORT_TOO_LONG : 0U;
}

static uint32_t download_segment(sdo_server_t* const server, const sdo_access_t* const access,
                                 const uint8_t request[SDO_OCTETS])
{
    const size_t size = SEGMENT_OCTETS - ((request[0] >> 1) & 7U);
    if ((server->offset + size) > sizeof server->buffer) {
        return SDO_ABORT_TOO_LONG;
    }
    memcpy(&server->buffer[server->offset], &request[1], size);
    server->offset += size;
    server->toggle ^= TOGGLE;
    if ((request[0] & LAST_SEGMENT) == 0U) {
        return 0U;
    }
    server->state = SDO_IDLE;
    if (server->has_size && (server->offset != server->size)) {
        return SDO_ABORT_LENGTH;
    }
    return store(access, server->object, server->buffer, server->offset);
}

static void upload(sdo_server_t* const server, object_t* const object, uint8_t reply[SDO_OCTETS])
{
    uint8_t octets[OBJECT_TEXT_MAX];
    if (object_is_text(object)) {
        memcpy(octets, object->text, object->size);
    } else {
        for (unsigned i = 0U; i < object->size; i++) {
            octets[i] = (uint8_t)(object->value >> (8U * i));
        }
    }
    server->state = SDO_IDLE;
    if ((object->size >= 1U) && (object->size <= 4U)) {
        const uint32_t unused = 4U - object->size;
        put_multiplexer(reply, (uint8_t)(SERVER_UPLOAD | (unused << 2) | EXPEDITED | SIZE_SHOWN),
                        object->index, object->subindex);
        memcpy(&reply[4], octets, object->size);
        return;
    }
    memcpy(server->buffer, octets, object->size);
    server->state  = SDO_UPLOADING;
    server->object = object;
    server->toggle = 0U;
    server->offset = 0U;
    server->size   = object->size;
    put_multiplexer(reply, SERVER_UPLOAD | SIZE_SHOWN, object->index, object->subindex);
    put_u32(&reply[4], object->size);
}

static void upload_segment(sdo_server_t* const server, uint8_t reply[SDO_OCTETS])
{
    const size_t left = server->size - server->offset;
    const size_t size = (left < SEGMENT_OCTETS) ? left : SEGMENT_OCTETS;
    memset(reply, 0, SDO_OCTETS);
    memcpy(&reply[1], &server->buffer[server->offset], size);
    server->offset += size;
    const uint32_t last = (server->offset == server->size) ? LAST_SEGMENT : 0U;
    reply[0]            = (uint8_t)(server->toggle | ((SEGMENT_OCTETS - size) << 1) | last);
    server->toggle ^= TOGGLE;
    if (last != 0U) {
        server->state = SDO_IDLE;
    }
}

/// Check that a segment belongs to a running transfer of its direction and that its toggle bit alternates.
/// Returns an abort code or 0.
static uint32_t segment_check(const sdo_server_t* const server, const sdo_state_t wanted,
                              const uint8_t command)
{
    if (server->state != wanted) {
        return SDO_ABORT_COMMAND;
    }
    return ((command & TOGGLE) != server->toggle) ? SDO_ABORT_TOGGLE : 0U;
}

static bool serve_segment(sdo_server_t* const server, const sdo_access_t* const access,
                          const uint8_t request[SDO_OCTETS], uint8_t reply[SDO_OCTETS])
{
    const bool is_upload     = (request[0] >> 5) == CLIENT_UPLOAD_SEGMENT;
    const sdo_state_t wanted = is_upload ? SDO_UPLOADING : SDO_DOWNLOADING;
    const bool has_object    = server->state != SDO_IDLE;
    const uint16_t index     = has_object ? server->object->index : 0U;
    const uint8_t subindex   = has_object ? server->object->subindex : 0U;
    uint32_t code            = segment_check(server, wanted, request[0]);
    if ((code == 0U) && is_upload) {
        upload_segment(server, reply);
        return true;
    }
    if (code == 0U) {
        code = download_segment(server, access, request);
    }
    if (code != 0U) {
        abort_transfer(server, reply, index, subindex, code);
        return true;
    }
    memset(reply, 0, SDO_OCTETS);
    reply[0] = (uint8_t)(SERVER_SEGMENT_TAKEN | (request[0] & TOGGLE));
    return true;
}

bool sdo_server_request(sdo_server_t* const server, const dictionary_t* const dictionary,
                        const sdo_access_t* const access, const uint8_t request[SDO_OCTETS],
                        uint8_t reply[SDO_OCTETS])
{
    const uint32_t command = request[0] >> 5;
    const uint16_t index   = (uint16_t)(request[1] | (request[2] << 8));
    const uint8_t subindex = request[3];
    if (command == CLIENT_ABORT) {
        server->state = SDO_IDLE;
        return false;
    }
    if ((command == CLIENT_DOWNLOAD_SEGMENT) || (command == CLIENT_UPLOAD_SEGMENT)) {
        return serve_segment(server, access, request, reply);
    }
    if ((command != CLIENT_DOWNLOAD) && (command != CLIENT_UPLOAD)) {
        abort_transfer(server, reply, index, subindex, SDO_ABORT_COMMAND); // Block transfer.
        return true;
    }
    object_t* object = NULL;
    uint32_t code    = find(dictionary, index, subindex, command == CLIENT_DOWNLOAD, &object);
    if ((code == 0U) && (command == CLIENT_DOWNLOAD)) {
        code = download(server, access, object, request);
        put_multiplexer(reply, SERVER_DOWNLOADED, index, subindex);
    } else if (code == 0U) {
        if (access->read != NULL) {
            access->read(access->context, object);
        }
        upload(server, object, reply);
    }
    if (code != 0U) {
        abort_transfer(server, reply, index, subindex, code);
    }
    return true;
}
