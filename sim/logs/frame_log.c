// SPDX-License-Identifier: Apache-2.0
#include "sim/logs/frame_log.h"

#include "sim/logs/record_file.h"
#include "sim/logs/write_behind.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATH_OCTETS 4096U
#define NS_PER_S 1000000000U
#define NS_PER_US 1000U
#define SECOND_DIGITS 10U // Decimal digits of the seconds and of the microseconds in a line.
#define MICROSECOND_DIGITS 6U
#define SECONDS_LOW 100000000U // The last eight digits of the seconds are below it.

#define PCAP_HEADER_OCTETS 24U
#define PCAP_FD_FRAME 0x04U

struct frame_log {
    char interface[FRAME_LOG_INTERFACE_MAX];
    write_behind_t frames;
    record_file_t text;
    record_file_t pcap;
};

static const char hexadecimal[] = "0123456789ABCDEF";

static char* put_hex(char* const text, uint32_t value, const unsigned digits)
{
    for (unsigned i = digits; i > 0U; i--) {
        text[i - 1U] = hexadecimal[value & 15U];
        value >>= 4;
    }
    return text + digits;
}

/// Convert a number below 10^8 to its eight decimal digits at once, without a loop. The first digit is in the
/// lowest octet of the result.
static uint64_t decimals(const uint32_t value)
{
    // Two numbers of four digits, then four of two, then eight of one. The products with 10486 / 2^20 and
    // 103 / 2^10 are the quotients by 100 and by 10 of all numbers that occur here.
    const uint64_t fours    = (value / 10000U) | ((uint64_t)(value % 10000U) << 32);
    const uint64_t hundreds = ((fours * 10486U) >> 20) & 0x0000007F0000007FU;
    const uint64_t twos     = hundreds + ((fours - (100U * hundreds)) << 16);
    const uint64_t tens     = ((twos * 103U) >> 10) & 0x000F000F000F000FU;
    return tens + ((twos - (10U * tens)) << 8) + 0x3030303030303030U;
}

/// Write the last `digits` (at most 8) of a number below 10^8.
static char* put_decimal(char* const text, const uint32_t value, const size_t digits)
{
    const uint64_t all = decimals(value) >> (8U * (8U - digits));
    for (size_t i = 0U; i < digits; i++) {
        text[i] = (char)(all >> (8U * i));
    }
    return text + digits;
}

/// Convert four octets, of which the first is the highest of `octets`, to eight hexadecimal digits at once,
/// without a loop.
static uint64_t hex_digits(const uint32_t octets)
{
    uint64_t nibbles = octets;
    nibbles          = (nibbles | (nibbles << 16)) & 0x0000FFFF0000FFFFU;
    nibbles          = (nibbles | (nibbles << 8)) & 0x00FF00FF00FF00FFU;
    nibbles          = (nibbles | (nibbles << 4)) & 0x0F0F0F0F0F0F0F0FU;
    // In ASCII there are 7 characters between the digit 9 and the letter A.
    const uint64_t letters = ((nibbles + 0x0606060606060606U) >> 4) & 0x0101010101010101U;
    return nibbles + 0x3030303030303030U + (letters * 7U);
}

static char* put_data(char* text, const uint8_t* const data, const size_t size)
{
    size_t i = 0U;
    for (; (i + 4U) <= size; i += 4U) {
        const uint64_t digits = hex_digits(((uint32_t)data[i] << 24) | ((uint32_t)data[i + 1U] << 16) |
                                           ((uint32_t)data[i + 2U] << 8) | data[i + 3U]);
        text[0]               = (char)(digits >> 56);
        text[1]               = (char)(digits >> 48);
        text[2]               = (char)(digits >> 40);
        text[3]               = (char)(digits >> 32);
        text[4]               = (char)(digits >> 24);
        text[5]               = (char)(digits >> 16);
        text[6]               = (char)(digits >> 8);
        text[7]               = (char)digits;
        text += 8;
    }
    for (; i < size; i++) {
        *text++ = hexadecimal[data[i] >> 4];
        *text++ = hexadecimal[data[i] & 15U];
    }
    return text;
}

