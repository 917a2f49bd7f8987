// SPDX-License-Identifier: Apache-2.0
#include "sim/world/world_latch.h"

#include "sim/world/world_internal.h"

#include <string.h>

#define STALL_MAX_NS 1e11
#define HALF_TURN_RAD 3.1416 // Largest angle between two frames, rounded up.

const field_t world_latch_fields[WORLD_LATCH_FIELDS] = {
    NAME(world_latch_t, "name", name),
    TEXT(world_latch_t, "a", a),
    TEXT(world_latch_t, "b", b),
    NUMBER(world_latch_t, "distance", distance, 1e-9, FAR_M),
    NUMBER(world_latch_t, "angle", angle, 1e-9, HALF_TURN_RAD),
    NUMBER(world_latch_t, "speed", speed, 1e-9, FAR_M),
    {"when", FIELD_NAME, offsetof(world_latch_t, when), 0.0, 0.0, true},
    OPTIONAL(world_latch_t, "force", force, 1e-9, GREAT),
    {"stall", FIELD_TIME, offsetof(world_latch_t, stall_ns), 0.0, STALL_MAX_NS, true},
    OPTIONAL(world_latch_t, "release", release, 1e-9, FAR_M),
    {"output", FIELD_UNSIGNED, offsetof(world_latch_t, output), 1.0, (double)WORLD_VALVE_OUTPUTS, true}};

static bool find_drive(const world_t* const world, world_latch_t* const latch)
{
    while ((latch->drive < world->drive_count) &&
           (strcmp(world->drive[latch->drive].device.name, latch->when) != 0)) {
        latch->drive++;
    }
    return latch->drive < world->drive_count;
}

static bool find_box(const world_t* const world, world_latch_t* const latch)
{
    while ((latch->box < world->valve_box_count) &&
           (strcmp(world->valve_box[latch->box].device.name, latch->when) != 0)) {
        latch->box++;
    }
    return latch->box < world->valve_box_count;
}

static bool output_has_valve(const world_t* const world, const world_latch_t* const latch)
{
    size_t index = 0U;
    while ((index < world->valve_count) &&
           ((world->valve[index].box != latch->box) || (world->valve[index].output != latch->output))) {
        index++;
    }
    return index < world->valve_count;
}

/// True if the attributes force, stall and release fit the device: a drive that presses needs the first two
/// and may have the third; other devices have none of them.
static bool has_forces_if(const element_t* const element, const bool is_pressed)
{
    const bool has_force   = element_attribute(element, "force") != NULL;
    const bool has_stall   = element_attribute(element, "stall") != NULL;
    const bool has_release = element_attribute(element, "release") != NULL;
    return (has_force == is_pressed) && (has_stall == is_pressed) && (is_pressed || !has_release);
}

/// Find the device that closes the latch, and check the attributes that belong to it.
static status_t find_trigger(const world_t* const world, const element_t* const element,
                             world_latch_t* const latch)
{
    const bool is_named   = latch->when[0] != '\0';
    const bool is_pressed = is_named && find_drive(world, latch);
    const bool is_wired   = is_named && !is_pressed && find_box(world, latch);
    const bool has_output = element_attribute(element, "output") != NULL;
    if (is_named && !is_pressed && !is_wired) {
        return element_refuse(element, latch->when, "a Gripper, Drive or ValveBox above");
    }
    if (!has_forces_if(element, is_pressed)) {
        return element_refuse(element, element->name,
                              "force and stall if `when` is a Gripper or Drive, otherwise no force, stall or "
                              "release");
    }
    if (has_output != is_wired) {
        return element_refuse(element, element->name, "output if `when` is a ValveBox, otherwise no output");
    }
    latch->trigger = is_pressed ? WORLD_LATCH_PRESSED : (is_wired ? WORLD_LATCH_WIRED : WORLD_LATCH_TOUCHED);
    return (is_wired && output_has_valve(world, latch))
               ? element_refuse(element, element_attribute(element, "output"), "an output without a Valve")
               : STATUS_OK;
}

/// True if both sides belong to the same body. All fixed bodies count as one: the world.
static bool is_of_one_body(const world_t* const world, const world_side_t* const a,
                           const world_side_t* const b)
{
    const world_robot_t* robot_a = &world->robot[a->robot];
    const world_robot_t* robot_b = &world->robot[b->robot];
    const unsigned body_a        = robot_a->model.frame[a->frame].body;
    const unsigned body_b        = robot_b->model.frame[b->frame].body;
    const bool are_still         = (body_a == 0U) && (body_b == 0U) && !robot_a->is_free && !robot_b->is_free;
    return are_still || ((a->robot == b->robot) && (body_a == body_b));
}

static bool is_same_side(const world_side_t* const a, const world_side_t* const b)
{
    return (a->robot == b->robot) && (a->frame == b->frame);
}

/// True if two latches connect the same links, in either order, and close by the same device.
static bool is_repetition(const world_latch_t* const a, const world_latch_t* const b)
{
    const bool is_pair = (is_same_side(&a->side[0], &b->side[0]) && is_same_side(&a->side[1], &b->side[1])) ||
                         (is_same_side(&a->side[0], &b->side[1]) && is_same_side(&a->side[1], &b->side[0]));
    return is_pair && (strcmp(a->when, b->when) == 0) && (a->output == b->output);
}

/// Refuse a latch that closes by the same device as one above, and connects the same links.
static status_t refuse_repeated(const world_t* const world, const element_t* const element,
                                const world_latch_t* const latch)
{
    for (const world_latch_t* other = world->latch; other < latch; other++) {
        if (is_repetition(latch, other)) {
            return element_refuse(element, latch->name,
                                  "links that no Latch above connects by the same `when` and output");
        }
    }
    return STATUS_OK;
}

status_t world_latch_finish(world_t* const world, const element_t* const element, void* const record)
{
    world_latch_t* latch = record;
    world_side_t* a      = &latch->side[0];
    world_side_t* b      = &latch->side[1];
    latch->line          = element->line;
    for (const world_latch_t* other = world->latch; other < latch; other++) {
        if (strcmp(other->name, latch->name) == 0) {
            return element_refuse(element, latch->name, "a name that no Latch above has");
        }
    }
    status_t status = world_find_frame(world, element, latch->a, &a->robot, &a->frame);
    if (status == STATUS_OK) {
        status = world_find_frame(world, element, latch->b, &b->robot, &b->frame);
    }
    if ((status == STATUS_OK) && is_of_one_body(world, a, b)) {
        status = element_refuse(element, latch->b, "a link that moves relative to that of `a`");
    }
    if (status == STATUS_OK) {
        status = find_trigger(world, element, latch);
    }
    return (status == STATUS_OK) ? refuse_repeated(world, element, latch) : status;
}
