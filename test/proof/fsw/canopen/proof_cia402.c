// SPDX-License-Identifier: Apache-2.0
// Proves: each statusword is decoded to the state to which CiA 402 assigns its bits; torque is commanded
//     only for the goal ENABLED and from SWITCHED_ON on, power only for the goals STANDBY and ENABLED; a
//     fault is reset, by a rising edge, if and only if it is permitted and the goal needs power; each goal is
//     reached in its states and in no others; in those of DISABLED and QUICK STOP a drive has no torque.
// Bounds: every statusword, state, goal and previous controlword.
// Replaced: nothing.
// Sources: fsw/canopen/cia402.c
// Options: --unwind 9
// Quick: yes
// Fault: fsw/canopen/cia402.c
//   - switch (statusword & 0x6FU) {
//   + switch (statusword & 0x2FU) {
// Fault: fsw/canopen/cia402.c
//   - return towards_power(state, false, may_reset, previous);
//   + return towards_power(state, true, may_reset, previous);
// Fault: fsw/canopen/cia402.c
//   - return state == CIA402_OPERATION_ENABLED;
//   + return state >= CIA402_OPERATION_ENABLED;
#include "fsw/canopen/cia402.h"
#include "test/proof/proof.h"

/// Masks and values of the states, as in the table "statusword" of CiA 402-2.
static canopen_cia402_state_t by_definition(const uint16_t word)
{
    static const struct {
        uint16_t mask;
        uint16_t value;
        canopen_cia402_state_t state;
    } rows[]                     = {{0x4FU, 0x00U, CIA402_NOT_READY},
                                    {0x4FU, 0x40U, CIA402_SWITCH_ON_DISABLED},
                                    {0x6FU, 0x21U, CIA402_READY},
                                    {0x6FU, 0x23U, CIA402_SWITCHED_ON},
                                    {0x6FU, 0x27U, CIA402_OPERATION_ENABLED},
                                    {0x6FU, 0x07U, CIA402_QUICK_STOP_ACTIVE},
                                    {0x4FU, 0x0FU, CIA402_FAULT_REACTION},
                                    {0x4FU, 0x08U, CIA402_FAULT}};
    canopen_cia402_state_t found = CIA402_UNKNOWN;
    unsigned matches             = 0U;
    for (unsigned i = 0U; i < 8U; i++) {
        if ((word & rows[i].mask) == rows[i].value) {
            found = rows[i].state;
            matches++;
        }
    }
    PROVE(matches <= 1U, "a statusword belongs to at most one state");
    return found;
}

void proof(void)
{
    const uint16_t statusword = nondet_u16();
    PROVE(canopen_cia402_state(statusword) == by_definition(statusword),
          "the state is that of the definition");

    const canopen_cia402_state_t state = (canopen_cia402_state_t)nondet_u8();
    const canopen_cia402_goal_t goal   = (canopen_cia402_goal_t)nondet_u8();
    const bool may_reset               = nondet_bool();
    const uint16_t previous            = nondet_u16();
    const uint16_t word                = canopen_cia402_controlword(state, goal, may_reset, previous);
    const bool wants_power             = (goal == CIA402_GOAL_STANDBY) || (goal == CIA402_GOAL_ENABLED);
    PROVE(IMPLIES((word & 0x0FU) == 0x0FU,
                  (goal == CIA402_GOAL_ENABLED) &&
                      ((state == CIA402_SWITCHED_ON) || (state == CIA402_OPERATION_ENABLED))),
          "torque is commanded only for ENABLED, from SWITCHED_ON on");
    PROVE(IMPLIES((word & 0x0FU) == 0x07U, wants_power), "power is commanded only for STANDBY and ENABLED");
    PROVE(((word & CIA402_CONTROL_FAULT_RESET) != 0U) ==
              (may_reset && wants_power && (state == CIA402_FAULT) &&
               ((previous & CIA402_CONTROL_FAULT_RESET) == 0U)),
          "a fault is reset if and only if permitted, for a goal with power, in FAULT, by a rising edge");
    PROVE(IMPLIES(goal == CIA402_GOAL_DISABLED, word == CIA402_CONTROL_DISABLE_VOLTAGE),
          "the goal DISABLED removes the voltage at once");
    PROVE(IMPLIES(goal == CIA402_GOAL_QUICK_STOP,
                  word == (((state == CIA402_OPERATION_ENABLED) || (state == CIA402_QUICK_STOP_ACTIVE))
                               ? CIA402_CONTROL_QUICK_STOP
                               : CIA402_CONTROL_DISABLE_VOLTAGE)),
          "the goal QUICK STOP brakes a drive with torque, and removes the voltage of all others");
    const bool is_idle =
        (state == CIA402_SWITCH_ON_DISABLED) || (state == CIA402_FAULT) || (state == CIA402_NOT_READY);
    PROVE(canopen_cia402_is_at_goal(state, goal) ==
              ((goal == CIA402_GOAL_ENABLED)   ? (state == CIA402_OPERATION_ENABLED)
               : (goal == CIA402_GOAL_STANDBY) ? (state == CIA402_SWITCHED_ON)
                                               : is_idle),
          "a goal is reached in its states and in no others");
}
