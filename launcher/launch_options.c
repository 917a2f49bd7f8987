// SPDX-License-Identifier: Apache-2.0
#include "launcher/launch_options.h"

#include "base/assertion.h"
#include "base/number.h"
#include "base/text.h"

#include <string.h>

#define WORDS_MAX 3U
#define NS_PER_S 1000000000ULL
/// Largest number of characters of a wrong value in an error message, so that the reason fits, too.
#define SHOWN_MAX 120U

const char* launch_options_help(void)
{
    return "usage: hirosco run [--OPTION VALUE ...]\n"
           "  --mission NAME     descriptors/missions/NAME.xml (default rokviss)\n"
           "  --scenario NAME    sim/scenarios/NAME.scn, or a path to another file (default: the\n"
           "                     mission's name, or else telepresence); none: fly until Ctrl-C\n"
           "  --world NAME       descriptors/worlds/NAME.xml, or a path to another file (default: the "
           "mission's\n"
           "                     name)\n"
           "  --seed N           seed of sensor noise and faults (default 1)\n"
           "  --form processes|image   a process per subsystem (default), or all in one program\n"
           "  --time stepped|real|free   discrete time; the same paced by the wall clock; or every "
           "process\n"
           "                     with its own clock, as on a spacecraft (default: stepped; without "
           "simulator\n"
           "                     real, which is then the same as free)\n"
           "  --bus shm|vcan|can carrier of the CAN buses: shared memory (default); virtual interfaces\n"
           "                     vcan-BUS, where candump and other tools attach; or real controllers:\n"
           "  --interface BUS=INTERFACE      with --bus can: flight's controller, e.g. robot=can0\n"
           "  --sim-interface BUS=INTERFACE  the simulator's controller on the same wires\n"
           "  --transport udp|tipc     carrier of messages between processes (default: the mission's)\n"
           "  --links shm|udp|tipc     transfer method of real-time links (default: the mission's)\n"
           "  --delay MS         round trip of the links between subsystems, 1 to 1000: a relay delays their "
           "frames\n"
           "                     (jitter 10 %, loss 5 %, drawn from the seed; default: no relay); with "
           "--nodes 2\n"
           "                     --time real, a network between the nodes (netem) delays them\n"
           "  --nodes 1|2        on-board computers that the processes are spread over (default 1)\n"
           "  --remote-endian SUBSYSTEM\n"
           "                     its program runs big-endian: built for s390x (make remote-endian),\n"
           "                     in qemu-s390x\n"
           "  --rtos SUBSYSTEM[:BOARD],...\n"
           "                     their programs run on FreeRTOS (make rtos), on a board that\n"
           "                     qemu-system-arm emulates: mps2-an500 (default) or mps2-an385\n"
           "  --port N           ground port on 127.0.0.1 (default: the first free from the mission's)\n"
           "  --tools N          serve bus tools on 127.0.0.1 at this port (socketcand; python-can, "
           "SavvyCAN)\n"
           "  --out DIRECTORY       directory of the logs of the run (default: a new one under runs/)\n"
           "  --storage DIRECTORY   persistent data: schedules, definitions, stores, files; a run continues "
           "the "
           "data\n"
           "                     of an earlier run (default: DIRECTORY/storage of --out)\n"
           "  --key FILE         accept only telecommands protected with this key (`gse key make "
           "FILE`;\n"
           "                     default: that of the mission, if it has one)\n"
           "  --duration S       shut the mission down after S simulated seconds\n"
           "  --report yes|no    draw the report at the end (default yes)";
}

static bool fail(char error[LAUNCH_ERROR_MAX], const char* const option, const char* const value,
                 const char* const expected)
{
    text_t text = text_in(error, LAUNCH_ERROR_MAX);
    text_add(&text, option);
    text_add(&text, (value[0] != '\0') ? " " : "");
    for (size_t i = 0U; (i < SHOWN_MAX) && (value[i] != '\0'); i++) {
        text_add_character(&text, value[i]);
    }
    text_add(&text, (strlen(value) > SHOWN_MAX) ? "...: " : ": ");
    text_add(&text, expected);
    return false;
}

static bool is_word(const char* const value, const char* const word)
{
    return strcmp(value, word) == 0;
}

static bool is_name(const char* const text)
{
    for (const char* next = text; *next != '\0'; next++) {
        const bool is_letter = ((*next >= 'a') && (*next <= 'z')) || ((*next >= 'A') && (*next <= 'Z')) ||
                               ((*next >= '0') && (*next <= '9')) || (*next == '-') || (*next == '_');
        if (!is_letter) {
            return false;
        }
    }
    return true;
}

