// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/device.h"

#include "base/assertion.h"

#include <stddef.h>

#define OBJECT_DEVICE_TYPE 0x1000U
#define OBJECT_IDENTITY 0x1018U
#define IDENTITY_VENDOR 1U
#define IDENTITY_PRODUCT 2U
#define OBJECT_RECEIVE_PARAMETER 0x1400U
#define OBJECT_RECEIVE_MAPPING 0x1600U
#define OBJECT_TRANSMIT_PARAMETER 0x1800U
#define OBJECT_TRANSMIT_MAPPING 0x1A00U
#define OBJECT_TEMPERATURE 0x2210U
#define OBJECT_PROFILE_AREA 0x6000U
#define OBJECT_CONTROLWORD 0x6040U
#define OBJECT_STATUSWORD 0x6041U
#define OBJECT_POSITION 0x6064U
#define OBJECT_VELOCITY 0x606CU
#define OBJECT_TARGET_TORQUE 0x6071U
#define OBJECT_MAX_TORQUE 0x6072U
#define OBJECT_RATED_TORQUE 0x6076U
#define OBJECT_TORQUE 0x6077U
#define OBJECT_CURRENT 0x6078U
#define OBJECT_TARGET_POSITION 0x607AU
#define OBJECT_TORQUE_OFFSET 0x60B2U
#define OBJECT_DIGITAL_INPUTS 0x60FDU
#define OBJECT_TARGET_VELOCITY 0x60FFU

#define PER_MILLE 0.001
#define MILLI 0.001

#define FIRST_UNIT 3U // Place of the units among the accesses that identify a device.

void canopen_device_reset(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    const canopen_device_profile_t* const profile = device->profile;
    for (uint8_t i = 0U; i < profile->transmit_count; i++) {
        device->transmit[i] =
            (canopen_device_pdo_t){.cob      = (uint16_t)(profile->transmit[i].cob_base + device->node),
                                   .is_valid = profile->transmit[i].is_valid};
    }
    for (uint8_t i = 0U; i < profile->receive_count; i++) {
        device->receive[i] =
            (canopen_device_pdo_t){.cob      = (uint16_t)(profile->receive[i].cob_base + device->node),
                                   .is_valid = profile->receive[i].is_valid};
    }
    for (uint8_t i = 0U; i < PROFILE_AXES_MAX; i++) {
        canopen_cia402_axis_init(&device->axes[i],
                                 (canopen_cia402_scale_t){.position_rad   = profile->position_rad,
                                                          .velocity_rad_s = profile->velocity_rad_s,
                                                          .torque_nm      = PER_MILLE});
    }
}

status_t canopen_device_attach(canopen_device_t* const device, canopen_master_t* const master,
                               const canopen_device_profile_t* const profile, const uint8_t node)
{
    FSW_ASSERT((device != NULL) && (master != NULL) && (profile != NULL));
    uint8_t index         = 0U;
    const status_t status = canopen_master_add_node(master, node, &index);
    if (status == STATUS_OK) {
        *device = (canopen_device_t){.profile = profile, .master = master, .node = node, .index = index};
        canopen_device_reset(device);
    }
    return status;
}

// ---- Commissioning ----

static void ask(canopen_device_t* const device, uint16_t* const count, const canopen_setting_t setting)
{
    FSW_ASSERT(*count < DEVICE_IDENTIFY_MAX);
    device->identify[*count] = setting;
    (*count)++;
}

/// A number of four octets that the device must have.
static void ask_number(canopen_device_t* const device, uint16_t* const count, const uint16_t index,
                       const uint8_t subindex, const uint32_t value)
{
    ask(device, count,
        (canopen_setting_t){
            .index = index, .subindex = subindex, .octets = 4U, .kind = SETTING_VERIFY, .value = value});
}

static void ask_mapping(canopen_device_t* const device, uint16_t* const count, const uint16_t object,
                        const canopen_profile_pdo_t* const pdo)
{
    ask(device, count,
        (canopen_setting_t){
            .index = object, .octets = 1U, .kind = SETTING_VERIFY, .value = pdo->entry_count});
    for (uint8_t i = 0U; i < pdo->entry_count; i++) {
        const canopen_profile_entry_t* const entry = &pdo->entries[i];
        const uint32_t value = ((uint32_t)entry->index << 16) | ((uint32_t)entry->subindex << 8) |
                               ((uint32_t)entry->octets * 8U);
        ask_number(device, count, object, (uint8_t)(i + 1U), value);
    }
}

