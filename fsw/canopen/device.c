// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/device.h"

#include "base/assertion.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#define OBJECT_DEVICE_TYPE 0x1000U
#define OBJECT_IDENTITY 0x1018U
#define IDENTITY_VENDOR 1U
#define IDENTITY_PRODUCT 2U
#define OBJECT_RECEIVE_PARAMETER 0x1400U
#define OBJECT_RECEIVE_MAPPING 0x1600U
#define OBJECT_TRANSMIT_PARAMETER 0x1800U
#define OBJECT_TRANSMIT_MAPPING 0x1A00U
#define OBJECT_MAX_TORQUE 0x6072U
#define OBJECT_RATED_TORQUE 0x6076U
#define OBJECT_POSITION_LIMITS 0x607DU
#define OBJECT_POSITION_LIMITS_LOW 1U
#define OBJECT_POSITION_LIMITS_HIGH 2U

#define PER_MILLE 0.001
#define MILLI 0.001
#define OCTET_BITS 8U

#define FIRST_TORQUE 3U // Index of the first torque in the list of accesses that identify a device.

/// Return to the mapping of the class, which the device itself restores at its boot-up.
static void forget_mapping(canopen_device_t* const device)
{
    if (device->mapping != NULL) {
        device->mapping->profile = *device->mapping->class_profile;
    }
}

