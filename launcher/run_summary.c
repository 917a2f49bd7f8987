// SPDX-License-Identifier: Apache-2.0
#include "launcher/run_summary.h"

#include "fsw/canopen/device_profile.h"
#include "launcher/launcher_guard.h"
#include "base/text.h"
#include "base/version.h"
#include "osal/include/osal/file.h"

#include <string.h>

#define SUMMARY_MAX 8192U
#define SUMMARY_PATH (LAUNCH_PATH_MAX + 24U)

/// Add a JSON string; characters that would need escaping become spaces.
static void add_string(text_t* const text, const char* const value)
{
    text_add_character(text, '"');
    for (const char* next = value; *next != '\0'; next++) {
        const bool is_plain = (*next >= ' ') && (*next != '"') && (*next != '\\');
        text_add_character(text, is_plain ? *next : ' ');
    }
    text_add_character(text, '"');
}

static void add_key(text_t* const text, const char* const key)
{
    text_add(text, (text->length > 1U) ? ",\n \"" : "\n \"");
    text_add(text, key);
    text_add(text, "\": ");
}

static void add_word(text_t* const text, const char* const key, const char* const value)
{
    add_key(text, key);
    add_string(text, value);
}

static void add_number(text_t* const text, const char* const key, const uint64_t value)
{
    add_key(text, key);
    text_add_unsigned(text, value);
}

static void add_hash(text_t* const text, const char* const key, const uint64_t hash)
{
    add_key(text, key);
    text_add_character(text, '"');
    text_add_hex(text, hash, 16U);
    text_add_character(text, '"');
}

/// Add value / 1000 with three decimals.
static void add_thousandths(text_t* const text, const char* const key, const uint64_t value)
{
    add_key(text, key);
    text_add_unsigned(text, value / 1000U);
    text_add_character(text, '.');
    text_add_digits(text, value % 1000U, 3U);
}

static void add_options(text_t* const text, const launch_options_t* const options)
{
    add_word(text, "mission", options->mission);
    add_word(text, "scenario", options->scenario);
    add_word(text, "world", options->world);
    add_number(text, "seed", options->seed);
    add_word(text, "form", options->is_image ? "image" : "processes");
    add_word(text, "time", launch_time_text(options));
    add_word(text, "bus", launch_bus_text(options->bus));
    add_word(text, "transport", options->is_image ? "ring" : options->transport);
    add_number(text, "nodes", options->computers);
    add_word(text, "links", options->links);
    if (options->remote_endian[0] != '\0') {
        add_word(text, "remote_endian", options->remote_endian);
    }
    if (options->rtos[0] != '\0') {
        add_word(text, "rtos", options->rtos);
    }
}

static void add_relay(text_t* const text, const launcher_t* const launcher)
{
    const run_relay_t* const relay = &launcher->run->relay;
    if (launcher->options.delay_ms == 0U) {
        return;
    }
    add_key(text, "relay");
    text_add(text, "{\"round_trip_ms\": ");
    text_add_unsigned(text, launcher->options.delay_ms);
    if (relay->is_network) {
        text_add(text, ", \"network\": true}"); // The ends of the links count the losses (`gse link list`).
        return;
    }
    text_add(text, ", \"delayed\": ");
    text_add_unsigned(text, relay->delayed);
    text_add(text, ", \"lost\": ");
    text_add_unsigned(text, relay->lost);
    text_add(text, ", \"reordered\": ");
    text_add_unsigned(text, relay->reordered);
    text_add(text, "}");
}

/// Add the numbers of frames of SocketCAN buses that did not arrive as announced, and of lost interfaces.
static void add_bus_frames(text_t* const text, const launcher_t* const launcher)
{
    add_number(text, "bus_frames_late", launcher->late_frames);
    add_number(text, "bus_frames_lost", launcher->lost_frames);
    add_number(text, "bus_frames_external", launcher->external_frames);
    add_number(text, "bus_interfaces_lost", launcher->bus_cuts);
}

/// Add the numbers of steps that were late by less than 0.1, 1, 10 and 100 ms, and by more, if the component
/// has its own clock.
static void add_lateness(text_t* const text, const launcher_t* const launcher, const unsigned component)
{
    if (launcher->scheduler != NULL) {
        return;
    }
    text_add(text, ", \"late_steps\": [");
    for (unsigned i = 0U; i < RUN_LATENESS; i++) {
        text_add(text, (i > 0U) ? ", " : "");
        text_add_unsigned(text, launcher->run->beats[component].late[i]);
    }
    text_add(text, "]");
}

static void add_children(text_t* const text, const launcher_t* const launcher)
{
    add_key(text, "processes");
    text_add(text, "[");
    for (size_t i = 0U; i < launcher->child_count; i++) {
        const child_t* const child = &launcher->children[i];
        text_add(text, (i > 0U) ? ",\n  {\"name\": " : "\n  {\"name\": ");
        add_string(text, child->name);
        text_add(text, child->result.was_signalled ? ", \"signal\": " : ", \"exit_code\": ");
        text_add_signed(text, child->result.code);
        text_add(text, ", \"memory_high_kib\": ");
        text_add_unsigned(text, child->memory_high_kib);
        if (child->is_component) {
            text_add(text, ", \"starts\": ");
            text_add_unsigned(text, launcher->run->components[child->component].found_life);
            add_lateness(text, launcher, child->component);
            text_add(text, ", \"memory_limit_kib\": ");
            text_add_unsigned(text, launcher->memory_limit_kib[child->component]);
        }
        text_add(text, "}");
    }
    text_add(text, "]");
}

