// SPDX-License-Identifier: Apache-2.0
// Devices are not files on this system: drivers of the processor serve its devices.
#include "osal/include/osal/device.h"

#include "base/assertion.h"

#include <stddef.h>

status_t osal_device_open(osal_device_t* const device, const char* const path,
                          const osal_device_direction_t direction)
{
    FSW_ASSERT((device != NULL) && (path != NULL));
    (void)direction;
    *device = (osal_device_t)OSAL_DEVICE_CLOSED;
    return STATUS_UNSUPPORTED;
}

status_t osal_device_write(osal_device_t* const device, const uint8_t* const octets, const size_t size,
                           size_t* const out_sent)
{
    FSW_ASSERT((device != NULL) && (octets != NULL) && (out_sent != NULL));
    (void)size;
    *out_sent = 0U;
    return STATUS_UNSUPPORTED;
}

status_t osal_device_read(osal_device_t* const device, uint8_t* const octets, const size_t capacity,
                          size_t* const out_size)
{
    FSW_ASSERT((device != NULL) && (octets != NULL) && (out_size != NULL));
    (void)capacity;
    *out_size = 0U;
    return STATUS_UNSUPPORTED;
}

status_t osal_device_wait_readable(osal_device_t* const device, const uint32_t timeout_ms)
{
    FSW_ASSERT(device != NULL);
    (void)timeout_ms;
    return STATUS_UNSUPPORTED;
}

void osal_device_close(osal_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    *device = (osal_device_t)OSAL_DEVICE_CLOSED;
}

status_t osal_device_pipe(osal_device_t* const out_reader, osal_device_t* const out_writer)
{
    FSW_ASSERT((out_reader != NULL) && (out_writer != NULL));
    *out_reader = (osal_device_t)OSAL_DEVICE_CLOSED;
    *out_writer = (osal_device_t)OSAL_DEVICE_CLOSED;
    return STATUS_UNSUPPORTED;
}

int osal_device_descriptor(const osal_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    return device->descriptor;
}
