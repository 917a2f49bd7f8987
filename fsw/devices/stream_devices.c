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

stream_device_t* stream_devices_at(stream_devices_t* const devices, const uint16_t index)
{
    FSW_ASSERT(devices != NULL);
    return (index < devices->count) ? &devices->devices[index] : NULL;
}

// ---- Faults ----

static void raise_fault(const stream_devices_t* const devices, const uint8_t index,
                        const stream_device_fault_t* const fault)
{
    static const char* const names[]               = {[STREAM_DEVICE_REFUSED]  = "STREAM_REFUSED",
                                                      [STREAM_DEVICE_LOST]     = "STREAM_LOST",
                                                      [STREAM_DEVICE_RETURNED] = "STREAM_RETURNED"};
    static const char* const others[]              = {[STREAM_DEVICE_REFUSED]  = "DEVICE_REFUSED",
                                                      [STREAM_DEVICE_LOST]     = "DEVICE_LOST",
                                                      [STREAM_DEVICE_RETURNED] = "DEVICE_RETURNED"};
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(devices->generic);
    const descriptor_event_t* event = descriptor_find_event_name(descriptor, names[fault->kind]);
    if ((event == NULL) && (devices->count == descriptor->device_count)) {
        // In a subsystem with devices on CAN, the events with the other names are those of fsw/drives.
        event = descriptor_find_event_name(descriptor, others[fault->kind]);
    }
    const uint8_t octets[EVENT_OCTETS] = {index, (uint8_t)fault->cause};
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
    devices->count                                 = 0U;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        if (descriptor_is_stream(&descriptor->devices[i])) {
            FSW_ASSERT(devices->count < STREAM_DEVICES_MAX); // stream_devices_fit has checked their number.
            stream_device_init(&devices->devices[devices->count], descriptor, &descriptor->devices[i],
                               devices->resolver);
            devices->count++;
        }
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

/// Returns the number of stream devices among `count` devices of the descriptor.
static uint16_t count_streams(const stream_devices_t* const devices, const uint16_t first,
                              const uint16_t count)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(devices->generic);
    uint16_t streams                               = 0U;
    for (uint16_t i = 0U; i < count; i++) {
        const bool is_stream = descriptor_is_stream(&descriptor->devices[first + i]);
        streams              = (uint16_t)(streams + (is_stream ? 1U : 0U));
    }
    return streams;
}

status_t stream_devices_configure(void* const self, const descriptor_configuration_t* const configuration)
{
    FSW_ASSERT((self != NULL) && (configuration != NULL));
    stream_devices_t* const devices = self;
    const uint64_t now_ns           = subsystem_now_ns(devices->generic);
    const uint16_t first            = count_streams(devices, 0U, configuration->first_device);
    const uint16_t count  = count_streams(devices, configuration->first_device, configuration->device_count);
    const bool is_started = (devices->started_count == count) && (devices->first_started == first);
    status_t status       = is_started ? STATUS_OK : stop_started(devices);
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < count); i++) {
        status = stream_device_start(&devices->devices[first + i], now_ns);
    }
    if (status == STATUS_OK) {
        devices->first_started = first;
        devices->started_count = count;
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
