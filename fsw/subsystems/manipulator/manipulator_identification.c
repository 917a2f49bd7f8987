// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/manipulator/manipulator_identification.h"

#include "base/assertion.h"
#include "fsw/framework/control/elementary.h"

#include <stddef.h>

// Gain of the residuals. The velocity in the momenta is noisy, and so are the residuals of unit masses,
// which the filter treats as exact; with the gain of the observer (400 1/s) this noise alone would make the
// masses 3 % too small.
#define RESIDUAL_GAIN_1_S 30.0
#define KEEP_CYCLES 2000U  // Cycles between two stored estimates: 1 s at 2 kHz.
#define QUIET_CYCLES 1000U // Cycles after a contact until the residuals no longer contain its torque.
// Cycles between two updates, because residuals of consecutive cycles are nearly equal.
#define UPDATE_CYCLES 10U
#define TARE_NOISE_NM 0.01 // Noise of a tare, which is the mean of many samples.
#define DEVIATIONS_MAX 4.0 // Estimated masses are limited to this number of standard deviations.

/// Replace both earlier estimates by the present one.
static void keep_all(manipulator_arm_identification_t* const identification)
{
    identification->kept[0] = identification->now;
    identification->kept[1] = identification->now;
    identification->age     = 0U;
}

void manipulator_arm_identification_init(manipulator_arm_identification_t* const identification,
                                         const manipulator_identification_t* const assumed,
                                         const manipulator_model_t* const model)
{
    FSW_ASSERT((identification != NULL) && (assumed != NULL) && (model != NULL));
    *identification = (manipulator_arm_identification_t){.is_started = false, .quiet = QUIET_CYCLES};
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const unsigned offset                          = ARM_JOINTS + i;
        const double mass_deviation                    = assumed->mass_share * model->link_mass[i];
        identification->now.unknown[i]                 = model->link_mass[i];
        identification->now.covariance[i][i]           = mass_deviation * mass_deviation;
        identification->now.covariance[offset][offset] = assumed->offset * assumed->offset;
    }
    keep_all(identification);
}

/// Returns the model of an arm in which only link `part` - 1 has a mass, 1 kg. Part 0 is the torque alone: no
/// link has a mass.
static manipulator_model_t part_of(const manipulator_model_t* const model, const unsigned part)
{
    manipulator_model_t unit = *model;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const bool is_there  = (part == (i + 1U));
        unit.link_mass[i]    = is_there ? 1.0 : 0.0;
        unit.link_inertia[i] = is_there ? (model->link_inertia[i] / model->link_mass[i]) : 0.0;
    }
    return unit;
}

/// Delay angle and torque by two equal poles, as the tracker of the observer delays the velocity. In a fast
/// motion, the filter would otherwise mistake the delay of the velocity for an effect of the masses.
static void delay(manipulator_arm_identification_t* const identification,
                  const manipulator_arm_observer_gains_t* const gains, const double link_rad[ARM_JOINTS],
                  const double torque_nm[ARM_JOINTS])
{
    const double share = gains->period_s * gains->bandwidth_rad_s;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        double angle  = link_rad[i];
        double torque = torque_nm[i];
        for (unsigned lag = 0U; lag < ARM_LAGS; lag++) {
            double* const late_rad = &identification->late_rad[lag][i];
            double* const late_nm  = &identification->late_nm[lag][i];
            *late_rad              = identification->is_started ? *late_rad : angle;
            *late_nm               = identification->is_started ? *late_nm : torque;
            *late_rad              = control_settle(*late_rad + (share * (angle - *late_rad)));
            *late_nm               = control_settle(*late_nm + (share * (torque - *late_nm)));
            angle                  = *late_rad;
            torque                 = *late_nm;
        }
    }
}

