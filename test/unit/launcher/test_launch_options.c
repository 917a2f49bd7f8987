// SPDX-License-Identifier: Apache-2.0
// Options of `hirosco run`: values, accepted combinations, and refused ones with the reason.
#include "launcher/launch_options.h"

#include <string.h>

#include "unity.h"

#define WORDS_MAX 16

static launch_options_t options;
static char error[LAUNCH_ERROR_MAX];

void setUp(void)
{
}

void tearDown(void)
{
}

/// Parse a line whose words are separated by single spaces.
static bool parse(const char* line)
{
    static char storage[256];
    char* words[WORDS_MAX];
    int count = 0;
    (void)strncpy(storage, line, sizeof storage - 1U);
    for (char* word = strtok(storage, " "); word != NULL; word = strtok(NULL, " ")) {
        TEST_ASSERT_LESS_THAN(WORDS_MAX, count);
        words[count] = word;
        count++;
    }
    return launch_options_parse(count, words, &options, error);
}

static void a_bus_is_shared_memory_unless_another_kind_is_given(void)
{
    TEST_ASSERT_TRUE(parse(""));
    TEST_ASSERT_EQUAL(LAUNCH_BUS_SHM, options.bus);
    TEST_ASSERT_TRUE(launch_has_simulator(&options));
    TEST_ASSERT_TRUE(parse("--bus vcan"));
    TEST_ASSERT_EQUAL(LAUNCH_BUS_VCAN, options.bus);
    TEST_ASSERT_TRUE(launch_has_simulator(&options));
    TEST_ASSERT_EQUAL_STRING("vcan", launch_bus_text(options.bus));
}

static void options_that_are_not_given_have_their_defaults(void)
{
    TEST_ASSERT_TRUE(parse(""));
    TEST_ASSERT_EQUAL_STRING("rokviss", options.mission);
    TEST_ASSERT_EQUAL_STRING("", options.scenario);
    TEST_ASSERT_EQUAL_UINT64(1U, options.seed);
    TEST_ASSERT_FALSE(options.is_image || options.is_free);
    TEST_ASSERT_TRUE(options.is_stepped && options.has_report);
    TEST_ASSERT_EQUAL_UINT(0U, options.interface_count + options.sim_interface_count);
    TEST_ASSERT_EQUAL_STRING("", options.transport);
    TEST_ASSERT_EQUAL_STRING("", options.links);
    TEST_ASSERT_EQUAL_UINT8(1U, options.computers);
    TEST_ASSERT_EQUAL_UINT16(0U, options.port);
    TEST_ASSERT_EQUAL_UINT16(0U, options.tools);
    TEST_ASSERT_EQUAL_UINT16(0U, options.delay_ms);
    TEST_ASSERT_EQUAL_STRING("", options.output);
    TEST_ASSERT_EQUAL_STRING("", options.storage);
    TEST_ASSERT_EQUAL_STRING("", options.remote_endian);
    TEST_ASSERT_EQUAL_UINT64(0U, options.duration_ns);
    TEST_ASSERT_EQUAL_STRING("", error);
}

/// The Makefile passes all options, also those without a value.
static void an_empty_value_counts_as_not_given(void)
{
    static char* names[] = {"--mission",   "--scenario",      "--seed",      "--form",          "--time",
                            "--bus",       "--port",          "--tools",     "--links",         "--report",
                            "--transport", "--nodes",         "--out",       "--storage",       "--key",
                            "--duration",  "--remote-endian", "--interface", "--sim-interface", "--world",
                            "--delay",     "--rtos"};
    static char empty[]  = "";
    launch_options_t defaults;
    TEST_ASSERT_TRUE(parse(""));
    defaults = options;
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        char* words[] = {names[i], empty};
        TEST_ASSERT_TRUE_MESSAGE(launch_options_parse(2, words, &options, error), names[i]);
        TEST_ASSERT_EQUAL_UINT64(defaults.seed, options.seed);
        TEST_ASSERT_EQUAL_STRING(defaults.mission, options.mission);
        TEST_ASSERT_EQUAL_STRING(defaults.scenario, options.scenario);
        TEST_ASSERT_EQUAL_STRING(defaults.world, options.world);
        TEST_ASSERT_EQUAL(defaults.is_stepped, options.is_stepped);
        TEST_ASSERT_EQUAL(defaults.has_report, options.has_report);
        TEST_ASSERT_EQUAL_UINT64(defaults.duration_ns, options.duration_ns);
        TEST_ASSERT_EQUAL_UINT16(defaults.port, options.port);
        TEST_ASSERT_EQUAL_UINT16(defaults.delay_ms, options.delay_ms);
        TEST_ASSERT_EQUAL_STRING(defaults.rtos, options.rtos);
        TEST_ASSERT_EQUAL_UINT(0U, options.interface_count + options.sim_interface_count);
    }
}

