// SPDX-License-Identifier: Apache-2.0
#include "sim/app/faults.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_US 1000.0
#define SYNC_ID 0x80U // CiA 301.

typedef struct {
    faults_t* faults;
    const fault_world_t* world;
} loader_t;

/// The letters stand for the arguments of a fault, in their order: B bus, P bus or instrument, i instrument,
/// b bus or channel B of it, n node, m node or none, p probability, u us, s on or off, c code, j joint, t Nm,
/// k degC, f frames, q frames of a queue, r way to restart, x process.
typedef struct {
    const char* word;
    const char* arguments;
    const char* usage;
} grammar_t;

static const grammar_t grammar[FAULT_KIND_COUNT] = {
    [FAULT_UNPLUG]        = {"unplug", "Pm", "unplug <bus> [node], or unplug <instrument>"},
    [FAULT_PLUG]          = {"plug", "Pm", "plug <bus> [node], or plug <instrument>"},
    [FAULT_CUT]           = {"cut", "bm", "cut <bus> [node]"},
    [FAULT_MEND]          = {"mend", "bm", "mend <bus> [node]"},
    [FAULT_LOSS]          = {"loss", "bp", "loss <bus> <probability 0..1>"},
    [FAULT_CORRUPTION]    = {"corruption", "bp", "corruption <bus> <probability 0..1>"},
    [FAULT_DUPLICATION]   = {"duplication", "bp", "duplication <bus> <probability 0..1>"},
    [FAULT_DELAY]         = {"delay", "bnu", "delay <bus> <node> <us>"},
    [FAULT_BABBLE]        = {"babble", "bns", "babble <bus> <node> on|off"},
    [FAULT_SYNC]          = {"sync", "bnq", "sync <bus> <node> <frames>"},
    [FAULT_STUCK]         = {"stuck", "bs", "stuck <bus> on|off"},
    [FAULT_OVERFLOW]      = {"overflow", "bnf", "overflow <bus> <node> <frames>"},
    [FAULT_BUS_OFF]       = {"bus-off", "bn", "bus-off <bus> <node>"},
    [FAULT_RESTART]       = {"restart", "bnr", "restart <bus> <node> auto|order|now"},
    [FAULT_ARBITRATION]   = {"arbitration", "bns", "arbitration <bus> <node> on|off"},
    [FAULT_RESET]         = {"reset", "Bn", "reset <bus> <node>"},
    [FAULT_ERROR]         = {"error", "Bncs", "error <bus> <node> <code> on|off"},
    [FAULT_TORQUE_OFFSET] = {"torque-offset", "jt", "torque-offset <joint> <Nm>"},
    [FAULT_TEMPERATURE]   = {"temperature", "jk", "temperature <joint> <degC>"},
    [FAULT_SILENT]        = {"silent", "is", "silent <instrument> on|off"},
    [FAULT_GARBAGE]       = {"garbage", "is", "garbage <instrument> on|off"},
    [FAULT_KILL]          = {"kill", "x", "kill <process>"},
    [FAULT_HANG]          = {"hang", "x", "hang <process>"},
    [FAULT_RESUME]        = {"resume", "x", "resume <process>"},
};

static const char* const verbs_expected =
    "unplug, plug, cut, mend, loss, corruption, duplication, delay, "
    "babble, sync, stuck, overflow, bus-off, restart, arbitration, reset, "
    "error, torque-offset, temperature, silent, garbage, kill, hang or resume";

const char* fault_word(const fault_kind_t kind)
{
    return grammar[kind].word;
}

bool fault_is_onset(const fault_t* const fault)
{
    static const enum {
        BY_VALUE,
        ALWAYS,
        NEVER,
        BY_ORDER
    } onset[FAULT_KIND_COUNT] = {
        [FAULT_UNPLUG] = ALWAYS, [FAULT_CUT] = ALWAYS,   [FAULT_BUS_OFF] = ALWAYS,   [FAULT_RESET] = ALWAYS,
        [FAULT_PLUG] = NEVER,    [FAULT_MEND] = NEVER,   [FAULT_RESTART] = BY_ORDER, [FAULT_KILL] = ALWAYS,
        [FAULT_HANG] = ALWAYS,   [FAULT_RESUME] = NEVER,
    };
    switch (onset[fault->kind]) {
    case ALWAYS:
        return true;
    case NEVER:
        return false;
    case BY_ORDER:
        return fault->value == (double)FAULT_RESTART_ORDER;
    case BY_VALUE:
        break;
    }
    return fault->value != 0.0;
}

