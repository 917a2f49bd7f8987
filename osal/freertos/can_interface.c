// SPDX-License-Identifier: Apache-2.0
// This system has no network interfaces for CAN: a bus is a ring in memory ("shm:").
#include "osal/include/osal/can_interface.h"

#include "base/assertion.h"

#include <stddef.h>

status_t osal_can_interface_look(const char* const name, osal_can_interface_t* const out_interface)
{
    FSW_ASSERT((name != NULL) && (out_interface != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_can_interface_create(const char* const name, const bool carries_fd, const char* const label)
{
    FSW_ASSERT((name != NULL) && (label != NULL));
    (void)carries_fd;
    return STATUS_UNSUPPORTED;
}

status_t osal_can_interface_remove(const char* const name)
{
    FSW_ASSERT(name != NULL);
    return STATUS_UNSUPPORTED;
}

status_t osal_can_interface_claim(const char* const name, osal_can_claim_t* const out_claim)
{
    FSW_ASSERT((name != NULL) && (out_claim != NULL));
    out_claim->descriptor = -1;
    return STATUS_UNSUPPORTED;
}

void osal_can_interface_release(osal_can_claim_t* const claim)
{
    FSW_ASSERT(claim != NULL);
    claim->descriptor = -1;
}
