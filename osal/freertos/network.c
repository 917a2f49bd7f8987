// SPDX-License-Identifier: Apache-2.0
// This system has no network stack.
#include "osal/include/osal/network.h"

#include "base/assertion.h"

#include <stddef.h>

status_t osal_network_enter(osal_network_t* const home, const char* const path)
{
    FSW_ASSERT((home != NULL) && (path != NULL));
    home->descriptor = -1;
    return STATUS_UNSUPPORTED;
}

status_t osal_network_leave(osal_network_t* const home)
{
    FSW_ASSERT(home != NULL);
    return STATUS_UNSUPPORTED;
}

status_t osal_network_remove(const char* const path)
{
    FSW_ASSERT(path != NULL);
    return STATUS_UNSUPPORTED;
}
