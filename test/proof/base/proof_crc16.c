// SPDX-License-Identifier: Apache-2.0
// Proves: crc16_ccitt_more computes the checksum of the definition, which divides bit by bit by x^16 + x^12 +
//     x^5 + 1, most significant bit first. Both computations are linear: the definition shifts and adds
//     modulo 2, and the code adds entries of tables, each of which is linear (proved here). So if both agree
//     for each single bit of the register and of the octets, they agree for all values. The checksum
//     continues from any register, so a string of any length is a sequence of blocks of eight octets and of
//     single octets.
// Bounds: every register; a block of eight octets and a single octet, each of any value.
// Replaced: nothing.
// Sources:
// Options: --unwind 17
// Fault: base/crc.c
//   - NIBBLE(0x45A0U, 0x8B40U, 0x06A1U, 0x0D42U)
//   + NIBBLE(0x45A0U, 0x8B40U, 0x06A1U, 0x0D43U)
#include "base/crc.c"

#include "test/proof/proof.h"

#define POLYNOMIAL 0x1021U
#define BLOCK 8U

static uint16_t by_definition(const uint16_t start, const uint8_t* const octets, const size_t size)
{
    uint32_t crc = start;
    for (size_t i = 0U; i < size; i++) {
        crc ^= (uint32_t)octets[i] << 8U;
        for (unsigned bit = 0U; bit < 8U; bit++) {
            crc = ((crc & 0x8000U) != 0U) ? (((crc << 1U) ^ POLYNOMIAL) & 0xFFFFU) : (crc << 1U);
        }
    }
    return (uint16_t)crc;
}

/// Each entry of a table is the sum (modulo 2) of the entries of the single bits of its index.
static void prove_tables_linear(void)
{
    for (size_t table = 0U; table < 16U; table++) {
        for (size_t entry = 0U; entry < 16U; entry++) {
            uint16_t sum = 0U;
            for (unsigned bit = 0U; bit < 4U; bit++) {
                sum ^= (((entry >> bit) & 1U) != 0U) ? crc16_tables[table][1U << bit] : 0U;
            }
            PROVE(crc16_tables[table][entry] == sum, "each table is linear");
        }
    }
}

static void prove_equal(const uint16_t start, const uint8_t octets[BLOCK])
{
    PROVE(crc16_ccitt_more(start, octets, BLOCK) == by_definition(start, octets, BLOCK), "a block of eight");
    PROVE(crc16_ccitt_more(start, octets, 1U) == by_definition(start, octets, 1U), "a single octet");
}

void proof(void)
{
    const uint8_t zeros[BLOCK] = {0};
    prove_tables_linear();
    PROVE(CRC16_START == 0xFFFFU, "a checksum starts with ones");
    prove_equal(0U, zeros);
    for (unsigned bit = 0U; bit < 16U; bit++) {
        prove_equal((uint16_t)(1U << bit), zeros);
    }
    for (size_t index = 0U; index < BLOCK; index++) {
        for (unsigned bit = 0U; bit < 8U; bit++) {
            uint8_t octets[BLOCK] = {0};
            octets[index]         = (uint8_t)(1U << bit);
            prove_equal(0U, octets);
        }
    }
}
