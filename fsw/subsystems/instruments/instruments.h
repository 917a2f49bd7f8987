// SPDX-License-Identifier: Apache-2.0
/// The subsystem INSTRUMENTS: simple axes that are connected by data flows. In OPERATIONAL each device gets
/// its value of TARGET; an event reports that all devices have arrived. The descriptor lists the devices,
/// their end nodes and their records, which must have the fields COUNT and VALUE in the direction to flight,
/// and ENABLE and TARGET in the direction to the device.
///
/// Ownership  The program provides instruments_t and the generic subsystem; both must not be moved.
/// Context    The task of the generic subsystem; its callbacks block only as those of fsw/devices do.
#ifndef FSW_SUBSYSTEMS_INSTRUMENTS_INSTRUMENTS_H
#define FSW_SUBSYSTEMS_INSTRUMENTS_INSTRUMENTS_H

#include "base/capacities.h"
#include "fsw/devices/stream_devices.h"
#include "fsw/framework/subsystem/subsystem.h"

#include "generated/instruments_descriptor.h"

#include <stdbool.h>
#include <stddef.h>

#define INSTRUMENTS_MAX 8U ///< Largest number of devices; the number of elements of the parameters.

typedef struct { // All fields are private.
    /// First member, because the callbacks of stream_devices.h get the same context.
    stream_devices_t devices;
    subsystem_t* generic;
    instruments_parameters_t parameters;
    bool is_under_way; ///< A device has not arrived at its target yet.
} instruments_t;
CAPACITY_CHECK(instruments_begin_with_devices, offsetof(instruments_t, devices) == 0U);

/// Call once, before the generic subsystem runs. The pointers must stay valid.
void instruments_init(instruments_t* own, subsystem_t* generic, const flow_resolver_t* resolver);
/// Returns the callbacks for the generic subsystem; their context is the instruments_t.
const subsystem_callbacks_t* instruments_callbacks(void);

#endif // FSW_SUBSYSTEMS_INSTRUMENTS_INSTRUMENTS_H
