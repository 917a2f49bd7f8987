// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/measuring_device.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_US 1000U
#define INVALID 1U // Status of values that are not valid.
#define ERRORS_MAX 8U

typedef struct {
    uint64_t available_ns;
    uint32_t syncs;
    uint64_t after_sync_ns;
    double value[MEASURING_VALUES_MAX];
} measurement_t;

struct measuring_device {
    node_t* node;
    measuring_config_t config;
    object_t* value[MEASURING_VALUES_MAX]; // Integers, or null.
    object_t* real[MEASURING_VALUES_MAX];  // REAL32 or REAL64, or null.
    // A manufacturer-specific device has one status object for all values.
    object_t* status[MEASURING_VALUES_MAX];
    double factor[MEASURING_VALUES_MAX];
    object_t* counter;
    object_t* stamp_syncs; // Null if the device does not stamp exposures.
    object_t* stamp_us;
    uint64_t next_ns;
    measurement_t delayed[MEASURING_DELAYED_MAX]; // From the oldest to the newest.
    unsigned delayed_count;
    uint16_t error[ERRORS_MAX]; // Present errors that make measurements invalid; 0: free entry.
};

static bool is_failed(const measuring_device_t* const device)
{
    bool is_failed = false;
    for (unsigned i = 0U; i < ERRORS_MAX; i++) {
        is_failed = is_failed || (device->error[i] != 0U);
    }
    return is_failed;
}

static void set_status(measuring_device_t* const device, const unsigned status)
{
    for (unsigned i = 0U; i < device->config.value_count; i++) {
        object_set(device->status[i], (int64_t)status);
    }
}

static void publish(measuring_device_t* const device, const measurement_t* const measurement)
{
    for (unsigned i = 0U; i < device->config.value_count; i++) {
        const double scaled = measurement->value[i] * device->factor[i];
        if (device->value[i] != NULL) {
            object_set(device->value[i], (int64_t)llround(fmax(INT32_MIN, fmin(INT32_MAX, scaled))));
        }
        if (device->real[i] != NULL) {
            object_set_real(device->real[i], measurement->value[i]);
        }
    }
    object_set(device->counter, (int64_t)device->counter->value + 1);
    if (device->stamp_syncs != NULL) {
        object_set(device->stamp_syncs, (int64_t)measurement->syncs);
        object_set(device->stamp_us, (int64_t)(measurement->after_sync_ns / NS_PER_US));
    }
    set_status(device, 0U);
}

/// Make a measurement, which becomes available after the delay of the device.
static void expose(measuring_device_t* const device, const uint64_t number, const uint64_t now_ns)
{
    measurement_t measurement = {.available_ns = now_ns + device->config.delay_ns};
    uint64_t sync_ns          = 0U;
    if (is_failed(device) || (device->delayed_count == MEASURING_DELAYED_MAX) ||
        !device->config.measure(device->config.context, number, measurement.value)) {
        return;
    }
    measurement.syncs                      = node_syncs(device->node, &sync_ns);
    measurement.after_sync_ns              = (now_ns > sync_ns) ? (now_ns - sync_ns) : 0U;
    device->delayed[device->delayed_count] = measurement;
    device->delayed_count++;
}

/// Publish the measurements whose delay has ended.
static void take_delayed(measuring_device_t* const device, const uint64_t now_ns)
{
    unsigned taken = 0U;
    while ((taken < device->delayed_count) && (device->delayed[taken].available_ns <= now_ns)) {
        publish(device, &device->delayed[taken]);
        taken++;
    }
    device->delayed_count -= taken;
    memmove(device->delayed, &device->delayed[taken], device->delayed_count * sizeof device->delayed[0]);
}

/// Called at each SYNC. A device without a period of its own measures here; others measure at the end of a
/// step (measuring_device_end_step).
static void on_sample(void* const context, const uint64_t now_ns)
{
    measuring_device_t* device = context;
    if (device->config.period_ns == 0U) {
        expose(device, now_ns / device->config.step_ns, now_ns);
    }
    take_delayed(device, now_ns);
    if (is_failed(device)) {
        set_status(device, INVALID);
    }
}

static void on_written(void* const context, const object_t* const object, const uint64_t now_ns)
{
    (void)context; // No written object changes the measurements.
    (void)object;
    (void)now_ns;
}

static void on_connection_lost(void* const context, const uint64_t now_ns)
{
    (void)context; // The device continues to measure.
    (void)now_ns;
}

static void on_reset(void* const context, const uint64_t now_ns)
{
    measuring_device_t* device = context;
    (void)now_ns;
    device->delayed_count = 0U;
    memset(device->error, 0, sizeof device->error);
}

