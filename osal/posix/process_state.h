// SPDX-License-Identifier: Apache-2.0
/// Private to osal/posix: the state of any process.
#ifndef OSAL_POSIX_PROCESS_STATE_H
#define OSAL_POSIX_PROCESS_STATE_H

#include <stdint.h>

/// Letter of the state of a process as in /proc/<id>/stat, e.g. 'T': stopped by a signal. '\0': no such
/// process.
char osal_process_state(int32_t id);

#endif // OSAL_POSIX_PROCESS_STATE_H
