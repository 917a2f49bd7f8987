// SPDX-License-Identifier: Apache-2.0
/// States of a drive in its statusword (CiA 402): the bits by which a state is recognized, and their values.
#ifndef TEST_UNIT_SIM_DEVICES_STATUSWORDS_H
#define TEST_UNIT_SIM_DEVICES_STATUSWORDS_H

#define STATE_BITS 0x6FU
#define READY_TO_SWITCH_ON 0x21U
#define SWITCHED_ON 0x23U
#define OPERATION_ENABLED 0x27U
#define QUICK_STOP_ACTIVE 0x07U

/// In these two states bit 5 has any value.
#define STATE_BITS_WITHOUT_5 0x4FU
#define SWITCH_ON_DISABLED 0x40U
#define FAULT 0x08U

#endif // TEST_UNIT_SIM_DEVICES_STATUSWORDS_H
