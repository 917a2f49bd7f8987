// SPDX-License-Identifier: Apache-2.0
/// A CAN controller as the operating system offers it: classic and FD frames, error frames, two ends.
///
/// A bus is named by an address, "shm:NAME" (rings in shared memory; needs nothing from the kernel) or
/// "can:INTERFACE" (SocketCAN). The node end is the flight side's controller; the wire end is for the
/// simulator's bus model, which arbitrates and delivers. A controller transmits in the order of sending.
/// Identifiers, flags and error frames are laid out as in Linux SocketCAN (linux/can.h, linux/can/error.h).
///
/// Ownership  The caller places osal_can_t; it must not be moved while open.
/// Context    One task per end. Never blocks. Time O(1).
/// Errors     Each function lists every status it returns; a null argument is a coding error (FSW_ASSERT).
#ifndef OSAL_CAN_H
#define OSAL_CAN_H

#include "fsw/framework/base/status.h"

#include <stdbool.h>
#include <stdint.h>

#define OSAL_CAN_EXTENDED 0x80000000U ///< 29-bit identifier.
#define OSAL_CAN_REMOTE 0x40000000U   ///< Remote request (classic only).
#define OSAL_CAN_ERROR 0x20000000U    ///< Error frame; the low bits are the error class.
#define OSAL_CAN_ID_MASK 0x1FFFFFFFU

#define OSAL_CAN_ERROR_CONTROLLER                                                                            \
    0x004U ///< data[1]: 0x04/0x08 warning, 0x10/0x20 passive, 0x40 active again.
#define OSAL_CAN_ERROR_NO_ACK 0x020U
#define OSAL_CAN_ERROR_BUS_OFF 0x040U
#define OSAL_CAN_ERROR_BUS 0x080U
#define OSAL_CAN_ERROR_RESTARTED                                                                             \
    0x100U ///< data[6], data[7] of error frames: transmit and receive error counters.

#define OSAL_CAN_FLAG_BRS 0x01U ///< Bit rate switch.
#define OSAL_CAN_FLAG_ESI 0x02U ///< Sender was error passive.
#define OSAL_CAN_FLAG_FD 0x04U  ///< CAN FD frame.

#define OSAL_CAN_DATA_MAX 64U
#define OSAL_CAN_RING_FRAMES 256U ///< Frames each ring of a shared-memory bus holds.

typedef struct {
    uint64_t time_ns; ///< Received: end of frame on the bus [ns]: the wire end's stamp; SocketCAN: monotonic.
    uint32_t id;      ///< Identifier and OSAL_CAN_EXTENDED, _REMOTE, _ERROR.
    uint8_t length;   ///< Data octets, 0..8 classic, 0..64 FD.
    uint8_t flags;    ///< OSAL_CAN_FLAG_*.
    uint8_t reserved[2];
    uint8_t data[OSAL_CAN_DATA_MAX];
} osal_can_frame_t;

typedef enum {
    OSAL_CAN_NODE, ///< A controller on the bus.
    OSAL_CAN_WIRE  ///< The bus itself: receives what the node sends, delivers what the node receives.
} osal_can_end_t;

typedef struct { // All fields are private, except the counters: read-only, for housekeeping.
    void* shared;
    int descriptor;
    osal_can_end_t end;
    uint32_t overruns; ///< Frames for the node that found its receive ring full, as of the last receive.
    uint32_t refused;  ///< Sends refused because the queue was full.
} osal_can_t;

/// Make the rings of a shared-memory bus. Exactly one process does it, before either end opens.
/// Returns STATUS_OK, STATUS_EXISTS, STATUS_INVALID (name, or not "shm:"), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_can_create(const char* address);
/// Remove them. Open ends stay usable. Returns STATUS_OK, STATUS_NOT_FOUND.
status_t osal_can_destroy(const char* address);

/// Open one end. A node end begins with nothing received. Returns STATUS_OK, STATUS_NOT_FOUND (no such bus),
/// STATUS_INVALID (address), STATUS_UNSUPPORTED (no SocketCAN here, or the wire end of one), STATUS_DENIED,
/// STATUS_IO.
MUST_USE status_t osal_can_open(osal_can_t* can, const char* address, osal_can_end_t end);
void osal_can_close(osal_can_t* can);

/// Queue a frame. Returns STATUS_OK, STATUS_FULL (counted in `refused`), STATUS_INVALID (a length no such
/// frame has, or FD on an interface without), STATUS_CLOSED (not open, or the interface is down).
MUST_USE status_t osal_can_send(osal_can_t* can, const osal_can_frame_t* frame);
/// Take the oldest received frame. Returns STATUS_OK, STATUS_EMPTY, STATUS_CLOSED.
MUST_USE status_t osal_can_receive(osal_can_t* can, osal_can_frame_t* out_frame);

#endif // OSAL_CAN_H
