// SPDX-License-Identifier: Apache-2.0
// The EEPROM of the emulated board, which the runner of the tests attaches. One test makes it silent.
#include "osal/freertos/eeprom.h"

#include "osal/freertos/board.h"
#include "osal/freertos/i2c.h"
#include "osal/include/osal/clock.h"
#include "unity.h"

#include <stdbool.h>
#include <string.h>

#define HALF 65536U
#define LONG_OCTETS 700U
#define LATEST_MS 25U

static unsigned transfers; ///< Number of writes on the bus.
static unsigned busy;      ///< Number of next addresses that are not acknowledged; UINT_MAX: all.
static uint8_t written[LONG_OCTETS];
static uint8_t found[LONG_OCTETS];

status_t __real_i2c_write(uint8_t device, const uint8_t* head, size_t head_size, const uint8_t* octets,
                          size_t size);
status_t __wrap_i2c_write(uint8_t device, const uint8_t* head, size_t head_size, const uint8_t* octets,
                          size_t size);

status_t __wrap_i2c_write(const uint8_t device, const uint8_t* const head, const size_t head_size,
                          const uint8_t* const octets, const size_t size)
{
    transfers++;
    if ((size == 0U) && (busy > 0U)) {
        busy -= (busy < UINT32_MAX) ? 1U : 0U;
        return STATUS_IO;
    }
    return __real_i2c_write(device, head, head_size, octets, size);
}

void setUp(void)
{
    busy      = 0U;
    transfers = 0U;
    for (size_t i = 0U; i < LONG_OCTETS; i++) {
        written[i] = (uint8_t)((i * 7U) + (i >> 8U));
    }
    (void)memset(found, 0, sizeof found);
}

void tearDown(void)
{
}

static void octets_are_stored_where_they_were_written(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_write(256U, written, 16U));
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(256U, found, 16U));
    TEST_ASSERT_EQUAL_MEMORY(written, found, 16U);
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(255U, found, 3U));
    TEST_ASSERT_EQUAL_UINT8(0xFFU, found[0]); // The octet before is still blank.
    TEST_ASSERT_EQUAL_MEMORY(written, &found[1], 2U);
    const uint8_t octets[] = {0x00U, 0xFFU, 0x80U, 0x01U};
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_write(257U, octets, sizeof octets)); // Needs no erasure.
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(256U, found, 6U));
    TEST_ASSERT_EQUAL_UINT8(written[0], found[0]);
    TEST_ASSERT_EQUAL_MEMORY(octets, &found[1], sizeof octets);
    TEST_ASSERT_EQUAL_UINT8(written[5], found[5]);
}

static void a_write_is_divided_at_pages_and_halves(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_write(HALF - 300U, written, LONG_OCTETS));
    // The pages begin 512 and 256 before the middle, at it, and 256 after it; each write is followed by one
    // poll.
    TEST_ASSERT_EQUAL_UINT(8U, transfers);
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(HALF - 300U, found, 300U));
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(HALF, &found[300], LONG_OCTETS - 300U));
    TEST_ASSERT_EQUAL_MEMORY(written, found, LONG_OCTETS);
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_write(EEPROM_OCTETS - 1U, written, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(EEPROM_OCTETS - 1U, found, 1U));
    TEST_ASSERT_EQUAL_UINT8(written[0], found[0]);
}

static void a_write_waits_until_the_octets_are_stored(void)
{
    busy = 3U;
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_write(0U, written, 1U));
    TEST_ASSERT_EQUAL_UINT(5U, transfers);
}

static void an_eeprom_that_stays_silent_is_an_error(void)
{
    const uint64_t begin_ns = osal_clock_monotonic_ns();
    busy                    = UINT32_MAX;
    TEST_ASSERT_EQUAL(STATUS_IO, eeprom_write(0U, written, LONG_OCTETS));
    TEST_ASSERT_LESS_THAN_UINT64(LATEST_MS * 1000000ULL, osal_clock_monotonic_ns() - begin_ns);
}

static void a_device_that_does_not_exist_does_not_acknowledge(void)
{
    const uint8_t head[] = {0U, 0U};
    TEST_ASSERT_EQUAL(STATUS_IO, i2c_read(0x57U, head, sizeof head, found, 1U));
    TEST_ASSERT_EQUAL(STATUS_IO, __real_i2c_write(0x57U, head, sizeof head, written, 1U));
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(0U, found, 1U)); // The bus is free again.
}

// ---- A bus in use ----

#define CLOCK 1U
#define DATA 2U
static volatile uint32_t* const lines = (volatile uint32_t*)BOARD_I2C; // [0]: released, [1]: pulled low.

static void pulse(const bool level)
{
    lines[level ? 0 : 1] = DATA;
    lines[0]             = CLOCK;
    lines[1]             = CLOCK;
}

/// Begin a read at the address that the last transfer set, and give up in the clock pulse after `bits` bits
/// of the first octet. (The emulated EEPROM holds the data line low only while the clock is high.)
static void leave_read_after(const unsigned bits)
{
    const unsigned device_reads = (0x50U << 1U) | 1U;
    lines[0]                    = DATA;
    lines[0]                    = CLOCK;
    lines[1]                    = DATA; // START
    lines[1]                    = CLOCK;
    for (unsigned bit = 0x80U; bit > 0U; bit >>= 1U) {
        pulse((device_reads & bit) != 0U);
    }
    for (unsigned i = 0U; i <= bits; i++) { // The first pulse takes the acknowledgement of the address.
        pulse(true);
    }
    lines[0] = CLOCK;
}

static void a_reset_within_a_read_leaves_no_line_low(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, eeprom_write(0U, "\0\0\xA5", 3U));
    for (unsigned bits = 0U; bits < 8U; bits++) {
        TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(0U, found, 1U)); // The next address is 1.
        leave_read_after(bits);
        TEST_ASSERT_EQUAL_UINT32(0U, lines[0] & DATA);
        TEST_ASSERT_EQUAL(STATUS_OK, i2c_clear());
        TEST_ASSERT_EQUAL_UINT32(DATA | CLOCK, lines[0]);
        TEST_ASSERT_EQUAL(STATUS_OK, eeprom_read(2U, found, 1U));
        TEST_ASSERT_EQUAL_UINT8(0xA5U, found[0]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(octets_are_stored_where_they_were_written);
    RUN_TEST(a_write_is_divided_at_pages_and_halves);
    RUN_TEST(a_write_waits_until_the_octets_are_stored);
    RUN_TEST(an_eeprom_that_stays_silent_is_an_error);
    RUN_TEST(a_device_that_does_not_exist_does_not_acknowledge);
    RUN_TEST(a_reset_within_a_read_leaves_no_line_low);
    return UNITY_END();
}
