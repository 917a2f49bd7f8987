// SPDX-License-Identifier: Apache-2.0
/// Bounded big-endian reader and writer of octet strings.
///
/// The first access outside the bounds sets `failed`, which stays set; a failed reader returns zeros and a
/// failed writer writes nothing, so that a codec can process the whole string and check `failed` once at its
/// end.
///
/// Ownership  The octets must exist as long as the reader or writer is used.
/// Context    Any; one task for each reader or writer.
/// Time       O(1), copies O(n).
#ifndef BASE_OCTETS_H
#define BASE_OCTETS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    const uint8_t* octets;
    size_t size;     ///< [octets]
    size_t position; ///< Next octet to read, 0..size.
    bool failed;     ///< A read went past the end.
} octet_reader_t;

typedef struct {
    uint8_t* octets;
    size_t capacity; ///< [octets]
    size_t position; ///< Octets written so far, 0..capacity.
    bool failed;     ///< A write did not fit.
} octet_writer_t;

/// Big-endian numbers at an address, without a check of bounds; for headers whose length is fixed.
static inline void octets_put_u16(uint8_t* octets, uint16_t value)
{
    octets[0] = (uint8_t)(value >> 8U);
    octets[1] = (uint8_t)(value & 0xFFU);
}

static inline void octets_put_u32(uint8_t* octets, uint32_t value)
{
    octets[0] = (uint8_t)(value >> 24U);
    octets[1] = (uint8_t)((value >> 16U) & 0xFFU);
    octets[2] = (uint8_t)((value >> 8U) & 0xFFU);
    octets[3] = (uint8_t)(value & 0xFFU);
}

static inline void octets_put_u64(uint8_t* octets, uint64_t value)
{
    octets_put_u32(octets, (uint32_t)(value >> 32U));
    octets_put_u32(&octets[4], (uint32_t)(value & UINT32_MAX));
}

static inline uint16_t octets_u16_at(const uint8_t* octets)
{
    return (uint16_t)(((uint32_t)octets[0] << 8U) | octets[1]);
}

static inline uint32_t octets_u32_at(const uint8_t* octets)
{
    return ((uint32_t)octets[0] << 24U) | ((uint32_t)octets[1] << 16U) | ((uint32_t)octets[2] << 8U) |
           octets[3];
}

static inline uint64_t octets_u64_at(const uint8_t* octets)
{
    return ((uint64_t)octets_u32_at(octets) << 32U) | octets_u32_at(&octets[4]);
}

octet_reader_t octet_reader(const uint8_t* octets, size_t size);
uint8_t octet_read_u8(octet_reader_t* reader);
uint16_t octet_read_u16(octet_reader_t* reader);
uint32_t octet_read_u32(octet_reader_t* reader);
uint64_t octet_read_u64(octet_reader_t* reader);
double octet_read_f64(octet_reader_t* reader);
/// Skip `size` octets and return a pointer to them in the reader's buffer, or NULL (and failed) if fewer are
/// left.
const uint8_t* octet_read_octets(octet_reader_t* reader, size_t size);
/// Returns the number of octets not read yet; 0 if the reader has failed.
size_t octet_reader_left(const octet_reader_t* reader);
/// True if nothing failed and the last octet has been read.
bool octet_reader_is_done(const octet_reader_t* reader);

octet_writer_t octet_writer(uint8_t* octets, size_t capacity);
void octet_write_u8(octet_writer_t* writer, uint8_t value);
void octet_write_u16(octet_writer_t* writer, uint16_t value);
void octet_write_u32(octet_writer_t* writer, uint32_t value);
void octet_write_u64(octet_writer_t* writer, uint64_t value);
void octet_write_f64(octet_writer_t* writer, double value);
/// Reserve the next `size` octets. Returns a pointer to them, for the caller to fill, or NULL (and failed) if
/// they do not fit.
uint8_t* octet_write_space(octet_writer_t* writer, size_t size);
void octet_write_octets(octet_writer_t* writer, const uint8_t* octets, size_t size);

#endif // BASE_OCTETS_H
