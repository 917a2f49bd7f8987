// SPDX-License-Identifier: Apache-2.0
/// EEPROM of 128 KiB on the bus I2C of the board, with the commands of the AT24CM01 of Microchip. An address
/// has 17 bits, of which the device address contains the highest. A page has 256 octets. A power cut during a
/// write leaves any octets in that page and does not change others. One task at a time.
#ifndef OSAL_FREERTOS_EEPROM_H
#define OSAL_FREERTOS_EEPROM_H

#include "base/status.h"
#include "osal/include/osal/target_eeprom.h"

#include <stddef.h>
#include <stdint.h>

#define EEPROM_OCTETS TARGET_EEPROM_OCTETS
#define EEPROM_PAGE 256U

/// Read octets that lie within one half of the EEPROM. STATUS_OK, STATUS_IO (there is no EEPROM).
MUST_USE status_t eeprom_read(uint32_t address, void* octets, size_t size);
/// Write octets, and wait until they are stored, which takes a real EEPROM some milliseconds for each page.
/// STATUS_OK, STATUS_IO (the EEPROM does not answer).
MUST_USE status_t eeprom_write(uint32_t address, const void* octets, size_t size);

#endif // OSAL_FREERTOS_EEPROM_H
