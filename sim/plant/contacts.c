// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

#include <math.h>
#include <string.h>

#define UNIT_SLACK 1e-9 // A vector is scaled to length 1 only if its error is larger.
#define STEEP 0.9 // If |y| of a normal is larger, y is too near the normal to derive directions from it.

// ---- Shapes ----

static double reach_of(const shape_t* const shape)
{
    const double* size = shape->size_m;
    switch (shape->kind) {
    case SHAPE_SPHERE:
        return shape->radius_m;
    case SHAPE_CYLINDER:
        return sqrt(shape->radius_m * shape->radius_m + shape->length_m * shape->length_m / 4.0);
    case SHAPE_BOX:
        break;
    }
    return sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]) / 2.0;
}

static void make_geometry(solid_t* const solid)
{
    const shape_t* shape = solid->shape;
    if (shape->kind == SHAPE_SPHERE) {
        solid->geom = dCreateSphere(NULL, shape->radius_m);
    } else if (shape->kind == SHAPE_BOX) {
        solid->geom = dCreateBox(NULL, shape->size_m[0], shape->size_m[1], shape->size_m[2]);
    } else {
        solid->geom = dCreateCylinder(NULL, shape->radius_m, shape->length_m);
        solid->side = dCreateCapsule(NULL, shape->radius_m, shape->length_m);
    }
    solid->reach_m = reach_of(shape);
}

static void put(const dGeomID geom, const double position_m[3], const matrix_t* const rotation)
{
    dMatrix3 turned = {0.0};
    dQuaternion unit; // ODE keeps the rotations of bodies as quaternions, too.
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            turned[(4U * i) + k] = rotation->at[i][k];
        }
    }
    dRtoQ(turned, unit);
    dNormalize4(unit);
    dGeomSetQuaternion(geom, unit);
    dGeomSetPosition(geom, position_m[0], position_m[1], position_m[2]);
}

static void move_to(solid_t* const solid, const pose_t* const pose)
{
    memcpy(solid->position_m, pose->position_m, sizeof solid->position_m);
    put(solid->geom, pose->position_m, &pose->rotation);
    if (solid->side != NULL) {
        put(solid->side, pose->position_m, &pose->rotation);
    }
}

/// Move the geometry to the present pose of its body.
static void follow(solid_t* const solid)
{
    const dReal* body    = dBodyGetRotation(solid->body);
    const double* centre = solid->centre_m;
    pose_t turn          = {.position_m = {0.0}};
    const pose_t inner   = {.rotation = solid->rotation};
    dVector3 at;
    for (unsigned i = 0U; i < 3U; i++) {
        for (unsigned k = 0U; k < 3U; k++) {
            turn.rotation.at[i][k] = body[(4U * i) + k];
        }
    }
    pose_t now = pose_compose(&turn, &inner);
    dBodyGetRelPointPos(solid->body, centre[0], centre[1], centre[2], at);
    memcpy(now.position_m, at, sizeof now.position_m);
    move_to(solid, &now);
}

/// Returns the number of a shape of a link. The shape is made when the first contact names it.
static unsigned solid_of_link(plant_t* const plant, const unsigned robot, const unsigned index)
{
    const unsigned number      = robot * ROBOT_SHAPES_MAX + index;
    const robot_model_t* model = &plant->world->robot[robot].model;
    const shape_t* shape       = &model->shape[index];
    const robot_frame_t* frame = &model->frame[shape->frame];
    solid_t* solid             = &plant->contacts.solid[number];
    const pose_t in_body       = pose_compose(&frame->pose, &shape->pose);
    if (solid->geom != NULL) {
        return number;
    }
    *solid = (solid_t){.shape      = shape,
                       .body       = plant->robot[robot].body[frame->body],
                       .robot      = robot,
                       .body_index = frame->body,
                       .rotation   = in_body.rotation};
    for (unsigned i = 0U; i < 3U; i++) {
        solid->centre_m[i] = in_body.position_m[i] - model->body[frame->body].com_m[i];
    }
    make_geometry(solid);
    if (solid->body == NULL) {
        const pose_t pose = pose_compose(&plant->robot[robot].base, &in_body);
        move_to(solid, &pose);
    } else {
        plant->contacts.moving[plant->contacts.moving_count] = solid;
        plant->contacts.moving_count++;
    }
    return number;
}

