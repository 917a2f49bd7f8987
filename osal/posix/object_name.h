// SPDX-License-Identifier: Apache-2.0
/// Names of shared memory and message queues. Internal to the port.
#ifndef OSAL_POSIX_OBJECT_NAME_H
#define OSAL_POSIX_OBJECT_NAME_H

#include <stdbool.h>

/// True if the name is a slash and 1 to 60 letters, digits, dots, underscores and hyphens, but not "/." or
/// "/..".
bool object_name_is_valid(const char* name);

#endif // OSAL_POSIX_OBJECT_NAME_H
