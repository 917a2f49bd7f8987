// SPDX-License-Identifier: Apache-2.0
#include "pus/tool/pusdump_packet.h"

#include "base/crc.h"
#include "pus/core/tailoring.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define NS_PER_S 1000000000ULL
#define NS_PER_MS 1000000ULL
#define S_PER_DAY 86400ULL
#define CODE_MASK 0xF0U
#define CUC_TAI 0x10U
#define CUC_AGENCY 0x20U
#define CDS 0x40U
#define CDS_AGENCY 0x08U
#define CDS_DAY_24 0x04U
#define LENGTH_OFFSET 7U

void dump_packet_add_problem(dump_packet_t* const packet, const char* const format, ...)
{
    const size_t used = strlen(packet->problem);
    const char* glue  = (used > 0U) ? "; " : "";
    if ((used + 8U) < PROBLEM_MAX) {
        (void)strcpy(&packet->problem[used], glue);
        va_list arguments;
        va_start(arguments, format);
        (void)vsnprintf(&packet->problem[used + strlen(glue)], PROBLEM_MAX - used - strlen(glue), format,
                        arguments);
        va_end(arguments);
    }
}

bool dump_packet_is_tai(const dump_packet_t* const packet)
{
    const unsigned code = packet->p_field & CODE_MASK;
    return (code == CUC_TAI) || ((code == CDS) && ((packet->p_field & CDS_AGENCY) == 0U));
}

static uint64_t read_number(octet_reader_t* const reader, const size_t size)
{
    uint64_t number = 0U;
    for (size_t i = 0U; i < size; i++) {
        number = (number << 8U) | octet_read_u8(reader);
    }
    return number;
}

static uint64_t read_cuc(octet_reader_t* const reader, const uint8_t p_field)
{
    const unsigned fine     = p_field & 3U;
    const uint64_t seconds  = read_number(reader, ((p_field >> 2U) & 3U) + 1U);
    const uint64_t fraction = read_number(reader, fine);
    const uint64_t half     = (fine > 0U) ? (1ULL << ((8U * fine) - 1U)) : 0U;
    return (seconds * NS_PER_S) + (((fraction * NS_PER_S) + half) >> (8U * fine));
}

static uint64_t read_cds(octet_reader_t* const reader, const uint8_t p_field)
{
    const uint64_t day          = read_number(reader, ((p_field & CDS_DAY_24) != 0U) ? 3U : 2U);
    const uint64_t milliseconds = read_number(reader, 4U);
    uint64_t time_ns            = (day * S_PER_DAY * NS_PER_S) + (milliseconds * NS_PER_MS);
    if ((p_field & 3U) == 1U) {
        time_ns += read_number(reader, 2U) * 1000U;
    } else if ((p_field & 3U) == 2U) {
        time_ns += read_number(reader, 4U) / 1000U;
    } else {
        // The time code has no field for less than a millisecond.
    }
    return time_ns;
}

status_t dump_time_read(octet_reader_t* const reader, uint8_t* const out_p_field, uint64_t* const out_time_ns)
{
    const uint8_t p_field = octet_read_u8(reader);
    const unsigned code   = p_field & CODE_MASK;
    *out_p_field          = p_field;
    *out_time_ns          = 0U;
    if (reader->failed) {
        return STATUS_TRUNCATED;
    }
    if ((code == CUC_TAI) || (code == CUC_AGENCY)) {
        *out_time_ns = read_cuc(reader, p_field);
    } else if ((code == CDS) && ((p_field & 3U) != 3U)) {
        *out_time_ns = read_cds(reader, p_field);
    } else {
        return STATUS_INVALID;
    }
    return reader->failed ? STATUS_TRUNCATED : STATUS_OK;
}

/// Check the fields of the primary header. Returns true if a secondary header must follow.
static bool check_primary(dump_packet_t* const packet, const uint16_t word0, const uint16_t word1,
                          const uint16_t length)
{
    const size_t stated = (size_t)length + LENGTH_OFFSET;
    const bool has_flag = (word0 & 0x0800U) != 0U;
    const bool may_lack_it =
        !packet->is_tc && ((packet->apid == PUS_APID_TIME) || (packet->apid == PUS_APID_IDLE));
    const unsigned version   = word0 >> 13U;
    const unsigned seq_flags = word1 >> 14U;
    const bool is_too_long   = stated > PUS_PACKET_MAX;
    if (stated != packet->size) {
        dump_packet_add_problem(packet, "length field says %zu octets, the packet has %zu", stated,
                                packet->size);
    } else if (is_too_long) {
        dump_packet_add_problem(packet, "%zu octets, largest packet is %u", stated, PUS_PACKET_MAX);
    } else {
        // The length field is right.
    }
    if (version != PUS_PACKET_VERSION) {
        dump_packet_add_problem(packet, "packet version %u, not 0", version);
    }
    if (seq_flags != PUS_UNSEGMENTED) {
        dump_packet_add_problem(packet, "sequence flags %u, not 3: segmented", seq_flags);
    }
    if (!has_flag && !may_lack_it) {
        dump_packet_add_problem(packet, "no secondary header");
    }
    return has_flag;
}

