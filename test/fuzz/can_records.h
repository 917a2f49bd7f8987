// SPDX-License-Identifier: Apache-2.0
/// Records that are CAN frames: identifier u16, then the data; the record's argument gives the kind of frame.
#ifndef TEST_FUZZ_CAN_RECORDS_H
#define TEST_FUZZ_CAN_RECORDS_H

#include "osal/include/osal/can.h"
#include "test/fuzz/fuzz.h"

#define CAN_RECORD_HEADER 2U

/// Returns the frame of a record. Argument bit 0: extended, 1: remote, 2: error, 3: FD (up to 64 octets
/// of data, otherwise up to 8).
osal_can_frame_t fuzz_can_frame(const fuzz_record_t* record);
/// Change the identifier to one that CANopen node 0x11 or 0x12 uses, or that of NMT.
void fuzz_repair_can(uint8_t kind, uint8_t* octets, size_t size, uint32_t* random);

#endif // TEST_FUZZ_CAN_RECORDS_H
