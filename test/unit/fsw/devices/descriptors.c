// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/devices/descriptors.h"

#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static descriptor_loader_t loader;

void load_document(const char* const document, subsystem_descriptor_t* const out_descriptor)
{
    char path[]          = "/tmp/stream-devices-XXXXXX";
    const int descriptor = mkstemp(path);
    TEST_ASSERT_TRUE(descriptor >= 0);
    TEST_ASSERT_EQUAL_INT64((long)strlen(document), (long)write(descriptor, document, strlen(document)));
    (void)close(descriptor);
    descriptor_loader_init(&loader);
    const status_t status = descriptor_load_subsystem(&loader, path, out_descriptor);
    (void)unlink(path);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, status, descriptor_error(&loader));
}
