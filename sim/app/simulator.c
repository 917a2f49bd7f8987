// SPDX-License-Identifier: Apache-2.0
#include "sim/app/simulator.h"

#include "sim/app/channels.h"
#include "sim/app/device_log.h"
#include "sim/app/devices.h"
#include "sim/app/instrument_set.h"
#include "sim/app/live.h"
#include "sim/app/plant_log.h"
#include "sim/app/segment.h"
#include "sim/app/senders.h"
#include "sim/app/spread.h"
#include "sim/app/supply.h"
#include "sim/operator/hand.h"
#include "sim/plant/plant.h"
#include "sim/socketcand/socketcand.h"
#include "sim/truth/truth.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BUS_SEEDS 2U      ///< The first bus has the seed of the run times 2, the next buses those after it.
#define BIT_RATE 1000000U ///< Bit rate of a bus without configured rates.
#define DATA_BIT_RATE 5000000U
#define DEFAULT_QUANTUM_NS 5000000U
#define PATH_OCTETS 4096U

struct simulator {
    uint64_t time_ns;
    segment_t segment[SIMULATOR_BUSES_MAX];
    bus_t* channel_b[SIMULATOR_BUSES_MAX]; ///< Channel B of each segment; null: it has none.
    unsigned bus_count;
    world_t world;
    devices_t* devices;
    instrument_set_t* instruments; // Null: there are none.
    plant_t* plant;
    const plant_truth_t* truth;
    plant_input_t input;
    hand_t* hand;
    truth_t* truth_log;
    device_log_t device_log;
    bool is_truth_broken;
    bool is_latched[WORLD_LATCHES_MAX]; // State of each latch that was written to the truth log last.
    faults_t faults;
    fault_world_t targets; // Targets of faults, by their names.
    live_t* live;          // Null: there is no live port.
    power_unit_t supply;
    socketcand_t* tools;
    bool tools_in_step;
    uint64_t tools_lost; // Tools in lock-step that were dropped because they did not finish a step in time.
    uint64_t tool_quantum_ns;
    uint64_t tool_credit_ns; // Time up to which the frames of the tool let time advance.
};

// ---- Truth ----

static void note_status(simulator_t* const simulator, const status_t status)
{
    simulator->is_truth_broken = simulator->is_truth_broken || (status != STATUS_OK);
}

static void log_change(void* const context, const uint64_t now_ns, const truth_drive_t* const event)
{
    simulator_t* simulator = context;
    if (simulator->truth_log != NULL) {
        note_status(simulator, truth_drive(simulator->truth_log, now_ns, event));
    }
}

static void log_valve(void* const context, const uint64_t now_ns, const truth_valve_t* const event)
{
    simulator_t* simulator = context;
    if (simulator->truth_log != NULL) {
        note_status(simulator, truth_valve(simulator->truth_log, now_ns, event));
    }
}

// ---- One step ----

static void run_buses(simulator_t* const simulator, const uint64_t until_ns)
{
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        bus_run_until(simulator->segment[i].bus, until_ns);
    }
}

static void run_faults(simulator_t* const simulator, const uint64_t until_ns)
{
    while (faults_next_ns(&simulator->faults) < until_ns) {
        run_buses(simulator, faults_next_ns(&simulator->faults));
        const fault_t* fault = faults_apply_next(&simulator->faults, &simulator->targets);
        if (simulator->truth_log == NULL) {
            continue;
        }
        const truth_fault_t event = {
            .kind = fault_word(fault->kind), .target = fault->target, .active = fault_is_onset(fault)};
        note_status(simulator, truth_fault(simulator->truth_log, fault->time_ns, &event));
        if ((fault->kind >= FAULT_UNPLUG) && (fault->kind <= FAULT_MEND)) {
            devices_report(simulator->devices, fault->time_ns);
        }
    }
}

/// Submit the frames of the tools. With tools_in_step, each frame allows simulated time to advance by one
/// quantum.
static void run_tools(simulator_t* const simulator)
{
    const unsigned submitted  = socketcand_receive(simulator->tools);
    const uint64_t allowed_ns = submitted * simulator->tool_quantum_ns;
    if (submitted != 0U) {
        const uint64_t from_ns =
            (simulator->tool_credit_ns > simulator->time_ns) ? simulator->tool_credit_ns : simulator->time_ns;
        simulator->tool_credit_ns = from_ns + allowed_ns;
    }
}

