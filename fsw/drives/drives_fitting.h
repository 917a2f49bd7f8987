// SPDX-License-Identifier: Apache-2.0
/// Checks that a subsystem can drive the devices of a descriptor, for its callback `fits`: classes, end nodes
/// and numbers. Without it such an error would appear only in flight, without file and line.
#ifndef FSW_DRIVES_DRIVES_FITTING_H
#define FSW_DRIVES_DRIVES_FITTING_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {           // Required contents of every configuration.
    uint8_t axes;          ///< Axes of each device; its class must be one of CiA 402.
    bool takes_modules;    ///< Classes without axes may be there as well, and each drive has its own mode.
    const char* says_type; ///< Refusal of another class.
    uint16_t count;        ///< Devices; 0: any number from one.
    const char* says_count;
    const int* modes; ///< One of these modes of operation, for all devices the same; ends with 0.
    const char* says_mode;
} drives_need_t;

/// True if the devices meet the need and are on CAN buses, within the limits of drives.h and network.h; each
/// bus has one channel B or none, and each node id one bus. Else *out_misfit is the first violation.
bool drives_fit(const subsystem_descriptor_t* descriptor, const drives_need_t* need,
                subsystem_misfit_t* out_misfit);

/// True if a configuration changes the mapping of PDOs of this node. The devices fit.
bool drives_is_mapped(const subsystem_descriptor_t* descriptor, uint8_t node);

/// Integer mode of operation (object 0x6060) that the configuration sets for the device; 0 if it sets none.
int drives_mode(const subsystem_descriptor_t* descriptor, const descriptor_device_t* device);

/// The CAN end node of a device that fits.
const descriptor_endnode_t* drives_endnode(const subsystem_descriptor_t* descriptor,
                                           const descriptor_device_t* device);

#endif // FSW_DRIVES_DRIVES_FITTING_H
