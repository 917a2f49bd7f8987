// SPDX-License-Identifier: Apache-2.0
// `hirosco run`: fly a mission. Exit codes: 0: flown to the end without a failure; 1: a failure; 2: wrong
// usage.
#include "launcher/launcher_guard.h"
#include "launcher/launcher_internal.h"
#include "base/text.h"
#include "osal/include/osal/console.h"

#include <string.h>

static launcher_t launcher;

static int report_error(const char* const what)
{
    char line[LAUNCHER_REASON_MAX + 16U];
    (void)text_join(line, sizeof line, (const char* const[]){"hirosco: ", what, NULL});
    osal_console_print_error(line);
    return 2;
}

/// Returns the directory of this program, which also contains the other programs, with a slash at the end.
static const char* directory_of(const char* const path)
{
    static char directory[LAUNCH_PATH_MAX];
    const char* const slash = strrchr(path, '/');
    text_t text             = text_in(directory, sizeof directory);
    for (const char* next = path; (slash != NULL) && (next <= slash); next++) {
        text_add_character(&text, *next);
    }
    return directory;
}

static void announce(void)
{
    char line[LAUNCH_PATH_MAX + 128U];
    text_t text = text_in(line, sizeof line);
    text_add_words(&text, (const char* const[]){
                              "mission ", launcher.mission.name, ", scenario ", launcher.options.scenario,
                              launcher.options.is_image ? ", one image, " : ", processes, ",
                              launch_time_text(&launcher.options), " time, ground port ",
                              (launcher.mission.is_ground_open != 0U) ? "0.0.0.0:" : "127.0.0.1:", NULL});
    text_add_unsigned(&text, launcher.run->ground_port);
    text_add_words(&text, (const char* const[]){", directory ", launcher.run->directory, NULL});
    osal_console_print_line(line);
}

static void conclude(void)
{
    char line[LAUNCHER_REASON_MAX + LAUNCH_PATH_MAX];
    const bool is_good = (launcher.exit_code == 0);
    (void)text_join(line, sizeof line,
                    (const char* const[]){osal_console_is_terminal() ? "\n" : "",
                                          is_good ? "flown to the end: " : "failed: ", launcher.reason,
                                          is_good ? "" : "; ", launcher.run->directory,
                                          launcher.options.has_report ? "/report.html" : "/run.json", NULL});
    osal_console_print_line(line);
}

/// Fly the mission, with a guard process.
static int run(const int argument_count, char* const arguments[], const launch_options_t* const options)
{
    static guard_t guard;
    int code = 1;
    osal_process_catch_stop();
    guard_start(&guard, arguments[0], argument_count - 2, &arguments[2]);
    if (launcher_prepare(&launcher, options, directory_of(arguments[0]))) {
        launcher.guard = &guard;
        announce();
        launcher_fly(&launcher);
        launcher_clean_up(&launcher);
        conclude();
        code = launcher.exit_code;
    } else {
        (void)report_error(launcher.reason);
        launcher_clean_up(&launcher);
    }
    guard_stop(&guard);
    return code;
}

/// Act as the guard of another process: `hirosco guard IDENTITY`, with the options of its run.
static int watch(char* const arguments[], const launch_options_t* const options)
{
    if (launcher_owner_of(arguments[2]) == 0) {
        return report_error(
            "expected `hirosco guard hirosco-NUMBER ...`; guards are started by `hirosco run`");
    }
    osal_process_ignore_interrupt();
    const int code = guard_watch(&launcher, options, directory_of(arguments[0]), arguments[2]);
    if (launcher.run != NULL) {
        conclude();
    } else if (code != 0) {
        (void)report_error("the launcher was killed before its run began; start it again");
    } else {
        // The launcher has ended normally and has cleaned up itself.
    }
    return code;
}

int main(const int argument_count, char* arguments[])
{
    if (osal_console_introduce(argument_count, arguments, "hirosco", NULL)) {
        return 0;
    }
    const bool is_run   = (argument_count >= 2) && (strcmp(arguments[1], "run") == 0);
    const bool is_guard = (argument_count >= 3) && (strcmp(arguments[1], "guard") == 0);
    const bool is_help  = (argument_count < 2) || (strcmp(arguments[argument_count - 1], "--help") == 0);
    const int first     = is_guard ? 3 : 2;
    if (is_help) {
        osal_console_print_line(launch_options_help());
        return 0;
    }
    if (!is_run && !is_guard) {
        return report_error("expected `hirosco run ...`; see hirosco --help");
    }
    launch_options_t options;
    char error[LAUNCH_ERROR_MAX];
    if (!launch_options_parse(argument_count - first, &arguments[first], &options, error)) {
        return report_error(error);
    }
    return is_guard ? watch(arguments, &options) : run(argument_count, arguments, &options);
}