/// Find a device of this bus by its name or node id.
static bool parse_device(const fault_world_t* const world, const char* const word, const unsigned bus,
                         unsigned* const out_device)
{
    char* end              = NULL;
    const unsigned long id = strtoul(word, &end, 0);
    const bool is_number   = (end != word) && (*end == '\0');
    if ((strcmp(word, "FLIGHT") == 0) || (is_number && (id == 1U))) {
        *out_device = FAULT_DEVICE_FLIGHT;
        return true;
    }
    for (unsigned i = 0U; i < world->device_count; i++) {
        const fault_device_t* device = &world->device[i];
        if ((device->bus == bus) &&
            ((strcmp(word, device->name) == 0) || (is_number && (id == device->id)))) {
            *out_device = i;
            return true;
        }
    }
    return false;
}

static status_t take_number(const scenario_line_t* const line, const size_t index, const char kind,
                            fault_t* const fault, char error[SCENARIO_ERROR_MAX])
{
    switch (kind) {
    case 'p':
        return scenario_number(line, index, "probability", 0.0, 1.0, &fault->value, error);
    case 'u':
        return scenario_number(line, index, "delay in us", 0.0, 1e6, &fault->value, error);
    case 'f':
        return scenario_number(line, index, "number of frames", 1.0, 1e6, &fault->value, error);
    case 'q':
        return scenario_number(line, index, "number of frames", 1.0, (double)BUS_QUEUE_FRAMES, &fault->value,
                               error);
    case 't':
        return scenario_number(line, index, "torque in Nm", -100.0, 100.0, &fault->value, error);
    default:
        return scenario_number(line, index, "temperature in degC", -100.0, 200.0, &fault->value, error);
    }
}

static status_t take_switch(const scenario_line_t* const line, const size_t index, fault_t* const fault,
                            char error[SCENARIO_ERROR_MAX])
{
    const bool is_on = strcmp(line->word[index], "on") == 0;
    if (!is_on && (strcmp(line->word[index], "off") != 0)) {
        return scenario_error(line, line->word[index], "on or off", error);
    }
    fault->value = is_on ? 1.0 : 0.0;
    return STATUS_OK;
}

static status_t take_restart(const scenario_line_t* const line, const size_t index, fault_t* const fault,
                             char error[SCENARIO_ERROR_MAX])
{
    static const char* const words[] = {
        [FAULT_RESTART_AUTO] = "auto", [FAULT_RESTART_ORDER] = "order", [FAULT_RESTART_NOW] = "now"};
    for (unsigned i = 0U; i <= FAULT_RESTART_NOW; i++) {
        if (strcmp(line->word[index], words[i]) == 0) {
            fault->value = (double)i;
            return STATUS_OK;
        }
    }
    return scenario_error(line, line->word[index], "auto, order or now", error);
}

static status_t take_code(const scenario_line_t* const line, const size_t index, fault_t* const fault,
                          char error[SCENARIO_ERROR_MAX])
{
    const char* word         = line->word[index];
    char* end                = NULL;
    const unsigned long code = strtoul(word, &end, 0);
    fault->code              = (uint16_t)code;
    const bool is_code       = (end != word) && (*end == '\0') && (code != 0U) && (code <= 0xFFFFU);
    return is_code ? STATUS_OK : scenario_error(line, word, "an emergency code 0x0001..0xFFFF", error);
}

/// Find a bus by its name, or channel B of a bus for the argument b. The message for the argument P lists the
/// instruments as well.
static status_t take_bus(const loader_t* const loader, const scenario_line_t* const line, const size_t index,
                         const char kind, fault_t* const fault, char error[SCENARIO_ERROR_MAX])
{
    const char* word        = line->word[index];
    const unsigned channels = (kind == 'b') ? NODE_CHANNELS : 1U;
    char expected[SCENARIO_LIST_MAX];
    (void)strcpy(expected, (kind == 'P') ? "a bus or an instrument of the run:" : "a bus of the run:");
    for (unsigned channel = 0U; channel < channels; channel++) {
        for (unsigned i = 0U; i < FAULT_BUSES_MAX; i++) {
            const char* name = loader->world->channel[i][channel].name;
            if ((name != NULL) && (strcmp(word, name) == 0)) {
                fault->bus     = i;
                fault->channel = channel;
                return STATUS_OK;
            }
            if (name != NULL) {
                scenario_list(expected, name);
            }
        }
    }
    for (size_t i = 0U; (kind == 'P') && (i < loader->world->instrument_count); i++) {
        scenario_list(expected, loader->world->instrument[i].name);
    }
    return scenario_list_error(line, word, expected, error);
}

