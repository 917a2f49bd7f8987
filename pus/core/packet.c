// SPDX-License-Identifier: Apache-2.0
#include "pus/core/packet_internal.h"

#include "base/assertion.h"
#include "base/crc.h"

#define NS_PER_S 1000000000ULL
#define TIME_FRACTIONS ((uint64_t)PUS_TIME_TICKS_PER_S)
#define SECONDS_SHIFT 24U // Shifts of the fields in the time format of the wire [bits].
#define P_FIELD_SHIFT 56U
#define RELATIVE_TIME_SIGN (1ULL << 55U)

void packet_header_read(octet_reader_t* const reader, packet_header_t* const out_header)
{
    out_header->word0 = octet_read_u16(reader);
    out_header->word1 = octet_read_u16(reader);
    (void)octet_read_u16(reader); // packet_check evaluates the length field.
    out_header->flags   = octet_read_u8(reader);
    out_header->service = octet_read_u8(reader);
    out_header->subtype = octet_read_u8(reader);
}

/// Returns the size of a packet that its length field specifies.
static size_t size_reported(const uint8_t* const octets)
{
    return (size_t)octets_u16_at(&octets[PACKET_LENGTH_FIELD]) + PACKET_LENGTH_OFFSET;
}

status_t pus_packet_frame(const uint8_t* const octets, const size_t size, size_t* const out_size)
{
    FSW_ASSERT(((octets != NULL) || (size == 0U)) && (out_size != NULL));
    *out_size = 0U;
    if (size < PUS_PRIMARY_HEADER_SIZE) {
        return STATUS_TRUNCATED;
    }
    *out_size = size_reported(octets);
    if (*out_size > PUS_PACKET_MAX) {
        return STATUS_TOO_LARGE;
    }
    return (size < *out_size) ? STATUS_TRUNCATED : STATUS_OK;
}

bool pus_packet_is_tc(const uint8_t* const octets, const size_t size)
{
    return (size > 0U) && ((octets[0] & (PACKET_TYPE_TC >> 8U)) != 0U);
}

pus_failure_t pus_failure(const uint16_t code, const uint32_t detail)
{
    return (pus_failure_t){.code = code, .instruction = 0U, .detail = detail};
}

pus_failure_t pus_no_failure(void)
{
    return pus_failure(PUS_FAILURE_NONE, 0U);
}

void pus_failure_write(octet_writer_t* const writer, const pus_failure_t* const failure)
{
    octet_write_u16(writer, failure->code);
    octet_write_u16(writer, failure->instruction);
    octet_write_u32(writer, failure->detail);
}

pus_failure_t pus_failure_read(octet_reader_t* const reader)
{
    pus_failure_t failure = {0};
    failure.code          = octet_read_u16(reader);
    failure.instruction   = octet_read_u16(reader);
    failure.detail        = octet_read_u32(reader);
    return failure;
}

/// Check size, length field and checksum; no other field of the header is evaluated.
static status_t check_frame(const uint8_t* const octets, const size_t size, const size_t least,
                            const size_t most, pus_failure_t* const out_failure)
{
    *out_failure = pus_failure(PUS_FAILURE_LENGTH, (uint32_t)size);
    if (size < least) {
        return STATUS_TRUNCATED;
    }
    if (size > most) {
        return STATUS_TOO_LARGE;
    }
    if (size_reported(octets) != size) {
        return STATUS_INVALID;
    }
    if (crc16_ccitt(octets, size) != 0U) {
        *out_failure = pus_failure(PUS_FAILURE_CHECKSUM, crc16_ccitt(octets, size - PUS_CRC_SIZE));
        return STATUS_CHECKSUM;
    }
    return STATUS_OK;
}

/// Check the other header fields.
static pus_failure_t check_header(const packet_header_t* const header, const uint16_t type)
{
    const uint32_t packet_version = (uint32_t)header->word0 >> 13U;
    const uint32_t sequence_flags = (uint32_t)header->word1 >> 14U;
    const uint32_t version        = (uint32_t)header->flags >> 4U;
    const uint32_t type_bit       = (header->word0 & PACKET_TYPE_TC) != 0U ? 1U : 0U;
    if (packet_version != PUS_PACKET_VERSION) {
        return pus_failure(PUS_FAILURE_PACKET_VERSION, packet_version);
    }
    if ((header->word0 & PACKET_TYPE_TC) != type) {
        return pus_failure(PUS_FAILURE_PACKET_TYPE, type_bit);
    }
    if ((header->word0 & PACKET_SECONDARY_HEADER) == 0U) {
        return pus_failure(PUS_FAILURE_SECONDARY_HEADER, 0U);
    }
    if (sequence_flags != PUS_UNSEGMENTED) {
        return pus_failure(PUS_FAILURE_SEQUENCE_FLAGS, sequence_flags);
    }
    if (version != PUS_VERSION) {
        return pus_failure(PUS_FAILURE_PUS_VERSION, version);
    }
    return pus_no_failure();
}