bool launch_is_path(const char* const text, const char* const ending)
{
    const size_t length = strlen(text);
    const size_t end    = strlen(ending);
    return (strchr(text, '/') != NULL) || ((length > end) && (strcmp(&text[length - end], ending) == 0));
}

/// Options whose value is a number.
static const struct {
    const char* option;
    uint64_t least;
    uint64_t most;
    const char* expected;
} numbers[] = {
    {"--seed", 0U, UINT64_MAX, "expected a number, 0 to 18446744073709551615"},
    {"--port", 1U, UINT16_MAX, "expected a port number, 1 to 65535"},
    {"--delay", 1U, 1000U, "expected the round trip of the links in whole ms, 1 to 1000"},
    {"--tools", 1U, UINT16_MAX, "expected a port number, 1 to 65535"},
    {"--duration", 1U, 10000000U, "expected whole seconds, 1 to 10000000"},
};

#define NUMBERS (sizeof numbers / sizeof numbers[0])

static bool take_number(launch_options_t* const options, const size_t which, const char* const value,
                        char error[LAUNCH_ERROR_MAX])
{
    const char* const option = numbers[which].option;
    const char* rest         = value;
    uint64_t number          = 0U;
    if ((number_read_unsigned(&rest, &number) != STATUS_OK) || !number_is_end(rest) ||
        (number < numbers[which].least) || (number > numbers[which].most)) {
        return fail(error, option, value, numbers[which].expected);
    }
    if (is_word(option, "--seed")) {
        options->seed = number;
    } else if (is_word(option, "--duration")) {
        options->duration_ns = number * NS_PER_S;
    } else if (is_word(option, "--delay")) {
        options->delay_ms = (uint16_t)number;
    } else {
        *(is_word(option, "--port") ? &options->port : &options->tools) = (uint16_t)number;
    }
    return true;
}

/// Options that take one of a few words.
static const struct {
    const char* option;
    const char* words[WORDS_MAX];
    const char* expected;
} choices[] = {
    {"--form", {"processes", "image"}, "expected processes or image"},
    {"--time", {"stepped", "real", "free"}, "expected stepped, real or free"},
    {"--bus", {"shm", "vcan", "can"}, "expected shm, vcan or can"},
    {"--transport", {"udp", "tipc"}, "expected udp or tipc"},
    {"--links", {"shm", "udp", "tipc"}, "expected shm, udp or tipc"},
    {"--nodes", {"1", "2"}, "expected 1 or 2 on-board computers (network namespaces joined by a veth)"},
    {"--report", {"yes", "no"}, "expected yes or no"},
};

#define CHOICES (sizeof choices / sizeof choices[0])

static size_t choice_of(const char* const option)
{
    size_t choice = 0U;
    while ((choice < CHOICES) && !is_word(option, choices[choice].option)) {
        choice++;
    }
    return choice;
}

static void keep_word(launch_options_t* const options, const char* const option, const char* const value)
{
    if (is_word(option, "--form")) {
        options->is_image = is_word(value, "image");
    } else if (is_word(option, "--time")) {
        options->is_stepped = is_word(value, "stepped");
        options->is_free    = is_word(value, "free");
    } else if (is_word(option, "--bus")) {
        options->bus = is_word(value, "vcan") ? LAUNCH_BUS_VCAN : LAUNCH_BUS_SHM;
        options->bus = is_word(value, "can") ? LAUNCH_BUS_CAN : options->bus;
    } else if (is_word(option, "--transport")) {
        options->transport = value;
    } else if (is_word(option, "--links")) {
        options->links = value;
    } else if (is_word(option, "--nodes")) {
        options->computers = is_word(value, "2") ? 2U : 1U;
    } else {
        options->has_report = is_word(value, "yes");
    }
}

static bool take_word(launch_options_t* const options, const size_t choice, const char* const value,
                      char error[LAUNCH_ERROR_MAX])
{
    for (size_t i = 0U; (i < WORDS_MAX) && (choices[choice].words[i] != NULL); i++) {
        if (is_word(value, choices[choice].words[i])) {
            keep_word(options, choices[choice].option, value);
            return true;
        }
    }
    return fail(error, choices[choice].option, value, choices[choice].expected);
}

