// SPDX-License-Identifier: Apache-2.0
// Reports that are lost while a request is performed in a loop of its own: the losses are counted once. How
// many are lost is mocked.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "unity.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define SLOW_NS 4000000ULL

void __real_pus_perform(pus_app_process_t* process, const pus_service_t* service, const pus_token_t* token,
                        const uint8_t* data, size_t size, uint64_t now_ns);
void __wrap_pus_perform(pus_app_process_t* process, const pus_service_t* service, const pus_token_t* token,
                        const uint8_t* data, size_t size, uint64_t now_ns)
{
    process->counters.lost += mock_type(uint32_t);
    process->counters.oversized += mock_type(uint32_t);
    __real_pus_perform(process, service, token, data, size, now_ns);
}

static void begin(void)
{
    static char xml[8192];
    const char* const whole = fixture_descriptor();
    const char* const at    = strstr(whole, "<HKService id='100'");
    assert_non_null(at);
    (void)snprintf(xml, sizeof xml,
                   "%.*s<Loop name='SLOW' samplingTime='4ms' priority='5' services='17 20'/>%s",
                   (int)(at - whole), whole, at);
    fixture_open(xml);
    fixture_bring(STATE_PRE_OPERATIONAL, FIXTURE_ALONE);
    fixture_run_until(((fixture.now_ns / SLOW_NS) * SLOW_NS) + (5U * SLOW_NS) + (SLOW_NS / 2U));
    fixture_forget();
}

static void reports_that_a_request_loses_are_counted_once(void** state)
{
    static const struct {
        uint32_t lost;
        uint32_t oversized;
    } losses[] = {{2U, 3U}, {2U, 3U}, {0U, 0U}, {0U, 0U}};
    subsystem_health_t health;
    (void)state;
    if (!TEST_PROTECT()) {
        fail_msg("the fixture has failed"); // It has printed its assertion.
    }
    begin();
    subsystem_health(&fixture.subsystem, &health);
    uint32_t expected = health.reports_lost;
    for (unsigned i = 0U; i < (sizeof losses / sizeof losses[0]); i++) {
        will_return(__wrap_pus_perform, losses[i].lost);
        will_return(__wrap_pus_perform, losses[i].oversized);
        (void)fixture_command(17U, 1U, NULL, 0U);
        fixture_run(8U);
        expected += losses[i].lost + losses[i].oversized;
        subsystem_health(&fixture.subsystem, &health);
        assert_int_equal(expected, health.reports_lost);
    }
    fixture_close();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(reports_that_a_request_loses_are_counted_once)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
