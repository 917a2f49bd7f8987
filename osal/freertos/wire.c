// SPDX-License-Identifier: Apache-2.0
#include "osal/freertos/wire.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "base/text.h"
#include "osal/freertos/datagrams.h"
#include "osal/freertos/semihosting.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/target_wire.h"

#include <limits.h>
#include <string.h>

#define BUFFER_OCTETS 32768U
#define LINE_MAX 96U

typedef struct {
    int in_number; ///< Descriptor numbers of the inherited pipes.
    int out_number;
    bool has_numbers;
    bool is_open;
    int in; ///< Handles of semihosting.
    int out;
    uint8_t arrived[BUFFER_OCTETS]; ///< Read from the pipe; those in [at, end) are not taken yet.
    size_t at;
    size_t end;
    size_t stream_rest;             ///< Octets that the present record of the stream still has.
    uint8_t leaving[BUFFER_OCTETS]; ///< Written to the pipe before the program waits.
    size_t leaving_size;
    uint32_t lost;  ///< Datagrams that had no room.
    bool is_synced; ///< The last answer to TARGET_WIRE_SYNC.
} wire_t;

static wire_t wire;

/// Returns the number at the beginning of a text, or -1; *text is moved past it.
static int take_number(const char** const text)
{
    int number = -1;
    while ((**text >= '0') && (**text <= '9')) {
        const int digit = **text - '0';
        if (number > ((INT_MAX - digit) / 10)) {
            return -1;
        }
        number = (((number < 0) ? 0 : number) * 10) + digit;
        (*text)++;
    }
    return number;
}

bool wire_set(const char* const numbers)
{
    const char* next    = numbers;
    wire.in_number      = take_number(&next);
    const bool has_both = (*next == ':');
    next                = has_both ? &next[1] : next;
    wire.out_number     = take_number(&next);
    wire.has_numbers    = has_both && (wire.in_number >= 0) && (wire.out_number >= 0) && (*next == '\0');
    return wire.has_numbers;
}

/// Open an inherited descriptor. -1: it cannot be opened.
static int open_number(const int number, const semihosting_mode_t mode)
{
    char path[24];
    text_t text = text_in(path, sizeof path);
    text_add(&text, "/dev/fd/");
    text_add_unsigned(&text, (uint64_t)number);
    return semihosting_open(path, mode);
}

status_t wire_open(void)
{
    if (!wire.has_numbers) {
        return STATUS_INVALID;
    }
    wire.in           = open_number(wire.in_number, SEMIHOSTING_READ);
    wire.out          = open_number(wire.out_number, SEMIHOSTING_WRITE);
    wire.is_open      = (wire.in >= 0) && (wire.out >= 0);
    wire.at           = 0U;
    wire.end          = 0U;
    wire.stream_rest  = 0U;
    wire.leaving_size = 0U;
    wire.lost         = 0U;
    return wire.is_open ? STATUS_OK : STATUS_INVALID;
}

bool wire_is_open(void)
{
    return wire.is_open;
}

uint32_t wire_lost(void)
{
    return wire.lost;
}

static void print_losses(void)
{
    char line[LINE_MAX];
    text_t text = text_in(line, sizeof line);
    text_add(&text, "wire: datagrams lost because there was no room for them: ");
    text_add_unsigned(&text, wire.lost);
    osal_console_print_error(line);
}

void wire_close(void)
{
    if (wire.is_open) {
        if (wire.lost > 1U) { // The first was printed when it was lost.
            print_losses();
        }
        semihosting_close(wire.in);
        semihosting_close(wire.out);
    }
    wire.is_open = false;
}

// ---- Octets ----

static status_t flush(void)
{
    const bool is_good = wire_is_open() && ((wire.leaving_size == 0U) ||
                                            semihosting_write(wire.out, wire.leaving, wire.leaving_size));
    wire.leaving_size  = 0U;
    return is_good ? STATUS_OK : STATUS_CLOSED;
}

static status_t put(const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT(size <= BUFFER_OCTETS);
    status_t status = STATUS_OK;
    if (size > (BUFFER_OCTETS - wire.leaving_size)) {
        status = flush();
    }
    (void)memcpy(&wire.leaving[wire.leaving_size], octets, size);
    wire.leaving_size += size;
    return status;
}

static status_t put_header(const target_wire_kind_t kind, const size_t content)
{
    uint8_t header[TARGET_WIRE_HEADER_OCTETS];
    octets_put_u32(header, (uint32_t)(content + 1U));
    header[4] = (uint8_t)kind;
    return put(header, sizeof header);
}

