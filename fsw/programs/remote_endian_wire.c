// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/remote_endian_wire.h"

#include "base/assertion.h"

#include <string.h>

#define SIZE_OCTETS 4U
#define HEADER_OCTETS (SIZE_OCTETS + 1U)
#define SIZE_RUN_OCTETS                                                                                      \
    (32U + RUN_IDENTITY_MAX + (3U * RUN_PATH_MAX) + (MISSION_SUBSYSTEMS_MAX * (22U + DESCRIPTOR_NAME_MAX)) + \
     (RUN_LINKS_MAX * 6U)) ///< Largest size of the content.
/// Size of a `done`, without its frames.
#define SIZE_DONE_OCTETS (24U + (OSAL_LOCKSTEP_PARTICIPANTS_MAX * 8U))
#define NO_BUS 0xFFU ///< Ends a list of frames.
#define MORE 0xFEU   ///< Ends a list of frames that continues in the next record.
#define NS_PER_MS 1000000ULL

CAPACITY_CHECK(a_run_fits, (HEADER_OCTETS + SIZE_RUN_OCTETS) <= REMOTE_ENDIAN_RECORD_MAX);
CAPACITY_CHECK(a_turn_fits_with_a_frame, (HEADER_OCTETS + SIZE_DONE_OCTETS + REMOTE_ENDIAN_FRAME_OCTETS +
                                          1U) <= REMOTE_ENDIAN_RECORD_MAX);

// ---- Carrier ----

static status_t stream_send(remote_endian_wire_t* const wire, const uint8_t* const octets, const size_t size,
                            size_t* const out_sent)
{
    return (wire->carrier.context != NULL) ? wire->carrier.send(wire->carrier.context, octets, size, out_sent)
                                           : osal_stream_send(&wire->socket, octets, size, out_sent);
}

static status_t stream_receive(remote_endian_wire_t* const wire, uint8_t* const octets, const size_t capacity,
                               size_t* const out_size)
{
    return (wire->carrier.context != NULL)
               ? wire->carrier.receive(wire->carrier.context, octets, capacity, out_size)
               : osal_stream_receive(&wire->socket, octets, capacity, out_size);
}

static status_t stream_wait(remote_endian_wire_t* const wire, const uint32_t timeout_ms)
{
    return (wire->carrier.context != NULL) ? wire->carrier.wait_readable(wire->carrier.context, timeout_ms)
                                           : osal_socket_wait_readable(&wire->socket, timeout_ms);
}

// ---- Records ----

octet_writer_t remote_endian_begin(remote_endian_wire_t* const wire, const remote_endian_kind_t kind)
{
    FSW_ASSERT(wire != NULL);
    octet_writer_t writer = octet_writer(wire->octets, sizeof wire->octets);
    (void)octet_write_space(&writer, SIZE_OCTETS); // remote_endian_send writes the size here.
    octet_write_u8(&writer, (uint8_t)kind);
    return writer;
}

status_t remote_endian_send(remote_endian_wire_t* const wire, const octet_writer_t* const writer)
{
    FSW_ASSERT((wire != NULL) && (writer != NULL));
    if (writer->failed) {
        return STATUS_TOO_LARGE;
    }
    octets_put_u32(wire->octets, (uint32_t)(writer->position - SIZE_OCTETS));
    size_t sent     = 0U;
    status_t status = STATUS_OK;
    while ((sent < writer->position) && (status == STATUS_OK)) {
        size_t size = 0U;
        status      = stream_send(wire, &wire->octets[sent], writer->position - sent, &size);
        sent += size;
        // The peer will read the rest, because it waits for this record. Until then it sends nothing: if the
        // stream becomes readable, the peer has closed it.
        if (status == STATUS_FULL) {
            const status_t waited = stream_wait(wire, 1U);
            status                = (waited == STATUS_TIMEOUT) ? STATUS_OK : STATUS_CLOSED;
        }
    }
    // Both directions use the same buffer: it is free for the answer now.
    wire->received = 0U;
    return status;
}

