// SPDX-License-Identifier: Apache-2.0
// The lines are open-drain: both ends can pull a line low, and a released line is high. Data change
// only while the clock is low; a change while it is high begins (START) or ends (STOP) a transfer.
#include "osal/freertos/i2c.h"

#include "osal/freertos/board.h"

#include <stdbool.h>

#define CLOCK 1U
#define DATA 2U
#define READS 1U        ///< Lowest bit of the first octet of a transfer: the device sends.
#define CLEAR_PULSES 9U ///< Eight bits and an acknowledge bit; without an acknowledge the device stops.

typedef struct {
    volatile uint32_t high; ///< Written: lines that are released. Read: levels of the lines.
    volatile uint32_t low;  ///< Written: lines that are pulled low.
} lines_t;
#define LINES ((lines_t*)BOARD_I2C)

static void set_data(const bool level)
{
    if (level) {
        LINES->high = DATA;
    } else {
        LINES->low = DATA;
    }
}

static void begin(void)
{
    LINES->high = DATA; // Released while the clock is low: a rise while it is high would be a STOP.
    LINES->high = CLOCK;
    LINES->low  = DATA;
    LINES->low  = CLOCK;
}

static void end(void)
{
    LINES->low  = DATA;
    LINES->high = CLOCK;
    LINES->high = DATA;
}

/// Returns the level of the data line during one pulse of the clock.
static bool pulse(void)
{
    LINES->high      = CLOCK;
    const bool level = (LINES->high & DATA) != 0U;
    LINES->low       = CLOCK;
    return level;
}

/// Send an octet. Returns true if the device acknowledges it.
static bool send(const uint8_t octet)
{
    bool level = false;
    set_data(level);
    for (unsigned bit = 0x80U; bit > 0U; bit >>= 1U) {
        const bool next = (octet & bit) != 0U;
        if (next != level) { // No access without a change, because each access to a register takes time.
            set_data(next);
            level = next;
        }
        LINES->high = CLOCK;
        LINES->low  = CLOCK;
    }
    set_data(true);
    return !pulse();
}

static uint8_t receive(const bool is_last)
{
    unsigned octet = 0U;
    for (unsigned i = 0U; i < 8U; i++) {
        octet = (octet << 1U) | (pulse() ? 1U : 0U);
    }
    set_data(is_last); // Low acknowledges: the device sends another octet.
    LINES->high = CLOCK;
    LINES->low  = CLOCK;
    set_data(true);
    return (uint8_t)octet;
}

/// Begin to write to a device, and send `head`. Returns false if the device does not acknowledge.
static bool address(const uint8_t device, const uint8_t* const head, const size_t size)
{
    begin();
    bool is_good = send((uint8_t)(device << 1U));
    for (size_t i = 0U; (i < size) && is_good; i++) {
        is_good = send(head[i]);
    }
    return is_good;
}

status_t i2c_clear(void)
{
    LINES->high = DATA;
    LINES->high = CLOCK;
    for (unsigned i = 0U; (i < CLEAR_PULSES) && ((LINES->high & DATA) == 0U); i++) {
        LINES->low  = CLOCK;
        LINES->high = CLOCK;
    }
    const bool is_free = (LINES->high & DATA) != 0U;
    LINES->low         = DATA; // A START resets each device, whatever it is doing.
    LINES->high        = DATA;
    return is_free ? STATUS_OK : STATUS_IO;
}

status_t i2c_write(const uint8_t device, const uint8_t* const head, const size_t head_size,
                   const uint8_t* const octets, const size_t size)
{
    bool is_good = address(device, head, head_size);
    for (size_t i = 0U; (i < size) && is_good; i++) {
        is_good = send(octets[i]);
    }
    end();
    return is_good ? STATUS_OK : STATUS_IO;
}

status_t i2c_read(const uint8_t device, const uint8_t* const head, const size_t head_size,
                  uint8_t* const octets, const size_t size)
{
    bool is_good = address(device, head, head_size);
    if (is_good) {
        begin();
        is_good = send((uint8_t)((unsigned)(device << 1U) | READS));
    }
    for (size_t i = 0U; (i < size) && is_good; i++) {
        octets[i] = receive((i + 1U) == size);
    }
    end();
    return is_good ? STATUS_OK : STATUS_IO;
}
