// SPDX-License-Identifier: Apache-2.0
// The simulator's reader of worlds as a program: one line for each file, "ok" or the error.
#include "sim/world/world.h"

#include <stdio.h>

int main(const int count, char* arguments[])
{
    static world_t world;
    for (int i = 1; i < count; i++) {
        char error[DOCUMENT_ERROR_MAX];
        const status_t status = world_read(arguments[i], &world, error);
        (void)printf("%s\n", (status == STATUS_OK) ? "ok" : error);
    }
    return 0;
}
