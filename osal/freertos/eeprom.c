// SPDX-License-Identifier: Apache-2.0
#include "osal/freertos/eeprom.h"

#include "base/assertion.h"
#include "osal/freertos/i2c.h"
#include "osal/include/osal/clock.h"

#include <stdbool.h>

#define DEVICE 0x50U            ///< Address of the first half; that of the second half is one higher.
#define HALF_OCTETS 65536U      ///< Octets of a half.
#define WRITE_TIME_NS 20000000U ///< Longer than a write to any EEPROM takes.

typedef struct {
    uint8_t device;
    uint8_t octets[2];
} i2c_address_t;

static i2c_address_t i2c_address_of(const uint32_t address)
{
    return (i2c_address_t){.device = (uint8_t)(DEVICE + (address / HALF_OCTETS)),
                           .octets = {(uint8_t)(address >> 8U), (uint8_t)address}};
}

status_t eeprom_read(const uint32_t address, void* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) && (size > 0U) && (address < EEPROM_OCTETS));
    FSW_ASSERT(size <= (HALF_OCTETS - (address % HALF_OCTETS)));
    const i2c_address_t from = i2c_address_of(address);
    return i2c_read(from.device, from.octets, sizeof from.octets, octets, size);
}

/// The EEPROM acknowledges its address only when it has stored what was written before.
static status_t await_stored(const i2c_address_t to)
{
    const uint64_t until_ns = osal_clock_monotonic_ns() + WRITE_TIME_NS;
    status_t status         = STATUS_IO;
    do {
        status = i2c_write(to.device, to.octets, sizeof to.octets, NULL, 0U);
    } while ((status != STATUS_OK) && (osal_clock_monotonic_ns() < until_ns));
    return status;
}

status_t eeprom_write(const uint32_t address, const void* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) && (address < EEPROM_OCTETS) && (size <= (EEPROM_OCTETS - address)));
    const uint8_t* const all = octets;
    status_t status          = STATUS_OK;
    size_t done              = 0U;
    while ((done < size) && (status == STATUS_OK)) {
        const uint32_t at = address + (uint32_t)done;
        // A write that goes beyond its page continues at the start of the same page.
        const size_t room      = EEPROM_PAGE - (at % EEPROM_PAGE);
        const size_t count     = ((size - done) < room) ? (size - done) : room;
        const i2c_address_t to = i2c_address_of(at);
        status                 = i2c_write(to.device, to.octets, sizeof to.octets, &all[done], count);
        status                 = (status == STATUS_OK) ? await_stored(to) : status;
        done += count;
    }
    return status;
}
