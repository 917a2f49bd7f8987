// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world_contact.h"

#include "sim/world/world_internal.h"

#include <string.h>

#define STIFFNESS_MIN 1e-3 // Smallest stiffness of a contact or spring [N/m].

const field_t world_contact_fields[WORLD_CONTACT_FIELDS] = {
    TEXT(world_contact_t, "a", a),
    TEXT(world_contact_t, "b", b),
    NUMBER(world_contact_t, "stiffness", stiffness, STIFFNESS_MIN, GREAT),
    NUMBER(world_contact_t, "damping", damping, 0.0, GREAT),
    NUMBER(world_contact_t, "friction", friction, 0.0, 10.0),
    OPTIONAL(world_contact_t, "shear", shear, 0.0, GREAT),
    OPTIONAL(world_contact_t, "shearDamping", shear_damping, 0.0, GREAT)};

/// True if a contact is between the sides of another one, in either order.
static bool is_of_pair(const world_contact_t* const contact, const world_contact_t* const other)
{
    return ((strcmp(contact->a, other->a) == 0) && (strcmp(contact->b, other->b) == 0)) ||
           ((strcmp(contact->a, other->b) == 0) && (strcmp(contact->b, other->a) == 0));
}

static status_t find_other_side(const world_t* const world, const element_t* const element,
                                world_contact_t* const contact)
{
    world_side_t* other = &contact->side[1];
    while ((other->fixture < world->fixture_count) &&
           (strcmp(world->fixture[other->fixture].name, contact->b) != 0)) {
        other->fixture++;
    }
    other->is_fixture = other->fixture < world->fixture_count;
    if (other->is_fixture) {
        return STATUS_OK;
    }
    other->fixture = 0U;
    return (world_find_frame(world, element, contact->b, &other->robot, &other->frame) == STATUS_OK)
               ? STATUS_OK
               : element_refuse(element, contact->b, "a Fixture, or robot.link of a robot above");
}

status_t world_contact_finish(world_t* const world, const element_t* const element, void* const record)
{
    world_contact_t* contact = record;
    contact->line            = element->line;
    for (const world_contact_t* other = world->contact; other < contact; other++) {
        if (is_of_pair(contact, other)) {
            return element_refuse(element, contact->b, "a pair that no Contact above has");
        }
    }
    if ((contact->shear == 0.0) && (contact->shear_damping > 0.0)) {
        return element_refuse(element, element_attribute(element, "shearDamping"),
                              "no shearDamping in a contact without shear, which sticks rigidly");
    }
    const status_t status = find_other_side(world, element, contact);
    return (status == STATUS_OK) ? world_find_frame(world, element, contact->a, &contact->side[0].robot,
                                                    &contact->side[0].frame)
                                 : status;
}

const field_t world_spring_fields[WORLD_SPRING_FIELDS] = {
    TEXT(world_spring_t, "on", on),
    VECTOR(world_spring_t, "hook", hook),
    NUMBER(world_spring_t, "catch", catch, 1e-6, FAR_M),
    NUMBER(world_spring_t, "length", length, 1e-6, FAR_M),
    NUMBER(world_spring_t, "stiffness", stiffness, STIFFNESS_MIN, GREAT),
    NUMBER(world_spring_t, "preload", preload, 0.0, GREAT),
    NUMBER(world_spring_t, "travel", travel, 1e-9, FAR_M),
    NUMBER(world_spring_t, "limit", limit, 1e-9, GREAT)};

static bool is_same_position(const double a[3], const double b[3])
{
    return (a[0] == b[0]) && (a[1] == b[1]) && (a[2] == b[2]);
}

status_t world_spring_finish(world_t* const world, const element_t* const element, void* const record)
{
    world_spring_t* spring = record;
    spring->line           = element->line;
    for (const world_spring_t* other = world->spring; other < spring; other++) {
        if ((strcmp(spring->on, other->on) == 0) && is_same_position(spring->hook, other->hook)) {
            return element_refuse(element, element_attribute(element, "hook"),
                                  "a hook that no CableSpring above has on this link");
        }
    }
    if (spring->limit < spring->preload) {
        return element_refuse(element, element_attribute(element, "limit"),
                              "a limit of at least the preload");
    }
    return world_find_frame(world, element, spring->on, &spring->robot, &spring->frame);
}