static char* put_identifier(char* const text, const uint32_t id)
{
    if ((id & OSAL_CAN_ERROR) != 0U) {
        return put_hex(text, id & (OSAL_CAN_ID_MASK | OSAL_CAN_ERROR), 8U);
    }
    return ((id & OSAL_CAN_EXTENDED) != 0U) ? put_hex(text, id & OSAL_CAN_ID_MASK, 8U)
                                            : put_hex(text, id & 0x7FFU, 3U);
}

size_t frame_log_line(const osal_can_frame_t* const frame, const char* const interface, char* const text)
{
    char* end                = text;
    const uint64_t time_ns   = frame->time_ns;
    const uint32_t seconds   = (uint32_t)(time_ns / NS_PER_S);
    const uint32_t time_us   = (uint32_t)(time_ns % NS_PER_S) / NS_PER_US;
    const size_t name_octets = strlen(interface);
    *end++                   = '(';
    end                      = put_decimal(end, seconds / SECONDS_LOW, SECOND_DIGITS - 8U);
    end                      = put_decimal(end, seconds % SECONDS_LOW, 8U);
    *end++                   = '.';
    end                      = put_decimal(end, time_us, MICROSECOND_DIGITS);
    *end++                   = ')';
    *end++                   = ' ';
    memcpy(end, interface, name_octets); // NOLINT(bugprone-not-null-terminated-result): the line continues.
    end += name_octets;
    *end++ = ' ';
    end    = put_identifier(end, frame->id);
    *end++ = '#';
    if ((frame->flags & OSAL_CAN_FLAG_FD) != 0U) {
        *end++ = '#';
        *end++ = hexadecimal[frame->flags & (OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI)];
    }
    if ((frame->id & OSAL_CAN_REMOTE) != 0U) {
        *end++ = 'R';
        *end++ = hexadecimal[frame->length & 15U];
    } else {
        end = put_data(end, frame->data, frame->length);
    }
    *end++ = '\n';
    return (size_t)(end - text);
}

static uint8_t* put_u32(uint8_t* octets, uint32_t value) // Little-endian, like the magic number of the file.
{
    octets[0] = (uint8_t)value;
    octets[1] = (uint8_t)(value >> 8);
    octets[2] = (uint8_t)(value >> 16);
    octets[3] = (uint8_t)(value >> 24);
    return octets + 4;
}

/// Write the identifier of a frame, which is big-endian in the pcap format of SocketCAN.
static uint8_t* put_u32_big(uint8_t* const octets, const uint32_t value)
{
    octets[0] = (uint8_t)(value >> 24);
    octets[1] = (uint8_t)(value >> 16);
    octets[2] = (uint8_t)(value >> 8);
    octets[3] = (uint8_t)value;
    return octets + 4;
}

size_t frame_log_record(const osal_can_frame_t* const frame, uint8_t* const octets)
{
    const uint32_t data_octets = ((frame->id & OSAL_CAN_REMOTE) != 0U) ? 0U : frame->length;
    const uint32_t size        = 8U + data_octets;
    const bool is_fd           = (frame->flags & OSAL_CAN_FLAG_FD) != 0U;
    uint8_t* end               = octets;
    end                        = put_u32(end, (uint32_t)(frame->time_ns / NS_PER_S));
    end                        = put_u32(end, (uint32_t)(frame->time_ns % NS_PER_S));
    end                        = put_u32(end, size);
    end                        = put_u32(end, size);
    end                        = put_u32_big(end, frame->id);
    *end++                     = frame->length;
    *end++ = is_fd ? (uint8_t)(PCAP_FD_FRAME | (frame->flags & (OSAL_CAN_FLAG_BRS | OSAL_CAN_FLAG_ESI))) : 0U;
    *end++ = 0U;
    *end++ = 0U;
    memcpy(end, frame->data, data_octets);
    return (size_t)(end - octets) + data_octets;
}

