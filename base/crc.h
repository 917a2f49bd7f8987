// SPDX-License-Identifier: Apache-2.0
/// Checksums of the wire formats, and the hash of descriptor texts. The functions use tables, are reentrant
/// and take O(size).
#ifndef BASE_CRC_H
#define BASE_CRC_H

#include <stddef.h>
#include <stdint.h>

/// CRC-16/CCITT-FALSE of ECSS packet error control: polynomial 0x1021, initial value 0xFFFF, no reflection.
/// The CRC of a packet with its own CRC at the end is 0. Check value: "123456789" -> 0x29B1.
uint16_t crc16_ccitt(const uint8_t* octets, size_t size);
/// CRC-16 of octets in several pieces. `start` is the result for the pieces before; CRC16_START for the
/// first.
#define CRC16_START 0xFFFFU
uint16_t crc16_ccitt_more(uint16_t start, const uint8_t* octets, size_t size);

/// CRC-32 (ISO-HDLC, as Ethernet): reflected 0xEDB88320. Check value: "123456789" -> 0xCBF43926.
uint32_t crc32_iso(const uint8_t* octets, size_t size);

/// FNV-1a 64 bit, continued from `hash`; start with FNV64_START. Used for descriptor hashes.
#define FNV64_START 0xCBF29CE484222325ULL
uint64_t fnv64(uint64_t hash, const uint8_t* octets, size_t size);

#endif // BASE_CRC_H
