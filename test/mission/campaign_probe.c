// SPDX-License-Identifier: Apache-2.0
// Preloaded into every program of a flight of the campaign. It simulates a disk that refuses writes for a
// while: of the writes into files whose path contains a text, <number> fail, beginning with write <first
// write>. The first of them writes half of its octets, the others nothing. Writes are counted over all
// programs and lives of the flight, so the same writes fail each time and in every form. At its end each
// program records how many descriptors it has open.
//     CAMPAIGN_DISK=<text>:<first write>:<number>:<errno>   CAMPAIGN_COUNT=<file of 4 octets>
//     CAMPAIGN_ENDS=<file>
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static char text[256];
static unsigned first, number;
static int error;
static unsigned* count;

__attribute__((constructor)) static void begin(void)
{
    const char* disk = getenv("CAMPAIGN_DISK");
    const char* path = getenv("CAMPAIGN_COUNT");
    if ((disk == NULL) || (path == NULL) ||
        (sscanf(disk, "%255[^:]:%u:%u:%d", text, &first, &number, &error) != 4)) {
        return;
    }
    const int file = open(path, O_RDWR | O_CLOEXEC);
    void* memory =
        (file >= 0) ? mmap(NULL, sizeof *count, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
    count = (memory != MAP_FAILED) ? memory : NULL;
    if (file >= 0) {
        (void)close(file);
    }
}

/// Returns the number of this write among the refused writes, from 1; 0 if it is not refused.
static unsigned refused(int descriptor)
{
    char link[64];
    char path[512];
    if ((count == NULL) || (descriptor < 3)) {
        return 0U;
    }
    (void)snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t length            = readlink(link, path, sizeof path - 1U);
    path[(length > 0) ? length : 0] = '\0';
    if (strstr(path, text) == NULL) {
        return 0U;
    }
    const unsigned now = __atomic_add_fetch(count, 1U, __ATOMIC_RELAXED);
    return ((now >= first) && (now < (first + number))) ? (now - first + 1U) : 0U;
}

ssize_t write(int descriptor, const void* octets, size_t size)
{
    ssize_t (*next)(int, const void*, size_t) = NULL;
    *(void**)&next                            = dlsym(RTLD_NEXT, "write");
    const unsigned which                      = refused(descriptor);
    if (which == 0U) {
        return next(descriptor, octets, size);
    }
    if ((which == 1U) && (size > 1U)) {
        return next(descriptor, octets, size / 2U);
    }
    errno = error;
    return -1;
}

ssize_t pwrite(int descriptor, const void* octets, size_t size, off_t offset)
{
    ssize_t (*next)(int, const void*, size_t, off_t) = NULL;
    *(void**)&next                                   = dlsym(RTLD_NEXT, "pwrite");
    const unsigned which                             = refused(descriptor);
    if (which == 0U) {
        return next(descriptor, octets, size, offset);
    }
    if ((which == 1U) && (size > 1U)) {
        return next(descriptor, octets, size / 2U, offset);
    }
    errno = error;
    return -1;
}

__attribute__((destructor)) static void end(void)
{
    const char* path = getenv("CAMPAIGN_ENDS");
    DIR* directory   = (path != NULL) ? opendir("/proc/self/fd") : NULL;
    if (directory == NULL) {
        return;
    }
    unsigned open_now = 0U; // Includes the descriptor of the directory.
    for (const struct dirent* entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        open_now += (entry->d_name[0] != '.') ? 1U : 0U;
    }
    (void)closedir(directory);
    FILE* file = fopen(path, "ae");
    if (file != NULL) {
        (void)fprintf(file, "%s %u\n", program_invocation_short_name, open_now - 1U);
        (void)fclose(file);
    }
}
