// SPDX-License-Identifier: Apache-2.0
/// All devices of a subsystem: those on CAN buses (fsw/drives) and stream devices (fsw/devices). The
/// descriptor decides which device is of which kind; a subsystem may have either kind or both.
///
/// The functions with a `void* self` are callbacks for subsystem_callbacks_t; their context begins with an
/// equipment_t. The table of a subsystem contains either all of them or none. drives.h and stream_devices.h
/// define what they do for each kind. HARDWARE_INIT and a configuration commission the stream devices first,
/// and then the devices on CAN, whose power stages are thus the last to become ready. Securing acts on all
/// devices of both kinds in the same cycle.
///
/// Ownership  The caller provides equipment_t, which must not be moved.
/// Context    The task of the generic subsystem.
/// Errors     Statuses of both modules; STATUS_BUSY: call again in the next cycle.
#ifndef FSW_EQUIPMENT_EQUIPMENT_H
#define FSW_EQUIPMENT_EQUIPMENT_H

#include "base/status.h"
#include "fsw/devices/stream_devices.h"
#include "fsw/drives/drives.h"
#include "fsw/drives/drives_fitting.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {              // Private, except the public members of `drives`.
    drives_t drives;          ///< First member: `abandon` of drives_init gets the context of the callbacks.
    stream_devices_t streams; ///< Public as the argument of stream_devices_at.
    bool is_securing;         // equipment_secure was called in this cycle or in the previous one.
    bool has_secured;         // equipment_secure was called in this cycle.
    // The devices on CAN are safe; they are not secured again until the stream devices are safe, too.
    bool are_drives_secure;
} equipment_t;

/// True if drives_fit and stream_devices_fit accept the devices of their kind. Each need must permit devices
/// of the other kind; a descriptor without devices on CAN need not meet `drives`.
bool equipment_fit(const subsystem_descriptor_t* descriptor, const drives_need_t* drives,
                   const stream_devices_need_t* streams, subsystem_misfit_t* out_misfit);

/// Call once, before the generic subsystem runs. The pointers must stay valid. `abandon`: see drives_init.
void equipment_init(equipment_t* equipment, subsystem_t* generic, const flow_resolver_t* resolver,
                    void (*abandon)(void* self));
/// True if the descriptor has a device on CAN.
bool equipment_has_drives(const equipment_t* equipment);
/// True if the actuators of the devices on CAN are on, or if there are none.
bool equipment_is_engaged(const equipment_t* equipment);

status_t equipment_hardware_init(void* self);
status_t equipment_configure(void* self, const descriptor_configuration_t* configuration);
status_t equipment_start_control(void* self);
status_t equipment_stop_control(void* self);
status_t equipment_engage(void* self);
status_t equipment_disengage(void* self);
status_t equipment_secure(void* self);
status_t equipment_post(void* self);
status_t equipment_hardware_deinit(void* self);
void equipment_release(void* self);
void equipment_sense(void* self);
void equipment_emit(void* self);

#endif // FSW_EQUIPMENT_EQUIPMENT_H
