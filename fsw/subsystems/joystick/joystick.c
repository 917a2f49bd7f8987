// SPDX-License-Identifier: Apache-2.0
// Entry actions of the joystick.
#include "fsw/subsystems/joystick/joystick.h"

#include "fsw/canopen/cia402.h"
#include "fsw/drives/drives_counters.h"
#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"
#include "fsw/subsystems/joystick/joystick_internal.h"

#include <stddef.h>

void joystick_init(joystick_t* const joystick, subsystem_t* const generic,
                   const flow_resolver_t* const resolver)
{
    FSW_ASSERT((joystick != NULL) && (generic != NULL) && (resolver != NULL));
    *joystick = (joystick_t){.generic = generic};
    drives_init(&joystick->drives, generic, resolver, joystick_abandon);
}

static status_t software_init(void* const self)
{
    joystick_t* const joystick = self;
    drives_counters_bind(&joystick->drives, &joystick_definitions[JOYSTICK_INDEX_COUNTERS],
                         &joystick->parameters.counters);
    return subsystem_publish_all(joystick->generic, joystick_definitions, joystick_offsets,
                                 JOYSTICK_PARAMETER_COUNT, &joystick->parameters);
}

static status_t configure(void* const self, const descriptor_configuration_t* const configuration)
{
    joystick_t* const joystick                     = self;
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(joystick->generic);
    joystick->is_remote =
        descriptor_find_port(descriptor, configuration, JOYSTICK_PORT_ROBOT_CONTACT) != NULL;
    joystick->robot_port    = joystick->is_remote ? JOYSTICK_PORT_ROBOT_CONTACT : JOYSTICK_PORT_ROBOT_STATE;
    joystick->is_reflecting = descriptor_find_port(descriptor, configuration, joystick->robot_port) != NULL;
    joystick->felt_nm[0]    = 0.0;
    joystick->felt_nm[1]    = 0.0;
    joystick_stick_control_init(&joystick->control);
    joystick_force_display_clear(&joystick->display);
    return drives_configure(joystick, configuration);
}

static status_t engage(void* const self)
{
    joystick_t* const joystick = self;
    joystick->share            = 0.0; // The reflected torque rises slowly from zero.
    control_port_energy_reset(&joystick->energy);
    joystick_remote_contact_reset(&joystick->contact);
    return drives_engage(joystick);
}

static bool fits(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    static const int modes[]         = {CIA402_MODE_CST, 0};
    static const drives_need_t stick = {
        .axes = 2U,
        .reason_type =
            "type of <Device>: expected a class of CiA 402 with two axes, a force-reflecting stick",
        .count        = 1U,
        .reason_count = "<Configuration>: expected one <Device>, the stick",
        .modes        = modes,
        .reason_mode  = "<Device>: expected a <Setting> of 0x6060:00 to 10 (torque)"};
    return drives_fit(descriptor, &stick, out_misfit);
}

const subsystem_callbacks_t* joystick_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init   = software_init,
        .hardware_init   = drives_hardware_init,
        .configure       = configure,
        .start_control   = drives_start_control,
        .stop_control    = drives_stop_control,
        .engage          = engage,
        .disengage       = drives_disengage,
        .secure          = drives_secure,
        .post            = drives_post,
        .hardware_deinit = drives_hardware_deinit,
        .sense           = joystick_sense,
        .control         = joystick_control,
        .emit            = drives_emit,
        .perform         = joystick_perform,
        .parameter_set   = joystick_parameter_set,
        .release         = drives_release,
        .fits            = fits,
    };
    return &callbacks;
}
