// SPDX-License-Identifier: Apache-2.0
/// Sequence counts and message type counters of an application, as plain numbers: a restarted process
/// continues with those of its predecessor, so that no number is used twice.
///
/// Context    The loop of the process and the requester.
/// Time       O(counters).
#ifndef PUS_CORE_COUNTS_H
#define PUS_CORE_COUNTS_H

#include "pus/core/app_process.h"
#include "pus/core/requester.h"

typedef struct {
    uint8_t service; ///< 0: free; the entries behind it are free as well.
    uint8_t subtype;
    uint16_t destination;
    uint16_t count;
} pus_message_count_t;

typedef struct {
    uint16_t apid; ///< 0: free; the entries behind it are free as well.
    uint16_t sequence;
} pus_request_count_t;

typedef struct {
    uint16_t sequence; ///< Sequence of the next report.
    pus_message_count_t messages[PUS_MESSAGE_COUNTERS];
    pus_request_count_t requests[PUS_ADDRESSEES];
} pus_counts_t;

void pus_counts(const pus_app_process_t* process, const pus_requester_t* requester, pus_counts_t* out_counts);
/// True if these can be counts.
bool pus_counts_are_sound(const pus_counts_t* counts);
/// Continue with consistent counts.
void pus_counts_resume(pus_app_process_t* process, pus_requester_t* requester, const pus_counts_t* counts);

#endif // PUS_CORE_COUNTS_H
