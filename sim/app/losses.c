// SPDX-License-Identifier: Apache-2.0
#include "sim/app/losses.h"

#include "osal/include/osal/console.h"

#include <inttypes.h>
#include <stdio.h>

static void print_loss(const uint64_t count, const char* const text)
{
    char line[256];
    if (count > 0U) {
        (void)snprintf(line, sizeof line, "simulator: %" PRIu64 " %s", count, text);
        osal_console_print_error(line);
    }
}

bool losses_report(const simulator_statistics_t* const statistics)
{
    char tools[96];
    (void)snprintf(tools, sizeof tools,
                   "tools in lock-step did not finish a step in %u s and were disconnected",
                   SIMULATOR_TOOL_TIMEOUT_S);
    print_loss(statistics->tools_lost, tools);
    print_loss(statistics->tool_dropped, "messages to tools dropped, because the tools did not read them");
    print_loss(statistics->unpublished, "frames not published, because the interface did not accept them");
    print_loss(statistics->undelivered,
               "octets and datagrams sent between flight software and stream devices did "
               "not arrive; the run is not reproducible");
    return statistics->undelivered > 0U;
}