/// Find an instrument by its name.
static bool find_instrument(const fault_world_t* const world, const char* const word, fault_t* const fault)
{
    for (unsigned i = 0U; i < world->instrument_count; i++) {
        if (strcmp(word, world->instrument[i].name) == 0) {
            fault->bus    = FAULT_BUSES_MAX;
            fault->device = i;
            return true;
        }
    }
    return false;
}

static status_t take_instrument(const loader_t* const loader, const scenario_line_t* const line,
                                const size_t index, fault_t* const fault, char error[SCENARIO_ERROR_MAX])
{
    const fault_world_t* world       = loader->world;
    char expected[SCENARIO_LIST_MAX] = "an instrument of the world:";
    if (find_instrument(world, line->word[index], fault)) {
        return STATUS_OK;
    }
    for (size_t i = 0U; i < world->instrument_count; i++) {
        scenario_list(expected, world->instrument[i].name);
    }
    return scenario_list_error(line, line->word[index], expected, error);
}

/// True for the faults of power units, which only receive: other faults concern sending or error reports.
static bool is_of_power_units(const fault_kind_t kind)
{
    return (kind == FAULT_UNPLUG) || (kind == FAULT_PLUG) || (kind == FAULT_CUT) || (kind == FAULT_MEND) ||
           (kind == FAULT_RESET);
}

/// Find a device of the bus that the previous argument names, or the controller of the flight software.
static status_t take_node(const loader_t* const loader, const scenario_line_t* const line, const size_t index,
                          fault_t* const fault, char error[SCENARIO_ERROR_MAX])
{
    const fault_world_t* world       = loader->world;
    char expected[SCENARIO_LIST_MAX] = "a device of this bus, or its id:";
    if (fault->bus == FAULT_BUSES_MAX) {
        return scenario_error(line, line->word[index], "no word after an instrument", error);
    }
    if (parse_device(world, line->word[index], fault->bus, &fault->device)) {
        const bool is_unit =
            (fault->device < world->device_count) && (world->device[fault->device].unit != NULL);
        return (!is_unit || is_of_power_units(fault->kind))
                   ? STATUS_OK
                   : scenario_error(line, line->word[0],
                                    "unplug, plug, cut, mend or reset for a power unit, which only receives",
                                    error);
    }
    for (size_t i = 0U; i < world->device_count; i++) {
        if (world->device[i].bus == fault->bus) {
            scenario_list(expected, world->device[i].name);
        }
    }
    scenario_list(expected, "FLIGHT");
    return scenario_error(line, line->word[index], expected, error);
}

/// Find a drive on any bus by its name.
static status_t take_drive(const loader_t* const loader, const scenario_line_t* const line,
                           const size_t index, fault_t* const fault, char error[SCENARIO_ERROR_MAX])
{
    const fault_world_t* world       = loader->world;
    char expected[SCENARIO_LIST_MAX] = "a drive:";
    for (unsigned i = 0U; i < world->device_count; i++) {
        const fault_device_t* device = &world->device[i];
        if ((device->drive != NULL) && (strcmp(line->word[index], device->name) == 0)) {
            fault->bus    = device->bus;
            fault->device = i;
            return STATUS_OK;
        }
        if (device->drive != NULL) {
            scenario_list(expected, device->name);
        }
    }
    return scenario_list_error(line, line->word[index], expected, error);
}