void canopen_device_identify(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    const canopen_device_profile_t* const profile = device->profile;
    uint16_t count                                = 0U;
    ask_number(device, &count, OBJECT_DEVICE_TYPE, 0U, profile->device_type);
    ask_number(device, &count, OBJECT_IDENTITY, IDENTITY_VENDOR, profile->vendor_id);
    ask_number(device, &count, OBJECT_IDENTITY, IDENTITY_PRODUCT, profile->product_code);
    FSW_ASSERT(count == FIRST_UNIT);
    for (uint8_t i = 0U; i < profile->axis_count;
         i++) { // canopen_device_identify_step finds these by their place.
        const uint16_t offset = (uint16_t)(i * PROFILE_AXIS_STEP);
        ask(device, &count,
            (canopen_setting_t){
                .index = (uint16_t)(OBJECT_RATED_TORQUE + offset), .octets = 4U, .kind = SETTING_READ});
        ask(device, &count,
            (canopen_setting_t){
                .index = (uint16_t)(OBJECT_MAX_TORQUE + offset), .octets = 2U, .kind = SETTING_READ});
    }
    for (uint8_t i = 0U; i < profile->transmit_count; i++) {
        ask_mapping(device, &count, (uint16_t)(OBJECT_TRANSMIT_MAPPING + i), &profile->transmit[i]);
    }
    for (uint8_t i = 0U; i < profile->receive_count; i++) {
        ask_mapping(device, &count, (uint16_t)(OBJECT_RECEIVE_MAPPING + i), &profile->receive[i]);
    }
    canopen_setting_run_begin(&device->run, device->identify, count);
}

static canopen_sdo_client_t* client_of(canopen_device_t* const device)
{
    return &device->master->nodes[device->index].sdo;
}

status_t canopen_device_identify_step(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    const status_t status = canopen_setting_run_step(&device->run, client_of(device));
    if (status != STATUS_OK) {
        return status;
    }
    for (uint8_t i = 0U; i < device->profile->axis_count; i++) {
        const uint16_t unit    = (uint16_t)(FIRST_UNIT + (2U * i));
        const double rated_nm  = (double)device->identify[unit].value * MILLI;
        const double max_share = (double)device->identify[unit + 1U].value * PER_MILLE;
        if (!(rated_nm > 0.0)) {
            device->run.position       = unit;
            device->run.is_other_value = true;
            return STATUS_INVALID;
        }
        canopen_cia402_scale_t scale = device->axes[i].scale;
        scale.torque_nm              = rated_nm * PER_MILLE;
        scale.torque_max_nm          = rated_nm * max_share;
        canopen_cia402_axis_init(&device->axes[i], scale);
    }
    return STATUS_OK;
}

void canopen_device_configure(canopen_device_t* const device, canopen_setting_t* const settings,
                              const uint16_t count)
{
    FSW_ASSERT(device != NULL);
    canopen_setting_run_begin(&device->run, settings, count);
}

/// Settings of communication parameters change the expected and sent PDOs.
static void follow_setting(canopen_device_pdo_t* const pdos, const uint8_t count, const uint16_t first_object,
                           const canopen_setting_t* const setting)
{
    const bool is_cob_id = (setting->subindex == 1U) && (setting->index >= first_object) &&
                           (setting->index < (first_object + count));
    if (is_cob_id) {
        canopen_device_pdo_t* const pdo = &pdos[setting->index - first_object];
        pdo->cob                        = (uint16_t)(setting->value & COB_PDO_ID_MASK);
        pdo->is_valid                   = (setting->value & COB_PDO_INVALID) == 0U;
    }
}

status_t canopen_device_configure_step(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    const status_t status = canopen_setting_run_step(&device->run, client_of(device));
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < device->run.count); i++) {
        const canopen_setting_t* const setting = &device->run.settings[i];
        follow_setting(device->transmit, device->profile->transmit_count, OBJECT_TRANSMIT_PARAMETER, setting);
        follow_setting(device->receive, device->profile->receive_count, OBJECT_RECEIVE_PARAMETER, setting);
    }
    return status;
}

// ---- Process data ----

/// Axis of an object of the profile area, and the object of the first axis that corresponds to it.
static canopen_cia402_axis_t* axis_of(canopen_device_t* const device, const uint16_t index,
                                      uint16_t* const out_object)
{
    const unsigned offset = (unsigned)index - OBJECT_PROFILE_AREA;
    const unsigned number = offset / PROFILE_AXIS_STEP;
    FSW_ASSERT((index >= OBJECT_PROFILE_AREA) && (number < device->profile->axis_count));
    *out_object = (uint16_t)(OBJECT_PROFILE_AREA + (offset % PROFILE_AXIS_STEP));
    return &device->axes[number];
}

