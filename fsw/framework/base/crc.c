// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/base/crc.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/crc_tables.h"

/// Eight octets at once: each has its own table, so that eight independent look-ups replace a chain of eight.
static uint32_t crc16_of_eight(const uint32_t crc, const uint8_t octets[8])
{
    return (uint32_t)crc16_tables[7][octets[0] ^ (crc >> 8U)] ^ crc16_tables[6][octets[1] ^ (crc & 0xFFU)] ^
           crc16_tables[5][octets[2]] ^ crc16_tables[4][octets[3]] ^ crc16_tables[3][octets[4]] ^
           crc16_tables[2][octets[5]] ^ crc16_tables[1][octets[6]] ^ crc16_tables[0][octets[7]];
}

uint16_t crc16_ccitt(const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    uint32_t crc       = 0xFFFFU;
    const size_t whole = size - (size % 8U);
    for (size_t i = 0U; i < whole; i += 8U) {
        crc = crc16_of_eight(crc, &octets[i]);
    }
    for (size_t i = whole; i < size; i++) {
        crc = ((crc << 8U) & 0xFFFFU) ^ crc16_tables[0][(crc >> 8U) ^ octets[i]];
    }
    return (uint16_t)crc;
}

uint32_t crc32_iso(const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((octets != NULL) || (size == 0U));
    uint32_t crc = 0xFFFFFFFFU;
    for (size_t i = 0U; i < size; i++) {
        crc = (crc >> 8U) ^ crc32_table[(crc ^ octets[i]) & 0xFFU];
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
