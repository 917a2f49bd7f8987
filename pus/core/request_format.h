// SPDX-License-Identifier: Apache-2.0
/// Format of a request: a short program, made from the catalogue of messages (pus/catalogue), that reads
/// through application data without effect, so that every count, length and selector is checked before a
/// service sees the request.
///
///     COUNT least length body   a count (u8) of at least `least`, and that many times the body
///     SELECT CASE value length body JUMP length ... FAIL   a selector (u8); its value decides what follows
///     ID r, LAYOUT r            a parameter id, or the code of a scalar layout; kept in register r (0, 1)
///     VALUE r                   a value of that layout; only scalars can be read
///     SIZED                     u16 length and that many octets; PACKET a whole request; REST all that is
///     left
///
/// Context    Any; no state.
/// Time       O(octets).
#ifndef PUS_CORE_REQUEST_FORMAT_H
#define PUS_CORE_REQUEST_FORMAT_H

#include "base/octets.h"

enum {
    PUS_REQUEST_FORMAT_END = 0,
    PUS_REQUEST_FORMAT_SKIP, ///< n: number of octets.
    PUS_REQUEST_FORMAT_COUNT,
    PUS_REQUEST_FORMAT_SELECT,
    PUS_REQUEST_FORMAT_CASE,
    PUS_REQUEST_FORMAT_JUMP, ///< length: of the program to leave out.
    PUS_REQUEST_FORMAT_FAIL,
    PUS_REQUEST_FORMAT_ID,
    PUS_REQUEST_FORMAT_LAYOUT,
    PUS_REQUEST_FORMAT_VALUE,
    PUS_REQUEST_FORMAT_SIZED,
    PUS_REQUEST_FORMAT_PACKET,
    PUS_REQUEST_FORMAT_REST
};

#define PUS_REQUEST_FORMAT_DEPTH 4U ///< Counts within counts.

/// Check application data. False: a count, a selector, a layout or an embedded request is wrong, at the
/// reader's position; or the reader has failed, because octets are missing. The caller sees whether octets
/// are left over.
bool pus_request_format_check(const uint8_t* program, octet_reader_t* reader);

#endif // PUS_CORE_REQUEST_FORMAT_H