static void log_step(simulator_t* const simulator, const uint64_t end_ns)
{
    truth_t* const log = simulator->truth_log;
    note_status(simulator, device_log_state(log, &simulator->device_log, end_ns));
    note_status(simulator, plant_log_state(log, &simulator->world, simulator->truth));
    note_status(simulator,
                plant_log_latches(log, &simulator->world, simulator->truth, simulator->is_latched));
    if (simulator->hand != NULL) {
        const hand_intent_t* intent = hand_intent(simulator->hand);
        truth_operator_t operator_  = {.grip = intent->grip, .verb = intent->verb};
        memcpy(operator_.intent_rad, intent->intent_rad, sizeof operator_.intent_rad);
        memcpy(operator_.wanted_tip_m, intent->wanted_tip_m, sizeof operator_.wanted_tip_m);
        memcpy(operator_.expected_torque_nm, intent->expected_torque_nm, sizeof operator_.expected_torque_nm);
        note_status(simulator, truth_operator(log, end_ns, &operator_));
    }
}

static void move_plant(simulator_t* const simulator, const uint64_t end_ns)
{
    devices_act(simulator->devices, &simulator->input);
    if (simulator->hand != NULL) {
        hand_step(simulator->hand, simulator->time_ns);
    }
    plant_step(simulator->plant, &simulator->input, end_ns - simulator->time_ns);
    devices_end_step(simulator->devices, simulator->time_ns, end_ns);
}

/// Perform one step: take waiting frames, run faults and buses up to the end of the step, then move the
/// plant. The plant obeys the commands that the devices have received in this step. The logs contain the
/// state at the end.
static void run_step(simulator_t* const simulator, const uint64_t end_ns)
{
    if (simulator->live != NULL) {
        live_take(simulator->live, simulator->time_ns);
    }
    if ((simulator->tools != NULL) && !simulator->tools_in_step) {
        run_tools(simulator);
    }
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        segment_take(&simulator->segment[i], simulator->time_ns);
    }
    run_faults(simulator, end_ns);
    run_buses(simulator, end_ns);
    power_unit_step(&simulator->supply, end_ns);
    if (simulator->tools != NULL) {
        socketcand_send(simulator->tools);
        simulator->tools_lost +=
            socketcand_end_step(simulator->tools, end_ns, SIMULATOR_TOOL_TIMEOUT_S * 1000U);
    }
    move_plant(simulator, end_ns);
    instrument_set_step(simulator->instruments, simulator->time_ns, end_ns);
    simulator->time_ns = end_ns;
    if (simulator->live != NULL) {
        live_report(simulator->live);
    }
    if (simulator->truth_log != NULL) {
        log_step(simulator, end_ns);
    }
}

uint64_t simulator_step(simulator_t* const simulator, const uint64_t now_ns)
{
    const uint64_t step_ns = (uint64_t)simulator->world.step_ns;
    while (((simulator->time_ns + step_ns) <= now_ns) && (plant_failure(simulator->plant) == NULL)) {
        run_step(simulator, simulator->time_ns + step_ns);
    }
    return simulator->time_ns + step_ns;
}

const char* simulator_failure(const simulator_t* const simulator)
{
    return plant_failure(simulator->plant);
}

simulator_pace_t simulator_pace(simulator_t* const simulator)
{
    if (simulator->live == NULL) {
        return (simulator_pace_t){.speed = 1.0};
    }
    if (live_is_held(simulator->live, simulator->time_ns)) { // Otherwise the next step takes the lines.
        live_take(simulator->live, simulator->time_ns);
    }
    return (simulator_pace_t){.is_held = live_is_held(simulator->live, simulator->time_ns),
                              .speed   = live_speed(simulator->live)};
}

bool simulator_may_step(simulator_t* const simulator, const uint32_t timeout_ms)
{
    if (!simulator->tools_in_step) {
        return true;
    }
    run_tools(simulator);
    if (simulator->tool_credit_ns > simulator->time_ns) {
        return true;
    }
    socketcand_wait(simulator->tools, timeout_ms);
    run_tools(simulator);
    return simulator->tool_credit_ns > simulator->time_ns;
}

// ---- Opening and closing ----

static status_t open_segment(simulator_t* const simulator, const simulator_config_t* const config,
                             const char* const name, char error[SIMULATOR_ERROR_MAX])
{
    const unsigned index    = simulator->bus_count;
    segment_config_t wanted = {.name          = name,
                               .output_path   = config->output_path,
                               .bit_rate      = BIT_RATE,
                               .data_bit_rate = DATA_BIT_RATE,
                               .seed          = (config->seed * BUS_SEEDS) + index};
    for (size_t i = 0U; i < config->bus_count; i++) {
        if (strcmp(config->bus[i].name, name) == 0) {
            wanted.address   = config->bus[i].address;
            wanted.published = config->bus[i].published;
            if (config->bus[i].bit_rate != 0U) {
                wanted.bit_rate      = config->bus[i].bit_rate;
                wanted.data_bit_rate = config->bus[i].data_bit_rate;
            }
        }
    }
    wanted.data_bit_rate = config->classic_bus ? 0U : wanted.data_bit_rate;
    simulator->bus_count++;
    return segment_open(&simulator->segment[index], &wanted, error);
}