static unsigned solid_of_fixture(plant_t* const plant, const unsigned fixture, const unsigned index)
{
    const unsigned number = WORLD_ROBOTS_MAX * ROBOT_SHAPES_MAX + fixture * WORLD_FIXTURE_SHAPES_MAX + index;
    const world_fixture_t* own = &plant->world->fixture[fixture];
    solid_t* solid             = &plant->contacts.solid[number];
    pose_t pose                = own->shape[index].pose;
    if (solid->geom == NULL) {
        *solid = (solid_t){.shape = &own->shape[index]};
        make_geometry(solid);
        for (unsigned i = 0U; i < 3U; i++) {
            pose.position_m[i] = own->at[i] + pose.position_m[i];
        }
        move_to(solid, &pose);
    }
    return number;
}

// ---- Pairs ----

/// Write the numbers of the shapes of one side of a contact, at most `most`. Returns their number.
static unsigned shapes_of(plant_t* const plant, const world_side_t* const side, const unsigned most,
                          unsigned out_solid[])
{
    unsigned count = 0U;
    if (side->is_fixture) {
        for (unsigned i = 0U; (i < plant->world->fixture[side->fixture].shape_count) && (count < most); i++) {
            out_solid[count] = solid_of_fixture(plant, side->fixture, i);
            count++;
        }
        return count;
    }
    const robot_model_t* model = &plant->world->robot[side->robot].model;
    for (unsigned i = 0U; (i < model->shape_count) && (count < most); i++) {
        if (model->shape[i].frame == side->frame) {
            out_solid[count] = solid_of_link(plant, side->robot, i);
            count++;
        }
    }
    return count;
}

static status_t add_pair(plant_t* const plant, const unsigned contact, const unsigned a, const unsigned b,
                         char error[DOCUMENT_ERROR_MAX])
{
    contacts_t* contacts       = &plant->contacts;
    const world_contact_t* own = &plant->world->contact[contact];
    const bool moves           = contacts->solid[a].body != NULL;
    if (!moves && (contacts->solid[b].body == NULL)) {
        return document_refuse(plant->world->path, own->line, own->a,
                               "a link that moves, or one on the other side", error);
    }
    if ((contacts->solid[a].shape->kind == SHAPE_CYLINDER) &&
        (contacts->solid[b].shape->kind == SHAPE_CYLINDER)) { // ODE finds only one point of a line contact.
        return document_refuse(plant->world->path, own->line, "two cylinders",
                               "a box or a sphere on one side: cylinders do not support each other", error);
    }
    if (contacts->pair_count == PAIRS_MAX) {
        return document_refuse(plant->world->path, own->line, own->a, "at most 64 pairs of shapes that touch",
                               error);
    }
    contacts->pair[contacts->pair_count] =
        (pair_t){.contact = contact, .a = moves ? a : b, .b = moves ? b : a, .is_swapped = !moves};
    contacts->pair_count++;
    return STATUS_OK;
}

static status_t create_contact(plant_t* const plant, const unsigned contact, char error[DOCUMENT_ERROR_MAX])
{
    const world_contact_t* own = &plant->world->contact[contact];
    unsigned a[ROBOT_SHAPES_MAX];
    unsigned b[ROBOT_SHAPES_MAX];
    const unsigned a_count = shapes_of(plant, &own->side[0], ROBOT_SHAPES_MAX, a);
    const unsigned b_count = shapes_of(plant, &own->side[1], ROBOT_SHAPES_MAX, b);
    status_t status        = STATUS_OK;
    if ((a_count == 0U) || (b_count == 0U)) {
        return document_refuse(plant->world->path, own->line, (a_count == 0U) ? own->a : own->b,
                               "a link with a collision shape", error);
    }
    for (unsigned i = 0U; i < a_count; i++) {
        for (unsigned k = 0U; (k < b_count) && (status == STATUS_OK); k++) {
            status = add_pair(plant, contact, a[i], b[k], error);
        }
    }
    return status;
}

