// SPDX-License-Identifier: Apache-2.0
/// Statuses for errors of the system on files and directories. Only for osal/posix.
#ifndef OSAL_POSIX_FILE_STATUS_H
#define OSAL_POSIX_FILE_STATUS_H

#include "base/status.h"

#include <errno.h>

/// Status of an access to a name: STATUS_NOT_FOUND, STATUS_DENIED, STATUS_IO.
static inline status_t file_status_of(int error)
{
    switch (error) {
    case ENOENT:
    case ENOTDIR:
        return STATUS_NOT_FOUND;
    case EACCES:
    case EPERM:
    case EROFS:
        return STATUS_DENIED;
    default:
        return STATUS_IO;
    }
}

/// Status of a write: STATUS_FULL, STATUS_IO.
static inline status_t file_status_of_write(int error)
{
    return ((error == ENOSPC) || (error == EDQUOT) || (error == EFBIG)) ? STATUS_FULL : STATUS_IO;
}

#endif // OSAL_POSIX_FILE_STATUS_H