static status_t take_argument(const loader_t* const loader, const scenario_line_t* const line,
                              const size_t index, const char kind, fault_t* const fault,
                              char error[SCENARIO_ERROR_MAX])
{
    switch (kind) {
    case 'B':
    case 'b':
        return take_bus(loader, line, index, kind, fault, error);
    case 'P':
        return find_instrument(loader->world, line->word[index], fault)
                   ? STATUS_OK
                   : take_bus(loader, line, index, kind, fault, error);
    case 'i':
        return take_instrument(loader, line, index, fault, error);
    case 'm':
    case 'n':
        return take_node(loader, line, index, fault, error);
    case 'j':
        return take_drive(loader, line, index, fault, error);
    case 'r':
        return take_restart(line, index, fault, error);
    case 's':
        return take_switch(line, index, fault, error);
    case 'c':
        return take_code(line, index, fault, error);
    case 'x':
        if (strlen(line->word[index]) >= sizeof fault->target) {
            return scenario_error(line, line->word[index], "the name of a process in run.json", error);
        }
        return (loader->world->check_process == NULL)
                   ? STATUS_OK
                   : loader->world->check_process(loader->world->process_context, line, index, error);
    default:
        return take_number(line, index, kind, fault, error);
    }
}

/// Write the arguments that name the target, for logs; for example "robot 0x11".
static void name_target(const scenario_line_t* const line, const char* const arguments, fault_t* const fault)
{
    size_t used = 0U;
    for (size_t i = 1U; (i < line->word_count) && (strchr("BPbinmjx", arguments[i - 1U]) != NULL); i++) {
        const int more = snprintf(&fault->target[used], sizeof fault->target - used, "%s%s",
                                  (used == 0U) ? "" : " ", line->word[i]);
        used += (more > 0) ? (size_t)more : 0U;
        if (used >= sizeof fault->target) {
            return;
        }
    }
}

status_t faults_add(faults_t* const faults, const fault_world_t* const world,
                    const scenario_line_t* const line, char error[SCENARIO_ERROR_MAX])
{
    const loader_t loader = {.faults = faults, .world = world};
    size_t kind           = 0U;
    while ((kind < FAULT_KIND_COUNT) && (strcmp(line->word[0], grammar[kind].word) != 0)) {
        kind++;
    }
    if (kind == FAULT_KIND_COUNT) {
        return scenario_error(line, line->word[0], verbs_expected, error);
    }
    fault_t fault = {.time_ns = line->time_ns, .kind = (fault_kind_t)kind, .device = FAULT_DEVICE_ALL};
    const char* arguments = grammar[kind].arguments;
    const size_t most     = strlen(arguments);
    const size_t least    = (arguments[most - 1U] == 'm') ? (most - 1U) : most;
    const size_t given    = line->word_count - 1U;
    if ((given < least) || (given > most)) {
        return scenario_error(line, line->word[0], grammar[kind].usage, error);
    }
    status_t status = STATUS_OK;
    for (size_t i = 0U; (i < given) && (status == STATUS_OK); i++) {
        status = take_argument(&loader, line, i + 1U, arguments[i], &fault, error);
    }
    name_target(line, arguments, &fault);
    status = (status == STATUS_OK) ? scenario_insert(faults, &fault, sizeof fault) : status;
    if (status == STATUS_EXHAUSTED) {
        (void)scenario_error(line, line->word[0], "memory for one more fault", error);
    }
    return status;
}

static status_t take_line(void* const context, const scenario_line_t* const line,
                          char error[SCENARIO_ERROR_MAX])
{
    const loader_t* loader = context;
    return faults_add(loader->faults, loader->world, line, error);
}

status_t faults_load(faults_t* const faults, const fault_world_t* const world,
                     const char* const scenario_path, char error[SCENARIO_ERROR_MAX])
{
    loader_t loader = {.faults = faults, .world = world};
    *faults         = (faults_t){0};
    if (scenario_path == NULL) {
        return STATUS_OK;
    }
    return scenario_read(scenario_path, "fault", take_line, &loader, error);
}

void faults_free(faults_t* const faults)
{
    free(faults->record);
    *faults = (faults_t){0};
}

uint64_t faults_next_ns(const faults_t* const faults)
{
    const fault_t* const fault = faults->record;
    return (faults->next < faults->count) ? fault[faults->next].time_ns : UINT64_MAX;
}

static void switch_flight(const fault_channel_t* const channel, const bool connects)
{
    if ((channel->bus == NULL) || (channel->flight_node >= BUS_NODES_MAX)) {
        return;
    }
    if (connects) {
        bus_plug(channel->bus, channel->flight_node);
    } else {
        bus_unplug(channel->bus, channel->flight_node);
    }
}

