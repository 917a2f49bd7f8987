// SPDX-License-Identifier: Apache-2.0
// Preloaded into the supervisor: each fiftieth write into the packet log takes 300 ms.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define DELAY_US 300000U
#define EACH 50U

static int is_log(int descriptor)
{
    char link[64];
    char path[512];
    (void)snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t length            = readlink(link, path, sizeof path - 1U);
    path[(length > 0) ? length : 0] = '\0';
    return strstr(path, "/packets.ascii") != NULL;
}

ssize_t write(int descriptor, const void* octets, size_t size)
{
    static unsigned count;
    ssize_t (*next)(int, const void*, size_t) = NULL;
    *(void**)&next                            = dlsym(RTLD_NEXT, "write");
    if (is_log(descriptor)) {
        count++;
        if ((count % EACH) == 0U) {
            (void)usleep(DELAY_US);
        }
    }
    return next(descriptor, octets, size);
}
