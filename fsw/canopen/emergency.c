// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/emergency.h"

#include "fsw/canopen/cob.h"
#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

static const canopen_emergency_code_t standard_codes[] = {
    {EMERGENCY_NO_ERROR, EMERGENCY_CLEARED},
    {0x8110U, EMERGENCY_LOW},    // overrun
    {0x8120U, EMERGENCY_LOW},    // error passive
    {0x8240U, EMERGENCY_LOW},    // unexpected SYNC data length
    {0x4210U, EMERGENCY_MEDIUM}, // over-temperature of the device
    {0x4310U, EMERGENCY_MEDIUM}, // over-temperature of the drive
    {0x8311U, EMERGENCY_MEDIUM}, // excess torque
    {0x8611U, EMERGENCY_MEDIUM}, // following error
    {0x2310U, EMERGENCY_HIGH},   // over-current
    {0x3220U, EMERGENCY_HIGH},   // under-voltage
    {0x7305U, EMERGENCY_HIGH},   // position sensor
    {0x8130U, EMERGENCY_HIGH},   // heartbeat lost
    {0x8140U, EMERGENCY_HIGH},   // recovered from bus-off
    {0x8250U, EMERGENCY_HIGH},   // RPDO time-out
};

canopen_emergency_t canopen_emergency_decode(const uint8_t node, const uint8_t octets[EMERGENCY_OCTETS])
{
    FSW_ASSERT(octets != NULL);
    canopen_emergency_t emergency = {
        .node = node, .code = (uint16_t)canopen_at(octets, 2U), .error_register = octets[2]};
    (void)memcpy(emergency.manufacturer, &octets[3], sizeof emergency.manufacturer);
    return emergency;
}

canopen_emergency_severity_t canopen_emergency_severity(const canopen_emergency_code_t* const codes,
                                                        const uint8_t count, const uint16_t code)
{
    FSW_ASSERT((codes != NULL) || (count == 0U));
    for (uint8_t i = 0U; i < count; i++) {
        if (codes[i].code == code) {
            return codes[i].severity;
        }
    }
    for (size_t i = 0U; i < (sizeof standard_codes / sizeof standard_codes[0]); i++) {
        if (standard_codes[i].code == code) {
            return standard_codes[i].severity;
        }
    }
    return EMERGENCY_MEDIUM;
}