void canopen_device_reset(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    forget_mapping(device);
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
    for (uint8_t i = 0U; i < profile->axis_count; i++) {
        canopen_cia402_axis_init(&device->axes[i],
                                 (canopen_cia402_scale_t){.position_rad   = profile->axes[i].position_rad,
                                                          .velocity_rad_s = profile->axes[i].velocity_rad_s,
                                                          .torque_nm      = PER_MILLE,
                                                          .low_rad        = profile->axes[i].low_rad,
                                                          .high_rad       = profile->axes[i].high_rad,
                                                          .speed_rad_s    = profile->axes[i].speed_rad_s});
    }
    (void)memset(device->values, 0, sizeof device->values);
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

void canopen_device_follow_mapping(canopen_device_t* const device, canopen_mapping_t* const mapping)
{
    FSW_ASSERT((device != NULL) && (device->mapping == NULL) && (mapping != NULL));
    mapping->class_profile = device->profile;
    mapping->profile       = *device->profile;
    device->mapping        = mapping;
    device->profile        = &mapping->profile;
}

// ---- Commissioning ----

/// Append an access to the list of the present step.
static void ask(canopen_device_t* const device, uint16_t* const count, const canopen_setting_t setting)
{
    FSW_ASSERT(*count < DEVICE_IDENTIFY_MAX);
    device->identify[*count] = setting;
    (*count)++;
}

/// Append an access that verifies an object of four octets.
static void ask_number(canopen_device_t* const device, uint16_t* const count, const uint16_t index,
                       const uint8_t subindex, const uint32_t value)
{
    ask(device, count,
        (canopen_setting_t){
            .index = index, .subindex = subindex, .octets = 4U, .kind = SETTING_VERIFY, .value = value});
}

/// Append the accesses that verify the mapping of a PDO.
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

/// Append the accesses of the first step: identity and torques.
static void ask_identity(canopen_device_t* const device, uint16_t* const count)
{
    const canopen_device_profile_t* const profile = device->profile;
    ask_number(device, count, OBJECT_DEVICE_TYPE, 0U, profile->device_type);
    ask_number(device, count, OBJECT_IDENTITY, IDENTITY_VENDOR, profile->vendor_id);
    ask_number(device, count, OBJECT_IDENTITY, IDENTITY_PRODUCT, profile->product_code);
    for (uint8_t i = 0U; i < profile->axis_count; i++) { // take_torques reads the results in this order.
        const uint16_t offset = (uint16_t)(i * PROFILE_AXIS_STEP);
        if (profile->axes[i].has_torque) {
            ask(device, count,
                (canopen_setting_t){
                    .index = (uint16_t)(OBJECT_RATED_TORQUE + offset), .octets = 4U, .kind = SETTING_READ});
            ask(device, count,
                (canopen_setting_t){
                    .index = (uint16_t)(OBJECT_MAX_TORQUE + offset), .octets = 2U, .kind = SETTING_READ});
        }
    }
}

/// Append the accesses that verify the units of an axis: with other units, it would move by wrong amounts.
static void ask_units(canopen_device_t* const device, uint16_t* const count,
                      const canopen_profile_axis_t* const axis)
{
    for (uint8_t i = 0U; i < axis->unit_count; i++) {
        const canopen_profile_unit_t* const unit = &axis->units[i];
        ask(device, count,
            (canopen_setting_t){.index    = unit->index,
                                .subindex = unit->subindex,
                                .octets   = unit->octets,
                                .kind     = SETTING_VERIFY,
                                .value    = unit->value});
    }
}

/// List the accesses of the next step: first identity and torques, then the units of each axis, and the
/// mapping of each PDO.
static void begin_step(canopen_device_t* const device)
{
    const canopen_device_profile_t* const profile = device->profile;
    const unsigned first_transmit                 = 1U + profile->axis_count;
    const unsigned first_receive                  = first_transmit + profile->transmit_count;
    uint16_t count                                = 0U;
    if (device->identified == 0U) {
        ask_identity(device, &count);
    } else if (device->identified < first_transmit) {
        ask_units(device, &count, &profile->axes[device->identified - 1U]);
    } else if (device->identified < first_receive) {
        const unsigned number = device->identified - first_transmit;
        ask_mapping(device, &count, (uint16_t)(OBJECT_TRANSMIT_MAPPING + number), &profile->transmit[number]);
    } else {
        const unsigned number = device->identified - first_receive;
        ask_mapping(device, &count, (uint16_t)(OBJECT_RECEIVE_MAPPING + number), &profile->receive[number]);
    }
    canopen_setting_run_begin(&device->run, device->identify, count);
}

void canopen_device_identify(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    forget_mapping(device);
    device->identified = 0U;
    begin_step(device);
}

static canopen_sdo_client_t* client_of(canopen_device_t* const device)
{
    return &device->master->nodes[device->index].sdo;
}

/// Compute the torque units from the rated torques that the device has reported. STATUS_OK, STATUS_INVALID
/// (no rated torque).
static status_t take_torques(canopen_device_t* const device)
{
    uint16_t position = FIRST_TORQUE;
    for (uint8_t i = 0U; i < device->profile->axis_count; i++) {
        if (!device->profile->axes[i].has_torque) {
            continue;
        }
        const double rated_nm  = (double)device->identify[position].value * MILLI;
        const double max_share = (double)device->identify[position + 1U].value * PER_MILLE;
        if (!(rated_nm > 0.0)) {
            device->run.position       = position;
            device->run.is_other_value = true;
            return STATUS_INVALID;
        }
        canopen_cia402_scale_t scale = device->axes[i].scale;
        scale.torque_nm              = rated_nm * PER_MILLE;
        scale.torque_max_nm          = rated_nm * max_share;
        canopen_cia402_axis_init(&device->axes[i], scale);
        position = (uint16_t)(position + 2U);
    }
    return STATUS_OK;
}

status_t canopen_device_identify_step(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    const canopen_device_profile_t* const profile = device->profile;
    const unsigned last = (unsigned)profile->axis_count + profile->transmit_count + profile->receive_count;
    status_t status     = canopen_setting_run_step(&device->run, client_of(device));
    if ((status == STATUS_OK) && (device->identified == 0U)) {
        status = take_torques(device);
    }
    // The next step starts in the same cycle in which the previous one ended. The step of an axis without
    // units is empty and ends at once.
    while ((status == STATUS_OK) && (device->identified < last)) {
        device->identified++;
        begin_step(device);
        status = canopen_setting_run_step(&device->run, client_of(device));
    }
    return status;
}

void canopen_device_clear_outputs(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    for (uint8_t i = 0U; i < device->profile->value_count; i++) {
        const bool is_output = canopen_device_profile_is_output(device->profile, i);
        device->values[i]    = is_output ? 0U : device->values[i];
    }
}

void canopen_device_configure(canopen_device_t* const device, canopen_setting_t* const settings,
                              const uint16_t count)
{
    FSW_ASSERT(device != NULL);
    // The first process data of this configuration must not contain outputs of an earlier one. Commands of
    // axes need not be cleared: they act only in operation, and by then the controllers have set new ones.
    canopen_device_clear_outputs(device);
    if (device->mapping != NULL) {
        (void)memcpy(device->mapping->earlier, device->profile->receive, sizeof device->mapping->earlier);
    }
    device->is_followed = false;
    device->cleared     = 0U;
    canopen_setting_run_begin(&device->run, settings, count);
}

/// Apply a setting of a communication parameter to the expected or sent PDOs.
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

/// Apply a setting of a position limit (0x607D) to the limits of commands.
static void follow_limit(canopen_device_t* const device, const canopen_setting_t* const setting)
{
    for (uint8_t i = 0U; i < device->profile->axis_count; i++) {
        canopen_cia402_scale_t* const scale = &device->axes[i].scale;
        const double limit_rad              = (double)(int32_t)(uint32_t)setting->value * scale->position_rad;
        if (setting->index != (OBJECT_POSITION_LIMITS + (i * PROFILE_AXIS_STEP))) {
            continue;
        }
        if (setting->subindex == OBJECT_POSITION_LIMITS_LOW) {
            scale->low_rad = limit_rad;
        } else if (setting->subindex == OBJECT_POSITION_LIMITS_HIGH) {
            scale->high_rad = limit_rad;
        } else {
            // Subindex 0 is the number of limits.
        }
    }
}

static void follow_settings(canopen_device_t* const device)
{
    for (uint16_t i = 0U; i < device->run.count; i++) {
        const canopen_setting_t* const setting = &device->run.settings[i];
        follow_setting(device->transmit, device->profile->transmit_count, OBJECT_TRANSMIT_PARAMETER, setting);
        follow_setting(device->receive, device->profile->receive_count, OBJECT_RECEIVE_PARAMETER, setting);
        follow_limit(device, setting);
        if (device->mapping != NULL) {
            // This cannot fail: the device has accepted the setting, and drives_fit has checked that flight
            // software supports it.
            (void)canopen_device_profile_map(&device->mapping->profile, setting->index, setting->subindex,
                                             (uint32_t)setting->value);
        }
    }
    device->is_followed = true;
}

/// True if a PDO that exists carries the object of an entry.
static bool is_carried(const canopen_device_t* const device, const canopen_profile_entry_t* const wanted)
{
    bool is_found = false;
    for (uint8_t i = 0U; i < device->profile->receive_count; i++) {
        const canopen_profile_pdo_t* const pdo = &device->profile->receive[i];
        for (uint8_t k = 0U; device->receive[i].is_valid && (k < pdo->entry_count); k++) {
            const canopen_profile_entry_t* const entry = &pdo->entries[k];
            is_found = is_found || ((entry->index == wanted->index) && (entry->subindex == wanted->subindex));
        }
    }
    return is_found;
}

/// Begin to write zero to the objects that no process data carry any more, because the device keeps their
/// values, and another mode may still use them: for example, CST adds the torque offset (0x60B2) of an
/// earlier CSP. Targets are not cleared: they act only in their own mode, whose process data carry them.
static void begin_clearing(canopen_device_t* const device, const uint8_t number)
{
    const canopen_profile_pdo_t* const earlier =
        (device->mapping != NULL) ? device->mapping->earlier : device->profile->receive;
    const canopen_profile_pdo_t* const pdo = &earlier[number];
    const bool holds_values                = device->receive[number].is_sent;
    uint16_t count                         = 0U;
    for (uint8_t i = 0U; holds_values && (i < pdo->entry_count); i++) {
        const canopen_profile_entry_t* const entry = &pdo->entries[i];
        const bool acts_in_any_mode =
            (entry->word == PROFILE_TORQUE_OFFSET) || (entry->word == PROFILE_VALUE);
        if (acts_in_any_mode && !is_carried(device, entry)) {
            ask(device, &count,
                (canopen_setting_t){.index    = entry->index,
                                    .subindex = entry->subindex,
                                    .octets   = entry->octets,
                                    .kind     = SETTING_WRITE});
        }
    }
    canopen_setting_run_begin(&device->run, device->identify, count);
}

status_t canopen_device_configure_step(canopen_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    status_t status = canopen_setting_run_step(&device->run, client_of(device));
    if ((status == STATUS_OK) && !device->is_followed) {
        follow_settings(device);
    }
    while ((status == STATUS_OK) && (device->cleared < device->profile->receive_count)) {
        begin_clearing(device, device->cleared);
        device->cleared++;
        status = canopen_setting_run_step(&device->run, client_of(device));
    }
    for (uint8_t i = 0U; (status == STATUS_OK) && (i < device->profile->receive_count); i++) {
        device->receive[i].is_sent = device->receive[i].is_sent && device->receive[i].is_valid;
    }
    return status;
}

// ---- Process data ----

/// Returns the axis of an entry that is a word of an axis; 0 for other entries.
static uint8_t axis_of(const canopen_profile_entry_t* const entry)
{
    return (entry->word >= PROFILE_STATUSWORD) ? entry->number : 0U;
}

/// Store the received value of an entry of a transmit PDO.
static void take_entry(canopen_device_t* const device, const canopen_profile_entry_t* const entry,
                       const uint32_t value)
{
    canopen_cia402_axis_t* const axis = &device->axes[axis_of(entry)];
    switch (entry->word) {
    case PROFILE_STATUSWORD:
        axis->statusword = (uint16_t)value;
        break;
    case PROFILE_POSITION:
        axis->position = (int32_t)value;
        break;
    case PROFILE_VELOCITY:
        axis->velocity = (int32_t)value;
        break;
    case PROFILE_TORQUE:
        axis->torque = (int16_t)(uint16_t)value;
        break;
    case PROFILE_CURRENT:
        axis->current = (int16_t)(uint16_t)value;
        break;
    case PROFILE_VALUE:
        device->values[entry->number] = value;
        break;
    default:
        FSW_ASSERT(entry->word == PROFILE_PADDING);
        break;
    }
}

/// Returns the present value of an entry of a receive PDO.
static uint32_t give_entry(const canopen_device_t* const device, const canopen_profile_entry_t* const entry)
{
    const canopen_cia402_axis_t* const axis = &device->axes[axis_of(entry)];
    switch (entry->word) {
    case PROFILE_CONTROLWORD:
        return axis->controlword;
    case PROFILE_TARGET_POSITION:
        return (uint32_t)axis->target_position;
    case PROFILE_TORQUE_OFFSET:
        return (uint16_t)axis->torque_offset;
    case PROFILE_TARGET_TORQUE:
        return (uint16_t)axis->target_torque;
    case PROFILE_TARGET_VELOCITY:
        return (uint32_t)axis->target_velocity;
    case PROFILE_VALUE:
        return device->values[entry->number];
    default:
        FSW_ASSERT(entry->word == PROFILE_PADDING);
        return 0U;
    }
}

/// Returns the number with these bits of a REAL32; NaN if they are those of an infinite number or of NaN.
static double real_of(const uint32_t bits)
{
    float number = 0.0F;
    (void)memcpy(&number, &bits, sizeof number);
    return (fabsf(number) <= FLT_MAX) ? (double)number : (double)NAN;
}

/// Returns the bits of the REAL32 that is nearest to a finite number within its range.
static uint32_t bits_of_real(const double number)
{
    const float nearest = (float)number;
    uint32_t bits       = 0U;
    (void)memcpy(&bits, &nearest, sizeof bits);
    return bits;
}

double canopen_device_value(const canopen_device_t* const device, const uint8_t value)
{
    FSW_ASSERT((device != NULL) && (value < device->profile->value_count));
    const canopen_profile_value_t* const object = &device->profile->values[value];
    const uint64_t end                          = (uint64_t)1U << (OCTET_BITS * object->octets);
    const uint64_t bits                         = device->values[value];
    const bool is_negative                      = object->is_signed && (bits >= (end / 2U));
    const double number                         = is_negative ? -(double)(end - bits) : (double)bits;
    return (object->is_real ? real_of(device->values[value]) : number) * object->scale;
}

void canopen_device_set_value(canopen_device_t* const device, const uint8_t value, const double wanted)
{
    FSW_ASSERT((device != NULL) && (value < device->profile->value_count));
    const canopen_profile_value_t* const object = &device->profile->values[value];
    const uint64_t end                          = (uint64_t)1U << (OCTET_BITS * object->octets);
    const uint64_t half                         = end / 2U;
    double low                                  = object->is_signed ? -(double)half : 0.0;
    double high                                 = (double)((object->is_signed ? half : end) - 1U);
    double number                               = wanted / object->scale;
    if (object->is_real) {
        low  = -(double)FLT_MAX;
        high = (double)FLT_MAX;
    }
    if (number != number) { // NaN.
        number = 0.0;
    }
    number = (number < low) ? low : ((number > high) ? high : number);
    device->values[value] =
        object->is_real ? bits_of_real(number) : (uint32_t)((uint64_t)(int64_t)round(number) & (end - 1U));
}

static void take_process_data(void* const context, const uint16_t cob, const uint8_t* const octets,
                              const uint8_t length)
{
    canopen_device_t* const device = context;
    uint8_t number                 = 0U;
    while (!device->transmit[number].is_valid || (device->transmit[number].cob != cob)) {
        number++;
        // The master routes only identifiers of this device to this function.
        FSW_ASSERT(number < device->profile->transmit_count);
    }
    const canopen_profile_pdo_t* const pdo = &device->profile->transmit[number];
    if (length != canopen_device_profile_pdo_octets(pdo)) {
        device->malformed++;
        return;
    }
    const uint8_t* octet = octets;
    for (uint8_t i = 0U; i < pdo->entry_count; i++) {
        const canopen_profile_entry_t* const entry = &pdo->entries[i];
        take_entry(device, entry, (uint32_t)canopen_at(octet, entry->octets));
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
            status = canopen_master_route(device->master, pdo->cob, take_process_data, device);
            // If the identifier belongs to another device, canopen_device_disconnect must not remove its
            // route.
            pdo->is_valid = (status == STATUS_OK);
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
        canopen_put(&octets[length], give_entry(device, entry), entry->octets);
        length = (uint8_t)(length + entry->octets);
    }
    device->receive[number].is_sent = true;
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