/// Read from the pipe until `size` octets are there; waits. STATUS_OK, STATUS_CLOSED.
static status_t await(const size_t size)
{
    FSW_ASSERT(size <= BUFFER_OCTETS);
    status_t status = STATUS_OK;
    if ((wire.end - wire.at) >= size) {
        return STATUS_OK;
    }
    status = flush();
    (void)memmove(wire.arrived, &wire.arrived[wire.at], wire.end - wire.at);
    wire.end -= wire.at;
    wire.at = 0U;
    while ((status == STATUS_OK) && (wire.end < size)) {
        const int count = semihosting_read(wire.in, &wire.arrived[wire.end], BUFFER_OCTETS - wire.end);
        status          = (count > 0) ? STATUS_OK : STATUS_CLOSED;
        wire.end += (count > 0) ? (size_t)count : 0U;
    }
    return status;
}

/// A datagram has arrived. If its socket is closed or there is no room, it is lost, as in a kernel.
static void store_datagram(const uint8_t* const content, const size_t size)
{
    const uint32_t number     = octets_u32_at(content);
    const osal_address_t from = {octets_u32_at(&content[4]), octets_u16_at(&content[8])};
    if (!datagrams_add(number, from, &content[TARGET_WIRE_DATAGRAM_OCTETS],
                       size - TARGET_WIRE_DATAGRAM_OCTETS)) {
        wire.lost += (wire.lost < UINT32_MAX) ? 1U : 0U;
        if (wire.lost == 1U) {
            print_losses();
        }
    }
}

/// Take the content of a record that is not of the stream. STATUS_OK; STATUS_CLOSED: the serving process has
/// not sent a record of the protocol, so what follows has no meaning either.
static status_t take_content(const target_wire_kind_t kind, const size_t size)
{
    const bool is_datagram = (kind == TARGET_WIRE_DATAGRAM) && (size >= TARGET_WIRE_DATAGRAM_OCTETS);
    if (is_datagram) {
        store_datagram(&wire.arrived[wire.at], size);
    }
    const bool is_answer = (kind == TARGET_WIRE_SYNCED) && (size == 1U) && (wire.arrived[wire.at] <= 1U);
    if (is_answer) {
        wire.is_synced = (wire.arrived[wire.at] == 1U);
    }
    wire.at += size;
    return (is_datagram || is_answer || ((kind == TARGET_WIRE_WAITED) && (size == 0U))) ? STATUS_OK
                                                                                        : STATUS_CLOSED;
}

/// Close the wire because of a record that the protocol does not have.
static status_t refuse(const target_wire_kind_t kind, const uint32_t size)
{
    char line[LINE_MAX];
    text_t text = text_in(line, sizeof line);
    text_add(&text, "wire: no record of the protocol: kind ");
    text_add_unsigned(&text, (uint64_t)kind);
    text_add(&text, ", octets ");
    text_add_unsigned(&text, size);
    text_add(&text, "; build proxy and program again");
    osal_console_print_error(line);
    return STATUS_CLOSED;
}

/// Take the next record. If it is a record of the stream, take only its header: stream_rest is the number of
/// octets that follow. STATUS_OK with its kind, STATUS_CLOSED (also: no record of the protocol).
static status_t take_record(target_wire_kind_t* const out_kind)
{
    if (await(TARGET_WIRE_HEADER_OCTETS) != STATUS_OK) {
        return STATUS_CLOSED;
    }
    const uint32_t size = octets_u32_at(&wire.arrived[wire.at]);
    *out_kind           = (target_wire_kind_t)wire.arrived[wire.at + 4U];
    if ((size < 1U) || (size > (TARGET_WIRE_CONTENT_MAX + 1U))) {
        return refuse(*out_kind, size);
    }
    const size_t content = (size_t)size - 1U;
    wire.at += TARGET_WIRE_HEADER_OCTETS;
    if (*out_kind == TARGET_WIRE_STREAM) {
        wire.stream_rest = content;
        return STATUS_OK;
    }
    if (await(content) != STATUS_OK) {
        return STATUS_CLOSED;
    }
    return (take_content(*out_kind, content) == STATUS_OK) ? STATUS_OK : refuse(*out_kind, size);
}

// ---- Stream ----

