// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/pending_table.h"

#include "base/assertion.h"

#include <string.h>

void supervisor_pending_init(pending_table_t* const table)
{
    FSW_ASSERT(table != NULL);
    (void)memset(table, 0, sizeof *table);
}

static bool is_of(const pending_table_t* const table, const size_t index, const uint16_t apid,
                  const uint32_t request_id, const uint16_t source)
{
    const pus_token_t* const token = &table->entries[index].token;
    return (table->entries[index].apid == apid) && (token->request_id == request_id) &&
           (token->source == source);
}

/// Returns the entry for a new request: that of a refused request with the same sequence count (so that no
/// report is attributed to the old request), otherwise a free one, otherwise that of any refused request;
/// PENDING_MAX if there is none.
static size_t slot_for(const pending_table_t* const table, const uint16_t apid,
                       const pus_token_t* const token)
{
    size_t free    = PENDING_MAX;
    size_t refused = PENDING_MAX;
    for (size_t next = PENDING_MAX; next > 0U; next--) {
        const size_t i = next - 1U;
        if (table->entries[i].apid == 0U) {
            free = i;
        } else if (table->entries[i].stage == PENDING_REFUSED) {
            refused = i;
            if (is_of(table, i, apid, token->request_id, token->source)) {
                return i;
            }
        } else {
            // The request of this entry is not finished.
        }
    }
    return (free < PENDING_MAX) ? free : refused;
}

status_t supervisor_pending_add(pending_table_t* const table, const uint16_t apid,
                                const pus_token_t* const token, const uint64_t now_ns)
{
    FSW_ASSERT((table != NULL) && (apid != 0U) && (token != NULL));
    if ((token->ack & PUS_ACK_ALL) == 0U) {
        return STATUS_OK;
    }
    const size_t i = slot_for(table, apid, token);
    if (i == PENDING_MAX) {
        table->refused++;
        return STATUS_EXHAUSTED;
    }
    if (table->entries[i].apid == 0U) {
        table->count++;
    }
    table->entries[i] = (pending_request_t){
        .since_ns = now_ns,
        .token    = *token,
        .stage    = ((token->ack & PUS_ACK_ACCEPTANCE) == 0U) ? PENDING_ANSWERED : PENDING_ASKED,
        .apid     = apid};
    return STATUS_OK;
}

/// Returns the subtype of ST[01] with which a successful request with these acknowledgement flags ends.
static uint8_t last_success(const uint8_t ack)
{
    if ((ack & PUS_ACK_COMPLETION) != 0U) {
        return 7U;
    }
    return ((ack & (PUS_ACK_START | PUS_ACK_PROGRESS)) != 0U) ? 3U : 1U;
}

/// Returns the stage after a report that does not end the request.
static pending_stage_t next_stage(const pending_stage_t stage, const uint8_t subtype)
{
    if (stage == PENDING_STARTED) {
        return stage;
    }
    if (subtype == 4U) {
        return PENDING_REFUSED;
    }
    return (subtype == 1U) ? PENDING_ANSWERED : PENDING_STARTED;
}

void supervisor_pending_report(pending_table_t* const table, const uint16_t apid, const uint16_t destination,
                               const pus_verification_t* const verification)
{
    FSW_ASSERT((table != NULL) && (apid != 0U) && (verification != NULL));
    // A refusal of one instruction does not end a request that has several.
    const bool is_part  = (verification->subtype == 4U) && (verification->failure.instruction != 0U);
    const bool is_final = !is_part && pus_verification_is_final(verification);
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        if (!is_of(table, i, apid, verification->request_id, destination)) {
            continue;
        }
        if (is_final || (verification->subtype == last_success(table->entries[i].token.ack))) {
            table->entries[i].apid = 0U;
            table->count--;
            return;
        }
        table->entries[i].stage = next_stage(table->entries[i].stage, verification->subtype);
    }
}

bool supervisor_pending_is_open(const pending_table_t* const table, const uint16_t apid,
                                const uint32_t request_id)
{
    FSW_ASSERT((table != NULL) && (apid != 0U));
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        if (is_of(table, i, apid, request_id, PUS_USER_SUPERVISOR)) {
            return true;
        }
    }
    return false;
}

static void take_out(pending_table_t* const table, const size_t index, pus_token_t* const out_token)
{
    *out_token                 = table->entries[index].token;
    table->entries[index].apid = 0U;
    table->count--;
}

bool supervisor_pending_take(pending_table_t* const table, const uint16_t apid, pus_token_t* const out_token)
{
    FSW_ASSERT((table != NULL) && (apid != 0U) && (out_token != NULL));
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        if (table->entries[i].apid == apid) {
            take_out(table, i, out_token);
            // The refusals of a refused request were reported, so there is nothing to end.
            if (table->entries[i].stage != PENDING_REFUSED) {
                return true;
            }
        }
    }
    return false;
}

bool supervisor_pending_take_unanswered(pending_table_t* const table, const uint64_t since_ns,
                                        pus_token_t* const out_token)
{
    FSW_ASSERT((table != NULL) && (out_token != NULL));
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        if ((table->entries[i].apid != 0U) && (table->entries[i].stage == PENDING_ASKED) &&
            (table->entries[i].since_ns < since_ns)) {
            take_out(table, i, out_token);
            return true;
        }
    }
    return false;
}