static void a_name_has_letters_digits_hyphen_and_underscore_only(void)
{
    TEST_ASSERT_TRUE(parse("--mission azAZ09-_ --scenario azAZ09-_ --remote-endian azAZ09-_"));
    for (int character = 1; character < 128; character++) {
        static char name[] = "--mission";
        char value[2]      = {(char)character, '\0'};
        char* words[]      = {name, value};
        const bool is_allowed =
            (strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_", character) != NULL);
        TEST_ASSERT_EQUAL_MESSAGE(is_allowed, launch_options_parse(2, words, &options, error), value);
    }
}

static void a_world_is_that_of_the_mission_unless_it_is_given(void)
{
    TEST_ASSERT_TRUE(parse("--mission classic"));
    TEST_ASSERT_EQUAL_STRING("classic", options.world);
    TEST_ASSERT_TRUE(parse("--world fine --mission classic"));
    TEST_ASSERT_EQUAL_STRING("fine", options.world);
    TEST_ASSERT_TRUE(parse("--world /tmp/w.xml"));
    TEST_ASSERT_EQUAL_STRING("/tmp/w.xml", options.world);
    TEST_ASSERT_TRUE(launch_is_path("w.xml", ".xml") && launch_is_path("a/b", ".xml"));
    TEST_ASSERT_FALSE(launch_is_path(".xml", ".xml") || launch_is_path("w.scn", ".xml"));
    TEST_ASSERT_FALSE(parse("--world w.scn"));
    TEST_ASSERT_NOT_NULL(strstr(error, "--world w.scn: expected a name"));
}

static void a_path_is_limited_in_length(void)
{
    static const struct {
        char* option;
        size_t most; // Characters.
        char* expected;
    } paths[] = {{"--out", LAUNCH_PATH_MAX - 65U, "at most 191 characters"},
                 {"--storage", LAUNCH_PATH_MAX - 65U, "at most 191 characters"},
                 {"--key", LAUNCH_PATH_MAX - 65U, "at most 191 characters"},
                 {"--scenario", LAUNCH_PATH_MAX - 1U, "at most 255 characters"}};
    for (size_t i = 0U; i < (sizeof paths / sizeof paths[0]); i++) {
        char value[LAUNCH_PATH_MAX + 2U] = "";
        char* words[]                    = {paths[i].option, value};
        (void)memset(value, '/', paths[i].most);
        TEST_ASSERT_TRUE_MESSAGE(launch_options_parse(2, words, &options, error), paths[i].option);
        value[paths[i].most] = '/';
        TEST_ASSERT_FALSE_MESSAGE(launch_options_parse(2, words, &options, error), paths[i].option);
        TEST_ASSERT_NOT_NULL(strstr(error, "the path is too long: expected "));
        TEST_ASSERT_NOT_NULL(strstr(error, paths[i].expected));
    }
}

/// Each number has its own bounds, and is accepted at them and refused one beyond.
static void a_number_is_accepted_within_its_bounds_only(void)
{
    static const struct {
        const char* line;
        const char* refusal;
    } refused[] = {
        {"--seed 18446744073709551616", "expected a number, 0 to 18446744073709551615"},
        {"--seed 1:", "expected a number, 0 to 18446744073709551615"},
        {"--seed /1", "expected a number, 0 to 18446744073709551615"},
        {"--port 0", "1 to 65535"},
        {"--port 65536", "1 to 65535"},
        {"--tools 0", "1 to 65535"},
        {"--tools 65536", "1 to 65535"},
        {"--duration 0", "1 to 10000000"},
        {"--duration 10000001", "1 to 10000000"},
    };
    TEST_ASSERT_TRUE(parse("--seed 0"));
    TEST_ASSERT_EQUAL_UINT64(0U, options.seed);
    TEST_ASSERT_TRUE(parse("--seed 18446744073709551615"));
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, options.seed);
    TEST_ASSERT_TRUE(parse("--port 65535 --tools 1 --duration 1"));
    TEST_ASSERT_EQUAL_UINT16(65535U, options.port);
    TEST_ASSERT_EQUAL_UINT16(1U, options.tools);
    TEST_ASSERT_EQUAL_UINT64(1000000000U, options.duration_ns);
    TEST_ASSERT_TRUE(parse("--port 1 --tools 65535 --duration 10000000"));
    for (size_t i = 0U; i < (sizeof refused / sizeof refused[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(parse(refused[i].line), refused[i].line);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, refused[i].refusal), error);
    }
}