static status_t open_segments(simulator_t* const simulator, const simulator_config_t* const config,
                              char error[SIMULATOR_ERROR_MAX])
{
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (status == STATUS_OK) && (i < SIMULATOR_BUSES_MAX); i++) {
        const char* name = channels_bus_name(&simulator->world, config, i);
        if (name == NULL) {
            break;
        }
        status = open_segment(simulator, config, name, error);
    }
    const char* surplus = channels_bus_name(&simulator->world, config, SIMULATOR_BUSES_MAX);
    if ((status == STATUS_OK) && (surplus != NULL)) {
        (void)snprintf(
            error, SIMULATOR_ERROR_MAX,
            "simulator: %s: found bus '%s' of the mission beside the buses of this world, expected "
            "at most 8 in all: remove one from the mission or from the devices of the world",
            simulator->world.path, surplus);
        return STATUS_INVALID;
    }
    return status;
}

/// Create the operator's hand if the world has one.
static status_t open_hand(simulator_t* const simulator, const simulator_config_t* const config,
                          char reason[SCENARIO_ERROR_MAX])
{
    const world_t* world = &simulator->world;
    scene_t scene;
    if (world->hand_count == 0U) {
        return hand_check_no_lines(config->scenario_path, reason);
    }
    const hand_parameters_t hand = hand_parameters_of(&world->hand[0]);
    const unsigned joystick      = world->hand[0].joystick;
    const bool knows_scene       = world->hand[0].knows_scene;
    status_t status              = knows_scene ? scene_of(world, &scene, reason) : STATUS_OK;
    if (status == STATUS_OK) {
        status =
            hand_load(&hand, knows_scene ? &scene : NULL, config->scenario_path, &simulator->hand, reason);
    }
    simulator->input.hand[joystick]         = hand_act;
    simulator->input.hand_context[joystick] = simulator->hand;
    return status;
}

static status_t open_plant(simulator_t* const simulator, const simulator_config_t* const config,
                           char error[SIMULATOR_ERROR_MAX])
{
    char reason[SCENARIO_ERROR_MAX];
    status_t status = plant_create(&simulator->world, &simulator->plant, reason);
    status          = (status == STATUS_OK) ? open_hand(simulator, config, reason) : status;
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
        return status;
    }
    simulator->truth = plant_truth(simulator->plant);
    return STATUS_OK;
}

static status_t open_devices(simulator_t* const simulator, const simulator_config_t* const config,
                             char error[SIMULATOR_ERROR_MAX])
{
    const devices_config_t wanted  = {.valve_changed = log_valve,
                                      .world         = &simulator->world,
                                      .directory     = (config->devices_path != NULL) ? config->devices_path
                                                                                      : "descriptors/devices",
                                      .truth         = simulator->truth,
                                      .plant         = simulator->plant,
                                      .segments      = simulator->segment,
                                      .channel_b     = simulator->channel_b,
                                      .seed          = config->seed,
                                      .changed       = log_change,
                                      .context       = simulator};
    simulator->input.drive         = devices_regulate;
    const status_t status          = devices_open(&wanted, &simulator->devices, error);
    simulator->input.drive_context = simulator->devices;
    return (status == STATUS_OK) ? senders_check(simulator->devices, &simulator->world, error) : status;
}

