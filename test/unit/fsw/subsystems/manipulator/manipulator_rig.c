// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/subsystems/manipulator/manipulator_rig.h"

#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define CYCLES_MAX 4000U

static descriptor_loader_t loader;
subsystem_descriptor_t rig_descriptor;
scripted_bus_t rig_bus;
static scripted_bus_t channel_b; // No device is connected to it.
scripted_node_t* rig_joints[2];
subsystem_t rig_generic;
manipulator_t rig_manipulator;
const subsystem_callbacks_t* rig_callbacks;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    const bool is_b = (strcmp(name, "robot-b") == 0);
    if ((kind != ENDNODE_CAN) || (!is_b && (strcmp(name, "robot") != 0))) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, is_b ? channel_b.address : rig_bus.address);
    out_address->is_fd = true;
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

/// Set the values that the drives report: those of a motionless arm in its home pose. A joint torque is the
/// torque of gravity plus a sensor offset.
void rig_show(const double torque1_nm, const double torque2_nm)
{
    rig_joints[0]->torque[0]   = (int16_t)lround(torque1_nm * 100.0);
    rig_joints[1]->torque[0]   = (int16_t)lround(torque2_nm * 100.0);
    rig_joints[0]->position[0] = (int32_t)lround((1.0471975512 + (torque1_nm / 8000.0)) * 1.0e6);
    rig_joints[1]->position[0] = (int32_t)lround((-1.5707963268 + (torque2_nm / 8000.0)) * 1.0e6);
}

void rig_set_up(void)
{
    rig_callbacks = manipulator_callbacks();
    scripted_bus_open(&rig_bus, "test-manipulator");
    scripted_bus_open(&channel_b, "test-manipulator-b");
    rig_joints[0] = scripted_bus_add(&rig_bus, SCRIPTED_DRIVE, 0x11U);
    rig_joints[1] = scripted_bus_add(&rig_bus, SCRIPTED_DRIVE, 0x12U);
    rig_show(GRAVITY1, GRAVITY2);
    double_init(&rig_generic, &rig_descriptor, rig_callbacks, &rig_manipulator);
    TEST_ASSERT_NOT_NULL(rig_generic.descriptor);
    manipulator_init(&rig_manipulator, &rig_generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&rig_generic));
}

void rig_tear_down(void)
{
    drives_release(&rig_manipulator.drives);
    scripted_bus_close(&rig_bus);
    scripted_bus_close(&channel_b);
}

static bool is_controlled(void)
{
    return (rig_generic.configuration != NULL) && (rig_generic.state >= STATE_PRE_OPERATIONAL) &&
           (rig_generic.state <= STATE_ERROR_OPERATIONAL);
}

status_t rig_cycle(const rig_action_t action)
{
    const status_t status = double_cycle(&rig_generic, action, is_controlled());
    scripted_bus_run(&rig_bus);
    rig_generic.now_ns += rig_generic.period_ns;
    if ((rig_generic.now_ns % 20000000U) == 0U) {
        scripted_bus_heartbeat(&rig_bus);
    }
    return status;
}

status_t rig_run_action(const rig_action_t action)
{
    status_t status = STATUS_BUSY;
    for (unsigned i = 0U; (status == STATUS_BUSY) && (i < CYCLES_MAX); i++) {
        status = rig_cycle(action);
    }
    return status;
}

void rig_idle(const unsigned cycles)
{
    for (unsigned i = 0U; i < cycles; i++) {
        (void)rig_cycle(NULL);
    }
}

status_t rig_configure(void* const self)
{
    return rig_callbacks->configure(self, rig_generic.configuration);
}

void rig_hand_at(const double first_rad, const double second_rad)
{
    const manipulator_hand_position_payload_t hand = {{first_rad, second_rad}};
    memcpy(rig_generic.ports[HAND].sample, &hand, sizeof hand);
    rig_generic.ports[HAND].read_status = STATUS_OK;
    rig_generic.ports[HAND].age_us      = 1500U;
}

/// Perform the entry actions from HARDWARE_INIT up to `state`, in a configuration.
void rig_bring(const uint16_t configuration, const state_t state)
{
    rig_generic.state = STATE_HARDWARE_INIT;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->hardware_init));
    rig_generic.state         = STATE_PRE_OPERATIONAL;
    rig_generic.configuration = descriptor_find_configuration(&rig_descriptor, configuration);
    double_set_initials(&rig_generic, rig_generic.configuration);
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_configure));
    if (state >= STATE_SAFE_OPERATIONAL) {
        rig_generic.state = STATE_SAFE_OPERATIONAL;
        TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->start_control));
    }
    if (state == STATE_OPERATIONAL) {
        rig_generic.state = STATE_OPERATIONAL;
        TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->engage));
    }
}

status_t rig_perform(const uint16_t function, const void* const arguments, const uint32_t call_token)
{
    const subsystem_function_t call = {
        .function_id = function, .arguments = arguments, .call_token = call_token};
    return rig_callbacks->perform(&rig_manipulator, &call);
}

const manipulator_cur_values_t* rig_values(void)
{
    return &rig_manipulator.parameters.cur_values;
}

bool rig_load(void)
{
    descriptor_loader_init(&loader);
    const char* const path = "descriptors/subsystems/manipulator.xml";
    const bool is_loaded   = descriptor_load_subsystem(&loader, path, &rig_descriptor) == STATUS_OK;
    if (!is_loaded) {
        (void)puts(descriptor_error(&loader));
    }
    return is_loaded;
}
