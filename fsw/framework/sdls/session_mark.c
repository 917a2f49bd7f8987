// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/sdls/session_mark.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "base/octets.h"

#include <stdbool.h>
#include <string.h>

#define COPIES 2U
#define SESSION_OFFSET 8U
#define CHECK_OFFSET 12U
#define CRC_OFFSET 28U

static const uint8_t heading[SESSION_OFFSET] = {'S', 'D', 'L', 'S', 1U, 0U, 0U, 0U};

/// Read one copy of the mark. STATUS_OK, STATUS_INVALID (damaged, or of another key), STATUS_IO.
static status_t read_copy(const sdls_session_mark_t* const mark, const unsigned copy,
                          uint32_t* const out_session)
{
    uint8_t record[SESSION_MARK_RECORD];
    const status_t status =
        mark->medium.read(mark->medium.context, (uint64_t)copy * SESSION_MARK_APART, record, sizeof record);
    if (status != STATUS_OK) {
        return (status == STATUS_TRUNCATED) ? STATUS_INVALID : STATUS_IO;
    }
    if ((memcmp(record, heading, sizeof heading) != 0) ||
        (memcmp(&record[CHECK_OFFSET], mark->check, sizeof mark->check) != 0) ||
        (octets_u32_at(&record[CRC_OFFSET]) != crc32_iso(record, CRC_OFFSET))) {
        return STATUS_INVALID;
    }
    *out_session = octets_u32_at(&record[SESSION_OFFSET]);
    return STATUS_OK;
}

/// Write one copy of the mark. STATUS_OK (it is on the disk), STATUS_FULL, STATUS_IO.
static status_t write_copy(const sdls_session_mark_t* const mark, const unsigned copy, const uint32_t session)
{
    uint8_t record[SESSION_MARK_RECORD] = {0};
    (void)memcpy(record, heading, sizeof heading);
    octets_put_u32(&record[SESSION_OFFSET], session);
    (void)memcpy(&record[CHECK_OFFSET], mark->check, sizeof mark->check);
    octets_put_u32(&record[CRC_OFFSET], crc32_iso(record, CRC_OFFSET));
    const status_t status =
        mark->medium.write(mark->medium.context, (uint64_t)copy * SESSION_MARK_APART, record, sizeof record);
    return (status == STATUS_OK) ? mark->medium.sync(mark->medium.context) : status;
}

status_t sdls_session_mark_open(sdls_session_mark_t* const mark, const medium_t* const medium,
                                const uint8_t check[SESSION_MARK_CHECK])
{
    FSW_ASSERT((mark != NULL) && (medium != NULL) && (check != NULL));
    uint32_t sessions[COPIES] = {0U, 0U};
    status_t found[COPIES];
    mark->medium = *medium;
    (void)memcpy(mark->check, check, sizeof mark->check);
    for (unsigned copy = 0U; copy < COPIES; copy++) {
        found[copy] = read_copy(mark, copy, &sessions[copy]);
        if (found[copy] == STATUS_IO) {
            return STATUS_IO;
        }
    }
    if ((found[0] != STATUS_OK) && (found[1] != STATUS_OK)) {
        return STATUS_INVALID;
    }
    const bool is_second =
        (found[0] != STATUS_OK) || ((found[1] == STATUS_OK) && (sessions[1] > sessions[0]));
    mark->whole   = is_second ? 1U : 0U;
    mark->session = sessions[mark->whole];
    if ((found[0] == STATUS_OK) && (found[1] == STATUS_OK) && (sessions[0] == sessions[1])) {
        return STATUS_OK;
    }
    // A power cut left different copies, or one copy is damaged: rewrite the older or damaged one.
    return write_copy(mark, 1U - mark->whole, mark->session);
}

status_t sdls_session_mark_advance(sdls_session_mark_t* const mark, const uint32_t session)
{
    FSW_ASSERT((mark != NULL) && (session > mark->session));
    status_t status = write_copy(mark, 1U - mark->whole, session);
    if (status == STATUS_OK) {
        mark->whole = 1U - mark->whole;
        status      = write_copy(mark, 1U - mark->whole, session);
    }
    if (status == STATUS_OK) {
        mark->session = session;
    }
    return status;
}
