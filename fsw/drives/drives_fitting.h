// SPDX-License-Identifier: Apache-2.0
/// Whether a subsystem can drive the devices of a descriptor, for its callback `fits`: classes, end nodes and
/// numbers, which would otherwise fail in flight, without a place.
#ifndef FSW_DRIVES_DRIVES_FITTING_H
#define FSW_DRIVES_DRIVES_FITTING_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct { // What every configuration has to have.
    const char* type;
    const char* says_type; ///< Refusal of another class.
    uint16_t count;        ///< Devices.
    const char* says_count;
    const int* modes; ///< One of these modes of operation, the same for all devices; ends with 0.
    const char* says_mode;
} drives_need_t;

/// True if the devices are what is needed, are reached by one CAN bus and its channel B, and have room in
/// network.h; else *out_misfit is the first that does not.
bool drives_fit(const subsystem_descriptor_t* descriptor, const drives_need_t* need,
                subsystem_misfit_t* out_misfit);

#endif // FSW_DRIVES_DRIVES_FITTING_H
