// SPDX-License-Identifier: Apache-2.0
// Entry actions of the joystick.
#include "fsw/subsystems/joystick/joystick.h"

#include "fsw/canopen/cia402.h"
#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"
#include "fsw/subsystems/joystick/joystick_internal.h"

#include <stddef.h>

void joystick_init(joystick_t* const joystick, subsystem_t* const generic,
                   const flow_resolver_t* const resolver)
{
    FSW_ASSERT((joystick != NULL) && (generic != NULL) && (resolver != NULL));
    *joystick = (joystick_t){.generic = generic, .activity = JOYSTICK_RESTING};
    drives_init(&joystick->drives, generic, resolver);
    joystick_stick_control_init(&joystick->control);
    joystick_force_display_clear(&joystick->display);
}

static status_t software_init(void* const self)
{
    joystick_t* const joystick = self;
    uint8_t* const storage     = (uint8_t*)&joystick->parameters;
    status_t status            = STATUS_OK;
    for (size_t i = 0U; (status == STATUS_OK) && (i < JOYSTICK_PARAMETER_COUNT); i++) {
        status = subsystem_publish(joystick->generic, &joystick_definitions[i], &storage[joystick_places[i]]);
    }
    return status;
}

static status_t hardware_init(void* const self)
{
    joystick_t* const joystick = self;
    joystick->activity         = JOYSTICK_RESTING;
    return drives_hardware_init(&joystick->drives);
}

static status_t configure(void* const self, const descriptor_configuration_t* const configuration)
{
    joystick_t* const joystick                     = self;
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(joystick->generic);
    joystick->activity                             = JOYSTICK_RESTING;
    joystick->is_reflecting =
        descriptor_find_port(descriptor, configuration, JOYSTICK_PORT_ROBOT_STATE) != NULL;
    joystick->felt_nm[0] = 0.0;
    joystick->felt_nm[1] = 0.0;
    joystick_stick_control_init(&joystick->control);
    joystick_force_display_clear(&joystick->display);
    const bool is_one_device =
        (configuration->device_count == 1U) &&
        (drives_mode(descriptor, &descriptor->devices[configuration->first_device]) == CIA402_MODE_CST);
    return is_one_device ? drives_configure(&joystick->drives, configuration) : STATUS_INVALID;
}

static status_t start_control(void* const self)
{
    joystick_t* const joystick = self;
    const status_t status      = drives_go(&joystick->drives, CIA402_GOAL_STANDBY);
    if (status == STATUS_OK) {
        joystick->activity = JOYSTICK_PREPARED;
    }
    return status;
}

static status_t stop_control(void* const self)
{
    joystick_t* const joystick = self;
    joystick->activity         = JOYSTICK_RESTING;
    joystick_abandon(joystick);
    return drives_go(&joystick->drives, CIA402_GOAL_DISABLED);
}

static status_t engage(void* const self)
{
    joystick_t* const joystick = self;
    const status_t status      = drives_go(&joystick->drives, CIA402_GOAL_ENABLED);
    joystick->share            = 0.0; // Whatever the robot feels comes to the hand smoothly.
    if (status == STATUS_OK) {
        joystick->activity = JOYSTICK_ENGAGED;
    }
    return status;
}

static status_t disengage(void* const self)
{
    joystick_t* const joystick = self;
    joystick->activity         = JOYSTICK_PREPARED;
    joystick_abandon(joystick);
    return drives_go(&joystick->drives, CIA402_GOAL_STANDBY);
}

static status_t secure(void* const self)
{
    joystick_t* const joystick = self;
    joystick->activity         = JOYSTICK_RESTING;
    joystick_abandon(joystick);
    return drives_secure(&joystick->drives);
}

static status_t post(void* const self)
{
    joystick_t* const joystick = self;
    joystick->activity         = JOYSTICK_RESTING;
    joystick_abandon(joystick);
    return drives_post(&joystick->drives);
}

static status_t hardware_deinit(void* const self)
{
    joystick_t* const joystick = self;
    return drives_hardware_deinit(&joystick->drives);
}

static void release(void* const self)
{
    drives_release(&((joystick_t*)self)->drives);
}

static bool fits(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    static const int modes[]         = {CIA402_MODE_CST, 0};
    static const drives_need_t stick = {
        .type       = "joystick",
        .says_type  = "type of <Device>: expected joystick, the class of the force-reflecting stick",
        .count      = 1U,
        .says_count = "<Configuration>: expected one <Device>, the stick",
        .modes      = modes,
        .says_mode  = "<Device>: expected a <Setting> of 0x6060:00 to 10 (torque)"};
    return drives_fit(descriptor, &stick, out_misfit);
}

const subsystem_callbacks_t* joystick_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init   = software_init,
        .hardware_init   = hardware_init,
        .configure       = configure,
        .start_control   = start_control,
        .stop_control    = stop_control,
        .engage          = engage,
        .disengage       = disengage,
        .secure          = secure,
        .post            = post,
        .hardware_deinit = hardware_deinit,
        .sense           = joystick_sense,
        .control         = joystick_control,
        .emit            = joystick_emit,
        .perform         = joystick_perform,
        .parameter_set   = joystick_parameter_set,
        .release         = release,
        .fits            = fits,
    };
    return &callbacks;
}
