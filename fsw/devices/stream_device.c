// SPDX-License-Identifier: Apache-2.0
#include "fsw/devices/stream_device.h"

#include "base/assertion.h"
#include "base/capacities.h"
#include "base/text.h"

#include <string.h>

#define US_NS 1000U
#define RECORDS_PER_CALL 64U ///< Bound, so that a device that sends without a pause cannot hold the cycle.

CAPACITY_CHECK(a_record_fits_a_message, STREAM_RECORD_OCTETS_MAX <= FLOW_OCTETS_MAX);

static flow_endnode_kind_t kind_of(const descriptor_endnode_type_t type)
{
    static const flow_endnode_kind_t kinds[] = {
        [DESCRIPTOR_ENDNODE_CAN] = ENDNODE_CAN,       [DESCRIPTOR_ENDNODE_SHM] = ENDNODE_SHM,
        [DESCRIPTOR_ENDNODE_MQUEUE] = ENDNODE_MQUEUE, [DESCRIPTOR_ENDNODE_UDP] = ENDNODE_UDP,
        [DESCRIPTOR_ENDNODE_TCP] = ENDNODE_TCP,       [DESCRIPTOR_ENDNODE_SERIAL] = ENDNODE_SERIAL,
        [DESCRIPTOR_ENDNODE_FILE] = ENDNODE_FILE};
    return kinds[type];
}

/// Returns the name of an end node for the resolver.
static const char* name_of(const descriptor_endnode_t* const endnode, char out_address[ENDNODE_ADDRESS_MAX])
{
    if ((endnode->type != DESCRIPTOR_ENDNODE_UDP) && (endnode->type != DESCRIPTOR_ENDNODE_TCP)) {
        return endnode->name;
    }
    text_t text = text_in(out_address, ENDNODE_ADDRESS_MAX);
    text_add(&text, endnode->address);
    text_add(&text, ":");
    text_add_unsigned(&text, endnode->port);
    return out_address;
}

void stream_device_init(stream_device_t* const device, const subsystem_descriptor_t* const descriptor,
                        const descriptor_device_t* const source, const flow_resolver_t* const resolver)
{
    FSW_ASSERT((device != NULL) && (descriptor != NULL) && (source != NULL) && (resolver != NULL));
    FSW_ASSERT(source->endnode_count == 1U);
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[source->first_endnode];
    (void)memset(device, 0, sizeof *device);
    device->name       = source->name;
    device->silence_ns = (uint64_t)endnode->silence_us * US_NS;
    stream_record_init(&device->in, descriptor, source, false);
    stream_record_init(&device->out, descriptor, source, true);
    stream_record_set_safe(&device->out);
    const flow_setup_t setup = {.kind             = kind_of(endnode->type),
                                .name             = name_of(endnode, device->address),
                                .format           = endnode->format,
                                .octets_in        = stream_record_octets(&device->in),
                                .octets_out       = stream_record_octets(&device->out),
                                .retry_first_ns   = (uint64_t)endnode->retry_us * US_NS,
                                .retry_longest_ns = (uint64_t)endnode->longest_us * US_NS};
    flow_init(&device->flow, &setup, resolver);
}

uint8_t stream_device_field(const stream_device_t* const device, const bool is_out, const char* const name)
{
    FSW_ASSERT((device != NULL) && (name != NULL));
    const stream_record_t* const record = is_out ? &device->out : &device->in;
    for (uint8_t i = 0U; i < record->field_count; i++) {
        if (strcmp(record->sources[i]->name, name) == 0) {
            return i;
        }
    }
    return STREAM_DEVICE_NO_FIELD;
}

// ---- Faults ----

static void set_fault(stream_device_t* const device, const stream_device_fault_kind_t kind,
                      const stream_device_cause_t cause)
{
    device->fault     = (stream_device_fault_t){.kind = kind, .cause = cause};
    device->has_fault = true;
}

/// Returns the number of octets and invalid records received. It changes with each arrival on a byte stream;
/// on other end nodes with each invalid record.
static uint32_t count_arrivals(const stream_device_t* const device)
{
    const flow_counters_t counters = flow_counters(&device->flow);
    return device->counters.unfit + counters.malformed + counters.octets;
}

static stream_device_cause_t cause_of(const stream_device_t* const device)
{
    if (!device->is_open) {
        return STREAM_CAUSE_CLOSED;
    }
    return (count_arrivals(device) != device->arrivals_counted) ? STREAM_CAUSE_MALFORMED
                                                                : STREAM_CAUSE_SILENT;
}

status_t stream_device_take_fault(stream_device_t* const device, stream_device_fault_t* const out_fault)
{
    FSW_ASSERT((device != NULL) && (out_fault != NULL));
    if (!device->has_fault) {
        return STATUS_EMPTY;
    }
    *out_fault        = device->fault;
    device->has_fault = false;
    return STATUS_OK;
}

// ---- The cycle ----

/// Record that the device has shown that it is present.
static void mark_present(stream_device_t* const device, const uint64_t now_ns)
{
    device->heard_ns         = now_ns;
    device->arrivals_counted = count_arrivals(device);
    device->has_heard        = true;
    device->is_refused       = false;
    if (device->is_lost) {
        device->is_lost = false;
        set_fault(device, STREAM_DEVICE_RETURNED, STREAM_CAUSE_NONE);
    }
}

