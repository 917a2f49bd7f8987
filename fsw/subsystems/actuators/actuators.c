// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/actuators/actuators.h"

#include "base/assertion.h"
#include "fsw/canopen/cia402.h"
#include "fsw/drives/drives_fitting.h"
#include "fsw/drives/drives_homing.h"
#include "pus/core/tailoring.h"

typedef struct { // Numbers of parameter elements that the devices counted so far use.
    uint16_t axes;
    uint16_t values[2]; // Numbers of inputs and outputs.
} counts_t;

#define INPUTS 0U
#define OUTPUTS 1U

// ---- Homing ----

static void end_home(actuators_t* const own, const uint16_t failure_code, const uint32_t detail)
{
    (void)drives_home(&own->drives, false);
    subsystem_function_done(own->generic, own->home_token, failure_code, detail);
    own->home_token = 0U;
}

static void abandon(void* const self)
{
    end_home(self, PUS_FAILURE_ABORTED, 0U);
}

static void watch_home(actuators_t* const own)
{
    uint8_t node          = 0U;
    const status_t status = (own->home_token != 0U) ? drives_homing(&own->drives, &node) : STATUS_BUSY;
    if (status == STATUS_OK) {
        end_home(own, PUS_FAILURE_NONE, 0U);
    } else if (status == STATUS_INVALID) {
        end_home(own, PUS_FAILURE_DEVICE, node);
    } else {
        // No axis searches its reference, or a search continues. When the activity of the drives changes,
        // abandon() ends the search.
    }
}

// ---- The cycle ----

static bool is_operational(const actuators_t* const own)
{
    return (subsystem_state(own->generic) == STATE_OPERATIONAL) && (own->drives.activity == DRIVES_ENGAGED);
}

/// Returns the next point on the way to the target, at most `step` away.
static double approach(const double from, const double to, const double step)
{
    const double away = to - from;
    return from + ((away > step) ? step : ((away < -step) ? -step : away));
}

/// Command VELOCITY to an axis in CSV while the subsystem is OPERATIONAL; otherwise set VELOCITY to 0, so
/// that each operation begins at rest.
static void command_velocity(actuators_t* const own, canopen_cia402_axis_t* const axis, const uint16_t index)
{
    if (!is_operational(own)) {
        own->parameters.velocity[index] = 0.0;
    }
    canopen_cia402_axis_command_velocity(axis, own->parameters.velocity[index], 0.0);
}

/// Read the state of an axis, and command its next position or its velocity.
static void serve_axis(actuators_t* const own, canopen_cia402_axis_t* const axis, const uint16_t index,
                       const int mode)
{
    actuators_cur_values_t* const values = &own->parameters.cur_values;
    const double step         = own->parameters.speed * ((double)subsystem_period_ns(own->generic) * 1e-9);
    values->position[index]   = canopen_cia402_axis_position_rad(axis);
    values->torque[index]     = canopen_cia402_axis_torque_nm(axis);
    values->statusword[index] = axis->statusword;
    if (!is_operational(own)) { // The next motion begins at the present position.
        own->reference_rad[index]     = values->position[index];
        own->parameters.target[index] = values->position[index];
    }
    if (mode == CIA402_MODE_CSV) {
        command_velocity(own, axis, index);
        return;
    }
    own->reference_rad[index] = approach(own->reference_rad[index], own->parameters.target[index], step);
    canopen_cia402_axis_command_position(axis, own->reference_rad[index], 0.0);
}

static void serve_values(actuators_t* const own, canopen_device_t* const device, counts_t* const counts)
{
    for (uint8_t i = 0U; i < device->profile->value_count; i++) {
        if (canopen_device_profile_is_output(device->profile, i)) {
            const double wanted = is_operational(own) ? own->parameters.output[counts->values[OUTPUTS]] : 0.0;
            canopen_device_set_value(device, i, wanted);
            counts->values[OUTPUTS]++;
        } else {
            own->parameters.cur_values.input[counts->values[INPUTS]] = canopen_device_value(device, i);
            counts->values[INPUTS]++;
        }
    }
}

/// Returns the mode of operation of a device of the applied configuration.
static int mode_of(const actuators_t* const own, const uint16_t position)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(own->generic);
    return drives_mode(descriptor, &descriptor->devices[own->drives.configuration->first_device + position]);
}

static void control(void* const self)
{
    actuators_t* const own   = self;
    counts_t counts          = {.axes = 0U};
    uint16_t position        = 0U;
    canopen_device_t* device = drives_device(&own->drives, 0U);
    parameter_lock(subsystem_dictionary(own->generic));
    while (device != NULL) {
        if (device->profile->axis_count == 0U) {
            serve_values(own, device, &counts);
        } else {
            serve_axis(own, &device->axes[0], counts.axes, mode_of(own, position));
            counts.axes++;
        }
        position++;
        device = drives_device(&own->drives, position);
    }
    own->parameters.cur_values.state  = (int32_t)subsystem_state(own->generic);
    own->parameters.cur_values.cycles = subsystem_cycle(own->generic);
    parameter_unlock(subsystem_dictionary(own->generic));
    watch_home(own);
}