/// Returns the octets of a frame up to the end of its data, or of eight octets of data: nearly all frames are
/// short, and a copy of constant size is faster.
static size_t size_of(const osal_can_frame_t* const frame)
{
    return offsetof(osal_can_frame_t, data) + ((frame->length <= 8U) ? 8U : frame->length);
}

void frame_log_write(frame_log_t* const log, const osal_can_frame_t* const frame)
{
    const size_t size = size_of(frame);
    uint8_t* octets   = write_behind_room(&log->frames, size);
    if (frame->length <= 8U) {
        memcpy(octets, frame, offsetof(osal_can_frame_t, data) + 8U);
    } else {
        memcpy(octets, frame, size);
    }
    write_behind_add(&log->frames, size);
}

/// Format frames and pass them to the operating system.
static void write_frames(void* const context, const uint8_t* const octets, const size_t size)
{
    frame_log_t* log       = context;
    osal_can_frame_t frame = {0};
    for (size_t at = 0U; at < size; at += size_of(&frame)) {
        memcpy(&frame, &octets[at], offsetof(osal_can_frame_t, data));
        memcpy(frame.data, &octets[at + offsetof(osal_can_frame_t, data)],
               size_of(&frame) - offsetof(osal_can_frame_t, data));
        char* const line = (char*)record_file_room(&log->text, FRAME_LOG_LINE_MAX);
        record_file_add(&log->text, frame_log_line(&frame, log->interface, line));
        uint8_t* const record = record_file_room(&log->pcap, FRAME_LOG_RECORD_MAX);
        record_file_add(&log->pcap, frame_log_record(&frame, record));
    }
    record_file_flush(&log->text);
    record_file_flush(&log->pcap);
}

void frame_log_flush(frame_log_t* const log, const bool waits)
{
    write_behind_flush(&log->frames, waits);
}

static bool open_file(record_file_t* const file, const char* const directory, const char* const interface,
                      const char* const suffix)
{
    char path[PATH_OCTETS];
    (void)snprintf(path, sizeof path, "%s/can-%s.%s", directory, interface, suffix);
    return record_file_open(file, path);
}

static void write_pcap_header(record_file_t* const file)
{
    uint8_t* end = record_file_room(file, PCAP_HEADER_OCTETS);
    end          = put_u32(end, 0xA1B23C4DU);     // Nanoseconds.
    end          = put_u32(end, 2U | (4U << 16)); // Version 2.4.
    end          = put_u32(end, 0U);
    end          = put_u32(end, 0U);
    end          = put_u32(end, 0x40000U); // Largest number of octets of a packet: that of tcpdump.
    (void)put_u32(end, 227U);              // LINKTYPE_CAN_SOCKETCAN.
    record_file_add(file, PCAP_HEADER_OCTETS);
}

/// True if all records were written.
static bool close_files(frame_log_t* const log)
{
    const bool has_text = record_file_close(&log->text);
    const bool has_pcap = record_file_close(&log->pcap);
    return has_text && has_pcap;
}

status_t frame_log_open(const char* const directory, const char* const interface, frame_log_t** const out_log)
{
    *out_log = NULL;
    if ((strlen(interface) >= FRAME_LOG_INTERFACE_MAX) || (strlen(directory) > (PATH_OCTETS - 64U))) {
        return STATUS_INVALID;
    }
    frame_log_t* log = calloc(1U, sizeof *log);
    if (log == NULL) {
        return STATUS_EXHAUSTED;
    }
    (void)strcpy(log->interface, interface);
    log->pcap.descriptor = -1;
    if (!open_file(&log->text, directory, interface, "log") ||
        !open_file(&log->pcap, directory, interface, "pcap")) {
        (void)close_files(log);
        free(log);
        return STATUS_IO;
    }
    write_pcap_header(&log->pcap);
    write_behind_open(&log->frames, write_frames, log);
    *out_log = log;
    return STATUS_OK;
}

status_t frame_log_close(frame_log_t* const log)
{
    if (log == NULL) {
        return STATUS_OK;
    }
    write_behind_close(&log->frames);
    const bool is_complete = close_files(log);
    free(log);
    return is_complete ? STATUS_OK : STATUS_IO;
}
