// SPDX-License-Identifier: Apache-2.0
/// Link of an end node to its object of the operating system (socket, queue, memory, device). The link
/// opens the object when an attempt is due, counts it in a quota, closes it after an error, and opens it
/// again after a delay. Each flow has a link and supplies the functions `open` and `close`.
///
/// Ownership  The caller provides flow_link_t in its flow; both must not be moved.
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
    /// Open the object. STATUS_OK, or the reason of the failure. An attempt that takes several steps sets
    /// `is_pending` of its link and returns STATUS_BUSY; it is called again in each step until it returns
    /// another status.
    status_t (*open)(void* flow);
    void (*close)(void* flow); ///< Called also after a failed `open`.
} flow_link_actions_t;

typedef struct { // Private. The flow may read is_open, failure and reconnect; its `open` sets is_pending.
    const flow_link_actions_t* actions;
    void* flow;
    quota_t* quota;
    bool is_open;
    bool is_pending;
    /// Time of the present step.
    uint64_t now_ns;
    /// Why the last attempt failed, or why the last object was closed; STATUS_OK if neither has happened.
    status_t failure;
    flow_reconnect_t reconnect;
} flow_link_t;

/// Initialise as closed; an attempt is due. Delays as in flow_reconnect_init; `quota` may be null.
void flow_link_init(flow_link_t* link, const flow_link_actions_t* actions, void* flow, quota_t* quota,
                    uint64_t retry_first_ns, uint64_t retry_longest_ns);
/// Open if an attempt is due. STATUS_OK (open), STATUS_BUSY (an attempt is pending), STATUS_CLOSED (`failure`
/// says why).
status_t flow_link_step(flow_link_t* link, uint64_t now_ns);
/// Close the object, which must be open or pending, because it has failed, and try again after the delay.
void flow_link_lose(flow_link_t* link, status_t why);
/// Close the object; the next step tries again at once.
void flow_link_close(flow_link_t* link);

#endif // FSW_FRAMEWORK_DATAFLOW_LINK_H
