// SPDX-License-Identifier: Apache-2.0
/// The descriptors that this process has open, so that a test can show that it closes those it opens. The
/// Makefile links tests so that each test of Unity and of cmocka counts: a test that leaves one open, or
/// closes one that is not its own, fails.
#ifndef TEST_SUPPORT_DESCRIPTORS_H
#define TEST_SUPPORT_DESCRIPTORS_H

#include <stdbool.h>

#define DESCRIPTORS_MAX 1024 ///< Higher numbers are not checked.

typedef struct {
    bool is_open[DESCRIPTORS_MAX];
} descriptors_t;

descriptors_t descriptors_now(void);
/// Number of descriptors that are open now and were not, or the other way round; each is printed.
unsigned descriptors_changed(const descriptors_t* before);

#endif // TEST_SUPPORT_DESCRIPTORS_H
