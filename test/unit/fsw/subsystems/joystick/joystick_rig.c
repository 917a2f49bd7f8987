// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/subsystems/joystick/joystick_rig.h"

#include "unity.h"

#include <stdio.h>
#include <string.h>

#define CYCLES_MAX 4000U

static descriptor_loader_t loader;
subsystem_descriptor_t rig_descriptor;
scripted_bus_t rig_bus;
static scripted_bus_t channel_b; // No device is connected to it.
scripted_node_t* rig_stick;
subsystem_t rig_generic;
joystick_t rig_joystick;
const subsystem_callbacks_t* rig_callbacks;

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    const bool is_b = (strcmp(name, "joystick-b") == 0);
    if ((kind != ENDNODE_CAN) || (!is_b && (strcmp(name, "joystick") != 0))) {
        return STATUS_NOT_FOUND;
    }
    (void)strcpy(out_address->address, is_b ? channel_b.address : rig_bus.address);
    return STATUS_OK;
}

static const flow_resolver_t resolver = {NULL, resolve};

void rig_set_up(void)
{
    rig_callbacks = joystick_callbacks();
    scripted_bus_open(&rig_bus, "test-joystick");
    scripted_bus_open(&channel_b, "test-joystick-b");
    rig_stick              = scripted_bus_add(&rig_bus, SCRIPTED_JOYSTICK, 0x21U);
    rig_stick->position[0] = 50000;
    rig_stick->position[1] = -20000;
    double_init(&rig_generic, &rig_descriptor, rig_callbacks, &rig_joystick);
    TEST_ASSERT_NOT_NULL(rig_generic.descriptor);
    joystick_init(&rig_joystick, &rig_generic, &resolver);
    TEST_ASSERT_EQUAL(STATUS_OK, double_software_init(&rig_generic));
}

void rig_tear_down(void)
{
    drives_release(&rig_joystick.drives);
    scripted_bus_close(&rig_bus);
    scripted_bus_close(&channel_b);
}

status_t rig_cycle(const rig_action_t action)
{
    const bool is_controlled = (rig_generic.configuration != NULL) &&
                               (rig_generic.state >= STATE_PRE_OPERATIONAL) &&
                               (rig_generic.state <= STATE_ERROR_OPERATIONAL);
    const status_t status = double_cycle(&rig_generic, action, is_controlled);
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

void rig_bring(const uint16_t configuration, const state_t state)
{
    rig_generic.state = STATE_HARDWARE_INIT;
    TEST_ASSERT_EQUAL(STATUS_OK, rig_run_action(rig_callbacks->hardware_init));
    rig_generic.state         = STATE_PRE_OPERATIONAL;
    rig_generic.configuration = descriptor_find_configuration(&rig_descriptor, configuration);
    double_set_initials(&rig_generic, rig_generic.configuration);
    // Shorter than RAMP_TIME and FADE_TIME of the descriptor, so that a test needs fewer cycles.
    rig_joystick.parameters.control.ramp_time = 0.2;
    rig_joystick.parameters.control.fade_time = 0.2;
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
    return rig_callbacks->perform(&rig_joystick, &call);
}

double rig_torque(const unsigned axis)
{
    return 1.0e-4 * (double)rig_stick->target_torque[axis];
}

bool rig_load(void)
{
    descriptor_loader_init(&loader);
    const char* const path = "descriptors/subsystems/joystick.xml";
    const bool is_loaded   = descriptor_load_subsystem(&loader, path, &rig_descriptor) == STATUS_OK;
    if (!is_loaded) {
        (void)puts(descriptor_error(&loader));
    }
    return is_loaded;
}