// ---- Functions ----

static status_t home(actuators_t* const own, const uint32_t call_token)
{
    if ((own->drives.activity != DRIVES_ENGAGED) || (own->home_token != 0U)) {
        return STATUS_FORBIDDEN;
    }
    const status_t status = drives_home(&own->drives, true);
    own->home_token       = (status == STATUS_OK) ? call_token : 0U;
    return (status == STATUS_OK) ? STATUS_BUSY : STATUS_FORBIDDEN;
}

static status_t stop(actuators_t* const own)
{
    end_home(own, PUS_FAILURE_ABORTED, 0U);
    parameter_lock(subsystem_dictionary(own->generic));
    for (size_t i = 0U; i < ACTUATORS_AXES_MAX; i++) {
        own->parameters.target[i]   = own->reference_rad[i];
        own->parameters.velocity[i] = 0.0;
    }
    parameter_unlock(subsystem_dictionary(own->generic));
    return STATUS_OK;
}

static status_t perform(void* const self, const subsystem_function_t* const function)
{
    switch (function->function_id) {
    case ACTUATORS_FUNCTION_HOME:
        return home(self, function->call_token);
    case ACTUATORS_FUNCTION_STOP:
        return stop(self);
    default:
        return STATUS_NOT_FOUND;
    }
}

// ---- Entry actions ----

void actuators_init(actuators_t* const own, subsystem_t* const generic, const flow_resolver_t* const resolver)
{
    FSW_ASSERT((own != NULL) && (generic != NULL) && (resolver != NULL));
    *own = (actuators_t){.generic = generic};
    drives_init(&own->drives, generic, resolver, abandon);
}

static status_t software_init(void* const self)
{
    actuators_t* const own = self;
    return subsystem_publish_all(own->generic, actuators_definitions, actuators_offsets,
                                 ACTUATORS_PARAMETER_COUNT, &own->parameters);
}

static void add_counts(const canopen_device_profile_t* const profile, counts_t* const counts)
{
    counts->axes = (uint16_t)(counts->axes + profile->axis_count);
    for (uint8_t i = 0U; (profile->axis_count == 0U) && (i < profile->value_count); i++) {
        counts->values[canopen_device_profile_is_output(profile, i) ? OUTPUTS : INPUTS]++;
    }
}

/// Refuse the device with which a configuration exceeds the number of elements of the parameters.
static bool are_few(const uint16_t count, const size_t most, const char* const reason,
                    const descriptor_device_t* const device, subsystem_misfit_t* const out_misfit)
{
    if (count > most) {
        *out_misfit = (subsystem_misfit_t){device->line, reason, (uint32_t)most};
        return false;
    }
    return true;
}

static bool counts_fit(const subsystem_descriptor_t* const descriptor,
                       const descriptor_configuration_t* const configuration,
                       subsystem_misfit_t* const out_misfit)
{
    counts_t counts = {.axes = 0U};
    for (uint16_t i = 0U; i < configuration->device_count; i++) {
        const descriptor_device_t* const device = &descriptor->devices[configuration->first_device + i];
        add_counts(canopen_device_profile_find(device->type), &counts);
        if (!are_few(counts.axes, ACTUATORS_AXES_MAX, "axes of a <Configuration>", device, out_misfit) ||
            !are_few(counts.values[INPUTS], ACTUATORS_INPUTS_MAX, "inputs of a <Configuration>", device,
                     out_misfit) ||
            !are_few(counts.values[OUTPUTS], ACTUATORS_OUTPUTS_MAX, "outputs of a <Configuration>", device,
                     out_misfit)) {
            return false;
        }
    }
    return true;
}

static bool fits(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    static const int modes[]        = {CIA402_MODE_CSP, CIA402_MODE_CSV, CIA402_MODE_HOMING, 0};
    static const drives_need_t need = {
        .axes          = 1U,
        .takes_modules = true,
        .reason_type = "type of <Device>: expected a drive of CiA 402 with one axis, or a class without axes",
        .reason_count = "<Configuration>: expected at least one <Device>",
        .modes        = modes,
        .reason_mode =
            "<Device>: expected a <Setting> of 0x6060:00 to 8 (position), 9 (velocity) or 6 (homing)"};
    bool fits = drives_fit(descriptor, &need, out_misfit);
    for (uint16_t i = 0U; fits && (i < descriptor->configuration_count); i++) {
        fits = counts_fit(descriptor, &descriptor->configurations[i], out_misfit);
    }
    return fits;
}

const subsystem_callbacks_t* actuators_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init   = software_init,
        .hardware_init   = drives_hardware_init,
        .configure       = drives_configure,
        .start_control   = drives_start_control,
        .stop_control    = drives_stop_control,
        .engage          = drives_engage,
        .disengage       = drives_disengage,
        .secure          = drives_secure,
        .post            = drives_post,
        .hardware_deinit = drives_hardware_deinit,
        .sense           = drives_sense,
        .control         = control,
        .emit            = drives_emit,
        .perform         = perform,
        .release         = drives_release,
        .fits            = fits,
    };
    return &callbacks;
}
