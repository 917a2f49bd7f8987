// SPDX-License-Identifier: Apache-2.0
/// Network namespaces: separate network stacks on one machine. The caller makes them. A socket always belongs
/// to the stack in which it was opened.
///
/// Ownership  The caller provides osal_network_t.
/// Context    One task; only that task changes its stack.
/// Errors     Each function lists its statuses; on a system without namespaces each returns
///            STATUS_UNSUPPORTED.
#ifndef OSAL_NETWORK_H
#define OSAL_NETWORK_H

#include "base/status.h"

typedef struct { // Private: the stack to return to.
    int descriptor;
} osal_network_t;

/// From now on this task, and the processes it starts, use the stack of the namespace of the file `path`.
/// `home` keeps the previous stack. STATUS_OK, STATUS_NOT_FOUND, STATUS_DENIED (no privilege),
/// STATUS_UNSUPPORTED, STATUS_IO; on failure nothing has changed.
MUST_USE status_t osal_network_enter(osal_network_t* home, const char* path);
/// Return to the stack that was used before the successful osal_network_enter that has filled `home`; `home`
/// is empty afterwards, whatever the status. STATUS_OK, STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_network_leave(osal_network_t* home);
/// Remove the name of a namespace. The namespace ends with its last process and socket. STATUS_OK,
/// STATUS_NOT_FOUND, STATUS_DENIED, STATUS_IO.
status_t osal_network_remove(const char* path);

#endif // OSAL_NETWORK_H