/// Returns the number of missing octets of the record, including its size field; 0 if the record is
/// complete, or its size is invalid.
static size_t missing_octets(const remote_endian_wire_t* const wire)
{
    if (wire->received < SIZE_OCTETS) {
        return SIZE_OCTETS - wire->received;
    }
    const uint32_t size = octets_u32_at(wire->octets);
    const bool is_good  = (size >= 1U) && (size <= (sizeof wire->octets - SIZE_OCTETS));
    return is_good ? ((SIZE_OCTETS + (size_t)size) - wire->received) : 0U;
}

/// Read the available octets of a record. STATUS_OK (complete, or invalid), STATUS_EMPTY, STATUS_CLOSED,
/// STATUS_IO.
static status_t take_in(remote_endian_wire_t* const wire)
{
    status_t status = STATUS_OK;
    while ((missing_octets(wire) > 0U) && (status == STATUS_OK)) {
        size_t size = 0U;
        status      = stream_receive(wire, &wire->octets[wire->received], missing_octets(wire), &size);
        wire->received += size;
    }
    return status;
}

status_t remote_endian_receive(remote_endian_wire_t* const wire, const remote_endian_kind_t kind,
                               const uint32_t timeout_ms, octet_reader_t* const out_reader)
{
    FSW_ASSERT((wire != NULL) && (out_reader != NULL));
    const uint64_t until_ns = osal_clock_monotonic_ns() + ((uint64_t)timeout_ms * NS_PER_MS);
    status_t status         = take_in(wire);
    while (status == STATUS_EMPTY) {
        const uint64_t now_ns = osal_clock_monotonic_ns();
        if (now_ns >= until_ns) {
            return STATUS_TIMEOUT;
        }
        const status_t waited = stream_wait(wire, (uint32_t)(((until_ns - now_ns) / NS_PER_MS) + 1U));
        (void)waited; // Only the status of the read matters.
        status = take_in(wire);
    }
    if (status != STATUS_OK) {
        return status;
    }
    const uint32_t size = octets_u32_at(wire->octets);
    if ((wire->received < HEADER_OCTETS) || (wire->octets[SIZE_OCTETS] != (uint8_t)kind)) {
        return STATUS_INVALID;
    }
    *out_reader    = octet_reader(&wire->octets[HEADER_OCTETS], (size_t)size - 1U);
    wire->received = 0U;
    return STATUS_OK;
}

// ---- The run ----

static void write_text(octet_writer_t* const writer, const char* const text)
{
    const size_t length = strlen(text);
    octet_write_u16(writer, (uint16_t)length);
    octet_write_octets(writer, (const uint8_t*)text, length);
}

static bool read_text(octet_reader_t* const reader, char* const out_text, const size_t capacity)
{
    const size_t length         = octet_read_u16(reader);
    const uint8_t* const octets = (length < capacity) ? octet_read_octets(reader, length) : NULL;
    if (octets == NULL) {
        return false;
    }
    (void)memcpy(out_text, octets, length);
    out_text[length] = '\0';
    return true;
}

void remote_endian_write_run(octet_writer_t* const writer, const run_state_t* const run,
                             const unsigned component, const char* const storage)
{
    FSW_ASSERT((writer != NULL) && (run != NULL) && (component < run->component_count) && (storage != NULL));
    write_text(writer, run->identity);
    write_text(writer, run->mission_path);
    write_text(writer, run->directory);
    write_text(writer, storage);
    octet_write_u64(writer, run->mission_hash);
    octet_write_u32(writer, component);
    octet_write_u8(writer, run->link_methods);
    octet_write_u32(writer, run->computer_ipv4[0]);
    octet_write_u16(writer, run->component_count);
    for (unsigned i = 0U; i < run->component_count; i++) {
        const run_component_t* const one = &run->components[i];
        octet_write_u16(writer, one->apid);
        write_text(writer, one->name);
        octet_write_u32(writer, (uint32_t)one->message_descriptor);
        octet_write_u16(writer, one->message_port);
        octet_write_u32(writer, one->message_window);
        octet_write_u32(writer, one->life);
        octet_write_u32(writer, one->link_floor);
    }
    for (unsigned i = 0U; i < RUN_LINKS_MAX; i++) {
        octet_write_u32(writer, (uint32_t)run->link_descriptors[i]);
        octet_write_u16(writer, run->link_ports[i]);
    }
}

