// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/permission_matrix.h"
#include "unity.h"

static mission_descriptor_t mission;

static const mission_rule_t rules[] = {
    {.service = 8U, .subtype = 1U, .select = "MOVE_TO", .target = 16U, .modes = 2U, .states = 1U << 5U},
    {.service = 8U,
     .subtype = 1U,
     .select  = "STOP",
     .target  = MISSION_ANY_TARGET,
     .modes   = UINT8_MAX,
     .states  = UINT16_MAX},
    {.service     = 129U,
     .subtype     = 1U,
     .number      = 4U,
     .is_numbered = true,
     .target      = 16U,
     .modes       = 2U,
     .states      = 1U << 3U},
    {.service = 20U, .subtype = 3U, .is_any = true, .target = 16U, .modes = 3U, .states = 1U << 4U},
};

void setUp(void)
{
    descriptor_mission_clear(&mission);
    for (size_t i = 0U; i < (sizeof rules / sizeof rules[0]); i++) {
        mission.storage.rules[i] = rules[i];
        mission.rule_count++;
    }
}

void tearDown(void)
{
}

static int rule_for(const permission_request_t request)
{
    int rule              = 99;
    const status_t status = supervisor_permission_check(&mission, &request, &rule);
    TEST_ASSERT_EQUAL((rule == PERMISSION_RULE_NONE) ? STATUS_FORBIDDEN : STATUS_OK, status);
    return rule;
}

static permission_request_t move_to(void)
{
    return (permission_request_t){
        .service = 8U, .subtype = 1U, .select = "MOVE_TO", .target = 16U, .mode = 1U, .state = 5U};
}

static void a_permission_names_the_rule_that_allows(void)
{
    TEST_ASSERT_EQUAL(0, rule_for(move_to()));
    permission_request_t request = move_to();
    request.select               = "STOP";
    request.state                = 3U;
    request.target               = 99U;
    TEST_ASSERT_EQUAL(1, rule_for(request));
}

/// A difference in any part of the key denies the request.
static void a_request_is_denied_if_any_part_of_its_key_differs(void)
{
    permission_request_t request = move_to();
    request.select               = "TARE";
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
    request        = move_to();
    request.select = NULL;
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
    request        = move_to();
    request.target = 17U;
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
    request         = move_to();
    request.subtype = 2U;
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
    request         = move_to();
    request.service = 9U;
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
    for (unsigned mode = 0U; mode < 256U; mode++) {
        request      = move_to();
        request.mode = (uint8_t)mode;
        TEST_ASSERT_EQUAL((mode == 1U) ? 0 : PERMISSION_RULE_NONE, rule_for(request));
    }
    for (unsigned state = 0U; state < 256U; state++) {
        request       = move_to();
        request.state = (uint8_t)state;
        TEST_ASSERT_EQUAL((state == 5U) ? 0 : PERMISSION_RULE_NONE, rule_for(request));
    }
}

/// True for the requests of the built-in set, except TC[129,1]: reports, reads, ST[17], closing a link,
/// shutdown. A key is service * 1000 + subtype.
static bool is_in(const uint8_t service, const uint8_t subtype)
{
    static const unsigned keys[] = {
        3009U,  3011U,  3027U,  3028U,  3033U,   3034U,   3040U,   4008U,   5007U,   11009U,  11011U, 11012U,
        11014U, 11016U, 11017U, 11018U, 11026U,  12008U,  12010U,  12013U,  12025U,  12027U,  14003U, 14007U,
        14011U, 14015U, 15005U, 15012U, 15018U,  15022U,  15035U,  15037U,  15039U,  18008U,  19006U, 19010U,
        20001U, 20006U, 21006U, 21009U, 21011U,  22009U,  22011U,  22012U,  22014U,  22016U,  22017U, 22018U,
        22026U, 23003U, 23007U, 23012U, 129004U, 130001U, 130007U, 130008U, 131005U, 131008U, 131010U};
    for (size_t i = 0U; i < (sizeof keys / sizeof keys[0]); i++) {
        if (keys[i] == ((service * 1000U) + subtype)) {
            return true;
        }
    }
    return (service == 17U) && (subtype < 64U);
}