/// Fill the table of buses and devices with the names that scenarios use.
static void name_targets(simulator_t* const simulator)
{
    fault_world_t* targets = &simulator->targets;
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        const segment_t* a                 = &simulator->segment[i];
        targets->channel[i][0].name        = a->name;
        targets->channel[i][0].bus         = a->bus;
        targets->channel[i][0].flight_node = a->flight_node;
    }
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        for (unsigned k = 0U; k < simulator->bus_count; k++) {
            if ((simulator->channel_b[i] != NULL) && (simulator->segment[k].bus == simulator->channel_b[i])) {
                targets->channel[i][NODE_CHANNEL_B]      = targets->channel[k][NODE_CHANNEL_A];
                targets->channel[k][NODE_CHANNEL_A].name = NULL;
            }
        }
    }
    targets->device_count = devices_count(simulator->devices);
    for (unsigned i = 0U; i < targets->device_count; i++) {
        const world_device_t* description = device_entry(simulator->devices, i);
        const device_model_t* model       = device_model(simulator->devices, i);
        targets->device[i]                = (fault_device_t){.name      = description->name,
                                                             .bus       = description->bus,
                                                             .id        = description->node,
                                                             .node      = model->node,
                                                             .drive     = device_drive(simulator->devices, i),
                                                             .set_error = model->set_error,
                                                             .model     = model->model};
    }
    for (size_t i = 0U; i < simulator->world.power_unit_count; i++) {
        const world_device_t* description      = &simulator->world.power_unit[i].device;
        targets->device[targets->device_count] = (fault_device_t){.name = description->name,
                                                                  .bus  = description->bus,
                                                                  .id   = description->node,
                                                                  .unit = &simulator->supply};
        targets->device_count++;
    }
    targets->instrument_count = instrument_set_count(simulator->instruments);
    for (unsigned i = 0U; i < targets->instrument_count; i++) {
        targets->instrument[i] =
            (fault_instrument_t){.name       = instrument_set_name(simulator->instruments, i),
                                 .instrument = instrument_set_at(simulator->instruments, i)};
    }
}

static status_t open_faults(simulator_t* const simulator, const simulator_config_t* const config,
                            char error[SIMULATOR_ERROR_MAX])
{
    char reason[SCENARIO_ERROR_MAX];
    name_targets(simulator);
    simulator->targets.process         = config->process_fault;
    simulator->targets.check_process   = config->process_check;
    simulator->targets.process_context = config->process_context;
    const status_t status =
        faults_load(&simulator->faults, &simulator->targets, config->scenario_path, reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
    }
    return status;
}

static status_t read_world(simulator_t* const simulator, const simulator_config_t* const config,
                           char error[SIMULATOR_ERROR_MAX])
{
    char reason[DOCUMENT_ERROR_MAX];
    const status_t status = world_read(config->world_path, &simulator->world, reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
        return status;
    }
    spread_apply(&simulator->world, config->seed);
    return status;
}

static status_t open_truth(simulator_t* const simulator, const simulator_config_t* const config,
                           char error[SIMULATOR_ERROR_MAX])
{
    char path[PATH_OCTETS];
    if (config->output_path == NULL) {
        return STATUS_OK;
    }
    (void)snprintf(path, sizeof path, "%s/truth.lcm", config->output_path);
    status_t status = truth_open(path, TRUTH_OCTETS_MAX, &simulator->truth_log);
    status = (status == STATUS_OK) ? plant_log_names(simulator->truth_log, &simulator->world) : status;
    simulator->device_log = (device_log_t){.world       = &simulator->world,
                                           .devices     = simulator->devices,
                                           .instruments = simulator->instruments,
                                           .segments    = simulator->segment,
                                           .bus_count   = simulator->bus_count};
    status = (status == STATUS_OK) ? device_log_names(simulator->truth_log, &simulator->device_log) : status;
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: cannot write truth.lcm in '%s'; does the directory exist?",
                       config->output_path);
    }
    return status;
}

static status_t open_tools(simulator_t* const simulator, const simulator_config_t* const config,
                           char error[SIMULATOR_ERROR_MAX])
{
    socketcand_bus_t buses[SIMULATOR_BUSES_MAX];
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        buses[i] = (socketcand_bus_t){simulator->segment[i].name, simulator->segment[i].bus};
    }
    if (!config->serve_tools) {
        return STATUS_OK;
    }
    simulator->tools_in_step = config->tools_in_step;
    simulator->tool_quantum_ns =
        (config->tool_quantum_ns != 0U) ? config->tool_quantum_ns : DEFAULT_QUANTUM_NS;
    const status_t status =
        socketcand_open(config->tool_port, buses, simulator->bus_count, &simulator->tools);
    if (status != STATUS_OK) {
        (void)snprintf(
            error, SIMULATOR_ERROR_MAX,
            "simulator: cannot listen on port %u for tools (%s); use --socketcand 0 for any free port",
            (unsigned)config->tool_port, status_text(status));
    }
    return status;
}

static status_t open_live(simulator_t* const simulator, const simulator_config_t* const config,
                          char error[SIMULATOR_ERROR_MAX])
{
    const live_config_t wanted = {.directory = config->output_path,
                                  .hand      = simulator->hand,
                                  .faults    = &simulator->faults,
                                  .targets   = &simulator->targets,
                                  .world     = &simulator->world,
                                  .truth     = simulator->truth,
                                  .is_paced  = config->is_paced};
    if (!config->is_live) {
        return STATUS_OK;
    }
    const status_t status = live_open(&wanted, &simulator->live);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: cannot open the live port, or write live.port and live.scn in '%s'; does "
                       "the directory exist?",
                       config->output_path);
    }
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        simulator->segment[i].live = simulator->live;
    }
    return status;
}

