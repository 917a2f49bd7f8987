// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/packet_log.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/capacities.h"
#include "fsw/framework/base/octets.h"
#include "fsw/framework/base/text.h"
#include "osal/include/osal/clock.h"
#include "pus/tailoring.h"

#include <stddef.h>
#include <string.h>

#define LENGTH_OCTETS 4U
#define RECORD_HEADER 17U
#define RECORD_MAX (RECORD_HEADER + PUS_PACKET_MAX)
#define RECORD_SHORT (RECORD_HEADER + PUS_TC_MIN) ///< With the shortest packet.
#define LINE_MAX_CHARACTERS (64U + (2U * PUS_PACKET_MAX))
#define DIRECTION_TC 0U
#define DIRECTION_TM 1U
#define DIRECTION_GAP 2U

#define PAUSE_FIRST_NS 1000000000ULL
#define PAUSE_LAST_NS 32000000000ULL
#define HEALTHY_NS 60000000000ULL ///< After so long without a failure the first pause counts again.
#define LOOK_NS 1000000000ULL     ///< Between looks whether the file still has its name.
#define DRAIN_RECORDS 512U        ///< Of the ring, into the file in one step.

CAPACITY_CHECK(ring_holds_what_a_mission_may_ask_for,
               PACKET_LOG_RING_OCTETS >= (CAPACITY_RING_RECORDS * (LENGTH_OCTETS + RECORD_SHORT)));
CAPACITY_CHECK(a_line_fits, PACKET_LOG_BUFFER > LINE_MAX_CHARACTERS);

// ---- Records ----

static size_t encode_record(uint8_t out_record[RECORD_MAX], const uint64_t number, const uint64_t time_ns,
                            const uint8_t direction, const uint8_t* const packet, const size_t size)
{
    octet_writer_t writer = octet_writer(out_record, RECORD_MAX);
    octet_write_u64(&writer, number);
    octet_write_u64(&writer, time_ns);
    octet_write_u8(&writer, direction);
    octet_write_octets(&writer, packet, size);
    FSW_ASSERT(!writer.failed);
    return writer.position;
}

static void add_line(text_t* const text, const uint8_t* const record, const size_t size)
{
    octet_reader_t reader   = octet_reader(record, size);
    const uint64_t number   = octet_read_u64(&reader);
    const uint64_t time_ns  = octet_read_u64(&reader);
    const uint8_t direction = octet_read_u8(&reader);
    text_add_unsigned(text, number);
    text_add_character(text, ' ');
    if (direction == DIRECTION_GAP) {
        text_add_unsigned(text, time_ns); // The last number.
        text_add(text, " GAP");
    } else {
        text_add_seconds(text, time_ns);
        text_add(text, (direction == DIRECTION_TC) ? " TC " : " TM ");
        text_add_octets(text, &record[RECORD_HEADER], size - RECORD_HEADER);
    }
    text_add_character(text, '\n');
    FSW_ASSERT(!text->cut);
}

// ---- Files ----

static void path_of(const packet_log_t* const log, const packet_log_strategy_t strategy,
                    char out_path[PACKET_LOG_PATH + 32U])
{
    static const char* const names[PACKET_LOG_STRATEGIES] = {"packets.ascii", "packets.spool", "",
                                                             "packets.ring"};
    text_t text                                           = text_in(out_path, PACKET_LOG_PATH + 32U);
    text_add(&text, log->folder);
    text_add(&text, "/");
    text_add(&text, names[strategy]);
    FSW_ASSERT(!text.cut); // The folder was measured when the log was opened.
}

/// Open a strategy's file behind its last whole record. STATUS_OK, STATUS_NOT_FOUND, STATUS_DENIED,
/// STATUS_IO.
static status_t open_file(packet_log_t* const log, const packet_log_strategy_t strategy,
                          osal_file_t* const file, uint64_t* const out_size)
{
    char path[PACKET_LOG_PATH + 32U];
    path_of(log, strategy, path);
    status_t status = osal_file_append(file, path);
    if (status != STATUS_OK) {
        return status;
    }
    status = osal_file_size(file, out_size);
    if ((status == STATUS_OK) && log->is_cut[strategy] && (*out_size > log->whole[strategy])) {
        status    = osal_file_resize(file, log->whole[strategy]);
        *out_size = log->whole[strategy];
    }
    if (status != STATUS_OK) {
        osal_file_close(file);
        return STATUS_IO;
    }
    log->is_cut[strategy] = false;
    return STATUS_OK;
}