static void a_rule_may_be_for_a_whole_service(void)
{
    mission.storage.rules[0].service = 11U;
    mission.storage.rules[0].subtype = 0U;
    mission.storage.rules[0].is_any  = true;
    for (unsigned subtype = 1U; subtype < 256U; subtype++) {
        permission_request_t request = move_to();
        request.service              = 11U;
        request.subtype              = (uint8_t)subtype;
        TEST_ASSERT_EQUAL(is_in(11U, request.subtype) ? PERMISSION_RULE_ALWAYS : 0, rule_for(request));
        request.service = 12U;
        TEST_ASSERT_EQUAL(is_in(12U, request.subtype) ? PERMISSION_RULE_ALWAYS : PERMISSION_RULE_NONE,
                          rule_for(request));
    }
}

/// Every service, subtype, state and selector without rules: only the built-in set is allowed.
static void without_rules_only_the_built_in_set_is_allowed(void)
{
    descriptor_mission_clear(&mission);
    for (unsigned service = 1U; service < 256U; service++) {
        for (unsigned subtype = 1U; subtype < 256U; subtype++) {
            for (unsigned state = 0U; state < 10U; state++) {
                if ((service == 129U) && (subtype == 1U)) {
                    continue; // Another test covers these.
                }
                const permission_request_t request = {.service = (uint8_t)service,
                                                      .subtype = (uint8_t)subtype,
                                                      .select  = "STOP",
                                                      .number  = (uint16_t)(state % 7U),
                                                      .target  = 16U,
                                                      .state   = (uint8_t)state};
                int rule                           = 0;
                const bool is_allowed = supervisor_permission_check(&mission, &request, &rule) == STATUS_OK;
                if (is_allowed != is_in(request.service, request.subtype)) {
                    TEST_FAIL();
                }
            }
        }
    }
}

/// Lower states and ERROR_OPERATIONAL are always allowed; higher states never without a rule. Rows: present
/// state; columns: target.
static void only_requests_for_lower_states_need_no_rule(void)
{
    static const char* const expected[10] = {
        // Target 0123456789
        "y.....y...", // OFFLINE
        "y.....y...", // SOFTWARE_INIT
        "y.....y...", // HARDWARE_INIT
        "y..y..y...", // PRE_OPERATIONAL
        "y..yy.y...", // SAFE_OPERATIONAL
        "y..yyyy...", // OPERATIONAL
        "y.....y...", // ERROR_OPERATIONAL
        "y.....y...", // POST_OPERATIONAL
        "y.....y...", // HARDWARE_DEINIT
        "y.....y...", // SOFTWARE_DEINIT
    };
    descriptor_mission_clear(&mission);
    for (uint8_t state = 0U; state < 10U; state++) {
        for (uint8_t target = 0U; target < 10U; target++) {
            const permission_request_t request = {
                .service = 129U, .subtype = 1U, .number = target, .target = 16U, .state = state};
            const int wanted =
                (expected[state][target] == 'y') ? PERMISSION_RULE_ALWAYS : PERMISSION_RULE_NONE;
            TEST_ASSERT_EQUAL(wanted, rule_for(request));
        }
    }
}

static void a_rule_allows_an_upward_request_from_its_state_only(void)
{
    permission_request_t request = {
        .service = 129U, .subtype = 1U, .number = 4U, .target = 16U, .mode = 1U, .state = 3U};
    TEST_ASSERT_EQUAL(2, rule_for(request));
    request.number = 5U;
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
    request.number = 4U;
    request.state  = 0U;
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
    request.state = 3U;
    request.mode  = 0U;
    TEST_ASSERT_EQUAL(PERMISSION_RULE_NONE, rule_for(request));
}

static void any_selector_matches_a_request_without_one(void)
{
    permission_request_t request = {.service = 20U, .subtype = 3U, .target = 16U, .mode = 0U, .state = 4U};
    TEST_ASSERT_EQUAL(3, rule_for(request));
    request.number = 7U;
    request.select = "ANYTHING";
    TEST_ASSERT_EQUAL(3, rule_for(request));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_permission_names_the_rule_that_allows);
    RUN_TEST(a_request_is_denied_if_any_part_of_its_key_differs);
    RUN_TEST(a_rule_may_be_for_a_whole_service);
    RUN_TEST(without_rules_only_the_built_in_set_is_allowed);
    RUN_TEST(only_requests_for_lower_states_need_no_rule);
    RUN_TEST(a_rule_allows_an_upward_request_from_its_state_only);
    RUN_TEST(any_selector_matches_a_request_without_one);
    return UNITY_END();
}