static void add_speed(text_t* const text, const launcher_t* const launcher)
{
    const uint64_t wall_ns      = launcher->last_wall_ns - launcher->first_wall_ns;
    const uint64_t simulated_ns = launcher->last_simulated_ns - launcher->first_simulated_ns;
    add_thousandths(text, "simulated_s", launcher->last_simulated_ns / 1000000U);
    if (launcher->first_wall_ns == 0U) {
        return; // Simulated time never advanced.
    }
    add_thousandths(text, "wall_s", wall_ns / 1000000U);
    if (wall_ns >= 1000000U) {
        add_thousandths(text, "real_time_factor", simulated_ns / (wall_ns / 1000U));
    }
}

/// Build the temporary and the final path.
static bool name_files(const launcher_t* const launcher, char out_part[SUMMARY_PATH],
                       char out_path[SUMMARY_PATH])
{
    const char* const directory = launcher->run->directory;
    return text_join(out_part, SUMMARY_PATH, (const char* const[]){directory, "/run.json.part", NULL}) &&
           text_join(out_path, SUMMARY_PATH, (const char* const[]){directory, "/run.json", NULL});
}

bool run_summary_reserve(const launcher_t* const launcher)
{
    char part[SUMMARY_PATH];
    char path[SUMMARY_PATH];
    osal_file_t file = {-1};
    if (!name_files(launcher, part, path) || (osal_file_create(&file, part) != STATUS_OK)) {
        return false;
    }
    const status_t status = osal_file_reserve(&file, SUMMARY_MAX);
    osal_file_close(&file);
    return (status == STATUS_OK) || (status == STATUS_UNSUPPORTED);
}

/// Write the summary into the reserved space; the final name refers to a complete file at any moment.
static bool write_whole(const launcher_t* const launcher, const char* const summary, const size_t size)
{
    char part[SUMMARY_PATH];
    char path[SUMMARY_PATH];
    osal_file_t file = {-1};
    if (!name_files(launcher, part, path) || (osal_file_update(&file, part) != STATUS_OK)) {
        return false;
    }
    const bool is_written = (osal_file_write_at(&file, 0U, summary, size) == STATUS_OK) &&
                            (osal_file_resize(&file, size) == STATUS_OK) &&
                            (osal_file_sync(&file) == STATUS_OK);
    osal_file_close(&file);
    return is_written && (osal_file_rename(part, path) == STATUS_OK);
}

/// Add the number of lines of the live port that changed the flight; no text if the run had no live port.
static void add_live(text_t* const text, const launcher_t* const launcher)
{
    char path[SUMMARY_PATH];
    char octets[4096];
    osal_file_t file = {-1};
    size_t size      = 0U;
    uint64_t lines   = 0U;
    if (!text_join(path, sizeof path, (const char* const[]){launcher->run->directory, "/live.scn", NULL}) ||
        (osal_file_open_read(&file, path) != STATUS_OK)) {
        return;
    }
    while ((osal_file_read(&file, octets, sizeof octets, &size) == STATUS_OK) && (size > 0U)) {
        for (size_t i = 0U; i < size; i++) {
            lines += (octets[i] == '\n') ? 1U : 0U;
        }
    }
    osal_file_close(&file);
    add_key(text, "live_lines");
    text_add_unsigned(text, lines);
}

static size_t describe_run(const launcher_t* const launcher, char out_summary[SUMMARY_MAX])
{
    text_t text = text_in(out_summary, SUMMARY_MAX);
    text_add(&text, "{");
    add_options(&text, &launcher->options);
    add_hash(&text, "interface_hash", launcher->mission.interface_hash);
    add_hash(&text, "configuration_hash", launcher->mission.configuration_hash);
    add_hash(&text, "device_classes_hash", DEVICE_CLASSES_HASH);
    add_speed(&text, launcher);
    // Two flights with the same seed have equal logs only if nothing from outside the run took part in it (a
    // ground client outside stepped time, frames of other programs), and if every announced frame arrived.
    const bool is_reproducible = launcher->options.is_stepped && !launcher->is_undetermined &&
                                 !launcher->is_cut_short && (launcher->run->is_intruded == 0U) &&
                                 (launcher->lost_frames == 0U) && (launcher->external_frames == 0U) &&
                                 (launcher->bus_cuts == 0U) && (launcher->run->is_lossy == 0U);
    add_key(&text, "reproducible");
    text_add(&text, is_reproducible ? "true" : "false");
    add_key(&text, "cut_short");
    text_add(&text, launcher->is_cut_short ? "true" : "false");
    add_live(&text, launcher);
    add_key(&text, "exit_code");
    text_add_signed(&text, launcher->exit_code);
    add_word(&text, "exit_reason", launcher->reason);
    add_bus_frames(&text, launcher);
    add_relay(&text, launcher);
    add_key(&text, "versions");
    text_add(&text, "{\"hirosco\": \"" HIROSCO_VERSION "\", \"compiler\": ");
    add_string(&text, __VERSION__);
    text_add(&text, "}");
    if ((launcher->guard != NULL) && (launcher->guard->starts > 1U)) {
        add_number(&text, "guards", launcher->guard->starts);
    }
    add_children(&text, launcher);
    text_add(&text, "\n}\n");
    return text.cut ? 0U : text.length;
}

bool run_summary_write(const launcher_t* const launcher)
{
    static char summary[SUMMARY_MAX];
    const size_t size = describe_run(launcher, summary);
    return (size > 0U) && write_whole(launcher, summary, size);
}
