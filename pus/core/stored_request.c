// SPDX-License-Identifier: Apache-2.0
#include "pus/core/stored_request.h"

status_t pus_stored_request_decode(const uint8_t* const octets, const size_t size, pus_tc_t* const out_tc,
                                   pus_failure_t* const out_failure)
{
    status_t status = pus_tc_decode(octets, size, out_tc, out_failure);
    if ((status == STATUS_OK) && ((out_tc->source & PUS_USER_ONBOARD) != 0U)) {
        *out_failure = pus_failure(PUS_FAILURE_SOURCE, out_tc->source);
        status       = STATUS_FORBIDDEN;
    }
    return status;
}