/// Only UDP links pass through the relay, and the relay needs simulated time.
static void a_delay_needs_a_scheduler_and_links_by_udp(void)
{
    static const struct {
        const char* line;
        const char* refusal;
    } refused[] = {
        {"--delay 0", "--delay 0: expected the round trip of the links in whole ms, 1 to 1000"},
        {"--delay 1001", "--delay 1001: expected the round trip of the links in whole ms, 1 to 1000"},
        {"--delay 20ms", "--delay 20ms: expected the round trip"},
        {"--delay 20 --links shm", "--delay --links shm: the relay passes UDP frames on; use udp"},
        {"--delay 20 --links tipc", "--delay --links tipc: the relay passes UDP frames on; use udp"},
        {"--delay 20 --time free", "--delay --time free: the relay works in simulated time"},
        {"--delay 20 --bus can --interface robot=can0", "--delay --time real: the relay works in"},
        {"--delay 20 --nodes 2", "--delay --nodes 2 --time stepped: the network between two nodes delays by"},
        {"--delay 20 --remote-endian JOYSTICK", "--delay --remote-endian JOYSTICK: the proxy"},
    };
    TEST_ASSERT_TRUE(parse("--delay 1"));
    TEST_ASSERT_EQUAL_UINT16(1U, options.delay_ms);
    TEST_ASSERT_EQUAL_STRING("udp", options.links);
    TEST_ASSERT_TRUE(parse("--delay 1000 --links udp --form image"));
    TEST_ASSERT_EQUAL_UINT16(1000U, options.delay_ms);
    TEST_ASSERT_TRUE(parse("--delay 20 --time real"));
    TEST_ASSERT_TRUE(parse("--delay 20 --time real --nodes 2"));
    for (size_t i = 0U; i < (sizeof refused / sizeof refused[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(parse(refused[i].line), refused[i].line);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, refused[i].refusal), error);
    }
}

