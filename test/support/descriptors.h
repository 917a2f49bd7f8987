// SPDX-License-Identifier: Apache-2.0
/// The descriptors that this process has open, by which a test shows that it closes those that it opens. The
/// Makefile links all tests of Unity and cmocka so that this is checked: a test fails if it leaves a
/// descriptor open or closes one that it has not opened.
#ifndef TEST_SUPPORT_DESCRIPTORS_H
#define TEST_SUPPORT_DESCRIPTORS_H

#include <stdbool.h>

#define DESCRIPTORS_MAX 1024 ///< Higher numbers are not checked.

typedef struct {
    bool is_open[DESCRIPTORS_MAX];
} descriptors_t;

descriptors_t descriptors_now(void);
/// Print each descriptor that was opened or closed since `before`. Returns their number.
unsigned descriptors_changed(const descriptors_t* before);

#endif // TEST_SUPPORT_DESCRIPTORS_H
