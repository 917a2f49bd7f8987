// SPDX-License-Identifier: Apache-2.0
#include "sim/app/bench_devices.h"

#include "sim/app/channels.h"
#include "sim/devices/drive.h"
#include "sim/parameters/rokviss.h"
#include "sim/plant/motor_bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_OCTETS 256U
#define PATH_OCTETS 4096U
#define WORDS 5U
#define NODE_MAX 127U

typedef struct {
    bench_devices_t* bench_devices;
    unsigned segment;
    uint8_t node;
    motor_bench_t bench;
    drive_t* drive;
} item_t;

struct bench_devices {
    bench_devices_config_t config;
    item_t item[BENCH_DEVICES_MAX];
    size_t count;
};

/// A line of the file under way.
typedef struct {
    const char* path;
    unsigned number;
    char* word[WORDS];
    size_t word_count;
    char* error;
} line_t;

// ---- Inputs and outputs of devices ----

static void look(void* const context, drive_truth_t* const out_truth)
{
    const item_t* item              = context;
    out_truth->motor_position_rad   = item->bench.rotor.position_rad;
    out_truth->motor_velocity_rad_s = item->bench.rotor.velocity_rad_s;
    out_truth->joint_torque_nm      = item->bench.output_torque_nm;
}

static void record(const item_t* const item, const uint64_t now_ns, const uint16_t statusword,
                   const bool brake)
{
    const bench_devices_config_t* config = &item->bench_devices->config;
    const truth_drive_t drive            = {.bus           = config->segments[item->segment].name,
                                            .node          = item->node,
                                            .statusword    = statusword,
                                            .plugged       = node_is_plugged(drive_node(item->drive)),
                                            .brake_engaged = brake};
    config->changed(config->context, now_ns, &drive);
}

static void on_axis(void* const context, const uint8_t node, const unsigned axis, const uint16_t statusword,
                    const bool brake, const uint64_t now_ns)
{
    (void)node;
    (void)axis;
    record(context, now_ns, statusword, brake);
}

// ---- The file ----

static status_t refuse(const line_t* const line, const size_t index, const char* const expected)
{
    (void)snprintf(line->error, SIMULATOR_ERROR_MAX, "simulator: %s:%u: found '%s', expected %s", line->path,
                   line->number, (index < line->word_count) ? line->word[index] : "the end of the line",
                   expected);
    return STATUS_INVALID;
}

static bool take_real(const line_t* const line, const size_t index, const double low, const double high,
                      double* const out_value)
{
    char* end  = NULL;
    *out_value = strtod(line->word[index], &end);
    return (end != line->word[index]) && (*end == '\0') && (*out_value >= low) && (*out_value <= high);
}

static status_t refuse_bus(const bench_devices_config_t* const config, const line_t* const line)
{
    char expected[128] = "a bus of the mission:";
    for (size_t i = 0U; i < config->segment_count; i++) {
        const size_t used = strlen(expected);
        (void)snprintf(&expected[used], sizeof expected - used, " %s", config->segments[i].name);
    }
    return refuse(line, 0U, expected);
}

static bool is_taken(const bench_devices_t* const bench_devices, const unsigned segment,
                     const unsigned long node)
{
    for (size_t i = 0U; i < bench_devices->count; i++) {
        if ((bench_devices->item[i].segment == segment) && (bench_devices->item[i].node == node)) {
            return true;
        }
    }
    return false;
}

static status_t create_drive(item_t* const item, char error[SIMULATOR_ERROR_MAX])
{
    const bench_devices_config_t* config = &item->bench_devices->config;
    char path[PATH_OCTETS];
    char reason[EDS_ERROR_MAX];
    const drive_config_t wanted = {.seed             = config->seed,
                                   .sensor_device    = (item->segment << 8) | item->node,
                                   .step_ns          = ROKVISS_STEP_NS,
                                   .substep_ns       = ROKVISS_STEP_NS / PLANT_SUBSTEPS,
                                   .torque_sensor    = rokviss_torque_sensor,
                                   .encoder          = rokviss_joint_encoder,
                                   .look             = look,
                                   .look_context     = item,
                                   .observer         = on_axis,
                                   .observer_context = item};
    (void)snprintf(path, sizeof path, "%s/joint-drive.eds", config->devices_path);
    const status_t status =
        drive_create(config->segments[item->segment].bus, path, item->node, &wanted, &item->drive, reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
        return status;
    }
    bus_t* channel_b = (config->channel_b != NULL) ? config->channel_b[item->segment] : NULL;
    return channels_connect(drive_node(item->drive), channel_b, config->segments[item->segment].name, error);
}

