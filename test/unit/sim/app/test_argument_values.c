// SPDX-License-Identifier: Apache-2.0
// Times on the command line. The console is mocked.
#include "sim/app/argument_values.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

void __wrap_osal_console_print_error(const char* line)
{
    check_expected_ptr(line);
}

static void a_time_is_rounded_to_the_nearest_nanosecond(void** state)
{
    (void)state;
    static const struct {
        const char* text;
        uint64_t ns;
    } times[] = {
        {"0", 0U},
        {"2.5", 2500000000U},
        {"0.0000000014", 1U},
        {"0.0000000015", 2U},
        // Above 2^52 ns a double has no halves, so adding one half would round once more.
        {"4503599.627370497", 4503599627370497U},
        {"1e9", 1000000000000000000U},
    };
    for (size_t i = 0U; i < (sizeof times / sizeof times[0]); i++) {
        uint64_t ns = 0U;
        assert_true(argument_seconds("duration", times[i].text, &ns));
        assert_int_equal(ns, times[i].ns);
    }
}

static void a_text_that_is_no_time_is_refused(void** state)
{
    (void)state;
    uint64_t ns = 7U;
    expect_string(__wrap_osal_console_print_error, line,
                  "simulator: --duration '-1': expected a time in seconds (see --help)");
    assert_false(argument_seconds("duration", "-1", &ns));
    assert_int_equal(ns, 7U);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_time_is_rounded_to_the_nearest_nanosecond),
        cmocka_unit_test(a_text_that_is_no_time_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
