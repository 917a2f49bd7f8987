// SPDX-License-Identifier: Apache-2.0
/// Private to the source files of osal/can.h: the interfaces of its carriers.
#ifndef OSAL_COMMON_CAN_PORT_H
#define OSAL_COMMON_CAN_PORT_H

#include "osal/include/osal/can.h"

// The functions return the statuses of the functions of osal/can.h with the same name.
/// can_shm.c: rings in shared memory. Name as in osal/shm.h.
status_t can_shm_create(const char* name);
status_t can_shm_open(osal_can_t* can, const char* name);
void can_shm_close(osal_can_t* can);
status_t can_shm_send(osal_can_t* can, const osal_can_frame_t* frame);
status_t can_shm_receive(osal_can_t* can, osal_can_frame_t* out_frame);

/// can_socket.c: SocketCAN.
status_t can_socket_open(osal_can_t* can, const char* interface);
void can_socket_close(osal_can_t* can);
status_t can_socket_filter(const osal_can_t* can);
status_t can_socket_send(osal_can_t* can, const osal_can_frame_t* frame);
status_t can_socket_receive(osal_can_t* can, osal_can_frame_t* out_frame);
/// Wait until a frame has arrived, at most until_ns (monotonic). False: no frame has arrived.
bool can_socket_wait(const osal_can_t* can, uint64_t until_ns);

/// can_counted.c: SocketCAN with a counted hand-over in the shared memory of that name.
status_t can_counted_create(const char* name, const char* interface);
status_t can_counted_open(osal_can_t* can, const char* name, const char* interface);
void can_counted_close(osal_can_t* can);
status_t can_counted_send(osal_can_t* can, const osal_can_frame_t* frame);
status_t can_counted_receive(osal_can_t* can, osal_can_frame_t* out_frame);
void can_counted_add_external(osal_can_t* can, uint32_t frames);
status_t can_counted_look(const char* name, osal_can_hand_over_t* out_counts);

#endif // OSAL_COMMON_CAN_PORT_H
