// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/network.h"

#include "base/assertion.h"

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/mount.h>
#include <unistd.h>

#define OWN "/proc/thread-self/ns/net"

static status_t status_of(const int error)
{
    switch (error) {
    case ENOENT:
    case ENOTDIR:
        return STATUS_NOT_FOUND;
    case EPERM:
    case EACCES:
        return STATUS_DENIED;
    case ENOSYS:
        return STATUS_UNSUPPORTED;
    default: // EINVAL: not a file of a network namespace.
        return STATUS_IO;
    }
}

status_t osal_network_enter(osal_network_t* const home, const char* const path)
{
    FSW_ASSERT((home != NULL) && (path != NULL));
    home->descriptor  = open(OWN, O_RDONLY | O_CLOEXEC);
    const int entered = open(path, O_RDONLY | O_CLOEXEC);
    int error         = ((home->descriptor < 0) || (entered < 0)) ? errno : 0;
    if ((error == 0) && (setns(entered, CLONE_NEWNET) != 0)) {
        error = errno;
    }
    if (entered >= 0) {
        (void)close(entered);
    }
    if ((error != 0) && (home->descriptor >= 0)) {
        (void)close(home->descriptor);
        home->descriptor = -1;
    }
    return (error == 0) ? STATUS_OK : status_of(error);
}

status_t osal_network_leave(osal_network_t* const home)
{
    FSW_ASSERT((home != NULL) && (home->descriptor >= 0));
    const int error = (setns(home->descriptor, CLONE_NEWNET) == 0) ? 0 : errno;
    (void)close(home->descriptor);
    home->descriptor = -1;
    return (error == 0) ? STATUS_OK : status_of(error);
}

status_t osal_network_remove(const char* const path)
{
    FSW_ASSERT(path != NULL);
    // A name is a file on which the namespace is mounted. EINVAL: nothing is mounted there, but the file must
    // be removed.
    const bool is_mounted = (umount2(path, MNT_DETACH | UMOUNT_NOFOLLOW) == 0);
    if (!is_mounted && (errno != EINVAL)) {
        return status_of(errno);
    }
    return (unlink(path) == 0) ? STATUS_OK : status_of(errno);
}