static void each_option_takes_its_value(void)
{
    TEST_ASSERT_TRUE(parse("--mission docking-2 --scenario pick_UP9 --seed 18446744073709551606 --form image "
                           "--duration 10000000"));
    TEST_ASSERT_EQUAL_STRING("docking-2", options.mission);
    TEST_ASSERT_EQUAL_STRING("pick_UP9", options.scenario);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX - 9U, options.seed);
    TEST_ASSERT_TRUE(options.is_image);
    TEST_ASSERT_EQUAL_UINT64(10000000000000000U, options.duration_ns);
    TEST_ASSERT_EQUAL_UINT8(1U, options.computers);
    TEST_ASSERT_TRUE(parse("--form processes --time real --transport udp --links tipc --nodes 2 --port 1 "
                           "--tools 65535"));
    TEST_ASSERT_FALSE(options.is_image || options.is_stepped || options.is_free);
    TEST_ASSERT_EQUAL_STRING("real", launch_time_text(&options));
    TEST_ASSERT_EQUAL_STRING("udp", options.transport);
    TEST_ASSERT_EQUAL_STRING("tipc", options.links);
    TEST_ASSERT_EQUAL_UINT8(2U, options.computers);
    TEST_ASSERT_EQUAL_UINT16(1U, options.port);
    TEST_ASSERT_EQUAL_UINT16(65535U, options.tools);
    TEST_ASSERT_TRUE(parse("--time stepped --nodes 1 --out a/b --storage c/d --report no"));
    TEST_ASSERT_EQUAL_STRING("stepped", launch_time_text(&options));
    TEST_ASSERT_EQUAL_UINT8(1U, options.computers);
    TEST_ASSERT_EQUAL_STRING("a/b", options.output);
    TEST_ASSERT_EQUAL_STRING("c/d", options.storage);
    TEST_ASSERT_FALSE(options.has_report);
    TEST_ASSERT_TRUE(parse("--time free --report yes"));
    TEST_ASSERT_TRUE(options.is_free && options.has_report);
    TEST_ASSERT_EQUAL_STRING("free", launch_time_text(&options));
}

static void a_scenario_is_a_name_or_a_path(void)
{
    static const struct {
        const char* scenario;
        bool is_path;
    } scenarios[] = {{"telepresence", false}, {"", false},          {".scn", false},
                     {"scn", false},          {"abcd", false},      {"a.scn", true},
                     {"long.name.scn", true}, {"a.scn.txt", false}, {"/", true},
                     {"./none", true},        {"x/y", true}};
    for (size_t i = 0U; i < (sizeof scenarios / sizeof scenarios[0]); i++) {
        TEST_ASSERT_EQUAL_MESSAGE(scenarios[i].is_path, launch_is_path(scenarios[i].scenario, ".scn"),
                                  scenarios[i].scenario);
    }
    TEST_ASSERT_TRUE(parse("--scenario x/y.scn"));
    TEST_ASSERT_EQUAL_STRING("x/y.scn", options.scenario);
}

/// A refusal shows the given value, or the beginning of a long value.
static void a_refusal_shows_the_option_and_its_value(void)
{
    TEST_ASSERT_FALSE(parse("--form box"));
    TEST_ASSERT_EQUAL_STRING("--form box: expected processes or image", error);
    TEST_ASSERT_FALSE(parse("--port 65536"));
    TEST_ASSERT_EQUAL_STRING("--port 65536: expected a port number, 1 to 65535", error);
    TEST_ASSERT_FALSE(parse("--mission a.b"));
    TEST_ASSERT_EQUAL_STRING(
        "--mission a.b: expected a name of letters, digits, - and _, without path or ending", error);
    char line[256] = "--form ";
    (void)memset(&line[7], 'k', 200U);
    TEST_ASSERT_FALSE(parse(line));
    const char* const cut = strstr(error, "k...: expected processes or image");
    TEST_ASSERT_NOT_NULL(cut);
    TEST_ASSERT_EQUAL_STRING_LEN("--form k", error, 8U);
    const size_t shown_length = (size_t)(cut - error) + 1U - 7U;
    line[7U + shown_length]   = '\0'; // A value of this length is shown completely.
    TEST_ASSERT_FALSE(parse(line));
    TEST_ASSERT_NULL(strstr(error, "..."));
}

/// The message of a refusal follows the list of the accepted words in memory.
static void the_message_of_an_option_is_not_accepted_as_its_value(void)
{
    static char option[] = "--time";
    static char value[]  = "expected stepped, real or free";
    char* words[]        = {option, value};
    TEST_ASSERT_FALSE(launch_options_parse(2, words, &options, error));
}

