// SPDX-License-Identifier: Apache-2.0
#include "test/support/assertion.h"

#include "base/assertion.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

static jmp_buf way_back; // Set by assertion_fails; fsw_assertion_failed returns to it.
static bool is_expected; // True while assertion_fails runs its function.

bool assertion_fails(void (*const act)(void))
{
    is_expected = true;
    if (setjmp(way_back) == 0) {
        act();
        is_expected = false;
        return false;
    }
    is_expected = false;
    return true;
}

void fsw_assertion_failed(const char* const file, const int line)
{
    if (is_expected) {
        longjmp(way_back, 1);
    }
    (void)fprintf(stderr, "%s:%d: assertion failed\n", file, line);
    abort();
}
