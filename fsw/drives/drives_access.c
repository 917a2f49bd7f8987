// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives_access.h"

#include "fsw/drives/drives_quantity.h"
#include "fsw/drives/drives_supply.h"
#include "base/assertion.h"
#include "base/octets.h"
#include "base/value.h"

#include <string.h>

#define NODE_SHIFT 24U // Position of the node id in the address of a register [bits].
#define INDEX_SHIFT 8U
#define REGISTER_SIZE 4U
#define ABORT_SHIFT 16U

typedef struct {    // An object of a device.
    uint8_t device; // Index in drives_t.devices.
    uint8_t subindex;
    uint16_t index;
    uint8_t length;
    bool is_read;
    const descriptor_quantity_t* quantity; // Null: the object was not addressed by a quantity.
} object_t;

static bool is_register(const pus_device_action_t* const action)
{
    return (action->kind == PUS_DEVICE_LOAD_REGISTER) || (action->kind == PUS_DEVICE_DUMP_REGISTER);
}

static bool is_logical(const pus_device_action_t* const action)
{
    return (action->kind == PUS_DEVICE_LOGICAL_COMMAND) || (action->kind == PUS_DEVICE_LOGICAL_ACQUIRE);
}

/// Find the object of a quantity. STATUS_OK, STATUS_NOT_FOUND (device), STATUS_OUT_OF_RANGE (no such
/// quantity, or it cannot have that value).
static status_t quantity_of(const drives_t* const drives, const pus_device_action_t* const action,
                            object_t* const out_object)
{
    uint8_t octets[DRIVES_QUANTITY_OCTETS];
    const bool is_read                    = (action->kind == PUS_DEVICE_LOGICAL_ACQUIRE);
    const uint32_t id                     = is_read ? action->address : action->command;
    const descriptor_quantity_t* quantity = NULL;
    const status_t status                 = drives_quantity_find(drives, action->device, id, &quantity);
    if (status != STATUS_OK) {
        return status;
    }
    *out_object            = (object_t){.index    = quantity->index,
                                        .subindex = quantity->subindex,
                                        .length   = (uint8_t)value_size(quantity->type),
                                        .is_read  = is_read,
                                        .quantity = quantity};
    const bool is_settable = quantity->is_settable && (action->size == DRIVES_QUANTITY_OCTETS) &&
                             drives_quantity_to_object(quantity, action->data, octets);
    return (is_read || is_settable) ? STATUS_OK : STATUS_OUT_OF_RANGE;
}

/// Find the object that an action addresses. STATUS_OK, STATUS_NOT_FOUND (no such device),
/// STATUS_OUT_OF_RANGE (length).
static status_t object_of(const drives_t* const drives, const pus_device_action_t* const action,
                          object_t* const out_object)
{
    uint32_t node = action->device;
    *out_object   = (object_t){0};
    if (is_logical(action)) {
        const status_t status = quantity_of(drives, action, out_object);
        if (status != STATUS_OK) {
            return status;
        }
    } else if (is_register(action)) {
        node                 = action->address >> NODE_SHIFT;
        out_object->index    = (uint16_t)((action->address >> INDEX_SHIFT) & 0xFFFFU);
        out_object->subindex = (uint8_t)(action->address & 0xFFU);
        out_object->length   = REGISTER_SIZE;
        out_object->is_read  = (action->kind == PUS_DEVICE_DUMP_REGISTER);
    } else { // PUS_DEVICE_COMMAND or PUS_DEVICE_ACQUIRE; pulses do not address objects.
        out_object->index    = octets_u16_at(action->protocol);
        out_object->subindex = action->protocol[2];
        out_object->length   = action->protocol[3];
        out_object->is_read  = (action->kind == PUS_DEVICE_ACQUIRE);
    }
    out_object->device = drives_find(drives, node);
    if (out_object->device == NETWORK_NO_DEVICE) {
        return STATUS_NOT_FOUND;
    }
    const bool is_written = !out_object->is_read && (out_object->quantity == NULL);
    const bool is_wrong =
        (out_object->length > SDO_OCTETS_MAX) ||
        (is_written && ((out_object->length == 0U) || (out_object->length != action->size)));
    return is_wrong ? STATUS_OUT_OF_RANGE : STATUS_OK;
}

static status_t check(void* const context, const pus_device_action_t* const action)
{
    const drives_t* const drives = context;
    object_t object;
    if (drives_supply_is(action)) {
        return drives_supply_check(drives, action);
    }
    const status_t status = object_of(drives, action, &object);
    return ((status == STATUS_OK) && !drives_are_running(drives)) ? STATUS_FORBIDDEN : status;
}

static status_t fail(pus_device_result_t* const out_result, const uint16_t code, const uint32_t detail)
{
    out_result->return_code = code;
    out_result->detail      = detail;
    return STATUS_IO;
}

static canopen_sdo_client_t* client_of(drives_t* const drives, const uint8_t device)
{
    const canopen_device_t* const node = &drives->devices[device].device;
    return &node->master->nodes[node->index].sdo;
}

/// Write the data of an action in the order of SDO, lowest octet first.
static void data_of(const pus_device_action_t* const action, const object_t* const object,
                    uint8_t* const out_octets)
{
    if (object->is_read) {
        return;
    }
    if (object->quantity != NULL) {
        // The check of the request has accepted the value.
        (void)drives_quantity_to_object(object->quantity, action->data, out_octets);
        return;
    }
    for (uint8_t i = 0U; i < object->length; i++) { // The value of a register begins with its highest octet.
        out_octets[i] = action->data[is_register(action) ? (REGISTER_SIZE - 1U - i) : i];
    }
}

