// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define FASTEST_M_S 1e5 // The simulator is not made for higher speeds. ODE asserts that states are finite.
#define FASTEST_RAD_S 1e5
#define NS_PER_S 1.0e9
#define NS_PER_US 1000.0

/// A body that is no longer sound, and the reason.
typedef struct {
    unsigned robot;
    unsigned body;
    const char* what;
    double value;
    const char* unit;
} finding_t;

static double length(const dReal vector[3])
{
    return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

/// True if a body has a finite state of reasonable size, and will have it after a step without its joints.
static bool is_sound(const dBodyID body, const double dt_s, finding_t* const out_finding)
{
    dMass mass;
    dBodyGetMass(body, &mass);
    const double least   = fmin(mass.I[0], fmin(mass.I[5], mass.I[10]));
    const double found[] = {length(dBodyGetLinearVel(body)) + length(dBodyGetForce(body)) * dt_s / mass.mass,
                            length(dBodyGetAngularVel(body)) + length(dBodyGetTorque(body)) * dt_s / least};
    const double most[]  = {FASTEST_M_S, FASTEST_RAD_S};
    const unsigned index = (found[0] <= most[0]) ? 1U : 0U;
    out_finding->what    = (index == 0U) ? "speed" : "rate";
    out_finding->unit    = (index == 0U) ? "m/s" : "rad/s";
    out_finding->value   = found[index];
    return found[index] <= most[index]; // False for numbers that are not finite, too.
}

/// Returns the name of the topmost link of a body.
static const char* link_of(const robot_model_t* const model, const unsigned body)
{
    unsigned frame = 0U;
    while (((frame + 1U) < model->frame_count) && (model->frame[frame].body != body)) {
        frame++;
    }
    return model->frame[frame].name;
}

static void explain(plant_t* const plant, const finding_t* const finding)
{
    const world_t* world       = plant->world;
    const world_robot_t* robot = &world->robot[finding->robot];
    const unsigned joint       = (finding->body > 0U) ? (finding->body - 1U) : 0U;
    const bool has_joint       = finding->body > 0U;
    const bool has_drive =
        has_joint && (plant->joint[plant->robot[finding->robot].first_joint + joint].drive_of != NULL);
    const int size = snprintf(
        plant->failure, sizeof plant->failure,
        "%s:%u: link %s.%s gets a %s of %.1e %s at %.4f s: the world diverges; check %s%s%s the "
        "stiffness and damping of its Contacts, what acts on it, and the step of %.0f us",
        world->path, robot->line, robot->name, link_of(&robot->model, finding->body), finding->what,
        finding->value, finding->unit, (double)plant->truth.time_ns / NS_PER_S,
        has_drive ? "the DriveType of its joint " : (has_joint ? "its joint " : ""),
        has_joint ? robot->model.joint[joint].name : "", has_joint ? "," : "", world->step_ns / NS_PER_US);
    if (size >= (int)sizeof plant->failure) { // The text does not fit.
        (void)strcpy(&plant->failure[sizeof plant->failure - sizeof "..."], "...");
    }
}

bool plant_is_sound(plant_t* const plant, const double dt_s)
{
    finding_t finding = {0};
    for (unsigned r = 0U; r < plant->world->robot_count; r++) {
        for (unsigned i = 0U; i <= plant->world->robot[r].model.joint_count; i++) {
            const dBodyID body = plant->robot[r].body[i];
            if ((body != NULL) && !is_sound(body, dt_s, &finding)) {
                finding.robot = r;
                finding.body  = i;
                explain(plant, &finding);
                return false;
            }
        }
    }
    return true;
}

const char* plant_failure(const plant_t* const plant)
{
    return (plant->failure[0] != '\0') ? plant->failure : NULL;
}
