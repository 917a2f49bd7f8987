// SPDX-License-Identifier: Apache-2.0
// Entry actions of the manipulator.
#include "fsw/subsystems/manipulator/manipulator.h"

#include "fsw/canopen/cia402.h"
#include "fsw/drives/drives_access.h"
#include "fsw/drives/drives_counters.h"
#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"
#include "fsw/subsystems/manipulator/manipulator_internal.h"

#include <stddef.h>

void manipulator_init(manipulator_t* const manipulator, subsystem_t* const generic,
                      const flow_resolver_t* const resolver)
{
    FSW_ASSERT((manipulator != NULL) && (generic != NULL) && (resolver != NULL));
    *manipulator = (manipulator_t){.generic = generic};
    drives_init(&manipulator->drives, generic, resolver, manipulator_abandon);
}

manipulator_arm_setup_t manipulator_setup(const manipulator_t* const manipulator)
{
    return (manipulator_arm_setup_t){.gains    = &manipulator->parameters.control,
                                     .model    = &manipulator->model,
                                     .period_s = (double)subsystem_period_ns(manipulator->generic) * 1.0e-9};
}

void manipulator_take_model(manipulator_t* const manipulator)
{
    FSW_ASSERT(manipulator != NULL);
    manipulator->model = manipulator->parameters.model;
    manipulator_arm_identification_init(&manipulator->identification, &manipulator->parameters.identification,
                                        &manipulator->model);
}

static status_t software_init(void* const self)
{
    manipulator_t* const manipulator = self;
    drives_counters_bind(&manipulator->drives, &manipulator_definitions[MANIPULATOR_INDEX_COUNTERS],
                         &manipulator->parameters.counters);
    return subsystem_publish_all(manipulator->generic, manipulator_definitions, manipulator_offsets,
                                 MANIPULATOR_PARAMETER_COUNT, &manipulator->parameters);
}

static status_t hardware_init(void* const self)
{
    manipulator_t* const manipulator = self;
    manipulator->has_zero            = false;
    manipulator_arm_tare_init(&manipulator->tare);
    manipulator_take_model(manipulator);
    return drives_hardware_init(manipulator);
}

static status_t configure(void* const self, const descriptor_configuration_t* const configuration)
{
    manipulator_t* const manipulator               = self;
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(manipulator->generic);
    const descriptor_device_t* const first         = &descriptor->devices[configuration->first_device];
    // `fits` has checked that all devices have the same mode of operation.
    manipulator->is_torque_mode = (drives_mode(descriptor, first) == CIA402_MODE_CST);
    manipulator->is_remote =
        descriptor_find_port(descriptor, configuration, MANIPULATOR_PORT_HAND_MOTION) != NULL;
    manipulator_arm_control_init(&manipulator->control);
    manipulator->control.zero_nm[0] = manipulator->tare.offset_nm[0];
    manipulator->control.zero_nm[1] = manipulator->tare.offset_nm[1];
    return drives_configure(manipulator, configuration);
}

static status_t start_control(void* const self)
{
    manipulator_t* const manipulator = self;
    const status_t status            = drives_start_control(manipulator);
    if (status == STATUS_OK) {
        manipulator_arm_tare_begin(&manipulator->tare);
    }
    return status;
}

/// Engage the drives. Torque mode requires a tare, and waits for a running one: a late start is better than
/// forces that are measured with a wrong zero. Position mode requires none, so that the arm can be moved out
/// of a contact that prevents a tare.
static status_t engage(void* const self)
{
    manipulator_t* const manipulator = self;
    if (manipulator->is_torque_mode && (manipulator->tare.result == STATUS_BUSY)) {
        return STATUS_BUSY;
    }
    if (manipulator->is_torque_mode && !manipulator->has_zero) {
        return STATUS_FORBIDDEN;
    }
    const status_t status = drives_engage(manipulator);
    if (status == STATUS_OK) {
        manipulator->is_beyond_limit[0] = false;
        manipulator->is_beyond_limit[1] = false;
        control_port_energy_reset(&manipulator->energy);
    }
    return status;
}

static bool fits(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    static const int modes[]         = {CIA402_MODE_CST, CIA402_MODE_CSP, 0};
    static const drives_need_t joint = {
        .axes         = 1U,
        .reason_type  = "type of <Device>: expected a class of CiA 402 with one axis, a joint of the arm",
        .count        = ARM_JOINTS,
        .reason_count = "<Configuration>: expected two <Device>, one for each joint",
        .modes        = modes,
        .reason_mode =
            "<Device>: expected a <Setting> of 0x6060:00 to 10 (torque) or 8 (position), the same for "
            "both joints"};
    return drives_fit(descriptor, &joint, out_misfit);
}

const subsystem_callbacks_t* manipulator_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init   = software_init,
        .hardware_init   = hardware_init,
        .configure       = configure,
        .start_control   = start_control,
        .stop_control    = drives_stop_control,
        .engage          = engage,
        .disengage       = drives_disengage,
        .secure          = drives_secure,
        .post            = drives_post,
        .hardware_deinit = drives_hardware_deinit,
        .sense           = manipulator_sense,
        .control         = manipulator_control,
        .emit            = drives_emit,
        .perform         = manipulator_perform,
        .parameter_set   = manipulator_parameter_set,
        .release         = drives_release,
        .device_port     = drives_access_port,
        .fits            = fits,
    };
    return &callbacks;
}