void manipulator_arm_identification_step(manipulator_arm_identification_t* const identification,
                                         const manipulator_model_t* const model,
                                         const manipulator_arm_observer_gains_t* const gains,
                                         const double link_rad[ARM_JOINTS],
                                         const double velocity_rad_s[ARM_JOINTS],
                                         const double torque_nm[ARM_JOINTS])
{
    FSW_ASSERT((identification != NULL) && (model != NULL) && (gains != NULL));
    delay(identification, gains, link_rad, torque_nm);
    const manipulator_arm_directions_t at =
        manipulator_arm_directions(identification->late_rad[ARM_LAGS - 1U]);
    for (unsigned part = 0U; part < ARM_PARTS; part++) {
        const manipulator_model_t unit      = part_of(model, part);
        const manipulator_arm_terms_t terms = manipulator_arm_terms_at(&unit, &at);
        double momentum[ARM_JOINTS];
        double coriolis[ARM_JOINTS];
        manipulator_arm_inertia_times(&terms, velocity_rad_s, momentum);
        manipulator_arm_coriolis_transposed(&terms, velocity_rad_s, coriolis);
        for (unsigned i = 0U; i < ARM_JOINTS; i++) {
            double* const integral = &identification->momentum[part][i];
            double* const residual = &identification->residual_nm[part][i];
            const double torque    = (part == 0U) ? identification->late_nm[ARM_LAGS - 1U][i] : 0.0;
            const double known     = torque + coriolis[i] - terms.gravity_nm[i];
            *integral              = identification->is_started ? *integral : momentum[i];
            *integral += gains->period_s * (known + *residual);
            *residual = RESIDUAL_GAIN_1_S * (momentum[i] - *integral);
        }
    }
    identification->is_started = true;
}

/// Compute a row of the measurement matrix: the effect of each unknown on the residual of one joint.
static void effects_of(const manipulator_arm_identification_t* const identification, const unsigned joint,
                       double out_effect[ARM_UNKNOWNS])
{
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        out_effect[i]              = identification->residual_nm[1U + i][joint];
        out_effect[ARM_JOINTS + i] = (i == joint) ? 1.0 : 0.0;
    }
}

/// Returns the measured torque minus the torque that the estimated unknowns explain.
static double rest_of(const manipulator_arm_identification_t* const identification,
                      const double effect[ARM_UNKNOWNS], const double measured_nm)
{
    double rest = measured_nm;
    for (unsigned i = 0U; i < ARM_UNKNOWNS; i++) {
        rest -= effect[i] * identification->now.unknown[i];
    }
    return rest;
}

/// Perform a scalar update of the filter: measured = effect * unknown + noise.
static void update(manipulator_arm_identification_t* const identification, const double effect[ARM_UNKNOWNS],
                   const double measured_nm, const double noise_nm)
{
    double gain[ARM_UNKNOWNS];
    double variance = noise_nm * noise_nm;
    for (unsigned i = 0U; i < ARM_UNKNOWNS; i++) {
        gain[i] = 0.0;
        for (unsigned k = 0U; k < ARM_UNKNOWNS; k++) {
            gain[i] += identification->now.covariance[i][k] * effect[k];
        }
        variance += effect[i] * gain[i];
    }
    const double rest = rest_of(identification, effect, measured_nm);
    for (unsigned i = 0U; i < ARM_UNKNOWNS; i++) {
        identification->now.unknown[i] += gain[i] * rest / variance;
        for (unsigned k = 0U; k < ARM_UNKNOWNS; k++) {
            identification->now.covariance[i][k] -= gain[i] * gain[k] / variance;
        }
    }
}

static void forget_offsets(manipulator_arm_identification_t* const identification, const double deviation_nm)
{
    for (unsigned i = ARM_JOINTS; i < ARM_UNKNOWNS; i++) {
        for (unsigned k = 0U; k < ARM_UNKNOWNS; k++) {
            identification->now.covariance[i][k] = 0.0;
            identification->now.covariance[k][i] = 0.0;
        }
        identification->now.covariance[i][i] = deviation_nm * deviation_nm;
        identification->now.unknown[i]       = 0.0;
    }
}

