// SPDX-License-Identifier: Apache-2.0
// Entry actions of the arm, and the check of its descriptor.
#include "fsw/subsystems/arm/arm.h"

#include "base/assertion.h"
#include "fsw/canopen/cia402.h"
#include "fsw/drives/drives_access.h"
#include "fsw/drives/drives_counters.h"
#include "fsw/drives/drives_fitting.h"
#include "fsw/subsystems/arm/arm_internal.h"
#include "pus/core/tailoring.h"

#include <stddef.h>
#include <string.h>

void arm_init(arm_t* const arm, subsystem_t* const generic, const flow_resolver_t* const resolver)
{
    FSW_ASSERT((arm != NULL) && (generic != NULL) && (resolver != NULL));
    *arm = (arm_t){.generic = generic};
    drives_init(&arm->drives, generic, resolver, arm_abandon);
}

static status_t software_init(void* const self)
{
    arm_t* const arm = self;
    arm_definitions_create(&arm->definitions, subsystem_descriptor(arm->generic));
    drives_counters_bind(&arm->drives, &arm->definitions.definitions[ARM_PARAMETER_COUNTERS],
                         &arm->parameters.counters);
    return subsystem_publish_all(arm->generic, arm->definitions.definitions, arm->definitions.offsets,
                                 arm->definitions.count, &arm->parameters);
}

static status_t take_parameters(arm_t* const arm)
{
    const unsigned joint_count = arm_joint_count(subsystem_descriptor(arm->generic));
    arm_limits_of_parameters(&arm->parameters, joint_count, &arm->limits);
    arm_hand_settings_of_parameters(&arm->parameters, &arm->hand_settings);
    return arm_model_of_parameters(&arm->parameters, joint_count, &arm->model);
}

static void take_ports(arm_t* const arm, const descriptor_configuration_t* const configuration)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(arm->generic);
    // `fits` has checked that a configuration has either all ports or none.
    arm->is_telepresence = (configuration->port_count > 0U);
    for (uint16_t i = 0U; i < configuration->port_count; i++) {
        const descriptor_port_t* const port = &descriptor->ports[configuration->first_port + i];
        if (port->is_provided) {
            arm->robot_port = port->id;
        } else {
            arm->hand_port = port->id;
        }
    }
}

static status_t configure(void* const self, const descriptor_configuration_t* const configuration)
{
    arm_t* const arm                               = self;
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(arm->generic);
    const descriptor_device_t* const first         = &descriptor->devices[configuration->first_device];
    // `fits` has checked that all devices have the same mode of operation.
    arm->is_torque_mode = (drives_mode(descriptor, first) == CIA402_MODE_CST);
    take_ports(arm, configuration);
    arm_force_init(&arm->force);
    arm_control_init(&arm->control);
    const status_t status = take_parameters(arm);
    return (status == STATUS_OK) ? drives_configure(arm, configuration) : status;
}

/// Apply new parameters. Limits act immediately; the model changes only when a configuration is applied.
/// With new settings of telepresence, the hand is coupled again at the present pose.
static void parameter_set(void* const self, const uint32_t parameter_id)
{
    arm_t* const arm = self;
    arm_limits_of_parameters(&arm->parameters, arm->model.joint_count, &arm->limits);
    if (arm->is_telepresence &&
        (parameter_id == arm->definitions.definitions[ARM_PARAMETER_TELEPRESENCE].id)) {
        arm_hand_settings_of_parameters(&arm->parameters, &arm->hand_settings);
        arm_hand_begin(&arm->hand, &arm->model, &arm->motion);
    }
}

// ---- Check of the descriptor ----

static bool refuse(subsystem_misfit_t* const misfit, const uint32_t line, const char* const reason)
{
    *misfit = (subsystem_misfit_t){line, reason, 0U};
    return false;
}

typedef struct {
    const char* name;
    uint16_t arguments;
    uint16_t each[3];  // Number of values of an argument for each joint.
    uint16_t fixed[3]; // Number of additional values; all are DOUBLE.
} function_row_t;

static const function_row_t functions[] = {
    {.name = "MOVE_TO", .arguments = 2U, .each = {1U, 0U}, .fixed = {0U, 1U}},
    {.name = "LINE_TO", .arguments = 3U, .fixed = {3U, 3U, 1U}},
    {.name = "STOP"},
    {.name = "ADD_VIA", .arguments = 1U, .each = {1U}},
    {.name = "CLR_VIA"},
    {.name = "MOVE_VIA", .arguments = 2U, .fixed = {1U, 1U}},
    {.name = "ADD_POSE", .arguments = 2U, .fixed = {3U, 3U}},
    {.name = "LINE_VIA", .arguments = 2U, .fixed = {1U, 1U}},
};

static const function_row_t* row_of(const char* const name)
{
    for (size_t i = 0U; i < (sizeof functions / sizeof functions[0]); i++) {
        if (strcmp(functions[i].name, name) == 0) {
            return &functions[i];
        }
    }
    return NULL;
}