static void take_object(canopen_device_t* const device, const uint16_t index, const uint32_t value)
{
    if (index == OBJECT_TEMPERATURE) {
        device->temperature = (int16_t)(uint16_t)value;
        return;
    }
    uint16_t object                   = 0U;
    canopen_cia402_axis_t* const axis = axis_of(device, index, &object);
    switch (object) {
    case OBJECT_STATUSWORD:
        axis->statusword = (uint16_t)value;
        break;
    case OBJECT_POSITION:
        axis->position = (int32_t)value;
        break;
    case OBJECT_VELOCITY:
        axis->velocity = (int32_t)value;
        break;
    case OBJECT_TORQUE:
        axis->torque = (int16_t)(uint16_t)value;
        break;
    case OBJECT_CURRENT:
        axis->current = (int16_t)(uint16_t)value;
        break;
    default:
        FSW_ASSERT(object == OBJECT_DIGITAL_INPUTS);
        device->digital_inputs = value;
        break;
    }
}

static uint32_t give_object(canopen_device_t* const device, const uint16_t index)
{
    uint16_t object                         = 0U;
    const canopen_cia402_axis_t* const axis = axis_of(device, index, &object);
    switch (object) {
    case OBJECT_CONTROLWORD:
        return axis->controlword;
    case OBJECT_TARGET_POSITION:
        return (uint32_t)axis->target_position;
    case OBJECT_TORQUE_OFFSET:
        return (uint16_t)axis->torque_offset;
    case OBJECT_TARGET_TORQUE:
        return (uint16_t)axis->target_torque;
    default:
        FSW_ASSERT(object == OBJECT_TARGET_VELOCITY);
        return (uint32_t)axis->target_velocity;
    }
}

static void take_process_data(void* const context, const uint16_t cob, const uint8_t* const octets,
                              const uint8_t length)
{
    canopen_device_t* const device = context;
    uint8_t number                 = 0U;
    while (!device->transmit[number].is_valid || (device->transmit[number].cob != cob)) {
        number++;
        FSW_ASSERT(number <
                   device->profile->transmit_count); // Only identifiers of this device are routed here.
    }
    const canopen_profile_pdo_t* const pdo = &device->profile->transmit[number];
    if (length != canopen_device_profile_pdo_octets(pdo)) {
        device->malformed++;
        return;
    }
    const uint8_t* octet = octets;
    for (uint8_t i = 0U; i < pdo->entry_count; i++) {
        const canopen_profile_entry_t* const entry = &pdo->entries[i];
        take_object(device, entry->index, (uint32_t)canopen_at(octet, entry->octets));
        octet += entry->octets;
    }
    device->transmit[number].is_heard    = true;
    device->transmit[number].heard_count = device->master->sync_count;
}

status_t canopen_device_connect(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    status_t status = STATUS_OK;
    for (uint8_t i = 0U; (status == STATUS_OK) && (i < device->profile->transmit_count); i++) {
        canopen_device_pdo_t* const pdo = &device->transmit[i];
        pdo->is_heard                   = false;
        pdo->heard_count                = device->master->sync_count;
        if (pdo->is_valid) {
            status        = canopen_master_route(device->master, pdo->cob, take_process_data, device);
            pdo->is_valid = (status == STATUS_OK); // Nothing may be unrouted that belongs to another device.
        }
    }
    return status;
}

void canopen_device_disconnect(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    for (uint8_t i = 0U; i < device->profile->transmit_count; i++) {
        if (device->transmit[i].is_valid) {
            canopen_master_unroute(device->master, device->transmit[i].cob);
        }
    }
}

static void emit_pdo(canopen_device_t* const device, const uint8_t number)
{
    const canopen_profile_pdo_t* const pdo = &device->profile->receive[number];
    uint8_t octets[CANOPEN_PDO_OCTETS_MAX];
    uint8_t length = 0U;
    for (uint8_t i = 0U; i < pdo->entry_count; i++) {
        const canopen_profile_entry_t* const entry = &pdo->entries[i];
        canopen_put(&octets[length], give_object(device, entry->index), entry->octets);
        length = (uint8_t)(length + entry->octets);
    }
    (void)canopen_master_send_process_data(device->master, device->receive[number].cob, octets, length);
}

void canopen_device_emit(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    for (uint8_t i = 0U; i < device->profile->receive_count; i++) {
        if (device->receive[i].is_valid) {
            emit_pdo(device, i);
        }
    }
}

bool canopen_device_is_heard(const canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    for (uint8_t i = 0U; i < device->profile->transmit_count; i++) {
        const bool is_expected = device->profile->transmit[i].is_each_sync && device->transmit[i].is_valid;
        if (is_expected && !device->transmit[i].is_heard) {
            return false;
        }
    }
    return true;
}

uint32_t canopen_device_silence(const canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    uint32_t longest = 0U;
    for (uint8_t i = 0U; i < device->profile->transmit_count; i++) {
        const uint32_t silence = device->master->sync_count - device->transmit[i].heard_count;
        const bool is_expected = device->profile->transmit[i].is_each_sync && device->transmit[i].is_valid;
        if (is_expected && (silence > longest)) {
            longest = silence;
        }
    }
    return longest;
}
