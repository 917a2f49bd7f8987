// SPDX-License-Identifier: Apache-2.0
/// The subsystem INSTRUMENTS: simple axes behind data flows. In OPERATIONAL each device gets its value of
/// TARGET; an event reports that all have arrived. The descriptor says which devices there are, their end
/// nodes and their records, which need the fields COUNT and VALUE to flight, ENABLE and TARGET to the device.
///
/// Ownership  The program places instruments_t and the generic subsystem; both must not be moved.
/// Context    The task of the generic subsystem; its callbacks wait only as fsw/devices does.
#ifndef FSW_SUBSYSTEMS_INSTRUMENTS_INSTRUMENTS_H
#define FSW_SUBSYSTEMS_INSTRUMENTS_INSTRUMENTS_H

#include "base/capacities.h"
#include "fsw/devices/stream_devices.h"
#include "fsw/framework/subsystem/subsystem.h"

#include "generated/instruments_descriptor.h"

#include <stdbool.h>
#include <stddef.h>

#define INSTRUMENTS_MAX 8U ///< Devices; as many as the parameters have places.

typedef struct {              // All fields are private.
    stream_devices_t devices; ///< First: the callbacks of stream_devices.h have the same context.
    subsystem_t* generic;
    instruments_parameters_t parameters;
    bool is_under_way; ///< Have not all arrived yet.
} instruments_t;
CAPACITY_CHECK(instruments_begin_with_devices, offsetof(instruments_t, devices) == 0U);

/// Once, before the generic subsystem runs. Pointers are kept.
void instruments_init(instruments_t* own, subsystem_t* generic, const flow_resolver_t* resolver);
/// Callbacks for the generic subsystem; their context is the instruments_t.
const subsystem_callbacks_t* instruments_callbacks(void);

#endif // FSW_SUBSYSTEMS_INSTRUMENTS_INSTRUMENTS_H
