// SPDX-License-Identifier: Apache-2.0
/// A CANopen master for tests of the devices: sends frames, records received ones, does SDO transfers frame
/// by frame.
///
/// Controlwords of CiA 402 in these tests: 0x06 shutdown, 0x07 switch on, 0x0F enable operation, 0x02 quick
/// stop, 0x80 fault reset. States in the statusword under the mask 0x6F: 0x21 ready, 0x23 switched on, 0x27
/// operation enabled, 0x07 quick stop active; under 0x4F: 0x40 switch on disabled, 0x08 fault.
#ifndef TEST_UNIT_SIM_DEVICES_MASTER_H
#define TEST_UNIT_SIM_DEVICES_MASTER_H

#include "sim/bus/bus.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MASTER_HEARD_MAX 8192U
#define MASTER_US 1000U
#define MASTER_MS 1000000U

typedef struct {
    bus_t* bus;
    unsigned node;
    unsigned count;
    osal_can_frame_t heard[MASTER_HEARD_MAX];
} master_t;

/// Make an FD bus, or a classic one if `classic`, whose first node is the master.
void master_open(master_t* master, bool classic);
void master_close(master_t* master);
/// Let simulated time pass.
void master_wait(master_t* master, uint64_t ns);
void master_send(master_t* master, uint32_t id, const void* data, uint8_t length);
void master_nmt(master_t* master, uint8_t command, uint8_t node);
/// Send SYNC, then let `ns` pass.
void master_sync(master_t* master, uint64_t ns);

/// Forget the received frames.
void master_forget(master_t* master);
/// Returns the number of received frames with an identifier.
unsigned master_heard(const master_t* master, uint32_t id);
/// Returns the last received frame with an identifier; null if there is none.
const osal_can_frame_t* master_last(const master_t* master, uint32_t id);

/// Send an SDO request (8 octets) and wait for its response. Returns false if there is none within 2 ms.
bool master_request(master_t* master, uint8_t node, const uint8_t request[8], uint8_t answer[8]);
/// Write or read an object by an expedited SDO transfer. Returns 0, the abort code, or UINT32_MAX if there is
/// no response.
uint32_t master_write(master_t* master, uint8_t node, uint16_t index, uint8_t subindex, uint32_t value,
                      uint8_t size);
uint32_t master_read(master_t* master, uint8_t node, uint16_t index, uint8_t subindex, uint32_t* out_value);

/// Read little-endian numbers from a frame.
uint16_t octets_u16(const uint8_t* octets);
uint32_t octets_u32(const uint8_t* octets);

#endif // TEST_UNIT_SIM_DEVICES_MASTER_H