static void power_on(simulator_t* const simulator)
{
    devices_power_on(simulator->devices);
    for (size_t i = 0U; i < simulator->world.power_unit_count; i++) {
        const world_power_unit_t* unit = &simulator->world.power_unit[i];
        supply_open(&simulator->supply, unit, simulator->segment, simulator->bus_count,
                    simulator->channel_b[unit->device.bus], simulator->devices);
    }
}

status_t simulator_open(const simulator_config_t* const config, simulator_t** const out_simulator,
                        char error[SIMULATOR_ERROR_MAX])
{
    *out_simulator         = NULL;
    simulator_t* simulator = calloc(1U, sizeof *simulator);
    if (simulator == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: out of memory");
        return STATUS_EXHAUSTED;
    }
    status_t status = read_world(simulator, config, error);
    status          = (status == STATUS_OK) ? open_segments(simulator, config, error) : status;
    status          = (status == STATUS_OK) ? channels_pair(simulator->segment, simulator->bus_count, config,
                                                            simulator->channel_b, error)
                                            : status;
    status          = (status == STATUS_OK) ? open_plant(simulator, config, error) : status;
    status          = (status == STATUS_OK) ? open_devices(simulator, config, error) : status;
    if (status == STATUS_OK) {
        channels_report_unused(simulator->segment, simulator->bus_count, config);
        status = instrument_set_open(&simulator->world, config, &simulator->instruments, error);
    }
    status = (status == STATUS_OK) ? open_faults(simulator, config, error) : status;
    status = (status == STATUS_OK) ? open_truth(simulator, config, error) : status;
    status = (status == STATUS_OK) ? open_tools(simulator, config, error) : status;
    status = (status == STATUS_OK) ? open_live(simulator, config, error) : status;
    if (status != STATUS_OK) {
        (void)simulator_close(simulator);
        return status;
    }
    power_on(simulator);
    *out_simulator = simulator;
    return STATUS_OK;
}

status_t simulator_close(simulator_t* const simulator)
{
    if (simulator == NULL) {
        return STATUS_OK;
    }
    bool is_complete = (truth_close(simulator->truth_log) == STATUS_OK) && !simulator->is_truth_broken;
    is_complete      = (live_close(simulator->live) == STATUS_OK) && is_complete;
    socketcand_close(simulator->tools);
    is_complete = (instrument_set_close(simulator->instruments) == STATUS_OK) && is_complete;
    devices_close(simulator->devices);
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        is_complete = (segment_close(&simulator->segment[i]) == STATUS_OK) && is_complete;
    }
    faults_free(&simulator->faults);
    hand_destroy(simulator->hand);
    plant_destroy(simulator->plant);
    free(simulator);
    return is_complete ? STATUS_OK : STATUS_IO;
}

const char* simulator_bus_name(const simulator_t* const simulator, const unsigned index)
{
    return (index < simulator->bus_count) ? simulator->segment[index].name : NULL;
}

uint16_t simulator_tool_port(const simulator_t* const simulator)
{
    return (simulator->tools != NULL) ? socketcand_port(simulator->tools) : 0U;
}

void simulator_statistics(const simulator_t* const simulator, simulator_statistics_t* const out_statistics)
{
    *out_statistics = (simulator_statistics_t){
        .tool_dropped = (simulator->tools != NULL) ? socketcand_dropped(simulator->tools) : 0U,
        .tools_lost   = simulator->tools_lost,
        .undelivered  = instrument_set_lost(simulator->instruments)};
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        out_statistics->busy_ns[i] = bus_statistics(simulator->segment[i].bus)->busy_ns;
        out_statistics->refused += simulator->segment[i].refused;
        if (simulator->segment[i].gateway != NULL) {
            const gateway_counters_t* gateway = gateway_counters(simulator->segment[i].gateway);
            out_statistics->tool_frames += gateway->from_tools;
            out_statistics->unpublished += gateway->unpublished;
        }
    }
}

void simulator_flush(simulator_t* const simulator, const bool waits)
{
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        if (simulator->segment[i].log != NULL) {
            frame_log_flush(simulator->segment[i].log, waits);
        }
    }
    instrument_set_flush(simulator->instruments);
    if (simulator->truth_log != NULL) {
        truth_flush(simulator->truth_log, waits);
    }
}