static void a_key_is_a_path(void)
{
    TEST_ASSERT_TRUE(parse("--seed 2"));
    TEST_ASSERT_EQUAL_STRING("", options.key);
    TEST_ASSERT_TRUE(parse("--key keys/ground.key"));
    TEST_ASSERT_EQUAL_STRING("keys/ground.key", options.key);
    char line[256] = "--key ";
    (void)memset(&line[6], 'k', 200U);
    TEST_ASSERT_FALSE(parse(line));
    TEST_ASSERT_NOT_NULL(strstr(error, "too long"));
}

static void real_controllers_are_named(void)
{
    TEST_ASSERT_TRUE(parse("--bus can --time real --interface robot=can0 --interface joystick=can1"));
    TEST_ASSERT_EQUAL(LAUNCH_BUS_CAN, options.bus);
    TEST_ASSERT_EQUAL_UINT(2U, options.interface_count);
    TEST_ASSERT_EQUAL_STRING("joystick=can1", options.interfaces[1]);
    TEST_ASSERT_FALSE(launch_has_simulator(&options));
    TEST_ASSERT_TRUE(parse("--bus can --interface robot=can0 --interface joystick=can1"));
    TEST_ASSERT_FALSE_MESSAGE(options.is_stepped, "devices that are not simulated do not wait");
    TEST_ASSERT_TRUE(parse("--bus can --interface robot=can0 --sim-interface robot=can1"));
    TEST_ASSERT_TRUE(options.is_stepped);
    TEST_ASSERT_TRUE(launch_has_simulator(&options));
}

static void a_remote_endian_program_takes_datagrams(void)
{
    TEST_ASSERT_TRUE(parse("--remote-endian MANIPULATOR"));
    TEST_ASSERT_EQUAL_STRING("MANIPULATOR", options.remote_endian);
    TEST_ASSERT_EQUAL_STRING("udp", options.links);
    TEST_ASSERT_EQUAL_STRING("udp", options.transport);
    TEST_ASSERT_TRUE(parse("--links shm"));
    TEST_ASSERT_EQUAL_STRING("", options.remote_endian);
}

static void wrong_and_contradictory_options_are_refused_with_the_reason(void)
{
    static const struct {
        const char* line;
        const char* reported;
    } cases[] = {
        {"--bus can0", "expected shm, vcan or can"},
        {"--bus can", "name flight's controllers"},
        {"--bus can --sim-interface robot=can1", "name flight's controllers"},
        {"--bus can --time stepped --interface robot=can0", "use --time real"},
        {"--bus can --interface robot", "expected BUS=INTERFACE"},
        {"--bus can --interface =can0", "expected BUS=INTERFACE"},
        {"--bus can --interface robot=", "expected BUS=INTERFACE"},
        {"--bus vcan --interface robot=can0", "use --bus can"},
        {"--interface robot=can0", "use --bus can"},
        {"--bus can --interface robot=can0 --interface joystick=can1 --sim-interface robot=can2",
         "or on no bus"},
        {"--bus can --time real --interface robot=can0 --tools 29536", "this run has no simulator"},
        {"--bus vcan --nodes 2", "one network namespace"},
        {"--scenario", "--scenario: expected a known option with its value; see hirosco run --help"},
        {"--seed 1 --port", "--port: expected a known option with its value"},
        {"--scenario none", "would never end"},
        {"--form image --tools 1", "a process of its own"},
        {"--form image --nodes 2", "one on-board computer"},
        {"--form image --transport udp", "in memory"},
        {"--form image --time real", "has no real-time mode"},
        {"--links tcp", "expected shm, udp or tipc"},
        {"--nodes 3", "expected 1 or 2"},
        {"--report maybe", "expected yes or no"},
        {"--remote-endian ../x", "name of a subsystem"},
        {"--mission x/y", "without path or ending"},
        {"--scenario a.b", "or a path with / or the usual ending"},
        {"--world a.b", "or a path with / or the usual ending"},
        {"--delay 20 --rtos ARM", "omit --delay"},
        {"--rtos ARM --links shm", "shares no memory"},
        {"--unknown 1", "unknown option"},
        {"--remote-endian MANIPULATOR --form image", "needs a process of its own"},
        {"--remote-endian MANIPULATOR --time real", "keeps no deadline"},
        {"--remote-endian MANIPULATOR --time free", "keeps no deadline"},
        {"--form image --time free", "has no real-time mode"},
        {"--time free --nodes 2", "use --nodes 1"},
        {"--remote-endian MANIPULATOR --links shm", "use udp"},
        {"--remote-endian MANIPULATOR --links tipc", "use udp"},
        {"--remote-endian MANIPULATOR --transport tipc", "use udp"},
        {"--remote-endian MANIPULATOR --bus vcan", "use --bus shm"},
        {"--remote-endian MANIPULATOR --bus can --interface robot=can0", "use --bus shm"},
        {"--remote-endian MANIPULATOR --nodes 2", "use --nodes 1"},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_FALSE_MESSAGE(parse(cases[i].line), cases[i].line);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error, cases[i].reported), error);
    }
}

