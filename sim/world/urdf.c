// SPDX-License-Identifier: Apache-2.0
#include "sim/world/urdf.h"

#include <math.h>
#include <string.h>

#define FAR_M 1e4
#define ANGLE_MAX 1e3       // rad
#define HEAVIEST 1e7        // kg, kgm2
#define JOINT_ELEMENTS 7U   // Kinds of elements in a <joint>.
#define TRIANGLE_SLACK 1e-6 // Relative tolerance for rounded moments of inertia.

typedef enum {
    IN_NOTHING,
    IN_ROBOT,
    IN_LINK,
    IN_INERTIAL,
    IN_COLLISION,
    IN_GEOMETRY,
    IN_JOINT
} urdf_element_t;

/// Inertia tensor, with the names of URDF.
typedef struct {
    double xx;
    double xy;
    double xz;
    double yy;
    double yz;
    double zz;
} moments_t;

typedef struct {
    urdf_element_t inside;
    urdf_t* urdf;
    urdf_origin_t origin; // Origin of the <inertial> or <collision> that is being read.
    double mass_kg;
    moments_t moments;
    bool has_origin; // Of the <inertial> or <collision> that is being read.
    bool has_mass;
    bool has_moments;
    bool has_shape;
    bool has[JOINT_ELEMENTS];       // Elements of the <joint> that is being read.
    char unused[DOCUMENT_TEXT_MAX]; // Texts without meaning for the simulator.
} urdf_reader_t;

// ---- Moments of inertia ----

/// True if each principal minor of a symmetric matrix is at least `least` (order 1), `least` * |`least`|
/// (order 2) or `least`^3 (order 3). With a positive `least` the matrix is then positive definite; with a
/// negative one, which allows for rounding, positive semi-definite.
static bool has_minors(const moments_t* const m, const double least)
{
    const double xy = m->xx * m->yy - m->xy * m->xy;
    const double xz = m->xx * m->zz - m->xz * m->xz;
    const double yz = m->yy * m->zz - m->yz * m->yz;
    const double whole =
        m->xx * yz - m->xy * (m->xy * m->zz - m->yz * m->xz) + m->xz * (m->xy * m->yz - m->yy * m->xz);
    const double two   = least * fabs(least);
    const double three = least * least * least;
    return (m->xx >= least) && (m->yy >= least) && (m->zz >= least) && (xy >= two) && (xz >= two) &&
           (yz >= two) && (whole >= three);
}

/// Check that a body can have these moments of inertia: all principal moments are positive, and none is
/// greater than the sum of the other two (half the trace minus the tensor is positive semi-definite). Returns
/// null, or the expectation that they do not meet.
static const char* check_moments(const moments_t* const m)
{
    const double half      = 0.5 * (m->xx + m->yy + m->zz);
    const moments_t spread = {half - m->xx, -m->xy, -m->xz, half - m->yy, -m->yz, half - m->zz};
    if (!(half > 0.0) || !has_minors(m, half * 1e-9)) {
        return "moments of inertia that are positive about every axis";
    }
    return has_minors(&spread, -half * TRIANGLE_SLACK)
               ? NULL
               : "moments of inertia of which none is more than the sum of the others";
}

// ---- Elements ----

/// Refuse an element that may occur once in its parent and has occurred before.
static status_t take_once(const element_t* const element, bool* const has)
{
    const bool is_second = *has;
    *has                 = true;
    return is_second ? element_refuse(element, element->name, "only one of these in its parent") : STATUS_OK;
}

static status_t take_origin(urdf_reader_t* const reader, const element_t* const element)
{
    static const field_t fields[] = {
        {"xyz", FIELD_VECTOR, offsetof(urdf_origin_t, position_m), -FAR_M, FAR_M, true},
        {"rpy", FIELD_VECTOR, offsetof(urdf_origin_t, rpy_rad), -ANGLE_MAX, ANGLE_MAX, true}};
    const status_t status = take_once(element, &reader->has_origin);
    return (status == STATUS_OK) ? element_take(element, fields, 2U, &reader->origin) : status;
}

