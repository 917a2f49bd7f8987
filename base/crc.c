// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"

#include "base/assertion.h"

// The functions process a whole word at once. Each half octet of the word has its own table, so that no
// look-up depends on the result of another; the tables of each checksum take 512 octets. A checksum is
// linear: therefore four constants, one for each bit of the half octet, define a table.
#define NIBBLE(a, b, c, d)                                                                                   \
    {                                                                                                        \
        0U, (a), (b), (a) ^ (b), (c), (a) ^ (c), (b) ^ (c), (a) ^ (b) ^ (c), (d), (a) ^ (d), (b) ^ (d),      \
            (a) ^ (b) ^ (d), (c) ^ (d), (a) ^ (c) ^ (d), (b) ^ (c) ^ (d), (a) ^ (b) ^ (c) ^ (d)              \
    }

/// x^16, x^17 and so on modulo the polynomial: the effect of each bit of eight octets, last bit first.
static const uint16_t crc16_tables[16][16] = {
    NIBBLE(0x1021U, 0x2042U, 0x4084U, 0x8108U), NIBBLE(0x1231U, 0x2462U, 0x48C4U, 0x9188U),
    NIBBLE(0x3331U, 0x6662U, 0xCCC4U, 0x89A9U), NIBBLE(0x0373U, 0x06E6U, 0x0DCCU, 0x1B98U),
    NIBBLE(0x3730U, 0x6E60U, 0xDCC0U, 0xA9A1U), NIBBLE(0x4363U, 0x86C6U, 0x1DADU, 0x3B5AU),
    NIBBLE(0x76B4U, 0xED68U, 0xCAF1U, 0x85C3U), NIBBLE(0x1BA7U, 0x374EU, 0x6E9CU, 0xDD38U),
    NIBBLE(0xAA51U, 0x4483U, 0x8906U, 0x022DU), NIBBLE(0x045AU, 0x08B4U, 0x1168U, 0x22D0U),
    NIBBLE(0x45A0U, 0x8B40U, 0x06A1U, 0x0D42U), NIBBLE(0x1A84U, 0x3508U, 0x6A10U, 0xD420U),
    NIBBLE(0xB861U, 0x60E3U, 0xC1C6U, 0x93ADU), NIBBLE(0x377BU, 0x6EF6U, 0xDDECU, 0xABF9U),
    NIBBLE(0x47D3U, 0x8FA6U, 0x0F6DU, 0x1EDAU), NIBBLE(0x3DB4U, 0x7B68U, 0xF6D0U, 0xFD81U),
};

/// Content of the CRC register 32 shifts after it contained a single bit; bit 0 first.
static const uint32_t crc32_tables[8][16] = {
    NIBBLE(0xB8BC6765U, 0xAA09C88BU, 0x8F629757U, 0xC5B428EFU),
    NIBBLE(0x5019579FU, 0xA032AF3EU, 0x9B14583DU, 0xED59B63BU),
    NIBBLE(0x01C26A37U, 0x0384D46EU, 0x0709A8DCU, 0x0E1351B8U),
    NIBBLE(0x1C26A370U, 0x384D46E0U, 0x709A8DC0U, 0xE1351B80U),
    NIBBLE(0x191B3141U, 0x32366282U, 0x646CC504U, 0xC8D98A08U),
    NIBBLE(0x4AC21251U, 0x958424A2U, 0xF0794F05U, 0x3B83984BU),
    NIBBLE(0x77073096U, 0xEE0E612CU, 0x076DC419U, 0x0EDB8832U),
    NIBBLE(0x1DB71064U, 0x3B6E20C8U, 0x76DC4190U, 0xEDB88320U),
};

/// Contribution of an octet to a CRC-16 if `following` octets of its block come after it.
static inline uint32_t crc16_of(const uint32_t octet, const size_t following)
{
    return (uint32_t)crc16_tables[(2U * following) + 1U][octet >> 4U] ^
           crc16_tables[2U * following][octet & 0xFU];
}

/// Contribution of an octet to a CRC-32 if `before` octets of its block come before it.
static inline uint32_t crc32_of(const uint32_t octet, const size_t before)
{
    return crc32_tables[2U * before][octet & 0xFU] ^ crc32_tables[(2U * before) + 1U][octet >> 4U];
}

uint16_t crc16_ccitt(const uint8_t* const octets, const size_t size)
{
    return crc16_ccitt_more(CRC16_START, octets, size);
}

uint16_t crc16_ccitt_more(const uint16_t start, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    uint32_t crc       = start;
    const size_t whole = size - (size % 8U);
    for (size_t i = 0U; i < whole; i += 8U) {
        const uint8_t* const next = &octets[i];
        crc = crc16_of(next[0] ^ (crc >> 8U), 7U) ^ crc16_of(next[1] ^ (crc & 0xFFU), 6U) ^
              crc16_of(next[2], 5U) ^ crc16_of(next[3], 4U) ^ crc16_of(next[4], 3U) ^ crc16_of(next[5], 2U) ^
              crc16_of(next[6], 1U) ^ crc16_of(next[7], 0U);
    }
    for (size_t i = whole; i < size; i++) {
        crc = ((crc << 8U) & 0xFFFFU) ^ crc16_of((crc >> 8U) ^ octets[i], 0U);
    }
    return (uint16_t)crc;
}

uint32_t crc32_iso(const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    uint32_t crc       = 0xFFFFFFFFU;
    const size_t whole = size - (size % 4U);
    for (size_t i = 0U; i < whole; i += 4U) {
        const uint8_t* const next = &octets[i];
        crc = crc32_of(next[0] ^ (crc & 0xFFU), 0U) ^ crc32_of(next[1] ^ ((crc >> 8U) & 0xFFU), 1U) ^
              crc32_of(next[2] ^ ((crc >> 16U) & 0xFFU), 2U) ^ crc32_of(next[3] ^ (crc >> 24U), 3U);
    }
    for (size_t i = whole; i < size; i++) {
        crc = (crc >> 8U) ^ crc32_of(octets[i] ^ (crc & 0xFFU), 3U);
    }
    return crc ^ 0xFFFFFFFFU;
}

uint64_t fnv64(const uint64_t hash, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    uint64_t value = hash;
    for (size_t i = 0U; i < size; i++) {
        value = (value ^ octets[i]) * 0x100000001B3ULL;
    }
    return value;
}
