// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/manipulator/manipulator_model.h"

manipulator_arm_directions_t manipulator_arm_directions(const double angle_rad[ARM_JOINTS])
{
    return (manipulator_arm_directions_t){.shoulder = control_sine_cosine(angle_rad[0]),
                                          .elbow    = control_sine_cosine(angle_rad[1]),
                                          .forearm  = control_sine_cosine(angle_rad[0] + angle_rad[1])};
}

manipulator_arm_terms_t manipulator_arm_terms_at(const manipulator_model_t* const model,
                                                 const manipulator_arm_directions_t* const at)
{
    const double m1       = model->link_mass[0];
    const double m2       = model->link_mass[1];
    const double l1       = model->link_length[0];
    const double c1       = model->link_centre[0];
    const double c2       = model->link_centre[1];
    const double coupling = m2 * l1 * c2;
    const double outer    = model->link_inertia[1] + (m2 * c2 * c2);
    const double inner    = model->link_inertia[0] + (m1 * c1 * c1) + (m2 * l1 * l1);
    const double weight2  = model->gravity * m2 * c2 * at->forearm.cosine;

    return (manipulator_arm_terms_t){
        .m11        = inner + outer + (2.0 * coupling * at->elbow.cosine),
        .m12        = outer + (coupling * at->elbow.cosine),
        .m22        = outer,
        .h          = coupling * at->elbow.sine,
        .gravity_nm = {(model->gravity * ((m1 * c1) + (m2 * l1)) * at->shoulder.cosine) + weight2, weight2},
    };
}

manipulator_arm_terms_t manipulator_arm_terms(const manipulator_model_t* const model,
                                              const double angle_rad[ARM_JOINTS])
{
    const manipulator_arm_directions_t at = manipulator_arm_directions(angle_rad);
    return manipulator_arm_terms_at(model, &at);
}

void manipulator_arm_inertia_times(const manipulator_arm_terms_t* const terms,
                                   const double vector[ARM_JOINTS], double out[ARM_JOINTS])
{
    const double first = (terms->m11 * vector[0]) + (terms->m12 * vector[1]);
    out[1]             = (terms->m12 * vector[0]) + (terms->m22 * vector[1]);
    out[0]             = first;
}

void manipulator_arm_coriolis(const manipulator_arm_terms_t* const terms,
                              const double velocity_rad_s[ARM_JOINTS], double out_nm[ARM_JOINTS])
{
    const double v1 = velocity_rad_s[0];
    const double v2 = velocity_rad_s[1];
    out_nm[0]       = -terms->h * ((2.0 * v1 * v2) + (v2 * v2));
    out_nm[1]       = terms->h * v1 * v1;
}

void manipulator_arm_coriolis_transposed(const manipulator_arm_terms_t* const terms,
                                         const double velocity_rad_s[ARM_JOINTS], double out_nm[ARM_JOINTS])
{
    const double v1 = velocity_rad_s[0];
    const double v2 = velocity_rad_s[1];
    out_nm[0]       = 0.0;
    out_nm[1]       = -terms->h * ((v1 * v1) + (v1 * v2));
}

void manipulator_arm_jacobian(const manipulator_model_t* const model, const double angle_rad[ARM_JOINTS],
                              double out[CONTROL_PLANAR_ENTRIES])
{
    const control_sine_cosine_t shoulder = control_sine_cosine(angle_rad[0]);
    const control_sine_cosine_t forearm  = control_sine_cosine(angle_rad[0] + angle_rad[1]);
    out[1]                               = -model->link_length[1] * forearm.sine;
    out[3]                               = model->link_length[1] * forearm.cosine;
    out[0]                               = out[1] - (model->link_length[0] * shoulder.sine);
    out[2]                               = out[3] + (model->link_length[0] * shoulder.cosine);
}
