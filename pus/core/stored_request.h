// SPDX-License-Identifier: Apache-2.0
/// Check of a request that a user stores on board, to be released later by ST[11], ST[19], ST[21] or ST[22].
///
/// Only requests of ground users may be stored, because a released request has the rights of its source, and
/// answers to a request of an on-board user belong to that user.
///
/// Context  Any.
#ifndef PUS_CORE_STORED_REQUEST_H
#define PUS_CORE_STORED_REQUEST_H

#include "pus/core/packet.h"

/// Check and decode a request. Statuses and failures of pus_tc_decode; also STATUS_FORBIDDEN with
/// PUS_FAILURE_SOURCE (the source is an on-board user).
MUST_USE status_t pus_stored_request_decode(const uint8_t* octets, size_t size, pus_tc_t* out_tc,
                                            pus_failure_t* out_failure);

#endif // PUS_CORE_STORED_REQUEST_H