status_t wire_stream_send(const uint8_t* const octets, const size_t size)
{
    status_t status = STATUS_OK;
    size_t sent     = 0U;
    while ((sent < size) && (status == STATUS_OK)) {
        const size_t rest  = size - sent;
        const size_t piece = (rest < TARGET_WIRE_STREAM_MAX) ? rest : TARGET_WIRE_STREAM_MAX;
        status             = put_header(TARGET_WIRE_STREAM, piece);
        status             = (status == STATUS_OK) ? put(&octets[sent], piece) : status;
        sent += piece;
    }
    return (status == STATUS_OK) ? flush() : status;
}

status_t wire_stream_receive(uint8_t* const octets, const size_t capacity, size_t* const out_size)
{
    target_wire_kind_t kind = TARGET_WIRE_WAITED;
    *out_size               = 0U;
    while (wire.stream_rest == 0U) {
        if (take_record(&kind) != STATUS_OK) {
            return STATUS_CLOSED;
        }
    }
    if (await(1U) != STATUS_OK) {
        return STATUS_CLOSED;
    }
    size_t size = wire.end - wire.at;
    size        = (size < wire.stream_rest) ? size : wire.stream_rest;
    size        = (size < capacity) ? size : capacity;
    (void)memcpy(octets, &wire.arrived[wire.at], size);
    wire.at += size;
    wire.stream_rest -= size;
    *out_size = size;
    return STATUS_OK;
}

// ---- Datagrams ----

status_t wire_adopt(const uint32_t number)
{
    uint8_t content[4];
    octets_put_u32(content, number);
    const status_t status = put_header(TARGET_WIRE_ADOPT, sizeof content);
    return (status == STATUS_OK) ? put(content, sizeof content) : status;
}

status_t wire_datagram_send(const uint32_t number, const osal_address_t to, const uint8_t* const octets,
                            const size_t size)
{
    uint8_t head[TARGET_WIRE_DATAGRAM_OCTETS];
    if (size > TARGET_WIRE_DATAGRAM_MAX) {
        return STATUS_TOO_LARGE;
    }
    octets_put_u32(head, number);
    octets_put_u32(&head[4], to.ipv4);
    octets_put_u16(&head[8], to.port);
    status_t status = put_header(TARGET_WIRE_DATAGRAM, sizeof head + size);
    status          = (status == STATUS_OK) ? put(head, sizeof head) : status;
    return (status == STATUS_OK) ? put(octets, size) : status;
}

status_t wire_datagram_receive(const uint32_t number, osal_address_t* const out_from, uint8_t* const octets,
                               const size_t capacity, size_t* const out_size)
{
    return datagrams_take(number, out_from, octets, capacity, out_size);
}

/// Take records up to the answer to a request. The serving process sends nothing of the stream before the
/// program has answered it. STATUS_OK, STATUS_CLOSED.
static status_t await_answer(const target_wire_kind_t answer)
{
    target_wire_kind_t kind = TARGET_WIRE_STREAM;
    status_t status         = STATUS_OK;
    while ((status == STATUS_OK) && (kind != answer)) {
        status = take_record(&kind);
        status = ((status == STATUS_OK) && (kind == TARGET_WIRE_STREAM)) ? STATUS_CLOSED : status;
    }
    return status;
}

status_t wire_datagram_wait(const uint32_t number, const uint32_t timeout_ms)
{
    uint8_t content[8];
    if (datagrams_has(number)) {
        return STATUS_OK;
    }
    octets_put_u32(content, number);
    octets_put_u32(&content[4], timeout_ms);
    status_t status = put_header(TARGET_WIRE_WAIT, sizeof content);
    status          = (status == STATUS_OK) ? put(content, sizeof content) : status;
    status          = (status == STATUS_OK) ? await_answer(TARGET_WIRE_WAITED) : status;
    if (status != STATUS_OK) {
        return status;
    }
    return datagrams_has(number) ? STATUS_OK : STATUS_TIMEOUT;
}

// ---- Files ----

status_t wire_sync(const char* const path, const bool is_of_names)
{
    const size_t length = strlen(path);
    const uint8_t what  = is_of_names ? TARGET_WIRE_SYNC_NAMES : TARGET_WIRE_SYNC_CONTENT;
    if ((length == 0U) || (length > TARGET_WIRE_PATH_MAX)) {
        return STATUS_IO;
    }
    status_t status = put_header(TARGET_WIRE_SYNC, sizeof what + length);
    status          = (status == STATUS_OK) ? put(&what, sizeof what) : status;
    status          = (status == STATUS_OK) ? put((const uint8_t*)path, length) : status;
    status          = (status == STATUS_OK) ? await_answer(TARGET_WIRE_SYNCED) : status;
    if (status != STATUS_OK) {
        return status;
    }
    return wire.is_synced ? STATUS_OK : STATUS_IO;
}
