// SPDX-License-Identifier: Apache-2.0
#include "sim/app/simulator.h"

#include "sim/app/channels.h"
#include "sim/app/bench_devices.h"
#include "sim/app/segment.h"
#include "sim/app/supply.h"
#include "sim/devices/drive.h"
#include "sim/devices/joystick.h"
#include "sim/operator/hand.h"
#include "sim/parameters/rokviss.h"
#include "sim/plant/plant.h"
#include "sim/socketcand/socketcand.h"
#include "sim/truth/truth.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BUSES 2U ///< The first buses, of arm and joystick; others follow.
#define ROBOT 0U
#define JOYSTICK 1U
#define DRIVES PLANT_JOINTS
#define JOINT1_ID 0x11U
#define STICK_ID 0x21U
#define DEFAULT_QUANTUM_NS 5000000U
#define TOOL_PATIENCE_MS 20000U ///< For a tool in lock-step; shorter than the launcher's for simulated time.
#define PATH_OCTETS 4096U

static const char* const bus_names[BUSES] = {"robot", "joystick"};

/// Joint as its drive sees it.
typedef struct {
    simulator_t* simulator;
    unsigned number;
} joint_t;

struct simulator {
    uint64_t time_ns;
    segment_t segment[SIMULATOR_BUSES_MAX];
    bus_t* channel_b[SIMULATOR_BUSES_MAX]; ///< Channel B of each segment; null: it has none.
    unsigned bus_count;
    bench_devices_t* bench_devices;
    plant_t* plant;
    const plant_truth_t* truth;
    plant_input_t input;
    hand_t* hand;
    truth_t* truth_log;
    bool is_truth_broken;
    drive_t* drive[DRIVES];
    joint_t joint[DRIVES];
    joystick_t* joystick;
    faults_t faults;
    fault_world_t world;
    power_unit_t supply; // Power unit of the drives.
    socketcand_t* tools;
    bool tools_in_step;
    uint64_t tools_lost; // In lock-step, and not done with a step in time.
    uint64_t tool_quantum_ns;
    uint64_t tool_credit_ns; // Time up to which the tool has sent frames.
};

// ---- Truth ----

static void note(simulator_t* const simulator, const status_t status)
{
    simulator->is_truth_broken = simulator->is_truth_broken || (status != STATUS_OK);
}

static void log_change(void* const context, const uint64_t now_ns, const truth_drive_t* const event)
{
    simulator_t* simulator = context;
    if (simulator->truth_log != NULL) {
        note(simulator, truth_drive(simulator->truth_log, now_ns, event));
    }
}

static void log_drive(simulator_t* const simulator, const uint64_t now_ns, const uint8_t node,
                      const unsigned axis, const uint16_t statusword, const bool brake, const bool is_plugged)
{
    const truth_drive_t event = {.bus           = bus_names[(node == STICK_ID) ? JOYSTICK : ROBOT],
                                 .node          = node,
                                 .axis          = (uint8_t)axis,
                                 .statusword    = statusword,
                                 .plugged       = is_plugged,
                                 .brake_engaged = brake};
    log_change(simulator, now_ns, &event);
}

static node_t* device_by_id(simulator_t* const simulator, const uint8_t id)
{
    return (id == STICK_ID) ? joystick_node(simulator->joystick)
                            : drive_node(simulator->drive[id - JOINT1_ID]);
}

static void on_axis(void* const context, const uint8_t node, const unsigned axis, const uint16_t statusword,
                    const bool brake, const uint64_t now_ns)
{
    simulator_t* simulator = context;
    const bool is_plugged  = node_is_plugged(device_by_id(simulator, node));
    log_drive(simulator, now_ns, node, axis, statusword, brake, is_plugged);
}

/// Report the state of every device: at the start, and after one was plugged or unplugged.
static void log_devices(simulator_t* const simulator, const uint64_t now_ns)
{
    for (unsigned i = 0U; i < DRIVES; i++) {
        drive_t* drive = simulator->drive[i];
        log_drive(simulator, now_ns, (uint8_t)(JOINT1_ID + i), 0U, drive_statusword(drive),
                  drive_brake_is_engaged(drive), node_is_plugged(drive_node(drive)));
    }
    for (unsigned i = 0U; i < JOYSTICK_AXES; i++) {
        log_drive(simulator, now_ns, STICK_ID, i, joystick_statusword(simulator->joystick, i), false,
                  node_is_plugged(joystick_node(simulator->joystick)));
    }
    bench_devices_report(simulator->bench_devices, now_ns);
}

