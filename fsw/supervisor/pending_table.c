// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/pending_table.h"

#include "fsw/framework/base/assertion.h"

#include <string.h>

#define PENDING_SUPERVISOR (PUS_USER_ONBOARD | 1U) // Source of its requests.

void pending_init(pending_table_t* const table)
{
    FSW_ASSERT(table != NULL);
    (void)memset(table, 0, sizeof *table);
}

status_t pending_add(pending_table_t* const table, const uint16_t apid, const pus_token_t* const token,
                     const uint64_t now_ns)
{
    FSW_ASSERT((table != NULL) && (token != NULL));
    if ((token->ack & PUS_ACK_ALL) == 0U) {
        return STATUS_OK;
    }
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        if (!table->entries[i].is_used) {
            table->entries[i].is_used     = true;
            table->entries[i].is_answered = (token->ack & PUS_ACK_ACCEPTANCE) == 0U;
            table->entries[i].apid        = apid;
            table->entries[i].since_ns    = now_ns;
            table->entries[i].token       = *token;
            table->count++;
            return STATUS_OK;
        }
    }
    table->refused++;
    return STATUS_EXHAUSTED;
}

/// The last report that a request with these flags gets when all goes well.
static uint8_t last_success(const uint8_t ack)
{
    if ((ack & PUS_ACK_COMPLETION) != 0U) {
        return 7U;
    }
    return ((ack & (PUS_ACK_START | PUS_ACK_PROGRESS)) != 0U) ? 3U : 1U;
}

void pending_report(pending_table_t* const table, const uint16_t apid, const uint16_t destination,
                    const pus_verification_t* const verification)
{
    FSW_ASSERT((table != NULL) && (verification != NULL));
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        const pus_token_t* const token = &table->entries[i].token;
        const bool is_it               = table->entries[i].is_used && (table->entries[i].apid == apid) &&
                           (token->request_id == verification->request_id) && (token->source == destination);
        table->entries[i].is_answered |= is_it;
        const bool is_part = (verification->subtype == 4U) && (verification->failure.instruction != 0U);
        if (is_it && !is_part &&
            (pus_verification_is_final(verification) ||
             (verification->subtype == last_success(token->ack)))) {
            table->entries[i].is_used = false;
            table->count--;
            return;
        }
    }
}

bool pending_is_open(const pending_table_t* const table, const uint16_t apid, const uint32_t request_id)
{
    FSW_ASSERT(table != NULL);
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        const pus_token_t* const token = &table->entries[i].token;
        if (table->entries[i].is_used && (table->entries[i].apid == apid) &&
            (token->request_id == request_id) && (token->source == PENDING_SUPERVISOR)) {
            return true;
        }
    }
    return false;
}

static void take_out(pending_table_t* const table, const size_t index, pus_token_t* const out_token)
{
    *out_token                    = table->entries[index].token;
    table->entries[index].is_used = false;
    table->count--;
}

bool pending_take(pending_table_t* const table, const uint16_t apid, pus_token_t* const out_token)
{
    FSW_ASSERT((table != NULL) && (out_token != NULL));
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        if (table->entries[i].is_used && (table->entries[i].apid == apid)) {
            take_out(table, i, out_token);
            return true;
        }
    }
    return false;
}

bool pending_take_unanswered(pending_table_t* const table, const uint64_t since_ns,
                             pus_token_t* const out_token)
{
    FSW_ASSERT((table != NULL) && (out_token != NULL));
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        if (table->entries[i].is_used && !table->entries[i].is_answered &&
            (table->entries[i].since_ns < since_ns)) {
            take_out(table, i, out_token);
            return true;
        }
    }
    return false;
}
