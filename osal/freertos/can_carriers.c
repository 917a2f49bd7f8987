// SPDX-License-Identifier: Apache-2.0
// SocketCAN does not exist on this system: CAN buses are rings in memory (osal/common/can_shm.c).
#include "osal/common/can_port.h"

#include "base/assertion.h"

#include <stddef.h>

status_t can_socket_open(osal_can_t* const can, const char* const interface)
{
    FSW_ASSERT((can != NULL) && (interface != NULL));
    return STATUS_UNSUPPORTED;
}

void can_socket_close(osal_can_t* const can)
{
    FSW_ASSERT(can != NULL);
}

status_t can_socket_filter(const osal_can_t* const can)
{
    FSW_ASSERT(can != NULL);
    return STATUS_CLOSED;
}

status_t can_socket_send(osal_can_t* const can, const osal_can_frame_t* const frame)
{
    FSW_ASSERT((can != NULL) && (frame != NULL));
    return STATUS_CLOSED;
}

status_t can_socket_receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    FSW_ASSERT((can != NULL) && (out_frame != NULL));
    return STATUS_CLOSED;
}

bool can_socket_wait(const osal_can_t* const can, const uint64_t until_ns)
{
    FSW_ASSERT(can != NULL);
    (void)until_ns;
    return false;
}

status_t can_counted_create(const char* const name, const char* const interface)
{
    FSW_ASSERT((name != NULL) && (interface != NULL));
    return STATUS_UNSUPPORTED;
}

status_t can_counted_open(osal_can_t* const can, const char* const name, const char* const interface)
{
    FSW_ASSERT((can != NULL) && (name != NULL) && (interface != NULL));
    return STATUS_UNSUPPORTED;
}

void can_counted_close(osal_can_t* const can)
{
    FSW_ASSERT(can != NULL);
}

status_t can_counted_send(osal_can_t* const can, const osal_can_frame_t* const frame)
{
    FSW_ASSERT((can != NULL) && (frame != NULL));
    return STATUS_CLOSED;
}

status_t can_counted_receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    FSW_ASSERT((can != NULL) && (out_frame != NULL));
    return STATUS_CLOSED;
}

void can_counted_add_external(osal_can_t* const can, const uint32_t frames)
{
    FSW_ASSERT(can != NULL);
    (void)frames;
}

status_t can_counted_look(const char* const name, osal_can_hand_over_t* const out_counts)
{
    FSW_ASSERT((name != NULL) && (out_counts != NULL));
    *out_counts = (osal_can_hand_over_t){.frames = 0U};
    return STATUS_NOT_FOUND;
}