static void log_arm(simulator_t* const simulator, const uint64_t now_ns)
{
    const plant_truth_t* truth = simulator->truth;
    truth_joints_t joints;
    truth_contact_t contact = {.in_contact = truth->in_contact, .spring_hooked = truth->spring_hooked};
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        joints.position_rad[i]       = truth->link_position_rad[i];
        joints.velocity_rad_s[i]     = truth->link_velocity_rad_s[i];
        joints.motor_position_rad[i] = truth->motor[i].position_rad;
        joints.motor_torque_nm[i]    = truth->motor_torque_nm[i];
        joints.joint_torque_nm[i]    = truth->joint_torque_nm[i];
        joints.friction_nm[i]        = truth->friction_nm[i];
        joints.brake_engaged[i]      = truth->brake_engaged[i];
    }
    memcpy(contact.tip_m, truth->tip_m, sizeof contact.tip_m);
    memcpy(contact.contact_point_m, truth->contact_point_m, sizeof contact.contact_point_m);
    memcpy(contact.contact_force_n, truth->contact_force_n, sizeof contact.contact_force_n);
    memcpy(contact.spring_force_n, truth->spring_force_n, sizeof contact.spring_force_n);
    memcpy(contact.external_torque_nm, truth->external_torque_nm, sizeof contact.external_torque_nm);
    note(simulator, truth_joints(simulator->truth_log, now_ns, &joints));
    note(simulator, truth_contact(simulator->truth_log, now_ns, &contact));
}

static void log_operator(simulator_t* const simulator, const uint64_t now_ns)
{
    const plant_truth_t* truth  = simulator->truth;
    const hand_intent_t* intent = hand_intent(simulator->hand);
    truth_stick_t stick;
    truth_operator_t operator_ = {.grip = intent->grip, .verb = intent->verb};
    for (unsigned i = 0U; i < PLANT_AXES; i++) {
        stick.position_rad[i]    = truth->stick_position_rad[i];
        stick.velocity_rad_s[i]  = truth->stick_velocity_rad_s[i];
        stick.motor_torque_nm[i] = truth->stick_torque_nm[i];
        stick.hand_torque_nm[i]  = truth->hand_torque_nm[i];
    }
    memcpy(operator_.intent_rad, intent->intent_rad, sizeof operator_.intent_rad);
    memcpy(operator_.wanted_tip_m, intent->wanted_tip_m, sizeof operator_.wanted_tip_m);
    memcpy(operator_.expected_torque_nm, intent->expected_torque_nm, sizeof operator_.expected_torque_nm);
    note(simulator, truth_stick(simulator->truth_log, now_ns, &stick));
    note(simulator, truth_operator(simulator->truth_log, now_ns, &operator_));
}

// ---- Devices: inputs and outputs ----

static void look_at_joint(void* const context, drive_truth_t* const out_truth)
{
    const joint_t* joint            = context;
    const plant_truth_t* truth      = joint->simulator->truth;
    out_truth->motor_position_rad   = truth->motor[joint->number].position_rad;
    out_truth->motor_velocity_rad_s = truth->motor[joint->number].velocity_rad_s;
    out_truth->joint_torque_nm      = truth->joint_torque_nm[joint->number];
}

static void look_at_stick(void* const context, joystick_truth_t* const out_truth)
{
    const simulator_t* simulator = context;
    out_truth->buttons           = 0U;
    memcpy(out_truth->position_rad, simulator->truth->stick_position_rad, sizeof out_truth->position_rad);
    memcpy(out_truth->velocity_rad_s, simulator->truth->stick_velocity_rad_s,
           sizeof out_truth->velocity_rad_s);
}

static void drive_motors(void* const context, const unsigned substep, const plant_rotor_t motor[PLANT_JOINTS],
                         double out_torque_nm[PLANT_JOINTS])
{
    simulator_t* simulator = context;
    (void)substep;
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        out_torque_nm[i] =
            drive_regulate(simulator->drive[i], motor[i].position_rad, motor[i].velocity_rad_s);
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
        const fault_t* fault = faults_apply_next(&simulator->faults, &simulator->world);
        if (simulator->truth_log == NULL) {
            continue;
        }
        const truth_fault_t event = {
            .kind = fault_word(fault->kind), .target = fault->target, .active = fault_is_onset(fault)};
        note(simulator, truth_fault(simulator->truth_log, fault->time_ns, &event));
        if ((fault->kind >= FAULT_UNPLUG) && (fault->kind <= FAULT_MEND)) {
            log_devices(simulator, fault->time_ns);
        }
    }
}

