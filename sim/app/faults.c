// SPDX-License-Identifier: Apache-2.0
#include "sim/app/faults.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_US 1000.0

static const char* const bus_words[FAULT_BUSES] = {"robot", "joystick"};

/// Arguments of a fault in their order: b bus, n node, m node or none, p probability, u us, s on or off, c
/// code, j joint, t Nm, k degC.
typedef struct {
    const char* word;
    const char* arguments;
    const char* usage;
} grammar_t;

static const grammar_t grammar[FAULT_KIND_COUNT] = {
    [FAULT_UNPLUG]        = {"unplug", "bm", "unplug <bus> [node]"},
    [FAULT_PLUG]          = {"plug", "bm", "plug <bus> [node]"},
    [FAULT_LOSS]          = {"loss", "bp", "loss <bus> <probability 0..1>"},
    [FAULT_CORRUPTION]    = {"corruption", "bp", "corruption <bus> <probability 0..1>"},
    [FAULT_DUPLICATION]   = {"duplication", "bp", "duplication <bus> <probability 0..1>"},
    [FAULT_DELAY]         = {"delay", "bnu", "delay <bus> <node> <us>"},
    [FAULT_BABBLE]        = {"babble", "bns", "babble <bus> <node> on|off"},
    [FAULT_STUCK]         = {"stuck", "bs", "stuck <bus> on|off"},
    [FAULT_RESET]         = {"reset", "bn", "reset <bus> <node>"},
    [FAULT_ERROR]         = {"error", "bncs", "error <bus> <node> <code> on|off"},
    [FAULT_TORQUE_OFFSET] = {"torque-offset", "jt", "torque-offset <joint> <Nm>"},
    [FAULT_TEMPERATURE]   = {"temperature", "jk", "temperature <joint> <degC>"},
};

static const char* const verbs_expected = "unplug, plug, loss, corruption, duplication, delay, babble, "
                                          "stuck, reset, error, torque-offset or temperature";

const char* fault_word(fault_kind_t kind)
{
    return grammar[kind].word;
}

bool fault_is_onset(const fault_t* fault)
{
    switch (fault->kind) {
    case FAULT_UNPLUG:
    case FAULT_RESET:
        return true;
    case FAULT_PLUG:
        return false;
    case FAULT_LOSS:
    case FAULT_CORRUPTION:
    case FAULT_DUPLICATION:
    case FAULT_DELAY:
    case FAULT_BABBLE:
    case FAULT_STUCK:
    case FAULT_ERROR:
    case FAULT_TORQUE_OFFSET:
    case FAULT_TEMPERATURE:
    case FAULT_KIND_COUNT:
        break;
    }
    return fault->value != 0.0;
}

typedef struct {
    const char* name;
    unsigned bus;
    unsigned id;
    fault_node_t node;
} node_word_t;

static const node_word_t node_words[] = {{"JOINT1", 0U, 0x11U, FAULT_NODE_JOINT1},
                                         {"JOINT2", 0U, 0x12U, FAULT_NODE_JOINT2},
                                         {"STICK", 1U, 0x21U, FAULT_NODE_STICK}};

#define NODE_WORDS (sizeof node_words / sizeof node_words[0])

/// A node by its name or id. It must be on the fault's bus.
static bool parse_node(const char* word, unsigned bus, fault_node_t* out_node)
{
    char* end              = NULL;
    const unsigned long id = strtoul(word, &end, 0);
    const bool is_number   = (end != word) && (*end == '\0');
    if ((strcmp(word, "FLIGHT") == 0) || (is_number && (id == 1U))) {
        *out_node = FAULT_NODE_FLIGHT;
        return true;
    }
    for (size_t i = 0U; i < NODE_WORDS; i++) {
        const bool is_meant =
            (strcmp(word, node_words[i].name) == 0) || (is_number && (id == node_words[i].id));
        if (is_meant && (node_words[i].bus == bus)) {
            *out_node = node_words[i].node;
            return true;
        }
    }
    return false;
}

static bool parse_bus(const char* word, unsigned* out_bus)
{
    for (unsigned i = 0U; i < FAULT_BUSES; i++) {
        if (strcmp(word, bus_words[i]) == 0) {
            *out_bus = i;
            return true;
        }
    }
    return false;
}

static status_t take_number(const scenario_line_t* line, size_t index, char kind, fault_t* fault,
                            char error[SCENARIO_ERROR_MAX])
{
    switch (kind) {
    case 'p':
        return scenario_number(line, index, "probability", 0.0, 1.0, &fault->value, error);
    case 'u':
        return scenario_number(line, index, "delay in us", 0.0, 1e6, &fault->value, error);
    case 't':
        return scenario_number(line, index, "torque in Nm", -100.0, 100.0, &fault->value, error);
    default:
        return scenario_number(line, index, "temperature in degC", -100.0, 200.0, &fault->value, error);
    }
}

