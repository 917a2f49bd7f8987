// SPDX-License-Identifier: Apache-2.0
// Resource limits of the process of a subsystem: those that the mission defines, otherwise derived from the
// program.
#include "launcher/launcher_internal.h"

#include "osal/include/osal/console.h"

/// Address space for everything except the program itself [KiB]: shared libraries, stacks, and the shared
/// memories of a run.
#define OTHER_MAPPINGS_KIB 8192U
/// Largest number of open file descriptors: twice the sockets and memories of all links and the files of all
/// stores.
#define DESCRIPTORS 128U

static void begin_line(text_t* const text, const char* const mission_path,
                       const mission_subsystem_t* const one)
{
    text_add_words(text, (const char* const[]){mission_path, ":", NULL});
    text_add_unsigned(text, one->line);
    text_add(text, ": ");
}

/// Returns the limit for a program of this size [KiB]: what it and its other mappings need, and a quarter
/// more.
static uint32_t derived_kib(const uint64_t octets)
{
    const uint64_t needed_kib = (octets / 1024U) + OTHER_MAPPINGS_KIB;
    return (uint32_t)(needed_kib + (needed_kib / 4U));
}

static bool set_limit(launcher_t* const launcher, const char* const mission_path, const uint16_t index)
{
    const mission_subsystem_t* const subsystem = &launcher->mission.subsystems[index];
    char path[LAUNCH_PATH_MAX];
    char line[LAUNCHER_REASON_MAX];
    uint64_t octets = 0U;
    (void)text_join(path, sizeof path,
                    (const char* const[]){launcher->program_directory, subsystem->executable, NULL});
    // This fails for a script, which is no executable with a size of its own.
    const status_t status = osal_process_loaded_size(path, &octets);
    if ((status == STATUS_OK) && (subsystem->memory_kib > 0U) && (subsystem->memory_kib < (octets / 1024U))) {
        text_t text = text_in(launcher->reason, sizeof launcher->reason);
        begin_line(&text, mission_path, subsystem);
        text_add(&text, "memoryKiB=\"");
        text_add_unsigned(&text, subsystem->memory_kib);
        text_add(&text, "\" of <Subsystem>: expected more KiB than the program alone needs, ");
        text_add_unsigned(&text, octets / 1024U);
        launcher->exit_code = 1;
        return false;
    }
    launcher->memory_limit_kib[index] =
        (subsystem->memory_kib > 0U) ? subsystem->memory_kib : derived_kib(octets);
    if (subsystem->memory_kib == 0U) {
        text_t text = text_in(line, sizeof line);
        begin_line(&text, mission_path, subsystem);
        text_add_words(&text, (const char* const[]){subsystem->name, " has no memoryKiB: limited to ", NULL});
        text_add_unsigned(&text, launcher->memory_limit_kib[index]);
        text_add(&text, " KiB");
        osal_console_print_line(line);
    }
    return true;
}

bool launcher_set_limits(launcher_t* const launcher, const char* const mission_path)
{
    bool is_good = true;
    for (uint16_t i = 0U; is_good && (i < launcher->mission.subsystem_count); i++) {
        is_good = set_limit(launcher, mission_path, i);
    }
    return is_good;
}

void launcher_limit(const launcher_t* const launcher, const child_t* const child,
                    osal_process_start_t* const start)
{
    // There is no limit for an emulator, because it maps the whole address space of the other processor.
    if (child->is_component && !launcher_has_proxy(launcher, child->component)) {
        start->memory_limit_octets = (uint64_t)launcher->memory_limit_kib[child->component] * 1024U;
        start->descriptor_limit    = DESCRIPTORS;
    }
}

/// Print the peak memory of a component that has failed, with its limit: a leak may be the cause of its end.
static void print_memory(const launcher_t* const launcher, const child_t* const child)
{
    char line[LAUNCHER_REASON_MAX];
    text_t text = text_in(line, sizeof line);
    text_add_words(&text, (const char* const[]){child->name, ": had ", NULL});
    text_add_unsigned(&text, child->memory_high_kib);
    text_add(&text, " KiB of memory at most; its address space is limited to ");
    text_add_unsigned(&text, launcher->memory_limit_kib[child->component]);
    text_add(&text, " KiB");
    osal_console_print_error(line);
}

bool launcher_has_ended(const launcher_t* const launcher, child_t* const child)
{
    if (!child->is_alive || (osal_process_poll(&child->process, &child->result) != STATUS_OK) ||
        !child->result.has_ended) {
        return false;
    }
    if (child->result.memory_high_kib > child->memory_high_kib) {
        child->memory_high_kib = child->result.memory_high_kib;
    }
    if (child->is_component && (child->result.was_signalled || (child->result.code != 0))) {
        print_memory(launcher, child);
    }
    return true;
}
