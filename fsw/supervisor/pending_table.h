// SPDX-License-Identifier: Apache-2.0
/// Requests that were sent to an addressee and whose verification is not complete. If the addressee dies, or
/// does not accept a request that requires an acknowledgement, the supervisor ends the request with TM[1,8],
/// so that no request stays open. If all instructions of a request are refused, there is one TM[1,4] for
/// each, and no further report. Therefore, while only refused instructions of a request are known, the
/// request is not reported as lost, and its entry can be used again.
///
/// Ownership  The caller provides the table.
/// Context    One loop.
/// Time       O(PENDING_MAX).
#ifndef FSW_SUPERVISOR_PENDING_TABLE_H
#define FSW_SUPERVISOR_PENDING_TABLE_H

#include "base/status.h"
#include "pus/core/packet.h"
#include "pus/st01/st01_verification.h"

#include <stdbool.h>
#include <stdint.h>

#define PENDING_MAX 128U

typedef enum {
    PENDING_ASKED,    ///< No report has arrived yet, and a report of acceptance is required.
    PENDING_ANSWERED, ///< A report has arrived, or no report of acceptance is required.
    PENDING_REFUSED,  ///< Instructions were refused, and none has started.
    PENDING_STARTED,  ///< A report of start, or a later one, has arrived.
} pending_stage_t;

typedef struct { // Private.
    uint64_t since_ns;
    pus_token_t token;
    pending_stage_t stage;
    uint16_t apid; // 0: the entry is free.
} pending_request_t;

typedef struct { // Private, except `count` and `refused`.
    pending_request_t entries[PENDING_MAX];
    uint16_t count;
    uint32_t refused; ///< Requests that were not tracked because the table was full.
} pending_table_t;

void supervisor_pending_init(pending_table_t* table);
/// Track a request that is sent to `apid` now. A request that requires no report is not tracked. STATUS_OK,
/// STATUS_EXHAUSTED (counted).
status_t supervisor_pending_add(pending_table_t* table, uint16_t apid, const pus_token_t* token,
                                uint64_t now_ns);
/// Process a verification report of `apid` to `destination`; removes the entry if this is the last report of
/// the request.
void supervisor_pending_report(pending_table_t* table, uint16_t apid, uint16_t destination,
                               const pus_verification_t* verification);
/// True if this request of the supervisor to `apid` is in the table.
bool supervisor_pending_is_open(const pending_table_t* table, uint16_t apid, uint32_t request_id);
/// Remove one request to `apid`; on the way to it, those of which only refused instructions are known, which
/// need no end. False if there is none; *out_token may have changed.
bool supervisor_pending_take(pending_table_t* table, uint16_t apid, pus_token_t* out_token);
/// Remove one request that was passed before `since_ns`, requires a report of acceptance, and got no report.
/// False if there is none.
bool supervisor_pending_take_unanswered(pending_table_t* table, uint64_t since_ns, pus_token_t* out_token);

#endif // FSW_SUPERVISOR_PENDING_TABLE_H
