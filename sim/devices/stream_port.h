// SPDX-License-Identifier: Apache-2.0
/// The end of a data flow at a device: it sends and receives the messages of the device, for each type of end
/// node except CAN. Formats and names are those of fsw/framework/dataflow. The implementation is separate, so
/// that an error on one side becomes visible.
///
///     SHM, MQUEUE   queues /RUN.flow.NAME.in (to flight) and .out
///     UDP, TCP      the device's address in this run (OSAL_IPV4_OF_DEVICES) with the port of the channel
///     SERIAL, FILE  a pseudo-terminal; flight opens the link /dev/shm/RUN.flow.PATH to it
///
/// In stepped time octets and datagrams are counted (osal/include/osal/hand_over.h), and the counts show
/// whether the device is plugged in.
///
/// Ownership  stream_port_open allocates, stream_port_close frees and removes the names.
/// Context    One task.
#ifndef SIM_DEVICES_STREAM_PORT_H
#define SIM_DEVICES_STREAM_PORT_H

#include "base/status.h"
#include "sim/devices/stream_frame.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STREAM_PORT_MESSAGE_MAX STREAM_FRAME_MESSAGE_MAX
#define STREAM_PORT_ERROR_MAX 200U

typedef enum {
    STREAM_PORT_SHM,
    STREAM_PORT_MQUEUE,
    STREAM_PORT_UDP,
    STREAM_PORT_TCP,
    STREAM_PORT_SERIAL,
    STREAM_PORT_FILE,
    STREAM_PORT_KINDS
} stream_port_kind_t;

typedef struct {
    stream_port_kind_t kind;
    const char* run;     ///< Identity of the run, "NAME-NUMBER".
    const char* channel; ///< Name, path, or "HOST:PORT".
    stream_framing_t framing;
    bool is_counted;   ///< In stepped time octets and datagrams are counted.
    size_t octets_out; ///< Octets of a message to flight.
    size_t octets_in;  ///< Octets of a message to the device.
} stream_port_config_t;

typedef struct stream_port stream_port_t;

/// Open a port; the device is plugged in. STATUS_OK; STATUS_INVALID (channel), STATUS_EXHAUSTED (memory),
/// statuses of osal_hand_over_create and of the call that opens the end node: *out_port is null and `error`
/// is filled.
MUST_USE status_t stream_port_open(const stream_port_config_t* config, stream_port_t** out_port,
                                   char error[STREAM_PORT_ERROR_MAX]);
void stream_port_plug(stream_port_t* port, bool is_plugged);
bool stream_port_is_plugged(const stream_port_t* port);
/// Accept connections. Must be called once a step, before stream_port_receive.
void stream_port_step(stream_port_t* port);
/// Send a message, framed as the end node requires. If flight has not opened its end, or its queue is full,
/// the message is lost.
void stream_port_send(stream_port_t* port, const uint8_t* message, size_t size);
/// Send octets without framing; on queues they must have the size of a message.
void stream_port_send_raw(stream_port_t* port, const uint8_t* octets, size_t size);
/// Receive the next message into STREAM_PORT_MESSAGE_MAX octets. False: there is none.
bool stream_port_receive(stream_port_t* port, uint8_t* message, size_t* out_size);
/// Octets and datagrams that one end has counted as sent and the other has not received in time [wraps]; if
/// not 0, the run is not reproducible.
uint32_t stream_port_lost(const stream_port_t* port);
/// Null is allowed.
void stream_port_close(stream_port_t* port);

#endif // SIM_DEVICES_STREAM_PORT_H
