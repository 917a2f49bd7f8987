// SPDX-License-Identifier: Apache-2.0
// Support of a subsystem whose program is for another, big-endian processor: it runs in an emulator, with a
// native proxy.
#include "launcher/launcher_internal.h"

#include "base/assertion.h"
#include "osal/include/osal/file.h"

#include <string.h>

#define RUNNER "/usr/bin/qemu-s390x"
#define PROGRAM_FOLDER "build/s390x/bin/"

bool launcher_is_remote_endian(const launcher_t* const launcher, const unsigned component)
{
    return strcmp(launcher->mission.subsystems[component].name, launcher->options.remote_endian) == 0;
}

bool launcher_check_remote_endian(launcher_t* const launcher)
{
    char program[LAUNCH_PATH_MAX];
    unsigned component = 0U;
    if (launcher->options.remote_endian[0] == '\0') {
        return true;
    }
    while ((component < launcher->mission.subsystem_count) &&
           !launcher_is_remote_endian(launcher, component)) {
        component++;
    }
    if (component == launcher->mission.subsystem_count) {
        return launcher_fail(launcher, "--remote-endian: the mission has no such subsystem: ",
                             launcher->options.remote_endian);
    }
    const mission_subsystem_t* const subsystem = &launcher->mission.subsystems[component];
    if ((subsystem->apid == SUPERVISOR_APID) || (subsystem->apid == COMMUNICATION_APID)) {
        return launcher_fail(
            launcher,
            "--remote-endian: the launcher and the operator reach this subsystem in shared memory; "
            "choose one that drives devices: ",
            launcher->options.remote_endian);
    }
    (void)text_join(program, sizeof program,
                    (const char* const[]){PROGRAM_FOLDER, subsystem->executable, NULL});
    if (!osal_file_exists(program)) {
        return launcher_fail(
            launcher, "--remote-endian: there is no such program (make remote-endian builds it): ", program);
    }
    return osal_file_exists(RUNNER) ||
           launcher_fail(launcher,
                         "--remote-endian: install the package qemu-user (make setup does); there is no ",
                         RUNNER);
}

void launcher_add_component(const launcher_t* const launcher, const unsigned component,
                            arguments_t* const arguments)
{
    const char* const executable = launcher->mission.subsystems[component].executable;
    const bool is_remote_endian  = launcher_is_remote_endian(launcher, component);
    char name[RUN_NAME_MAX];
    FSW_ASSERT(run_name(launcher->run, "run", 0U, name, sizeof name));
    arguments_add_joined(arguments, launcher->program_folder, is_remote_endian ? "proxy" : executable);
    arguments_add_option(arguments, "--run", name);
    arguments_add_number(arguments, "--component", component);
    if (is_remote_endian) {
        arguments_add(arguments, "--program");
        arguments_add_joined(arguments, PROGRAM_FOLDER, executable);
        arguments_add_option(arguments, "--runner", RUNNER);
    }
}
