// SPDX-License-Identifier: Apache-2.0
/// Assertions under test: fsw_assertion_failed for test programs. An assertion that no test expects prints
/// its place and aborts.
#ifndef TEST_SUPPORT_ASSERTION_H
#define TEST_SUPPORT_ASSERTION_H

#include <stdbool.h>

/// Run `act`. Returns true if an FSW_ASSERT inside it failed, which ends `act` at that point.
bool assertion_fails(void (*act)(void));

#endif // TEST_SUPPORT_ASSERTION_H
