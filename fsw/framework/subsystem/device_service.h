// SPDX-License-Identifier: Apache-2.0
/// ST[02] of a subsystem (`<Service type="2"/>` of its descriptor): access to the devices that its callback
/// `device_port` offers. A subsystem that lists this service must have that callback. A device has one second
/// to answer.
///
/// Ownership  The generated program provides device_service_t.
/// Context    The main loop of the component.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_DEVICE_SERVICE_H
#define FSW_FRAMEWORK_SUBSYSTEM_DEVICE_SERVICE_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "pus/st02/st02_device_access.h"

#define DEVICE_SERVICE_TIMEOUT_NS 1000000000ULL

typedef struct { // Private, except `access.counters`.
    pus_device_access_t access;
} device_service_t;

/// Add the service to a component, with room for `count` requests that run at the same time.
void subsystem_device_service_add(subsystem_t* subsystem, device_service_t* service,
                                  pus_device_operation_t* operations, uint8_t count);

#endif // FSW_FRAMEWORK_SUBSYSTEM_DEVICE_SERVICE_H
