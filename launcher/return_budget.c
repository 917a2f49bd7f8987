// SPDX-License-Identifier: Apache-2.0
#include "launcher/return_budget.h"

#include "base/assertion.h"

#include <stddef.h>

bool return_budget_take(return_budget_t* const budget, const uint64_t now_ns, uint64_t* const out_delay_ns)
{
    static const uint64_t delays_ns[RETURN_BUDGET] = {0U, 100000000U, 1000000000U};
    FSW_ASSERT((budget != NULL) && (out_delay_ns != NULL));
    unsigned recent = 0U;
    for (unsigned i = 0U; (i < budget->deaths) && (i < RETURN_BUDGET); i++) {
        recent += ((now_ns - budget->died_ns[i]) < RETURN_PERIOD_NS) ? 1U : 0U;
    }
    if (recent == RETURN_BUDGET) {
        return false;
    }
    budget->died_ns[budget->deaths % RETURN_BUDGET] = now_ns;
    budget->deaths++;
    *out_delay_ns = delays_ns[recent];
    return true;
}
