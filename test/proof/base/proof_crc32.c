// SPDX-License-Identifier: Apache-2.0
// Proves: crc32_iso computes the checksum of the definition, which divides bit by bit by the polynomial
//     0x04C11DB7, least significant bit first, from a register of ones, and inverts the result. For strings
//     of equal size both computations are linear except for a constant: the definition shifts and adds modulo
//     2, and the code adds entries of tables, each of which is linear (proved here). So if both agree for the
//     string of zeros and for each string with a single bit, they agree for all strings of this size. After a
//     block of four octets the register can have any value, because the block can have any value; so
//     agreement for a block and the octets after it is agreement for a string of any length.
// Bounds: strings of 0, 1, 4, 5 and 8 octets of any value; any length by induction.
// Replaced: nothing.
// Sources:
// Options: --unwind 17
// Fault: base/crc.c
//   - NIBBLE(0x01C26A37U, 0x0384D46EU, 0x0709A8DCU, 0x0E1351B8U),
//   + NIBBLE(0x01C26A37U, 0x0384D46EU, 0x0709A8DCU, 0x0E1351B9U),
// Fault: base/crc.c
//   - crc = (crc >> 8U) ^ crc32_of(octets[i] ^ (crc & 0xFFU), 3U);
//   + crc = (crc >> 8U) ^ crc32_of(octets[i] ^ (crc & 0xFFU), 2U);
#include "base/crc.c"

#include "test/proof/proof.h"

#define POLYNOMIAL 0xEDB88320U // 0x04C11DB7 with its bits in reverse order.
#define STRING 8U

static uint32_t by_definition(const uint8_t* const octets, const size_t size)
{
    uint32_t crc = UINT32_MAX;
    for (size_t i = 0U; i < size; i++) {
        crc ^= octets[i];
        for (unsigned bit = 0U; bit < 8U; bit++) {
            crc = ((crc & 1U) != 0U) ? ((crc >> 1U) ^ POLYNOMIAL) : (crc >> 1U);
        }
    }
    return ~crc;
}

/// Each entry of a table is the sum (modulo 2) of the entries of the single bits of its index.
static void prove_tables_linear(void)
{
    for (size_t table = 0U; table < 8U; table++) {
        for (size_t entry = 0U; entry < 16U; entry++) {
            uint32_t sum = 0U;
            for (unsigned bit = 0U; bit < 4U; bit++) {
                sum ^= (((entry >> bit) & 1U) != 0U) ? crc32_tables[table][1U << bit] : 0U;
            }
            PROVE(crc32_tables[table][entry] == sum, "each table is linear");
        }
    }
}

static void prove_equal(const size_t size)
{
    const uint8_t zeros[STRING] = {0};
    PROVE(crc32_iso(zeros, size) == by_definition(zeros, size), "a string of zeros");
    for (size_t index = 0U; index < size; index++) {
        for (unsigned bit = 0U; bit < 8U; bit++) {
            uint8_t octets[STRING] = {0};
            octets[index]          = (uint8_t)(1U << bit);
            PROVE(crc32_iso(octets, size) == by_definition(octets, size), "a string with a single bit");
        }
    }
}

void proof(void)
{
    prove_tables_linear();
    prove_equal(0U);
    prove_equal(1U);
    prove_equal(4U);
    prove_equal(5U);
    prove_equal(8U);
}
