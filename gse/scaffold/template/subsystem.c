// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/@name@/@name@.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "fsw/canopen/cia402.h"
#include "fsw/framework/control/elementary.h"
#include "pus/core/tailoring.h"

#include <stddef.h>

#define FAST_FACTOR 2.0
#define MILLI 1000.0

// ---- Functions ----

static void end_move(@name@_t* const own, const uint16_t failure_code)
{
    subsystem_function_done(own->generic, own->move_token, failure_code, 0U);
    own->move_token = 0U;
}

/// Keep the present value until the next command.
static void hold(@name@_t* const own)
{
    parameter_lock(subsystem_dictionary(own->generic));
    own->parameters.des_value = own->value;
    own->is_under_way         = false;
    parameter_unlock(subsystem_dictionary(own->generic));
    end_move(own, PUS_FAILURE_ABORTED);
}

/// Abort the motion: called when the actuators are switched on or off.
static void abandon(void* const self)
{
    hold(self);
}

static status_t move(@name@_t* const own, const @name@_move_arguments_t* const arguments,
                     const uint32_t call_token)
{
    const double reach = own->parameters.reach;
    if (control_absolute(arguments->to) > reach) {
        subsystem_function_done(own->generic, call_token, @NAME@_FAILURE_BEYOND_REACH,
                                (uint32_t)(reach * MILLI));
        return STATUS_BUSY;
    }
    end_move(own, PUS_FAILURE_ABORTED); // A new motion replaces the one before.
    parameter_lock(subsystem_dictionary(own->generic));
    own->parameters.des_value = arguments->to;
    own->parameters.pace      = arguments->pace;
    own->is_under_way         = true;
    parameter_unlock(subsystem_dictionary(own->generic));
    own->move_token = call_token;
    return STATUS_BUSY; // The function ends with subsystem_function_done.
}

static status_t perform(void* const self, const subsystem_function_t* const function)
{
    switch (function->function_id) {
    case @NAME@_FUNCTION_STOP:
        hold(self);
        return STATUS_OK;
    case @NAME@_FUNCTION_MOVE:
        return move(self, function->arguments, function->call_token);
    default:
        return STATUS_NOT_FOUND;
    }
}

// ---- The cycle ----

/// Move the value by one step. True if it arrives with this step.
static bool follow(@name@_t* const own)
{
    const double period_s    = (double)subsystem_period_ns(own->generic) * 1.0e-9;
    const bool is_fast       = (own->parameters.pace == (uint8_t)@NAME@_VALUE_PACE_FAST);
    const double most        = own->parameters.rate * period_s * (is_fast ? FAST_FACTOR : 1.0);
    const double away        = own->parameters.des_value - own->value;
    const bool was_under_way = own->is_under_way;

    own->value += control_clamp(away, -most, most);
    own->is_under_way = (control_absolute(away) > most);
    return was_under_way && !own->is_under_way;
}

static void report_arrival(@name@_t* const own)
{
    uint8_t octets[@NAME@_EVENT_ARRIVED_OCTETS];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_f64(&writer, own->value);
    octet_write_u8(&writer, own->parameters.pace);
    (void)subsystem_raise(own->generic, @NAME@_EVENT_ARRIVED, octets, writer.position);
    end_move(own, PUS_FAILURE_NONE);
}

/// Read what the devices have measured. Out of operation, the next motion begins at the angle of the motor.
static void measure(@name@_t* const own)
{
    @name@_cur_values_t* const values    = &own->parameters.cur_values;
    const canopen_device_t* const motor  = drives_device(&own->equipment.drives, 0U);
    const stream_device_t* const probe   = stream_devices_at(&own->equipment.streams, 0U);
    if (motor != NULL) {
        values->motor = canopen_cia402_axis_position_rad(&motor->axes[0]);
        own->value    = equipment_is_engaged(&own->equipment) ? own->value : values->motor;
    }
    if (probe != NULL) {
        values->probe = stream_device_value(probe, stream_device_field(probe, false, "VALUE"));
    }
}