status_t contacts_create(plant_t* const plant, char error[DOCUMENT_ERROR_MAX])
{
    status_t status        = STATUS_OK;
    plant->contacts.joints = dJointGroupCreate(0);
    for (unsigned i = 0U; (i < plant->world->contact_count) && (status == STATUS_OK); i++) {
        status = create_contact(plant, i, error);
    }
    return status;
}

void contacts_destroy(plant_t* const plant)
{
    contacts_t* contacts = &plant->contacts;
    if (contacts->joints != NULL) {
        dJointGroupDestroy(contacts->joints);
    }
    for (unsigned i = 0U; i < SHAPES_MAX; i++) {
        if (contacts->solid[i].geom != NULL) {
            dGeomDestroy(contacts->solid[i].geom);
        }
        if (contacts->solid[i].side != NULL) {
            dGeomDestroy(contacts->solid[i].side);
        }
    }
}

// ---- Touching ----

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/// Two directions along a surface. The first is perpendicular to the world's y, so it lies in the plane of a
/// planar robot; on a steep surface, whose normal is nearly y, it is perpendicular to z.
static void directions(const double normal[3], const bool is_steep, double out_along[2][3])
{
    const double* n       = normal;
    const double first[3] = {is_steep ? -n[1] : n[2], is_steep ? n[0] : 0.0, is_steep ? 0.0 : -n[0]};
    const double length   = sqrt(dot(first, first));
    const double scale    = (fabs(length - 1.0) > UNIT_SLACK) ? 1.0 / length : 1.0;
    for (unsigned i = 0U; i < 3U; i++) {
        out_along[0][i] = first[i] * scale;
    }
    cross(n, out_along[0], out_along[1]);
}

/// Choose the directions for a normal; when they change, express the stretch in the new ones.
static void set_directions(pair_t* const pair, const double normal[3])
{
    const bool is_steep = fabs(normal[1]) > STEEP;
    double before[2][3];
    double now[2][3];
    if (pair->is_steep == is_steep) {
        return;
    }
    directions(normal, pair->is_steep, before);
    directions(normal, is_steep, now);
    const double* z        = pair->stretch_m;
    const double turned[2] = {z[0] * dot(before[0], now[0]) + z[1] * dot(before[1], now[0]),
                              z[0] * dot(before[0], now[1]) + z[1] * dot(before[1], now[1])};
    memcpy(pair->stretch_m, turned, sizeof turned);
    pair->is_steep = is_steep;
}

/// Set the point at which the force acts: the deepest point of the surface of a sphere, else the point that
/// ODE has found.
static void set_point(const solid_t* const a, const solid_t* const b, const dContactGeom* const found,
                      point_t* const point)
{
    for (unsigned i = 0U; i < 3U; i++) {
        point->normal[i]  = found->normal[i];
        point->point_m[i] = found->pos[i];
        if (a->shape->kind == SHAPE_SPHERE) {
            point->point_m[i] = a->position_m[i] - a->shape->radius_m * found->normal[i];
        } else if (b->shape->kind == SHAPE_SPHERE) {
            point->point_m[i] = b->position_m[i] + b->shape->radius_m * found->normal[i];
        } else {
            // Keep the point that ODE has found.
        }
    }
}

/// Add the elasticity along the surface: while the contact does not slide, a spring and a damper hold it. ODE
/// integrates both implicitly if they are expressed as a slip proportional to the force and a motion of the
/// surface that reduces the stretch.
static void add_shear(const world_contact_t* const own, const pair_t* const pair, const double share,
                      const double dt_s, dSurfaceParameters* const surface)
{
    const double stiffness = own->shear * share;
    if (stiffness > 0.0) {
        const double sum = dt_s * stiffness + own->shear_damping * share;
        surface->mode |= dContactSlip1 | dContactMotion1 | dContactSlip2 | dContactMotion2;
        surface->slip1   = 1.0 / sum;
        surface->slip2   = 1.0 / sum;
        surface->motion1 = -stiffness * pair->stretch_m[0] / sum;
        surface->motion2 = -stiffness * pair->stretch_m[1] / sum;
    }
}