static void switch_device(node_t* const node, const fault_t* const fault)
{
    if (fault->kind == FAULT_CUT) {
        node_cut(node, fault->channel, true);
    } else if (fault->kind == FAULT_MEND) {
        node_cut(node, fault->channel, false);
    } else if ((fault->kind == FAULT_PLUG) && !node_is_plugged(node)) {
        node_plug(node);
    } else if ((fault->kind == FAULT_UNPLUG) && node_is_plugged(node)) {
        node_unplug(node);
    } else {
        // The channel is already in the commanded state.
    }
}

static void switch_power_unit(power_unit_t* const unit, const fault_t* const fault)
{
    if ((fault->kind == FAULT_CUT) || (fault->kind == FAULT_MEND)) {
        power_unit_cut(unit, fault->channel, fault->kind == FAULT_CUT);
    } else {
        power_unit_plug(unit, fault->kind == FAULT_PLUG);
    }
}

/// Connect or disconnect a node: both channels for unplug and plug, one channel for cut and mend.
static void switch_node(const fault_world_t* const world, const fault_t* const fault)
{
    if (fault->bus == FAULT_BUSES_MAX) {
        instrument_plug(world->instrument[fault->device].instrument, fault->kind == FAULT_PLUG);
        return;
    }
    const bool connects            = (fault->kind == FAULT_PLUG) || (fault->kind == FAULT_MEND);
    const bool affects_one_channel = (fault->kind == FAULT_CUT) || (fault->kind == FAULT_MEND);
    for (unsigned i = 0U; (fault->device == FAULT_DEVICE_FLIGHT) && (i < NODE_CHANNELS); i++) {
        if (!affects_one_channel || (i == fault->channel)) {
            switch_flight(&world->channel[fault->bus][i], connects);
        }
    }
    for (unsigned i = 0U; i < world->device_count; i++) {
        const fault_device_t* device = &world->device[i];
        if ((fault->device == i) || ((fault->device == FAULT_DEVICE_ALL) && (device->bus == fault->bus))) {
            if (device->unit != NULL) {
                switch_power_unit(device->unit, fault);
            } else {
                switch_device(device->node, fault);
            }
        }
    }
}

/// Returns the index of the node that a fault names, on its bus; BUS_NODES_MAX: the bus does not have it.
static unsigned bus_node(const fault_world_t* const world, const fault_t* const fault)
{
    return (fault->device < world->device_count)
               ? node_bus_index(world->device[fault->device].node, fault->channel)
               : world->channel[fault->bus][fault->channel].flight_node;
}

static void set_error(const fault_world_t* const world, const fault_t* const fault)
{
    const bool is_on = fault->value != 0.0;
    if (fault->device >= world->device_count) {
        return; // The fault names the controller of the flight software.
    }
    const fault_device_t* device = &world->device[fault->device];
    device->set_error(device->model, fault->code, is_on, fault->time_ns);
}

static void order_restart(bus_t* const bus, const unsigned node, const fault_t* const fault)
{
    if (fault->value == (double)FAULT_RESTART_NOW) {
        bus_restart(bus, node);
    } else {
        bus_set_restart(bus, node, fault->value == (double)FAULT_RESTART_AUTO);
    }
}

/// Send SYNC frames from a node that is not the master; all devices of the bus react to them.
static void send_syncs(bus_t* const bus, const unsigned node, const fault_t* const fault)
{
    const osal_can_frame_t sync = {.id = SYNC_ID};
    for (unsigned i = 0U; i < (unsigned)fault->value; i++) {
        (void)bus_submit(bus, node, &sync, 0U); // Refused if the node is in bus-off.
    }
}

