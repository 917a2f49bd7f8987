// SPDX-License-Identifier: Apache-2.0
/// Emergencies of a CANopen device: the errors that are present, the error register 0x1001, the history
/// 0x1003.
#ifndef SIM_DEVICES_EMERGENCY_H
#define SIM_DEVICES_EMERGENCY_H

#include "sim/devices/dictionary.h"

#include <stdbool.h>
#include <stdint.h>

#define EMERGENCY_OCTETS 8U
#define EMERGENCY_PRESENT_MAX 8U
#define EMERGENCY_HISTORY 8U

// Codes of CiA 301 and CiA 402 used here.
#define EMERGENCY_NONE 0x0000U
#define EMERGENCY_OVER_CURRENT 0x2310U
#define EMERGENCY_UNDER_VOLTAGE 0x3220U
#define EMERGENCY_DEVICE_TEMPERATURE 0x4210U
#define EMERGENCY_DRIVE_TEMPERATURE 0x4310U
#define EMERGENCY_POSITION_SENSOR 0x7305U
#define EMERGENCY_OVERRUN 0x8110U
#define EMERGENCY_ERROR_PASSIVE 0x8120U
#define EMERGENCY_HEARTBEAT 0x8130U
#define EMERGENCY_RECOVERED 0x8140U
#define EMERGENCY_PDO_LENGTH 0x8210U
#define EMERGENCY_PDO_TOO_LONG 0x8220U
#define EMERGENCY_SYNC_LENGTH 0x8240U
#define EMERGENCY_RPDO_TIMEOUT 0x8250U
#define EMERGENCY_EXCESS_TORQUE 0x8311U
#define EMERGENCY_FOLLOWING_ERROR 0x8611U
#define EMERGENCY_TORQUE_SENSOR 0xFF01U

typedef struct { // Private.
    uint16_t code;
    uint8_t axis;
} emergency_t;

typedef struct { // All fields are private.
    object_t* error_register;
    object_t* history_count;
    object_t* history[EMERGENCY_HISTORY];
    emergency_t present[EMERGENCY_PRESENT_MAX];
    unsigned present_count;
} emergencies_t;

void emergencies_init(emergencies_t* emergencies, const dictionary_t* dictionary);
/// Clear all errors; the history is kept.
void emergencies_reset(emergencies_t* emergencies);

/// An error appears. Returns true and the message to send; false if the error was present, or if
/// EMERGENCY_PRESENT_MAX others are: then it is not noted. The last four octets of the message contain `raw`:
/// a number about the error, such as the length of a wrong frame.
bool emergency_raise(emergencies_t* emergencies, uint16_t code, uint8_t axis, int32_t raw,
                     uint8_t message[EMERGENCY_OCTETS]);
/// An error has ended. Returns true and the message to send (code 0) if it was present and no other error
/// remains.
bool emergency_clear(emergencies_t* emergencies, uint16_t code, uint8_t axis,
                     uint8_t message[EMERGENCY_OCTETS]);
bool emergency_is_present(const emergencies_t* emergencies, uint16_t code, uint8_t axis);

#endif // SIM_DEVICES_EMERGENCY_H
