// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/packet_log.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/octets.h"
#include "fsw/framework/base/text.h"
#include "pus/tailoring.h"

#include <stddef.h>
#include <string.h>

#define RECORD_HEADER 17U
#define RECORD_MAX (RECORD_HEADER + PUS_PACKET_MAX)
#define LINE_MAX_CHARACTERS (64U + (2U * PUS_PACKET_MAX))

static const char* file_of(const packet_log_strategy_t strategy)
{
    switch (strategy) {
    case PACKET_LOG_ASCII:
        return "packets.ascii";
    case PACKET_LOG_SQLITE:
        return "packets.spool";
    default:
        return "packets.ring";
    }
}

static status_t open_file(packet_log_t* const log, const packet_log_strategy_t strategy,
                          osal_file_t* const file)
{
    char path[PACKET_LOG_PATH + 32U];
    text_t text = text_in(path, sizeof path);
    text_add(&text, log->folder);
    text_add(&text, "/");
    text_add(&text, file_of(strategy));
    return osal_file_append(file, path);
}

status_t packet_log_flush(packet_log_t* const log)
{
    FSW_ASSERT(log != NULL);
    if ((log->used == 0U) || !log->is_open) {
        return STATUS_OK;
    }
    const status_t status = osal_file_write(&log->file, log->buffer, log->used);
    if (status != STATUS_OK) {
        log->is_cut[log->strategy] = true; // Where it ends nobody knows.
        log->failures += log->buffered;
    }
    log->used     = 0U;
    log->buffered = 0U;
    return status;
}

/// One record as it stands in the file; never parted between two writes. A full buffer is written first: its
/// status is the result.
static status_t buffer_record(packet_log_t* const log, const void* const octets, const size_t size)
{
    const bool is_full    = (log->used + size + 1U) > sizeof log->buffer;
    const status_t status = is_full ? packet_log_flush(log) : STATUS_OK;
    if (log->is_cut[log->strategy] && (log->strategy == PACKET_LOG_SQLITE)) {
        log->failures++;
        return STATUS_IO; // Binary records behind a cut one cannot be told apart.
    }
    if (log->is_cut[log->strategy]) {
        log->buffer[log->used] = (uint8_t)'\n'; // A cut line ends here, and counts as none.
        log->used++;
        log->is_cut[log->strategy] = false;
    }
    (void)memcpy(&log->buffer[log->used], octets, size);
    log->used += size;
    log->buffered++;
    return status;
}

static size_t encode_record(uint8_t out_record[RECORD_MAX], const uint64_t number, const uint64_t time_ns,
                            const bool is_tc, const uint8_t* const packet, const size_t size)
{
    octet_writer_t writer = octet_writer(out_record, RECORD_MAX);
    octet_write_u64(&writer, number);
    octet_write_u64(&writer, time_ns);
    octet_write_u8(&writer, (uint8_t)(is_tc ? 0U : 1U));
    octet_write_octets(&writer, packet, size);
    FSW_ASSERT(!writer.failed);
    return writer.position;
}

static status_t append_line(packet_log_t* const log, const uint8_t* const record, const size_t size)
{
    char line[LINE_MAX_CHARACTERS];
    octet_reader_t reader = octet_reader(record, size);
    text_t text           = text_in(line, sizeof line);
    text_add_unsigned(&text, octet_read_u64(&reader));
    text_add_character(&text, ' ');
    text_add_seconds(&text, octet_read_u64(&reader));
    text_add(&text, (octet_read_u8(&reader) == 0U) ? " TC " : " TM ");
    text_add_octets(&text, &record[RECORD_HEADER], size - RECORD_HEADER);
    text_add_character(&text, '\n');
    FSW_ASSERT(!text.cut);
    return buffer_record(log, line, text.length);
}

static status_t append_spool(packet_log_t* const log, const uint8_t* const record, const size_t size)
{
    uint8_t octets[4U + RECORD_MAX];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u32(&writer, (uint32_t)size);
    octet_write_octets(&writer, record, size);
    FSW_ASSERT(!writer.failed);
    return buffer_record(log, octets, writer.position);
}

static status_t append_ring(packet_log_t* const log, const uint8_t* const record, const size_t size)
{
    uint8_t oldest[RECORD_MAX];
    size_t oldest_size = 0U;
    while (octet_ring_room(&log->ring) < size) {
        const status_t status = octet_ring_take(&log->ring, oldest, sizeof oldest, &oldest_size);
        FSW_ASSERT(status == STATUS_OK);
    }
    return octet_ring_put(&log->ring, record, size);
}

status_t packet_log_append(packet_log_t* const log, const uint64_t time_ns, const bool is_tc,
                           const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((log != NULL) && (packet != NULL) && (size <= PUS_PACKET_MAX));
    uint8_t record[RECORD_MAX];
    const size_t record_size = encode_record(record, log->next_number, time_ns, is_tc, packet, size);
    log->next_number++;
    if (!log->is_open) {
        log->failures++;
        return STATUS_IO;
    }
    switch (log->strategy) {
    case PACKET_LOG_ASCII:
        return append_line(log, record, record_size);
    case PACKET_LOG_SQLITE:
        return append_spool(log, record, record_size);
    default:
        return append_ring(log, record, record_size);
    }
}

/// The ring's records, oldest first, as lines of its file.
static void write_out_ring(packet_log_t* const log)
{
    uint8_t record[RECORD_MAX];
    size_t size = 0U;
    while (octet_ring_take(&log->ring, record, sizeof record, &size) == STATUS_OK) {
        (void)append_line(log, record, size);
    }
}

static void leave_strategy(packet_log_t* const log)
{
    if (!log->is_open) {
        return;
    }
    if (log->strategy == PACKET_LOG_RING) {
        write_out_ring(log);
    }
    (void)packet_log_flush(log);
    osal_file_close(&log->file);
    log->is_open = false;
}

status_t packet_log_select(packet_log_t* const log, const packet_log_strategy_t strategy)
{
    FSW_ASSERT(log != NULL);
    if (((unsigned)strategy >= (unsigned)PACKET_LOG_STRATEGIES) || (strategy == PACKET_LOG_POSTGRESQL)) {
        return STATUS_UNSUPPORTED;
    }
    if (log->is_cut[strategy] && (strategy == PACKET_LOG_SQLITE)) {
        return STATUS_IO;
    }
    osal_file_t file      = {-1};
    const status_t status = open_file(log, strategy, &file);
    if (status != STATUS_OK) {
        return ((status == STATUS_DENIED) || (status == STATUS_NOT_FOUND)) ? status : STATUS_IO;
    }
    leave_strategy(log);
    log->file     = file;
    log->strategy = strategy;
    log->is_open  = true;
    return STATUS_OK;
}

status_t packet_log_open(packet_log_t* const log, const char* const folder,
                         const packet_log_strategy_t strategy, const uint64_t next_number)
{
    FSW_ASSERT((log != NULL) && (folder != NULL) && (next_number >= 1U));
    (void)memset(log, 0, offsetof(packet_log_t, buffer));
    log->next_number = next_number;
    octet_ring_init(&log->ring, log->ring_storage, sizeof log->ring_storage);
    text_t text = text_in(log->folder, sizeof log->folder);
    text_add(&text, folder);
    return text.cut ? STATUS_NOT_FOUND : packet_log_select(log, strategy);
}

void packet_log_close(packet_log_t* const log)
{
    FSW_ASSERT(log != NULL);
    leave_strategy(log);
}