static status_t begin_pulse(drives_t* const drives, const uint8_t slot,
                            const pus_device_action_t* const action, pus_device_result_t* const out_result)
{
    const status_t status      = drives_supply_send(drives, action);
    drives->access.slots[slot] = (drives_transfer_t){.is_pulse = true};
    return ((status == STATUS_OK) || (status == STATUS_FULL))
               ? status
               : fail(out_result, DRIVES_ACCESS_CLOSED, DRIVES_ACCESS_CLOSED);
}

static status_t begin(void* const context, const uint8_t slot, const pus_device_action_t* const action,
                      pus_device_result_t* const out_result)
{
    drives_t* const drives = context;
    FSW_ASSERT(slot < DRIVES_ACCESS_SLOTS);
    object_t object;
    if (drives_supply_is(action)) {
        return begin_pulse(drives, slot, action, out_result);
    }
    if ((object_of(drives, action, &object) != STATUS_OK) || !drives_are_running(drives)) {
        // After the check of the request process data was stopped, or the buses were closed.
        return fail(out_result, DRIVES_ACCESS_CLOSED, DRIVES_ACCESS_CLOSED);
    }
    if (drives->access.owners[object.device] != 0U) {
        return STATUS_FULL;
    }
    uint8_t octets[SDO_OCTETS_MAX] = {0U};
    data_of(action, &object, octets);
    canopen_sdo_client_t* const client = client_of(drives, object.device);
    const status_t status =
        object.is_read
            ? canopen_sdo_client_upload(client, object.index, object.subindex)
            : canopen_sdo_client_download(client, object.index, object.subindex, octets, object.length);
    // The client of the node is busy: the request waits.
    if (status != STATUS_OK) {
        return STATUS_FULL;
    }
    drives->access.owners[object.device] = (uint8_t)(slot + 1U);
    drives->access.slots[slot]           = (drives_transfer_t){.device      = object.device,
                                                               .length      = object.length,
                                                               .is_read     = object.is_read,
                                                               .is_register = is_register(action),
                                                               .quantity    = object.quantity};
    return STATUS_OK;
}

/// Convert the value that was read into the result of the request.
static status_t take_value(const drives_transfer_t* const transfer, const canopen_sdo_client_t* const client,
                           pus_device_result_t* const out_result)
{
    size_t size                 = 0U;
    const uint8_t* const octets = canopen_sdo_client_value(client, &size);
    if ((transfer->length != 0U) && (size != transfer->length)) {
        return fail(out_result, DRIVES_ACCESS_WRONG, DRIVES_ACCESS_WRONG);
    }
    if (transfer->quantity != NULL) {
        drives_quantity_of_object(transfer->quantity, octets, out_result->data);
        out_result->size = (uint16_t)DRIVES_QUANTITY_OCTETS;
        return STATUS_OK;
    }
    out_result->size = (uint16_t)size;
    for (size_t i = 0U; i < size; i++) {
        out_result->data[i] = octets[transfer->is_register ? (size - 1U - i) : i];
    }
    return STATUS_OK;
}

/// Check the transfer of a slot. Its result frees the device for the next transfer.
static status_t poll(void* const context, const uint8_t slot, pus_device_result_t* const out_result)
{
    drives_t* const drives                  = context;
    const drives_transfer_t* const transfer = &drives->access.slots[slot];
    if (transfer->is_pulse) {
        return drives_supply_poll(drives);
    }
    const canopen_sdo_client_t* const client = client_of(drives, transfer->device);
    uint32_t abort_code                      = 0U;
    status_t status =
        drives_are_running(drives) ? canopen_sdo_client_result(client, &abort_code) : STATUS_CLOSED;
    if (status == STATUS_BUSY) {
        return status;
    }
    drives->access.owners[transfer->device] = 0U;
    switch (status) {
    case STATUS_OK:
        return transfer->is_read ? take_value(transfer, client, out_result) : STATUS_OK;
    case STATUS_FORBIDDEN:
        return fail(out_result, (uint16_t)(abort_code >> ABORT_SHIFT), abort_code);
    case STATUS_TIMEOUT:
        return fail(out_result, (uint16_t)(SDO_ABORT_TIMEOUT >> ABORT_SHIFT), SDO_ABORT_TIMEOUT);
    case STATUS_CLOSED:
    case STATUS_EMPTY:
        return fail(out_result, DRIVES_ACCESS_CLOSED, DRIVES_ACCESS_CLOSED);
    default:
        return fail(out_result, DRIVES_ACCESS_WRONG, DRIVES_ACCESS_WRONG);
    }
}

static void abandon(void* const context, const uint8_t slot)
{
    drives_t* const drives = context;
    const uint8_t device   = drives->access.slots[slot].device;
    if (drives->access.slots[slot].is_pulse) {
        drives_give_back(drives);
        return;
    }
    // While process data do not flow, commissioning uses the client: do not reset it.
    if (drives_are_running(drives)) {
        canopen_sdo_client_reset(client_of(drives, device));
    }
    drives->access.owners[device] = 0U;
}

pus_device_port_t drives_access_port(void* const self)
{
    FSW_ASSERT(self != NULL);
    return (pus_device_port_t){
        .context = self, .check = check, .begin = begin, .poll = poll, .abandon = abandon};
}
