// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/subsystems/arm/arm_rig.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define CYCLES_MAX 4000U
#define BUSES 2U
#define JOINTS_OF_A_BUS 3U
#define TORQUE_UNIT_NM 0.01 // Rated torque of the scripted drives: 10 Nm, per mille.

static descriptor_loader_t loader;
static scripted_bus_t buses[BUSES];
static const char* const bus_names[BUSES] = {"arm-1", "arm-2"};
static const subsystem_callbacks_t* callbacks;
subsystem_descriptor_t rig_descriptor;
scripted_node_t* rig_joints[RIG_JOINTS];
subsystem_t rig_generic;
arm_t rig_arm;
const double rig_pose_rad[RIG_JOINTS] = {0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.2};

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    for (unsigned i = 0U; i < BUSES; i++) {
        if ((kind == ENDNODE_CAN) && (strcmp(name, bus_names[i]) == 0)) {
            (void)strcpy(out_address->address, buses[i].address);
            out_address->is_fd = true;
            return STATUS_OK;
        }
    }
    return STATUS_NOT_FOUND;
}

static const flow_resolver_t resolver = {NULL, resolve};

void rig_load(void)
{
    descriptor_loader_init(&loader);
    const status_t status =
        descriptor_load_subsystem(&loader, "descriptors/subsystems/ur5e.xml", &rig_descriptor);
    TEST_ASSERT_EQUAL_MESSAGE(STATUS_OK, status, descriptor_error(&loader));
    subsystem_misfit_t misfit = {0U, "", 0U};
    TEST_ASSERT_TRUE_MESSAGE(arm_callbacks()->fits(&rig_descriptor, &misfit), misfit.reason);
}

void rig_set_up(void)
{
    callbacks = arm_callbacks();
    scripted_bus_open(&buses[0], "test-arm-1");
    scripted_bus_open(&buses[1], "test-arm-2");
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        rig_joints[i] = scripted_bus_add(&buses[i / JOINTS_OF_A_BUS], SCRIPTED_DRIVE, (uint8_t)(0x51U + i));
        scripted_object(rig_joints[i], 0x6072U, 0U)->value = 15000U;
        scripted_object(rig_joints[i], 0x1018U, 2U)->value = (i < JOINTS_OF_A_BUS) ? 0x4011U : 0x4010U;
    }
    double_init(&rig_generic, &rig_descriptor, callbacks, &rig_arm);
    rig_generic.period_ns = 1000000U;
    arm_init(&rig_arm, &rig_generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&rig_generic));
    rig_show(rig_pose_rad);
}

void rig_tear_down(void)
{
    callbacks->release(&rig_arm);
    scripted_bus_close(&buses[0]);
    scripted_bus_close(&buses[1]);
}

void rig_model(arm_model_t* const out_model, arm_limits_t* const out_limits)
{
    double_init(&rig_generic, &rig_descriptor, arm_callbacks(), &rig_arm);
    arm_init(&rig_arm, &rig_generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&rig_generic));
    TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(&rig_arm.parameters, RIG_JOINTS, out_model));
    arm_limits_of_parameters(&rig_arm.parameters, RIG_JOINTS, out_limits);
}

void rig_show(const double pose_rad[RIG_JOINTS])
{
    arm_model_t model;
    arm_motion_t still = {.position_rad = {0.0}};
    double weight_nm[ARM_JOINTS_MAX];
    TEST_ASSERT_EQUAL(STATUS_OK, arm_model_of_parameters(&rig_arm.parameters, RIG_JOINTS, &model));
    memcpy(still.position_rad, pose_rad, RIG_JOINTS * sizeof pose_rad[0]);
    arm_inverse_dynamics(&model, &still, weight_nm);
    for (unsigned i = 0U; i < RIG_JOINTS; i++) {
        const double motor_rad     = pose_rad[i] + (weight_nm[i] / rig_arm.parameters.drives.stiffness[i]);
        rig_joints[i]->torque[0]   = (int16_t)lround(weight_nm[i] / TORQUE_UNIT_NM);
        rig_joints[i]->position[0] = (int32_t)lround(motor_rad * 1.0e6);
    }
}

static bool is_controlled(void)
{
    return (rig_generic.configuration != NULL) && (rig_generic.state >= STATE_PRE_OPERATIONAL) &&
           (rig_generic.state <= STATE_ERROR_OPERATIONAL);
}

status_t rig_cycle(const rig_action_t action)
{
    const status_t status = double_cycle(&rig_generic, action, is_controlled());
    for (unsigned i = 0U; i < BUSES; i++) {
        scripted_bus_run(&buses[i]);
    }
    rig_generic.now_ns += rig_generic.period_ns;
    if ((rig_generic.now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&buses[0]);
        scripted_bus_heartbeat(&buses[1]);
    }
    return status;
}

void rig_idle(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        (void)rig_cycle(NULL);
    }
}

static status_t run(const rig_action_t action)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < CYCLES_MAX); i++) {
        status = rig_cycle(action);
    }
    return status;
}

static status_t configure(void* const self)
{
    return callbacks->configure(self, rig_generic.configuration);
}

void rig_bring(const uint16_t configuration, const state_t state)
{
    rig_generic.state = STATE_HARDWARE_INIT;
    TEST_ASSERT_EQUAL(STATUS_OK, run(callbacks->hardware_init));
    rig_generic.state         = STATE_PRE_OPERATIONAL;
    rig_generic.configuration = descriptor_find_configuration(&rig_descriptor, configuration);
    double_set_initials(&rig_generic, rig_generic.configuration);
    TEST_ASSERT_EQUAL(STATUS_OK, run(configure));
    rig_generic.state = STATE_SAFE_OPERATIONAL;
    TEST_ASSERT_EQUAL(STATUS_OK, run(callbacks->start_control));
    if (state == STATE_OPERATIONAL) {
        rig_generic.state = STATE_OPERATIONAL;
        TEST_ASSERT_EQUAL(STATUS_OK, run(callbacks->engage));
    }
}

status_t rig_perform(const uint16_t function, const void* const arguments, const uint32_t call_token)
{
    const subsystem_function_t call = {
        .function_id = function, .arguments = arguments, .call_token = call_token};
    return callbacks->perform(&rig_arm, &call);
}
