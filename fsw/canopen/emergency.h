// SPDX-License-Identifier: Apache-2.0
/// Emergency messages (CiA 301, 402): errors that a device reports, and their severity.
///
/// The table in emergency.c contains the codes of the standards. The data sheet of a class of devices (CiA
/// 306) adds codes of its manufacturer, or changes a severity, by lines "EMCY 0xFF01 HIGH text" in its
/// section [Comments].
#ifndef FSW_CANOPEN_EMERGENCY_H
#define FSW_CANOPEN_EMERGENCY_H

#include <stdint.h>

#define EMERGENCY_OCTETS 8U
#define EMERGENCY_MANUFACTURER_OCTETS 5U
#define EMERGENCY_NO_ERROR 0x0000U

typedef enum {
    EMERGENCY_CLEARED, ///< Code 0x0000: no error is left.
    EMERGENCY_LOW,     ///< The emergency should be logged.
    EMERGENCY_MEDIUM,  ///< Actuators should be switched off.
    EMERGENCY_HIGH     ///< The device can no longer work.
} canopen_emergency_severity_t;

typedef struct {
    uint8_t node;
    uint16_t code;
    uint8_t error_register;
    uint8_t manufacturer[EMERGENCY_MANUFACTURER_OCTETS]; ///< Their meaning is defined by the manufacturer.
} canopen_emergency_t;

typedef struct {
    uint16_t code;
    canopen_emergency_severity_t severity;
} canopen_emergency_code_t;

/// Decode the 8 octets of a frame.
canopen_emergency_t canopen_emergency_decode(uint8_t node, const uint8_t octets[EMERGENCY_OCTETS]);
/// Returns the severity of a code: as defined by the `count` codes of the device's class, otherwise by the
/// standards. An unknown code is MEDIUM, because its effect is unknown.
canopen_emergency_severity_t canopen_emergency_severity(const canopen_emergency_code_t* codes, uint8_t count,
                                                        uint16_t code);

#endif // FSW_CANOPEN_EMERGENCY_H
