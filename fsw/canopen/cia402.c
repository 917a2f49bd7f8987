// SPDX-License-Identifier: Apache-2.0
#include "fsw/canopen/cia402.h"

canopen_cia402_state_t canopen_cia402_state(const uint16_t statusword)
{
    switch (statusword & 0x4FU) { // These states do not depend on the quick stop bit.
    case 0x00U:
        return CIA402_NOT_READY;
    case 0x40U:
        return CIA402_SWITCH_ON_DISABLED;
    case 0x0FU:
        return CIA402_FAULT_REACTION;
    case 0x08U:
        return CIA402_FAULT;
    default:
        break;
    }
    switch (statusword & 0x6FU) {
    case 0x21U:
        return CIA402_READY;
    case 0x23U:
        return CIA402_SWITCHED_ON;
    case 0x27U:
        return CIA402_OPERATION_ENABLED;
    case 0x07U:
        return CIA402_QUICK_STOP_ACTIVE;
    default:
        return CIA402_UNKNOWN;
    }
}

/// Returns the controlword of the next transition towards SWITCHED ON or OPERATION ENABLED. A fault reset is
/// a rising edge, so the bit is sent in every second cycle.
static uint16_t towards_power(const canopen_cia402_state_t state, const bool is_enable_wanted,
                              const bool may_reset, const uint16_t previous)
{
    switch (state) {
    case CIA402_SWITCH_ON_DISABLED:
        return CIA402_CONTROL_SHUTDOWN;
    case CIA402_READY:
        return CIA402_CONTROL_SWITCH_ON;
    case CIA402_SWITCHED_ON:
    case CIA402_OPERATION_ENABLED:
        return is_enable_wanted ? CIA402_CONTROL_ENABLE : CIA402_CONTROL_SWITCH_ON;
    case CIA402_FAULT:
        return (may_reset && ((previous & CIA402_CONTROL_FAULT_RESET) == 0U))
                   ? CIA402_CONTROL_FAULT_RESET
                   : CIA402_CONTROL_DISABLE_VOLTAGE;
    case CIA402_NOT_READY:
    case CIA402_QUICK_STOP_ACTIVE:
    case CIA402_FAULT_REACTION:
    case CIA402_UNKNOWN:
    default:
        return CIA402_CONTROL_DISABLE_VOLTAGE;
    }
}

uint16_t canopen_cia402_controlword(const canopen_cia402_state_t state, const canopen_cia402_goal_t goal,
                                    const bool may_reset, const uint16_t previous)
{
    switch (goal) {
    case CIA402_GOAL_STANDBY:
        return towards_power(state, false, may_reset, previous);
    case CIA402_GOAL_ENABLED:
        return towards_power(state, true, may_reset, previous);
    case CIA402_GOAL_QUICK_STOP:
        return ((state == CIA402_OPERATION_ENABLED) || (state == CIA402_QUICK_STOP_ACTIVE))
                   ? CIA402_CONTROL_QUICK_STOP
                   : CIA402_CONTROL_DISABLE_VOLTAGE;
    case CIA402_GOAL_DISABLED:
    default:
        return CIA402_CONTROL_DISABLE_VOLTAGE;
    }
}

bool canopen_cia402_is_at_goal(const canopen_cia402_state_t state, const canopen_cia402_goal_t goal)
{
    switch (goal) {
    case CIA402_GOAL_STANDBY:
        return state == CIA402_SWITCHED_ON;
    case CIA402_GOAL_ENABLED:
        return state == CIA402_OPERATION_ENABLED;
    case CIA402_GOAL_DISABLED:
    case CIA402_GOAL_QUICK_STOP:
    default:
        // In these states the drive has no torque.
        return (state == CIA402_SWITCH_ON_DISABLED) || (state == CIA402_FAULT) || (state == CIA402_NOT_READY);
    }
}