/// Whole records; if they do not fit, none of them.
static status_t write_whole(packet_log_t* const log, const packet_log_strategy_t strategy,
                            const void* const octets, const size_t size)
{
    const uint64_t start_ns = osal_clock_monotonic_ns();
    status_t status         = osal_file_write(&log->file, octets, size);
    const uint64_t took_ns  = osal_clock_monotonic_ns() - start_ns;
    log->slowest_ns         = (took_ns > log->slowest_ns) ? took_ns : log->slowest_ns;
    if (status == STATUS_OK) {
        log->size += size;
    } else if (osal_file_resize(&log->file, log->size) != STATUS_OK) {
        log->is_cut[strategy] = true;
        log->whole[strategy]  = log->size;
    } else {
        // It ends with its last whole record.
    }
    return status;
}

static void close_file(packet_log_t* const log)
{
    if (log->is_open) {
        osal_file_close(&log->file);
        log->is_open = false;
    }
}

// ---- Ring ----

/// Number of the oldest record in the ring, or of the next one.
static uint64_t oldest_number(const packet_log_t* const log)
{
    uint8_t number[8];
    size_t size           = 0U;
    const status_t status = octet_ring_peek(&log->ring, number, sizeof number, &size);
    return (status == STATUS_OK) ? octets_u64_at(number) : log->next_number;
}

static void append_ring(packet_log_t* const log, const uint8_t* const record, const size_t size)
{
    uint8_t oldest[RECORD_MAX];
    size_t oldest_size = 0U;
    while ((octet_ring_room(&log->ring) < size) || (log->ring.blocks >= log->ring_records)) {
        const status_t status = octet_ring_take(&log->ring, oldest, sizeof oldest, &oldest_size);
        FSW_ASSERT(status == STATUS_OK);
        log->failures += (log->wanted == PACKET_LOG_RING) ? 0U : 1U; // Else that is how a ring is.
    }
    const status_t status = octet_ring_put(&log->ring, record, size);
    FSW_ASSERT(status == STATUS_OK);
}

/// From here on the ring stands in for the file.
static void fall_back(packet_log_t* const log)
{
    const bool was_healthy =
        (log->strategy == log->wanted) && ((log->now_ns - log->resumed_ns) >= HEALTHY_NS);
    close_file(log);
    log->pause_ns     = was_healthy ? PAUSE_FIRST_NS : (log->pause_ns * 2U);
    log->pause_ns     = (log->pause_ns < PAUSE_FIRST_NS) ? PAUSE_FIRST_NS : log->pause_ns;
    log->pause_ns     = (log->pause_ns > PAUSE_LAST_NS) ? PAUSE_LAST_NS : log->pause_ns;
    log->retry_ns     = log->now_ns + log->pause_ns;
    log->strategy     = PACKET_LOG_RING;
    log->first_number = oldest_number(log);
}

// ---- Buffer ----

static uint32_t length_at(const packet_log_t* const log, const size_t position)
{
    return octets_u32_at(&log->buffer[position]);
}

/// Records from `position` on as lines, as many as the text takes. Returns where the next one begins.
static size_t make_lines(packet_log_t* const log, size_t position, text_t* const out_text)
{
    *out_text = text_in(log->lines, sizeof log->lines);
    while ((position < log->used) && ((out_text->length + LINE_MAX_CHARACTERS) <= sizeof log->lines)) {
        const uint32_t size = length_at(log, position);
        add_line(out_text, &log->buffer[position + LENGTH_OCTETS], size);
        position += LENGTH_OCTETS + size;
    }
    return position;
}

/// Hand over what is buffered. Returns where the first record begins that was not taken.
static size_t write_buffer(packet_log_t* const log)
{
    size_t done     = 0U;
    status_t status = STATUS_OK;
    while ((done < log->used) && (status == STATUS_OK)) {
        size_t next = log->used;
        if (log->strategy == PACKET_LOG_SQLITE) {
            status = write_whole(log, log->strategy, log->buffer, log->used);
        } else {
            text_t text;
            next   = make_lines(log, done, &text);
            status = write_whole(log, log->strategy, log->lines, text.length);
        }
        done = (status == STATUS_OK) ? next : done;
    }
    return done;
}

