// SPDX-License-Identifier: Apache-2.0
#include "pus/core/traffic_class.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "pus/st05/st05_events.h"
#include "pus/private/st129_management.h"
#include "pus/private/st130_rtlink.h"
#include "pus/private/st131_mission.h"

#define OFFSET_SERVICE 7U // Offset of the service type in requests and in reports.
#define OFFSET_SOURCE 9U  // Offset of the source id in a request.
#define OFFSET_NOTICE_SEVERITY (PUS_TM_HEADER_SIZE + 2U)

/// A message type: service << 8 | subtype.
#define TYPE(service, subtype) (uint16_t)(((service) << 8U) | (subtype))

static bool is_firm(const uint16_t type, const uint8_t* const packet, const size_t size)
{
    switch (type) {
    case TYPE(PUS_SERVICE_EVENTS, PUS_SEVERITY_HIGH):
    case TYPE(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_TRANSITION):
    case TYPE(PUS_SERVICE_RTLINK, PUS_LINK_TRANSITION):
    case TYPE(PUS_SERVICE_MISSION, PUS_MISSION_MODE_TRANSITION):
        return true;
    case TYPE(PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_NOTICE):
        return (size > OFFSET_NOTICE_SEVERITY) &&
               (packet[OFFSET_NOTICE_SEVERITY] == (uint8_t)PUS_SEVERITY_HIGH);
    default:
        return (type >> 8U) == PUS_SERVICE_VERIFICATION;
    }
}

/// True for reports whose sender continues later after a refusal, or counts the lost packets.
static bool is_bulk(const uint16_t type)
{
    static const uint16_t types[] = {
        TYPE(2U, 6U),   TYPE(2U, 9U),   TYPE(2U, 12U),  TYPE(3U, 10U),  TYPE(3U, 12U),  TYPE(3U, 25U),
        TYPE(3U, 26U),  TYPE(3U, 41U),  TYPE(4U, 2U),   TYPE(4U, 9U),   TYPE(12U, 9U),  TYPE(12U, 11U),
        TYPE(12U, 14U), TYPE(12U, 26U), TYPE(12U, 28U), TYPE(14U, 4U),  TYPE(14U, 8U),  TYPE(14U, 12U),
        TYPE(14U, 16U), TYPE(15U, 6U),  TYPE(15U, 36U), TYPE(15U, 38U), TYPE(15U, 40U), TYPE(18U, 9U),
        TYPE(6U, 4U),   TYPE(6U, 6U),   TYPE(11U, 10U), TYPE(11U, 13U), TYPE(12U, 12U), TYPE(13U, 1U),
        TYPE(13U, 2U),  TYPE(13U, 3U),  TYPE(19U, 7U),  TYPE(19U, 11U), TYPE(21U, 12U), TYPE(22U, 10U),
        TYPE(22U, 13U), TYPE(23U, 8U),  TYPE(23U, 13U)};
    for (size_t i = 0U; i < (sizeof types / sizeof types[0]); i++) {
        if (types[i] == type) {
            return true;
        }
    }
    return false;
}

/// True for the requests by which the supervisor changes states and links. They are FIRM, so that they do not
/// wait for requests of other users.
static bool is_order(const uint8_t* const packet)
{
    const uint8_t service = packet[OFFSET_SERVICE];
    return (octets_u16_at(&packet[OFFSET_SOURCE]) == PUS_USER_SUPERVISOR) &&
           ((service == PUS_SERVICE_MANAGEMENT) || (service == PUS_SERVICE_RTLINK));
}

pus_class_t pus_class_of(const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((packet != NULL) || (size == 0U));
    if ((size >= PUS_TC_HEADER_SIZE) && pus_packet_is_tc(packet, size)) {
        return is_order(packet) ? PUS_CLASS_FIRM : PUS_CLASS_PLAIN;
    }
    if (size < PUS_TM_HEADER_SIZE) {
        return PUS_CLASS_BULK;
    }
    const uint16_t type = octets_u16_at(&packet[OFFSET_SERVICE]);
    if (is_firm(type, packet, size)) {
        return PUS_CLASS_FIRM;
    }
    return is_bulk(type) ? PUS_CLASS_BULK : PUS_CLASS_PLAIN;
}