bool remote_endian_read_run(octet_reader_t* const reader, run_state_t* const out_run,
                            unsigned* const out_component)
{
    FSW_ASSERT((reader != NULL) && (out_run != NULL) && (out_component != NULL));
    *out_run     = (run_state_t){.is_stepped = true, .transport = (uint8_t)RUN_TRANSPORT_UDP};
    bool is_good = read_text(reader, out_run->identity, sizeof out_run->identity) &&
                   read_text(reader, out_run->mission_path, sizeof out_run->mission_path) &&
                   read_text(reader, out_run->directory, sizeof out_run->directory) &&
                   read_text(reader, out_run->storage, sizeof out_run->storage);
    out_run->mission_hash      = octet_read_u64(reader);
    *out_component             = octet_read_u32(reader);
    out_run->link_methods      = octet_read_u8(reader);
    out_run->computer_count    = 1U;
    out_run->computer_ipv4[0]  = octet_read_u32(reader);
    out_run->ground_descriptor = -1;
    out_run->component_count   = octet_read_u16(reader);
    is_good                    = is_good && (out_run->component_count <= MISSION_SUBSYSTEMS_MAX) &&
              (*out_component < out_run->component_count);
    for (unsigned i = 0U; is_good && (i < out_run->component_count); i++) {
        run_component_t* const one = &out_run->components[i];
        one->apid                  = octet_read_u16(reader);
        is_good                    = read_text(reader, one->name, sizeof one->name);
        one->message_descriptor    = (int)octet_read_u32(reader);
        one->message_port          = octet_read_u16(reader);
        one->message_window        = octet_read_u32(reader);
        one->life                  = octet_read_u32(reader);
        one->link_floor            = octet_read_u32(reader);
    }
    for (unsigned i = 0U; i < RUN_LINKS_MAX; i++) {
        out_run->link_descriptors[i] = (int)octet_read_u32(reader);
        out_run->link_ports[i]       = octet_read_u16(reader);
    }
    return is_good && octet_reader_is_done(reader);
}

// ---- A turn ----

void remote_endian_write_done(octet_writer_t* const writer, const remote_endian_done_t* const done)
{
    FSW_ASSERT((writer != NULL) && (done != NULL));
    octet_write_u64(writer, done->wake_ns);
    octet_write_u32(writer, done->opened);
    octet_write_u8(writer, done->is_lossy ? 1U : 0U);
    for (unsigned i = 0U; i < OSAL_LOCKSTEP_PARTICIPANTS_MAX; i++) {
        octet_write_u32(writer, done->deliveries.lives[i]);
        octet_write_u32(writer, done->deliveries.messages[i]);
        octet_write_u32(writer, done->deliveries.octets[i]);
    }
}

bool remote_endian_read_done(octet_reader_t* const reader, remote_endian_done_t* const out_done)
{
    FSW_ASSERT((reader != NULL) && (out_done != NULL));
    out_done->wake_ns  = octet_read_u64(reader);
    out_done->opened   = octet_read_u32(reader);
    out_done->is_lossy = (octet_read_u8(reader) != 0U);
    for (unsigned i = 0U; i < OSAL_LOCKSTEP_PARTICIPANTS_MAX; i++) {
        out_done->deliveries.lives[i]    = octet_read_u32(reader);
        out_done->deliveries.messages[i] = octet_read_u32(reader);
        out_done->deliveries.octets[i]   = octet_read_u32(reader);
    }
    return !reader->failed;
}

void remote_endian_write_grant(octet_writer_t* const writer, const osal_grant_t* const grant,
                               const run_state_t* const run)
{
    FSW_ASSERT((writer != NULL) && (grant != NULL) && (run != NULL));
    octet_write_u64(writer, grant->now_ns);
    octet_write_u32(writer, grant->messages);
    octet_write_u32(writer, grant->octets);
    for (unsigned i = 0U; i < run->component_count; i++) {
        octet_write_u32(writer, run->components[i].life);
        octet_write_u32(writer, run->components[i].link_floor);
    }
}