static void receive(stream_device_t* const device, const uint64_t now_ns)
{
    uint8_t octets[FLOW_OCTETS_MAX];
    size_t size     = 0U;
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (status == STATUS_OK) && (i < RECORDS_PER_CALL); i++) {
        status = flow_receive(&device->flow, octets, &size);
        if (status != STATUS_OK) {
            device->is_open = (status != STATUS_CLOSED);
        } else if (stream_record_take(&device->in, octets, size) == STATUS_OK) {
            device->counters.received++;
            mark_present(device, now_ns);
        } else {
            device->counters.unfit++;
        }
    }
}

static bool is_silent(const stream_device_t* const device, const uint64_t now_ns)
{
    return (now_ns - device->heard_ns) >= device->silence_ns;
}

/// Detect faults. A device in use is lost when its end node is closed, or after silence_ns without a record.
/// A device that is not yet in use is refused after silence_ns without a record.
static void watch(stream_device_t* const device, const uint64_t now_ns)
{
    if (device->is_started && !device->is_lost && (is_silent(device, now_ns) || !device->is_open)) {
        device->is_lost = true;
        set_fault(device, STREAM_DEVICE_LOST, cause_of(device));
    }
    if (device->is_begun && !device->is_started && !device->is_refused && is_silent(device, now_ns)) {
        device->is_refused = true;
        set_fault(device, STREAM_DEVICE_REFUSED, cause_of(device));
    }
    // The connection may be broken although it looks open: close it, so that the flow connects again.
    if (device->is_begun && device->is_open && is_silent(device, now_ns) &&
        ((now_ns - device->opened_ns) >= device->silence_ns)) {
        flow_give_up(&device->flow);
    }
}

void stream_device_sense(stream_device_t* const device, const uint64_t now_ns)
{
    FSW_ASSERT(device != NULL);
    const bool was_open = device->is_open;
    device->is_open     = (flow_step(&device->flow, now_ns) == STATUS_OK);
    device->opened_ns   = was_open ? device->opened_ns : now_ns;
    if (device->is_open) {
        receive(device, now_ns);
    }
    if (device->is_open && (device->in.field_count == 0U)) {
        // The device sends no records: only the open end node shows that it is present.
        mark_present(device, now_ns);
    }
    watch(device, now_ns);
}

static status_t send(stream_device_t* const device)
{
    uint8_t octets[STREAM_RECORD_OCTETS_MAX];
    if (device->out.field_count == 0U) {
        return STATUS_OK;
    }
    const size_t size     = stream_record_put(&device->out, octets);
    const status_t status = flow_send(&device->flow, octets, size);
    if (status == STATUS_OK) {
        device->counters.sent++;
    } else {
        device->counters.refused++;
    }
    return status;
}

void stream_device_command(stream_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    if (device->is_started && device->is_open) {
        (void)send(device);
    }
}

// ---- Commissioning ----

status_t stream_device_open(stream_device_t* const device, const uint64_t now_ns)
{
    FSW_ASSERT(device != NULL);
    if (!device->is_begun) {
        device->is_begun = true;
        device->heard_ns = now_ns;
    }
    return device->is_open ? STATUS_OK : STATUS_BUSY;
}

status_t stream_device_boot(const stream_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    return device->has_heard ? STATUS_OK : STATUS_BUSY;
}

status_t stream_device_start(stream_device_t* const device, const uint64_t now_ns)
{
    FSW_ASSERT(device != NULL);
    if (!device->is_open || !device->has_heard || is_silent(device, now_ns)) {
        return STATUS_BUSY;
    }
    stream_record_set_safe(&device->out);
    device->is_started = true;
    device->is_lost    = false;
    device->heard_ns   = now_ns;
    return STATUS_OK;
}

status_t stream_device_secure(stream_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    stream_record_set_safe(&device->out);
    const status_t status = device->is_open ? send(device) : STATUS_CLOSED;
    return (status == STATUS_FULL) ? STATUS_BUSY : STATUS_OK;
}

status_t stream_device_stop(stream_device_t* const device)
{
    const status_t status = stream_device_secure(device);
    if (status == STATUS_OK) {
        device->is_started = false;
        device->is_lost    = false;
    }
    return status;
}

void stream_device_close(stream_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    flow_close(&device->flow);
    device->is_begun   = false;
    device->is_open    = false;
    device->is_started = false;
    device->has_heard  = false;
    device->is_refused = false;
    device->is_lost    = false;
    device->has_fault  = false;
}

// ---- Values ----

double stream_device_value(const stream_device_t* const device, const uint8_t field)
{
    FSW_ASSERT(device != NULL);
    return stream_record_value(&device->in, field);
}

bool stream_device_is_lost(const stream_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    return device->is_lost;
}

status_t stream_device_set(stream_device_t* const device, const uint8_t field, const double value)
{
    FSW_ASSERT(device != NULL);
    return stream_record_set(&device->out, field, value);
}
