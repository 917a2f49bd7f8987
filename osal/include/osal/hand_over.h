// SPDX-License-Identifier: Apache-2.0
/// Counted hand-over of a stream or of datagrams in stepped time. The kernel may deliver octets after the
/// call that sent them has returned. Therefore each end announces in shared memory how many octets or
/// datagrams it has sent. The receiver reads until it has taken all announced octets or datagrams; it waits
/// for those that the kernel has not delivered yet.
///
/// The device end creates the memory and sets whether the device is present. The flight end opens the memory
/// and begins each connection with osal_hand_over_begin, so that nothing is due in either direction.
///
/// Names      As in shm.h.
/// Ownership  The caller provides osal_hand_over_t. If it is closed, the operations have no effect and
///            nothing is due, so that a flow without counts is no special case.
/// Context    One task per end; the scheduler of the run grants one end at a time.
/// Time       O(1).
#ifndef OSAL_HAND_OVER_H
#define OSAL_HAND_OVER_H

#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

/// Longest wait for announced octets or datagrams, wall-clock time [ms].
#define OSAL_HAND_OVER_TIMEOUT_MS 2000U

typedef struct { // Private.
    void* shared;
    bool is_device;
} osal_hand_over_t;

#define OSAL_HAND_OVER_CLOSED                                                                                \
    {                                                                                                        \
        NULL, false                                                                                          \
    }

/// Create the memory, as the device end, and set the device present. STATUS_OK and statuses of
/// osal_shm_create.
MUST_USE status_t osal_hand_over_create(osal_hand_over_t* hand_over, const char* name);
/// Open the memory as the flight end. STATUS_OK, STATUS_NOT_FOUND (no memory, or the device is not present)
/// and other statuses of osal_shm_open.
MUST_USE status_t osal_hand_over_open(osal_hand_over_t* hand_over, const char* name);
void osal_hand_over_close(osal_hand_over_t* hand_over);
bool osal_hand_over_is_open(const osal_hand_over_t* hand_over);

/// Flight end: begin a connection; no octet or datagram is due in either direction.
void osal_hand_over_begin(osal_hand_over_t* hand_over);
/// Device end: true if the flight end has begun a connection and not closed it.
bool osal_hand_over_is_connected(const osal_hand_over_t* hand_over);
/// Returns the number of connections begun so far [wraps].
uint32_t osal_hand_over_connection(const osal_hand_over_t* hand_over);
/// Device end: set whether the device is present.
void osal_hand_over_set_present(osal_hand_over_t* hand_over, bool is_present);
/// True if the device is present, or if `hand_over` is closed.
bool osal_hand_over_is_present(const osal_hand_over_t* hand_over);

/// Announce `count` octets or datagrams that this end has sent.
void osal_hand_over_announce(osal_hand_over_t* hand_over, uint32_t count);
/// Returns the number of octets or datagrams announced by the other end and not taken yet.
uint32_t osal_hand_over_due(const osal_hand_over_t* hand_over);
/// Note that this end has received `count` octets or datagrams; of these, at most those that are due count.
void osal_hand_over_take(osal_hand_over_t* hand_over, uint32_t count);
/// Count all octets or datagrams that are due as lost, and do not wait for them any more.
void osal_hand_over_give_up(osal_hand_over_t* hand_over);
/// Returns the number of octets or datagrams lost so far in both directions [wraps]. If it is not 0, the run
/// is not reproducible.
uint32_t osal_hand_over_lost(const osal_hand_over_t* hand_over);

#endif // OSAL_HAND_OVER_H
