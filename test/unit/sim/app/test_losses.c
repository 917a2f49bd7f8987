// SPDX-License-Identifier: Apache-2.0
// The lines about losses at the end of a run. The console is mocked.
#include "sim/app/losses.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

void __wrap_osal_console_print_error(const char* line)
{
    check_expected_ptr(line);
}

static void a_run_without_losses_prints_nothing(void** state)
{
    (void)state;
    // The flight software itself counts the frames that its bus refused.
    const simulator_statistics_t none = {.busy_ns = {7U}, .refused = 1U, .tool_frames = 3U};
    assert_false(losses_report(&none));
}

static void each_kind_of_loss_is_reported_with_its_count(void** state)
{
    (void)state;
    const simulator_statistics_t of_tools = {
        .tools_lost = 1U, .tool_dropped = 2U, .unpublished = 1ULL << 32U};
    expect_string(__wrap_osal_console_print_error, line,
                  "simulator: 1 tools in lock-step did not finish a step in 20 s and were disconnected");
    expect_string(__wrap_osal_console_print_error, line,
                  "simulator: 2 messages to tools dropped, because the tools did not read them");
    expect_string(__wrap_osal_console_print_error, line,
                  "simulator: 4294967296 frames not published, because the interface did not accept them");
    assert_false(losses_report(&of_tools));
}

static void announced_octets_that_did_not_arrive_make_a_run_not_reproducible(void** state)
{
    (void)state;
    const simulator_statistics_t of_flows = {.undelivered = 5U};
    expect_string(
        __wrap_osal_console_print_error, line,
        "simulator: 5 octets and datagrams sent between flight software and stream devices did not arrive; "
        "the run is not reproducible");
    assert_true(losses_report(&of_flows));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_without_losses_prints_nothing),
        cmocka_unit_test(each_kind_of_loss_is_reported_with_its_count),
        cmocka_unit_test(announced_octets_that_did_not_arrive_make_a_run_not_reproducible),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
