// SPDX-License-Identifier: Apache-2.0
// Library that is preloaded into the supervisor. It replaces functions of the C library, so that the disk of
// the packet log seems to be slow, to hang, or to become read-only.
//
// SLOW_DISK_DIRECTORY names a directory of the test. While it contains a file
//     hold      a write does not end; the file "held" shows that one waits
//     readonly  nothing can be written, shortened, or opened for writing
// Without that variable every fiftieth write takes 300 ms.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

#define DELAY_US 300000U
#define POLL_US 1000U
#define WRITES_PER_DELAY 50U

static bool is_log(const char* path)
{
    return strstr(path, "/packets.") != NULL;
}

static bool is_open_log(int descriptor)
{
    char link[64];
    char path[512];
    (void)snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t length            = readlink(link, path, sizeof path - 1U);
    path[(length > 0) ? length : 0] = '\0';
    return is_log(path);
}

static const char* path_of(const char* name)
{
    static _Thread_local char path[512];
    const char* directory = getenv("SLOW_DISK_DIRECTORY");
    (void)snprintf(path, sizeof path, "%s/%s", (directory != NULL) ? directory : "/nowhere", name);
    return path;
}

static bool has(const char* name)
{
    return access(path_of(name), F_OK) == 0;
}

static void* next_of(const char* name)
{
    return dlsym(RTLD_NEXT, name);
}

static int open_file(const char* path, int flags, mode_t mode)
{
    int (*next)(const char*, int, mode_t) = NULL;
    *(void**)&next                        = next_of("open");
    return next(path, flags, mode);
}

static void wait_while_held(void)
{
    if (has("hold")) {
        const int descriptor = open_file(path_of("held"), O_WRONLY | O_CREAT, 0644);
        (void)close(descriptor);
    }
    while (has("hold")) {
        (void)usleep(POLL_US);
    }
}

int open(const char* path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = ((flags & O_CREAT) != 0) ? va_arg(rest, mode_t) : 0U;
    va_end(rest);
    if (((flags & O_ACCMODE) != O_RDONLY) && is_log(path) && has("readonly")) {
        errno = EROFS;
        return -1;
    }
    return open_file(path, flags, mode);
}

int ftruncate(int descriptor, off_t size)
{
    int (*next)(int, off_t) = NULL;
    *(void**)&next          = next_of("ftruncate");
    if (is_open_log(descriptor) && has("readonly")) {
        errno = EROFS;
        return -1;
    }
    return next(descriptor, size);
}

ssize_t write(int descriptor, const void* octets, size_t size)
{
    static unsigned count;
    ssize_t (*next)(int, const void*, size_t) = NULL;
    *(void**)&next                            = next_of("write");
    if (is_open_log(descriptor)) {
        count++;
        if (getenv("SLOW_DISK_DIRECTORY") != NULL) {
            wait_while_held();
        } else if ((count % WRITES_PER_DELAY) == 0U) {
            (void)usleep(DELAY_US);
        }
        if (has("readonly")) {
            errno = EROFS;
            return -1;
        }
    }
    return next(descriptor, octets, size);
}
