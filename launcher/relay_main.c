// SPDX-License-Identifier: Apache-2.0
// The relay of the links as a separate process, which is a participant of the run's scheduler
// (launcher_relay.h).
#include "launcher/launcher_relay.h"

#include "base/text.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/process.h"

#include <string.h>

#define LINE_MAX 512U

static launcher_relay_t relay;

static int report_error(const char* const what)
{
    char line[LINE_MAX];
    (void)text_join(line, sizeof line, (const char* const[]){"relay: ", what, NULL});
    osal_console_print_error(line);
    return 1;
}

int main(int argument_count, char* arguments[])
{
    static const char usage[] = "usage: --run NAME (the launcher `hirosco run --delay MS` starts it)";
    osal_shm_t run_shm;
    osal_shm_t scheduler_shm;
    run_state_t* run = NULL;
    char name[RUN_NAME_MAX];
    if (osal_console_introduce(argument_count, arguments, "relay", usage)) {
        return 0;
    }
    if ((argument_count != 3) || (strcmp(arguments[1], "--run") != 0)) {
        (void)report_error(usage);
        return 2;
    }
    osal_process_catch_stop();
    osal_process_ignore_interrupt();
    if ((run_state_attach(&run_shm, arguments[2], &run) != STATUS_OK) ||
        !run_name(run, "scheduler", 0U, name, sizeof name) ||
        (osal_shm_open(&scheduler_shm, name) != STATUS_OK)) {
        return report_error("there is no such run; `hirosco run --delay MS` starts it");
    }
    osal_lockstep_t* const scheduler = osal_lockstep_attach(osal_shm_address(&scheduler_shm));
    const char* const error =
        (scheduler == NULL) ? "the run's scheduler is of another version; build all programs with `make`"
                            : launcher_relay_open(&relay, run, scheduler);
    if (error != NULL) {
        return report_error(error);
    }
    uint64_t wake_ns   = 0U;
    osal_grant_t grant = {0U, 0U, 0U};
    while ((osal_lockstep_wait(scheduler, run_relay(run), 1U, wake_ns, &grant) == STATUS_OK) &&
           (osal_process_stop_count() == 0U)) {
        wake_ns = launcher_relay_step(&relay, &grant);
    }
    launcher_relay_close(&relay);
    return 0;
}
