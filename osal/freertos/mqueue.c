// SPDX-License-Identifier: Apache-2.0
// One program runs on this processor: message queues between processes do not exist.
#include "osal/include/osal/mqueue.h"

#include "base/assertion.h"

#include <stddef.h>

status_t osal_mqueue_create(osal_mqueue_t* const queue, const char* const name, const uint32_t depth,
                            const uint32_t message_octets)
{
    FSW_ASSERT((queue != NULL) && (name != NULL));
    (void)depth;
    (void)message_octets;
    return STATUS_UNSUPPORTED;
}

status_t osal_mqueue_open(osal_mqueue_t* const queue, const char* const name)
{
    FSW_ASSERT((queue != NULL) && (name != NULL));
    return STATUS_UNSUPPORTED;
}

status_t osal_mqueue_send(osal_mqueue_t* const queue, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((queue != NULL) && (octets != NULL));
    (void)size;
    return STATUS_UNSUPPORTED;
}

status_t osal_mqueue_receive(osal_mqueue_t* const queue, uint8_t* const octets, const size_t capacity,
                             size_t* const out_size)
{
    FSW_ASSERT((queue != NULL) && (octets != NULL) && (out_size != NULL));
    (void)capacity;
    *out_size = 0U;
    return STATUS_UNSUPPORTED;
}

uint32_t osal_mqueue_message_octets(const osal_mqueue_t* const queue)
{
    FSW_ASSERT(queue != NULL);
    return 0U;
}

void osal_mqueue_close(osal_mqueue_t* const queue)
{
    FSW_ASSERT(queue != NULL);
}

status_t osal_mqueue_remove(const char* const name)
{
    FSW_ASSERT(name != NULL);
    return STATUS_UNSUPPORTED;
}
