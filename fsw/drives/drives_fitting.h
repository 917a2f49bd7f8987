// SPDX-License-Identifier: Apache-2.0
/// Checks that a subsystem can drive the devices of a descriptor, for its callback `fits`: classes, end nodes
/// and numbers. Without it such an error would appear only in flight, without file and line.
#ifndef FSW_DRIVES_DRIVES_FITTING_H
#define FSW_DRIVES_DRIVES_FITTING_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct { // Required contents of every configuration.
    const char* type;
    const char* says_type; ///< Refusal of another class.
    uint16_t count;        ///< Devices.
    const char* says_count;
    const int* modes; ///< One of these modes of operation, the same for all devices; ends with 0.
    const char* says_mode;
} drives_need_t;

/// True if the devices meet the need, are on one CAN bus and its channel B, and fit the limits of network.h;
/// else *out_misfit is the first violation.
bool drives_fit(const subsystem_descriptor_t* descriptor, const drives_need_t* need,
                subsystem_misfit_t* out_misfit);

/// The CAN end node of a device that fits.
const descriptor_endnode_t* drives_endnode(const subsystem_descriptor_t* descriptor,
                                           const descriptor_device_t* device);

#endif // FSW_DRIVES_DRIVES_FITTING_H
