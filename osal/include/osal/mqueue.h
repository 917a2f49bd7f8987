// SPDX-License-Identifier: Apache-2.0
/// Message queue of the system: whole messages, in the order of sending, kept until they are received. The
/// creator owns the name; any number of senders may open it.
///
/// A queue whose creator has died remains, with its messages, until its name is removed. A receiver restarts
/// by removing the queue and creating it again; a sender that still has the removed queue open gets
/// STATUS_CLOSED.
///
/// Ownership  The caller provides osal_mqueue_t.
/// Names      '/' and then 1..60 of [A-Za-z0-9._-], but neither "." nor ".." alone.
/// Context    Any task. Never blocks.
/// Time       O(message).
/// Errors     Each function lists its statuses; interrupted calls are repeated inside. A null argument is a
///            coding error (FSW_ASSERT).
#ifndef OSAL_MQUEUE_H
#define OSAL_MQUEUE_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_MQUEUE_DEPTH_ALWAYS 10U    ///< Depth that every system permits [messages].
#define OSAL_MQUEUE_OCTETS_ALWAYS 8192U ///< Size of a message that every system permits [octets].

typedef struct { // Private.
    int descriptor;
    uint32_t message_octets;
    bool is_open;
} osal_mqueue_t;

/// Create a queue of `depth` messages of up to `message_octets` (1 or more each) and open it to send and
/// receive. STATUS_OK, STATUS_EXISTS, STATUS_INVALID (name, or a depth or size of 0), STATUS_EXHAUSTED (more
/// than the system grants), STATUS_DENIED, STATUS_UNSUPPORTED, STATUS_IO.
MUST_USE status_t osal_mqueue_create(osal_mqueue_t* queue, const char* name, uint32_t depth,
                                     uint32_t message_octets);
/// Open a queue to send and receive. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID (name), STATUS_EXHAUSTED,
/// STATUS_DENIED, STATUS_UNSUPPORTED, STATUS_IO.
MUST_USE status_t osal_mqueue_open(osal_mqueue_t* queue, const char* name);
/// Send a message. STATUS_OK, STATUS_FULL, STATUS_TOO_LARGE, STATUS_CLOSED (the name of the queue was
/// removed), STATUS_IO.
MUST_USE status_t osal_mqueue_send(osal_mqueue_t* queue, const uint8_t* octets, size_t size);
/// Receive the oldest message; *out_size may be 0. STATUS_OK, STATUS_EMPTY, STATUS_TOO_LARGE (capacity less
/// than message_octets: nothing is taken), STATUS_IO.
MUST_USE status_t osal_mqueue_receive(osal_mqueue_t* queue, uint8_t* octets, size_t capacity,
                                      size_t* out_size);
/// Returns the size of the largest message [octets].
uint32_t osal_mqueue_message_octets(const osal_mqueue_t* queue);
void osal_mqueue_close(osal_mqueue_t* queue);
/// Remove the name. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_DENIED.
status_t osal_mqueue_remove(const char* name);

#endif // OSAL_MQUEUE_H
