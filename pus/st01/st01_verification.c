// SPDX-License-Identifier: Apache-2.0
#include "pus/st01/st01_verification.h"

#include "base/assertion.h"

enum {
    ACCEPTED        = 1,
    REJECTED        = 2,
    STARTED         = 3,
    START_FAILED    = 4,
    PROGRESS        = 5,
    PROGRESS_FAILED = 6,
    COMPLETED       = 7,
    FAILED          = 8,
    UNROUTED        = 10
};

/// Send or keep one report. `step` and `failure` are null if the subtype has no such field.
static void report(pus_app_process_t* const process, const pus_token_t* const token, const uint8_t subtype,
                   const uint16_t* const step, const pus_failure_t* const failure, const uint64_t now_ns)
{
    FSW_ASSERT((process != NULL) && (token != NULL));
    octet_writer_t writer = pus_tm_begin(process, PUS_SERVICE_VERIFICATION, subtype, token->source, now_ns);
    octet_write_u32(&writer, token->request_id);
    if (step != NULL) {
        octet_write_u16(&writer, *step);
    }
    if (failure != NULL) {
        pus_failure_write(&writer, failure);
    }
    (void)pus_tm_post(process, &writer); // The process counts lost reports.
}

/// Send a report of success if the request asks for it; it contains only the request id.
static void report_if_asked(pus_app_process_t* const process, const pus_token_t* const token,
                            const uint8_t ack, const uint8_t subtype, const uint64_t now_ns)
{
    if ((token->ack & ack) != 0U) {
        report(process, token, subtype, NULL, NULL, now_ns);
    }
}

void pus_verify_accepted(pus_app_process_t* const process, const pus_token_t* const token,
                         const uint64_t now_ns)
{
    report_if_asked(process, token, PUS_ACK_ACCEPTANCE, ACCEPTED, now_ns);
}

void pus_verify_rejected(pus_app_process_t* const process, const pus_token_t* const token,
                         const pus_failure_t* const failure, const uint64_t now_ns)
{
    report(process, token, REJECTED, NULL, failure, now_ns);
}

void pus_verify_started(pus_app_process_t* const process, const pus_token_t* const token,
                        const uint64_t now_ns)
{
    report_if_asked(process, token, PUS_ACK_START, STARTED, now_ns);
}

void pus_verify_start_failed(pus_app_process_t* const process, const pus_token_t* const token,
                             const pus_failure_t* const failure, const uint64_t now_ns)
{
    report(process, token, START_FAILED, NULL, failure, now_ns);
}

void pus_verify_progress(pus_app_process_t* const process, const pus_token_t* const token,
                         const uint16_t step, const uint64_t now_ns)
{
    if ((token->ack & PUS_ACK_PROGRESS) != 0U) {
        report(process, token, PROGRESS, &step, NULL, now_ns);
    }
}

void pus_verify_progress_failed(pus_app_process_t* const process, const pus_token_t* const token,
                                const uint16_t step, const pus_failure_t* const failure,
                                const uint64_t now_ns)
{
    report(process, token, PROGRESS_FAILED, &step, failure, now_ns);
}

void pus_verify_completed(pus_app_process_t* const process, const pus_token_t* const token,
                          const uint64_t now_ns)
{
    report_if_asked(process, token, PUS_ACK_COMPLETION, COMPLETED, now_ns);
}

void pus_verify_failed(pus_app_process_t* const process, const pus_token_t* const token,
                       const pus_failure_t* const failure, const uint64_t now_ns)
{
    report(process, token, FAILED, NULL, failure, now_ns);
}

void pus_verify_ended(pus_app_process_t* const process, const pus_token_t* const token,
                      const pus_failure_t failure, const uint64_t now_ns)
{
    if (failure.code == PUS_FAILURE_NONE) {
        pus_verify_completed(process, token, now_ns);
    } else {
        pus_verify_failed(process, token, &failure, now_ns);
    }
}

void pus_verify_unrouted(pus_app_process_t* const process, const pus_token_t* const token,
                         const pus_failure_t* const failure, const uint64_t now_ns)
{
    report(process, token, UNROUTED, NULL, failure, now_ns);
}

static bool has_failure(const uint8_t subtype)
{
    return (subtype % 2U) == 0U;
}

status_t pus_verification_read(const pus_tm_t* const tm, pus_verification_t* const out_verification)
{
    FSW_ASSERT((tm != NULL) && (out_verification != NULL));
    *out_verification   = (pus_verification_t){.subtype = tm->subtype};
    const bool is_known = ((tm->subtype >= ACCEPTED) && (tm->subtype <= FAILED)) || (tm->subtype == UNROUTED);
    if ((tm->service != PUS_SERVICE_VERIFICATION) || !is_known) {
        return STATUS_NOT_FOUND;
    }
    octet_reader_t reader        = octet_reader(tm->data, tm->size);
    out_verification->request_id = octet_read_u32(&reader);
    if ((tm->subtype == PROGRESS) || (tm->subtype == PROGRESS_FAILED)) {
        out_verification->step = octet_read_u16(&reader);
    }
    if (has_failure(tm->subtype)) {
        out_verification->failure = pus_failure_read(&reader);
    }
    return octet_reader_is_done(&reader) ? STATUS_OK : STATUS_INVALID;
}

bool pus_verification_is_final(const pus_verification_t* const verification)
{
    FSW_ASSERT(verification != NULL);
    const bool is_failed = has_failure(verification->subtype) && (verification->subtype != PROGRESS_FAILED);
    return is_failed || (verification->subtype == COMPLETED);
}