static status_t start_link(urdf_reader_t* const reader, const element_t* const element)
{
    static const field_t fields[] = {{"name", FIELD_TEXT, offsetof(urdf_link_t, name), 0.0, 0.0, false}};
    if (reader->urdf->link_count == ROBOT_LINKS_MAX) {
        return element_refuse(element, "one more link", "at most 32");
    }
    urdf_link_t* link     = &reader->urdf->link[reader->urdf->link_count];
    *link                 = (urdf_link_t){.line = element->line, .joint = URDF_ROOT};
    const status_t status = element_take(element, fields, 1U, link);
    for (size_t i = 0U; (status == STATUS_OK) && (i < reader->urdf->link_count); i++) {
        if (strcmp(reader->urdf->link[i].name, link->name) == 0) {
            return element_refuse(element, link->name, "a name that no earlier link has");
        }
    }
    reader->urdf->link_count++;
    reader->inside = IN_LINK;
    return status;
}

static status_t start_joint(urdf_reader_t* const reader, const element_t* const element)
{
    static const field_t fields[]    = {{"name", FIELD_TEXT, offsetof(urdf_joint_t, name), 0.0, 0.0, false},
                                        {"type", FIELD_TEXT, offsetof(urdf_joint_t, type), 0.0, 0.0, false}};
    static const char* const types[] = {[ROBOT_JOINT_REVOLUTE]   = "revolute",
                                        [ROBOT_JOINT_CONTINUOUS] = "continuous",
                                        [ROBOT_JOINT_PRISMATIC]  = "prismatic",
                                        [ROBOT_JOINT_FIXED]      = "fixed"};
    if (reader->urdf->joint_count == URDF_JOINTS_MAX) {
        return element_refuse(element, "one more joint", "at most 31");
    }
    urdf_joint_t* joint   = &reader->urdf->joint[reader->urdf->joint_count];
    *joint                = (urdf_joint_t){.line = element->line, .axis = {1.0, 0.0, 0.0}, .multiplier = 1.0};
    const status_t status = element_take(element, fields, 2U, joint);
    if (status != STATUS_OK) {
        return status;
    }
    for (size_t i = 0U; i < reader->urdf->joint_count; i++) {
        if (strcmp(reader->urdf->joint[i].name, joint->name) == 0) {
            return element_refuse(element, joint->name, "a name that no earlier joint has");
        }
    }
    unsigned kind = 0U;
    while ((kind <= ROBOT_JOINT_FIXED) && (strcmp(joint->type, types[kind]) != 0)) {
        kind++;
    }
    if (kind > ROBOT_JOINT_FIXED) {
        return element_refuse(element, joint->type, "revolute, continuous, prismatic or fixed");
    }
    joint->kind = (robot_joint_kind_t)kind;
    reader->urdf->joint_count++;
    reader->inside = IN_JOINT;
    memset(reader->has, 0, sizeof reader->has);
    return STATUS_OK;
}

static status_t start_in_robot(urdf_reader_t* const reader, const element_t* const element,
                               bool* const out_is_skipped)
{
    *out_is_skipped =
        (strcmp(element->name, "material") == 0) || (strcmp(element->name, "transmission") == 0);
    if (*out_is_skipped) {
        return STATUS_OK;
    }
    if (strcmp(element->name, "link") == 0) {
        return start_link(reader, element);
    }
    return (strcmp(element->name, "joint") == 0)
               ? start_joint(reader, element)
               : element_refuse(element, element->name, "link, joint, material or transmission");
}

