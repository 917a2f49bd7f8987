// SPDX-License-Identifier: Apache-2.0
/// Checks that a subsystem can drive the devices of a descriptor: their classes, end nodes and numbers. For
/// the callback `fits` of the subsystem. Without these checks an error would appear only in flight, without
/// file and line.
#ifndef FSW_DRIVES_DRIVES_FITTING_H
#define FSW_DRIVES_DRIVES_FITTING_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {  // Required contents of every configuration.
    uint8_t axes; ///< Required number of axes of each device; its class must be one of CiA 402.
    /// Devices of classes without axes are permitted too, and each drive may have a mode of its own.
    bool takes_modules;
    const char* reason_type; ///< Message about a device of another class.
    uint16_t count;          ///< Required number of devices on CAN; 0: any number from one.
    const char* reason_count;
    const int* modes; ///< Permitted modes of operation, 0 at the end; all devices must have the same mode.
    const char* reason_mode;
    bool permits_streams; ///< Stream devices are permitted, and are left to fsw/devices.
} drives_need_t;

/// True if the devices meet the need and are on CAN buses, within the limits of drives.h and network.h;
/// each bus has at most one channel B; each node id occurs on one bus only, and once in a configuration;
/// settings keep the units of the class, and change a mapping in the order of CiA 301. Otherwise *out_misfit
/// is the first violation.
bool drives_fit(const subsystem_descriptor_t* descriptor, const drives_need_t* need,
                subsystem_misfit_t* out_misfit);

/// True if a configuration changes the mapping of PDOs of this node. drives_fit must have accepted the
/// devices.
bool drives_is_mapped(const subsystem_descriptor_t* descriptor, uint8_t node);

/// Returns the mode of operation (object 0x6060) that the configuration sets for the device; 0 if it sets
/// none.
int drives_mode(const subsystem_descriptor_t* descriptor, const descriptor_device_t* device);

/// Returns the CAN end node of a device that drives_fit has accepted; null for a stream device.
const descriptor_endnode_t* drives_endnode(const subsystem_descriptor_t* descriptor,
                                           const descriptor_device_t* device);

#endif // FSW_DRIVES_DRIVES_FITTING_H
