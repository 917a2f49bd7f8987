// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/reconnect.h"

#include "base/assertion.h"

#include <stddef.h>

void flow_reconnect_init(flow_reconnect_t* const reconnect, const uint64_t first_ns,
                         const uint64_t longest_ns)
{
    FSW_ASSERT((reconnect != NULL) && (first_ns >= 1U) && (first_ns <= longest_ns));
    *reconnect = (flow_reconnect_t){.first_ns = first_ns, .longest_ns = longest_ns, .delay_ns = first_ns};
}

bool flow_reconnect_is_due(const flow_reconnect_t* const reconnect, const uint64_t now_ns)
{
    FSW_ASSERT(reconnect != NULL);
    return !reconnect->is_connected && (now_ns >= reconnect->due_ns);
}

/// Set the time of the next attempt by the present delay, and double the delay up to its maximum.
static void back_off(flow_reconnect_t* const reconnect, const uint64_t now_ns)
{
    reconnect->due_ns =
        (now_ns < (UINT64_MAX - reconnect->delay_ns)) ? (now_ns + reconnect->delay_ns) : UINT64_MAX;
    reconnect->delay_ns = (reconnect->delay_ns <= (reconnect->longest_ns / 2U)) ? (reconnect->delay_ns * 2U)
                                                                                : reconnect->longest_ns;
}

void flow_reconnect_succeeded(flow_reconnect_t* const reconnect, const uint64_t now_ns)
{
    FSW_ASSERT(reconnect != NULL);
    reconnect->is_connected = true;
    reconnect->since_ns     = now_ns;
    reconnect->connected++;
}

void flow_reconnect_failed(flow_reconnect_t* const reconnect, const uint64_t now_ns)
{
    FSW_ASSERT(reconnect != NULL);
    reconnect->failed++;
    back_off(reconnect, now_ns);
}

void flow_reconnect_lost(flow_reconnect_t* const reconnect, const uint64_t now_ns)
{
    FSW_ASSERT(reconnect != NULL);
    if (!reconnect->is_connected) {
        return;
    }
    reconnect->is_connected = false;
    reconnect->lost++;
    if ((now_ns - reconnect->since_ns) >= reconnect->delay_ns) {
        reconnect->delay_ns = reconnect->first_ns;
    }
    back_off(reconnect, now_ns);
}
