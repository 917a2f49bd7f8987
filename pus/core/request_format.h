// SPDX-License-Identifier: Apache-2.0
/// Format of a request: a short program, generated from the catalogue of messages (pus/catalogue). The
/// interpreter reads the application data without any other effect and checks every count, length and
/// selector, before a service gets the request. `length` counts octets of the program.
///
///     SKIP n                    n octets of the data
///     COUNT least length body   a count (u8) of at least `least`, and that many times the body
///     SELECT CASE value length body JUMP length ... FAIL   a selector (u8), and the body of its case
///     ID r, LAYOUT r            a parameter id, or the code of a scalar layout; stored in register r (0, 1)
///     VALUE r                   a value of the layout in register r; only scalars can be read
///     SIZED                     a length (u16) and that many octets
///     PACKET, REST              a whole request; all octets that are left
///     END                       the end of the program
///
/// Context    Any; no state.
/// Time       O(octets of the application data).
#ifndef PUS_CORE_REQUEST_FORMAT_H
#define PUS_CORE_REQUEST_FORMAT_H

#include "base/octets.h"

enum {
    PUS_REQUEST_FORMAT_END = 0,
    PUS_REQUEST_FORMAT_SKIP, ///< n: number of octets.
    PUS_REQUEST_FORMAT_COUNT,
    PUS_REQUEST_FORMAT_SELECT,
    PUS_REQUEST_FORMAT_CASE,
    PUS_REQUEST_FORMAT_JUMP, ///< length: octets of the program to skip.
    PUS_REQUEST_FORMAT_FAIL,
    PUS_REQUEST_FORMAT_ID,
    PUS_REQUEST_FORMAT_LAYOUT,
    PUS_REQUEST_FORMAT_VALUE,
    PUS_REQUEST_FORMAT_SIZED,
    PUS_REQUEST_FORMAT_PACKET,
    PUS_REQUEST_FORMAT_REST
};

#define PUS_REQUEST_FORMAT_DEPTH 4U ///< Largest number of nested counts.

/// Check application data. False with a failed reader: octets are missing. False otherwise: the reader is at
/// a wrong count or selector, at a value whose layout is not scalar, or at an embedded request whose length
/// is wrong. The caller checks whether octets are left over.
bool pus_request_format_check(const uint8_t* program, octet_reader_t* reader);

#endif // PUS_CORE_REQUEST_FORMAT_H