static void meaningful_combinations_are_accepted(void)
{
    static const char* const lines[] = {
        "--scenario none --duration 1",
        "--scenario none --time real",
        "--scenario none --time free",
        "--nodes 2",
        "--nodes 2 --time real",
        "--bus vcan --nodes 1",
        "--form image --nodes 1",
        "--bus can --interface robot=can0 --sim-interface robot=can1 --tools 1",
        "--bus can --interface r=c",
        "--remote-endian ARM --links udp --transport udp",
        "--time free --nodes 1"};
    for (size_t i = 0U; i < (sizeof lines / sizeof lines[0]); i++) {
        TEST_ASSERT_FALSE(parse("--unknown 1"));
        TEST_ASSERT_TRUE_MESSAGE(parse(lines[i]), lines[i]);
        TEST_ASSERT_EQUAL_STRING("", error); // The earlier error text is cleared.
    }
}

static void more_interfaces_than_buses_are_refused(void)
{
    char* words[2 * (LAUNCH_INTERFACES_MAX + 1)];
    for (size_t i = 0U; i <= LAUNCH_INTERFACES_MAX; i++) {
        static char option[] = "--interface";
        static char value[]  = "robot=can0";
        words[2U * i]        = option;
        words[(2U * i) + 1U] = value;
    }
    TEST_ASSERT_FALSE(launch_options_parse(2 * ((int)LAUNCH_INTERFACES_MAX + 1), words, &options, error));
    TEST_ASSERT_EQUAL_UINT((unsigned)LAUNCH_INTERFACES_MAX, options.interface_count);
    TEST_ASSERT_NOT_NULL(
        strstr(error, "more interfaces than a mission can have buses; give one for each bus"));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_bus_is_shared_memory_unless_another_kind_is_given);
    RUN_TEST(options_that_are_not_given_have_their_defaults);
    RUN_TEST(an_empty_value_counts_as_not_given);
    RUN_TEST(a_name_has_letters_digits_hyphen_and_underscore_only);
    RUN_TEST(a_world_is_that_of_the_mission_unless_it_is_given);
    RUN_TEST(a_path_is_limited_in_length);
    RUN_TEST(a_number_is_accepted_within_its_bounds_only);
    RUN_TEST(a_delay_needs_a_scheduler_and_links_by_udp);
    RUN_TEST(each_option_takes_its_value);
    RUN_TEST(a_scenario_is_a_name_or_a_path);
    RUN_TEST(a_refusal_shows_the_option_and_its_value);
    RUN_TEST(the_message_of_an_option_is_not_accepted_as_its_value);
    RUN_TEST(a_key_is_a_path);
    RUN_TEST(real_controllers_are_named);
    RUN_TEST(a_remote_endian_program_takes_datagrams);
    RUN_TEST(wrong_and_contradictory_options_are_refused_with_the_reason);
    RUN_TEST(meaningful_combinations_are_accepted);
    RUN_TEST(more_interfaces_than_buses_are_refused);
    return UNITY_END();
}
