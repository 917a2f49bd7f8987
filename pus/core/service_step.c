// SPDX-License-Identifier: Apache-2.0
// For hosts without a component, which steps each of its services by itself.
#include "base/assertion.h"
#include "pus/core/service.h"

void pus_dispatcher_step(pus_dispatcher_t* const dispatcher, const uint64_t now_ns, const uint32_t cycle)
{
    FSW_ASSERT(dispatcher != NULL);
    (void)pus_dispatcher_resume(dispatcher, now_ns); // The rest is sent in a later step.
    for (size_t i = 0U; i < dispatcher->service_count; i++) {
        if (dispatcher->services[i].step != NULL) {
            dispatcher->services[i].step(dispatcher->services[i].self, now_ns, cycle);
        }
    }
}
