// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/link.h"

#include "base/assertion.h"

#include <stddef.h>

void flow_link_init(flow_link_t* const link, const flow_link_actions_t* const actions, void* const flow,
                    quota_t* const quota, const uint64_t retry_first_ns, const uint64_t retry_longest_ns)
{
    FSW_ASSERT((link != NULL) && (actions != NULL) && (flow != NULL));
    *link = (flow_link_t){.actions = actions, .flow = flow, .quota = quota};
    flow_reconnect_init(&link->reconnect, retry_first_ns, retry_longest_ns);
}

static void release(flow_link_t* const link)
{
    link->actions->close(link->flow);
    quota_give(link->quota);
    link->is_open    = false;
    link->is_pending = false;
}

/// Begin an attempt to open the object, or check the result of the pending attempt.
static void attempt(flow_link_t* const link)
{
    status_t status      = link->is_pending ? STATUS_OK : quota_take(link->quota);
    const bool has_quota = (status == STATUS_OK);
    if (has_quota) {
        status = link->actions->open(link->flow);
    }
    if (status == STATUS_OK) {
        link->is_open    = true;
        link->is_pending = false;
        flow_reconnect_succeeded(&link->reconnect, link->now_ns);
    } else if (!link->is_pending || (status != STATUS_BUSY)) {
        if (has_quota) {
            release(link);
        }
        link->failure = status;
        flow_reconnect_failed(&link->reconnect, link->now_ns);
    } else {
        // The next step checks the result.
    }
}

status_t flow_link_step(flow_link_t* const link, const uint64_t now_ns)
{
    FSW_ASSERT(link != NULL);
    link->now_ns = now_ns;
    if (link->is_pending || (!link->is_open && flow_reconnect_is_due(&link->reconnect, now_ns))) {
        attempt(link);
    }
    if (link->is_pending) {
        return STATUS_BUSY;
    }
    return link->is_open ? STATUS_OK : STATUS_CLOSED;
}

void flow_link_lose(flow_link_t* const link, const status_t why)
{
    FSW_ASSERT(link != NULL);
    release(link);
    link->failure = why;
    flow_reconnect_lost(&link->reconnect, link->now_ns);
}

void flow_link_close(flow_link_t* const link)
{
    FSW_ASSERT(link != NULL);
    if (link->is_open || link->is_pending) {
        flow_link_lose(link, STATUS_CLOSED);
    }
    flow_reconnect_init(&link->reconnect, link->reconnect.first_ns, link->reconnect.longest_ns);
}