static status_t start_in_link(urdf_reader_t* const reader, const element_t* const element,
                              bool* const out_is_skipped)
{
    static const field_t label[] = {{"name", FIELD_TEXT, offsetof(urdf_reader_t, unused), 0.0, 0.0, true}};
    *out_is_skipped              = strcmp(element->name, "visual") == 0;
    const bool is_mass           = strcmp(element->name, "inertial") == 0;
    const bool is_shape          = strcmp(element->name, "collision") == 0;
    reader->origin               = (urdf_origin_t){{0.0}, {0.0}};
    reader->has_origin           = false;
    reader->has_mass             = false;
    reader->has_moments          = false;
    reader->has_shape            = false;
    if (is_mass) {
        reader->inside = IN_INERTIAL;
        return (reader->urdf->link[reader->urdf->link_count - 1U].mass.mass_kg == 0.0)
                   ? element_take(element, NULL, 0U, NULL)
                   : element_refuse(element, element->name, "one inertial in each link");
    }
    if (is_shape) {
        reader->inside = IN_COLLISION;
        return element_take(element, label, 1U, reader);
    }
    return *out_is_skipped ? STATUS_OK
                           : element_refuse(element, element->name, "inertial, collision or visual");
}

static status_t start_in_inertial(urdf_reader_t* const reader, const element_t* const element)
{
    static const field_t mass[] = {
        {"value", FIELD_NUMBER, offsetof(urdf_reader_t, mass_kg), 1e-9, HEAVIEST, false}};
    static const field_t moments[] = {
        {"ixx", FIELD_NUMBER, offsetof(moments_t, xx), -HEAVIEST, HEAVIEST, false},
        {"ixy", FIELD_NUMBER, offsetof(moments_t, xy), -HEAVIEST, HEAVIEST, false},
        {"ixz", FIELD_NUMBER, offsetof(moments_t, xz), -HEAVIEST, HEAVIEST, false},
        {"iyy", FIELD_NUMBER, offsetof(moments_t, yy), -HEAVIEST, HEAVIEST, false},
        {"iyz", FIELD_NUMBER, offsetof(moments_t, yz), -HEAVIEST, HEAVIEST, false},
        {"izz", FIELD_NUMBER, offsetof(moments_t, zz), -HEAVIEST, HEAVIEST, false}};
    if (strcmp(element->name, "origin") == 0) {
        return take_origin(reader, element);
    }
    if (strcmp(element->name, "mass") == 0) {
        const status_t once = take_once(element, &reader->has_mass);
        return (once == STATUS_OK) ? element_take(element, mass, 1U, reader) : once;
    }
    if (strcmp(element->name, "inertia") != 0) {
        return element_refuse(element, element->name, "origin, mass or inertia");
    }
    status_t status   = take_once(element, &reader->has_moments);
    status            = (status == STATUS_OK) ? element_take(element, moments, 6U, &reader->moments) : status;
    const char* fault = (status == STATUS_OK) ? check_moments(&reader->moments) : NULL;
    return (fault != NULL) ? element_refuse(element, element->name, fault) : status;
}

static status_t start_in_geometry(urdf_reader_t* const reader, const element_t* const element)
{
    static const struct {
        const char* name;
        field_t field[2];
        size_t count;
    } shapes[] = {
        [SHAPE_BOX]    = {"box", {{"size", FIELD_VECTOR, offsetof(shape_t, size_m), 1e-6, FAR_M, false}}, 1U},
        [SHAPE_SPHERE] = {"sphere",
                          {{"radius", FIELD_NUMBER, offsetof(shape_t, radius_m), 1e-6, FAR_M, false}},
                          1U},
        [SHAPE_CYLINDER] = {"cylinder",
                            {{"radius", FIELD_NUMBER, offsetof(shape_t, radius_m), 1e-6, FAR_M, false},
                             {"length", FIELD_NUMBER, offsetof(shape_t, length_m), 1e-6, FAR_M, false}},
                            2U}};
    unsigned kind = 0U;
    while ((kind <= SHAPE_CYLINDER) && (strcmp(element->name, shapes[kind].name) != 0)) {
        kind++;
    }
    if ((kind > SHAPE_CYLINDER) || reader->has_shape) {
        return element_refuse(element, element->name, "one box, sphere or cylinder");
    }
    if (reader->urdf->shape_count == ROBOT_SHAPES_MAX) {
        return element_refuse(element, "one more shape", "at most 32");
    }
    shape_t* shape = &reader->urdf->shape[reader->urdf->shape_count];
    *shape = (shape_t){.kind = (shape_kind_t)kind, .frame = (unsigned)(reader->urdf->link_count - 1U)};
    reader->has_shape = true;
    return element_take(element, shapes[kind].field, shapes[kind].count, shape);
}

