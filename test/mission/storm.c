// SPDX-License-Identifier: Apache-2.0
// Wraps joystick_control: from its first cycle in OPERATIONAL on the joystick raises STORM_EACH events of LOW
// severity in each cycle of 0.5 ms, for STORM_CYCLES cycles, and in cycle STORM_HIGH of these one event of
// HIGH severity.
#include "fsw/subsystems/joystick/joystick_internal.h"

#include <stdlib.h>

#define LOW_EVENT 9U  ///< OPERATOR_NOTE
#define HIGH_EVENT 6U ///< LINK_STALE

void __real_joystick_control(void* self);
void __wrap_joystick_control(void* self);

static unsigned number(const char* name)
{
    const char* const value = getenv(name);
    return (value != NULL) ? (unsigned)strtoul(value, NULL, 10) : 0U;
}

void __wrap_joystick_control(void* self)
{
    static unsigned cycle;
    joystick_t* const joystick = self;
    if ((cycle > 0U) || (subsystem_state(joystick->generic) == STATE_OPERATIONAL)) {
        cycle++;
        for (unsigned i = 0U; (cycle <= number("STORM_CYCLES")) && (i < number("STORM_EACH")); i++) {
            (void)subsystem_raise(joystick->generic, LOW_EVENT, NULL, 0U);
        }
        if (cycle == number("STORM_HIGH")) {
            (void)subsystem_raise(joystick->generic, HIGH_EVENT, NULL, 0U);
        }
    }
    __real_joystick_control(self);
}
