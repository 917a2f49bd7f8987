// SPDX-License-Identifier: Apache-2.0
#include "pus/st09/st09_time.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "generated/pus/st09_request_formats.h"

#define RECORD_KEY 0U
#define HEADER_WORD 0x0000U // A report of APID 0 without secondary header.
#define SEQUENCE_FLAGS 0xC000U
#define SEQUENCE_MASK 0x3FFFU
#define LENGTH_OFFSET 7U // Size of a packet minus the value of its length field [octets].
#define BODY_SIZE (PUS_TIME_PACKET_SIZE - PUS_CRC_SIZE)

#define NS_PER_S 1000000000ULL
#define NS_PER_MS 1000000ULL
#define NS_PER_US 1000ULL
#define US_PER_MS 1000U
#define MS_PER_S 1000ULL
#define S_PER_DAY 86400ULL
#define MS_PER_DAY (S_PER_DAY * MS_PER_S)
#define DAYS_MASK 0xFFFFU

void pus_time_init(pus_time_t* const time, const pus_time_config_t* const config)
{
    FSW_ASSERT((time != NULL) && (config != NULL) && (config->port.send != NULL) &&
               ((config->exponent <= PUS_TIME_EXPONENT_MAX) || (config->exponent == PUS_TIME_NO_REPORTS)));
    *time = (pus_time_t){.config = *config, .exponent = config->exponent, .period = UINT64_MAX};
}

status_t pus_time_restore(pus_time_t* const time, const uint32_t key, const uint8_t* const octets,
                          const size_t size)
{
    FSW_ASSERT((time != NULL) && ((octets != NULL) || (size == 0U)));
    if (key != RECORD_KEY) {
        return STATUS_NOT_FOUND;
    }
    if ((size != 1U) || (octets[0] > PUS_TIME_EXPONENT_MAX)) {
        return STATUS_INVALID;
    }
    time->exponent = octets[0];
    return STATUS_OK;
}

static uint64_t absolute_ns(const pus_time_t* const time, const uint64_t now_ns)
{
    return (time->config.epoch_s * NS_PER_S) + now_ns;
}

static uint64_t period_ns(const pus_time_t* const time)
{
    return NS_PER_S << time->exponent;
}

static bool is_due(const pus_time_t* const time, const uint64_t now_ns)
{
    return (time->exponent <= PUS_TIME_EXPONENT_MAX) &&
           ((absolute_ns(time, now_ns) / period_ns(time)) != time->period);
}

uint64_t pus_time_due_ns(const pus_time_t* const time, const uint64_t now_ns)
{
    FSW_ASSERT(time != NULL);
    if (time->exponent > PUS_TIME_EXPONENT_MAX) {
        return UINT64_MAX;
    }
    const uint64_t passed_ns = absolute_ns(time, now_ns) % period_ns(time);
    return is_due(time, now_ns) ? now_ns : (now_ns + (period_ns(time) - passed_ns));
}

/// Write a CDS time: days, milliseconds of the day and microseconds of the millisecond. It is rounded down to
/// 1 us.
static void write_cds(octet_writer_t* const writer, const uint64_t time_ns)
{
    const uint64_t ms = time_ns / NS_PER_MS;
    octet_write_u16(writer, (uint16_t)((ms / MS_PER_DAY) & DAYS_MASK));
    octet_write_u32(writer, (uint32_t)(ms % MS_PER_DAY));
    octet_write_u16(writer, (uint16_t)((time_ns / NS_PER_US) % US_PER_MS));
}

void pus_time_step(pus_time_t* const time, const uint64_t now_ns)
{
    FSW_ASSERT(time != NULL);
    if (!is_due(time, now_ns)) {
        return;
    }
    uint8_t packet[PUS_TIME_PACKET_SIZE];
    octet_writer_t writer = octet_writer(packet, sizeof packet);
    octet_write_u16(&writer, HEADER_WORD);
    octet_write_u16(&writer, (uint16_t)(SEQUENCE_FLAGS | time->sequence));
    octet_write_u16(&writer, (uint16_t)(PUS_TIME_PACKET_SIZE - LENGTH_OFFSET));
    octet_write_u8(&writer, time->exponent);
    if (time->config.format == PUS_TIME_CUC) {
        pus_time_write(&writer, absolute_ns(time, now_ns));
    } else {
        write_cds(&writer, absolute_ns(time, now_ns));
    }
    octet_write_u8(&writer, time->config.status);
    octet_write_u16(&writer, crc16_ccitt(packet, BODY_SIZE));
    FSW_ASSERT(!writer.failed);
    const pus_port_t* const port = &time->config.port;
    if (port->send(port->context, packet, sizeof packet) == STATUS_OK) {
        time->counters.sent++;
        time->sequence = (uint16_t)((time->sequence + 1U) & SEQUENCE_MASK);
        time->period   = absolute_ns(time, now_ns) / period_ns(time);
    } else {
        time->counters.refused++;
    }
}

static pus_reply_t set_rate(void* const self, pus_request_t* const request)
{
    pus_time_t* const time                     = self;
    const pus_persistence_t* const persistence = time->config.persistence;
    const uint8_t exponent                     = octet_read_u8(&request->reader);
    if (exponent > PUS_TIME_EXPONENT_MAX) {
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    const status_t status = (persistence == NULL) ? STATUS_OK
                                                  : persistence->put(persistence->context, PUS_SERVICE_TIME,
                                                                     RECORD_KEY, &exponent, 1U);
    if (status != STATUS_OK) {
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    time->exponent = exponent;
    time->period   = absolute_ns(time, request->now_ns) / period_ns(time);
    return pus_done();
}

pus_service_t pus_time_service(pus_time_t* const time)
{
    static const pus_subtype_t subtypes[] = {PUS_REQUEST(9, 1, set_rate)};
    return pus_service_of(PUS_SERVICE_TIME, subtypes, sizeof subtypes / sizeof subtypes[0], time);
}

bool pus_is_time_packet(const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    return (size >= sizeof(uint16_t)) && (octets_u16_at(octets) == HEADER_WORD);
}