status_t packet_check(const uint8_t* const octets, const size_t size, const packet_form_t* const form,
                      const packet_header_t* const header, pus_failure_t* const out_failure)
{
    const status_t status = check_frame(octets, size, form->least, form->most, out_failure);
    if (status != STATUS_OK) {
        return status;
    }
    *out_failure = check_header(header, form->type);
    return (out_failure->code == PUS_FAILURE_NONE) ? STATUS_OK : STATUS_INVALID;
}

/// Decode a request of at most `most` octets.
static status_t decode_tc(const uint8_t* const octets, const size_t size, const size_t most,
                          pus_tc_t* const out_tc, pus_failure_t* const out_failure)
{
    FSW_ASSERT(((octets != NULL) || (size == 0U)) && (out_tc != NULL) && (out_failure != NULL));
    octet_reader_t reader = octet_reader(octets, size);
    packet_header_t header;
    packet_header_read(&reader, &header);
    out_tc->apid     = (uint16_t)(header.word0 & PACKET_APID_MASK);
    out_tc->sequence = (uint16_t)(header.word1 & PACKET_SEQUENCE_MASK);
    out_tc->ack      = (uint8_t)(header.flags & PUS_ACK_ALL);
    out_tc->service  = header.service;
    out_tc->subtype  = header.subtype;
    // In a shorter request, the octets at this position are absent or belong to the checksum.
    out_tc->source     = (size >= PUS_TC_MIN) ? octet_read_u16(&reader) : PUS_USER_GROUND;
    out_tc->request_id = ((uint32_t)header.word0 << 16U) | header.word1;
    out_tc->data       = NULL;
    out_tc->size       = 0U;

    const packet_form_t form = {.least = PUS_TC_MIN, .most = most, .type = PACKET_TYPE_TC};
    const status_t status    = packet_check(octets, size, &form, &header, out_failure);
    if (status == STATUS_OK) {
        out_tc->size = size - PUS_TC_MIN;
        out_tc->data = octet_read_octets(&reader, out_tc->size);
    }
    return status;
}

status_t pus_tc_decode(const uint8_t* const octets, const size_t size, pus_tc_t* const out_tc,
                       pus_failure_t* const out_failure)
{
    return decode_tc(octets, size, PUS_PACKET_MAX, out_tc, out_failure);
}

status_t pus_tc_decode_large(const uint8_t* const octets, const size_t size, pus_tc_t* const out_tc,
                             pus_failure_t* const out_failure)
{
    return decode_tc(octets, size, PUS_LARGE_MAX, out_tc, out_failure);
}

pus_token_t pus_token_of(const pus_tc_t* const tc)
{
    return (pus_token_t){.request_id = tc->request_id,
                         .source     = tc->source,
                         .ack        = tc->ack,
                         .service    = tc->service,
                         .subtype    = tc->subtype};
}

// Absolute time (CUC): P-field (1 octet), seconds (4) and fraction of a second (3). It is processed as one
// number of 64 bits.

void pus_time_write(octet_writer_t* const writer, const uint64_t time_ns)
{
    const uint64_t seconds  = (time_ns / NS_PER_S) & UINT32_MAX;
    const uint64_t fraction = ((time_ns % NS_PER_S) * TIME_FRACTIONS) / NS_PER_S;
    octet_write_u64(writer,
                    ((uint64_t)PUS_TIME_P_FIELD << P_FIELD_SHIFT) | (seconds << SECONDS_SHIFT) | fraction);
}

status_t pus_time_read(octet_reader_t* const reader, uint64_t* const out_time_ns)
{
    const uint64_t field    = octet_read_u64(reader);
    const uint64_t seconds  = (field >> SECONDS_SHIFT) & UINT32_MAX;
    const uint64_t fraction = field & (TIME_FRACTIONS - 1U);
    *out_time_ns            = 0U;
    if (reader->failed) {
        return STATUS_TRUNCATED;
    }
    if ((field >> P_FIELD_SHIFT) != PUS_TIME_P_FIELD) {
        return STATUS_INVALID;
    }
    // Rounded up, so that writing this time gives the same field again.
    *out_time_ns = (seconds * NS_PER_S) + (((fraction * NS_PER_S) + (TIME_FRACTIONS - 1U)) / TIME_FRACTIONS);
    return STATUS_OK;
}

int64_t pus_relative_time_read(octet_reader_t* const reader)
{
    const uint64_t high  = octet_read_u32(reader);
    const uint64_t low   = (uint64_t)octet_read_u16(reader) << 8U;
    const uint64_t ticks = (high << 24U) | low | octet_read_u8(reader);
    // 56 bits in two's complement: the highest bit has the value -2^55.
    return (int64_t)(ticks & (RELATIVE_TIME_SIGN - 1U)) - (int64_t)(ticks & RELATIVE_TIME_SIGN);
}
