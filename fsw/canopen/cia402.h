// SPDX-License-Identifier: Apache-2.0
/// Power state machine of CiA 402 drives for the master: which state a statusword reports, and which
/// controlword leads one step closer to a goal.
///
/// Pure functions.
///
/// Context    Any.
/// Time       O(1).
#ifndef FSW_CANOPEN_CIA402_H
#define FSW_CANOPEN_CIA402_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    CIA402_NOT_READY,
    CIA402_SWITCH_ON_DISABLED, ///< 0x40: no power, brake holds.
    CIA402_READY,              ///< 0x21
    CIA402_SWITCHED_ON,        ///< 0x23: power, no torque, brake holds.
    CIA402_OPERATION_ENABLED,  ///< 0x27
    CIA402_QUICK_STOP_ACTIVE,  ///< 0x07
    CIA402_FAULT_REACTION,     ///< 0x0F
    CIA402_FAULT,              ///< 0x08
    CIA402_UNKNOWN             ///< The statusword matches no state.
} canopen_cia402_state_t;

typedef enum {
    CIA402_GOAL_DISABLED,  ///< Switch on disabled (0x40), without braking first.
    CIA402_GOAL_STANDBY,   ///< Switched on (0x23).
    CIA402_GOAL_ENABLED,   ///< Operation enabled (0x27).
    CIA402_GOAL_QUICK_STOP ///< From 0x27: brake actively, then 0x40. From other states directly to 0x40.
} canopen_cia402_goal_t;

#define CIA402_CONTROL_DISABLE_VOLTAGE 0x0000U
#define CIA402_CONTROL_QUICK_STOP 0x0002U
#define CIA402_CONTROL_SHUTDOWN 0x0006U
#define CIA402_CONTROL_SWITCH_ON 0x0007U
#define CIA402_CONTROL_ENABLE 0x000FU
#define CIA402_CONTROL_HOMING_START 0x0010U ///< Bit 4, mode homing.
#define CIA402_CONTROL_FAULT_RESET 0x0080U

#define CIA402_STATUS_TARGET_REACHED 0x0400U  ///< Bit 10.
#define CIA402_STATUS_HOMING_ATTAINED 0x1000U ///< Bit 12, homing.
#define CIA402_STATUS_HOMING_ERROR 0x2000U    ///< Bit 13, homing.

/// Modes of operation, object 0x6060.
#define CIA402_MODE_HOMING 6
#define CIA402_MODE_CSP 8
#define CIA402_MODE_CSV 9
#define CIA402_MODE_CST 10

canopen_cia402_state_t canopen_cia402_state(uint16_t statusword);
/// Returns the controlword for the next cycle. `previous` is the last one sent, because a fault reset is a
/// rising edge of bit 7. A fault is reset only with `may_reset` and the goal STANDBY or ENABLED.
uint16_t canopen_cia402_controlword(canopen_cia402_state_t state, canopen_cia402_goal_t goal, bool may_reset,
                                    uint16_t previous);
/// True if the state is that of the goal. FAULT and NOT_READY also fulfil DISABLED and QUICK_STOP, because
/// the drive then has no torque.
bool canopen_cia402_is_at_goal(canopen_cia402_state_t state, canopen_cia402_goal_t goal);

#endif // FSW_CANOPEN_CIA402_H
