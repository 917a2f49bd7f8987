// SPDX-License-Identifier: Apache-2.0
/// All stream devices of a subsystem: commissioning by state, cycle, faults as events, safe state. The
/// functions with a `void* self` are callbacks for subsystem_callbacks_t; their context begins with a
/// stream_devices_t.
///
/// HARDWARE_INIT opens the devices of all configurations and waits for a record of each; PRE_OPERATIONAL
/// starts those of the configuration; ERROR_OPERATIONAL sends the safe record of each device, in each cycle
/// until all end nodes have accepted it. Faults raise events, if the descriptor defines them: STREAM_REFUSED
/// and STREAM_LOST (UINT8 number of the device, UINT8 stream_device_cause_t), STREAM_RETURNED (UINT8 number).
/// In a subsystem without devices on CAN they may be called DEVICE_REFUSED, DEVICE_LOST and DEVICE_RETURNED.
///
/// The subsystem may have devices on CAN, too: fsw/equipment/equipment.h.
///
/// Ownership  The caller provides stream_devices_t, which must not be moved.
/// Context    The task of the generic subsystem.
#ifndef FSW_DEVICES_STREAM_DEVICES_H
#define FSW_DEVICES_STREAM_DEVICES_H

#include "base/status.h"
#include "fsw/devices/stream_device.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>
#include <stdint.h>

#define STREAM_DEVICES_MAX 16U ///< In all configurations of a subsystem together.

typedef struct { // Private, except count.
    subsystem_t* generic;
    const flow_resolver_t* resolver;
    stream_device_t devices[STREAM_DEVICES_MAX];
    uint16_t count;         ///< Stream devices of the descriptor, in its order.
    uint16_t first_started; // Devices of the configuration in use.
    uint16_t started_count;
    bool is_open;
} stream_devices_t;

/// Fields that the program uses of each device. Null ends each list; a device may have further fields.
typedef struct {
    const char* const* in;
    const char* const* out;
    const char* reason_in;  ///< Message about a device that lacks a field of `in`.
    const char* reason_out; ///< Message about a device that lacks a field of `out`.
    uint16_t most;          ///< Devices of all configurations, at most STREAM_DEVICES_MAX.
    /// Message about more devices than `most`.
    const char* reason_most;
    bool permits_drives; ///< Devices on CAN are permitted, and are left to fsw/drives.
} stream_devices_need_t;

/// True if the stream devices of a descriptor can be reached and have these fields, and other devices are
/// permitted.
bool stream_devices_fit(const subsystem_descriptor_t* descriptor, const stream_devices_need_t* need,
                        subsystem_misfit_t* out_misfit);

/// Call once, before the generic subsystem runs. The pointers must stay valid.
void stream_devices_init(stream_devices_t* devices, subsystem_t* generic, const flow_resolver_t* resolver);
/// Returns a device by its index among the stream devices of the descriptor; null if there is none, or if
/// HARDWARE_INIT has not begun.
stream_device_t* stream_devices_at(stream_devices_t* devices, uint16_t index);

status_t stream_devices_hardware_init(void* self);
status_t stream_devices_configure(void* self, const descriptor_configuration_t* configuration);
status_t stream_devices_secure(void* self);
status_t stream_devices_post(void* self);
status_t stream_devices_hardware_deinit(void* self);
void stream_devices_release(void* self);
void stream_devices_sense(void* self);
void stream_devices_emit(void* self);

#endif // FSW_DEVICES_STREAM_DEVICES_H
