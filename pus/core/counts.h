// SPDX-License-Identifier: Apache-2.0
/// Sequence counts and message type counters of an application process, in a form that can be stored. A
/// restarted process continues with the counts of its predecessor, so that no number is used twice.
///
/// Context    The loop of the process and the requester.
/// Time       O(counters).
#ifndef PUS_CORE_COUNTS_H
#define PUS_CORE_COUNTS_H

#include "pus/core/app_process.h"
#include "pus/core/requester.h"

typedef struct {
    uint8_t service; ///< 0: this entry and all after it are free.
    uint8_t subtype;
    uint16_t destination;
    uint16_t count;
} pus_message_count_t;

typedef struct {
    uint16_t apid; ///< 0: this entry and all after it are free.
    uint16_t sequence;
} pus_request_count_t;

/// Counts of a process and of its requester.
typedef struct {
    uint16_t sequence; ///< Sequence count of the next report.
    pus_message_count_t messages[PUS_MESSAGE_COUNTERS];
    pus_request_count_t requests[PUS_ADDRESSEES];
} pus_counts_t;

/// Copy the present counts.
void pus_counts(const pus_app_process_t* process, const pus_requester_t* requester, pus_counts_t* out_counts);
/// True if all numbers are in their ranges, so that pus_counts_resume accepts them.
bool pus_counts_are_sound(const pus_counts_t* counts);
/// Continue with these counts; pus_counts_are_sound is true for them. Call it before the first report and the
/// first request.
void pus_counts_resume(pus_app_process_t* process, pus_requester_t* requester, const pus_counts_t* counts);

#endif // PUS_CORE_COUNTS_H
