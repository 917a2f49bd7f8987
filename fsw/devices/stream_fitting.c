// SPDX-License-Identifier: Apache-2.0
#include "fsw/devices/stream_devices.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

static bool refuse(subsystem_misfit_t* const misfit, const uint32_t line, const char* const reason)
{
    *misfit = (subsystem_misfit_t){line, reason, 0U};
    return false;
}

/// True if an end node marks the end of each record.
static bool is_framed(const descriptor_endnode_t* const endnode)
{
    const bool is_stream = (endnode->type == DESCRIPTOR_ENDNODE_TCP) ||
                           (endnode->type == DESCRIPTOR_ENDNODE_SERIAL) ||
                           (endnode->type == DESCRIPTOR_ENDNODE_FILE);
    return !is_stream || (endnode->format.framing == FLOW_FRAMING_LENGTH) ||
           (endnode->format.framing == FLOW_FRAMING_SLIP);
}

/// Returns the number of fields in the record of one direction.
static uint16_t count_fields(const subsystem_descriptor_t* const descriptor,
                             const descriptor_device_t* const device, const bool is_out)
{
    uint16_t count = 0U;
    for (uint16_t i = 0U; i < device->record_field_count; i++) {
        if (descriptor->record_fields[device->first_record_field + i].is_out == is_out) {
            count++;
        }
    }
    return count;
}

static bool endnode_fits(const subsystem_descriptor_t* const descriptor,
                         const descriptor_device_t* const device, subsystem_misfit_t* const out_misfit)
{
    if ((device->setting_count > 0U) || (device->quantity_count > 0U) || (device->supply_count > 0U)) {
        return refuse(out_misfit, device->line,
                      "<Device> of type \"stream\": expected no <Setting>, <Quantity> or <Supply>");
    }
    if (device->endnode_count != 1U) {
        return refuse(out_misfit, device->line, "<Device> of type \"stream\": expected one <Endnode>");
    }
    const descriptor_endnode_t* const endnode = &descriptor->endnodes[device->first_endnode];
    if (endnode->type == DESCRIPTOR_ENDNODE_CAN) {
        return refuse(out_misfit, endnode->line,
                      "type=\"CAN\" of <Endnode>: expected SHM, MQUEUE, UDP, TCP, SERIAL or FILE, by which "
                      "this subsystem reaches its devices");
    }
    if (!is_framed(endnode)) {
        return refuse(out_misfit, endnode->line,
                      "framing of <Endnode>: expected LENGTH or SLIP, which mark the end of a record");
    }
    const bool sends = (count_fields(descriptor, device, false) > 0U);
    const bool takes = (count_fields(descriptor, device, true) > 0U);
    if ((takes && (endnode->format.direction == FLOW_DIRECTION_READ)) ||
        (sends && (endnode->format.direction == FLOW_DIRECTION_WRITE))) {
        return refuse(
            out_misfit, endnode->line,
            "direction of <Endnode>: expected BOTH, or a <Device> with fields of that direction only");
    }
    return true;
}

/// True if both have the same name or port. Two devices on one end node would receive each other's records.
static bool is_same(const descriptor_endnode_t* const one, const descriptor_endnode_t* const other)
{
    if (one->type != other->type) {
        return false;
    }
    const bool has_port = (one->type == DESCRIPTOR_ENDNODE_UDP) || (one->type == DESCRIPTOR_ENDNODE_TCP);
    return has_port ? (one->port == other->port) : (strcmp(one->name, other->name) == 0);
}

static bool endnode_is_free(const subsystem_descriptor_t* const descriptor, const uint16_t index,
                            subsystem_misfit_t* const out_misfit)
{
    const descriptor_endnode_t* const endnode =
        &descriptor->endnodes[descriptor->devices[index].first_endnode];
    for (uint16_t i = 0U; i < index; i++) {
        const descriptor_device_t* const other = &descriptor->devices[i];
        if (descriptor_is_stream(other) && is_same(endnode, &descriptor->endnodes[other->first_endnode])) {
            return refuse(out_misfit, endnode->line,
                          "name or port of <Endnode>: expected one that no device above has");
        }
    }
    return true;
}

static bool has_field(const subsystem_descriptor_t* const descriptor, const descriptor_device_t* const device,
                      const bool is_out, const char* const name)
{
    for (uint16_t i = 0U; i < device->record_field_count; i++) {
        const descriptor_record_field_t* const field =
            &descriptor->record_fields[device->first_record_field + i];
        if ((field->is_out == is_out) && (strcmp(field->name, name) == 0)) {
            return true;
        }
    }
    return false;
}

static bool fields_fit(const subsystem_descriptor_t* const descriptor,
                       const descriptor_device_t* const device, const stream_devices_need_t* const need,
                       subsystem_misfit_t* const out_misfit)
{
    for (const char* const* name = need->in; *name != NULL; name++) {
        if (!has_field(descriptor, device, false, *name)) {
            return refuse(out_misfit, device->line, need->reason_in);
        }
    }
    for (const char* const* name = need->out; *name != NULL; name++) {
        if (!has_field(descriptor, device, true, *name)) {
            return refuse(out_misfit, device->line, need->reason_out);
        }
    }
    if ((count_fields(descriptor, device, false) > STREAM_RECORD_FIELDS_MAX) ||
        (count_fields(descriptor, device, true) > STREAM_RECORD_FIELDS_MAX)) {
        return refuse(out_misfit, device->line, "too many <Field> of one direction, at most 16");
    }
    return true;
}

bool stream_devices_fit(const subsystem_descriptor_t* const descriptor,
                        const stream_devices_need_t* const need, subsystem_misfit_t* const out_misfit)
{
    FSW_ASSERT((descriptor != NULL) && (need != NULL) && (out_misfit != NULL));
    FSW_ASSERT(need->most <= STREAM_DEVICES_MAX);
    uint16_t count = 0U;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        const descriptor_device_t* const device = &descriptor->devices[i];
        if (!descriptor_is_stream(device) && need->permits_drives) {
            continue;
        }
        count++;
        if (count > need->most) {
            return refuse(out_misfit, device->line, need->reason_most);
        }
        if (!descriptor_is_stream(device)) {
            return refuse(out_misfit, device->line, "type of <Device>: expected \"stream\"");
        }
        if (!endnode_fits(descriptor, device, out_misfit) || !endnode_is_free(descriptor, i, out_misfit) ||
            !fields_fit(descriptor, device, need, out_misfit)) {
            return false;
        }
    }
    return true;
}