/// Add one contact joint. A soft constraint with these ERP and CFM is exactly a spring and damper integrated
/// implicitly. The points of a pair share its stiffness.
static void add_joint(plant_t* const plant, pair_t* const pair, const dContactGeom* const found,
                      const double share, const double dt_s)
{
    const world_contact_t* own = &plant->world->contact[pair->contact];
    point_t* point             = &pair->point[pair->count];
    const solid_t* a           = &plant->contacts.solid[pair->a];
    const solid_t* b           = &plant->contacts.solid[pair->b];
    const double spring        = dt_s * (own->stiffness * share);
    const double sum           = spring + own->damping * share;

    set_point(a, b, found, point);
    directions(point->normal, pair->is_steep, point->along);
    dContact contact         = {0};
    contact.surface.mode     = dContactSoftERP | dContactSoftCFM | dContactApprox1 | dContactFDir1;
    contact.surface.mu       = own->friction;
    contact.surface.soft_erp = spring / sum;
    contact.surface.soft_cfm = 1.0 / sum;
    contact.geom             = *found;
    memcpy(contact.fdir1, point->along[0], sizeof point->along[0]);
    memcpy(contact.geom.pos, point->point_m, sizeof point->point_m);
    add_shear(own, pair, share, dt_s, &contact.surface);
    const dJointID joint = dJointCreateContact(plant->ode, plant->contacts.joints, &contact);
    dJointAttach(joint, a->body, b->body);
    dJointSetFeedback(joint, &point->feedback);
    pair->count++;
}

/// Returns the geometry of `solid` for contact with `other`. For a sphere at the side of a cylinder it is a
/// capsule, whose side is the same surface.
static dGeomID geometry(const solid_t* const solid, const solid_t* const other)
{
    if ((solid->side == NULL) || (other->shape->kind != SHAPE_SPHERE)) {
        return solid->geom;
    }
    const dReal* turn    = dGeomGetRotation(solid->geom);
    const double off[3]  = {other->position_m[0] - solid->position_m[0],
                            other->position_m[1] - solid->position_m[1],
                            other->position_m[2] - solid->position_m[2]};
    const double along   = turn[2] * off[0] + turn[6] * off[1] + turn[10] * off[2];
    const bool is_beside = fabs(along) <= (solid->shape->length_m / 2.0);
    return is_beside ? solid->side : solid->geom;
}

static bool is_near(const solid_t* const a, const solid_t* const b)
{
    const double reach  = a->reach_m + b->reach_m + UNIT_SLACK;
    const double off[3] = {a->position_m[0] - b->position_m[0], a->position_m[1] - b->position_m[1],
                           a->position_m[2] - b->position_m[2]};
    return dot(off, off) <= (reach * reach);
}

void contacts_touch(plant_t* const plant, const double dt_s)
{
    contacts_t* contacts = &plant->contacts;
    for (size_t i = 0U; i < contacts->moving_count; i++) {
        follow(contacts->moving[i]);
    }
    for (size_t i = 0U; i < contacts->pair_count; i++) {
        pair_t* pair     = &contacts->pair[i];
        const solid_t* a = &contacts->solid[pair->a];
        const solid_t* b = &contacts->solid[pair->b];
        dContactGeom found[POINTS_PER_PAIR];
        pair->count          = 0U;
        const bool may_touch = is_near(a, b) && !latches_connect(plant, a->body, b->body);
        const int count = may_touch ? dCollide(geometry(a, b), geometry(b, a), (int)POINTS_PER_PAIR, found,
                                               (int)sizeof found[0])
                                    : 0;
        if (count > 0) {
            set_directions(pair, found[0].normal);
        }
        for (int k = 0; k < count; k++) {
            add_joint(plant, pair, &found[k], 1.0 / (double)count, dt_s);
        }
    }
}

// ---- Forces ----