static status_t start_in_collision(urdf_reader_t* const reader, const element_t* const element)
{
    if (strcmp(element->name, "origin") == 0) {
        return take_origin(reader, element);
    }
    if (strcmp(element->name, "geometry") == 0) {
        reader->inside = IN_GEOMETRY;
        return element_take(element, NULL, 0U, NULL);
    }
    return element_refuse(element, element->name, "origin or geometry");
}

static status_t start_in_joint(urdf_reader_t* const reader, const element_t* const element)
{
    static const struct {
        const char* name;
        field_t field[4];
        size_t count;
    } elements[JOINT_ELEMENTS] = {
        {"origin",
         {{"xyz", FIELD_VECTOR, offsetof(urdf_joint_t, origin.position_m), -FAR_M, FAR_M, true},
          {"rpy", FIELD_VECTOR, offsetof(urdf_joint_t, origin.rpy_rad), -ANGLE_MAX, ANGLE_MAX, true}},
         2U},
        {"parent", {{"link", FIELD_TEXT, offsetof(urdf_joint_t, parent_name), 0.0, 0.0, false}}, 1U},
        {"child", {{"link", FIELD_TEXT, offsetof(urdf_joint_t, child_name), 0.0, 0.0, false}}, 1U},
        {"axis", {{"xyz", FIELD_VECTOR, offsetof(urdf_joint_t, axis), -FAR_M, FAR_M, false}}, 1U},
        {"limit",
         {{"lower", FIELD_NUMBER, offsetof(urdf_joint_t, lower), -FAR_M, FAR_M, true},
          {"upper", FIELD_NUMBER, offsetof(urdf_joint_t, upper), -FAR_M, FAR_M, true},
          {"effort", FIELD_NUMBER, offsetof(urdf_joint_t, unused[0]), 0.0, HEAVIEST, false},
          {"velocity", FIELD_NUMBER, offsetof(urdf_joint_t, unused[1]), 0.0, HEAVIEST, false}},
         4U},
        {"dynamics",
         {{"damping", FIELD_NUMBER, offsetof(urdf_joint_t, unused[2]), 0.0, 0.0, true},
          {"friction", FIELD_NUMBER, offsetof(urdf_joint_t, unused[3]), 0.0, 0.0, true}},
         2U},
        {"mimic",
         {{"joint", FIELD_TEXT, offsetof(urdf_joint_t, leader_name), 0.0, 0.0, false},
          {"multiplier", FIELD_NUMBER, offsetof(urdf_joint_t, multiplier), -FAR_M, FAR_M, true},
          {"offset", FIELD_NUMBER, offsetof(urdf_joint_t, offset), -FAR_M, FAR_M, true}},
         3U}};
    urdf_joint_t* joint = &reader->urdf->joint[reader->urdf->joint_count - 1U];
    joint->has_limit    = joint->has_limit || (strcmp(element->name, "limit") == 0);
    joint->leader_line  = (strcmp(element->name, "mimic") == 0) ? element->line : joint->leader_line;
    for (size_t i = 0U; i < JOINT_ELEMENTS; i++) {
        if (strcmp(element->name, elements[i].name) == 0) {
            const status_t status = take_once(element, &reader->has[i]);
            return (status == STATUS_OK) ? element_take(element, elements[i].field, elements[i].count, joint)
                                         : status;
        }
    }
    return element_refuse(element, element->name,
                          "origin, parent, child, axis, limit, mimic or zero dynamics");
}

