// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/device.h"

#include "base/assertion.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static status_t status_of_open(const int error)
{
    switch (error) {
    case ENOENT:
    case ENOTDIR:
    case ENXIO: // A FIFO without a reader, or a device node without a driver.
    case ENODEV:
        return STATUS_NOT_FOUND;
    case EBUSY:
        return STATUS_BUSY;
    case EACCES:
    case EPERM:
    case EROFS:
        return STATUS_DENIED;
    case EMFILE:
    case ENFILE:
    case ENOMEM:
        return STATUS_EXHAUSTED;
    case EISDIR:
        return STATUS_INVALID;
    default:
        return STATUS_IO;
    }
}

status_t osal_device_open(osal_device_t* const device, const char* const path,
                          const osal_device_direction_t direction)
{
    FSW_ASSERT((device != NULL) && (path != NULL));
    static const int accesses[] = {O_RDONLY, O_WRONLY, O_RDWR};
    const int flags             = accesses[direction] | O_APPEND | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
    int descriptor              = -1;
    *device                     = (osal_device_t)OSAL_DEVICE_CLOSED;
    struct stat what            = {0};
    do {
        descriptor = open(path, flags);
    } while ((descriptor < 0) && (errno == EINTR));
    if (descriptor < 0) {
        return status_of_open(errno);
    }
    if ((fstat(descriptor, &what) != 0) || S_ISDIR(what.st_mode)) {
        (void)close(descriptor);
        return STATUS_INVALID;
    }
    *device = (osal_device_t){.descriptor = descriptor, .is_file = S_ISREG(what.st_mode)};
    return STATUS_OK;
}

/// Write, and suppress SIGPIPE, which the kernel sends if the FIFO has no reader any more.
static ssize_t write_quietly(const int descriptor, const uint8_t* const octets, const size_t size)
{
    sigset_t pipe_only;
    sigset_t kept;
    sigset_t before;
    (void)sigemptyset(&pipe_only);
    (void)sigaddset(&pipe_only, SIGPIPE);
    (void)sigpending(&before);
    (void)pthread_sigmask(SIG_BLOCK, &pipe_only, &kept);
    ssize_t written = 0;
    do {
        written = write(descriptor, octets, size);
    } while ((written < 0) && (errno == EINTR));
    const int error = errno;
    if ((written < 0) && (error == EPIPE) && (sigismember(&before, SIGPIPE) == 0)) {
        const struct timespec at_once = {0, 0};
        (void)sigtimedwait(&pipe_only, NULL, &at_once);
    }
    (void)pthread_sigmask(SIG_SETMASK, &kept, NULL);
    errno = error;
    return written;
}

static bool is_gone(const int error)
{
    return (error == EPIPE) || (error == EIO) || (error == ENXIO) || (error == ENODEV);
}

status_t osal_device_write(osal_device_t* const device, const uint8_t* const octets, const size_t size,
                           size_t* const out_sent)
{
    FSW_ASSERT((device != NULL) && (octets != NULL) && (size > 0U) && (out_sent != NULL));
    const ssize_t written = write_quietly(device->descriptor, octets, size);
    *out_sent             = (written > 0) ? (size_t)written : 0U;
    if (written > 0) {
        return STATUS_OK;
    }
    if ((written == 0) || (errno == EAGAIN) || (errno == ENOSPC) || (errno == EDQUOT)) {
        return STATUS_FULL;
    }
    return is_gone(errno) ? STATUS_CLOSED : STATUS_IO;
}

status_t osal_device_read(osal_device_t* const device, uint8_t* const octets, const size_t capacity,
                          size_t* const out_size)
{
    FSW_ASSERT((device != NULL) && (octets != NULL) && (capacity > 0U) && (out_size != NULL));
    ssize_t size = 0;
    do {
        size = read(device->descriptor, octets, capacity);
    } while ((size < 0) && (errno == EINTR));
    *out_size = (size > 0) ? (size_t)size : 0U;
    if (size > 0) {
        return STATUS_OK;
    }
    if (size == 0) {
        return device->is_file ? STATUS_EMPTY : STATUS_CLOSED;
    }
    if (errno == EAGAIN) {
        return STATUS_EMPTY;
    }
    return is_gone(errno) ? STATUS_CLOSED : STATUS_IO;
}

status_t osal_device_wait_readable(osal_device_t* const device, const uint32_t timeout_ms)
{
    FSW_ASSERT((device != NULL) && (timeout_ms <= (uint32_t)INT_MAX));
    struct pollfd watched = {.fd = device->descriptor, .events = POLLIN};
    int ready             = 0;
    do {
        ready = poll(&watched, 1U, (int)timeout_ms);
    } while ((ready < 0) && (errno == EINTR));
    return (ready > 0) ? STATUS_OK : STATUS_TIMEOUT;
}

void osal_device_close(osal_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    if (device->descriptor >= 0) {
        (void)close(device->descriptor);
    }
    *device = (osal_device_t)OSAL_DEVICE_CLOSED;
}

status_t osal_device_pipe(osal_device_t* const out_reader, osal_device_t* const out_writer)
{
    FSW_ASSERT((out_reader != NULL) && (out_writer != NULL));
    int ends[2]        = {-1, -1};
    const bool is_made = (pipe2(ends, O_CLOEXEC | O_NONBLOCK) == 0);
    *out_reader        = (osal_device_t){.descriptor = is_made ? ends[0] : -1};
    *out_writer        = (osal_device_t){.descriptor = is_made ? ends[1] : -1};
    return is_made ? STATUS_OK : STATUS_EXHAUSTED;
}

int osal_device_descriptor(const osal_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    return device->descriptor;
}
