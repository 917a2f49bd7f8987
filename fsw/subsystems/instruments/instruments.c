// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/instruments/instruments.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

/// Largest distance from the target at arrival; the coarsest record of a device has steps of 2e-3.
#define ARRIVED_RAD 2e-3

void instruments_init(instruments_t* const own, subsystem_t* const generic,
                      const flow_resolver_t* const resolver)
{
    FSW_ASSERT((own != NULL) && (generic != NULL) && (resolver != NULL));
    *own = (instruments_t){.generic = generic};
    stream_devices_init(&own->devices, generic, resolver);
}

static bool fits(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    static const char* const in[]           = {"COUNT", "VALUE", NULL};
    static const char* const out[]          = {"ENABLE", "TARGET", NULL};
    static const stream_devices_need_t need = {
        .in          = in,
        .out         = out,
        .reason_in   = "<Device>: expected a <Field> COUNT and a <Field> VALUE of direction IN",
        .reason_out  = "<Device>: expected a <Field> ENABLE and a <Field> TARGET of direction OUT",
        .most        = INSTRUMENTS_MAX,
        .reason_most = "too many <Device>, at most 8"};
    return stream_devices_fit(descriptor, &need, out_misfit);
}

static status_t software_init(void* const self)
{
    instruments_t* const own = self;
    return subsystem_publish_all(own->generic, instruments_definitions, instruments_offsets,
                                 INSTRUMENTS_PARAMETER_COUNT, &own->parameters);
}

/// Make the present position of every axis its target.
static void hold(instruments_t* const own)
{
    parameter_lock(subsystem_dictionary(own->generic));
    for (uint16_t i = 0U; i < INSTRUMENTS_MAX; i++) {
        own->parameters.target[i] = own->parameters.cur_values.value[i];
    }
    own->is_under_way = false; // No ARRIVED follows: no axis moves to a target that was commanded.
    parameter_unlock(subsystem_dictionary(own->generic));
}

static status_t engage(void* const self)
{
    hold(self);
    return STATUS_OK;
}

// ---- The cycle ----

static void measure(instruments_t* const own, const uint16_t index, const stream_device_t* const device)
{
    instruments_cur_values_t* const values = &own->parameters.cur_values;
    instruments_counters_t* const counters = &own->parameters.counters;
    values->value[index] = stream_device_value(device, stream_device_field(device, false, "VALUE"));
    values->count[index] = (uint16_t)stream_device_value(device, stream_device_field(device, false, "COUNT"));
    values->lost[index]  = stream_device_is_lost(device) ? 1U : 0U;
    counters->received[index]  = device->counters.received;
    counters->unfit[index]     = device->counters.unfit + flow_counters(&device->flow).malformed;
    counters->sent[index]      = device->counters.sent;
    counters->refused[index]   = device->counters.refused;
    counters->connected[index] = flow_counters(&device->flow).connected;
}

/// Command one axis. True if it is at its target.
static bool follow(const instruments_t* const own, const uint16_t index, stream_device_t* const device)
{
    const bool is_on    = (subsystem_state(own->generic) == STATE_OPERATIONAL);
    const double target = own->parameters.target[index];
    const double away   = target - own->parameters.cur_values.value[index];
    (void)stream_device_set(device, stream_device_field(device, true, "ENABLE"), is_on ? 1.0 : 0.0);
    (void)stream_device_set(device, stream_device_field(device, true, "TARGET"), target);
    return control_absolute(away) <= ARRIVED_RAD;
}

static void control(void* const self)
{
    instruments_t* const own = self;
    const bool is_on         = (subsystem_state(own->generic) == STATE_OPERATIONAL);
    bool are_at_target       = true;
    parameter_lock(subsystem_dictionary(own->generic));
    for (uint16_t i = 0U; i < INSTRUMENTS_MAX; i++) {
        stream_device_t* const device = stream_devices_at(&own->devices, i);
        if (device != NULL) {
            measure(own, i, device);
            are_at_target = follow(own, i, device) && are_at_target;
        }
    }
    own->parameters.cur_values.state  = (int32_t)subsystem_state(own->generic);
    own->parameters.cur_values.cycles = subsystem_cycle(own->generic);
    const bool have_arrived           = is_on && are_at_target && own->is_under_way;
    own->is_under_way                 = is_on && !are_at_target;
    parameter_unlock(subsystem_dictionary(own->generic));
    // Raised after the unlock, because an event that samples parameters takes the lock.
    if (have_arrived) {
        (void)subsystem_raise(own->generic, INSTRUMENTS_EVENT_ARRIVED, NULL, 0U);
    }
}

static status_t perform(void* const self, const subsystem_function_t* const function)
{
    if (function->function_id != INSTRUMENTS_FUNCTION_STOP) {
        return STATUS_NOT_FOUND;
    }
    hold(self);
    return STATUS_OK;
}

const subsystem_callbacks_t* instruments_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init   = software_init,
        .hardware_init   = stream_devices_hardware_init,
        .configure       = stream_devices_configure,
        .engage          = engage,
        .secure          = stream_devices_secure,
        .post            = stream_devices_post,
        .hardware_deinit = stream_devices_hardware_deinit,
        .sense           = stream_devices_sense,
        .control         = control,
        .emit            = stream_devices_emit,
        .perform         = perform,
        .release         = stream_devices_release,
        .fits            = fits,
    };
    return &callbacks;
}
