// SPDX-License-Identifier: Apache-2.0
/// The one status type of the flight software.
///
/// Every function that can fail returns status_t and lists in its header each value that it can return.
/// Results are written through pointers `out_...`, so that a return value has only one meaning. A coding
/// error (null argument, call out of order) is not a status: it fails FSW_ASSERT.
#ifndef BASE_STATUS_H
#define BASE_STATUS_H

#if defined(__GNUC__)
#define MUST_USE __attribute__((warn_unused_result))
#else
#define MUST_USE
#endif

typedef enum {
    STATUS_OK = 0,
    STATUS_EMPTY,        ///< The queue or receive buffer is empty.
    STATUS_FULL,         ///< No room or no credit now; try again later.
    STATUS_EXHAUSTED,    ///< A table, a pool or a resource of the system is used up.
    STATUS_NOT_FOUND,    ///< Unknown name, id, address or file.
    STATUS_EXISTS,       ///< Name or id is already in use.
    STATUS_INVALID,      ///< Malformed or inconsistent input.
    STATUS_OUT_OF_RANGE, ///< Well-formed value outside its bounds.
    STATUS_TOO_LARGE,    ///< Does not fit the caller's buffer or the format's limit.
    STATUS_TRUNCATED,    ///< The input ends too early.
    STATUS_CHECKSUM,     ///< The checksum of the input is wrong.
    STATUS_READ_ONLY,    ///< Value may not be set.
    STATUS_FORBIDDEN,    ///< Not permitted in the present state or mode.
    STATUS_BUSY,         ///< In progress; call again.
    STATUS_TIMEOUT,      ///< The time allowed has passed.
    STATUS_CLOSED,       ///< The peer or the object does not exist any more.
    STATUS_STALE,        ///< Data is older than allowed.
    STATUS_NOT_OURS,     ///< Handle or pointer does not belong to this object.
    STATUS_UNSUPPORTED,  ///< This port or build does not have the function.
    STATUS_DENIED,       ///< The operating system refused for lack of privilege.
    STATUS_IO,           ///< Input/output error of the operating system or device.
    STATUS_COUNT         ///< Number of values; never returned.
} status_t;

/// Returns the text of a status in lower case ("ok", "not found", ...); "unknown status" outside the range.
/// Never null.
const char* status_text(status_t status);

#endif // BASE_STATUS_H
