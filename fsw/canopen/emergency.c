// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/emergency.h"

#include "fsw/canopen/cob.h"
#include "base/assertion.h"

#include <stddef.h>

typedef struct {
    uint16_t code;
    canopen_emergency_class_t class;
} code_class_t;

static const code_class_t code_classes[] = {
    {EMERGENCY_NO_ERROR, EMERGENCY_CLEARED},
    {0x8110U, EMERGENCY_LOW},    // overrun
    {0x8120U, EMERGENCY_LOW},    // error passive
    {0x8240U, EMERGENCY_LOW},    // SYNC of another length
    {0x4210U, EMERGENCY_MEDIUM}, // over-temperature of the device
    {0x4310U, EMERGENCY_MEDIUM}, // over-temperature of the drive
    {0x8311U, EMERGENCY_MEDIUM}, // excess torque
    {0x8611U, EMERGENCY_MEDIUM}, // following error
    {0x2310U, EMERGENCY_HIGH},   // over-current
    {0x3220U, EMERGENCY_HIGH},   // under-voltage
    {0x7305U, EMERGENCY_HIGH},   // position sensor
    {0x8130U, EMERGENCY_HIGH},   // heartbeat lost
    {0x8140U, EMERGENCY_HIGH},   // recovered from bus-off
    {0x8250U, EMERGENCY_HIGH},   // process data missing
    {0xFF01U, EMERGENCY_HIGH},   // torque sensor
};

canopen_emergency_t canopen_emergency_decode(const uint8_t node, const uint8_t octets[EMERGENCY_OCTETS])
{
    FSW_ASSERT(octets != NULL);
    return (canopen_emergency_t){.node           = node,
                                 .code           = (uint16_t)canopen_at(octets, 2U),
                                 .error_register = octets[2],
                                 .axis           = octets[3],
                                 .raw_value      = (int32_t)canopen_u32_at(&octets[4])};
}

canopen_emergency_class_t canopen_emergency_class(const uint16_t code)
{
    for (size_t i = 0U; i < (sizeof code_classes / sizeof code_classes[0]); i++) {
        if (code_classes[i].code == code) {
            return code_classes[i].class;
        }
    }
    return EMERGENCY_MEDIUM;
}
