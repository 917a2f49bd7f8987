// SPDX-License-Identifier: Apache-2.0
/// Master of a bus I2C. The board has registers for the levels of its two lines only (Arm SBCon, "Serial Bus
/// Controller" in the manual of the MPS2 boards), so the processor sends each bit. One task at a time.
#ifndef OSAL_FREERTOS_I2C_H
#define OSAL_FREERTOS_I2C_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

/// Free the bus ("bus clear" in the specification of I2C, NXP UM10204). If the processor was reset within a
/// read, a device may still send an octet; it holds the data line low until it gets clock pulses. Called
/// before the first transfer. STATUS_OK; STATUS_IO: the data line stays low.
MUST_USE status_t i2c_clear(void);
/// Write `head` and then `octets` to a device, whose address has 7 bits, in one transfer. STATUS_OK;
/// STATUS_IO: the device does not acknowledge.
MUST_USE status_t i2c_write(uint8_t device, const uint8_t* head, size_t head_size, const uint8_t* octets,
                            size_t size);
/// Write `head` to a device and then read `size` octets, size >= 1, in one transfer. Same statuses.
MUST_USE status_t i2c_read(uint8_t device, const uint8_t* head, size_t head_size, uint8_t* octets,
                           size_t size);

#endif // OSAL_FREERTOS_I2C_H