/// Read the name of a mission, scenario or world. An empty value keeps the default.
static bool take_name(launch_options_t* const options, const char* const option, const char* const value,
                      char error[LAUNCH_ERROR_MAX])
{
    const bool is_scenario = is_word(option, "--scenario");
    const bool is_world    = is_word(option, "--world");
    const bool may_be_path = is_scenario || is_world;
    const bool is_path     = may_be_path && launch_is_path(value, is_world ? ".xml" : ".scn");
    if (is_path && (strlen(value) >= LAUNCH_PATH_MAX)) {
        return fail(error, option, value, "the path is too long: expected at most 255 characters");
    }
    if (!is_path && !is_name(value)) {
        return fail(error, option, value,
                    may_be_path
                        ? "expected a name of letters, digits, - and _, or a path with / or the usual ending"
                        : "expected a name of letters, digits, - and _, without path or ending");
    }
    if ((value[0] != '\0') && is_world) {
        options->world = value;
    } else if (value[0] != '\0') {
        *(is_scenario ? &options->scenario : &options->mission) = value;
    } else {
        // The value is empty: keep the default.
    }
    return true;
}

/// Read "BUS=INTERFACE"; the option may be given several times.
static bool take_interface(launch_options_t* const options, const char* const option, const char* const value,
                           char error[LAUNCH_ERROR_MAX])
{
    const bool is_flight     = (strcmp(option, "--interface") == 0);
    const char** const list  = is_flight ? options->interfaces : options->sim_interfaces;
    size_t* const count      = is_flight ? &options->interface_count : &options->sim_interface_count;
    const char* const equals = strchr(value, '=');
    if (value[0] == '\0') {
        return true;
    }
    if ((equals == NULL) || (equals == value) || (equals[1] == '\0')) {
        return fail(error, option, value, "expected BUS=INTERFACE, for example robot=can0");
    }
    if (*count == LAUNCH_INTERFACES_MAX) {
        return fail(error, option, value,
                    "there are more interfaces than a mission can have buses; give one for each bus");
    }
    list[*count] = value;
    (*count)++;
    return true;
}

static bool take_path(launch_options_t* const options, const char* const option, const char* const value,
                      char error[LAUNCH_ERROR_MAX])
{
    if (is_word(option, "--key")) {
        options->key = value;
    } else {
        *(is_word(option, "--out") ? &options->output : &options->storage) = value;
    }
    // Names of files in the directory are appended to the path.
    return (strlen(value) < (LAUNCH_PATH_MAX - 64U)) ||
           fail(error, option, value, "the path is too long: expected at most 191 characters");
}

/// Check "SUBSYSTEM[:BOARD],...".
static bool take_rtos(launch_options_t* const options, const char* const value, char error[LAUNCH_ERROR_MAX])
{
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_,:";
    options->rtos               = value;
    return (value[strspn(value, allowed)] == '\0') ||
           fail(error, "--rtos", value,
                "expected names of subsystems of the mission with commas, each with :BOARD or without");
}

static bool is_file_name(const char* const option)
{
    return is_word(option, "--mission") || is_word(option, "--scenario") || is_word(option, "--world");
}

/// Read the value of one option. An empty value keeps the default.
static bool take(launch_options_t* const options, const char* const option, const char* const value,
                 char error[LAUNCH_ERROR_MAX])
{
    const size_t choice = choice_of(option);
    for (size_t i = 0U; i < NUMBERS; i++) {
        if (is_word(option, numbers[i].option)) {
            return (value[0] == '\0') || take_number(options, i, value, error);
        }
    }
    if (choice < CHOICES) {
        return (value[0] == '\0') || take_word(options, choice, value, error);
    }
    if (is_file_name(option)) {
        return take_name(options, option, value, error);
    }
    if (is_word(option, "--interface") || is_word(option, "--sim-interface")) {
        return take_interface(options, option, value, error);
    }
    if (strcmp(option, "--remote-endian") == 0) {
        options->remote_endian = value;
        return is_name(value) ||
               fail(error, option, value, "expected the name of a subsystem of the mission");
    }
    if (strcmp(option, "--rtos") == 0) {
        return take_rtos(options, value, error);
    }
    if (is_word(option, "--out") || is_word(option, "--storage") || is_word(option, "--key")) {
        return take_path(options, option, value, error);
    }
    return fail(error, option, value, "unknown option; see hirosco run --help");
}

const char* launch_time_text(const launch_options_t* const options)
{
    FSW_ASSERT(options != NULL);
    const char* const real = options->is_free ? "free" : "real";
    return options->is_stepped ? "stepped" : real;
}

bool launch_has_scheduler(const launch_options_t* const options)
{
    return launch_has_simulator(options) && !options->is_free;
}

