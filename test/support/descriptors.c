// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L
#include "test/support/descriptors.h"

#include "unity.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define DIRECTORY "/proc/self/fd"

descriptors_t descriptors_now(void)
{
    descriptors_t now          = {{false}};
    DIR* const directory       = opendir(DIRECTORY);
    const struct dirent* entry = (directory != NULL) ? readdir(directory) : NULL;
    for (; entry != NULL; entry = readdir(directory)) {
        const long number = (entry->d_name[0] == '.') ? DESCRIPTORS_MAX : strtol(entry->d_name, NULL, 10);
        if ((number < DESCRIPTORS_MAX) && (number != dirfd(directory))) {
            now.is_open[number] = true;
        }
    }
    (void)closedir(directory);
    return now;
}

static void print(const int number, const bool is_open)
{
    char link[64];
    char path[256]            = "";
    const int written         = snprintf(link, sizeof link, DIRECTORY "/%d", number);
    const ssize_t end         = (written > 0) ? readlink(link, path, sizeof path - 1U) : 0;
    path[(end > 0) ? end : 0] = '\0';
    (void)printf("descriptor %d is %s after the test: %s\n", number, is_open ? "open" : "closed", path);
}

unsigned descriptors_changed(const descriptors_t* before)
{
    const descriptors_t now = descriptors_now();
    unsigned changed        = 0U;
    for (int number = 0; number < DESCRIPTORS_MAX; number++) {
        if (now.is_open[number] != before->is_open[number]) {
            print(number, now.is_open[number]);
            changed++;
        }
    }
    return changed;
}

void __real_UnityDefaultTestRun(UnityTestFunction test, const char* name, int line);
void __wrap_UnityDefaultTestRun(UnityTestFunction test, const char* name, int line)
{
    const UNITY_UINT failures  = Unity.TestFailures;
    const descriptors_t before = descriptors_now();
    __real_UnityDefaultTestRun(test, name, line);
    // A test that fails ends at once and cannot close what it has opened: its descriptors are not checked.
    if ((Unity.TestFailures == failures) && (descriptors_changed(&before) > 0U)) {
        (void)printf("%s:%d:%s:FAIL: the test leaves the descriptors above open or closed\n", Unity.TestFile,
                     line, name);
        Unity.TestFailures++;
    }
}
