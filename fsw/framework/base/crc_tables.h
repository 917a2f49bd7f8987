// SPDX-License-Identifier: Apache-2.0
/// Constants of the checksums: effect of one octet, for crc16 also of one that 1 to 7 others follow.
#ifndef FSW_FRAMEWORK_BASE_CRC_TABLES_H
#define FSW_FRAMEWORK_BASE_CRC_TABLES_H

#include <stdint.h>

extern const uint16_t crc16_tables[8][256];
extern const uint32_t crc32_table[256];

#endif // FSW_FRAMEWORK_BASE_CRC_TABLES_H
