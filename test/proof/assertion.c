// SPDX-License-Identifier: Apache-2.0
// In a proof no assertion of the code may fail: it is a statement to prove like all others.
#include "base/assertion.h"
#include "test/proof/proof.h"

void fsw_assertion_failed(const char* const file, const int line)
{
    (void)file;
    (void)line;
    NEVER("no assertion of the code fails");
    ASSUME(false);
}
