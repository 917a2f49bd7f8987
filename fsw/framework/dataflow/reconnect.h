// SPDX-License-Identifier: Apache-2.0
/// Time of the next attempt to connect. After each failure the delay doubles up to a maximum. It returns to
/// its first value after a connection that has lasted as long as the delay before it; a shorter connection
/// counts as a failure.
///
/// Ownership  The caller provides flow_reconnect_t.
/// Context    One task; the time is an argument.
/// Time       O(1).
#ifndef FSW_FRAMEWORK_DATAFLOW_RECONNECT_H
#define FSW_FRAMEWORK_DATAFLOW_RECONNECT_H

#include <stdbool.h>
#include <stdint.h>

typedef struct { // Private, except the counters: read-only.
    uint64_t first_ns;
    uint64_t longest_ns;
    uint64_t delay_ns; ///< Delay before the next attempt, if the present one fails.
    uint64_t due_ns;
    uint64_t since_ns; ///< Time at which the connection began.
    bool is_connected;
    uint32_t connected; ///< Attempts that succeeded [wraps].
    uint32_t failed;    ///< Attempts that failed [wraps].
    uint32_t lost;      ///< Connections that ended [wraps].
} flow_reconnect_t;

/// Initialise, with the counters zero; the first attempt is due immediately. 1 <= first_ns <= longest_ns.
void flow_reconnect_init(flow_reconnect_t* reconnect, uint64_t first_ns, uint64_t longest_ns);
/// True if there is no connection and the time of the next attempt has come.
bool flow_reconnect_is_due(const flow_reconnect_t* reconnect, uint64_t now_ns);
/// Report how an attempt ended.
void flow_reconnect_succeeded(flow_reconnect_t* reconnect, uint64_t now_ns);
void flow_reconnect_failed(flow_reconnect_t* reconnect, uint64_t now_ns);
/// Report that the connection ended. No effect without a connection.
void flow_reconnect_lost(flow_reconnect_t* reconnect, uint64_t now_ns);

#endif // FSW_FRAMEWORK_DATAFLOW_RECONNECT_H