static void run_tools(simulator_t* const simulator)
{
    const unsigned submitted = socketcand_receive(simulator->tools);
    const uint64_t bought_ns = submitted * simulator->tool_quantum_ns;
    if (submitted != 0U) {
        const uint64_t from_ns =
            (simulator->tool_credit_ns > simulator->time_ns) ? simulator->tool_credit_ns : simulator->time_ns;
        simulator->tool_credit_ns = from_ns + bought_ns;
    }
}

static void move_plant(simulator_t* const simulator, const uint64_t end_ns)
{
    for (unsigned i = 0U; i < PLANT_JOINTS; i++) {
        simulator->input.brake_engaged[i] = drive_brake_is_engaged(simulator->drive[i]);
    }
    joystick_torque(simulator->joystick, simulator->input.stick_torque_nm);
    hand_step(simulator->hand, simulator->time_ns);
    plant_step(simulator->plant, &simulator->input, end_ns - simulator->time_ns);
    for (unsigned i = 0U; i < DRIVES; i++) {
        drive_end_step(simulator->drive[i], end_ns);
    }
    joystick_end_step(simulator->joystick, end_ns);
    bench_devices_move(simulator->bench_devices, simulator->time_ns, end_ns);
}

static void run_step(simulator_t* const simulator, const uint64_t end_ns)
{
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
        simulator->tools_lost += socketcand_end_step(simulator->tools, end_ns, TOOL_PATIENCE_MS);
    }
    move_plant(simulator, end_ns);
    simulator->time_ns = end_ns;
    if (simulator->truth_log != NULL) {
        log_arm(simulator, end_ns);
        log_operator(simulator, end_ns);
    }
}