static status_t take_switch(const scenario_line_t* line, size_t index, fault_t* fault,
                            char error[SCENARIO_ERROR_MAX])
{
    const bool is_on = strcmp(line->word[index], "on") == 0;
    if (!is_on && (strcmp(line->word[index], "off") != 0)) {
        return scenario_error(line, line->word[index], "on or off", error);
    }
    fault->value = is_on ? 1.0 : 0.0;
    return STATUS_OK;
}

static status_t take_argument(const scenario_line_t* line, size_t index, char kind, fault_t* fault,
                              char error[SCENARIO_ERROR_MAX])
{
    const char* word = line->word[index];
    switch (kind) {
    case 'b':
        return parse_bus(word, &fault->bus) ? STATUS_OK
                                            : scenario_error(line, word, "robot or joystick", error);
    case 'm':
    case 'n':
        return parse_node(word, fault->bus, &fault->node)
                   ? STATUS_OK
                   : scenario_error(line, word,
                                    "JOINT1, JOINT2 (robot), STICK (joystick), FLIGHT or their id", error);
    case 'j':
        if (parse_node(word, 0U, &fault->node) && (fault->node != FAULT_NODE_FLIGHT)) {
            return STATUS_OK;
        }
        return scenario_error(line, word, "JOINT1 or JOINT2", error);
    case 's':
        return take_switch(line, index, fault, error);
    case 'c': {
        char* end                = NULL;
        const unsigned long code = strtoul(word, &end, 0);
        fault->code              = (uint16_t)code;
        const bool is_code       = (end != word) && (*end == '\0') && (code != 0U) && (code <= 0xFFFFU);
        return is_code ? STATUS_OK : scenario_error(line, word, "an emergency code 0x0001..0xFFFF", error);
    }
    default:
        return take_number(line, index, kind, fault, error);
    }
}

/// "robot 0x11"-like text for logs: the arguments that name the target.
static void name_target(const scenario_line_t* line, const char* arguments, fault_t* fault)
{
    size_t used = 0U;
    for (size_t i = 1U; (i < line->word_count) && (strchr("bnmj", arguments[i - 1U]) != NULL); i++) {
        const int more = snprintf(&fault->target[used], sizeof fault->target - used, "%s%s",
                                  (used == 0U) ? "" : " ", line->word[i]);
        used += (more > 0) ? (size_t)more : 0U;
        if (used >= sizeof fault->target) {
            return;
        }
    }
}

static status_t take_line(void* context, const scenario_line_t* line, char error[SCENARIO_ERROR_MAX])
{
    faults_t* faults = context;
    size_t kind      = 0U;
    while ((kind < FAULT_KIND_COUNT) && (strcmp(line->word[0], grammar[kind].word) != 0)) {
        kind++;
    }
    if (kind == FAULT_KIND_COUNT) {
        return scenario_error(line, line->word[0], verbs_expected, error);
    }
    if (faults->count == FAULTS_MAX) {
        return scenario_error(line, line->word[0], "at most 256 faults", error);
    }
    fault_t* fault        = &faults->fault[faults->count];
    *fault                = (fault_t){.time_ns = line->time_ns, .kind = (fault_kind_t)kind};
    const char* arguments = grammar[kind].arguments;
    const size_t most     = strlen(arguments);
    const size_t least    = (arguments[most - 1U] == 'm') ? (most - 1U) : most;
    const size_t given    = line->word_count - 1U;
    if ((given < least) || (given > most)) {
        return scenario_error(line, line->word[0], grammar[kind].usage, error);
    }
    status_t status = STATUS_OK;
    for (size_t i = 0U; (i < given) && (status == STATUS_OK); i++) {
        status = take_argument(line, i + 1U, arguments[i], fault, error);
    }
    name_target(line, arguments, fault);
    faults->count += (status == STATUS_OK) ? 1U : 0U;
    return status;
}

status_t faults_load(faults_t* faults, const char* scenario_path, char error[SCENARIO_ERROR_MAX])
{
    faults->count = 0U;
    faults->next  = 0U;
    if (scenario_path == NULL) {
        return STATUS_OK;
    }
    return scenario_read(scenario_path, "fault", take_line, faults, error);
}

uint64_t faults_next_ns(const faults_t* faults)
{
    return (faults->next < faults->count) ? faults->fault[faults->next].time_ns : UINT64_MAX;
}

