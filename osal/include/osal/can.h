// SPDX-License-Identifier: Apache-2.0
/// A CAN controller for classic frames, FD frames and error frames. A bus has two ends. Its address is one of
///
///     "shm:NAME"            rings in shared memory, without the kernel
///     "can:INTERFACE"       SocketCAN
///     "can:INTERFACE@NAME"  SocketCAN with a counted hand-over for stepped time: each end announces its
///                           frames in the shared memory NAME; the other end waits for exactly these
///
/// The node end is the flight software's controller; the wire end is for the simulator's bus model, which
/// arbitrates and delivers. A controller transmits in the order of sending and does not receive its own
/// frames. Identifiers, flags and error data are those of Linux SocketCAN (linux/can.h, linux/can/error.h).
///
/// Ownership  The caller provides osal_can_t; it must not be moved while open.
/// Context    One task per end. Only the counted hand-over waits, OSAL_CAN_TIMEOUT_MS at most.
/// Time       O(1).
/// Errors     Each function lists every status it returns; a null argument is a coding error (FSW_ASSERT).
#ifndef OSAL_CAN_H
#define OSAL_CAN_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_CAN_EXTENDED 0x80000000U ///< 29-bit identifier.
#define OSAL_CAN_REMOTE 0x40000000U   ///< Remote request (classic only).
#define OSAL_CAN_ERROR 0x20000000U    ///< Error frame; the low bits are the error classes.
#define OSAL_CAN_ID_MASK 0x1FFFFFFFU

/// Set by the controller's driver: a frame was not sent in time.
#define OSAL_CAN_ERROR_TX_TIMEOUT 0x001U
#define OSAL_CAN_ERROR_LOST_ARBITRATION 0x002U ///< data[0]: bit at which arbitration was lost, 0 if unknown.
/// data[1]: 0x01/0x02 overflow rx/tx, 0x04/0x08 warning, 0x10/0x20 passive, 0x40 active again.
#define OSAL_CAN_ERROR_CONTROLLER 0x004U
/// data[2]: type of the violation, data[3]: its position in the frame.
#define OSAL_CAN_ERROR_PROTOCOL 0x008U
#define OSAL_CAN_ERROR_TRANSCEIVER 0x010U ///< data[4]: the bus line concerned.
#define OSAL_CAN_ERROR_NO_ACK 0x020U
#define OSAL_CAN_ERROR_BUS_OFF 0x040U
#define OSAL_CAN_ERROR_BUS 0x080U
#define OSAL_CAN_ERROR_RESTARTED 0x100U
/// The transmit and receive error counters in data[6] and data[7] are valid; also in frames of other classes.
#define OSAL_CAN_ERROR_COUNTERS 0x200U

#define OSAL_CAN_FLAG_BRS 0x01U ///< Bit rate switch.
#define OSAL_CAN_FLAG_ESI 0x02U ///< Error state indicator: the sender was error passive.
#define OSAL_CAN_FLAG_FD 0x04U  ///< CAN FD frame.

#define OSAL_CAN_DATA_MAX 64U
#define OSAL_CAN_RING_FRAMES 256U ///< Capacity of each direction of a stepped bus [frames].
#define OSAL_CAN_FILTERS_MAX 16U
#define OSAL_CAN_TIMEOUT_MS 2000U ///< Longest wait for an announced frame, wall-clock time [ms].

typedef struct {
    /// Time of a received frame [ns]. "shm:": end of frame, set by the wire end; SocketCAN: monotonic time at
    /// which the kernel received the frame.
    uint64_t time_ns;
    uint32_t id;    ///< Identifier and OSAL_CAN_EXTENDED, _REMOTE, _ERROR.
    uint8_t length; ///< Data octets, 0..8 classic, 0..64 FD.
    uint8_t flags;  ///< OSAL_CAN_FLAG_*.
    uint8_t reserved[2];
    uint8_t data[OSAL_CAN_DATA_MAX];
} osal_can_frame_t;

typedef enum {
    OSAL_CAN_NODE, ///< A controller on the bus.
    OSAL_CAN_WIRE  ///< The bus itself: receives what the node sends, delivers what the node receives.
} osal_can_end_t;

