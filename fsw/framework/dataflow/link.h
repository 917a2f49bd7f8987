// SPDX-License-Identifier: Apache-2.0
/// Link of an end node to its system object (socket, queue, memory, device): opened when an attempt is due,
/// counted in a quota, lost on an error, opened again after a delay. A flow has one and supplies `open` and
/// `close`.
///
/// Ownership  The caller places flow_link_t in its flow; both must not be moved.
/// Context    One task; the caller supplies the time.
/// Time       O(1), and that of `open` and `close`.
/// Errors     Each function lists its statuses.
#ifndef FSW_FRAMEWORK_DATAFLOW_LINK_H
#define FSW_FRAMEWORK_DATAFLOW_LINK_H

#include "base/quota.h"
#include "base/status.h"
#include "fsw/framework/dataflow/reconnect.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    /// STATUS_OK, or the reason of the failure. An attempt that takes several steps sets `is_pending` of its
    /// link and returns STATUS_BUSY; it is called again in each step until it returns another status.
    status_t (*open)(void* flow);
    void (*close)(void* flow); ///< Called also after a failed `open`.
} flow_link_actions_t;

typedef struct { // Private; read-only for the flow: is_open, is_pending (see open), failure, reconnect.
    const flow_link_actions_t* actions;
    void* flow;
    quota_t* quota;
    bool is_open;
    bool is_pending;
    uint64_t now_ns;
    status_t failure; ///< Why the last attempt failed, or the last object was left; STATUS_OK: nothing yet.
    flow_reconnect_t reconnect;
} flow_link_t;

/// Closed, an attempt is due. Delays as flow_reconnect_init; `quota` may be null.
void flow_link_init(flow_link_t* link, const flow_link_actions_t* actions, void* flow, quota_t* quota,
                    uint64_t retry_first_ns, uint64_t retry_longest_ns);
/// Open if an attempt is due. STATUS_OK (open), STATUS_BUSY (an attempt is pending), STATUS_CLOSED (`failure`
/// says why).
status_t flow_link_step(flow_link_t* link, uint64_t now_ns);
/// The object has failed: close it, and try again later.
void flow_link_lose(flow_link_t* link, status_t why);
/// Close; the next step tries again at once.
void flow_link_close(flow_link_t* link);

#endif // FSW_FRAMEWORK_DATAFLOW_LINK_H
