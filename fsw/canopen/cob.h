// SPDX-License-Identifier: Apache-2.0
/// Identifiers, NMT commands and states of CiA 301 that more than one part of this library uses, and its
/// octet order.
#ifndef FSW_CANOPEN_COB_H
#define FSW_CANOPEN_COB_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

#define CANOPEN_NODE_MAX 127U
#define CANOPEN_PDO_OCTETS_MAX 8U ///< A PDO has at most 8 octets, also on a bus with CAN FD.

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

/// Write a number of 1 to 8 octets, the lowest octet first.
static inline void canopen_put(uint8_t* octets, uint64_t value, size_t size)
{
    for (size_t i = 0U; i < size; i++) {
        octets[i] = (uint8_t)(value >> (8U * i));
    }
}

/// Read a number of 1 to 8 octets, the lowest octet first.
static inline uint64_t canopen_at(const uint8_t* octets, size_t size)
{
    uint64_t value = 0U;
    for (size_t i = 0U; i < size; i++) {
        value |= (uint64_t)octets[i] << (8U * i);
    }
    return value;
}

static inline uint32_t canopen_u32_at(const uint8_t* octets)
{
    return (uint32_t)canopen_at(octets, sizeof(uint32_t));
}

typedef enum { // NMT commands.
    NMT_START           = 0x01,
    NMT_PRE_OPERATIONAL = 0x80,
    NMT_RESET_NODE      = 0x81
} canopen_nmt_command_t;

typedef enum { // NMT states as in heartbeats.
    NMT_STATE_BOOT_UP         = 0x00,
    NMT_STATE_STOPPED         = 0x04,
    NMT_STATE_OPERATIONAL     = 0x05,
    NMT_STATE_PRE_OPERATIONAL = 0x7F
} canopen_nmt_state_t;

#endif // FSW_CANOPEN_COB_H
