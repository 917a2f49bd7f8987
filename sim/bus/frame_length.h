// SPDX-License-Identifier: Apache-2.0
/// Exact length of a classic or FD frame on the wire, with every stuff bit.
///
/// Classic: dynamic stuffing from start of frame to the end of the 15-bit CRC. FD with bit rate switch:
/// dynamic stuffing from start of frame to the end of the data field, then the fixed stuff bits of the CRC
/// field as ISO 11898-1:2015 defines them (one in front of the stuff count and one after each fourth bit). A
/// dynamic stuff bit due right at the end of the data field is the first fixed stuff bit.
///
/// Time  About 20 ns for a PDO, because each octet takes one look-up in a table (256 entries per state of the
///       stuffing rule).
#ifndef SIM_BUS_FRAME_LENGTH_H
#define SIM_BUS_FRAME_LENGTH_H

#include "osal/include/osal/can.h"

#include <stdint.h>

#define CAN_INTERMISSION_BITS 3U ///< Between two frames, at the nominal rate.
#define CAN_TAIL_BITS 8U         ///< Bits after the ACK slot: acknowledge delimiter and end of frame field.

/// Bits of a frame from start of frame to the last bit of end of frame, without intermission.
typedef struct {
    uint32_t nominal_bits; ///< At the nominal bit rate.
    uint32_t data_bits;    ///< At the data bit rate (FD with bit rate switch), else 0.
} frame_length_t;

/// Returns the length of a frame; zero for an error frame. The length field must be one that is possible in
/// CAN.
frame_length_t frame_length(const osal_can_frame_t* frame);

/// CRC-15 of classic CAN over the unstuffed bits from start of frame to the end of the data field.
uint16_t frame_crc15(const osal_can_frame_t* frame);

/// Returns the number of data octets of an FD frame for `length` octets of payload (next of 0..8, 12, 16, 20,
/// 24, 32, 48, 64).
uint8_t frame_fd_length(uint8_t length);

#endif // SIM_BUS_FRAME_LENGTH_H
