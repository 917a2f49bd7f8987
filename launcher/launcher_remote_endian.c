// SPDX-License-Identifier: Apache-2.0
// Support of subsystems whose programs are for another processor: one of another byte order, or a board with
// a real-time operating system. An emulator runs each program, and a native proxy connects it with the run.
#include "launcher/launcher_internal.h"

#include "base/assertion.h"
#include "base/text.h"
#include "fsw/framework/message/message.h"
#include "osal/include/osal/file.h"

#include <string.h>

typedef struct {
    const char* option;
    const char* runner;
    const char* package;   ///< Debian package that contains the emulator.
    const char* directory; ///< Directory of the programs for this processor.
    const char* target;    ///< Command that builds these programs.
    /// Name of the emulated board; null: the program is a process of another byte order.
    const char* board;
} processor_t;

static const processor_t big_endian = {"--remote-endian: ", "/usr/bin/qemu-s390x", "qemu-user",
                                       "build/s390x/bin/",  "make remote-endian",  NULL};
// The first board is the default of the option.
static const processor_t boards[] = {{"--rtos: ", "/usr/bin/qemu-system-arm", "qemu-system-arm",
                                      "build/mps2-an500/bin/", "make rtos", "mps2-an500"},
                                     {"--rtos: ", "/usr/bin/qemu-system-arm", "qemu-system-arm",
                                      "build/mps2-an385/bin/", "make rtos BOARD=mps2-an385", "mps2-an385"}};
#define BOARDS (sizeof boards / sizeof boards[0])

/// One part of `--rtos`, "SUBSYSTEM[:BOARD]".
typedef struct {
    const char* name;
    size_t name_length;
    const char* board;
    size_t board_length;
} choice_t;

/// Take the next part of the list and move *list after it. False: the list has ended.
static bool next_choice(const char** const list, choice_t* const out_choice)
{
    const char* const text = *list;
    const size_t length    = strcspn(text, ",");
    const size_t name      = strcspn(text, ",:");
    if (text[0] == '\0') {
        return false;
    }
    *out_choice = (choice_t){text, name, &text[name], 0U};
    if (name < length) {
        out_choice->board        = &text[name + 1U];
        out_choice->board_length = length - name - 1U;
    }
    *list = (text[length] == ',') ? &text[length + 1U] : &text[length];
    return true;
}

static bool is_same(const char* const name, const char* const text, const size_t length)
{
    return (strlen(name) == length) && (strncmp(name, text, length) == 0);
}

/// Returns the board of a choice, or null if there is no such board.
static const processor_t* board_of(const choice_t* const choice)
{
    for (size_t i = 0U; i < BOARDS; i++) {
        if ((choice->board_length == 0U) || is_same(boards[i].board, choice->board, choice->board_length)) {
            return &boards[i];
        }
    }
    return NULL;
}

/// Returns the processor of a component's program, or null if the program is native.
static const processor_t* processor_of(const launcher_t* const launcher, const unsigned component)
{
    const char* const name = launcher->mission.subsystems[component].name;
    const char* list       = launcher->options.rtos;
    choice_t choice;
    if (strcmp(name, launcher->options.remote_endian) == 0) {
        return &big_endian;
    }
    while (next_choice(&list, &choice)) {
        if (is_same(name, choice.name, choice.name_length)) {
            return board_of(&choice);
        }
    }
    return NULL;
}

bool launcher_has_proxy(const launcher_t* const launcher, const unsigned component)
{
    return processor_of(launcher, component) != NULL;
}

uint32_t launcher_message_window(const launcher_t* const launcher, const unsigned component)
{
    const processor_t* const processor = processor_of(launcher, component);
    return ((processor != NULL) && (processor->board != NULL)) ? MESSAGE_SMALL_WINDOW_OCTETS
                                                               : MESSAGE_WINDOW_OCTETS;
}

/// Refuse the run; the reason consists of the three texts. Returns false.
static bool refuse(launcher_t* const launcher, const char* const option, const char* const what,
                   const char* const detail)
{
    char line[LAUNCH_PATH_MAX];
    (void)text_join(line, sizeof line, (const char* const[]){option, what, NULL});
    return launcher_fail(launcher, line, detail);
}