bool launch_has_simulator(const launch_options_t* const options)
{
    FSW_ASSERT(options != NULL);
    return (options->bus != LAUNCH_BUS_CAN) || (options->sim_interface_count > 0U);
}

const char* launch_bus_text(const launch_bus_t bus)
{
    static const char* const texts[] = {"shm", "vcan", "can"};
    FSW_ASSERT((size_t)bus < (sizeof texts / sizeof texts[0]));
    return texts[bus];
}

static bool are_interfaces_sensible(const launch_options_t* const options, char error[LAUNCH_ERROR_MAX])
{
    const size_t count = options->interface_count;
    if ((options->bus != LAUNCH_BUS_CAN) && ((count + options->sim_interface_count) > 0U)) {
        return fail(error, "--bus", launch_bus_text(options->bus),
                    "interfaces are named for real controllers only; use --bus can");
    }
    if ((options->bus == LAUNCH_BUS_CAN) && (count == 0U)) {
        return fail(error, "--bus", "can",
                    "name flight's controllers, for example --interface robot=can0 --interface joystick=can1 "
                    "(make sim-run BUS=can ROBOT_IF=can0 JOYSTICK_IF=can1)");
    }
    if ((options->sim_interface_count > 0U) && (options->sim_interface_count != count)) {
        return fail(error, "--sim-interface", options->sim_interfaces[0],
                    "the simulator needs a controller on each bus on which flight has one, or on no bus");
    }
    if (!launch_has_simulator(options) && (options->tools != 0U)) {
        return fail(error, "--bus can", "--tools",
                    "the simulator serves bus tools, and this run has no simulator; attach them to the "
                    "interface (candump can0)");
    }
    if (!launch_has_simulator(options) && options->is_stepped) {
        return fail(error, "--bus can", "--time stepped",
                    "devices that are not simulated do not wait; use --time real, or name the simulator's "
                    "controllers (--sim-interface)");
    }
    return true;
}

/// Check the options of a run with a program for another processor, which shares no memory with the rest of
/// the run; `option` is the one that selects this program. If --links or --transport is not given, UDP is
/// chosen.
static bool is_remote_sensible(launch_options_t* const options, const char* const option,
                               char error[LAUNCH_ERROR_MAX])
{
    char with[48];
    options->links     = (options->links[0] == '\0') ? "udp" : options->links;
    options->transport = (options->transport[0] == '\0') ? "udp" : options->transport;
    if (options->is_image) {
        return fail(error, option, "--form image",
                    "a program for another processor needs a process of its own; use --form processes");
    }
    if (strcmp(options->links, "udp") != 0) {
        (void)text_join(with, sizeof with, (const char* const[]){option, " --links", NULL});
        return fail(error, with, options->links,
                    "its program shares no memory with the run and has no TIPC; use udp");
    }
    if (strcmp(options->transport, "udp") != 0) {
        (void)text_join(with, sizeof with, (const char* const[]){option, " --transport", NULL});
        return fail(error, with, options->transport, "an emulated processor has no TIPC; use udp");
    }
    if (options->bus != LAUNCH_BUS_SHM) {
        (void)text_join(with, sizeof with, (const char* const[]){option, " --bus", NULL});
        return fail(error, with, launch_bus_text(options->bus),
                    "its proxy forwards frames, but not the status of a controller; use --bus shm");
    }
    if (!options->is_stepped) {
        (void)text_join(with, sizeof with, (const char* const[]){option, " --time", NULL});
        return fail(error, with, options->is_free ? "free" : "real",
                    "its proxy works in stepped time, and an emulated processor keeps no deadline; use "
                    "--time stepped");
    }
    return (options->computers == 1U) ||
           fail(error, option, "--nodes 2",
                "a proxy and its program run on one on-board computer; use --nodes 1");
}

static bool are_remotes_sensible(launch_options_t* const options, char error[LAUNCH_ERROR_MAX])
{
    return ((options->remote_endian[0] == '\0') || is_remote_sensible(options, "--remote-endian", error)) &&
           ((options->rtos[0] == '\0') || is_remote_sensible(options, "--rtos", error));
}