uint64_t simulator_step(simulator_t* const simulator, const uint64_t now_ns)
{
    while ((simulator->time_ns + ROKVISS_STEP_NS) <= now_ns) {
        run_step(simulator, simulator->time_ns + ROKVISS_STEP_NS);
    }
    return simulator->time_ns + ROKVISS_STEP_NS;
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

/// Name of bus `index`: the arm's and the joystick's, then the others as they are given.
static const char* bus_name(const simulator_config_t* const config, const unsigned index)
{
    unsigned others = BUSES;
    if (index < BUSES) {
        return bus_names[index];
    }
    for (size_t i = 0U; i < config->bus_count; i++) {
        const char* name = config->bus[i].name;
        if ((strcmp(name, bus_names[ROBOT]) != 0) && (strcmp(name, bus_names[JOYSTICK]) != 0)) {
            if (others == index) {
                return name;
            }
            others++;
        }
    }
    return NULL;
}

static status_t open_segment(simulator_t* const simulator, const simulator_config_t* const config,
                             const char* const name, char error[SIMULATOR_ERROR_MAX])
{
    const unsigned index    = simulator->bus_count;
    segment_config_t wanted = {.name        = name,
                               .output_path = config->output_path,
                               .is_classic  = config->classic_bus,
                               .seed        = (config->seed * BUSES) + index};
    for (size_t i = 0U; i < config->bus_count; i++) {
        if (strcmp(config->bus[i].name, name) == 0) {
            wanted.address    = config->bus[i].address;
            wanted.published  = config->bus[i].published;
            wanted.is_classic = config->classic_bus || config->bus[i].is_classic;
        }
    }
    simulator->bus_count++;
    return segment_open(&simulator->segment[index], &wanted, error);
}

static status_t open_segments(simulator_t* const simulator, const simulator_config_t* const config,
                              char error[SIMULATOR_ERROR_MAX])
{
    status_t status = STATUS_OK;
    for (unsigned i = 0U; (status == STATUS_OK) && (i < SIMULATOR_BUSES_MAX); i++) {
        const char* name = bus_name(config, i);
        if (name == NULL) {
            break;
        }
        status = open_segment(simulator, config, name, error);
    }
    return status;
}

static status_t open_bench_devices(simulator_t* const simulator, const simulator_config_t* const config,
                                   const char* const folder, char error[SIMULATOR_ERROR_MAX])
{
    const bench_devices_config_t wanted = {.path          = config->bench_path,
                                           .devices_path  = folder,
                                           .segments      = simulator->segment,
                                           .segment_count = simulator->bus_count,
                                           .channel_b     = simulator->channel_b,
                                           .seed          = config->seed,
                                           .changed       = log_change,
                                           .context       = simulator};
    return (config->bench_path != NULL) ? bench_devices_open(&wanted, &simulator->bench_devices, error)
                                        : STATUS_OK;
}

static status_t open_drive(simulator_t* const simulator, const unsigned number,
                           const simulator_config_t* const config, const char* const folder,
                           char error[SIMULATOR_ERROR_MAX])
{
    char path[PATH_OCTETS];
    char reason[EDS_ERROR_MAX];
    joint_t* joint              = &simulator->joint[number];
    const uint8_t id            = (uint8_t)(JOINT1_ID + number);
    const drive_config_t wanted = {.seed             = config->seed,
                                   .sensor_device    = (ROBOT << 8) | id,
                                   .step_ns          = ROKVISS_STEP_NS,
                                   .substep_ns       = ROKVISS_STEP_NS / PLANT_SUBSTEPS,
                                   .torque_sensor    = rokviss_torque_sensor,
                                   .encoder          = rokviss_joint_encoder,
                                   .look             = look_at_joint,
                                   .look_context     = joint,
                                   .observer         = on_axis,
                                   .observer_context = simulator};
    *joint                      = (joint_t){.simulator = simulator, .number = number};
    (void)snprintf(path, sizeof path, "%s/joint-drive.eds", folder);
    const status_t status =
        drive_create(simulator->segment[ROBOT].bus, path, id, &wanted, &simulator->drive[number], reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
        return status;
    }
    return channels_connect(drive_node(simulator->drive[number]), simulator->channel_b[ROBOT],
                            bus_names[ROBOT], error);
}

static status_t open_devices(simulator_t* const simulator, const simulator_config_t* const config,
                             char error[SIMULATOR_ERROR_MAX])
{
    char path[PATH_OCTETS];
    char reason[EDS_ERROR_MAX];
    const char* folder = (config->devices_path != NULL) ? config->devices_path : "descriptors/devices";
    const joystick_config_t wanted = {.encoder          = rokviss_stick_encoder,
                                      .look             = look_at_stick,
                                      .look_context     = simulator,
                                      .observer         = on_axis,
                                      .observer_context = simulator};
    status_t status                = STATUS_OK;
    for (unsigned i = 0U; (i < DRIVES) && (status == STATUS_OK); i++) {
        status = open_drive(simulator, i, config, folder, error);
    }
    if (status != STATUS_OK) {
        return status;
    }
    (void)snprintf(path, sizeof path, "%s/joystick.eds", folder);
    status = joystick_create(simulator->segment[JOYSTICK].bus, path, STICK_ID, &wanted, &simulator->joystick,
                             reason);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
        return status;
    }
    status = channels_connect(joystick_node(simulator->joystick), simulator->channel_b[JOYSTICK],
                              bus_names[JOYSTICK], error);
    return (status == STATUS_OK) ? open_bench_devices(simulator, config, folder, error) : status;
}

