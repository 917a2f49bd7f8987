// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/@name@/@name@.h"

#include "base/assertion.h"
#include "base/octets.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

void @name@_init(@name@_t* const own, subsystem_t* const generic, const flow_resolver_t* const resolver)
{
    FSW_ASSERT((own != NULL) && (generic != NULL) && (resolver != NULL));
    *own = (@name@_t){.generic = generic, .resolver = resolver};
}

static status_t software_init(void* const self)
{
    @name@_t* const own = self;

    return subsystem_publish_all(own->generic, @name@_definitions, @name@_places, @NAME@_PARAMETER_COUNT,
                                 &own->parameters);
}

/// Keep the present value until the next command.
static void hold(@name@_t* const own)
{
    parameter_lock(subsystem_dictionary(own->generic));
    own->parameters.des_value = own->value;
    own->is_under_way         = false;
    parameter_unlock(subsystem_dictionary(own->generic));
}

static status_t engage(void* const self)
{
    hold(self);
    return STATUS_OK;
}

/// Move the value by one step. True if it arrives with this step.
static bool follow(@name@_t* const own)
{
    const double period_s    = (double)subsystem_period_ns(own->generic) * 1.0e-9;
    const double most        = own->parameters.rate * period_s;
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
    (void)subsystem_raise(own->generic, @NAME@_EVENT_ARRIVED, octets, writer.position);
}

static void control(void* const self)
{
    @name@_t* const own = self;

    const state_t state = subsystem_state(own->generic);
    parameter_lock(subsystem_dictionary(own->generic));
    const bool has_arrived = (state == STATE_OPERATIONAL) && follow(own);

    own->parameters.cur_values.state  = (int32_t)state;
    own->parameters.cur_values.cycles = subsystem_cycle(own->generic);
    own->parameters.cur_values.value  = own->value;
    parameter_unlock(subsystem_dictionary(own->generic));
    if (has_arrived) {
        report_arrival(own);
    }
}

static status_t perform(void* const self, const subsystem_function_t* const function)
{
    @name@_t* const own = self;

    if (function->function_id != @NAME@_FUNCTION_STOP) {
        return STATUS_NOT_FOUND;
    }
    hold(own);
    return STATUS_OK;
}

const subsystem_callbacks_t* @name@_callbacks(void)
{
    static const subsystem_callbacks_t callbacks = {
        .software_init = software_init,
        .engage        = engage,
        .control       = control,
        .perform       = perform,
    };
    return &callbacks;
}