static void command(@name@_t* const own)
{
    const bool is_on              = (subsystem_state(own->generic) == STATE_OPERATIONAL);
    canopen_device_t* const motor = drives_device(&own->equipment.drives, 0U);
    stream_device_t* const probe  = stream_devices_at(&own->equipment.streams, 0U);
    if (motor != NULL) {
        canopen_cia402_axis_command_position(&motor->axes[0], own->value, 0.0);
    }
    if (probe != NULL) {
        (void)stream_device_set(probe, stream_device_field(probe, true, "ENABLE"), is_on ? 1.0 : 0.0);
        (void)stream_device_set(probe, stream_device_field(probe, true, "TARGET"), own->value);
    }
}

static void control(void* const self)
{
    @name@_t* const own = self;

    const state_t state = subsystem_state(own->generic);
    parameter_lock(subsystem_dictionary(own->generic));
    measure(own);
    const bool has_arrived = (state == STATE_OPERATIONAL) && follow(own);

    own->parameters.cur_values.state  = (int32_t)state;
    own->parameters.cur_values.cycles = subsystem_cycle(own->generic);
    own->parameters.cur_values.value  = own->value;
    parameter_unlock(subsystem_dictionary(own->generic));
    command(own);
    if (has_arrived) {
        report_arrival(own);
    }
}

// ---- Entry actions ----

void @name@_init(@name@_t* const own, subsystem_t* const generic, const flow_resolver_t* const resolver)
{
    FSW_ASSERT((own != NULL) && (generic != NULL) && (resolver != NULL));
    *own = (@name@_t){.generic = generic};
    equipment_init(&own->equipment, generic, resolver, abandon);
}

static status_t software_init(void* const self)
{
    @name@_t* const own = self;

    return subsystem_publish_all(own->generic, @name@_definitions, @name@_offsets, @NAME@_PARAMETER_COUNT,
                                 &own->parameters);
}

/// Refuse, with file and line, a descriptor whose devices this program cannot serve.
static bool fits(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    static const int modes[]                   = {CIA402_MODE_CSP, 0};
    static const char* const in[]              = {"VALUE", NULL};
    static const char* const out[]             = {"ENABLE", "TARGET", NULL};
    static const drives_need_t drives          = {.axes            = 1U,
                                                  .reason_type     = "type of <Device>: expected a drive with one axis",
                                                  .count           = 1U,
                                                  .reason_count    = "<Configuration>: expected one <Device> on CAN",
                                                  .modes           = modes,
                                                  .reason_mode     = "<Device>: expected a <Setting> of 0x6060:00 to 8",
                                                  .permits_streams = true};
    static const stream_devices_need_t streams = {.in             = in,
                                                  .out            = out,
                                                  .reason_in      = "<Device>: expected a <Field> VALUE of direction IN",
                                                  .reason_out     = "<Device>: expected a <Field> ENABLE and a <Field> TARGET of direction OUT",
                                                  .most           = 1U,
                                                  .reason_most    = "too many <Device> of type \"stream\", at most 1",
                                                  .permits_drives = true};
    return equipment_fit(descriptor, &drives, &streams, out_misfit);
}

const subsystem_callbacks_t* @name@_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init   = software_init,
        .hardware_init   = equipment_hardware_init,
        .configure       = equipment_configure,
        .start_control   = equipment_start_control,
        .stop_control    = equipment_stop_control,
        .engage          = equipment_engage,
        .disengage       = equipment_disengage,
        .secure          = equipment_secure,
        .post            = equipment_post,
        .hardware_deinit = equipment_hardware_deinit,
        .sense           = equipment_sense,
        .control         = control,
        .emit            = equipment_emit,
        .perform         = perform,
        .release         = equipment_release,
        .fits            = fits,
    };
    return &callbacks;
}