static status_t open_world(simulator_t* const simulator, const simulator_config_t* const config,
                           char error[SIMULATOR_ERROR_MAX])
{
    char reason[SCENARIO_ERROR_MAX];
    const plant_options_t options = {.gravity = true, .seed = (uint32_t)config->seed};
    simulator->plant              = plant_create(&rokviss_plant, &options);
    if (simulator->plant == NULL) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: out of memory");
        return STATUS_EXHAUSTED;
    }
    simulator->truth = plant_truth(simulator->plant);
    status_t status =
        hand_load(&rokviss_hand, &rokviss_plant, config->scenario_path, &simulator->hand, reason);
    if (status == STATUS_OK) {
        status = faults_load(&simulator->faults, config->scenario_path, reason);
    }
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX, "simulator: %s", reason);
    }
    simulator->input = (plant_input_t){
        .drive = drive_motors, .drive_context = simulator, .hand = hand_act, .hand_context = simulator->hand};
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
    const status_t status = truth_open(path, &simulator->truth_log);
    if (status != STATUS_OK) {
        (void)snprintf(error, SIMULATOR_ERROR_MAX,
                       "simulator: cannot write truth.lcm in '%s'; does the folder exist?",
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

static void power_on(simulator_t* const simulator)
{
    simulator->world.joystick = simulator->joystick;
    for (unsigned i = 0U; i < BUSES; i++) {
        fault_channel_t* channels = simulator->world.channel[i];
        channels[NODE_CHANNEL_A] =
            (fault_channel_t){simulator->segment[i].bus, simulator->segment[i].flight_node};
        for (unsigned k = 0U; k < simulator->bus_count; k++) {
            if ((simulator->channel_b[i] != NULL) && (simulator->segment[k].bus == simulator->channel_b[i])) {
                channels[NODE_CHANNEL_B] =
                    (fault_channel_t){simulator->segment[k].bus, simulator->segment[k].flight_node};
            }
        }
    }
    for (unsigned i = 0U; i < DRIVES; i++) {
        simulator->world.drive[i] = simulator->drive[i];
        node_power_on(drive_node(simulator->drive[i]));
    }
    supply_open(&simulator->supply, simulator->segment, simulator->bus_count, ROBOT,
                simulator->channel_b[ROBOT], simulator->drive, DRIVES);
    node_power_on(joystick_node(simulator->joystick));
    bench_devices_power_on(simulator->bench_devices);
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
    status_t status = open_segments(simulator, config, error);
    status          = (status == STATUS_OK) ? channels_pair(simulator->segment, simulator->bus_count, config,
                                                            simulator->channel_b, error)
                                            : status;
    status          = (status == STATUS_OK) ? open_world(simulator, config, error) : status;
    status          = (status == STATUS_OK) ? open_devices(simulator, config, error) : status;
    status          = (status == STATUS_OK) ? open_truth(simulator, config, error) : status;
    status          = (status == STATUS_OK) ? open_tools(simulator, config, error) : status;
    if (status != STATUS_OK) {
        (void)simulator_close(simulator);
        return status;
    }
    simulator->world.process         = config->process_fault;
    simulator->world.process_context = config->process_context;
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
    socketcand_close(simulator->tools);
    joystick_destroy(simulator->joystick);
    for (unsigned i = 0U; i < DRIVES; i++) {
        drive_destroy(simulator->drive[i]);
    }
    bench_devices_close(simulator->bench_devices);
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        is_complete = (segment_close(&simulator->segment[i]) == STATUS_OK) && is_complete;
    }
    hand_destroy(simulator->hand);
    plant_destroy(simulator->plant);
    free(simulator);
    return is_complete ? STATUS_OK : STATUS_IO;
}

uint16_t simulator_tool_port(const simulator_t* const simulator)
{
    return (simulator->tools != NULL) ? socketcand_port(simulator->tools) : 0U;
}

void simulator_statistics(const simulator_t* const simulator, simulator_statistics_t* const out_statistics)
{
    const bus_statistics_t* robot    = bus_statistics(simulator->segment[ROBOT].bus);
    const bus_statistics_t* joystick = bus_statistics(simulator->segment[JOYSTICK].bus);
    *out_statistics                  = (simulator_statistics_t){
                         .robot_frames     = robot->frames,
                         .joystick_frames  = joystick->frames,
                         .robot_busy_ns    = robot->busy_ns,
                         .joystick_busy_ns = joystick->busy_ns,
                         .refused          = simulator->segment[ROBOT].refused + simulator->segment[JOYSTICK].refused,
                         .tool_dropped     = (simulator->tools != NULL) ? socketcand_dropped(simulator->tools) : 0U,
                         .tools_lost       = simulator->tools_lost};
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        if (simulator->segment[i].gateway != NULL) {
            const gateway_counters_t* gateway = gateway_counters(simulator->segment[i].gateway);
            out_statistics->tool_frames += gateway->from_tools;
            out_statistics->unshown += gateway->unshown;
        }
    }
}

void simulator_flush(simulator_t* const simulator)
{
    for (unsigned i = 0U; i < simulator->bus_count; i++) {
        if (simulator->segment[i].log != NULL) {
            frame_log_flush(simulator->segment[i].log);
        }
    }
}