/// Apply a fault to one controller.
static void apply_to_controller(const fault_world_t* const world, const fault_t* const fault)
{
    bus_t* bus          = world->channel[fault->bus][fault->channel].bus;
    const unsigned node = bus_node(world, fault);
    if ((bus == NULL) || (node >= BUS_NODES_MAX)) {
        return;
    }
    if (fault->kind == FAULT_DELAY) {
        bus_set_delay(bus, node, (uint64_t)llround(fault->value * NS_PER_US));
    } else if (fault->kind == FAULT_BABBLE) {
        bus_set_babbling(bus, node, fault->value != 0.0);
    } else if (fault->kind == FAULT_SYNC) {
        send_syncs(bus, node, fault);
    } else if (fault->kind == FAULT_OVERFLOW) {
        bus_lose_next(bus, node, (unsigned)fault->value);
    } else if (fault->kind == FAULT_BUS_OFF) {
        bus_force_off(bus, node);
    } else if (fault->kind == FAULT_ARBITRATION) {
        bus_set_arbitration_reports(bus, node, fault->value != 0.0);
    } else {
        order_restart(bus, node, fault);
    }
}

/// Apply a fault to the wire of one channel.
static void apply_to_wire(const fault_world_t* const world, const fault_t* const fault)
{
    bus_t* bus = world->channel[fault->bus][fault->channel].bus;
    if (bus == NULL) {
        return;
    }
    if (fault->kind == FAULT_LOSS) {
        bus_set_loss(bus, fault->value);
    } else if (fault->kind == FAULT_CORRUPTION) {
        bus_set_corruption(bus, fault->value);
    } else if (fault->kind == FAULT_DUPLICATION) {
        bus_set_duplication(bus, fault->value);
    } else {
        bus_set_stuck(bus, fault->value != 0.0);
    }
}

static void reset_node(const fault_world_t* const world, const fault_t* const fault)
{
    if (fault->device >= world->device_count) {
        return; // The fault names the controller of the flight software.
    }
    const fault_device_t* device = &world->device[fault->device];
    if (device->unit != NULL) {
        power_unit_reset(device->unit);
    } else {
        node_power_on(device->node);
    }
}

static void offset_torque(const fault_world_t* const world, const fault_t* const fault)
{
    drive_set_torque_offset(world->device[fault->device].drive, fault->value);
}

static void set_temperature(const fault_world_t* const world, const fault_t* const fault)
{
    drive_set_temperature(world->device[fault->device].drive, fault->value, fault->time_ns);
}

static void act_on_instrument(const fault_world_t* const world, const fault_t* const fault)
{
    instrument_t* const instrument = world->instrument[fault->device].instrument;
    if (fault->kind == FAULT_SILENT) {
        instrument_set_silent(instrument, fault->value != 0.0);
    } else {
        instrument_set_garbage(instrument, fault->value != 0.0);
    }
}

static void act_on_process(const fault_world_t* const world, const fault_t* const fault)
{
    if (world->process != NULL) {
        world->process(world->process_context, fault->kind, fault->target);
    }
}

const fault_t* faults_apply_next(faults_t* const faults, const fault_world_t* const world)
{
    static void (*const apply[FAULT_KIND_COUNT])(const fault_world_t* world, const fault_t* fault) = {
        [FAULT_UNPLUG]        = switch_node,
        [FAULT_PLUG]          = switch_node,
        [FAULT_CUT]           = switch_node,
        [FAULT_MEND]          = switch_node,
        [FAULT_LOSS]          = apply_to_wire,
        [FAULT_CORRUPTION]    = apply_to_wire,
        [FAULT_DUPLICATION]   = apply_to_wire,
        [FAULT_STUCK]         = apply_to_wire,
        [FAULT_RESET]         = reset_node,
        [FAULT_ERROR]         = set_error,
        [FAULT_TORQUE_OFFSET] = offset_torque,
        [FAULT_TEMPERATURE]   = set_temperature,
        [FAULT_DELAY]         = apply_to_controller,
        [FAULT_BABBLE]        = apply_to_controller,
        [FAULT_SYNC]          = apply_to_controller,
        [FAULT_OVERFLOW]      = apply_to_controller,
        [FAULT_BUS_OFF]       = apply_to_controller,
        [FAULT_RESTART]       = apply_to_controller,
        [FAULT_ARBITRATION]   = apply_to_controller,
        [FAULT_SILENT]        = act_on_instrument,
        [FAULT_GARBAGE]       = act_on_instrument,
        [FAULT_KILL]          = act_on_process,
        [FAULT_HANG]          = act_on_process,
        [FAULT_RESUME]        = act_on_process,
    };
    const fault_t* fault = &((const fault_t*)faults->record)[faults->next];
    faults->next++;
    apply[fault->kind](world, fault);
    return fault;
}
