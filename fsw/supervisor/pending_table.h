// SPDX-License-Identifier: Apache-2.0
/// Requests that were passed to an addressee and whose verification is not complete. If the addressee dies,
/// or does not accept a request that requires an acknowledgement, the request ends with TM[1,8], so that none
/// stays open. A request whose instructions were all refused has one TM[1,4] for each and no further end. As
/// long as only refused instructions of a request are known, it is not reported as lost, and its entry can be
/// reused.
///
/// Ownership  The caller places the table.
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
    PENDING_ASKED,    ///< No report yet, and one is due.
    PENDING_ANSWERED, ///< A report has arrived, or none is due before completion.
    PENDING_REFUSED,  ///< Instructions were refused, and none has started.
    PENDING_STARTED,
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
    uint32_t refused; ///< Requests not tracked because the table was full.
} pending_table_t;

void supervisor_pending_init(pending_table_t* table);
/// Track a request that is passed to `apid` now. A request that asks for no report is over at once.
/// STATUS_OK, STATUS_EXHAUSTED (counted).
status_t supervisor_pending_add(pending_table_t* table, uint16_t apid, const pus_token_t* token,
                                uint64_t now_ns);
/// A verification report of `apid` to `destination` has passed; drops the entry if its chain ends here.
void supervisor_pending_report(pending_table_t* table, uint16_t apid, uint16_t destination,
                               const pus_verification_t* verification);
/// True if that request of the supervisor to `apid` is in the table.
bool supervisor_pending_is_open(const pending_table_t* table, uint16_t apid, uint32_t request_id);
/// Remove one request of `apid`. False: none is left.
bool supervisor_pending_take(pending_table_t* table, uint16_t apid, pus_token_t* out_token);
/// Remove one request that was passed before `since_ns`, requires a report of acceptance, and got no report.
/// False: none is left.
bool supervisor_pending_take_unanswered(pending_table_t* table, uint64_t since_ns, pus_token_t* out_token);

#endif // FSW_SUPERVISOR_PENDING_TABLE_H