void measuring_device_end_step(measuring_device_t* const device, const uint64_t now_ns)
{
    const uint64_t period_ns = device->config.period_ns;
    if ((period_ns == 0U) || (now_ns < device->next_ns)) {
        return;
    }
    const uint64_t number = now_ns / period_ns;
    device->next_ns       = (number + 1U) * period_ns;
    if (node_is_powered(device->node)) {
        expose(device, number, now_ns);
    }
}

void measuring_device_set_error(measuring_device_t* const device, const uint16_t code, const bool is_present,
                                const uint64_t now_ns)
{
    // A high temperature does not make the measurements invalid.
    const bool is_warning = (code == EMERGENCY_DEVICE_TEMPERATURE) || (code == EMERGENCY_DRIVE_TEMPERATURE);
    unsigned index        = 0U;
    if (is_present) {
        node_raise(device->node, code, 0U, 0, now_ns);
    } else {
        node_clear(device->node, code, 0U, now_ns);
    }
    while ((index < ERRORS_MAX) && (device->error[index] != code)) {
        index++;
    }
    for (unsigned i = 0U; (index == ERRORS_MAX) && is_present && !is_warning && (i < ERRORS_MAX); i++) {
        index = (device->error[i] == 0U) ? i : index;
    }
    if (index < ERRORS_MAX) {
        device->error[index] = is_present ? code : 0U;
    }
}

// ---- Creation ----

/// Returns the object if it is real, or if it is an integer, as wanted; otherwise null.
static object_t* of_kind(object_t* const object, const bool is_real)
{
    return ((object != NULL) && (object_is_real(object) == is_real)) ? object : NULL;
}

static bool find_value(measuring_device_t* const device, const unsigned index)
{
    const uint8_t member = (uint8_t)(index + 1U);
    node_t* node         = device->node;
    const bool is_404 = (node_object(node, 0x9130U, 1U) != NULL) || (node_object(node, 0x6130U, 1U) != NULL);
    const object_t* digits = is_404
                                 ? node_object(node, 0x6132U, member)
                                 : node_object_named(node, "Decimal digits of the measured values", member);
    object_t* const value =
        is_404 ? node_object(node, 0x9130U, member) : node_object_named(node, "Measured values", member);
    device->value[index] = of_kind(value, false);
    device->real[index]  = of_kind(is_404 ? node_object(node, 0x6130U, member) : value, true);
    device->status[index] =
        is_404 ? node_object(node, 0x6150U, member) : node_object_named(node, "Status (1: not valid)", 0U);
    device->factor[index]    = (digits != NULL) ? pow(10.0, (double)object_signed(digits)) : 0.0;
    const void* const needed = (device->value[index] != NULL) ? (const void*)digits : device->real[index];
    return (needed != NULL) && (device->status[index] != NULL);
}

static bool find_objects(void* const context)
{
    measuring_device_t* device = context;
    bool is_whole              = true;
    device->counter            = node_object_named(device->node, "Counter of measurements", 0U);
    device->stamp_syncs        = node_object_named(device->node, "Stamp of the exposure", 1U);
    device->stamp_us           = node_object_named(device->node, "Stamp of the exposure", 2U);
    for (unsigned i = 0U; i < device->config.value_count; i++) {
        is_whole = is_whole && find_value(device, i);
    }
    return is_whole && (device->counter != NULL) &&
           ((device->stamp_syncs == NULL) == (device->stamp_us == NULL));
}

status_t measuring_device_create(bus_t* const bus, const char* const eds_path, const uint8_t id,
                                 const measuring_config_t* const config,
                                 measuring_device_t** const out_device, char error[EDS_ERROR_MAX])
{
    *out_device                = NULL;
    measuring_device_t* device = calloc(1U, sizeof *device);
    if (device == NULL) {
        (void)snprintf(error, EDS_ERROR_MAX, "%s: out of memory", eds_path);
        return STATUS_EXHAUSTED;
    }
    const node_application_t application = {.name            = "a measuring device",
                                            .find            = find_objects,
                                            .sample          = on_sample,
                                            .written         = on_written,
                                            .connection_lost = on_connection_lost,
                                            .reset           = on_reset,
                                            .context         = device};
    device->config                       = *config;
    const status_t status                = node_create(bus, eds_path, id, &application, &device->node, error);
    if (status != STATUS_OK) {
        free(device);
        return status;
    }
    *out_device = device;
    return STATUS_OK;
}

void measuring_device_destroy(measuring_device_t* const device)
{
    if (device != NULL) {
        node_destroy(device->node);
        free(device);
    }
}

node_t* measuring_device_node(measuring_device_t* const device)
{
    return device->node;
}