/// Hand over what is buffered; what is not taken goes to the ring.
static void flush(packet_log_t* const log)
{
    if (log->used == 0U) {
        return;
    }
    const size_t done = write_buffer(log);
    for (size_t position = done; position < log->used; position += LENGTH_OCTETS + length_at(log, position)) {
        append_ring(log, &log->buffer[position + LENGTH_OCTETS], length_at(log, position));
    }
    const bool is_whole = (done == log->used);
    log->written_number =
        (is_whole ? log->next_number : octets_u64_at(&log->buffer[done + LENGTH_OCTETS])) - 1U;
    log->used = 0U;
    if (!is_whole) {
        fall_back(log);
    }
}

static void append_buffer(packet_log_t* const log, const uint8_t* const record, const size_t size)
{
    octet_writer_t writer = octet_writer(&log->buffer[log->used], sizeof log->buffer - log->used);
    octet_write_u32(&writer, (uint32_t)size);
    octet_write_octets(&writer, record, size);
    FSW_ASSERT(!writer.failed);
    log->used += writer.position;
}

void packet_log_append(packet_log_t* const log, const uint64_t time_ns, const bool is_tc,
                       const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((log != NULL) && (packet != NULL) && (size <= PUS_PACKET_MAX));
    uint8_t record[RECORD_MAX];
    const size_t record_size = encode_record(record, log->next_number, time_ns,
                                             (uint8_t)(is_tc ? DIRECTION_TC : DIRECTION_TM), packet, size);
    log->now_ns              = time_ns;
    if ((log->strategy != PACKET_LOG_RING) &&
        ((log->used + LENGTH_OCTETS + record_size) > sizeof log->buffer)) {
        flush(log);
    }
    if (log->strategy == PACKET_LOG_RING) {
        append_ring(log, record, record_size);
    } else {
        append_buffer(log, record, record_size);
    }
    log->next_number++;
}

// ---- From the ring into a file ----

/// One record at a time: what is not taken stays in the ring, in its order.
static status_t write_record(packet_log_t* const log, const packet_log_strategy_t strategy,
                             const uint8_t* const record, const size_t size)
{
    if (strategy == PACKET_LOG_SQLITE) {
        uint8_t octets[LENGTH_OCTETS + RECORD_MAX];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        octet_write_u32(&writer, (uint32_t)size);
        octet_write_octets(&writer, record, size);
        return write_whole(log, strategy, octets, writer.position);
    }
    text_t text = text_in(log->lines, sizeof log->lines);
    add_line(&text, record, size);
    return write_whole(log, strategy, log->lines, text.length);
}

static status_t write_gap(packet_log_t* const log, const packet_log_strategy_t strategy)
{
    uint8_t record[RECORD_MAX];
    const uint64_t first = log->written_number + 1U;
    const uint64_t next  = oldest_number(log);
    if (first >= next) {
        return STATUS_OK;
    }
    const size_t size     = encode_record(record, first, next - 1U, DIRECTION_GAP, record, 0U);
    const status_t status = write_record(log, strategy, record, size);
    log->written_number   = (status == STATUS_OK) ? (next - 1U) : log->written_number;
    return status;
}

static status_t drain(packet_log_t* const log, const packet_log_strategy_t strategy, const uint32_t most)
{
    uint8_t record[RECORD_MAX];
    size_t size     = 0U;
    status_t status = write_gap(log, strategy);
    for (uint32_t i = 0U; (i < most) && (status == STATUS_OK) &&
                          (octet_ring_peek(&log->ring, record, sizeof record, &size) == STATUS_OK);
         i++) {
        status = write_record(log, strategy, record, size);
        if (status == STATUS_OK) {
            log->written_number = octets_u64_at(record);
            status              = octet_ring_take(&log->ring, record, sizeof record, &size);
        }
    }
    return status;
}

/// The file at hand takes what is in the ring; when all is in it, it is in force.
static void go_on(packet_log_t* const log, const uint32_t most)
{
    if (drain(log, log->wanted, most) != STATUS_OK) {
        fall_back(log);
    } else if (log->ring.blocks == 0U) {
        log->strategy     = log->wanted;
        log->first_number = log->file_first;
        log->resumed_ns   = log->now_ns;
        log->looked_ns    = log->now_ns;
    } else {
        // The rest at the next step.
    }
}

static void try_again(packet_log_t* const log)
{
    if (!log->is_open) {
        log->is_open    = (open_file(log, log->wanted, &log->file, &log->size) == STATUS_OK);
        log->file_first = oldest_number(log);
    }
    if (log->is_open) {
        go_on(log, DRAIN_RECORDS);
    } else {
        fall_back(log);
    }
}

