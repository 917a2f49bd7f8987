// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/valve_box.h"

#include <stdio.h>
#include <stdlib.h>

#define OCTETS 2U // Objects of eight outputs or inputs each.
#define OCTET_BITS 8U
#define TIME_NS 10000000U // Unit of the longest time of the outputs.
#define LONGEST_NS 1e18   // A longer REAL32 is no limit.

struct valve_box {
    node_t* node;
    valve_box_config_t config;
    object_t* input[OCTETS];
    object_t* output[OCTETS];
    object_t* error_mode[OCTETS];
    object_t* error_value[OCTETS];
    object_t* longest;

    uint32_t wanted; // Commanded valves: one bit for each output.
    uint32_t open;
    uint64_t close_ns; // Time at which all valves close; UINT64_MAX: never.
    uint64_t opened_ns[VALVE_BOX_OUTPUTS];
};

static uint32_t bits_of(object_t* const object[OCTETS])
{
    return (uint32_t)object[0]->value | ((uint32_t)object[1]->value << OCTET_BITS);
}

/// Open the wanted valves; close the others as soon as they have been open for their shortest pulse.
static void move(valve_box_t* const box, const uint64_t now_ns)
{
    for (unsigned i = 0U; i < VALVE_BOX_OUTPUTS; i++) {
        const uint32_t bit   = 1U << i;
        const bool is_open   = (box->open & bit) != 0U;
        const bool is_wanted = (box->wanted & bit) != 0U;
        const bool may_close = (now_ns - box->opened_ns[i]) >= box->config.shortest_ns[i];
        if ((is_open == is_wanted) || (is_open && !may_close)) {
            continue;
        }
        box->open ^= bit;
        box->opened_ns[i] = is_wanted ? now_ns : box->opened_ns[i];
        if (box->config.changed != NULL) {
            box->config.changed(box->config.context, i, is_wanted, now_ns);
        }
    }
}

/// Returns the time at which all valves close after a command at `now_ns`; UINT64_MAX: never. The longest
/// time is an integer or a REAL32; one that is not positive, or is NaN, is none.
static uint64_t close_time(const object_t* const longest, const uint64_t now_ns)
{
    if (object_is_real(longest)) {
        const double time_ns = object_real(longest) * (double)TIME_NS;
        return ((time_ns > 0.0) && (time_ns < LONGEST_NS)) ? (now_ns + (uint64_t)time_ns) : UINT64_MAX;
    }
    return (longest->value > 0U) ? (now_ns + (longest->value * TIME_NS)) : UINT64_MAX;
}

static void on_written(void* const context, const object_t* const object, const uint64_t now_ns)
{
    valve_box_t* box = context;
    if ((object == box->output[0]) || (object == box->output[1]) || (object == box->longest)) {
        box->wanted   = bits_of(box->output);
        box->close_ns = close_time(box->longest, now_ns);
        move(box, now_ns);
    }
}

static void on_sample(void* const context, const uint64_t now_ns)
{
    const valve_box_t* box = context;
    (void)now_ns;
    object_set(box->input[0], (int64_t)(box->open & 0xFFU));
    object_set(box->input[1], (int64_t)(box->open >> OCTET_BITS));
}

static void on_connection_lost(void* const context, const uint64_t now_ns)
{
    valve_box_t* box    = context;
    const uint32_t mode = bits_of(box->error_mode);
    box->wanted         = (box->wanted & ~mode) | (bits_of(box->error_value) & mode);
    move(box, now_ns);
}

static void on_reset(void* const context, const uint64_t now_ns)
{
    valve_box_t* box = context;
    box->wanted      = 0U;
    box->close_ns    = UINT64_MAX;
    for (unsigned i = 0U; i < VALVE_BOX_OUTPUTS; i++) {
        const bool is_open = (box->open & (1U << i)) != 0U;
        if (is_open && (box->config.changed != NULL)) {
            box->config.changed(box->config.context, i, false, now_ns);
        }
    }
    box->open = 0U;
}

void valve_box_end_step(valve_box_t* const box, const uint64_t now_ns)
{
    if (now_ns >= box->close_ns) {
        box->wanted   = 0U;
        box->close_ns = UINT64_MAX;
    }
    move(box, now_ns);
}

bool valve_box_is_open(const valve_box_t* const box, const unsigned output)
{
    return (box->open & (1U << output)) != 0U;
}

static bool find_objects(void* const context)
{
    valve_box_t* box = context;
    bool has_all     = true;
    box->longest     = node_object_named(box->node, "Longest time of the outputs, in 10 ms", 0U);
    for (uint8_t i = 0U; i < OCTETS; i++) {
        const uint8_t subindex = (uint8_t)(i + 1U);
        box->input[i]          = node_object(box->node, 0x6000U, subindex);
        box->output[i]         = node_object(box->node, 0x6200U, subindex);
        box->error_mode[i]     = node_object(box->node, 0x6206U, subindex);
        box->error_value[i]    = node_object(box->node, 0x6207U, subindex);
        has_all                = has_all && (box->input[i] != NULL) && (box->output[i] != NULL) &&
                  (box->error_mode[i] != NULL) && (box->error_value[i] != NULL);
    }
    return has_all && (box->longest != NULL);
}

status_t valve_box_create(bus_t* const bus, const char* const eds_path, const uint8_t id,
                          const valve_box_config_t* const config, valve_box_t** const out_box,
                          char error[EDS_ERROR_MAX])
{
    *out_box         = NULL;
    valve_box_t* box = calloc(1U, sizeof *box);
    if (box == NULL) {
        (void)snprintf(error, EDS_ERROR_MAX, "%s: out of memory", eds_path);
        return STATUS_EXHAUSTED;
    }
    const node_application_t application = {.name            = "a valve box",
                                            .find            = find_objects,
                                            .sample          = on_sample,
                                            .written         = on_written,
                                            .connection_lost = on_connection_lost,
                                            .reset           = on_reset,
                                            .context         = box};
    box->config                          = *config;
    box->close_ns                        = UINT64_MAX;
    const status_t status                = node_create(bus, eds_path, id, &application, &box->node, error);
    if (status != STATUS_OK) {
        free(box);
        return status;
    }
    *out_box = box;
    return STATUS_OK;
}

void valve_box_destroy(valve_box_t* const box)
{
    if (box != NULL) {
        node_destroy(box->node);
        free(box);
    }
}

node_t* valve_box_node(valve_box_t* const box)
{
    return box->node;
}