/// Check the options of a run whose links have a delay: the relay needs UDP and a scheduler. If --links is
/// not given, UDP is chosen.
static bool is_delay_sensible(launch_options_t* const options, char error[LAUNCH_ERROR_MAX])
{
    if (options->delay_ms == 0U) {
        return true;
    }
    options->links = (options->links[0] == '\0') ? "udp" : options->links;
    if (strcmp(options->links, "udp") != 0) {
        return fail(error, "--delay --links", options->links, "the relay passes UDP frames on; use udp");
    }
    if (!launch_has_scheduler(options)) {
        return fail(error, "--delay --time", launch_time_text(options),
                    "the relay works in simulated time, and this run has no scheduler; use --time stepped or "
                    "real, with a simulator");
    }
    if ((options->computers > 1U) && options->is_stepped) {
        return fail(error, "--delay --nodes 2 --time", "stepped",
                    "the network between two nodes delays by wall-clock time; use --time real, or --nodes 1 "
                    "for a relay in simulated time");
    }
    if (options->rtos[0] != '\0') {
        return fail(error, "--delay --rtos", options->rtos,
                    "the proxy of such a program does not announce its frames to the relay; omit --delay");
    }
    return (options->remote_endian[0] == '\0') ||
           fail(error, "--delay --remote-endian", options->remote_endian,
                "the proxy of such a program does not announce its frames to the relay; omit --delay");
}

static bool is_image_sensible(const launch_options_t* const options, char error[LAUNCH_ERROR_MAX])
{
    if (!options->is_image) {
        return true;
    }
    if (!options->is_stepped) {
        return fail(error, "--form image --time", options->is_free ? "free" : "real",
                    "--form image has no real-time mode; use --form processes");
    }
    if (options->tools != 0U) {
        return fail(error, "--form image", "--tools",
                    "bus tools need a simulator in a process of its own; use --form processes");
    }
    if (options->computers > 1U) {
        return fail(error, "--form image", "--nodes 2",
                    "the image is one program and runs on one on-board computer; use --form processes");
    }
    return (options->transport[0] == '\0') ||
           fail(error, "--form image --transport", options->transport,
                "the components of the image exchange messages in memory; use --form processes");
}

/// Check the combinations of options. If one is impossible, the error text contains the reason.
static bool is_sensible(const launch_options_t* const options, char error[LAUNCH_ERROR_MAX])
{
    if (!is_image_sensible(options, error)) {
        return false;
    }
    if ((options->computers > 1U) && (options->bus != LAUNCH_BUS_SHM)) {
        return fail(
            error, "--nodes 2 --bus", launch_bus_text(options->bus),
            "a CAN interface belongs to one network namespace, and each computer has a namespace of its "
            "own; use --bus shm");
    }
    if (options->is_free && (options->computers > 1U)) {
        return fail(error, "--time free", "--nodes 2",
                    "the simulator's buses are in the memory of one on-board computer; use --nodes 1");
    }
    if (!are_interfaces_sensible(options, error)) {
        return false;
    }
    const bool is_endless = (strcmp(options->scenario, "none") == 0) && (options->duration_ns == 0U);
    if (options->is_stepped && is_endless) {
        return fail(error, "--scenario none", "--time stepped",
                    "the flight would never end; use --time real (Ctrl-C ends it) or give --duration");
    }
    return true;
}

bool launch_options_parse(const int argument_count, char* const arguments[],
                          launch_options_t* const out_options, char error[LAUNCH_ERROR_MAX])
{
    FSW_ASSERT((arguments != NULL) && (out_options != NULL) && (error != NULL));
    *out_options       = (launch_options_t){.mission       = "rokviss",
                                            .scenario      = "",
                                            .world         = "",
                                            .seed          = 1U,
                                            .is_stepped    = true,
                                            .transport     = "",
                                            .links         = "",
                                            .computers     = 1U,
                                            .output        = "",
                                            .storage       = "",
                                            .key           = "",
                                            .remote_endian = "",
                                            .rtos          = "",
                                            .has_report    = true};
    error[0]           = '\0';
    bool is_time_given = false;
    for (int i = 0; i < argument_count; i += 2) {
        if ((i + 1) == argument_count) {
            return fail(error, arguments[i], "",
                        "expected a known option with its value; see hirosco run --help");
        }
        if (!take(out_options, arguments[i], arguments[i + 1], error)) {
            return false;
        }
        is_time_given = is_time_given || (is_word(arguments[i], "--time") && (arguments[i + 1][0] != '\0'));
    }
    if (out_options->world[0] == '\0') {
        out_options->world = out_options->mission;
    }
    if (!is_time_given) { // With real devices the default is real time.
        out_options->is_stepped = launch_has_simulator(out_options);
    }
    // The first two checks choose defaults, which the last one also checks.
    return are_remotes_sensible(out_options, error) && is_delay_sensible(out_options, error) &&
           is_sensible(out_options, error);
}