/// Check that the component may use a program for this processor, and that program and emulator exist.
static bool check(launcher_t* const launcher, const processor_t* const processor, const unsigned component)
{
    char program[LAUNCH_PATH_MAX];
    char what[LAUNCH_PATH_MAX];
    const mission_subsystem_t* const subsystem = &launcher->mission.subsystems[component];
    if ((subsystem->apid == SUPERVISOR_APID) || (subsystem->apid == COMMUNICATION_APID)) {
        return refuse(launcher, processor->option,
                      "the launcher and the operator reach this subsystem in shared memory; choose one that "
                      "drives devices: ",
                      subsystem->name);
    }
    (void)text_join(program, sizeof program,
                    (const char* const[]){processor->directory, subsystem->executable, NULL});
    if (!osal_file_exists(program)) {
        (void)text_join(
            what, sizeof what,
            (const char* const[]){"there is no such program (", processor->target, " builds it): ", NULL});
        return refuse(launcher, processor->option, what, program);
    }
    if (!osal_file_exists(processor->runner)) {
        (void)text_join(what, sizeof what,
                        (const char* const[]){"install the package ", processor->package,
                                              " (make setup does); there is no ", NULL});
        return refuse(launcher, processor->option, what, processor->runner);
    }
    return true;
}

/// Returns the index of the subsystem of that name, or the number of subsystems if there is none.
static unsigned find(const launcher_t* const launcher, const char* const name, const size_t length)
{
    unsigned component = 0U;
    while ((component < launcher->mission.subsystem_count) &&
           !is_same(launcher->mission.subsystems[component].name, name, length)) {
        component++;
    }
    return component;
}

/// Check one subsystem that an option names; `value` is the text of the option. `processor` null: there is no
/// such board.
static bool check_name(launcher_t* const launcher, const processor_t* const processor, const char* const name,
                       const size_t length, const char* const value)
{
    const unsigned component = find(launcher, name, length);
    if (processor == NULL) {
        return refuse(launcher, boards[0].option,
                      "there is no such board; there are mps2-an500, mps2-an385: ", value);
    }
    if (component == launcher->mission.subsystem_count) {
        return refuse(launcher, processor->option,
                      "the mission has no such subsystem (its file lists them in <Subsystems>): ", value);
    }
    if ((processor != &big_endian) &&
        (strcmp(launcher->mission.subsystems[component].name, launcher->options.remote_endian) == 0)) {
        return refuse(launcher, processor->option,
                      "--remote-endian names this subsystem, too; omit one of the options: ", value);
    }
    return check(launcher, processor, component);
}

/// Check each part of `--rtos`.
static bool check_boards(launcher_t* const launcher)
{
    const char* const value                = launcher->options.rtos;
    const char* list                       = value;
    bool is_listed[MISSION_SUBSYSTEMS_MAX] = {false};
    choice_t choice;
    while (next_choice(&list, &choice)) {
        if (!check_name(launcher, board_of(&choice), choice.name, choice.name_length, value)) {
            return false;
        }
        bool* const is_again = &is_listed[find(launcher, choice.name, choice.name_length)];
        if (*is_again) {
            return refuse(launcher, boards[0].option, "a subsystem is listed twice; list each once: ", value);
        }
        *is_again = true;
    }
    return true;
}

bool launcher_check_remote_endian(launcher_t* const launcher)
{
    const char* const name = launcher->options.remote_endian;
    return ((name[0] == '\0') || check_name(launcher, &big_endian, name, strlen(name), name)) &&
           check_boards(launcher);
}

void launcher_add_component(const launcher_t* const launcher, const unsigned component,
                            arguments_t* const arguments)
{
    const char* const executable       = launcher->mission.subsystems[component].executable;
    const processor_t* const processor = processor_of(launcher, component);
    char name[RUN_NAME_MAX];
    FSW_ASSERT(run_name(launcher->run, "run", 0U, name, sizeof name));
    arguments_add_joined(arguments, launcher->program_directory, (processor != NULL) ? "proxy" : executable);
    arguments_add_option(arguments, "--run", name);
    arguments_add_number(arguments, "--component", component);
    if (processor == NULL) {
        return;
    }
    arguments_add(arguments, "--program");
    arguments_add_joined(arguments, processor->directory, executable);
    arguments_add_option(arguments, "--runner", processor->runner);
    if (processor->board != NULL) {
        arguments_add_option(arguments, "--board", processor->board);
    }
}
