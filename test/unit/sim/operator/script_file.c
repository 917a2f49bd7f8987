// SPDX-License-Identifier: Apache-2.0
#include "test/unit/sim/operator/script_file.h"

#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char path[32];

const char* script_file_write(const char* text)
{
    script_file_remove();
    (void)snprintf(path, sizeof path, "/tmp/scenario-XXXXXX");
    const int descriptor = mkstemp(path);
    TEST_ASSERT_TRUE(descriptor >= 0);
    TEST_ASSERT_EQUAL_INT64((int64_t)strlen(text), write(descriptor, text, strlen(text)));
    (void)close(descriptor);
    return path;
}

void script_file_remove(void)
{
    if (path[0] != '\0') {
        (void)unlink(path);
        path[0] = '\0';
    }
}