static void read_secondary(dump_packet_t* const packet, octet_reader_t* const reader)
{
    const uint8_t octet = octet_read_u8(reader);
    packet->flags       = octet & 0x0FU;
    packet->service     = octet_read_u8(reader);
    packet->subtype     = octet_read_u8(reader);
    packet->counter     = packet->is_tc ? 0U : octet_read_u16(reader);
    packet->user        = octet_read_u16(reader);
    if (reader->failed) {
        dump_packet_add_problem(packet, "ends within the secondary header");
        return;
    }
    packet->has_secondary = true;
    if ((octet >> 4U) != PUS_VERSION) {
        dump_packet_add_problem(packet, "PUS version %u, not %u", (unsigned)octet >> 4U, PUS_VERSION);
    }
    if (!packet->is_tc) {
        const status_t status = dump_time_read(reader, &packet->p_field, &packet->time_ns);
        packet->has_time      = (status == STATUS_OK);
        if (status == STATUS_INVALID) {
            dump_packet_add_problem(packet, "time code 0x%02X is not known", packet->p_field);
        } else if (status == STATUS_TRUNCATED) {
            dump_packet_add_problem(packet, "ends within the time");
        } else {
            // The packet has a time.
        }
    }
}

/// Read a packet of APID 0: it has no secondary header, but rate, time and status.
static void read_spacecraft_time(dump_packet_t* const packet, octet_reader_t* const reader)
{
    (void)octet_read_u8(reader);
    packet->has_time = (dump_time_read(reader, &packet->p_field, &packet->time_ns) == STATUS_OK);
    if (!packet->has_time) {
        dump_packet_add_problem(packet, "no time in a spacecraft time packet");
    }
    // The data that are shown are the whole field: rate, time and status.
    reader->position = PUS_PRIMARY_HEADER_SIZE;
    reader->failed   = false;
}

static void check_crc(dump_packet_t* const packet)
{
    if (packet->size < (PUS_PRIMARY_HEADER_SIZE + PUS_CRC_SIZE)) {
        return;
    }
    const size_t end        = packet->size - PUS_CRC_SIZE;
    const unsigned stated   = ((unsigned)packet->octets[end] << 8U) | packet->octets[end + 1U];
    const unsigned computed = crc16_ccitt(packet->octets, end);
    packet->has_crc         = true;
    packet->crc_is_good     = (stated == computed);
    if (stated != computed) {
        dump_packet_add_problem(packet, "checksum 0x%04X, computed 0x%04X", stated, computed);
    }
}

void dump_packet_read(const uint8_t* const octets, const size_t size, dump_packet_t* const out_packet)
{
    (void)memset(out_packet, 0, sizeof *out_packet);
    out_packet->octets      = octets;
    out_packet->size        = size;
    octet_reader_t reader   = octet_reader(octets, size);
    const uint16_t word0    = octet_read_u16(&reader);
    const uint16_t word1    = octet_read_u16(&reader);
    const uint16_t length   = octet_read_u16(&reader);
    out_packet->is_tc       = (word0 & 0x1000U) != 0U;
    out_packet->apid        = word0 & 0x07FFU;
    out_packet->sequence    = word1 & 0x3FFFU;
    out_packet->has_primary = !reader.failed;
    if (reader.failed) {
        dump_packet_add_problem(out_packet, "%zu octets are too few for a packet", size);
        return;
    }
    if (check_primary(out_packet, word0, word1, length)) {
        read_secondary(out_packet, &reader);
    } else if (out_packet->apid == PUS_APID_TIME) {
        read_spacecraft_time(out_packet, &reader);
    } else {
        // A packet without a secondary header has no further fields.
    }
    const bool is_read = !reader.failed && (out_packet->is_tc || out_packet->has_time);
    const size_t left  = octet_reader_left(&reader);
    if (is_read && (left < PUS_CRC_SIZE)) {
        dump_packet_add_problem(out_packet, "ends before the checksum");
    } else if (is_read) {
        out_packet->data_size = left - PUS_CRC_SIZE;
        out_packet->data      = octet_read_octets(&reader, out_packet->data_size);
    } else {
        // The time could not be read, so the beginning of the data is unknown: `data` stays null.
    }
    check_crc(out_packet);
}