void packet_log_step(packet_log_t* const log, const uint64_t now_ns)
{
    FSW_ASSERT(log != NULL);
    log->now_ns = now_ns;
    flush(log);
    if (log->strategy != log->wanted) {
        if (log->is_open || (now_ns >= log->retry_ns)) {
            try_again(log);
        }
    } else if (log->is_open && (now_ns >= (log->looked_ns + LOOK_NS))) {
        log->looked_ns = now_ns;
        if (!osal_file_is_named(&log->file)) { // Removed: what is written there is lost.
            fall_back(log);
        }
    } else {
        // All is as it should be.
    }
}

// ---- Selection ----

status_t packet_log_select(packet_log_t* const log, const packet_log_strategy_t strategy)
{
    FSW_ASSERT(log != NULL);
    if (((unsigned)strategy >= (unsigned)PACKET_LOG_STRATEGIES) || (strategy == PACKET_LOG_POSTGRESQL)) {
        return STATUS_UNSUPPORTED;
    }
    flush(log);
    if (strategy == PACKET_LOG_RING) {
        close_file(log);
        log->wanted       = PACKET_LOG_RING;
        log->strategy     = PACKET_LOG_RING;
        log->first_number = oldest_number(log);
        return STATUS_OK;
    }
    osal_file_t file      = {-1};
    uint64_t size         = 0U;
    const status_t status = open_file(log, strategy, &file, &size);
    if (status != STATUS_OK) {
        return status;
    }
    close_file(log);
    log->file       = file;
    log->size       = size;
    log->is_open    = true;
    log->wanted     = strategy;
    log->file_first = oldest_number(log);
    go_on(log, UINT32_MAX);
    return STATUS_OK;
}

status_t packet_log_open_after(packet_log_t* const log, const char* const folder,
                               const packet_log_strategy_t strategy, const packet_log_past_t* const past,
                               const uint32_t ring_records)
{
    FSW_ASSERT((log != NULL) && (folder != NULL) && (past != NULL) && (past->next_number >= 1U) &&
               (past->written_number < past->next_number) && (ring_records >= 1U));
    (void)memset(log, 0, offsetof(packet_log_t, buffer));
    log->strategy       = PACKET_LOG_RING;
    log->wanted         = PACKET_LOG_RING;
    log->next_number    = past->next_number;
    log->written_number = past->written_number;
    log->ring_records   = ring_records;
    if ((unsigned)strategy < (unsigned)PACKET_LOG_STRATEGIES) {
        log->is_cut[strategy] = true;
        log->whole[strategy]  = past->size;
    }
    octet_ring_init(&log->ring, log->ring_storage, sizeof log->ring_storage);
    if (past->ring_octets > 0U) {
        octet_ring_refill(&log->ring, past->ring, past->ring_octets);
    }
    log->first_number = oldest_number(log);
    text_t text       = text_in(log->folder, sizeof log->folder);
    text_add(&text, folder);
    const status_t status = text.cut ? STATUS_NOT_FOUND : packet_log_select(log, strategy);
    if (text.cut || (status == STATUS_OK) || (status == STATUS_UNSUPPORTED)) {
        return status;
    }
    log->wanted = strategy;
    fall_back(log);
    return STATUS_OK;
}

status_t packet_log_open(packet_log_t* const log, const char* const folder,
                         const packet_log_strategy_t strategy, const uint64_t next_number,
                         const uint32_t ring_records)
{
    const packet_log_past_t past = {next_number, next_number - 1U, UINT64_MAX, NULL, 0U};
    return packet_log_open_after(log, folder, strategy, &past, ring_records);
}

void packet_log_abandon(packet_log_t* const log)
{
    FSW_ASSERT(log != NULL);
    close_file(log);
}

void packet_log_close(packet_log_t* const log)
{
    FSW_ASSERT(log != NULL);
    flush(log);
    if ((log->strategy != log->wanted) &&
        (log->is_open || (open_file(log, log->wanted, &log->file, &log->size) == STATUS_OK))) {
        log->is_open = true;
        go_on(log, UINT32_MAX);
    }
    close_file(log);
    if ((log->strategy == PACKET_LOG_RING) &&
        (open_file(log, PACKET_LOG_RING, &log->file, &log->size) == STATUS_OK)) {
        log->is_open          = true;
        const status_t status = drain(log, PACKET_LOG_RING, UINT32_MAX);
        (void)status; // What is left in the ring is counted.
        close_file(log);
    }
    log->failures += log->ring.blocks;
}
