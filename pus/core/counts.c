// SPDX-License-Identifier: Apache-2.0
#include "pus/core/counts.h"

#include "base/assertion.h"

#include <string.h>

void pus_counts(const pus_app_process_t* const process, const pus_requester_t* const requester,
                pus_counts_t* const out_counts)
{
    FSW_ASSERT((process != NULL) && (requester != NULL) && (out_counts != NULL));
    (void)memset(out_counts, 0, sizeof *out_counts);
    out_counts->sequence = process->sequence;
    for (size_t i = 0U; (i < PUS_MESSAGE_COUNTERS) && (process->messages[i].service != 0U); i++) {
        const pus_message_counter_t* const counter = &process->messages[i];
        out_counts->messages[i]                    = (pus_message_count_t){.service     = counter->service,
                                                                           .subtype     = counter->subtype,
                                                                           .destination = counter->destination,
                                                                           .count       = counter->count};
    }
    for (size_t i = 0U; i < requester->addressee_count; i++) {
        out_counts->requests[i] = (pus_request_count_t){.apid     = requester->addressees[i].apid,
                                                        .sequence = requester->addressees[i].sequence};
    }
}

bool pus_counts_are_sound(const pus_counts_t* const counts)
{
    FSW_ASSERT(counts != NULL);
    for (size_t i = 0U; i < PUS_ADDRESSEES; i++) {
        if ((counts->requests[i].apid > PUS_APID_MAX) ||
            (counts->requests[i].sequence >= PUS_SEQUENCE_COUNT)) {
            return false;
        }
    }
    return counts->sequence < PUS_SEQUENCE_COUNT;
}

void pus_counts_resume(pus_app_process_t* const process, pus_requester_t* const requester,
                       const pus_counts_t* const counts)
{
    FSW_ASSERT((process != NULL) && (requester != NULL) && (counts != NULL) && pus_counts_are_sound(counts));
    process->sequence = counts->sequence;
    for (size_t i = 0U; (i < PUS_MESSAGE_COUNTERS) && (counts->messages[i].service != 0U); i++) {
        const pus_message_count_t* const count = &counts->messages[i];
        process->messages[i]                   = (pus_message_counter_t){.service     = count->service,
                                                                         .subtype     = count->subtype,
                                                                         .destination = count->destination,
                                                                         .count       = count->count};
    }
    for (size_t i = 0U; (i < PUS_ADDRESSEES) && (counts->requests[i].apid != 0U); i++) {
        requester->addressees[i].apid     = counts->requests[i].apid;
        requester->addressees[i].sequence = counts->requests[i].sequence;
        requester->addressee_count        = (uint16_t)(i + 1U);
    }
}
