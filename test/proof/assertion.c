// SPDX-License-Identifier: Apache-2.0
// In a proof each assertion of the code is a further statement to prove.
#include "base/assertion.h"
#include "test/proof/proof.h"

void fsw_assertion_failed(const char* const file, const int line)
{
    (void)file;
    (void)line;
    NEVER("no assertion of the code fails");
    ASSUME(false);
}