static status_t start_robot(urdf_reader_t* const reader, const element_t* const element)
{
    static const field_t labels[] = {
        {"name", FIELD_TEXT, offsetof(urdf_reader_t, unused), 0.0, 0.0, false},
        {"version", FIELD_TEXT, offsetof(urdf_reader_t, unused), 0.0, 0.0, true},
        {"xmlns:xacro", FIELD_TEXT, offsetof(urdf_reader_t, unused), 0.0, 0.0, true}}; // From xacro.
    reader->inside = IN_ROBOT;
    return (strcmp(element->name, "robot") == 0) ? element_take(element, labels, 3U, reader)
                                                 : element_refuse(element, element->name, "robot");
}

/// Depth of the open element while the reader is in `inside`.
static unsigned depth_of(const urdf_element_t inside)
{
    static const unsigned depths[] = {
        [IN_NOTHING] = 0U,   [IN_ROBOT] = 1U,    [IN_LINK] = 2U, [IN_INERTIAL] = 3U,
        [IN_COLLISION] = 3U, [IN_GEOMETRY] = 4U, [IN_JOINT] = 2U};
    return depths[inside];
}

static status_t on_start(void* const context, const element_t* const element, bool* const out_is_skipped)
{
    urdf_reader_t* reader = context;
    if (element->depth != (depth_of(reader->inside) + 1U)) {
        return element_refuse(element, element->name, "no element inside of this one");
    }
    switch (reader->inside) {
    case IN_NOTHING:
        break;
    case IN_ROBOT:
        return start_in_robot(reader, element, out_is_skipped);
    case IN_LINK:
        return start_in_link(reader, element, out_is_skipped);
    case IN_INERTIAL:
        return start_in_inertial(reader, element);
    case IN_COLLISION:
        return start_in_collision(reader, element);
    case IN_GEOMETRY:
        return start_in_geometry(reader, element);
    case IN_JOINT:
        return start_in_joint(reader, element);
    }
    return start_robot(reader, element);
}

static status_t end_inertial(urdf_reader_t* const reader, const element_t* const element)
{
    const moments_t* m = &reader->moments;
    const pose_t pose  = pose_of(reader->origin.position_m, reader->origin.rpy_rad);
    if (!reader->has_mass || !reader->has_moments) {
        return element_refuse(element, element->name, "a mass and an inertia in it");
    }
    const robot_mass_t mass = {
        .mass_kg      = reader->mass_kg,
        .inertia_kgm2 = {{{m->xx, m->xy, m->xz}, {m->xy, m->yy, m->yz}, {m->xz, m->yz, m->zz}}}};
    robot_mass_add(&reader->urdf->link[reader->urdf->link_count - 1U].mass, &pose, &mass);
    reader->inside = IN_LINK;
    return STATUS_OK;
}

static status_t end_collision(urdf_reader_t* const reader, const element_t* const element)
{
    if (!reader->has_shape) {
        return element_refuse(element, element->name, "a geometry in it");
    }
    reader->urdf->shape[reader->urdf->shape_count].pose =
        pose_of(reader->origin.position_m, reader->origin.rpy_rad);
    reader->urdf->shape_count++;
    reader->inside = IN_LINK;
    return STATUS_OK;
}

static status_t on_end(void* const context, const element_t* const element)
{
    urdf_reader_t* reader = context;
    if (element->depth != depth_of(reader->inside)) {
        return STATUS_OK; // The end of an element that cannot contain others does not change `inside`.
    }
    switch (reader->inside) {
    case IN_NOTHING:
    case IN_ROBOT:
        reader->inside = IN_NOTHING;
        break;
    case IN_LINK:
    case IN_JOINT:
        reader->inside = IN_ROBOT;
        break;
    case IN_INERTIAL:
        return end_inertial(reader, element);
    case IN_COLLISION:
        return end_collision(reader, element);
    case IN_GEOMETRY:
        reader->inside = IN_COLLISION;
        break;
    }
    return STATUS_OK;
}

status_t urdf_read(const char* const path, urdf_t* const out_urdf, char error[DOCUMENT_ERROR_MAX])
{
    urdf_reader_t reader             = {.urdf = out_urdf};
    const document_handler_t handler = {.start = on_start, .end = on_end, .context = &reader};
    memset(out_urdf, 0, sizeof *out_urdf);
    return document_read(path, &handler, error);
}