void manipulator_arm_identification_tare(manipulator_arm_identification_t* const identification,
                                         const manipulator_identification_t* const assumed,
                                         const manipulator_model_t* const model,
                                         const double offset_nm[ARM_JOINTS])
{
    FSW_ASSERT((identification != NULL) && (assumed != NULL) && (model != NULL));
    forget_offsets(identification, assumed->offset);
    for (unsigned joint = 0U; joint < ARM_JOINTS; joint++) {
        double effect[ARM_UNKNOWNS];
        double torque = offset_nm[joint];
        effects_of(identification, joint, effect);
        // Add the gravity torque of the model; at rest the residual of a unit mass is its gravity torque.
        for (unsigned i = 0U; i < ARM_JOINTS; i++) {
            torque += effect[i] * model->link_mass[i];
        }
        update(identification, effect, torque, TARE_NOISE_NM);
    }
    keep_all(identification);
}

/// Limit the masses to DEVIATIONS_MAX standard deviations around those of the model, so that a wrong sensor
/// cannot lead to impossible masses.
static void limit_masses(manipulator_arm_identification_t* const identification,
                         const manipulator_identification_t* const assumed,
                         const manipulator_model_t* const model)
{
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        const double range             = DEVIATIONS_MAX * assumed->mass_share * model->link_mass[i];
        identification->now.unknown[i] = control_clamp(
            identification->now.unknown[i], model->link_mass[i] - range, model->link_mass[i] + range);
    }
}

/// Store the present estimate every KEEP_CYCLES cycles.
static void keep(manipulator_arm_identification_t* const identification)
{
    identification->age++;
    if (identification->age >= KEEP_CYCLES) {
        identification->kept[0] = identification->kept[1];
        identification->kept[1] = identification->now;
        identification->age     = 0U;
    }
}

/// Return to the older of the earlier estimates, because later updates may contain the torque of the
/// contact that was detected now. True if updates were discarded.
static bool go_back(manipulator_arm_identification_t* const identification)
{
    const bool is_changed   = (identification->age > 0U);
    identification->now     = identification->kept[0];
    identification->kept[1] = identification->kept[0];
    identification->age     = 0U;
    return is_changed;
}

bool manipulator_arm_identification_learn(manipulator_arm_identification_t* const identification,
                                          const manipulator_identification_t* const assumed,
                                          const manipulator_model_t* const model)
{
    FSW_ASSERT((identification != NULL) && (assumed != NULL) && (model != NULL));
    double effect[ARM_JOINTS][ARM_UNKNOWNS];
    bool is_free = true;
    identification->cycle++;
    for (unsigned joint = 0U; joint < ARM_JOINTS; joint++) {
        effects_of(identification, joint, effect[joint]);
        const double rest = rest_of(identification, effect[joint], -identification->residual_nm[0U][joint]);
        is_free           = is_free && (control_absolute(rest) < assumed->ceiling);
    }
    if (!is_free) {
        identification->quiet = 0U;
        return go_back(identification);
    }
    if (identification->quiet < QUIET_CYCLES) {
        identification->quiet++;
        return false;
    }
    keep(identification);
    if (identification->cycle < UPDATE_CYCLES) {
        return false;
    }
    for (unsigned joint = 0U; joint < ARM_JOINTS; joint++) {
        update(identification, effect[joint], -identification->residual_nm[0U][joint], assumed->noise);
    }
    limit_masses(identification, assumed, model);
    identification->cycle = 0U;
    identification->updates++;
    return true;
}

manipulator_model_t manipulator_arm_identified(const manipulator_arm_identification_t* const identification,
                                               const manipulator_model_t* const model)
{
    FSW_ASSERT((identification != NULL) && (model != NULL));
    manipulator_model_t identified = *model;
    for (unsigned i = 0U; i < ARM_JOINTS; i++) {
        identified.link_mass[i] = identification->now.unknown[i];
        identified.link_inertia[i] =
            model->link_inertia[i] * identification->now.unknown[i] / model->link_mass[i];
    }
    return identified;
}
