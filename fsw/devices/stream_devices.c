// SPDX-License-Identifier: Apache-2.0
#include "fsw/devices/stream_devices.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

#define EVENT_OCTETS 2U

void stream_devices_init(stream_devices_t* const devices, subsystem_t* const generic,
                         const flow_resolver_t* const resolver)
{
    FSW_ASSERT((devices != NULL) && (generic != NULL) && (resolver != NULL));
    (void)memset(devices, 0, sizeof *devices);
    devices->generic  = generic;
    devices->resolver = resolver;
}

stream_device_t* stream_devices_at(stream_devices_t* const devices, const uint16_t place)
{
    FSW_ASSERT(devices != NULL);
    return (place < devices->count) ? &devices->devices[place] : NULL;
}

// ---- Faults ----

static void raise_fault(const stream_devices_t* const devices, const uint8_t place,
                        const stream_device_fault_t* const fault)
{
    static const char* const names[] = {[STREAM_DEVICE_REFUSED]  = "DEVICE_REFUSED",
                                        [STREAM_DEVICE_LOST]     = "DEVICE_LOST",
                                        [STREAM_DEVICE_RETURNED] = "DEVICE_RETURNED"};
    const descriptor_event_t* const event =
        descriptor_find_event_name(subsystem_descriptor(devices->generic), names[fault->kind]);
    const uint8_t octets[EVENT_OCTETS] = {place, (uint8_t)fault->cause};
    if ((event != NULL) && (event->octets <= EVENT_OCTETS)) {
        (void)subsystem_raise(devices->generic, event->id, octets, event->octets);
    }
}

static void raise_faults(stream_devices_t* const devices)
{
    for (uint16_t i = 0U; i < devices->count; i++) {
        stream_device_fault_t fault;
        if (stream_device_take_fault(&devices->devices[i], &fault) == STATUS_OK) {
            raise_fault(devices, (uint8_t)i, &fault);
        }
    }
}

// ---- Commissioning ----

static void close_all(stream_devices_t* const devices)
{
    for (uint16_t i = 0U; i < devices->count; i++) {
        stream_device_close(&devices->devices[i]);
    }
    devices->count         = 0U;
    devices->started_count = 0U;
    devices->is_open       = false;
}

static void begin(stream_devices_t* const devices)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(devices->generic);
    FSW_ASSERT(descriptor->device_count <= STREAM_DEVICES_MAX);
    devices->count = descriptor->device_count;
    for (uint16_t i = 0U; i < devices->count; i++) {
        stream_device_init(&devices->devices[i], descriptor, &descriptor->devices[i], devices->resolver);
    }
    devices->is_open = true;
}

/// Combine the statuses of two actions: STATUS_BUSY if one of them is not done.
static status_t status_of_both(const status_t one, const status_t other)
{
    return (one == STATUS_OK) ? other : one;
}

status_t stream_devices_hardware_init(void* const self)
{
    FSW_ASSERT(self != NULL);
    stream_devices_t* const devices = self;
    const uint64_t now_ns           = subsystem_now_ns(devices->generic);
    status_t status                 = STATUS_OK;
    if (!devices->is_open) {
        begin(devices);
    }
    for (uint16_t i = 0U; i < devices->count; i++) {
        stream_device_t* const device = &devices->devices[i];
        status                        = status_of_both(
                                   status, status_of_both(stream_device_open(device, now_ns), stream_device_boot(device)));
    }
    return status;
}

/// Stop the devices of the configuration in use.
static status_t stop_started(stream_devices_t* const devices)
{
    status_t status = STATUS_OK;
    for (uint16_t i = 0U; i < devices->started_count; i++) {
        status = status_of_both(status, stream_device_stop(&devices->devices[devices->first_started + i]));
    }
    devices->started_count = (status == STATUS_OK) ? 0U : devices->started_count;
    return status;
}

static bool is_started(const stream_devices_t* const devices,
                       const descriptor_configuration_t* const configuration)
{
    return (devices->started_count == configuration->device_count) &&
           (devices->first_started == configuration->first_device);
}

status_t stream_devices_configure(void* const self, const descriptor_configuration_t* const configuration)
{
    FSW_ASSERT((self != NULL) && (configuration != NULL));
    stream_devices_t* const devices = self;
    const uint64_t now_ns           = subsystem_now_ns(devices->generic);
    status_t status                 = is_started(devices, configuration) ? STATUS_OK : stop_started(devices);
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < configuration->device_count); i++) {
        status = stream_device_start(&devices->devices[configuration->first_device + i], now_ns);
    }
    if (status == STATUS_OK) {
        devices->first_started = configuration->first_device;
        devices->started_count = configuration->device_count;
    }
    return status;
}

status_t stream_devices_secure(void* const self)
{
    FSW_ASSERT(self != NULL);
    stream_devices_t* const devices = self;
    status_t status                 = STATUS_OK;
    for (uint16_t i = 0U; i < devices->count; i++) {
        status = status_of_both(status, stream_device_secure(&devices->devices[i]));
    }
    return status;
}

status_t stream_devices_post(void* const self)
{
    FSW_ASSERT(self != NULL);
    stream_devices_t* const devices = self;
    status_t status                 = STATUS_OK;
    for (uint16_t i = 0U; i < devices->count; i++) {
        status = status_of_both(status, stream_device_stop(&devices->devices[i]));
    }
    devices->started_count = (status == STATUS_OK) ? 0U : devices->started_count;
    return status;
}

status_t stream_devices_hardware_deinit(void* const self)
{
    FSW_ASSERT(self != NULL);
    close_all(self);
    return STATUS_OK;
}

void stream_devices_release(void* const self)
{
    FSW_ASSERT(self != NULL);
    close_all(self);
}

// ---- The cycle ----

void stream_devices_sense(void* const self)
{
    FSW_ASSERT(self != NULL);
    stream_devices_t* const devices = self;
    const uint64_t now_ns           = subsystem_now_ns(devices->generic);
    for (uint16_t i = 0U; i < devices->count; i++) {
        stream_device_sense(&devices->devices[i], now_ns);
    }
    raise_faults(devices);
}

void stream_devices_emit(void* const self)
{
    FSW_ASSERT(self != NULL);
    stream_devices_t* const devices = self;
    for (uint16_t i = 0U; i < devices->count; i++) {
        stream_device_command(&devices->devices[i]);
    }
}