/// Speed of `a` relative to `b` at a point, along a direction.
static double speed_along(const plant_t* const plant, const pair_t* const pair, const point_t* const point,
                          const double along[3])
{
    const dBodyID b  = plant->contacts.solid[pair->b].body;
    const double* at = point->point_m;
    dVector3 of_a;
    dVector3 of_b = {0.0};
    dBodyGetPointVel(plant->contacts.solid[pair->a].body, at[0], at[1], at[2], of_a);
    if (b != NULL) {
        dBodyGetPointVel(b, at[0], at[1], at[2], of_b);
    }
    const double speed[3] = {of_a[0] - of_b[0], of_a[1] - of_b[1], of_a[2] - of_b[2]};
    return dot(along, speed);
}

/// Stretch of a pair along one direction after the step. While the contact slides, friction limits the
/// stretch.
static double stretched(const plant_t* const plant, const pair_t* const pair, const unsigned direction,
                        const double dt_s)
{
    const world_contact_t* own = &plant->world->contact[pair->contact];
    double speed               = 0.0;
    double force               = 0.0;
    for (unsigned k = 0U; k < pair->count; k++) {
        const double* along = pair->point[k].along[direction];
        speed += speed_along(plant, pair, &pair->point[k], along) / (double)pair->count;
        force += dot(along, pair->point[k].feedback.f1);
    }
    const double held = fabs((force + own->shear_damping * speed) / own->shear);
    return fmax(-held, fmin(held, pair->stretch_m[direction] + dt_s * speed));
}

static void step_shear(const plant_t* const plant, pair_t* const pair, const double dt_s)
{
    const bool is_elastic = (pair->count > 0U) && (plant->world->contact[pair->contact].shear > 0.0);
    for (unsigned k = 0U; k < 2U; k++) {
        pair->stretch_m[k] = is_elastic ? stretched(plant, pair, k, dt_s) : 0.0;
    }
}

/// Add the force at one point to the sums of its contact, and to the external torques of the joints.
static void read_point(plant_t* const plant, const pair_t* const pair, const point_t* const point,
                       double* const weight)
{
    plant_contact_t* sum = &plant->truth.contact[pair->contact];
    const double* force  = point->feedback.f1;
    const double size    = sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]);
    for (unsigned side = 0U; side < 2U; side++) {
        const solid_t* solid = &plant->contacts.solid[(side == 0U) ? pair->a : pair->b];
        const double sign    = (side == 0U) ? 1.0 : -1.0;
        load_t load          = {.robot = solid->robot, .body = solid->body_index};
        for (unsigned i = 0U; i < 3U; i++) {
            load.force_n[i] = sign * force[i];
            load.point_m[i] = point->point_m[i];
        }
        if (solid->body != NULL) {
            robots_add_load(plant, &load);
        }
    }
    for (unsigned i = 0U; i < 3U; i++) {
        sum->force_n[i] += pair->is_swapped ? -force[i] : force[i];
        sum->point_m[i] += size * point->point_m[i];
    }
    *weight += size;
}

void contacts_read(plant_t* const plant, const double dt_s)
{
    double weight[WORLD_CONTACTS_MAX] = {0.0};
    contacts_t* contacts              = &plant->contacts;
    for (unsigned i = 0U; i < plant->world->contact_count; i++) {
        memset(plant->truth.contact[i].force_n, 0, sizeof plant->truth.contact[i].force_n);
        memset(plant->truth.contact[i].point_m, 0, sizeof plant->truth.contact[i].point_m);
    }
    for (size_t i = 0U; i < contacts->pair_count; i++) {
        pair_t* pair = &contacts->pair[i];
        for (unsigned k = 0U; k < pair->count; k++) {
            read_point(plant, pair, &pair->point[k], &weight[pair->contact]);
        }
        step_shear(plant, pair, dt_s);
    }
    dJointGroupEmpty(contacts->joints);
    for (unsigned i = 0U; i < plant->world->contact_count; i++) {
        plant_contact_t* sum = &plant->truth.contact[i];
        sum->is_touching     = weight[i] > 0.0;
        for (unsigned axis = 0U; axis < 3U; axis++) {
            sum->point_m[axis] = sum->is_touching ? sum->point_m[axis] / weight[i] : 0.0;
        }
    }
}
