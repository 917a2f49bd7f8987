// SPDX-License-Identifier: Apache-2.0
// Serial lines are not files on this system.
#include "osal/include/osal/serial.h"

#include "base/assertion.h"

#include <stddef.h>

status_t osal_serial_open(osal_device_t* const line, const char* const path, const uint32_t baud)
{
    FSW_ASSERT((line != NULL) && (path != NULL));
    (void)baud;
    *line = (osal_device_t)OSAL_DEVICE_CLOSED;
    return STATUS_UNSUPPORTED;
}