static bool function_fits(const subsystem_descriptor_t* const descriptor,
                          const descriptor_function_t* const function, subsystem_misfit_t* const out_misfit)
{
    const function_row_t* const row = row_of(function->name);
    if ((row == NULL) || (function->argument_count != row->arguments)) {
        return refuse(out_misfit, function->line,
                      "<Function>: expected one of an arm, with its arguments (docs/arm.md)");
    }
    for (uint16_t i = 0U; i < row->arguments; i++) {
        const descriptor_field_t* const argument = &descriptor->fields[function->first_argument + i];
        const unsigned count = (row->each[i] * arm_joint_count(descriptor)) + row->fixed[i];
        if ((argument->type != VALUE_DOUBLE) || (argument->count != count)) {
            return refuse(out_misfit, argument->line,
                          "<Argument>: expected type DOUBLE and the count that an arm needs (docs/arm.md)");
        }
    }
    return true;
}

/// Check a port. HAND_POSITION has two angles of the hand; ROBOT_STATE has the offset of the tool as angles
/// of the hand, and the force on the tool as torques.
static bool port_fits(const subsystem_descriptor_t* const descriptor, const descriptor_port_t* const port,
                      subsystem_misfit_t* const out_misfit)
{
    const char* const name = port->is_provided ? "ROBOT_STATE" : "HAND_POSITION";
    bool is_fitting = (strcmp(port->name, name) == 0) && (port->field_count == (port->is_provided ? 2U : 1U));
    for (uint16_t i = 0U; is_fitting && (i < port->field_count); i++) {
        const descriptor_field_t* const field = &descriptor->fields[port->first_field + i];
        is_fitting = (field->type == VALUE_DOUBLE) && (field->count == ARM_HAND_AXES);
    }
    return is_fitting || refuse(out_misfit, port->line,
                                "<RTLinkService>: expected HAND_POSITION of 2 DOUBLE, required, and "
                                "ROBOT_STATE of 2 and 2 DOUBLE, provided (docs/arm.md)");
}

static bool ports_fit(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    for (uint16_t i = 0U; i < descriptor->configuration_count; i++) {
        const descriptor_configuration_t* const configuration = &descriptor->configurations[i];
        if ((configuration->port_count != 0U) && (configuration->port_count != 2U)) {
            return refuse(out_misfit, configuration->line,
                          "<Configuration>: expected both ports of telepresence, HAND_POSITION and "
                          "ROBOT_STATE, or none (docs/arm.md)");
        }
    }
    for (uint16_t i = 0U; i < descriptor->port_count; i++) {
        if (!port_fits(descriptor, &descriptor->ports[i], out_misfit)) {
            return false;
        }
    }
    return true;
}

static uint16_t largest_capacity(const uint8_t service_type)
{
    switch (service_type) {
    case PUS_SERVICE_DEVICE_ACCESS:
        return ARM_DEVICE_REQUESTS;
    case PUS_SERVICE_STATISTICS:
        return ARM_STATISTICS;
    case PUS_SERVICE_MEMORY:
        return ARM_MEMORY_OPERATIONS;
    default: // ST[12]; the reader of descriptors admits no other service.
        return ARM_MONITORS;
    }
}

/// Check that the capacities of the services fit the storage that arm.h defines.
static bool services_fit(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    for (uint16_t i = 0U; i < descriptor->service_count; i++) {
        const descriptor_service_t* const service = &descriptor->services[i];
        if ((service->capacity > largest_capacity(service->type)) ||
            (service->functional > ARM_FUNCTIONAL_MONITORS)) {
            return refuse(
                out_misfit, service->line,
                "<Service>: expected a capacity for which the program of an arm has storage (docs/arm.md)");
        }
    }
    return true;
}

static bool fits(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    static const int modes[]  = {CIA402_MODE_CST, CIA402_MODE_CSP, 0};
    const drives_need_t joint = {
        .axes         = 1U,
        .reason_type  = "type of <Device>: expected a drive of CiA 402 with one axis",
        .count        = (uint16_t)arm_joint_count(descriptor),
        .reason_count = "<Configuration>: expected as many <Device> as in the first configuration",
        .modes        = modes,
        .reason_mode =
            "<Device>: expected a <Setting> of 0x6060:00 to 10 (torque) or 8 (position), the same for "
            "all joints"};
    if ((joint.count < 1U) || (joint.count > ARM_JOINTS_MAX)) {
        return refuse(out_misfit, 1U, "first <Configuration>: expected 1 to 12 <Device>, one for each joint");
    }
    for (uint16_t i = 0U; i < descriptor->function_count; i++) {
        if (!function_fits(descriptor, &descriptor->functions[i], out_misfit)) {
            return false;
        }
    }
    return arm_parameters_fit(descriptor, out_misfit) && services_fit(descriptor, out_misfit) &&
           ports_fit(descriptor, out_misfit) && drives_fit(descriptor, &joint, out_misfit);
}

const subsystem_callbacks_t* arm_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init   = software_init,
        .hardware_init   = drives_hardware_init,
        .configure       = configure,
        .start_control   = drives_start_control,
        .stop_control    = drives_stop_control,
        .engage          = drives_engage,
        .disengage       = drives_disengage,
        .secure          = drives_secure,
        .post            = drives_post,
        .hardware_deinit = drives_hardware_deinit,
        .sense           = arm_sense,
        .control         = arm_cycle,
        .emit            = drives_emit,
        .perform         = arm_perform,
        .parameter_set   = parameter_set,
        .release         = drives_release,
        .device_port     = drives_access_port,
        .fits            = fits,
    };
    return &callbacks;
}