/// Node of a device, or null for flight's controller.
static node_t* device_node(const fault_world_t* world, fault_node_t node)
{
    switch (node) {
    case FAULT_NODE_JOINT1:
        return drive_node(world->drive[0]);
    case FAULT_NODE_JOINT2:
        return drive_node(world->drive[1]);
    case FAULT_NODE_STICK:
        return joystick_node(world->joystick);
    case FAULT_NODE_ALL:
    case FAULT_NODE_FLIGHT:
        break;
    }
    return NULL;
}

static void switch_flight(const fault_world_t* world, const fault_t* fault, bool connects)
{
    const unsigned node = world->flight_node[fault->bus];
    if (node >= BUS_NODES_MAX) {
        return;
    }
    if (connects) {
        bus_plug(world->bus[fault->bus], node);
    } else {
        bus_unplug(world->bus[fault->bus], node);
    }
}

static void switch_device(const fault_world_t* world, fault_node_t which, bool connects)
{
    node_t* node = device_node(world, which);
    if (connects && !node_is_plugged(node)) {
        node_plug(node);
    } else if (!connects && node_is_plugged(node)) {
        node_unplug(node);
    }
}

static void switch_node(const fault_world_t* world, const fault_t* fault, bool connects)
{
    if (fault->node == FAULT_NODE_FLIGHT) {
        switch_flight(world, fault, connects);
        return;
    }
    for (size_t i = 0U; i < NODE_WORDS; i++) {
        const bool is_meant = (fault->node == node_words[i].node) ||
                              ((fault->node == FAULT_NODE_ALL) && (node_words[i].bus == fault->bus));
        if (is_meant) {
            switch_device(world, node_words[i].node, connects);
        }
    }
}

/// Index on its bus of the node a fault names; BUS_NODES_MAX: flight's controller that is not there.
static unsigned bus_node(const fault_world_t* world, const fault_t* fault)
{
    const node_t* node = device_node(world, fault->node);
    return (node != NULL) ? node_bus_index(node) : world->flight_node[fault->bus];
}

static void set_error(const fault_world_t* world, const fault_t* fault)
{
    const bool is_on = fault->value != 0.0;
    if (fault->node == FAULT_NODE_STICK) {
        joystick_set_error(world->joystick, fault->code, is_on, fault->time_ns);
    } else if ((fault->node == FAULT_NODE_JOINT1) || (fault->node == FAULT_NODE_JOINT2)) {
        drive_set_error(world->drive[fault->node - FAULT_NODE_JOINT1], fault->code, is_on, fault->time_ns);
    }
}

static void apply_to_node(const fault_world_t* world, const fault_t* fault)
{
    bus_t* bus          = world->bus[fault->bus];
    const unsigned node = bus_node(world, fault);
    if (node >= BUS_NODES_MAX) {
        return;
    }
    if (fault->kind == FAULT_DELAY) {
        bus_set_delay(bus, node, (uint64_t)llround(fault->value * NS_PER_US));
    } else if (fault->kind == FAULT_BABBLE) {
        bus_set_babbling(bus, node, fault->value != 0.0);
    } else if (device_node(world, fault->node) != NULL) {
        node_power_on(device_node(world, fault->node));
    }
}

const fault_t* faults_apply_next(faults_t* faults, const fault_world_t* world)
{
    const fault_t* fault = &faults->fault[faults->next];
    bus_t* bus           = world->bus[fault->bus];
    faults->next++;
    switch (fault->kind) {
    case FAULT_UNPLUG:
    case FAULT_PLUG:
        switch_node(world, fault, fault->kind == FAULT_PLUG);
        break;
    case FAULT_LOSS:
        bus_set_loss(bus, fault->value);
        break;
    case FAULT_CORRUPTION:
        bus_set_corruption(bus, fault->value);
        break;
    case FAULT_DUPLICATION:
        bus_set_duplication(bus, fault->value);
        break;
    case FAULT_STUCK:
        bus_set_stuck(bus, fault->value != 0.0);
        break;
    case FAULT_ERROR:
        set_error(world, fault);
        break;
    case FAULT_TORQUE_OFFSET:
        drive_set_torque_offset(world->drive[fault->node - FAULT_NODE_JOINT1], fault->value);
        break;
    case FAULT_TEMPERATURE:
        drive_set_temperature(world->drive[fault->node - FAULT_NODE_JOINT1], fault->value, fault->time_ns);
        break;
    case FAULT_DELAY:
    case FAULT_BABBLE:
    case FAULT_RESET:
    case FAULT_KIND_COUNT:
        apply_to_node(world, fault);
        break;
    }
    return fault;
}
