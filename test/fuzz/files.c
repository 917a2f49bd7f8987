// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE // memfd_create
#include "test/fuzz/fuzz.h"

#include <errno.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define MEMORY_DESCRIPTOR 100 // Fixed, so that the path is a constant.
#define PATH_CHARACTERS 256U

const char* fuzz_file(const uint8_t* const data, const size_t size)
{
    static int descriptor = -1;
    if (descriptor < 0) {
        const int made = memfd_create("input", 0U);
        descriptor     = dup2(made, MEMORY_DESCRIPTOR);
        FUZZ_CHECK((made >= 0) && (descriptor == MEMORY_DESCRIPTOR));
    }
    FUZZ_CHECK(ftruncate(descriptor, 0) == 0);
    FUZZ_CHECK(pwrite(descriptor, data, size, 0) == (ssize_t)size);
    return "/proc/self/fd/100";
}

static void create_directory(const char* const path)
{
    FUZZ_CHECK((mkdir(path, 0755U) == 0) || (errno == EEXIST));
}

const char* fuzz_directory(const char* const name)
{
    static char path[PATH_CHARACTERS];
    create_directory("build");
    create_directory("build/fuzz");
    create_directory("build/fuzz/directory");
    (void)snprintf(path, sizeof path, "build/fuzz/directory/%s", name);
    create_directory(path);
    return path;
}

void fuzz_link(const char* const directory, const char* const link, const char* const target)
{
    char path[PATH_CHARACTERS];
    (void)snprintf(path, sizeof path, "%s/%s", directory, link);
    FUZZ_CHECK((symlink(target, path) == 0) || (errno == EEXIST));
}