bool remote_endian_read_grant(octet_reader_t* const reader, osal_grant_t* const out_grant,
                              run_state_t* const run)
{
    FSW_ASSERT((reader != NULL) && (out_grant != NULL) && (run != NULL));
    out_grant->now_ns   = octet_read_u64(reader);
    out_grant->messages = octet_read_u32(reader);
    out_grant->octets   = octet_read_u32(reader);
    for (unsigned i = 0U; i < run->component_count; i++) {
        run->components[i].life       = octet_read_u32(reader);
        run->components[i].link_floor = octet_read_u32(reader);
    }
    return !reader->failed;
}

/// True if the writer has room for one more frame and the end of the list.
static bool has_room(const octet_writer_t* const writer)
{
    return (writer->position + REMOTE_ENDIAN_FRAME_OCTETS + 1U) <= REMOTE_ENDIAN_RECORD_MAX;
}

/// Write the frames received at the ends, as many as fit. Returns false if some may be left.
static bool write_frames(octet_writer_t* const writer, remote_endian_buses_t* const buses)
{
    for (unsigned bus = 0U; bus < MISSION_BUSES_MAX; bus++) {
        const bool is_open = ((buses->open & (1U << bus)) != 0U);
        osal_can_frame_t frame;
        while (is_open && has_room(writer) && (osal_can_receive(&buses->ends[bus], &frame) == STATUS_OK)) {
            octet_write_u8(writer, (uint8_t)bus);
            octet_write_u64(writer, frame.time_ns);
            octet_write_u32(writer, frame.id);
            octet_write_u8(writer, frame.flags);
            octet_write_u8(writer, frame.length);
            octet_write_octets(writer, frame.data, frame.length);
        }
    }
    const bool is_whole = has_room(writer);
    octet_write_u8(writer, is_whole ? NO_BUS : MORE);
    return is_whole;
}

status_t remote_endian_send_frames(remote_endian_wire_t* const wire, octet_writer_t* const writer,
                                   remote_endian_buses_t* const buses)
{
    FSW_ASSERT((wire != NULL) && (writer != NULL) && (buses != NULL));
    const remote_endian_kind_t kind = (remote_endian_kind_t)wire->octets[SIZE_OCTETS];
    bool is_whole                   = write_frames(writer, buses);
    status_t status                 = remote_endian_send(wire, writer);
    while (!is_whole && (status == STATUS_OK)) {
        *writer  = remote_endian_begin(wire, kind);
        is_whole = write_frames(writer, buses);
        status   = remote_endian_send(wire, writer);
    }
    return status;
}

bool remote_endian_read_frames(octet_reader_t* const reader, remote_endian_buses_t* const buses,
                               bool* const out_more)
{
    FSW_ASSERT((reader != NULL) && (buses != NULL) && (out_more != NULL));
    unsigned bus = octet_read_u8(reader);
    while (!reader->failed && (bus != NO_BUS) && (bus != MORE)) {
        osal_can_frame_t frame      = {.time_ns = octet_read_u64(reader)};
        frame.id                    = octet_read_u32(reader);
        frame.flags                 = octet_read_u8(reader);
        frame.length                = octet_read_u8(reader);
        const uint8_t* const octets = octet_read_octets(reader, frame.length);
        if ((octets == NULL) || (frame.length > OSAL_CAN_DATA_MAX) || (bus >= MISSION_BUSES_MAX) ||
            ((buses->open & (1U << bus)) == 0U)) {
            return false;
        }
        (void)memcpy(frame.data, octets, frame.length);
        buses->refused += (osal_can_send(&buses->ends[bus], &frame) == STATUS_OK) ? 0U : 1U;
        bus = octet_read_u8(reader);
    }
    *out_more = (bus == MORE);
    return octet_reader_is_done(reader);
}
