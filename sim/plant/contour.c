// SPDX-License-Identifier: Apache-2.0
#include "sim/plant/plant_internal.h"

bool contour_create(plant_t* const plant)
{
    const plant_parameters_t* parameters = &plant->parameters;
    contour_t* contour                   = &plant->contour;

    contour->joints   = dJointGroupCreate(0);
    contour->finger   = dCreateSphere(NULL, parameters->tip_radius_m);
    contour->shape[0] = dCreateBox(NULL, parameters->contour_end_m - parameters->contour_start_m,
                                   parameters->contour_width_m, parameters->contour_depth_m);
    contour->shape[1] = dCreateCapsule(NULL, parameters->bump_radius_m, parameters->contour_width_m);
    if ((contour->joints == NULL) || (contour->finger == NULL) || (contour->shape[0] == NULL) ||
        (contour->shape[1] == NULL)) {
        return false;
    }

    dGeomSetPosition(contour->shape[0], (parameters->contour_start_m + parameters->contour_end_m) / 2.0, 0.0,
                     parameters->contour_top_m - parameters->contour_depth_m / 2.0);
    dMatrix3 across;
    dRFromAxisAndAngle(across, 1.0, 0.0, 0.0, M_PI / 2.0); // A capsule lies along its z; turn it into y.
    dGeomSetRotation(contour->shape[1], across);
    dGeomSetPosition(contour->shape[1], parameters->bump_x_m, 0.0,
                     parameters->contour_top_m + parameters->bump_height_m - parameters->bump_radius_m);
    return true;
}

void contour_destroy(plant_t* const plant)
{
    contour_t* contour = &plant->contour;
    if (contour->joints != NULL) {
        dJointGroupDestroy(contour->joints);
    }
    if (contour->finger != NULL) {
        dGeomDestroy(contour->finger);
    }
    for (unsigned i = 0U; i < CONTOUR_SHAPES; i++) {
        if (contour->shape[i] != NULL) {
            dGeomDestroy(contour->shape[i]);
        }
    }
}

/// One contact joint between finger and contour. A soft constraint with these two numbers is exactly a spring
/// and damper integrated implicitly.
static void add_contact(plant_t* const plant, const dContactGeom* const geometry, const double dt_s)
{
    const plant_parameters_t* parameters = &plant->parameters;
    contour_t* contour                   = &plant->contour;
    const double spring                  = dt_s * parameters->contour_stiffness_n_m;
    const double sum                     = spring + parameters->contour_damping_ns_m;

    dContact contact         = {0};
    contact.surface.mode     = dContactSoftERP | dContactSoftCFM | dContactApprox1 | dContactFDir1;
    contact.surface.mu       = parameters->contour_friction;
    contact.surface.soft_erp = spring / sum;
    contact.surface.soft_cfm = 1.0 / sum;
    contact.geom             = *geometry;
    contact.fdir1[0]         = geometry->normal[2]; // Along the contour, in the plane of the arm.
    contact.fdir1[2]         = -geometry->normal[0];

    // The force acts where the finger's sphere reaches deepest.
    const unsigned index = contour->count;
    for (unsigned i = 0U; i < 3U; i++) {
        contour->point_m[index][i] = plant->truth.tip_m[i] - parameters->tip_radius_m * geometry->normal[i];
        contact.geom.pos[i]        = contour->point_m[index][i];
    }
    const dJointID joint = dJointCreateContact(plant->world, contour->joints, &contact);
    dJointAttach(joint, plant->link[PLANT_JOINTS - 1U], NULL);
    dJointSetFeedback(joint, &contour->feedback[index]);
    contour->count++;
}

void contour_touch(plant_t* const plant, const double dt_s)
{
    const plant_parameters_t* parameters = &plant->parameters;
    contour_t* contour                   = &plant->contour;
    const double* tip                    = plant->truth.tip_m;

    contour->count = 0U;
    if (tip[2] - parameters->tip_radius_m > parameters->contour_top_m + parameters->bump_height_m) {
        return;
    }
    dGeomSetPosition(contour->finger, tip[0], tip[1], tip[2]);
    for (unsigned i = 0U; i < CONTOUR_SHAPES; i++) {
        dContactGeom found[CONTOUR_CONTACTS];
        const int count =
            dCollide(contour->finger, contour->shape[i], (int)CONTOUR_CONTACTS, found, (int)sizeof found[0]);
        for (int k = 0; k < count; k++) {
            add_contact(plant, &found[k], dt_s);
        }
    }
}

unsigned contour_loads(plant_t* const plant, plant_load_t out_load[CONTOUR_POINTS])
{
    contour_t* contour = &plant->contour;
    for (unsigned i = 0U; i < contour->count; i++) {
        for (unsigned axis = 0U; axis < 3U; axis++) {
            out_load[i].force_n[axis] = contour->feedback[i].f1[axis];
            out_load[i].point_m[axis] = contour->point_m[i][axis];
        }
    }
    dJointGroupEmpty(contour->joints);
    return contour->count;
}