static status_t take_device(bench_devices_t* const bench_devices, const line_t* const line)
{
    char* end          = NULL;
    double contact_rad = 0.0;
    double stiffness   = 0.0;
    const unsigned segment =
        channels_find(bench_devices->config.segments, bench_devices->config.segment_count, line->word[0]);
    if (segment == bench_devices->config.segment_count) {
        return refuse_bus(&bench_devices->config, line);
    }
    if (line->word_count != WORDS) {
        return refuse(line, line->word_count, "<bus> <node> joint-drive <contact rad> <stiffness Nm/rad>");
    }
    const unsigned long node = strtoul(line->word[1], &end, 0);
    if ((end == line->word[1]) || (*end != '\0') || (node < 2U) || (node > NODE_MAX)) {
        return refuse(line, 1U, "a node id from 2 to 127 (1 is flight)");
    }
    if (is_taken(bench_devices, segment, node)) {
        return refuse(line, 1U, "a node id that no other device of this bus has");
    }
    if (strcmp(line->word[2], "joint-drive") != 0) {
        return refuse(line, 2U, "joint-drive");
    }
    if (!take_real(line, 3U, -10.0, 10.0, &contact_rad)) {
        return refuse(line, 3U, "an angle in rad, -10 to 10");
    }
    if (!take_real(line, 4U, 0.0, 1.0e5, &stiffness)) {
        return refuse(line, 4U, "a stiffness in Nm/rad, 0 to 1e5");
    }
    if (bench_devices->count == BENCH_DEVICES_MAX) {
        return refuse(line, 0U, "at most 16 devices");
    }
    item_t* item = &bench_devices->item[bench_devices->count];
    *item        = (item_t){.bench_devices = bench_devices, .segment = segment, .node = (uint8_t)node};
    motor_bench_init(&item->bench, &rokviss_plant, contact_rad, stiffness);
    bench_devices->count++;
    return create_drive(item, line->error);
}

/// Words of a line; more than WORDS count, but are not kept.
static void split(line_t* const line, char* const text)
{
    char* rest               = NULL;
    line->word_count         = 0U;
    text[strcspn(text, "#")] = '\0';
    for (char* word = strtok_r(text, " \t\r\n", &rest); word != NULL;
         word       = strtok_r(NULL, " \t\r\n", &rest)) {
        if (line->word_count < WORDS) {
            line->word[line->word_count] = word;
        }
        line->word_count++;
    }
}

static status_t read_file(bench_devices_t* const bench_devices, char error[SIMULATOR_ERROR_MAX])
{
    char text[LINE_OCTETS];
    line_t line     = {.path = bench_devices->config.path, .error = error};
    status_t status = STATUS_OK;
    FILE* in        = fopen(line.path, "r");
    if (in == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: cannot read '%s'", line.path);
        return STATUS_NOT_FOUND;
    }
    while ((status == STATUS_OK) && (fgets(text, sizeof text, in) != NULL)) {
        line.number++;
        split(&line, text);
        if (line.word_count > WORDS) {
            line.word_count = WORDS;
            status          = refuse(&line, WORDS - 1U, "nothing behind the fifth word");
        } else if (line.word_count > 0U) {
            status = take_device(bench_devices, &line);
        } else {
            // An empty line.
        }
    }
    (void)fclose(in);
    return status;
}

// ---- Opening, closing, one step ----

status_t bench_devices_open(const bench_devices_config_t* const config,
                            bench_devices_t** const out_bench_devices, char error[SIMULATOR_ERROR_MAX])
{
    *out_bench_devices             = NULL;
    bench_devices_t* bench_devices = calloc(1U, sizeof *bench_devices);
    if (bench_devices == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: out of memory");
        return STATUS_EXHAUSTED;
    }
    bench_devices->config = *config;
    const status_t status = read_file(bench_devices, error);
    if (status != STATUS_OK) {
        bench_devices_close(bench_devices);
        return status;
    }
    *out_bench_devices = bench_devices;
    return STATUS_OK;
}

void bench_devices_close(bench_devices_t* const bench_devices)
{
    for (size_t i = 0U; (bench_devices != NULL) && (i < bench_devices->count); i++) {
        drive_destroy(bench_devices->item[i].drive);
    }
    free(bench_devices);
}

void bench_devices_power_on(bench_devices_t* const bench_devices)
{
    for (size_t i = 0U; (bench_devices != NULL) && (i < bench_devices->count); i++) {
        node_power_on(drive_node(bench_devices->item[i].drive));
    }
}

void bench_devices_report(bench_devices_t* const bench_devices, const uint64_t now_ns)
{
    for (size_t i = 0U; (bench_devices != NULL) && (i < bench_devices->count); i++) {
        const item_t* item = &bench_devices->item[i];
        record(item, now_ns, drive_statusword(item->drive), drive_brake_is_engaged(item->drive));
    }
}

void bench_devices_move(bench_devices_t* const bench_devices, const uint64_t now_ns, const uint64_t end_ns)
{
    const double h_s = (double)(end_ns - now_ns) * 1.0e-9 / (double)PLANT_SUBSTEPS;
    for (size_t i = 0U; (bench_devices != NULL) && (i < bench_devices->count); i++) {
        item_t* item     = &bench_devices->item[i];
        const bool brake = drive_brake_is_engaged(item->drive);
        for (unsigned k = 0U; k < PLANT_SUBSTEPS; k++) {
            const plant_rotor_t* rotor = &item->bench.rotor;
            const double torque_nm = drive_regulate(item->drive, rotor->position_rad, rotor->velocity_rad_s);
            motor_bench_step(&item->bench, brake, torque_nm, h_s);
        }
        drive_end_step(item->drive, end_ns);
    }
}
