// SPDX-License-Identifier: Apache-2.0
#include "base/status.h"

const char* status_text(const status_t status)
{
    static const char* const texts[STATUS_COUNT] = {
        [STATUS_OK]           = "ok",
        [STATUS_EMPTY]        = "empty",
        [STATUS_FULL]         = "full",
        [STATUS_EXHAUSTED]    = "exhausted",
        [STATUS_NOT_FOUND]    = "not found",
        [STATUS_EXISTS]       = "exists already",
        [STATUS_INVALID]      = "invalid",
        [STATUS_OUT_OF_RANGE] = "out of range",
        [STATUS_TOO_LARGE]    = "too large",
        [STATUS_TRUNCATED]    = "truncated",
        [STATUS_CHECKSUM]     = "checksum wrong",
        [STATUS_READ_ONLY]    = "read only",
        [STATUS_FORBIDDEN]    = "forbidden",
        [STATUS_BUSY]         = "busy",
        [STATUS_TIMEOUT]      = "time-out",
        [STATUS_CLOSED]       = "closed",
        [STATUS_STALE]        = "stale",
        [STATUS_NOT_OURS]     = "not ours",
        [STATUS_UNSUPPORTED]  = "unsupported",
        [STATUS_DENIED]       = "permission denied",
        [STATUS_IO]           = "input/output error",
    };
    const unsigned index = (unsigned)status;
    return (index < (unsigned)STATUS_COUNT) ? texts[index] : "unknown status";
}
