// SPDX-License-Identifier: Apache-2.0
/// The highest session number that was ever accepted under one key, on a medium that survives a power cut.
///
/// The medium holds the record twice: a write torn by a power cut destroys at most one copy, and if one copy
/// is damaged later the other remains. The number never decreases: a session is valid only after both copies
/// are on the disk, and if no copy can be read the mark is not opened. The program that generates a key
/// also writes its mark, with session 0; therefore an empty medium means that the mark was lost.
///
///     copy at octet 0 and at octet 512: "SDLS" | version 1 | 3 zeros | session (4) | check of the key (8) |
///                                       8 zeros | CRC-32 (4); big-endian
///
/// Ownership  The caller provides sdls_session_mark_t; the medium outlives it.
/// Context    One task; waits for the medium.
#ifndef FSW_FRAMEWORK_SDLS_SESSION_MARK_H
#define FSW_FRAMEWORK_SDLS_SESSION_MARK_H

#include "base/medium.h"

#define SESSION_MARK_RECORD 32U ///< Octets of a copy.
#define SESSION_MARK_APART 512U ///< Distance of the copies [octets], so that they are not in the same sector.
#define SESSION_MARK_CHECK 8U   ///< Octets that distinguish keys.

typedef struct { // Private, except `session`.
    medium_t medium;
    uint8_t check[SESSION_MARK_CHECK];
    uint32_t session; ///< Highest number in use.
    unsigned whole;   // Index of the copy that is known to be intact; writing begins with the other copy.
} sdls_session_mark_t;

/// Read the mark of the key with this check, and repair a damaged copy. STATUS_OK; STATUS_INVALID (no copy is
/// both intact and of this key), STATUS_FULL, STATUS_IO: no frame may be accepted.
MUST_USE status_t sdls_session_mark_open(sdls_session_mark_t* mark, const medium_t* medium,
                                         const uint8_t check[SESSION_MARK_CHECK]);
/// Write a higher number to the disk. STATUS_OK; STATUS_FULL, STATUS_IO: the session must not be used; a
/// later attempt with a higher number may succeed.
MUST_USE status_t sdls_session_mark_advance(sdls_session_mark_t* mark, uint32_t session);

#endif // FSW_FRAMEWORK_SDLS_SESSION_MARK_H
