// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world_valve.h"

#include "sim/world/world_internal.h"

#include <math.h>
#include <string.h>

#define PULSE_MAX_NS 1e10

const field_t world_valve_box_fields[WORLD_VALVE_BOX_FIELDS] = {ADDRESS(world_valve_box_t),
                                                                TEXT(world_valve_box_t, "eds", device.eds)};

static const field_t valve_fields[] = {
    NAME(world_valve_t, "name", name),
    TEXT(world_valve_t, "on", on),
    VECTOR(world_valve_t, "at", at),
    VECTOR(world_valve_t, "direction", direction),
    NUMBER(world_valve_t, "force", force, 1e-9, GREAT),
    {"minimum", FIELD_TIME, offsetof(world_valve_t, shortest_ns), 0.0, PULSE_MAX_NS, true},
    UNSIGNED(world_valve_t, "output", output, 1.0, (double)WORLD_VALVE_OUTPUTS)};

status_t world_valve_box_finish(world_t* const world, const element_t* const element, void* const record)
{
    return world_take_device(world, element, &((world_valve_box_t*)record)->device);
}

static bool make_unit(double vector[3])
{
    const double length = sqrt((vector[0] * vector[0]) + (vector[1] * vector[1]) + (vector[2] * vector[2]));
    for (unsigned i = 0U; (i < 3U) && (length > 0.0); i++) {
        vector[i] /= length;
    }
    return length > 0.0;
}

static status_t finish(const world_t* const world, const element_t* const element, world_valve_t* const valve)
{
    for (const world_valve_t* other = world->valve; other < valve; other++) {
        if (strcmp(other->name, valve->name) == 0) {
            return element_refuse(element, valve->name, "a name that no Valve above has");
        }
        if ((other->box == valve->box) && (other->output == valve->output)) {
            return element_refuse(element, element_attribute(element, "output"),
                                  "an output that no Valve above has in this ValveBox");
        }
    }
    if (!make_unit(valve->direction)) {
        return element_refuse(element, element_attribute(element, "direction"),
                              "a direction other than 0 0 0");
    }
    return world_find_frame(world, element, valve->on, &valve->robot, &valve->frame);
}

status_t world_valve_take(world_t* const world, const element_t* const element)
{
    world_valve_t* valve = &world->valve[world->valve_count];
    if (world->valve_count == WORLD_VALVES_MAX) {
        return element_refuse(element, element->name, "at most 32 valves");
    }
    const status_t status = element_take(element, valve_fields, COUNT_OF(valve_fields), valve);
    valve->line           = element->line;
    valve->box            = (unsigned)world->valve_box_count - 1U;
    if (status != STATUS_OK) {
        return status;
    }
    world->valve_count++;
    return finish(world, element, valve);
}
