// SPDX-License-Identifier: Apache-2.0
/// Shape of a request: a short program, made from the catalogue of messages (pus/catalogue), that walks
/// through application data without effect, so that every count, length and selector is checked before a
/// service sees the request.
///
///     COUNT least length body   a count (u8) of at least `least`, and the body so many times
///     SELECT CASE value length body JUMP length ... FAIL   a selector (u8) and what follows it by its value
///     ID r, LAYOUT r            a parameter id, or the code of a scalar layout; kept in register r (0, 1)
///     VALUE r                   a value of that layout; only scalars can be walked
///     SIZED                     u16 length and so many octets; PACKET a whole request; REST all that is left
///
/// Context    Any; no state.
/// Time       O(octets).
#ifndef PUS_CORE_SHAPE_H
#define PUS_CORE_SHAPE_H

#include "base/octets.h"

enum {
    PUS_SHAPE_END = 0,
    PUS_SHAPE_SKIP, ///< n: so many octets.
    PUS_SHAPE_COUNT,
    PUS_SHAPE_SELECT,
    PUS_SHAPE_CASE,
    PUS_SHAPE_JUMP, ///< length: of the program to leave out.
    PUS_SHAPE_FAIL,
    PUS_SHAPE_ID,
    PUS_SHAPE_LAYOUT,
    PUS_SHAPE_VALUE,
    PUS_SHAPE_SIZED,
    PUS_SHAPE_PACKET,
    PUS_SHAPE_REST
};

#define PUS_SHAPE_DEPTH 4U ///< Counts within counts.

/// Walk. False: a count, a selector, a layout or an embedded request is wrong, at the reader's position; or
/// the reader has failed, because octets are missing. The caller sees whether octets are left over.
bool pus_shape_walk(const uint8_t* program, octet_reader_t* reader);

#endif // PUS_CORE_SHAPE_H
