// SPDX-License-Identifier: Apache-2.0
/// ST[01] request verification: reports about the stages of one request, and their decoding.
///
/// Reports of success are sent only if the acknowledgement flags of the request ask for that stage; reports
/// of failure are always sent. All reports go to the source of the request. If the port of the process
/// refuses a report, the process keeps it while it has room, and counts those that are lost.
#ifndef PUS_ST01_ST01_VERIFICATION_H
#define PUS_ST01_ST01_VERIFICATION_H

#include "pus/core/packet.h"
#include "pus/core/app_process.h"

/// Acceptance: send TM[1,1] or TM[1,2].
void pus_verify_accepted(pus_app_process_t* process, const pus_token_t* token, uint64_t now_ns);
void pus_verify_rejected(pus_app_process_t* process, const pus_token_t* token, const pus_failure_t* failure,
                         uint64_t now_ns);
/// Start of execution: send TM[1,3] or TM[1,4].
void pus_verify_started(pus_app_process_t* process, const pus_token_t* token, uint64_t now_ns);
void pus_verify_start_failed(pus_app_process_t* process, const pus_token_t* token,
                             const pus_failure_t* failure, uint64_t now_ns);
/// Progress: send TM[1,5] or TM[1,6]. After a failed step the caller must later end the request with TM[1,8].
void pus_verify_progress(pus_app_process_t* process, const pus_token_t* token, uint16_t step,
                         uint64_t now_ns);
void pus_verify_progress_failed(pus_app_process_t* process, const pus_token_t* token, uint16_t step,
                                const pus_failure_t* failure, uint64_t now_ns);
/// Completion: send TM[1,7] or TM[1,8].
void pus_verify_completed(pus_app_process_t* process, const pus_token_t* token, uint64_t now_ns);
void pus_verify_failed(pus_app_process_t* process, const pus_token_t* token, const pus_failure_t* failure,
                       uint64_t now_ns);
/// Completion: send TM[1,7] if the code of `failure` is PUS_FAILURE_NONE, else TM[1,8].
void pus_verify_ended(pus_app_process_t* process, const pus_token_t* token, pus_failure_t failure,
                      uint64_t now_ns);
/// Routing: send TM[1,10]. Only a router does this.
void pus_verify_unrouted(pus_app_process_t* process, const pus_token_t* token, const pus_failure_t* failure,
                         uint64_t now_ns);

/// A decoded verification report.
typedef struct {
    uint8_t subtype; ///< 1..8, 10.
    uint32_t request_id;
    uint16_t step;         ///< Number of the step in subtypes 5 and 6; else 0.
    pus_failure_t failure; ///< Failure in subtypes 2, 4, 6, 8 and 10; else its code is PUS_FAILURE_NONE.
} pus_verification_t;

/// Decode a verification report. STATUS_OK, STATUS_NOT_FOUND (not a report of ST[01]), STATUS_INVALID (octets
/// missing or left over).
MUST_USE status_t pus_verification_read(const pus_tm_t* tm, pus_verification_t* out_verification);
/// True if the report is the last about its request: completion, or a failure of any stage except progress. A
/// failed step is followed by other steps or by TM[1,8].
bool pus_verification_is_final(const pus_verification_t* verification);

#endif // PUS_ST01_ST01_VERIFICATION_H