typedef struct { ///< A frame passes if (its id & mask) == (id & mask). Error frames always pass.
    uint32_t id;
    uint32_t mask;
} osal_can_filter_t;

typedef struct { // All fields are private, except the last four, which may be read.
    void* shared;
    int descriptor;
    osal_can_end_t end;
    bool is_filtered;
    uint8_t filter_count;
    uint32_t kernel_overruns;
    osal_can_filter_t filters[OSAL_CAN_FILTERS_MAX];
    bool carries_fd; ///< FD frames may be sent.
    /// Frames lost because the receive queue of the node end was full, as of the last receive.
    uint32_t overruns;
    uint32_t refused;  ///< Sends refused because the queue was full.
    uint32_t filtered; ///< Received and dropped by the filters; those that the kernel drops are not counted.
} osal_can_t;

typedef struct {       // Counts of a counted hand-over, sums of both directions [frames, wraps].
    uint32_t frames;   ///< Frames handed over.
    uint32_t late;     ///< Frames of `frames` for which the receiver had to wait.
    uint32_t lost;     ///< Frames announced but not received within OSAL_CAN_TIMEOUT_MS.
    uint32_t external; ///< Frames received but not announced: another program sends on the interface.
    uint32_t cuts;     ///< Calls that failed because the interface of their end was down or removed.
} osal_can_hand_over_t;

/// Create the shared memory of a "shm:" or counted bus. Exactly one process calls this, before either end
/// opens. For a counted bus the address names the interface of the wire end. Returns STATUS_OK,
/// STATUS_EXISTS, STATUS_INVALID (malformed address, or one without shared memory), STATUS_NOT_FOUND
/// (interface), STATUS_NOT_OURS (the interface is not for CAN), STATUS_UNSUPPORTED (no SocketCAN here),
/// STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_can_create(const char* address);
/// Remove the shared memory of a bus. Open ends stay usable. Returns STATUS_OK, STATUS_NOT_FOUND (no such
/// memory, or it cannot be removed).
status_t osal_can_destroy(const char* address);
/// Read the counts of a counted bus. Returns STATUS_OK, STATUS_NOT_FOUND (no such counted bus).
MUST_USE status_t osal_can_hand_over(const char* address, osal_can_hand_over_t* out_counts);

/// Add `frames` to the count of external frames, for frames that came from outside of the run and reached the
/// bus by another way. No effect on a carrier that does not count.
void osal_can_add_external(osal_can_t* can, uint32_t frames);

/// Open one end. The receive queue of a node end is empty after opening. Returns STATUS_OK, STATUS_NOT_FOUND
/// (no such bus), STATUS_INVALID (address, or an interface name of more than 15 characters), STATUS_CLOSED
/// (the interface is down), STATUS_UNSUPPORTED (no SocketCAN here, or no CAN interface), STATUS_DENIED,
/// STATUS_IO.
MUST_USE status_t osal_can_open(osal_can_t* can, const char* address, osal_can_end_t end);
void osal_can_close(osal_can_t* can);
/// Receive only frames that pass one of the filters; without filters: only error frames. After opening all
/// frames pass. Returns STATUS_OK, STATUS_INVALID (more than OSAL_CAN_FILTERS_MAX), STATUS_CLOSED, STATUS_IO.
MUST_USE status_t osal_can_filter(osal_can_t* can, const osal_can_filter_t* filters, size_t count);

/// Queue a frame. Returns STATUS_OK, STATUS_FULL (counted in `refused`), STATUS_INVALID (a length that no CAN
/// frame has, or an FD frame on an interface that does not carry FD), STATUS_UNSUPPORTED (an error frame on a
/// counted bus whose wire end is a controller), STATUS_CLOSED (not open, or the interface is down or gone).
MUST_USE status_t osal_can_send(osal_can_t* can, const osal_can_frame_t* frame);
/// Take the oldest received frame that passes the filters. Returns STATUS_OK, STATUS_EMPTY (also: this call
/// has dropped OSAL_CAN_RING_FRAMES frames; more may follow), STATUS_CLOSED (not open, or the interface is
/// down or removed: close; when it exists again, open again). *out_frame is valid only with STATUS_OK.
MUST_USE status_t osal_can_receive(osal_can_t* can, osal_can_frame_t* out_frame);

#endif // OSAL_CAN_H
