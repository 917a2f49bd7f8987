// SPDX-License-Identifier: Apache-2.0
/// Identifiers, commands and object indices of CiA 301 that more than one part of this library uses.
#ifndef FSW_CANOPEN_COB_H
#define FSW_CANOPEN_COB_H

#include "base/status.h"

#include <stdint.h>

#define CANOPEN_NODE_MAX 127U
#define CANOPEN_PDO_OCTETS_MAX 8U ///< Process data have at most the classic length on every bus.

// Predefined connection set.
#define COB_NMT 0x000U
#define COB_SYNC 0x080U
#define COB_EMERGENCY 0x080U ///< + node
#define COB_SDO_ANSWER 0x580U
#define COB_SDO_REQUEST 0x600U
#define COB_HEARTBEAT 0x700U
#define COB_FUNCTION_MASK 0x780U
#define COB_NODE_MASK 0x07FU
#define COB_PDO_INVALID 0x80000000U ///< Bit 31 of a PDO's COB-ID entry: the PDO does not exist.
#define COB_PDO_ID_MASK 0x7FFU

typedef enum { // NMT commands.
    NMT_START               = 0x01,
    NMT_STOP                = 0x02,
    NMT_PRE_OPERATIONAL     = 0x80,
    NMT_RESET_NODE          = 0x81,
    NMT_RESET_COMMUNICATION = 0x82
} canopen_nmt_command_t;

typedef enum { // NMT states as in heartbeats.
    NMT_STATE_BOOT_UP         = 0x00,
    NMT_STATE_STOPPED         = 0x04,
    NMT_STATE_OPERATIONAL     = 0x05,
    NMT_STATE_PRE_OPERATIONAL = 0x7F,
    NMT_STATE_UNKNOWN         = 0xFF ///< Nothing heard yet.
} canopen_nmt_state_t;

#endif // FSW_CANOPEN_COB_H
